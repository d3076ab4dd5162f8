//! Reads the picture files of pbrt scenes: PNG, JPEG, BMP, TGA, OpenEXR and Radiance HDR.

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::parameters::Parameters;
use crate::image::{Image, PixelMeaning, QuantizedRgba, decode, decode_quantized_rgba};
use glam::Vec3;

/// Transfer curve from the integer levels of a picture file to linear values.
///
/// OpenEXR and Radiance HDR files store linear values, so no curve applies to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LevelCurve {
    /// Levels are proportional to the values.
    Linear,
    /// Transfer function of sRGB.
    Srgb,
    /// Power function with this exponent: linear value = level^exponent, for levels in \[0, 1].
    Gamma(f64),
}

/// Decoded pixels of a picture file.
pub(super) struct PbrtPicture {
    /// Linear red, green and blue.
    pub image: Image,
    /// Alpha of each pixel; `None` if the file has no alpha, or if alpha is 1 everywhere.
    ///
    /// The transfer curve of the colors applies to alpha too, as in pbrt.
    pub alpha: Option<Vec<f32>>,
}

impl LevelCurve {
    /// Returns the curve of an `imagemap` texture, from its parameter `encoding` (pbrt-v4) or
    /// `gamma` (pbrt-v3); sRGB without either.
    pub fn from_parameters(parameters: &Parameters) -> ReadResult<Self> {
        let Some(encoding) = parameters.text("encoding") else {
            return Ok(if parameters.flag("gamma") == Some(false) { Self::Linear } else { Self::Srgb });
        };
        let exponent = encoding.strip_prefix("gamma").and_then(|exponent| exponent.trim().parse::<f64>().ok());
        match (encoding, exponent) {
            ("linear", _) => Ok(Self::Linear),
            ("sRGB", _) => Ok(Self::Srgb),
            (_, Some(exponent)) if exponent > 0.0 && exponent <= 100.0 => Ok(Self::Gamma(exponent)),
            _ => {
                let message = format!("`{encoding}` is no encoding of pictures");
                Err(parameters.place.error(message, "use sRGB, linear, or gamma with a number, as `gamma 2.2`"))
            }
        }
    }

    /// Returns the curve of pictures of lights: sRGB, but linear in pbrt-v3, which does not decode
    /// them.
    pub fn of_lights(is_v3: bool) -> Self {
        if is_v3 { Self::Linear } else { Self::Srgb }
    }

    /// Returns a table of linear values, by the integer level of a channel: from level 0 to the
    /// greatest level of the picture's format.
    fn table(self, levels: &QuantizedRgba) -> Vec<f32> {
        let greatest = f64::from(levels.max_level);
        let by_level = |value: &dyn Fn(f64) -> f64| {
            (0..=levels.max_level).map(|level| value(f64::from(level) / greatest) as f32).collect()
        };
        match self {
            Self::Linear => by_level(&|x| x),
            Self::Srgb => levels.srgb_table(),
            Self::Gamma(exponent) => by_level(&|x| libm::pow(x, exponent)),
        }
    }
}

/// Reads and decodes the picture file `name`, which the directive at `place` refers to.
pub(super) fn read_picture(
    name: &str,
    curve: LevelCurve,
    place: &PbrtSourceLocation,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<PbrtPicture> {
    let path = files.resolve_path(place, name)?;
    let bytes = files.read_file(&path)?;
    let failed = |e: &dyn std::fmt::Display| place.error(e, "convert the picture to PNG or OpenEXR");
    let levels = decode_quantized_rgba(&path, &bytes, files.free_memory()).map_err(|e| failed(&e))?;
    let Some(levels) = levels else {
        let (image, _) = decode(&path, &bytes, PixelMeaning::Color, files.free_memory()).map_err(|e| failed(&e))?;
        files.reserve_memory(12 * image.pixels().len() as u64)?;
        return Ok(PbrtPicture { image, alpha: None });
    };
    let table = curve.table(&levels);
    let value = |level: u16| table.get(usize::from(level)).copied().unwrap_or_default();
    let is_opaque = levels.pixels.iter().all(|pixel| pixel[3] == levels.max_level);
    files.reserve_memory(if is_opaque { 12 } else { 16 } * levels.pixels.len() as u64)?;
    let alpha = (!is_opaque).then(|| levels.pixels.iter().map(|pixel| value(pixel[3])).collect());
    let pixels = levels.pixels.iter().map(|p| Vec3::new(value(p[0]), value(p[1]), value(p[2]))).collect();
    let image = Image::from_pixels(levels.width, levels.height, pixels).map_err(|e| failed(&e))?;
    Ok(PbrtPicture { image, alpha })
}
