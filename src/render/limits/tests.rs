use super::*;
use crate::integrate::SilentMonitor;
use crate::render::driver::{EndReason, RenderResult, render};
use crate::render::test_integrator::{NoisyIntegrator, SIZE};

/// Integrator with the error σ/√(2n) after n passes: 3 % after 50 passes, 10 % after 5.
const NOISY: NoisyIntegrator = NoisyIntegrator { sigma: 0.3, bias: 0.0, estimates_error: true };

fn rendered(integrator: &NoisyIntegrator, stop: &StopCriteria<'_>) -> RenderResult {
    render(RenderResult::without_passes(integrator, SIZE), 0..u32::MAX, integrator, stop, &SilentMonitor, |_| {})
}

/// Renders with `limits`. Returns the reason of the end and the number of passes.
fn end_reason_and_passes(limits: RenderLimits, algorithm: Algorithm, integrator: &NoisyIntegrator) -> (EndReason, u32) {
    let interrupted = AtomicBool::new(false);
    let made = rendered(integrator, &limits.stop_criteria(algorithm, integrator, &interrupted));
    (made.end_reason, made.film.passes())
}

fn limits() -> RenderLimits {
    RenderLimits::default()
}

#[test]
fn default_render_ends_at_default_error() {
    let interrupted = AtomicBool::new(false);
    let stop = limits().stop_criteria(Algorithm::Hybrid, &NOISY, &interrupted);
    assert_eq!((stop.max_passes, stop.time_limit), (None, Some(DEFAULT_TIME_LIMIT)));
    let made = rendered(&NOISY, &stop);
    let confidence = stop.target.unwrap().interval_confidence();
    let estimate = made.estimator.as_ref().unwrap().estimate_with_confidence(&made.film, confidence);
    assert_eq!(made.end_reason, EndReason::Target);
    assert!(estimate.high <= DEFAULT_TARGET_ERROR && estimate.high > 0.95 * DEFAULT_TARGET_ERROR, "{estimate:?}");
}

#[test]
fn default_render_ends_when_time_is_up() {
    let interrupted = AtomicBool::new(false);
    let stop = limits().stop_criteria(Algorithm::Hybrid, &NOISY, &interrupted);
    let made = rendered(&NOISY, &StopCriteria { time_limit: Some(Duration::from_nanos(1)), ..stop });
    assert_eq!((made.end_reason, made.film.passes()), (EndReason::Time, 1));
    let short = RenderLimits { time_limit: Some(Duration::ZERO), ..limits() };
    assert_eq!(end_reason_and_passes(short, Algorithm::Hybrid, &NOISY), (EndReason::Time, 1));
}

#[test]
fn preview_ends_at_preview_error() {
    let preview = RenderLimits { preview: true, ..limits() };
    let (end_reason, passes) = end_reason_and_passes(preview, Algorithm::Hybrid, &NOISY);
    assert_eq!(end_reason, EndReason::Target);
    assert!((5..8).contains(&passes), "{passes}");
    let short = RenderLimits { max_passes: Some(2), ..preview };
    assert_eq!(end_reason_and_passes(short, Algorithm::Hybrid, &NOISY), (EndReason::Passes, 2));
    let long = RenderLimits { max_passes: Some(99), ..preview };
    assert_eq!(end_reason_and_passes(long, Algorithm::Hybrid, &NOISY), (EndReason::Target, passes));
}

#[test]
fn given_limits_replace_defaults() {
    let many = RenderLimits { max_passes: Some(99), ..limits() };
    assert_eq!(end_reason_and_passes(many, Algorithm::Hybrid, &NOISY), (EndReason::Passes, 99));
    let interrupted = AtomicBool::new(false);
    let coarse = RenderLimits { target_error: Some(0.2), ..limits() };
    let stop = coarse.stop_criteria(Algorithm::Hybrid, &NOISY, &interrupted);
    assert_eq!((stop.max_passes, stop.time_limit, stop.target.map(|t| t.error)), (None, None, Some(0.2)));
    let timed = RenderLimits { time_limit: Some(Duration::from_secs(9)), ..limits() };
    assert_eq!(timed.stop_criteria(Algorithm::Hybrid, &NOISY, &interrupted).target, None);
}

#[test]
fn render_without_error_estimates_makes_default_passes() {
    let blind = NoisyIntegrator { estimates_error: false, ..NOISY };
    for algorithm in Algorithm::ALL {
        let passes = algorithm.default_passes();
        assert_eq!(end_reason_and_passes(limits(), algorithm, &blind), (EndReason::Passes, passes));
        assert_eq!(
            end_reason_and_passes(RenderLimits { preview: true, ..limits() }, algorithm, &blind),
            (EndReason::Passes, passes)
        );
    }
    let long = RenderLimits { time_limit: Some(Duration::from_secs(3600)), ..limits() };
    assert_eq!(end_reason_and_passes(long, Algorithm::Raycast, &blind), (EndReason::Passes, 1));
}

/// A render without limits ends once its noise is small, although bias keeps the error above the
/// default.
///
/// Bias of 20 % keeps the error at 0.2/√2 = 14 %. After 32 passes, the noise is 3 % of the radiance
/// without bias, which is 1.
#[test]
fn default_render_ends_when_only_bias_is_left() {
    let biased = NoisyIntegrator { sigma: 0.24, bias: 0.2, ..NOISY };
    let (end_reason, passes) = end_reason_and_passes(limits(), Algorithm::Pm, &biased);
    assert_eq!(end_reason, EndReason::BiasFloor);
    assert!((32..36).contains(&passes), "{passes}");
    let given = RenderLimits { target_error: Some(0.03), max_passes: Some(40), ..limits() };
    assert_eq!(end_reason_and_passes(given, Algorithm::Pm, &biased), (EndReason::Passes, 40));
}
