//! Input files of a scene, and their SHA-256 digests for the headers of films.

use super::{CommandFailure, Exit};
use crate::format::FileStamp;
use crate::format::mesh::{MeshReadMonitor, TriangleMesh};
use crate::render::InputDigest;
use miette::Report;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A file that a command reads, with its modification time and length (stamp) before reading.
#[derive(Clone, Debug)]
pub(super) struct InputFile {
    pub path: PathBuf,
    /// Modification time and length of the file before reading; `None` if there was no such file.
    stamp: Option<FileStamp>,
}

impl InputFile {
    /// Makes an input file with the current modification time and length of the file at `path`.
    /// Call this before the file is read.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), stamp: FileStamp::of_file(path) }
    }
}

/// Error: a file changed after it was read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the file `{}` changed while the scene was read", .0.display())]
#[diagnostic(help("give the same command again"))]
struct ChangedInputError(PathBuf);

/// Monitor that collects all files that a scene names. It forwards the progress of reading to
/// another monitor.
pub(super) struct InputFileCollector<'a> {
    progress: &'a dyn MeshReadMonitor,
    files: Mutex<Vec<InputFile>>,
}

impl<'a> InputFileCollector<'a> {
    pub fn new(progress: &'a dyn MeshReadMonitor) -> Self {
        Self { progress, files: Mutex::default() }
    }

    /// Returns all files that the scene names, in the order of reading.
    pub fn into_input_files(self) -> Vec<InputFile> {
        self.files.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the paths of all files that the scene names, in the order of reading.
    pub fn into_input_paths(self) -> Vec<PathBuf> {
        self.into_input_files().into_iter().map(|file| file.path).collect()
    }
}

impl MeshReadMonitor for InputFileCollector<'_> {
    fn on_input_file_found(&self, path: &Path) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).push(InputFile::new(path));
    }

    fn on_read_start(&self, path: &Path, bytes: u64) {
        self.progress.on_read_start(path, bytes);
    }

    fn on_bytes_parsed(&self, bytes: u64) {
        self.progress.on_bytes_parsed(bytes);
    }

    fn on_read_end(&self, path: &Path, mesh: &TriangleMesh) {
        self.progress.on_read_end(path, mesh);
    }
}

/// Returns the SHA-256 digests of the scene file and of `inputs`, the files that it names, sorted
/// by name and digest.
///
/// Returns a failure if a file has changed since it was read, because its digest would not describe
/// the loaded scene.
pub(super) fn input_digests(scene: &InputFile, inputs: &[InputFile]) -> Result<Vec<InputDigest>, CommandFailure> {
    let mut files: Vec<&InputFile> = std::iter::once(scene).chain(inputs).collect();
    // A file that the scene names several times keeps its first stamp (modification time and
    // length), because the sort is stable.
    files.sort_by_key(|file| &file.path);
    files.dedup_by_key(|file| &file.path);
    let mut digests = Vec::with_capacity(files.len());
    for file in files {
        let digest = file_digest(&file.path);
        let digest = digest.map_err(|error| CommandFailure::new(Exit::Input, Report::from_err(error)))?;
        if FileStamp::of_file(&file.path) != file.stamp {
            return Err(CommandFailure::new(Exit::Input, ChangedInputError(file.path.clone())));
        }
        digests.push(InputDigest { name: film_input_name(&file.path, &scene.path), digest });
    }
    digests.sort_by(|a, b| (&a.name, &a.digest).cmp(&(&b.name, &b.digest)));
    digests.dedup();
    Ok(digests)
}

/// Returns the name under which a film of the scene file `scene` stores the file at `path`: its
/// path relative to the scene's folder, or only its file name if it lies outside of that folder.
///
/// So the names stay equal if the scene folder is copied to another place.
fn film_input_name(path: &Path, scene: &Path) -> String {
    let (file, scene) = (normal_path(path), normal_path(scene));
    let inside = scene.parent().and_then(|folder| file.strip_prefix(folder).ok());
    let Some(inside) = inside else {
        return path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    };
    let parts: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
    parts.join("/")
}

/// Returns the absolute path of a file, with `.` and `..` removed. Symbolic links are not resolved.
fn normal_path(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut normal = PathBuf::new();
    for component in absolute.components() {
        match component {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

/// Returns the SHA-256 digest of a file in hexadecimal digits.
fn file_digest(path: &Path) -> io::Result<String> {
    let mut hasher = Sha256::new();
    io::copy(&mut File::open(path)?, &mut HashWriter(&mut hasher))?;
    Ok(hasher.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

/// Writer that adds all written bytes to a SHA-256 digest.
struct HashWriter<'a>(&'a mut Sha256);

impl io::Write for HashWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_changed_during_loading_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, mesh] = ["scene.txt", "mesh.obj"].map(|name| folder.path().join(name));
        fs::write(&scene, "a").unwrap();
        fs::write(&mesh, "v").unwrap();
        let read_scene = InputFile::new(&scene);
        let collector = InputFileCollector::new(&());
        collector.on_input_file_found(&mesh);
        let inputs = collector.into_input_files();
        let names = |digests: Vec<InputDigest>| digests.into_iter().map(|input| input.name).collect::<Vec<_>>();
        assert_eq!(names(input_digests(&read_scene, &inputs).unwrap()), ["mesh.obj", "scene.txt"]);
        fs::write(&mesh, "v 0").unwrap();
        // The stamp (modification time and length) from before the change counts, even if the file
        // was found again after the change.
        let again = [inputs[0].clone(), InputFile::new(&mesh)];
        let failure = input_digests(&read_scene, &again).unwrap_err();
        assert!(failure.reports[0].to_string().contains("mesh.obj` changed while the scene was read"));
    }

    #[test]
    fn film_input_names_are_relative_to_scene_folder() {
        let name = |path: &str, scene: &str| film_input_name(Path::new(path), Path::new(scene));
        assert_eq!(name("a/tex/wood.png", "a/ring.txt"), "tex/wood.png");
        assert_eq!(name("./tex/../wood.png", "ring.txt"), "wood.png");
        assert_eq!(name("a/../../b/wood.png", "a/ring.txt"), "wood.png");
        let absolute = std::path::absolute("tex/wood.png").unwrap();
        assert_eq!(name(absolute.to_str().unwrap(), "ring.txt"), "tex/wood.png");
    }
}
