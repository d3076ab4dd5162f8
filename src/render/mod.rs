//! The render loop: it runs passes of an integrator, averages them and estimates the error.

mod driver;
pub mod error_estimate;
mod film;
mod merge_error;

pub use driver::{EndReason, ErrorTarget, PassProgress, RenderResult, StopCriteria, render};
pub use film::Film;
pub use merge_error::MergeError;

#[cfg(test)]
mod tests;
