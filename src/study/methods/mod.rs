//! Studies of methods: their error over time.

mod clock;
mod command;
pub mod fit;
mod result;
mod run;
mod split;
#[cfg(test)]
mod tests;
mod truth;
mod variant;

pub use clock::Moment;
pub use command::{Subject, in_shell};
pub use result::{Checkpoint, MethodResult, MethodStudyResult, Truth};
pub use run::{Limits, MethodStudy, Step};
pub use truth::{References, TruthError, reference_algorithm};
pub use variant::{Variant, VariantError, methods_for};
