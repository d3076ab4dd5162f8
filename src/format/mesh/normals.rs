//! Smooth shading normals for meshes without normals.

use super::TriangleMesh;
use super::merge::{DeduplicatedList, keep_listed_vertices};
use super::topology::{MeshTopology, ParityUnionFind};
use glam::DVec3;

pub(super) fn compute_missing_smooth_normals(mesh: &mut TriangleMesh, angle: f64) {
    let missing: Vec<bool> = match &mesh.normals {
        Some(normals) => {
            let zero = |t: &[u32; 3]| t.iter().any(|&v| normals[v as usize] == DVec3::ZERO);
            mesh.triangles.iter().map(zero).collect()
        }
        None => vec![true; mesh.triangles.len()],
    };
    if !missing.contains(&true) {
        return;
    }
    let faces: Vec<DVec3> = mesh.triangles.iter().map(|t| face_normal(mesh, *t)).collect();
    let groups = smoothing_groups(mesh, &faces, angle);
    let mut sums: Vec<DVec3> = Vec::new();
    for (corner, group) in groups.iter().enumerate() {
        if *group as usize == sums.len() {
            sums.push(DVec3::ZERO);
        }
        sums[*group as usize] += faces[corner / 3] * corner_angle(mesh, corner);
    }
    assign_smoothing_group_normals(mesh, &missing, &groups, &sums);
}

/// Returns the unit normal of a triangle on its counter-clockwise side; zero for triangles without
/// area.
pub(super) fn face_normal(mesh: &TriangleMesh, triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
    normalize_without_overflow(normalize_without_overflow(b - a).cross(normalize_without_overflow(c - a)))
}

/// Returns the angle at a corner of a triangle \[radians]. The index `corner` is 3t + k for corner
/// k of triangle t.
fn corner_angle(mesh: &TriangleMesh, corner: usize) -> f64 {
    let triangle = mesh.triangles[corner / 3];
    let [p, q, r] = [0, 1, 2].map(|k| mesh.positions[triangle[(corner + k) % 3] as usize]);
    let (e, f) = (normalize_without_overflow(q - p), normalize_without_overflow(r - p));
    libm::atan2(e.cross(f).length(), e.dot(f))
}

/// Returns the index of the smoothing group of each triangle corner. All corners of a group get the
/// same shading normal.
///
/// Element 3t + k of the result is for corner k of triangle t. Groups are numbered in the order of
/// their first corners.
///
/// `faces` holds the normals of the triangles. Edges whose face normals differ by more than `angle`
/// \[degrees] separate groups.
fn smoothing_groups(mesh: &TriangleMesh, faces: &[DVec3], angle: f64) -> Vec<u32> {
    // Products of unit vectors err by some ulps. An angle equal to the limit counts as smooth.
    let least = if angle >= 180.0 { f64::NEG_INFINITY } else { libm::cos(angle.to_radians()) - 8.0 * f64::EPSILON };
    let topology = MeshTopology::new(mesh);
    let mut union = ParityUnionFind::new(3 * mesh.triangles.len());
    for half_edges in topology.half_edges_by_edge() {
        let &[a, b] = half_edges else { continue };
        let smooth = faces[a.triangle as usize].dot(faces[b.triangle as usize]) >= least;
        if a.is_forward != b.is_forward && smooth {
            let ([a0, a1], [b0, b1]) = (a.corners_in_position_order(), b.corners_in_position_order());
            union.union_sets(a0, b0, false);
            union.union_sets(a1, b1, false);
        }
    }
    let mut group_of_corner = vec![u32::MAX; 3 * mesh.triangles.len()];
    let mut next = 0;
    for corner in 0..group_of_corner.len() {
        // The root of a group is its lowest corner index, so it is numbered already.
        let (root, _) = union.find_root(corner);
        group_of_corner[corner] = if root == corner { next } else { group_of_corner[root] };
        next += u32::from(root == corner);
    }
    group_of_corner
}

/// Gives smooth normals to the triangles marked in `missing`. Splits vertices whose corners are in
/// different groups.
///
/// `groups` holds the smoothing group of each triangle corner. `sums` holds, for each group, the
/// sum of the face normals at its corners, weighted by the corner angles.
fn assign_smoothing_group_normals(mesh: &mut TriangleMesh, missing: &[bool], groups: &[u32], sums: &[DVec3]) {
    const KEEPS_NORMAL: u32 = u32::MAX;
    let mut new_vertices: DeduplicatedList<(u32, u32)> = DeduplicatedList::with_capacity(mesh.positions.len());
    for (t, triangle) in mesh.triangles.iter_mut().enumerate() {
        for (k, v) in triangle.iter_mut().enumerate() {
            let group = if missing[t] { groups[3 * t + k] } else { KEEPS_NORMAL };
            *v = new_vertices.find_or_append((*v, group), |key| *key);
        }
    }
    let vertices = new_vertices.into_values();
    let normal = |&(v, group): &(u32, u32)| match (group, &mesh.normals) {
        (KEEPS_NORMAL, Some(normals)) => normals[v as usize],
        _ => sums.get(group as usize).copied().unwrap_or_default().normalize_or_zero(),
    };
    mesh.normals = Some(vertices.iter().map(normal).collect());
    keep_listed_vertices(mesh, vertices.iter().map(|(v, _)| *v));
    mesh.merge_equal_vertices();
}

/// Returns `v` scaled to unit length, without overflow or underflow; zero if `v` is zero or not
/// finite.
fn normalize_without_overflow(v: DVec3) -> DVec3 {
    let size = v.abs().max_element();
    if size > 0.0 && size.is_finite() { (v / size).normalize_or_zero() } else { DVec3::ZERO }
}
