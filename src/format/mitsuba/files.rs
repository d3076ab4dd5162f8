//! Access to the files of a Mitsuba scene, with search folders and checks of permission and memory.

use crate::format::description::Span;
pub(super) use crate::format::import::ReadResult;
use crate::format::import::{ImportOptions, SceneReadError};
use crate::format::imported_files::{self, FileDefect};
use crate::format::mesh::MeshReadMonitor;
use crate::format::{SceneError, SourceText};
use crate::image::parent_folder;
use std::cell::RefCell;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Position of an element in the scene file or in a file that it includes.
#[derive(Clone, Debug)]
pub(super) struct MitsubaSourceLocation {
    /// Name and text of the file.
    pub source: SourceText,
    /// Part of the text at which errors point: the `<` and the name of the element.
    pub span: Span,
    /// Line of the element, from 1.
    pub line: u32,
}

impl MitsubaSourceLocation {
    /// Returns an error at this position, with `message` and the help text `help`.
    pub fn error(&self, message: impl Display, help: &str) -> SceneReadError {
        SceneError::error_at_span(&self.source, self.span, message.to_string(), "here", help).into()
    }

    /// Returns the position as text for messages: `line 3` in the file `main`, and `a.xml line 3`
    /// in another file.
    pub fn position_text(&self, main: &str) -> String {
        let Self { source, line, .. } = self;
        if source.file_name() == main { format!("line {line}") } else { format!("{} line {line}", source.file_name()) }
    }
}

/// Access to the scene file and the files that it refers to, within a memory limit.
pub(super) struct MitsubaSceneFiles<'a> {
    /// Path of the scene file.
    pub path: &'a Path,
    /// Observer that receives the path of each file that is read after the scene file.
    pub monitor: &'a dyn MeshReadMonitor,
    /// Memory limit, and permission to read files outside of the scene's folder.
    pub options: &'a ImportOptions,
    /// Folders of the `path` elements read so far, in which files are searched; the last one first.
    search_folders: RefCell<Vec<PathBuf>>,
    /// Free memory before the scene is read \[bytes]; `None` without a limit.
    free_at_start: Option<u64>,
}

impl<'a> MitsubaSceneFiles<'a> {
    /// Returns the access to the scene at `path` and its files. Reads no file yet.
    pub fn new(path: &'a Path, monitor: &'a dyn MeshReadMonitor, options: &'a ImportOptions) -> Self {
        let free_at_start = options.memory_limit.available_bytes();
        Self { path, monitor, options, search_folders: RefCell::default(), free_at_start }
    }

    /// Returns the memory that may still be allocated \[bytes]; `None` if there is no limit.
    pub fn free_memory(&self) -> Option<u64> {
        self.options.memory_limit.available_bytes()
    }

    /// Fails with an error that names `path` if `needed` bytes exceed the free memory.
    pub fn check_memory(&self, path: &Path, needed: u64) -> ReadResult<()> {
        imported_files::check_memory(path, needed, self.free_memory())
    }

    /// Fails if `total` \[bytes] exceeds the memory that was free at the start. `total` is the
    /// estimated memory of all elements or all objects so far.
    ///
    /// This check is fast enough for each element, because it does not ask for the memory that is
    /// free now.
    pub fn check_total_memory(&self, total: u64) -> ReadResult<()> {
        imported_files::check_memory(self.path, total, self.free_at_start)
    }

    /// Returns the content of a file. Fails if the file cannot be read or exceeds the free memory.
    pub fn read_file(&self, path: &Path) -> ReadResult<Vec<u8>> {
        imported_files::read_file(path, |length| self.check_memory(path, length))
    }

    /// Adds the search folder `name` of a `path` element, relative to the folder of the scene.
    pub fn add_folder(&self, name: &str) {
        self.search_folders.borrow_mut().push(parent_folder(self.path).join(path_with_slashes(name)));
    }

    /// Returns the path of the file `name`, to which the element at `place` refers. Reports the
    /// file to the monitor.
    ///
    /// Searches the folders of `path` elements, then the folder of the scene, then the folder of
    /// the file that contains `place`. Fails if the file does not exist. Also fails if it lies
    /// outside the scene's folder, unless the options allow outside files.
    pub fn find_file(&self, name: &str, place: &MitsubaSourceLocation) -> ReadResult<PathBuf> {
        let relative = path_with_slashes(name);
        let including_folder = Path::new(place.source.file_name()).parent().map(Path::to_owned);
        let folders = self.search_folders.borrow();
        let candidates =
            folders.iter().rev().cloned().chain([parent_folder(self.path).to_owned()]).chain(including_folder);
        let found = candidates.map(|folder| folder.join(&relative)).find(|file| file.is_file());
        let Some(file) = found.filter(|_| !name.is_empty()) else {
            let help = format!("put the file at `{}`", parent_folder(self.path).join(&relative).display());
            return Err(place.error(format!("the file `{name}` does not exist"), &help));
        };
        imported_files::check_permission(self.path, &file, name, self.options)
            .map_err(|FileDefect { message, help }| place.error(message, &help))?;
        self.monitor.on_input_file_found(&file);
        Ok(file)
    }
}

/// Returns the path `name` with backslashes, as in scenes from Windows, replaced by slashes.
fn path_with_slashes(name: &str) -> PathBuf {
    PathBuf::from(name.replace('\\', "/"))
}
