//! `caustica study`: measurements of effects and of methods.

mod effects;
mod knobs;
mod methods;
mod output;
mod table;
mod variants;

use super::{Exit, Failure, StudyArguments};

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, Failure> {
    if arguments.kind.effects { effects::run(arguments) } else { methods::run(arguments) }
}
