//! Homogeneous media in closed form: transmittance, distance sampling and emission.

use super::{DistanceSample, Medium, channel_probabilities, zero_unsampled_channels};
use crate::color::Rgb;
use glam::DVec3;
use rand::{Rng, RngExt};

/// Optical depth `sigma` · `distance` in each color channel; 0 where `sigma` is 0, even at infinite
/// distance.
fn optical_depth(sigma: Rgb, distance: f64) -> DVec3 {
    DVec3::from_array(sigma.to_array().map(|s| if s > 0.0 { f64::from(s) * distance } else { 0.0 }))
}

/// exp(−depth) in each color channel.
fn exp_neg(depth: DVec3) -> DVec3 {
    DVec3::from_array(depth.to_array().map(|x| libm::exp(-x)))
}

/// Transmittance over `distance` with extinction coefficient `sigma` \[1/length], by the
/// Beer–Lambert law.
#[inline]
#[must_use]
pub fn transmittance(sigma: Rgb, distance: f32) -> Rgb {
    transmittance_f64(sigma, distance).as_vec3()
}

/// Returns the result of [`transmittance`] in f64.
#[inline]
pub(super) fn transmittance_f64(sigma: Rgb, distance: f32) -> DVec3 {
    if sigma.x == sigma.y && sigma.y == sigma.z {
        let depth = if sigma.x > 0.0 { f64::from(sigma.x) * f64::from(distance.max(0.0)) } else { 0.0 };
        return DVec3::splat(libm::exp(-depth));
    }
    exp_neg(optical_depth(sigma, f64::from(distance.max(0.0))))
}

/// Samples a scattering distance from the exponential distribution of one color channel, chosen
/// with probability proportional to its throughput.
///
/// The pdf by which the weight of the sample is divided is the mean of the channels' pdfs, weighted
/// with these probabilities (balance heuristic). If the chosen channel has no extinction, the ray
/// passes through.
pub(super) fn distance_sample(medium: &Medium, distance: f32, throughput: Rgb, rng: &mut impl Rng) -> DistanceSample {
    let sigma = medium.extinction();
    let probability = channel_probabilities(throughput);
    let mut choice = rng.random::<f64>();
    let mut channel = 0;
    // If rounding leaves `choice` positive after the last channel, the last channel with positive
    // probability is chosen.
    for i in 0..3 {
        if probability[i] > 0.0 {
            channel = i;
            if choice < probability[i] {
                break;
            }
            choice -= probability[i];
        }
    }
    let rate = f64::from(sigma[channel]);
    let distance = f64::from(distance.max(0.0));
    let t = if rate > 0.0 { -libm::log(1.0 - rng.random::<f64>()) / rate } else { f64::INFINITY };
    if t < distance {
        let transmittance = exp_neg(optical_depth(sigma, t));
        let density = probability.dot(sigma.as_dvec3() * transmittance);
        DistanceSample {
            scattering_distance: Some(t as f32),
            weight: zero_unsampled_channels(medium.scattering.as_dvec3() * transmittance / density, probability),
        }
    } else {
        let transmittance = exp_neg(optical_depth(sigma, distance));
        DistanceSample {
            scattering_distance: None,
            weight: zero_unsampled_channels(transmittance / probability.dot(transmittance), probability),
        }
    }
}

/// Pdf \[1/length] of scattering at distance `t`: the mean of the channels' pdfs, weighted by the
/// channels' throughputs.
pub(super) fn distance_pdf(sigma: Rgb, t: f32, throughput: Rgb) -> f32 {
    if t < 0.0 {
        return 0.0;
    }
    channel_probabilities(throughput).dot(sigma.as_dvec3() * exp_neg(optical_depth(sigma, f64::from(t)))) as f32
}

/// Radiance \[W/(m² sr)] that reaches a ray's origin from the medium's emission along the distance
/// d = `distance` \[length].
///
/// With emission ε and extinction σ, the radiance is ∫ ε exp(−σt) dt = ε(1 − exp(−σd))/σ.
pub(super) fn emitted_radiance(medium: &Medium, distance: f32) -> Rgb {
    let sigma = medium.extinction();
    let distance = f64::from(distance.max(0.0));
    let channel = |i: usize| {
        let (emission, rate) = (f64::from(medium.emission[i]), f64::from(sigma[i]));
        if emission == 0.0 {
            0.0
        } else if rate == 0.0 {
            emission * distance
        } else {
            -emission * libm::expm1(-rate * distance) / rate
        }
    };
    DVec3::from_array(std::array::from_fn(channel)).as_vec3()
}
