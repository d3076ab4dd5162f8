//! Calls of Slurm's programs: sbatch, squeue, scontrol and scancel.

use std::collections::BTreeMap;
use std::io;
use std::process::Command;

/// Default of Slurm's setting `MaxArraySize`. The number of a task in a job array must be less than
/// this setting.
pub(super) const DEFAULT_MAX_ARRAY_SIZE: u32 = 1001;

/// Slurm's names of the states of jobs that have ended and will not start again.
const FINAL_STATES: [&str; 10] = [
    "BOOT_FAIL",
    "CANCELLED",
    "COMPLETED",
    "DEADLINE",
    "FAILED",
    "NODE_FAIL",
    "OUT_OF_MEMORY",
    "PREEMPTED",
    "REVOKED",
    "TIMEOUT",
];

/// Error of a call of one of Slurm's programs.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(super) enum SlurmError {
    /// The program is not installed.
    #[error("there is no program `{program}` here")]
    #[diagnostic(help("run this command where jobs of Slurm are submitted, or print the scripts by --dry-run"))]
    Missing {
        /// Name of the program.
        program: &'static str,
    },
    /// The program could not be started.
    #[error("cannot start `{program}`: {source}")]
    Start {
        /// Name of the program.
        program: &'static str,
        /// Error of the system.
        source: io::Error,
    },
    /// The program reported an error.
    #[error("`{program}` refuses: {message}")]
    #[diagnostic(help("--partition, --account, --time-limit and --sbatch set what the jobs ask for"))]
    Refused {
        /// Name of the program.
        program: &'static str,
        /// Message that the program printed.
        message: String,
    },
    /// Slurm allows no job arrays, because its setting `MaxArraySize` is 0 or 1. Holds this
    /// setting.
    #[error("this Slurm allows no job arrays: its MaxArraySize is {0}")]
    #[diagnostic(help("ask its administrator for a MaxArraySize of at least 2"))]
    NoArrays(u32),
}

/// State of a Slurm job, or of a task of a job array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SlurmTaskStatus {
    /// Number of the job, such as `12`, or of the task in its array, such as `12_3`.
    pub id: String,
    /// State in Slurm's words, such as `RUNNING`.
    pub state: String,
    /// Reason why the task waits or failed, such as `Resources`. Slurm writes `None` if there is no
    /// reason.
    pub reason: String,
}

impl SlurmTaskStatus {
    /// True if the task waits, runs or will start again: its state is none of Slurm's final states.
    pub fn is_active(&self) -> bool {
        !FINAL_STATES.contains(&self.state.as_str())
    }
}

/// Returns the largest number that a task in a job array may have.
pub(super) fn max_task_number() -> Result<u32, SlurmError> {
    let text = run("scontrol", &["show", "config"])?;
    let size = text.lines().find_map(|line| line.strip_prefix("MaxArraySize"));
    let size = size.and_then(|rest| rest.trim_start_matches([' ', '=']).trim().parse().ok());
    match size.unwrap_or(DEFAULT_MAX_ARRAY_SIZE) {
        small @ (0 | 1) => Err(SlurmError::NoArrays(small)),
        size => Ok(size - 1),
    }
}

/// Submits a job with the arguments of sbatch, and returns the job's number.
pub(super) fn submit(arguments: &[String]) -> Result<String, SlurmError> {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let printed = run("sbatch", &arguments)?;
    // If Slurm has several clusters, it prints a semicolon and the name of the cluster after the
    // number.
    let id = printed.trim().split(';').next().unwrap_or_default();
    if id.is_empty() || !id.bytes().all(|b| b.is_ascii_digit()) {
        let message = format!("it printed `{}` instead of the number of the job", printed.trim());
        return Err(SlurmError::Refused { program: "sbatch", message });
    }
    Ok(id.to_owned())
}

/// Returns all tasks of `jobs` that Slurm still knows. Slurm forgets ended jobs after some minutes.
pub(super) fn query_tasks(jobs: &[String]) -> Result<Vec<SlurmTaskStatus>, SlurmError> {
    let list = jobs.join(",");
    let arguments = ["--noheader", "--array", "--states=all", "--format=%i|%T|%r", "--jobs", &list];
    let text = match run("squeue", &arguments) {
        Err(SlurmError::Refused { message, .. }) if message.contains("Invalid job id") => String::new(),
        text => text?,
    };
    let task = |line: &str| {
        let mut fields = line.trim().split('|').map(str::to_owned);
        Some(SlurmTaskStatus { id: fields.next()?, state: fields.next()?, reason: fields.next().unwrap_or_default() })
    };
    Ok(text.lines().filter_map(task).collect())
}

/// Cancels jobs. Ignores errors of scancel, because the jobs may have ended already.
pub(super) fn cancel(jobs: &[String]) {
    let jobs: Vec<&str> = jobs.iter().map(String::as_str).collect();
    let _ = run("scancel", &jobs);
}

/// Returns a text with the number of tasks in each state, such as `2 completed, 3 pending
/// (Resources)`.
pub(super) fn tasks_text(tasks: &[SlurmTaskStatus]) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for task in tasks {
        let waits = task.state == "PENDING" && !["None", "Dependency", ""].contains(&task.reason.as_str());
        let reason = if waits { format!(" ({})", task.reason) } else { String::new() };
        *counts.entry(format!("{}{reason}", task.state.to_lowercase().replace('_', " "))).or_default() += 1;
    }
    let counts = counts.into_iter().map(|(state, n)| format!("{n} {state}"));
    counts.collect::<Vec<_>>().join(", ")
}

/// Runs a program of Slurm and returns its standard output.
fn run(program: &'static str, arguments: &[&str]) -> Result<String, SlurmError> {
    let output = Command::new(program).args(arguments).output().map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => SlurmError::Missing { program },
        _ => SlurmError::Start { program, source },
    })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let message = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    let message = if message.is_empty() { output.status.to_string() } else { message };
    Err(SlurmError::Refused { program, message })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn task_counts_name_why_tasks_wait() {
        let task = |state: &str, reason: &str| SlurmTaskStatus {
            id: "1_1".to_owned(),
            state: state.to_owned(),
            reason: reason.to_owned(),
        };
        let all = [
            task("PENDING", "Resources"),
            task("COMPLETED", "None"),
            task("PENDING", "Resources"),
            task("OUT_OF_MEMORY", "OutOfMemory"),
            task("PENDING", "Dependency"),
        ];
        assert_eq!(tasks_text(&all), "1 completed, 1 out of memory, 1 pending, 2 pending (Resources)");
        assert_eq!(all.each_ref().map(SlurmTaskStatus::is_active), [true, false, true, false, true]);
        assert!(task("COMPLETING", "None").is_active() && task("SUSPENDED", "None").is_active());
    }
}
