//! The files that a study writes.

use crate::cli::progress::Progress;
use crate::cli::{Exit, Failure, StudyArguments};
use crate::image::{OutputFormat, check_place, check_writable, replace_file};
use miette::IntoDiagnostic;
use std::path::{Path, PathBuf};

/// Makes a report of what was found.
pub(super) type Writer<F> = fn(&StudyArguments, &F) -> miette::Result<String>;

/// A report whose name says something else.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` does not name a report", path.display())]
#[diagnostic(help("give it the extension {known}"))]
struct NoReport {
    path: PathBuf,
    known: String,
}

/// Files with what makes them, checked before any work.
pub(super) struct Outputs<'a, F>(Vec<(&'a Path, Writer<F>)>);

impl<'a, F> Outputs<'a, F> {
    /// Looks whether all can be written. `known` holds the extensions, and what makes such a file.
    pub fn check(paths: &'a [PathBuf], known: &[(&str, Writer<F>)]) -> Result<Self, Failure> {
        let writer = |path: &'a PathBuf| {
            let named = |(extension, _): &&(&str, Writer<F>)| {
                path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
            };
            let found = known.iter().find(named).ok_or_else(|| {
                let known = known.iter().map(|(extension, _)| format!(".{extension}")).collect::<Vec<_>>().join(" or ");
                Failure::new(Exit::Output, NoReport { path: path.clone(), known })
            });
            let (_, writer) = found?;
            check_place(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
            Ok((path.as_path(), *writer))
        };
        paths.iter().map(writer).collect::<Result<_, _>>().map(Self)
    }

    /// Writes them all.
    pub fn write(&self, arguments: &StudyArguments, found: &F, progress: &Progress) -> miette::Result<()> {
        for (path, writer) in &self.0 {
            replace_file(path, writer(arguments, found)?.as_bytes()).into_diagnostic()?;
            progress.say(&format!("wrote {}", path.display()));
        }
        Ok(())
    }
}

/// A picture that is to hold light, but is named as one that cannot.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` cannot hold a reference, whose light must not be clipped", path.display())]
#[diagnostic(help("give it the extension .exr"))]
struct NotExr {
    path: PathBuf,
}

/// Looks whether a reference can be written.
pub(super) fn check_reference(path: &Path) -> Result<(), Failure> {
    if !matches!(OutputFormat::from_path(path), Ok(OutputFormat::Exr)) {
        return Err(Failure::new(Exit::Output, NotExr { path: path.to_owned() }));
    }
    check_writable(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))
}
