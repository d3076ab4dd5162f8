//! Error type for merging the passes of two renders.

use super::pass_set::PassSet;

/// Error: the passes of two renders cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// The pictures have different sizes (width, height).
    #[error("a film of {} × {} pixels cannot be added to one of {} × {}", other.0, other.1, own.0, own.1)]
    SizeMismatch {
        /// Size of the picture to which passes are added: width and height \[pixels].
        own: (u32, u32),
        /// Size of the picture whose passes are added: width and height \[pixels].
        other: (u32, u32),
    },
    /// The two films together have more than 2³² − 1 passes.
    #[error("two films of {own} and {other} passes have too many: at most {} are allowed", u32::MAX)]
    TooManyPasses {
        /// Number of passes of the film to which passes are added.
        own: u32,
        /// Number of passes of the film whose passes are added.
        other: u32,
    },
    /// Some passes are in both renders.
    #[error("both renders have passes {common}: a sum would count them twice")]
    CommonPasses {
        /// The passes that both renders hold.
        common: PassSet,
    },
    /// One render has light groups and the other has none, or one clamps light and the other does
    /// not.
    #[error("a film with light groups or clamped light cannot be added to one without")]
    LayerMismatch,
    /// The error estimates come from different integrators or pictures.
    #[error("error estimates of different integrators or pictures cannot be merged")]
    EstimatorMismatch,
}
