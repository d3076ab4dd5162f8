//! Photon estimates in media: the radiance that a medium scatters along a segment of a camera path.

use super::vertex::MediumPathSegment;
use super::worker::PathWorker;
use crate::color::{Rgb, Wavelength};
use crate::medium::{self, Medium, TransmittanceCurve};
use crate::photon::{LEVELS, PhotonBeamMap, VolumePhotonMap, VolumePhotons};
use crate::scene::{Interior, MediumSegment};
use glam::Vec3;
use rand::Rng;

/// Estimator of in-scattered radiance from photons in media.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeEstimator {
    /// Photon beams near the ray (Jarosz et al. 2011). In heterogeneous media, `BeamRadiance`
    /// replaces it.
    #[default]
    Beams,
    /// Beam radiance estimate: photons near the ray (Jarosz, Zwicker and Jensen 2008).
    BeamRadiance,
    /// Photons near one sampled point of the ray (Jensen and Christensen 1998).
    Points,
}

impl VolumeEstimator {
    /// Returns the number of dimensions of the kernel in homogeneous and in heterogeneous media.
    pub(super) fn kernel_dimensions(self) -> (u32, u32) {
        match self {
            Self::Beams => (1, 2),
            Self::BeamRadiance => (2, 2),
            Self::Points => (3, 3),
        }
    }
}

/// Photon beams and photon points of one photon map, with their search structures.
pub(super) struct BeamAndPointMaps {
    beams: PhotonBeamMap,
    points: VolumePhotonMap,
    estimate: VolumeEstimator,
    /// Half width of the kernel over wavelengths, for estimates in media and on surfaces \[nm].
    pub band: f32,
}

/// Sums of the radiance from photons, for a kernel of the full radius and of smaller nested radii.
struct NestedKernelSums {
    sums: [Rgb; LEVELS],
    /// Factor by which the kernel's normalization grows when its squared radius is halved.
    level_scale: f32,
    /// Exponent in the kernel's shape (1 − x²)^power.
    power: i32,
    /// True if the smaller radii are summed too.
    nested: bool,
}

impl NestedKernelSums {
    /// Makes empty sums for a kernel in `dimensions` dimensions.
    fn new(dimensions: u32, power: i32, nested: bool) -> Self {
        let level_scale = [1.0, std::f32::consts::SQRT_2, 2.0, 2.0 * std::f32::consts::SQRT_2][dimensions as usize];
        Self { sums: [Rgb::ZERO; LEVELS], level_scale, power, nested }
    }

    /// Adds `radiance` times the kernel value `weight` of the full radius.
    ///
    /// `x2` is the squared distance relative to the squared full radius, in \[0, 1).
    #[inline]
    fn add(&mut self, radiance: Rgb, weight: f32, x2: f32) {
        self.sums[0] += radiance * weight;
        if !self.nested {
            return;
        }
        let (mut scale, mut x) = (1.0, x2);
        for sum in &mut self.sums[1..] {
            scale *= self.level_scale;
            x *= 2.0;
            if x < 1.0 {
                let ratio = (1.0 - x) / (1.0 - x2);
                let shape = if self.power == 1 { ratio } else { ratio * ratio };
                *sum += radiance * (weight * scale * shape);
            }
        }
    }

    /// Returns all sums times `factor`.
    fn scaled_by(self, factor: Rgb) -> [Rgb; LEVELS] {
        self.sums.map(|sum| sum * factor)
    }
}

impl BeamAndPointMaps {
    /// Builds the search structures of photons in media.
    ///
    /// `beams` and `points` are the kernel radii of photon beams and of photon points \[length].
    pub fn build(volume: VolumePhotons, (beams, points): (f32, f32), estimate: VolumeEstimator, band: f32) -> Self {
        let VolumePhotons { beams: stored_beams, points: stored_points } = volume;
        Self {
            beams: PhotonBeamMap::build(stored_beams, beams),
            points: VolumePhotonMap::build(stored_points, points),
            estimate,
            band,
        }
    }

    /// Estimates the radiance that a medium scatters to the start of a segment \[W/(m² sr)].
    ///
    /// Only the nested estimates in `worker` are multiplied by `samples`; the result is not.
    pub fn radiance<I: Interior>(
        &self,
        path_segment: &MediumPathSegment<'_, I>,
        samples: f32,
        rng: &mut impl Rng,
        worker: &mut PathWorker,
    ) -> Rgb {
        if self.beams.is_empty() && self.points.is_empty() {
            return Rgb::ZERO;
        }
        worker.counters.gathers += 1;
        let nested = worker.nests_estimates;
        let (count, curve) = (&mut worker.counters.gathered_photons, &mut worker.transmittance);
        let MediumSegment { ray, medium, .. } = path_segment.segment;
        let mut levels = [Rgb::ZERO; LEVELS];
        let mut add = |sums: [Rgb; LEVELS]| levels.iter_mut().zip(sums).for_each(|(level, sum)| *level += sum);
        if medium.is_homogeneous() {
            add(self.estimate_by_beams(path_segment, count, nested));
        }
        if !self.points.is_empty() {
            add(match self.estimate {
                VolumeEstimator::Points => self.estimate_at_sampled_point(path_segment, rng, count, nested),
                VolumeEstimator::Beams | VolumeEstimator::BeamRadiance => {
                    curve.sample(medium, ray, ray.t_max, rng);
                    self.estimate_along_ray(path_segment, curve, count, nested)
                }
            });
        }
        if nested {
            worker.nested.add(path_segment.throughput * samples, levels);
            worker.photon_step = levels[0] - levels[1];
        }
        levels[0]
    }

    /// Estimates radiance from photon beams, with a one-dimensional kernel over the distance
    /// between ray and beam. Returns it for each kernel size, largest first.
    fn estimate_by_beams<I: Interior>(
        &self,
        path_segment: &MediumPathSegment<'_, I>,
        count: &mut u64,
        nested: bool,
    ) -> [Rgb; LEVELS] {
        let MediumSegment { ray, medium, index, interior, .. } = path_segment.segment;
        let (own, extinction) = (interior.wavelength(), medium.extinction());
        let mut sums = NestedKernelSums::new(1, 1, nested);
        self.beams.visit_near_ray(ray, |beam, crossing| {
            if beam.medium != *index {
                return;
            }
            *count += 1;
            let transmittance = medium::transmittance(extinction, crossing.t + crossing.s);
            let phase = medium.phase.evaluate(-crossing.cos);
            let radiance = beam.flux * transmittance * wavelength_kernel_weight(own, beam.wavelength, self.band);
            sums.add(radiance, phase * crossing.weight, crossing.x2);
        });
        sums.scaled_by(medium.scattering)
    }

    /// Estimates radiance from photon points, with a two-dimensional kernel around the ray. Returns
    /// it for each kernel size, largest first.
    fn estimate_along_ray<I: Interior>(
        &self,
        path_segment: &MediumPathSegment<'_, I>,
        curve: &TransmittanceCurve,
        count: &mut u64,
        nested: bool,
    ) -> [Rgb; LEVELS] {
        let MediumSegment { ray, medium, index, interior, .. } = path_segment.segment;
        let own = interior.wavelength();
        let mut sums = NestedKernelSums::new(2, 2, nested);
        self.points.visit_near_ray(ray, |photon, t, cos, weight, x2| {
            if photon.medium != *index {
                return;
            }
            *count += 1;
            let transmittance = curve.transmittance_at(t);
            let phase = medium.phase.evaluate(-cos);
            sums.add(
                photon.flux() * transmittance * wavelength_kernel_weight(own, photon.wavelength, self.band),
                phase * weight,
                x2,
            );
        });
        sums.scaled_by(Rgb::ONE)
    }

    /// Estimates radiance from photon points, with a three-dimensional kernel around one sampled
    /// point of the ray. Returns it for each kernel size, largest first.
    fn estimate_at_sampled_point<I: Interior>(
        &self,
        path_segment: &MediumPathSegment<'_, I>,
        rng: &mut impl Rng,
        count: &mut u64,
        nested: bool,
    ) -> [Rgb; LEVELS] {
        let MediumSegment { ray, medium, index, interior, .. } = path_segment.segment;
        let own = interior.wavelength();
        let distance_sample = medium.distance_sample(ray, ray.t_max, path_segment.throughput, rng);
        let Some(t) = distance_sample.scattered else { return [Rgb::ZERO; LEVELS] };
        let p = ray.at(t);
        let mut sums = NestedKernelSums::new(3, 1, nested);
        self.points.visit_near_point(p, |photon, weight, x2| {
            if photon.medium != *index {
                return;
            }
            *count += 1;
            let phase = medium.phase.evaluate(-photon.direction().dot(ray.direction));
            sums.add(photon.flux() * wavelength_kernel_weight(own, photon.wavelength, self.band), phase * weight, x2);
        });
        // The weight is σs·T over the pdf, but the photons are scattered light already.
        sums.scaled_by(divide_by_scattering(distance_sample.weight, medium, p))
    }
}

/// Returns `weight` divided by the scattering coefficient at `p`; 0 in channels without scattering.
fn divide_by_scattering(weight: Rgb, medium: &Medium, p: Vec3) -> Rgb {
    let scattering = medium.scattering * medium.density_at(p);
    Rgb::select(scattering.cmpgt(Rgb::ZERO), weight / scattering, Rgb::ZERO)
}

/// Returns the factor on a photon's flux that accounts for the wavelengths of photon and camera
/// path.
///
/// `own` is the wavelength of the camera path, `other` the wavelength code of the photon. If both
/// are set, the factor replaces the photon's spectral weight by a box kernel of half width `band`
/// \[nm]. Otherwise it is 1.
pub(super) fn wavelength_kernel_weight(own: Option<Wavelength>, other: u8, band: f32) -> Rgb {
    let (Some(own), Some(other)) = (own, Wavelength::from_byte_code(other)) else { return Rgb::ONE };
    let apart = (own.nanometres() - other.nanometres()).abs();
    if apart > band {
        return Rgb::ZERO;
    }
    let response = other.weight() * other.pdf();
    let nm = own.nanometres();
    let width = (nm + band).min(Wavelength::LONGEST) - (nm - band).max(Wavelength::SHORTEST);
    Rgb::select(response.cmpgt(Rgb::ZERO), 1.0 / (response * width), Rgb::ZERO)
}
