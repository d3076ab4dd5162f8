//! Renders of one scene with different effects, compared bit by bit.

use crate::support::scene_from_text_in;
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, FinalGathering, Settings, SilentMonitor};
use caustica::plan::{EffectDecision, EffectOverrides};
use caustica::scene::Scene;
use caustica::stats::Counters;

/// Settings of a render, except its effects.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    pub algorithm: Algorithm,
    pub passes: u32,
    pub samples: Option<u32>,
    pub max_bounces: u32,
    pub seed: u64,
    pub photons: u32,
    pub caustic_photons: u32,
    pub gather_k: Option<u32>,
    pub radius: Option<f32>,
    pub gathering: FinalGathering,
}

impl RenderSettings {
    /// Returns settings with few photons. They suffice, because any difference changes the radii
    /// and guides that pilots find.
    pub fn new(algorithm: Algorithm) -> Self {
        Self {
            algorithm,
            passes: 1,
            samples: Some(1),
            max_bounces: 100,
            seed: 0,
            photons: 3000,
            caustic_photons: 2000,
            gather_k: None,
            radius: None,
            gathering: FinalGathering::Bsdf,
        }
    }
}

/// Pixels of all passes, counters and plan decisions of a render.
pub struct Picture {
    pub pixels: Vec<Rgb>,
    pub counters: Counters,
    pub decisions: Vec<EffectDecision>,
}

impl Picture {
    pub fn new(scene: &Scene, how: &RenderSettings, effects: EffectOverrides) -> Self {
        let camera_paths = CameraPathSettings {
            samples_per_pixel: how.samples,
            max_bounces: how.max_bounces,
            seed: how.seed,
            effects,
            ..CameraPathSettings::default()
        };
        let settings = Settings {
            camera_paths,
            unaimed_paths: how.photons,
            aimed_paths: how.caustic_photons,
            gather_k: how.gather_k,
            initial_gather_radius: how.radius,
            final_gathering: how.gathering,
            ..Settings::default()
        };
        let integrator = how.algorithm.prepare(scene, settings);
        let decisions = integrator.plan().decisions.clone();
        let mut picture = Self { pixels: Vec::new(), counters: Counters::default(), decisions };
        for i in 0..how.passes {
            let pass = integrator.render_pass(i, &SilentMonitor);
            picture.pixels.extend(pass.image);
            picture.counters += pass.counters;
        }
        picture
    }

    /// Returns a message if any bit of both pictures differs; `None` if all are equal.
    pub fn difference(&self, other: &Self) -> Option<String> {
        assert_eq!(self.pixels.len(), other.pixels.len());
        let bits = |p: &Rgb| p.to_array().map(f32::to_bits);
        let pairs = || self.pixels.iter().zip(&other.pixels).enumerate();
        let differ = |(_, (a, b)): &(usize, (&Rgb, &Rgb))| bits(a) != bits(b);
        let (at, (a, b)) = pairs().find(differ)?;
        let count = pairs().filter(differ).count();
        Some(format!("{count} of {} pixels differ, first {at}: {a:?} and {b:?}", self.pixels.len()))
    }
}

/// Compares the planned render with one that forces effects on or off by `forced`.
///
/// Returns a message if any bit differs.
pub fn difference(scene: &Scene, how: &RenderSettings, forced: EffectOverrides) -> Option<String> {
    let planned = Picture::new(scene, how, EffectOverrides::NO_OVERRIDES);
    let found = planned.difference(&Picture::new(scene, how, forced))?;
    let decisions: Vec<String> = planned
        .decisions
        .iter()
        .map(|d| format!("  {:16} {} {}", d.effect, if d.is_simulated { "on " } else { "off" }, d.reason))
        .collect();
    Some(format!("{found}\n{how:?}\nforced: {forced:?}\n{}", decisions.join("\n")))
}

/// Builds the scene of `text`. File names in it are relative to the root of the repository.
#[track_caller]
pub fn scene(text: &str) -> Scene {
    scene_from_text_in("", text)
}
