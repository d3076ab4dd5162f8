//! Errors of reading meshes and their materials, and helpers that keep to a memory limit.

use crate::format::line_error::{LineError, MessageAndRemedy};
use crate::image::open_file;
use crate::stats::format_bytes;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Reason why a mesh or its materials could not be read.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The mesh file does not exist.
    #[error("there is no mesh file {}: check the path, which counts from the scene file's folder or the one above it", path.display())]
    MissingMeshFile {
        /// Path of the mesh file.
        path: PathBuf,
    },
    /// The material file does not exist.
    #[error("there is no material file {}: put it beside the mesh that names it", path.display())]
    MissingMtlFile {
        /// Path of the material file.
        path: PathBuf,
    },
    /// The file exists but cannot be read.
    #[error("cannot read the mesh {}: check that it is a file and that you may read it", path.display())]
    Unreadable {
        /// Path of the mesh or material file.
        path: PathBuf,
        /// Cause reported by the system.
        source: std::io::Error,
    },
    /// A line of the file is invalid.
    #[error(transparent)]
    InvalidLine(#[from] LineError),
    /// A binary file holds invalid data.
    #[error("{}: byte {byte}, {element}: {message}: {remedy}", path.display())]
    InvalidElement {
        /// Path of the mesh file.
        path: PathBuf,
        /// Offset of the invalid data from the start of the file \[bytes].
        byte: usize,
        /// Name and index, from 0, of the invalid PLY element, such as `face 12`.
        element: String,
        /// Description of the defect.
        message: String,
        /// Advice on how to correct the file.
        remedy: &'static str,
    },
    /// The mesh has no faces.
    #[error("the mesh {} has no faces: export it with faces", path.display())]
    NoFaces {
        /// Path of the mesh file.
        path: PathBuf,
    },
    /// The mesh has more vertices than `i32::MAX`.
    #[error("the mesh {} has more than 2147483647 vertices: split it", path.display())]
    TooManyVertices {
        /// Path of the mesh file.
        path: PathBuf,
    },
    /// The mesh takes more memory than is free.
    #[error(
        "the mesh {} takes {} of memory, and {} are free: simplify or split it, or let it have more (--memory)",
        path.display(), format_bytes(*needed), format_bytes(*free)
    )]
    OutOfMemory {
        /// Path of the mesh or material file.
        path: PathBuf,
        /// Memory that reading the file takes \[bytes].
        needed: u64,
        /// Memory that is free \[bytes].
        free: u64,
    },
    /// Faces name a material that no material file defines.
    #[error("the mesh {} names a material `{name}` that its material files do not hold: add it to one of them", path.display())]
    UndefinedMaterial {
        /// Path of the mesh file.
        path: PathBuf,
        /// Name of the material.
        name: String,
    },
    /// An MTL material cannot be converted to a material of the scene language.
    #[error("{}: {message}: {remedy}", path.display())]
    UnconvertibleMaterial {
        /// Path of the mesh whose material files define the material.
        path: PathBuf,
        /// Description of the defect.
        message: String,
        /// Advice on how to correct the material.
        remedy: &'static str,
    },
    /// The parser crate `tobj` refuses a file that Caustica's own line check accepted.
    #[error("cannot read the mesh {}: {source}: export it anew as plain triangles", path.display())]
    RejectedByTobj {
        /// Path of the mesh file.
        path: PathBuf,
        /// Cause reported by `tobj`.
        source: tobj::LoadError,
    },
}

impl MeshError {
    pub(in crate::format) fn error_at_line(path: &Path, line: usize, problem: MessageAndRemedy) -> Self {
        Self::InvalidLine(LineError::new(path, line, problem))
    }
}

/// Returns the bytes of the file at `path`.
///
/// Fails before allocating if the file is longer than `free` bytes. A `free` of `None` sets no
/// limit.
pub(in crate::format) fn read_file_bytes(path: &Path, free: Option<u64>) -> Result<Vec<u8>, MeshError> {
    let refused = |source: std::io::Error| match source.kind() {
        std::io::ErrorKind::NotFound => MeshError::MissingMeshFile { path: path.into() },
        _ => MeshError::Unreadable { path: path.into(), source },
    };
    let (mut file, length) = open_file(path).map_err(refused)?;
    check_memory(path, length, free)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(refused)?;
    Ok(bytes)
}

/// Fails with an error that names `path` if `needed` exceeds `free`, both in bytes.
///
/// `free` is `None` without a memory limit.
pub(in crate::format) fn check_memory(path: &Path, needed: u64, free: Option<u64>) -> Result<(), MeshError> {
    match free {
        Some(free) if needed > free => Err(MeshError::OutOfMemory { path: path.into(), needed, free }),
        _ => Ok(()),
    }
}
