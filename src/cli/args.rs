//! What can be typed.

use super::number::{
    alpha, bytes, confidence, count, duration, error, gather_count, length, positive_count, size, stops, threads,
};
use super::{DiffArguments, MeshArguments};
use crate::camera::FilterKind;
use crate::image::{BitDepth, Curve, FloatDepth};
use crate::integrate::{Algorithm, FinalGathering, VolumeEstimate};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;
use crate::render::error_estimate::Confidence;
use crate::stats::Memory;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// Photon mapping that tells what accuracy costs.
#[derive(Debug, Parser)]
#[command(name = "caustica", version, about, after_help = EXIT_CODES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 a scene, mesh or picture is missing or wrong; 2 wrong command line, or too little memory for it; 3 an output cannot be written; \
4 pictures differ by more than `caustica diff` was told to allow; 130 interrupted (once: the picture so far was written; twice: nothing was).";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to pictures
    Render(Box<RenderArguments>),
    /// Tell what of light a scene calls for, why, and what it costs
    Plan(Box<PlanArguments>),
    /// Tell what an error costs: passes, time and photons, after a short pilot
    Price(Box<PriceArguments>),
    /// Measure what parts of a picture cost and are worth
    Study(Box<StudyArguments>),
    /// Tell how far two pictures are apart, and draw where
    Diff(Box<DiffArguments>),
    /// Tell what a mesh is like, repair it, and convert it
    Mesh(Box<MeshArguments>),
}

/// What light is computed by: common to all commands that render.
#[derive(Clone, Debug, Args)]
pub struct MethodArguments {
    /// The algorithm
    #[arg(long, value_enum, default_value = "hybrid")]
    pub integrator: Algorithm,

    /// Photon paths of the global map a pass, such as 500k or 2M; 0 for none  [default: about 500k]
    #[arg(long, value_parser = count, value_name = "N")]
    pub photons: Option<u32>,

    /// Photon paths aimed at glass and mirrors a pass; 0 for none  [default: half as many as --photons]
    #[arg(long, value_parser = count, value_name = "N")]
    pub caustic_photons: Option<u32>,

    /// Camera rays a pixel and pass  [default: by integrator]
    #[arg(long, value_parser = positive_count, value_name = "N")]
    pub spp: Option<u32>,

    /// Most photons in a density estimate, at least 2; 0 for no limit but the radius  [default: 50 in caustics, else no limit]
    #[arg(long, value_parser = gather_count, value_name = "K")]
    pub gather_k: Option<u32>,

    /// Largest gather radius of the first pass, in units of the scene  [default: found by a pilot pass]
    #[arg(long, value_parser = length, value_name = "R")]
    pub radius: Option<f32>,

    /// How fast gather radii shrink: variance falls as N^-ALPHA over N passes, in (0, 1]; 1 keeps them. No matter to pm  [default: 2/3]
    #[arg(long, value_parser = alpha, value_name = "ALPHA")]
    pub alpha: Option<f64>,

    /// Kernel of the density estimate: box, cone or epanechnikov
    #[arg(long, default_value = "epanechnikov", value_name = "NAME")]
    pub kernel: Kernel,

    /// How pm looks at the global map: none (directly), bsdf or importance (gather rays, drawn from the BSDF or guided by photons)
    #[arg(long, value_enum, default_value = "bsdf", value_name = "NAME")]
    pub final_gathering: FinalGathering,

    /// How light in media is estimated from photons: beams, beam-radiance or points
    #[arg(long, value_enum, default_value = "beams", value_name = "NAME")]
    pub volume: VolumeEstimate,

    /// Bounces after which a path is cut
    #[arg(long, value_parser = count, default_value = "100", value_name = "N")]
    pub max_bounces: u32,

    /// Pixel filter: box, tent, gaussian, blackman-harris or mitchell
    #[arg(long, default_value = "blackman-harris", value_name = "NAME")]
    pub filter: FilterKind,

    /// Give pixels camera rays in proportion to their noise, as a pilot sees it; no more in all
    #[arg(long)]
    pub adaptive: bool,

    /// Seed: the same seed and settings give the same picture, bit for bit
    #[arg(long, default_value = "0", value_name = "N")]
    pub seed: u64,
}

/// What is simulated, for commands whose `--effects` says so.
#[derive(Debug, Args)]
pub struct EffectsArguments {
    /// What to simulate whatever the scene calls for: auto, all or none, then +effect or -effect, divided by commas; `caustica plan`
    /// lists them
    #[arg(long, allow_hyphen_values = true, value_name = "WISHES", default_value = "auto")]
    pub effects: EffectOverrides,
}

/// What is rendered and with what: common to all commands that render.
#[derive(Debug, Args)]
pub struct SceneArguments {
    /// The scene file
    pub scene: PathBuf,

    /// Picture size, such as 1280x720  [default: the scene's]
    #[arg(long, value_parser = size, value_name = "WxH")]
    pub size: Option<(u32, u32)>,

    /// Threads  [default: one a core]
    #[arg(long, value_parser = threads, value_name = "N")]
    pub threads: Option<u32>,

    /// Most memory to take, such as 4G or 512M: what would take more is refused before it begins  [default: what is free]
    #[arg(long, value_parser = bytes, value_name = "SIZE")]
    pub memory: Option<u64>,
}

impl SceneArguments {
    /// What memory may be taken.
    pub(super) fn memory(&self) -> Memory {
        self.memory.map_or(Memory::System, Memory::Limit)
    }
}

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArguments,

    /// Where to write: .png or .exr; may be given several times
    #[arg(short, long = "output", required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub method: MethodArguments,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub effects: EffectsArguments,

    /// Passes; their mean is the picture  [default: by integrator, or no limit with --time or --target-error]
    #[arg(long, value_parser = positive_count, value_name = "N")]
    pub passes: Option<u32>,

    /// End after the pass in which this much time has gone by, such as 60s or 5m
    #[arg(long, value_parser = duration, value_name = "TIME")]
    pub time: Option<Duration>,

    /// End after the pass by which the relative error is no larger, such as 2%; the error is told of noise and bias (see docs/theory/accuracy.md)
    #[arg(long, value_parser = error, value_name = "ERROR", conflicts_with = "no_gauge")]
    pub target_error: Option<f64>,

    /// How sure --target-error must be; without it, the interval of the error that is told
    #[arg(long, value_parser = confidence, default_value = "90%", value_name = "PART")]
    pub confidence: Confidence,

    /// Write the picture and maps of its error as layers of an .exr file: noise, bias, and the radius and photons of estimates
    #[arg(long, value_name = "FILE", conflicts_with = "no_gauge")]
    pub aov: Option<PathBuf>,

    /// Do not tell the error: a picture takes a little less time and memory, and is the same
    #[arg(long)]
    pub no_gauge: bool,

    /// Tone curve of PNG: srgb, filmic or course (bytes without gamma)  [default: srgb; raycast course]
    #[arg(long, value_name = "NAME")]
    pub tone: Option<Curve>,

    /// Exposure of PNG in stops: +1 is twice as bright
    #[arg(long, default_value = "0", value_parser = stops, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: f32,

    /// Bits a channel of PNG: 8 or 16
    #[arg(long, default_value = "8", value_parser = depth, value_name = "BITS")]
    pub png_bits: BitDepth,

    /// Bits a channel of OpenEXR: 16 (up to 65504) or 32
    #[arg(long, default_value = "32", value_parser = float_depth, value_name = "BITS")]
    pub exr_bits: FloatDepth,

    /// Write what was done as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,

    /// Say nothing but errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArguments,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub method: MethodArguments,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub effects: EffectsArguments,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `price`.
#[derive(Debug, Args)]
pub struct PriceArguments {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArguments,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub method: MethodArguments,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub effects: EffectsArguments,

    /// Relative errors to be priced
    #[arg(long, value_parser = error, value_delimiter = ',', default_value = "10%,5%,2%,1%", value_name = "ERROR,…")]
    pub errors: Vec<f64>,

    /// Let the pilot run for about so long, and eight passes at least
    #[arg(long, value_parser = duration, default_value = "10s", value_name = "TIME")]
    pub pilot: Duration,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Say nothing but the result, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}
/// Arguments of a study of methods.
const OF_METHODS: [&str; 8] = ["methods", "variants", "knobs", "budget", "seeds", "truth", "truth_time", "save_truth"];

#[derive(Debug, Args)]
pub struct StudyKind {
    /// Render the picture with and without each effect of the plan: what it costs, and what it adds
    #[arg(long, conflicts_with_all = OF_METHODS)]
    pub effects: bool,

    /// Measure how the error of these methods falls with time, such as path,sppm  [default: those of path, pm, ppm, sppm and hybrid that
    /// differ in the scene, where neither --variant nor --knobs is given]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "NAMES")]
    pub methods: Vec<Algorithm>,

    /// Measure a method with flags of its own besides those given to all, such as "sppm --gather-k 20"; may be given several times
    #[arg(long = "variant", value_name = "METHOD FLAGS")]
    pub variants: Vec<String>,

    /// Measure what each setting of a method buys: it alone, and with one setting changed at a time
    #[arg(long, value_enum, value_name = "METHOD")]
    pub knobs: Option<Algorithm>,

    /// Processor time that a seed of each method may take, such as 60s or 5m
    #[arg(long, value_parser = duration, default_value = "60s", value_name = "TIME")]
    pub budget: Duration,

    /// Pictures of each method, from --seed upwards; what tells noise from bias
    #[arg(long, value_parser = seeds, default_value = "8", value_name = "N")]
    pub seeds: u32,

    /// What errors are held against: auto (two references, rendered first), A.exr,B.exr (two that are independent) or A.exr (exact)
    #[arg(long, default_value = "auto", value_name = "FILES")]
    pub truth: TruthFiles,

    /// Processor time of each of the two references of --truth auto  [default: four times --budget]
    #[arg(long, value_parser = duration, value_name = "TIME")]
    pub truth_time: Option<Duration>,

    /// Where to keep the two references of --truth auto: A.exr,B.exr
    #[arg(long, value_name = "FILES", value_parser = pair)]
    pub save_truth: Option<(PathBuf, PathBuf)>,
}

/// What errors are held against.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TruthFiles {
    /// Two references, to be rendered.
    Auto,
    /// One that is exact.
    One(PathBuf),
    /// Two that are independent.
    Two(PathBuf, PathBuf),
}

impl FromStr for TruthFiles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ if text.contains(',') => pair(text).map(|(a, b)| Self::Two(a, b)),
            _ => Ok(Self::One(text.into())),
        }
    }
}

/// Two files.
fn pair(text: &str) -> Result<(PathBuf, PathBuf), String> {
    match text.split(',').collect::<Vec<_>>()[..] {
        [a, b] if a == b => Err(format!("`{a}` is named twice: two references must be independent")),
        [a, b] if !a.is_empty() && !b.is_empty() => Ok((a.into(), b.into())),
        _ => Err(format!("`{text}` names no two files: write A.exr,B.exr")),
    }
}

/// More seeds tell no more than longer runs do.
const MOST_SEEDS: u32 = 1000;

fn seeds(text: &str) -> Result<u32, String> {
    match count(text)? {
        0 | 1 => Err("it must be at least 2, as one picture does not tell noise from bias".to_owned()),
        n @ ..=MOST_SEEDS => Ok(n),
        _ => Err(format!("it must be at most {MOST_SEEDS}")),
    }
}

/// Arguments of `study`.
#[derive(Debug, Args)]
#[command(mut_arg("integrator", |integrator| integrator.requires("effects").conflicts_with_all(OF_METHODS)))]
pub struct StudyArguments {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub kind: StudyKind,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArguments,

    /// Write a report; the extension says which. .html: a page with the pictures that needs no other file; .json: all figures. May be
    /// given several times
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Vec<PathBuf>,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub method: MethodArguments,

    /// What the whole picture simulates, as --effects of `caustica render`
    #[arg(long, allow_hyphen_values = true, value_name = "WISHES", default_value = "auto")]
    pub wish: EffectOverrides,

    /// Passes of each picture, or the most of each method  [default: 4 with --effects, else as many as --budget allows]
    #[arg(long, value_parser = positive_count, value_name = "N")]
    pub passes: Option<u32>,

    /// Exposure of the whole picture on the page in stops: +1 is twice as bright
    #[arg(long, default_value = "0", value_parser = stops, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: f32,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Say nothing but the result, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

fn depth(text: &str) -> Result<BitDepth, String> {
    match text {
        "8" => Ok(BitDepth::Eight),
        "16" => Ok(BitDepth::Sixteen),
        _ => Err("PNG has 8 or 16 bits a channel here".to_owned()),
    }
}

fn float_depth(text: &str) -> Result<FloatDepth, String> {
    match text {
        "16" => Ok(FloatDepth::Half),
        "32" => Ok(FloatDepth::Single),
        _ => Err("OpenEXR has 16 or 32 bits a channel here".to_owned()),
    }
}
