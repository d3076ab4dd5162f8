//! Arguments of `caustica study`, for studies of methods and of effects.

use crate::cli::args::MethodArguments;
use crate::cli::scene_args::SceneArguments;
use crate::cli::value_parsers::{parse_duration, parse_exposure_stops, parse_positive_count, parse_seed_count};
use crate::integrate::Algorithm;
use crate::plan::EffectOverrides;
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// Fields of [`StudyModeArguments`] that only a study of methods uses. Their flags conflict with
/// `--effects`, which asks for a study of effects.
const METHOD_STUDY_FLAGS: [&str; 8] =
    ["methods", "variants", "knobs", "budget", "seeds", "truth", "truth_time", "save_truth"];

/// Flags that choose between a study of effects (`--effects`) and a study of methods (all other
/// flags).
#[derive(Debug, Args)]
pub struct StudyModeArguments {
    /// Render the picture with and without each effect of the plan, to measure its cost and
    /// contribution
    #[arg(long, conflicts_with_all = METHOD_STUDY_FLAGS)]
    pub effects: bool,

    /// Measure how the error of these methods falls with time, such as path,sppm. Without
    /// --methods, --variant and --knobs, the study measures path, and each of pm, ppm, sppm and
    /// hybrid that finds more light than path in this scene
    #[arg(long, value_enum, value_delimiter = ',', value_name = "NAMES")]
    pub methods: Vec<Algorithm>,

    /// Measure a method with its own flags in addition to the common ones, such as
    /// "sppm --gather-k 20"; may be given several times
    #[arg(long = "variant", value_name = "METHOD FLAGS")]
    pub variants: Vec<String>,

    /// Measure the method with its default settings, and with one setting changed at a time
    #[arg(long, value_enum, value_name = "METHOD")]
    pub knobs: Option<Algorithm>,

    /// Processor time of each picture, such as 60s or 5m; each method renders one picture per seed
    #[arg(long, value_parser = parse_duration, default_value = "60s", value_name = "TIME")]
    pub budget: Duration,

    /// Number of pictures per method, with the seeds --seed, --seed + 1 and so on. Several pictures
    /// separate noise from bias
    #[arg(long, value_parser = parse_seed_count, default_value = "8", value_name = "N")]
    pub seeds: u32,

    /// Reference pictures to measure errors against: auto (two pictures, rendered first),
    /// A.exr,B.exr (two independent pictures) or A.exr (one picture, taken as exact)
    #[arg(long, default_value = "auto", value_name = "FILES")]
    pub truth: ReferenceSource,

    /// Processor time of each of the two references of --truth auto  [default: four times --budget]
    #[arg(long, value_parser = parse_duration, value_name = "TIME")]
    pub truth_time: Option<Duration>,

    /// Save the two references of --truth auto to these files: A.exr,B.exr
    #[arg(long, value_name = "FILES", value_parser = parse_file_pair)]
    pub save_truth: Option<(PathBuf, PathBuf)>,
}

/// Source of the reference pictures that errors are measured against: value of `--truth`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReferenceSource {
    /// Two independent references, which the study renders first.
    Auto,
    /// File of one reference picture, which is taken as exact.
    OneFile(PathBuf),
    /// Files of two reference pictures with independent noise.
    TwoFiles(PathBuf, PathBuf),
}

impl FromStr for ReferenceSource {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ if text.contains(',') => parse_file_pair(text).map(|(a, b)| Self::TwoFiles(a, b)),
            _ => Ok(Self::OneFile(text.into())),
        }
    }
}

/// Parses two different file names separated by a comma.
fn parse_file_pair(text: &str) -> Result<(PathBuf, PathBuf), String> {
    match text.split(',').collect::<Vec<_>>()[..] {
        [a, b] if a == b => Err(format!("`{a}` is named twice: two references must be independent")),
        [a, b] if !a.is_empty() && !b.is_empty() => Ok((a.into(), b.into())),
        _ => Err(format!("`{text}` names no two files: write A.exr,B.exr")),
    }
}

/// Arguments of `study`.
#[derive(Debug, Args)]
#[command(mut_arg("integrator", |integrator| integrator.requires("effects").conflicts_with_all(METHOD_STUDY_FLAGS)))]
pub struct StudyArguments {
    #[command(flatten)]
    pub kind: StudyModeArguments,

    #[command(flatten)]
    pub scene: SceneArguments,

    /// Write a report: .html (a page with the pictures, in one file), .json (all figures), .csv or
    /// .md; may be given several times
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Vec<PathBuf>,

    #[command(flatten)]
    pub method: MethodArguments,

    /// Effects that the full picture simulates, as with --effects of `caustica render`
    #[arg(long, visible_alias = "wish", allow_hyphen_values = true, value_name = "EFFECTS", default_value = "auto")]
    pub simulate: EffectOverrides,

    /// With --effects, number of passes of each picture; else, largest number of passes of each
    /// method  [default: 4 with --effects, else limited by --budget]
    #[arg(long, value_parser = parse_positive_count, value_name = "N")]
    pub passes: Option<u32>,

    /// Exposure of the full picture on the page in stops: +1 is twice as bright
    #[arg(long, default_value = "0", value_parser = parse_exposure_stops, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: f32,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Print only the result, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}
