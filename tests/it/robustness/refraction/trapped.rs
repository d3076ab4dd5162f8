//! Paths with a thousand internal reflections: no light is lost, positions stay on the surface, and
//! every path ends.

use crate::support::{render_passes, test_key};
use caustica::bsdf::TransportMode;
use caustica::camera::Camera;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::math::{Ray, warp};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::Dimension;
use caustica::scene::{
    Effects, InteriorStack, LightStrength, Material, PathEvent, Scene, SceneBuilder, UnscaledDeltaLight,
};
use caustica::shape::{Plane, Rectangle, Shape, Sphere};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

const BOUNCES: u32 = 1000;

fn built(b: SceneBuilder) -> Scene {
    b.build(Camera::perspective(DVec3::new(0.1, 0.2, 0.3), DVec3::ONE, DVec3::Y, 0.1, 4, 4).unwrap()).unwrap()
}

/// Builds a cube of edge 2 with its faces outwards, of rectangles or of triangles.
fn cube(triangles: bool) -> SceneBuilder {
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(1.5, Vec3::ZERO));
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut e = [DVec3::ZERO; 3];
            (e[axis][axis], e[(axis + 1) % 3][(axis + 1) % 3], e[(axis + 2) % 3][(axis + 2) % 3]) = (sign, 2.0, 2.0);
            let (n, mut e0, mut e1) = (e[axis], e[(axis + 1) % 3], e[(axis + 2) % 3]);
            let corner = n - 0.5 * (e0 + e1);
            if e0.cross(e1).dot(n) < 0.0 {
                (e0, e1) = (e1, e0);
            }
            if triangles {
                let corners = [corner, corner + e0, corner + e0 + e1, corner + e1];
                b.add_mesh(&corners, &[], &[[0, 1, 2], [0, 2, 3]], glass, Vec3::ZERO);
            } else {
                b.add_shape(Shape::Rectangle(Rectangle::new(corner, e0, e1)), glass, Vec3::ZERO);
            }
        }
    }
    b
}

/// Traces a path from the origin. Calls `see` with position and direction after each reflection.
///
/// Panics if a reflection is not total.
fn follow(scene: &Scene, direction: Vec3, mut see: impl FnMut(Vec3, Vec3)) {
    let mut path = scene.start_light_path::<InteriorStack>(0, Ray::new(Vec3::ZERO, direction), Effects::NONE);
    for bounce in 0..BOUNCES {
        let PathEvent::Surface(vertex) = path.next_vertex(scene, test_key(1), |_| None) else {
            panic!("out after {bounce}")
        };
        let surface = vertex.surface;
        assert!(surface.wo.dot(surface.point.ng) < 0.0, "from outside after {bounce}");
        // The largest number below 1 selects transmission if there is any.
        let s = surface.sample(1.0 - f32::EPSILON / 2.0, Vec2::ZERO, TransportMode::Importance).unwrap();
        assert!(!s.is_transmitted && s.weight == Vec3::ONE, "through after {bounce}");
        see(surface.point.p, s.wi);
        path.leave_surface_with_wavelength_weight(&surface, s.wi, false);
    }
}

/// Returns directions that hit all faces of a cube of index 1.5 beyond the critical angle.
///
/// The cosine of the critical angle is 0.745.
fn trapped_directions(n: u64) -> Vec<Vec3> {
    let all =
        (0..).map(|i| warp::square_to_uniform_sphere(test_key(2).child_key(i).uniform_2d(Dimension::LightDirection)));
    all.filter(|d| d.abs().max_element() < 0.74).take(n as usize).collect()
}

/// Rays that are trapped in a cube of glass stay on its faces.
///
/// Each reflection flips one direction cosine and normalises, which rounds all of them by at most 3
/// · 2⁻²⁴. A position on a face rounds by 2⁻²⁴ and stays on the face.
#[test]
fn trapped_rays_stay_in_cube() {
    for triangles in [false, true] {
        let mut b = cube(triangles);
        b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ZERO }, LightStrength::Power(Vec3::ONE));
        let scene = built(b);
        trapped_directions(400).par_iter().for_each(|direction| {
            let drift = BOUNCES as f32 * 3.0 * f32::EPSILON / 2.0;
            follow(&scene, *direction, |p, d| {
                assert!((p.abs().max_element() - 1.0).abs() <= f32::EPSILON, "{p}");
                assert!((d.abs() - direction.abs()).abs().max_element() < drift, "{d} {direction}");
            });
        });
    }
}

/// Rays that are trapped between two planes keep their cosine to them, over a thousand thicknesses.
#[test]
fn trapped_rays_stay_in_slab() {
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(1.5, Vec3::ZERO));
    b.add_plane(Plane::new(DVec3::Y, DVec3::Y), glass, Vec3::ZERO);
    b.add_plane(Plane::new(DVec3::NEG_Y, DVec3::NEG_Y), glass, Vec3::ZERO);
    b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ZERO }, LightStrength::Power(Vec3::ONE));
    let middle = Camera::perspective(DVec3::ZERO, DVec3::ONE, DVec3::Y, 0.1, 4, 4).unwrap();
    let scene = b.build(middle).unwrap();
    for i in 1..100 {
        let (sin, cos) = libm::sincosf(0.745 * (i as f32) / 100.0);
        let direction = Vec3::new(cos * 0.6, sin, cos * 0.8).normalize();
        follow(&scene, direction, |p, d| {
            assert!((p.y.abs() - 1.0).abs() <= f32::EPSILON);
            assert!((d.y.abs() - direction.y).abs() < BOUNCES as f32 * 1.5 * f32::EPSILON);
        });
    }
}

/// Rays that are trapped in a ball keep their distance from its center.
///
/// Each reflection rounds the position by half an ulp per coordinate. The direction rounds by seven
/// times √3 · 2⁻²⁴, in the normal, the reflection and the normalisation.
#[test]
fn trapped_rays_stay_in_ball() {
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(1.5, Vec3::ZERO));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, -0.9, 0.0), 1.0)), glass, Vec3::ZERO);
    b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ZERO }, LightStrength::Power(Vec3::ONE));
    let scene = built(b);
    // The scene moves the center to the origin. Light starts 0.9 off it.
    let drift = BOUNCES as f32 * 7.0 * 1.74 * f32::EPSILON / 2.0;
    for i in 0..100 {
        let (sin, cos) = libm::sincosf(0.4 * i as f32 / 100.0);
        let direction = Vec3::new(cos * 0.6, sin, cos * 0.8).normalize();
        let start = Vec3::Y * 0.9;
        let expected = start.cross(direction).length();
        assert!(expected > 0.7, "beyond the critical angle");
        let mut path = scene.start_light_path::<InteriorStack>(0, Ray::new(start, direction), Effects::NONE);
        for bounce in 0..BOUNCES {
            let PathEvent::Surface(vertex) = path.next_vertex(&scene, test_key(1), |_| None) else {
                panic!("out after {bounce}")
            };
            let s = vertex.surface.sample(1.0 - f32::EPSILON / 2.0, Vec2::ZERO, TransportMode::Importance).unwrap();
            let p = vertex.surface.point.p;
            assert!(!s.is_transmitted && (p.length() - 1.0).abs() < 2.0 * f32::EPSILON);
            assert!(
                (p.cross(s.wi).length() - expected).abs() < drift,
                "{bounce}: {}",
                p.cross(s.wi).length() - expected
            );
            path.leave_surface_with_wavelength_weight(&vertex.surface, s.wi, false);
        }
    }
}

/// Trapped photon paths stop at the bounce limit with their initial flux, bit for bit.
#[test]
fn trapped_photons_keep_flux_and_terminate() {
    for triangles in [false, true] {
        let mut b = cube(triangles);
        // Every direction within 5° of the diagonal hits faces at more than 49° from their normals.
        let source = UnscaledDeltaLight::Spot { position: DVec3::ZERO, axis: DVec3::ONE, inner: 0.08, outer: 0.08 };
        b.add_delta_light(source, LightStrength::Power(Vec3::new(1.0, 2.0, 3.0)));
        let scene = built(b);
        let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
        let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::CAUSTIC, max_bounces: BOUNCES };
        let traced = tracer.trace(test_key(3), 1024, &|_| {});
        assert_eq!(traced.audit.stopped, traced.audit.emitted);
        assert_eq!(
            (traced.audit.escaped, traced.audit.absorbed, traced.audit.net_roulette_loss),
            ([0.0; 3], [0.0; 3], [0.0; 3])
        );
        assert_eq!(traced.rays, 1024 * u64::from(BOUNCES + 1));
    }
}

/// Camera paths in a cube end.
///
/// The camera looks along the diagonal, so it sees no sky.
#[test]
fn trapped_camera_paths_terminate() {
    for algorithm in [Algorithm::Path, Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Distributed, Algorithm::Whitted] {
        let mut b = cube(true);
        b.set_background(Vec3::ONE);
        b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ZERO }, LightStrength::Power(Vec3::ONE));
        let camera_paths =
            CameraPathSettings { samples_per_pixel: Some(4), max_bounces: BOUNCES, ..CameraPathSettings::default() };
        let settings = Settings {
            camera_paths,
            unaimed_paths: 100,
            aimed_paths: 100,
            allows_ray_photon_balance: false,
            ..Settings::default()
        };
        let image = render_passes(&built(b), algorithm, settings, 1);
        assert!(image.iter().all(|p| *p == Vec3::ZERO), "{algorithm:?}: {image:?}");
    }
}
