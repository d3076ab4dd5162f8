//! Ends of the unit interval through every warp, densities near zero, roulette at its ends, lobes at theirs.

mod bsdfs;
mod choices;
mod ends;
mod roulette;

use glam::Vec2;

/// The largest number below 1, the least above 0 that is drawn, and both sides of the middle.
const ENDS: [f32; 5] = [0.0, 1.0 / 16_777_216.0, 0.5, 0.5 - f32::EPSILON / 4.0, 1.0 - f32::EPSILON / 2.0];

/// All pairs of [`ENDS`].
fn corners() -> impl Iterator<Item = Vec2> {
    ENDS.into_iter().flat_map(|x| ENDS.map(|y| Vec2::new(x, y)))
}
