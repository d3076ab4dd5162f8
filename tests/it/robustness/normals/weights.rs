//! Weights of photons under shading normals.
//!
//! Veach's correction factor is unbounded, but its mean and tail are known. Under uniform light,
//! photons arrive in proportion to the cosine to the geometric normal.

use crate::support::{midpoint_integral, scene_from_text, test_key};
use caustica::bsdf::{
    Bsdf, Conductor, Dielectric, MicrofacetScattering, Phong, ThinDielectric, TransportMode,
    deposit_shading_normal_correction,
};
use caustica::math::{Frame, warp};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::{Dimension, Key};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Largest weight that counts in sums, so that they have a variance.
///
/// Each test bounds the effect on its mean.
const MAX_WEIGHT: f64 = 100.0;

/// Two-sided quantile of the normal distribution for a false-alarm rate of 10⁻⁶.
const Z: f64 = 4.9;

const N: u64 = 1 << 18;

/// Returns a random direction from which a photon arrives, by the cosine to the geometric normal z.
fn arrival_direction(key: Key) -> Vec3 {
    Frame::from_normal(Vec3::Z).to_world(warp::square_to_cosine_hemisphere(key.uniform_2d(Dimension::LightDirection)))
}

fn tilted_normal(degrees: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(degrees.to_radians());
    Vec3::new(0.6 * sin, 0.8 * sin, cos)
}

/// Returns the mean of the values that are at most [`MAX_WEIGHT`], and [`Z`] standard errors of it.
fn clamped_mean(values: impl ParallelIterator<Item = f64>) -> (f64, f64) {
    let zero = || (0.0, 0.0);
    let add = |(s, q): (f64, f64), (t, r): (f64, f64)| (s + t, q + r);
    let (sum, squares) = values.map(|x| (x.min(MAX_WEIGHT), x.min(MAX_WEIGHT) * x.min(MAX_WEIGHT))).reduce(zero, add);
    let (mean, square) = (sum / N as f64, squares / N as f64);
    (mean, Z * ((square - mean * mean).max(0.0) / N as f64).sqrt())
}

/// Weights of photons conserve flux, and their tail is bounded.
///
/// The mean over arrivals of |w·ns|/|w·ng| is ∫|w·ns| dω/π over the upper hemisphere. It is (1 +
/// c)/2 from directions w on which the normals agree, and (1 − c)/2 from others. c and s are the
/// cosine and sine between the normals.
///
/// The slope of a direction along one axis exceeds a with the probability P(a) = ½(1 − a/√(1 +
/// a²)). The factor is |c + s·slope|. So the factor exceeds x with the probability P((x − c)/s) +
/// P((x + c)/s). As P(a) < 1/4a², that is below s²/(x − c)². Its integral from x on is below s²/(x
/// − c).
#[test]
fn photon_weights_conserve_flux_with_bounded_tail() {
    for degrees in [5.0, 37.0, 70.0, 87.0] {
        let ns = tilted_normal(degrees);
        let (c, s) = (f64::from(ns.z), f64::from((1.0 - ns.z * ns.z).sqrt()));
        let factor = |i: u64| {
            f64::from(deposit_shading_normal_correction(arrival_direction(test_key(60).child_key(i)), ns, Vec3::Z))
        };
        let (kept, error) = clamped_mean((0..N).into_par_iter().map(factor));
        let cut = s * s / (MAX_WEIGHT - c);
        assert!(kept <= 1.0 + error && kept >= 1.0 - cut - error, "{degrees}°: {kept} ± {error}");
        for x in [1.5, 3.0, 10.0, 30.0] {
            let beyond_slope = |a: f64| 0.5 * (1.0 - a / (1.0 + a * a).sqrt());
            let expected = N as f64 * (beyond_slope((x - c) / s) + beyond_slope((x + c) / s));
            let beyond = (0..N).into_par_iter().filter(|i| factor(*i) > x).count() as f64;
            // At low counts, the tail of the Poisson distribution is longer than that of the normal
            // distribution.
            let noise = Z * expected.sqrt() + 10.0;
            assert!((beyond - expected).abs() <= noise, "{degrees}°: {beyond} beyond {x}, {expected}");
        }
    }
}

/// A diffuse surface scatters light only where both normals agree.
///
/// At albedo 1, the mean weight is (1 + c)/2 for arriving directions, times the same factor for
/// leaving ones. It is the fraction of directions on which both normals agree; c and s are the
/// cosine and sine between the normals.
///
/// The factors a and b are max(c + s·slope, 0) of independent slopes. The products up to
/// [`MAX_WEIGHT`] have the mean E[a G(MAX_WEIGHT/a)]. Here G(z) = ½(z + 1 − √(s² + (z − c)²)) is
/// the integral of P(b > x) up to z. With slope = tanφ this is an integral of ½ cosφ dφ. Factors
/// round some ten times in single precision.
#[test]
fn diffuse_scatters_where_both_normals_agree() {
    for degrees in [5.0, 37.0, 70.0] {
        let ns = tilted_normal(degrees);
        let (c, s) = (f64::from(ns.z), f64::from((1.0 - ns.z * ns.z).sqrt()));
        let up_to = |z: f64| 0.5 * (1.0 + (2.0 * c * z - 1.0) / (z + (s * s + (z - c) * (z - c)).sqrt()));
        let part = |phi: f64| {
            let flux = 0.5 * (c * libm::cos(phi) + s * libm::sin(phi));
            flux * up_to(MAX_WEIGHT * libm::cos(phi) * 0.5 / flux)
        };
        // Second derivatives are at most a few hundred, where samples cross the bound. The error is
        // 10⁻⁷.
        let expected = midpoint_integral(-libm::atan(c / s), FRAC_PI_2, 20_000, part);
        // Light from beyond the shading horizon arrives behind the shading normal, which is then
        // flipped. The fraction of such directions is (1 − c)/2.
        let (agreeing, error) = clamped_mean((0..N).into_par_iter().map(|i| {
            let wo = arrival_direction(test_key(61).child_key(i));
            if wo.dot(ns) > 0.0 {
                remaining_photon_weight(&Bsdf::Diffuse(Vec3::ONE), wo, ns, i, TransportMode::Importance)
            } else {
                0.0
            }
        }));
        assert!((agreeing - expected).abs() <= error + 1e-6, "{degrees}°: {agreeing} ± {error}, {expected}");
        assert!(error < 0.05 * expected, "{degrees}°: {error}");
    }
}

/// Returns the weight of a photon that arrives from `wo` after it is scattered; 0 if it is
/// absorbed.
fn remaining_photon_weight(bsdf: &Bsdf, wo: Vec3, ns: Vec3, i: u64, transport: TransportMode) -> f64 {
    let key = test_key(62).child_key(i);
    let (lobe, u) = (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
    bsdf.sample(wo, ns, Vec3::Z, lobe, u, transport).map_or(0.0, |s| {
        let adjoint = if transport == TransportMode::Importance { s.adjoint_correction(wo, ns, Vec3::Z) } else { 1.0 };
        let weight = f64::from(s.weight.x * adjoint);
        assert!(weight.is_finite() && weight >= 0.0, "{bsdf:?} {wo} {ns}: {s:?}");
        weight
    })
}

fn lossless_bsdfs() -> Vec<(Bsdf, bool)> {
    let metal =
        |alpha| Bsdf::Conductor(Conductor::new(Vec3::ZERO, Vec3::splat(2.0), alpha, MicrofacetScattering::Single));
    vec![
        (Bsdf::Diffuse(Vec3::ONE), false),
        (Bsdf::Phong(Phong::new(Vec3::ZERO, Vec3::splat(100.0), 30.0)), false),
        (Bsdf::Mirror(Vec3::ONE), true),
        (metal(0.0), true),
        (metal(0.1), false),
        (metal(1.0), false),
        (Bsdf::ThinDielectric(ThinDielectric { eta: 1.5, internal_transmittance: Vec3::ONE }), true),
        (Bsdf::Dielectric(Dielectric { eta: 1.5 }), false),
        (Bsdf::dielectric(1.5, 0.1, MicrofacetScattering::Single), false),
        (Bsdf::dielectric(1.5, 1.0, MicrofacetScattering::Single), false),
    ]
}

/// Returns an upper bound of the mean weight of light that leaves glass of index 1.5.
///
/// `c` is the cosine between the normals. The directions outside on which the normals agree are the
/// fraction (1 + c)/2 by flux. They all see the same fraction of the inside. The directions inside
/// that lead to them are the fraction c of these, which adds T(1 − c)/2n². Directions that ns would
/// send into the surface leave by ng. They are the (1 − c)/2 on which normals disagree outside,
/// seen from inside, where their cosine to ns is above √(1 − n⁻²).
fn max_weight_out_of_glass(c: f64) -> f64 {
    let n2 = 1.5 * 1.5;
    1.0 + 0.5 * (1.0 - c) / n2 * (1.0 + 1.0 / (1.0 - 1.0 / n2).sqrt())
}

/// No surface scatters more than it receives, in the mean over uniform incident light.
///
/// A mirror and a straight transmitter lose nothing either. Reflection about ns keeps solid angles,
/// and a direction below the surface is reflected about ng instead. The exception is light that
/// leaves glass: see [`max_weight_out_of_glass`].
///
/// Factors of mirrors are |wi·ng|/|wo·ng|. They exceed x with a probability of at most that of a
/// cosine below 1/x, which is 1/x². So the mean beyond 100 is below 1/50.
#[test]
fn no_surface_reflects_more_than_it_receives() {
    for (bsdf, keeps) in lossless_bsdfs() {
        for degrees in [5.0, 37.0, 70.0, 87.0] {
            let ns = tilted_normal(degrees);
            for ns in [ns, -ns] {
                // The outer side is the side of both normals.
                let turn = if ns.z < 0.0 { -1.0 } else { 1.0 };
                let from = |i: u64| arrival_direction(test_key(63).child_key(i)) * Vec3::new(1.0, 1.0, turn);
                let values = (0..N)
                    .into_par_iter()
                    .map(|i| remaining_photon_weight(&bsdf, from(i), ns * turn, i, TransportMode::Importance));
                let (kept, error) = clamped_mean(values);
                let most = if bsdf.transmits() && !keeps && turn < 0.0 {
                    max_weight_out_of_glass(f64::from(ns.z.abs()))
                } else {
                    1.0
                };
                assert!(kept <= most + error + 1e-6, "{bsdf:?} at {degrees}°: {kept} ± {error}");
                assert!(!keeps || kept >= 1.0 - 0.02 - error, "{bsdf:?} at {degrees}°: {kept} ± {error}");
            }
        }
    }
}

/// The flux on a ball of twenty flat faces with smooth shading normals is the arriving flux.
///
/// A sky sends photons to the ball. Their weight has the mean 1, because any shading normals
/// conserve flux. So the stored flux is πL times the area. No shading normal is more than 37.4° off
/// its face normal.
#[test]
fn coarse_ball_flux_matches_its_faces() {
    const L: f64 = 2.0;
    let scene = scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 0 4  direction 0 0 -1  up 0 1 0  angle 40  width 1  height 1 }}
        Lights {{ EnvironmentLight {{ radiance {L} {L} {L} }} }}
        Materials {{ Diffuse white {{ reflectance 1 1 1 }} }}
        Group {{ MaterialName white TriangleMesh {{ obj_file coarse-ball.obj }} }}"
    ));
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::DIRECT, max_bounces: 0 };
    // An icosahedron of circumradius 1 has the area 20·(√3/4)·a² with a = 1/sin(72°).
    let edge = 1.0 / libm::sin(0.4 * std::f64::consts::PI);
    let expected = std::f64::consts::PI * L * 5.0 * 3f64.sqrt() * edge * edge;
    let s2 = libm::pow(libm::sin(37.4f64.to_radians()), 2.0);
    let traced: Vec<_> =
        (0..16u64).into_par_iter().map(|i| tracer.trace(test_key(64).child_key(i), 1 << 15, &|_| {})).collect();
    let samples: Vec<f64> = traced
        .iter()
        .map(|t| {
            let each = t.audit.emitted[0] / t.paths as f64;
            let flux = |p: &caustica::photon::Photon| f64::from(p.attributes.flux().x);
            t.deposits.surface_photons.iter().map(|p| flux(p).min(MAX_WEIGHT * each)).sum()
        })
        .collect();
    // The hue of a photon rounds by 10⁻⁵. Weights that are left out change the mean by at most
    // s²/99.
    let slack = expected * (s2 / (MAX_WEIGHT - 1.0) + 3e-5);
    crate::support::assert_mean("flux on a coarse ball", &samples, expected, slack, 0.01);
    // The number of photons with a factor above x is compared with its expected value.
    let landed: usize = traced.iter().map(|t| t.deposits.surface_photons.len()).sum();
    for x in [3.0, 10.0, 30.0] {
        let each = traced[0].audit.emitted[0] / traced[0].paths as f64;
        let beyond = traced
            .iter()
            .flat_map(|t| &t.deposits.surface_photons)
            .filter(|p| f64::from(p.attributes.flux().x) > x * each)
            .count();
        let expected = landed as f64 * s2 / (s2 + (x - 1.0) * (x - 1.0));
        assert!((beyond as f64) < expected + Z * expected.sqrt() + 10.0, "{beyond} beyond {x}, {expected}");
    }
    assert!(landed > 100_000);
}

/// Correction factors are finite at every grazing angle that floats can represent.
#[test]
fn grazing_factors_are_finite() {
    let ns = tilted_normal(60.0);
    for exponent in 0..45 {
        let z = libm::powf(10.0, -(exponent as f32));
        let wo = DVec3::new(1.0, 0.0, f64::from(z)).normalize().as_vec3();
        assert!(deposit_shading_normal_correction(wo, ns, Vec3::Z).is_finite() || z < 1e-37, "{z:e}");
        for (bsdf, _) in lossless_bsdfs() {
            for i in 0..64 {
                for n in [ns, -ns + 2.0 * ns.z * Vec3::Z] {
                    // A photon of 1 W must have a finite weight if directions round to 2⁻²⁴.
                    if z > 1e-37 {
                        remaining_photon_weight(&bsdf, wo, n, i, TransportMode::Importance);
                    }
                }
            }
        }
    }
}
