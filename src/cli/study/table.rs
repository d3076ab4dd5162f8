//! Text tables of the results of a study of methods.

use crate::study::methods::fit::{fit_convergence, judge_convergence};
use crate::study::methods::{ConvergenceCheckpoint, MethodStudyResult};
use crate::study::text::percent_text;
use std::fmt::Write as _;

/// Returns text tables, one per method. Each row has the error, noise and bias at one checkpoint.
pub(super) fn checkpoints_table(result: &MethodStudyResult) -> String {
    let mut text = format!("reference: {}", result.reference.source);
    if let Some(error) = result.reference.error {
        let _ = write!(text, "\nreference: noise {}", percent_text(error));
    }
    let _ =
        writeln!(text, "\n{} seeds each; seconds of processor time per seed; - means hidden by noise", result.seeds);
    for method in &result.methods {
        let _ = writeln!(text, "\n{}: prepared in {:.2} s", method.label, method.setup_seconds);
        let _ = writeln!(
            text,
            "  {:>8} {:>10} {:>9} {:>9} {:>9} {:>7} {:>9}",
            "passes", "seconds", "error", "noise", "bias", "rate", "estimated"
        );
        for (i, checkpoint) in method.checkpoints.iter().enumerate() {
            let before = i.checked_sub(1).map(|before| &method.checkpoints[before]);
            let rate = before.and_then(|before| convergence_rate(before, checkpoint));
            let _ = writeln!(
                text,
                "  {:>8} {:>10.3} {:>9} {:>9} {:>9} {:>7} {:>9}",
                checkpoint.passes,
                checkpoint.cpu_seconds,
                square_root_percent_text(checkpoint.mean_relative_squared_error()),
                square_root_percent_text(checkpoint.squared_noise),
                square_root_percent_text(checkpoint.squared_bias),
                rate.map_or(String::new(), |rate| format!("{rate:.2}")),
                rms_estimated_error_text(checkpoint),
            );
        }
        let _ =
            writeln!(text, "  {}", judge_convergence(method, fit_convergence(method).as_ref(), result.reference.error));
        let _ = writeln!(text, "  {}", method.render_command);
    }
    text
}

/// Returns the square root of `square` in percent, or `-` if `square` is not positive. The estimate
/// of a squared error can be negative if noise hides the error.
pub(super) fn square_root_percent_text(square: f64) -> String {
    if square > 0.0 { percent_text(square.sqrt()) } else { "-".to_owned() }
}

/// Returns the error that the renderer estimated itself, without a reference, in percent: the root
/// mean square over all seeds. Returns an empty text if there are no such estimates.
fn rms_estimated_error_text(checkpoint: &ConvergenceCheckpoint) -> String {
    checkpoint.mean_square_of_estimated_error().map_or(String::new(), square_root_percent_text)
}

/// Returns the exponent k in error ∝ time^k between two checkpoints. The error is the root of the
/// mean squared error over seeds, and the time is processor time.
///
/// Returns `None` if an estimated squared error is not positive, or if k is not finite. For
/// example, k is not finite between equal times.
fn convergence_rate(before: &ConvergenceCheckpoint, after: &ConvergenceCheckpoint) -> Option<f64> {
    let squares = [before, after].map(ConvergenceCheckpoint::mean_relative_squared_error);
    if squares.iter().any(|square| *square <= 0.0) {
        return None;
    }
    let error = 0.5 * libm::log(squares[1] / squares[0]);
    let rate = error / libm::log(after.cpu_seconds / before.cpu_seconds);
    rate.is_finite().then_some(rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn convergence_rate_is_exponent_of_time() {
        let at = |seconds, square| ConvergenceCheckpoint {
            cpu_seconds: seconds,
            relative_squared_errors: vec![square; 2],
            ..ConvergenceCheckpoint::default()
        };
        // In four times the time, the squared error falls to a quarter. The error falls to a half,
        // so the exponent is −½.
        assert!((convergence_rate(&at(1.0, 0.04), &at(4.0, 0.01)).unwrap() + 0.5).abs() < 1e-12);
        assert_eq!(convergence_rate(&at(1.0, -0.04), &at(4.0, -0.01)), None);
        assert_eq!(
            (convergence_rate(&at(1.0, 0.04), &at(1.0, 0.01)), convergence_rate(&at(1.0, 0.04), &at(4.0, -0.01))),
            (None, None)
        );
        assert_eq!(
            (square_root_percent_text(0.0009), square_root_percent_text(-0.1)),
            ("3.0 %".to_owned(), "-".to_owned())
        );
    }
}
