//! A ball lens under collimated light. The expected fluxes follow from Snell's law and Fresnel's
//! equations.
//!
//! A ray at the distance h from the axis crosses the axis behind the ball, at the distance h/sin
//! 2(θi − θt) from its center. θi is the angle of incidence, and θt the angle of refraction.

use crate::support::*;
use caustica::photon::{PhotonMap, PhotonSource, StoreMask, TracedPhotons};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::DVec3;
use std::f64::consts::TAU;

const N: f64 = 1.5;
const IRRADIANCE: f64 = 2.0;

/// Builds a glass ball of radius 1 under light from above, and a screen at depth `z` below its
/// center.
fn lens_scene(z: f64) -> Scene {
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(N as f32, grey(0.0)));
    let white = b.add_material(Material::diffuse(grey(0.5)));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), glass, grey(0.0));
    let corner = dvec3(-1.5, -z, -1.5);
    b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::Z * 3.0, DVec3::X * 3.0)), white, grey(0.0));
    b.add_delta_light(
        UnscaledDeltaLight::Directional { direction: -DVec3::Y },
        LightStrength::Physical(grey(IRRADIANCE)),
    );
    photon_only_scene(b)
}

/// Returns the distance from the axis at which the ray of distance `h` lands on a screen at depth
/// `z`.
///
/// Also returns the fraction of its light that passes both surfaces, whose reflectances are equal.
/// Returns `None` if the ray turns back upwards.
fn landing_radius(h: f64, z: f64) -> Option<(f64, f64)> {
    let deviation = 2.0 * (libm::asin(h) - libm::asin(h / N));
    let r = fresnel_reflectance((1.0 - h * h).sqrt(), N);
    let crossing = h / libm::sin(deviation);
    let down = libm::cos(deviation) > 0.0;
    down.then(|| ((z - crossing).abs() * libm::tan(deviation), (1.0 - r) * (1.0 - r)))
}

/// Returns the flux that lands on a screen at depth `z`, weighted by a function of the distance
/// from the axis.
fn beam_average(z: f64, weight: impl Fn(f64) -> f64) -> f64 {
    let ring = |h: f64| landing_radius(h, z).map_or(0.0, |(rho, part)| TAU * h * IRRADIANCE * part * weight(rho));
    midpoint_integral(0.0, 1.0, 400_000, ring)
}

/// Traces passes with two bounces, so that photons pass through the ball without inner reflections.
///
/// Photons that the outer side of the ball reflects land at more than .7 from the axis.
fn trace_focus_passes(scene: &Scene, aimed: bool) -> Vec<TracedPhotons> {
    let source =
        if aimed { PhotonSource::aimed_at_casters(scene) } else { PhotonSource::emitting_in_all_directions(scene) };
    trace_passes_from_source(scene, &source.unwrap(), StoreMask::CAUSTIC, 2, PASSES, 1 << 16)
}

/// The flux within the distance r of the axis obeys Snell's law and Fresnel's equations.
///
/// The screen is before, at and behind the paraxial focus, which is at nR/(2(n − 1)) = 1.5. The
/// quadrature misplaces a jump of the integrand by at most one step, 2.5·10⁻⁶ of the beam.
#[test]
fn ball_lens_focus_flux_obeys_snell_and_fresnel() {
    for z in [1.1, 1.3, 1.5, 2.5] {
        let scene = lens_scene(z);
        for aimed in [true, false] {
            let passes = trace_focus_passes(&scene, aimed);
            for radius in [0.05, 0.1, 0.2, 0.4, 0.6] {
                let expected = beam_average(z, |rho| f64::from(u8::from(rho <= radius)));
                let inside = |p: DVec3| p.x * p.x + p.z * p.z <= radius * radius;
                let samples: Vec<f64> =
                    passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, inside).x).collect();
                let what = format!("z = {z}, within {radius}, aimed: {aimed}");
                assert_mean(&what, &samples, expected, expected * STORED_COLOR_ROUNDING + 4e-5, 0.04);
            }
        }
    }
}

/// The density estimate on the axis, inside the caustic, has the expected value of the closed form:
/// the beam's flux weighted by the kernel.
#[test]
fn focus_estimate_is_beam_convolved_with_kernel() {
    for z in [1.3, 1.5] {
        let scene = lens_scene(z);
        let maps: Vec<PhotonMap> = trace_focus_passes(&scene, true)
            .into_iter()
            .map(|t| PhotonMap::build(t.deposits.surface_photons))
            .collect();
        for kernel in KERNELS {
            for radius in [0.03, 0.1] {
                let expected = beam_average(z, |rho| kernel_at(kernel, rho, radius));
                let probe = EstimatePoint { scene: &scene, at: dvec3(0.0, -z, 0.0), normal: DVec3::Y, radius, kernel };
                assert_estimates("focus", &probe, &maps, expected, 2e-4, 0.02);
            }
        }
    }
}
