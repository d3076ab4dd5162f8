//! Mean and variance of the density estimate, for uniform photons on an integrating sphere.
//!
//! Reflected photons on a sphere of radius R are independent and uniform. A cap of chord r has
//! exactly the fraction (r/2R)² of the sphere's area. N photons of flux w have the mean density λ =
//! Nw/(4πR²). So all laws are exact, without a Poisson approximation.

use crate::support::*;
use caustica::photon::{Bandwidth, Kernel, PhotonMap, StoreMask};
use caustica::scene::{LightStrength, Material, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Shape, Sphere};
use glam::DVec3;
use std::f64::consts::PI;

/// Number of points at which each pass estimates the density.
///
/// The disc of each point covers less than 0.003 of the sphere, and no two discs overlap.
const PROBES: u32 = 120;

struct Moments {
    mean: Vec<f64>,
    variance: Vec<f64>,
    /// Variance that theory predicts, by pass.
    expected: Vec<f64>,
}

/// Returns, for each pass, the mean of estimate/λ over the points, and of its squared deviation
/// from 1.
///
/// λ is the true density. `variance` returns the expected variance for N photons.
fn moments(bandwidth: Bandwidth, kernel: Kernel, variance: impl Fn(f64) -> f64) -> Moments {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(Material::diffuse(grey(0.5)));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), wall, grey(0.0));
    b.add_delta_light(UnscaledDeltaLight::Point { position: dvec3(0.4, 0.1, -0.3) }, LightStrength::Power(grey(1.0)));
    let scene = photon_only_scene(b);
    let mut moments = Moments { mean: vec![], variance: vec![], expected: vec![] };
    for traced in trace_photon_passes(&scene, StoreMask::INDIRECT, 1000, 48, 1 << 15) {
        let n = traced.deposits.surface_photons.len() as f64;
        let density = flux_where(&scene, &traced.deposits.surface_photons, |_| true).x / (4.0 * PI);
        let map = PhotonMap::build(traced.deposits.surface_photons);
        let at = |p: &DVec3| estimated_irradiance(&scene, &map, *p, -*p, bandwidth, kernel).x / density - 1.0;
        let deviations: Vec<f64> = fibonacci_directions(PROBES).iter().map(at).collect();
        let count = f64::from(PROBES);
        moments.mean.push(1.0 + deviations.iter().sum::<f64>() / count);
        moments.variance.push(deviations.iter().map(|d| d * d).sum::<f64>() / count);
        moments.expected.push(variance(n));
    }
    moments
}

fn check_density_moments(what: &str, m: &Moments) {
    // Distances round to f32 relative to coordinates of 1. So a squared distance of 0.01 has a
    // relative error near 10⁻⁵.
    assert_mean(&format!("{what}: mean"), &m.mean, 1.0, 1e-4, 6e-3);
    let ratios: Vec<f64> = m.variance.iter().zip(&m.expected).map(|(v, e)| v / e).collect();
    assert_mean(&format!("{what}: variance over the expected"), &ratios, 1.0, 1e-3, 0.04);
}

/// The variance of estimates with a fixed radius agrees with theory.
///
/// A fixed disc holds a binomial number of photons. The relative variance of the estimate is c/n −
/// 1/N. n is the expected number of photons in the disc, N that of all photons, and c the kernel's
/// noise factor.
#[test]
#[ignore = "long: statistics against a closed form"]
fn fixed_radius_noise_matches_kernel() {
    for kernel in KERNELS {
        let radius = 0.1;
        let m = moments(fixed_bandwidth(radius), kernel, |n| {
            let inside = n * radius * radius / 4.0;
            kernel_noise_factor(kernel) / inside - 1.0 / n
        });
        check_density_moments(&format!("fixed radius, {kernel:?}"), &m);
    }
}

/// Mean and variance of estimates from the k nearest of N photons agree with theory.
///
/// The fraction of the sphere within the distance of the k-th photon has the distribution Beta(k, N
/// − k + 1). The k − 1 nearer photons are uniform in it. The estimate is (k − 1)/(πr²) for the box
/// kernel, and the plain sum for kernels that vanish at the edge. The estimate has the mean λ and
/// the relative variance (N − 1)(k + c − 2)/(N(k − 2)) − 1, where c is the kernel's noise factor.
/// For the box kernel and large N, this is 1/(k − 2). Only moments of order below k exist. With k ≥
/// 15, the squared deviations have a variance, so a t-test of their means over 120 points is valid.
#[test]
#[ignore = "long: t-tests of variances"]
fn nearest_neighbour_mean_and_variance_match_theory() {
    for kernel in KERNELS {
        for k in [15, 50] {
            let kf = f64::from(k);
            let m = moments(Bandwidth { radius: 0.4, k }, kernel, |n| {
                (n - 1.0) * (kf + kernel_noise_factor(kernel) - 2.0) / (n * (kf - 2.0)) - 1.0
            });
            check_density_moments(&format!("{k} nearest, {kernel:?}"), &m);
        }
    }
}
