//! State of one parallel task that traces camera paths.

use super::gather_guide::GatherGuide;
use super::indirect_division::{IndirectLightByTechnique, IndirectWeights};
use super::light_group::GroupedLight;
use super::nested_estimates::NestedEstimateSum;
use super::prefix_rays::PrefixLightSums;
use super::scatter_point_guide::{GuidedDistances, InScatteringSample};
use crate::color::Rgb;
use crate::medium::TransmittanceCurve;
use crate::photon::{PhotonSearchBuffers, VisiblePoint};
use crate::stats::Counters;
use glam::Vec2;

/// Parallel task that traces camera paths one after the other, such as those of a tile.
///
/// Each task starts with a new value, so results do not depend on the number of threads.
#[derive(Debug, Default)]
pub(super) struct PathTask {
    /// Counts of rays and photons of all camera paths of the task.
    pub counters: Counters,
    pub inputs: PathInputs,
    /// Weights and sums of the light that paths find up to their first receiver. They are set
    /// before the camera paths of a pixel, and again before its prefix rays.
    pub prefix: PrefixLightSums,
    pub pixel: PixelState,
    pub records: PilotRecords,
    pub scratch: ScratchBuffers,
}

/// Values that the current camera path reads: film position, time, and technique weights.
#[derive(Debug, Default)]
pub(super) struct PathInputs {
    /// True if each photon estimate is repeated with smaller nested discs, to measure its bias. It
    /// holds for the whole task.
    pub nests_estimates: bool,
    /// Film position \[pixels from the top left]: in a render, the center of the current pixel; in
    /// a pilot that traces film points, the current point.
    pub film_position: Vec2,
    /// Index of the slice of the shutter interval in which the current camera ray is traced.
    pub shutter_slice: usize,
    /// Weights of camera paths and of photon estimates for indirect light at `film_position`.
    pub technique_weights: IndirectWeights,
}

/// Light of the current pixel, and of its current camera ray, that is kept apart from the radiance.
/// A pixel's last camera ray or prefix ray ends its lifetime.
#[derive(Debug, Default)]
pub(super) struct PixelState {
    /// Radiance of the current camera ray that photon estimates found \[W/(m² sr)].
    pub photon_radiance: Rgb,
    /// Light of the current camera ray, divided into direct, indirect and caustic light.
    pub groups: GroupedLight,
    /// Sums of nested photon estimates over the rays of the pixel.
    pub nested: NestedEstimateSum,
}

/// Records that pilots take from the task. A render writes only `indirect_by_technique`, and does
/// not read it.
#[derive(Debug, Default)]
pub(super) struct PilotRecords {
    /// Indirect light by technique, summed over the camera paths since the pilot last took it.
    pub indirect_by_technique: IndirectLightByTechnique,
    /// Shadow rays from media, of all camera paths of the task.
    pub in_scattering_samples: Vec<InScatteringSample>,
    /// Points visible to the camera, of all camera paths of the task.
    pub visible_points: Vec<VisiblePoint>,
}

/// Buffers that vertices reuse, to save allocations. Their contents have a meaning only within one
/// vertex or one medium segment.
#[derive(Debug, Default)]
pub(super) struct ScratchBuffers {
    /// Buffers of photon searches in each map.
    pub searches: MapSearchBuffers,
    /// Distribution of final-gathering directions at the current receiver.
    pub gather_guide: GatherGuide,
    /// Transmittance along the current medium segment.
    pub transmittance: TransmittanceCurve,
    /// Distribution of guided scattering distances along the current medium segment.
    pub guided_distances: GuidedDistances,
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
    /// Returns a task that has traced no path. If `nests_estimates`, its photon estimates are
    /// repeated with smaller nested discs.
    pub fn new(nests_estimates: bool) -> Self {
        Self { inputs: PathInputs { nests_estimates, ..PathInputs::default() }, ..Self::default() }
    }
}
