//! Photon maps and lights in extreme cases.
//!
//! Maps hold no photon, one photon or ten million, at a point, in a plane, or with densities over
//! nine orders of magnitude. Lights have zero power or 10^±30 W, or are inside walls and behind
//! them.

mod focus;
mod lights;
mod map;
mod power;
mod radius;
mod spots;
mod walls;

use caustica::camera::{Camera, Filter, FilterKind};
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings, SilentMonitor};
use caustica::photon::Photon;
use caustica::render::{RenderResult, StopCriteria, render};
use caustica::sampling::{Dimension, Key, Purpose};
use caustica::scene::{Material, Scene, SceneBuilder};
use caustica::shape::{Cuboid, Rectangle, Shape};
use glam::{DVec3, Vec3};
use std::sync::atomic::AtomicBool;

/// Relative rounding error of a channel of a stored grey photon.
///
/// It is half a step of 1/65535 of the channel sum, which is three times the channel.
const STORED_COLOR_ROUNDING: f64 = 1.5 / 65_535.0;

/// Every integrator with photons.
const WITH_PHOTONS: [Algorithm; 4] = [Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Ppm, Algorithm::Pm];

/// Returns three pseudorandom numbers in \[0, 1) that depend on `i`.
fn random(i: u64) -> Vec3 {
    let key = Key::new(8).purpose_key(Purpose::Test).child_key(i);
    key.uniform_2d(Dimension::LightPosition).extend(key.uniform_1d(Dimension::Light))
}

/// Returns a photon on a surface that faces +z, with incident light along the normal.
fn photon(position: Vec3, flux: f32) -> Photon {
    Photon::new(position, Rgb::splat(flux), Vec3::Z, Vec3::Z).unwrap()
}

/// Returns a rectangle with center `center` and the given edge vectors.
fn rectangle_around(center: DVec3, edge0: DVec3, edge1: DVec3) -> Shape {
    Shape::Rectangle(Rectangle::new(center - 0.5 * (edge0 + edge1), edge0, edge1))
}

/// Adds a slab of glass of the given width, .5 above the origin.
///
/// Its index is so near 1 that light crosses it straight on and without loss. But shadow rays do
/// not cross it, so photons carry all light below it.
fn add_invisible_slab(builder: &mut SceneBuilder, width: f64) {
    let glass = builder.add_material(Material::dielectric(1.0 + 1e-6, Rgb::ZERO));
    let corner = DVec3::new(0.5 * width, 0.01, 0.5 * width);
    let slab = Cuboid::new(DVec3::Y * 0.51 - corner, DVec3::Y * 0.51 + corner).unwrap();
    builder.add_shape(Shape::Cuboid(slab), glass, Rgb::ZERO);
}

/// Returns an orthographic camera with `size` × `size` pixels over a square of edge `width`.
fn flat_camera(center: DVec3, direction: DVec3, width: f64, size: u32) -> Camera {
    let up = if direction.normalize().y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    Camera::orthographic(center, direction, up, width, size, size).unwrap()
}

/// Returns settings with `paths` photon paths per map and `samples` camera rays per pixel.
///
/// The division of work is fixed, and the filter is a box.
fn settings(paths: u32, samples: u32) -> Settings {
    let filter = Filter::new(FilterKind::Box);
    let camera_paths = CameraPathSettings {
        samples_per_pixel: Some(samples),
        seed: 5,
        filter,
        estimate_error: true,
        ..CameraPathSettings::default()
    };
    Settings {
        camera_paths,
        unaimed_paths: paths,
        aimed_paths: paths,
        allows_ray_photon_balance: false,
        ..Settings::default()
    }
}

/// Renders `passes` passes with error estimation.
fn rendered(scene: &Scene, algorithm: Algorithm, settings: Settings, passes: u32) -> RenderResult {
    let integrator = algorithm.prepare(scene, settings);
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { max_passes: Some(passes), ..StopCriteria::unlimited(&interrupted) };
    let start = RenderResult::without_passes(integrator.as_ref(), scene.camera().size());
    render(start, 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |_| {})
}

/// Fails if a pixel, an error map or an error estimate of a render is not finite.
///
/// Also fails if a sample or a photon was rejected.
#[track_caller]
fn assert_finite(what: &str, rendered: &RenderResult) {
    let mean = rendered.film.mean_picture();
    assert!(mean.iter().all(|v| v.is_finite()), "{what}: a pixel is not finite");
    assert_eq!(rendered.counters.rejected_samples, 0, "{what}: samples were left out");
    assert_eq!(rendered.counters.rejected_photons, 0, "{what}: photons were left out");
    let estimator = rendered.estimator.as_ref().unwrap();
    let maps = estimator.error_maps(&rendered.film);
    assert!(maps.noise.iter().chain(&maps.blur).all(|v| v.is_finite()), "{what}: a map of errors is not finite");
    let discs = || maps.caustic_discs.iter().chain(&maps.indirect_discs);
    assert!(discs().all(|d| d.radius.is_finite() && d.mean_count.is_finite()), "{what}: a disc is not finite");
    let estimate = estimator.estimate(&rendered.film);
    let all = [
        estimate.error,
        estimate.low,
        estimate.high,
        estimate.noise,
        estimate.bias,
        estimate.blur,
        estimate.shared_paths,
    ];
    let unknown = rendered.film.passes() < caustica::render::error_estimate::MIN_ERROR_ESTIMATE_PASSES;
    assert!(unknown || all.iter().all(|x| x.is_finite() && *x >= 0.0), "{what}: {estimate:?}");
    for audit in [rendered.unaimed.audit, rendered.aimed.audit] {
        let parts = [audit.emitted, audit.absorbed, audit.escaped, audit.stopped, audit.net_roulette_loss];
        assert!(parts.as_flattened().iter().all(|x| x.is_finite()), "{what}: {audit:?}");
    }
}
