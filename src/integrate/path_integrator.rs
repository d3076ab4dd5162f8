//! Integrator of all algorithms that a [`PathPolicy`](super::policy::PathPolicy) describes: all
//! except `raycast`.

use super::adaptive_pilot::find_relative_ray_counts;
use super::balance::RayPhotonBalance;
use super::camera_path::trace_camera_path;
use super::environment_pilot::EnvironmentGuidingReport;
use super::film_sampling::FilmSampling;
use super::indirect_division::IndirectDivision;
use super::indirect_pilot::divide_indirect_light;
use super::integrator::Integrator;
use super::light_group::LightGroup;
use super::map_builder::MapBuildOptions;
use super::nee::ShadowRayGuides;
use super::pass::{ExpectedPhotons, PassResult, ProgressMonitor, SilentMonitor};
use super::pass_renderer::PassRenderer;
use super::policy::{PathContinuation, PathPolicy, PolicyFn};
use super::prefix_pilot::find_prefix_ray_counts;
use super::prefix_rays::PrefixRayAllocation;
use super::radius_law::RadiusLaw;
use super::radius_pilot::{EmissionGuidingReports, GatherRadii};
use super::scatter_point_pilot::{ScatterPointGuidingReport, guide_scatter_points};
use super::settings::{CameraPathSettings, IndirectPhotons, Settings};
use super::shutter::{ShutterSlice, SlicedCameras};
use super::tiles::render_tiles;
use super::work_pilot::{estimate_pass_counters, find_ray_photon_balance};
use crate::photon::{add_splats, add_splats_across_seams};
use crate::plan::Plan;
use crate::sampling::{Key, Purpose};
use crate::scene::{Effect, Effects, Scene, with_interior_type};
use crate::stats::Counters;
use glam::Vec2;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Integrator of all algorithms that a [`PathPolicy`](super::policy::PathPolicy) describes: all
/// except `raycast`.
#[derive(Debug)]
pub(super) struct PathIntegrator<'a> {
    renderer: PassRenderer<'a>,
    plan: Plan,
    /// Function that makes the algorithm's path policy for a set of effects.
    make_policy: PolicyFn,
    /// Report of the pilot (small simulation before the first pass) that guides shadow rays to the
    /// environment light; `None` if no such pilot ran.
    environment_guiding: Option<EnvironmentGuidingReport>,
    /// Report of the pilot (small simulation before the first pass) that learns where direct light
    /// arrives in media, so that shadow rays start there. `None` if no such pilot ran, or if it
    /// found no light in media.
    scatter_point_guiding: Option<ScatterPointGuidingReport>,
    balance: Option<RayPhotonBalance>,
    /// Number of slices of the shutter interval in each pass. Each slice has its own photons and
    /// camera rays.
    shutter_slice_count: u32,
}

impl Integrator for PathIntegrator<'_> {
    fn render_pass(&self, pass: u32, monitor: &dyn ProgressMonitor) -> PassResult {
        let mut out = PassResult::default();

        // Move the scene to the time of each slice of the shutter interval.
        let renderer = &self.renderer;
        let slices = (0..self.shutter_slice_count).map(|index| ShutterSlice { index, count: self.shutter_slice_count });
        let seed = renderer.settings.camera_paths.seed;
        let scenes: Vec<Scene> = if renderer.has_motion() {
            slices.clone().map(|slice| renderer.scene.at_time(slice.time(seed, pass))).collect()
        } else {
            Vec::new()
        };
        let moved: Vec<PassRenderer<'_>> = scenes.iter().map(|scene| renderer.for_scene_at_time(scene)).collect();
        let renderers = if moved.is_empty() { std::slice::from_ref(renderer) } else { &moved[..] };

        // Trace and index photons.
        let (mut maps_of_slices, mut splats) = (Vec::new(), Vec::new());
        for (slice_renderer, slice) in renderers.iter().zip(slices) {
            let map_builder = &slice_renderer.map_builder;
            let options = MapBuildOptions::for_slice(seed, pass, slice);
            let mut slice_maps = map_builder.traces_photons().then(|| map_builder.build(&options, monitor, &mut out));
            if let Some(maps) = &mut slice_maps {
                // Average over slices: each slice estimates the light of the whole shutter
                // interval.
                let share = 1.0 / slice.count as f32;
                maps.splats.par_iter_mut().for_each(|splat| splat.integrated_radiance *= share);
                splats.append(&mut maps.splats);
            }
            maps_of_slices.push(slice_maps);
        }

        // Trace camera paths.
        let start = Instant::now();
        let inputs = renderers.iter().zip(&maps_of_slices);
        let paths: Vec<_> = inputs.map(|(renderer, maps)| renderer.path_context(maps.as_ref(), pass)).collect();
        let key = renderer.camera_path_key(pass);
        let cameras = || (self.shutter_slice_count > 1).then(|| sliced_cameras(renderers, pass));
        let settings = &renderer.settings.camera_paths;
        let CameraPathSettings { groups_light, clamp, .. } = *settings;
        let window = settings.window(renderer.scene.camera().size());
        let sampling =
            FilmSampling { slices: cameras(), groups_light, window, clamp, ..renderers[0].film_sampling(pass) };
        let render_camera_paths = |sampling: &FilmSampling<'_>, key: Key, monitor: &dyn ProgressMonitor| {
            with_interior_type!(paths[0].policy.effects, <I> {
                render_tiles(sampling, key, monitor, |camera_ray, task, branches| {
                    trace_camera_path::<I>(&paths[camera_ray.shutter_slice], camera_ray, task, branches)
                })
            })
        };
        let picture = render_camera_paths(&sampling, key, monitor);
        (out.image, out.nested, out.light_groups) = (picture.image, picture.nested, picture.light_groups);
        out.removed_by_clamp = picture.removed_by_clamp;
        out.counters += picture.counters;

        // Add the light that photons sent to the camera.
        if !splats.is_empty() {
            add_splats_across_seams(&mut splats, renderer.scene.camera(), &settings.filter);
            // Moving by whole pixels is exact for all splats that reach the window.
            let corner = Vec2::new(window.left as f32, window.top as f32);
            splats.par_iter_mut().for_each(|splat| splat.film_position -= corner);
            let (width, _) = window.size();
            if let Some(caustic) = out.light_groups.get_mut(LightGroup::Caustic as usize) {
                add_splats(splats.clone(), &settings.filter, width, caustic);
            }
            add_splats(splats, &settings.filter, width, &mut out.image);
        }

        // If passes share camera paths, trace some tiles a second time by unshared paths.
        if let Some((sampling, key)) = renderers[0].unshared_path_sampling(pass, cameras()) {
            let unshared = render_camera_paths(&sampling, key, &SilentMonitor);
            out.unshared_path_pixels =
                unshared.rendered_pixel_indices.iter().map(|i| (*i, unshared.image[*i as usize])).collect();
        }
        out.seconds.camera += start.elapsed().as_secs_f64();
        out
    }

    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn expected_work(&self, effects: Effects) -> Counters {
        let policy = (self.make_policy)(effects, &self.renderer.settings);
        let mut work = estimate_pass_counters(&self.renderer.with_policy(policy));
        // Count the work of prefix rays as work of this effect, because most of them follow
        // specular surfaces.
        if effects.has(Effect::Specular)
            && let Some(prefix_rays) = &self.renderer.prefix_rays
        {
            work += prefix_rays.expected_work;
        }
        work
    }

    fn expected_photons(&self) -> ExpectedPhotons {
        self.renderer.map_builder.expected_photons()
    }

    fn ray_photon_balance(&self) -> Option<RayPhotonBalance> {
        self.balance
    }

    fn prefix_rays_per_pixel(&self) -> f64 {
        self.renderer.prefix_rays.as_ref().map_or(0.0, PrefixRayAllocation::mean_rays_per_pixel)
    }

    fn interreflection_photon_weight(&self, pass: u32) -> f64 {
        self.renderer.map_builder.technique_of_pass(pass).mean_photon_weight()
    }

    fn initial_gather_radii(&self) -> Option<GatherRadii> {
        self.renderer.map_builder.radii
    }

    fn radius_law(&self) -> Option<RadiusLaw> {
        let map_builder = &self.renderer.map_builder;
        map_builder.traces_photons().then(|| map_builder.radius_law())
    }

    fn estimates_error(&self) -> bool {
        self.renderer.settings.camera_paths.estimate_error
    }

    fn groups_light(&self) -> bool {
        self.renderer.settings.camera_paths.groups_light
    }

    fn clamps_light(&self) -> bool {
        self.renderer.settings.camera_paths.clamp.is_some()
    }

    fn omits_light_from_media(&self) -> bool {
        let PathPolicy { effects, continuation, .. } = self.renderer.policy;
        let finds_it = match continuation {
            PathContinuation::Always | PathContinuation::GatherRays => true,
            PathContinuation::Never | PathContinuation::Glossy => false,
        };
        !finds_it && effects.has(Effect::Media) && self.renderer.scene.has_emitting_media()
    }

    fn environment_guiding_report(&self) -> Option<EnvironmentGuidingReport> {
        self.environment_guiding
    }

    fn scatter_point_guiding_report(&self) -> Option<ScatterPointGuidingReport> {
        self.scatter_point_guiding
    }

    fn emission_guiding_reports(&self) -> EmissionGuidingReports {
        self.renderer.map_builder.emission_guiding_reports
    }
}

impl<'a> PathIntegrator<'a> {
    /// Makes an integrator for `scene`.
    ///
    /// Runs the pilots (small simulations). They guide photon emission and shadow rays, find gather
    /// radii, and divide the work between camera rays and photons.
    pub fn new(scene: &'a Scene, plan: Plan, settings: Settings, make_policy: PolicyFn) -> Self {
        let (effects, needed) = (plan.simulated_effects(), plan.needed_and_simulated_effects());
        let policy = make_policy(effects, &settings);
        let mut renderer = PassRenderer::new(scene, settings.clone(), policy);

        // Guide shadow rays to the environment light.
        let needed_policy = || (needed != effects).then(|| make_policy(needed, &settings));
        let (guides, environment_guiding) = run_pilot(&renderer, needed_policy(), PassRenderer::find_environment_guide);
        renderer.set_guides(guides);

        // Guide shadow rays from media.
        let (scatter_points, scatter_point_guiding) = run_pilot(&renderer, needed_policy(), guide_scatter_points);
        renderer.set_guides(ShadowRayGuides { scatter_points, ..renderer.guides().clone() });

        // Divide indirect light between camera paths and photons.
        let weighs = policy.indirect_photons == IndirectPhotons::Weighted;
        let division = if weighs && renderer.map_builder.may_build_interreflection_map() {
            let division = run_pilot(&renderer, needed_policy(), divide_indirect_light);
            renderer.map_builder.set_division(division.clone());
            division
        } else {
            None
        };
        // Balance camera rays against photons. Use only effects that change the picture, so that
        // the others do not change the ray-photon balance.
        let balances = settings.allows_ray_photon_balance
            && settings.camera_paths.samples_per_pixel.is_none()
            && policy.allows_ray_photon_balance();
        let balance = match (balances, needed_policy()) {
            (false, _) => None,
            (true, None) => find_ray_photon_balance(&renderer),
            (true, Some(policy)) => {
                let mut renderer = PassRenderer::new(scene, settings.clone(), policy);
                // Only `IndirectPhotons::Weighted` divides indirect light. With
                // `IndirectPhotons::Full`, `set_division(None)` would remove the photon paths that
                // start in all directions, which are needed there.
                if weighs {
                    renderer.map_builder.set_division(division.clone());
                }
                find_ray_photon_balance(&renderer)
            }
        };
        if let Some(RayPhotonBalance {
            samples_per_pixel: samples,
            unaimed_paths: photons,
            aimed_paths: caustic_photons,
        }) = balance
        {
            renderer.samples_per_pixel = samples;
            let counts = &mut renderer.map_builder.counts;
            counts.unaimed = photons.unwrap_or(counts.unaimed);
            counts.aimed = caustic_photons.unwrap_or(counts.aimed);
            let unaimed_paths = counts.unaimed;
            if let Some(division) = &mut renderer.map_builder.division {
                *division =
                    Arc::new(IndirectDivision { samples_per_pixel: samples, unaimed_paths, ..(**division).clone() });
            }
        }

        // Divide directly visible caustics between photon estimates and light tracing.
        renderer.map_builder.set_density_estimate_shares();

        // Add prefix rays where highlights and caustics need them.
        if settings.allows_prefix_rays && policy.allows_prefix_rays() {
            renderer.prefix_rays = run_pilot(&renderer, needed_policy(), find_prefix_ray_counts);
        }

        // Distribute camera rays over the pixels, unless passes share their camera paths. A pilot
        // would then measure these very paths, and its choice would bias the picture.
        let adapts = settings.camera_paths.adaptive && !policy.passes_share_paths;
        renderer.relative_ray_counts = if adapts { find_relative_ray_counts(&renderer) } else { None };

        // Divide the shutter interval.
        let slices = run_pilot(&renderer, needed_policy(), PassRenderer::find_slice_count);
        Self {
            renderer,
            plan,
            make_policy,
            environment_guiding,
            scatter_point_guiding,
            balance,
            shutter_slice_count: slices,
        }
    }
}

/// Runs `pilot` for `renderer`, and returns its result. If `policy` is given, it replaces the
/// policy of the renderer.
///
/// `policy` must be the renderer's policy with fewer effects of light.
fn run_pilot<'a, T>(
    renderer: &PassRenderer<'a>,
    policy: Option<PathPolicy>,
    pilot: impl FnOnce(&PassRenderer<'a>) -> T,
) -> T {
    match policy {
        None => pilot(renderer),
        Some(policy) => pilot(&renderer.with_policy(policy)),
    }
}

/// Returns the cameras of the slices of the shutter interval in pass `pass`. `renderers` holds one
/// renderer for each slice.
fn sliced_cameras<'b>(renderers: &'b [PassRenderer<'_>], pass: u32) -> SlicedCameras<'b> {
    let seed = renderers[0].settings.camera_paths.seed;
    SlicedCameras {
        cameras: renderers.iter().map(|renderer| renderer.scene.camera()).collect(),
        key: Key::new(seed).purpose_key(Purpose::Shutter),
        pass,
    }
}

#[cfg(test)]
mod tests;
