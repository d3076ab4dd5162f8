//! `caustica diff`: measures the difference of two pictures and draws error maps.

mod args;
mod error_map;
mod report;

pub use args::{DiffArguments, ErrorMapKind, FlipMetricModeArgument};

use super::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use super::progress::{ProgressDisplay, print_message};
use super::{CommandFailure, Exit};
use crate::image::flip::{DEFAULT_PIXELS_PER_DEGREE, FlipMetricMode, FlipMetricOptions, FlipMetricResult, flip_metric};
use crate::image::metrics::{MetricError, PixelDifferences, largest_differences, relative_error, relative_mse, rmse};
use crate::image::{self, Image, InputFormat, OutputFormat, WriteOptions};
use crate::study::text::three_digit_text;
use miette::IntoDiagnostic;
use report::{DiffReport, ErrorMapReport, FlipReport, LargestDifferences, MeanRadiances, RELATIVE_MSE_EPSILON};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Error: two pictures cannot be compared.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum IncomparablePicturesError {
    #[error("`{}` has {} × {} pixels, but `{}` has {} × {}", a.0.display(), a.1.0, a.1.1, b.0.display(), b.1.0, b.1.1)]
    #[diagnostic(help("render both with the same --size"))]
    SizeMismatch { a: (PathBuf, (u32, u32)), b: (PathBuf, (u32, u32)) },
    #[error("`{}` has a pixel that is not finite, in column {x}, row {y}", path.display())]
    #[diagnostic(help("render the picture again, or repair the pixel"))]
    NonFinite { path: PathBuf, x: u32, y: u32 },
    #[error("the pictures cannot be compared: {0}")]
    #[diagnostic(help("choose a number within the range"))]
    Other(MetricError),
}

/// Usage error: `--exposure` is given with HDR-FLIP, which chooses exposures itself.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--exposure applies to LDR-FLIP only: HDR-FLIP derives its exposures from the reference")]
#[diagnostic(help("add --flip ldr, or leave out --exposure"))]
struct ExposureWithHdrFlipError;

pub(super) fn run(arguments: &DiffArguments) -> Result<Exit, CommandFailure> {
    if let Some(path) = &arguments.output {
        image::check_writable(path).map_err(CommandFailure::output_error)?;
        let inputs = [FileWithRole::new("the picture", &arguments.a), FileWithRole::new("the reference", &arguments.b)];
        check_distinct_files(&[FileWithRole::new("-o", path)], &inputs)?;
    }
    let read =
        |path| image::read_and_detect_format(path).into_diagnostic().map_err(|e| CommandFailure::new(Exit::Input, e));
    let (a, a_format) = read(&arguments.a)?;
    let (b, b_format) = read(&arguments.b)?;
    let mode = selected_flip_mode(arguments, a_format == InputFormat::Png && b_format == InputFormat::Png)?;
    let (mut report, flip) =
        compare_pictures(arguments, &a, &b, mode).map_err(|error| comparison_failure(arguments, error))?;
    let exceeded = exceeded_limits(arguments, &report);
    report.exceeded = exceeded.iter().map(|(flag, _)| *flag).collect();
    let mut failures = OutputFailures::default();
    if let Some(path) = &arguments.output {
        report.map = failures.ok_or_collect_report(write_error_map(path, arguments.map, &a, &b, &flip));
    }
    let text = if arguments.json {
        serde_json::to_string_pretty(&report).map_err(CommandFailure::output_error)? + "\n"
    } else {
        report.text_table()
    };
    failures.ok_or_collect_error(std::io::stdout().write_all(text.as_bytes()));
    if let Some(map) = &report.map {
        let colors = map.color_scale.map_or(String::new(), |c| {
            format!(
                ", colours from {} to {}",
                three_digit_text(c.first_color_error),
                three_digit_text(c.last_color_error)
            )
        });
        ProgressDisplay::new(arguments.quiet).print_line(&format!("wrote {}: {}{colors}", map.file, map.kind));
    }
    exceeded.iter().for_each(|(flag, why)| print_message(&format!("--{flag}: {why}")));
    failures.into_result(if exceeded.is_empty() { Exit::Success } else { Exit::Differ })
}

/// Returns the FLIP mode that `--flip` selects.
///
/// Without `--flip`, the mode is LDR if both pictures are PNG files (`both_are_png`), because these
/// hold display values. Else the mode is HDR.
fn selected_flip_mode(arguments: &DiffArguments, both_are_png: bool) -> Result<FlipMetricMode, CommandFailure> {
    match (arguments.flip, arguments.exposure) {
        (Some(FlipMetricModeArgument::Ldr), stops) => Ok(FlipMetricMode::Ldr(stops.unwrap_or(0.0))),
        (None, stops) if both_are_png => Ok(FlipMetricMode::Ldr(stops.unwrap_or(0.0))),
        (_, None) => Ok(FlipMetricMode::Hdr),
        (_, Some(_)) => Err(CommandFailure::usage_error(ExposureWithHdrFlipError)),
    }
}

fn compare_pictures(
    arguments: &DiffArguments,
    a: &Image,
    b: &Image,
    mode: FlipMetricMode,
) -> Result<(DiffReport, FlipMetricResult), MetricError> {
    let PixelDifferences { largest: [red, green, blue], differing_pixel_count: pixels } = largest_differences(a, b)?;
    let options =
        FlipMetricOptions { pixels_per_degree: arguments.pixels_per_degree.unwrap_or(DEFAULT_PIXELS_PER_DEGREE), mode };
    let flip = flip_metric(b, a, &options)?;
    let (name, exposure) = match mode {
        FlipMetricMode::Ldr(stops) => ("ldr", Some(stops)),
        FlipMetricMode::Hdr => ("hdr", None),
    };
    let report = DiffReport {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        a: arguments.a.display().to_string(),
        b: arguments.b.display().to_string(),
        width: a.width(),
        height: a.height(),
        mean: MeanRadiances { a: mean_channel_value(a), b: mean_channel_value(b) },
        rmse: rmse(a, b)?,
        relative_mse: relative_mse(a, b, RELATIVE_MSE_EPSILON, None)?,
        relative_error: relative_error(a, b)?,
        flip: FlipReport { mode: name, exposure, pixels_per_degree: options.pixels_per_degree, mean: flip.mean },
        largest: LargestDifferences { red, green, blue },
        differing_pixels: pixels,
        map: None,
        exceeded: Vec::new(),
    };
    Ok((report, flip))
}

/// Returns the mean of a picture's values over all pixels and channels.
fn mean_channel_value(image: &Image) -> f64 {
    let sum: f64 = image.pixels().iter().map(|p| p.as_dvec3().element_sum()).sum();
    sum / (3.0 * image.pixels().len() as f64)
}

fn comparison_failure(arguments: &DiffArguments, error: MetricError) -> CommandFailure {
    let (a, b) = (&arguments.a, &arguments.b);
    let report = match error {
        MetricError::SizeMismatch { a: first, b: second } => {
            IncomparablePicturesError::SizeMismatch { a: (a.clone(), first), b: (b.clone(), second) }
        }
        MetricError::NonFinite { which, x, y } => {
            let path = if which == "first" { a } else { b };
            IncomparablePicturesError::NonFinite { path: path.clone(), x, y }
        }
        MetricError::OptionOutOfRange { .. } => {
            return CommandFailure::usage_error(IncomparablePicturesError::Other(error));
        }
    };
    CommandFailure::new(Exit::Input, report)
}

/// Returns the flags whose limits the measured differences exceed, such as `max-rmse`. Each flag
/// has an explanation such as "an RMSE of 0.2 is more than 0.1".
fn exceeded_limits(arguments: &DiffArguments, report: &DiffReport) -> Vec<(&'static str, String)> {
    let limits = [
        ("max-rmse", "an RMSE", report.rmse, arguments.max_rmse),
        ("max-relative", "a relative error", report.relative_error, arguments.max_relative),
        ("max-flip", "a mean FLIP", report.flip.mean, arguments.max_flip),
        ("max-difference", "a difference", report.largest_difference(), arguments.max_difference),
    ];
    let mut exceeded: Vec<(&'static str, String)> = limits
        .into_iter()
        .filter_map(|(flag, name, found, limit)| {
            let limit = limit.filter(|limit| found > *limit)?;
            Some((flag, format!("{name} of {found} is more than {limit}")))
        })
        .collect();
    if arguments.identical && report.differing_pixels > 0 {
        exceeded.push(("identical", format!("{} pixels differ", report.differing_pixels)));
    }
    exceeded
}

/// Writes the error map of `kind` to `path`, the file of `--output`. Returns a description of the
/// map for the report.
fn write_error_map(
    path: &Path,
    kind: ErrorMapKind,
    a: &Image,
    b: &Image,
    flip: &FlipMetricResult,
) -> miette::Result<ErrorMapReport> {
    let format = OutputFormat::from_path(path).into_diagnostic()?;
    let (pixels, colors) = error_map::error_map(kind, a, b, &flip.error_map, format);
    let picture = Image::from_pixels(a.width(), a.height(), pixels).into_diagnostic()?;
    let name = match kind {
        ErrorMapKind::Flip => "flip",
        ErrorMapKind::Relative => "relative",
        ErrorMapKind::Signed => "signed",
        ErrorMapKind::Absolute => "absolute",
    };
    let mut metadata = vec![("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")))];
    metadata.push(("Map".to_owned(), name.to_owned()));
    if let Some(c) = colors {
        metadata.push(("Colors".to_owned(), format!("from {} to {}", c.first_color_error, c.last_color_error)));
    }
    image::write(path, &picture, &WriteOptions { metadata, ..WriteOptions::default() }).into_diagnostic()?;
    Ok(ErrorMapReport { file: path.display().to_string(), kind: name, color_scale: colors })
}
