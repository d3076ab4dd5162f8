//! Checks that a command's output files are distinct, and collection of their write errors.

use super::{CommandFailure, Exit};
use crate::image::canonical_output_path;
use miette::Report;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A file that a command reads or writes. Error messages name the file by its role.
#[derive(Clone, Debug)]
pub(super) struct FileWithRole {
    /// Flag such as `--stats`, or role such as "the scene file".
    role: &'static str,
    /// Path as given on the command line or in the scene.
    path: PathBuf,
    /// Path of the file after all links are resolved.
    resolved: PathBuf,
}

impl FileWithRole {
    pub fn new(role: &'static str, path: &Path) -> Self {
        Self { role, path: path.to_owned(), resolved: canonical_output_path(path) }
    }
}

/// Error: one file has two roles that exclude each other, such as two outputs.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{} `{}` and {} `{}` are the same file", output.role, output.path.display(), other.role, other.path.display())]
#[diagnostic(help("choose another path for {}", output.role))]
struct SameFileError {
    output: FileWithRole,
    other: FileWithRole,
}

/// Returns a failure if an output is the same file as another output or an input.
pub(super) fn check_distinct_files(outputs: &[FileWithRole], inputs: &[FileWithRole]) -> Result<(), CommandFailure> {
    let mut others: HashMap<&Path, &FileWithRole> = HashMap::new();
    for input in inputs {
        others.entry(&input.resolved).or_insert(input);
    }
    for output in outputs {
        if let Some(other) = others.insert(&output.resolved, output) {
            return Err(CommandFailure::usage_error(SameFileError { output: output.clone(), other: other.clone() }));
        }
    }
    Ok(())
}

/// Errors of outputs that could not be written. Other outputs are still written after a failure.
#[derive(Debug, Default)]
pub(super) struct OutputFailures(Vec<Report>);

impl OutputFailures {
    /// Returns the value of `result`. If `result` is an error, collects the error and returns
    /// `None`.
    pub fn ok_or_collect_error<T>(
        &mut self,
        result: Result<T, impl std::error::Error + Send + Sync + 'static>,
    ) -> Option<T> {
        result.map_err(|error| self.0.push(Report::from_err(error))).ok()
    }

    /// Returns the value of `result`. If `result` is a report, collects the report and returns
    /// `None`.
    pub fn ok_or_collect_report<T>(&mut self, result: miette::Result<T>) -> Option<T> {
        result.map_err(|report| self.0.push(report)).ok()
    }

    /// Returns `exit` if no output failed, else a failure with all collected errors and the exit
    /// code [`Exit::Output`].
    pub fn into_result(self, exit: Exit) -> Result<Exit, CommandFailure> {
        if self.0.is_empty() { Ok(exit) } else { Err(CommandFailure { reports: self.0, exit: Exit::Output }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same_file_message(outputs: &[FileWithRole], inputs: &[FileWithRole]) -> Option<String> {
        check_distinct_files(outputs, inputs).err().map(|failure| failure.reports[0].to_string())
    }

    #[test]
    fn two_outputs_of_one_path_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (plain, dotted) = (folder.path().join("a.exr"), folder.path().join("./a.exr"));
        let outputs = [FileWithRole::new("-o", &plain), FileWithRole::new("--aov", &dotted)];
        let refused = same_file_message(&outputs, &[]).unwrap();
        assert!(refused.starts_with("--aov `") && refused.contains(" and -o `"), "{refused}");
        assert_eq!(same_file_message(&outputs[..1], &[]), None);
    }

    #[cfg(unix)]
    #[test]
    fn links_to_an_input_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, link) = (folder.path().join("a.txt"), folder.path().join("b.png"));
        std::fs::write(&scene, "").unwrap();
        std::os::unix::fs::symlink(&scene, &link).unwrap();
        let input = FileWithRole::new("the scene file", &scene);
        let refused = same_file_message(&[FileWithRole::new("-o", &link)], &[input]).unwrap();
        assert!(refused.contains("the scene file `"), "{refused}");
    }
}
