//! The command line: arguments, commands, messages and exit codes.

mod args;
mod check;
mod completions_and_manual;
mod convert;
mod diagnostics;
mod diff;
mod estimate;
mod failure;
mod farm;
mod file_lock;
mod film;
mod forecast_text;
mod frames;
mod input_files;
mod interrupt;
#[cfg(feature = "view")]
mod live;
mod merge;
mod mesh;
mod outputs;
mod picture_updates;
mod pictures;
mod pivot;
mod plan;
mod progress;
mod render;
mod report;
mod scene;
mod scene_args;
mod settings;
mod shard;
mod study;
#[cfg(feature = "view")]
mod tev;
mod value_parsers;
#[cfg(feature = "view")]
mod view;

pub use args::{Arguments, Command, EstimateArguments, MethodArguments, PlanArguments, RenderArguments};
pub use convert::ConvertArguments;
pub use diff::{DiffArguments, ErrorMapKind, FlipMetricModeArgument};
pub use failure::{CommandFailure, Exit};
pub use farm::{FarmArguments, FarmEngine, RefusedArguments, SlurmArguments};
pub use film::FilmArguments;
pub use frames::FrameRange;
pub use merge::MergeArguments;
pub use mesh::MeshArguments;
pub use pictures::PictureArguments;
pub use shard::Shard;
pub use study::StudyArguments;
#[cfg(feature = "view")]
pub use view::ViewArguments;

/// Runs a command.
///
/// # Errors
/// [`CommandFailure`] with the reports to show and the exit code.
pub fn run(arguments: Arguments) -> Result<Exit, CommandFailure> {
    failure::install_report_style();
    match arguments.command {
        Command::Render(arguments) => render::run(&arguments),
        #[cfg(feature = "view")]
        Command::View(arguments) => view::run(&arguments),
        Command::Plan(arguments) if arguments.check => check::run(&arguments.scene),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Estimate(arguments) => estimate::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
        Command::Diff(arguments) => diff::run(&arguments),
        Command::Mesh(arguments) => mesh::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Film(arguments) => film::run(&arguments),
        Command::Farm(arguments) => farm::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Completions { shell } => completions_and_manual::print_completions(shell),
        Command::Man => completions_and_manual::print_manual(),
    }
}
