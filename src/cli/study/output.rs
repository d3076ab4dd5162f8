//! Output files of a study: reports and reference pictures.

use crate::cli::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use crate::cli::progress::ProgressDisplay;
use crate::cli::{CommandFailure, Exit, StudyArguments};
use crate::image::{OutputFormat, check_replaceable, check_writable, replace_file};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Function that makes the text of a report from the result `F` of a study.
pub(super) type ReportFormatter<F> = fn(&StudyArguments, &F) -> miette::Result<String>;

/// Error: the extension of an output path names no report format.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` has no extension of a report", path.display())]
#[diagnostic(help("give it the extension {known}"))]
struct UnknownReportFormatError {
    path: PathBuf,
    known: String,
}

/// Report files to write, each with the function that makes its text.
pub(super) struct StudyOutputs<'a, F>(Vec<(&'a Path, ReportFormatter<F>)>);

impl<'a, F> StudyOutputs<'a, F> {
    /// Returns the report files that the command line names. Returns a failure if one of them
    /// cannot be written.
    ///
    /// `known` lists the file extensions of reports, each with the function that makes the text.
    pub fn from_arguments(
        arguments: &'a StudyArguments,
        known: &[(&str, ReportFormatter<F>)],
    ) -> Result<Self, CommandFailure> {
        let writer = |path: &'a PathBuf| {
            let matches = |(extension, _): &&(&str, ReportFormatter<F>)| {
                path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
            };
            let (_, writer) = known.iter().find(matches).ok_or_else(|| {
                let known = known.iter().map(|(extension, _)| format!(".{extension}")).collect::<Vec<_>>().join(" or ");
                CommandFailure::new(Exit::Output, UnknownReportFormatError { path: path.clone(), known })
            })?;
            check_replaceable(path).map_err(CommandFailure::output_error)?;
            Ok((path.as_path(), *writer))
        };
        let outputs = arguments.output.iter().map(writer).collect::<Result<_, _>>().map(Self)?;
        check_distinct_files(
            &study_output_files(arguments),
            &[FileWithRole::new("the scene file", &arguments.scene.scene)],
        )?;
        Ok(outputs)
    }

    /// Writes all reports, and prints `text` to the standard output.
    ///
    /// If one report fails, the others are still written.
    pub fn write_reports(
        &self,
        arguments: &StudyArguments,
        result: &F,
        text: miette::Result<String>,
        progress: &ProgressDisplay,
        exit: Exit,
    ) -> Result<Exit, CommandFailure> {
        let mut failures = OutputFailures::default();
        for (path, writer) in &self.0 {
            let Some(report) = failures.ok_or_collect_report(writer(arguments, result)) else { continue };
            if failures.ok_or_collect_error(replace_file(path, report.as_bytes())).is_some() {
                progress.print_line(&format!("wrote {}", path.display()));
            }
        }
        if let Some(text) = failures.ok_or_collect_report(text) {
            failures.ok_or_collect_error(std::io::stdout().write_all(text.as_bytes()));
        }
        failures.into_result(exit)
    }
}

/// Returns all files that a study writes, with their roles.
pub(super) fn study_output_files(arguments: &StudyArguments) -> Vec<FileWithRole> {
    let reports = arguments.output.iter().map(|path| FileWithRole::new("-o", path));
    let references = arguments.kind.save_truth.iter().flat_map(|(a, b)| [a, b]);
    reports.chain(references.map(|path| FileWithRole::new("--save-truth", path))).collect()
}

/// Error: the file for a reference picture is not OpenEXR. Other formats clip radiance.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` cannot hold a reference: its format clips radiance", path.display())]
#[diagnostic(help("give it the extension .exr"))]
struct ReferenceNotExrError {
    path: PathBuf,
}

/// Checks that a reference picture can be written to `path`, which must be an OpenEXR file.
pub(super) fn check_reference_path(path: &Path) -> Result<(), CommandFailure> {
    if !matches!(OutputFormat::from_path(path), Ok(OutputFormat::Exr)) {
        return Err(CommandFailure::new(Exit::Output, ReferenceNotExrError { path: path.to_owned() }));
    }
    check_writable(path).map_err(CommandFailure::output_error)
}
