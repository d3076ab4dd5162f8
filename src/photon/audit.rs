//! Where flux goes.

use crate::color::Rgb;
use glam::DVec3;
use std::ops::AddAssign;

/// Where the emitted flux went \[W]. Emitted = absorbed + escaped + stopped + roulette, to rounding; the mean of `roulette` is
/// zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Audit {
    /// Flux that left the lights.
    pub emitted: [f64; 3],
    /// Flux taken up by surfaces and bodies.
    pub absorbed: [f64; 3],
    /// Flux that left the scene.
    pub escaped: [f64; 3],
    /// Flux of paths cut by the bounce limit, or ended because what would follow is not wanted.
    pub stopped: [f64; 3],
    /// Flux removed by Russian roulette less flux it added.
    pub roulette: [f64; 3],
}

impl AddAssign for Audit {
    fn add_assign(&mut self, other: Self) {
        let pairs = [
            (&mut self.emitted, other.emitted),
            (&mut self.absorbed, other.absorbed),
            (&mut self.escaped, other.escaped),
            (&mut self.stopped, other.stopped),
            (&mut self.roulette, other.roulette),
        ];
        for (mine, theirs) in pairs {
            *mine = (DVec3::from(*mine) + DVec3::from(theirs)).to_array();
        }
    }
}

pub(super) fn book(account: &mut [f64; 3], flux: Rgb) {
    *account = (DVec3::from(*account) + flux.as_dvec3()).to_array();
}
