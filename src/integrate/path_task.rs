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

/// Parallel task that traces camera paths, such as those of a tile: its counters and buffers, and
/// the state of its current camera ray.
///
/// Each task starts with a new value, so results do not depend on the number of threads.
#[derive(Debug, Default)]
pub(super) struct PathTask {
    pub counters: Counters,
    /// Buffers of photon searches in each map.
    pub search_buffers: MapSearchBuffers,
    /// Distribution of final-gathering directions at the last receiver.
    pub gather_guide: GatherGuide,
    /// True if each photon estimate is repeated with smaller nested discs, to measure its bias.
    pub nests_estimates: bool,
    /// Sums of nested photon estimates over the rays of the current pixel.
    pub nested: NestedEstimateSum,
    /// Last photon estimate minus the estimate at the same point with half the disc area \[W/(m²
    /// sr)].
    pub nested_difference: Rgb,
    /// Transmittance along the current segment of a medium.
    pub transmittance: TransmittanceCurve,
    /// Distribution of guided scattering distances along the current medium segment; a reused
    /// buffer.
    pub guided_distances: GuidedDistances,
    /// Shadow rays from media that a pilot records.
    pub in_scattering_samples: Vec<InScatteringSample>,
    /// Points visible to the camera that a pilot records.
    pub visible_points: Vec<VisiblePoint>,
    /// Weights and sums of the light that paths find up to their first receiver.
    pub prefix: PrefixLightSums,
    /// Film position \[pixels from the top left]: in a render, the center of the current pixel; in
    /// a pilot that traces film points, the current point.
    pub film_position: Vec2,
    /// Index of the slice of the shutter interval in which the current camera ray is traced.
    pub shutter_slice: usize,
    /// Weights that divide the indirect light of the current camera path between camera paths and
    /// photon estimates.
    pub indirect_weights: IndirectWeights,
    /// Indirect light of the current camera path of a pilot: once as the continued path finds it,
    /// and once as the photon estimate does. Values are contributions to the pixel.
    pub indirect_light: IndirectLightByTechnique,
    /// Radiance of the current camera ray that photon estimates found \[W/(m² sr)].
    pub photon_radiance: Rgb,
    /// Light of the current camera ray, divided into direct, indirect and caustic light.
    pub groups: GroupedLight,
}
