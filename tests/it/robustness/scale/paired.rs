//! Passes of two renders that share their random numbers, compared.

use crate::support::{mean_and_error, student};
use caustica::color::Rgb;
use glam::DVec3;

/// False-alarm rate of one number of a comparison: some thousand of them are compared in all, so that all together cry wolf once in 10⁴ runs.
pub const RATE: f64 = 1e-8;

/// What rounding may change of a mean, as part of it. A stored photon's hue is rounded to steps of 2⁻¹⁶ of the sum of its channels, by
/// half a step, which is 1.5·2⁻¹⁶ of a grey channel; a walk of some hundred factors, each rounded to 2⁻²⁴, adds 100·2⁻²⁴.
pub const ROUNDING: f64 = 1.5 / 65_536.0 + 100.0 / 16_777_216.0;

/// The mean of each pass over the whole picture and over its quarters, by channels: 15 numbers a pass.
pub fn summary(image: &[Rgb], (width, height): (u32, u32)) -> Vec<f64> {
    let (width, height) = (width as usize, height as usize);
    let mut sums = [DVec3::ZERO; 4];
    for (i, value) in image.iter().enumerate() {
        assert!(value.is_finite(), "pixel {i} is {value}");
        sums[usize::from(i % width >= width / 2) + 2 * usize::from(i / width >= height / 2)] += value.as_dvec3();
    }
    let pixels = (width * height) as f64;
    let whole = sums.iter().sum::<DVec3>() / pixels;
    let quarters = sums.iter().map(|s| *s * 4.0 / pixels);
    [whole].into_iter().chain(quarters).flat_map(|v| v.to_array()).collect()
}

/// What is wrong with the claim that `ours` and `theirs`, numbers of passes, have the same means but for the part `slack`, or that their first
/// three differ by so much noise that a difference of the part `told` of the brightest would pass; `None` where nothing is.
///
/// A pass of one goes with the pass of the other that has its random numbers. Differences of such pairs are independent, and Student's t
/// tells whether their mean is 0.
pub fn objection(ours: &[Vec<f64>], theirs: &[Vec<f64>], slack: f64, told: f64) -> Option<String> {
    let dof = ours.len() as f64 - 1.0;
    let column = |of: &[Vec<f64>], i: usize| of.iter().map(|pass| pass[i]).collect::<Vec<f64>>();
    let sharp = told / quantile(RATE, dof);
    let brightest = (0..3).map(|i| mean_and_error(&column(theirs, i)).0).fold(0.0, f64::max);
    if brightest <= 0.0 {
        return Some("all is black".to_owned());
    }
    (0..ours[0].len()).find_map(|i| {
        let (a, b) = (column(ours, i), column(theirs, i));
        let level = mean_and_error(&b).0;
        let differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let (mean, error) = mean_and_error(&differences);
        let excess = (mean.abs() - slack * level.abs()).max(0.0);
        let p = if excess == 0.0 { 1.0 } else { student(excess / error, dof) };
        let blunt = i < 3 && error > sharp * brightest;
        let why = if blunt { "the error bar is too wide" } else { "the means differ" };
        (p < RATE || blunt).then(|| format!("number {i}: {why}: {mean:.3e} ± {error:.1e} of {level:.6e}, p = {p:.1e}"))
    })
}

/// The t beyond which a part `rate` of Student's distribution lies, by halving.
fn quantile(rate: f64, dof: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e4);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if student(middle, dof) > rate { low = middle } else { high = middle }
    }
    high
}
