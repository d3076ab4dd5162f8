//! Loop subdivision of triangle meshes (Loop 1987). Vertices move to their limit positions.

use crate::format::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::HashMap;

/// Sums over the neighbors of a vertex.
#[derive(Clone, Debug, Default)]
struct Neighborhood {
    /// Number of edges at the vertex.
    valence: u32,
    /// Sum of the positions of all neighbors.
    neighbor_sum: DVec3,
    /// Number of boundary edges at the vertex.
    boundary_edge_count: u32,
    /// Sum of the positions of neighbors along boundary edges.
    boundary_neighbor_sum: DVec3,
}

/// Edges of a mesh. A key holds both vertex indices, the lower one first.
///
/// A value holds the number of triangles at the edge. It also holds, for the first two of these
/// triangles, the vertex opposite to the edge.
type EdgeTable = HashMap<[u32; 2], (u32, [u32; 2])>;

/// Returns the mesh after `levels` Loop subdivisions, at its limit positions and with smooth
/// normals.
pub(super) fn loop_subdivided_to_limit(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>, levels: u32) -> TriangleMesh {
    let (mut positions, mut triangles) = (positions, triangles);
    for _ in 0..levels {
        (positions, triangles) = subdivided_once(&positions, &triangles);
    }
    let edges = edges_of_triangles(&triangles);
    let neighbors = neighborhoods(&positions, &edges);
    let limits = positions.iter().zip(&neighbors).map(|(position, around)| limit_position(*position, around));
    let mut mesh = TriangleMesh { positions: limits.collect(), triangles, ..TriangleMesh::default() };
    mesh.compute_missing_smooth_normals(180.0);
    mesh
}

/// Returns the mesh after one subdivision: each triangle becomes four.
fn subdivided_once(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let edges = edges_of_triangles(triangles);
    let neighbors = neighborhoods(positions, &edges);
    let mut fine: Vec<DVec3> = positions.iter().zip(&neighbors).map(|(p, around)| even_position(*p, around)).collect();
    let mut middles: HashMap<[u32; 2], u32> = HashMap::with_capacity(edges.len());
    let mut middle = |a: u32, b: u32| {
        let key = [a.min(b), a.max(b)];
        *middles.entry(key).or_insert_with(|| {
            let ends = positions[a as usize] + positions[b as usize];
            fine.push(match edges.get(&key) {
                Some((2, [c, d])) => 0.375 * ends + 0.125 * (positions[*c as usize] + positions[*d as usize]),
                _ => 0.5 * ends,
            });
            fine.len() as u32 - 1
        })
    };
    let mut out = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    (fine, out)
}

/// Returns the edges of a mesh. The two vertex indices of each edge are sorted.
fn edges_of_triangles(triangles: &[[u32; 3]]) -> EdgeTable {
    let mut edges = EdgeTable::with_capacity(2 * triangles.len());
    for &[a, b, c] in triangles {
        for (start, end, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
            let (count, corners) = edges.entry([start.min(end), start.max(end)]).or_default();
            if let Some(corner) = corners.get_mut(*count as usize) {
                *corner = opposite;
            }
            *count += 1;
        }
    }
    edges
}

/// Returns, for each vertex, sums over its neighbors.
fn neighborhoods(positions: &[DVec3], edges: &EdgeTable) -> Vec<Neighborhood> {
    let mut neighbors = vec![Neighborhood::default(); positions.len()];
    // A floating-point sum depends on the order of its terms, and a hash map has no order.
    let mut sorted: Vec<_> = edges.iter().collect();
    sorted.sort_unstable_by_key(|(ends, _)| **ends);
    for (&[a, b], (count, _)) in sorted {
        for (vertex, neighbor) in [(a, b), (b, a)] {
            let around = &mut neighbors[vertex as usize];
            around.valence += 1;
            around.neighbor_sum += positions[neighbor as usize];
            if *count == 1 {
                around.boundary_edge_count += 1;
                around.boundary_neighbor_sum += positions[neighbor as usize];
            }
        }
    }
    neighbors
}

/// Returns the weight of each neighbor of an inner vertex in Loop subdivision (Warren 1995).
fn neighbor_weight(valence: u32) -> f64 {
    if valence == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * f64::from(valence)) }
}

/// Returns the position of a vertex of the old mesh after one Loop subdivision.
fn even_position(position: DVec3, around: &Neighborhood) -> DVec3 {
    match around.boundary_edge_count {
        0 if around.valence > 0 => {
            let weight = neighbor_weight(around.valence);
            position * (1.0 - f64::from(around.valence) * weight) + weight * around.neighbor_sum
        }
        2 => 0.75 * position + 0.125 * around.boundary_neighbor_sum,
        _ => position,
    }
}

/// Returns the position of a vertex after infinitely many subdivisions.
fn limit_position(position: DVec3, around: &Neighborhood) -> DVec3 {
    match around.boundary_edge_count {
        0 if around.valence > 0 => {
            let valence = f64::from(around.valence);
            let weight = 1.0 / (valence + 3.0 / (8.0 * neighbor_weight(around.valence)));
            position * (1.0 - valence * weight) + weight * around.neighbor_sum
        }
        2 => 0.6 * position + 0.2 * around.boundary_neighbor_sum,
        _ => position,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let positions = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let triangles =
            [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]].to_vec();
        (positions, triangles)
    }

    /// A limit position is a fixed point: further subdivision does not move it.
    #[test]
    fn limits_do_not_depend_on_the_level() {
        let (positions, triangles) = octahedron();
        let coarse = loop_subdivided_to_limit(positions.clone(), triangles.clone(), 0);
        let fine = loop_subdivided_to_limit(positions, triangles, 3);
        assert_eq!(fine.triangles.len(), 8 * 64);
        for corner in &coarse.positions {
            assert!(fine.positions.iter().any(|p| p.abs_diff_eq(*corner, 1e-12)), "{corner}");
        }
        // Loop's rules put the limits of corners at 1/2 and those of edge midpoints at 29/96. The
        // weights are 3/8 and 1/8 for an edge, and 1/2 and 1/12 for a limit position of valence 6.
        for limit in [DVec3::X * 0.5, DVec3::new(29.0, 29.0, 0.0) / 96.0] {
            assert!(fine.positions.iter().any(|p| p.abs_diff_eq(limit, 1e-12)), "{limit}");
        }
        let normals = fine.normals.unwrap();
        assert!(fine.positions.iter().zip(&normals).all(|(p, n)| p.normalize().dot(*n) > 0.8));
    }

    #[test]
    fn a_flat_square_keeps_its_plane_and_boundary() {
        let square = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let mesh = loop_subdivided_to_limit(square, vec![[0, 1, 2], [0, 2, 3]], 2);
        assert_eq!(mesh.triangles.len(), 32);
        let inside = |p: &DVec3| p.z == 0.0 && p.x >= 0.0 && p.y >= 0.0 && p.x <= 1.0 && p.y <= 1.0;
        assert!(mesh.positions.iter().all(inside));
    }
}
