//! `caustica study`: measurements of effects and of methods.

mod args;
mod effects;
mod knobs;
mod methods;
mod output;
mod table;
mod variants;

pub use args::StudyArguments;

use super::{CommandFailure, Exit};

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, CommandFailure> {
    if arguments.kind.effects { effects::run(arguments) } else { methods::run(arguments) }
}
