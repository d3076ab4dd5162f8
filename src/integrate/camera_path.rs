//! Camera paths: the path-tracing loop of every algorithm except `raycast`.
//!
//! A *receiver* is a surface or medium that stores photons, such as a diffuse wall. A *caster*
//! passes photons on, such as a mirror or glass; [`PhotonKind`](crate::photon::PhotonKind) has the
//! exact definitions. If the policy leaves caustics to photons, a camera path ignores emission that
//! it hits after a receiver and one or more casters. So no light path counts twice.
//!
//! A path's inputs are a [`PathContext`], which all paths of a pass share, and a [`CameraRay`]. Its
//! state between two vertices is a [`PathState`]. A [`PathTask`] collects the paths' ray counts,
//! light groups and pilot records. [`indirect_division`](super::indirect_division) lists the fields
//! by which camera paths and photon estimates share indirect light.

mod media;

use super::camera_ray::CameraRay;
use super::indirect_division::{IndirectTechnique, IndirectWeights};
use super::light_group::LightGroup;
use super::nee::NextEventEstimator;
use super::path_task::PathTask;
use super::photon_maps::{PhotonMapChoice, PhotonMaps};
use super::policy::{DirectionSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::prefix_rays::PrefixWeights;
use super::scatter;
use super::vertex::{PathHistory, PathVertex, PrevVertex};
use crate::bsdf::TransportMode;
use crate::color::{self, Rgb};
use crate::medium::PhaseFunction;
use crate::photon::VisiblePoint;
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Effect, Interior, PathEvent, PathRay, Scene, SurfaceInteraction, SurfaceVertex};
use glam::Vec3;

/// Throughput of the fainter branch, as a mean over RGB, above which a camera path follows both
/// branches at a smooth dielectric: the reflected and the refracted one.
///
/// If the fainter branch has less throughput, the path samples one of the two branches.
const MIN_SPLIT_THROUGHPUT: f32 = 0.001;

/// Throughput, as a mean over RGB, below which Russian roulette may end a camera path.
const ROULETTE_THROUGHPUT: f32 = 0.125;

/// Number of bounces without Russian roulette, for a camera path that has met only mirrors, glass
/// and other specular or glossy casters.
const ROULETTE_BOUNCE: u32 = 8;

/// Largest number of reflected branches of one camera path that wait on the stack to be traced.
const MAX_BRANCHES: usize = 16;

/// Gather radius \[length] that stands in for the radius of the indirect map if a pass has no
/// photon maps. [`PathContext::min_gather_distance`] is a multiple of it.
const FALLBACK_GATHER_RADIUS: f32 = 1.0;

/// Smallest length of a final-gathering ray that reads the indirect map at its end, divided by the
/// map's gather radius.
///
/// At the end of a shorter ray, the blur of the map would show. The path then continues instead.
const MIN_RELATIVE_GATHER_DISTANCE: f32 = 2.0;

/// Scene, policy, photon maps and limits that all camera paths of a pass share.
pub(super) struct PathContext<'a> {
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
    technique: IndirectTechnique<'a>,
    /// Length above which a final-gathering ray reads the indirect map at its end \[length].
    min_gather_distance: f32,
}

/// State of a camera path between two vertices. At a smooth dielectric, a path splits into a
/// reflected and a refracted branch; each branch then has a state of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathState<I> {
    path_ray: PathRay<I>,
    /// Factor from radiance that arrives along the ray to radiance of the pixel.
    throughput: Rgb,
    bounce: u32,
    history: PathHistory,
    /// Factor by which the next vertex multiplies the throughput. On the ray that leaves the path's
    /// first receiver (surface or medium that stores photons), the factor is
    /// [`IndirectWeights::continued_path_factor`], because photon estimates may carry a part of the
    /// indirect light. On all other rays, the factor is 1.
    ///
    /// Emission at the next vertex is direct light of the receiver, so the path adds that emission
    /// before it applies the factor.
    pending_weight: f32,
    /// True if the path's indirect light is divided: this path finds a part of that light, and a
    /// photon estimate at the path's first receiver the rest. False before the first receiver.
    shares_indirect: bool,
    /// Previous vertex, if next-event estimation there could have sampled the light that the path
    /// hits next. `None` at the camera, after a specular bounce, and beyond a boundary that blocks
    /// shadow rays.
    prev_nee_vertex: Option<PrevVertex>,
    /// Sampler of the next vertex's random decisions.
    sampler: Sampler,
}

/// Weights of the light that one camera path finds. Weights are needed because other paths of the
/// pixel, and photon estimates, find some of the same light.
struct PathWeights {
    /// Weights of the light up to the first receiver (a surface or medium that stores photons).
    prefix: PrefixWeights,
    /// Weights of camera paths and of photon estimates for the indirect light at the first
    /// receiver.
    indirect: IndirectWeights,
}

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
    let weights = PathWeights {
        prefix: camera_ray.prefix_weights,
        indirect: paths.technique.technique_weights(camera_ray.weight_lookup_position),
    };
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
                    if media::scatter_in_medium(&mut path, phase, weights.indirect) {
                        continue;
                    }
                    break;
                }
                PathEvent::Escaped { crossed_hidden_boundary } => {
                    path.count_crossed_boundary(crossed_hidden_boundary);
                    let escaped = path.throughput * mis_weighted_escaped_radiance(paths, &path);
                    radiance += weigh_and_record_light(escaped, &path, &weights, task);
                    break;
                }
            };
            path.throughput *= hit.absorption_and_wavelength_weight;
            path.count_crossed_boundary(hit.crossed_hidden_boundary);

            // Add emission, weighted by MIS against next-event estimation at the previous vertex.
            if hit.surface.emission != Rgb::ZERO && may_add_hit_emission(policy, &path) {
                let weight = path.prev_nee_vertex.map_or(1.0, |prev| emission_mis_weight(nee, &prev, &hit.surface));
                let found = path.throughput * hit.surface.emission * weight;
                radiance += weigh_and_record_light(found, &path, &weights, task);
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
    let survival = color::channel_mean(path.throughput) / ROULETTE_THROUGHPUT;
    if survival < 1.0 && policy.min_throughput == 0.0 {
        if path.sampler.get_1d(Dimension::ShadingRoulette) >= survival {
            return false;
        }
        path.throughput /= survival;
    }
    if policy.directions == DirectionSampling::OneLobe {
        receiver.surface.bsdf = receiver.surface.bsdf.select_lobe(path.sampler.get_1d(Dimension::ReceiverBranch));
    }
    let surface = &receiver.surface;
    let interior = path.path_ray.interior;
    let vertex = path.vertex_at_surface(paths, surface, &interior, receiver.distance);
    let ends_gather_ray = ends_gather_ray(paths, &vertex);
    let shares_indirect = shares_indirect_light(weights.indirect, vertex.history);
    let continues = path.bounce < paths.max_bounces
        && (!shares_indirect || is_path_continued(weights.indirect, vertex.sampler))
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
    let reflected = direct + photon_radiance(paths, weights, &vertex, ends_gather_ray, task);
    *radiance += path.throughput * reflected;
    if path.shares_indirect {
        task.records.light.indirect_by_paths += path.throughput * reflected;
    }

    // Continue in a sampled direction.
    path.history = PathHistory { receivers: path.history.receivers + 1, casters_since_receiver: 0 };
    if !(continues && continue_path(paths, path, &vertex, task)) {
        return false;
    }
    if shares_indirect {
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
    if !surface.bsdf.is_specular() && policy.uses_nee && may_add_light_after(policy, path.history) {
        let direct = path.throughput * nee.estimate_direct_light(&vertex, continues, task);
        *radiance += weigh_and_record_light(direct, path, weights, task);
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

/// Returns the radiance that `vertex` reflects towards the previous vertex, estimated from photon
/// maps \[W/(m² sr)]. Also adds the radiance, times the throughput, to the light that `task`
/// records.
///
/// If only a few paths of a pixel read the maps, the radiance is scaled up to stand for the pixel's
/// other paths. Returns 0 if the policy reads no map at `vertex`. With
/// [`PhotonLookups::RecordVisible`], records `vertex` as a visible point and returns 0.
#[inline]
fn photon_radiance<I: Interior>(
    paths: &PathContext<'_>,
    weights: &PathWeights,
    vertex: &PathVertex<'_, I>,
    ends_gather_ray: bool,
    task: &mut PathTask,
) -> Rgb {
    let lookup_scale = match paths.policy.lookups {
        PhotonLookups::Never => return Rgb::ZERO,
        PhotonLookups::FewPerPixel => match vertex.sampler.sample_index_and_count() {
            (index, samples) if vertex.history.receivers == 0 && index < weights.prefix.lookup_count => {
                samples as f32 * weights.prefix.lookup_weight
            }
            _ => return Rgb::ZERO,
        },
        PhotonLookups::FirstReceiver | PhotonLookups::GatherRays => 1.0,
        PhotonLookups::RecordVisible => {
            record_visible_point(vertex, task);
            return Rgb::ZERO;
        }
    };
    let before_gather_ray = paths.policy.lookups == PhotonLookups::GatherRays && !ends_gather_ray;
    let lookup = if before_gather_ray { PhotonMapChoice::Caustic } else { PhotonMapChoice::CausticAndIndirect };
    let estimate = paths.maps.map_or(Rgb::ZERO, |maps| maps.radiance(vertex, lookup, lookup_scale, task));
    let interreflection = if shares_indirect_light(weights.indirect, vertex.history) {
        let lookup_scale = lookup_scale * weights.indirect.photon_weight;
        paths.maps.map_or(Rgb::ZERO, |maps| maps.interreflection_radiance(vertex, lookup_scale, task))
    } else {
        Rgb::ZERO
    };
    let estimate = estimate + interreflection;
    task.records.light.photon_estimates += vertex.throughput * estimate;
    task.pixel.photon_radiance += vertex.throughput * estimate;
    estimate
}

/// True if a photon estimate carries part or all of the indirect light that does not come from
/// caustics. This happens only at the first receiver (surface or medium that stores photons) of a
/// camera path.
///
/// `history` counts the receivers and casters on the path before this vertex.
#[inline]
fn shares_indirect_light(weights: IndirectWeights, history: PathHistory) -> bool {
    weights.photon_weight > 0.0 && history.receivers == 0
}

/// True if the camera path continues beyond its first receiver, the surface or medium that stores
/// photons. `sampler` is the sampler of the path's vertex there.
///
/// If photon estimates carry part of the indirect light at the receiver, only some of a pixel's
/// paths continue.
#[inline]
fn is_path_continued(weights: IndirectWeights, sampler: Sampler) -> bool {
    weights.continues_at_receiver(sampler.sample_index_and_count(), sampler.get_1d(Dimension::ReceiverBranch))
}

/// Returns `light` times its weight, and adds the weighted light to the light that `task` records.
/// `light` is a contribution to the pixel that `path` found: emission that it hit, or direct light
/// at a glossy surface such as rough glass.
///
/// Before the first receiver (surface or medium that stores photons), `light` has a weight of
/// [`PrefixWeights`], because extra camera paths of the pixel find the same light. Later, its
/// weight is 1.
#[inline]
fn weigh_and_record_light<I>(light: Rgb, path: &PathState<I>, weights: &PathWeights, task: &mut PathTask) -> Rgb {
    if path.history.receivers > 0 {
        if path.history.receivers > 1 && path.shares_indirect {
            task.records.light.indirect_by_paths += light;
        }
        task.pixel.groups.add(LightGroup::of_found_light(path.history), light);
        return light;
    }
    let weighted = light * weights.prefix.up_to_receiver;
    task.records.light.up_to_receiver += weighted;
    task.pixel.groups.add(LightGroup::Direct, weighted);
    weighted
}

/// Records `vertex` in `task` as a point that the camera sees, once for each side from which it
/// scatters light.
///
/// The weight of the point is the importance of photons on that side: the throughput times the BSDF
/// for light along the normal, averaged over RGB.
fn record_visible_point<I: Interior>(vertex: &PathVertex<'_, I>, task: &mut PathTask) {
    let surface = vertex.surface;
    for normal in surface.light_side_normals() {
        let bsdf = surface.bsdf.evaluate(surface.wo, normal, normal, normal, TransportMode::Radiance);
        task.records.visible_points.push(VisiblePoint {
            position: surface.point.p,
            position_error: surface.point.position_error,
            normal,
            weight: color::channel_mean(vertex.throughput * bsdf),
        });
    }
}

/// True if `vertex` ends a final-gathering ray that is long enough for a lookup in the indirect
/// map.
#[inline]
fn ends_gather_ray<I>(paths: &PathContext<'_>, vertex: &PathVertex<'_, I>) -> bool {
    paths.policy.continuation == PathContinuation::GatherRays
        && vertex.history.receivers > 0
        && vertex.distance > paths.min_gather_distance
}

/// True if a camera path may add the light that it finds next. `history` counts the receivers
/// (surfaces and media that store photons) and casters (such as glass) that the path has visited.
///
/// False if that light forms a caustic and the policy leaves caustics to photons.
#[inline]
fn may_add_light_after(policy: &PathPolicy, history: PathHistory) -> bool {
    policy.adds_caustics || !history.is_caustic()
}

/// True if `path` may add the emission of the surface or environment that its ray has just reached.
///
/// False for caustics that photons carry. Also false after next-event estimation if soft shadows
/// are off. Next-event estimation then samples only the centers of lights, without MIS, and carries
/// all their light.
#[inline]
fn may_add_hit_emission<I>(policy: &PathPolicy, path: &PathState<I>) -> bool {
    (path.prev_nee_vertex.is_none() || policy.effects.has(Effect::SoftShadows))
        && may_add_light_after(policy, path.history)
}

/// Returns the MIS weight of emission at `hit` against next-event estimation at `prev`; 1 if `hit`
/// is not on a light.
///
/// The weight is the balance heuristic (Veach 1997, section 9.2.2).
#[inline]
fn emission_mis_weight(nee: &NextEventEstimator<'_>, prev: &PrevVertex, hit: &SurfaceInteraction<'_>) -> f32 {
    let Some(light) = hit.area_light_index else { return 1.0 };
    prev.pdf / (prev.pdf + nee.mis_pdf(prev, light as usize, -hit.wo, Some(&hit.point)))
}

/// Returns the radiance \[W/(m² sr)] that `path` adds when its ray leaves the scene. This is the
/// environment's radiance times its MIS weight. Without an environment light, or if its effect is
/// off, it is the background.
///
/// Returns 0 for the background after a receiver (surface or medium that stores photons), because
/// the background lights nothing. Also returns 0 for environment light that photons or next-event
/// estimation carry.
fn mis_weighted_escaped_radiance<I: Interior>(paths: &PathContext<'_>, path: &PathState<I>) -> Rgb {
    let PathContext { scene, policy, nee, .. } = *paths;
    let direction = path.path_ray.ray.direction;
    match scene.environment_light_index().filter(|_| policy.effects.has(Effect::Environment)) {
        // The background is visible but lights nothing.
        None if path.history.receivers > 0 => Rgb::ZERO,
        None => scene.background(),
        Some(_) if !may_add_hit_emission(policy, path) => Rgb::ZERO,
        Some(light) => {
            let light_pdf = |prev: PrevVertex| nee.mis_pdf(&prev, light, direction, None);
            let weight = path.prev_nee_vertex.map_or(1.0, |prev| prev.pdf / (prev.pdf + light_pdf(prev)));
            scene.escaped_radiance(direction) * weight
        }
    }
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
}

impl<I: Interior> PathState<I> {
    /// Sets the weight of the indirect light that this path will find beyond its first receiver,
    /// the surface or medium that stores photons. Photon estimates carry the rest of that light.
    ///
    /// `sampler` is the sampler of the path's vertex at the receiver.
    #[inline]
    fn share_indirect_with_photons(&mut self, weights: IndirectWeights, sampler: Sampler) {
        let (_, samples) = sampler.sample_index_and_count();
        self.pending_weight = weights.continued_path_factor(samples);
        self.shares_indirect = true;
    }

    /// Returns the state of a new path that starts with `camera_ray`.
    fn from_camera_ray(paths: &PathContext<'_>, camera_ray: &CameraRay) -> Self {
        let CameraRay { ray, sampler, .. } = *camera_ray;
        let mut path_ray: PathRay<I> = paths.scene.start_camera_path(ray, paths.policy.effects);
        path_ray.interior.set_wavelength_sample(paths.scene, || sampler.get_1d(Dimension::Wavelength));
        let history = PathHistory::default();
        Self {
            path_ray,
            throughput: Rgb::ONE,
            bounce: 0,
            history,
            pending_weight: 1.0,
            shares_indirect: false,
            prev_nee_vertex: None,
            sampler,
        }
    }

    /// Counts a crossed boundary as one of `history.casters_since_receiver`, and clears
    /// `prev_nee_vertex`. Does nothing if `crossed_hidden_boundary` is false.
    ///
    /// A hidden boundary lies inside a body of higher priority. It blocks shadow rays, but not
    /// camera rays. So next-event estimation could not have sampled the light beyond it.
    #[inline]
    fn count_crossed_boundary(&mut self, crossed_hidden_boundary: bool) {
        if crossed_hidden_boundary {
            self.history.casters_since_receiver += 1;
            self.prev_nee_vertex = None;
        }
    }

    /// Returns the vertex of this path at `surface`, which is `distance` \[length] from the
    /// previous vertex. `interior` holds the nested bodies on the side from which the path arrives.
    fn vertex_at_surface<'v>(
        &self,
        paths: &PathContext<'_>,
        surface: &'v SurfaceInteraction<'v>,
        interior: &'v I,
        distance: f32,
    ) -> PathVertex<'v, I> {
        let shadow_sampler = self.sampler.shadow_ray_sampler(paths.pass);
        let Self { history, throughput, sampler, .. } = *self;
        PathVertex { surface, interior, history, throughput, distance, sampler, shadow_sampler }
    }

    /// Returns the state of the path after it leaves `surface` in unit `direction`.
    /// `prev_nee_vertex` is `None`, as after a specular bounce; the caller sets it after other
    /// bounces.
    ///
    /// `weight` is the product of the BSDF and the cosine, divided by the pdf of the direction.
    #[inline]
    fn after_scattering(
        &self,
        surface: &SurfaceInteraction<'_>,
        direction: Vec3,
        weight: Rgb,
        transmitted: bool,
    ) -> Self {
        let mut path_ray = self.path_ray;
        let weight = weight * path_ray.leave_surface_with_wavelength_weight(surface, direction, transmitted);
        let sampler = self.sampler.next_vertex_sampler(self.bounce, transmitted);
        let throughput = self.throughput * weight;
        Self { path_ray, throughput, bounce: self.bounce + 1, prev_nee_vertex: None, sampler, ..*self }
    }

    /// Plays Russian roulette by the path's throughput. Returns false if the path ends.
    ///
    /// If the path survives, its throughput is divided by the survival probability. `sampler`
    /// provides the random number.
    #[inline]
    fn play_russian_roulette(&mut self, sampler: Sampler) -> bool {
        let survival = (color::channel_mean(self.throughput) / ROULETTE_THROUGHPUT).min(1.0);
        if survival.is_nan() || sampler.get_1d(Dimension::Roulette) >= survival {
            return false;
        }
        self.throughput /= survival;
        true
    }
}
