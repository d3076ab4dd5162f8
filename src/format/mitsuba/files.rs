//! Files of one Mitsuba scene: search folders, permission, memory checks and errors.

use crate::format::description::Span;
use crate::format::import::{ImportOptions, SceneReadError};
use crate::format::mesh::MeshReadMonitor;
use crate::format::{SceneError, SourceText};
use crate::image::open_file;
use std::cell::RefCell;
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};

pub(super) type ReadResult<T> = Result<T, SceneReadError>;

/// Position of an element in the scene file or in a file that it includes.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The file with its text.
    pub source: SourceText,
    /// The element in the text.
    pub span: Span,
    /// Line of the element, from 1.
    pub line: u32,
}

impl Place {
    /// Returns an error at this place.
    pub fn error(&self, message: impl Display, help: &str) -> SceneReadError {
        SceneError::error_at_span(&self.source, self.span, message.to_string(), "here", help).into()
    }

    /// Returns the line for messages, with the name of the file if it is not the file called
    /// `main`.
    pub fn described(&self, main: &str) -> String {
        let Self { source, line, .. } = self;
        if source.name() == main { format!("line {line}") } else { format!("{} line {line}", source.name()) }
    }
}

/// The files that a scene file may name.
pub(super) struct SceneFiles<'a> {
    /// Path of the scene file.
    pub path: &'a Path,
    /// Receiver of the paths of further files.
    pub monitor: &'a dyn MeshReadMonitor,
    /// Memory limit, and permission to leave the folder.
    pub options: &'a ImportOptions,
    /// Folders of `path` elements, in the order of the file. The last one is searched first.
    folders: RefCell<Vec<PathBuf>>,
    /// Free memory before the scene is read \[bytes]; `None` if no limit is known.
    free_at_start: Option<u64>,
}

impl<'a> SceneFiles<'a> {
    /// Returns the files of the scene at `path`, without further search folders.
    pub fn new(path: &'a Path, monitor: &'a dyn MeshReadMonitor, options: &'a ImportOptions) -> Self {
        let free_at_start = options.memory.available_bytes();
        Self { path, monitor, options, folders: RefCell::default(), free_at_start }
    }

    /// Returns the bytes of memory that may still be allocated; `None` if no limit is known.
    pub fn free_memory(&self) -> Option<u64> {
        self.options.memory.available_bytes()
    }

    /// Returns an error if `needed` bytes do not fit into the free memory.
    pub fn check_memory(&self, path: &Path, needed: u64) -> ReadResult<()> {
        match self.free_memory() {
            Some(free) if needed > free => Err(SceneReadError::Memory { path: path.to_owned(), needed, free }),
            _ => Ok(()),
        }
    }

    /// Returns an error if the elements or objects of the scene take more memory than was free
    /// before reading; `total` is their memory \[bytes].
    ///
    /// Asking for the free memory at each element would take long.
    pub fn check_total(&self, total: u64) -> ReadResult<()> {
        match self.free_at_start {
            Some(free) if total > free => {
                Err(SceneReadError::Memory { path: self.path.to_owned(), needed: total, free })
            }
            _ => Ok(()),
        }
    }

    /// Reads a whole file.
    pub fn read(&self, path: &Path) -> ReadResult<Vec<u8>> {
        let unreadable = |source| SceneReadError::Unreadable { path: path.to_owned(), source };
        let (file, length) = open_file(path).map_err(unreadable)?;
        self.check_memory(path, length)?;
        let mut bytes = Vec::new();
        file.take(length).read_to_end(&mut bytes).map_err(unreadable)?;
        Ok(bytes)
    }

    /// Adds the folder of a `path` element, relative to the folder of the scene.
    pub fn add_folder(&self, name: &str) {
        self.folders.borrow_mut().push(self.scene_folder().join(portable(name)));
    }

    /// Returns the path of a file that `place` names, and reports it to the monitor.
    ///
    /// Searches the folders of `path` elements, the folder of the scene, and the folder of the file
    /// of `place`. The file must lie below the scene's folder, unless the options allow others.
    pub fn find(&self, name: &str, place: &Place) -> ReadResult<PathBuf> {
        let relative = portable(name);
        let own = Path::new(place.source.name()).parent().map(Path::to_owned);
        let folders = self.folders.borrow();
        let candidates = folders.iter().rev().cloned().chain([self.scene_folder()]).chain(own);
        let found = candidates.map(|folder| folder.join(&relative)).find(|file| file.is_file());
        let Some(file) = found.filter(|_| !name.is_empty()) else {
            let help = format!("put the file at `{}`", self.scene_folder().join(&relative).display());
            return Err(place.error(format!("the file `{name}` does not exist"), &help));
        };
        let is_inside = match (self.scene_folder().canonicalize(), file.canonicalize()) {
            (Ok(folder), Ok(file)) => file.starts_with(folder),
            _ => false,
        };
        if !is_inside && !self.options.allows_outside_files {
            let help = "move the file below the scene's folder, or trust the scene with --allow-outside";
            return Err(place.error(format!("`{name}` is outside the folder of the scene"), help));
        }
        self.monitor.on_input_file_found(&file);
        Ok(file)
    }

    fn scene_folder(&self) -> PathBuf {
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).to_owned()
    }
}

/// Returns a relative path with slashes, because scenes from Windows have backslashes.
fn portable(name: &str) -> PathBuf {
    PathBuf::from(name.replace('\\', "/"))
}
