//! Camera paths through participating media.

use super::{PathContext, PathState, PathWeights, is_path_continued, shares_indirect_light};
use crate::color::Rgb;
use crate::integrate::indirect_division::IndirectWeights;
use crate::integrate::light_group::LightGroup;
use crate::integrate::path_task::PathTask;
use crate::integrate::policy::{PathContinuation, PhotonLookups};
use crate::integrate::vertex::{MediumPathSegment, PathHistory, PrevVertex};
use crate::medium::PhaseFunction;
use crate::sampling::Dimension;
use crate::scene::{Interior, MediumSegment, PathEvent};
use glam::DVec3;
use rand::rngs::SmallRng;

/// Advances `path` to its next vertex. Adds to `radiance` the light that media on the way emit and
/// scatter towards the previous vertex.
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
/// of the segment, a part of the path's ray within one medium.
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
        && (!shares_indirect_light(weights.indirect, history) || is_path_continued(weights.indirect, path.sampler));
    let distance_sample = medium.distance_sample(ray, ray.t_max, throughput, rng);
    let shadow_sampler = path.sampler.shadow_ray_sampler(paths.pass);
    let path_segment = MediumPathSegment { segment, history, throughput, sampler: path.sampler, shadow_sampler };
    let mut scattered = Rgb::ZERO;
    if policy.uses_nee {
        scattered += paths.nee.estimate_direct_light_in_medium(&path_segment, &distance_sample, continues, task);
        task.pixel.groups.add(LightGroup::of_direct_light(history), throughput * scattered);
    }
    scattered += photon_radiance(paths, weights.indirect, &path_segment, rng, task);
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

/// Returns the radiance that a medium segment scatters to its start, estimated from photon maps
/// \[W/(m² sr)]; 0 if the policy reads no map on this segment. Also adds the radiance, times the
/// throughput, to the light that `task` records.
///
/// If only one path of a pixel reads the maps, the radiance is multiplied by the number of the
/// pixel's paths, to stand for all of them. `weights` are the weights of camera paths and of photon
/// estimates for the indirect light at the path's first receiver (surface or medium that stores
/// photons).
fn photon_radiance<I: Interior>(
    paths: &PathContext<'_>,
    weights: IndirectWeights,
    path_segment: &MediumPathSegment<'_, I>,
    rng: &mut SmallRng,
    task: &mut PathTask,
) -> Rgb {
    let Some(maps) = paths.maps else { return Rgb::ZERO };
    let lookup_scale = match paths.policy.lookups {
        PhotonLookups::Never | PhotonLookups::RecordVisible => return Rgb::ZERO,
        PhotonLookups::FewPerPixel => match path_segment.sampler.sample_index_and_count() {
            (0, samples) if path_segment.history.receivers == 0 => samples as f32,
            _ => return Rgb::ZERO,
        },
        PhotonLookups::FirstReceiver | PhotonLookups::GatherRays => 1.0,
    };
    let mut estimate = maps.radiance_in_medium(path_segment, lookup_scale, rng, task);
    if shares_indirect_light(weights, path_segment.history) {
        estimate +=
            maps.interreflection_radiance_in_medium(path_segment, lookup_scale * weights.photon_weight, rng, task);
    }
    task.records.light.photon_estimates += path_segment.throughput * estimate;
    task.pixel.photon_radiance += path_segment.throughput * estimate;
    estimate
}

/// Continues `path` from a scattering event in a direction sampled from `phase`. Returns false if
/// Russian roulette ends the path.
///
/// `weights` are the weights of camera paths and of photon estimates for indirect light. They apply
/// only if this event is the path's first receiver (surface or medium that stores photons).
pub(super) fn scatter_in_medium<I: Interior>(
    path: &mut PathState<I>,
    phase: PhaseFunction,
    weights: IndirectWeights,
) -> bool {
    let mut next = *path;
    if shares_indirect_light(weights, path.history) {
        next.share_indirect_with_photons(weights, path.sampler);
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
