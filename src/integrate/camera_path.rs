//! Camera paths: the path-tracing loop of every algorithm except `raycast`.
//!
//! A *receiver* is a surface or medium that stores photons, such as a diffuse wall. A *caster*
//! passes photons on, such as a mirror or glass; [`PhotonKind`](crate::photon::PhotonKind) has the
//! exact definitions. If the policy leaves caustics to photons, a camera path ignores emission that
//! it hits after a receiver and one or more casters. So no light path counts twice.
//!
//! A path's inputs are a [`PathContext`], which all paths of a pass share, and a [`CameraRay`]. Its
//! state between two vertices is a [`PathState`], and [`PathWeights`] weight the light that it
//! finds. A [`PathTask`] collects the paths' ray counts, light groups and pilot records.
//! [`indirect_division`](super::indirect_division) lists the fields by which camera paths and
//! photon estimates share indirect light.

mod context;
mod emission;
mod media;
mod photon_estimate;
mod state;
mod weights;

pub(super) use context::PathContext;
pub(super) use state::PathState;

use super::camera_ray::CameraRay;
use super::light_group::LightGroup;
use super::path_task::PathTask;
use super::policy::{DirectionSampling, PathContinuation};
use super::scatter;
use super::vertex::{PathHistory, PathVertex, PrevVertex};
use crate::bsdf::TransportMode;
use crate::color::{self, Rgb};
use crate::medium::PhaseFunction;
use crate::sampling::Dimension;
use crate::scene::{Effect, Interior, PathEvent, SurfaceVertex};
use weights::PathWeights;

/// Throughput of the fainter branch, as a mean over RGB, above which a camera path follows both
/// branches at a smooth dielectric: the reflected and the refracted one.
///
/// If the fainter branch has less throughput, the path samples one of the two branches.
const MIN_SPLIT_THROUGHPUT: f32 = 0.001;

/// Number of bounces without Russian roulette, for a camera path that has met only mirrors, glass
/// and other specular or glossy casters.
const ROULETTE_BOUNCE: u32 = 8;

/// Largest number of reflected branches of one camera path that wait on the stack to be traced.
const MAX_BRANCHES: usize = 16;

/// Traces the camera path that starts with `camera_ray`, and returns its radiance \[W/(m² sr)].
/// Adds ray counts, light groups and records for pilots (small simulations before the first pass)
/// to `task`.
///
/// `stack` holds branches of the path that are still to be traced; it is empty before and after.
pub(super) fn trace_camera_path<I: Interior>(
    paths: &PathContext<'_>,
    camera_ray: &CameraRay,
    task: &mut PathTask,
    stack: &mut Vec<PathState<I>>,
) -> Rgb {
    let PathContext { scene, policy, nee, .. } = *paths;
    let weights = PathWeights::of_camera_ray(paths, camera_ray);
    let mut radiance = Rgb::ZERO;
    let mut branch = Some(PathState::from_camera_ray(paths, camera_ray));
    while let Some(mut path) = branch {
        loop {
            // Find the next vertex; add in-scattering and emission of the media along the segment.
            task.counters.continuation_rays += u64::from(path.bounce > 0);
            let (event, phase) = if I::HAS_MEDIA_OR_WAVELENGTH {
                media::advance_to_vertex(paths, &weights, &mut path, task, &mut radiance)
            } else {
                (path.path_ray.next_vertex(scene, path.sampler.sample_key(), |_| None), PhaseFunction::Isotropic)
            };
            let mut hit = match event {
                PathEvent::Surface(hit) => hit,
                PathEvent::Scattered { absorption_transmittance: transmittance, crossed_hidden_boundary } => {
                    path.throughput *= transmittance * path.pending_weight;
                    path.pending_weight = 1.0;
                    path.history.casters_since_receiver += u32::from(crossed_hidden_boundary);
                    if media::scatter_in_medium(&mut path, phase, &weights) {
                        continue;
                    }
                    break;
                }
                PathEvent::Escaped { crossed_hidden_boundary } => {
                    path.count_crossed_boundary(crossed_hidden_boundary);
                    let escaped = path.throughput * emission::mis_weighted_escaped_radiance(paths, &path);
                    radiance += weights.weigh_and_record_light(escaped, &path, task);
                    break;
                }
            };
            path.throughput *= hit.absorption_and_wavelength_weight;
            path.count_crossed_boundary(hit.crossed_hidden_boundary);

            // Add emission, weighted by MIS against next-event estimation at the previous vertex.
            if hit.surface.emission != Rgb::ZERO && emission::may_add_hit_emission(policy, &path) {
                let found = path.throughput * hit.surface.emission * emission::mis_weight(nee, &path, &hit.surface);
                radiance += weights.weigh_and_record_light(found, &path, task);
            }
            path.throughput *= path.pending_weight;
            path.pending_weight = 1.0;

            // Reflect and refract at casters: surfaces that store no photons, such as mirrors and
            // glass.
            if !hit.surface.bsdf.stores_photons() {
                if hit.surface.bsdf.is_black() || !policy.effects.has(Effect::Specular) {
                    break;
                }
                if scatter_at_caster(paths, &weights, &mut path, &hit, task, &mut radiance, stack) {
                    continue;
                }
                break;
            }

            // Shade a receiver: a surface that stores photons.
            if !shade_receiver(paths, &weights, &mut path, &mut hit, task, &mut radiance) {
                break;
            }
        }
        branch = stack.pop();
    }
    radiance
}

/// Adds the direct light and the photon estimate at `receiver`, a surface that stores photons, to
/// `radiance`, times the path's throughput. Continues `path` from there, or returns false if the
/// path ends.
#[inline(always)]
fn shade_receiver<I: Interior>(
    paths: &PathContext<'_>,
    weights: &PathWeights,
    path: &mut PathState<I>,
    receiver: &mut SurfaceVertex<'_>,
    task: &mut PathTask,
    radiance: &mut Rgb,
) -> bool {
    let PathContext { policy, nee, .. } = *paths;

    // End faint paths by Russian roulette before shading, which costs as much as many rays.
    if policy.min_throughput == 0.0 && !path.play_shading_roulette() {
        return false;
    }
    if policy.directions == DirectionSampling::OneLobe {
        receiver.surface.bsdf = receiver.surface.bsdf.select_lobe(path.sampler.get_1d(Dimension::ReceiverBranch));
    }
    let surface = &receiver.surface;
    let interior = path.path_ray.interior;
    let vertex = path.vertex_at_surface(paths, surface, &interior, receiver.distance);
    let ends_gather_ray = paths.ends_gather_ray(&vertex);
    let continues = path.bounce < paths.max_bounces
        && weights.continues_beyond_receiver(vertex.history, vertex.sampler)
        && !weights.prefix.ends_at_receiver
        && match policy.continuation {
            PathContinuation::Never => false,
            PathContinuation::Glossy => !surface.bsdf.is_diffuse_or_coated(),
            PathContinuation::GatherRays => !ends_gather_ray,
            PathContinuation::Always => true,
        };
    if let (true, DirectionSampling::Guided, Some(maps)) = (continues, policy.directions, paths.maps) {
        scatter::collect_gather_directions(maps, paths.min_gather_distance, &vertex, task);
    }

    // Add direct light by next-event estimation.
    let direct = if policy.uses_nee && !ends_gather_ray && !weights.prefix.ends_at_receiver {
        nee.estimate_direct_light(&vertex, continues, task)
    } else {
        Rgb::ZERO
    };

    task.pixel.groups.add(LightGroup::of_direct_light(vertex.history), path.throughput * direct);

    // Add the photon estimate.
    let reflected = direct + photon_estimate::radiance(paths, weights, &vertex, ends_gather_ray, task);
    *radiance += path.throughput * reflected;
    if path.shares_indirect {
        task.records.light.indirect_by_paths += path.throughput * reflected;
    }

    // Continue in a sampled direction.
    path.history = PathHistory { receivers: path.history.receivers + 1, casters_since_receiver: 0 };
    if !(continues && continue_path(paths, path, &vertex, task)) {
        return false;
    }
    if weights.shares_indirect_light(vertex.history) {
        path.share_indirect_with_photons(weights.indirect, vertex.sampler);
    }
    true
}

/// Continues `path` from `caster`, a surface that stores no photons, such as glass. Returns false
/// if the path ends. At a glossy caster, also adds direct light to `radiance`.
///
/// If a smooth dielectric splits the path, the reflected branch goes to `stack`. The function is
/// not inlined, so that [`trace_camera_path`] stays small for scenes without casters.
#[inline(never)]
fn scatter_at_caster<I: Interior>(
    paths: &PathContext<'_>,
    weights: &PathWeights,
    path: &mut PathState<I>,
    caster: &SurfaceVertex<'_>,
    task: &mut PathTask,
    radiance: &mut Rgb,
    stack: &mut Vec<PathState<I>>,
) -> bool {
    let PathContext { policy, nee, .. } = *paths;
    let surface = &caster.surface;
    let continues = path.bounce < paths.max_bounces;
    path.history.casters_since_receiver += 1;
    let interior = path.path_ray.interior;
    let vertex = path.vertex_at_surface(paths, surface, &interior, caster.distance);

    // Add direct light at glossy casters, unless photons carry the light that arrives via this
    // caster.
    if !surface.bsdf.is_specular() && policy.uses_nee && emission::may_add_light_after(policy, path.history) {
        let direct = path.throughput * nee.estimate_direct_light(&vertex, continues, task);
        *radiance += weights.weigh_and_record_light(direct, path, task);
    }
    if !continues && !surface.bsdf.transmits_straight() {
        return false;
    }

    // Follow both branches at a smooth dielectric that the camera sees directly or via mirrors and
    // glass.
    if let Some(split) =
        surface.bsdf.reflect_and_refract(surface.wo, surface.point.ns, surface.point.ng, TransportMode::Radiance)
    {
        let weaker = split.reflected.1.min(split.transmitted.1) * color::channel_mean(path.throughput);
        let has_room = stack.len() < MAX_BRANCHES;
        if has_room && path.history.receivers == 0 && weaker > MIN_SPLIT_THROUGHPUT.max(policy.min_throughput) {
            stack.push(path.after_scattering(surface, split.reflected.0, Rgb::splat(split.reflected.1), false));
            let weight = Rgb::splat(split.transmitted.1 / split.transmitted_radiance_divisor);
            *path = path.after_scattering(surface, split.transmitted.0, weight, true);
            return true;
        }
    }
    continue_path(paths, path, &vertex, task)
}

/// Continues `path` from `vertex` in a sampled direction. Returns false if the path ends there.
///
/// A path that crosses a thin sheet straight on continues as if the sheet were not there: shadow
/// rays of the previous vertex cross the sheet, too.
#[inline]
fn continue_path<I: Interior>(
    paths: &PathContext<'_>,
    path: &mut PathState<I>,
    vertex: &PathVertex<'_, I>,
    task: &mut PathTask,
) -> bool {
    let policy = paths.policy;
    let Some(sample) = scatter::sample(policy.directions, vertex, task) else { return false };
    let mut next = path.after_scattering(vertex.surface, sample.wi, sample.weight, sample.is_transmitted);
    if sample.is_transmitted && vertex.surface.bsdf.transmits_straight() {
        next.bounce = path.bounce;
        next.history.casters_since_receiver -= 1;
        next.prev_nee_vertex = path.prev_nee_vertex;
    } else if path.bounce >= paths.max_bounces {
        // Callers let a path that has made all its bounces come here only to cross a thin sheet,
        // which is no bounce. This path does not cross the sheet.
        return false;
    } else {
        next.prev_nee_vertex = (!sample.is_specular).then_some(PrevVertex {
            p: vertex.surface.point.p,
            hemisphere: vertex.scattering_hemisphere(),
            history: vertex.history,
            pdf: sample.pdf,
        });
    }
    if color::channel_mean(next.throughput) < policy.min_throughput {
        return false;
    }
    let certain = next.history.receivers == 0 && next.bounce <= ROULETTE_BOUNCE;
    if !certain && !next.play_russian_roulette(path.sampler) {
        return false;
    }
    *path = next;
    true
}
