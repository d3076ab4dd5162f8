//! Measurements of a mesh: size, area, volume and topology.

use super::topology::{MeshTopology, ParityUnionFind};
use super::{TriangleMesh, point_bounds};
use glam::DVec3;
use serde::Serialize;

/// Measurements of a mesh.
///
/// Triangles are adjacent if they share vertex positions. Normals and texture coordinates that
/// differ at a position do not separate them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of vertices that equal an earlier vertex bit for bit, without the vertices that no
    /// triangle uses.
    pub repeated_vertices: usize,
    /// Number of vertices that no triangle uses.
    pub isolated_vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// True if the mesh has normals.
    #[serde(rename = "normals")]
    pub has_normals: bool,
    /// True if the mesh has texture coordinates.
    #[serde(rename = "texture_coordinates")]
    pub has_texcoords: bool,
    /// Lower corner of the bounds of all triangles; +∞ if there are none.
    #[serde(rename = "min")]
    pub bounds_min: [f64; 3],
    /// Upper corner of the bounds of all triangles; −∞ if there are none.
    #[serde(rename = "max")]
    pub bounds_max: [f64; 3],
    /// Total area of the triangles \[length²].
    pub area: f64,
    /// Signed enclosed volume \[length³], negative if the mesh is inside out.
    ///
    /// `None` if the mesh is open or its windings are inconsistent.
    pub volume: Option<f64>,
    /// True if every edge has at least two triangles; false for a mesh without triangles.
    #[serde(rename = "closed")]
    pub is_closed: bool,
    /// True if each edge has at most two triangles, and the triangles around each vertex form a
    /// single fan, connected by edges.
    #[serde(rename = "manifold")]
    pub is_manifold: bool,
    /// True if flipping triangles can make all windings consistent.
    #[serde(rename = "orientable")]
    pub is_orientable: bool,
    /// Number of edges with one triangle.
    pub boundary_edges: usize,
    /// Number of edges with more than two triangles.
    pub non_manifold_edges: usize,
    /// Number of non-manifold vertex positions. The triangles at such a position form several fans
    /// that no common edge connects.
    pub non_manifold_vertices: usize,
    /// Number of edges that both their triangles traverse in the same direction. The winding of one
    /// of the two must then be wrong.
    pub inconsistent_edges: usize,
    /// Number of triangles of area 0.
    #[serde(rename = "degenerate_faces")]
    pub degenerate_triangles: usize,
    /// Number of triangles that have the same three positions as an earlier one, in any order.
    /// Triangles with two equal positions do not count.
    #[serde(rename = "duplicate_faces")]
    pub duplicate_triangles: usize,
    /// Number of connected components. Triangles with a common edge are connected.
    pub components: usize,
    /// Euler characteristic: number of positions − number of edges + number of triangles. Triangles
    /// with two equal positions are left out.
    pub euler_characteristic: i64,
    /// Sum of the genera (numbers of handles) of all components; `None` if the mesh is open, not
    /// manifold or not orientable.
    pub genus: Option<i64>,
}

pub(super) fn mesh_report(mesh: &TriangleMesh) -> MeshReport {
    let topology = MeshTopology::new(mesh);
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
    let corners = mesh.triangles.iter().flatten().map(|v| mesh.positions[*v as usize]);
    let (min, max) = point_bounds(corners);
    let counts = TopologyCounts::new(mesh, &topology);
    let closed = counts.boundary_edges == 0 && counts.faces > 0;
    let manifold = counts.non_manifold_edges == 0 && counts.non_manifold_vertices == 0;
    let euler = counts.positions as i64 - counts.edges as i64 + counts.faces as i64;
    let handles = closed && manifold && counts.is_orientable;
    let mut shared = mesh.clone();
    shared.merge_equal_vertices();
    let isolated = used.iter().filter(|used| !**used).count();
    MeshReport {
        vertices: mesh.positions.len(),
        repeated_vertices: (mesh.positions.len() - isolated).saturating_sub(shared.positions.len()),
        isolated_vertices: isolated,
        triangles: mesh.triangles.len(),
        materials: mesh.materials.clone(),
        has_normals: mesh.normals.is_some(),
        has_texcoords: mesh.texcoords.is_some(),
        bounds_min: min.to_array(),
        bounds_max: max.to_array(),
        area: mesh.triangles.iter().map(|t| mesh.triangle_area(*t)).sum(),
        volume: (closed && counts.has_balanced_edges).then(|| signed_volume(mesh, 0.5 * (min + max))),
        is_closed: closed,
        is_manifold: manifold,
        is_orientable: counts.is_orientable,
        boundary_edges: counts.boundary_edges,
        non_manifold_edges: counts.non_manifold_edges,
        non_manifold_vertices: counts.non_manifold_vertices,
        inconsistent_edges: counts.inconsistent_edges,
        degenerate_triangles: mesh.triangles.iter().filter(|t| mesh.triangle_area(**t) == 0.0).count(),
        duplicate_triangles: mark_duplicate_triangles(mesh, &topology).iter().filter(|d| **d).count(),
        components: counts.components,
        euler_characteristic: euler,
        genus: handles.then_some(counts.components as i64 - euler / 2),
    }
}

pub(super) fn bounds_diagonal(mesh: &TriangleMesh) -> f64 {
    let (low, high) = point_bounds(mesh.positions.iter().copied());
    let diagonal = (high - low).length();
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

pub(super) fn triangle_area(mesh: &TriangleMesh, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
    0.5 * (b - a).cross(c - a).length()
}

/// Returns the signed volume of a closed mesh \[length³], as a sum of signed tetrahedra.
///
/// `about` is the common apex of the tetrahedra. An apex near the mesh reduces cancellation.
fn signed_volume(mesh: &TriangleMesh, about: DVec3) -> f64 {
    let six = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize] - about);
        a.dot(b.cross(c))
    };
    mesh.triangles.iter().map(six).sum::<f64>() / 6.0
}

/// Marks each triangle that has the same three positions as an earlier one, in any order.
///
/// Triangles with two equal positions are not marked.
pub(super) fn mark_duplicate_triangles(mesh: &TriangleMesh, topology: &MeshTopology) -> Vec<bool> {
    let mut keys: Vec<([u32; 3], u32)> = Vec::with_capacity(mesh.triangles.len());
    for (t, triangle) in
        mesh.triangles.iter().enumerate().filter(|(_, triangle)| topology.has_distinct_positions(**triangle))
    {
        let mut sorted_positions = triangle.map(|v| topology.vertex_position_indices[v as usize]);
        sorted_positions.sort_unstable();
        keys.push((sorted_positions, t as u32));
    }
    keys.sort_unstable();
    let mut duplicates = vec![false; mesh.triangles.len()];
    for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        duplicates[pair[1].1 as usize] = true;
    }
    duplicates
}

/// Counts of a mesh's edges, faces, components and topological defects; see [`MeshReport`].
struct TopologyCounts {
    /// Number of distinct positions that triangles use.
    positions: usize,
    edges: usize,
    /// Number of triangles with three different positions.
    faces: usize,
    boundary_edges: usize,
    non_manifold_edges: usize,
    non_manifold_vertices: usize,
    inconsistent_edges: usize,
    is_orientable: bool,
    /// True if half of the triangles at each edge traverse the edge in one direction, and half in
    /// the other.
    has_balanced_edges: bool,
    components: usize,
}

impl TopologyCounts {
    fn new(mesh: &TriangleMesh, topology: &MeshTopology) -> Self {
        let whole: Vec<usize> =
            (0..mesh.triangles.len()).filter(|t| topology.has_distinct_positions(mesh.triangles[*t])).collect();
        let mut this = Self {
            positions: 0,
            edges: 0,
            faces: whole.len(),
            boundary_edges: 0,
            non_manifold_edges: 0,
            non_manifold_vertices: 0,
            inconsistent_edges: 0,
            is_orientable: true,
            has_balanced_edges: true,
            components: 0,
        };
        let mut surfaces = ParityUnionFind::new(mesh.triangles.len());
        let mut windings = ParityUnionFind::new(mesh.triangles.len());
        let mut fans = ParityUnionFind::new(3 * mesh.triangles.len());
        for half_edges in topology.half_edges_by_edge() {
            this.edges += 1;
            let forward = half_edges.iter().filter(|half_edge| half_edge.is_forward).count();
            this.has_balanced_edges &= 2 * forward == half_edges.len();
            match half_edges {
                [_] => this.boundary_edges += 1,
                [a, b] => {
                    let against = a.is_forward == b.is_forward;
                    this.inconsistent_edges += usize::from(against);
                    this.is_orientable &= windings.union_sets(a.triangle as usize, b.triangle as usize, against);
                }
                _ => this.non_manifold_edges += 1,
            }
            for half_edge in &half_edges[1..] {
                surfaces.union_sets(half_edges[0].triangle as usize, half_edge.triangle as usize, false);
                for (a, b) in
                    half_edges[0].corners_in_position_order().into_iter().zip(half_edge.corners_in_position_order())
                {
                    fans.union_sets(a, b, false);
                }
            }
        }
        let mut fan_count = vec![0_u8; topology.position_count];
        for t in whole {
            this.components += usize::from(surfaces.find_root(t).0 == t);
            for (k, v) in mesh.triangles[t].into_iter().enumerate() {
                if fans.find_root(3 * t + k).0 == 3 * t + k {
                    let count = &mut fan_count[topology.vertex_position_indices[v as usize] as usize];
                    *count = count.saturating_add(1);
                }
            }
        }
        this.positions = fan_count.iter().filter(|count| **count > 0).count();
        this.non_manifold_vertices = fan_count.iter().filter(|count| **count > 1).count();
        this
    }
}
