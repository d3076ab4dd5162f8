//! Scenes of the calibration, their settings and their references.

use super::random_scenes;
use caustica::format::SceneFile;
use caustica::image::RelativeErrorWeights;
use caustica::integrate::{Algorithm, IndirectPhotons, Settings, SilentMonitor};
use caustica::render::{RenderResult, StopCriteria, render};
use caustica::scene::Scene;
use glam::Vec3;
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A scene with its name in tables.
pub struct TestScene {
    pub name: String,
    pub scene: Scene,
}

impl TestScene {
    /// Reads `scenes/NAME.txt`, with a picture of `size` (width, height) pixels.
    pub fn from_file(name: &str, size: (u32, u32)) -> Result<Self, Box<dyn Error>> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.txt"));
        let mut file = SceneFile::read(&path)?;
        let camera = &mut file.description.camera.value;
        (camera.width, camera.height) = size;
        Ok(Self { name: name.to_owned(), scene: file.resolve()? })
    }

    /// Makes the random scene of `seed`, with a picture of `size` (width, height) pixels.
    pub fn random(seed: u64, size: (u32, u32)) -> Result<Self, Box<dyn Error>> {
        Ok(Self { name: format!("random {seed}"), scene: random_scenes::scene(seed, size)? })
    }
}

/// Returns default settings with `photons` photon paths per pass.
pub fn settings(photons: u32) -> Settings {
    let mut settings = Settings { unaimed_paths: photons, aimed_paths: photons / 2, ..Settings::default() };
    settings.camera_paths.estimate_error = true;
    settings
}

/// Two independent references A and B of a scene.
///
/// E[(I − A)·(I − B)] is the squared error of an image I, although A and B are noisy.
pub struct Truth {
    references: [Vec<Vec3>; 2],
    weights: RelativeErrorWeights,
    /// Relative noise of the mean of both references.
    pub uncertainty: f64,
}

impl Truth {
    /// Renders both references by `hybrid` with a tenth of the radius, `passes` passes each.
    pub fn render(scene: &Scene, settings: &Settings, size: (u32, u32), passes: u32) -> Self {
        let references = [1u64, 2].map(|i| reference(scene, settings, size, i << 40, passes));
        let [a, b] = &references;
        let mean: Vec<Vec3> = a.iter().zip(b).map(|(a, b)| (*a + *b) * 0.5).collect();
        let weights = RelativeErrorWeights::from_pixels(size, &mean);
        let difference = |i: usize| (a[i] - b[i]).as_dvec3();
        let uncertainty = 0.5 * weights.mean_relative_squared_error(|i| difference(i) * difference(i)).sqrt();
        Self { references, weights, uncertainty }
    }

    /// Returns the true relative error of an image.
    pub fn error(&self, image: &[Vec3]) -> f64 {
        let [a, b] = &self.references;
        let square =
            self.weights.mean_relative_squared_error(|i| (image[i] - a[i]).as_dvec3() * (image[i] - b[i]).as_dvec3());
        square.max(0.0).sqrt()
    }
}

/// Returns the mean of many passes with a small, constant radius.
fn reference(scene: &Scene, settings: &Settings, size: (u32, u32), seed: u64, passes: u32) -> Vec<Vec3> {
    let mut settings = settings.clone();
    settings.camera_paths.seed = seed;
    let radii = Algorithm::Hybrid.prepare(scene, settings.clone()).initial_gather_radii();
    settings.initial_gather_radius = radii.map(|radii| radii.caustic / 10.0);
    (settings.alpha, settings.gather_k) = (1.0, Some(0));
    // Camera paths find indirect light without bias.
    settings.indirect_photons = IndirectPhotons::Off;
    (settings.unaimed_paths, settings.aimed_paths) = (4 * settings.unaimed_paths, 8 * settings.aimed_paths);
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { max_passes: Some(passes), ..StopCriteria::unlimited(&interrupted) };
    let integrator = Algorithm::Hybrid.prepare(scene, settings);
    let start = RenderResult::without_passes(integrator.as_ref(), size);
    render(start, 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |_| {}).film.mean_picture()
}
