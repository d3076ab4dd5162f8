//! Bodies for media behind flat surfaces.
//!
//! In Tungsten, a medium has no shape: a ray is in the medium that the last crossed surface names.
//! So one flat surface may be the only boundary of a medium. In Caustica, a closed body contains a
//! medium. The importer makes this body: the part of the scene's bounds behind all flat surfaces of
//! the medium.

use crate::format::mesh::TriangleMesh;
use glam::DVec3;

/// Distance of the body from the bounds of the scene, relative to their diagonal. It keeps the body
/// apart from walls in the bounds.
const RELATIVE_INSET: f64 = 1e-4;

/// A half-space: all points p with `normal` · p ≤ `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfSpace {
    /// Unit normal, which points out of the half-space.
    pub normal: DVec3,
    /// Distance of the boundary plane from the origin along the normal.
    pub offset: f64,
}

impl HalfSpace {
    /// Returns the signed distance of `point` from the boundary plane; negative inside.
    fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Returns the mesh of the part of a box that lies in all half-spaces; `None` if it is empty.
///
/// The box reaches from `low` to `high`. It is shrunk slightly at first.
pub(super) fn region_mesh((low, high): (DVec3, DVec3), half_spaces: &[HalfSpace]) -> Option<TriangleMesh> {
    let inset = RELATIVE_INSET * (high - low).length();
    let (low, high) = (low + inset, high - inset);
    if !(low.is_finite() && high.is_finite() && low.cmplt(high).all()) {
        return None;
    }
    let mut faces = box_faces(low, high);
    for half_space in half_spaces {
        faces = clipped_faces(faces, half_space);
    }
    let mut mesh = TriangleMesh::default();
    for face in faces {
        let base = mesh.positions.len() as u32;
        let count = face.len() as u32;
        mesh.positions.extend(face);
        mesh.triangles.extend((2..count).map(|i| [base, base + i - 1, base + i]));
    }
    mesh.merge_equal_vertices();
    (!mesh.triangles.is_empty()).then_some(mesh)
}

/// Returns the six faces of a box as polygons, counter-clockwise seen from outside.
fn box_faces(low: DVec3, high: DVec3) -> Vec<Vec<DVec3>> {
    let corner = |axis: usize, [end, u, v]: [bool; 3]| {
        let mut point = low;
        for (k, is_high) in [end, u, v].into_iter().enumerate() {
            let k = (axis + k) % 3;
            point[k] = if is_high { high[k] } else { low[k] };
        }
        point
    };
    let mut faces = Vec::new();
    for axis in 0..3 {
        let turn = [[false, false], [true, false], [true, true], [false, true]];
        faces.push(turn.iter().map(|[u, v]| corner(axis, [true, *u, *v])).collect());
        faces.push(turn.iter().rev().map(|[u, v]| corner(axis, [false, *u, *v])).collect());
    }
    faces
}

/// Returns the faces of the part of a convex body inside `half_space`.
fn clipped_faces(faces: Vec<Vec<DVec3>>, half_space: &HalfSpace) -> Vec<Vec<DVec3>> {
    if faces.iter().flatten().all(|point| half_space.distance(*point) <= 0.0) {
        return faces;
    }
    let mut clipped = Vec::new();
    let mut cut = Vec::new();
    for face in faces {
        let mut kept = Vec::new();
        for (i, a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            let (da, db) = (half_space.distance(*a), half_space.distance(b));
            if da <= 0.0 {
                kept.push(*a);
            }
            if (da <= 0.0) != (db <= 0.0) {
                let point = edge_point(*a, b, da, db);
                kept.push(point);
                cut.push(point);
            }
        }
        if kept.len() >= 3 {
            clipped.push(kept);
        }
    }
    clipped.extend(cap(cut, half_space.normal));
    clipped
}

/// Returns the point between `a` and `b` whose distance from a plane is 0. `da` and `db` are the
/// signed distances of `a` and `b`. Exactly one of the two is above 0.
///
/// Both directions of an edge give equal points, because the point inside comes first.
fn edge_point(a: DVec3, b: DVec3, da: f64, db: f64) -> DVec3 {
    let (inside, outside, d_inside, d_outside) = if da <= 0.0 { (a, b, da, db) } else { (b, a, db, da) };
    inside + (outside - inside) * (d_inside / (d_inside - d_outside))
}

/// Returns the face with the corners `points` in a plane, counter-clockwise seen from the side of
/// `normal`; `None` if there are fewer than three different corners.
fn cap(mut points: Vec<DVec3>, normal: DVec3) -> Option<Vec<DVec3>> {
    let center = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    let angle = |point: &DVec3| libm::atan2((*point - center).dot(v), (*point - center).dot(u));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points.dedup();
    (points.len() >= 3).then_some(points)
}

#[cfg(test)]
mod tests {
    use super::{HalfSpace, region_mesh};
    use glam::DVec3;

    /// Returns the volume and the bounds of the part of the box \[−1, 1]³ in the half-spaces.
    fn volume_and_top(half_spaces: &[HalfSpace]) -> Option<(f64, f64)> {
        let mesh = region_mesh((DVec3::NEG_ONE, DVec3::ONE), half_spaces)?;
        assert_eq!(mesh.solid_defect(), None);
        let signed = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        let top = mesh.positions.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        Some((mesh.triangles.iter().map(signed).sum(), top))
    }

    #[test]
    fn a_region_is_the_part_of_the_box_behind_all_planes() {
        let side = 2.0 - 2.0 * 1e-4 * 12.0_f64.sqrt();
        let plane = |normal: DVec3, offset: f64| HalfSpace { normal: normal.normalize(), offset };
        let is_near = |found: f64, expected: f64| (found - expected).abs() < 1e-9 * expected;
        let (volume, _) = volume_and_top(&[plane(DVec3::Z, 5.0)]).unwrap();
        assert!(is_near(volume, side * side * side), "{volume}");
        let (volume, top) = volume_and_top(&[plane(DVec3::Z, 0.25)]).unwrap();
        assert!(is_near(volume, side * side * (0.5 * side + 0.25)) && top == 0.25, "{volume} {top}");
        // A plane through six edges halves the box.
        let (volume, _) = volume_and_top(&[plane(DVec3::ONE, 0.0)]).unwrap();
        assert!(is_near(volume, 0.5 * side * side * side), "{volume}");
        let wedge = [plane(DVec3::Z, 0.0), plane(DVec3::X, 0.0)];
        assert!(is_near(volume_and_top(&wedge).unwrap().0, 0.25 * side * side * side));
        assert_eq!(volume_and_top(&[plane(DVec3::Z, -2.0)]), None);
        assert!(region_mesh((DVec3::ZERO, DVec3::X), &[]).is_none());
    }
}
