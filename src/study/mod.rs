//! Studies of a scene: cost and contribution of effects, and convergence of methods.

mod effects;
pub mod methods;
pub mod report;
#[cfg(test)]
mod tests;
mod work;

pub use effects::{
    Clock, EffectContribution, EffectCost, EffectResult, EffectStudy, EffectStudyResult, PictureCost, StudyError,
};
pub use report::effects::{ReportContext, effects_html_page};
pub use report::text;
pub use work::{ExpectedWork, WorkCounts, expected_work};
