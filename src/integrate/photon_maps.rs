//! Photon maps of a pass, and radiance estimates from them.

use super::light_group::LightGroup;
use super::nested_estimates::GatherDiscSum;
use super::path_task::PathTask;
use super::vertex::{MediumPathSegment, PathHistory, PathVertex};
use super::volume_estimate::{BeamAndPointMaps, wavelength_kernel_weight};
use crate::bsdf::TransportMode;
use crate::color::Rgb;
use crate::photon::{
    Bandwidth, Kernel, NestedRadianceEstimate, PhotonData, PhotonMap, PhotonSearchBuffers, Splat, disc_coverage,
    nested_disc_coverage,
};
use crate::scene::{Interior, Scene};
use rand::Rng;

/// One photon map, of surfaces and media, with the bandwidth and kernel of its density estimates.
pub(super) struct PhotonDensityEstimator<'a> {
    pub scene: &'a Scene,
    pub map: PhotonMap,
    pub bandwidth: Bandwidth,
    pub kernel: Kernel,
    /// Photon beams and photon points in media.
    pub volume: BeamAndPointMaps,
    /// True if each photon stores the share of its flux that counts in density estimates at
    /// directly visible surfaces. Light tracing carries the rest.
    pub has_density_estimate_shares: bool,
}

/// Choice of the photon maps that one estimate reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PhotonMapChoice {
    /// The caustic map.
    Caustic,
    /// The caustic map and the indirect map.
    CausticAndIndirect,
}

/// Photon maps of one pass.
///
/// | map | algorithm | kinds of photons | emitted |
/// | --- | --- | --- | --- |
/// | caustic | all with photons | `Caustic` | towards casters |
/// | indirect | `pm`, `ppm`, `sppm` | `AfterCaustic`, `AfterDirect` | in all directions |
/// | indirect | `hybrid` | `AfterCaustic` | towards casters |
/// | interreflection | `hybrid` | `AfterDirect` | in all directions |
///
/// [`PhotonKind`](crate::photon::PhotonKind) defines the kinds. If final-gathering rays read the
/// indirect map of `pm`, it holds `Direct` photons too.
pub(super) struct PhotonMaps<'a> {
    /// Caustic map: photons of kind [`PhotonKind::Caustic`](crate::photon::PhotonKind::Caustic).
    pub caustic: PhotonDensityEstimator<'a>,
    /// Indirect map: photons of all indirect light except caustics. Jensen 2001 and the command
    /// line call it the global map.
    ///
    /// In `hybrid`, it holds only light that a receiver has reflected from a caustic. If
    /// final-gathering rays read the map, it also holds direct light.
    pub indirect: PhotonDensityEstimator<'a>,
    /// Interreflection map of `hybrid`: photons that went straight from a light to a receiver and
    /// scattered there. `None` if camera paths carry all of this light.
    pub interreflection: Option<PhotonDensityEstimator<'a>>,
    /// Map of photons whose directions guide final-gathering rays.
    pub guides: PhotonMap,
    /// Splats on the film of caustic photons that light tracing connected to the camera; empty
    /// without light tracing.
    pub splats: Vec<Splat>,
}

impl PhotonMaps<'_> {
    /// Returns the radiance that `vertex` reflects towards the previous vertex, estimated from the
    /// maps that `lookup` names, times `samples` \[W/(m² sr)].
    ///
    /// One camera path may read the maps for all paths of its pixel. `samples` is then the number
    /// of these paths, times a weight. Also adds the estimates to the light groups of `task`.
    #[inline]
    pub fn radiance<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        lookup: PhotonMapChoice,
        samples: f32,
        task: &mut PathTask,
    ) -> Rgb {
        let caustic =
            self.caustic.radiance(vertex, samples, |t| (&mut t.search_buffers.caustic, &mut t.nested.caustic), task);
        let indirect = match lookup {
            PhotonMapChoice::Caustic => Rgb::ZERO,
            PhotonMapChoice::CausticAndIndirect => self.indirect.radiance(
                vertex,
                samples,
                |t| (&mut t.search_buffers.indirect, &mut t.nested.indirect),
                task,
            ),
        };
        task.groups.add(LightGroup::of_caustic_map(vertex.history), vertex.throughput * caustic * samples);
        task.groups.add(LightGroup::Indirect, vertex.throughput * indirect * samples);
        (caustic + indirect) * samples
    }

    /// Returns the radiance that `vertex` reflects towards the previous vertex, estimated from the
    /// interreflection map, times `samples` \[W/(m² sr)]; 0 without that map. Also adds it, times
    /// the throughput, to `task.indirect_light` and the light groups.
    ///
    /// One camera path may read the map for all paths of its pixel. `samples` is then the number of
    /// these paths, times a weight.
    #[inline]
    pub fn interreflection_radiance<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        samples: f32,
        task: &mut PathTask,
    ) -> Rgb {
        let Some(map) = &self.interreflection else { return Rgb::ZERO };
        task.nested_difference = Rgb::ZERO;
        let radiance =
            map.radiance(vertex, samples, |t| (&mut t.search_buffers.interreflection, &mut t.nested.indirect), task);
        task.indirect_light.photons += vertex.throughput * radiance * samples;
        task.indirect_light.nested_difference += vertex.throughput * task.nested_difference * samples;
        task.groups.add(LightGroup::Indirect, vertex.throughput * radiance * samples);
        radiance * samples
    }

    /// Returns the radiance that a medium scatters to the start of a segment, estimated from the
    /// caustic and the indirect map, times `samples` \[W/(m² sr)].
    ///
    /// One camera path may read the maps for all paths of its pixel; `samples` is then the number
    /// of these paths. Also adds the estimates to the light groups of `task`.
    #[inline]
    pub fn radiance_in_medium<I: Interior>(
        &self,
        vertex: &MediumPathSegment<'_, I>,
        samples: f32,
        rng: &mut impl Rng,
        task: &mut PathTask,
    ) -> Rgb {
        let caustic = self.caustic.volume.radiance(self.caustic.scene, vertex, samples, rng, task);
        let indirect = self.indirect.volume.radiance(self.indirect.scene, vertex, samples, rng, task);
        task.groups.add(LightGroup::of_caustic_map(vertex.history), vertex.throughput * caustic * samples);
        task.groups.add(LightGroup::Indirect, vertex.throughput * indirect * samples);
        (caustic + indirect) * samples
    }

    /// Returns the radiance that a medium scatters to the start of a segment, estimated from the
    /// interreflection map, times `samples` \[W/(m² sr)]; 0 without that map. Also adds it, times
    /// the throughput, to `task.indirect_light` and the light groups.
    ///
    /// One camera path may read the map for all paths of its pixel. `samples` is then the number of
    /// these paths, times a weight.
    #[inline]
    pub fn interreflection_radiance_in_medium<I: Interior>(
        &self,
        vertex: &MediumPathSegment<'_, I>,
        samples: f32,
        rng: &mut impl Rng,
        task: &mut PathTask,
    ) -> Rgb {
        let Some(map) = &self.interreflection else { return Rgb::ZERO };
        task.nested_difference = Rgb::ZERO;
        let radiance = map.volume.radiance(map.scene, vertex, samples, rng, task);
        task.indirect_light.photons += vertex.throughput * radiance * samples;
        task.indirect_light.nested_difference += vertex.throughput * task.nested_difference * samples;
        task.groups.add(LightGroup::Indirect, vertex.throughput * radiance * samples);
        radiance * samples
    }
}

impl PhotonDensityEstimator<'_> {
    /// Returns the largest gather radius \[length].
    pub fn max_gather_radius(&self) -> f32 {
        self.bandwidth.radius
    }

    /// Estimates the radiance that `vertex` reflects towards the previous vertex, from the photons
    /// of this map \[W/(m² sr)].
    ///
    /// `scratch` returns the task's search buffers and sums for this map. `samples` is the number
    /// of camera paths for which the estimate stands, times a weight. It multiplies only the nested
    /// estimates in `task`, not the result.
    #[inline]
    fn radiance<I: Interior>(
        &self,
        vertex: &PathVertex<'_, I>,
        samples: f32,
        scratch: fn(&mut PathTask) -> (&mut PhotonSearchBuffers, &mut GatherDiscSum),
        task: &mut PathTask,
    ) -> Rgb {
        if self.has_density_estimate_shares && vertex.history == PathHistory::default() {
            self.radiance_with_shares::<I, true>(vertex, samples, scratch, task)
        } else {
            self.radiance_with_shares::<I, false>(vertex, samples, scratch, task)
        }
    }

    /// Estimates the radiance that `vertex` reflects towards the previous vertex \[W/(m² sr)].
    ///
    /// If `SHARED` is true, only the share of each photon's flux counts that light tracing leaves
    /// to density estimates.
    #[inline]
    fn radiance_with_shares<I: Interior, const SHARED: bool>(
        &self,
        vertex: &PathVertex<'_, I>,
        samples: f32,
        scratch: fn(&mut PathTask) -> (&mut PhotonSearchBuffers, &mut GatherDiscSum),
        task: &mut PathTask,
    ) -> Rgb {
        if self.map.is_empty() {
            return Rgb::ZERO;
        }
        task.counters.gathers += 1;
        let surface = vertex.surface;
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        let wavelength = vertex.interior.wavelength();
        let brdf = |photon: &PhotonData| {
            let mut brdf =
                surface.bsdf.evaluate(surface.wo, photon.incident_direction(), ns, ns, TransportMode::Radiance);
            if SHARED {
                brdf *= photon.density_estimate_share();
            }
            if I::HAS_MEDIA_OR_WAVELENGTH {
                brdf * wavelength_kernel_weight(wavelength, photon.wavelength(), self.volume.band)
            } else {
                brdf
            }
        };
        let (p, normal) = (surface.point.p, surface.facing_normal());
        let (bandwidth, kernel, key) = (self.bandwidth, self.kernel, vertex.sampler.sample_key());
        let nested = task.nests_estimates;
        let (buffers, discs) = scratch(task);
        if !nested {
            let estimate = self.map.estimate_radiance(p, normal, bandwidth, kernel, buffers, brdf);
            task.counters.gathered_photons += u64::from(estimate.count);
            if estimate.count == 0 {
                return Rgb::ZERO;
            }
            return estimate.radiance / disc_coverage(self.scene, p, normal, estimate.radius, kernel, key);
        }
        let NestedRadianceEstimate { whole, mut radiance } =
            self.map.estimate_radiance_in_nested_discs(p, normal, bandwidth, kernel, buffers, brdf);
        discs.add(whole.radius, whole.count);
        task.counters.gathered_photons += u64::from(whole.count);
        if whole.count == 0 {
            return Rgb::ZERO;
        }
        let covered = disc_coverage(self.scene, p, normal, whole.radius, kernel, key);
        let estimate = whole.radiance / covered;
        if covered != 1.0 {
            // The coverage probes differ from pass to pass, even if passes share camera paths.
            // Otherwise the noise of shared probes would count as bias.
            let key = vertex.shadow_sampler.sample_key();
            let levels = nested_disc_coverage(self.scene, p, normal, whole.radius, kernel, key);
            radiance.iter_mut().zip(levels).for_each(|(radiance, covered)| *radiance /= covered);
        }
        task.nested.add(vertex.throughput * samples, radiance);
        task.nested_difference = radiance[0] - radiance[1];
        estimate
    }
}
