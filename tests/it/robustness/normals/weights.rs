//! Weights of photons under shading normals.
//!
//! Veach's correction factor for shading normals (1997, section 5.3) is unbounded, but its mean and
//! tail are known. Under uniform light, photons arrive with a density proportional to the cosine to
//! the geometric normal ng. ns is the shading normal.

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

/// Largest weight that sums include, so that their variance is finite.
///
/// Each test bounds the effect of the omitted weights on its mean.
const MAX_WEIGHT: f64 = 100.0;

/// Allowed deviation of a mean, in standard errors: the two-sided quantile of the normal
/// distribution for a false-alarm rate of 10⁻⁶.
const MAX_STANDARD_ERRORS: f64 = 4.9;

const N: u64 = 1 << 18;

/// Returns a random direction from which a photon arrives, with a pdf proportional to the cosine to
/// the geometric normal +z.
fn arrival_direction(key: Key) -> Vec3 {
    Frame::from_normal(Vec3::Z).to_world(warp::square_to_cosine_hemisphere(key.uniform_2d(Dimension::LightDirection)))
}

fn tilted_normal(degrees: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(degrees.to_radians());
    Vec3::new(0.6 * sin, 0.8 * sin, cos)
}

/// Returns the mean of the values that are at most [`MAX_WEIGHT`], and its allowed deviation of
/// [`MAX_STANDARD_ERRORS`] standard errors.
fn clamped_mean(values: impl ParallelIterator<Item = f64>) -> (f64, f64) {
    let zero = || (0.0, 0.0);
    let add = |(s, q): (f64, f64), (t, r): (f64, f64)| (s + t, q + r);
    let (sum, squares) = values.map(|x| (x.min(MAX_WEIGHT), x.min(MAX_WEIGHT) * x.min(MAX_WEIGHT))).reduce(zero, add);
    let (mean, square) = (sum / N as f64, squares / N as f64);
    (mean, MAX_STANDARD_ERRORS * ((square - mean * mean).max(0.0) / N as f64).sqrt())
}

/// Weights of photons conserve flux, and their tail is bounded.
///
/// The weight of a photon from direction w is |w·ns|/|w·ng|. c and s are the cosine and sine of the
/// angle between the normals.
///
/// Mean: ∫|w·ns| dω/π over the upper hemisphere is 1. Directions for which both normals are on the
/// same side contribute (1 + c)/2, and all others (1 − c)/2.
///
/// Tail: the weight is |c + s·slope|, where slope is that of w along one axis. The slope exceeds a
/// with the probability P(a) = ½(1 − a/√(1 + a²)). So the weight exceeds x with the probability
/// P((x − c)/s) + P((x + c)/s). Because P(a) < 1/(4a²), this is below s²/(x − c)². The integral of
/// this probability from x on is below s²/(x − c).
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
            // The added 10 covers low counts, for which a Poisson distribution has a longer tail
            // than a normal one.
            let noise = MAX_STANDARD_ERRORS * expected.sqrt() + 10.0;
            assert!((beyond - expected).abs() <= noise, "{degrees}°: {beyond} beyond {x}, {expected}");
        }
    }
}

/// A diffuse surface scatters light only between directions that are on the same side of both
/// normals.
///
/// c and s are the cosine and sine of the angle between the normals. At albedo 1, the mean weight
/// is (1 + c)/2 for arriving directions, times the same factor for leaving ones.
///
/// The weight is a product of two factors a and b. Each is max(c + s·slope, 0), with independent
/// slopes. The products up to [`MAX_WEIGHT`] have the mean E\[a G(MAX_WEIGHT/a)]. Here G(z) = ½(z +
/// 1 − √(s² + (z − c)²)) is the integral of P(b > x) from 0 to z. With slope = tan φ, the
/// expectation over a is an integral with ½ cos φ dφ.
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
        // The midpoint rule has an error of 10⁻⁷: second derivatives are at most a few hundred,
        // where weights reach the bound.
        let expected = midpoint_integral(-libm::atan(c / s), FRAC_PI_2, 20_000, part);
        // Directions behind the shading normal count as 0, because the normal would be flipped for
        // them. They are the fraction (1 − c)/2.
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

/// Returns the weight after scattering of a photon that arrives from `wo` with weight 1; 0 if it is
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
/// `c` is the cosine of the angle between the normals. The bound is 1 plus two terms:
///
/// - The outer directions for which both normals agree are the fraction (1 + c)/2 of the flux. Of
///   the inner directions that lead to them, only the fraction c is on the same side of both
///   normals. This adds at most (1 − c)/(2n²).
/// - Directions that refraction about ns would send into the surface leave by ng instead. Outside,
///   they are the fraction (1 − c)/2 of the flux. Inside, their cosine to ns is above √(1 − n⁻²).
///   This adds at most (1 − c)/(2n² √(1 − n⁻²)).
fn max_weight_out_of_glass(c: f64) -> f64 {
    let n2 = 1.5 * 1.5;
    1.0 + 0.5 * (1.0 - c) / n2 * (1.0 + 1.0 / (1.0 - 1.0 / n2).sqrt())
}

/// No surface scatters more than it receives, in the mean over uniform incident light.
///
/// Mirrors and straight transmitters also lose nothing. Reflection about ns keeps solid angles. If
/// the reflected direction is below the surface, it is reflected about ng instead. The exception is
/// light that leaves glass: see [`max_weight_out_of_glass`].
///
/// Photon weights at mirrors are |wi·ng|/|wo·ng|. A weight above x needs a cosine below 1/x, which
/// has the probability 1/x². So weights above 100 contribute less than 1/50 to the mean.
#[test]
fn no_surface_reflects_more_than_it_receives() {
    for (bsdf, keeps) in lossless_bsdfs() {
        for degrees in [5.0, 37.0, 70.0, 87.0] {
            let ns = tilted_normal(degrees);
            for ns in [ns, -ns] {
                // Both normals point outward, to +z. If `turn` is −1, photons arrive from inside.
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
    // The stored color of a photon rounds by 10⁻⁵. Omitted weights change the mean by at most
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
        assert!(
            (beyond as f64) < expected + MAX_STANDARD_ERRORS * expected.sqrt() + 10.0,
            "{beyond} beyond {x}, {expected}"
        );
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
