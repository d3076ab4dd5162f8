//! Reads and writes RGB pictures as OpenEXR files.
//!
//! Files hold linear radiance without exposure or tone curve. With half precision, values are
//! clamped to ±65504.

use std::io::Cursor;

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    Compression, Encoding, Image as ExrImage, Layer, LayerAttributes, MetaData, SpecificChannels, Text, Vec2,
    WritableImage, f16,
};
use glam::Vec3;

use super::buffer::{Image, pixel_count};
use super::error::{DecodeFailure, WriteError, check_compression_ratio, check_memory};
use super::options::ExrPrecision;
use super::tone::ClippedPixelReport;

/// Rec. 709 primaries and the white point D65.
pub(super) const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Encodes `image` as the bytes of an OpenEXR file with lossless compression.
///
/// Also returns the numbers of pixels with clamped or non-finite values.
pub(super) fn encode(
    image: &Image,
    floats: ExrPrecision,
    metadata: &[(String, String)],
) -> Result<(Vec<u8>, ClippedPixelReport), WriteError> {
    let (width, pixels) = (image.width() as usize, image.pixels());
    let size = (width, image.height() as usize);
    // A macro instead of a function, because layers of 16 and 32 bits have different types.
    macro_rules! file {
        ($sample:expr) => {{
            let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
                let [r, g, b] = pixels[y * width + x].to_array().map($sample);
                (r, g, b)
            });
            let layer = Layer::new(size, layer_attributes(metadata), Encoding::SMALL_LOSSLESS, channels);
            let mut picture = ExrImage::from_layer(layer);
            picture.attributes.chromaticities = Some(REC_709);
            let mut file = Cursor::new(Vec::new());
            let written = picture.write().non_parallel().to_buffered(&mut file);
            written.map(|()| file.into_inner()).map_err(|error| WriteError::Encode(error.to_string()))
        }};
    }
    let file = match floats {
        ExrPrecision::Half => file!(to_clamped_half)?,
        ExrPrecision::Single => file!(|x: f32| x)?,
    };
    let count = |predicate: &dyn Fn(&Vec3) -> bool| pixels.iter().filter(|pixel| predicate(pixel)).count();
    let too_bright = match floats {
        ExrPrecision::Half => count(&|p| p.is_finite() && p.abs().max_element() > LARGEST_HALF),
        ExrPrecision::Single => 0,
    };
    Ok((file, ClippedPixelReport { non_finite: count(&|p| !p.is_finite()), too_bright, negative: 0 }))
}

/// Largest finite number in half precision (IEEE 754 binary16).
const LARGEST_HALF: f32 = 65_504.0;

/// Rounds `x` to half precision. Finite numbers are clamped to ±65504, so that they stay finite.
fn to_clamped_half(x: f32) -> f16 {
    f16::from_f32(if x.is_finite() { x.clamp(-LARGEST_HALF, LARGEST_HALF) } else { x })
}

/// Returns OpenEXR layer attributes that hold `metadata` in the attribute `comments`, as lines
/// `key: text`.
pub(super) fn layer_attributes(metadata: &[(String, String)]) -> LayerAttributes {
    let mut attributes = LayerAttributes::default();
    if !metadata.is_empty() {
        // Custom attributes would be stored in the order of a hash map, which varies by run.
        let lines: Vec<String> = metadata.iter().map(|(key, text)| format!("{key}: {text}")).collect();
        attributes.comments = Some(Text::from_slice_unchecked(lines.join("\n").as_bytes()));
    }
    attributes
}

/// Largest display window of an OpenEXR file that is accepted without a check \[pixels]. For a
/// larger window, the file must be long enough to hold data for all pixels of the window.
///
/// The limit exceeds 3840 × 2160. A short file may have a large display window, because pixels
/// outside the data window are not stored.
const MAX_UNCHECKED_WINDOW_PIXELS: u64 = 1 << 23;

impl From<exr::error::Error> for DecodeFailure {
    fn from(error: exr::error::Error) -> Self {
        Self::Reason(error.to_string())
    }
}

/// Decodes the first layer with channels R, G and B of any sample type. Other channels are ignored.
///
/// The picture has the size of the display window. It is black outside of the data window. Fails if
/// reading needs more than `free` bytes of memory; `None` means no limit.
pub(super) fn decode(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    for header in &MetaData::read_from_buffered(Cursor::new(file), false)?.headers {
        let Vec2(width, height) = header.layer_size;
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let pixels = pixel_count(side(width), side(height))? as u64;
        // DWA stores a uniform 8 × 8 block as one value before DEFLATE. JPEG 2000 is not supported.
        // All other codecs compress at most as much as DEFLATE.
        let block = match header.compression {
            Compression::Uncompressed | Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => 1,
            Compression::PIZ | Compression::PXR24 | Compression::B44 | Compression::B44A => 1,
            Compression::DWAA(_) | Compression::DWAB(_) | Compression::HTJ2K32 | Compression::HTJ2K256 => 64,
        };
        check_compression_ratio(pixels * 2 / block, file.len())?;
        // The decoder returns the display window. Pixels outside the data window are black.
        let Vec2(width, height) = header.shared_attributes.display_window.size;
        let shown = pixel_count(side(width), side(height))? as u64;
        if shown > MAX_UNCHECKED_WINDOW_PIXELS {
            check_compression_ratio(shown * 2 / block, file.len())?;
        }
        check_memory(pixels.max(shown) as usize, free)?;
    }

    let mut reader = ::image::ImageReader::with_format(Cursor::new(file), ::image::ImageFormat::OpenExr);
    // The default limit of 0.5 GB is too low for large pictures. Memory is checked above.
    reader.no_limits();
    let picture = reader.decode().map_err(|error| DecodeFailure::Reason(error.to_string()))?.into_rgb32f();
    let (width, height) = picture.dimensions();
    let pixels = picture.pixels().map(|p| Vec3::from(p.0)).collect();
    Ok(Image::from_pixels(width, height, pixels)?)
}

#[cfg(test)]
mod tests;
