//! Repair of meshes: merges vertices, removes duplicate and degenerate triangles, and makes
//! windings consistent and outward. [`MeshRepairOptions`] selects the repairs.

use super::TriangleMesh;
use super::report::mark_duplicate_triangles;
use super::topology::MeshTopology;
use serde::Serialize;

/// Selection of repairs to make on a mesh. The repairs are made in the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshRepairOptions {
    /// Distance within which vertex positions are merged \[length]. 0 merges only equal positions,
    /// and `None` merges none.
    ///
    /// In every case, vertices that are equal bit for bit in all their data are merged.
    pub weld_tolerance: Option<f64>,
    /// True if each triangle is removed that has the same three positions as an earlier triangle,
    /// in any order.
    pub removes_duplicates: bool,
    /// True if triangles of area 0 are removed, except for those that keep the surface closed.
    pub removes_degenerates: bool,
    /// True if windings are made consistent and outward; see [`TriangleMesh::orient_outward`].
    pub orients_outward: bool,
}

impl MeshRepairOptions {
    /// Default merge distance of vertices, as a fraction of the diagonal of the mesh's bounds.
    ///
    /// It is far below 6·10⁻⁸, the relative rounding error of single precision. So it hardly merges
    /// positions that differ in single precision, if the coordinates are as large as the diagonal.
    pub const DEFAULT_RELATIVE_WELD_TOLERANCE: f64 = 1e-9;
}

/// Counts of the repairs that were made on a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RepairCounts {
    /// Number of distinct positions that were merged into others.
    #[serde(rename = "welded")]
    pub welded_positions: usize,
    /// Number of removed triangles that had the same three positions as an earlier one.
    #[serde(rename = "duplicates")]
    pub removed_duplicates: usize,
    /// Number of removed triangles without area.
    #[serde(rename = "degenerate")]
    pub removed_degenerates: usize,
    /// Number of triangles flipped to make windings consistent and outward.
    #[serde(rename = "turned")]
    pub flipped_triangles: usize,
}

pub(super) fn repair(mesh: &mut TriangleMesh, repair: &MeshRepairOptions) -> RepairCounts {
    let mut done = RepairCounts::default();
    if let Some(tolerance) = repair.weld_tolerance {
        done.welded_positions = mesh.weld_vertices(tolerance);
    }
    if repair.removes_duplicates {
        let duplicates = mark_duplicate_triangles(mesh, &MeshTopology::new(mesh));
        done.removed_duplicates = remove_triangles(mesh, &duplicates);
    }
    if repair.removes_degenerates {
        let degenerate = mark_removable_degenerates(mesh);
        done.removed_degenerates = remove_triangles(mesh, &degenerate);
    }
    if repair.orients_outward {
        done.flipped_triangles = mesh.orient_outward();
    }
    mesh.merge_equal_vertices();
    done
}

/// Marks triangles of area 0 that can be removed without opening the surface.
///
/// A triangle of area 0 is kept if each of its edges has exactly two triangles. It may then close
/// the gap at a T-junction, where a vertex lies on an edge of another triangle.
fn mark_removable_degenerates(mesh: &TriangleMesh) -> Vec<bool> {
    let topology = MeshTopology::new(mesh);
    let mut closing = vec![0_u8; mesh.triangles.len()];
    for half_edges in topology.half_edges_by_edge().filter(|half_edges| half_edges.len() == 2) {
        half_edges.iter().for_each(|half_edge| closing[half_edge.triangle as usize] += 1);
    }
    mesh.triangles.iter().zip(closing).map(|(t, edges)| mesh.triangle_area(*t) == 0.0 && edges < 3).collect()
}

/// Removes the triangles that are marked in `unwanted`, and returns their number.
fn remove_triangles(mesh: &mut TriangleMesh, unwanted: &[bool]) -> usize {
    let before = mesh.triangles.len();
    let mut keep = unwanted.iter().map(|unwanted| !unwanted);
    mesh.triangle_materials.retain(|_| keep.next().unwrap_or(true));
    let mut keep = unwanted.iter().map(|unwanted| !unwanted);
    mesh.triangles.retain(|_| keep.next().unwrap_or(true));
    remove_unused_materials(mesh);
    before - mesh.triangles.len()
}

/// Keeps only the materials that a triangle uses, and renumbers them.
fn remove_unused_materials(mesh: &mut TriangleMesh) {
    let mut used = vec![false; mesh.materials.len()];
    for number in &mesh.triangle_materials {
        if let Some(used) = used.get_mut(*number as usize) {
            *used = true;
        }
    }
    if used.iter().all(|used| *used) {
        return;
    }
    let mut next = 0;
    let renumbered: Vec<u32> = used
        .iter()
        .map(|used| {
            next += u32::from(*used);
            next.wrapping_sub(1)
        })
        .collect();
    for number in &mut mesh.triangle_materials {
        *number = renumbered.get(*number as usize).copied().unwrap_or(*number);
    }
    let mut keep = used.into_iter();
    mesh.materials.retain(|_| keep.next().unwrap_or(true));
    if mesh.materials.is_empty() {
        mesh.triangle_materials.clear();
    }
}
