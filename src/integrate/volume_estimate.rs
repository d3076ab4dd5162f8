//! Photon estimates in media: the radiance that a medium scatters to the start of a camera-path
//! segment.

use super::path_task::PathTask;
use super::vertex::MediumPathSegment;
use crate::color::{Rgb, Wavelength};
use crate::math::{Frame, Ray};
use crate::medium::{self, Medium, TransmittanceCurve};
use crate::photon::{
    BeamIntersection, KernelProbes, NESTED_DISC_COUNT, PhotonBeam, PhotonBeamMap, VolumePhotonMap, VolumePhotons,
};
use crate::scene::{Interior, MediumSegment, Scene};
use glam::Vec3;
use rand::{Rng, RngExt};
use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Density estimator of the radiance that media scatter along a camera ray, from photons in media.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeEstimator {
    /// The estimator reads photon beams near the camera ray (Jarosz et al. 2011). Heterogeneous
    /// media use `BeamRadiance` instead.
    #[default]
    Beams,
    /// The beam radiance estimate reads photons near the camera ray (Jarosz, Zwicker and Jensen
    /// 2008).
    BeamRadiance,
    /// The estimator reads photons near one sampled point of the camera ray (Jensen and Christensen
    /// 1998).
    Points,
}

impl VolumeEstimator {
    /// Returns the number of dimensions of the density-estimation kernel. The first value is for
    /// homogeneous media, the second for heterogeneous media.
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
    estimator: VolumeEstimator,
    /// Half width of the kernel over wavelengths, for estimates in media and on surfaces \[nm].
    pub wavelength_kernel_half_width: f32,
}

/// Sums of the radiance from photons in a medium: one for a kernel of the full radius, the others
/// for kernels of smaller radii around the same center.
///
/// Walls may hide a part of the kernel. Probe rays from its center measure the hidden part. The
/// first probe ray goes towards one photon, chosen with a probability proportional to its radiance.
struct NestedKernelSums {
    sums: [Rgb; NESTED_DISC_COUNT],
    /// Number of dimensions in which the kernel spreads: 1 to 3.
    dimensions: u32,
    /// True if the photons are also summed with kernels of smaller radii, to estimate the bias.
    repeats_in_nested_discs: bool,
    chosen: Option<ChosenPhoton>,
}

/// Photon chosen at random from all photons of a kernel. Probe rays towards it and around it
/// measure the part of the kernel that surfaces hide.
struct ChosenPhoton {
    /// Contribution of the photon: its radiance times the phase function and the kernel value for
    /// the full radius.
    radiance: Rgb,
    /// Squared distance of the photon from the kernel's center, divided by the squared full radius.
    squared_relative_distance: f32,
    /// Ray from the kernel's center towards the photon, with unit direction.
    towards: Ray,
}

impl NestedKernelSums {
    /// Makes empty sums for a kernel in `dimensions` dimensions. If `repeats_in_nested_discs` is
    /// true, also sums the kernels of smaller radii.
    fn new(dimensions: u32, repeats_in_nested_discs: bool) -> Self {
        Self { sums: [Rgb::ZERO; NESTED_DISC_COUNT], dimensions, repeats_in_nested_discs, chosen: None }
    }

    /// Adds the `radiance` of one photon, times `weight`: the phase function times the value of the
    /// full-radius kernel at the photon.
    ///
    /// `x2` is the squared distance of the photon from the kernel's center, divided by the squared
    /// full radius, in \[0, 1). `towards` returns the ray from the center towards the photon.
    #[inline]
    fn add(&mut self, radiance: Rgb, weight: f32, x2: f32, rng: &mut impl Rng, towards: impl FnOnce() -> Ray) {
        let radiance = radiance * weight;
        self.sums[0] += radiance;
        if rng.random::<f32>() * self.sums[0].element_sum() < radiance.element_sum() {
            self.chosen = Some(ChosenPhoton { radiance, squared_relative_distance: x2, towards: towards() });
        }
        if self.repeats_in_nested_discs {
            let factors = kernel_ratios(self.dimensions, x2);
            self.sums[1..].iter_mut().zip(&factors[1..]).for_each(|(sum, factor)| *sum += radiance * *factor);
        }
    }

    /// Returns all sums times `factor`, corrected for the part of each kernel that surfaces hide.
    /// `radius` is the full radius \[length], and `axis` the unit direction of the camera ray.
    ///
    /// Ideally, a photon's contribution f would be divided by the coverage c, the visible part of
    /// the kernel, and photons behind a surface would be left out. To measure c for all photons
    /// would take too many probe rays. So one photon is chosen with probability f/F, where F is the
    /// sum of all f. For this photon, the function adds F/c − F, or −F if it is hidden. The result
    /// has the same mean.
    fn with_coverage_correction(
        mut self,
        scene: &Scene,
        axis: Vec3,
        radius: f32,
        factor: Rgb,
    ) -> [Rgb; NESTED_DISC_COUNT] {
        if let Some(ChosenPhoton { radiance, squared_relative_distance: x2, towards }) = self.chosen {
            let probes = KernelProbes::trace(scene, &towards, axis, self.dimensions, radius);
            let is_visible = probes.first_probe_is_clear(x2.sqrt() * radius);
            let all = self.sums[0].element_sum() / radiance.element_sum();
            let mut radius = radius;
            for (sum, ratio) in self.sums.iter_mut().zip(kernel_ratios(self.dimensions, x2)) {
                let coverage_factor = if is_visible { 1.0 / probes.visible_fraction(radius) } else { 0.0 };
                *sum += radiance * (ratio * all * (coverage_factor - 1.0));
                radius *= FRAC_1_SQRT_2;
            }
        }
        self.sums.map(|sum| sum * factor)
    }
}

/// Returns the kernel value at one photon for each kernel radius, divided by the value for the full
/// radius. Each radius is the next larger one divided by √2.
///
/// At the fraction x of its radius, a kernel is proportional to 1 − x² in one and three dimensions,
/// and to (1 − x²)² in two. `x2` is x² for the full radius.
#[inline]
fn kernel_ratios(dimensions: u32, x2: f32) -> [f32; NESTED_DISC_COUNT] {
    let level_scale = [1.0, SQRT_2, 2.0, 2.0 * SQRT_2][dimensions as usize];
    let (mut scale, mut x) = (1.0, x2);
    let mut ratios = [1.0; NESTED_DISC_COUNT];
    for value in &mut ratios[1..] {
        scale *= level_scale;
        x *= 2.0;
        let ratio = ((1.0 - x) / (1.0 - x2)).max(0.0);
        *value = scale * if dimensions == 2 { ratio * ratio } else { ratio };
    }
    ratios
}

impl BeamAndPointMaps {
    /// Builds the search structures for `volume`, the photons of one map in media.
    ///
    /// `beams` and `points` are the kernel radii for photon beams and for photon points \[length].
    /// `band` is the half width of the kernel over wavelengths \[nm].
    pub fn build(volume: VolumePhotons, (beams, points): (f32, f32), estimator: VolumeEstimator, band: f32) -> Self {
        let VolumePhotons { beams: stored_beams, points: stored_points } = volume;
        Self {
            beams: PhotonBeamMap::build(stored_beams, beams),
            points: VolumePhotonMap::build(stored_points, points),
            estimator,
            wavelength_kernel_half_width: band,
        }
    }

    /// Estimates the radiance that a medium scatters to the start of a segment \[W/(m² sr)].
    ///
    /// `lookup_scale` is the weight of photon estimates, times the number of camera paths that
    /// share this estimate. The result is not multiplied by `lookup_scale`. But `task` records the
    /// differences between nested kernels, times `lookup_scale`.
    pub fn radiance<I: Interior>(
        &self,
        scene: &Scene,
        path_segment: &MediumPathSegment<'_, I>,
        lookup_scale: f32,
        rng: &mut impl Rng,
        task: &mut PathTask,
    ) -> Rgb {
        if self.beams.is_empty() && self.points.is_empty() {
            return Rgb::ZERO;
        }
        task.counters.density_estimates += 1;
        let repeats_in_nested_discs = task.pixel.nested.is_wanted;
        let (count, curve) = (&mut task.counters.gathered_photons, &mut task.scratch.transmittance);
        let MediumSegment { ray, medium, .. } = path_segment.segment;
        let mut levels = [Rgb::ZERO; NESTED_DISC_COUNT];
        let mut add =
            |sums: [Rgb; NESTED_DISC_COUNT]| levels.iter_mut().zip(sums).for_each(|(level, sum)| *level += sum);
        if medium.is_homogeneous() {
            add(self.estimate_by_beams(scene, path_segment, rng, count, repeats_in_nested_discs));
        }
        if !self.points.is_empty() {
            add(match self.estimator {
                VolumeEstimator::Points => {
                    self.estimate_at_sampled_point(scene, path_segment, rng, count, repeats_in_nested_discs)
                }
                VolumeEstimator::Beams | VolumeEstimator::BeamRadiance => {
                    curve.sample(medium, ray, ray.t_max, rng);
                    self.estimate_along_ray(scene, path_segment, (curve, rng), count, repeats_in_nested_discs)
                }
            });
        }
        if repeats_in_nested_discs {
            task.pixel.nested.add(path_segment.throughput * lookup_scale, levels);
        }
        levels[0]
    }

    /// Estimates the radiance \[W/(m² sr)] that a medium scatters to the start of a segment, from
    /// photon beams. The kernel is one-dimensional, over the distance between ray and beam. Returns
    /// one value for each nested kernel radius, largest first.
    fn estimate_by_beams<I: Interior>(
        &self,
        scene: &Scene,
        path_segment: &MediumPathSegment<'_, I>,
        rng: &mut impl Rng,
        count: &mut u64,
        repeats_in_nested_discs: bool,
    ) -> [Rgb; NESTED_DISC_COUNT] {
        let MediumSegment { ray, medium, medium_index: index, interior, .. } = path_segment.segment;
        let (path_wavelength, extinction) = (interior.wavelength(), medium.extinction());
        let mut sums = NestedKernelSums::new(1, repeats_in_nested_discs);
        self.beams.visit_near_ray(ray, |beam, crossing| {
            if beam.medium != *index {
                return;
            }
            *count += 1;
            let transmittance = medium::transmittance(extinction, crossing.t + crossing.s);
            let phase = medium.phase.evaluate(-crossing.cos);
            let radiance = beam.flux
                * transmittance
                * wavelength_kernel_weight(path_wavelength, beam.wavelength_code, self.wavelength_kernel_half_width);
            let towards = || ray_towards_beam(ray, beam, &crossing);
            sums.add(radiance, phase * crossing.weight, crossing.squared_relative_distance, rng, towards);
        });
        sums.with_coverage_correction(scene, ray.direction, self.beams.radius(), medium.scattering)
    }

    /// Estimates the radiance \[W/(m² sr)] that a medium scatters to the start of a segment, from
    /// photon points. The kernel is two-dimensional, around the ray. Returns one value for each
    /// nested kernel radius, largest first.
    fn estimate_along_ray<I: Interior>(
        &self,
        scene: &Scene,
        path_segment: &MediumPathSegment<'_, I>,
        (curve, rng): (&TransmittanceCurve, &mut impl Rng),
        count: &mut u64,
        repeats_in_nested_discs: bool,
    ) -> [Rgb; NESTED_DISC_COUNT] {
        let MediumSegment { ray, medium, medium_index: index, interior, .. } = path_segment.segment;
        let path_wavelength = interior.wavelength();
        let mut sums = NestedKernelSums::new(2, repeats_in_nested_discs);
        self.points.visit_near_ray(ray, |photon, t, cos, weight, x2| {
            if photon.medium != *index {
                return;
            }
            *count += 1;
            let transmittance = curve.transmittance_at(t);
            let phase = medium.phase.evaluate(-cos);
            let radiance = photon.flux()
                * transmittance
                * wavelength_kernel_weight(path_wavelength, photon.wavelength_code, self.wavelength_kernel_half_width);
            let towards = || {
                let center = ray.at(t);
                let offset = photon.position - center;
                ray_along(center, offset - ray.direction * offset.dot(ray.direction), ray.direction)
            };
            sums.add(radiance, phase * weight, x2, rng, towards);
        });
        sums.with_coverage_correction(scene, ray.direction, self.points.radius(), Rgb::ONE)
    }

    /// Estimates the radiance \[W/(m² sr)] that a medium scatters to the start of a segment, from
    /// photon points. The kernel is three-dimensional, around one sampled point of the ray. Returns
    /// one value for each nested kernel radius, largest first.
    fn estimate_at_sampled_point<I: Interior>(
        &self,
        scene: &Scene,
        path_segment: &MediumPathSegment<'_, I>,
        rng: &mut impl Rng,
        count: &mut u64,
        repeats_in_nested_discs: bool,
    ) -> [Rgb; NESTED_DISC_COUNT] {
        let MediumSegment { ray, medium, medium_index: index, interior, .. } = path_segment.segment;
        let path_wavelength = interior.wavelength();
        let distance_sample = medium.distance_sample(ray, ray.t_max, path_segment.throughput, rng);
        let Some(t) = distance_sample.scattering_distance else { return [Rgb::ZERO; NESTED_DISC_COUNT] };
        let p = ray.at(t);
        let mut sums = NestedKernelSums::new(3, repeats_in_nested_discs);
        self.points.visit_near_point(p, |photon, weight, x2| {
            if photon.medium != *index {
                return;
            }
            *count += 1;
            let phase = medium.phase.evaluate(-photon.direction().dot(ray.direction));
            let radiance = photon.flux()
                * wavelength_kernel_weight(path_wavelength, photon.wavelength_code, self.wavelength_kernel_half_width);
            sums.add(radiance, phase * weight, x2, rng, || ray_along(p, photon.position - p, ray.direction));
        });
        // The weight is σs·T over the pdf of the distance. Photons already carry scattered light,
        // so divide by σs.
        let factor = divide_by_scattering(distance_sample.weight, medium, p);
        sums.with_coverage_correction(scene, ray.direction, self.points.radius(), factor)
    }
}

/// Returns the shortest connection from `ray` to `beam`: the ray from the point of `ray` that is
/// closest to the beam, towards the closest point of the beam.
fn ray_towards_beam(ray: &Ray, beam: &PhotonBeam, crossing: &BeamIntersection) -> Ray {
    let normal = ray.direction.as_dvec3().cross(beam.direction.as_dvec3()).normalize();
    let side = normal.dot(beam.start.as_dvec3() - ray.origin.as_dvec3());
    Ray::new(ray.at(crossing.t), if side < 0.0 { -normal } else { normal }.as_vec3())
}

/// Returns the ray from `origin` in the direction of `offset`. If `offset` is too small to have a
/// direction, the ray is perpendicular to the unit vector `axis`.
fn ray_along(origin: Vec3, offset: Vec3, axis: Vec3) -> Ray {
    Ray::new(origin, offset.try_normalize().unwrap_or_else(|| Frame::from_normal(axis).s))
}

/// Returns `weight` divided by the scattering coefficient at `p`. Channels without scattering
/// become 0.
fn divide_by_scattering(weight: Rgb, medium: &Medium, p: Vec3) -> Rgb {
    let scattering = medium.scattering * medium.density_at(p);
    Rgb::select(scattering.cmpgt(Rgb::ZERO), weight / scattering, Rgb::ZERO)
}

/// Returns the factor on a photon's flux that accounts for the difference between the wavelengths
/// of the photon and of the camera path.
///
/// `path_wavelength` is the wavelength of the camera path, and `photon_code` the wavelength code of
/// the photon. If both are set, the factor replaces the photon's spectral weight by a box kernel of
/// half width `band` \[nm]. Otherwise the factor is 1.
pub(super) fn wavelength_kernel_weight(path_wavelength: Option<Wavelength>, photon_code: u8, band: f32) -> Rgb {
    let (Some(path), Some(photon)) = (path_wavelength, Wavelength::from_byte_code(photon_code)) else {
        return Rgb::ONE;
    };
    let apart = (path.nanometres() - photon.nanometres()).abs();
    if apart > band {
        return Rgb::ZERO;
    }
    let response = photon.weight() * photon.pdf();
    let nm = path.nanometres();
    let width = (nm + band).min(Wavelength::LONGEST_NM) - (nm - band).max(Wavelength::SHORTEST_NM);
    Rgb::select(response.cmpgt(Rgb::ZERO), 1.0 / (response * width), Rgb::ZERO)
}

#[cfg(test)]
mod tests;
