//! `caustica diff`.

mod args;
mod map;
mod report;

pub use args::{DiffArguments, FlipName, MapKind};

use super::progress::{Progress, tell};
use super::{Exit, Failure};
use crate::image::flip::{Flip, FlipMode, FlipOptions, PIXELS_PER_DEGREE, flip};
use crate::image::metrics::{Differences, MetricError, differences, relative_error, relative_mse, rmse};
use crate::image::{self, Image, InputFormat, OutputFormat, WriteOptions};
use crate::study::text::figure;
use miette::IntoDiagnostic;
use report::{EPSILON, FlipReport, LargestReport, MapReport, Means, Report};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Why two pictures are not compared.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum Incomparable {
    #[error("`{}` has {} × {} pixels, but `{}` has {} × {}", a.0.display(), a.1.0, a.1.1, b.0.display(), b.1.0, b.1.1)]
    #[diagnostic(help("render both with the same --size"))]
    Size { a: (PathBuf, (u32, u32)), b: (PathBuf, (u32, u32)) },
    #[error("`{}` has a pixel that is not finite, in column {x}, row {y}", path.display())]
    #[diagnostic(help("no mean can weigh it: render the picture again, or repair the pixel"))]
    NonFinite { path: PathBuf, x: u32, y: u32 },
    #[error("the pictures cannot be compared: {0}")]
    #[diagnostic(help("choose a number within range"))]
    Other(MetricError),
}

/// An exposure for HDR-FLIP, which has its own.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--exposure is for LDR-FLIP: HDR-FLIP finds its exposures in the reference")]
#[diagnostic(help("add --flip ldr, or leave out --exposure"))]
struct NeedlessExposure;

pub(super) fn run(arguments: &DiffArguments) -> Result<Exit, Failure> {
    let output = |e| Failure::new(Exit::Output, e);
    if let Some(path) = &arguments.output {
        image::check_writable(path).into_diagnostic().map_err(output)?;
    }
    let read = |path| image::read_with_format(path).into_diagnostic().map_err(|e| Failure::new(Exit::Input, e));
    let (a, a_format) = read(&arguments.a)?;
    let (b, b_format) = read(&arguments.b)?;
    let mode = mode(arguments, a_format == InputFormat::Png && b_format == InputFormat::Png)?;
    let (mut report, seen) = compare(arguments, &a, &b, mode).map_err(|error| incomparable(arguments, error))?;
    let complaints = complaints(arguments, &report);
    report.exceeded = complaints.iter().map(|(flag, _)| *flag).collect();
    if let Some(path) = &arguments.output {
        report.map = Some(draw(path, arguments.map, &a, &b, &seen).map_err(output)?);
    }
    let told = if arguments.json {
        serde_json::to_string_pretty(&report).into_diagnostic().map_err(output)? + "\n"
    } else {
        report.table()
    };
    std::io::stdout().write_all(told.as_bytes()).into_diagnostic().map_err(output)?;
    if let Some(map) = &report.map {
        let colors =
            map.colors.map_or(String::new(), |c| format!(", colours from {} to {}", figure(c.from), figure(c.to)));
        Progress::new(arguments.quiet).say(&format!("wrote {}: {}{colors}", map.file, map.kind));
    }
    complaints.iter().for_each(|(flag, why)| tell(&format!("--{flag}: {why}")));
    Ok(if complaints.is_empty() { Exit::Success } else { Exit::Differ })
}

/// How FLIP looks at the pictures: what is meant for a screen as it stands, radiance at every exposure.
fn mode(arguments: &DiffArguments, displayed: bool) -> Result<FlipMode, Failure> {
    match (arguments.flip, arguments.exposure) {
        (Some(FlipName::Ldr), stops) => Ok(FlipMode::Ldr(stops.unwrap_or(0.0))),
        (None, stops) if displayed => Ok(FlipMode::Ldr(stops.unwrap_or(0.0))),
        (_, None) => Ok(FlipMode::Hdr),
        (_, Some(_)) => Err(Failure::new(Exit::Usage, NeedlessExposure)),
    }
}

fn compare(arguments: &DiffArguments, a: &Image, b: &Image, mode: FlipMode) -> Result<(Report, Flip), MetricError> {
    let Differences { largest: [red, green, blue], pixels } = differences(a, b)?;
    let options = FlipOptions { pixels_per_degree: arguments.pixels_per_degree.unwrap_or(PIXELS_PER_DEGREE), mode };
    let seen = flip(b, a, &options)?;
    let (name, exposure) = match mode {
        FlipMode::Ldr(stops) => ("ldr", Some(stops)),
        FlipMode::Hdr => ("hdr", None),
    };
    let report = Report {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        a: arguments.a.display().to_string(),
        b: arguments.b.display().to_string(),
        width: a.width(),
        height: a.height(),
        mean: Means { a: mean(a), b: mean(b) },
        rmse: rmse(a, b)?,
        relative_mse: relative_mse(a, b, EPSILON, None)?,
        relative_error: relative_error(a, b)?,
        flip: FlipReport { mode: name, exposure, pixels_per_degree: options.pixels_per_degree, mean: seen.mean },
        largest: LargestReport { red, green, blue },
        differing_pixels: pixels,
        map: None,
        exceeded: Vec::new(),
    };
    Ok((report, seen))
}

/// Over pixels and channels.
fn mean(image: &Image) -> f64 {
    let sum: f64 = image.pixels().iter().map(|p| p.as_dvec3().element_sum()).sum();
    sum / (3.0 * image.pixels().len() as f64)
}

fn incomparable(arguments: &DiffArguments, error: MetricError) -> Failure {
    let (a, b) = (&arguments.a, &arguments.b);
    let told = match error {
        MetricError::Size { a: first, b: second } => {
            Incomparable::Size { a: (a.clone(), first), b: (b.clone(), second) }
        }
        MetricError::NonFinite { which, x, y } => {
            let path = if which == "first" { a } else { b };
            Incomparable::NonFinite { path: path.clone(), x, y }
        }
        MetricError::Parameter { .. } => return Failure::new(Exit::Usage, Incomparable::Other(error)),
    };
    Failure::new(Exit::Input, told)
}

/// The flags whose bound is exceeded, and by what.
fn complaints(arguments: &DiffArguments, report: &Report) -> Vec<(&'static str, String)> {
    let bounds = [
        ("max-rmse", "an RMSE", report.rmse, arguments.max_rmse),
        ("max-relative", "a relative error", report.relative_error, arguments.max_relative),
        ("max-flip", "a mean FLIP", report.flip.mean, arguments.max_flip),
        ("max-difference", "a difference", report.largest(), arguments.max_difference),
    ];
    let mut complaints: Vec<(&'static str, String)> = bounds
        .into_iter()
        .filter_map(|(flag, name, found, bound)| {
            let bound = bound.filter(|b| found > *b)?;
            Some((flag, format!("{name} of {found} is more than {bound}")))
        })
        .collect();
    if arguments.identical && report.differing_pixels > 0 {
        complaints.push(("identical", format!("{} pixels differ", report.differing_pixels)));
    }
    complaints
}

/// Writes the map.
fn draw(path: &Path, kind: MapKind, a: &Image, b: &Image, seen: &Flip) -> miette::Result<MapReport> {
    let format = OutputFormat::from_path(path).into_diagnostic()?;
    let (pixels, colors) = map::map(kind, a, b, &seen.map, format);
    let picture = Image::from_pixels(a.width(), a.height(), pixels).into_diagnostic()?;
    let name = match kind {
        MapKind::Flip => "flip",
        MapKind::Relative => "relative",
        MapKind::Signed => "signed",
        MapKind::Absolute => "absolute",
    };
    let mut metadata = vec![("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")))];
    metadata.push(("Map".to_owned(), name.to_owned()));
    if let Some(c) = colors {
        metadata.push(("Colors".to_owned(), format!("from {} to {}", c.from, c.to)));
    }
    image::write(path, &picture, &WriteOptions { metadata, ..WriteOptions::default() }).into_diagnostic()?;
    Ok(MapReport { file: path.display().to_string(), kind: name, colors })
}
