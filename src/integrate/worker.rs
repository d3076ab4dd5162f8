//! Counters and buffers of one parallel task that traces camera paths.

use super::gather_guide::GatherGuide;
use super::indirect_division::{IndirectLight, IndirectWeights};
use super::light_group::GroupedLight;
use super::nested_estimates::NestedEstimateSum;
use super::prefix_rays::PrefixLight;
use super::scatter_point_guide::{GuidedDistances, InScatteringSample};
use crate::color::Rgb;
use crate::medium::TransmittanceCurve;
use crate::photon::{PhotonSearchBuffers, VisiblePoint};
use crate::stats::Counters;
use glam::Vec2;

/// Counters and reusable buffers of one parallel task that traces camera paths, such as a tile.
///
/// Each task starts with a new value, so results do not depend on the number of threads.
#[derive(Debug, Default)]
pub(super) struct PathWorker {
    pub counters: Counters,
    /// Buffers of photon searches in the caustic map.
    pub caustic: PhotonSearchBuffers,
    /// Buffers of photon searches in the indirect map.
    pub indirect: PhotonSearchBuffers,
    /// Buffers of photon searches in the interreflection map, which only `hybrid` builds.
    pub interreflection: PhotonSearchBuffers,
    /// Buffers of searches for photons that guide final-gathering rays.
    pub guide_lookup: PhotonSearchBuffers,
    /// Distribution of final-gathering directions at the last receiver.
    pub gather_guide: GatherGuide,
    /// True if each photon estimate is repeated with smaller nested discs, to measure its bias.
    pub nests_estimates: bool,
    /// Sums of nested photon estimates over the rays of the current pixel.
    pub nested: NestedEstimateSum,
    /// Last photon estimate minus the estimate at the same point with half the disc area \[W/(m²
    /// sr)].
    pub photon_step: Rgb,
    /// Transmittance along the current segment of a medium.
    pub transmittance: TransmittanceCurve,
    /// Distribution of guided scattering distances along the current medium segment; a reused
    /// buffer.
    pub guided_distances: GuidedDistances,
    /// Shadow rays from media that a pilot records.
    pub in_scattering: Vec<InScatteringSample>,
    /// Points visible to the camera that a pilot records.
    pub visible: Vec<VisiblePoint>,
    /// Weights and sums of the light that paths find up to their first receiver.
    pub prefix: PrefixLight,
    /// Film position \[pixels from the top left]: in a render, the center of the current pixel; in
    /// a pilot that traces film points, the current point.
    pub film_position: Vec2,
    /// Index of the slice of the shutter interval in which the current camera ray is traced.
    pub slice: usize,
    /// Weights that divide the indirect light of the current camera path between camera paths and
    /// photon estimates.
    pub indirect_weights: IndirectWeights,
    /// Indirect light of the current camera path of a pilot: once as the continued path finds it,
    /// and once as the photon estimate does. Values are contributions to the pixel.
    pub indirect_light: IndirectLight,
    /// Radiance of the current camera ray that photon estimates found \[W/(m² sr)].
    pub photon_light: Rgb,
    /// Light of the current camera ray, divided into direct, indirect and caustic light.
    pub groups: GroupedLight,
}
