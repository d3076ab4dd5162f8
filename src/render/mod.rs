//! The render loop: it runs passes of an integrator, averages them and estimates the error.

mod driver;
pub mod error_estimate;
mod expected_end;
mod film;
mod limits;
mod merge_error;
#[cfg(test)]
mod test_integrator;

pub use driver::{EndReason, ErrorTarget, PassProgress, RenderResult, StopCriteria, render};
pub use expected_end::ExpectedEnd;
pub use film::Film;
pub use limits::{DEFAULT_ERROR, DEFAULT_TIME, PREVIEW_ERROR, RenderLimits};
pub use merge_error::MergeError;

#[cfg(test)]
mod tests;
