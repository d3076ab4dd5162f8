//! The render loop: runs an integrator pass by pass, averages the passes and estimates their error.

mod driver;
pub mod error_estimate;
mod film;

pub use driver::{EndReason, ErrorTarget, PassProgress, RenderResult, StopCriteria, render};
pub use film::Film;
