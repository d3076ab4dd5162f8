//! Pilot (small simulation before the first pass) that finds points visible to the camera. Other
//! pilots guide photon emission and shadow rays by these points.

use super::camera_path::PathContext;
use super::film_points::trace_paths_through_film_points;
use super::indirect_division::IndirectTechnique;
use super::nee::{NextEventEstimator, ShadowRayGuides};
use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::{CameraPathSettings, IndirectPhotons, LightTracing};
use crate::math::Bounds;
use crate::photon::{VisiblePoint, VisiblePointMap};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effects, Scene};
use glam::Vec2;

/// Smallest and largest number of camera rays that find visible points. Between these limits, there
/// are four rays per pixel.
const RAY_COUNT_RANGE: (u32, u32) = (2000, 20_000);

/// Upper bound on the radius around a visible point within which photons count as visible, divided
/// by the diagonal of the bounding box of all visible points. If the visible points are sparse, the
/// radius may exceed this bound.
const MAX_RELATIVE_RADIUS: f32 = 0.1;

/// Returns a map of the points that the camera sees on *receivers* (surfaces that store photons),
/// directly or via casters such as glass or mirrors.
///
/// A photon within `radius` \[length] of such a point counts as visible. The radius is smaller if
/// the visible part of the scene is small, and larger if the found points are sparse.
pub(super) fn find_visible_points(
    scene: &Scene,
    settings: &CameraPathSettings,
    effects: Effects,
    radius: f32,
) -> VisiblePointMap {
    let key = Key::new(settings.seed).purpose_key(Purpose::VisiblePoints);
    let (width, height) = scene.camera().size();
    let rays = width.saturating_mul(height).saturating_mul(4).clamp(RAY_COUNT_RANGE.0, RAY_COUNT_RANGE.1);
    let visible = record_receiver_points(scene, effects, key, rays, PathContinuation::Never, settings.max_bounces);
    let extent = Bounds::from_points(visible.iter().map(|point| point.position)).extent().length();
    let radius = if extent > 0.0 { radius.min(extent * MAX_RELATIVE_RADIUS) } else { radius };
    VisiblePointMap::new(visible, radius)
}

/// Traces `rays` camera paths, and returns the points where they reach *receivers* (surfaces that
/// store photons), in the order of the paths.
///
/// `continuation` selects the receivers from which a path continues. A path ends after
/// `max_bounces` bounces. If a receiver transmits light, its point is returned once for each side.
pub(super) fn record_receiver_points(
    scene: &Scene,
    effects: Effects,
    key: Key,
    rays: u32,
    continuation: PathContinuation,
    max_bounces: u32,
) -> Vec<VisiblePoint> {
    let policy = PathPolicy { continuation, ..path_policy(effects) };
    let nee = NextEventEstimator::new(scene, &policy, ShadowRayGuides::default());
    let paths = PathContext::new(scene, &policy, &nee, None, 0, max_bounces, IndirectTechnique::Paths);
    let (width, height) = scene.camera().size();
    let size = Vec2::new(width as f32, height as f32);
    let samplers = (0..rays).map(|i| Sampler::new(key, i, rays));
    let points: Vec<_> = samplers.map(|sampler| (sampler.get_2d(Dimension::Film) * size, sampler)).collect();
    let (_, tasks) = trace_paths_through_film_points(&paths, &points);
    tasks.into_iter().flat_map(|task| task.records.visible_points).collect()
}

/// Returns the rules of camera paths that record visible points but compute no light.
fn path_policy(effects: Effects) -> PathPolicy {
    PathPolicy {
        effects,
        default_samples_per_pixel: 1,
        passes_share_paths: false,
        uses_nee: false,
        light_sampling: LightSampling::Centers,
        continuation: PathContinuation::Never,
        directions: DirectionSampling::Bsdf,
        adds_caustics: false,
        min_throughput: 0.0,
        lookups: PhotonLookups::RecordVisible,
        shrinking_radii: true,
        light_tracing: LightTracing::Off,
        indirect_photons: IndirectPhotons::Off,
    }
}
