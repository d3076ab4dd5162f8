//! Photon mapping with two maps of fixed radii (Jensen 2001, chapter 9).
//!
//! At the first receiver: direct light by shadow rays, light focused by casters from the caustic map, and light that was
//! scattered before either from the global map itself (*direct visualisation*) or by one more ray, at whose end the map is
//! looked at (*final gathering*), which hides the map's blur and its seams at edges.

use super::FinalGathering;
use super::direct::Asking;
use super::guide::GUIDES;
use super::maps::{Maps, Needs, Schedule};
use super::method::{AtReceiver, History, Method, Passage, Vertex};
use super::prepared::{Strategy, Walks};
use super::tiles::Worker;
use crate::bsdf::{BsdfSample, Transport};
use crate::color::Rgb;
use crate::photon::{Bandwidth, Kernel, StoreMask};
use crate::plan::{Effect, Effects};
use crate::sampling::Dimension;
use crate::scene::Interior;
use glam::Vec3;
use rand::rngs::SmallRng;
use std::cell::RefCell;

/// A gather ray shorter than so many radii of the global map ends where the map knows no more than where it began: the walk goes
/// on.
const SHORT: f32 = 2.0;

/// How far guides may be, in lengths of the shortest gather ray that ends.
const GUIDED_WITHIN: f32 = 4.0;

/// Photon mapping.
#[derive(Debug)]
pub(super) struct PhotonMapping {
    pub gathering: FinalGathering,
}

impl Strategy for PhotonMapping {
    fn samples(&self) -> u32 {
        match self.gathering {
            FinalGathering::None => 1,
            // One gather ray each.
            FinalGathering::Bsdf | FinalGathering::Importance => 4,
        }
    }

    fn asking(&self) -> Asking {
        match self.gathering {
            FinalGathering::None => Asking::Sampled(4),
            FinalGathering::Bsdf | FinalGathering::Importance => Asking::Walk,
        }
    }

    fn needs(&self, effects: Effects) -> Needs {
        let global = match self.gathering {
            _ if !effects.has(Effect::Gathering) => StoreMask::GLOBAL,
            FinalGathering::None => StoreMask::GLOBAL,
            // A gather ray sees direct light too.
            FinalGathering::Bsdf | FinalGathering::Importance => StoreMask { caustic: false, ..StoreMask::ALL },
        };
        let guides = self.gathering == FinalGathering::Importance && effects.has(Effect::Gathering);
        Needs { caustic: true, global, guides, schedule: Schedule::Fixed, ..Needs::NOTHING }
    }

    fn walk(&self, walks: Walks<'_>, maps: &Maps<'_>) {
        let gathers = walks.effects.has(Effect::Gathering) && walks.effects.has(Effect::Interreflection);
        let guided = match self.gathering {
            _ if !gathers => return walks.by(&Seen { maps, repeats: false }),
            FinalGathering::None => return walks.by(&Seen { maps, repeats: false }),
            FinalGathering::Bsdf => false,
            FinalGathering::Importance => true,
        };
        walks.by(&Gathered { maps, guided, short: SHORT * maps.smooth.radius() });
    }
}

/// Both maps seen at the first receiver.
pub(super) struct Seen<'a> {
    pub maps: &'a Maps<'a>,
    /// Whether all passes share their camera walks.
    pub repeats: bool,
}

impl Method for Seen<'_> {
    fn at_receiver<I: Interior>(&self, _: &Vertex<'_, I>) -> AtReceiver {
        AtReceiver { direct: true, onward: false }
    }

    fn estimates(&self) -> bool {
        true
    }

    #[inline]
    fn photons<I: Interior>(&self, vertex: &Vertex<'_, I>, worker: &mut Worker) -> Rgb {
        self.maps.radiance(vertex, 1, worker)
    }

    fn volume<I: Interior>(&self, passage: &Passage<'_, I>, rng: &mut SmallRng, worker: &mut Worker) -> Rgb {
        self.maps.volume(passage, 1, rng, worker)
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }

    fn repeats_walks(&self) -> bool {
        self.repeats
    }
}

/// The global map seen through a gather ray.
struct Gathered<'a> {
    maps: &'a Maps<'a>,
    /// Whether gather rays follow photons.
    guided: bool,
    short: f32,
}

impl Gathered<'_> {
    /// Whether the map is looked at here.
    #[inline]
    fn ends_at<I: Interior>(&self, vertex: &Vertex<'_, I>) -> bool {
        vertex.history.receivers > 0 && vertex.distance > self.short
    }
}

impl Method for Gathered<'_> {
    fn at_receiver<I: Interior>(&self, vertex: &Vertex<'_, I>) -> AtReceiver {
        let goes_on = !self.ends_at(vertex);
        AtReceiver { direct: goes_on, onward: goes_on }
    }

    fn estimates(&self) -> bool {
        true
    }

    fn prepare<I: Interior>(&self, vertex: &Vertex<'_, I>, worker: &mut Worker) {
        if !self.guided {
            return;
        }
        let surface = vertex.surface;
        let Worker { guide, guides, .. } = worker;
        guide.clear();
        let guide = RefCell::new(guide);
        let around = Bandwidth { radius: self.short * GUIDED_WITHIN, k: GUIDES };
        let (p, normal) = (surface.point.p, surface.facing_normal());
        let _ = self.maps.guides.estimate(p, normal, around, Kernel::Cone, guides, |flux| {
            guide.borrow_mut().push(flux.from());
            Rgb::ZERO
        });
    }

    fn sample<I: Interior>(&self, vertex: &Vertex<'_, I>, worker: &mut Worker) -> Option<BsdfSample> {
        let surface = vertex.surface;
        let (lobe, u) = (vertex.draw.get_1d(Dimension::BsdfLobe), vertex.draw.get_2d(Dimension::BsdfDirection));
        // Casters are not guided, and have no say in what guided the last receiver.
        if !self.guided || !surface.bsdf.stores_photons() {
            return surface.sample(lobe, u, Transport::Radiance);
        }
        if lobe >= 0.5 {
            let mut sample = surface.sample(2.0 * lobe - 1.0, u, Transport::Radiance)?;
            let mixed = self.pdf(vertex, sample.wi, worker);
            sample.weight *= sample.pdf / mixed;
            sample.pdf = mixed;
            return Some(sample);
        }
        let Some(wi) = worker.guide.sample(2.0 * lobe, u) else {
            return surface.sample(2.0 * lobe, u, Transport::Radiance);
        };
        let reflected = surface.scatter(wi);
        let pdf = self.pdf(vertex, wi, worker);
        (reflected != Rgb::ZERO && pdf > 0.0).then_some(BsdfSample {
            wi,
            weight: reflected / pdf,
            pdf,
            specular: false,
            transmitted: false,
            flat: false,
        })
    }

    fn pdf<I: Interior>(&self, vertex: &Vertex<'_, I>, wi: Vec3, worker: &mut Worker) -> f32 {
        let bsdf = vertex.surface.pdf(wi);
        match worker.guide.pdf(wi) {
            Some(guide) if self.guided && vertex.surface.bsdf.stores_photons() => 0.5 * (bsdf + guide),
            _ => bsdf,
        }
    }

    fn photons<I: Interior>(&self, vertex: &Vertex<'_, I>, worker: &mut Worker) -> Rgb {
        if self.ends_at(vertex) { self.maps.radiance(vertex, 1, worker) } else { self.maps.caustic(vertex, 1, worker) }
    }

    fn volume<I: Interior>(&self, passage: &Passage<'_, I>, rng: &mut SmallRng, worker: &mut Worker) -> Rgb {
        self.maps.volume(passage, 1, rng, worker)
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }
}
