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

pub use clock::CpuWallTime;
pub use command::{StudySubject, shell_quoted};
pub use result::{Checkpoint, MethodResult, MethodStudyResult, Truth};
pub use run::{MethodStudy, StudyLimits, StudyProgress};
pub use truth::{References, TruthError, reference_algorithm};
pub use variant::{Variant, VariantError, applicable_methods};
