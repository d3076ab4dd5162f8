//! How the error of each method falls with time.

mod clock;
mod command;
pub mod fit;
mod found;
mod run;
mod split;
#[cfg(test)]
mod tests;
mod truth;
mod variant;

pub use clock::Moment;
pub use command::{Subject, in_shell};
pub use found::{Checkpoint, MethodFound, MethodsFound, Truth};
pub use run::{Limits, MethodStudy, Step};
pub use truth::{References, TruthError, truthful};
pub use variant::{Variant, VariantError, methods_for};
