//! Studies of a scene: cost and contribution of effects, and convergence of methods.

mod balanced;
mod effects;
pub mod methods;
pub mod report;
#[cfg(test)]
mod tests;
mod work;

pub use effects::{
    Clock, Cost, EffectContribution, EffectResult, EffectStudy, EffectStudyResult, PictureCost, StudyError,
};
pub use report::effects::{About, page};
pub use report::text;
pub use work::{ExpectedWork, Work, expected_work};
