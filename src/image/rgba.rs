//! Decodes PNG, JPEG, BMP and TGA pictures with alpha, for scenes of other programs.

use super::buffer::pixel_count;
use super::error::{DecodeFailure, ReadError, check_compression_ratio, check_memory};
use super::tone::srgb_decode;
use ::image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Integer levels of an RGBA picture as its file stores them, without conversion to linear values.
#[derive(Clone, Debug)]
pub(crate) struct QuantizedRgba {
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Levels of red, green, blue and alpha from 0 to `max_level`, in rows from the top.
    pub pixels: Vec<[u16; 4]>,
    /// Largest level, which stands for 1: 255 or 65,535.
    pub max_level: u16,
}

impl QuantizedRgba {
    /// Returns a table that maps each level from 0 to `max_level` to its linear value in \[0, 1],
    /// by the sRGB transfer function.
    pub fn srgb_table(&self) -> Vec<f32> {
        (0..=self.max_level).map(|level| srgb_decode(f64::from(level) / f64::from(self.max_level)) as f32).collect()
    }
}

/// Memory that a decoder may allocate per pixel \[bytes]: two buffers of four 16-bit channels.
const DECODED_BYTES_PER_PIXEL: u64 = 16;

/// Memory that a decoder may allocate for tables, in addition to the memory for pixels \[bytes].
const DECODER_BYTES: u64 = 1 << 20;

/// Decodes a PNG, JPEG, BMP or TGA picture from the bytes `file`; returns `Ok(None)` for another
/// format.
///
/// TGA files have no signature, so the extension `tga` of `path` selects that format. For other
/// formats, `path` is only for messages.
///
/// Fails if decoding needs more than `free` bytes of memory; `None` means no limit.
///
/// # Errors
/// [`ReadError`] if the picture is damaged or too large.
pub(crate) fn decode_quantized_rgba(
    path: &Path,
    file: &[u8],
    free: Option<u64>,
) -> Result<Option<QuantizedRgba>, ReadError> {
    let format = match ::image::guess_format(file) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Bmp)) => format,
        Err(_) if has_tga_extension(path) => ImageFormat::Tga,
        Ok(_) | Err(_) => return Ok(None),
    };
    decode_levels(file, format, free).map(Some).map_err(|failure| failure.into_read_error(path.to_owned()))
}

/// True if `path` ends in `.tga`, in upper or lower case.
fn has_tga_extension(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tga"))
}

fn decode_levels(file: &[u8], format: ImageFormat, free: Option<u64>) -> Result<QuantizedRgba, DecodeFailure> {
    let reason = |error: ImageError| DecodeFailure::Reason(error.to_string());
    let (width, height) = ImageReader::with_format(Cursor::new(file), format).into_dimensions().map_err(reason)?;
    let pixels = pixel_count(width, height)?;
    // Before compression, a PNG or BMP has at least one bit per pixel. A JPEG codes each block of
    // 64 pixels by a bit or more. A TGA codes a run of up to 128 pixels by two bytes or more.
    check_compression_ratio(pixels as u64 / 8, file.len())?;
    check_memory(pixels, free)?;
    let mut reader = ImageReader::with_format(Cursor::new(file), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(DECODED_BYTES_PER_PIXEL * pixels as u64 + DECODER_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(reason)?;
    let (pixels, greatest) = match decoded {
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => (decoded.into_rgba16().pixels().map(|p| p.0).collect(), u16::MAX),
        _ => (decoded.into_rgba8().pixels().map(|p| p.0.map(u16::from)).collect(), 255),
    };
    Ok(QuantizedRgba { width, height, pixels, max_level: greatest })
}
