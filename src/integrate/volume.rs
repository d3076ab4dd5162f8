//! What photons brought to media, seen along stretches of camera walks.

use super::method::Passage;
use super::tiles::Worker;
use crate::color::{Rgb, Wavelength};
use crate::medium::{Medium, TransmittanceCurve, transmittance};
use crate::photon::{BeamMap, LEVELS, PointMap, VolumePhotons};
use crate::scene::{Interior, MediumSegment};
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

/// Sums at the radius of a blur, and at narrower ones within it.
struct Sums {
    sums: [Rgb; LEVELS],
    /// What the kernel grows by at half the squared radius, but for its shape.
    narrower: f32,
    /// The kernel's shape is this power of 1 − x².
    power: i32,
    gauge: bool,
}

impl Sums {
    /// Of a kernel in so many dimensions.
    fn new(dimensions: u32, power: i32, gauge: bool) -> Self {
        let narrower = [1.0, std::f32::consts::SQRT_2, 2.0, 2.0 * std::f32::consts::SQRT_2][dimensions as usize];
        Self { sums: [Rgb::ZERO; LEVELS], narrower, power, gauge }
    }

    /// Adds `sent` by a kernel of `weight` at squared distance `x2`, in squares of the radius.
    #[inline]
    fn add(&mut self, sent: Rgb, weight: f32, x2: f32) {
        self.sums[0] += sent * weight;
        if !self.gauge {
            return;
        }
        let (mut scale, mut x) = (1.0, x2);
        for sum in &mut self.sums[1..] {
            scale *= self.narrower;
            x *= 2.0;
            if x < 1.0 {
                let ratio = (1.0 - x) / (1.0 - x2);
                let shape = if self.power == 1 { ratio } else { ratio * ratio };
                *sum += sent * (weight * scale * shape);
            }
        }
    }

    /// All of them times `by`.
    fn times(self, by: Rgb) -> [Rgb; LEVELS] {
        self.sums.map(|sum| sum * by)
    }
}

impl VolumeMap {
    /// Indexes what was stored for blurs of these radii: of beams, and of points.
    pub fn build(volume: VolumePhotons, (beams, points): (f32, f32), estimate: VolumeEstimate, band: f32) -> Self {
        let VolumePhotons { beams: ways, points: places } = volume;
        Self { beams: BeamMap::build(ways, beams), points: PointMap::build(places, points), estimate, band }
    }

    /// Radiance that a stretch sends to its start; it will count `times` times.
    pub fn radiance<I: Interior>(
        &self,
        passage: &Passage<'_, I>,
        times: u32,
        rng: &mut impl Rng,
        worker: &mut Worker,
    ) -> Rgb {
        if self.beams.is_empty() && self.points.is_empty() {
            return Rgb::ZERO;
        }
        worker.counters.gathers += 1;
        let gauge = worker.gauge;
        let (found, fade) = (&mut worker.counters.gathered_photons, &mut worker.fade);
        let MediumSegment { ray, medium, .. } = passage.stretch;
        let mut levels = [Rgb::ZERO; LEVELS];
        let mut add = |sums: [Rgb; LEVELS]| levels.iter_mut().zip(sums).for_each(|(level, sum)| *level += sum);
        if medium.is_homogeneous() {
            add(self.by_beams(passage, found, gauge));
        }
        if !self.points.is_empty() {
            add(match self.estimate {
                VolumeEstimate::Points => self.at_a_point(passage, rng, found, gauge),
                VolumeEstimate::Beams | VolumeEstimate::BeamRadiance => {
                    fade.sample(medium, ray, ray.t_max, rng);
                    self.along(passage, fade, found, gauge)
                }
            });
        }
        if gauge {
            worker.tally.note(passage.throughput * times as f32, levels);
        }
        levels[0]
    }

    fn by_beams<I: Interior>(&self, passage: &Passage<'_, I>, found: &mut u64, gauge: bool) -> [Rgb; LEVELS] {
        let MediumSegment { ray, medium, index, inside, .. } = passage.stretch;
        let (own, extinction) = (inside.wavelength(), medium.extinction());
        let mut sums = Sums::new(1, 1, gauge);
        self.beams.visit(ray, |beam, crossing| {
            if beam.medium != *index {
                return;
            }
            *found += 1;
            let left = transmittance(extinction, crossing.t + crossing.s);
            let phase = medium.phase.evaluate(-crossing.cos);
            let sent = beam.flux * left * shared(own, beam.wavelength, self.band);
            sums.add(sent, phase * crossing.weight, crossing.x2);
        });
        sums.times(medium.scattering)
    }

    fn along<I: Interior>(
        &self,
        passage: &Passage<'_, I>,
        fade: &TransmittanceCurve,
        found: &mut u64,
        gauge: bool,
    ) -> [Rgb; LEVELS] {
        let MediumSegment { ray, medium, index, inside, .. } = passage.stretch;
        let own = inside.wavelength();
        let mut sums = Sums::new(2, 2, gauge);
        self.points.visit(ray, |photon, t, cos, weight, x2| {
            if photon.medium != *index {
                return;
            }
            *found += 1;
            let left = fade.at(t);
            let phase = medium.phase.evaluate(-cos);
            sums.add(photon.flux() * left * shared(own, photon.wavelength, self.band), phase * weight, x2);
        });
        sums.times(Rgb::ONE)
    }

    fn at_a_point<I: Interior>(
        &self,
        passage: &Passage<'_, I>,
        rng: &mut impl Rng,
        found: &mut u64,
        gauge: bool,
    ) -> [Rgb; LEVELS] {
        let MediumSegment { ray, medium, index, inside, .. } = passage.stretch;
        let own = inside.wavelength();
        let distance_sample = medium.distance_sample(ray, ray.t_max, passage.throughput, rng);
        let Some(t) = distance_sample.scattered else { return [Rgb::ZERO; LEVELS] };
        let p = ray.at(t);
        let mut sums = Sums::new(3, 1, gauge);
        self.points.around(p, |photon, weight, x2| {
            if photon.medium != *index {
                return;
            }
            *found += 1;
            let phase = medium.phase.evaluate(-photon.direction().dot(ray.direction));
            sums.add(photon.flux() * shared(own, photon.wavelength, self.band), phase * weight, x2);
        });
        // What was drawn counts σs·T over the density; the photons are scattered light already.
        sums.times(over(distance_sample.weight, medium, p))
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
    let response = other.weight() * other.pdf();
    let nm = own.nanometres();
    let width = (nm + band).min(Wavelength::LONGEST) - (nm - band).max(Wavelength::SHORTEST);
    Rgb::select(response.cmpgt(Rgb::ZERO), 1.0 / (response * width), Rgb::ZERO)
}
