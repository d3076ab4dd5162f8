//! Spheres and lights seen from a million radii away.

use crate::robustness::transforms::double_double::{DoubleDouble, DoubleDoubleVec};
use crate::support::render_one_pass;
use caustica::accel::ShapeHit;
use caustica::camera::Camera;
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::light::{AreaLight, Light, LightSurface, ShadowTarget};
use caustica::math::{Ray, Transform, warp};
use caustica::sampling::DiscreteDistribution;
use caustica::scene::{Material, SceneBuilder};
use caustica::shape::parametric_surface::SplineBasis;
use caustica::shape::{Disc, Mesh, MeshInstance, MeshWithBvh, Patch, Plane, Rectangle, Revolution, Shape, Sphere};
use glam::{DAffine3, DVec2, DVec3, DVec4, Vec2, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use std::sync::Arc;

fn random_vec2(rng: &mut SmallRng) -> Vec2 {
    Vec2::new(rng.random(), rng.random())
}

/// Hits of far spheres agree with double-double arithmetic.
///
/// The solver's discriminant is r² minus the squared distance of the ray's line from the center. It
/// rounds by some ulps of distance · r. Rays within 16 of these ulps of a tangent may hit or miss.
/// The position of a hit has only its final rounding error. The error of the normal is its own
/// rounding plus the effect of the position's rounding.
#[test]
fn far_spheres_are_hit_correctly() {
    let mut rng = SmallRng::seed_from_u64(3);
    let center = DVec3::new(0.3, -0.7, 0.2);
    let ball = Shape::Sphere(Sphere::new(center, 1.0));
    for distance in [3.0, 30.0, 1e3, 1e5, 1e6] {
        let (mut hits, mut doubtful) = (0, 0);
        for _ in 0..100_000 {
            let from = center.as_vec3() + warp::square_to_uniform_sphere(random_vec2(&mut rng)) * distance;
            let aim = Vec3::new(rng.random(), rng.random(), rng.random()) * 2.4 - 1.2;
            let ray = Ray::new(from, (center.as_vec3() + aim - from).normalize());
            let l = DoubleDoubleVec::from(ray.origin.as_dvec3()) - DoubleDoubleVec::from(center);
            let d = DoubleDoubleVec::from(ray.direction.as_dvec3());
            let (a, b) = (d.dot(d), l.dot(d));
            let discriminant = b * b - a * (l.dot(l) - DoubleDouble::ONE);
            let found = ball.intersect(&ray);
            if discriminant.value().abs() <= 16.0 * f64::EPSILON * f64::from(distance) {
                doubtful += 1;
                continue;
            }
            assert_eq!(found.is_some(), discriminant > DoubleDouble::ZERO, "{ray:?}");
            let Some(ShapeHit { t, shape_coords: uv }) = found else { continue };
            hits += 1;
            let exact = (-b - discriminant.sqrt()) / a;
            // t is rounded only once.
            assert!((f64::from(t) / exact.value() - 1.0).abs() <= 1.0 / 16_777_216.0, "{ray:?}: {t}");
            let s = ball.surface_point(&ray, t, uv);
            let n = (l + d.scaled(exact)).value();
            // The first term is half an ulp of each component, for coordinates below 2. The second
            // term is the effect of an ulp in the square root at grazing incidence.
            let slack =
                3f64.sqrt() / 16_777_216.0 + 16.0 * f64::EPSILON * f64::from(distance) / discriminant.value().sqrt();
            assert!((s.ng.as_dvec3() - n).length() < slack, "{ray:?}: {} {n}", s.ng);
            assert!((s.p.as_dvec3() - center - n).length() < slack, "{ray:?}: {}", s.p);
        }
        assert!(hits > 50_000 && doubtful < 5, "{distance} {hits} {doubtful}");
    }
}

/// A far light does not occlude itself: a shadow ray to a visible point ends before the light.
///
/// Points of an ellipsoid are sampled by area, so they may be on its far side, where it occludes
/// itself. Rays nearly along a surface may hit or miss, so the test ignores points with a cosine
/// below 10⁻³.
#[test]
fn far_lights_cast_no_shadow_on_themselves() {
    let squash = Transform::new(DAffine3::from_scale(DVec3::new(1.0, 0.6, 0.8))).unwrap();
    let ball = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0));
    let egg = ball.transformed(&squash).unwrap();
    let disc = Shape::Disc(Disc::circular_disc(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), 1.0));
    let corners = [Vec3::new(-1.0, 0.1, -0.7), Vec3::new(1.0, -0.2, -0.5), Vec3::new(0.1, 0.7, 0.6)];
    let one = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let mesh = Arc::new(one.clone());
    let edges = [DVec3::new(1.0, -0.2, 0.7), DVec3::new(0.1, 0.9, 0.6)];
    let rectangle = Shape::Rectangle(Rectangle::new(-0.5 * (edges[0] + edges[1]), edges[0], edges[1]));
    // The shapes are a dome, and a surface like a sail over a square. Both are convex on the
    // emissive side.
    let profile = [DVec2::new(0.8, -0.8), DVec2::new(1.0, 0.9), DVec2::new(0.0, 0.9)];
    let bell = Shape::Revolution(Revolution::new(&SplineBasis::bezier_basis(3).unwrap(), &profile).unwrap());
    let square = [1.0, -1.0, 1.0];
    let control =
        |i: usize, j: usize| DVec4::new(i as f64 - 1.0, 1.0 - 0.5 * (square[i] + square[j]), j as f64 - 1.0, 1.0);
    let net: Vec<DVec4> = (0..9).map(|i| control(i % 3, i / 3)).collect();
    let basis = SplineBasis::bezier_basis(3).unwrap();
    let patch = Shape::Patch(Patch::new([&basis, &basis], &net).unwrap());
    let placed = Shape::Instance(MeshInstance::new(Arc::new(MeshWithBvh::new(one)), squash));
    let emitters = [
        LightSurface::Shape(ball),
        LightSurface::Shape(egg),
        LightSurface::Shape(disc),
        LightSurface::Shape(rectangle),
        LightSurface::Shape(bell),
        LightSurface::Shape(patch),
        LightSurface::Shape(placed),
        LightSurface::Triangles {
            mesh,
            first_triangle: 0,
            triangle_distribution: DiscreteDistribution::new([1.0]).unwrap(),
        },
    ];
    let mut rng = SmallRng::seed_from_u64(4);
    for (kind, emitter) in emitters.into_iter().enumerate() {
        let tree = caustica::accel::Bvh::build(&[corners], &[]);
        let light = Light::Area(AreaLight::with_uniform_radiance(emitter.clone(), Rgb::ONE));
        for distance in [2.0, 30.0, 1e3, 1e5, 1e6] {
            let mut tested = 0;
            for _ in 0..50_000 {
                let p = warp::square_to_uniform_sphere(random_vec2(&mut rng)) * distance;
                let Some(sample) = light.sample_li(p, random_vec2(&mut rng)) else { continue };
                let ShadowTarget::Point(target) = sample.target else { panic!("{sample:?}") };
                let ray = Ray::between_points(p, target);
                let blocked = match &emitter {
                    LightSurface::Shape(shape) => shape.intersect(&ray).is_some(),
                    LightSurface::Triangles { .. } => tree.occluded(&ray, |_, _| false),
                };
                // A ray to a point that is seen along the surface comes arbitrarily close to the
                // surface.
                let slant = sample.wi.dot((target - p).normalize());
                assert!(!blocked || slant < 1e-3, "{distance} {kind} {ray:?} {slant}");
                tested += 1;
            }
            assert!(tested > 10_000, "{tested}");
        }
    }
}

/// A floor lit by a far sphere has no noise, because all directions in the cone of light contribute
/// equally.
///
/// It reflects ρ·L·(r/d)²·cos θ, with albedo ρ, radiance L, radius r, distance d and angle θ. The
/// image shows a few units of the floor. Distance and angle vary over it by at most 2/d.
#[test]
fn far_sphere_light_loses_no_flux() {
    for distance in [1e3, 1e5, 1e6, 1e7] {
        let mut builder = SceneBuilder::new();
        let grey = builder.add_material(Material::diffuse(Rgb::splat(0.5)));
        let place = DVec3::new(0.0, 0.0, distance);
        builder.add_plane(Plane::new(place, DVec3::new(0.0, 0.3, -1.0)), grey, Rgb::ZERO);
        let light = Shape::Sphere(Sphere::new(DVec3::new(0.3, 0.2, 0.1), 1.0));
        builder.add_shape(light, grey, Rgb::splat((distance * distance) as f32));
        let eye = place + DVec3::new(0.5, 0.25, -1.5);
        let camera = Camera::perspective(eye, DVec3::new(0.013, -0.027, 1.0), DVec3::Y, 0.3, 8, 8).unwrap();
        let scene = builder.build(camera).unwrap();
        let camera_paths = CameraPathSettings {
            samples_per_pixel: Some(16),
            max_bounces: 1,
            seed: 5,
            ..CameraPathSettings::default()
        };
        let method = Algorithm::Path.prepare(&scene, Settings { camera_paths, ..Settings::default() });
        let expected = 0.5 / 1.09f64.sqrt();
        for pixel in render_one_pass(&*method, 0) {
            let off = f64::from(pixel.x) / expected - 1.0;
            // The distance varies by a few units, and shading rounds about a hundred times.
            assert!(off.abs() < 4.0 / distance + 100.0 / 16_777_216.0, "{distance}: off by {off}");
        }
    }
}
