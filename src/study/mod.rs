//! Studies of a scene: cost and contribution of effects, and convergence of methods.

mod effects;
pub mod methods;
pub mod report;
#[cfg(test)]
mod tests;
mod work;

pub use effects::{Clock, Cost, EffectStudy, Finding, Findings, Gain, Spent, StudyError};
pub use report::effects::{About, page};
pub use report::text;
pub use work::{ExpectedWork, Work, expected_work};

use crate::integrate::{Algorithm, Settings};
use crate::scene::Scene;

/// Settings with the numbers of rays and photons that a pilot of the whole picture finds, so that
/// pictures with fewer effects use the same numbers.
fn settled(scene: &Scene, algorithm: Algorithm, settings: &Settings) -> Settings {
    let mut settled = Settings { balance: false, ..settings.clone() };
    if settings.balance
        && let Some(balance) = algorithm.prepare(scene, settings.clone()).balance()
    {
        settled.eye.samples = Some(balance.samples);
        settled.photons = balance.photons.unwrap_or(settled.photons);
        settled.caustic_photons = balance.caustic_photons.unwrap_or(settled.caustic_photons);
    }
    settled
}
