//! Arguments of `caustica farm`.

use crate::camera::CropWindow;
use crate::cli::args::{EffectsArguments, MethodArguments};
use crate::cli::film::FilmHeaderSettings;
use crate::cli::pictures::PictureArguments;
use crate::cli::scene_args::SceneArguments;
use crate::cli::value_parsers::{
    parse_confidence, parse_count, parse_duration, parse_positive_count, parse_radiance_limit, parse_relative_error,
};
use crate::render::error_estimate::Confidence;
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, Subcommand};
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `farm`.
#[derive(Debug, Args)]
pub struct FarmArguments {
    /// Batch system that runs the shards, which are parts of the passes of a render.
    #[command(subcommand)]
    pub engine: FarmEngine,
}

/// Batch system that runs the jobs of a farm, with its arguments.
#[derive(Debug, Subcommand)]
pub enum FarmEngine {
    /// Render by job arrays of Slurm (version 22 or later), and wait for them to write the picture
    Slurm(Box<SlurmArguments>),
}

/// Arguments of `farm slurm`.
#[derive(Debug, Args)]
#[command(mut_arg("threads", |threads| threads.help("Threads of each shard, for which it asks Slurm for processors  [default: 1]")))]
#[command(mut_arg("memory", |memory| memory.help("Memory limit of each shard, for which it asks Slurm, such as 4G  [default: that of the partition]")))]
pub struct SlurmArguments {
    #[command(flatten)]
    pub scene: SceneArguments,

    /// File to write: .png, .exr or .film; may be given several times
    #[arg(short, long = "output", required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Number of shards, which are parts of the passes. Each shard runs as one Slurm task. With
    /// --target-error, later waves of jobs add shards
    #[arg(long, value_parser = parse_positive_count, value_name = "N")]
    pub shards: u32,

    /// Number of passes, whose mean is the picture. With --target-error, later waves of jobs add
    /// passes
    #[arg(long, value_parser = parse_positive_count, value_name = "N")]
    pub passes: u32,

    /// Submit further waves of jobs until the estimated relative error is at most this, such as 2%
    #[arg(long, value_parser = parse_relative_error, value_name = "ERROR", conflicts_with = "no_error_estimate")]
    pub target_error: Option<f64>,

    /// Confidence that the error is at most --target-error
    #[arg(long, value_parser = parse_confidence, default_value = "90%", value_name = "PART")]
    pub confidence: Confidence,

    /// Largest number of passes, summed over all waves of jobs  [default: 100 times --passes]
    #[arg(long, value_parser = parse_positive_count, value_name = "N", requires = "target_error")]
    pub max_passes: Option<u32>,

    /// Folder of scripts, films and logs, which all machines of the farm can reach  [default: the
    /// first output with .farm added]
    #[arg(long, value_name = "FOLDER")]
    pub work_dir: Option<PathBuf>,

    /// Slurm partition in which the jobs run
    #[arg(long, value_name = "NAME")]
    pub partition: Option<String>,

    /// Slurm account to which the jobs are charged
    #[arg(long, value_name = "NAME")]
    pub account: Option<String>,

    /// Time limit of a shard in Slurm's notation, such as 2:30:00. Later jobs continue a shard that
    /// reaches the limit
    #[arg(long, value_name = "TIME")]
    pub time_limit: Option<String>,

    /// Further option for sbatch, such as --sbatch=--constraint=zen4; may be given several times
    #[arg(long, allow_hyphen_values = true, value_name = "OPTION")]
    pub sbatch: Vec<String>,

    /// Path of this program on the machines of the farm  [default: its path here]
    #[arg(long, value_name = "FILE")]
    pub program: Option<PathBuf>,

    /// Number of rounds of jobs in a row that may fail to add any pass. After one more such round,
    /// the farm gives up
    #[arg(long, value_parser = parse_count, default_value = "3", value_name = "N")]
    pub retries: u32,

    /// Time between two queries of the state of the jobs
    #[arg(long, value_parser = parse_duration, default_value = "10s", value_name = "TIME")]
    pub poll: Duration,

    /// Print the scripts and the commands that submit them, and submit nothing
    #[arg(long)]
    pub dry_run: bool,

    /// Time between two saves of a shard's film, such as 1m. The film is also saved when the shard
    /// ends
    #[arg(long, value_parser = parse_duration, default_value = "5m", value_name = "TIME")]
    pub save_every: Duration,

    /// Do not estimate the error. Saves a little time and memory; the same passes give the same
    /// picture
    #[arg(long)]
    pub no_error_estimate: bool,

    /// Also store direct, indirect and caustic light separately in the films
    #[arg(long)]
    pub light_groups: bool,

    /// Render only a window of the picture, in pixels from its upper left corner. Its pixels are
    /// bit-identical to those of the whole picture
    #[arg(long, value_name = "X0,Y0,X1,Y1")]
    pub crop: Option<CropWindow>,

    /// Clamp the light of each camera path to this radiance, against fireflies. The picture loses
    /// light, which counts as bias  [default: no limit]
    #[arg(long, value_parser = parse_radiance_limit, value_name = "RADIANCE")]
    pub clamp: Option<f32>,

    #[command(flatten)]
    pub method: MethodArguments,

    #[command(flatten)]
    pub effects: EffectsArguments,

    #[command(flatten)]
    pub pictures: PictureArguments,

    /// Print only errors and warnings
    #[arg(short, long)]
    pub quiet: bool,

    #[command(flatten)]
    pub refused: RefusedArguments,
}

impl SlurmArguments {
    /// Returns the scene and the settings that the headers of all shards' films hold.
    pub(super) fn film_header_settings(&self) -> FilmHeaderSettings<'_> {
        FilmHeaderSettings {
            scene: &self.scene.scene,
            method: &self.method,
            effects: self.effects.effects,
            no_error_estimate: self.no_error_estimate,
            light_groups: self.light_groups,
            clamp: self.clamp,
            crop: self.crop,
            planned_passes: None,
        }
    }
}

/// Flags of `render` that a farm refuses, each with the reason or with the flags to use instead.
const REFUSED_FLAGS: [(&str, &str); 14] = [
    ("film", "each shard has a film of its own in --work-dir; `-o FILE.film` writes the film of all passes"),
    ("shard", "--shards divides the passes"),
    ("time", "the passes are divided before the jobs start; --time-limit limits each shard"),
    ("preview", "--target-error 10% stops at the same error"),
    ("aov", FILM_REMEDY),
    ("aov-first-hit", FILM_REMEDY),
    ("stats", FILM_REMEDY),
    ("update", "each wave writes the picture once, at its end"),
    ("listen", LIVE_REMEDY),
    ("tev", LIVE_REMEDY),
    ("reference", LIVE_REMEDY),
    ("frames", FRAMES_REMEDY),
    ("turn", FRAMES_REMEDY),
    ("stereo", "a film holds one picture: render the pair by `caustica render` with this flag"),
];

const FILM_REMEDY: &str = "afterwards, `caustica render` with this flag, --film DIR/merged.film and the same --passes \
                           makes no further pass; DIR is that of --work-dir";

const FRAMES_REMEDY: &str =
    "frames are renders of their own: let each job K of an array run `caustica render` with --frames K..K+1";

const LIVE_REMEDY: &str = "shards run on other machines; afterwards, `caustica render` with this flag and \
                           --film DIR/merged.film goes on from their passes; DIR is that of --work-dir";

/// Flags of `render` that `farm slurm` accepts only to refuse them with a reason.
#[derive(Clone, Copy, Debug)]
pub struct RefusedArguments;

impl Args for RefusedArguments {
    fn augment_args(command: Command) -> Command {
        // Accept any value, so that no error about a value hides the reason for the refusal.
        let argument = |name| Arg::new(name).long(name).hide(true).num_args(0..=1).action(ArgAction::Append);
        command.args(REFUSED_FLAGS.map(|(name, _)| argument(name)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for RefusedArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        match REFUSED_FLAGS.iter().find(|(name, _)| matches.contains_id(name)) {
            None => Ok(Self),
            Some((name, remedy)) => {
                let message = format!("a farm does not take --{name}: {remedy}\n");
                Err(clap::Error::raw(ErrorKind::ArgumentConflict, message))
            }
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        Self::from_arg_matches(matches).map(|refused| *self = refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Arguments;
    use clap::{CommandFactory, Parser};
    use std::collections::BTreeSet;

    /// Each flag of `render` is a flag of `farm slurm`, or is refused with a reason.
    #[test]
    fn farm_accepts_or_refuses_every_render_flag() {
        let arguments = Arguments::command();
        let flags = |command: &Command, hidden: bool| -> BTreeSet<String> {
            let flags = command.get_arguments().filter(|argument| argument.is_hide_set() == hidden);
            flags.filter_map(|argument| argument.get_long()).map(str::to_owned).collect()
        };
        let slurm = arguments.find_subcommand("farm").unwrap().find_subcommand("slurm").unwrap();
        let render = flags(arguments.find_subcommand("render").unwrap(), false);
        let refused: BTreeSet<String> = REFUSED_FLAGS.iter().map(|(name, _)| (*name).to_owned()).collect();
        let taken = flags(slurm, false);
        let unknown: Vec<_> = render.difference(&taken).filter(|name| !refused.contains(*name)).collect();
        assert!(unknown.is_empty(), "neither taken nor refused: {unknown:?}");
        assert_eq!(flags(slurm, true), refused);
        let needed = ["caustica", "farm", "slurm", "a.txt", "-o", "a.exr", "--shards", "2", "--passes", "4"];
        assert!(Arguments::try_parse_from(needed).is_ok());
        for (name, remedy) in REFUSED_FLAGS {
            for value in ["", "=x"] {
                let flag = format!("--{name}{value}");
                let error = Arguments::try_parse_from(needed.into_iter().chain([flag.as_str()])).unwrap_err();
                assert!(error.to_string().contains(&format!("does not take --{name}: {remedy}")), "{error}");
            }
        }
    }
}
