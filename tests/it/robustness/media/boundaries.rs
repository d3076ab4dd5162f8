//! Paths across a million boundaries of nested bodies.

use crate::support::render_one_pass;
use caustica::camera::Camera;
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::medium::{Medium, PhaseFunction};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::{Key, Purpose};
use caustica::scene::{Body, LightStrength, Material, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Rectangle, Shape};
use glam::DVec3;
use std::time::{Duration, Instant};

/// Number of nested bodies, many more than an interior stack can hold.
const NEST: u32 = 100;

/// Number of times that light crosses all nested bodies: 2 · 100 · 5,000 boundaries.
const TURNS: u32 = 5000;

/// Total optical depth of a path over all crossings.
const DEPTH: f64 = 1.0;

/// Relative error of the transmittance of a path across so many boundaries.
///
/// It has three parts. The coefficient σ of each body rounds by 2⁻²⁴. Each of 5,000 crossings
/// rounds its transmittance and the product: 2·2⁻²⁴. And at each boundary, the offset of the ray
/// origin shortens the path by a few roundings of a coordinate near 1: at most 8·2⁻²⁴.
const ROUNDING: f64 = (DEPTH + 2.0 * 5000.0 + 100.0 * 8.0 * DEPTH) / 16_777_216.0;

/// Returns a rectangle around `center` with these edges.
fn rectangle_around(center: DVec3, edge0: DVec3, edge1: DVec3) -> Shape {
    Shape::Rectangle(Rectangle::new(center - 0.5 * (edge0 + edge1), edge0, edge1))
}

/// Returns half the thickness of body `i`, the outermost first.
fn half_thickness(i: u32) -> f64 {
    0.9 * f64::from(NEST - i) / f64::from(NEST)
}

/// Returns the absorption coefficient in body `i`.
///
/// The optical depth of `turns` crossings of all bodies is [`DEPTH`]. Neighbouring bodies differ,
/// so that the test finds a confusion of two bodies.
fn absorption_of_body(i: u32, turns: u32) -> f64 {
    let uneven = |i: u32| 1.0 + f64::from(i % 7);
    let thickness = |i: u32| 2.0 * (half_thickness(i) - if i + 1 < NEST { half_thickness(i + 1) } else { 0.0 });
    let total: f64 = (0..NEST).map(|i| uneven(i) * thickness(i)).sum();
    uneven(i) / total * DEPTH / f64::from(turns)
}

/// Cause of absorption in the nested bodies.
#[derive(Clone, Copy, Debug)]
enum Filled {
    /// A medium inside each body.
    Media,
    /// The absorption coefficient of each body's dielectric.
    Bodies,
}

/// Adds nested slabs across the x axis, with index-matched boundaries.
fn nested_bodies(b: &mut SceneBuilder, filled: Filled, turns: u32) {
    let (y, z) = (DVec3::Y * 400.0, DVec3::Z * 400.0);
    for i in 0..NEST {
        let absorption = Rgb::splat(absorption_of_body(i, turns) as f32);
        let body = match filled {
            Filled::Media => Body::null_interface_with_medium(b.add_medium(Medium::homogeneous(
                absorption,
                Rgb::ZERO,
                Rgb::ZERO,
                PhaseFunction::Isotropic,
            ))),
            Filled::Bodies => Body { absorption, is_null_interface: true, ..Body::new(1.0) },
        };
        let body = b.add_material(Material::smooth_boundary(body));
        b.add_shape(rectangle_around(DVec3::X * half_thickness(i), y, z), body, Rgb::ZERO);
        b.add_shape(rectangle_around(-DVec3::X * half_thickness(i), z, y), body, Rgb::ZERO);
    }
}

/// Returns a camera on the x axis that looks along it through one pixel.
fn camera_along_x() -> Camera {
    Camera::orthographic(-0.95 * DVec3::X, DVec3::X, DVec3::Z, 1e-3, 1, 1).unwrap()
}

fn settings(max_bounces: u32) -> Settings {
    let camera_paths = CameraPathSettings { samples_per_pixel: Some(1), max_bounces, ..CameraPathSettings::default() };
    Settings { camera_paths, allows_ray_photon_balance: false, ..Settings::default() }
}

/// A camera ray across a million boundaries obeys Beer's law.
///
/// The bodies lie between two mirrors. The ray hits the far mirror 2,500 times. This mirror emits
/// radiance 1, so the sum is Σ exp(−(2k + 1)τ), where τ is the optical depth of one crossing. Each
/// term adds a rounding error of 2⁻²⁴ of the sum.
#[test]
fn camera_ray_obeys_beer_over_million_boundaries() {
    let tau = DEPTH / f64::from(TURNS);
    let expected: f64 = (0..TURNS / 2).map(|k| libm::exp(-f64::from(2 * k + 1) * tau)).sum();
    let slack = ROUNDING + f64::from(TURNS / 2) / 16_777_216.0;
    let off = [Filled::Media, Filled::Bodies].map(|filled| {
        let mut b = SceneBuilder::new();
        let silver = b.add_material(Material::mirror(Rgb::ONE));
        let (y, z) = (DVec3::Y * 2.0, DVec3::Z * 2.0);
        b.add_shape(rectangle_around(DVec3::X, z, y), silver, Rgb::ONE);
        b.add_shape(rectangle_around(-DVec3::X, y, z), silver, Rgb::ZERO);
        nested_bodies(&mut b, filled, TURNS);
        let scene = b.build(camera_along_x()).unwrap();
        let begun = Instant::now();
        let image = render_one_pass(&*Algorithm::Path.prepare(&scene, settings(TURNS - 1)), 0);
        // The test takes half a second on an idle machine.
        assert!(begun.elapsed() < Duration::from_secs(60));
        (f64::from(image[0].y) / expected - 1.0).abs()
    });
    assert!(off.iter().all(|off| *off < slack), "media, bodies: {off:?}, may be {slack}");
}

/// Photons across a million boundaries obey Beer's law.
///
/// A spotlight is between the two mirrors. Its half angle of 10⁻³ lengthens paths by less than
/// 10⁻⁶. The test compares the flux after the last bounce.
#[test]
fn photons_obey_beer_over_million_boundaries() {
    let off = [Filled::Media, Filled::Bodies].map(|filled| {
        let mut b = SceneBuilder::new();
        let silver = b.add_material(Material::mirror(Rgb::ONE));
        let (y, z) = (DVec3::Y * 400.0, DVec3::Z * 400.0);
        b.add_shape(rectangle_around(DVec3::X, z, y), silver, Rgb::ZERO);
        b.add_shape(rectangle_around(-DVec3::X, y, z), silver, Rgb::ZERO);
        nested_bodies(&mut b, filled, TURNS);
        let spot = UnscaledDeltaLight::Spot { position: -0.95 * DVec3::X, axis: DVec3::X, inner: 0.9e-3, outer: 1e-3 };
        b.add_delta_light(spot, LightStrength::Power(Rgb::ONE));
        let scene = b.build(camera_along_x()).unwrap();
        let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
        let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: TURNS - 1 };
        let audit = tracer.trace(Key::new(3).purpose_key(Purpose::Test), 2, &|_| {}).audit;
        let left = audit.stopped[1] / audit.emitted[1];
        let booked = (audit.absorbed[1] + audit.stopped[1] + audit.net_roulette_loss[1]) / audit.emitted[1];
        // The audit adds five thousand differences in single precision.
        assert!((booked - 1.0).abs() < 5000.0 / 16_777_216.0 && audit.escaped == [0.0; 3], "{audit:?}");
        (left / libm::exp(-DEPTH) - 1.0).abs()
    });
    assert!(off.iter().all(|off| *off < ROUNDING + 1e-6), "media, bodies: {off:?}, may be {ROUNDING}");
}

/// A shadow ray crosses more bodies than an interior stack holds, and transmits exp(−depth).
///
/// It runs through 200 boundaries from a floor to a directional light. An interior stack holds
/// twelve bodies.
#[test]
#[ignore = "long: many samples of a hard case"]
fn shadow_rays_cross_more_bodies_than_stack_holds() {
    for filled in [Filled::Media, Filled::Bodies] {
        let mut b = SceneBuilder::new();
        let white = b.add_material(Material::diffuse(Rgb::ONE));
        nested_bodies(&mut b, filled, 1);
        b.add_shape(rectangle_around(-DVec3::X, DVec3::Y * 2.0, DVec3::Z * 2.0), white, Rgb::ZERO);
        let sun = UnscaledDeltaLight::Directional { direction: -DVec3::X };
        b.add_delta_light(sun, LightStrength::Physical(Rgb::splat(std::f32::consts::PI)));
        let camera = Camera::orthographic(-0.95 * DVec3::X, -DVec3::X, DVec3::Z, 1e-3, 1, 1).unwrap();
        let scene = b.build(camera).unwrap();
        for algorithm in [Algorithm::Path, Algorithm::Hybrid, Algorithm::Distributed] {
            let found = f64::from(render_one_pass(&*algorithm.prepare(&scene, settings(10)), 0)[0].y);
            // The tolerance is that of [`ROUNDING`] for one crossing, plus a few operations of
            // shading.
            let slack = (DEPTH + 100.0 * 8.0 * DEPTH + 16.0) / 16_777_216.0;
            assert!((found / libm::exp(-DEPTH) - 1.0).abs() < slack, "{filled:?}, {}: {found}", algorithm.name());
        }
    }
}
