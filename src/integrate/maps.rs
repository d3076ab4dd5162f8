//! The photon maps of a pass.

use super::gauged::DiscSum;
use super::method::{Passage, Vertex};
use super::tiles::Worker;
use super::volume::{VolumeMap, shared};
use crate::bsdf::Transport;
use crate::color::Rgb;
use crate::photon::{
    Bandwidth, Kernel, NestedEstimate, PhotonData, PhotonMap, Scratch, StoreMask, coverage, nested_coverage,
};
use crate::plan::{Effect, Effects};
use crate::scene::{Interior, Scene};
use rand::Rng;

/// How radii go from pass to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Schedule {
    /// They shrink, so that bias goes away.
    Shrinking,
    /// They stay.
    Fixed,
}

/// Which maps an algorithm looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Needs {
    /// The caustic map.
    pub caustic: bool,
    /// A map of what caustics become, from the paths of the caustic map.
    pub after_caustic: bool,
    /// The classes of the global map.
    pub global: StoreMask,
    /// Photons whose directions guide gather rays.
    pub guides: bool,
    /// The radii of all.
    pub schedule: Schedule,
}

impl Needs {
    /// No map.
    pub const NOTHING: Self = Self {
        caustic: false,
        after_caustic: false,
        global: StoreMask::NONE,
        guides: false,
        schedule: Schedule::Shrinking,
    };

    /// What is left of them where only these effects are simulated.
    pub fn within(self, effects: Effects) -> Self {
        let bounces = effects.has(Effect::CausticBounces);
        let interreflection = effects.has(Effect::Interreflection);
        let global = StoreMask {
            direct: self.global.direct && interreflection,
            after_caustic: self.global.after_caustic && bounces,
            global: self.global.global && interreflection,
            ..self.global
        };
        Self {
            caustic: self.caustic && effects.has(Effect::Caustics),
            after_caustic: self.after_caustic && bounces,
            global,
            guides: self.guides && interreflection,
            ..self
        }
    }

    /// What is wanted of the paths of the caustic map.
    pub fn by_casters(self) -> StoreMask {
        StoreMask {
            caustic: self.caustic,
            after_caustic: self.after_caustic,
            apart: self.after_caustic,
            ..StoreMask::NONE
        }
    }
}

/// A map with the width of its estimates.
pub(super) struct PhotonEstimator<'a> {
    pub scene: &'a Scene,
    pub map: PhotonMap,
    pub bandwidth: Bandwidth,
    pub kernel: Kernel,
    /// The same light in media.
    pub volume: VolumeMap,
}

/// The maps of one pass.
pub(super) struct Maps<'a> {
    pub caustic: PhotonEstimator<'a>,
    /// The global map, or that of what caustics become.
    pub smooth: PhotonEstimator<'a>,
    /// Scattered light by few photons, whose directions guide gather rays.
    pub guides: PhotonMap,
}

impl Maps<'_> {
    /// Radiance that the surface of `vertex` sends to its viewer of the light in both maps, which counts `times` times.
    #[inline]
    pub fn radiance<I: Interior>(&self, vertex: &Vertex<'_, I>, times: u32, worker: &mut Worker) -> Rgb {
        let caustic = self.caustic(vertex, times, worker);
        let smooth = self.smooth.radiance(vertex, times, |w| (&mut w.smooth, &mut w.tally.global), worker);
        (caustic + smooth) * times as f32
    }

    /// The same of the caustic map alone, not multiplied.
    #[inline]
    pub fn caustic<I: Interior>(&self, vertex: &Vertex<'_, I>, times: u32, worker: &mut Worker) -> Rgb {
        self.caustic.radiance(vertex, times, |w| (&mut w.caustic, &mut w.tally.caustic), worker)
    }

    /// Radiance that a stretch of a medium sends to its start of the light in both maps, which counts `times` times.
    #[inline]
    pub fn volume<I: Interior>(
        &self,
        passage: &Passage<'_, I>,
        times: u32,
        rng: &mut impl Rng,
        worker: &mut Worker,
    ) -> Rgb {
        let caustic = self.caustic.volume.radiance(passage, times, rng, worker);
        (caustic + self.smooth.volume.radiance(passage, times, rng, worker)) * times as f32
    }
}

impl PhotonEstimator<'_> {
    /// Largest radius of an estimate \[length].
    pub fn radius(&self) -> f32 {
        self.bandwidth.radius
    }

    /// What the surface of `vertex` sends to its viewer of the light in the map; it will count `times` times.
    #[inline]
    fn radiance<I: Interior>(
        &self,
        vertex: &Vertex<'_, I>,
        times: u32,
        own: fn(&mut Worker) -> (&mut Scratch, &mut DiscSum),
        worker: &mut Worker,
    ) -> Rgb {
        if self.map.is_empty() {
            return Rgb::ZERO;
        }
        worker.counters.gathers += 1;
        let surface = vertex.surface;
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        let wavelength = vertex.inside.wavelength();
        let brdf = |flux: &PhotonData| {
            let brdf = surface.bsdf.evaluate(surface.wo, flux.from(), ns, ns, Transport::Radiance);
            if I::IMMERSED { brdf * shared(wavelength, flux.wavelength(), self.volume.band) } else { brdf }
        };
        let (p, normal) = (surface.point.p, surface.facing_normal());
        let (bandwidth, kernel, key) = (self.bandwidth, self.kernel, vertex.draw.key());
        let gauge = worker.gauge;
        let (scratch, discs) = own(worker);
        if !gauge {
            let found = self.map.estimate(p, normal, bandwidth, kernel, scratch, brdf);
            worker.counters.gathered_photons += u64::from(found.count);
            if found.count == 0 {
                return Rgb::ZERO;
            }
            return found.radiance / coverage(self.scene, p, normal, found.radius, kernel, key);
        }
        let NestedEstimate { whole, mut radiance } =
            self.map.estimate_nested(p, normal, bandwidth, kernel, scratch, brdf);
        discs.add(whole.radius, whole.count);
        worker.counters.gathered_photons += u64::from(whole.count);
        if whole.count == 0 {
            return Rgb::ZERO;
        }
        let covered = coverage(self.scene, p, normal, whole.radius, kernel, key);
        let found = whole.radiance / covered;
        if covered != 1.0 {
            // Probes of the pass's own, also where passes share their walks: what chance these have is not blur.
            let key = vertex.shadow_draw.key();
            let levels = nested_coverage(self.scene, p, normal, whole.radius, kernel, key);
            radiance.iter_mut().zip(levels).for_each(|(radiance, covered)| *radiance /= covered);
        }
        worker.tally.note(vertex.throughput * times as f32, radiance);
        found
    }
}
