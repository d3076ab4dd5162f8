//! Furnace: a closed room whose walls all emit Le and reflect ρ has the radiance Le/(1 − ρ)
//! everywhere.

use crate::support::*;
use caustica::photon::StoreMask;
use caustica::scene::{Material, Scene, SceneBuilder};
use glam::DVec3;
use std::f64::consts::PI;

const ALBEDO: DVec3 = DVec3::new(0.7, 0.5, 0.2);
const EMITTED: DVec3 = DVec3::new(1.0, 0.5, 2.0);

fn furnace_scene() -> Scene {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(Material::diffuse(ALBEDO.as_vec3()));
    for face in box_faces(-DVec3::ONE, DVec3::ONE, true) {
        b.add_shape(face, wall, EMITTED.as_vec3());
    }
    // The view covers |x|, |y| < 0.6 of the back wall, so that discs of radius 0.3 stay on the
    // wall.
    b.build(square_camera(dvec3(0.0, 0.0, 0.9), dvec3(0.0, 0.0, -1.0), 2.0 * libm::atan(0.6 / 1.9) * 180.0 / PI, 12))
        .unwrap()
}

fn wall_power(x: f64, n: u32) -> f64 {
    (0..n).fold(1.0, |p, _| p * x)
}

/// The radiance with at most n bounces of photons is Le·(1 + ρ + … + ρⁿ⁺¹).
///
/// A path with `max_bounces` = n ends at its surface n + 1, and the visible wall adds one
/// reflection. Emission and direct light need no photons. Irradiance is uniform, so the estimate
/// has no bias.
#[test]
fn furnace_radiance_is_geometric_series() {
    let scene = furnace_scene();
    for (n, photons) in [(0, 1024), (1, 1 << 16), (3, 1 << 16), (1000, 1 << 16)] {
        let settings = caustica::integrate::Settings {
            camera_paths: camera_ray_settings(16, n).camera_paths,
            ..fixed_radius_settings(photons, 0, 0.3)
        };
        let series = (0..3).map(|c| {
            let rho: f64 = ALBEDO[c];
            EMITTED[c] * (1.0 - wall_power(rho, n + 2)) / (1.0 - rho)
        });
        let expected = DVec3::from_array(series.collect::<Vec<_>>().try_into().unwrap());
        assert_mean_rgb(
            &format!("furnace, {n} bounces"),
            &mean_radiance_per_pass(&scene, settings, PASSES),
            expected,
            0.006,
        );
    }
}

/// Estimates from the k nearest photons give the radiance of the furnace.
///
/// The radius depends on the photons. In a uniform field, the estimate is still unbiased up to
/// O(1/N) for N photons of unequal power, because the color of a photon does not depend on its
/// distance.
#[test]
#[ignore = "long: statistics against a closed form"]
fn furnace_radiance_holds_for_nearest_neighbours() {
    let scene = furnace_scene();
    for kernel in KERNELS {
        let settings =
            caustica::integrate::Settings { gather_k: Some(40), kernel, ..fixed_radius_settings(1 << 16, 0, 0.3) };
        let expected = EMITTED / (DVec3::ONE - ALBEDO);
        assert_mean_rgb(
            &format!("furnace, k nearest, {kernel:?}"),
            &mean_radiance_per_pass(&scene, settings, PASSES),
            expected,
            0.006,
        );
    }
}

/// The flux that lands over all bounces is Φ/(1 − ρ) in each channel, where Φ is the emitted flux.
///
/// Roulette uses the mean of the color channels. So it changes the colors of surviving photons, but
/// not the mean flux per channel.
#[test]
fn coloured_flux_survives_grey_roulette() {
    let scene = furnace_scene();
    let passes = trace_photon_passes(&scene, StoreMask::ALL, 1000, 64, 1 << 13);
    let landed: Vec<DVec3> = passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, |_| true)).collect();
    let emitted = EMITTED * (PI * 24.0);
    assert_mean_rgb("landed flux", &landed, emitted / (DVec3::ONE - ALBEDO), 4e-3);
    let direct: Vec<DVec3> = trace_photon_passes(&scene, StoreMask::DIRECT, 0, 4, 1 << 13)
        .iter()
        .map(|t| t.deposits.surface_photons.iter().map(|p| p.attributes.flux().as_dvec3()).sum())
        .collect();
    for flux in direct {
        // Emitted flux is random only by the choice of lights. All six lights are equal, so it is
        // exact up to rounding.
        assert!(((flux - emitted) / emitted).abs().max_element() < 1e-4, "{flux} {emitted}");
    }
}
