//! A render as job arrays of Slurm, from the first submission to the finished picture.
//!
//! The films in the work folder show which passes are made. Slurm is asked only whether jobs are
//! still active. So a user can give an interrupted command again, and it continues the render.

use super::args::SlurmArguments;
use super::division::{ArrayTasks, ShardDivision, job_arrays, number_list};
use super::script::JobScripts;
use super::slurm::{self, SlurmError, SlurmTaskStatus};
use super::waves::{WaveDecision, decide_next_wave};
use super::work_folder::{FarmState, MERGE_SCRIPT_NAME, MERGED_FILM_NAME, SHARD_SCRIPT_NAME, WorkFolder};
use crate::cli::film::{check_film_memory, read_film};
use crate::cli::interrupt::INTERRUPTED;
use crate::cli::progress::{ProgressDisplay, print_message};
use crate::cli::value_parsers::count_with_noun;
use crate::cli::{CommandFailure, Exit, forecast_text};
use crate::render::error_estimate::MIN_ERROR_ESTIMATE_PASSES;
use crate::render::{ErrorTarget, FilmHeader, RenderResult};
use crate::study::text::percent_text;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Default of `--max-passes` (number of passes of all waves of jobs), as a multiple of `--passes`
/// (number of passes of the first wave).
const DEFAULT_MAX_PASSES_FACTOR: u32 = 100;

/// Time after which the command gives up if Slurm answers no query.
const MAX_SLURM_SILENCE: Duration = Duration::from_secs(600);

/// Longest wait for a network file system to show a file that a finished job wrote.
const FILE_DELAY: Duration = Duration::from_secs(60);

/// Longest sleep between two checks for an interrupting signal.
const SIGNAL_POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Error: the work folder holds another render.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the folder `{}` holds another render:\n{}", path.display(), differences.join("\n"))]
#[diagnostic(help("render with the same settings, or choose another --work-dir"))]
struct FolderOfOtherRenderError {
    path: PathBuf,
    differences: Vec<String>,
}

/// Error: several rounds of jobs in a row added no pass to the films.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{what} after {rounds} without a new pass; the last messages of one job are:\n{log}")]
#[diagnostic(help("remove the cause and give the same command again: finished passes are kept in `{}`", folder.display()))]
struct FailedJobsError {
    what: String,
    rounds: String,
    log: String,
    folder: PathBuf,
}

/// Error: somebody cancelled jobs of the render.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{jobs} cancelled; incomplete shards: {shards}")]
#[diagnostic(help("give the same command again to continue: finished passes are kept in `{}`", folder.display()))]
struct CancelledJobsError {
    jobs: String,
    shards: String,
    folder: PathBuf,
}

/// Outcome of a round. A round submits jobs for all incomplete shards, and one job that merges the
/// films of all shards. The round ends when all these jobs have ended.
enum RoundEnd {
    /// All shards have all their passes, and their films are merged.
    Complete,
    /// All jobs ended, but some shards lack passes or the films are not merged. Holds the last
    /// known states of the tasks.
    Incomplete(Vec<SlurmTaskStatus>),
    /// A signal interrupted the command.
    Interrupted,
}

/// A render that runs as jobs of Slurm.
pub(super) struct SlurmRender<'a> {
    arguments: &'a SlurmArguments,
    folder: &'a WorkFolder,
    header: FilmHeader,
    progress: &'a ProgressDisplay,
}

/// Returns the arguments of sbatch for a job array of shards.
pub(super) fn shard_arguments(folder: &WorkFolder, array: &ArrayTasks) -> Vec<String> {
    let script = folder.file_path(SHARD_SCRIPT_NAME).display().to_string();
    vec![
        "--parsable".to_owned(),
        format!("--chdir={}", folder.path().display()),
        format!("--array={}", array.tasks),
        script,
        array.shard_offset.to_string(),
    ]
}

/// Returns the arguments of sbatch for the job that merges the films. The job begins when all
/// `jobs` have ended.
pub(super) fn merge_arguments(folder: &WorkFolder, jobs: &[String]) -> Vec<String> {
    let mut words = vec!["--parsable".to_owned(), format!("--chdir={}", folder.path().display())];
    if !jobs.is_empty() {
        words.push(format!("--dependency=afterany:{}", jobs.join(":")));
    }
    words.push(folder.file_path(MERGE_SCRIPT_NAME).display().to_string());
    words
}

impl<'a> SlurmRender<'a> {
    pub fn new(
        arguments: &'a SlurmArguments,
        folder: &'a WorkFolder,
        header: FilmHeader,
        progress: &'a ProgressDisplay,
    ) -> Self {
        Self { arguments, folder, header, progress }
    }

    /// Renders the passes of `division` and writes the picture. With `--target-error`, adds waves
    /// of jobs until the error is reached.
    pub fn run(&self, division: ShardDivision) -> Result<Exit, CommandFailure> {
        let most_tasks = slurm::max_task_number().map_err(slurm_failure)?;
        let (_lock, earlier) = self.folder.lock_and_read_state().map_err(CommandFailure::usage_error)?;
        let mut state = self.initial_state(division, earlier)?;
        loop {
            if let Some(exit) = self.complete_shards(&mut state, most_tasks)? {
                return Ok(exit);
            }
            let merged = self.folder.file_path(MERGED_FILM_NAME);
            check_film_memory(std::slice::from_ref(&merged), 1, self.arguments.scene.memory)?;
            let film = read_film(&merged)?;
            let Some(target) = self.error_target() else { return Ok(self.print_picture_summary(&film.rendered)) };
            let most =
                self.arguments.max_passes.unwrap_or(self.arguments.passes.saturating_mul(DEFAULT_MAX_PASSES_FACTOR));
            match decide_next_wave(&film.rendered, state.division, target, most) {
                WaveDecision::Grow(larger) => {
                    let error = film.rendered.estimate_error(Some(target));
                    let error = error.map_or("unknown".to_owned(), |(error, _)| forecast_text::error_text(&error));
                    let more = count_with_noun((larger.shards - state.division.shards) as usize, "shard", "shards");
                    self.progress.print_line(&format!("estimated error {error}; the next wave has {more}"));
                    state.division = larger;
                }
                end @ (WaveDecision::TargetReached
                | WaveDecision::TargetUnreachable(_)
                | WaveDecision::TooManyPasses) => {
                    let exit = self.print_picture_summary(&film.rendered);
                    self.print_wave_end(end, target, most);
                    return Ok(exit);
                }
            }
        }
    }

    /// Returns the state from which to continue: `earlier`, the state that the work folder stores,
    /// or else a new state with `division`.
    fn initial_state(&self, division: ShardDivision, earlier: Option<FarmState>) -> Result<FarmState, CommandFailure> {
        let new = FarmState { header: self.header.clone(), division, last_round_jobs: Vec::new() };
        let Some(mut state) = earlier else { return Ok(new) };
        let mut differences = new.header.differences(&state.header);
        let size = |d: ShardDivision| format!("{} passes in {} shards", d.passes, d.shards);
        if !division.has_same_shard_passes(state.division) {
            differences.push(format!("{} here, {} there", size(division), size(state.division)));
        }
        if !differences.is_empty() {
            let error = FolderOfOtherRenderError { path: self.folder.path().to_owned(), differences };
            return Err(CommandFailure::usage_error(error));
        }
        if state.division.shards > division.shards {
            self.progress.print_line(&format!("the folder already has {}", size(state.division)));
        } else {
            state.division = division;
        }
        Ok(state)
    }

    /// Submits rounds of jobs until all shards of `state` have all their passes and are merged.
    /// First waits for jobs of an earlier command that are still active.
    ///
    /// Returns `None` on success, or the exit code if a signal interrupts the command. Returns a
    /// failure if jobs are cancelled, or if too many rounds add no pass.
    fn complete_shards(&self, state: &mut FarmState, most_tasks: u32) -> Result<Option<Exit>, CommandFailure> {
        let mut failures = 0;
        if tasks_of_earlier_jobs(&state.last_round_jobs)?.iter().any(SlurmTaskStatus::is_active) {
            let jobs = jobs_text(&state.last_round_jobs);
            self.progress.print_line(&format!("following {jobs} of an earlier command"));
            match self.finish_round(state)? {
                // The merge job of the earlier command may have written other outputs than this
                // command asks for. If so, merge again below.
                RoundEnd::Complete if self.has_current_merge_script(state.division)? => return Ok(None),
                RoundEnd::Complete => {}
                RoundEnd::Incomplete(tasks) => self.check_cancelled_jobs(&tasks, state.division)?,
                RoundEnd::Interrupted => return Ok(Some(Exit::Interrupted)),
            }
        }
        loop {
            let before = self.completed_pass_count(state.division);
            self.submit_round(state, most_tasks)?;
            let ended_tasks = match self.finish_round(state)? {
                RoundEnd::Complete => return Ok(None),
                RoundEnd::Incomplete(tasks) => tasks,
                RoundEnd::Interrupted => return Ok(Some(Exit::Interrupted)),
            };
            self.check_cancelled_jobs(&ended_tasks, state.division)?;
            let missing = self.incomplete_shards(state.division);
            failures = if self.completed_pass_count(state.division) > before { 0 } else { failures + 1 };
            if failures > self.arguments.retries {
                return Err(self.no_progress_failure(&missing, failures, state, &ended_tasks));
            }
            if !missing.is_empty() {
                let list = number_list(&missing);
                self.progress.print_line(&format!("incomplete shards: {list}; they are submitted again"));
            }
        }
    }

    /// True if the merge script in the folder is the one that this command would write. An earlier
    /// command with other outputs left a different script.
    fn has_current_merge_script(&self, division: ShardDivision) -> Result<bool, CommandFailure> {
        let scripts = self.scripts(division)?;
        Ok(self.folder.has_file(MERGE_SCRIPT_NAME, scripts.merge_script.as_bytes()))
    }

    /// Returns the scripts of the jobs of `division`.
    fn scripts(&self, division: ShardDivision) -> Result<JobScripts, CommandFailure> {
        JobScripts::new(self.arguments, self.folder, &self.header, division).map_err(CommandFailure::usage_error)
    }

    /// Returns a failure if somebody cancelled one of `tasks`.
    fn check_cancelled_jobs(&self, tasks: &[SlurmTaskStatus], division: ShardDivision) -> Result<(), CommandFailure> {
        let cancelled = tasks.iter().filter(|task| task.state == "CANCELLED").count();
        if cancelled == 0 {
            return Ok(());
        }
        let error = CancelledJobsError {
            jobs: count_with_noun(cancelled, "job was", "jobs were"),
            shards: number_list(&self.incomplete_shards(division)),
            folder: self.folder.path().to_owned(),
        };
        Err(CommandFailure::new(Exit::Farm, error))
    }

    /// Submits jobs for all incomplete shards, and a job that merges all films afterwards. If
    /// sbatch refuses one of the jobs, cancels those already submitted.
    fn submit_round(&self, state: &mut FarmState, most_tasks: u32) -> Result<(), CommandFailure> {
        let scripts = self.scripts(state.division)?;
        let folder = self.folder;
        state.last_round_jobs.clear();
        let written = folder
            .save(state)
            .and_then(|()| folder.write(SHARD_SCRIPT_NAME, scripts.shard_script.as_bytes()))
            .and_then(|()| folder.write(MERGE_SCRIPT_NAME, scripts.merge_script.as_bytes()))
            .and_then(|()| folder.remove_merge_mark());
        written.map_err(CommandFailure::output_error)?;
        let shards = self.incomplete_shards(state.division);
        let mut submit = |arguments: Vec<String>| match slurm::submit(&arguments) {
            Ok(job) => {
                state.last_round_jobs.push(job.clone());
                folder.save(state).map_err(CommandFailure::output_error)?;
                Ok(job)
            }
            Err(error) => {
                slurm::cancel(&state.last_round_jobs);
                Err(slurm_failure(error))
            }
        };
        let mut arrays = Vec::new();
        for array in job_arrays(&shards, most_tasks) {
            arrays.push(submit(shard_arguments(folder, &array))?);
        }
        let merge = submit(merge_arguments(folder, &arrays))?;
        let count = count_with_noun(shards.len(), "shard", "shards");
        match arrays.as_slice() {
            [] => self.progress.print_line(&format!("submitted the merge as job {merge}")),
            _ => {
                let arrays = jobs_text(&arrays);
                self.progress.print_line(&format!("submitted {count} as {arrays}, and the merge as job {merge}"));
            }
        }
        Ok(())
    }

    /// Waits until the jobs of the last round in `state` have ended, and returns the outcome of the
    /// round.
    fn finish_round(&self, state: &FarmState) -> Result<RoundEnd, CommandFailure> {
        let Some(tasks) = self.follow_jobs(&state.last_round_jobs)? else { return Ok(RoundEnd::Interrupted) };
        self.wait_for_files(state.division, &tasks);
        Ok(if self.is_complete(state.division) { RoundEnd::Complete } else { RoundEnd::Incomplete(tasks) })
    }

    /// Waits until no job is active. Prints a line whenever the states of tasks change.
    ///
    /// Returns the tasks with their last known states; `None` if a signal interrupted the command.
    fn follow_jobs(&self, jobs: &[String]) -> Result<Option<Vec<SlurmTaskStatus>>, CommandFailure> {
        let start = Instant::now();
        let mut shown = String::new();
        let mut last: Vec<SlurmTaskStatus> = Vec::new();
        let mut silent_since: Option<Instant> = None;
        loop {
            match slurm::query_tasks(jobs) {
                Ok(tasks) => {
                    silent_since = None;
                    let text = slurm::tasks_text(&tasks);
                    if text != shown && !text.is_empty() {
                        let time = forecast_text::duration_text(start.elapsed().as_secs_f64());
                        self.progress.print_line(&format!("{time}: {text}"));
                        shown = text;
                    }
                    if !tasks.iter().any(SlurmTaskStatus::is_active) {
                        // Slurm forgets ended jobs. In this case, return the last known states of
                        // their tasks, which show why they ended.
                        return Ok(Some(if tasks.is_empty() { last } else { tasks }));
                    }
                    last = tasks;
                }
                Err(error) => {
                    let since = *silent_since.get_or_insert_with(|| {
                        print_message(&format!("warning: {error}; asking again"));
                        Instant::now()
                    });
                    if since.elapsed() > MAX_SLURM_SILENCE {
                        return Err(slurm_failure(error));
                    }
                }
            }
            if sleep_was_interrupted(self.arguments.poll) {
                return Ok(None);
            }
        }
    }

    /// Waits at most [`FILE_DELAY`] for files that completed jobs must have written, but that a
    /// network file system does not show yet.
    fn wait_for_files(&self, division: ShardDivision, tasks: &[SlurmTaskStatus]) {
        let start = Instant::now();
        let all_completed = !tasks.is_empty() && tasks.iter().all(|task| task.state == "COMPLETED");
        while all_completed && !self.is_complete(division) && start.elapsed() < FILE_DELAY {
            if sleep_was_interrupted(Duration::from_secs(1)) {
                return;
            }
        }
    }

    /// True if all shards have all their passes, and their films are merged.
    fn is_complete(&self, division: ShardDivision) -> bool {
        self.folder.is_merged() && self.incomplete_shards(division).is_empty()
    }

    /// Returns the numbers of the shards whose films lack passes.
    fn incomplete_shards(&self, division: ShardDivision) -> Vec<u32> {
        let is_incomplete = |shard: &u32| {
            let passes = division.shard_passes(*shard);
            self.folder.completed_shard_passes(*shard).first_missing(passes).is_some()
        };
        (1..=division.shards).filter(is_incomplete).collect()
    }

    /// Returns the total number of passes in the films of all shards.
    fn completed_pass_count(&self, division: ShardDivision) -> u64 {
        (1..=division.shards).map(|shard| self.folder.completed_shard_passes(shard).len()).sum()
    }

    /// Returns the failure of a render that gives up after `rounds` rounds of jobs without a new
    /// pass.
    fn no_progress_failure(
        &self,
        missing: &[u32],
        rounds: u32,
        state: &FarmState,
        tasks: &[SlurmTaskStatus],
    ) -> CommandFailure {
        let failed = tasks.iter().find(|task| task.state != "COMPLETED").map(|task| task.id.clone());
        let log = failed.or_else(|| state.last_round_jobs.last().cloned()).unwrap_or_default();
        let what = if missing.is_empty() {
            "the merge failed".to_owned()
        } else {
            format!("there are incomplete shards ({})", number_list(missing))
        };
        CommandFailure::new(
            Exit::Farm,
            FailedJobsError {
                what,
                rounds: count_with_noun(rounds as usize, "round", "rounds"),
                log: self.folder.log_end(&format!("{log}.log")),
                folder: self.folder.path().to_owned(),
            },
        )
    }

    /// Returns the error target; `None` without `--target-error`.
    fn error_target(&self) -> Option<ErrorTarget> {
        let error = self.arguments.target_error?;
        Some(ErrorTarget { error, confidence: self.arguments.confidence })
    }

    /// Prints the outputs, passes and estimated error of the finished picture.
    fn print_picture_summary(&self, rendered: &RenderResult) -> Exit {
        for path in &self.arguments.output {
            self.progress.print_line(&format!("wrote {}", path.display()));
        }
        let passes = rendered.film.passes();
        self.progress.print_line(&count_with_noun(passes as usize, "pass", "passes"));
        let estimate = rendered.estimate_error(self.error_target()).filter(|_| passes >= MIN_ERROR_ESTIMATE_PASSES);
        if let Some((estimate, _)) = estimate {
            self.progress.print_line(&format!("estimated error {}", forecast_text::error_text(&estimate)));
        }
        Exit::Success
    }

    /// Prints why no further wave of jobs follows.
    fn print_wave_end(&self, end: WaveDecision, target: ErrorTarget, most: u32) {
        let error = percent_text(target.error);
        match end {
            WaveDecision::TargetReached => self.progress.print_line(&format!(
                "the error is at most {error} with {} confidence",
                percent_text(target.confidence.probability())
            )),
            WaveDecision::TargetUnreachable(part) => {
                print_message(&format!("warning: the rest is bias; {}", forecast_text::bias_remedy(part)));
            }
            WaveDecision::TooManyPasses => print_message(&format!(
                "warning: the error is above {error}, and a further wave would exceed {most} passes; --max-passes allows more"
            )),
            WaveDecision::Grow(_) => {}
        }
    }
}

/// Sleeps for `time`, or until a signal interrupts the command. Returns true if there was a signal.
fn sleep_was_interrupted(time: Duration) -> bool {
    let start = Instant::now();
    loop {
        if INTERRUPTED.load(Ordering::Relaxed) {
            return true;
        }
        let left = time.saturating_sub(start.elapsed());
        if left.is_zero() {
            return false;
        }
        sleep(left.min(SIGNAL_POLL_INTERVAL));
    }
}

/// Returns the tasks of `jobs`, which an earlier command submitted; an empty list if `jobs` is
/// empty.
fn tasks_of_earlier_jobs(jobs: &[String]) -> Result<Vec<SlurmTaskStatus>, CommandFailure> {
    if jobs.is_empty() { Ok(Vec::new()) } else { slurm::query_tasks(jobs).map_err(slurm_failure) }
}

fn slurm_failure(error: SlurmError) -> CommandFailure {
    CommandFailure::new(Exit::Farm, error)
}

/// Returns the numbers of jobs as text, such as `job 12` or `jobs 12, 13`.
fn jobs_text(jobs: &[String]) -> String {
    format!("{} {}", if jobs.len() == 1 { "job" } else { "jobs" }, jobs.join(", "))
}
