//! Data that all camera paths of a pass share.

use crate::integrate::indirect_division::IndirectTechnique;
use crate::integrate::nee::NextEventEstimator;
use crate::integrate::photon_maps::PhotonMaps;
use crate::integrate::policy::{PathContinuation, PathPolicy};
use crate::integrate::vertex::PathVertex;
use crate::scene::Scene;

/// Gather radius \[length] that stands in for the radius of the indirect map if a pass has no
/// photon maps. [`PathContext::min_gather_distance`] is a multiple of it.
const FALLBACK_GATHER_RADIUS: f32 = 1.0;

/// Smallest length of a final-gathering ray that reads the indirect map at its end, divided by the
/// map's gather radius.
///
/// At the end of a shorter ray, the blur of the map would show. The path then continues instead.
const MIN_RELATIVE_GATHER_DISTANCE: f32 = 2.0;

/// Scene, policy, photon maps and limits that all camera paths of a pass share.
pub(in crate::integrate) struct PathContext<'a> {
    pub scene: &'a Scene,
    pub policy: &'a PathPolicy,
    pub nee: &'a NextEventEstimator<'a>,
    /// Photon maps of the pass; `None` if the pass has no photons.
    pub maps: Option<&'a PhotonMaps<'a>>,
    pub pass: u32,
    /// Number of bounces after which a camera path ends.
    pub max_bounces: u32,
    /// Technique that finds the indirect light at a path's first receiver (a surface or medium that
    /// stores photons): continued camera paths, photon estimates, or both.
    pub(super) technique: IndirectTechnique<'a>,
    /// Length above which a final-gathering ray reads the indirect map at its end \[length].
    pub(super) min_gather_distance: f32,
}

impl<'a> PathContext<'a> {
    /// Returns the data that all camera paths of pass `pass` share.
    pub fn new(
        scene: &'a Scene,
        policy: &'a PathPolicy,
        nee: &'a NextEventEstimator<'a>,
        maps: Option<&'a PhotonMaps<'a>>,
        pass: u32,
        max_bounces: u32,
        technique: IndirectTechnique<'a>,
    ) -> Self {
        let radius = maps.map_or(FALLBACK_GATHER_RADIUS, |maps| maps.indirect.max_gather_radius());
        let min_gather_distance = MIN_RELATIVE_GATHER_DISTANCE * radius;
        Self { scene, policy, nee, maps, pass, max_bounces, technique, min_gather_distance }
    }

    /// Returns a copy of this context in which `technique` finds the indirect light at the first
    /// receiver (surface or medium that stores photons) of a path.
    pub fn with_technique(self, technique: IndirectTechnique<'a>) -> Self {
        Self { technique, ..self }
    }

    /// True if `vertex` ends a final-gathering ray that is long enough for a lookup in the indirect
    /// map.
    #[inline]
    pub(super) fn ends_gather_ray<I>(&self, vertex: &PathVertex<'_, I>) -> bool {
        self.policy.continuation == PathContinuation::GatherRays
            && vertex.history.receivers > 0
            && vertex.distance > self.min_gather_distance
    }
}
