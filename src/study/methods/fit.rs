//! Convergence of error, noise and bias: slopes, theory, verdicts, and time to reach an error.
//!
//! A slope is that of the least-squares line through the tail of a log-log plot. The tail consists
//! of the checkpoints with at least 1/16 of the passes of the last checkpoint. Confidence intervals
//! come from a bootstrap over seeds. It resamples whole seeds, since the checkpoints of a seed
//! share passes.

mod slopes;
mod theory;
mod time_to_error;
mod verdict;

pub use slopes::{ConvergenceFit, ConvergenceSlopes, SlopeEstimate, fit_convergence, mean_confidence_interval};
pub use theory::{ErrorComponent, SlopeRange, predicted_slopes};
pub use time_to_error::{
    MethodRecommendation, ParetoPoint, RenderEffort, TimeToError, error_after_seconds, pareto_front, recommend_method,
    time_to_error, time_to_tenth_of_error,
};
pub use verdict::{BIAS_DOMINATED_SHARE, BiasCause, ConvergenceVerdict, judge_convergence};

#[cfg(test)]
mod tests;
