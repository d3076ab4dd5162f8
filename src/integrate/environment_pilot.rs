//! Pilot (small simulation before the first pass) for guided sampling of the environment light.
//!
//! Camera paths of the pilot record points of *receivers*, the surfaces that store photons. In each
//! round, shadow rays start from these points towards the environment, guided by the rays of all
//! earlier rounds. The last round measures how much guiding reduces the variance.

use super::environment_guide::{EnvironmentGuide, EnvironmentGuideFitter};
use super::policy::PathContinuation;
use super::visible_pilot::record_receiver_points;
use crate::color::{self, Rgb};
use crate::light::EnvironmentLight;
use crate::math::{Ray, offset_ray_origin};
use crate::photon::VisiblePoint;
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effects, Scene, with_interior_type};
use glam::Vec2;
use rayon::prelude::*;

/// Smallest and largest number of camera paths of the environment-guiding pilot. The pilot's shadow
/// rays start at the surface points that these paths hit. Between the limits, there is one path per
/// pixel.
const PATH_COUNT_RANGE: (u32, u32) = (4000, 8000);

/// Largest number of bounces of the environment-guiding pilot's camera paths. The pilot's shadow
/// rays start at the surface points that these paths hit.
const MAX_BOUNCES: u32 = 2;

/// Number of rounds of shadow rays of the environment-guiding pilot. Each round is guided by the
/// rays of all earlier rounds.
const ROUNDS: u32 = 4;

/// Number of shadow rays that the environment-guiding pilot traces from each recorded surface point
/// in each round.
const RAYS_PER_POINT: u32 = 6;

/// Gain above which passes use guided shadow rays: the second moment of the contributions of
/// unguided rays to the picture, divided by the second moment for guided rays.
///
/// The value exceeds 1, because guided rays take longer to sample, and because camera paths that
/// sample the BSDF find a widely visible environment without shadow rays.
const MIN_GAIN: f64 = 1.5;

/// Fraction of contributing rays above which the environment-guiding pilot ends after its first
/// round, without guiding. A ray contributes if it reaches the environment and adds light to the
/// picture.
///
/// The rays of the first round are unguided. If many of them contribute, the sky is widely visible,
/// and camera paths that sample the BSDF find it well.
const MAX_CONTRIBUTING_FRACTION: f64 = 0.25;

/// Work and estimated benefit of the pilot (small simulation before the first pass) that guides
/// shadow rays to the environment light.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct EnvironmentGuidingReport {
    /// Number of shadow rays that the pilot traced.
    #[serde(rename = "rays")]
    pub shadow_rays: u64,
    /// Fraction in \[0, 1] of unguided shadow rays that reach the environment and contribute to the
    /// picture.
    #[serde(rename = "unoccluded")]
    pub contributing_fraction: f64,
    /// Gain of guiding: the second moment of the contributions of unguided shadow rays to the
    /// picture, divided by the second moment for guided rays. The gain is set to 1 (no gain) if no
    /// ray contributes. It is also set to 1 if the pilot ends after the first round, before it
    /// measures the gain.
    #[serde(rename = "gain")]
    pub variance_gain: f64,
    /// True if the render guides shadow rays to the environment light.
    pub used: bool,
}

/// Shadow ray towards the environment that the environment-guiding pilot traced.
struct PilotRay {
    /// Index of the recorded surface point from which the ray starts.
    point: usize,
    /// Point in \[0, 1)² that the environment light maps to the ray's direction.
    u: Vec2,
    /// Pdf of `u` over the unit square.
    u_pdf: f32,
    /// Contribution of the ray to the picture, weighted as if unguided sampling had chosen the
    /// ray's direction; 0 if the ray is occluded.
    unguided_contribution: f64,
}

/// Runs the environment-guiding pilot. Returns learned distributions of shadow-ray directions to
/// the environment `light` of `scene`, and a report. The distributions are `None` if they would not
/// reduce the noise enough.
///
/// The result depends only on the scene, `effects` and `seed`.
pub(super) fn guide_environment_light(
    scene: &Scene,
    light: &EnvironmentLight,
    effects: Effects,
    seed: u64,
) -> (Option<EnvironmentGuide>, EnvironmentGuidingReport) {
    let key = Key::new(seed).purpose_key(Purpose::EnvironmentGuiding);
    let (width, height) = scene.camera().size();
    let paths = width.saturating_mul(height).clamp(PATH_COUNT_RANGE.0, PATH_COUNT_RANGE.1);
    let points =
        record_receiver_points(scene, effects, key.training_round_key(0), paths, PathContinuation::Always, MAX_BOUNCES);
    let mut fit = EnvironmentGuideFitter::new(&points.iter().map(|point| point.position).collect::<Vec<_>>());
    let mut report = EnvironmentGuidingReport { variance_gain: 1.0, ..EnvironmentGuidingReport::default() };
    let mut guide = None;
    for round in 1..=ROUNDS {
        let rays = trace_round(scene, light, &points, guide.as_ref(), effects, key.training_round_key(round));
        report.shadow_rays += rays.len() as u64;
        if round == 1 {
            let unoccluded = rays.iter().filter(|ray| ray.unguided_contribution > 0.0).count();
            report.contributing_fraction = unoccluded as f64 / rays.len().max(1) as f64;
            if report.contributing_fraction > MAX_CONTRIBUTING_FRACTION {
                return (None, report);
            }
        }
        if round == ROUNDS {
            report.variance_gain = guiding_variance_gain(&rays);
        }
        for ray in &rays {
            fit.add(points[ray.point].position, ray.u, ray.unguided_contribution * ray.unguided_contribution);
        }
        guide = fit.fitted_guide();
    }
    report.used = guide.is_some() && report.variance_gain > MIN_GAIN;
    (guide.filter(|_| report.used), report)
}

/// Traces the shadow rays of one round of the environment-guiding pilot. Returns them in the order
/// of the points from which they start.
fn trace_round(
    scene: &Scene,
    light: &EnvironmentLight,
    points: &[VisiblePoint],
    guide: Option<&EnvironmentGuide>,
    effects: Effects,
    key: Key,
) -> Vec<PilotRay> {
    let count = u32::try_from(points.len()).unwrap_or(u32::MAX).saturating_mul(RAYS_PER_POINT);
    let ray = |index: u32| {
        let point = (index / RAYS_PER_POINT) as usize;
        let VisiblePoint { position: p, position_error, normal, weight } = points[point];
        let u = Sampler::new(key, index, count).get_2d(Dimension::LightPosition);
        let (u, u_pdf) = guide.map_or((u, 1.0), |guide| guide.sample_unit_square(p, u));
        let contribution = light.sample(u).map_or(0.0, |(wi, pdf)| {
            let cosine = wi.dot(normal);
            let origin = offset_ray_origin(p, position_error, normal, wi);
            if cosine <= 0.0 {
                return 0.0;
            }
            let transmittance = transmittance_to_environment(scene, &Ray::new(origin, wi), effects, key);
            let radiance = light.radiance(wi) * transmittance;
            f64::from(weight * cosine) * f64::from(color::channel_mean(radiance) / pdf)
        });
        PilotRay { point, u, u_pdf, unguided_contribution: contribution }
    };
    (0..count).into_par_iter().map(ray).collect()
}

/// Returns the transmittance along `ray` to the environment. The result is 1 if nothing blocks the
/// ray, and 0 if an opaque surface does.
///
/// Shadow rays pass only null interfaces and thin sheets. A ray that meets no surface counts as
/// unattenuated, even if it starts in a medium.
fn transmittance_to_environment(scene: &Scene, ray: &Ray, effects: Effects, key: Key) -> Rgb {
    if !scene.occluded(ray) {
        return Rgb::ONE;
    }
    let Some(light) = scene.environment_light_index() else { return Rgb::ZERO };
    if !scene.shadow_rays_cross_surfaces() {
        return Rgb::ZERO;
    }
    with_interior_type!(effects, <I> {
        // Start at the light, outside all bodies. Crossed boundaries reveal the bodies around the
        // ray's origin.
        let interior = scene.start_light_path::<I>(light, *ray, effects).interior;
        scene.shadow_transmittance(ray, interior, effects, key)
    })
}

/// Returns the gain of guiding: the second moment of the contributions of unguided shadow rays to
/// the picture, divided by the second moment for guided rays. Both moments are estimated from the
/// guided `rays`. Returns 1 (no gain) if no ray contributes.
fn guiding_variance_gain(rays: &[PilotRay]) -> f64 {
    let (mut unguided, mut guided) = (0.0, 0.0);
    for ray in rays {
        let (square, pdf) = (ray.unguided_contribution * ray.unguided_contribution, f64::from(ray.u_pdf));
        unguided += square / pdf;
        guided += square / (pdf * pdf);
    }
    if guided > 0.0 { unguided / guided } else { 1.0 }
}
