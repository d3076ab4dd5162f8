//! Studies: what of a picture costs what, and is worth what.

mod effects;
mod html;
mod page;
mod picture;
#[cfg(test)]
mod tests;
pub mod text;
mod work;

pub use effects::{Clock, Cost, EffectStudy, Finding, Findings, Gain, Spent, StudyError};
pub use page::{About, page};
pub use work::{ExpectedWork, Work, expected_work};
