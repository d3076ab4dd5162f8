//! Shell scripts that Slurm runs as jobs.

use super::args::SlurmArguments;
use super::division::ShardDivision;
use super::work_folder::{MERGE_MARK_NAME, MERGED_FILM_NAME, WorkFolder};
use crate::cli::film::merge_memory;
use crate::cli::pictures::picture_flags;
use crate::render::FilmHeader;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

/// Number of bytes in a mebibyte, the unit of Slurm's `--mem`.
const MEBIBYTE: u64 = 1 << 20;

/// Error: a path or option has a line break or is not UTF-8, so that a shell script cannot contain
/// it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` cannot stand in a script of Slurm: it has a line break or is not UTF-8")]
#[diagnostic(help("choose another name"))]
pub(super) struct UnquotableWordError {
    text: String,
}

/// Error: a job script cannot be made.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(super) enum ScriptError {
    /// A path or option has a line break or is not UTF-8, so that a script cannot contain it.
    #[error(transparent)]
    #[diagnostic(transparent)]
    UnquotableWord(#[from] UnquotableWordError),
    /// The system cannot make a path absolute.
    #[error("cannot find the absolute path of a file: {0}")]
    Path(#[from] io::Error),
}

/// Job scripts of a farm render: one renders a shard, the other merges the films of all shards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct JobScripts {
    /// Script that renders one shard. It takes one argument,
    /// [`ArrayTasks::shard_offset`](super::division::ArrayTasks::shard_offset): the number of the
    /// shard minus the number of the task.
    pub shard_script: String,
    /// Script that merges all films.
    pub merge_script: String,
}

impl JobScripts {
    /// Returns the scripts for a render with `arguments`. `division` says which passes each shard
    /// renders, and `header` is the header of the films of all shards.
    pub fn new(
        arguments: &SlurmArguments,
        folder: &WorkFolder,
        header: &FilmHeader,
        division: ShardDivision,
    ) -> Result<Self, ScriptError> {
        let program = match &arguments.program {
            Some(program) => absolute_text(program)?,
            None => absolute_text(&std::env::current_exe()?)?,
        };
        let folder = absolute_text(folder.path())?;
        let cd_command = format!("cd {} || exit\n", quoted(&folder)?);
        Ok(Self {
            shard_script: shard_script(arguments, &program, &cd_command, division)?,
            merge_script: merge_script(arguments, header, &program, &cd_command)?,
        })
    }
}

/// Returns the script that renders a shard. `cd_command` is the command that enters the work
/// folder.
fn shard_script(
    arguments: &SlurmArguments,
    program: &str,
    cd_command: &str,
    ShardDivision { shards, passes }: ShardDivision,
) -> Result<String, ScriptError> {
    let scene = &arguments.scene;
    let mut words = vec![program.to_owned(), "render".to_owned(), absolute_text(&scene.scene)?];
    let mut add = |flag: &str, value: String| words.extend([flag.to_owned(), value]);
    add("--passes", passes.to_string());
    add("--threads", shard_threads(arguments).to_string());
    add("--seed", arguments.method.seed.to_string());
    add("--save-every", format!("{}s", arguments.save_every.as_secs_f64()));
    if let Some((width, height)) = scene.size {
        add("--size", format!("{width}x{height}"));
    }
    if let Some(memory) = scene.memory {
        add("--memory", memory.to_string());
    }
    if let Some(format) = &scene.import.format {
        add("--format", format.clone());
    }
    words.extend(arguments.film_header_settings().non_default_flags());
    let switches = [("--strict", scene.import.strict), ("--allow-outside", scene.import.allow_outside)];
    words.extend(switches.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag.to_owned()));
    let command = shell_command_line(&words)?;
    let head = script_head(arguments, "shards", shard_threads(arguments), scene.memory, "log/%A_%a.log")?;
    Ok(format!(
        "{head}{cd_command}shard=$((${{1:-0}} + SLURM_ARRAY_TASK_ID))\n\
         echo \"shard $shard of {shards}, start ${{SLURM_RESTART_COUNT:-0}}\"\n\
         exec {command} --shard \"$shard/{shards}\" --film \"$(printf 'shard-%06d.film' \"$shard\")\"\n"
    ))
}

/// Returns the script that merges the films of all shards. `cd_command` is the command that enters
/// the work folder.
fn merge_script(
    arguments: &SlurmArguments,
    header: &FilmHeader,
    program: &str,
    cd_command: &str,
) -> Result<String, ScriptError> {
    // A merge has two films in memory, so it may need more memory than the render of a shard.
    let memory = arguments.scene.memory.map(|shard| shard.max(merge_memory(header)));
    let mut words = Vec::new();
    for path in &arguments.output {
        words.extend(["-o".to_owned(), absolute_text(path)?]);
    }
    words.extend(picture_flags(&arguments.pictures));
    if let Some(memory) = memory {
        words.extend(["--memory".to_owned(), memory.to_string()]);
    }
    let (program, outputs) = (quoted(program)?, shell_command_line(&words)?);
    let head = script_head(arguments, "merge", 1, memory, "log/%j.log")?;
    Ok(format!(
        "{head}{cd_command}{program} merge shard-*.film -o {MERGED_FILM_NAME} {outputs} || exit\necho done >{MERGE_MARK_NAME}\n"
    ))
}

/// Returns the first lines of a script, with options for sbatch.
///
/// `kind` is the last part of the job's name. `memory` is the memory that the job asks for
/// \[bytes]; `None` for the default of the partition. `log` is the file for the script's output.
fn script_head(
    arguments: &SlurmArguments,
    kind: &str,
    threads: u32,
    memory: Option<u64>,
    log: &str,
) -> Result<String, UnquotableWordError> {
    let scene = arguments.scene.scene.file_stem().unwrap_or_default().to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let scene = scene.replace(|c| !is_plain(c), "_");
    let mut options = vec![
        format!("--job-name={scene}-{kind}"),
        "--ntasks=1".to_owned(),
        format!("--cpus-per-task={threads}"),
        // A job that is requeued, for example after its node failed, appends to its log.
        "--requeue".to_owned(),
        "--open-mode=append".to_owned(),
        format!("--output={log}"),
    ];
    options.extend(memory.map(|bytes| format!("--mem={}M", bytes.div_ceil(MEBIBYTE))));
    options.extend(arguments.partition.as_ref().map(|name| format!("--partition={name}")));
    options.extend(arguments.account.as_ref().map(|name| format!("--account={name}")));
    options.extend(arguments.time_limit.as_ref().map(|time| format!("--time={time}")));
    options.extend(arguments.sbatch.iter().cloned());
    let mut head = "#!/bin/sh\n".to_owned();
    for option in &options {
        let _ = writeln!(head, "#SBATCH {}", quoted(option)?);
    }
    Ok(head)
}

/// Returns the number of threads of a shard: the value of `--threads`, or else 1.
fn shard_threads(arguments: &SlurmArguments) -> u32 {
    arguments.scene.threads.unwrap_or(1)
}

/// Returns `path` as an absolute path in text form.
fn absolute_text(path: &Path) -> Result<String, ScriptError> {
    let absolute: PathBuf = std::path::absolute(path)?;
    let unfit = || UnquotableWordError { text: absolute.display().to_string() };
    Ok(absolute.to_str().ok_or_else(unfit)?.to_owned())
}

/// Joins words to one shell command line, with quotes where necessary.
pub(super) fn shell_command_line(words: &[String]) -> Result<String, UnquotableWordError> {
    let words: Result<Vec<String>, UnquotableWordError> = words.iter().map(|word| quoted(word)).collect();
    Ok(words?.join(" "))
}

/// Returns `word` in single quotes if a shell would interpret it, else unchanged.
fn quoted(word: &str) -> Result<String, UnquotableWordError> {
    if word.contains(['\n', '\r', '\0']) {
        return Err(UnquotableWordError { text: word.escape_debug().to_string() });
    }
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return Ok(word.to_owned());
    }
    Ok(format!("'{}'", word.replace('\'', r"'\''")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn shells_read_quoted_words_unchanged() {
        let words = ["a b", "it's", "$HOME `x` \"q\" \\", "", "--flag=ä*?", "plain/path-1.txt", "a;b&c|d>e#f ~"];
        let words: Vec<String> = words.map(str::to_owned).to_vec();
        let script = format!("printf '%s\\n' {}", shell_command_line(&words).unwrap());
        let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), words.join("\n") + "\n");
        assert!(quoted("a\nb").is_err());
    }
}
