//! Studies of a scene: cost and contribution of its effects, and convergence of algorithms.

mod effects;
pub mod methods;
pub mod report;
#[cfg(test)]
mod tests;
mod work;

pub use effects::{
    AddedCost, ClockKind, EffectContribution, EffectResult, EffectStudy, EffectStudyResult, PictureCost, StudyError,
};
pub use report::effects::{EffectReportHeader, effects_html_page};
pub use report::text;
pub use work::{ExpectedWork, WorkCounts, expected_work};
