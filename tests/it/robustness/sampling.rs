//! Sampling in extreme cases: extreme random numbers in every warp, pdfs near zero, roulette at
//! probabilities 0 and 1, and narrow lobes.

mod bsdfs;
mod choices;
mod ends;
mod roulette;

use glam::Vec2;

/// Extreme random numbers in \[0, 1).
///
/// They are 0, the smallest positive number, the middle and the number below it, and the largest
/// number below 1.
const ENDS: [f32; 5] = [0.0, 1.0 / 16_777_216.0, 0.5, 0.5 - f32::EPSILON / 4.0, 1.0 - f32::EPSILON / 2.0];

/// Returns all pairs of [`ENDS`].
fn corners() -> impl Iterator<Item = Vec2> {
    ENDS.into_iter().flat_map(|x| ENDS.map(|y| Vec2::new(x, y)))
}
