//! True and estimated errors of pictures with foci, and the light in windows around them.
//!
//! The truth comes from two long renders A and B whose caustics on visible surfaces are found by
//! light tracing alone, and all others by a tenth of the radius. E[(I − A)(I − B)] is the squared
//! error of a picture I, although A and B are noisy.

use crate::arguments::Arguments;
use crate::focus::{Check, Focus, SIZE};
use crate::settings;
use caustica::image::RelativeErrorWeights;
use caustica::integrate::{Algorithm, IndirectPhotons, LightTracing, Settings, SilentMonitor};
use caustica::render::Film;
use caustica::render::error_estimate::{ErrorEstimate, ErrorEstimator};
use caustica::stats::cpu_seconds;
use glam::{DVec3, Vec3};
use std::error::Error;

/// Number of passes after which the light in the window is compared.
const WINDOW_PASSES: u32 = 16;

/// Number of seeds whose light in the window is compared.
const WINDOW_SEEDS: u64 = 8;

/// Default number of photon paths in all directions, as in `calibration`.
const PHOTONS: u32 = 20_000;

/// Kinds of errors: relative to the local light and clamped to 1 for each pixel, as estimated; of
/// radiance over its mean in the picture; and of radiance over its mean in the window, without the
/// rest of the picture.
const ERRORS: [&str; 3] = ["relative", "of radiance", "in the window"];

/// A mean with its standard error.
#[derive(Clone, Copy)]
struct Measured {
    mean: f64,
    error: f64,
}

impl Measured {
    fn of(samples: &[f64]) -> Self {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let square = samples.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
        Self { mean, error: (square / n).sqrt() }
    }

    /// Returns the ratio to another measured value.
    fn over(self, other: Self) -> Self {
        let part = (self.error / self.mean).hypot(other.error / other.mean);
        Self { mean: self.mean / other.mean, error: self.mean / other.mean * part }
    }
}

impl std::fmt::Display for Measured {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.4} ± {:.4}", self.mean, self.error)
    }
}

/// A picture, and the light in the window by pass.
struct Render {
    pixels: Vec<Vec3>,
    light: Vec<f64>,
}

fn render(focus: &Focus, algorithm: Algorithm, settings: Settings, passes: u32) -> Render {
    let integrator = algorithm.prepare(&focus.scene, settings);
    let (mut film, mut light) = (Film::new(SIZE.0, SIZE.1), Vec::new());
    for pass in 0..passes {
        let image = integrator.render_pass(pass, &SilentMonitor).image;
        light.push(focus.light(&image));
        film.add(&image);
    }
    Render { pixels: film.mean_picture(), light }
}

/// Two long renders, and their light in the window.
struct Truth {
    pictures: [Vec<Vec3>; 2],
    scale: RelativeErrorWeights,
    mean: f64,
    light: Measured,
}

impl Truth {
    fn new(focus: &Focus, settings: &Settings, passes: u32) -> Self {
        let [a, b] = [1, 2].map(|seed| {
            let mut settings = settings.clone();
            settings.camera_paths.seed = seed << 40;
            render(focus, Algorithm::Hybrid, settings, passes)
        });
        let both: Vec<Vec3> = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a + *b) * 0.5).collect();
        let mean = both.iter().map(|p| p.as_dvec3().element_sum()).sum::<f64>() / (3.0 * both.len() as f64);
        let scale = RelativeErrorWeights::from_pixels(SIZE, &both);
        let light = Measured::of(&[a.light, b.light].concat());
        Self { pictures: [a.pixels, b.pixels], scale, mean, light }
    }

    /// Returns the squared errors of a picture, in the order of [`ERRORS`].
    fn squares(&self, focus: &Focus, pixels: &[Vec3]) -> [f64; 3] {
        let product = |i: usize| -> DVec3 {
            let [a, b] = [0, 1].map(|k| (pixels[i] - self.pictures[k][i]).as_dvec3());
            a * b
        };
        let radiance = |pixels: &mut dyn Iterator<Item = usize>, mean: f64| {
            let squares: Vec<f64> = pixels.map(|i| product(i).element_sum() / 3.0).collect();
            squares.iter().sum::<f64>() / (squares.len() as f64 * mean * mean)
        };
        let window = self.light.mean / focus.pixels().count() as f64;
        [
            self.scale.mean_relative_squared_error(product),
            radiance(&mut (0..pixels.len()), self.mean),
            radiance(&mut focus.pixels(), window),
        ]
    }
}

/// Settings of a reference: small gather discs of a fixed radius, and four times the photons.
fn reference_settings(focus: &Focus, usual: &Settings, light_tracing: LightTracing) -> Settings {
    let radii = Algorithm::Hybrid.prepare(&focus.scene, usual.clone()).initial_gather_radii();
    Settings {
        initial_gather_radius: radii.map(|radii| radii.caustic / 10.0),
        alpha: 1.0,
        gather_k: Some(0),
        unaimed_paths: 4 * usual.unaimed_paths,
        aimed_paths: 4 * usual.aimed_paths,
        allows_ray_photon_balance: false,
        indirect_photons: IndirectPhotons::Off,
        light_tracing,
        ..usual.clone()
    }
}

/// Returns the light in the window by a way without light tracing.
fn check(focus: &Focus, usual: &Settings, passes: u32) -> (&'static str, Measured) {
    match focus.check {
        Check::PathTracing => {
            let mut settings = usual.clone();
            settings.camera_paths.samples_per_pixel = Some(64);
            ("`path`", Measured::of(&render(focus, Algorithm::Path, settings, passes).light))
        }
        Check::PhotonEstimates => {
            let settings = reference_settings(focus, usual, LightTracing::Off);
            ("photon estimates", Measured::of(&render(focus, Algorithm::Hybrid, settings, passes).light))
        }
        Check::ClosedForm(light) => ("closed form", Measured { mean: light, error: 0.0 }),
    }
}

/// Picture of one seed after some number of passes.
struct Sample {
    squares: [f64; 3],
    estimate: ErrorEstimate,
}

/// Returns the samples of one seed for each number of passes, and the light in the window.
fn samples(focus: &Focus, truth: &Truth, mut settings: Settings, passes: &[u32]) -> (Vec<Sample>, Measured) {
    settings.camera_paths.estimate_error = true;
    let integrator = Algorithm::Hybrid.prepare(&focus.scene, settings);
    let (mut film, mut estimator) = (Film::new(SIZE.0, SIZE.1), ErrorEstimator::new(integrator.radius_law()));
    let (mut samples, mut light) = (Vec::new(), Vec::new());
    for pass in 0..passes.iter().copied().max().unwrap_or(0) {
        let made = integrator.render_pass(pass, &SilentMonitor);
        if pass < WINDOW_PASSES {
            light.push(focus.light(&made.image));
        }
        estimator.add(pass, &made);
        film.add(&made.image);
        if passes.contains(&(pass + 1)) {
            samples.push(Sample {
                squares: truth.squares(focus, &film.mean_picture()),
                estimate: estimator.estimate(&film),
            });
        }
    }
    (samples, Measured::of(&light))
}

/// Returns the slope of the root of `squares`, against passes, on logarithmic scales.
fn slope(passes: &[u32], squares: &[f64]) -> f64 {
    let n = passes.len() as f64;
    let x: Vec<f64> = passes.iter().map(|n| libm::log(f64::from(*n))).collect();
    let y: Vec<f64> = squares.iter().map(|s| 0.5 * libm::log(*s)).collect();
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let product: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    product / x.iter().map(|x| (x - mx) * (x - mx)).sum::<f64>()
}

/// Returns the root of a squared error in percent. The square of a small error may be negative,
/// because the truth is noisy; it then has no root.
fn root(square: f64) -> String {
    if square > 0.0 { format!("{:.2} %", 100.0 * square.sqrt()) } else { "–".to_owned() }
}

/// Prints the errors of one kind by passes, and the slope from [`WINDOW_PASSES`] passes on with its
/// standard error by the jackknife over seeds.
fn print_errors(name: &str, kind: usize, passes: &[u32], seeds: &[Vec<Sample>]) {
    let mean = |without: Option<usize>, at: usize| {
        let kept = seeds.iter().enumerate().filter(|(seed, _)| Some(*seed) != without);
        let squares: Vec<f64> = kept.map(|(_, samples)| samples[at].squares[kind]).collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    let from = passes.iter().position(|n| *n >= WINDOW_PASSES).unwrap_or(0);
    let fitted = |without| {
        let squares: Vec<f64> = (from..passes.len()).map(|at| mean(without, at)).collect();
        slope(&passes[from..], &squares)
    };
    let left_out: Vec<f64> = (0..seeds.len()).map(|seed| fitted(Some(seed))).collect();
    let error = Measured::of(&left_out).error * (seeds.len() as f64 - 1.0);
    print!("| {name} | {} ", ERRORS[kind]);
    for at in 0..passes.len() {
        print!("| {} ", root(mean(None, at)));
    }
    let uncertainty = if error.is_finite() { format!(" ± {error:.2}") } else { String::new() };
    let slope = fitted(None);
    if slope.is_finite() { println!("| {slope:.2}{uncertainty} |") } else { println!("| – |") }
}

/// Prints estimated errors at `passes[at]`, and whether they rise to the next number of passes.
fn print_estimates(name: &str, at: usize, passes: &[u32], seeds: &[Vec<Sample>]) {
    let mean = |of: &dyn Fn(&ErrorEstimate) -> f64| {
        100.0 * seeds.iter().map(|samples| of(&samples[at].estimate)).sum::<f64>() / seeds.len() as f64
    };
    let square = seeds.iter().map(|samples| samples[at].squares[0]).sum::<f64>() / seeds.len() as f64;
    print!("| {name} | {} | {} | {:.2} % ", passes[at], root(square), mean(&|e| e.error));
    print!("| {:.2} % to {:.2} % ", mean(&|e| e.low), mean(&|e| e.high));
    if at + 1 < passes.len() {
        let rises: Vec<f64> =
            seeds.iter().map(|samples| samples[at + 1].estimate.error / samples[at].estimate.high).collect();
        let most = rises.iter().copied().fold(0.0, f64::max);
        println!("| {most:.2} | {}/{} |", rises.iter().filter(|r| **r > 1.0).count(), rises.len());
    } else {
        println!("| | |");
    }
}

pub fn print(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let names: Vec<&str> = match arguments.names.as_slice() {
        [] => Focus::NAMES.to_vec(),
        names => names.iter().map(String::as_str).collect(),
    };
    let passes = arguments.passes.clone().unwrap_or_else(|| vec![4, 16, 64, 256, 1024]);
    let part = f64::from(arguments.photons.unwrap_or(PHOTONS)) / f64::from(Settings::default().unaimed_paths);
    let truth_passes = arguments.truth.unwrap_or(1024);
    for name in names {
        let focus = Focus::new(name)?;
        let start = cpu_seconds().unwrap_or(0.0);
        let usual = settings(arguments, 0, part)?;
        let truth = Truth::new(&focus, &reference_settings(&focus, &usual, LightTracing::Full), truth_passes);
        let (way, light) = check(&focus, &usual, truth_passes);
        let prepared = cpu_seconds().unwrap_or(0.0);
        println!("\nLight in the window of {name}, {way} over light tracing: {}", light.over(truth.light));
        let light = if light.error < truth.light.error { light } else { truth.light };

        let (mut seeds, mut ratios) = (Vec::new(), Vec::new());
        let long_seeds = arguments.seeds.unwrap_or(4);
        for seed in 0..long_seeds.max(WINDOW_SEEDS) {
            let long = seed < long_seeds;
            let passes = if long { passes.as_slice() } else { &[WINDOW_PASSES] };
            let (samples, window) = samples(&focus, &truth, settings(arguments, seed, part)?, passes);
            ratios.push(window.over(light));
            if long {
                seeds.push(samples);
            }
        }
        let off = ratios.iter().map(|ratio| (ratio.mean - 1.0).abs()).fold(0.0, f64::max);
        println!("\n| focus | seed | light after {WINDOW_PASSES} passes / truth |\n| --- | --- | --- |");
        for (seed, ratio) in ratios.iter().enumerate() {
            println!("| {name} | {seed} | {ratio} |");
        }
        println!("\nGreatest deviation: {:.2} %", 100.0 * off);
        let counts: Vec<String> = passes.iter().map(|n| format!("{n} passes")).collect();
        println!(
            "\n| focus | error | {} | slope |\n| --- | ---{} | --- |",
            counts.join(" | "),
            " | ---".repeat(passes.len())
        );
        (0..ERRORS.len()).for_each(|kind| print_errors(name, kind, &passes, &seeds));
        println!(
            "\n| focus | passes | true error | estimated | interval | most rise | rises |\n|{}",
            " --- |".repeat(7)
        );
        (0..passes.len()).for_each(|at| print_estimates(name, at, &passes, &seeds));
        let end = cpu_seconds().unwrap_or(0.0);
        eprintln!("{name}: truth {:.0} s, renders {:.0} s", prepared - start, end - prepared);
    }
    Ok(())
}
