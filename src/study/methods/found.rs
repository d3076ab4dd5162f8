//! What a study of methods found.

use crate::image::Image;
use crate::integrate::Algorithm;
use serde::Serialize;

/// A method as it stood after some passes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checkpoint {
    /// Passes made.
    pub passes: u32,
    /// Processor time of the passes so far, mean over seeds, without preparation \[s].
    pub seconds: f64,
    /// Wall time of the same \[s].
    pub wall: f64,
    /// Rays of every kind so far, mean over seeds.
    pub rays: f64,
    /// Photon paths so far.
    pub photons: f64,
    /// Relative squared error of each seed's picture (see [`RelativeScale`](crate::image::RelativeScale)). It is free of the noise of the
    /// references, so that it can be below zero where the error is far less than theirs.
    pub squares: Vec<f64>,
    /// Relative variance between seeds.
    pub noise2: f64,
    /// Each seed's part of it: the relative squared difference of its picture to the mean over S seeds, times S/(S − 1). Their mean is
    /// `noise2`; empty with one seed.
    pub noises: Vec<f64>,
    /// Relative squared error of the mean of infinitely many seeds, without bias; it can be below zero where noise hides it.
    pub bias2: f64,
    /// What the gauge of each seed's render says its relative squared error is.
    pub gauged: Vec<f64>,
    /// Root of the mean squared difference to the truth over pixels, channels and seeds \[W/(m² sr)].
    pub rmse: f64,
    /// FLIP of the first seed's picture to the truth, in \[0, 1].
    pub flip: f64,
}

impl Checkpoint {
    /// Relative squared error, mean over seeds.
    #[must_use]
    pub fn square(&self) -> f64 {
        self.squares.iter().sum::<f64>() / self.squares.len().max(1) as f64
    }
}

/// A method with its settings.
#[derive(Clone, Debug)]
pub struct MethodFound {
    /// What tells it from the others, such as `sppm` or `sppm --gather-k 20`.
    pub label: String,
    /// The algorithm.
    pub algorithm: Algorithm,
    /// The command that renders its last picture of the first seed.
    pub command: String,
    /// Preparation, pilots included, of the first seed \[s].
    pub setup: f64,
    /// How fast radii shrink: α of [`shrink`](crate::integrate::shrink), 1 where they stay.
    pub alpha: f64,
    /// Largest gather radii of the first pass, of the global and of the caustic map; `None` without photons \[length].
    pub radii: Option<[f32; 2]>,
    /// From few passes to many; each has twice the passes of the last, but for the final one.
    pub checkpoints: Vec<Checkpoint>,
    /// The last picture of the first seed.
    pub picture: Image,
    /// Root of the squared relative error of each pixel of the last pictures, mean over seeds.
    pub error: Vec<f32>,
    /// Mean over seeds of the last pictures less the truth.
    pub difference: Image,
}

/// What errors are held against.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Where it is from, such as `auto: 256 passes of hybrid, twice`.
    pub source: String,
    /// Relative error of the mean of the two references, as far as it is known.
    pub error: Option<f64>,
    /// Their mean.
    pub picture: Image,
}

/// The result of a study of methods.
#[derive(Clone, Debug)]
pub struct MethodsFound {
    /// The scene's file.
    pub scene: String,
    /// The command that repeats the study.
    pub command: String,
    /// Program and version.
    pub program: String,
    /// Processor and threads.
    pub machine: String,
    /// Seeds of each method.
    pub seeds: u32,
    /// Most processor time of a seed \[s].
    pub budget: f64,
    /// Least part of the threads' time that the processor gave to this program; below .9 others disturbed.
    pub share: f64,
    /// What errors are held against.
    pub truth: Truth,
    /// The methods.
    pub methods: Vec<MethodFound>,
    /// Whether it ended early.
    pub interrupted: bool,
}
