//! Media whose density varies, by tentative collisions.
//!
//! Collisions are drawn at the rate of a local majorant; at each, what is missing to the majorant is taken for a null collision
//! (Woodcock 1965). Absorption is weighed, never drawn.

use super::grid_density::{GridDensity, Line};
use super::{DistanceSample, Medium, TransmittanceCurve, shares, weight};
use crate::color::Rgb;
use crate::math::Ray;
use glam::DVec3;
use rand::{Rng, RngExt};

/// Below this part of where it began a walk is ended by chance.
const FAINT: f64 = 0.1;

/// Tentative collisions after which a walk goes on with probability ½, so that a majorant however high does not hold it.
const PATIENCE: u32 = 1 << 14;

/// The mean number of tentative collisions along a way, at least, where emission is looked for.
const LOOKS: f64 = 4.0;

/// The mean number of tentative collisions along a way, at least, where what is left is wanted all along it.
const FINE: f64 = 16.0;

/// A tentative collision.
struct Collision {
    t: f64,
    /// The density of the medium there, over the rate of collisions per unit of the coefficients.
    density: f64,
}

/// Whether a walk is over.
enum Step {
    On,
    End,
}

/// Visits tentative collisions at `rate` times the local majorant until `visit` says to end; whether it did not.
fn track<R: Rng>(line: &Line, rate: f64, rng: &mut R, mut visit: impl FnMut(Collision, &mut R) -> Step) -> bool {
    // The depth to the next collision; what a block does not use up is carried into the next one.
    let mut depth = exponential(rng);
    for (start, stop, majorant) in line.blocks() {
        let mut t = start;
        loop {
            let step = depth / (rate * majorant);
            if step >= stop - t {
                depth -= (stop - t) * (rate * majorant);
                break;
            }
            t += step;
            // Interpolation rounds; the majorant does not.
            let density = line.density(t).min(majorant) / (rate * majorant);
            if matches!(visit(Collision { t, density }, rng), Step::End) {
                return false;
            }
            depth = exponential(rng);
        }
    }
    true
}

fn exponential(rng: &mut impl Rng) -> f64 {
    -libm::log(1.0 - rng.random::<f64>())
}

/// Russian roulette by what is left of 1: `None` ends the walk, else what its weight is multiplied by.
fn roulette(left: f64, steps: u32, rng: &mut impl Rng) -> Option<f64> {
    let faint = if left < FAINT { left / FAINT } else { 1.0 };
    let stay = if steps.is_multiple_of(PATIENCE) { 0.5 * faint } else { faint };
    if stay >= 1.0 { Some(1.0) } else { (rng.random::<f64>() < stay).then(|| 1.0 / stay) }
}

/// Ratio tracking: the product over all collisions of the probability that they are null.
pub(super) fn transmittance(medium: &Medium, field: &GridDensity, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
    let sigma = medium.extinction().as_dvec3();
    let rate = sigma.max_element();
    if rate <= 0.0 {
        return Rgb::ONE;
    }
    let (mut left, mut steps) = (DVec3::ONE, 0u32);
    let through = track(&field.along(ray, distance), rate, rng, |collision, rng| {
        left *= DVec3::ONE - sigma * collision.density;
        decay(&mut left, &mut steps, rng)
    });
    if through { left.as_vec3() } else { Rgb::ZERO }
}

/// Ratio tracking that keeps what is left after each collision, in order, for all distances up to `distance` at once.
pub(super) fn fade(
    medium: &Medium,
    field: &GridDensity,
    ray: &Ray,
    distance: f32,
    rng: &mut impl Rng,
    fade: &mut TransmittanceCurve,
) {
    let sigma = medium.extinction().as_dvec3();
    let line = field.along(ray, distance);
    let depth: f64 = line.blocks().map(|(start, stop, majorant)| (stop - start) * majorant).sum();
    if sigma == DVec3::ZERO || depth <= 0.0 {
        return;
    }
    // More collisions take less away each: a smoother curve.
    let rate = sigma.max_element().max(FINE / depth);
    let (mut left, mut steps) = (DVec3::ONE, 0u32);
    let through = track(&line, rate, rng, |collision, rng| {
        left *= DVec3::ONE - sigma * collision.density;
        let step = decay(&mut left, &mut steps, rng);
        fade.steps.push((collision.t as f32, left.as_vec3()));
        step
    });
    if !through && let Some((_, left)) = fade.steps.last_mut() {
        *left = Rgb::ZERO;
    }
}

/// Ends a walk of which too little is left.
fn decay(left: &mut DVec3, steps: &mut u32, rng: &mut impl Rng) -> Step {
    *left = left.max(DVec3::ZERO);
    *steps = steps.wrapping_add(1);
    match roulette(left.max_element(), *steps, rng) {
        Some(gain) => {
            *left *= gain;
            Step::On
        }
        None => Step::End,
    }
}

/// Spectral tracking (Kutz, Habel, Li, Novák 2017, section 4.3): a collision scatters or is null in proportion to what the walk
/// would carry on in each case, over all channels; so the mean over channels never grows.
pub(super) fn distance_sample(
    medium: &Medium,
    field: &GridDensity,
    ray: &Ray,
    distance: f32,
    throughput: Rgb,
    rng: &mut impl Rng,
) -> DistanceSample {
    let share = shares(throughput);
    let alive = share.cmpgt(DVec3::ZERO);
    let sigma = DVec3::select(alive, medium.extinction().as_dvec3(), DVec3::ZERO);
    let scattering = DVec3::select(alive, medium.scattering.as_dvec3(), DVec3::ZERO);
    let rate = sigma.max_element();
    let (mut left, mut steps, mut scattered) = (DVec3::ONE, 0u32, None);
    let through = rate <= 0.0
        || track(&field.along(ray, distance), rate, rng, |collision, rng| {
            let real = left * scattering * collision.density;
            let null = left * (DVec3::ONE - sigma * collision.density).max(DVec3::ZERO);
            let (a, b) = (share.dot(real), share.dot(null));
            if a + b <= 0.0 {
                return Step::End;
            }
            let probability = a / (a + b);
            if rng.random::<f64>() < probability {
                left = real / probability;
                scattered = Some(collision.t as f32);
                return Step::End;
            }
            left = null / (1.0 - probability);
            steps = steps.wrapping_add(1);
            match roulette(share.dot(left), steps, rng) {
                Some(gain) => {
                    left *= gain;
                    Step::On
                }
                None => Step::End,
            }
        });
    let lost = !through && scattered.is_none();
    DistanceSample { scattered, weight: if lost { Rgb::ZERO } else { weight(left, share) } }
}

/// What every tentative collision finds emitted, through what the ones before it left.
pub(super) fn emitted(medium: &Medium, field: &GridDensity, ray: &Ray, distance: f32, rng: &mut impl Rng) -> Rgb {
    let (sigma, emission) = (medium.extinction().as_dvec3(), medium.emission.as_dvec3());
    let line = field.along(ray, distance);
    let depth: f64 = line.blocks().map(|(start, stop, majorant)| (stop - start) * majorant).sum();
    if depth <= 0.0 {
        return Rgb::ZERO;
    }
    // A thin flame is looked at as often as a dense one.
    let rate = sigma.max_element().max(LOOKS / depth);
    let (mut sum, mut left, mut steps) = (DVec3::ZERO, DVec3::ONE, 0u32);
    track(&line, rate, rng, |collision, rng| {
        sum += left * emission * collision.density;
        left *= DVec3::ONE - sigma * collision.density;
        decay(&mut left, &mut steps, rng)
    });
    sum.as_vec3()
}
