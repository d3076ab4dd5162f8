//! `caustica study`: measurements of effects and of methods.

mod effects;
mod knobs;
mod methods;
mod output;
mod table;
mod variants;

use super::{CommandFailure, Exit, StudyArguments};

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, CommandFailure> {
    if arguments.kind.effects { effects::run(arguments) } else { methods::run(arguments) }
}
