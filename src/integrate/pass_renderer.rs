//! Inputs of a pass: the scene, the path policy, photon maps, camera rays and random keys.

use super::camera_path::PathContext;
use super::environment_pilot::{EnvironmentGuidingReport, guide_environment_light};
use super::film_sampling::{FilmSampling, PrefixRays};
use super::map_builder::PhotonMapBuilder;
use super::nee::{NextEventEstimator, ShadowRayGuides};
use super::photon_maps::PhotonMaps;
use super::policy::PathPolicy;
use super::prefix_rays::PrefixRayAllocation;
use super::settings::Settings;
use super::shutter::{MAX_PHOTON_SLICES, MAX_SLICES, SLICE_PIXELS, SlicedCameras};
use super::tiles;
use crate::sampling::{Key, Purpose};
use crate::scene::{self, Effect, Scene};
use std::sync::Arc;

/// Approximate number of tiles that a pass renders twice if all passes share camera paths: once
/// with the shared paths, and once with paths that only this pass traces. The difference measures
/// the error that the shared paths cause, which more passes do not reduce.
const UNSHARED_PATH_TILE_COUNT: u32 = 48;

/// Inputs from which passes are rendered: the scene, path policy, settings, sample counts and
/// results of pilots.
#[derive(Debug)]
pub(super) struct PassRenderer<'a> {
    pub scene: &'a Scene,
    pub policy: PathPolicy,
    pub settings: Settings,
    nee: NextEventEstimator<'a>,
    guides: ShadowRayGuides,
    pub map_builder: PhotonMapBuilder<'a>,
    /// Mean number of camera rays per pixel and pass.
    pub samples_per_pixel: u32,
    /// Number of camera rays of each pixel, divided by `samples_per_pixel`. `None` if each pixel
    /// gets `samples_per_pixel` rays.
    pub relative_ray_counts: Option<Arc<[f32]>>,
    /// Number of each pixel's [prefix rays](super::prefix_rays), and their expected work; `None`
    /// traces none. Prefix rays are extra camera paths that end at the first surface that stores
    /// photons.
    pub prefix_rays: Option<PrefixRayAllocation>,
}

impl<'a> PassRenderer<'a> {
    /// Makes a renderer with the numbers of camera rays and photon paths of `settings`.
    ///
    /// Runs the pilots (small simulations) that guide photon emission, and the pilots that find
    /// gather radii if `settings` give none.
    pub fn new(scene: &'a Scene, settings: Settings, policy: PathPolicy) -> Self {
        Self {
            scene,
            policy,
            nee: NextEventEstimator::new(scene, &policy, ShadowRayGuides::default()),
            guides: ShadowRayGuides::default(),
            map_builder: PhotonMapBuilder::new(scene, settings.clone(), policy),
            samples_per_pixel: settings.camera_paths.samples_per_pixel.unwrap_or(policy.default_samples_per_pixel),
            settings,
            relative_ray_counts: None,
            prefix_rays: None,
        }
    }

    /// Returns a renderer for `scene`, which must be the same scene at another shutter time. The
    /// new renderer keeps the results of pilots.
    pub fn for_scene_at_time<'b>(&self, scene: &'b Scene) -> PassRenderer<'b> {
        PassRenderer {
            scene,
            policy: self.policy,
            settings: self.settings.clone(),
            nee: NextEventEstimator::new(scene, &self.policy, self.guides.clone()),
            guides: self.guides.clone(),
            map_builder: self.map_builder.for_scene_at_time(scene),
            samples_per_pixel: self.samples_per_pixel,
            relative_ray_counts: self.relative_ray_counts.clone(),
            prefix_rays: self.prefix_rays.clone(),
        }
    }

    /// Returns a renderer for `policy`, which must be this renderer's policy with fewer effects of
    /// light. The new renderer keeps the results of pilots.
    pub fn with_policy(&self, policy: PathPolicy) -> Self {
        let nee = NextEventEstimator::new(self.scene, &policy, self.guides.clone());
        let map_builder = self.map_builder.with_policy(&policy);
        Self { policy, nee, map_builder, ..self.for_scene_at_time(self.scene) }
    }

    /// Returns the learned distributions of shadow rays: one for directions to the environment, and
    /// one for scattering points, the points in media from which shadow rays start.
    pub fn guides(&self) -> &ShadowRayGuides {
        &self.guides
    }

    /// Sets the learned distributions of shadow rays: one for directions to the environment, and
    /// one for scattering points, the points in media from which shadow rays start.
    pub fn set_guides(&mut self, guides: ShadowRayGuides) {
        self.nee = NextEventEstimator::new(self.scene, &self.policy, guides.clone());
        self.guides = guides;
    }

    /// Runs the pilot that learns from which directions the environment lights the scene. Returns a
    /// copy of this renderer's guides (learned distributions of shadow rays), in which
    /// `environment` is the pilot's result. This result is `None` if guiding would not reduce the
    /// noise enough. Also returns a report.
    ///
    /// The report is `None` if the settings forbid the pilot, or if there is no environment light
    /// to which shadow rays could be guided.
    pub fn find_environment_guide(&self) -> (ShadowRayGuides, Option<EnvironmentGuidingReport>) {
        let light = self.nee.guidable_environment_light().filter(|_| self.settings.allows_environment_guiding);
        let Some(light) = light.filter(|_| self.policy.uses_nee) else { return (self.guides.clone(), None) };
        let seed = self.settings.camera_paths.seed;
        let (guide, report) = guide_environment_light(self.scene, light, self.policy.effects, seed);
        (ShadowRayGuides { environment: guide.map(Arc::new), ..self.guides.clone() }, Some(report))
    }

    /// Returns a copy of this renderer with one camera ray per pixel, and without [prefix
    /// rays](super::prefix_rays), the extra camera paths that end at the first surface that stores
    /// photons.
    pub fn with_one_sample(&self) -> Self {
        Self {
            samples_per_pixel: 1,
            relative_ray_counts: None,
            prefix_rays: None,
            ..self.for_scene_at_time(self.scene)
        }
    }

    /// True if the camera or an object moves while the shutter is open, so that passes show
    /// different times.
    pub fn has_motion(&self) -> bool {
        self.policy.effects.has(Effect::Motion) && self.scene.has_motion()
    }

    /// Returns the number of slices of the shutter interval in each pass; 1 if nothing moves. Each
    /// slice has a copy of the scene at one time.
    ///
    /// Each slice covers [`SLICE_PIXELS`] pixels of motion on the film. There are fewer slices if
    /// copies of the scene would cost more than the camera rays, or if a slice would get too few
    /// camera rays or photons.
    pub fn find_slice_count(&self) -> u32 {
        if !self.has_motion() {
            return 1;
        }
        let scene = self.scene;
        let wanted = (scene::max_motion_in_pixels(scene) / SLICE_PIXELS).ceil();
        // Limit the cost of placing the moving parts for all slices to the cost of the camera rays.
        let (width, height) = scene.camera().size();
        let rays = u64::from(width) * u64::from(height) * u64::from(self.samples_per_pixel);
        let affordable = rays / (scene.parts_copied_per_time() as u64).max(1);
        let most = if !self.map_builder.traces_photons() {
            MAX_SLICES
        } else if self.policy.reads_photons_each_sample() {
            // Use no more slices than a pixel has rays: a camera ray reads only photons of its
            // slice, and these carry all indirect light.
            self.samples_per_pixel.min(MAX_PHOTON_SLICES)
        } else {
            self.samples_per_pixel.saturating_mul(2).min(MAX_PHOTON_SLICES)
        };
        (wanted as u32).min(most).min(u32::try_from(affordable).unwrap_or(u32::MAX)).max(1)
    }

    /// Returns the data that all camera paths of pass `pass` share.
    pub fn path_context<'b>(&'b self, maps: Option<&'b PhotonMaps<'b>>, pass: u32) -> PathContext<'b> {
        let max_bounces = self.settings.camera_paths.max_bounces;
        PathContext::new(
            self.scene,
            &self.policy,
            &self.nee,
            maps,
            pass,
            max_bounces,
            self.map_builder.technique_of_pass(pass),
        )
    }

    /// Returns the random key of the camera paths of pass `pass`.
    pub fn camera_path_key(&self, pass: u32) -> Key {
        let key = Key::new(self.settings.camera_paths.seed).purpose_key(Purpose::CameraPaths);
        if self.policy.passes_share_paths { key.shared_camera_paths_key() } else { key.pass_key(pass) }
    }

    /// Returns the random key of the [prefix rays](super::prefix_rays) of pass `pass`.
    pub fn prefix_ray_key(&self, pass: u32) -> Key {
        Key::new(self.settings.camera_paths.seed).purpose_key(Purpose::PrefixRays).pass_key(pass)
    }

    /// Returns the camera, filter and numbers of camera rays of pass `pass`.
    ///
    /// Shutter slices, crop window, light groups and clamping are off; the caller sets them.
    pub fn film_sampling(&self, pass: u32) -> FilmSampling<'_> {
        let filter = Some(&self.settings.camera_paths.filter);
        let lens = self.policy.effects.has(Effect::Lens);
        FilmSampling {
            relative_ray_counts: self.relative_ray_counts.as_deref(),
            prefix_rays: self.prefix_rays.as_ref().map(|rays| PrefixRays {
                counts: &rays.counts,
                key: self.prefix_ray_key(pass),
                lamp_images: &rays.lamp_images,
                aimed_key: Key::new(self.settings.camera_paths.seed)
                    .purpose_key(Purpose::AimedPrefixRays)
                    .pass_key(pass),
            }),
            repeats_in_nested_discs: self.settings.camera_paths.estimate_error && self.policy.reads_photons(),
            ..FilmSampling::of_camera(self.scene.camera(), filter, self.samples_per_pixel, lens)
        }
    }

    /// Returns the film sampling and the random key for the tiles that pass `pass` renders a second
    /// time, with camera paths that only this pass traces.
    ///
    /// These paths measure the error of camera paths that all passes share. Returns `None` if
    /// passes share no paths, or if the error is not estimated.
    pub fn unshared_path_sampling<'b>(
        &'b self,
        pass: u32,
        slices: Option<SlicedCameras<'b>>,
    ) -> Option<(FilmSampling<'b>, Key)> {
        let settings = &self.settings.camera_paths;
        let window = settings.window(self.scene.camera().size());
        let sampling = FilmSampling { slices, window, clamp: settings.clamp, ..self.film_sampling(pass) };
        if !(sampling.repeats_in_nested_discs && self.policy.passes_share_paths) {
            return None;
        }
        let tile_stride = tiles::rendered_tile_stride(sampling.window.size(), UNSHARED_PATH_TILE_COUNT);
        let key = Key::new(settings.seed).purpose_key(Purpose::CameraPaths).unshared_camera_paths_key(pass);
        Some((FilmSampling { repeats_in_nested_discs: false, tile_stride, ..sampling }, key))
    }
}
