//! Exit codes, and the reports of a command that failed.

use super::progress::clear_progress_bar;
use miette::{Diagnostic, MietteHandlerOpts, Report};
use std::io::Write;
use std::process::ExitCode;

/// Exit code of the program `caustica`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// The command did all its work.
    Success = 0,
    /// A scene, mesh, picture or other input is missing or wrong.
    Input = 1,
    /// The command line is wrong, or asks for more memory than there is.
    Usage = 2,
    /// At least one output cannot be written.
    Output = 3,
    /// Pictures differ by more than `caustica diff` allows.
    Differ = 4,
    /// The batch system of a farm is missing or refuses a job, or parts of the render failed there.
    Farm = 5,
    /// A signal such as Ctrl-C interrupted the command. The first signal still writes the outputs;
    /// a later one ends the program without them.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Failure of a command: error reports and the exit code.
#[derive(Debug)]
pub struct CommandFailure {
    /// Reports of the errors to print, at least one.
    pub reports: Vec<Report>,
    /// The exit code that the program returns.
    pub exit: Exit,
}

impl CommandFailure {
    pub(super) fn new(exit: Exit, report: impl Into<Report>) -> Self {
        Self { reports: vec![report.into()], exit }
    }

    /// Makes a failure for a command line that asks for something impossible.
    pub(super) fn usage_error(report: impl Into<Report>) -> Self {
        Self::new(Exit::Usage, report)
    }

    /// Makes a failure for an output that cannot be written.
    pub(super) fn output_error(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::new(Exit::Output, Report::from_err(error))
    }

    /// Removes the progress bar and prints the reports to the standard error.
    pub fn print_reports(&self) {
        clear_progress_bar();
        for report in &self.reports {
            // A closed stderr must not turn an error into a panic.
            let _ = writeln!(std::io::stderr(), "{report:?}");
        }
    }
}

/// Installs the style of error reports, which prints each message in a chain of causes once. Call
/// this function before the first report is made.
pub(super) fn install_report_style() {
    // A second call in one process fails and changes nothing.
    let _ = miette::set_hook(Box::new(|diagnostic| {
        let options = MietteHandlerOpts::new();
        let options = if message_includes_causes(diagnostic) { options.without_cause_chain() } else { options };
        Box::new(options.build())
    }));
}

/// True if the message of a diagnostic contains the messages of all its causes.
fn message_includes_causes(diagnostic: &dyn Diagnostic) -> bool {
    let message = diagnostic.to_string();
    let mut cause = diagnostic.source();
    while let Some(error) = cause {
        if !message.contains(&error.to_string()) {
            return false;
        }
        cause = error.source();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[derive(Debug, thiserror::Error, Diagnostic)]
    enum ErrorWithCause {
        #[error("cannot write: {source}")]
        Inline { source: io::Error },
        #[error("cannot read")]
        Apart { source: io::Error },
    }

    #[test]
    fn a_stated_cause_is_not_printed_again() {
        let source = || io::Error::other("disk full");
        assert!(message_includes_causes(&ErrorWithCause::Inline { source: source() }));
        assert!(!message_includes_causes(&ErrorWithCause::Apart { source: source() }));
    }
}
