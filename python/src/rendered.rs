//! Results of renders: picture, layers and estimated error.

use crate::errors::write_exception;
use caustica::image::{
    BitDepth, ExrLayer, ExrPrecision, ToneCurve, ToneMap, UnknownToneCurve, WriteOptions, write_layers,
};
use caustica::integrate::SurfaceAovs;
use caustica::render::error_estimate::{Confidence, ErrorForecast, StopForecast};
use caustica::render::{EndReason, RenderResult, picture_layers, surface_layers};
use caustica::{ErrorEstimate, Image, write_image};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use std::path::PathBuf;

/// Name of a channel, and its f32 values as bytes.
type Channel<'py> = (String, Bound<'py, PyByteArray>);

/// Least, median and greatest number of passes, and the bias that no number of passes removes.
type StopTuple = (Option<u32>, Option<u32>, Option<u32>, Option<f64>);

/// Result of a render.
#[pyclass(frozen)]
pub struct NativeResult {
    rendered: RenderResult,
    /// Albedo, normal and the like; `None` if they are not wanted.
    aovs: Option<SurfaceAovs>,
    /// Tone curve of PNG files if none is given.
    default_tone: ToneCurve,
    /// Confidence of the interval of the estimated error if none is given.
    confidence: Confidence,
}

/// Forecast of the error after more passes.
#[pyclass(frozen)]
pub struct NativeForecast {
    forecast: ErrorForecast,
}

/// Estimated error for Python: passes, then error, low, high, noise, bias, blur, shared-path error
/// and clamping, then the confidence of the interval, then the forecast.
pub type EstimateTuple = (u32, [f64; 8], f64, NativeForecast);

/// Returns the values of an error estimate for Python.
pub fn estimate_tuple(e: &ErrorEstimate, forecast: ErrorForecast, confidence: Confidence) -> EstimateTuple {
    let values = [e.error, e.low, e.high, e.noise, e.bias, e.blur, e.shared_paths, e.clamping];
    (e.passes, values, confidence.probability(), NativeForecast { forecast })
}

/// Returns the confidence of probability `probability`, or a `ValueError`.
pub fn confidence_from_probability(probability: f64) -> PyResult<Confidence> {
    let message = || PyValueError::new_err(format!("a confidence of {probability}: give a number between 0 and 1"));
    Confidence::new(probability).ok_or_else(message)
}

impl NativeResult {
    /// Makes the result of a render whose error interval has `confidence`.
    pub fn new(
        rendered: RenderResult,
        aovs: Option<SurfaceAovs>,
        default_tone: ToneCurve,
        confidence: Confidence,
    ) -> Self {
        Self { rendered, aovs, default_tone, confidence }
    }

    /// Returns all layers, as `--aov` writes them.
    fn all_layers(&self) -> Vec<ExrLayer> {
        let mut layers = picture_layers(&self.rendered);
        layers.extend(self.aovs.iter().flat_map(surface_layers));
        layers
    }

    fn write_options(&self, tone: Option<&str>, exposure: f32, png_bits: u32, exr_bits: u32) -> PyResult<WriteOptions> {
        let curve = tone.map_or(Ok(self.default_tone), str::parse);
        let curve = curve.map_err(|e: UnknownToneCurve| PyValueError::new_err(e.to_string()))?;
        let depth = match png_bits {
            8 => BitDepth::Eight,
            16 => BitDepth::Sixteen,
            _ => return Err(PyValueError::new_err(format!("png_bits is {png_bits}: give 8 or 16"))),
        };
        let floats = match exr_bits {
            16 => ExrPrecision::Half,
            32 => ExrPrecision::Single,
            _ => return Err(PyValueError::new_err(format!("exr_bits is {exr_bits}: give 16 or 32"))),
        };
        let tone = ToneMap { curve, exposure_stops: exposure };
        Ok(WriteOptions { tone, bit_depth: depth, exr_precision: floats, metadata: metadata() })
    }
}

/// Returns the metadata of written files.
fn metadata() -> Vec<(String, String)> {
    vec![("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")))]
}

#[pymethods]
impl NativeResult {
    /// Width and height \[pixels].
    fn size(&self) -> (u32, u32) {
        self.rendered.film.size()
    }

    /// Number of passes.
    fn passes(&self) -> u32 {
        self.rendered.film.passes()
    }

    /// Wall time of all passes \[s].
    fn seconds(&self) -> f64 {
        self.rendered.wall_time.as_secs_f64()
    }

    /// Why the render ended: passes, time, target, floor or interrupted.
    fn ended(&self) -> &'static str {
        end_reason_name(self.rendered.end_reason)
    }

    /// Light that clamping removed, as a fraction of the light without clamping; `None` without
    /// clamping.
    fn clamped_fraction(&self, py: Python<'_>) -> Option<f64> {
        py.detach(|| self.rendered.clamping_loss_fraction())
    }

    /// Radiance of each pixel as f32: rows from the top, then columns, then red, green and blue.
    fn image<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        let values = py.detach(|| self.rendered.film.mean_picture());
        let bytes: Vec<u8> = values.iter().flat_map(|pixel| pixel.to_array()).flat_map(f32::to_ne_bytes).collect();
        PyByteArray::new(py, &bytes)
    }

    /// Layers: the name, empty for the picture, and the channels as name and f32 values.
    fn layers<'py>(&self, py: Python<'py>) -> Vec<(String, Vec<Channel<'py>>)> {
        let layers = py.detach(|| self.all_layers());
        let bytes = |values: &[f32]| values.iter().flat_map(|value| value.to_ne_bytes()).collect::<Vec<u8>>();
        let channel = |(name, values): (String, Vec<f32>)| (name, PyByteArray::new(py, &bytes(&values)));
        layers.into_iter().map(|layer| (layer.name, layer.channels.into_iter().map(channel).collect())).collect()
    }

    /// Estimated error; `None` if it is not estimated, or after too few passes.
    fn error(&self, py: Python<'_>, confidence: Option<f64>) -> PyResult<Option<EstimateTuple>> {
        let confidence = confidence.map_or(Ok(self.confidence), confidence_from_probability)?;
        let estimate = py.detach(|| {
            let estimator = self.rendered.estimator.as_ref()?;
            let estimate = estimator.estimate_with_confidence(&self.rendered.film, confidence);
            Some((estimate, estimator.forecast(&estimate)?))
        });
        Ok(estimate.map(|(estimate, forecast)| estimate_tuple(&estimate, forecast, confidence)))
    }

    /// Writes the picture as PNG or OpenEXR. Returns the numbers of pixels that are clipped to
    /// white, not finite, and negative.
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        tone: Option<&str>,
        exposure: f32,
        png_bits: u32,
        exr_bits: u32,
    ) -> PyResult<()> {
        let options = self.write_options(tone, exposure, png_bits, exr_bits)?;
        let (width, height) = self.rendered.film.size();
        let picture = Image::from_pixels(width, height, self.rendered.film.mean_picture());
        let picture = picture.map_err(|e| PyValueError::new_err(e.to_string()))?;
        py.detach(|| write_image(&path, &picture, &options)).map_err(|e| write_exception(&e))?;
        Ok(())
    }

    /// Writes all layers as one OpenEXR file.
    fn save_layers(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let size = self.rendered.film.size();
        let written = py.detach(|| write_layers(&path, size, &self.all_layers(), &metadata()));
        written.map_err(|e| write_exception(&e))?;
        Ok(())
    }
}

#[pymethods]
impl NativeForecast {
    /// Predicted relative error after `passes` passes.
    fn error_after_passes(&self, passes: u32) -> f64 {
        self.forecast.error_after_passes(passes)
    }

    /// Forecast of the pass after which the error is at most `target` with `confidence`.
    ///
    /// Returns the least, median and greatest number of passes, and the bias that no number of
    /// passes removes. `confidence` is that of the upper end of the error interval.
    fn stop(&self, target: f64, confidence: f64) -> PyResult<StopTuple> {
        let confidence = confidence_from_probability(confidence)?;
        let interval = caustica::render::ErrorTarget { error: target, confidence }.interval_confidence();
        Ok(match self.forecast.stop_forecast(target, interval) {
            StopForecast::Passes(range) => (Some(range.low), Some(range.median), range.high, None),
            StopForecast::Never { floor } => (None, None, None, Some(floor)),
            StopForecast::TooFar { at_least } => (Some(at_least), None, None, None),
        })
    }
}

/// Returns the name of the reason why a render ended.
pub fn end_reason_name(end_reason: EndReason) -> &'static str {
    match end_reason {
        EndReason::Passes => "passes",
        EndReason::Time => "time",
        EndReason::Target => "target",
        EndReason::BiasFloor => "floor",
        EndReason::Interrupted => "interrupted",
    }
}
