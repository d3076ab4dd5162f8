//! The files that a study writes.

use crate::cli::outputs::{NamedFile, OutputFailures, check_distinct};
use crate::cli::progress::Progress;
use crate::cli::{Exit, Failure, StudyArguments};
use crate::image::{OutputFormat, check_replaceable, check_writable, replace_file};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Makes the text of a report from the results of a study.
pub(super) type Writer<F> = fn(&StudyArguments, &F) -> miette::Result<String>;

/// A report with an unknown extension.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` has no extension of a report", path.display())]
#[diagnostic(help("give it the extension {known}"))]
struct NoReport {
    path: PathBuf,
    known: String,
}

/// Report files with their writers, checked before any work.
pub(super) struct Outputs<'a, F>(Vec<(&'a Path, Writer<F>)>);

impl<'a, F> Outputs<'a, F> {
    /// Checks that all files of a study can be written. `known` lists the extensions and their
    /// writers.
    pub fn check(arguments: &'a StudyArguments, known: &[(&str, Writer<F>)]) -> Result<Self, Failure> {
        let writer = |path: &'a PathBuf| {
            let matches = |(extension, _): &&(&str, Writer<F>)| {
                path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
            };
            let (_, writer) = known.iter().find(matches).ok_or_else(|| {
                let known = known.iter().map(|(extension, _)| format!(".{extension}")).collect::<Vec<_>>().join(" or ");
                Failure::new(Exit::Output, NoReport { path: path.clone(), known })
            })?;
            check_replaceable(path).map_err(Failure::output)?;
            Ok((path.as_path(), *writer))
        };
        let outputs = arguments.output.iter().map(writer).collect::<Result<_, _>>().map(Self)?;
        check_distinct(&outputs_of(arguments), &[NamedFile::new("the scene file", &arguments.scene.scene)])?;
        Ok(outputs)
    }

    /// Writes all reports, and prints `text` to the standard output. Every output is tried.
    pub fn write(
        &self,
        arguments: &StudyArguments,
        found: &F,
        text: miette::Result<String>,
        progress: &Progress,
        exit: Exit,
    ) -> Result<Exit, Failure> {
        let mut failures = OutputFailures::default();
        for (path, writer) in &self.0 {
            let Some(report) = failures.keep_report(writer(arguments, found)) else { continue };
            if failures.keep(replace_file(path, report.as_bytes())).is_some() {
                progress.say(&format!("wrote {}", path.display()));
            }
        }
        if let Some(text) = failures.keep_report(text) {
            failures.keep(std::io::stdout().write_all(text.as_bytes()));
        }
        failures.finish(exit)
    }
}

/// All files that a study writes.
pub(super) fn outputs_of(arguments: &StudyArguments) -> Vec<NamedFile> {
    let reports = arguments.output.iter().map(|path| NamedFile::new("-o", path));
    let references = arguments.kind.save_truth.iter().flat_map(|(a, b)| [a, b]);
    reports.chain(references.map(|path| NamedFile::new("--save-truth", path))).collect()
}

/// A reference whose file format would clip radiance.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` cannot hold a reference: its format clips radiance", path.display())]
#[diagnostic(help("give it the extension .exr"))]
struct NotExr {
    path: PathBuf,
}

/// Checks that a reference can be written.
pub(super) fn check_reference(path: &Path) -> Result<(), Failure> {
    if !matches!(OutputFormat::from_path(path), Ok(OutputFormat::Exr)) {
        return Err(Failure::new(Exit::Output, NotExr { path: path.to_owned() }));
    }
    check_writable(path).map_err(Failure::output)
}
