//! A scene made ready for an algorithm, and its passes.

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, Method};
use super::maps::{MapMaker, Maps, Needs};
use super::{Expected, EyeSettings, Integrator, Lessons, Monitor, Pass, Radii, Settings};
use crate::plan::{Effects, Plan};
use crate::scene::Scene;

/// What an algorithm is, before a scene is known.
pub(super) trait Strategy: Sync + std::fmt::Debug {
    /// Camera rays a pixel and pass, where the user does not say.
    fn samples(&self) -> u32;

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
    monitor: &'w dyn Monitor,
    out: &'w mut Pass,
}

impl Walks<'_> {
    /// Follows them all.
    pub fn by(self, method: &impl Method) {
        let Self { scene, effects, settings, direct, samples, pass, monitor, out } = self;
        EyePass { scene, effects, settings, direct, method, samples, pass }.run(monitor, out);
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
    strategy: Box<dyn Strategy>,
}

impl<'a> Prepared<'a> {
    pub fn new(scene: &'a Scene, plan: Plan, settings: Settings, strategy: Box<dyn Strategy>) -> Self {
        let effects = plan.effects();
        let direct = DirectLight::new(scene, strategy.asking(), effects);
        let eye = settings.eye.clone();
        let maker = MapMaker::new(scene, settings, effects, strategy.needs(effects));
        Self { scene, plan, effects, eye, direct, maker, strategy }
    }
}

impl Integrator for Prepared<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = self.maker.make(pass, monitor, &mut out);
        let samples = self.eye.samples.unwrap_or(self.strategy.samples());
        let Self { scene, effects, eye: settings, direct, .. } = self;
        let walks = Walks { scene, effects: *effects, settings, direct, samples, pass, monitor, out: &mut out };
        self.strategy.walk(walks, &maps);
        out
    }

    fn expected(&self) -> Expected {
        self.maker.expected()
    }

    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn radii(&self) -> Option<Radii> {
        self.maker.radii
    }

    fn lessons(&self) -> Lessons {
        self.maker.lessons
    }
}
