//! Radii after very long renders, and radii below the rounding of positions.

use super::{
    STORED_COLOR_ROUNDING, add_invisible_slab, assert_finite, flat_camera, rectangle_around, rendered, settings,
};
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, DEFAULT_ALPHA, Settings, SilentMonitor, squared_radius_ratio};
use caustica::photon::{Bandwidth, Kernel, Photon, PhotonMap, PhotonSearchBuffers};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use glam::{DVec3, Vec3};

const MILLION: u32 = 1_000_000;

/// The squared radius after 10⁶ passes agrees with a ratio of gamma functions.
///
/// The reference is Γ(z + α)/(Γ(1 + α) Γ(z + 1)) at z = 10⁶ + 1, by the series of Tricomi and
/// Erdélyi. Its next term is below z⁻². Each of the 10⁶ factors rounds three times: 3·10⁶·2⁻⁵³.
#[test]
fn radius_after_million_passes_matches_gamma_ratio() {
    let z = f64::from(MILLION) + 1.0;
    let series = 1.0 + (DEFAULT_ALPHA - 1.0) * DEFAULT_ALPHA / (2.0 * z);
    let closed = libm::pow(z, DEFAULT_ALPHA - 1.0) * series / libm::tgamma(1.0 + DEFAULT_ALPHA);
    let error = (squared_radius_ratio(DEFAULT_ALPHA, MILLION) / closed - 1.0).abs();
    assert!(error < 3e6 * f64::EPSILON / 2.0 + 1e-12, "{error:e}");
}

/// Builds a floor of 1 × 1 that is lit through an invisible slab, so that all its light is a
/// caustic.
///
/// The middle quarter of the floor is visible.
fn behind_a_slab() -> Scene {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
    b.add_shape(rectangle_around(DVec3::ZERO, DVec3::Z, DVec3::X), white, Rgb::ZERO);
    add_invisible_slab(&mut b, 1.0);
    b.add_delta_light(UnscaledDeltaLight::Directional { direction: -DVec3::Y }, LightStrength::Physical(Rgb::ONE));
    b.build(flat_camera(DVec3::Y * 0.2, -DVec3::Y, 0.5, 4)).unwrap()
}

/// After 10⁶ passes, disc radii follow the law and no light is lost.
///
/// Each of 4 × 4 pixels has 1,000 rays, with gather discs of radius .0105. Together the discs cover
/// the visible quarter of the floor. For n photons on the floor, the relative error is below
/// √(c/(n/4)) with the kernel's noise factor c = 4/3. Five sigma for 50,000 photons are .052.
///
/// Once the radius is below the rounding of positions, discs no longer shrink. They hold so few
/// photons that an image cannot test their mean.
#[test]
fn discs_after_million_passes_hold_photons() {
    let scene = behind_a_slab();
    for (radius, paths, law) in [(0.1f32, 250_000, true), (1e-9, 20_000, false)] {
        let settings = Settings { initial_gather_radius: Some(radius), gather_k: Some(0), ..settings(paths, 1000) };
        let method = Algorithm::Sppm.prepare(&scene, settings);
        let pass = method.render_pass(MILLION, &SilentMonitor);
        assert_eq!((pass.counters.rejected_samples, pass.counters.rejected_photons), (0, 0));
        let expected = f64::from(radius) * squared_radius_ratio(DEFAULT_ALPHA, MILLION).sqrt();
        for pixel in &pass.nested {
            let found = f64::from(pixel.caustic_disc.unwrap().radius);
            if law {
                // The tolerance covers the rounding of the radius, of its root, and of the mean of
                // a thousand equal radii in single precision.
                assert!((found / expected - 1.0).abs() < 1002.0 * f64::from(f32::EPSILON), "{found} {expected}");
            } else {
                // Positions are within .9 of the scene's center, which bounds their rounding.
                assert!(found > 100.0 * expected && found < 1e-5, "{found} {expected}");
            }
            assert!(pixel.differences.iter().all(|s| s.is_finite()));
        }
        if law {
            let stored = pass.aimed.stored_photons as f64;
            let mean = pass.image.iter().map(|v| f64::from(v.y)).sum::<f64>() / 16.0;
            assert!(stored > 50_000.0);
            let off = (mean * std::f64::consts::PI / 0.5 - 1.0).abs();
            assert!(off < 5.0 * (4.0 / 3.0 / (0.25 * stored)).sqrt(), "{mean}");
        }
    }
}

/// Photons on a plane far from the origin are found at any radius, although their positions are
/// rounded.
///
/// The photons lie around a point of a tilted plane, as close together as floats allow. The
/// estimate is finite, and includes all photons that rounding moves off the plane. The smallest
/// radius of a disc is 10⁻⁵ R, where R is the distance from the origin. Each rotated position has
/// an error of γ(3)R in each coordinate. So distances have an error of 2·3·2⁻²⁴·√3 R = 6.2·10⁻⁷ R,
/// .062 of the disc's radius. Epanechnikov's kernel changes by at most the square of this fraction.
#[test]
fn disc_radius_never_falls_below_position_rounding() {
    let normal = Vec3::new(0.5, 0.7, -0.4).normalize();
    for size in [1e-3f32, 1.0, 1e6] {
        let center = Vec3::new(0.7, -0.3, 0.9) * size;
        let step = |i: u64, shift: u64| 1.0 + ((i >> shift) % 3) as f32 * f32::EPSILON;
        let place = |i: u64| center * Vec3::new(step(i, 0), step(i, 2), step(i, 4));
        let photons = (0..1000u64).map(|i| Photon::new(place(i * 37), Rgb::ONE, normal, normal).unwrap()).collect();
        let map = PhotonMap::build(photons);
        for radius in [1e-3f32, 1e-6, 1e-9, 1e-20].map(|r| r * size) {
            for k in [0, 50] {
                let found = map.estimate_radiance_in_nested_discs(
                    center,
                    normal,
                    Bandwidth { radius, k },
                    Kernel::Epanechnikov,
                    &mut PhotonSearchBuffers::default(),
                    |_| Rgb::ONE,
                );
                let r = f64::from(found.full_disc.radius);
                assert!(r >= 0.99e-5 * f64::from(center.length()) && r <= 1.01e-3 * f64::from(size), "{r}");
                let part = f64::from(found.full_disc.radiance.y) * std::f64::consts::PI * r * r / 2000.0;
                assert!(
                    (part - 1.0).abs() < 0.062 * 0.062 + STORED_COLOR_ROUNDING,
                    "{size:e}, {radius:e}, k = {k}: {part}"
                );
                assert!(found.radiance.iter().all(|l| l.is_finite()));
            }
        }
    }
}

/// A full render is finite with the smallest radius that a user can set.
#[test]
#[ignore = "long: many samples of a hard case"]
fn renders_with_tiny_radius_are_finite() {
    for radius in [1e-30f32, 1e-12, 1e-6] {
        let settings = Settings { initial_gather_radius: Some(radius), ..settings(20_000, 4) };
        assert_finite("narrow", &rendered(&behind_a_slab(), Algorithm::Sppm, settings, 4));
    }
}
