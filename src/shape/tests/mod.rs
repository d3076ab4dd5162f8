//! Tests of properties that all kinds of shapes have.

mod solids;

use super::*;
use crate::math::offset_ray_origin;
use crate::sampling::{Dimension, Key, Purpose};
use glam::DAffine3;

fn frustum_shape(bottom: DVec3, top: DVec3, radii: [f64; 2], capped: bool) -> Shape {
    Shape::Frustum(Frustum::new(bottom, top, radii, capped).unwrap())
}

/// One or more shapes of each kind, except meshes and parametric surfaces.
fn one_shape_of_each_kind() -> Vec<Shape> {
    let squash = Transform::new(DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 0.2, 2.5),
        glam::DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5),
        DVec3::new(0.3, -2.0, 1.0),
    ))
    .unwrap();
    vec![
        Shape::Sphere(Sphere::new(DVec3::new(1.0, 2.0, -0.5), 0.7)),
        Shape::Ellipsoid(Ellipsoid::new(squash)),
        Shape::Disc(Disc::new(DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.0, 0.2, 1.0))),
        Shape::Rectangle(Rectangle::new(DVec3::ONE, DVec3::new(2.0, 0.1, 0.0), DVec3::new(0.3, 1.0, 0.5))),
        Shape::Cuboid(Cuboid::from_transform(squash)),
        Shape::Cuboid(Cuboid::new(DVec3::new(-1.0, 0.5, 2.0), DVec3::new(0.5, 0.75, 2.5)).unwrap()),
        frustum_shape(DVec3::X, DVec3::ONE, [0.5, 0.5], true),
        frustum_shape(DVec3::X, DVec3::ONE, [0.5, 0.5], false),
        frustum_shape(DVec3::X, DVec3::ONE, [0.5, 0.0], true),
        frustum_shape(DVec3::X, DVec3::ONE, [0.0, 0.7], false),
        frustum_shape(DVec3::ZERO, DVec3::Y, [1.0, 0.3], true).transformed(&squash).unwrap(),
    ]
}

/// True if [`one_shape_of_each_kind`] must contain shapes of this kind; false for mesh instances
/// and parametric surfaces, which have tests of their own.
///
/// Another variant of [`Shape`] does not compile here until it is added to the match, which reminds
/// its author of the list.
fn is_listed_kind(shape: &Shape) -> bool {
    match shape {
        Shape::Sphere(_)
        | Shape::Ellipsoid(_)
        | Shape::Disc(_)
        | Shape::Rectangle(_)
        | Shape::Cuboid(_)
        | Shape::Frustum(_) => true,
        Shape::Instance(_) | Shape::Revolution(_) | Shape::Patch(_) => false,
    }
}

#[test]
fn every_listed_kind_of_shape_is_tested() {
    let shapes = one_shape_of_each_kind();
    assert!(shapes.iter().all(is_listed_kind));
    let kinds: std::collections::HashSet<_> = shapes.iter().map(std::mem::discriminant).collect();
    assert_eq!(kinds.len(), 6);
}

/// A ray towards a sampled point hits the shape there, and the mean of 1/pdf is the area.
#[test]
fn sampled_points_have_their_stated_pdf() {
    for shape in one_shape_of_each_kind() {
        let (n, mut sum, mut squares) = (100_000u64, 0.0, 0.0);
        for i in 0..n {
            let s =
                shape.sample(Key::new(3).purpose_key(Purpose::Test).child_key(i).uniform_2d(Dimension::LightPosition));
            let inverse = 1.0 / f64::from(s.pdf);
            sum += inverse;
            squares += inverse * inverse;
            // The pdf is computed from the point's normal, which is rounded to f32.
            assert!((shape.pdf(&s.point) * inverse as f32 - 1.0).abs() < 1e-6, "{shape:?}");
            if i < 1000 {
                let above = s.point.p + s.point.ng * 0.1;
                let ray = Ray::new(above, -s.point.ng);
                let ShapeHit { t, shape_coords: uv } = shape.intersect(&ray).expect("a ray at a sampled point hits");
                assert!((t - 0.1).abs() < 1e-5, "{shape:?} {t}");
                let back = shape.surface_point(&ray, t, uv);
                assert!((back.p - s.point.p).length() < 1e-5 && back.ng.dot(s.point.ng) > 1.0 - 1e-4);
            }
        }
        let mean = sum / n as f64;
        let sigma = ((squares / n as f64 - mean * mean).max(0.0) / n as f64).sqrt();
        assert!((mean - shape.area()).abs() < 5.0 * sigma + 1e-6 * shape.area(), "{shape:?}: {mean}");
    }
}

/// Texture coordinates of flat shapes depend only on the position. So an emission texture has one
/// value at a point, whether a ray hits the point or light sampling chooses it.
#[test]
fn flat_shapes_derive_texture_coordinates_from_positions() {
    for shape in one_shape_of_each_kind().iter().filter(|shape| matches!(shape, Shape::Disc(_) | Shape::Rectangle(_))) {
        for i in 0..1000 {
            let s =
                shape.sample(Key::new(3).purpose_key(Purpose::Test).child_key(i).uniform_2d(Dimension::LightPosition));
            let ShapeHit { shape_coords, .. } =
                shape.intersect(&Ray::new(s.point.p + s.point.ng * 0.1, -s.point.ng)).expect("the ray hits the sample");
            let coord = shape.tex_coord(s.point.p, s.shape_coords);
            assert!((coord.uv - shape_coords.as_dvec2()).length() < 1e-5, "{shape:?} {coord:?}");
            assert_eq!(shape.tex_coord(s.point.p, shape_coords), coord);
        }
    }
}

/// Rays from offset origins on a sphere do not hit the sphere at their origin.
///
/// An outward ray misses the sphere, and an inward ray hits the far side.
#[test]
fn offset_origins_prevent_self_intersection() {
    for scale in [1e-3, 1.0, 1e4] {
        for center in [DVec3::ZERO, DVec3::new(3.0, -200.0, 1e3) * scale] {
            let sphere = Shape::Sphere(Sphere::new(center, scale));
            for i in 0..20_000u64 {
                let key = Key::new(5).purpose_key(Purpose::Test).child_key(i);
                let s = sphere.sample(key.uniform_2d(Dimension::LightPosition)).point;
                let d = crate::math::warp::square_to_cosine_hemisphere(key.uniform_2d(Dimension::LightDirection));
                let d = crate::math::Frame::from_normal(s.ng).to_world(d);
                let out = Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, d), d);
                assert!(sphere.intersect(&out).is_none(), "{scale} {center} {i}");
                let inside = Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, -d), -d);
                let ShapeHit { t, .. } = sphere.intersect(&inside).expect("an inner ray meets the far side");
                let chord = 2.0 * scale as f32 * d.dot(s.ng);
                assert!(
                    (t - chord).abs() < 1e-3 * chord + 4.0 * s.position_error.max_element() / d.dot(s.ng),
                    "{t} {chord}"
                );
            }
        }
    }
}

#[test]
fn spheres_stay_spheres_under_similarities_only() {
    let ball = Shape::Sphere(Sphere::new(DVec3::X, 0.5));
    let twice = Transform::new(DAffine3::from_scale(DVec3::splat(-2.0))).unwrap();
    match ball.transformed(&twice) {
        Some(Shape::Sphere(s)) => assert_eq!((s.center, s.radius), (DVec3::new(-2.0, 0.0, 0.0), 1.0)),
        other => panic!("{other:?}"),
    }
    let stretched = Transform::new(DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0))).unwrap();
    assert!(matches!(ball.transformed(&stretched), Some(Shape::Ellipsoid(_))));
}

#[test]
fn boxes_contain_their_shapes() {
    for shape in one_shape_of_each_kind() {
        let b = shape.bounds();
        for i in 0..5000u64 {
            let u = Key::new(1).purpose_key(Purpose::Test).child_key(i).uniform_2d(Dimension::LightPosition);
            let p = shape.sample(u).point.p;
            assert!(p.cmpge(b.min).all() && p.cmple(b.max).all(), "{shape:?} {p}");
        }
    }
}
