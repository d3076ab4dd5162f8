//! Reads and writes PNG files (ISO/IEC 15948).

use std::io::Cursor;

use glam::Vec3;
use png::{BitDepth as Depth, ColorType, Decoder, DecodingError, Encoder, EncodingError, SrgbRenderingIntent};
use rayon::prelude::*;

use super::buffer::{Image, Rgb8Image, pixel_count};
use super::error::{DecodeFailure, WriteError, check_compression_ratio, check_memory};
use super::options::{BitDepth, WriteOptions};
use super::tone::{ClippedPixelReport, Quantizer, ToneCurve, srgb_decode};

/// Encodes `image` as the bytes of a PNG file.
///
/// Also returns the numbers of pixels with clamped or non-finite values. The file has an sRGB
/// chunk, except for the tone curve [`ToneCurve::Legacy`], which does not encode levels by sRGB.
pub(super) fn encode(image: &Image, options: &WriteOptions) -> Result<(Vec<u8>, ClippedPixelReport), WriteError> {
    let (samples, report) = quantize_image(image, options)?;
    let mut file = Vec::new();
    let refused = |error: EncodingError| WriteError::Encode(error.to_string());

    let mut encoder = Encoder::new(&mut file, image.width(), image.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match options.bit_depth {
        BitDepth::Eight => Depth::Eight,
        BitDepth::Sixteen => Depth::Sixteen,
    });
    if options.tone.curve != ToneCurve::Legacy {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    for (key, text) in &options.metadata {
        // Older readers know only tEXt chunks, which are Latin-1. Other text needs iTXt.
        if text.is_ascii() {
            encoder.add_text_chunk(key.clone(), text.clone()).map_err(refused)?;
        } else {
            encoder.add_itxt_chunk(key.clone(), text.clone()).map_err(refused)?;
        }
    }
    let mut writer = encoder.write_header().map_err(refused)?;
    writer.write_image_data(&samples).map_err(refused)?;
    writer.finish().map_err(refused)?;
    Ok((file, report))
}

/// Converts radiance to the samples of a PNG file by the tone map of `options`; 16-bit samples are
/// big-endian.
fn quantize_image(image: &Image, options: &WriteOptions) -> Result<(Vec<u8>, ClippedPixelReport), WriteError> {
    let (white, size) = match options.bit_depth {
        BitDepth::Eight => (255, 1),
        BitDepth::Sixteen => (65_535, 2),
    };
    let quantizer = Quantizer::new(options.tone, white)?;
    let width = image.width() as usize;
    let mut samples = vec![0; image.pixels().len() * 3 * size];
    let report = samples
        .par_chunks_mut(width * 3 * size)
        .zip(image.pixels().par_chunks(width))
        .map(|(row, pixels)| {
            let mut report = ClippedPixelReport::default();
            for (bytes, &pixel) in row.chunks_exact_mut(3 * size).zip(pixels) {
                for (sample, level) in bytes.chunks_exact_mut(size).zip(quantizer.quantize_pixel(pixel, &mut report)) {
                    sample.copy_from_slice(&level.to_be_bytes()[2 - size..]);
                }
            }
            report
        })
        .reduce(ClippedPixelReport::default, ClippedPixelReport::merged_with);
    Ok((samples, report))
}

impl From<DecodingError> for DecodeFailure {
    fn from(error: DecodingError) -> Self {
        Self::Reason(error.to_string())
    }
}

/// Samples of a PNG file, converted to RGB without alpha.
struct DecodedPng {
    width: u32,
    height: u32,
    /// All samples, in rows from the top. Each has one or two bytes, big-endian.
    samples: Vec<u8>,
    /// True if samples have 16 bits.
    sixteen: bool,
    /// Value of the gAMA chunk; `None` if the file has no such chunk, or if it has an sRGB chunk,
    /// which has priority.
    encoding_gamma: Option<f64>,
}

/// Decodes the samples of a PNG file.
///
/// Fails if decoding needs more than `free` bytes of memory (`None` means no limit), or if a pixel
/// is transparent.
fn decode_png_samples(file: &[u8], free: Option<u64>) -> Result<DecodedPng, DecodeFailure> {
    let mut decoder = Decoder::new(Cursor::new(file));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info()?;
    let info = reader.info();
    let (width, height) = (info.width, info.height);
    let gamma = match (info.srgb, info.gama_chunk) {
        (None, Some(gamma)) => Some(f64::from(gamma.into_value())),
        _ => None,
    };
    if gamma.is_some_and(|g| g <= 0.0) {
        return Err(DecodeFailure::Reason("its gAMA chunk states a gamma of zero".into()));
    }
    let pixels = pixel_count(width, height)?;
    let stored = u64::from(height) * info.raw_row_length() as u64;
    check_compression_ratio(stored, file.len())?;
    check_memory(pixels, free)?;

    let (color, depth) = reader.output_color_type();
    let (channels, sixteen) = (color.samples(), depth == Depth::Sixteen);
    let size = if sixteen { 2 } else { 1 };
    let length = pixels * channels * size;
    if reader.output_buffer_size() != Some(length) {
        return Err(DecodeFailure::Reason(
            "its layout of samples is not supported: convert it to 8- or 16-bit RGB".into(),
        ));
    }
    let mut raw = vec![0; length];
    reader.next_frame(&mut raw)?;

    let has_alpha = matches!(color, ColorType::Rgba | ColorType::GrayscaleAlpha);
    let is_color = matches!(color, ColorType::Rgb | ColorType::Rgba);
    let mut samples = Vec::with_capacity(pixels * 3 * size);
    for pixel in raw.chunks_exact(channels * size) {
        if has_alpha && pixel[(channels - 1) * size..].iter().any(|&byte| byte != 255) {
            return Err(DecodeFailure::Reason("it has transparent pixels: flatten it on a background first".into()));
        }
        for channel in 0..3 {
            let at = if is_color { channel * size } else { 0 };
            samples.extend_from_slice(&pixel[at..at + size]);
        }
    }
    Ok(DecodedPng { width, height, samples, sixteen, encoding_gamma: gamma })
}

/// Decodes a PNG file as linear radiance.
///
/// Samples are linearized by the sRGB transfer function. If the file has a gAMA chunk and no sRGB
/// chunk, the gamma of that chunk is used instead. `free` is the memory limit \[bytes]; `None`
/// means no limit.
pub(super) fn decode(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    let decoded = decode_png_samples(file, free)?;
    match decoded.encoding_gamma {
        Some(gamma) => apply_transfer_function(decoded, |signal| libm::pow(signal, 1.0 / gamma) as f32),
        None => apply_transfer_function(decoded, |signal| srgb_decode(signal) as f32),
    }
}

/// Decodes a PNG file of data such as roughness: levels become numbers from 0 to 1, without a
/// transfer function.
///
/// `free` is the memory limit \[bytes]; `None` means no limit.
pub(super) fn decode_non_color(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    apply_transfer_function(decode_png_samples(file, free)?, |signal| signal as f32)
}

/// Converts samples to a picture. Each sample is scaled to \[0, 1], and the function `linear` maps
/// it to a linear value.
fn apply_transfer_function(decoded: DecodedPng, linear: impl Fn(f64) -> f32) -> Result<Image, DecodeFailure> {
    let DecodedPng { width, height, samples, sixteen, .. } = decoded;
    let table: Vec<f32> = if sixteen {
        (0..=65_535).map(|level| linear(f64::from(level) / 65_535.0)).collect()
    } else {
        (0..=255).map(|level| linear(f64::from(level) / 255.0)).collect()
    };
    let level = |i: usize| {
        if sixteen { usize::from(u16::from_be_bytes([samples[2 * i], samples[2 * i + 1]])) } else { samples[i].into() }
    };
    let value = |i: usize| table[level(i)];
    let count = pixel_count(width, height)?;
    let pixels = (0..count).map(|i| Vec3::new(value(3 * i), value(3 * i + 1), value(3 * i + 2))).collect();
    Ok(Image::from_pixels(width, height, pixels)?)
}

/// Decodes the levels of an 8-bit PNG file, without a transfer function. Fails for a 16-bit file.
pub(super) fn decode_rgb8(file: &[u8]) -> Result<Rgb8Image, DecodeFailure> {
    let decoded = decode_png_samples(file, None)?;
    if decoded.sixteen {
        return Err(DecodeFailure::Reason(
            "it has 16 bits per channel, and only 8-bit pictures can be compared by bytes".into(),
        ));
    }
    Ok(Rgb8Image::from_pixels(decoded.width, decoded.height, decoded.samples.as_chunks().0.to_vec())?)
}

#[cfg(test)]
mod tests;
