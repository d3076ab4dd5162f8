//! Settings with the work of a pass fixed by a pilot.

use crate::integrate::{Algorithm, Settings};
use crate::scene::Scene;

/// Settings with the numbers of rays and photons that a pilot of the whole picture finds, so that
/// pictures with fewer effects use the same numbers.
pub(super) fn balanced(scene: &Scene, algorithm: Algorithm, settings: &Settings) -> Settings {
    let mut balanced = Settings { balance: false, ..settings.clone() };
    if settings.balance
        && let Some(balance) = algorithm.prepare(scene, settings.clone()).balance()
    {
        balanced.camera_paths.samples = Some(balance.samples);
        balanced.photons = balance.photons.unwrap_or(balanced.photons);
        balanced.caustic_photons = balance.caustic_photons.unwrap_or(balanced.caustic_photons);
    }
    balanced
}
