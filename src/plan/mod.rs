//! The plan of a render: which effects the scene needs, and which the user forces on or off.
//!
//! The plan leaves out an effect only if it certainly adds nothing. The picture is then
//! bit-identical to one with all effects. If in doubt, an effect stays on. docs/theory/plan.md
//! describes the decisions.

mod decide;
mod effect_overrides;
mod scene_features;

pub use crate::scene::{Effect, Effects};
pub use decide::{Decision, Plan, Reason};
pub use effect_overrides::{EffectOverrides, UnknownOverride};
pub use scene_features::SceneFeatures;
