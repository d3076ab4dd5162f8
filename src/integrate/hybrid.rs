//! Path tracing for every path that connections find, photons for exactly the rest.
//!
//! A light's path that begins with casters and then meets a receiver is found by photons, at the first receiver of the camera
//! walk: from the caustic map where that receiver is the first on the light's path, from a map of what caustics become where
//! it is a later one. All other paths are found by the walk itself, by shadow rays and by chance, weighted against each other.

use super::direct::Asking;
use super::maps::{Maps, Needs};
use super::method::{AtReceiver, History, Method, Passage, Vertex};
use super::prepared::{Strategy, Walks};
use super::tiles::Worker;
use crate::color::Rgb;
use crate::plan::{Effect, Effects};
use crate::scene::Interior;
use rand::rngs::SmallRng;

/// Path tracing with a caustic map.
#[derive(Debug)]
pub(super) struct Hybrid;

impl Strategy for Hybrid {
    fn samples(&self) -> u32 {
        8
    }

    /// One estimate a pixel and pass: those of its other samples would rest on the same photons.
    fn estimates_each_sample(&self) -> bool {
        false
    }

    fn asking(&self) -> Asking {
        Asking::Walk
    }

    fn needs(&self, _: Effects) -> Needs {
        Needs { caustic: true, after_caustic: true, ..Needs::NOTHING }
    }

    fn walk(&self, walks: Walks<'_>, maps: &Maps<'_>) {
        let onward = walks.effects.has(Effect::Interreflection);
        walks.by(&Connected { maps, onward });
    }
}

struct Connected<'a> {
    maps: &'a Maps<'a>,
    /// Whether receivers light each other.
    onward: bool,
}

impl Method for Connected<'_> {
    fn at_receiver<I: Interior>(&self, _: &Vertex<'_, I>) -> AtReceiver {
        AtReceiver { direct: true, onward: self.onward }
    }

    fn estimates(&self) -> bool {
        true
    }

    #[inline]
    fn photons<I: Interior>(&self, vertex: &Vertex<'_, I>, worker: &mut Worker) -> Rgb {
        match vertex.draw.place() {
            (0, count) if vertex.history.receivers == 0 => self.maps.radiance(vertex, count, worker),
            _ => Rgb::ZERO,
        }
    }

    fn volume<I: Interior>(&self, passage: &Passage<'_, I>, rng: &mut SmallRng, worker: &mut Worker) -> Rgb {
        match passage.draw.place() {
            (0, count) if passage.history.receivers == 0 => self.maps.volume(passage, count, rng, worker),
            _ => Rgb::ZERO,
        }
    }

    fn in_medium(&self, _: History) -> AtReceiver {
        AtReceiver { direct: true, onward: self.onward }
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }
}
