//! Steps of camera paths through participating media: crossing, emission and scattering.

use super::{PathContext, PathState, PathWeights, photon_estimate};
use crate::color::Rgb;
use crate::integrate::light_group::LightGroup;
use crate::integrate::path_task::PathTask;
use crate::integrate::policy::PathContinuation;
use crate::integrate::vertex::{MediumPathSegment, PathHistory, PrevVertex};
use crate::medium::PhaseFunction;
use crate::sampling::Dimension;
use crate::scene::{Interior, MediumSegment, PathEvent};
use glam::DVec3;
use rand::rngs::SmallRng;

/// Advances `path` to its next vertex. Adds to `radiance` the light that media on the way emit and
/// scatter towards the previous vertex, times the path's throughput.
///
/// Returns the event at the next vertex, and the phase function of the medium there. The phase
/// function is meaningful only for scattering events.
pub(super) fn advance_to_vertex<'a, I: Interior>(
    paths: &PathContext<'a>,
    weights: &PathWeights,
    path: &mut PathState<I>,
    task: &mut PathTask,
    radiance: &mut Rgb,
) -> (PathEvent<'a>, PhaseFunction) {
    let mut rng = path.sampler.sample_key().medium_tracking_key(paths.pass).rng();
    let mut path_ray = path.path_ray;
    let mut phase = PhaseFunction::Isotropic;
    let mut weight = DVec3::ONE;
    let event = path_ray.next_vertex(paths.scene, path.sampler.sample_key(), |segment| {
        phase = segment.medium.phase;
        cross_medium(paths, weights, path, segment, &mut weight, &mut rng, task, radiance)
    });
    path.path_ray = path_ray;
    path.throughput *= weight.as_vec3();
    (event, phase)
}

/// Adds to `radiance` the light that the medium of `segment` emits and scatters towards the start
/// of the segment, times the path's throughput. `segment` is the part of the path's ray within one
/// medium.
///
/// Returns the distance \[length] at which the path scatters; `None` if it passes through. `weight`
/// is the product of the throughput factors since the last vertex. The function multiplies `weight`
/// by the factor of this segment.
#[expect(clippy::too_many_arguments, reason = "one call's inputs, all of different kinds")]
fn cross_medium<I: Interior>(
    paths: &PathContext<'_>,
    weights: &PathWeights,
    path: &PathState<I>,
    segment: &MediumSegment<'_, I>,
    weight: &mut DVec3,
    rng: &mut SmallRng,
    task: &mut PathTask,
    radiance: &mut Rgb,
) -> Option<f32> {
    let MediumSegment { medium, ray, .. } = segment;
    let policy = paths.policy;
    let throughput = path.throughput * weight.as_vec3() * segment.absorption_transmittance_before;

    // Add emission. It is direct light of the last receiver, so `pending_weight`, which is for
    // indirect light, does not apply.
    let history = PathHistory {
        casters_since_receiver: path.history.casters_since_receiver + u32::from(segment.crossed_hidden_boundary),
        ..path.history
    };
    if medium.emits() {
        let emitted = throughput * medium.emitted_radiance(ray, ray.t_max, rng);
        task.pixel.groups.add(LightGroup::of_found_light(history), emitted);
        *radiance += emitted;
    }
    let throughput = throughput * path.pending_weight;
    if !medium.scatters() {
        *weight *= medium.transmittance_f64(ray, ray.t_max, rng);
        return None;
    }

    // Add the direct light and the light of photons that the medium scatters on this segment.
    let continues = policy.continuation == PathContinuation::Always
        && path.bounce < paths.max_bounces
        && weights.continues_beyond_receiver(history, path.sampler);
    let distance_sample = medium.distance_sample(ray, ray.t_max, throughput, rng);
    let shadow_sampler = path.sampler.shadow_ray_sampler(paths.pass);
    let path_segment = MediumPathSegment { segment, history, throughput, sampler: path.sampler, shadow_sampler };
    let mut scattered = Rgb::ZERO;
    if policy.uses_nee {
        scattered += paths.nee.estimate_direct_light_in_medium(&path_segment, &distance_sample, continues, task);
        task.pixel.groups.add(LightGroup::of_direct_light(history), throughput * scattered);
    }
    scattered += photon_estimate::radiance_in_medium(paths, weights, &path_segment, rng, task);
    *radiance += throughput * scattered;
    if path.shares_indirect {
        task.records.light.indirect_by_paths += throughput * scattered;
    }

    // Scatter, or continue to the end of the segment.
    if continues {
        *weight *= distance_sample.weight.as_dvec3();
        return distance_sample.scattering_distance;
    }
    *weight *= medium.transmittance_f64(ray, ray.t_max, rng);
    None
}

/// Continues `path` from a scattering event in a direction sampled from `phase`. Returns false if
/// Russian roulette ends the path.
///
/// If this event is the path's first receiver (surface or medium that stores photons), `weights`
/// divide the indirect light there between camera paths and photon estimates.
pub(super) fn scatter_in_medium<I: Interior>(
    path: &mut PathState<I>,
    phase: PhaseFunction,
    weights: &PathWeights,
) -> bool {
    let mut next = *path;
    if weights.shares_indirect_light(path.history) {
        next.share_indirect_with_photons(weights.indirect, path.sampler);
    }
    let (direction, pdf) = phase.sample(next.path_ray.ray.direction, path.sampler.get_2d(Dimension::Phase));
    next.path_ray.scatter_towards(direction);
    next.prev_nee_vertex =
        Some(PrevVertex { p: next.path_ray.ray.origin, hemisphere: None, history: path.history, pdf });
    next.history = PathHistory { receivers: path.history.receivers + 1, casters_since_receiver: 0 };
    next.bounce += 1;
    next.sampler = path.sampler.next_vertex_sampler(path.bounce, false);
    if !next.play_russian_roulette(path.sampler) {
        return false;
    }
    *path = next;
    true
}
