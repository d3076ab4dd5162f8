//! Tests of phase functions: normalization, and samples against the pdf by Pearson's chi-square
//! test.

use super::*;
use glam::Vec2;
use rand::RngExt;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

const RINGS: usize = 40;
const SECTORS: usize = 8;
const POINTS: usize = 200;

fn tested_phase_functions() -> Vec<PhaseFunction> {
    let mut phases = vec![PhaseFunction::Isotropic, PhaseFunction::Rayleigh];
    phases.extend([-0.99, -0.5, -1e-4, 0.0, 1e-4, 0.3, 0.9, 0.99].map(PhaseFunction::HenyeyGreenstein));
    phases
}

/// Bins of the scattering angle, narrow where the phase function peaks.
///
/// Bins are of equal width in a coordinate x in \[0, 1], which `bin_edge_angle` maps to the angle.
struct AngleBins {
    width: f64,
    backwards: bool,
}

impl AngleBins {
    fn bins_for_phase_function(phase: PhaseFunction) -> Self {
        let g = f64::from(phase.mean_cosine());
        Self { width: 1.0 - g.abs(), backwards: g < 0.0 }
    }

    fn bin_edge_angle(&self, x: f64) -> f64 {
        let angle = x * PI * self.width / (PI + self.width - PI * x);
        if self.backwards { PI - angle } else { angle }
    }

    fn bin_of_angle(&self, angle: f64) -> usize {
        let angle = if self.backwards { PI - angle } else { angle };
        let x = angle * (PI + self.width) / (PI * (angle + self.width));
        ((x * RINGS as f64) as usize).min(RINGS - 1)
    }

    /// Returns the integral over each bin of `f`(cos) times the phase function.
    fn integrate_bins(&self, phase: PhaseFunction, f: impl Fn(f64) -> f64) -> Vec<f64> {
        let n = RINGS * POINTS;
        let mut rings = vec![0.0; RINGS];
        for i in 0..n {
            let [low, middle, high] = [0.0, 0.5, 1.0].map(|d| self.bin_edge_angle((i as f64 + d) / n as f64));
            let cos = libm::cos(middle);
            let area = TAU * (libm::cos(low) - libm::cos(high)).abs();
            rings[i / POINTS] += area * f(cos) * f64::from(phase.evaluate(cos as f32));
        }
        rings
    }
}

/// Compares the integral of each phase function with 1, and its mean cosine with g.
///
/// The tolerance is 10⁻³, because cosines are rounded to f32. At g = 0.99, an error of 2⁻²⁵ in a
/// cosine changes the peak by the relative amount 3g·2⁻²⁵/(1−g)² < 10⁻³. The midpoint rule errs by
/// less.
#[test]
fn phase_functions_are_normalised_with_mean_cosine() {
    for phase in tested_phase_functions() {
        let rings = AngleBins::bins_for_phase_function(phase);
        let total: f64 = rings.integrate_bins(phase, |_| 1.0).iter().sum();
        let mean: f64 = rings.integrate_bins(phase, |cos| cos).iter().sum();
        let off = (total - 1.0).abs().max((mean - f64::from(phase.mean_cosine())).abs());
        assert!(off < 1e-3, "{phase:?}: {total}, {mean}");
        if phase.mean_cosine().abs() < 0.95 {
            assert!(off < 2e-5, "{phase:?}: {total}, {mean}");
        }
    }
}

#[test]
fn phase_samples_follow_their_pdf() {
    let n = 100_000;
    let travels = [Vec3::Z, Vec3::NEG_Z, Vec3::new(0.3, -0.5, 0.6).normalize()];
    let mut random = test_rng(1);
    for phase in tested_phase_functions() {
        for travel in travels {
            let rings = AngleBins::bins_for_phase_function(phase);
            let expected = rings.integrate_bins(phase, |_| 1.0);
            let axis = travel.as_dvec3().normalize();
            let side = axis.any_orthonormal_vector();
            let mut counts = vec![0u32; RINGS * SECTORS];
            let mut mean = RunningMean::default();
            for _ in 0..n {
                let (next, pdf) = phase.sample(travel, Vec2::new(random.random(), random.random()));
                assert!((next.length() - 1.0).abs() < 3e-7 && pdf > 0.0 && pdf.is_finite(), "{phase:?} {next} {pdf}");
                let d = next.as_dvec3();
                let [x, y, z] = [side, axis.cross(side), axis].map(|a| a.dot(d));
                // A dot product of unit vectors in f32 errs by less than 4·2⁻²⁴. The pdf errs by
                // this error times its slope.
                let a = f64::from(phase.mean_cosine().abs());
                let slope = 3.0 * a / ((1.0 - a) * (1.0 - a) + 2.0 * a * (1.0 - z.abs()));
                let again = f64::from(phase.evaluate(travel.dot(next)));
                assert!((f64::from(pdf) / again - 1.0).abs() < 2.4e-7 * (slope + 4.0), "{phase:?} {z}: {pdf} {again}");
                let ring = rings.bin_of_angle(libm::atan2(libm::hypot(x, y), z));
                let sector = (libm::atan2(y, x) / TAU + 0.5) * SECTORS as f64;
                counts[ring * SECTORS + (sector as usize).min(SECTORS - 1)] += 1;
                mean.add_sample(DVec3::splat(z));
            }
            mean.assert_near(DVec3::splat(f64::from(phase.mean_cosine())), "mean cosine");
            let cells = counts
                .iter()
                .enumerate()
                .map(|(i, c)| (f64::from(n) * expected[i / SECTORS] / SECTORS as f64, f64::from(*c)));
            let p = chi_square_p_value(cells);
            // 30 cases at this limit, about 0.0025/30, give one false alarm in 400 runs (Šidák's
            // correction).
            assert!(p > 8e-5, "{phase:?} along {travel}: p = {p:e}");
        }
    }
}

/// Returns the p-value of Pearson's chi-square test, by the Wilson–Hilferty approximation.
///
/// `cells` yields (expected count, observed count). Neighboring cells are pooled until 5 samples
/// are expected.
fn chi_square_p_value(cells: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut pool, mut chi2, mut used) = ((0.0, 0.0), 0.0, 0u32);
    for (expected, found) in cells {
        pool = (pool.0 + expected, pool.1 + found);
        if pool.0 >= 5.0 {
            chi2 += (pool.1 - pool.0) * (pool.1 - pool.0) / pool.0;
            used += 1;
            pool = (0.0, 0.0);
        }
    }
    let nu = f64::from(used - 1);
    let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
    0.5 * libm::erfc(z * FRAC_1_SQRT_2)
}

#[test]
fn extreme_henyey_greenstein_is_stable() {
    let last = 1.0 - f32::EPSILON / 2.0;
    for phase in tested_phase_functions() {
        for cos in [-1.0, 1.0, -1.0 - 1e-6, 1.0 + 1e-6] {
            assert!(phase.evaluate(cos) > 0.0 && phase.evaluate(cos).is_finite(), "{phase:?} {cos}");
        }
        for u in [0.0, f32::EPSILON / 2.0, 0.5, last] {
            let (next, pdf) = phase.sample(Vec3::X, Vec2::new(u, 0.25));
            assert!(next.is_normalized() && pdf > 0.0 && pdf.is_finite(), "{phase:?} {u}: {next} {pdf}");
        }
    }
    // The peaks in closed form: (1+g)/(4π(1−g)²) ahead and (1−g)/(4π(1+g)²) behind.
    let g = f64::from(0.99f32);
    let peak = (1.0 + g) / (4.0 * PI * (1.0 - g) * (1.0 - g));
    let tail = (1.0 - g) / (4.0 * PI * (1.0 + g) * (1.0 + g));
    for (phase, cos, truth) in [(0.99, 1.0, peak), (0.99, -1.0, tail), (-0.99, -1.0, peak), (-0.99, 1.0, tail)] {
        let found = f64::from(PhaseFunction::HenyeyGreenstein(phase).evaluate(cos));
        assert!((found / truth - 1.0).abs() < 1e-6, "{phase} {cos}: {found}, not {truth}");
    }
}
