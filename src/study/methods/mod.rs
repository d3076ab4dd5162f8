//! How the error of each method falls with time.

mod found;

pub use found::{Checkpoint, MethodFound, MethodsFound, Truth};
