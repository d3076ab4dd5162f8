//! Comparison of passes of two renders that share their random numbers.

use crate::support::{mean_and_error, student_t_tail};
use caustica::color::Rgb;
use glam::DVec3;

/// False-alarm rate of the comparison of one number.
///
/// A test run compares some thousand numbers, so one run in 10⁴ has a false alarm.
pub const RATE: f64 = 1e-8;

/// Relative change of a mean by rounding.
///
/// The color of a stored photon rounds by half a step of 2⁻¹⁶ of the channel sum, which is 1.5·2⁻¹⁶
/// of a grey channel. The throughput of a path, a product of about a hundred factors that round to
/// 2⁻²⁴ each, adds 100·2⁻²⁴.
pub const ROUNDING: f64 = 1.5 / 65_536.0 + 100.0 / 16_777_216.0;

/// Returns the mean over the image and over each of its quarters, by channels: 15 numbers.
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

/// Returns a message if the means of `ours` and `theirs` differ by more than the fraction `slack`.
///
/// Also returns a message if noise would hide a difference of the fraction `detectable` of the
/// brightest of the first three numbers. Returns `None` otherwise. Passes are paired by their
/// random numbers. Differences of pairs are independent, and Student's t tests whether their mean
/// is 0.
pub fn mean_difference(ours: &[Vec<f64>], theirs: &[Vec<f64>], slack: f64, detectable: f64) -> Option<String> {
    let dof = ours.len() as f64 - 1.0;
    let column = |of: &[Vec<f64>], i: usize| of.iter().map(|pass| pass[i]).collect::<Vec<f64>>();
    let max_relative_error = detectable / quantile(RATE, dof);
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
        let p = if excess == 0.0 { 1.0 } else { student_t_tail(excess / error, dof) };
        let is_too_noisy = i < 3 && error > max_relative_error * brightest;
        let why = if is_too_noisy { "the error bar is too wide" } else { "the means differ" };
        (p < RATE || is_too_noisy)
            .then(|| format!("number {i}: {why}: {mean:.3e} ± {error:.1e} of {level:.6e}, p = {p:.1e}"))
    })
}

/// Returns the two-sided quantile of Student's distribution for probability `rate`, by bisection.
fn quantile(rate: f64, dof: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e4);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if student_t_tail(middle, dof) > rate { low = middle } else { high = middle }
    }
    high
}
