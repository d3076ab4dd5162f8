//! Reads PNG, OpenEXR and Radiance HDR files.

use std::io::{Cursor, Read};
use std::path::Path;

use ::image::DynamicImage;
use ::image::codecs::hdr::HdrDecoder;
use glam::Vec3;

use super::buffer::{Image, Rgb8Image, pixel_count};
use super::error::{DecodeFailure, ReadError, check_compression_ratio, check_memory};
use super::open::open_file;
use super::{exr, png};

const PNG_SIGNATURE: [u8; 4] = *b"\x89PNG";
const EXR_SIGNATURE: [u8; 4] = *b"\x76\x2f\x31\x01";
/// Common first bytes of the two Radiance HDR signatures, `#?RADIANCE` and `#?RGBE`.
const HDR_SIGNATURE: [u8; 3] = *b"#?R";

/// Picture file format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFormat {
    /// PNG: integer levels that encode display values by the sRGB curve or a gamma.
    Png,
    /// OpenEXR: linear radiance.
    Exr,
    /// Radiance HDR: linear radiance.
    Hdr,
}

impl InputFormat {
    /// Returns the file format that the first bytes of `file` indicate; `None` if they are not a
    /// known signature.
    fn from_signature(file: &[u8]) -> Option<Self> {
        match file {
            _ if file.starts_with(&PNG_SIGNATURE) => Some(Self::Png),
            _ if file.starts_with(&EXR_SIGNATURE) => Some(Self::Exr),
            _ if file.starts_with(&HDR_SIGNATURE) => Some(Self::Hdr),
            _ => None,
        }
    }
}

/// Reads a PNG, OpenEXR or Radiance HDR picture as linear radiance.
///
/// The first bytes of the file determine the format:
///
/// - PNG: levels are linearized by the sRGB curve, or by a gAMA chunk if there is no sRGB chunk.
/// - OpenEXR: the first layer with channels R, G and B is read.
/// - Radiance HDR: pixels are divided by the exposures in the header.
///
/// Tone curves are not undone.
///
/// # Errors
/// [`ReadError`] if the file is missing, damaged, of another format, transparent, or larger than
/// [`super::MAX_PIXELS`].
pub fn read(path: &Path) -> Result<Image, ReadError> {
    Ok(read_and_detect_format(path)?.0)
}

/// Reads a picture as linear radiance like [`read`], and returns its file format.
///
/// # Errors
/// [`ReadError`], see [`read`].
pub fn read_and_detect_format(path: &Path) -> Result<(Image, InputFormat), ReadError> {
    let file = read_file_bytes(path, None)?;
    decode(path, &file, PixelMeaning::Color, None)
}

/// Reads a picture like [`read`], but returns PNG samples as numbers from 0 to 1, without a
/// transfer function.
///
/// # Errors
/// [`ReadError`], see [`read`].
pub fn read_non_color(path: &Path) -> Result<Image, ReadError> {
    read_with_memory_limit(path, PixelMeaning::NonColor, None)
}

/// Meaning of the pixels of a picture file: colors or other data.
///
/// The meaning determines how PNG samples are decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelMeaning {
    /// The pixels are colors. PNG samples are linearized.
    Color,
    /// The pixels are data such as roughness. PNG samples become numbers from 0 to 1 without a
    /// transfer function.
    NonColor,
}

/// Reads a picture with pixels of the given `meaning`, using at most `free` bytes of memory; `None`
/// means no limit.
///
/// # Errors
/// [`ReadError`], see [`read`]; also if reading needs more than `free` bytes.
pub fn read_with_memory_limit(path: &Path, meaning: PixelMeaning, free: Option<u64>) -> Result<Image, ReadError> {
    let file = read_file_bytes(path, free)?;
    Ok(decode(path, &file, meaning, free.map(|free| free.saturating_sub(file.len() as u64)))?.0)
}

/// Decodes a picture from the bytes `file` of a picture file; returns the picture and the file
/// format.
///
/// Decoding may use at most `free` bytes of memory; `None` means no limit. `path` is only for
/// messages.
///
/// # Errors
/// [`ReadError`], see [`read_with_memory_limit`].
pub fn decode(
    path: &Path,
    file: &[u8],
    meaning: PixelMeaning,
    free: Option<u64>,
) -> Result<(Image, InputFormat), ReadError> {
    let format = InputFormat::from_signature(file).ok_or_else(|| ReadError::UnknownFormat { path: path.to_owned() })?;
    let image = match (format, meaning) {
        (InputFormat::Png, PixelMeaning::Color) => png::decode(file, free),
        (InputFormat::Png, PixelMeaning::NonColor) => png::decode_non_color(file, free),
        (InputFormat::Exr, _) => exr::decode(file, free),
        (InputFormat::Hdr, _) => decode_hdr(file, free),
    };
    Ok((image.map_err(|failure| failure.into_read_error(path.to_owned()))?, format))
}

/// Reads the 8-bit levels that a PNG file stores, without conversion to linear values, for exact
/// comparisons.
///
/// # Errors
/// [`ReadError`], see [`read`]; also if the file is not an 8-bit PNG.
pub fn read_rgb8(path: &Path) -> Result<Rgb8Image, ReadError> {
    let file = read_file_bytes(path, None)?;
    let bytes = match InputFormat::from_signature(&file) {
        Some(InputFormat::Png) => png::decode_rgb8(&file),
        Some(_) => Err(DecodeFailure::Reason(
            "a picture of floating-point numbers has no bytes to compare: use an 8-bit PNG".into(),
        )),
        None => return Err(ReadError::UnknownFormat { path: path.to_owned() }),
    };
    bytes.map_err(|failure| failure.into_read_error(path.to_owned()))
}

/// Decodes a Radiance HDR picture (Ward 1991, "Real Pixels"). Pixels are divided by the exposure in
/// the header, 1 if there is none.
///
/// `free` is the memory limit \[bytes]; `None` means no limit.
fn decode_hdr(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    let reason = |error: ::image::ImageError| DecodeFailure::Reason(error.to_string());
    // Strict decoding accepts only one of the two signatures.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(file)).map_err(reason)?;
    let header = decoder.metadata();
    // Run-length coding stores at most 127 bytes in two, so the limit for DEFLATE is never
    // exceeded.
    let pixels = pixel_count(header.width, header.height)?;
    check_compression_ratio(4 * pixels as u64, file.len())?;
    check_memory(pixels, free)?;
    let exposure = header.exposure.unwrap_or(1.0);
    if !(exposure > 0.0 && exposure.is_finite()) {
        return Err(DecodeFailure::Reason(format!("the exposure is {exposure}, which is not above zero")));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(reason)?.into_rgb32f();
    let pixels = picture.pixels().map(|p| Vec3::from(p.0) / exposure).collect();
    Ok(Image::from_pixels(header.width, header.height, pixels)?)
}

/// Reads all bytes of a file. Fails if the file is longer than `free` bytes; `None` means no limit.
fn read_file_bytes(path: &Path, free: Option<u64>) -> Result<Vec<u8>, ReadError> {
    let refused = |source| ReadError::Io { path: path.to_owned(), source };
    let (mut file, needed) = open_file(path).map_err(refused)?;
    if let Some(free) = free.filter(|free| needed > *free) {
        return Err(ReadError::Memory { path: path.to_owned(), needed, free });
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(refused)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
