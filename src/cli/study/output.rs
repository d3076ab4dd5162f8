//! The files that a study writes.

use crate::cli::outputs::{NamedFile, OutputFailures, check_distinct};
use crate::cli::progress::Progress;
use crate::cli::{Exit, Failure, StudyArguments};
use crate::image::{OutputFormat, check_replaceable, check_writable, replace_file};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Makes the text of a report from the results of a study.
pub(super) type ReportWriter<F> = fn(&StudyArguments, &F) -> miette::Result<String>;

/// A report with an unknown extension.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` has no extension of a report", path.display())]
#[diagnostic(help("give it the extension {known}"))]
struct UnknownReportFormat {
    path: PathBuf,
    known: String,
}

/// Report files with their writers, checked before any work.
pub(super) struct Outputs<'a, F>(Vec<(&'a Path, ReportWriter<F>)>);

impl<'a, F> Outputs<'a, F> {
    /// Checks that all files of a study can be written. `known` lists the extensions and their
    /// writers.
    pub fn check(arguments: &'a StudyArguments, known: &[(&str, ReportWriter<F>)]) -> Result<Self, Failure> {
        let writer = |path: &'a PathBuf| {
            let matches = |(extension, _): &&(&str, ReportWriter<F>)| {
                path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
            };
            let (_, writer) = known.iter().find(matches).ok_or_else(|| {
                let known = known.iter().map(|(extension, _)| format!(".{extension}")).collect::<Vec<_>>().join(" or ");
                Failure::new(Exit::Output, UnknownReportFormat { path: path.clone(), known })
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
            let Some(report) = failures.take_ok_report(writer(arguments, found)) else { continue };
            if failures.take_ok(replace_file(path, report.as_bytes())).is_some() {
                progress.say(&format!("wrote {}", path.display()));
            }
        }
        if let Some(text) = failures.take_ok_report(text) {
            failures.take_ok(std::io::stdout().write_all(text.as_bytes()));
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
struct ReferenceNotExr {
    path: PathBuf,
}

/// Checks that a reference can be written.
pub(super) fn check_reference(path: &Path) -> Result<(), Failure> {
    if !matches!(OutputFormat::from_path(path), Ok(OutputFormat::Exr)) {
        return Err(Failure::new(Exit::Output, ReferenceNotExr { path: path.to_owned() }));
    }
    check_writable(path).map_err(Failure::output)
}
