//! A scene made ready for an algorithm, and its passes.

use super::balance::{self, Balance, Part};
use super::direct::{Asking, DirectLight};
use super::eye::EyePass;
use super::maker::{Draft, MapMaker};
use super::maps::{Maps, Needs};
use super::method::Method;
use super::{Expected, EyeSettings, Integrator, Lessons, Monitor, Pass, PhotonReport, Radii, Settings, Silent};
use crate::color::{self, Rgb};
use crate::plan::{Effects, Plan};
use crate::sampling::{Dimension, Draw, Key, Purpose};
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
    pass: u32,
    job: Job<'w>,
}

/// Which walks.
pub(super) enum Job<'w> {
    /// Those of all pixels.
    Picture(&'w dyn Monitor, &'w mut Pass),
    /// One through each of some points of the film, for a pilot.
    Points(&'w [(Vec2, Draw)], &'w mut Found),
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
        let Self { scene, effects, settings, direct, samples, pass, job } = self;
        let eye = EyePass { scene, effects, settings, direct, method, samples, pass };
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
    scene: &'a Scene,
    plan: Plan,
    effects: Effects,
    eye: EyeSettings,
    direct: DirectLight<'a>,
    maker: MapMaker<'a>,
    strategy: Arc<dyn Strategy>,
    samples: u32,
    balance: Option<Balance>,
}

/// Points of the film at which a balance is struck.
const POINTS: u32 = 1024;

/// A pilot traces one of so many of a pass's photon paths.
const PILOT_PART: u32 = 16;

impl<'a> Prepared<'a> {
    pub fn new(scene: &'a Scene, plan: Plan, settings: Settings, strategy: Arc<dyn Strategy>) -> Self {
        let make = |effects: Effects| Self {
            scene,
            plan: plan.clone(),
            effects,
            eye: settings.eye.clone(),
            direct: DirectLight::new(scene, strategy.asking(), effects),
            maker: MapMaker::new(scene, settings.clone(), effects, strategy.needs(effects)),
            samples: settings.eye.samples.unwrap_or(strategy.samples()),
            strategy: Arc::clone(&strategy),
            balance: None,
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
        prepared
    }

    /// How a pass should divide its work; `None` where there are no photons to divide it with. It depends on the scene and the settings
    /// alone.
    fn find_balance(&self) -> Option<Balance> {
        if !self.maker.has_photons() {
            return None;
        }
        let key = Key::new(self.eye.seed).purpose(Purpose::Balance);
        let points = |other| self.points(key, other);
        let whole = self.maker.counts;
        let draft = |i| {
            let mut out = Pass::default();
            let draft = Draft { key: key.with(i), pass: 0, part: PILOT_PART, limited: false };
            (self.maker.make_from(&draft, &Silent, &mut out), out)
        };
        let ((mut one, made), (mut other, _)) = (draft(0), draft(1));
        let look = |maps: &Maps<'_>, points: &[(Vec2, Draw)]| {
            let mut found = Found::default();
            self.walk(maps, 0, Job::Points(points, &mut found));
            found
        };
        let (here, beside) = (points(0), points(1));
        let first = look(&one, &here);
        let second = look(&one, &beside);
        std::mem::swap(&mut one.caustic, &mut other.caustic);
        // What caustics become comes from the paths of the caustic map.
        let shared = self.maker.needs.after_caustic;
        if shared {
            std::mem::swap(&mut one.smooth, &mut other.smooth);
        }
        let by_caustics = look(&one, &here);
        let by_global = if shared { None } else { Some(look(&other, &here)) };
        let light: Vec<f64> = (0..here.len())
            .map(|i| {
                let values = [&first, &second, &by_caustics].map(|f| f64::from(color::mean(f.radiance[i])));
                values.iter().sum::<f64>() / 3.0
            })
            .collect();
        let noise = |other: &Found| balance::noise(&first.radiance, &other.radiance, &light);

        let pixels = self.pixels();
        let points = f64::from(POINTS);
        // Estimates hold more photons the more there are; all that a pass will have, not only the pilot's.
        let gathered = balance::gathering(&first.counters) / points * pixels * f64::from(PILOT_PART);
        let paths = (made.global.emitted + made.caustic.emitted) as f64;
        let part = |noise: f64, report: &PhotonReport, rays: f64, count: u32| {
            let emitted = report.emitted as f64;
            let cost = rays / paths
                + balance::storing(report.stored) / emitted.max(1.0)
                + gathered / (paths * f64::from(PILOT_PART));
            Part { variance: noise * emitted, cost, count: f64::from(count) }
        };
        let rays = made.counters.photon_rays as f64;
        let walking = balance::walking(&first.counters) / points * pixels;
        let camera = Part {
            variance: noise(&second),
            cost: if self.strategy.estimates_each_sample() { walking + gathered } else { walking },
            count: f64::from(self.samples),
        };
        let caustic = part(noise(&by_caustics), &made.caustic, rays, whole.caustic_photons);
        let global = by_global.map_or(0.0, |found| noise(&found));
        let global = part(global, &made.global, rays, whole.photons);
        let [samples, photons, caustic_photons] = balance::divide(&[camera, global, caustic]);
        let paths = |n: f64, emitted: u64| (emitted > 0).then(|| n.round().min(f64::from(u32::MAX)) as u32);
        Some(Balance {
            samples: samples.round().max(1.0) as u32,
            photons: paths(photons, made.global.emitted),
            caustic_photons: paths(caustic_photons, made.caustic.emitted),
        })
    }

    fn pixels(&self) -> f64 {
        let (width, height) = self.scene.camera().size();
        f64::from(width) * f64::from(height)
    }

    /// Points of the film with their random numbers; of two sets with the same key, points of one place are in one pixel.
    fn points(&self, key: Key, set: u64) -> Vec<(Vec2, Draw)> {
        let (width, height) = self.scene.camera().size();
        let size = Vec2::new(width as f32, height as f32);
        let key = key.purpose(Purpose::Camera);
        let point = |i| {
            let pixel = (Draw::new(key, i, POINTS).two(Dimension::Film) * size).floor();
            let draw = Draw::new(key.with(set << 32 | u64::from(i)), 0, 1);
            (pixel + draw.two(Dimension::Film), draw)
        };
        (0..POINTS).map(point).collect()
    }

    /// Counts the work of a pass at few points with few photons.
    fn sketch(&self) -> Counters {
        let key = Key::new(self.eye.seed).purpose(Purpose::Balance);
        let mut out = Pass::default();
        let maps = self.maker.make_from(&Draft { key, pass: 0, part: PILOT_PART, limited: true }, &Silent, &mut out);
        let mut found = Found::default();
        self.walk(&maps, 0, Job::Points(&self.points(key, 0), &mut found));
        let scaled = |n: u64, by: f64| (n as f64 * by).round() as u64;
        let Counters { onward_rays, shadow_rays, gathers, gathered_photons, .. } = found.counters;
        let samples = f64::from(self.samples) * self.pixels() / f64::from(POINTS);
        let estimates = if self.strategy.estimates_each_sample() { samples } else { self.pixels() / f64::from(POINTS) };
        let photons = f64::from(PILOT_PART);
        Counters {
            camera_rays: u64::from(self.samples) * self.pixels() as u64,
            onward_rays: scaled(onward_rays, samples),
            shadow_rays: scaled(shadow_rays, samples),
            photon_rays: scaled(out.counters.photon_rays, photons),
            gathers: scaled(gathers, estimates),
            gathered_photons: scaled(gathered_photons, estimates * photons),
            rejected_samples: 0,
        }
    }

    fn walk(&self, maps: &Maps<'_>, pass: u32, job: Job<'_>) {
        let Self { scene, effects, eye: settings, direct, samples, .. } = self;
        self.strategy.walk(Walks { scene, effects: *effects, settings, direct, samples: *samples, pass, job }, maps);
    }
}

impl Integrator for Prepared<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = self.maker.make(pass, monitor, &mut out);
        self.walk(&maps, pass, Job::Picture(monitor, &mut out));
        out
    }

    fn expected(&self) -> Expected {
        self.maker.expected()
    }

    fn expected_work(&self, effects: Effects) -> Counters {
        let within = Self {
            plan: self.plan.clone(),
            effects,
            eye: self.eye.clone(),
            direct: DirectLight::new(self.scene, self.strategy.asking(), effects),
            maker: self.maker.within(effects, self.strategy.needs(effects)),
            strategy: Arc::clone(&self.strategy),
            ..*self
        };
        within.sketch()
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

    fn lessons(&self) -> Lessons {
        self.maker.lessons
    }
}
