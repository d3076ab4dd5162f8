//! Energy audit of photon tracing: sums of the flux that photon paths emit and lose.

use crate::color::Rgb;
use glam::DVec3;
use std::ops::AddAssign;

/// Sums of the flux \[W] that the paths of a photon pass emit and lose, for each RGB channel.
///
/// Energy is conserved: `emitted` = `absorbed` + `escaped` + `stopped` + `net_roulette_loss`, up to
/// rounding. The expected value of `net_roulette_loss` is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct EnergyAudit {
    /// Flux emitted by the lights \[W].
    pub emitted: [f64; 3],
    /// Flux absorbed by surfaces and media \[W].
    pub absorbed: [f64; 3],
    /// Flux that escaped from the scene \[W].
    pub escaped: [f64; 3],
    /// Flux \[W] of photon paths that were ended early: at the bounce limit, or because no further
    /// photon of the path would be stored.
    pub stopped: [f64; 3],
    /// Net flux \[W] that Russian roulette removed: the flux of the ended paths, minus the flux
    /// that the continued paths gained.
    #[serde(rename = "roulette")]
    pub net_roulette_loss: [f64; 3],
}

impl AddAssign for EnergyAudit {
    fn add_assign(&mut self, other: Self) {
        let pairs = [
            (&mut self.emitted, other.emitted),
            (&mut self.absorbed, other.absorbed),
            (&mut self.escaped, other.escaped),
            (&mut self.stopped, other.stopped),
            (&mut self.net_roulette_loss, other.net_roulette_loss),
        ];
        for (mine, theirs) in pairs {
            *mine = (DVec3::from(*mine) + DVec3::from(theirs)).to_array();
        }
    }
}

/// Adds `flux` \[W] to `account`, one of the per-channel sums of an [`EnergyAudit`].
pub(super) fn add_flux(account: &mut [f64; 3], flux: Rgb) {
    *account = (DVec3::from(*account) + flux.as_dvec3()).to_array();
}
