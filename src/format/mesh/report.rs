//! Facts about a mesh: size, area, volume and topology.

use super::TriangleMesh;
use super::topology::{MeshTopology, ParityUnionFind};
use glam::DVec3;
use serde::Serialize;

/// Facts about a mesh.
///
/// Edges and surfaces are defined by vertex positions, so seams of normals or texture coordinates
/// are no borders.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of vertices that repeat another one bit for bit.
    pub repeated_vertices: usize,
    /// Number of vertices that no triangle uses.
    pub isolated_vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// True if the mesh has normals.
    pub normals: bool,
    /// True if the mesh has texture coordinates.
    pub texture_coordinates: bool,
    /// Lowest coordinates of the used vertices.
    pub min: [f64; 3],
    /// Highest coordinates of the used vertices.
    pub max: [f64; 3],
    /// Total area of the triangles \[length²].
    pub area: f64,
    /// Enclosed volume by the divergence theorem \[length³]; `None` unless closed and consistently
    /// wound.
    pub volume: Option<f64>,
    /// True if every edge has more than one face.
    pub closed: bool,
    /// True if each edge has at most two faces, and edges connect all faces around each vertex.
    pub manifold: bool,
    /// True if windings can be made consistent.
    pub orientable: bool,
    /// Number of edges with one face.
    pub boundary_edges: usize,
    /// Number of edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Number of positions where surfaces touch without a common edge.
    pub non_manifold_vertices: usize,
    /// Number of edges whose two faces have opposite windings.
    pub inconsistent_edges: usize,
    /// Number of triangles without area.
    pub degenerate_faces: usize,
    /// Number of triangles that have the three positions of an earlier one, in any order.
    pub duplicate_faces: usize,
    /// Number of surfaces connected by edges.
    pub components: usize,
    /// Positions − edges + faces, without faces of fewer than three positions.
    pub euler_characteristic: i64,
    /// Number of handles of all components; `None` unless closed, manifold and orientable.
    pub genus: Option<i64>,
}

impl TriangleMesh {
    /// Computes the facts about the mesh.
    #[must_use]
    pub fn report(&self) -> MeshReport {
        let topology = MeshTopology::new(self);
        let mut used = vec![false; self.positions.len()];
        self.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        let corners = self.triangles.iter().flatten().map(|v| self.positions[*v as usize]);
        let (min, max) =
            corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let surface = TopologyCounts::new(self, &topology);
        let closed = surface.boundary == 0 && surface.faces > 0;
        let manifold = surface.crowded == 0 && surface.pinched == 0;
        let euler = surface.places as i64 - surface.edges as i64 + surface.faces as i64;
        let handles = closed && manifold && surface.orientable;
        let mut shared = self.clone();
        shared.merge_equal_vertices();
        let isolated = used.iter().filter(|used| !**used).count();
        MeshReport {
            vertices: self.positions.len(),
            repeated_vertices: (self.positions.len() - isolated).saturating_sub(shared.positions.len()),
            isolated_vertices: isolated,
            triangles: self.triangles.len(),
            materials: self.materials.clone(),
            normals: self.normals.is_some(),
            texture_coordinates: self.texcoords.is_some(),
            min: min.to_array(),
            max: max.to_array(),
            area: self.triangles.iter().map(|t| self.triangle_area(*t)).sum(),
            volume: (closed && surface.balanced).then(|| self.signed_volume(0.5 * (min + max))),
            closed,
            manifold,
            orientable: surface.orientable,
            boundary_edges: surface.boundary,
            non_manifold_edges: surface.crowded,
            non_manifold_vertices: surface.pinched,
            inconsistent_edges: surface.inconsistent,
            degenerate_faces: self.triangles.iter().filter(|t| self.triangle_area(**t) == 0.0).count(),
            duplicate_faces: self.duplicate_triangles(&topology).iter().filter(|d| **d).count(),
            components: surface.components,
            euler_characteristic: euler,
            genus: handles.then_some(surface.components as i64 - euler / 2),
        }
    }

    /// Diagonal of the box around all vertices \[length]; 0 if it is not finite.
    #[must_use]
    pub fn bounds_diagonal(&self) -> f64 {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = self.positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
        let diagonal = (high - low).length();
        if diagonal.is_finite() { diagonal } else { 0.0 }
    }

    /// Area of a triangle \[length²].
    #[must_use]
    pub fn triangle_area(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Signed volume of a closed mesh \[length³], summed about the point `about` near it.
    fn signed_volume(&self, about: DVec3) -> f64 {
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize] - about);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// True for each triangle that has the three positions of an earlier one.
    pub(super) fn duplicate_triangles(&self, topology: &MeshTopology) -> Vec<bool> {
        let mut keys: Vec<([u32; 3], u32)> = Vec::with_capacity(self.triangles.len());
        for (t, triangle) in
            self.triangles.iter().enumerate().filter(|(_, triangle)| topology.has_distinct_positions(**triangle))
        {
            let mut places = triangle.map(|v| topology.places[v as usize]);
            places.sort_unstable();
            keys.push((places, t as u32));
        }
        keys.sort_unstable();
        let mut duplicates = vec![false; self.triangles.len()];
        for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            duplicates[pair[1].1 as usize] = true;
        }
        duplicates
    }
}

/// Counts over the edges of a mesh.
struct TopologyCounts {
    places: usize,
    edges: usize,
    faces: usize,
    boundary: usize,
    crowded: usize,
    pinched: usize,
    inconsistent: usize,
    orientable: bool,
    /// True if each edge is traversed equally often in both directions.
    balanced: bool,
    components: usize,
}

impl TopologyCounts {
    fn new(mesh: &TriangleMesh, topology: &MeshTopology) -> Self {
        let whole: Vec<usize> =
            (0..mesh.triangles.len()).filter(|t| topology.has_distinct_positions(mesh.triangles[*t])).collect();
        let mut this = Self {
            places: 0,
            edges: 0,
            faces: whole.len(),
            boundary: 0,
            crowded: 0,
            pinched: 0,
            inconsistent: 0,
            orientable: true,
            balanced: true,
            components: 0,
        };
        let mut surfaces = ParityUnionFind::new(mesh.triangles.len());
        let mut windings = ParityUnionFind::new(mesh.triangles.len());
        let mut fans = ParityUnionFind::new(3 * mesh.triangles.len());
        for sides in topology.edges() {
            this.edges += 1;
            let forward = sides.iter().filter(|side| side.forward).count();
            this.balanced &= 2 * forward == sides.len();
            match sides {
                [_] => this.boundary += 1,
                [a, b] => {
                    let against = a.forward == b.forward;
                    this.inconsistent += usize::from(against);
                    this.orientable &= windings.join(a.triangle as usize, b.triangle as usize, against);
                }
                _ => this.crowded += 1,
            }
            for side in &sides[1..] {
                surfaces.join(sides[0].triangle as usize, side.triangle as usize, false);
                for (a, b) in sides[0].corner_indices().into_iter().zip(side.corner_indices()) {
                    fans.join(a, b, false);
                }
            }
        }
        let mut fan_count = vec![0_u8; topology.place_count];
        for t in whole {
            this.components += usize::from(surfaces.find(t).0 == t);
            for (k, v) in mesh.triangles[t].into_iter().enumerate() {
                if fans.find(3 * t + k).0 == 3 * t + k {
                    let count = &mut fan_count[topology.places[v as usize] as usize];
                    *count = count.saturating_add(1);
                }
            }
        }
        this.places = fan_count.iter().filter(|count| **count > 0).count();
        this.pinched = fan_count.iter().filter(|count| **count > 1).count();
        this
    }
}
