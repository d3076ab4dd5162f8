//! Arguments of the command line, for all commands.

#[cfg(feature = "view")]
use super::ViewArguments;
use super::pictures::PictureArguments;
use super::scene_args::SceneArguments;
use super::shard::Shard;
use super::value_parsers::{
    parse_alpha, parse_confidence, parse_count, parse_duration, parse_gather_count, parse_positive_count,
    parse_positive_length, parse_radiance_limit, parse_relative_error, parse_seed,
};
use super::{
    ConvertArguments, DiffArguments, FarmArguments, FilmArguments, FrameRange, MergeArguments, MeshArguments,
    StudyArguments,
};
use crate::camera::{CropWindow, FilterKind};
use crate::integrate::{Algorithm, FinalGathering, IndirectPhotons, LightTracing, VolumeEstimator};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;
use crate::render::error_estimate::Confidence;
#[cfg(feature = "view")]
use crate::view::{ListenAddress, TevAddress};
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;
use std::time::Duration;

/// Photon-mapping renderer that estimates the error of its pictures.
#[derive(Debug, Parser)]
#[command(name = "caustica", version, about, after_help = EXIT_CODES_HELP)]
pub struct Arguments {
    /// The command to run.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES_HELP: &str = "\
Exit codes:
  0    success
  1    a scene, mesh or picture is missing or wrong
  2    the command line is wrong, or asks for more memory than there is
  3    at least one output cannot be written; all others are written
  4    pictures differ by more than the limits of `caustica diff`
  5    the engine of a farm is missing or refuses, or parts of a render failed on it
  130  interrupted by Ctrl-C, SIGTERM or SIGHUP: after the first one the picture so far is written, \
a second one stops at once";

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to pictures
    Render(Box<RenderArguments>),
    /// Render a scene and show it on a live page, which follows changes of the scene file
    #[cfg(feature = "view")]
    View(Box<ViewArguments>),
    /// Show which effects of light a scene needs, why, and what each costs
    Plan(Box<PlanArguments>),
    /// Estimate, from a short pilot render, the passes, time and photons needed for given errors
    #[command(visible_alias = "price")]
    Estimate(Box<EstimateArguments>),
    /// Measure how the error of rendering methods falls with time, or how much time each effect of
    /// light costs and how much light it adds
    Study(Box<StudyArguments>),
    /// Measure the error of a picture against a reference, and draw a map of the error
    Diff(Box<DiffArguments>),
    /// Inspect, repair and convert a mesh
    Mesh(Box<MeshArguments>),
    /// Read a scene and everything it names, report errors and warnings, and render nothing
    Check(Box<SceneArguments>),
    /// Merge the film files of parts of a render into one film or picture
    Merge(MergeArguments),
    /// Describe a film file: its scene, settings, passes and estimated error
    Film(FilmArguments),
    /// Render on many machines, by jobs of a batch system such as Slurm
    Farm(FarmArguments),
    /// Convert a scene to the text format of this program; embedded meshes and pictures become
    /// files
    Convert(ConvertArguments),
    /// Print a completion script for a shell
    Completions {
        /// Shell for which the script is printed
        shell: Shell,
    },
    /// Print the manual page in roff, for `man -l -`
    Man,
}

/// Flags that choose the rendering algorithm and its settings.
#[derive(Clone, Debug, Args)]
pub struct MethodArguments {
    /// Rendering algorithm
    #[arg(long, value_enum, default_value = "hybrid")]
    pub integrator: Algorithm,

    /// Photon paths per pass that lights emit in all directions, such as 500k or 2M; 0 for none.
    /// They fill the map of indirect light, which in hybrid leaves out the light of caustics
    /// [default: about 500k]
    #[arg(long, value_parser = parse_count, value_name = "N")]
    pub photons: Option<u32>,

    /// Photon paths per pass that lights aim at casters, objects that cast caustics, such as glass
    /// and mirrors; 0 for none. They fill the caustic map  [default: half as many as --photons]
    #[arg(long, value_parser = parse_count, value_name = "N")]
    pub caustic_photons: Option<u32>,

    /// Camera rays per pixel and pass  [default: depends on the integrator]
    #[arg(long, value_parser = parse_positive_count, value_name = "N")]
    pub spp: Option<u32>,

    /// Largest number of photons in a density estimate, at least 2; 0 for all photons within the
    /// gather radius  [default: 50 for caustics, else all]
    #[arg(long, value_parser = parse_gather_count, value_name = "K")]
    pub gather_k: Option<u32>,

    /// Largest gather radius of the first pass, in scene units  [default: chosen by a pilot pass]
    #[arg(long, value_parser = parse_positive_length, value_name = "R")]
    pub radius: Option<f32>,

    /// Controls how fast gather radii shrink, in (0, 1]: after N passes, variance has fallen as
    /// N^-ALPHA. 1 keeps all radii. pm ignores this flag  [default: 2/3]
    #[arg(long, value_parser = parse_alpha, value_name = "ALPHA")]
    pub alpha: Option<f64>,

    /// Kernel of density estimates: box, cone or epanechnikov
    #[arg(long, default_value = "epanechnikov", value_name = "NAME")]
    pub kernel: Kernel,

    /// Final gathering of pm: none, bsdf (gather rays sampled from the BSDF) or importance (half of
    /// the gather rays follow directions from which nearby photons came)
    #[arg(long, value_enum, default_value = "bsdf", value_name = "NAME")]
    pub final_gathering: FinalGathering,

    /// Turn off the prefix rays of hybrid. These extra camera rays end at the first diffuse
    /// surface, and reduce the noise of highlights and caustics seen through glass
    #[arg(long)]
    pub no_prefix_rays: bool,

    /// Choose directions to an environment light by its brightness alone. By default, a pilot also
    /// finds which of these directions are unblocked in each part of the scene
    #[arg(long)]
    pub no_environment_guiding: bool,

    /// Turn off the pilot that chooses where in fog shadow rays start. By default, the pilot finds
    /// the lit parts of homogeneous media, and the number of such starting points per camera ray
    #[arg(long)]
    pub no_scatter_point_guiding: bool,

    /// Use of light tracing for directly visible caustics in hybrid: off (photon estimates alone),
    /// weighted (a mix of both, set per pixel) or full (light tracing alone)
    #[arg(long, value_enum, default_value = "weighted", value_name = "NAME")]
    pub light_tracing: LightTracing,

    /// Use of photon estimates for indirect light in hybrid: off (camera paths alone), weighted (a
    /// mix of both) or full (photon estimates alone)
    #[arg(long, value_enum, default_value = "weighted", value_name = "NAME")]
    pub indirect_photons: IndirectPhotons,

    /// Photon estimate in media: beams (photon beams near the camera ray), beam-radiance (photons
    /// near the camera ray) or points (photons near one point of the camera ray)
    #[arg(long, value_enum, default_value = "beams", value_name = "NAME")]
    pub volume: VolumeEstimator,

    /// Largest number of bounces of a path
    #[arg(long, value_parser = parse_count, default_value = "100", value_name = "N")]
    pub max_bounces: u32,

    /// Reconstruction filter of pixels: box, tent, gaussian, blackman-harris or mitchell
    #[arg(long, default_value = "blackman-harris", value_name = "NAME")]
    pub filter: FilterKind,

    /// Send more camera rays through pixels where a pilot pass finds more noise. The total number
    /// of camera rays does not change
    #[arg(long)]
    pub adaptive: bool,

    /// Seed of all random numbers. Equal seeds and settings give equal pictures, bit for bit
    #[arg(long, value_parser = parse_seed, default_value = "0", value_name = "N")]
    pub seed: u64,
}

/// The flag `--effects`: which effects of light are simulated.
#[derive(Clone, Debug, Args)]
pub struct EffectsArguments {
    /// Effects of light to simulate: auto (those that the scene needs), all or none. +EFFECT or
    /// -EFFECT after a comma turns one effect on or off. `caustica plan` lists the effects
    #[arg(long, allow_hyphen_values = true, value_name = "EFFECTS", default_value = "auto")]
    pub effects: EffectOverrides,
}

/// Arguments of `render`.
#[derive(Clone, Debug, Args)]
pub struct RenderArguments {
    #[command(flatten)]
    pub scene: SceneArguments,

    /// File to write: .png or .exr; may be given several times. Required without --film
    #[arg(short, long = "output", required_unless_present = "film", value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Film file, which accumulates the samples of all passes. If the file exists, the render
    /// continues from it
    #[arg(long, value_name = "FILE")]
    pub film: Option<PathBuf>,

    /// Time between two saves of the film file, such as 1m. The end of the render saves it too
    #[arg(long, value_parser = parse_duration, default_value = "5m", value_name = "TIME", requires = "film")]
    pub save_every: Duration,

    /// Render only the K-th of N parts of the passes, such as 3/16. `caustica merge` adds the films
    /// of all parts
    #[arg(long, value_name = "K/N", requires_all = ["film", "passes"], conflicts_with_all = ["time", "target_error", "preview"])]
    pub shard: Option<Shard>,

    #[command(flatten)]
    pub method: MethodArguments,

    #[command(flatten)]
    pub effects: EffectsArguments,

    /// Number of passes, whose mean is the picture  [default: no limit; 1 for raycast]
    #[arg(long, value_parser = parse_positive_count, value_name = "N")]
    pub passes: Option<u32>,

    /// Stop after the pass whose end is nearest to this time, such as 60s or 5m. Loading and pilots
    /// are part of the time  [default: 5m; no limit with --passes or --target-error]
    #[arg(long, value_parser = parse_duration, value_name = "TIME")]
    pub time: Option<Duration>,

    /// Stop after the pass in which the estimated relative error is at most this, such as 2%. The
    /// true error may be larger  [default: 3%; none with --passes or --time]
    #[arg(long, value_parser = parse_relative_error, value_name = "ERROR", conflicts_with = "no_error_estimate")]
    pub target_error: Option<f64>,

    /// Stop at an error of 10% instead of 3%, for a quick picture. With --passes or --time, stop at
    /// whichever comes first
    #[arg(long, conflicts_with_all = ["target_error", "no_error_estimate"])]
    pub preview: bool,

    /// Confidence that the error is at most --target-error when the render stops. With --passes or
    /// --time alone, confidence of the printed interval of the error
    #[arg(long, value_parser = parse_confidence, default_value = "90%", value_name = "PART")]
    pub confidence: Confidence,

    /// Write the picture and further layers as one .exr file: albedo, normal, depth, position,
    /// object, material and motion, and maps of the estimated error
    #[arg(long, value_name = "FILE")]
    pub aov: Option<PathBuf>,

    /// Take albedo, normal and other surface layers of --aov from the first surface. By default,
    /// they come from the first surface that is not a mirror or smooth glass
    #[arg(long, requires = "aov")]
    pub aov_first_hit: bool,

    /// Also write direct, indirect and caustic light as layers of --aov, whose sum is the
    /// picture
    #[arg(long)]
    pub light_groups: bool,

    /// Do not estimate the error. Saves a little time and memory; the same passes give the same
    /// picture. Without --passes and --time, stop after 16 passes (path: 32; sppm, ppm and pm: 20)
    #[arg(long, visible_alias = "no-gauge")]
    pub no_error_estimate: bool,

    /// Render only a window of the picture, in pixels from its upper left corner. Its pixels are
    /// bit-identical to those of the whole picture
    #[arg(long, value_name = "X0,Y0,X1,Y1")]
    pub crop: Option<CropWindow>,

    /// Render the frames A to B-1 of a turntable: the camera circles around the point that it looks
    /// at. In names of outputs, %04d stands for the number of the frame
    #[arg(long, value_name = "A..B", conflicts_with_all = ["film", "shard"])]
    #[cfg_attr(feature = "view", arg(conflicts_with_all = ["listen", "tev"]))]
    pub frames: Option<FrameRange>,

    /// Number of frames in which the camera of --frames makes a full turn  [default: the end of
    /// --frames]
    #[arg(long, value_name = "N", value_parser = parse_positive_count, requires = "frames")]
    pub turn: Option<u32>,

    /// Render two pictures, of a left and a right eye this distance apart, in scene units. Names of
    /// outputs get -left and -right
    #[arg(long, value_name = "DISTANCE", value_parser = parse_positive_length, conflicts_with_all = ["film", "shard", "frames"])]
    #[cfg_attr(feature = "view", arg(conflicts_with_all = ["listen", "tev"]))]
    pub stereo: Option<f32>,

    /// Clamp the light of each camera path to this radiance, against fireflies. The picture loses
    /// light, which is reported and counts as bias  [default: no limit]
    #[arg(long, value_parser = parse_radiance_limit, value_name = "RADIANCE")]
    pub clamp: Option<f32>,

    /// Time between two updates of the files of -o during the render, such as 30s. The first update
    /// follows the first pass. 0 writes the files at the end only
    #[arg(long, value_parser = parse_duration, default_value = "10s", value_name = "TIME")]
    pub update: Duration,

    /// Show the render on a live page at this address while it goes on  [default without ADDR:PORT:
    /// a free port of 127.0.0.1]
    #[cfg(feature = "view")]
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:0")]
    pub listen: Option<ListenAddress>,

    /// Send the picture to the viewer tev during the render  [default without HOST:PORT:
    /// 127.0.0.1:14158]
    #[cfg(feature = "view")]
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1")]
    pub tev: Option<TevAddress>,

    /// Picture to compare with on the live page: .exr, .png or .hdr
    #[cfg(feature = "view")]
    #[arg(long, value_name = "FILE", requires = "listen")]
    pub reference: Option<PathBuf>,

    #[command(flatten)]
    pub pictures: PictureArguments,

    /// Write a report of the render as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,

    /// Print only errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

impl RenderArguments {
    /// Returns the time between two updates of the picture files; `None` to write them only at the
    /// end.
    pub(super) fn update_interval(&self) -> Option<Duration> {
        Some(self.update).filter(|interval| *interval > Duration::ZERO)
    }
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    #[command(flatten)]
    pub scene: SceneArguments,

    #[command(flatten)]
    pub method: MethodArguments,

    #[command(flatten)]
    pub effects: EffectsArguments,

    /// Only check the scene and its inputs, like `caustica check`
    #[arg(long)]
    pub check: bool,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `estimate`.
#[derive(Debug, Args)]
pub struct EstimateArguments {
    #[command(flatten)]
    pub scene: SceneArguments,

    #[command(flatten)]
    pub method: MethodArguments,

    #[command(flatten)]
    pub effects: EffectsArguments,

    /// Target errors, such as 2%: relative errors for which the cost of a render is estimated
    #[arg(long, value_parser = parse_relative_error, value_delimiter = ',', default_value = "10%,5%,3%,2%,1%", value_name = "ERROR,…")]
    pub errors: Vec<f64>,

    /// Further algorithms whose costs are estimated; a table shows which algorithm is the fastest
    #[arg(long, value_enum, value_delimiter = ',', value_name = "METHOD,…")]
    pub compare: Vec<Algorithm>,

    /// Duration of the pilot render. The pilot takes longer if it has not made eight passes by then
    #[arg(long, value_parser = parse_duration, default_value = "10s", value_name = "TIME")]
    pub pilot: Duration,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Print only the result, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}
