//! The command line: what was typed, what it means, and what is told in return.

mod aov;
mod args;
mod dark;
mod diff;
mod error;
mod interrupt;
mod memory;
mod mesh;
mod number;
mod plan;
mod price;
mod progress;
mod render;
mod report;
mod scene;
mod settings;
mod study;

pub use args::{Arguments, Command, PlanArguments, PriceArguments, RenderArguments, StudyArguments};
pub use diff::{DiffArguments, FlipName, MapKind};
pub use mesh::MeshArguments;

use std::process::ExitCode;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All was done.
    Success = 0,
    /// A scene, mesh, picture or other input is missing or wrong.
    Input = 1,
    /// The command line is wrong, or asks for more than memory holds.
    Usage = 2,
    /// An output cannot be written.
    Output = 3,
    /// Pictures differ by more than was allowed.
    Differ = 4,
    /// Interrupted: once, the picture so far was written; twice, nothing was.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command failed, with the exit code that says so.
#[derive(Debug)]
pub struct Failure {
    /// The report to show.
    pub report: miette::Report,
    /// The exit code.
    pub exit: Exit,
}

impl Failure {
    fn new(exit: Exit, report: impl Into<miette::Report>) -> Self {
        Self { report: report.into(), exit }
    }
}

/// Runs a command.
///
/// # Errors
/// [`Failure`] with what to tell the user.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    match arguments.command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Price(arguments) => price::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
        Command::Diff(arguments) => diff::run(&arguments),
        Command::Mesh(arguments) => mesh::run(&arguments),
    }
}
