//! What photons brought to media, seen along stretches of camera walks.

use super::method::Passage;
use super::tiles::Worker;
use crate::color::{Rgb, Wavelength};
use crate::medium::{Fade, Medium, transmittance};
use crate::photon::{BeamMap, PointMap, Volume};
use crate::scene::{Interior, Stretch};
use glam::Vec3;
use rand::Rng;

/// How light in media is estimated from photons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeEstimate {
    /// Ways of photons near the ray (Jarosz et al. 2011); in media of varied density, as `BeamRadiance`.
    #[default]
    Beams,
    /// Scattered photons near the ray (Jarosz, Zwicker and Jensen 2008).
    BeamRadiance,
    /// Scattered photons near a point of the ray (Jensen and Christensen 1998).
    Points,
}

impl VolumeEstimate {
    /// Dimensions of the kernel, in homogeneous media and in others.
    pub(super) fn dimensions(self) -> (u32, u32) {
        match self {
            Self::Beams => (1, 2),
            Self::BeamRadiance => (2, 2),
            Self::Points => (3, 3),
        }
    }
}

/// The light in media of one map.
pub(super) struct VolumeMap {
    beams: BeamMap,
    points: PointMap,
    estimate: VolumeEstimate,
    /// Wavelengths so far apart count as one \[nm], on surfaces too.
    pub band: f32,
}

impl VolumeMap {
    /// Indexes what was stored for blurs of these radii: of beams, and of points.
    pub fn build(volume: Volume, (beams, points): (f32, f32), estimate: VolumeEstimate, band: f32) -> Self {
        let Volume { beams: ways, points: places } = volume;
        Self { beams: BeamMap::build(ways, beams), points: PointMap::build(places, points), estimate, band }
    }

    /// Radiance that a stretch sends to its start.
    pub fn radiance<I: Interior>(&self, passage: &Passage<'_, I>, rng: &mut impl Rng, worker: &mut Worker) -> Rgb {
        if self.beams.is_empty() && self.points.is_empty() {
            return Rgb::ZERO;
        }
        worker.counters.gathers += 1;
        let (found, fade) = (&mut worker.counters.gathered_photons, &mut worker.fade);
        let Stretch { ray, medium, .. } = passage.stretch;
        let mut sum = Rgb::ZERO;
        if medium.is_homogeneous() {
            sum += self.by_beams(passage, found);
        }
        if self.points.is_empty() {
            return sum;
        }
        sum + match self.estimate {
            VolumeEstimate::Points => self.at_a_point(passage, rng, found),
            VolumeEstimate::Beams | VolumeEstimate::BeamRadiance => {
                fade.learn(medium, ray, ray.t_max, rng);
                self.along(passage, fade, found)
            }
        }
    }

    fn by_beams<I: Interior>(&self, passage: &Passage<'_, I>, found: &mut u64) -> Rgb {
        let Stretch { ray, medium, index, inside, .. } = passage.stretch;
        let (own, extinction) = (inside.wavelength(), medium.extinction());
        let mut sum = Rgb::ZERO;
        self.beams.visit(ray, |beam, crossing| {
            if beam.medium != *index {
                return;
            }
            *found += 1;
            let left = transmittance(extinction, crossing.t + crossing.s);
            let phase = medium.phase.evaluate(-crossing.cos);
            sum += beam.flux * left * shared(own, beam.wavelength, self.band) * (phase * crossing.weight);
        });
        sum * medium.scattering
    }

    fn along<I: Interior>(&self, passage: &Passage<'_, I>, fade: &Fade, found: &mut u64) -> Rgb {
        let Stretch { ray, medium, index, inside, .. } = passage.stretch;
        let own = inside.wavelength();
        let mut sum = Rgb::ZERO;
        self.points.visit(ray, |photon, t, cos, weight| {
            if photon.medium != *index {
                return;
            }
            *found += 1;
            let left = fade.left(t);
            let phase = medium.phase.evaluate(-cos);
            sum += photon.flux() * left * shared(own, photon.wavelength, self.band) * (phase * weight);
        });
        sum
    }

    fn at_a_point<I: Interior>(&self, passage: &Passage<'_, I>, rng: &mut impl Rng, found: &mut u64) -> Rgb {
        let Stretch { ray, medium, index, inside, .. } = passage.stretch;
        let own = inside.wavelength();
        let flight = medium.flight(ray, ray.t_max, passage.throughput, rng);
        let Some(t) = flight.scattered else { return Rgb::ZERO };
        let p = ray.at(t);
        let mut sum = Rgb::ZERO;
        self.points.around(p, |photon, weight| {
            if photon.medium != *index {
                return;
            }
            *found += 1;
            let phase = medium.phase.evaluate(-photon.direction().dot(ray.direction));
            sum += photon.flux() * shared(own, photon.wavelength, self.band) * (phase * weight);
        });
        // What was drawn counts σs·T over the density; the photons are scattered light already.
        sum * over(flight.weight, medium, p)
    }
}

/// `weight` over σs at `p`.
fn over(weight: Rgb, medium: &Medium, p: Vec3) -> Rgb {
    let scattering = medium.scattering * medium.density_at(p);
    Rgb::select(scattering.cmpgt(Rgb::ZERO), weight / scattering, Rgb::ZERO)
}

/// What the flux of a photon with a wavelength of code `other` is multiplied by for a walk of wavelength `own`, where either has one.
///
/// Each has been weighted for its own. Where both have one, light is shared by those that are less than `band` \[nm] apart: a kernel over
/// wavelengths in place of the photon's own weight.
pub(super) fn shared(own: Option<Wavelength>, other: u8, band: f32) -> Rgb {
    let (Some(own), Some(other)) = (own, Wavelength::from_code(other)) else { return Rgb::ONE };
    let apart = (own.nanometres() - other.nanometres()).abs();
    if apart > band {
        return Rgb::ZERO;
    }
    let response = other.weight() * other.density();
    let nm = own.nanometres();
    let width = (nm + band).min(Wavelength::LONGEST) - (nm - band).max(Wavelength::SHORTEST);
    Rgb::select(response.cmpgt(Rgb::ZERO), 1.0 / (response * width), Rgb::ZERO)
}
