//! The integrator of all algorithms that a [`PathPolicy`] expresses.

use super::balance::Balance;
use super::camera_path::{PathContext, PathState, radiance};
use super::film::{self, FilmSampling, Worker};
use super::for_interior::for_interior;
use super::integrator::Integrator;
use super::map_builder::PhotonMapBuilder;
use super::nee::NextEventEstimator;
use super::pass::{Expected, Monitor, Pass, Silent};
use super::photon_maps::PhotonMaps;
use super::policy::{PathPolicy, PolicyFn};
use super::radius_law::RadiusLaw;
use super::radius_pilot::{GuidingReports, Radii};
use super::settings::Settings;
use crate::math::Ray;
use crate::plan::{Effect, Effects, Plan};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Interior, Scene};
use crate::stats::Counters;
use std::sync::Arc;
use std::time::Instant;

/// If passes share their camera paths, each traces about this many tiles by fresh paths to measure
/// the shared error.
const FRESH_TILES: u32 = 48;

/// Integrator whose camera paths follow a [`PathPolicy`].
#[derive(Debug)]
pub(super) struct PathIntegrator<'a> {
    pub scene: &'a Scene,
    plan: Plan,
    /// Makes the policy for other sets of effects.
    make_policy: PolicyFn,
    pub policy: PathPolicy,
    pub settings: Settings,
    pub nee: NextEventEstimator<'a>,
    pub map_builder: PhotonMapBuilder<'a>,
    /// Mean number of camera rays per pixel and pass.
    pub samples: u32,
    balance: Option<Balance>,
    /// Camera rays of each pixel, in parts of `samples`.
    density: Option<Arc<[f32]>>,
}

impl Integrator for PathIntegrator<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();

        // Move the scene to the time of the pass.
        let (moved_scene, moved);
        let integrator = if self.has_motion() {
            moved_scene = self.scene.at(shutter_time(self.settings.eye.seed, pass));
            moved = self.at(&moved_scene);
            &moved
        } else {
            self
        };

        // Trace and index photons.
        let map_builder = &integrator.map_builder;
        let maps = map_builder.has_photons().then(|| map_builder.build(pass, monitor, &mut out));

        // Trace camera paths.
        let paths = integrator.paths(maps.as_ref(), pass);
        for_interior!(paths.policy.effects, integrator.render_pixels(&paths, monitor, &mut out));
        out
    }

    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn expected_work(&self, effects: Effects) -> Counters {
        let policy = (self.make_policy)(effects, &self.settings);
        let nee = NextEventEstimator::new(self.scene, &policy);
        let map_builder = self.map_builder.with_policy(&policy);
        Self { policy, nee, map_builder, ..self.at(self.scene) }.measure_work()
    }

    fn expected(&self) -> Expected {
        self.map_builder.expected()
    }

    fn balance(&self) -> Option<Balance> {
        self.balance
    }

    fn radii(&self) -> Option<Radii> {
        self.map_builder.radii
    }

    fn radius_law(&self) -> Option<RadiusLaw> {
        self.map_builder.has_photons().then(|| self.map_builder.law())
    }

    fn nests_estimates(&self) -> bool {
        self.settings.eye.estimate_error
    }

    fn guiding_reports(&self) -> GuidingReports {
        self.map_builder.guiding_reports
    }
}

impl<'a> PathIntegrator<'a> {
    /// Prepares an algorithm for `scene`: finds radii, guides emission, and balances camera rays
    /// against photons.
    pub fn new(scene: &'a Scene, plan: Plan, settings: Settings, make_policy: PolicyFn) -> Self {
        let with_effects = |effects: Effects| {
            let policy = make_policy(effects, &settings);
            Self {
                scene,
                plan: plan.clone(),
                make_policy,
                policy,
                nee: NextEventEstimator::new(scene, &policy),
                map_builder: PhotonMapBuilder::new(scene, settings.clone(), policy),
                samples: settings.eye.samples.unwrap_or(policy.samples),
                settings: settings.clone(),
                balance: None,
                density: None,
            }
        };
        let (effects, needed) = (plan.effects(), plan.needed());
        let mut integrator = with_effects(effects);
        let balances = settings.balance && settings.eye.samples.is_none() && integrator.policy.can_be_balanced();
        // Effects that add nothing must not change the balance: the picture is the same with them.
        let balance = match (balances, needed == effects) {
            (false, _) => None,
            (true, true) => integrator.find_balance(),
            (true, false) => with_effects(needed).find_balance(),
        };
        if let Some(Balance { samples, photons, caustic_photons }) = balance {
            integrator.samples = samples;
            let counts = &mut integrator.map_builder.counts;
            counts.photons = photons.unwrap_or(counts.photons);
            counts.caustic_photons = caustic_photons.unwrap_or(counts.caustic_photons);
        }
        integrator.balance = balance;
        integrator.density = if settings.eye.adaptive { integrator.find_density() } else { None };
        integrator
    }

    /// This integrator for `scene`, its own scene at another time; results of pilots are kept.
    pub fn at<'b>(&self, scene: &'b Scene) -> PathIntegrator<'b> {
        PathIntegrator {
            scene,
            plan: self.plan.clone(),
            make_policy: self.make_policy,
            policy: self.policy,
            settings: self.settings.clone(),
            nee: NextEventEstimator::new(scene, &self.policy),
            map_builder: self.map_builder.at(scene),
            samples: self.samples,
            balance: self.balance,
            density: self.density.clone(),
        }
    }

    /// This integrator with one camera ray per pixel.
    pub fn with_one_sample(self) -> Self {
        Self { samples: 1, density: None, ..self }
    }

    /// True if passes show the scene at different times.
    fn has_motion(&self) -> bool {
        self.policy.effects.has(Effect::Motion) && self.scene.moves()
    }

    /// Inputs of the camera paths of pass `pass`.
    pub fn paths<'b>(&'b self, maps: Option<&'b PhotonMaps<'b>>, pass: u32) -> PathContext<'b> {
        PathContext::new(self.scene, &self.policy, &self.nee, maps, pass, self.settings.eye.max_bounces)
    }

    /// Renders all pixels by camera paths into `out`.
    pub fn render_pixels<I: Interior>(&self, paths: &PathContext<'_>, monitor: &dyn Monitor, out: &mut Pass) {
        let start = Instant::now();
        let (policy, camera, eye) = (paths.policy, paths.scene.camera(), &self.settings.eye);
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
        let trace = |ray: &Ray, sampler: Sampler, worker: &mut Worker, stack: &mut Vec<PathState<I>>| {
            radiance(paths, ray, sampler, worker, stack)
        };
        let key = Key::new(eye.seed).purpose(Purpose::Camera);
        let own_key = if policy.shares_paths { key.shared_paths() } else { key.pass(paths.pass) };
        let rendered = film::render_tiles(&sampling, own_key, monitor, trace);
        (out.image, out.nested) = (rendered.image, rendered.nested);
        out.counters += rendered.counters;

        // Trace some tiles by fresh paths if passes share theirs.
        if nested && policy.shares_paths {
            let every = film::tile_interval(camera.size(), FRESH_TILES);
            sampling = FilmSampling { nested: false, every, ..sampling };
            let fresh = film::render_tiles(&sampling, key.fresh_paths(paths.pass), &Silent, trace);
            out.fresh = fresh.pixels.iter().map(|i| (*i, fresh.image[*i as usize])).collect();
        }
        out.seconds.eye += start.elapsed().as_secs_f64();
    }
}

/// Time of a pass in \[0, 1) of the shutter interval.
///
/// The times of all passes are stratified: a power of two of them divides the interval in equal
/// steps.
fn shutter_time(seed: u64, pass: u32) -> f64 {
    let start = Key::new(seed).purpose(Purpose::Shutter).uniform(Dimension::Time);
    let step = f64::from(pass.reverse_bits()) / 4_294_967_296.0;
    let time = f64::from(start) + step;
    time - time.floor()
}
