//! Photon maps of a pass, and density estimates of radiance from them.
//!
//! The [module](super) lists the maps, the photon paths that fill them, and their names in reports.

use super::light_group::LightGroup;
use super::nested_differences::GatherDiscSum;
use super::path_task::PathTask;
use super::vertex::{MediumPathSegment, PathHistory, PathVertex};
use super::volume_estimate::{BeamAndPointMaps, wavelength_kernel_weight};
use crate::bsdf::TransportMode;
use crate::color::Rgb;
use crate::photon::{
    Bandwidth, Kernel, NestedRadianceEstimate, PhotonAttributes, PhotonMap, PhotonSearchBuffers, Splat, disc_coverage,
    nested_disc_coverage,
};
use crate::scene::{Interior, Scene};
use glam::Vec3;
use rand::Rng;

/// Photons of one map, on surfaces and in media, with the kernel and the bandwidth (largest radius
/// and photon count) of density estimates from them.
pub(super) struct PhotonDensityEstimator<'a> {
    pub scene: &'a Scene,
    pub map: PhotonMap,
    pub bandwidth: Bandwidth,
    pub kernel: Kernel,
    /// Photon beams and photon points in media.
    pub volume: BeamAndPointMaps,
    /// True if density estimates at surfaces that the camera sees directly use only a part of each
    /// photon's flux. Each photon stores this fraction in \[0, 1]. Light tracing (photons connected
    /// to the camera) carries the rest.
    pub has_density_estimate_shares: bool,
}

/// Photon maps that one radiance estimate reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PhotonMapChoice {
    /// The estimate reads only the caustic map.
    Caustic,
    /// The estimate reads the caustic map and the indirect map.
    CausticAndIndirect,
}

/// Photon maps of one pass: the caustic, indirect and interreflection map, and the map that guides
/// final-gathering rays.
pub(super) struct PhotonMaps<'a> {
    /// Caustic map: photons that went from a light via mirrors, glass and other casters to a
    /// surface or medium.
    pub caustic: PhotonDensityEstimator<'a>,
    /// Indirect map: photons that a receiver, such as a diffuse surface, has scattered; in
    /// `hybrid`, only after a caustic. If gather rays of `pm` read the map, it holds direct photons
    /// too.
    pub indirect: PhotonDensityEstimator<'a>,
    /// Interreflection map of `hybrid`: photons of indirect light that does not come from a
    /// caustic. `None` in other algorithms, or if camera paths carry all of this light.
    pub interreflection: Option<PhotonDensityEstimator<'a>>,
    /// Map of photons whose directions guide final-gathering rays; empty if these rays are not
    /// guided.
    pub guides: PhotonMap,
    /// Film splats of the caustic photons that light tracing connected to the camera; empty without
    /// light tracing.
    pub splats: Vec<Splat>,
}

impl PhotonMaps<'_> {
    /// Returns the radiance that `vertex` reflects towards the previous vertex, estimated from the
    /// photon maps that `lookup` selects, times `lookup_scale` \[W/(m² sr)]. Also adds the
    /// estimates to the light groups of `task`.
    ///
    /// `lookup_scale` is the weight of photon estimates, times the number of camera paths that
    /// share this estimate: one camera path may read the maps for all paths of its pixel.
    #[inline]
    pub fn radiance<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        lookup: PhotonMapChoice,
        lookup_scale: f32,
        task: &mut PathTask,
    ) -> Rgb {
        let caustic = self.caustic.radiance(
            vertex,
            lookup_scale,
            |t| (&mut t.scratch.searches.caustic, &mut t.pixel.nested.caustic_discs),
            task,
        );
        let indirect = match lookup {
            PhotonMapChoice::Caustic => Rgb::ZERO,
            PhotonMapChoice::CausticAndIndirect => self.indirect.radiance(
                vertex,
                lookup_scale,
                |t| (&mut t.scratch.searches.indirect, &mut t.pixel.nested.indirect_discs),
                task,
            ),
        };
        task.pixel.groups.add(LightGroup::of_caustic_map(vertex.history), vertex.throughput * caustic * lookup_scale);
        task.pixel.groups.add(LightGroup::Indirect, vertex.throughput * indirect * lookup_scale);
        (caustic + indirect) * lookup_scale
    }

    /// Returns the radiance that `vertex` reflects towards the previous vertex, estimated from the
    /// interreflection map (indirect light that does not come from a caustic), times `lookup_scale`
    /// \[W/(m² sr)]. Returns 0 without that map.
    ///
    /// Also adds the radiance, times the throughput, to `task.records.light` and to the light
    /// groups. `lookup_scale` is the weight of photon estimates, times the number of camera paths
    /// that share this estimate.
    #[inline]
    pub fn interreflection_radiance<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        lookup_scale: f32,
        task: &mut PathTask,
    ) -> Rgb {
        let Some(map) = &self.interreflection else { return Rgb::ZERO };
        task.pixel.nested.last_difference = Rgb::ZERO;
        let radiance = map.radiance(
            vertex,
            lookup_scale,
            |t| (&mut t.scratch.searches.interreflection, &mut t.pixel.nested.indirect_discs),
            task,
        );
        task.records.light.indirect_by_photons += vertex.throughput * radiance * lookup_scale;
        task.records.light.indirect_nested_difference +=
            vertex.throughput * task.pixel.nested.last_difference * lookup_scale;
        task.pixel.groups.add(LightGroup::Indirect, vertex.throughput * radiance * lookup_scale);
        radiance * lookup_scale
    }

    /// Returns the radiance that a medium scatters to the start of a segment, estimated from the
    /// caustic and the indirect map, times `lookup_scale` \[W/(m² sr)].
    ///
    /// Also adds the estimates to the light groups of `task`. `lookup_scale` is the weight of
    /// photon estimates, times the number of camera paths that share this estimate.
    #[inline]
    pub fn radiance_in_medium<I: Interior>(
        &self,
        vertex: &MediumPathSegment<'_, I>,
        lookup_scale: f32,
        rng: &mut impl Rng,
        task: &mut PathTask,
    ) -> Rgb {
        let caustic = self.caustic.volume.radiance(self.caustic.scene, vertex, lookup_scale, rng, task);
        let indirect = self.indirect.volume.radiance(self.indirect.scene, vertex, lookup_scale, rng, task);
        task.pixel.groups.add(LightGroup::of_caustic_map(vertex.history), vertex.throughput * caustic * lookup_scale);
        task.pixel.groups.add(LightGroup::Indirect, vertex.throughput * indirect * lookup_scale);
        (caustic + indirect) * lookup_scale
    }

    /// Returns the radiance that a medium scatters to the start of a segment, estimated from the
    /// interreflection map (indirect light that does not come from a caustic), times `lookup_scale`
    /// \[W/(m² sr)]. Returns 0 without that map.
    ///
    /// Also adds the radiance, times the throughput, to `task.records.light` and to the light
    /// groups. `lookup_scale` is the weight of photon estimates, times the number of camera paths
    /// that share this estimate.
    #[inline]
    pub fn interreflection_radiance_in_medium<I: Interior>(
        &self,
        vertex: &MediumPathSegment<'_, I>,
        lookup_scale: f32,
        rng: &mut impl Rng,
        task: &mut PathTask,
    ) -> Rgb {
        let Some(map) = &self.interreflection else { return Rgb::ZERO };
        task.pixel.nested.last_difference = Rgb::ZERO;
        let radiance = map.volume.radiance(map.scene, vertex, lookup_scale, rng, task);
        task.records.light.indirect_by_photons += vertex.throughput * radiance * lookup_scale;
        task.records.light.indirect_nested_difference +=
            vertex.throughput * task.pixel.nested.last_difference * lookup_scale;
        task.pixel.groups.add(LightGroup::Indirect, vertex.throughput * radiance * lookup_scale);
        radiance * lookup_scale
    }
}

impl PhotonDensityEstimator<'_> {
    /// Returns the largest gather radius of density estimates on surfaces \[length].
    pub fn max_gather_radius(&self) -> f32 {
        self.bandwidth.radius
    }

    /// Estimates the radiance that `vertex` scatters towards the previous vertex, from the photons
    /// of this map \[W/(m² sr)]. If the surface transmits, photons on both of its sides count.
    ///
    /// `scratch` returns the task's search buffers and gather-disc sums for this map. The result is
    /// not multiplied by `lookup_scale`, the factor of [`PhotonMaps::radiance`]. But `task` records
    /// the differences between nested discs, times `lookup_scale`.
    #[inline]
    fn radiance<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        lookup_scale: f32,
        scratch: fn(&mut PathTask) -> (&mut PhotonSearchBuffers, &mut GatherDiscSum),
        task: &mut PathTask,
    ) -> Rgb {
        if self.has_density_estimate_shares && vertex.history == PathHistory::default() {
            self.radiance_weighted_by_share::<I, true>(vertex, lookup_scale, scratch, task)
        } else {
            self.radiance_weighted_by_share::<I, false>(vertex, lookup_scale, scratch, task)
        }
    }

    /// Estimates the radiance that `vertex` scatters towards the previous vertex \[W/(m² sr)].
    ///
    /// If `HAS_SHARES` is true, the estimate uses only a fraction of each photon's flux; light
    /// tracing (photons connected to the camera) carries the rest.
    #[inline]
    fn radiance_weighted_by_share<I: Interior, const HAS_SHARES: bool>(
        &self,
        vertex: &PathVertex<'_, I>,
        lookup_scale: f32,
        scratch: fn(&mut PathTask) -> (&mut PhotonSearchBuffers, &mut GatherDiscSum),
        task: &mut PathTask,
    ) -> Rgb {
        if self.map.is_empty() {
            return Rgb::ZERO;
        }
        let normal = vertex.surface.facing_normal();
        if !vertex.surface.bsdf.transmits() {
            return self.radiance_from_side::<I, HAS_SHARES, false>(vertex, normal, lookup_scale, scratch, task);
        }
        let mut sum = (Rgb::ZERO, Rgb::ZERO);
        for normal in vertex.surface.light_side_normals() {
            task.pixel.nested.last_difference = Rgb::ZERO;
            sum.0 += self.radiance_from_side::<I, HAS_SHARES, true>(vertex, normal, lookup_scale, scratch, task);
            sum.1 += task.pixel.nested.last_difference;
        }
        task.pixel.nested.last_difference = sum.1;
        sum.0
    }

    /// Estimates the radiance that `vertex` scatters towards the previous vertex, from the photons
    /// on the side of the unit geometric `normal` \[W/(m² sr)].
    ///
    /// `TRANSMITS` is true if the BSDF transmits. If `HAS_SHARES` is true, the estimate uses only a
    /// fraction of each photon's flux; light tracing (photons connected to the camera) carries the
    /// rest.
    #[inline]
    fn radiance_from_side<I: Interior, const HAS_SHARES: bool, const TRANSMITS: bool>(
        &self,
        vertex: &PathVertex<'_, I>,
        normal: Vec3,
        lookup_scale: f32,
        scratch: fn(&mut PathTask) -> (&mut PhotonSearchBuffers, &mut GatherDiscSum),
        task: &mut PathTask,
    ) -> Rgb {
        task.counters.density_estimates += 1;
        let surface = vertex.surface;
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        let wavelength = vertex.interior.wavelength();
        let bsdf = |photon: &PhotonAttributes| {
            let wi = photon.incident_direction();
            // On a curved surface, light that reaches a neighboring point from the side of `normal`
            // may come from below the tangent plane here. It must not count as light from the other
            // side.
            if TRANSMITS && wi.dot(normal) <= 0.0 {
                return Rgb::ZERO;
            }
            let ng = if TRANSMITS { normal } else { ns };
            let mut bsdf = surface.bsdf.evaluate(surface.wo, wi, ns, ng, TransportMode::Radiance);
            if HAS_SHARES {
                bsdf *= photon.density_estimate_share();
            }
            if I::HAS_MEDIA_OR_WAVELENGTH {
                bsdf * wavelength_kernel_weight(
                    wavelength,
                    photon.wavelength_code(),
                    self.volume.wavelength_kernel_half_width,
                )
            } else {
                bsdf
            }
        };
        let p = surface.point.p;
        let (bandwidth, kernel, key) = (self.bandwidth, self.kernel, vertex.sampler.sample_key());
        let nested = task.pixel.nested.is_wanted;
        let (buffers, discs) = scratch(task);
        if !nested {
            let estimate = self.map.estimate_radiance(p, normal, bandwidth, kernel, buffers, bsdf);
            task.counters.gathered_photons += u64::from(estimate.photon_count);
            if estimate.photon_count == 0 {
                return Rgb::ZERO;
            }
            return estimate.radiance / disc_coverage(self.scene, p, normal, estimate.radius, kernel, key);
        }
        let NestedRadianceEstimate { full_disc: whole, mut radiance } =
            self.map.estimate_radiance_in_nested_discs(p, normal, bandwidth, kernel, buffers, bsdf);
        discs.add(whole.radius, whole.photon_count);
        task.counters.gathered_photons += u64::from(whole.photon_count);
        if whole.photon_count == 0 {
            return Rgb::ZERO;
        }
        let covered = disc_coverage(self.scene, p, normal, whole.radius, kernel, key);
        let estimate = whole.radiance / covered;
        if covered != 1.0 {
            // Measure the coverage by probe rays that differ from pass to pass, even if passes
            // share camera paths. Otherwise the noise of shared probe rays would count as bias.
            let key = vertex.shadow_sampler.sample_key();
            let levels = nested_disc_coverage(self.scene, p, normal, whole.radius, kernel, key);
            radiance.iter_mut().zip(levels).for_each(|(radiance, covered)| *radiance /= covered);
        }
        task.pixel.nested.add(vertex.throughput * lookup_scale, radiance);
        estimate
    }
}
