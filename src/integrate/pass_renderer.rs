//! Everything that renders the camera paths of a pass, apart from the choice of settings by pilots.

use super::camera_path::{self, PathContext, PathState};
use super::film::{self, FilmSampling, Worker};
use super::map_builder::PhotonMapBuilder;
use super::nee::NextEventEstimator;
use super::pass::{Monitor, Pass, Silent};
use super::photon_maps::PhotonMaps;
use super::policy::PathPolicy;
use super::settings::Settings;
use crate::math::Ray;
use crate::plan::Effect;
use crate::sampling::{Key, Purpose, Sampler};
use crate::scene::{Interior, Scene};
use std::sync::Arc;
use std::time::Instant;

/// Number of tiles that each pass traces by fresh paths if passes share their camera paths.
///
/// Fresh paths measure the error that all passes share.
const FRESH_TILE_COUNT: u32 = 48;

/// A scene with a policy, and the numbers of camera rays and photons of a pass.
#[derive(Debug)]
pub(super) struct PassRenderer<'a> {
    pub scene: &'a Scene,
    pub policy: PathPolicy,
    pub settings: Settings,
    nee: NextEventEstimator<'a>,
    pub map_builder: PhotonMapBuilder<'a>,
    /// Mean number of camera rays per pixel and pass.
    pub samples: u32,
    /// Camera rays of each pixel, in parts of `samples`; `None` gives all pixels the mean.
    pub density: Option<Arc<[f32]>>,
}

impl<'a> PassRenderer<'a> {
    /// Renderer with default numbers of camera rays and photons. Pilots guide emission and find
    /// radii that are not set.
    pub fn new(scene: &'a Scene, settings: Settings, policy: PathPolicy) -> Self {
        Self {
            scene,
            policy,
            nee: NextEventEstimator::new(scene, &policy),
            map_builder: PhotonMapBuilder::new(scene, settings.clone(), policy),
            samples: settings.camera_paths.samples.unwrap_or(policy.samples),
            settings,
            density: None,
        }
    }

    /// This renderer for `scene`, its own scene at another time; results of pilots are kept.
    pub fn at<'b>(&self, scene: &'b Scene) -> PassRenderer<'b> {
        PassRenderer {
            scene,
            policy: self.policy,
            settings: self.settings.clone(),
            nee: NextEventEstimator::new(scene, &self.policy),
            map_builder: self.map_builder.at(scene),
            samples: self.samples,
            density: self.density.clone(),
        }
    }

    /// This renderer for a policy with fewer effects; results of pilots are kept.
    pub fn with_policy(&self, policy: PathPolicy) -> Self {
        let nee = NextEventEstimator::new(self.scene, &policy);
        let map_builder = self.map_builder.with_policy(&policy);
        Self { policy, nee, map_builder, ..self.at(self.scene) }
    }

    /// This renderer with one camera ray per pixel.
    pub fn with_one_sample(&self) -> Self {
        Self { samples: 1, density: None, ..self.at(self.scene) }
    }

    /// True if passes show the scene at different times.
    pub fn has_motion(&self) -> bool {
        self.policy.effects.has(Effect::Motion) && self.scene.has_motion()
    }

    /// Inputs of the camera paths of pass `pass`.
    pub fn paths<'b>(&'b self, maps: Option<&'b PhotonMaps<'b>>, pass: u32) -> PathContext<'b> {
        let max_bounces = self.settings.camera_paths.max_bounces;
        PathContext::new(self.scene, &self.policy, &self.nee, maps, pass, max_bounces)
    }

    /// Renders all pixels by camera paths into `out`.
    pub fn render_pixels<I: Interior>(&self, paths: &PathContext<'_>, monitor: &dyn Monitor, out: &mut Pass) {
        let start = Instant::now();
        let (policy, camera, eye) = (paths.policy, paths.scene.camera(), &self.settings.camera_paths);
        let nested = eye.estimate_error && policy.reads_photons();
        let mut sampling = FilmSampling {
            camera,
            filter: Some(&eye.filter),
            samples: self.samples,
            lens: policy.effects.has(Effect::Lens),
            density: self.density.as_deref(),
            nested,
            every: 1,
        };
        let radiance = |ray: &Ray, sampler: Sampler, worker: &mut Worker, stack: &mut Vec<PathState<I>>| {
            camera_path::radiance(paths, ray, sampler, worker, stack)
        };
        let key = Key::new(eye.seed).purpose_key(Purpose::Camera);
        let pass_key = if policy.shares_paths { key.shared_paths_key() } else { key.pass_key(paths.pass) };
        let rendered = film::render_tiles(&sampling, pass_key, monitor, radiance);
        (out.image, out.nested) = (rendered.image, rendered.nested);
        out.counters += rendered.counters;

        // Trace some tiles by fresh paths if passes share theirs.
        if nested && policy.shares_paths {
            let every = film::tile_interval(camera.size(), FRESH_TILE_COUNT);
            sampling = FilmSampling { nested: false, every, ..sampling };
            let fresh = film::render_tiles(&sampling, key.fresh_paths_key(paths.pass), &Silent, radiance);
            out.fresh = fresh.pixels.iter().map(|i| (*i, fresh.image[*i as usize])).collect();
        }
        out.seconds.camera += start.elapsed().as_secs_f64();
    }
}
