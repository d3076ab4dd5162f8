//! Stochastic progressive photon mapping (Hachisuka and Jensen 2009) by independent passes (Knaus and Zwicker 2011): new photons
//! and new camera walks in each, with radii that shrink.

use super::direct::Asking;
use super::maps::{Maps, Needs};
use super::pm::Seen;
use super::prepared::{Strategy, Walks};
use crate::photon::StoreMask;
use crate::plan::Effects;

/// Stochastic progressive photon mapping.
#[derive(Debug)]
pub(super) struct Sppm;

impl Strategy for Sppm {
    fn samples(&self) -> u32 {
        1
    }

    fn asking(&self) -> Asking {
        Asking::Sampled(4)
    }

    fn needs(&self, _: Effects) -> Needs {
        Needs { caustic: true, global: StoreMask::GLOBAL, ..Needs::NOTHING }
    }

    fn walk(&self, walks: Walks<'_>, maps: &Maps<'_>) {
        walks.by(&Seen { maps, repeats: false });
    }
}
