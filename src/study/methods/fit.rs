//! Convergence of error, noise and bias: slopes, theory, verdicts, and time to reach an error.
//!
//! Slopes are least-squares lines of logarithms over the tail: checkpoints with at least 1/16 of
//! the last one's passes. Intervals resample seeds; a seed brings all its checkpoints, since these
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
