//! What a scene calls for: facts, decisions that follow from them, and what a user wishes otherwise.
//!
//! An effect is left out only where it is certain that it would add nothing, so that a picture is the same to the bit as with
//! everything simulated: when in doubt, on. Where decisions lie is told in docs/theory/plan.md.

mod decide;
mod effect_overrides;
mod scene_features;

pub use crate::scene::{Effect, Effects};
pub use decide::{Decision, Plan, Reason};
pub use effect_overrides::{EffectOverrides, UnknownOverride};
pub use scene_features::SceneFeatures;
