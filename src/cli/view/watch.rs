//! Changes of the files of a scene, found by their time and length.

use crate::format::FileStamp;
use crate::format::mesh::{MeshReadMonitor, TriangleMesh};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Files of a scene, each with the stamp that was taken before it was read; `None` for a file that
/// does not exist.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct WatchedFiles(Vec<(PathBuf, Option<FileStamp>)>);

impl WatchedFiles {
    /// Makes a list with one file and its present stamp.
    pub fn new(path: &Path) -> Self {
        Self(vec![(path.to_owned(), FileStamp::of_file(path))])
    }

    /// Adds the files of `other` that this list lacks, with the stamps that they have in `other`.
    pub fn add_all(&mut self, other: &Self) {
        for (path, stamp) in &other.0 {
            if self.0.iter().all(|(known, _)| known != path) {
                self.0.push((path.clone(), *stamp));
            }
        }
    }

    /// Adds the file at `path` with its present stamp, unless the list already has it.
    fn add(&mut self, path: &Path) {
        if self.0.iter().all(|(known, _)| known != path) {
            self.0.push((path.to_owned(), FileStamp::of_file(path)));
        }
    }

    /// Returns a list of these files with their present stamps.
    fn with_present_stamps(&self) -> Self {
        Self(self.0.iter().map(|(path, _)| (path.clone(), FileStamp::of_file(path))).collect())
    }

    /// True if all files except the first, the scene file, are unchanged since their stamps were
    /// taken.
    pub fn has_unchanged_inputs(&self) -> bool {
        self.0.iter().skip(1).all(|(path, stamp)| FileStamp::of_file(path) == *stamp)
    }
}

/// Monitor that collects the files that a scene names, just before each is read.
pub(super) struct WatchedFileCollector(Mutex<WatchedFiles>);

impl WatchedFileCollector {
    /// Makes a monitor for the scene file at `path`, which is read next.
    pub fn new(path: &Path) -> Self {
        Self(Mutex::new(WatchedFiles::new(path)))
    }

    /// Returns the scene file and the files that it names.
    pub fn into_files(self) -> WatchedFiles {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MeshReadMonitor for WatchedFileCollector {
    fn on_input_file_found(&self, path: &Path) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).add(path);
    }

    fn on_read_start(&self, _: &Path, _: u64) {}
    fn on_bytes_parsed(&self, _: u64) {}
    fn on_read_end(&self, _: &Path, _: &TriangleMesh) {}
}

/// Detects changes of files. It reads their states only when the session calls
/// [`Self::has_settled_change`].
///
/// A change is reported once two looks in a row find the same new state. So a half-written file is
/// not reported.
#[derive(Debug, Default)]
pub(super) struct FileWatch {
    files: WatchedFiles,
    /// Changed stamps that the last look found. They are reported if the next look finds them
    /// again. `None` if the last look found the stamps of `files`.
    unsettled: Option<WatchedFiles>,
}

impl FileWatch {
    /// Watches `files` from now on. A difference from their stamps counts as a change.
    pub fn set_files(&mut self, files: WatchedFiles) {
        (self.files, self.unsettled) = (files, None);
    }

    /// Takes the stamps of all files. Returns true once after each change, when two calls in a row
    /// have found the same new stamps.
    pub fn has_settled_change(&mut self) -> bool {
        let now = self.files.with_present_stamps();
        if now == self.files {
            self.unsettled = None;
            return false;
        }
        let is_settled = self.unsettled.as_ref() == Some(&now);
        if is_settled {
            self.set_files(now);
        } else {
            self.unsettled = Some(now);
        }
        is_settled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn settled_changes_are_reported_once() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, mesh] = ["scene.txt", "mesh.obj"].map(|name| folder.path().join(name));
        fs::write(&scene, "a").unwrap();
        let monitor = WatchedFileCollector::new(&scene);
        monitor.on_input_file_found(&mesh);
        monitor.on_input_file_found(&mesh);
        let files = monitor.into_files();
        assert_eq!(files.0.len(), 2);
        let mut watch = FileWatch::default();
        watch.set_files(files.clone());
        assert!(!watch.has_settled_change());
        // A file that is still growing is not reported yet.
        fs::write(&scene, "ab").unwrap();
        assert!(!watch.has_settled_change());
        fs::write(&scene, "abc").unwrap();
        assert!(!watch.has_settled_change());
        assert!(watch.has_settled_change() && !watch.has_settled_change() && files.has_unchanged_inputs());
        // A file appears, and is removed again before two looks have found it.
        fs::write(&mesh, "v").unwrap();
        assert!(!watch.has_settled_change() && !files.has_unchanged_inputs());
        fs::remove_file(&mesh).unwrap();
        assert!(!watch.has_settled_change() && !watch.has_settled_change());
    }
}
