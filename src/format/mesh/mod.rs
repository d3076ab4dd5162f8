//! Triangle meshes: reading, writing, inspection and repair.

mod error;
mod merge;
mod normals;
mod obj;
mod orient;
mod ply;
mod repair;
mod report;
mod solid;
mod split;
#[cfg(test)]
mod tests;
mod topology;
mod weld;
mod write;

pub use error::MeshError;
pub(in crate::format) use error::{check_memory, read_file_bytes};
pub(in crate::format) use merge::{KeyIndexer, coordinate_bits};
pub use repair::{MeshRepairs, RepairCounts};
pub use report::MeshReport;
pub use solid::{SOLID_CHECK_BYTES, SolidDefect};
pub use write::MeshFormat;
pub(in crate::format) use write::ShortestDecimal;

use super::line_error::strip_byte_order_mark;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Material index of a triangle that has no material.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Triangles with shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions. After reading, a triangle uses each of them.
    pub positions: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from outside. Triangles without area are kept.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals per vertex.
    ///
    /// If the file has none for a triangle, they are zero at all its corners.
    pub normals: Option<Vec<DVec3>>,
    /// Texture coordinates per vertex; zero if the file has none.
    pub texcoords: Option<Vec<DVec2>>,
    /// Names of the materials; a triangle uses each of them.
    pub materials: Vec<String>,
    /// Index into `materials` of each triangle, or [`NO_MATERIAL`]; empty if `materials` is empty.
    pub triangle_materials: Vec<u32>,
}

/// Mesh as read from a file, with facts about the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The mesh. Vertices are shared if position, normal and texture coordinates are equal bit for
    /// bit.
    pub mesh: TriangleMesh,
    /// Material files that the mesh names, as written.
    pub libraries: Vec<String>,
    /// Number of vertices in the file.
    pub vertices: usize,
    /// Number of vertices in the file that no face uses; `mesh` lacks them.
    pub isolated: usize,
    /// True if the file indexes positions, normals and texture coordinates separately.
    ///
    /// Its vertices are then positions.
    pub positions_only: bool,
}

impl LoadedMesh {
    /// Number of vertices in the file that repeat another one bit for bit.
    #[must_use]
    pub fn repeated_vertices(&self) -> usize {
        let used = self.vertices - self.isolated;
        let split = self.mesh.normals.is_some() || self.mesh.texcoords.is_some();
        let kept =
            if self.positions_only && split { self.mesh.distinct_position_count() } else { self.mesh.positions.len() };
        used.saturating_sub(kept)
    }
}

/// Receiver of progress reports while meshes are read. `()` ignores them.
pub trait MeshReadMonitor: Sync {
    /// Receives the path of each file that the scene names, before it is read.
    fn names(&self, _path: &Path) {}
    /// A file of `bytes` bytes is about to be read.
    fn begin(&self, path: &Path, bytes: u64);
    /// Another `bytes` bytes have been processed.
    fn advance(&self, bytes: u64);
    /// The file has been read.
    fn end(&self, path: &Path, mesh: &TriangleMesh);
}

impl MeshReadMonitor for () {
    fn begin(&self, _: &Path, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self, _: &Path, _: &TriangleMesh) {}
}

/// Reads the triangles of a PLY or OBJ file; polygons become fans about their first corner.
///
/// A file without the signature or extension of PLY is read as OBJ.
///
/// # Errors
///
/// [`MeshError`], which names the file.
pub fn load(path: &Path, monitor: &dyn MeshReadMonitor) -> Result<LoadedMesh, MeshError> {
    load_with_memory_limit(path, monitor, None)
}

/// Like [`load`], limited to `free` bytes of memory if that number is known.
///
/// A mesh that takes more is refused before any memory is allocated.
///
/// # Errors
///
/// [`MeshError`], which names the file.
pub fn load_with_memory_limit(
    path: &Path,
    monitor: &dyn MeshReadMonitor,
    free: Option<u64>,
) -> Result<LoadedMesh, MeshError> {
    let bytes = read_file_bytes(path, free)?;
    let free = free.map(|free| free.saturating_sub(bytes.len() as u64));
    decode(path, bytes, monitor, free)
}

/// Like [`load_with_memory_limit`], from the bytes of a file that errors call `path`.
///
/// # Errors
///
/// [`MeshError`].
pub fn decode(
    path: &Path,
    bytes: Vec<u8>,
    monitor: &dyn MeshReadMonitor,
    free: Option<u64>,
) -> Result<LoadedMesh, MeshError> {
    monitor.begin(path, bytes.len() as u64);
    let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    let text = strip_byte_order_mark(&bytes);
    let loaded = if named || text.starts_with(b"ply\n") || text.starts_with(b"ply\r") {
        ply::read(path, &bytes, monitor, free)?
    } else {
        obj::read(path, bytes, monitor, free)?
    };
    if loaded.mesh.triangles.is_empty() {
        return Err(MeshError::NoFaces { path: path.into() });
    }
    monitor.end(path, &loaded.mesh);
    Ok(loaded)
}

/// `v` at unit length; zero if `v` is too short or too long.
///
/// A vector of unit length within rounding is returned unchanged, so that written normals read back
/// bit for bit.
pub(in crate::format) fn unit_normal(v: DVec3) -> DVec3 {
    let squared = v.length_squared();
    // Normalisation errs by 2.5 ulps per component, so by about 5 in the square; the sum adds 3.
    if (squared - 1.0).abs() <= 8.0 * f64::EPSILON {
        v
    } else if squared.is_normal() {
        v.normalize()
    } else {
        DVec3::ZERO
    }
}
