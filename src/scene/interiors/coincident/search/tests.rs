//! Tests of the search for faces that may coincide.

use super::*;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::scene::{Body, Material, Scene, SceneBuilder};
use crate::shape::parametric_surface::SplineBasis;
use crate::shape::{Plane, Sphere};
use glam::{DVec2, Vec2, Vec3};

/// Returns the numbers of flagged triangles in a scene of two glass cubes: a unit cube, and the
/// same cube after `scale` and `shift`.
fn flagged_triangles_of_cubes(scale: f64, shift: DVec3) -> [usize; 2] {
    let mut builder = SceneBuilder::new();
    let corners: Vec<DVec3> = (0..8).map(|i| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(f64::from))).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |f: [u32; 4]| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]];
    let triangles: Vec<[u32; 3]> = faces.into_iter().flat_map(halves).collect();
    for (index, scale, shift) in [(1.3, 1.0, DVec3::ZERO), (1.5, scale, shift)] {
        let glass = builder.add_material(Material::smooth_boundary(Body::new(index)));
        let placed: Vec<DVec3> = corners.iter().map(|p| *p * scale + shift).collect();
        builder.add_mesh(&placed, &[], &triangles, glass, Rgb::ZERO);
    }
    let camera = Camera::perspective(DVec3::splat(9.0), DVec3::NEG_ONE, DVec3::Y, 1.0, 4, 4).unwrap();
    let scene = builder.build(camera).unwrap();
    let may = |i: &u32| scene.coincident.may_coincide(HitPrimitive::Triangle(*i, Vec2::ZERO));
    [(0..12).filter(may).count(), (12..24).filter(may).count()]
}

#[test]
fn only_faces_that_may_coincide_are_flagged() {
    let beside = |x: f64| flagged_triangles_of_cubes(0.5, DVec3::new(x, 0.25, 0.25));
    // In the unit cube, the two triangles of the shared wall are flagged. In the small cube, this
    // wall and the four walls that end at it are flagged.
    assert_eq!(beside(1.0), [2, 10]);
    assert_eq!(beside(1.0 + 1e-7), [2, 10], "within the position error");
    assert_eq!(beside(0.75), [2, 8], "walls that cross");
    for x in [0.25, 0.999, 1.001, 2.0] {
        assert_eq!(beside(x), if x == 0.999 { [2, 8] } else { [0, 0] }, "{x}");
    }
}

/// Scene of a glass and a liquid that share a wall. The glass reaches from height −1 to 1, the
/// liquid from 0 to 3, and the shared wall from 0 to 1.
fn coaxial_tubes() -> Scene {
    let mut builder = SceneBuilder::new();
    for (index, heights) in [(1.5, [-1.0, 1.0]), (1.33, [0.0, 3.0])] {
        let material = builder.add_material(Material::smooth_boundary(Body::new(index)));
        let wall = heights.map(|height| DVec2::new(1.0, height));
        let tube = Revolution::new(&SplineBasis::bezier_basis(2).unwrap(), &wall).unwrap();
        builder.add_shape(Shape::Revolution(tube), material, Rgb::ZERO);
    }
    let camera = Camera::perspective(DVec3::splat(9.0), DVec3::NEG_ONE, DVec3::Y, 1.0, 4, 4).unwrap();
    builder.build(camera).unwrap()
}

#[test]
fn coaxial_surfaces_are_flagged_where_they_meet() {
    let scene = coaxial_tubes();
    let may = |(shape, u)| scene.coincident.may_coincide(HitPrimitive::Shape(shape, Vec2::new(u, 0.3)));
    assert_eq!([(0, 0.25), (0, 0.75), (1, 0.2), (1, 0.8)].map(may), [false, true, true, false]);
}

/// A budget of zero pairs of profile leaves does not suffice for two tubes of one leaf each, so
/// both tubes are flagged wholly. With a budget of one pair, intervals are flagged.
#[test]
fn coaxial_surfaces_over_budget_are_flagged_wholly() {
    let scene = coaxial_tubes();
    let flagged = |budget| {
        let mut parts = vec![CoincidentPart::Nothing; 2];
        flag_coaxial_pairs(&scene.geometry, vec![(0, 1, 1e-6); 2], budget, &mut parts);
        parts
    };
    assert_eq!(flagged(0), [CoincidentPart::Everything, CoincidentPart::Everything]);
    assert!(flagged(1).iter().all(|part| matches!(part, CoincidentPart::ProfileIntervals(_))));
}

#[test]
fn a_spatial_join_agrees_with_brute_force() {
    let mut key = 1u32;
    let mut chance = || {
        key = key.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (key >> 8) as f32 / 16_777_216.0
    };
    for (count, size) in [(3, 0.5), (200, 0.1), (3000, 0.02)] {
        let faces: Vec<BoundaryFace> = (0..count)
            .map(|i| {
                let min = Vec3::new(chance(), chance(), chance());
                let max = min + Vec3::new(chance(), chance(), chance()) * size;
                BoundaryFace {
                    primitive: PrimitiveIndex::Other(i),
                    bounds: Bounds { min, max },
                    boundary_object: i % 3,
                }
            })
            .collect();
        let one = |a: &BoundaryFace| {
            faces.iter().any(|b| a.boundary_object != b.boundary_object && a.bounds.overlaps(&b.bounds))
        };
        let expected: Vec<bool> = faces.iter().map(one).collect();
        assert!(count < 100 || expected.contains(&true) && expected.contains(&false));
        assert_eq!(SpatialSelfJoin::faces_near_other_objects(&faces, &|_, _| true), expected, "{count}");
    }
}

#[test]
fn too_many_overlaps_flag_every_face() {
    let bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
    let face = |i| BoundaryFace { primitive: PrimitiveIndex::Other(i), bounds, boundary_object: i % 2 };
    let faces: Vec<BoundaryFace> = (0..3000).map(face).collect();
    assert_eq!(SpatialSelfJoin::faces_near_other_objects(&faces, &|_, _| false), vec![true; 3000]);
    assert_eq!(SpatialSelfJoin::faces_near_other_objects(&faces[..100], &|_, _| false), vec![false; 100]);
}

#[test]
fn unbounded_boundaries_may_coincide_anywhere() {
    let scene = |planes: u32, balls: u32| {
        let mut builder = SceneBuilder::new();
        let glass = builder.add_material(Material::smooth_boundary(Body::new(1.5)));
        for i in 0..balls {
            let center = DVec3::X * 10.0 * f64::from(i);
            builder.add_shape(Shape::Sphere(Sphere::new(center, 1.0)), glass, Rgb::ZERO);
        }
        for _ in 0..planes {
            builder.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), glass, Rgb::ZERO);
        }
        let camera = Camera::perspective(DVec3::splat(9.0), DVec3::NEG_ONE, DVec3::Y, 1.0, 4, 4).unwrap();
        builder.build(camera).unwrap().coincident.may_coincide(HitPrimitive::Shape(0, Vec2::ZERO))
    };
    assert_eq!([scene(0, 2), scene(1, 1), scene(1, 0)], [false, true, false]);
}
