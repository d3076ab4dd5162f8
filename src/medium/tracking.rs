//! Null-collision methods for heterogeneous media.
//!
//! Tentative collisions are sampled as if the extinction in each block of the density grid were
//! constant and equal to its majorant, an upper bound of the extinction in the block. Each
//! tentative collision is real or null (Woodcock 1965). Absorption does not end a path but reduces
//! its weight.

use super::grid_density::{GridDensity, GridRay};
use super::{DistanceSample, Medium, TransmittanceCurve, channel_probabilities, zero_unsampled_channels};
use crate::color::Rgb;
use crate::math::Ray;
use glam::DVec3;
use rand::{Rng, RngExt};

/// Path weight below which Russian roulette may end the tracking of collisions.
const ROULETTE_THRESHOLD: f64 = 0.1;

/// Number of tentative collisions from one unconditional roulette to the next. This Russian
/// roulette ends tracking with probability ½, at any path weight.
///
/// The roulette bounds the mean time of tracking at high majorants.
const COLLISIONS_PER_ROULETTE: u32 = 1 << 14;

/// Smallest mean number of tentative collisions along a ray, for an estimate of the radiance that a
/// medium emits along this ray.
///
/// In thin media, the collision rate is raised to reach this number, because an estimate from few
/// collisions has a high variance.
const MIN_EMISSION_COLLISIONS: f64 = 4.0;

/// Smallest mean number of tentative collisions along a ray for a [`TransmittanceCurve`].
///
/// In thin media, the collision rate is raised to reach this number, for a smoother curve.
const MIN_CURVE_COLLISIONS: f64 = 16.0;

/// A tentative collision of delta tracking, which may be real or null.
struct TentativeCollision {
    /// Distance along the ray \[length].
    t: f64,
    /// Density of the medium divided by the mean number of tentative collisions per length
    /// \[length].
    ///
    /// The rate of tentative collisions is the sum of the rates of scattering, absorption and null
    /// collisions. The share of scattering is σs·`density_over_rate`, where σs \[1/length] is the
    /// scattering coefficient at density 1. The share of absorption is σa·`density_over_rate`.
    density_over_rate: f64,
}

enum TrackingDecision {
    Continue,
    Stop,
}

/// Samples tentative collisions along `line`, from near to far, and calls `visit` for each.
///
/// Returns true if tracking reached the end of the line, and false if `visit` stopped it.
///
/// The mean number of tentative collisions per length is `rate` \[1/length] times the majorant: the
/// upper bound of the density in the grid block that `line` crosses at this point.
fn track_collisions<R: Rng>(
    line: &GridRay,
    rate: f64,
    rng: &mut R,
    mut visit: impl FnMut(TentativeCollision, &mut R) -> TrackingDecision,
) -> bool {
    // `depth` is the optical depth to the next collision. The part that remains after a block is
    // used in the next block.
    let mut depth = sample_exponential(rng);
    for (start, stop, majorant) in line.majorant_segments() {
        let mut t = start;
        loop {
            let step = depth / (rate * majorant);
            if step >= stop - t {
                depth -= (stop - t) * (rate * majorant);
                break;
            }
            t += step;
            // Interpolated densities may exceed the majorant by rounding, so they are clamped to
            // it.
            let density_over_rate = line.density(t).min(majorant) / (rate * majorant);
            if matches!(visit(TentativeCollision { t, density_over_rate }, rng), TrackingDecision::Stop) {
                return false;
            }
            depth = sample_exponential(rng);
        }
    }
    true
}

/// Samples the exponential distribution with rate 1.
fn sample_exponential(rng: &mut impl Rng) -> f64 {
    -libm::log(1.0 - rng.random::<f64>())
}

/// Plays Russian roulette on a tracked path of weight `weight`, after `steps` tentative collisions.
///
/// Returns the factor by which the caller must multiply the weight, or `None` if tracking ends.
fn russian_roulette(weight: f64, steps: u32, rng: &mut impl Rng) -> Option<f64> {
    let faint = if weight < ROULETTE_THRESHOLD { weight / ROULETTE_THRESHOLD } else { 1.0 };
    let stay = if steps.is_multiple_of(COLLISIONS_PER_ROULETTE) { 0.5 * faint } else { faint };
    if stay >= 1.0 { Some(1.0) } else { (rng.random::<f64>() < stay).then(|| 1.0 / stay) }
}

/// Estimates the transmittance of the first `distance` \[length] of `ray` by ratio tracking: the
/// product of the null-collision probabilities.
pub(super) fn transmittance(medium: &Medium, grid: &GridDensity, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
    let sigma = medium.extinction().as_dvec3();
    let rate = sigma.max_element();
    if rate <= 0.0 {
        return Rgb::ONE;
    }
    let (mut weight, mut steps) = (DVec3::ONE, 0u32);
    let reached_end = track_collisions(&grid.ray_in_grid(ray, distance), rate, rng, |collision, rng| {
        weight *= DVec3::ONE - sigma * collision.density_over_rate;
        transmittance_roulette(&mut weight, &mut steps, rng)
    });
    if reached_end { weight.as_vec3() } else { Rgb::ZERO }
}

/// Estimates the transmittance from the start of `ray` to each distance up to `distance` \[length].
///
/// One run of ratio tracking appends a step to `curve` at each tentative collision.
pub(super) fn sample_transmittance_curve(
    medium: &Medium,
    grid: &GridDensity,
    ray: &Ray,
    distance: f32,
    rng: &mut impl Rng,
    curve: &mut TransmittanceCurve,
) {
    let sigma = medium.extinction().as_dvec3();
    let line = grid.ray_in_grid(ray, distance);
    let depth: f64 = line.majorant_segments().map(|(start, stop, majorant)| (stop - start) * majorant).sum();
    if sigma == DVec3::ZERO || depth <= 0.0 {
        return;
    }
    // A rate above the largest extinction gives more steps, and so a smoother curve.
    let rate = sigma.max_element().max(MIN_CURVE_COLLISIONS / depth);
    let (mut weight, mut steps) = (DVec3::ONE, 0u32);
    let reached_end = track_collisions(&line, rate, rng, |collision, rng| {
        weight *= DVec3::ONE - sigma * collision.density_over_rate;
        let step = transmittance_roulette(&mut weight, &mut steps, rng);
        curve.steps.push((collision.t as f32, weight.as_vec3()));
        step
    });
    if !reached_end && let Some((_, weight)) = curve.steps.last_mut() {
        *weight = Rgb::ZERO;
    }
}

/// Increments the collision count `steps`, plays Russian roulette on the path weight `weight`, and
/// decides whether tracking continues.
///
/// If tracking continues, `weight` is divided by the survival probability.
fn transmittance_roulette(weight: &mut DVec3, steps: &mut u32, rng: &mut impl Rng) -> TrackingDecision {
    *weight = weight.max(DVec3::ZERO);
    *steps = steps.wrapping_add(1);
    match russian_roulette(weight.max_element(), *steps, rng) {
        Some(gain) => {
            *weight *= gain;
            TrackingDecision::Continue
        }
        None => TrackingDecision::Stop,
    }
}

/// Samples a scattering distance by spectral tracking (Kutz, Habel, Li, Novák 2017, section 4.3).
///
/// Each tentative collision scatters or is null. The probability of each of these two events is
/// proportional to the channel mean of the throughput after the event. This mean never increases,
/// except through Russian roulette.
pub(super) fn distance_sample(
    medium: &Medium,
    grid: &GridDensity,
    ray: &Ray,
    distance: f32,
    throughput: Rgb,
    rng: &mut impl Rng,
) -> DistanceSample {
    let probabilities = channel_probabilities(throughput);
    let alive = probabilities.cmpgt(DVec3::ZERO);
    let sigma = DVec3::select(alive, medium.extinction().as_dvec3(), DVec3::ZERO);
    let scattering = DVec3::select(alive, medium.scattering.as_dvec3(), DVec3::ZERO);
    let rate = sigma.max_element();
    let (mut weight, mut steps, mut scattered) = (DVec3::ONE, 0u32, None);
    let reached_end = rate <= 0.0
        || track_collisions(&grid.ray_in_grid(ray, distance), rate, rng, |collision, rng| {
            let real = weight * scattering * collision.density_over_rate;
            let null = weight * (DVec3::ONE - sigma * collision.density_over_rate).max(DVec3::ZERO);
            let (a, b) = (probabilities.dot(real), probabilities.dot(null));
            if a + b <= 0.0 {
                return TrackingDecision::Stop;
            }
            let probability = a / (a + b);
            if rng.random::<f64>() < probability {
                weight = real / probability;
                scattered = Some(collision.t as f32);
                return TrackingDecision::Stop;
            }
            weight = null / (1.0 - probability);
            steps = steps.wrapping_add(1);
            match russian_roulette(probabilities.dot(weight), steps, rng) {
                Some(gain) => {
                    weight *= gain;
                    TrackingDecision::Continue
                }
                None => TrackingDecision::Stop,
            }
        });
    let lost = !reached_end && scattered.is_none();
    DistanceSample {
        scattering_distance: scattered,
        weight: if lost { Rgb::ZERO } else { zero_unsampled_channels(weight, probabilities) },
    }
}

/// Estimates the radiance \[W/(m² sr)] that reaches the origin of `ray` from the emission of
/// `medium` along the first `distance` \[length].
///
/// The estimate is the sum over tentative collisions of transmittance times emission, divided by
/// the collision rate.
pub(super) fn emitted_radiance(
    medium: &Medium,
    grid: &GridDensity,
    ray: &Ray,
    distance: f32,
    rng: &mut impl Rng,
) -> Rgb {
    let (sigma, emission) = (medium.extinction().as_dvec3(), medium.emission.as_dvec3());
    let line = grid.ray_in_grid(ray, distance);
    let depth: f64 = line.majorant_segments().map(|(start, stop, majorant)| (stop - start) * majorant).sum();
    if depth <= 0.0 {
        return Rgb::ZERO;
    }
    // The minimum number of collisions keeps the variance low in thin media.
    let rate = sigma.max_element().max(MIN_EMISSION_COLLISIONS / depth);
    let (mut sum, mut weight, mut steps) = (DVec3::ZERO, DVec3::ONE, 0u32);
    track_collisions(&line, rate, rng, |collision, rng| {
        sum += weight * emission * collision.density_over_rate;
        weight *= DVec3::ONE - sigma * collision.density_over_rate;
        transmittance_roulette(&mut weight, &mut steps, rng)
    });
    sum.as_vec3()
}
