//! Tests of studies, on synthetic methods with known noise, bias and cost.

use super::clock::ClockFn;
use super::noise_and_bias::{relative_pixel_errors, separate_noise_and_bias};
use super::run::IntegratorFactory;
use super::{
    CpuWallTime, MethodStudy, MethodStudyEvent, MethodStudyResult, MethodVariant, ReferenceError, ReferencePictures,
    StudiedScene, StudyLimits, reference_algorithm,
};
use crate::color::Rgb;
use crate::image::{self, Image, WriteOptions};
use crate::integrate::{
    Algorithm, CameraPathSettings, Integrator, PassResult, ProgressMonitor, Settings, SilentMonitor,
};
use crate::plan::{EffectOverrides, Plan};
use crate::scene::{Effect, Effects};
use crate::stats::{Counters, cpu_seconds};
use crate::study::tests::{diffuse_sphere_on_floor, glass_sphere_on_floor};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

const SIZE: (u32, u32) = (64, 64);
const CHANNELS: f64 = 3.0 * 64.0 * 64.0;

/// Returns uniform noise of mean 0 and standard deviation `sigma`; the number `key` selects the
/// random number.
fn uniform_noise(sigma: f64, key: u64) -> f64 {
    // SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators").
    let mut z = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let uniform = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
    12f64.sqrt() * sigma * (uniform - 0.5)
}

/// Makes a picture of radiance 1 + `bias` with noise of standard deviation `sigma`;
/// `random_seed` selects the random numbers.
fn noisy_picture(bias: f64, sigma: f64, random_seed: u64) -> Vec<Rgb> {
    let value = |i: u64| 1.0 + bias + uniform_noise(sigma, (random_seed << 32) + i);
    let pixel = |i: u64| glam::DVec3::new(value(3 * i), value(3 * i + 1), value(3 * i + 2)).as_vec3();
    (0..u64::from(SIZE.0 * SIZE.1)).map(pixel).collect()
}

fn image_from_pixels(pixels: Vec<Rgb>) -> Image {
    Image::from_pixels(SIZE.0, SIZE.1, pixels).unwrap()
}

/// Makes two references of radiance 1 with noise of standard deviation `sigma`.
fn references_with_noise(sigma: f64) -> ReferencePictures {
    let [a, b] = [1000, 1001].map(|random_seed| image_from_pixels(noisy_picture(0.0, sigma, random_seed)));
    ReferencePictures::new("here".into(), a, Some(b)).unwrap()
}

fn assert_near(found: f64, expected: f64, sigma: f64) {
    assert!((found - expected).abs() < 4.0 * sigma, "{found} is not {expected} ± {sigma}");
}

/// [`separate_noise_and_bias`] recovers the known bias and noise of four pictures, from two noisy
/// references.
///
/// The tolerances follow from two facts. At radiance 1 in a picture of mean radiance 1, an error e
/// has the relative squared error e²/(1² + 1²). The product of two independent errors of variance v
/// has the standard deviation v.
#[test]
fn noise_and_bias_are_separated() {
    let (bias, sigma, reference) = (0.1, 0.2, 0.2);
    let pictures: Vec<_> = (0..4).map(|seed| noisy_picture(bias, sigma, seed)).collect();
    let found = separate_noise_and_bias(&references_with_noise(reference), &pictures);
    let (bias2, noise2, reference2) = (bias * bias, sigma * sigma, reference * reference);
    let deviation_of_mean = |v: f64| 0.5 * v / CHANNELS.sqrt();
    for square in &found.squared_errors {
        assert_near(*square, 0.5 * (bias2 + noise2), deviation_of_mean(bias2 + noise2 + reference2));
    }
    // A variance that is estimated from n channels, with three degrees of freedom each, has the
    // relative standard deviation √(2/(3n)).
    assert_near(found.squared_noise, 0.5 * noise2, 0.5 * noise2 * (2.0 / (3.0 * CHANNELS)).sqrt());
    assert_near(found.squared_bias, 0.5 * bias2, deviation_of_mean(bias2 + 0.25 * noise2 + reference2));
    let mean: f64 = found.squared_errors.iter().sum::<f64>() / 4.0;
    assert!((mean - found.squared_noise - found.squared_bias).abs() < 1e-12, "the parts make the whole");
    assert_near(found.rmse * found.rmse, bias2 + noise2, 2.0 * deviation_of_mean(bias2 + noise2 + reference2));
}

#[test]
fn unbiased_pictures_have_no_bias() {
    let pictures: Vec<_> = (0..4).map(|seed| noisy_picture(0.0, 0.2, seed)).collect();
    let found = separate_noise_and_bias(&references_with_noise(0.2), &pictures);
    assert_near(found.squared_bias, 0.0, 0.5 * (0.01 + 0.04) / CHANNELS.sqrt());
}

#[test]
fn pixel_errors_are_rms_over_seeds() {
    let references =
        ReferencePictures::new("here".into(), image_from_pixels(noisy_picture(0.0, 0.0, 0)), None).unwrap();
    let pictures = [noisy_picture(0.1, 0.0, 0), noisy_picture(-0.3, 0.0, 0)];
    let map = relative_pixel_errors(&references, &pictures);
    // The squared errors are 0.01 and 0.09. Their mean is halved to make it relative to 1² + 1².
    // Pixels near 1 are rounded by 6e-8, so errors near 0.1 are rounded by 6e-7 of their value.
    assert!(map.iter().all(|e| (f64::from(*e) - 0.025f64.sqrt()).abs() < 1e-6), "{}", map[0]);
}

/// Synthetic method with known noise, bias and cost.
#[derive(Clone, Copy)]
struct SyntheticMethod {
    bias: f64,
    sigma: f64,
    /// Processor time of a pass of the first seed \[s]. Seed n takes 1 + n/2 times as much.
    cost: f64,
    /// True if the user interrupts the study during the third pass of the first seed.
    interrupts: bool,
}

const FAST_METHOD: SyntheticMethod = SyntheticMethod { bias: 0.0, sigma: 0.5, cost: 0.2, interrupts: false };
const SLOW_METHOD: SyntheticMethod = SyntheticMethod { bias: 0.1, sigma: 0.1, cost: 0.8, interrupts: false };

/// State that all synthetic methods of a test share: clock, log of passes and interruption flag.
#[derive(Default)]
struct SyntheticStudyState {
    time: Mutex<CpuWallTime>,
    /// An entry for each pass in order: cost of the method (which identifies it), seed, and number
    /// of the pass.
    log: Mutex<Vec<(f64, u64, u32)>>,
    interrupted: AtomicBool,
}

struct SyntheticIntegrator<'w> {
    fake: SyntheticMethod,
    seed: u64,
    state: &'w SyntheticStudyState,
}

impl Integrator for SyntheticIntegrator<'_> {
    fn render_pass(&self, pass: u32, _: &dyn ProgressMonitor) -> PassResult {
        let SyntheticMethod { bias, sigma, cost, interrupts } = self.fake;
        let processor = cost * (1.0 + 0.5 * self.seed as f64);
        // Other programs use the processor for a fifth of the time.
        let wall = processor / (0.8 * rayon::current_num_threads() as f64);
        *self.state.time.lock().unwrap() += CpuWallTime { cpu_seconds: processor, wall_seconds: wall };
        self.state.log.lock().unwrap().push((cost, self.seed, pass));
        self.state.interrupted.fetch_or(interrupts && pass == 2 && self.seed == 0, Ordering::Relaxed);
        let random_seed = (f64::to_bits(cost) >> 40) + 1000 * u64::from(pass) + self.seed;
        let counters = Counters { camera_rays: 10 + self.seed, shadow_rays: 5, ..Counters::default() };
        let mut pass = PassResult { image: noisy_picture(bias, sigma, random_seed), counters, ..PassResult::default() };
        pass.unaimed.emitted_paths = 100;
        pass.aimed.emitted_paths = 50;
        pass
    }

    fn expected_work(&self, _: Effects) -> Counters {
        Counters::default()
    }

    fn plan(&self) -> &Plan {
        unreachable!("nothing asks for it here")
    }
}

fn run_synthetic_study<'w>(
    state: &'w SyntheticStudyState,
    fakes: &[SyntheticMethod],
    limits: StudyLimits,
) -> MethodStudyResult {
    let variant = |fake: SyntheticMethod| {
        let label = format!("of {} s", fake.cost);
        let settings = Settings::default();
        let variant =
            MethodVariant { label, algorithm: Algorithm::Path, settings, flags: vec!["--spp".into(), "3".into()] };
        let make: IntegratorFactory<'w> = Box::new(move |seed| Box::new(SyntheticIntegrator { fake, seed, state }));
        (variant, make)
    };
    let clock: ClockFn<'w> = Box::new(|| *state.time.lock().unwrap());
    let study = MethodStudy::new(SIZE, fakes.iter().map(|f| variant(*f)).collect(), 2, clock).unwrap();
    let subject = StudiedScene { scene_path: "a.txt".into(), ..StudiedScene::default() };
    let mut reported = Vec::new();
    let found = study.run(&subject, limits, &references_with_noise(0.0), &state.interrupted, &SilentMonitor, |step| {
        if let MethodStudyEvent::Checkpoint(label, checkpoint) = step {
            reported.push((label.to_owned(), checkpoint.passes));
        }
    });
    let found = found.unwrap();
    for method in &found.methods {
        for checkpoint in &method.checkpoints {
            assert!(reported.contains(&(method.label.clone(), checkpoint.passes)), "{}", checkpoint.passes);
        }
    }
    found
}

fn checkpoint_pass_counts(found: &MethodStudyResult, method: usize) -> Vec<u32> {
    found.methods[method].checkpoints.iter().map(|c| c.passes).collect()
}

/// Each method makes passes until the mean processor time of its two seeds reaches the budget.
///
/// Passes of the two seeds take 1 and 1.5 times the cost of the method. So the mean is 1 s for the
/// slow method and 0.25 s for the fast one.
#[test]
fn methods_run_until_their_budget() {
    let state = SyntheticStudyState::default();
    let found = run_synthetic_study(
        &state,
        &[SLOW_METHOD, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 6.0 - 1e-9, passes: None },
    );
    assert_eq!(checkpoint_pass_counts(&found, 0), [1, 2, 4, 6]);
    assert_eq!(checkpoint_pass_counts(&found, 1), [1, 2, 4, 8, 16, 24]);
    let last = found.methods[0].checkpoints.last().unwrap();
    assert!(
        (last.cpu_seconds - 6.0).abs() < 1e-9 && (last.rays - 6.0 * 15.5).abs() < 1e-9 && last.photon_paths == 900.0
    );
    assert!((last.wall_seconds * 0.8 * rayon::current_num_threads() as f64 - 6.0).abs() < 1e-9);
    assert!(
        !found.interrupted && (found.thread_time_share - if cpu_seconds().is_some() { 0.8 } else { 1.0 }).abs() < 1e-9
    );
    assert!(found.methods[1].render_command.ends_with(" --spp 3 --seed 0 --passes 24 -o of-0.2-s.exr"));
}

#[test]
fn checkpoint_close_before_the_last_is_dropped() {
    let found = run_synthetic_study(
        &SyntheticStudyState::default(),
        &[SLOW_METHOD, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 5.0 - 1e-9, passes: None },
    );
    assert_eq!(
        (checkpoint_pass_counts(&found, 0), checkpoint_pass_counts(&found, 1)),
        (vec![1, 2, 5], vec![1, 2, 4, 8, 20])
    );
    let capped = run_synthetic_study(
        &SyntheticStudyState::default(),
        &[SLOW_METHOD, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 5.0 - 1e-9, passes: Some(6) },
    );
    assert_eq!(
        (checkpoint_pass_counts(&capped, 0), checkpoint_pass_counts(&capped, 1)),
        (vec![1, 2, 5], vec![1, 2, 4, 6])
    );
    let least = run_synthetic_study(
        &SyntheticStudyState::default(),
        &[SLOW_METHOD, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 0.0, passes: None },
    );
    assert_eq!((checkpoint_pass_counts(&least, 0), checkpoint_pass_counts(&least, 1)), (vec![1], vec![1]));
}

#[test]
fn rounds_start_at_different_methods() {
    let state = SyntheticStudyState::default();
    run_synthetic_study(
        &state,
        &[SLOW_METHOD, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 1e9, passes: Some(3) },
    );
    let round = [(0.8, 0), (0.8, 1), (0.2, 0), (0.2, 1)];
    let expected = (0..3).flat_map(|r| (0..4).map(move |i| (round[(i + r) % 4].0, round[(i + r) % 4].1, r as u32)));
    assert_eq!(*state.log.lock().unwrap(), expected.collect::<Vec<_>>());
}

#[test]
fn interrupted_method_studies_finish_their_round() {
    let state = SyntheticStudyState::default();
    let found = run_synthetic_study(
        &state,
        &[SyntheticMethod { interrupts: true, ..SLOW_METHOD }, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 100.0, passes: None },
    );
    assert!(found.interrupted);
    assert_eq!((checkpoint_pass_counts(&found, 0), checkpoint_pass_counts(&found, 1)), (vec![1, 2, 3], vec![1, 2, 3]));
    // An interruption during the last round of passes leaves out no pass, because each round is
    // completed.
    let whole = run_synthetic_study(
        &SyntheticStudyState::default(),
        &[SyntheticMethod { interrupts: true, ..SLOW_METHOD }],
        StudyLimits { cpu_seconds_per_seed: 100.0, passes: Some(3) },
    );
    assert!(!whole.interrupted);
}

#[test]
fn measured_errors_match_synthetic_methods() {
    let found = run_synthetic_study(
        &SyntheticStudyState::default(),
        &[SLOW_METHOD, FAST_METHOD],
        StudyLimits { cpu_seconds_per_seed: 100.0, passes: Some(16) },
    );
    for (method, SyntheticMethod { bias, sigma, .. }) in found.methods.iter().zip([SLOW_METHOD, FAST_METHOD]) {
        for checkpoint in &method.checkpoints {
            let noise2 = sigma * sigma / f64::from(checkpoint.passes);
            // A variance that is estimated from n channels, with one degree of freedom each, has
            // the relative standard deviation √(2/n). Means near 1 are rounded at 6e-8.
            assert_near(checkpoint.squared_noise, 0.5 * noise2, 0.5 * noise2 * (2.0 / CHANNELS).sqrt() + 1e-9);
            let v = bias * bias + noise2;
            assert_near(checkpoint.mean_relative_squared_error(), 0.5 * v, v / CHANNELS.sqrt());
            assert_near(checkpoint.squared_bias, 0.5 * bias * bias, v / CHANNELS.sqrt());
        }
        let error =
            method.relative_pixel_errors.iter().map(|e| f64::from(e * e)).sum::<f64>() / f64::from(SIZE.0 * SIZE.1);
        assert!((error - method.checkpoints.last().unwrap().mean_relative_squared_error()).abs() < 1e-6, "{error}");
        // `mean` is taken over all channels. Each channel has the standard deviation σ/√(16 passes
        // · 2 seeds).
        let mean = method.mean_difference.pixels().iter().map(|d| d.as_dvec3().element_sum()).sum::<f64>() / CHANNELS;
        assert_near(mean, bias, sigma / (32.0 * CHANNELS).sqrt());
    }
    let state = SyntheticStudyState::default();
    let one = SyntheticIntegrator { fake: SLOW_METHOD, seed: 0, state: &state };
    let sum = (0..16).map(|i| one.render_pass(i, &SilentMonitor).image[7].as_dvec3()).sum::<glam::DVec3>();
    assert_eq!(found.methods[0].first_seed_picture.pixels()[7], (sum / 16.0).as_vec3());
}

#[test]
fn references_estimate_their_noise() {
    // The mean of both references has half the variance of each reference. At radiance 1, the
    // relative error of this mean is √(0.2²/2 / 2) = 0.1.
    let reference = references_with_noise(0.2).mean_reference();
    assert_near(reference.error.unwrap(), 0.1, 0.1 / (2.0 * CHANNELS).sqrt() + 5e-4);
    let exact = ReferencePictures::new("here".into(), image_from_pixels(noisy_picture(0.0, 0.0, 0)), None).unwrap();
    assert_eq!(exact.mean_reference().error, None);
}

#[test]
fn reference_algorithm_depends_on_caustics() {
    let (diffuse_sphere_on_floor, glass) = (diffuse_sphere_on_floor(8, 6), glass_sphere_on_floor(8, 6));
    assert_eq!(reference_algorithm(&diffuse_sphere_on_floor, EffectOverrides::NO_OVERRIDES).0, Algorithm::Path);
    assert_eq!(reference_algorithm(&glass, EffectOverrides::NO_OVERRIDES).0, Algorithm::Hybrid);
    assert_eq!(
        reference_algorithm(&glass, EffectOverrides::NO_OVERRIDES.with_forced_off(Effect::Caustics)).0,
        Algorithm::Path
    );
    let render = |seed, interrupted| {
        let camera_paths = CameraPathSettings { seed, ..CameraPathSettings::default() };
        ReferencePictures::render(
            &diffuse_sphere_on_floor,
            &camera_paths,
            0.0,
            &AtomicBool::new(interrupted),
            &SilentMonitor,
            |_, _| {},
        )
        .unwrap()
    };
    let [first, second] = [0, 1].map(|seed| render(seed, false).unwrap());
    assert!(
        first.both_reference_pictures()[0] != first.both_reference_pictures()[1]
            && first.both_reference_pictures()[0] != second.both_reference_pictures()[0]
    );
    assert!(first.mean_reference().source.starts_with("auto: 1 pass of path, twice: "));
    assert!(render(0, true).is_none());
}

#[test]
fn unusable_references_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let good = image_from_pixels(noisy_picture(0.0, 0.2, 0));
    for name in ["a.exr", "a.png"] {
        image::write(&path(name), &good, &WriteOptions::default()).unwrap();
    }
    assert!(
        ReferencePictures::read(&path("a.exr"), None, SIZE).unwrap().mean_reference().source.contains("taken as exact")
    );
    let refused = |name: &str, size| ReferencePictures::read(&path("a.exr"), Some(&path(name)), size).unwrap_err();
    assert!(matches!(refused("a.png", SIZE), ReferenceError::NotLinear { .. }));
    assert!(matches!(refused("b.exr", SIZE), ReferenceError::Read(_)));
    let other = refused("a.exr", (64, 63)).to_string();
    assert!(other.contains("64 × 64 pixels, but the study 64 × 63: give --size 64x64"), "{other}");
    let mut pixels = noisy_picture(0.0, 0.0, 0);
    pixels[70].x = f32::NAN;
    let broken = ReferencePictures::new(String::new(), good, Some(image_from_pixels(pixels))).unwrap_err();
    assert!(broken.to_string().contains("column 6, row 1"), "{broken}");
}
