use super::*;
use crate::integrate::{Algorithm, SilentMonitor};
use crate::render::driver::{RenderResult, render};
use crate::render::limits::RenderLimits;
use crate::render::test_integrator::{NoisyIntegrator, SIZE};
use std::sync::atomic::AtomicBool;

const NOISY: NoisyIntegrator = NoisyIntegrator { sigma: 0.3, bias: 0.0, estimates_error: true };

/// Returns the end of a render with `limits` that a pilot (trial render) of 8 passes predicts, and
/// the real end of the render.
fn expected_and_actual_end(
    limits: RenderLimits,
    integrator: &NoisyIntegrator,
    pass_seconds: f64,
) -> (ExpectedEnd, (EndReason, u32)) {
    let interrupted = AtomicBool::new(false);
    let stop = limits.stop_criteria(Algorithm::Pm, integrator, &interrupted);
    let eight = StopCriteria { max_passes: Some(8), ..StopCriteria::unlimited(&interrupted) };
    let start = || RenderResult::without_passes(integrator, SIZE);
    let pilot = render(start(), 0..u32::MAX, integrator, &eight, &SilentMonitor, |_| {});
    let estimator = pilot.estimator.unwrap();
    let estimate = estimator.estimate(&pilot.film);
    let forecast = estimator.forecast(&estimate).unwrap();
    let made = render(start(), 0..u32::MAX, integrator, &stop, &SilentMonitor, |_| {});
    (stop.expected_end(&forecast, pass_seconds).unwrap(), (made.end_reason, made.film.passes()))
}

/// The predicted number of passes is right to a twentieth, because `render` estimates the error
/// only each time that the number of passes has grown by a twentieth.
#[test]
fn expected_end_agrees_with_render() {
    let biased = NoisyIntegrator { sigma: 0.24, bias: 0.2, ..NOISY };
    for (integrator, preview) in [(&NOISY, false), (&NOISY, true), (&biased, false)] {
        let (expected, (end_reason, passes)) =
            expected_and_actual_end(RenderLimits { preview, ..RenderLimits::default() }, integrator, 1e-3);
        assert_eq!(expected.reason, end_reason);
        assert!(expected.passes.abs_diff(passes) <= 1 + passes / 20, "{} {passes}", expected.passes);
    }
}

/// The default time limit ends a render of slow passes.
///
/// The limit of five minutes allows 5 passes of one minute. The error after the fifth pass is
/// σ/√10.
#[test]
fn slow_passes_end_by_time() {
    let (expected, _) = expected_and_actual_end(RenderLimits::default(), &NOISY, 60.0);
    assert_eq!((expected.reason, expected.passes), (EndReason::Time, 5));
    assert!((expected.error / (0.3 / 10f64.sqrt()) - 1.0).abs() < 0.05, "{}", expected.error);
}

/// Without limits of passes and time, a bias above the target ends a render at any noise.
#[test]
fn unreachable_targets_end_renders_without_limits() {
    let biased = NoisyIntegrator { sigma: 0.24, bias: 0.2, ..NOISY };
    let limits = RenderLimits { target_error: Some(0.05), ..RenderLimits::default() };
    let (expected, end) = expected_and_actual_end(limits, &biased, 1e-3);
    assert_eq!((expected.reason, expected.passes), (EndReason::BiasFloor, 16));
    assert_eq!(end, (EndReason::BiasFloor, 16));
}
