//! Why a mesh could not be read.

use crate::format::problem::{LineError, Problem};
use crate::image::open_file;
use crate::stats::bytes;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Why a mesh or its materials could not be read.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// There is no such file.
    #[error("there is no mesh file {}: check the path, which counts from the scene file's folder or the one above it", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// There is no such file of materials.
    #[error("there is no material file {}: put it beside the mesh that names it", path.display())]
    NoLibrary {
        /// The file.
        path: PathBuf,
    },
    /// The file is there but cannot be read.
    #[error("cannot read the mesh {}: check that it is a file and that you may read it", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line cannot be understood.
    #[error(transparent)]
    Line(#[from] LineError),
    /// A place in a binary file that says nothing sound.
    #[error("{}: byte {byte}, {element}: {message}: {remedy}", path.display())]
    Byte {
        /// The file.
        path: PathBuf,
        /// From 0.
        byte: usize,
        /// Which vertex, face or other entry, from 0.
        element: String,
        /// What is wrong.
        message: String,
        /// What would be right.
        remedy: &'static str,
    },
    /// Nothing to see.
    #[error("the mesh {} has no faces: export it with faces", path.display())]
    NoFaces {
        /// The file.
        path: PathBuf,
    },
    /// More vertices than an index can count.
    #[error("the mesh {} has more than 2147483647 vertices: split it", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// More memory than there is.
    #[error(
        "the mesh {} takes {} of memory, and {} are free: simplify or split it, or let it have more (--memory)",
        path.display(), bytes(*needed), bytes(*free)
    )]
    Memory {
        /// The file.
        path: PathBuf,
        /// Bytes that the mesh takes, with what reading it takes.
        needed: u64,
        /// Bytes that it may take.
        free: u64,
    },
    /// Faces name a material that no file of materials holds.
    #[error("the mesh {} names a material `{name}` that its material files do not hold: add it to one of them", path.display())]
    NoMaterial {
        /// The file.
        path: PathBuf,
        /// The material.
        name: String,
    },
    /// A material that cannot be rendered.
    #[error("{}: {message}: {remedy}", path.display())]
    BadMaterial {
        /// The mesh whose material files hold it.
        path: PathBuf,
        /// What is wrong.
        message: String,
        /// What would be right.
        remedy: &'static str,
    },
    /// The reader refuses what the check let pass.
    #[error("cannot read the mesh {}: {source}: export it anew as plain triangles", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What the reader says.
        source: tobj::LoadError,
    },
}

impl MeshError {
    pub(in crate::format) fn line(path: &Path, line: usize, problem: Problem) -> Self {
        Self::Line(LineError::new(path, line, problem))
    }
}

/// The bytes of a file, where they may take that much memory.
pub(in crate::format) fn read(path: &Path, free: Option<u64>) -> Result<Vec<u8>, MeshError> {
    let refused = |source: std::io::Error| match source.kind() {
        std::io::ErrorKind::NotFound => MeshError::Missing { path: path.into() },
        _ => MeshError::Unreadable { path: path.into(), source },
    };
    let (mut file, length) = open_file(path).map_err(refused)?;
    check_memory(path, length, free)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(refused)?;
    Ok(bytes)
}

/// Checks that `needed` bytes may be taken for a mesh, before they are.
pub(in crate::format) fn check_memory(path: &Path, needed: u64, free: Option<u64>) -> Result<(), MeshError> {
    match free {
        Some(free) if needed > free => Err(MeshError::Memory { path: path.into(), needed, free }),
        _ => Ok(()),
    }
}
