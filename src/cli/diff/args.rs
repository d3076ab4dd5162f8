//! Arguments of `caustica diff`: the two pictures, and the error map to write.

use crate::cli::value_parsers::{parse_exposure_stops, parse_fraction, parse_pixels_per_degree, parse_upper_bound};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Quantity that the error map shows: value of `--map`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ErrorMapKind {
    /// FLIP, from 0 to 1
    Flip,
    /// Error divided by √(L² + m²), where L is the mean radiance of the reference around the pixel,
    /// and m the median of L over the pixels with L > 0
    Relative,
    /// Picture A minus picture B, the reference
    Signed,
    /// Absolute difference of the pictures
    Absolute,
}

/// Mode of the FLIP metric: value of `--flip`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FlipMetricModeArgument {
    /// LDR-FLIP: compares display values, clamped as in a PNG
    Ldr,
    /// HDR-FLIP: for each pixel, maximum of LDR-FLIP over a range of exposures
    Hdr,
}

/// Arguments of `diff`.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// Picture to judge: .png, .exr or .hdr
    pub a: PathBuf,

    /// Reference: .png, .exr or .hdr
    pub b: PathBuf,

    /// Write a map of errors: .png or .exr
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Quantity that the map shows
    #[arg(long, value_enum, default_value = "flip", value_name = "KIND")]
    pub map: ErrorMapKind,

    /// Mode of FLIP  [default: ldr for two PNGs, else hdr]
    #[arg(long, value_enum, value_name = "MODE")]
    pub flip: Option<FlipMetricModeArgument>,

    /// Exposure of LDR-FLIP in stops: +1 is twice as bright  [default: 0]
    #[arg(long, value_parser = parse_exposure_stops, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: Option<f32>,

    /// Pixels per degree of the viewer's field of view, for FLIP  [default: 67.02]
    #[arg(long, value_parser = parse_pixels_per_degree, value_name = "N")]
    pub pixels_per_degree: Option<f64>,

    /// Exit with code 4 if the RMSE exceeds this
    #[arg(long, value_parser = parse_upper_bound, value_name = "X")]
    pub max_rmse: Option<f64>,

    /// Exit with code 4 if the relative error exceeds this, such as 2% or 0.02
    #[arg(long, value_parser = parse_fraction, value_name = "X")]
    pub max_relative: Option<f64>,

    /// Exit with code 4 if mean FLIP exceeds this
    #[arg(long, value_parser = parse_upper_bound, value_name = "X")]
    pub max_flip: Option<f64>,

    /// Exit with code 4 if any channel of any pixel differs by more than this
    #[arg(long, value_parser = parse_upper_bound, value_name = "X")]
    pub max_difference: Option<f64>,

    /// Exit with code 4 if any pixel differs at all
    #[arg(long)]
    pub identical: bool,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// Print only the measured differences, errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}
