//! What can be typed after `caustica diff`.

use crate::cli::number::{bound, fraction, pixels_per_degree, stops};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What a map of errors shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MapKind {
    /// FLIP, from 0 to 1
    Flip,
    /// The error relative to the light around
    Relative,
    /// A less B
    Signed,
    /// The absolute difference
    Absolute,
}

/// How FLIP looks at the pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FlipName {
    /// As PNG shows them
    Ldr,
    /// At every exposure that shows something
    Hdr,
}

/// Arguments of `diff`.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// The picture that is judged: .png, .exr or .hdr
    pub a: PathBuf,

    /// The reference: .png, .exr or .hdr
    pub b: PathBuf,

    /// Write a map of errors: .png or .exr
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// What the map shows
    #[arg(long, value_enum, default_value = "flip", value_name = "KIND")]
    pub map: MapKind,

    /// How FLIP looks at the pictures  [default: ldr for two PNGs, else hdr]
    #[arg(long, value_enum, value_name = "MODE")]
    pub flip: Option<FlipName>,

    /// Exposure of LDR-FLIP in stops: +1 is twice as bright  [default: 0]
    #[arg(long, value_parser = stops, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: Option<f32>,

    /// Pixels in a degree of the viewer's field, for FLIP  [default: 67.02]
    #[arg(long, value_parser = pixels_per_degree, value_name = "N")]
    pub pixels_per_degree: Option<f64>,

    /// End with code 4 where the RMSE is more than this
    #[arg(long, value_parser = bound, value_name = "X")]
    pub max_rmse: Option<f64>,

    /// End with code 4 where the relative error is more than this, such as 2% or 0.02
    #[arg(long, value_parser = fraction, value_name = "X")]
    pub max_relative: Option<f64>,

    /// End with code 4 where mean FLIP is more than this
    #[arg(long, value_parser = bound, value_name = "X")]
    pub max_flip: Option<f64>,

    /// End with code 4 where a channel of a pixel differs by more than this
    #[arg(long, value_parser = bound, value_name = "X")]
    pub max_difference: Option<f64>,

    /// End with code 4 where a pixel differs at all
    #[arg(long)]
    pub identical: bool,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Say nothing but the figures, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}
