//! What there is to say of a mesh.

use super::TriangleMesh;
use super::topology::{Topology, Union};
use glam::DVec3;
use serde::Serialize;

/// Figures of a mesh. Edges and surfaces go by the places of vertices, so that seams of normals and
/// texture coordinates are none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshReport {
    /// Vertices.
    pub vertices: usize,
    /// Vertices that repeat another one bit for bit.
    pub repeated_vertices: usize,
    /// Vertices that no triangle uses.
    pub isolated_vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Whether there are normals.
    pub normals: bool,
    /// Whether there are texture coordinates.
    pub texture_coordinates: bool,
    /// Lowest coordinates of vertices that are used.
    pub min: [f64; 3],
    /// Highest coordinates.
    pub max: [f64; 3],
    /// Sum of the triangles' areas \[length²].
    pub area: f64,
    /// Volume inside, by the divergence theorem \[length³]; `None` unless it is closed and all
    /// windings agree.
    pub volume: Option<f64>,
    /// Whether no edge is open.
    pub closed: bool,
    /// Whether each edge has at most two faces, and the faces around each vertex hang together over
    /// edges.
    pub manifold: bool,
    /// Whether windings could agree everywhere.
    pub orientable: bool,
    /// Edges of one face.
    pub boundary_edges: usize,
    /// Edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Places where surfaces touch that do not hang together there over edges.
    pub non_manifold_vertices: usize,
    /// Edges whose two faces are wound against each other.
    pub inconsistent_edges: usize,
    /// Faces without area.
    pub degenerate_faces: usize,
    /// Faces whose corners are the places of an earlier one's, however wound.
    pub duplicate_faces: usize,
    /// Surfaces that hang together over edges.
    pub components: usize,
    /// Places − edges + faces, without faces of fewer than three places.
    pub euler_characteristic: i64,
    /// Handles of all components; `None` unless closed, manifold and orientable.
    pub genus: Option<i64>,
}

impl TriangleMesh {
    /// What there is to say of the mesh.
    #[must_use]
    pub fn report(&self) -> MeshReport {
        let topology = Topology::new(self);
        let mut used = vec![false; self.positions.len()];
        self.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
        let corners = self.triangles.iter().flatten().map(|v| self.positions[*v as usize]);
        let (min, max) =
            corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let surface = Surface::of(self, &topology);
        let closed = surface.boundary == 0 && surface.faces > 0;
        let manifold = surface.crowded == 0 && surface.pinched == 0;
        let euler = surface.places as i64 - surface.edges as i64 + surface.faces as i64;
        let handles = closed && manifold && surface.orientable;
        let mut shared = self.clone();
        shared.share();
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
            area: self.triangles.iter().map(|t| self.area(*t)).sum(),
            volume: (closed && surface.balanced).then(|| self.volume(0.5 * (min + max))),
            closed,
            manifold,
            orientable: surface.orientable,
            boundary_edges: surface.boundary,
            non_manifold_edges: surface.crowded,
            non_manifold_vertices: surface.pinched,
            inconsistent_edges: surface.inconsistent,
            degenerate_faces: self.triangles.iter().filter(|t| self.area(**t) == 0.0).count(),
            duplicate_faces: self.duplicates(&topology).iter().filter(|d| **d).count(),
            components: surface.components,
            euler_characteristic: euler,
            genus: handles.then_some(surface.components as i64 - euler / 2),
        }
    }

    /// Length of the diagonal of the box around all vertices; 0 where that is no finite number.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = self.positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
        let diagonal = (high - low).length();
        if diagonal.is_finite() { diagonal } else { 0.0 }
    }

    /// Area of a triangle \[length²].
    #[must_use]
    pub fn area(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Signed volume inside of a closed mesh, summed about a point near it \[length³].
    fn volume(&self, about: DVec3) -> f64 {
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize] - about);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// Which triangles have the three places of an earlier one.
    pub(super) fn duplicates(&self, topology: &Topology) -> Vec<bool> {
        let mut keys: Vec<([u32; 3], u32)> = Vec::with_capacity(self.triangles.len());
        for (t, triangle) in self.triangles.iter().enumerate().filter(|(_, triangle)| topology.is_whole(**triangle)) {
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

/// Counts over edges.
struct Surface {
    places: usize,
    edges: usize,
    faces: usize,
    boundary: usize,
    crowded: usize,
    pinched: usize,
    inconsistent: usize,
    orientable: bool,
    /// Whether each edge is passed as often one way as the other.
    balanced: bool,
    components: usize,
}

impl Surface {
    fn of(mesh: &TriangleMesh, topology: &Topology) -> Self {
        let whole: Vec<usize> = (0..mesh.triangles.len()).filter(|t| topology.is_whole(mesh.triangles[*t])).collect();
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
        let mut surfaces = Union::new(mesh.triangles.len());
        let mut windings = Union::new(mesh.triangles.len());
        let mut fans = Union::new(3 * mesh.triangles.len());
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
                for (a, b) in sides[0].corners().into_iter().zip(side.corners()) {
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
