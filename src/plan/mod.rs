//! The plan of a render: which light-transport effects are simulated, and why.
//!
//! The plan omits an effect only if the picture is certainly bit-identical without it. The user may
//! force effects on or off. docs/theory/plan.md explains the decisions.

mod decide;
mod effect_overrides;
mod scene_features;

pub use decide::{EffectDecision, EffectReason, Plan};
pub use effect_overrides::{EffectOverrides, UnknownOverrideError};
pub use scene_features::SceneFeatures;
