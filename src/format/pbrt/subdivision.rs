//! Loop subdivision of triangle meshes (Loop 1987), with vertices at their limit positions.

use crate::format::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::HashMap;

/// Number of neighbors of a mesh vertex, and the sums of their positions. From these, Loop
/// subdivision computes the new position of the vertex.
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

/// Edges of a mesh, each with its adjacent triangles.
///
/// A key holds both vertex indices of an edge, the lower one first. A value holds the number of
/// triangles at the edge, and the vertices opposite to the edge in the first two of them.
type EdgeTable = HashMap<[u32; 2], (u32, [u32; 2])>;

/// Returns the mesh after `levels` Loop subdivisions, with vertices at their limit positions and
/// with smooth normals.
pub(super) fn loop_subdivided_to_limit(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>, levels: u32) -> TriangleMesh {
    let (mut positions, mut triangles) = (positions, triangles);
    for _ in 0..levels {
        (positions, triangles) = subdivided_once(&positions, &triangles);
    }
    let edges = edges_of_triangles(&triangles);
    let neighbors = neighborhoods(&positions, &edges);
    let limits =
        positions.iter().zip(&neighbors).map(|(position, neighborhood)| limit_position(*position, neighborhood));
    let mut mesh = TriangleMesh { positions: limits.collect(), triangles, ..TriangleMesh::default() };
    mesh.compute_missing_smooth_normals(180.0);
    mesh
}

/// Returns positions and triangles after one Loop subdivision: each triangle becomes four.
fn subdivided_once(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let edges = edges_of_triangles(triangles);
    let neighbors = neighborhoods(positions, &edges);
    let mut fine: Vec<DVec3> =
        positions.iter().zip(&neighbors).map(|(p, neighborhood)| even_position(*p, neighborhood)).collect();
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

/// Returns all edges of a triangle mesh.
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

/// Returns the [`Neighborhood`] of each vertex, in the order of `positions`.
fn neighborhoods(positions: &[DVec3], edges: &EdgeTable) -> Vec<Neighborhood> {
    let mut neighbors = vec![Neighborhood::default(); positions.len()];
    // Sort the edges: a hash map has no fixed order, and rounding depends on the order of a sum.
    let mut sorted: Vec<_> = edges.iter().collect();
    sorted.sort_unstable_by_key(|(ends, _)| **ends);
    for (&[a, b], (count, _)) in sorted {
        for (vertex, neighbor) in [(a, b), (b, a)] {
            let neighborhood = &mut neighbors[vertex as usize];
            neighborhood.valence += 1;
            neighborhood.neighbor_sum += positions[neighbor as usize];
            if *count == 1 {
                neighborhood.boundary_edge_count += 1;
                neighborhood.boundary_neighbor_sum += positions[neighbor as usize];
            }
        }
    }
    neighbors
}

/// Returns the weight β of Loop subdivision (Warren 1995). An inner vertex with n neighbors moves
/// to (1 − n β) times its position, plus β times the sum of the positions of its neighbors.
fn neighbor_weight(valence: u32) -> f64 {
    if valence == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * f64::from(valence)) }
}

/// Returns the new position of a vertex of the coarse mesh after one Loop subdivision.
fn even_position(position: DVec3, neighborhood: &Neighborhood) -> DVec3 {
    match neighborhood.boundary_edge_count {
        0 if neighborhood.valence > 0 => {
            let weight = neighbor_weight(neighborhood.valence);
            position * (1.0 - f64::from(neighborhood.valence) * weight) + weight * neighborhood.neighbor_sum
        }
        2 => 0.75 * position + 0.125 * neighborhood.boundary_neighbor_sum,
        _ => position,
    }
}

/// Returns the limit of a vertex's position after infinitely many Loop subdivisions.
fn limit_position(position: DVec3, neighborhood: &Neighborhood) -> DVec3 {
    match neighborhood.boundary_edge_count {
        0 if neighborhood.valence > 0 => {
            let valence = f64::from(neighborhood.valence);
            let weight = 1.0 / (valence + 3.0 / (8.0 * neighbor_weight(neighborhood.valence)));
            position * (1.0 - valence * weight) + weight * neighborhood.neighbor_sum
        }
        2 => 0.6 * position + 0.2 * neighborhood.boundary_neighbor_sum,
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

    /// Subdivision levels change the number of vertices, but not the limit of any vertex.
    #[test]
    fn limit_positions_do_not_depend_on_the_level() {
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
