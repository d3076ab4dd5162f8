//! State of one parallel task that traces camera paths.

use super::gather_guide::GatherGuide;
use super::light_group::GroupedLight;
use super::nested_differences::PixelNestedDifferenceSum;
use super::scatter_point_guide::{GuidedDistanceDistribution, InScatteringSample};
use crate::color::Rgb;
use crate::medium::TransmittanceCurve;
use crate::photon::{PhotonSearchBuffers, VisiblePoint};
use crate::stats::Counters;

/// State of a parallel task that traces camera paths one after the other, such as those of a tile.
/// It holds what the paths have found so far, and the buffers that they reuse, but no input of a
/// path.
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

/// Light of the pixel that a task is rendering, and of the camera ray that it is tracing, kept
/// apart from the radiance. It is reset after the pixel's last ray.
#[derive(Debug, Default)]
pub(super) struct PixelLight {
    /// Radiance that photon estimates found for the camera ray that is being traced \[W/(m² sr)].
    pub photon_radiance: Rgb,
    /// Light of the camera ray that is being traced, divided into direct, indirect and caustic
    /// light.
    pub groups: GroupedLight,
    /// Sums of differences between photon estimates with nested gather discs, over the rays of the
    /// pixel.
    pub nested: PixelNestedDifferenceSum,
}

/// Records that pilots take from the task. A render writes only `light`, and does not read it.
#[derive(Debug, Default)]
pub(super) struct PilotRecords {
    /// Sums of light since the pilot last took them, by the part of the camera path, or the
    /// technique, that found the light.
    pub light: LightByPart,
    /// Light that each shadow ray from a point of a medium found, over all camera paths of the
    /// task.
    pub in_scattering_samples: Vec<InScatteringSample>,
    /// Points on receivers that the camera paths of the task reached.
    pub visible_points: Vec<VisiblePoint>,
}

/// Light of camera paths by the part of the path, or the technique, that found it. Values are
/// contributions to the pixel \[W/(m² sr)].
///
/// *Divided* light is the indirect light at the first receiver that
/// [both techniques](super::indirect_division) find.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LightByPart {
    /// Light found up to the first receiver: emission of surfaces, environment light and direct
    /// light at casters, with the weights of [`PrefixWeights`](super::prefix_rays::PrefixWeights).
    pub up_to_receiver: Rgb,
    /// Photon estimates from all maps.
    pub photon_estimates: Rgb,
    /// Divided light found by camera paths that continue at their first receiver.
    pub divided_light_of_paths: Rgb,
    /// Divided light found by photon estimates. It is also a part of `photon_estimates`.
    pub divided_light_of_photons: Rgb,
    /// `divided_light_of_photons` with the full gather disc minus the estimate with half its area;
    /// 0 without nested estimates.
    pub divided_nested_difference: Rgb,
}

/// Buffers that vertices reuse, to save allocations. Their contents have a meaning only within one
/// vertex or one medium segment.
#[derive(Debug, Default)]
pub(super) struct ScratchBuffers {
    /// Buffers of photon searches in each map.
    pub searches: MapSearchBuffers,
    /// Distribution of final-gathering directions at the path's last receiver.
    pub gather_guide: GatherGuide,
    /// Transmittance along the medium segment that the path is crossing.
    pub transmittance: TransmittanceCurve,
    /// Distribution of guided scattering distances along the medium segment that the path is
    /// crossing.
    pub guided_distances: GuidedDistanceDistribution,
}

/// Reusable buffers of photon searches, for each map of photons on surfaces.
#[derive(Debug, Default)]
pub(super) struct MapSearchBuffers {
    /// Buffers of searches in the caustic map.
    pub caustic: PhotonSearchBuffers,
    /// Buffers of searches in the indirect map.
    pub indirect: PhotonSearchBuffers,
    /// Buffers of searches in the interreflection map, which only `hybrid` builds.
    pub interreflection: PhotonSearchBuffers,
    /// Buffers of searches for photons that guide final-gathering rays.
    pub guides: PhotonSearchBuffers,
}

impl PathTask {
    /// Returns a task that has traced no path. If `repeats_in_nested_discs`, its photon estimates
    /// are repeated with smaller nested discs, to measure their bias. If `groups_light`, it divides
    /// light by [`LightGroup`](super::light_group::LightGroup).
    pub fn new(repeats_in_nested_discs: bool, groups_light: bool) -> Self {
        let nested = PixelNestedDifferenceSum::new(repeats_in_nested_discs);
        let groups = GroupedLight::new(groups_light);
        Self { pixel: PixelLight { nested, groups, ..PixelLight::default() }, ..Self::default() }
    }
}
