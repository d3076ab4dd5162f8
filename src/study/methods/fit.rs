//! Convergence of error, noise and bias: slopes, theory, verdicts, and time to reach an error.
//!
//! Slopes are least-squares lines of logarithms over the tail: checkpoints with at least 1/16 of
//! the last one's passes. Intervals resample seeds; a seed brings all its checkpoints, since these
//! share passes.

mod slopes;
mod theory;
mod time_to_error;
mod verdict;

pub use slopes::{Fit, Slope, Slopes, fit, mean_interval};
pub use theory::{Law, Quantity, predicted_law};
pub use time_to_error::{
    Effort, ParetoPoint, Recommendation, TimeToError, error_at, pareto, recommend, time_to_error, time_to_tenth,
};
pub use verdict::{BIAS_SHARE, Cause, Verdict, verdict};

#[cfg(test)]
mod tests;
