//! A scene made ready for an algorithm, and its passes.

use super::balance::Balance;
use super::direct::{Asking, DirectLight};
use super::eye::EyePass;
use super::maker::PhotonMapBuilder;
use super::maps::{Maps, Needs};
use super::method::Method;
use super::{Expected, EyeSettings, GuidingReports, Integrator, Monitor, Pass, Radii, RadiusLaw, Settings};
use crate::color::Rgb;
use crate::plan::{Effect, Effects, Plan};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::Scene;
use crate::stats::Counters;
use glam::Vec2;
use std::sync::Arc;

/// What an algorithm is, before a scene is known.
pub(super) trait Strategy: Send + Sync + std::fmt::Debug {
    /// Camera rays a pixel and pass, where the user does not say.
    fn samples(&self) -> u32;

    /// Whether camera rays and photons may be traded for each other.
    fn can_be_balanced(&self) -> bool {
        true
    }

    /// Whether every camera ray takes estimates of its own.
    fn estimates_each_sample(&self) -> bool {
        true
    }

    /// How lights are asked.
    fn asking(&self) -> Asking;

    /// Which photon maps are looked at where these effects are simulated.
    fn needs(&self, _: Effects) -> Needs {
        Needs::NOTHING
    }

    /// Follows the camera walks of a pass by its own [`Method`].
    fn walk(&self, walks: Walks<'_>, maps: &Maps<'_>);
}

/// The camera walks of a pass, which want a method.
pub(super) struct Walks<'w> {
    scene: &'w Scene,
    pub effects: Effects,
    settings: &'w EyeSettings,
    direct: &'w DirectLight<'w>,
    samples: u32,
    density: Option<&'w [f32]>,
    pass: u32,
    job: Job<'w>,
}

/// Which walks.
pub(super) enum Job<'w> {
    /// Those of all pixels.
    Picture(&'w dyn Monitor, &'w mut Pass),
    /// One through each of some points of the film, for a pilot.
    Points(&'w [(Vec2, Sampler)], &'w mut Found),
}

/// What a pilot's walks found.
#[derive(Default)]
pub(super) struct Found {
    pub radiance: Vec<Rgb>,
    pub counters: Counters,
}

impl Walks<'_> {
    /// Follows them all.
    pub fn by(self, method: &impl Method) {
        let Self { scene, effects, settings, direct, samples, density, pass, job } = self;
        let eye = EyePass { scene, effects, settings, direct, method, samples, density, pass };
        match job {
            Job::Picture(monitor, out) => eye.run(monitor, out),
            Job::Points(points, found) => {
                let (radiance, workers) = eye.at(points);
                found.radiance = radiance;
                workers.iter().for_each(|worker| found.counters += worker.counters);
            }
        }
    }
}

/// An algorithm with its scene.
#[derive(Debug)]
pub(super) struct Prepared<'a> {
    pub scene: &'a Scene,
    plan: Plan,
    effects: Effects,
    pub eye: EyeSettings,
    direct: DirectLight<'a>,
    pub maker: PhotonMapBuilder<'a>,
    pub strategy: Arc<dyn Strategy>,
    pub samples: u32,
    balance: Option<Balance>,
    /// How many camera rays each pixel gets, in parts of `samples`.
    density: Option<Arc<[f32]>>,
}

impl<'a> Prepared<'a> {
    pub fn new(scene: &'a Scene, plan: Plan, settings: Settings, strategy: Arc<dyn Strategy>) -> Self {
        let make = |effects: Effects| Self {
            scene,
            plan: plan.clone(),
            effects,
            eye: settings.eye.clone(),
            direct: DirectLight::new(scene, strategy.asking(), effects),
            maker: PhotonMapBuilder::new(scene, settings.clone(), effects, strategy.needs(effects)),
            samples: settings.eye.samples.unwrap_or(strategy.samples()),
            strategy: Arc::clone(&strategy),
            balance: None,
            density: None,
        };
        let (effects, needed) = (plan.effects(), plan.needed());
        let mut prepared = make(effects);
        let wanted = settings.balance && settings.eye.samples.is_none() && strategy.can_be_balanced();
        // What is simulated needlessly has no say: a picture is the same with it.
        let balance = match (wanted, needed == effects) {
            (false, _) => None,
            (true, true) => prepared.find_balance(),
            (true, false) => make(needed).find_balance(),
        };
        if let Some(Balance { samples, photons, caustic_photons }) = balance {
            prepared.samples = samples;
            let counts = &mut prepared.maker.counts;
            counts.photons = photons.unwrap_or(counts.photons);
            counts.caustic_photons = caustic_photons.unwrap_or(counts.caustic_photons);
        }
        prepared.balance = balance;
        prepared.density = if settings.eye.adaptive { prepared.find_density() } else { None };
        prepared
    }

    /// Whether passes happen at different times.
    pub fn moves(&self) -> bool {
        self.effects.has(Effect::Motion) && self.scene.moves()
    }

    /// The same with one camera ray a pixel.
    pub fn looking(self) -> Self {
        Self { samples: 1, density: None, ..self }
    }

    /// The same algorithm in `scene`, which is its own at another time; what pilots found stays.
    pub fn at<'b>(&self, scene: &'b Scene) -> Prepared<'b> {
        Prepared {
            scene,
            plan: self.plan.clone(),
            effects: self.effects,
            eye: self.eye.clone(),
            direct: DirectLight::new(scene, self.strategy.asking(), self.effects),
            maker: self.maker.at(scene),
            strategy: Arc::clone(&self.strategy),
            samples: self.samples,
            balance: self.balance,
            density: self.density.clone(),
        }
    }

    /// A pass of the scene as it stands.
    fn still(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = self.maker.make(pass, monitor, &mut out);
        self.walk(&maps, pass, Job::Picture(monitor, &mut out));
        out
    }

    /// Follows the camera walks of `job`.
    pub fn walk(&self, maps: &Maps<'_>, pass: u32, job: Job<'_>) {
        let Self { scene, effects, eye: settings, direct, samples, .. } = self;
        let (samples, density) = (*samples, self.density.as_deref());
        self.strategy.walk(Walks { scene, effects: *effects, settings, direct, samples, density, pass, job }, maps);
    }
}

/// When in \[0, 1) the things of a pass are seen: the passes together fill the time evenly, a power of two of them in equal steps.
fn shutter_time(seed: u64, pass: u32) -> f64 {
    let start = Key::new(seed).purpose(Purpose::Shutter).uniform(Dimension::Time);
    let step = f64::from(pass.reverse_bits()) / 4_294_967_296.0;
    let time = f64::from(start) + step;
    time - time.floor()
}

impl Integrator for Prepared<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        if self.moves() {
            let scene = self.scene.at(shutter_time(self.eye.seed, pass));
            self.at(&scene).still(pass, monitor)
        } else {
            self.still(pass, monitor)
        }
    }

    fn expected(&self) -> Expected {
        self.maker.expected()
    }

    fn expected_work(&self, effects: Effects) -> Counters {
        let direct = DirectLight::new(self.scene, self.strategy.asking(), effects);
        let maker = self.maker.within(effects, self.strategy.needs(effects));
        Self { effects, direct, maker, ..self.at(self.scene) }.sketch()
    }

    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn balance(&self) -> Option<Balance> {
        self.balance
    }

    fn radii(&self) -> Option<Radii> {
        self.maker.radii
    }

    fn radius_law(&self) -> Option<RadiusLaw> {
        self.maker.has_photons().then(|| self.maker.law())
    }

    fn gauged(&self) -> bool {
        self.eye.gauge
    }

    fn lessons(&self) -> GuidingReports {
        self.maker.lessons
    }
}
