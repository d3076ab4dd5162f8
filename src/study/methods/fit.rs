//! Convergence of error, noise and bias: slopes, theory, verdicts, and time to reach an error.
//!
//! A slope is the slope of a least-squares line in a log-log plot of error, noise or bias over time
//! or passes. The line is fitted to the checkpoints (measurements during a render) that have at
//! least 1/16 of the passes of the last one. Confidence intervals come from a bootstrap over seeds.
//! It draws all checkpoints of a seed's render together, because they share passes.

mod slopes;
mod theory;
mod time_to_error;
mod verdict;

pub use slopes::{ConvergenceFit, ConvergenceSlopes, SlopeEstimate, fit_convergence, mean_confidence_interval};
pub use theory::{ErrorComponent, SlopeRange, predicted_convergence_slopes};
pub use time_to_error::{
    MAX_EXTRAPOLATION_FACTOR, MethodRecommendation, ParetoPoint, RenderEffort, TimeToError, error_after_cpu_seconds,
    pareto_front, recommend_method, time_to_error, time_to_tenth_of_error,
};
pub use verdict::{BiasCause, ConvergenceVerdict, DOMINANT_SQUARED_BIAS_SHARE, judge_convergence};

#[cfg(test)]
mod tests;
