//! Texts about the estimated error of a picture, and about the time until the error is lower.

use crate::render::ErrorTarget;
use crate::render::error_estimate::{BiasPart, ErrorEstimate, StopForecast};
use crate::study::text::percent_text;

/// Returns advice for a render whose bias keeps the error above the target. `part` is the largest
/// part of the bias that remains.
pub(super) fn bias_remedy(part: BiasPart) -> &'static str {
    match part {
        BiasPart::Blur => "choose a smaller --radius, or --integrator sppm or hybrid, whose radii shrink",
        BiasPart::SharedPaths => {
            "passes of ppm share their camera paths: choose a larger --spp, or --integrator sppm or hybrid"
        }
        BiasPart::Clamping => "--clamp removes light: choose a larger limit, or leave out --clamp",
    }
}

/// Usage error: a flag needs an error estimate, but the algorithm is `raycast`, which makes only
/// one pass and no estimate.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} needs an error estimate, and raycast makes one pass, which has none")]
#[diagnostic(help("leave it out, or choose another --integrator"))]
pub(super) struct ErrorEstimateUnsupportedError {
    pub flag: &'static str,
}

/// Returns an estimated error with its noise and bias, such as `2.1 % (noise 1.9 %, bias 0.8 %)`.
pub(super) fn error_text(estimate: &ErrorEstimate) -> String {
    format!(
        "{} (noise {}, bias {})",
        percent_text(estimate.error),
        percent_text(estimate.noise),
        percent_text(estimate.bias)
    )
}

/// Returns a text that says when a render reaches the relative error `target`, such as `; 1.0 % in
/// about 42 s (35 s to 50 s)`.
///
/// `estimate` is the error of the passes so far. `forecast` predicts the number of passes that
/// reach `target`. `pass_seconds` is the time of one pass \[s]. The text is empty if the error so
/// far is 0.
pub(super) fn time_to_target_text(
    estimate: &ErrorEstimate,
    target: ErrorTarget,
    forecast: StopForecast,
    pass_seconds: f64,
) -> String {
    if estimate.error == 0.0 {
        return String::new();
    }
    let error = percent_text(target.error);
    let time = |n: u32| duration_text(f64::from(n.saturating_sub(estimate.passes)) * pass_seconds);
    match forecast {
        StopForecast::Passes(range) => {
            let high = range.high.map_or("unknown".to_owned(), time);
            format!("; {error} in about {} ({} to {high})", time(range.median), time(range.low))
        }
        StopForecast::Never { floor } => format!("; {error} never: {} is bias that stays", percent_text(floor)),
        StopForecast::TooFar { at_least } => {
            format!("; {error}: cannot tell yet, at least {}", time(at_least))
        }
    }
}

/// Returns a duration in seconds as text, such as `0.8 s`, `3 min 20 s` or `5 h 10 min`.
pub(super) fn duration_text(seconds: f64) -> String {
    if seconds < 9.95 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round().min(1e15) as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        3600..172_800 => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
        172_800.. => format!("{} d", whole / 86_400),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_use_the_unit_that_fits() {
        let texts = [0.0, 9.94, 9.96, 59.6, 200.0, 18_600.0, 1e6, f64::INFINITY].map(duration_text);
        assert_eq!(texts[..7], ["0.0 s", "9.9 s", "10 s", "1 min 0 s", "3 min 20 s", "5 h 10 min", "11 d"]);
        assert!(texts[7].ends_with(" d"), "{}", texts[7]);
    }
}
