//! Warnings in reports of a study of methods.

use crate::study::methods::{MIN_THREAD_TIME_SHARE, MethodStudyResult};
use crate::study::report::text::error_percent_text;

/// Smallest reliable value of a method's measured error, as a multiple of the error of the
/// reference. If the measured error is smaller, the report contains a warning.
///
/// At the ratio 3, the squared error of the reference is 1/9 of the squared error of the method.
/// This changes the measured error by about 6 %.
const MIN_RELIABLE_ERROR_RATIO: f64 = 3.0;

/// Returns warnings about a study whose results may be unreliable; empty if there is no reason for
/// doubt.
pub(super) fn study_warnings(result: &MethodStudyResult) -> Vec<String> {
    let mut warnings = Vec::new();
    if result.interrupted {
        warnings.push("The study was interrupted: methods may have had less time than the budget.".to_owned());
    }
    if result.thread_time_share < MIN_THREAD_TIME_SHARE {
        warnings.push(format!(
            "The machine was busy: this program had only {:.0} % of its threads' time at worst. Wall times are too long, and processor \
             times may be too.",
            100.0 * result.thread_time_share
        ));
    }
    if let Some(reference_error) = result.reference.error {
        let close = |m: &&crate::study::methods::MethodResult| {
            m.checkpoints.last().is_some_and(|c| {
                c.mean_relative_squared_error()
                    < MIN_RELIABLE_ERROR_RATIO * MIN_RELIABLE_ERROR_RATIO * reference_error * reference_error
            })
        };
        let labels: Vec<&str> = result.methods.iter().filter(close).map(|m| m.label.as_str()).collect();
        if !labels.is_empty() {
            warnings.push(format!(
                "The reference has an error of about {}, and {} below {MIN_RELIABLE_ERROR_RATIO} times that. Its bias may distort them: render longer references.",
                error_percent_text(reference_error),
                match labels.as_slice() {
                    [one] => format!("that of {one} is"),
                    many => format!("those of {} are", many.join(", ")),
                }
            ));
        }
    }
    warnings
}
