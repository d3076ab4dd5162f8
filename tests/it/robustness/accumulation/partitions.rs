//! Passes rendered in parts and merged give the bits of one render.

use crate::support::{project_path, test_key};
use caustica::format::SceneFile;
use caustica::integrate::{Algorithm, Integrator, PassResult, Settings, SilentMonitor};
use caustica::render::Film;
use caustica::render::error_estimate::ErrorEstimator;
use caustica::sampling::Dimension;

const SIZE: (u32, u32) = (16, 12);
const PASSES: u32 = 12;

/// Film and error estimator of some passes.
struct Part {
    film: Film,
    estimator: ErrorEstimator,
}

impl Part {
    fn new(integrator: &dyn Integrator) -> Self {
        Self { film: Film::new(SIZE.0, SIZE.1), estimator: ErrorEstimator::new(integrator.radius_law()) }
    }

    fn add(&mut self, number: u32, pass: &PassResult) {
        self.estimator.add(number, pass);
        self.film.add(&pass.image);
    }

    /// Returns the error estimate, and the bits of the picture and of the maps of noise and bias.
    fn results(&self) -> (String, Vec<u64>, Vec<u32>) {
        let estimate = self.estimator.estimate(&self.film);
        let text = format!("{estimate:?} {:?}", self.estimator.forecast(&estimate));
        let maps = self.estimator.error_maps(&self.film);
        let maps = maps.noise.iter().chain(&maps.blur).flat_map(|value| value.to_array().map(f32::to_bits));
        let picture = self.film.pixel_means().flat_map(|mean| mean.to_array().map(f64::to_bits));
        (text, picture.collect(), maps.collect())
    }
}

/// Deals `passes` at random to up to six parts, and merges the parts in random order.
fn render_in_parts(integrator: &dyn Integrator, passes: &[PassResult], seed: u64) -> Part {
    let key = test_key(seed);
    let random = |i: u64, which: u64| f64::from(key.child_key(which).child_key(i).uniform_1d(Dimension::Film));
    let mut parts: Vec<Part> = (0..=seed % 6).map(|_| Part::new(integrator)).collect();
    let mut order: Vec<usize> = (0..passes.len()).collect();
    order.sort_by(|a, b| random(*a as u64, 0).total_cmp(&random(*b as u64, 0)));
    for number in order {
        let part = (random(number as u64, 1) * parts.len() as f64) as usize;
        parts[part].add(number as u32, &passes[number]);
    }
    while parts.len() > 1 {
        let last = parts.pop().unwrap();
        let at = (random(parts.len() as u64, 2) * parts.len() as f64) as usize;
        parts[at].film.merge(&last.film).unwrap();
        parts[at].estimator.merge(&last.estimator).unwrap();
    }
    parts.pop().unwrap()
}

/// Parts of a render that are merged in any order give the bits of one render.
///
/// The test covers three integrators, a moving scene, and a scene with a medium. Passes of the
/// integrator `ppm` share camera paths.
#[test]
fn merged_parts_equal_one_render() {
    let cases = [
        ("ring", Algorithm::Hybrid),
        ("ring", Algorithm::Ppm),
        ("matte", Algorithm::Path),
        ("motion", Algorithm::Sppm),
        ("milk", Algorithm::Hybrid),
    ];
    for (name, algorithm) in cases {
        let mut file = SceneFile::read(&project_path(&format!("scenes/{name}.txt"))).unwrap();
        (file.description.camera.value.width, file.description.camera.value.height) = SIZE;
        let scene = file.resolve().unwrap();
        let mut settings =
            Settings { unaimed_paths: 500, aimed_paths: 500, allows_ray_photon_balance: false, ..Settings::default() };
        settings.camera_paths.samples_per_pixel = Some(1);
        settings.camera_paths.estimate_error = true;
        let integrator = algorithm.prepare(&scene, settings);
        let passes: Vec<PassResult> = (0..PASSES).map(|pass| integrator.render_pass(pass, &SilentMonitor)).collect();
        let mut whole = Part::new(&*integrator);
        (0..PASSES).zip(&passes).for_each(|(number, pass)| whole.add(number, pass));
        let expected = whole.results();
        for seed in 0..40 {
            let merged = render_in_parts(&*integrator, &passes, seed);
            assert!(merged.results() == expected, "{name}, {algorithm:?}, seed {seed}");
        }
    }
}
