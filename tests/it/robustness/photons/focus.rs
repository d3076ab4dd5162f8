//! All photons of a caustic at one point: the focus of a parabolic mirror.

use super::{STORED_COLOR_ROUNDING, WITH_PHOTONS, assert_finite, flat_camera, rendered, settings};
use crate::support::{mean_and_error, render_one_pass};
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::{Key, Purpose};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::parametric_surface::SplineBasis;
use caustica::shape::{Disc, Revolution, Shape};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::time::{Duration, Instant};

const IRRADIANCE: f64 = 2.0;
const REFLECTANCE: f64 = 0.8;
const TARGET: f64 = 0.01;

/// Width of a pixel \[length]. The focus is at the common corner of four pixels.
const PIXEL: f64 = 0.001;

/// Number of pixels along each edge of the image.
const PIXELS: u32 = 16;

/// Builds a parabolic mirror y = (x² + z²)/4 up to x² + z² = 1, under collimated light from above.
///
/// A diffuse disc around the focus at y = 1 faces the mirror. The image shows it in `pixels` ×
/// `pixels`.
fn parabola(pixels: u32) -> Scene {
    let mut b = SceneBuilder::new();
    let mirror = b.add_material(Material::mirror(Rgb::splat(REFLECTANCE as f32)));
    let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
    let controls = [DVec2::ZERO, DVec2::new(0.5, 0.0), DVec2::new(1.0, 0.25)];
    let bowl = Revolution::new(&SplineBasis::bezier_basis(3).unwrap(), &controls).unwrap();
    b.add_shape(Shape::Revolution(bowl), mirror, Rgb::ZERO);
    b.add_shape(Shape::Disc(Disc::circular_disc(DVec3::Y, -DVec3::Y, TARGET)), white, Rgb::ZERO);
    b.add_delta_light(
        UnscaledDeltaLight::Directional { direction: -DVec3::Y },
        LightStrength::Physical(Rgb::splat(IRRADIANCE as f32)),
    );
    b.build(flat_camera(DVec3::Y * 0.9, DVec3::Y, PIXEL * f64::from(pixels), pixels)).unwrap()
}

/// Returns the flux that the mirror reflects to the disc \[W]. The disc's shadow on the mirror
/// reflects nothing.
fn flux() -> f64 {
    IRRADIANCE * REFLECTANCE * PI * (1.0 - TARGET * TARGET)
}

/// Each of a million photons lands within 10⁻⁵ of the focus.
///
/// This distance is a few roundings of directions and of positions near 1, over distances of 2. The
/// photons' flux is area × irradiance × reflectance.
#[test]
fn photons_converge_at_focus() {
    let scene = parabola(PIXELS);
    let source = PhotonSource::aimed_at_casters(&scene).unwrap();
    let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::CAUSTIC, max_bounces: 10 };
    let key = |i| Key::new(3).purpose_key(Purpose::Test).child_key(i);
    let begun = Instant::now();
    let samples: Vec<f64> = (0..8)
        .map(|i| {
            let traced = tracer.trace(key(i), 1 << 17, &|_| {});
            let focus = (DVec3::Y - scene.origin()).as_vec3();
            let off = traced.deposits.surface_photons.iter().map(|p| (p.position - focus).length()).fold(0.0, f32::max);
            assert!(off < 1e-5, "{off}");
            traced.deposits.surface_photons.iter().map(|p| f64::from(p.attributes.flux().y)).sum()
        })
        .collect();
    let (mean, error) = mean_and_error(&samples);
    // With eight passes, Student's t with 7 degrees of freedom exceeds 9 once in 20,000 times.
    assert!((mean - flux()).abs() < 9.0 * error + STORED_COLOR_ROUNDING * flux(), "{mean} ± {error}, {}", flux());
    assert!(error < 3e-3 * mean, "{error}");
    assert!(begun.elapsed() < Duration::from_secs(60));
}

/// With default settings, images of the focus are finite and show all light, for every integrator.
///
/// The radiance over the visible area is ρ/π Φ, with albedo ρ and flux Φ, if the estimate's disc
/// lies within the area. The disc is a fraction of a pixel.
///
/// All photons lie at one point and have equal flux, so noise comes only from the number of rays
/// that hit the disc. Few pixels and few photons suffice for this. Renders have few passes, because
/// discs shrink from pass to pass, and share the radius of one pilot. With sixteen renders,
/// Student's t with 15 degrees of freedom exceeds 6.5 once in 100,000 times. 6.5 standard errors
/// are at most a fifth of the light.
#[test]
fn image_of_focus_shows_all_flux() {
    let scene = parabola(PIXELS);
    for algorithm in WITH_PHOTONS {
        assert_finite(algorithm.name(), &rendered(&scene, algorithm, settings(5_000, 4), 4));
    }
    let pilot = Algorithm::Sppm.prepare(&scene, settings(20_000, 256)).initial_gather_radii().unwrap().caustic;
    for (name, radius, k, pixels, samples) in
        [("by pilot", pilot, None, 2, 256), ("wide", (2.0 * PIXEL) as f32, Some(0), 6, 8)]
    {
        let scene = parabola(pixels);
        let seen = PIXEL * f64::from(pixels);
        assert!(2.0 * f64::from(radius) < seen, "{name}: {radius}");
        let expected = 0.5 / PI * flux() / (seen * seen);
        let mean = |seed| {
            let settings = Settings { initial_gather_radius: Some(radius), gather_k: k, ..settings(1_000, samples) };
            let camera_paths = CameraPathSettings { seed, ..settings.camera_paths };
            let method = Algorithm::Sppm.prepare(&scene, Settings { camera_paths, ..settings });
            let pass = |i| render_one_pass(&*method, i).iter().map(|v| f64::from(v.y)).sum::<f64>();
            (0..8).map(pass).sum::<f64>() / f64::from(8 * pixels * pixels)
        };
        let samples: Vec<f64> = (0..16).into_par_iter().map(mean).collect();
        let (mean, error) = mean_and_error(&samples);
        assert!(
            (mean - expected).abs() < 6.5 * error + STORED_COLOR_ROUNDING * expected,
            "{name}: {mean} ± {error}, {expected}"
        );
        assert!(error < 0.03 * expected, "{name}: {error}");
    }
}
