//! Tests of computed smooth normals against closed forms.

use super::super::normals::face_normal;
use super::*;

#[test]
fn the_smoothing_angle_decides_a_cubes_normals() {
    let mut flat = cube_mesh();
    flat.compute_missing_smooth_normals(30.0);
    assert_eq!(flat.positions.len(), 24);
    let normals = flat.normals.clone().unwrap();
    for t in &flat.triangles {
        let face = face_normal(&flat, *t);
        assert!(t.iter().all(|v| normals[*v as usize] == face), "{face}");
    }
    for angle in [90.0, 180.0] {
        let mut round = cube_mesh();
        round.compute_missing_smooth_normals(angle);
        assert_eq!(round.positions.len(), 8);
        for (p, n) in round.positions.iter().zip(round.normals.as_ref().unwrap()) {
            // Faces are divided unevenly, but their corner angles at a vertex have equal sums. Sums
            // of unit vectors err by ulps.
            assert!((*n - p.normalize()).length() < 4e-16 * 4.0, "{n} at {p}");
        }
    }
    let mut sharp = cube_mesh();
    sharp.compute_missing_smooth_normals(89.9);
    assert_eq!(sharp.positions.len(), 24);
}

#[test]
fn a_ball_has_the_normals_of_a_sphere() {
    let n = 24;
    let mut ball = sphere_mesh(n);
    ball.compute_missing_smooth_normals(180.0);
    assert_eq!(ball.positions.len() as u32, 6 * n * n + 2);
    for (p, normal) in ball.positions.iter().zip(ball.normals.as_ref().unwrap()) {
        // The normal of a triangle inscribed in the unit sphere points to its circumcentre. So any
        // mean of the faces around a vertex lies within an edge's length of the vertex's direction.
        // An edge spans at most (π/2)/n √2 · 4/π.
        let edge = 2.0 * std::f64::consts::SQRT_2 / f64::from(n);
        let angle = libm::acos(p.dot(*normal).min(1.0));
        assert!(angle < edge, "{angle} {edge}");
        // With symmetric faces around a vertex, errors cancel to the second order.
        assert!(angle < edge * edge, "{angle} {edge}");
    }
}

#[test]
fn vertex_normals_are_weighted_by_angle() {
    // Of the three faces at a corner of the cube, one consists of three triangles there. The number
    // of triangles must not matter.
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [0.2, 1.0, 0.0]];
    let mut corner = triangle_mesh(&points, &[[0, 1, 4], [0, 4, 5], [0, 5, 2], [0, 3, 1], [0, 2, 3]]);
    corner.compute_missing_smooth_normals(180.0);
    let normal = corner.normals.unwrap()[0];
    assert!((normal - DVec3::new(1.0, 1.0, 1.0).normalize()).length() < 1e-15, "{normal}");
}

#[test]
fn normals_of_the_file_are_kept() {
    let mut cube = cube_mesh();
    cube.compute_missing_smooth_normals(180.0);
    let before = cube.clone();
    cube.compute_missing_smooth_normals(10.0);
    assert_eq!(cube, before);
    // A triangle without normals between others that have them.
    let normals = cube.normals.as_mut().unwrap();
    let lost = cube.triangles[0];
    cube.positions.push(cube.positions[lost[0] as usize]);
    normals.push(DVec3::ZERO);
    cube.triangles[0][0] = 8;
    cube.compute_missing_smooth_normals(10.0);
    let normals = cube.normals.as_ref().unwrap();
    let face = face_normal(&cube, cube.triangles[0]);
    assert!(cube.triangles[0].iter().all(|v| normals[*v as usize] == face));
    let kept = before.normals.unwrap();
    for (t, old) in cube.triangles.iter().zip(&before.triangles).skip(1) {
        assert!((0..3).all(|k| normals[t[k] as usize] == kept[old[k] as usize]));
    }
}

#[test]
fn degenerate_faces_do_not_affect_normals() {
    let mut cube = cube_mesh();
    cube.triangles.push([0, 0, 1]);
    cube.compute_missing_smooth_normals(30.0);
    let normals = cube.normals.as_ref().unwrap();
    assert!(cube.triangles[..12].iter().flatten().all(|v| normals[*v as usize].is_normalized()));
    assert_eq!(normals.iter().filter(|n| **n == DVec3::ZERO).count(), 2);
    // Faces with an area that underflows to 0 count like others.
    let mut tiny = scaled_and_translated_mesh(super::cube_mesh(), 1e-170, DVec3::ZERO);
    tiny.compute_missing_smooth_normals(180.0);
    assert!(tiny.normals.unwrap().iter().all(|n| n.is_normalized()));
}
