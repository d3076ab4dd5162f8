//! Pilot (small simulation before the first pass) that learns where to place scattering points in
//! homogeneous media: the points from which shadow rays start.
//!
//! Camera paths of the pilot send shadow rays from many points of each segment, and record the
//! light that these rays find. A second part of the pilot finds how many scattering points a
//! segment needs: more points have less noise, but take longer.

use super::balance::{camera_path_work, relative_variance};
use super::camera_path::PathContext;
use super::film_points::{generate_film_points, map_paths_through_film_points, trace_paths_through_film_points};
use super::indirect_division::IndirectTechnique;
use super::nee::{NextEventEstimator, ScatterPointSampling, ShadowRayGuides};
use super::pass_renderer::PassRenderer;
use super::policy::{PathContinuation, PathPolicy, PhotonLookups};
use super::scatter_point_guide::{ScatterPointGuide, ScatterPointGuideFitter};
use crate::color::{self, Rgb};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::Effect;
use crate::stats::Counters;
use glam::Vec2;
use std::sync::Arc;

/// Smallest and largest number of camera paths by which the scatter-point pilot learns where direct
/// light arrives in media. Between these limits, the pilot traces one path per pixel.
const PATH_COUNT_RANGE: (u32, u32) = (2000, 6000);

/// Mean numbers of guided scattering points (starts of shadow rays in media) per camera path that
/// the scatter-point pilot tries. It compares variance times work for these numbers.
const TRIAL_POINTS_PER_PATH: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];

/// Largest acceptable value of variance times work, divided by the lowest value that the
/// scatter-point pilot finds among its trials. The trials differ in the number of scattering points
/// (starts of shadow rays in media). The pilot takes the smallest number with an acceptable value.
///
/// The ratio exceeds 1, because a shadow ray from a medium takes longer than the mean ray of a
/// camera path, so fewer points save more time than the work shows.
const NEGLIGIBLE_LOSS: f64 = 1.15;

/// Efficiency gain above which passes guide shadow rays in media: variance times work of unguided
/// sampling, divided by variance times work of guided sampling.
///
/// The value exceeds 1, because the work counts rays only, and guided points take longer to sample.
const MIN_GAIN: f64 = 1.3;

/// Work and estimated benefit of the pilot (small simulation before the first pass) that learns
/// where direct light arrives in media. Shadow rays find light only there, so most guided shadow
/// rays start there.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ScatterPointGuidingReport {
    /// Number of shadow rays that the pilot traced to learn where direct light arrives in media.
    #[serde(rename = "rays")]
    pub shadow_rays: u64,
    /// Gain in efficiency: variance times work of camera paths if shadow rays in media are
    /// unguided, divided by variance times work if they are guided.
    #[serde(rename = "gain")]
    pub efficiency_gain: f64,
    /// True if the render guides shadow rays in media: most of them then start where direct light
    /// arrives.
    pub used: bool,
}

/// Runs the scatter-point pilot. Returns the method by which passes of `renderer` choose scattering
/// points, from which shadow rays start in homogeneous media. Also returns a report.
///
/// The result depends only on the scene, the policy and the settings. The report is `None` if one
/// of these conditions holds:
///
/// - The settings forbid the pilot, or next-event estimation or media are off.
/// - No homogeneous medium scatters, or no medium gets direct light.
/// - There are no lights, or so many that shadow rays go to randomly chosen ones.
pub(super) fn guide_scatter_points(
    renderer: &PassRenderer<'_>,
) -> (ScatterPointSampling, Option<ScatterPointGuidingReport>) {
    let (scene, policy, settings) = (renderer.scene, &renderer.policy, &renderer.settings);
    let may_guide = policy.uses_nee && policy.effects.has(Effect::Media) && settings.allows_scatter_point_guiding;
    if !may_guide || !scene.media_in_use().iter().any(|medium| medium.is_homogeneous() && medium.scatters()) {
        return (ScatterPointSampling::Unguided, None);
    }
    let lights = NextEventEstimator::new(scene, policy, ShadowRayGuides::default()).always_sampled_light_count();
    if lights == 0 {
        return (ScatterPointSampling::Unguided, None);
    }
    let key = Key::new(settings.camera_paths.seed).purpose_key(Purpose::ScatterPointGuiding);

    let Some(learned) = learn_guide(renderer, key, lights) else { return (ScatterPointSampling::Unguided, None) };
    let shadow_rays = learned.shadow_rays;
    let (sampling, efficiency_gain) = choose_point_count(renderer, key, learned);
    let used = efficiency_gain > MIN_GAIN;
    let sampling = if used { sampling } else { ScatterPointSampling::Unguided };
    (sampling, Some(ScatterPointGuidingReport { shadow_rays, efficiency_gain, used }))
}

/// Learned distribution of scattering points (starts of shadow rays in media), with two results of
/// the scatter-point pilot: the mean radiance that media scatter, and the number of shadow rays.
struct LearnedGuide {
    guide: Arc<ScatterPointGuide>,
    /// Mean radiance that media scatter to a camera path, straight from lights \[W/(m² sr)].
    mean_radiance: f64,
    shadow_rays: u64,
}

/// Learns which parts of media direct light reaches, separately for each of the `lights` lights.
/// Traces camera paths that send shadow rays from many points of media. Returns `None` if no shadow
/// ray finds light.
fn learn_guide(renderer: &PassRenderer<'_>, key: Key, lights: usize) -> Option<LearnedGuide> {
    let (width, height) = renderer.scene.camera().size();
    let size = Vec2::new(width as f32, height as f32);
    let count = width.saturating_mul(height).clamp(PATH_COUNT_RANGE.0, PATH_COUNT_RANGE.1);
    let samplers = (0..count).map(|i| Sampler::new(key, i, count));
    let points: Vec<_> = samplers.map(|sampler| (sampler.get_2d(Dimension::Film) * size, sampler)).collect();
    let policy = PathPolicy { continuation: PathContinuation::Never, lookups: PhotonLookups::Never, ..renderer.policy };
    let tasks = with_path_context(renderer, &policy, ScatterPointSampling::Recorded, |paths| {
        trace_paths_through_film_points(paths, &points).1
    });
    let samples = || tasks.iter().flat_map(|task| &task.records.in_scattering_samples);
    let mean_radiance = samples().map(|sample| sample.contribution).sum::<f64>() / f64::from(count);
    if mean_radiance.is_nan() || mean_radiance <= 0.0 {
        return None;
    }
    let mut fit = ScatterPointGuideFitter::new(samples().map(|sample| sample.p), lights)?;
    samples().for_each(|sample| fit.add(sample));
    Some(LearnedGuide { guide: Arc::new(fit.fitted_guide()), mean_radiance, shadow_rays: samples().count() as u64 })
}

/// Finds the best number of scattering points (points in media from which shadow rays start) for
/// guided sampling. Tries several numbers, and chooses the smallest whose variance times work is
/// close to the lowest value.
///
/// Returns guided sampling with this number, and its gain: variance times work of unguided
/// sampling, divided by variance times work of guided sampling. If the estimates have no noise,
/// returns unguided sampling and 1 (no gain).
fn choose_point_count(renderer: &PassRenderer<'_>, key: Key, learned: LearnedGuide) -> (ScatterPointSampling, f64) {
    let LearnedGuide { guide, mean_radiance, .. } = learned;
    let guided = TRIAL_POINTS_PER_PATH.map(|points| ScatterPointSampling::Guided {
        guide: guide.clone(),
        points_per_radiance: (points / mean_radiance) as f32,
    });

    // Estimate the radiance at film points twice with each sampling.
    let estimate = |sampling: &ScatterPointSampling| {
        [0, 1].map(|set| {
            let points = generate_film_points(renderer.scene, key, set);
            with_path_context(renderer, &renderer.policy, sampling.clone(), |paths| {
                map_paths_through_film_points(paths, &points, false, |radiance, _| radiance)
            })
        })
    };
    let unguided = estimate(&ScatterPointSampling::Unguided);
    let trials = guided.map(|sampling| (estimate(&sampling), sampling));

    // Compare their variance times their work.
    let all = || trials.iter().map(|(estimates, _)| estimates).chain([&unguided]).flatten();
    let mean = |i: usize| all().map(|(radiance, _)| f64::from(color::channel_mean(radiance[i]))).sum::<f64>();
    let light: Vec<f64> = (0..unguided[0].0.len()).map(|i| mean(i) / all().count() as f64).collect();
    let cost = |[(a, work_a), (b, work_b)]: &[(Vec<Rgb>, Counters); 2]| {
        relative_variance(a, b, &light) * (camera_path_work(work_a) + camera_path_work(work_b))
    };
    let lowest = trials.iter().map(|(estimates, _)| cost(estimates)).fold(f64::INFINITY, f64::min);
    let best = trials.iter().find(|(estimates, _)| cost(estimates) <= lowest * NEGLIGIBLE_LOSS);
    match best {
        Some((estimates, sampling)) if lowest > 0.0 => (sampling.clone(), cost(&unguided) / cost(estimates)),
        _ => (ScatterPointSampling::Unguided, 1.0),
    }
}

/// Calls `trace` with a context for camera paths of `policy` that read no photons. `sampling`
/// chooses the scattering points, from which their shadow rays start in media.
fn with_path_context<T>(
    renderer: &PassRenderer<'_>,
    policy: &PathPolicy,
    sampling: ScatterPointSampling,
    trace: impl FnOnce(&PathContext<'_>) -> T,
) -> T {
    let guides = ShadowRayGuides { scatter_points: sampling, ..renderer.guides().clone() };
    let nee = NextEventEstimator::new(renderer.scene, policy, guides);
    let max_bounces = renderer.settings.camera_paths.max_bounces;
    trace(&PathContext::new(renderer.scene, policy, &nee, None, 0, max_bounces, IndirectTechnique::Paths))
}
