//! Studies of methods: error against processor time of algorithms with their settings.

mod clock;
mod command;
pub mod fit;
mod noise_and_bias;
mod references;
mod result;
mod run;
#[cfg(test)]
mod tests;
mod variant;

pub use clock::CpuWallTime;
pub use command::{StudiedScene, shell_command_line};
pub use references::{ReferenceError, ReferencePictures, reference_algorithm};
pub use result::{ConvergenceCheckpoint, MIN_THREAD_TIME_SHARE, MethodResult, MethodStudyResult, Reference};
pub use run::{MethodStudy, MethodStudyEvent, StudyLimits};
pub use variant::{MethodVariant, MethodVariantError, applicable_methods};
