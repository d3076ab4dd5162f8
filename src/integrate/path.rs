//! Path tracing: unbiased. At each receiver the lights are asked and the walk goes on; light that both could find is weighted
//! (Veach 1997, chapters 9 and 10).

use super::direct::Asking;
use super::maps::Maps;
use super::method::{AtReceiver, History, Method, Vertex};
use super::prepared::{Strategy, Walks};
use crate::plan::Effect;
use crate::scene::Interior;

/// Path tracing.
#[derive(Debug)]
pub(super) struct PathTracing;

impl Strategy for PathTracing {
    fn samples(&self) -> u32 {
        4
    }

    fn asking(&self) -> Asking {
        Asking::Walk
    }

    fn walk(&self, walks: Walks<'_>, _: &Maps<'_>) {
        let onward = walks.effects.has(Effect::Interreflection);
        let caustics = walks.effects.has(Effect::Caustics);
        walks.by(&Everywhere { onward, caustics });
    }
}

struct Everywhere {
    /// Whether receivers light each other.
    onward: bool,
    caustics: bool,
}

impl Method for Everywhere {
    fn at_receiver<I: Interior>(&self, _: &Vertex<'_, I>) -> AtReceiver {
        AtReceiver { direct: true, onward: self.onward }
    }

    fn in_medium(&self, _: History) -> AtReceiver {
        AtReceiver { direct: true, onward: self.onward }
    }

    fn counts(&self, history: History) -> bool {
        self.caustics || !history.is_caustic()
    }
}
