//! Student's t-test of sample means, and quadrature by midpoints.

use std::f64::consts::PI;

/// False-alarm rate of one two-sided comparison.
pub const FALSE_ALARM_RATE: f64 = 1e-6;

/// Returns the mean of independent samples and the standard error of this mean.
pub fn mean_and_error(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let squares: f64 = samples.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// Integrates `f` from `a` to `b` by the midpoint rule with `n` steps.
///
/// The error is at most (b−a)³/(24n²)·max|f″| for smooth f, and (b−a)/n·|jump| at a jump.
pub fn midpoint_integral(a: f64, b: f64, n: u32, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b - a) / f64::from(n);
    (0..n).map(|i| f(a + (f64::from(i) + 0.5) * h)).sum::<f64>() * h
}

/// Returns P(|T| ≥ t) for a variable T of Student's distribution with ν = `dof` degrees of freedom.
///
/// It is integrated over φ. With T = √ν tanφ, the density of φ is proportional to cosᵛ⁻¹φ.
pub fn student_t_tail(t: f64, dof: f64) -> f64 {
    let norm = libm::exp(libm::lgamma(0.5 * (dof + 1.0)) - libm::lgamma(0.5 * dof)) / PI.sqrt();
    let density = |phi: f64| libm::pow(libm::cos(phi).max(0.0), dof - 1.0);
    2.0 * norm * midpoint_integral(libm::atan(t.abs() / dof.sqrt()), 0.5 * PI, 4000, density)
}

/// Panics if `samples` contradict a mean within `expected` ± `slack`.
///
/// The test is Student's, with the false-alarm rate [`FALSE_ALARM_RATE`]. Also panics if the
/// standard error exceeds `max_relative_error` · `expected`, because noise could then hide an
/// error.
#[track_caller]
pub fn assert_mean(what: &str, samples: &[f64], expected: f64, slack: f64, max_relative_error: f64) {
    let (mean, error) = mean_and_error(samples);
    let excess = ((mean - expected).abs() - slack).max(0.0);
    let p = if excess == 0.0 { 1.0 } else { student_t_tail(excess / error, samples.len() as f64 - 1.0) };
    let line = format!("{what}: {mean:.6e} ± {error:.1e}, expected {expected:.6e} (p = {p:.1e})");
    eprintln!("{line}");
    assert!(p >= FALSE_ALARM_RATE, "{line}");
    assert!(error <= max_relative_error * expected.abs(), "{line}: too blunt, {:.1e}", error / expected.abs());
}
