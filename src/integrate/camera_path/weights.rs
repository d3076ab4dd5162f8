//! Weights of the light that one camera path finds.

use super::{PathContext, PathState};
use crate::color::Rgb;
use crate::integrate::camera_ray::CameraRay;
use crate::integrate::indirect_division::IndirectWeights;
use crate::integrate::light_group::LightGroup;
use crate::integrate::path_task::PathTask;
use crate::integrate::prefix_rays::PrefixWeights;
use crate::integrate::vertex::PathHistory;
use crate::sampling::{Dimension, Sampler};

/// Weights of the light that one camera path finds. Weights are needed because other paths of the
/// pixel, and photon estimates, find some of the same light.
pub(super) struct PathWeights {
    /// Weights of the light up to the first receiver (a surface or medium that stores photons).
    pub prefix: PrefixWeights,
    /// Weights of camera paths and of photon estimates for the indirect light at the first
    /// receiver.
    pub indirect: IndirectWeights,
}

impl PathWeights {
    /// Returns the weights of the camera path that starts with `camera_ray`.
    #[inline]
    pub fn of_camera_ray(paths: &PathContext<'_>, camera_ray: &CameraRay) -> Self {
        Self {
            prefix: camera_ray.prefix_weights,
            indirect: paths.technique.technique_weights(camera_ray.weight_lookup_position),
        }
    }

    /// True if a photon estimate carries part or all of the indirect light that does not come from
    /// caustics. This happens only at the first receiver (surface or medium that stores photons) of
    /// a camera path.
    ///
    /// `history` counts the receivers and casters on the path before this vertex.
    #[inline]
    pub fn shares_indirect_light(&self, history: PathHistory) -> bool {
        self.indirect.photon_weight > 0.0 && history.receivers == 0
    }

    /// True if the camera path may continue beyond a receiver, a surface or medium that stores
    /// photons.
    ///
    /// False only at the path's first receiver: if photon estimates carry part of the indirect
    /// light there, only some of a pixel's paths continue. `history` counts the receivers and
    /// casters on the path before this vertex, and `sampler` is the vertex's sampler.
    #[inline]
    pub fn continues_beyond_receiver(&self, history: PathHistory, sampler: Sampler) -> bool {
        !self.shares_indirect_light(history)
            || self
                .indirect
                .continues_at_receiver(sampler.sample_index_and_count(), sampler.get_1d(Dimension::ReceiverBranch))
    }

    /// Returns `light` times its weight, and adds the weighted light to the light that `task`
    /// records. `light` is a contribution to the pixel that `path` found: emission that it hit, or
    /// direct light at a glossy surface such as rough glass.
    ///
    /// Before the first receiver (surface or medium that stores photons), `light` has a weight of
    /// [`PrefixWeights`], because extra camera paths of the pixel find the same light. Later, its
    /// weight is 1.
    #[inline]
    pub fn weigh_and_record_light<I>(&self, light: Rgb, path: &PathState<I>, task: &mut PathTask) -> Rgb {
        if path.history.receivers > 0 {
            if path.history.receivers > 1 && path.shares_indirect {
                task.records.light.indirect_by_paths += light;
            }
            task.pixel.groups.add(LightGroup::of_found_light(path.history), light);
            return light;
        }
        let weighted = light * self.prefix.up_to_receiver;
        task.records.light.up_to_receiver += weighted;
        task.pixel.groups.add(LightGroup::Direct, weighted);
        weighted
    }
}
