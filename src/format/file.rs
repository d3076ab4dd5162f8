//! Scene files: reading and resolving.

use super::description::Description;
use super::mesh::ReadMonitor;
use super::{SceneError, Source, parse_bytes, resolve, resolve_watched};
use crate::image::open_file;
use crate::scene::Scene;
use crate::stats::{Memory, bytes};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Scene file that was read and parsed but not resolved; its description may still be changed.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Parsed description.
    pub description: Description,
    /// Text of the file, for error messages.
    pub source: Source,
    folder: PathBuf,
}

/// Bytes of memory per byte of the file.
///
/// A sphere of 40 letters takes a kilobyte for its shape, boxes and tree.
const PER_BYTE: u64 = 32;

/// Reason why a scene file could not be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("cannot read the scene `{}`", path.display())]
    #[diagnostic(help("check the path and its permissions"))]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Cause reported by the system.
        source: std::io::Error,
    },
    /// The scene takes more memory than is free.
    #[error("the scene `{}` takes about {} of memory, and {} are free", path.display(), bytes(*needed), bytes(*free))]
    #[diagnostic(help("put what is large into meshes, or let it have more (--memory)"))]
    Memory {
        /// Path of the file.
        path: PathBuf,
        /// Bytes that the scene takes.
        needed: u64,
        /// Bytes of memory that are free.
        free: u64,
    },
    /// The text is not valid in the scene language.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Language(#[from] SceneError),
}

impl SceneFile {
    /// Reads and parses the file at `path`.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        Self::read_within(path, Memory::Unbounded)
    }

    /// Like [`SceneFile::read`]; a file that takes more than `memory` is refused before it is read.
    ///
    /// # Errors
    ///
    /// [`ReadError`].
    pub fn read_within(path: &Path, memory: Memory) -> Result<Self, ReadError> {
        let unreadable = |source| ReadError::Unreadable { path: path.to_owned(), source };
        let (mut file, length) = open_file(path).map_err(unreadable)?;
        let needed = PER_BYTE * length;
        if let Some(free) = memory.free().filter(|free| needed > *free) {
            return Err(ReadError::Memory { path: path.to_owned(), needed, free });
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(unreadable)?;
        let name = path.display().to_string();
        let description = parse_bytes(&name, &bytes)?;
        let source = Source::new(&name, &String::from_utf8_lossy(&bytes));
        Ok(Self { description, source, folder: path.parent().unwrap_or(Path::new("")).to_owned() })
    }

    /// Resolves the description; meshes are found beside the scene file and in the folder above.
    ///
    /// # Errors
    ///
    /// [`SceneError`].
    pub fn resolve(&self) -> Result<Scene, SceneError> {
        resolve(&self.description, &self.source, &self.folder)
    }

    /// Like [`SceneFile::resolve`], limited to `memory`; `monitor` receives the progress of reading
    /// meshes.
    ///
    /// # Errors
    ///
    /// [`SceneError`].
    pub fn resolve_watched(&self, monitor: &dyn ReadMonitor, memory: Memory) -> Result<Scene, SceneError> {
        resolve_watched(&self.description, &self.source, &self.folder, monitor, memory)
    }
}
