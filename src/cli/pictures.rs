//! Flags and messages of the pictures that a command writes.

use super::outputs::OutputFailures;
use super::progress::{ProgressDisplay, print_message};
use super::value_parsers::{count_with_noun, parse_exposure_stops};
use crate::image::{
    self, BitDepth, ClippedPixelReport, ExrPrecision, Image, OutputFormat, ToneCurve, ToneMap, WriteOptions,
};
use crate::integrate::Algorithm;
use clap::Args;
use std::path::{Path, PathBuf};

/// Flags for writing picture files: tone curve, exposure and bits per channel.
#[derive(Clone, Debug, Args)]
pub struct PictureArguments {
    /// Tone curve of PNG: srgb, filmic or course (linear: bytes are proportional to
    /// radiance)  [default: srgb; course for raycast]
    #[arg(long, value_name = "NAME")]
    pub tone: Option<ToneCurve>,

    /// Exposure of PNG in stops: +1 is twice as bright
    #[arg(long, default_value = "0", value_parser = parse_exposure_stops, allow_negative_numbers = true, value_name = "STOPS")]
    pub exposure: f32,

    /// Bits per channel of PNG: 8 or 16
    #[arg(long, default_value = "8", value_parser = parse_png_depth, value_name = "BITS")]
    pub png_bits: BitDepth,

    /// Bits per channel of OpenEXR: 16 (largest value 65504) or 32
    #[arg(long, default_value = "32", value_parser = parse_exr_depth, value_name = "BITS")]
    pub exr_bits: ExrPrecision,
}

impl PictureArguments {
    /// Returns the options for writing picture files. `curve` is the tone curve that is used
    /// without `--tone`.
    pub(super) fn write_options(&self, curve: ToneCurve) -> WriteOptions {
        WriteOptions {
            tone: ToneMap { curve: self.tone.unwrap_or(curve), exposure_stops: self.exposure },
            bit_depth: self.png_bits,
            exr_precision: self.exr_bits,
            metadata: vec![("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")))],
        }
    }
}

/// Returns the default tone curve for pictures that `algorithm` renders.
pub(super) fn default_tone_curve(algorithm: Algorithm) -> ToneCurve {
    match algorithm {
        Algorithm::Raycast => ToneCurve::Legacy,
        Algorithm::Hybrid
        | Algorithm::Path
        | Algorithm::Sppm
        | Algorithm::Ppm
        | Algorithm::Pm
        | Algorithm::Distributed
        | Algorithm::Whitted => ToneCurve::Srgb,
    }
}

/// Returns the flags that reproduce `arguments`. Leaves out default values.
pub(super) fn picture_flags(arguments: &PictureArguments) -> Vec<String> {
    let mut flags = Vec::new();
    if let Some(tone) = arguments.tone {
        flags.extend(["--tone".to_owned(), tone.to_string()]);
    }
    if arguments.exposure != 0.0 {
        flags.push(format!("--exposure={}", arguments.exposure));
    }
    match arguments.png_bits {
        BitDepth::Eight => {}
        BitDepth::Sixteen => flags.extend(["--png-bits", "16"].map(str::to_owned)),
    }
    match arguments.exr_bits {
        ExrPrecision::Half => flags.extend(["--exr-bits", "16"].map(str::to_owned)),
        ExrPrecision::Single => {}
    }
    flags
}

/// Writes `picture` to each of `paths`. Prints which files were written, and warns of pixels whose
/// values a file cannot store. Collects errors in `failures`.
pub(super) fn write_pictures<'a>(
    paths: impl Iterator<Item = &'a PathBuf>,
    picture: &Image,
    options: &WriteOptions,
    progress: &ProgressDisplay,
    failures: &mut OutputFailures,
) {
    for path in paths {
        if let Some(written) = failures.ok_or_collect_error(image::write(path, picture, options)) {
            progress.print_line(&format!("wrote {}", path.display()));
            warn_of_clipped_pixels(&written, path, options.tone.exposure_stops, progress);
        }
    }
}

/// Prints warnings of pixels whose values the file format cannot store. `exposure` is the exposure
/// of the written file \[stops].
fn warn_of_clipped_pixels(written: &ClippedPixelReport, path: &Path, exposure: f32, progress: &ProgressDisplay) {
    let pixels = |n: usize| format!("{} of {}", count_with_noun(n, "pixel", "pixels"), path.display());
    if written.non_finite > 0 {
        print_message(&format!("warning: {}: not finite", pixels(written.non_finite)));
    }
    match (written.too_bright, OutputFormat::from_path(path)) {
        (0, _) => {}
        // Clipping in an OpenEXR file gives a warning, because readers of such files expect
        // unclipped radiance.
        (n, Ok(OutputFormat::Exr)) => {
            print_message(&format!("warning: {}: clipped to 65504; --exr-bits 32 holds larger values", pixels(n)));
        }
        (n, Ok(OutputFormat::Png) | Err(_)) => {
            let darker = exposure - 1.0;
            let remedy = format!("--exposure {darker} or --tone filmic shows more, an .exr file holds all");
            progress.print_line(&format!("note: {}: clipped to white; {remedy}", pixels(n)));
        }
    }
    if written.negative > 0 {
        progress.print_line(&format!("note: {}: negative, clipped to black", pixels(written.negative)));
    }
}

fn parse_png_depth(text: &str) -> Result<BitDepth, String> {
    match text {
        "8" => Ok(BitDepth::Eight),
        "16" => Ok(BitDepth::Sixteen),
        _ => Err(format!("`{text}` is not a bit depth of PNG: write 8 or 16")),
    }
}

fn parse_exr_depth(text: &str) -> Result<ExrPrecision, String> {
    match text {
        "16" => Ok(ExrPrecision::Half),
        "32" => Ok(ExrPrecision::Single),
        _ => Err(format!("`{text}` is not a bit depth of OpenEXR: write 16 or 32")),
    }
}
