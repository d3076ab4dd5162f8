//! Path tracing: unbiased. At each receiver the lights are asked and the walk goes on; light that both could find is weighted
//! (Veach 1997, chapters 9 and 10).

use super::direct::Asking;
use super::eye::{AtReceiver, History, Method, Vertex};
use super::maps::Maps;
use super::prepared::{Strategy, Walks};

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
        walks.by(&Everywhere);
    }
}

struct Everywhere;

impl Method for Everywhere {
    fn at_receiver(&self, _: &Vertex<'_>) -> AtReceiver {
        AtReceiver { direct: true, onward: true }
    }

    fn counts(&self, _: History) -> bool {
        true
    }
}
