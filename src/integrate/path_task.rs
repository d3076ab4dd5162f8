//! State of one parallel task that traces camera paths.

use super::gather_guide::GatherGuide;
use super::light_group::GroupedLight;
use super::nested_differences::PixelNestedDifferenceSum;
use super::scatter_point_guide::{GuidedDistanceDistribution, InScatteringSample};
use crate::color::Rgb;
use crate::medium::TransmittanceCurve;
use crate::photon::{PhotonSearchBuffers, VisiblePoint};
use crate::stats::Counters;

/// State of a parallel task that traces camera paths one after the other, such as the paths of a
/// tile. It holds the results of these paths apart from radiance, and reusable buffers, but no
/// input of a path.
///
/// Each task starts with an empty state, so results do not depend on the number of threads.
#[derive(Debug, Default)]
pub(super) struct PathTask {
    /// Counts of rays and photons of all camera paths of the task.
    pub counters: Counters,
    pub pixel: PixelLight,
    pub records: PilotRecords,
    pub scratch: ScratchBuffers,
}

/// Light that a task records besides radiance. Values for the current camera ray are reset with
/// each ray, and values for the current pixel after the pixel's last ray.
#[derive(Debug, Default)]
pub(super) struct PixelLight {
    /// Radiance that photon estimates found for the camera ray that is being traced \[W/(m² sr)].
    pub photon_radiance: Rgb,
    /// Light of the camera ray that is being traced, divided into direct, indirect and caustic
    /// light.
    pub groups: GroupedLight,
    /// Differences between photon estimates with gather discs of full, half and quarter area,
    /// summed over the rays of the pixel.
    pub nested: PixelNestedDifferenceSum,
}

/// Records for pilots (small simulations before the first pass), which take them from the task.
/// Passes write only `light`, and do not read it.
#[derive(Debug, Default)]
pub(super) struct PilotRecords {
    /// Light that camera paths found since the pilot last took this record, summed separately for
    /// each part of a path and each technique that found it.
    pub light: LightByPart,
    /// Light found by each shadow ray that started in a medium, for all camera paths of the task.
    pub in_scattering_samples: Vec<InScatteringSample>,
    /// Points that the camera paths of the task reached on receivers, the surfaces that store
    /// photons.
    pub visible_points: Vec<VisiblePoint>,
}

/// Light of camera paths, summed separately for each part of a path and each technique that found
/// it. Values are contributions to the pixel \[W/(m² sr)].
///
/// *Receiver*: a surface or medium that stores photons. [Two techniques](super::indirect_division)
/// share the indirect light at a path's first receiver: continued camera paths and photon
/// estimates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LightByPart {
    /// Light found up to the first receiver (surface or medium that stores photons): emission of
    /// surfaces, environment light, and direct light at casters such as rough glass. The light is
    /// multiplied by [`PrefixWeights`](super::prefix_rays::PrefixWeights).
    pub up_to_receiver: Rgb,
    /// Light found by photon estimates from all photon maps.
    pub photon_estimates: Rgb,
    /// Indirect light at the first receiver (surface or medium that stores photons), found by
    /// camera paths that continue there. Photon estimates find the rest.
    pub indirect_by_paths: Rgb,
    /// Indirect light at the first receiver (surface or medium that stores photons), found by
    /// photon estimates. Continued camera paths find the rest. `photon_estimates` includes this
    /// light.
    pub indirect_by_photons: Rgb,
    /// Difference between two photon estimates: `indirect_by_photons` minus the same estimate with
    /// half the disc area. The difference is 0 if estimates are not repeated in smaller discs.
    pub indirect_nested_difference: Rgb,
}

/// Buffers that all vertices of a task reuse, to save allocations. Their contents are valid only
/// within one vertex or one medium segment.
#[derive(Debug, Default)]
pub(super) struct ScratchBuffers {
    /// Buffers of photon searches in each map.
    pub searches: MapSearchBuffers,
    /// Directions of photons near the path's last surface that stores photons. They guide the
    /// final-gathering ray from there.
    pub gather_guide: GatherGuide,
    /// Transmittance along the medium segment that the path is crossing.
    pub transmittance: TransmittanceCurve,
    /// Learned distribution of the scattering points, from which shadow rays start, along the
    /// medium segment that the path is crossing.
    pub guided_distances: GuidedDistanceDistribution,
}

/// Reusable buffers of photon searches, for each map of photons on surfaces.
#[derive(Debug, Default)]
pub(super) struct MapSearchBuffers {
    /// Buffers of searches in the caustic map.
    pub caustic: PhotonSearchBuffers,
    /// Buffers of searches in the indirect map.
    pub indirect: PhotonSearchBuffers,
    /// Buffers of searches in the interreflection map: indirect light of `hybrid` that does not
    /// come from caustics.
    pub interreflection: PhotonSearchBuffers,
    /// Buffers of searches for photons that guide final-gathering rays.
    pub guides: PhotonSearchBuffers,
}

impl PathTask {
    /// Returns the state of a task that has traced no path. If `repeats_in_nested_discs` is true,
    /// photon estimates are repeated in smaller discs with the same center, to measure their bias.
    /// If `groups_light` is true, the task divides light by
    /// [`LightGroup`](super::light_group::LightGroup).
    pub fn new(repeats_in_nested_discs: bool, groups_light: bool) -> Self {
        let nested = PixelNestedDifferenceSum::new(repeats_in_nested_discs);
        let groups = GroupedLight::new(groups_light);
        Self { pixel: PixelLight { nested, groups, ..PixelLight::default() }, ..Self::default() }
    }
}
