//! Emission that a camera path hits: whether the path may add it, and its MIS weight against
//! next-event estimation.

use super::{PathContext, PathState};
use crate::color::Rgb;
use crate::integrate::nee::NextEventEstimator;
use crate::integrate::policy::PathPolicy;
use crate::integrate::vertex::PathHistory;
use crate::scene::{Effect, Interior, SurfaceInteraction};
use crate::shape::SurfacePoint;
use glam::Vec3;

/// True if a camera path may add the light that it finds next. `history` counts the receivers
/// (surfaces and media that store photons) and casters (such as glass) that the path has visited.
///
/// False if that light forms a caustic and the policy leaves caustics to photons.
#[inline]
pub(super) fn may_add_light_after(policy: &PathPolicy, history: PathHistory) -> bool {
    policy.adds_caustics || !history.is_caustic()
}

/// True if `path` may add the emission of the surface or environment that its ray has just reached.
///
/// False for caustics that photons carry. Also false after next-event estimation if soft shadows
/// are off. Next-event estimation then samples only the centers of lights, without MIS, and carries
/// all their light.
#[inline]
pub(super) fn may_add_hit_emission<I>(policy: &PathPolicy, path: &PathState<I>) -> bool {
    (path.prev_nee_vertex.is_none() || policy.effects.has(Effect::SoftShadows))
        && may_add_light_after(policy, path.history)
}

/// Returns the MIS weight of emission at `hit` against next-event estimation at the previous vertex
/// of `path`; 1 if that vertex sampled no lights, or if `hit` is not on a light.
///
/// The weight is the balance heuristic (Veach 1997, section 9.2.2).
#[inline]
pub(super) fn mis_weight<I>(nee: &NextEventEstimator<'_>, path: &PathState<I>, hit: &SurfaceInteraction<'_>) -> f32 {
    let Some(light) = hit.area_light_index else { return 1.0 };
    balance_weight(nee, path, light as usize, -hit.wo, Some(&hit.point))
}

/// Returns the MIS weight of light number `light`, which the ray of `path` in unit `direction`
/// reaches at `point`; `None` stands for a light at infinity. The weight is 1 if the previous
/// vertex sampled no lights.
#[inline]
fn balance_weight<I>(
    nee: &NextEventEstimator<'_>,
    path: &PathState<I>,
    light: usize,
    direction: Vec3,
    point: Option<&SurfacePoint>,
) -> f32 {
    path.prev_nee_vertex.map_or(1.0, |prev| prev.pdf / (prev.pdf + nee.mis_pdf(&prev, light, direction, point)))
}

/// Returns the radiance \[W/(m² sr)] that `path` adds when its ray leaves the scene. This is the
/// environment's radiance times its MIS weight. Without an environment light, or if its effect is
/// off, it is the background.
///
/// Returns 0 for the background after a receiver (surface or medium that stores photons), because
/// the background lights nothing. Also returns 0 for environment light that photons or next-event
/// estimation carry.
pub(super) fn mis_weighted_escaped_radiance<I: Interior>(paths: &PathContext<'_>, path: &PathState<I>) -> Rgb {
    let PathContext { scene, policy, nee, .. } = *paths;
    let direction = path.path_ray.ray.direction;
    match scene.environment_light_index().filter(|_| policy.effects.has(Effect::Environment)) {
        // The background is visible but lights nothing.
        None if path.history.receivers > 0 => Rgb::ZERO,
        None => scene.background(),
        Some(_) if !may_add_hit_emission(policy, path) => Rgb::ZERO,
        Some(light) => scene.escaped_radiance(direction) * balance_weight(nee, path, light, direction, None),
    }
}
