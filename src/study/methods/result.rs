//! Results of a study of methods: error, noise, bias and cost of each method after 1, 2, 4 …
//! passes.

use crate::image::Image;
use crate::integrate::Algorithm;
use serde::Serialize;

/// Checkpoint of a rendering method: its error, noise, bias and cost after a number of passes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ConvergenceCheckpoint {
    /// Number of passes that each seed has made.
    pub passes: u32,
    /// Processor time of all passes so far, mean over seeds \[s]. Preparing the integrator is not
    /// included.
    #[serde(rename = "seconds")]
    pub cpu_seconds: f64,
    /// Wall time of all passes so far, mean over seeds \[s]. Preparing the integrator is not
    /// included.
    #[serde(rename = "wall")]
    pub wall_seconds: f64,
    /// Number of rays of all kinds so far, mean over seeds.
    pub rays: f64,
    /// Number of photon paths emitted so far, mean over seeds.
    #[serde(rename = "photons")]
    pub photon_paths: f64,
    /// Relative squared error of each seed's picture, see
    /// [`RelativeErrorWeights`](crate::image::RelativeErrorWeights).
    ///
    /// Each value is an unbiased estimate, because it is computed from two references whose
    /// independent noise cancels in the mean. If the error is small, noise can make the estimate
    /// negative.
    #[serde(rename = "squares")]
    pub relative_squared_errors: Vec<f64>,
    /// Relative squared noise: variance between the pictures of the seeds. Pixels are weighted as
    /// in `relative_squared_errors`.
    #[serde(rename = "noise2")]
    pub squared_noise: f64,
    /// Estimates of the relative squared noise, one from each seed; their mean is `squared_noise`.
    ///
    /// With S seeds, the estimate is S/(S − 1) times the relative squared difference between the
    /// seed's picture and the mean picture of all seeds. The list is empty if only `squared_noise`
    /// is known.
    #[serde(rename = "noises")]
    pub squared_noises: Vec<f64>,
    /// Relative squared bias: mean of `relative_squared_errors`, minus `squared_noise`. This
    /// estimate may be negative.
    #[serde(rename = "bias2")]
    pub squared_bias: f64,
    /// Squares of the relative errors that the renderer estimates by itself, without a reference.
    /// There is one value for each seed whose estimate is finite.
    #[serde(rename = "estimated")]
    pub squared_estimated_errors: Vec<f64>,
    /// Root mean square error over pixels, channels and seeds \[W/(m² sr)], without the noise of
    /// the references. If noise makes the estimated mean square negative, the value is 0.
    pub rmse: f64,
    /// Mean ꟻLIP error of the first seed's picture against the reference, in \[0, 1].
    pub flip: f64,
}

impl ConvergenceCheckpoint {
    /// Returns the relative squared error, as a mean over seeds.
    #[must_use]
    pub fn mean_relative_squared_error(&self) -> f64 {
        self.relative_squared_errors.iter().sum::<f64>() / self.relative_squared_errors.len().max(1) as f64
    }

    /// Returns the square of the relative error that the renderer estimates by itself, without a
    /// reference. The result is a mean over the seeds with an estimate; `None` if no seed has one.
    #[must_use]
    pub fn mean_square_of_estimated_error(&self) -> Option<f64> {
        let n = self.squared_estimated_errors.len() as f64;
        (n > 0.0).then(|| self.squared_estimated_errors.iter().sum::<f64>() / n)
    }
}

/// Measured convergence of one rendering method: an algorithm with its settings.
#[derive(Clone, Debug)]
pub struct MethodResult {
    /// Unique label, such as `sppm` or `sppm --gather-k 20`.
    pub label: String,
    /// Rendering algorithm.
    pub algorithm: Algorithm,
    /// Shell command that renders the first seed's picture at the last checkpoint.
    pub render_command: String,
    /// Processor time of preparing the integrator of the first seed, including pilots (small
    /// simulations before the first pass) \[s].
    pub setup_seconds: f64,
    /// Parameter α of the law by which gather radii r shrink (Knaus and Zwicker 2011): for pass
    /// i + 1, r² is (i + α) / (i + 1) times the r² of pass i. With α = 1, radii are fixed.
    pub alpha: f64,
    /// Gather radii of the first pass \[length], in this order: indirect map, caustic map. Each is
    /// the largest radius of its map's density estimates. `None` if the algorithm has no photons.
    pub gather_radii: Option<[f32; 2]>,
    /// Checkpoints after 1, 2, 4, 8 … passes and after the last pass. The second-to-last checkpoint
    /// is left out if the last one has less than 1.3 times as many passes.
    pub checkpoints: Vec<ConvergenceCheckpoint>,
    /// Picture of the first seed at the last checkpoint.
    pub first_seed_picture: Image,
    /// Relative error of each pixel at the last checkpoint, as a root mean square over seeds.
    /// Pixels are in rows from the top.
    pub relative_pixel_errors: Vec<f32>,
    /// Mean over seeds of the pictures at the last checkpoint, minus the reference \[W/(m² sr)].
    pub mean_difference: Image,
}

/// Reference picture against which errors are measured, with its origin and its own error.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Origin of the references, such as `auto: 256 passes of hybrid, twice`.
    pub source: String,
    /// Relative error of `picture`, due to the noise of the two references; `None` for a single
    /// reference, which is taken as exact.
    pub error: Option<f64>,
    /// Mean of the two reference pictures, or the single reference picture.
    pub picture: Image,
}

/// Smallest [`MethodStudyResult::thread_time_share`] at which measured times are reliable.
///
/// A smaller value means that other programs used the processor, or that threads waited.
pub const MIN_THREAD_TIME_SHARE: f64 = 0.9;

/// Measured convergence of all rendering methods that a study compares.
#[derive(Clone, Debug)]
pub struct MethodStudyResult {
    /// Path of the scene file.
    pub scene_path: String,
    /// Shell command that repeats the study.
    pub study_command: String,
    /// Name and version of this program.
    pub program: String,
    /// Description of the processor, and number of threads.
    pub machine: String,
    /// Number of seeds of each method.
    pub seeds: u32,
    /// Time budget of each method: processor time per seed \[s].
    pub max_cpu_seconds_per_seed: f64,
    /// Fraction of the wall time in which the program's threads ran on a processor, from 0 to 1:
    /// processor time / (wall time · threads). The value is the minimum over methods, and 1 if the
    /// system does not report processor time.
    pub thread_time_share: f64,
    /// Reference picture against which errors are measured.
    pub reference: Reference,
    /// Results of each method that the study compares.
    pub methods: Vec<MethodResult>,
    /// True if the study was interrupted before it reached its limits.
    pub interrupted: bool,
}
