//! Result of `caustica diff` as a table and as JSON.
//!
//! `docs/guide/command-line.md` describes each field.

use super::error_map::ColorScale;
use crate::image::metrics::LargestDifference;
use crate::study::text::three_digit_text;
use serde::Serialize;
use std::fmt::Write;

/// Constant ε in the denominator b² + ε of the relative MSE, where b is the reference; see
/// [`relative_mse`](crate::image::metrics::relative_mse).
pub(super) const RELATIVE_MSE_EPSILON: f64 = 0.01;

/// Result of `caustica diff`: how the picture `a` differs from the reference `b`.
#[derive(Debug, Serialize)]
pub(super) struct DiffReport {
    pub schema: u32,
    pub version: &'static str,
    pub a: String,
    pub b: String,
    pub width: u32,
    pub height: u32,
    pub mean: MeanRadiances,
    pub rmse: f64,
    pub relative_mse: f64,
    pub relative_error: f64,
    pub flip: FlipReport,
    pub largest: LargestDifferences,
    pub differing_pixels: usize,
    /// Description of the written error map; `None` without `--output`, or if writing failed.
    pub map: Option<ErrorMapReport>,
    /// Names of the flags whose limits the differences exceed, such as `max-rmse`.
    pub exceeded: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
pub(super) struct MeanRadiances {
    pub a: f64,
    pub b: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct FlipReport {
    pub mode: &'static str,
    /// Exposure of LDR-FLIP in stops; `None` for HDR-FLIP.
    pub exposure: Option<f32>,
    pub pixels_per_degree: f64,
    pub mean: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct LargestDifferences {
    pub red: Option<LargestDifference>,
    pub green: Option<LargestDifference>,
    pub blue: Option<LargestDifference>,
}

#[derive(Debug, Serialize)]
pub(super) struct ErrorMapReport {
    pub file: String,
    pub kind: &'static str,
    /// Errors that the first and last colours of a PNG map show; `None` for an OpenEXR map, whose
    /// pixels are the errors themselves.
    #[serde(rename = "colors")]
    pub color_scale: Option<ColorScale>,
}

impl DiffReport {
    /// Returns the largest absolute difference over all pixels and channels.
    pub fn largest_difference(&self) -> f64 {
        let LargestDifferences { red, green, blue } = &self.largest;
        [red, green, blue].into_iter().flatten().map(|l| l.difference).fold(0.0, f64::max)
    }

    pub fn text_table(&self) -> String {
        let pixels = u64::from(self.width) * u64::from(self.height);
        let mut text = format!("{} against {}, {} × {} pixels\n", self.a, self.b, self.width, self.height);
        let mut row = |name: &str, value: String, about: String| {
            let line = format!("  {name:<20} {value:>10}  {about}");
            let _ = writeln!(text, "{}", line.trim_end());
        };
        row(
            "mean radiance",
            three_digit_text(self.mean.a),
            format!("of the reference {}", three_digit_text(self.mean.b)),
        );
        row("RMSE", three_digit_text(self.rmse), String::new());
        row("relative MSE", three_digit_text(self.relative_mse), format!("with ε = {RELATIVE_MSE_EPSILON}"));
        row(
            "relative error",
            percent_text(self.relative_error),
            "of the mean luminance of the neighbourhood".to_owned(),
        );
        let mode = match self.flip.exposure {
            Some(stops) => format!("LDR at {stops} stops"),
            None => "HDR".to_owned(),
        };
        row(
            "FLIP",
            three_digit_text(self.flip.mean),
            format!("{mode}, {:.2} pixels per degree", self.flip.pixels_per_degree),
        );
        let LargestDifferences { red, green, blue } = &self.largest;
        for (name, largest) in [("red", red), ("green", green), ("blue", blue)] {
            let (value, position) = match largest {
                Some(LargestDifference { difference, x, y }) => {
                    (three_digit_text(*difference), format!("in column {x}, row {y}"))
                }
                None => (three_digit_text(0.0), String::new()),
            };
            row(&format!("largest in {name}"), value, position);
        }
        let share = percent_text(self.differing_pixels as f64 / pixels as f64);
        row("pixels that differ", self.differing_pixels.to_string(), share);
        text
    }
}

fn percent_text(fraction: f64) -> String {
    format!("{} %", three_digit_text(100.0 * fraction))
}
