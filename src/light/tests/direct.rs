//! Tests that direct light samples follow their pdf.

use super::chi_square::{DirectionCells, INTEGRAL_ERROR, sidak_significance_level};
use super::*;
use crate::accel::ShapeHit;
use crate::math::Transform;
use crate::sampling::DiscreteDistribution;
use crate::shape::{Ellipsoid, Mesh, SurfacePoint};
use glam::DAffine3;
use std::sync::Arc;

/// Three triangles of different size that share a corner, and occlude each other from some
/// positions.
pub fn three_triangle_mesh(origin: Vec3) -> Arc<Mesh> {
    let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1.3, 0.], [0., 0., 0.6]].map(|p| Vec3::from(p) + origin);
    let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3]];
    Arc::new(Mesh { positions: positions.to_vec(), triangles, ..Mesh::default() })
}

pub fn mesh_light_surface(mesh: Arc<Mesh>) -> LightSurface {
    let choice = DiscreteDistribution::new((0..mesh.triangles.len()).map(|i| mesh.triangle_area(i))).unwrap();
    LightSurface::Triangles { mesh, first_triangle: 0, triangle_distribution: choice }
}

/// First hit of the ray from `p` along `wi` with a light surface, from either side.
fn first_hit_on_light_surface(emitter: &LightSurface, p: Vec3, wi: Vec3) -> Option<SurfacePoint> {
    let ray = crate::math::Ray::new(p, wi);
    match emitter {
        LightSurface::Shape(shape) => {
            shape.intersect(&ray).map(|ShapeHit { t, shape_coords: uv }| shape.surface_point(&ray, t, uv))
        }
        LightSurface::Triangles { mesh, .. } => {
            let cross = |i: usize| {
                let [a, b, c] = mesh.corners(i).map(|v| v.as_dvec3() - p.as_dvec3());
                let m = glam::DMat3::from_cols(b - a, c - a, -wi.as_dvec3());
                let x = m.inverse() * -a;
                (x.x >= 0.0 && x.y >= 0.0 && x.x + x.y <= 1.0 && x.z > 0.0).then_some((x.z, i, x.truncate()))
            };
            let nearest = (0..mesh.triangles.len()).filter_map(cross).min_by(|a, b| a.0.total_cmp(&b.0));
            nearest.map(|(_, i, b)| mesh.surface_point(i, b.as_vec2()))
        }
    }
}

/// Light surfaces, each with a viewpoint. The flag is true if light sampling chooses only points
/// that are visible from the viewpoint.
fn surfaces_and_viewpoints() -> Vec<(LightSurface, Vec3, bool)> {
    let squash = Transform::new(DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 0.2, 0.5),
        glam::DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5),
        DVec3::new(0.3, 2.0, 1.0),
    ))
    .unwrap();
    let rectangle = Rectangle::new(point_on_y_axis(1.0), DVec3::new(2.0, 0.0, 0.5), DVec3::new(-0.2, 0.0, 0.8));
    let slanted = Rectangle::new(point_on_y_axis(1.0), DVec3::new(2.0, 0.0, 0.5), DVec3::new(0.2, 0.3, 0.8));
    let disc = Disc::new(point_on_y_axis(2.0), DVec3::X, DVec3::new(0.0, 0.3, 0.6));
    let shapes = [
        (Shape::Sphere(SphereShape::new(point_on_y_axis(2.0), 0.5)), Vec3::new(1.0, 0.0, 0.3), true),
        (Shape::Sphere(SphereShape::new(point_on_y_axis(2.0), 0.5)), Vec3::new(0.0, 1.49, 0.0), true),
        (Shape::Disc(disc), Vec3::new(0.7, 0.0, 0.3), true),
        (Shape::Ellipsoid(Ellipsoid::new(squash)), Vec3::new(1.0, 0.5, 0.3), false),
        (Shape::Rectangle(slanted), Vec3::new(0.3, 0.1, 0.2), true),
        (Shape::Rectangle(rectangle), Vec3::new(0.3, 0.1, 0.2), true),
        (Shape::Rectangle(rectangle), Vec3::new(-2.0, 0.2, -1.0), true),
        // Viewpoints near the plane of the rectangle: beside the rectangle, and below its middle.
        (Shape::Rectangle(rectangle), Vec3::new(-0.4, 0.9, 0.0), true),
        (Shape::Rectangle(rectangle), Vec3::new(0.9, 0.99, 0.6), true),
        // A distant viewpoint, from which the rectangle is sampled by area.
        (Shape::Rectangle(rectangle), Vec3::new(90.0, -90.0, 3.0), true),
    ];
    let shapes = shapes.into_iter().map(|(shape, p, all)| (LightSurface::Shape(shape), p, all));
    let corners = [(Vec3::new(0.9, 1.1, 1.0), true), (Vec3::new(1.5, -0.5, 0.4), false)];
    shapes
        .chain(corners.into_iter().map(|(p, all)| (mesh_light_surface(three_triangle_mesh(Vec3::ZERO)), p, all)))
        .collect()
}

/// Grid of direction cells over a cone that contains all directions that `light` samples at `p`.
fn direction_cells_around_samples(light: &Light, p: Vec3) -> DirectionCells {
    let draws = || (0..2000).filter_map(|i| light.sample_li(p, test_key(i).uniform_2d(Dimension::LightTarget)));
    let axis = draws().map(|s| s.wi).sum::<Vec3>().normalize();
    let widest = draws().map(|s| libm::acos(f64::from(s.wi.dot(axis)).min(1.0))).fold(0.0, f64::max);
    DirectionCells::new(axis, (widest * 1.5).min(std::f64::consts::PI))
}

#[test]
fn direct_samples_follow_pdf_li() {
    let views = surfaces_and_viewpoints();
    let threshold = sidak_significance_level(views.len());
    for (emitter, p, all) in views {
        // An ellipsoid is sampled by area. The pdf per solid angle then grows without bound towards
        // its outline, where the midpoint rule fails.
        let least_cos = if matches!(emitter, LightSurface::Shape(Shape::Ellipsoid(_))) { 0.2 } else { 0.0 };
        let light = Light::Area(AreaLight::with_uniform_radiance(emitter.clone(), Rgb::ONE));
        let drawn = |u: glam::Vec2| {
            let sample = light.sample_li(p, u)?;
            let ShadowTarget::Point(end) = sample.target else { panic!("a surface is not at infinity") };
            // A sample that the light itself occludes does not count.
            let point = first_hit_on_light_surface(&emitter, p, sample.wi)
                .filter(|point| (point.p - end).length() < 1e-4 && sample.wi.dot(point.ng) < 0.0)?;
            let (density, pdf) = (light.pdf_li(p, sample.wi, Some(&point)), sample.pdf?);
            // Rounding the direction by 2⁻²³ moves the hit by 2⁻²³ d/cos. The normal turns by this
            // distance times the curvature, at most 25. So the relative error of the cosine is 2⁻²³
            // · 25 d/cos².
            let cos = -sample.wi.dot(point.ng);
            assert!((density / pdf - 1.0).abs() < 1e-5 / (cos * cos), "{light:?} {p}: {density} {pdf}");
            assert!((sample.weight.x * pdf - 1.0).abs() < 1e-5);
            (cos > least_cos).then_some(sample.wi)
        };
        let density = |wi: Vec3| {
            let point = first_hit_on_light_surface(&emitter, p, wi).filter(|point| -wi.dot(point.ng) > least_cos);
            point.map_or(0.0, |point| f64::from(light.pdf_li(p, wi, Some(&point))))
        };
        let (chance, total) = direction_cells_around_samples(&light, p).test_samples_against_pdf(&drawn, &density);
        assert!(chance > threshold, "{light:?} {p}: p = {chance}");
        assert!(if all { (total - 1.0).abs() < INTEGRAL_ERROR } else { total < 0.999 }, "{light:?} {p}: {total}");
    }
}

/// Irradiance below and beside a rectangle light agrees with closed forms, at any distance from the
/// plane of the light. In this plane, and behind it, no light arrives.
#[test]
fn rectangle_sampling_is_exact_near_its_plane() {
    let (a, b) = (2.0f64, 1.5);
    for h in [1e-1f64, 1e-3, 1e-6, 1e-12, 1e-30] {
        let light = area_light(Shape::Rectangle(Rectangle::new(point_on_y_axis(0.0), DVec3::X * a, DVec3::Z * b)), 5.0);
        // A point below a corner of the light. In the limit h → 0, the light covers a quarter of
        // the hemisphere.
        let term = |p: f64, q: f64| p / (h * h + p * p).sqrt() * libm::atan(q / (h * h + p * p).sqrt());
        let truth = 2.5 * (term(a, b) + term(b, a));
        assert_within_five_sigma(estimate_irradiance(&light, Vec3::new(0.0, -h as f32, 0.0), Vec3::Y), truth);
        // A point on a wall that faces the light, at distance 1 beside it. The closed form is a
        // difference of two irradiances: that of a rectangle from the wall to the light's far edge,
        // minus that of a rectangle from the wall to the light's near edge.
        let part = |x: f64| h / libm::hypot(x, h) * libm::atan(b / libm::hypot(x, h));
        assert_within_five_sigma(
            estimate_irradiance(&light, Vec3::new(-1.0, -h as f32, 0.0), Vec3::X),
            2.5 * (part(1.0) - part(1.0 + a)),
        );
    }
    let light = area_light(Shape::Rectangle(Rectangle::new(point_on_y_axis(0.0), DVec3::X * a, DVec3::Z * b)), 5.0);
    for p in [Vec3::new(0.5, 0.0, 0.5), Vec3::new(-1.0, 0.0, 0.5), Vec3::new(0.5, 1.0, 0.5)] {
        assert!(light.sample_li(p, glam::Vec2::splat(0.3)).is_none(), "its plane and its back are black");
    }
}

/// Sampling a rectangle by solid angle has less variance than sampling it by area, by a factor that
/// grows near the light.
#[test]
fn solid_angle_sampling_has_less_variance_near_the_light() {
    let rectangle = Rectangle::new(point_on_y_axis(0.0), DVec3::X, DVec3::Z);
    let light = area_light(Shape::Rectangle(rectangle), 1.0);
    let emitter = LightSurface::Shape(Shape::Rectangle(rectangle));
    for (h, least) in [(0.05f32, 100.0), (0.3, 4.0), (1.0, 1.0)] {
        let p = Vec3::new(0.4, -h, 0.6);
        let (mean, variance) = estimate_irradiance(&light, p, Vec3::Y);
        let by_area = estimate_mean_and_variance(100_000, |k| {
            let s = emitter.sample(k.uniform_2d(Dimension::LightPosition));
            let d = s.point.p - p;
            let cos = d.normalize().y;
            f64::from(cos * cos / (d.length_squared() * s.pdf))
        });
        let gain = by_area.1 / variance;
        eprintln!(
            "at distance {h}: relative variance {:.3e}, {gain:.1} times less than by area",
            variance * 1e5 / (mean * mean)
        );
        assert_within_five_sigma(by_area, mean);
        assert!(gain > least, "{h}: {gain}");
    }
}
