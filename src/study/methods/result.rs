//! Results of a study of methods.

use crate::image::Image;
use crate::integrate::Algorithm;
use serde::Serialize;

/// Measurements of a method after some passes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checkpoint {
    /// Passes made.
    pub passes: u32,
    /// Processor time of the passes so far, mean over seeds, without setup \[s].
    pub seconds: f64,
    /// Wall time of the passes so far, mean over seeds \[s].
    pub wall: f64,
    /// Rays of every kind so far, mean over seeds.
    pub rays: f64,
    /// Photon paths so far, mean over seeds.
    pub photons: f64,
    /// Relative squared error of each seed's picture (see
    /// [`RelativeScale`](crate::image::RelativeScale)). It is unbiased by the noise of the
    /// references, so it may be negative.
    pub squares: Vec<f64>,
    /// Relative variance between seeds.
    pub noise2: f64,
    /// Part of each seed in `noise2`: squared difference to the mean over S seeds, times S/(S − 1).
    /// Their mean is `noise2`; empty with one seed.
    pub noises: Vec<f64>,
    /// Relative squared bias; unbiased itself, so it may be negative.
    pub bias2: f64,
    /// Relative squared error that the error estimate of each seed reports.
    pub estimated: Vec<f64>,
    /// Root of the mean squared difference to the truth over pixels, channels and seeds \[W/(m²
    /// sr)].
    pub rmse: f64,
    /// FLIP of the first seed's picture to the truth, in \[0, 1].
    pub flip: f64,
}

impl Checkpoint {
    /// Relative squared error, mean over seeds.
    #[must_use]
    pub fn mean_squared_error(&self) -> f64 {
        self.squares.iter().sum::<f64>() / self.squares.len().max(1) as f64
    }
}

/// Results of one method.
#[derive(Clone, Debug)]
pub struct MethodResult {
    /// Unique label, such as `sppm` or `sppm --gather-k 20`.
    pub label: String,
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Command that renders the last picture of the first seed.
    pub command: String,
    /// Setup time of the first seed, with pilots \[s].
    pub setup: f64,
    /// Exponent α of the radius law [`shrink`](crate::integrate::shrink); 1 for fixed radii.
    pub alpha: f64,
    /// Largest gather radii of the first pass, of the global and of the caustic map; `None` without
    /// photons \[length].
    pub radii: Option<[f32; 2]>,
    /// Checkpoints by passes; each has twice the passes of the previous one, except the last.
    pub checkpoints: Vec<Checkpoint>,
    /// The last picture of the first seed.
    pub picture: Image,
    /// Relative error of each pixel of the last pictures: root of the mean square over seeds.
    pub error: Vec<f32>,
    /// Mean over seeds of the last pictures, less the truth.
    pub difference: Image,
}

/// Reference picture.
#[derive(Clone, Debug)]
pub struct GroundTruth {
    /// Origin, such as `auto: 256 passes of hybrid, twice`.
    pub source: String,
    /// Relative error of the mean of both references from their noise; `None` if taken as exact.
    pub error: Option<f64>,
    /// Mean of both references.
    pub picture: Image,
}

/// Results of a study of methods.
#[derive(Clone, Debug)]
pub struct MethodStudyResult {
    /// Path of the scene file.
    pub scene: String,
    /// The command that repeats the study.
    pub command: String,
    /// Program and version.
    pub program: String,
    /// Processor and threads.
    pub machine: String,
    /// Seeds of each method.
    pub seeds: u32,
    /// Limit of processor time per seed \[s].
    pub budget: f64,
    /// Smallest fraction of the threads' time that the processor gave to this program; below 0.9
    /// other programs disturbed.
    pub share: f64,
    /// Reference picture.
    pub truth: GroundTruth,
    /// Results by method.
    pub methods: Vec<MethodResult>,
    /// True if the study ended early.
    pub interrupted: bool,
}
