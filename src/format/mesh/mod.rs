//! Triangle meshes: reading, writing, inspection and repair.

mod error;
mod merge;
mod normals;
mod obj;
mod options;
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
pub(in crate::format) use merge::{DeduplicatedList, coordinate_bits};
pub use options::MeshOptions;
pub use repair::{MeshRepairOptions, RepairCounts};
pub use report::MeshReport;
pub use solid::{SOLIDITY_BYTES_PER_TRIANGLE, SolidDefect};
pub use write::MeshFormat;
pub(in crate::format) use write::ShortestDecimal;

use super::line_error::strip_byte_order_mark;
use crate::image::WriteError;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Material index of triangles without a material.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Indexed triangle mesh, as in a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions. After reading, at least one triangle uses each of them.
    pub positions: Vec<DVec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    ///
    /// Readers keep degenerate triangles, whose area is 0.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals of the vertices; `None` if no triangle has normals.
    ///
    /// A triangle without normals has zero vectors at all its corners.
    pub normals: Option<Vec<DVec3>>,
    /// Texture coordinates of the vertices; `None` if no vertex has any.
    ///
    /// If only some vertices have texture coordinates, the others have (0, 0).
    pub texcoords: Option<Vec<DVec2>>,
    /// Names of the materials. After reading, at least one triangle uses each of them.
    pub materials: Vec<String>,
    /// Material index of each triangle: an index into `materials`, or [`NO_MATERIAL`].
    ///
    /// The list is empty if `materials` is empty.
    pub triangle_materials: Vec<u32>,
}

impl TriangleMesh {
    /// True if both meshes have the same triangles and materials, and equal vertices bit for bit.
    pub(in crate::format) fn is_equal_in_bits(&self, other: &Self) -> bool {
        let Self { positions, triangles, normals, texcoords, materials, triangle_materials } = self;
        triangles == &other.triangles
            && materials == &other.materials
            && triangle_materials == &other.triangle_materials
            && are_equal_in_bits(Some(positions), Some(&other.positions))
            && are_equal_in_bits(normals.as_ref(), other.normals.as_ref())
            && are_equal_in_bits(texcoords.as_ref(), other.texcoords.as_ref())
    }

    /// Merges vertices that are equal bit for bit, and removes unused vertices.
    ///
    /// Afterwards, vertices are in the order in which the triangles use them. A triangle that has
    /// no normal at one corner loses its normals at the others.
    pub fn merge_equal_vertices(&mut self) {
        merge::merge_equal_vertices(self);
    }

    /// Numbers the distinct vertex positions from 0, in the order of the vertices at which they
    /// first occur.
    ///
    /// Returns a list with the number of each vertex's position, and the count of distinct
    /// positions. Coordinates −0 and 0 are equal here.
    #[must_use]
    pub fn distinct_position_indices(&self) -> (Vec<u32>, usize) {
        merge::distinct_position_indices(self)
    }

    /// Moves each vertex to the position of the first vertex before it that lies within `tolerance`
    /// \[length] and was not moved itself. Then merges equal vertices and removes unused ones.
    ///
    /// Returns the decrease in the number of distinct positions.
    pub fn weld_vertices(&mut self, tolerance: f64) -> usize {
        weld::weld_vertices(self, tolerance)
    }

    /// Repairs the mesh as `repair` selects. Returns how many elements each repair changed.
    ///
    /// Always merges vertices that are equal bit for bit, and removes unused vertices.
    pub fn repair(&mut self, repair: &MeshRepairOptions) -> RepairCounts {
        repair::repair(self, repair)
    }

    /// Computes smooth shading normals for all triangles that have none.
    ///
    /// A vertex normal is the mean of the normals of adjacent faces, weighted by their corner
    /// angles (Thürmer and Wüthrich 1998, "Computing vertex normals from polygonal facets"). The
    /// mean extends across an edge if the normals of its two faces differ by at most `angle`
    /// \[degrees].
    ///
    /// Vertices are split at all other edges:
    ///
    /// - edges whose face normals differ by more than `angle`,
    /// - edges with one face, or with more than two faces,
    /// - edges whose two faces have inconsistent windings.
    pub fn compute_missing_smooth_normals(&mut self, angle: f64) {
        normals::compute_missing_smooth_normals(self, angle);
    }

    /// Makes the windings of each connected component consistent and outward. Returns the number of
    /// flipped triangles.
    ///
    /// - Closed components get a positive signed volume, so they face outward. A component inside
    ///   an odd number of other closed components of the same material faces inward instead.
    ///   Nesting is ignored if the mesh has more than 256 closed components.
    /// - In open components, all triangles get the winding that the majority has.
    /// - Non-orientable components, such as Möbius strips, are not changed.
    ///
    /// Shading normals of flipped triangles are reversed if they would point to the back side.
    pub fn orient_outward(&mut self) -> usize {
        orient::orient_outward(self)
    }

    /// Reverses the winding of all triangles and the direction of all normals.
    pub fn reverse_orientation(&mut self) {
        orient::reverse_orientation(self);
    }

    /// Splits the mesh by material. Returns one mesh per material, with its material index.
    ///
    /// The list is in the order of the first triangle of each material. Triangles without material
    /// have index [`NO_MATERIAL`]. The returned meshes have empty lists of materials.
    #[must_use]
    pub fn split_by_material(&self) -> Vec<(u32, Self)> {
        split::split_by_material(self)
    }

    /// Returns the mesh's size, area, volume, and topological counts.
    #[must_use]
    pub fn mesh_report(&self) -> MeshReport {
        report::mesh_report(self)
    }

    /// Returns the length of the bounding box's diagonal \[length]; 0 if the diagonal is not
    /// finite.
    #[must_use]
    pub fn bounds_diagonal(&self) -> f64 {
        report::bounds_diagonal(self)
    }

    /// Returns the area of the triangle with the given vertex indices \[length²].
    #[must_use]
    pub fn triangle_area(&self, triangle: [u32; 3]) -> f64 {
        report::triangle_area(self, triangle)
    }

    /// Returns the first defect that keeps the mesh from bounding a solid body; `None` if the mesh
    /// is closed and faces outward.
    ///
    /// The shading normals of a triangle decide which of its sides is the outside. Without normals,
    /// the winding decides. Triangles with two corners at one position are ignored.
    #[must_use]
    pub fn solid_defect(&self) -> Option<SolidDefect> {
        solid::solid_defect(self)
    }

    /// Writes a mesh file. The file is written under a temporary name and then renamed, so that a
    /// failure leaves an existing file unchanged. A reader gets exactly the numbers of the mesh.
    ///
    /// `libraries` are the paths of MTL files for the `mtllib` lines of an OBJ file. An OBJ file
    /// also names the material of each triangle. A PLY file has no materials.
    ///
    /// # Errors
    ///
    /// [`WriteError`] if the file cannot be written.
    pub fn write(&self, path: &Path, format: MeshFormat, libraries: &[String]) -> Result<(), WriteError> {
        write::write(self, path, format, libraries)
    }
}

/// Mesh that was read from a file, with the paths of its material files and vertex statistics.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The mesh. No two vertices are equal bit for bit in position, normal and texture coordinates.
    pub mesh: TriangleMesh,
    /// Arguments of the `mtllib` lines of an OBJ file, as written: paths of MTL files.
    pub mtllib_arguments: Vec<String>,
    /// Number of vertices in the file, before equal ones are merged.
    pub file_vertex_count: usize,
    /// Number of vertices in the file that no face uses. `mesh` does not contain them.
    pub isolated_vertex_count: usize,
    /// True if the file indexes normals and texture coordinates separately from positions, as OBJ
    /// files do.
    pub has_separate_indices: bool,
}

impl LoadedMesh {
    /// Returns the number of vertices in the file that repeat an earlier vertex bit for bit.
    ///
    /// Vertices that no face uses do not count. For OBJ files, only positions are compared.
    #[must_use]
    pub fn repeated_vertex_count(&self) -> usize {
        let used = self.file_vertex_count - self.isolated_vertex_count;
        let split = self.mesh.normals.is_some() || self.mesh.texcoords.is_some();
        let kept = if self.has_separate_indices && split {
            merge::distinct_position_count(&self.mesh)
        } else {
            self.mesh.positions.len()
        };
        used.saturating_sub(kept)
    }
}

/// Receiver of progress reports while a scene's files are read. The implementation for `()` ignores
/// the reports.
pub trait MeshReadMonitor: Sync {
    /// Called with the path of each file besides the scene file itself, before the file is read.
    fn on_input_file_found(&self, _path: &Path) {}
    /// Called before parsing the mesh file at `path`, whose size is `bytes`.
    fn on_read_start(&self, path: &Path, bytes: u64);
    /// Called repeatedly during parsing, possibly by several threads. `bytes` is the number of
    /// bytes parsed since the last call; for OBJ files, an estimate.
    fn on_bytes_parsed(&self, bytes: u64);
    /// Called after parsing the file at `path`. `mesh` is the mesh of the file.
    fn on_read_end(&self, path: &Path, mesh: &TriangleMesh);
}

impl MeshReadMonitor for () {
    fn on_read_start(&self, _: &Path, _: u64) {}
    fn on_bytes_parsed(&self, _: u64) {}
    fn on_read_end(&self, _: &Path, _: &TriangleMesh) {}
}

/// Reads the triangles of a PLY or OBJ file, without a limit on memory.
///
/// Polygons become triangle fans about their first corner. A file is read as OBJ if it has neither
/// the signature nor the extension of PLY.
///
/// # Errors
/// [`MeshError`], which names the file.
pub fn load(path: &Path, monitor: &dyn MeshReadMonitor) -> Result<LoadedMesh, MeshError> {
    load_with_memory_limit(path, monitor, None)
}

/// Reads a mesh file in one of the formats of [`load`].
///
/// Fails before allocating if the mesh takes more than `free` bytes. A `free` of `None` sets no
/// limit, for systems whose free memory is unknown.
///
/// # Errors
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

/// Parses the bytes of a PLY or OBJ file by the rules of [`load_with_memory_limit`].
///
/// `path` appears in errors, and its extension `.ply` marks a PLY file.
///
/// # Errors
/// [`MeshError`].
pub fn decode(
    path: &Path,
    bytes: Vec<u8>,
    monitor: &dyn MeshReadMonitor,
    free: Option<u64>,
) -> Result<LoadedMesh, MeshError> {
    monitor.on_read_start(path, bytes.len() as u64);
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
    monitor.on_read_end(path, &loaded.mesh);
    Ok(loaded)
}

/// True if both lists exist and hold the same vectors bit for bit, or if neither exists.
fn are_equal_in_bits<const N: usize, V: Copy + Into<[f64; N]>>(a: Option<&Vec<V>>, b: Option<&Vec<V>>) -> bool {
    let bits = |vector: &V| (*vector).into().map(f64::to_bits);
    match (a, b) {
        (Some(a), Some(b)) => a.iter().map(bits).eq(b.iter().map(bits)),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// Returns the lower and upper corner of the bounds of `points`; +∞ and −∞ if there are none.
fn point_bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Returns `v` scaled to unit length. Returns zero if the squared length of `v` is zero, subnormal
/// or not finite.
///
/// A vector whose length differs from 1 only by rounding is returned unchanged. So normals keep
/// their bits when they are written to a file and read back.
pub(in crate::format) fn unit_normal(v: DVec3) -> DVec3 {
    let squared = v.length_squared();
    // Normalization errs by 2.5 ulps per component, which is about 5 ulps in the squared length.
    // The sum of squares adds 3 ulps.
    if (squared - 1.0).abs() <= 8.0 * f64::EPSILON {
        v
    } else if squared.is_normal() {
        v.normalize()
    } else {
        DVec3::ZERO
    }
}
