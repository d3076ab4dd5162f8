//! Progressive photon mapping (Hachisuka, Ogaki and Jensen 2008): hit points that stay, passes of photons with radii that shrink.
//!
//! All passes share their camera walks, so that the hit points are the same; radii follow the law of independent passes (Knaus
//! and Zwicker 2011) in place of statistics kept at each hit point, so that any pass can be computed alone. What the camera
//! samples once, such as the edge of an object within a pixel, more passes do not refine.

use super::direct::Asking;
use super::maps::{Maps, Needs};
use super::pm::Seen;
use super::prepared::{Strategy, Walks};
use crate::photon::StoreMask;
use crate::plan::Effects;

/// Progressive photon mapping.
#[derive(Debug)]
pub(super) struct Ppm;

impl Strategy for Ppm {
    /// All that the picture will ever have.
    fn samples(&self) -> u32 {
        4
    }

    /// Its camera rays are not drawn anew.
    fn can_be_balanced(&self) -> bool {
        false
    }

    fn asking(&self) -> Asking {
        Asking::Sampled(1)
    }

    fn needs(&self, _: Effects) -> Needs {
        Needs { caustic: true, global: StoreMask::GLOBAL, ..Needs::NOTHING }
    }

    fn walk(&self, walks: Walks<'_>, maps: &Maps<'_>) {
        walks.by(&Seen { maps, repeats: true });
    }
}
