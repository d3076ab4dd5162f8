//! Triangle meshes: reading by the kind of the file, and what is done with them apart from rendering.

mod error;
mod normals;
mod orient;
mod parts;
mod repair;
mod report;
mod share;
mod solid;
#[cfg(test)]
mod tests;
mod topology;
mod weld;
mod write;

pub use error::MeshError;
pub(in crate::format) use error::{check_memory, read};
pub use repair::{Repair, Repaired};
pub use report::MeshReport;
pub(in crate::format) use share::{Numbers, bits};
pub use solid::{SOLID_CHECK_BYTES, SolidDefect};
pub use write::MeshFormat;
pub(in crate::format) use write::Shortest;

use super::problem::without_bom;
use super::{obj, ply};
use glam::{DVec2, DVec3};
use std::path::Path;

/// The material of a triangle that has none.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Triangles with shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Places of the vertices. As read, each is used by a triangle.
    pub positions: Vec<DVec3>,
    /// Counterclockwise seen from outside; indices into `positions`. Triangles without area are kept.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals by vertex, of unit length. Zero where the file has none: then at all corners of a triangle.
    pub normals: Option<Vec<DVec3>>,
    /// Texture coordinates by vertex; zero where the file has none.
    pub texcoords: Option<Vec<DVec2>>,
    /// Names of materials, each used by a triangle.
    pub materials: Vec<String>,
    /// Material of each triangle, an index into `materials` or [`NO_MATERIAL`]; empty where `materials` is.
    pub triangle_materials: Vec<u32>,
}

/// A mesh as a file holds it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// The mesh. Vertices are shared where position, normal and texture coordinates agree in every bit.
    pub mesh: TriangleMesh,
    /// Files of materials that the file names, as written.
    pub libraries: Vec<String>,
    /// Vertices in the file.
    pub vertices: usize,
    /// Vertices in the file that no face uses; they are left out of `mesh`.
    pub isolated: usize,
    /// Whether the file indexes positions, normals and texture coordinates apart, so that its vertices are positions.
    pub positions_only: bool,
}

impl Loaded {
    /// Vertices in the file that repeat another one bit for bit.
    #[must_use]
    pub fn repeated(&self) -> usize {
        let used = self.vertices - self.isolated;
        let split = self.mesh.normals.is_some() || self.mesh.texcoords.is_some();
        let kept =
            if self.positions_only && split { self.mesh.distinct_positions() } else { self.mesh.positions.len() };
        used.saturating_sub(kept)
    }
}

/// Hears how far the reading of meshes is. `()` hears nothing.
pub trait ReadMonitor: Sync {
    /// Receives the path of each file that the scene names, before it is read.
    fn names(&self, _path: &Path) {}
    /// A file of `bytes` bytes is begun.
    fn begin(&self, path: &Path, bytes: u64);
    /// `bytes` more of its bytes are done.
    fn advance(&self, bytes: u64);
    /// The file is done.
    fn end(&self, path: &Path, mesh: &TriangleMesh);
}

impl ReadMonitor for () {
    fn begin(&self, _: &Path, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self, _: &Path, _: &TriangleMesh) {}
}

/// Reads the triangles of a PLY file, or of an OBJ file where it is not one; polygons are cut into fans about their first corner.
///
/// # Errors
/// See [`MeshError`]; all name the file.
pub fn load(path: &Path, monitor: &dyn ReadMonitor) -> Result<Loaded, MeshError> {
    load_within(path, monitor, None)
}

/// As [`load`], within `free` bytes of memory, where that number is known: a mesh that takes more is refused before it takes any.
///
/// # Errors
/// See [`MeshError`]; all name the file.
pub fn load_within(path: &Path, monitor: &dyn ReadMonitor, free: Option<u64>) -> Result<Loaded, MeshError> {
    let bytes = read(path, free)?;
    let free = free.map(|free| free.saturating_sub(bytes.len() as u64));
    decode(path, bytes, monitor, free)
}

/// As [`load_within`], of the bytes of a file that errors call `path`.
///
/// # Errors
/// See [`MeshError`].
pub fn decode(path: &Path, bytes: Vec<u8>, monitor: &dyn ReadMonitor, free: Option<u64>) -> Result<Loaded, MeshError> {
    monitor.begin(path, bytes.len() as u64);
    let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    let text = without_bom(&bytes);
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

/// `v` at unit length, or zero where it is too short or long to tell.
///
/// What is of unit length but for rounding stays as it is, so that a normal that was written reads back bit for bit.
pub(in crate::format) fn unit_normal(v: DVec3) -> DVec3 {
    let squared = v.length_squared();
    // Normalising errs by 2.5 ulps a component, so by some 5 in the square, and summing it by 3 more.
    if (squared - 1.0).abs() <= 8.0 * f64::EPSILON {
        v
    } else if squared.is_normal() {
        v.normalize()
    } else {
        DVec3::ZERO
    }
}
