//! Access to the files of a pbrt scene, with checks of permission and memory.

use crate::format::SceneError;
pub(super) use crate::format::import::ReadResult;
use crate::format::import::{ImportOptions, SceneReadError};
use crate::format::imported_files::{self, FileDefect};
use crate::format::mesh::MeshReadMonitor;
use std::cell::Cell;
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Position in a pbrt file, for messages: file name and line.
#[derive(Clone, Debug)]
pub(super) struct PbrtSourceLocation {
    /// Path of the file, as text.
    pub file: Rc<str>,
    /// Line of the file, from 1.
    pub line: u32,
}

impl PbrtSourceLocation {
    /// Returns an error at this position, with `message` and the help text `help`.
    pub fn error(&self, message: impl Display, help: &str) -> SceneReadError {
        SceneError::error_without_position(&self.file, format!("line {}: {message}", self.line), help).into()
    }

    /// Returns the position as text for messages, such as `scene.pbrt line 3`.
    pub fn position_text(&self) -> String {
        let name = Path::new(&*self.file).file_name().unwrap_or_default().to_string_lossy();
        format!("{name} line {}", self.line)
    }
}

/// Access to the scene file and the files that it refers to, within a memory limit.
pub(super) struct PbrtSceneFiles<'a> {
    /// Path of the scene file.
    pub path: &'a Path,
    /// Observer that receives the path of each file that is read after the scene file.
    pub monitor: &'a dyn MeshReadMonitor,
    /// Memory limit, and permission to read files outside of the scene's folder.
    pub options: &'a ImportOptions,
    /// Free memory before the scene is read \[bytes]; `None` without a limit.
    free_at_start: Option<u64>,
    /// Estimated memory of the scene so far \[bytes].
    reserved_memory: Cell<u64>,
}

impl<'a> PbrtSceneFiles<'a> {
    /// Returns the access to the scene at `path` and its files. Reads no file yet.
    pub fn new(path: &'a Path, monitor: &'a dyn MeshReadMonitor, options: &'a ImportOptions) -> Self {
        let free_at_start = options.memory_limit.available_bytes();
        Self { path, monitor, options, free_at_start, reserved_memory: Cell::new(0) }
    }

    /// Returns the memory that the scene may still take \[bytes]; `None` without a limit.
    pub fn free_memory(&self) -> Option<u64> {
        self.free_at_start.map(|free| free.saturating_sub(self.reserved_memory.get()))
    }

    /// Adds `bytes` to the estimated memory of the scene. Fails if the sum exceeds the free memory.
    pub fn reserve_memory(&self, bytes: u64) -> ReadResult<()> {
        self.reserved_memory.set(self.reserved_memory.get().saturating_add(bytes));
        imported_files::check_memory(self.path, self.reserved_memory.get(), self.free_at_start)
    }

    /// Returns the content of a file, and adds its size to the estimated memory of the scene.
    pub fn read_file(&self, path: &Path) -> ReadResult<Vec<u8>> {
        imported_files::read_file(path, |length| self.reserve_memory(length))
    }

    /// Returns the path of the file `name`, relative to the folder of the scene file. Reports the
    /// file to the monitor.
    ///
    /// Fails if the file does not exist. Also fails if it lies outside that folder, unless the
    /// options allow outside files.
    pub fn resolve_path(&self, place: &PbrtSourceLocation, name: &str) -> ReadResult<PathBuf> {
        let file = imported_files::find_file_in_folder(self.path, name, self.options)
            .map_err(|FileDefect { message, help }| place.error(message, &help))?;
        self.monitor.on_input_file_found(&file);
        Ok(file)
    }

    /// Returns the decompressed content of a gzip file, and adds its size to the estimated memory.
    pub fn gunzipped(&self, bytes: &[u8], place: &PbrtSourceLocation) -> ReadResult<Vec<u8>> {
        let free = self.free_memory().unwrap_or(u64::MAX);
        let mut out = Vec::new();
        let read = flate2::read::MultiGzDecoder::new(bytes).take(free).read_to_end(&mut out);
        read.map_err(|e| place.error(format!("the compressed file is damaged: {e}"), "compress it again with gzip"))?;
        self.reserve_memory(out.len() as u64 + 1)?;
        Ok(out)
    }
}
