//! Reads and writes PNG (ISO/IEC 15948).

use std::io::Cursor;

use glam::Vec3;
use png::{BitDepth as Depth, ColorType, Decoder, DecodingError, Encoder, EncodingError, SrgbRenderingIntent};
use rayon::prelude::*;

use super::buffer::{Image, RgbBytes, pixel_count};
use super::error::{DecodeFailure, WriteError, check_memory, check_plausible};
use super::tone::{Curve, Quantizer, WriteReport, srgb_decode};
use super::write::{BitDepth, WriteOptions};

/// Encodes `image` as a PNG file. All curves except [`Curve::Course`] add an sRGB chunk.
pub(super) fn encode(image: &Image, options: &WriteOptions) -> Result<(Vec<u8>, WriteReport), WriteError> {
    let (samples, report) = quantize(image, options)?;
    let mut file = Vec::new();
    let refused = |error: EncodingError| WriteError::Encode(error.to_string());

    let mut encoder = Encoder::new(&mut file, image.width(), image.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(match options.depth {
        BitDepth::Eight => Depth::Eight,
        BitDepth::Sixteen => Depth::Sixteen,
    });
    if options.tone.curve != Curve::Course {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    }
    for (key, text) in &options.metadata {
        // Older readers support only tEXt, which is Latin-1.
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

/// The samples in file order; 16-bit samples are big-endian.
///
/// Rows are independent and counts are integers, so the result does not depend on the threads.
fn quantize(image: &Image, options: &WriteOptions) -> Result<(Vec<u8>, WriteReport), WriteError> {
    let (white, size) = match options.depth {
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
            let mut report = WriteReport::default();
            for (bytes, &pixel) in row.chunks_exact_mut(3 * size).zip(pixels) {
                for (sample, level) in bytes.chunks_exact_mut(size).zip(quantizer.levels(pixel, &mut report)) {
                    sample.copy_from_slice(&level.to_be_bytes()[2 - size..]);
                }
            }
            report
        })
        .reduce(WriteReport::default, WriteReport::merge);
    Ok((samples, report))
}

impl From<DecodingError> for DecodeFailure {
    fn from(error: DecodingError) -> Self {
        Self::Reason(error.to_string())
    }
}

/// Stored samples, expanded to three per pixel.
struct Decoded {
    width: u32,
    height: u32,
    /// One or two bytes per sample, big-endian.
    samples: Vec<u8>,
    /// True if samples have 16 bits.
    sixteen: bool,
    /// Exponent of the gAMA chunk, unless an sRGB chunk overrides it.
    gamma: Option<f64>,
}

fn decode(file: &[u8], free: Option<u64>) -> Result<Decoded, DecodeFailure> {
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
    check_plausible(stored, file.len())?;
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
    Ok(Decoded { width, height, samples, sixteen, gamma })
}

/// Reads linear radiance.
///
/// The transfer function is that of the gAMA chunk if there is no sRGB chunk, else sRGB, the
/// convention for unlabelled PNG files.
pub(super) fn read(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    let decoded = decode(file, free)?;
    match decoded.gamma {
        Some(gamma) => read_by(decoded, |signal| libm::pow(signal, 1.0 / gamma) as f32),
        None => read_by(decoded, |signal| srgb_decode(signal) as f32),
    }
}

/// Reads the samples without a transfer function, from 0 to 1.
pub(super) fn read_data(file: &[u8], free: Option<u64>) -> Result<Image, DecodeFailure> {
    read_by(decode(file, free)?, |signal| signal as f32)
}

/// Converts samples by a transfer function from signals in [0, 1].
fn read_by(decoded: Decoded, linear: impl Fn(f64) -> f32) -> Result<Image, DecodeFailure> {
    let Decoded { width, height, samples, sixteen, .. } = decoded;
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

/// Reads the bytes of an 8-bit file.
pub(super) fn read_bytes(file: &[u8]) -> Result<RgbBytes, DecodeFailure> {
    let decoded = decode(file, None)?;
    if decoded.sixteen {
        return Err(DecodeFailure::Reason(
            "it has 16 bits per channel, and only 8-bit pictures can be compared by bytes".into(),
        ));
    }
    Ok(RgbBytes::from_pixels(decoded.width, decoded.height, decoded.samples.as_chunks().0.to_vec())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ToneMap;

    fn options(curve: Curve, depth: BitDepth) -> WriteOptions {
        WriteOptions { tone: ToneMap { curve, exposure_stops: 0.0 }, depth, ..WriteOptions::default() }
    }

    fn ramp() -> Image {
        let pixels = (0..35).map(|i| Vec3::new(i as f32 / 34.0, 0.5, 1.0 - i as f32 / 34.0)).collect();
        Image::from_pixels(7, 5, pixels).unwrap()
    }

    fn decoded<T>(result: Result<T, DecodeFailure>) -> T {
        result.unwrap_or_else(|failure| panic!("{}", failure.at("memory".into())))
    }

    fn failure<T>(result: Result<T, DecodeFailure>) -> String {
        result.err().expect("a failure").at("memory".into()).to_string()
    }

    #[test]
    fn eight_bit_levels_are_read_back() {
        let (file, report) = encode(&ramp(), &options(Curve::Course, BitDepth::Eight)).unwrap();
        let bytes = decoded(read_bytes(&file));
        for (i, rgb) in bytes.pixels().iter().enumerate() {
            let up = (255.0 * (i as f32 / 34.0)) as u8;
            let down = (255.0 * (1.0 - i as f32 / 34.0)) as u8;
            assert_eq!(*rgb, [up, 127, down], "pixel {i}");
        }
        assert_eq!(report, WriteReport::default());
    }

    #[test]
    fn reading_undoes_the_srgb_curve_to_half_a_level() {
        for (depth, levels) in [(BitDepth::Eight, 255.0), (BitDepth::Sixteen, 65_535.0)] {
            let (file, _) = encode(&ramp(), &options(Curve::Srgb, depth)).unwrap();
            let image = decoded(read(&file, None));
            // The slope of the decoding curve is at most 2.4 / 1.055 = 2.275. Rounding adds 2⁻²⁴.
            let bound = (0.5 / levels * 2.275 + f64::from(f32::EPSILON)) as f32;
            for (a, b) in image.pixels().iter().zip(ramp().pixels()) {
                assert!((*a - *b).abs().max_element() <= bound, "{a} {b} {depth:?}");
            }
        }
    }

    #[test]
    fn only_the_course_curve_omits_srgb() {
        for (curve, stated) in [(Curve::Srgb, true), (Curve::Filmic, true), (Curve::Course, false)] {
            let (file, _) = encode(&ramp(), &options(curve, BitDepth::Eight)).unwrap();
            assert_eq!(file.windows(4).any(|w| w == b"sRGB"), stated, "{curve}");
            assert!(!file.windows(4).any(|w| w == b"gAMA"), "{curve}");
        }
    }

    #[test]
    fn metadata_is_stored_as_text() {
        let mut options = options(Curve::Srgb, BitDepth::Eight);
        options.metadata = vec![("Seed".into(), "42".into()), ("Scene".into(), "Glas-Ω".into())];
        let (file, _) = encode(&ramp(), &options).unwrap();
        let reader = Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let (plain, wide) = (&reader.info().uncompressed_latin1_text, &reader.info().utf8_text);
        assert_eq!((plain[0].keyword.as_str(), plain[0].text.as_str()), ("Seed", "42"));
        assert_eq!((wide[0].keyword.as_str(), wide[0].get_text().unwrap().as_str()), ("Scene", "Glas-Ω"));
    }

    fn foreign(color: ColorType, depth: Depth, gamma: Option<f32>, data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(png::ScaledFloat::new(gamma));
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        file
    }

    #[test]
    fn other_png_variants_are_read_or_refused() {
        let gray = foreign(ColorType::Grayscale, Depth::Eight, None, &[10, 200]);
        assert_eq!(decoded(read_bytes(&gray)).pixels(), [[10; 3], [200; 3]]);
        let opaque = foreign(ColorType::Rgba, Depth::Eight, None, &[1, 2, 3, 255, 4, 5, 6, 255]);
        assert_eq!(decoded(read_bytes(&opaque)).pixels(), [[1, 2, 3], [4, 5, 6]]);
        let clear = foreign(ColorType::Rgba, Depth::Eight, None, &[1, 2, 3, 255, 4, 5, 6, 254]);
        assert!(failure(read(&clear, None)).contains("flatten"));
        let deep = foreign(ColorType::Rgb, Depth::Sixteen, Some(1.0), &[128, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255]);
        assert!(failure(read_bytes(&deep)).contains("16 bits"));
        // A gamma of 1 is linear, so level 32768 reads as 32768 / 65535.
        let image = decoded(read(&deep, None));
        assert!((image.pixels()[0].x - 32_768.0 / 65_535.0).abs() < 1e-7);
        assert_eq!(image.pixels()[1].z, 1.0);
    }

    /// Checksum of a PNG chunk (ISO/IEC 15948, annex D).
    fn crc32(bytes: &[u8]) -> u32 {
        let step = |c: u32| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
        !bytes.iter().fold(!0, |c, &byte| (0..8).fold(c ^ u32::from(byte), |c, _| step(c)))
    }

    #[test]
    fn damaged_files_are_errors() {
        let (file, _) = encode(&ramp(), &options(Curve::Srgb, BitDepth::Eight)).unwrap();
        for cut in 8..file.len() - 13 {
            assert!(read(&file[..cut], None).is_err(), "cut at {cut}");
        }
        // A header of 16384 × 16384 pixels, with a valid checksum.
        let mut huge = file;
        huge[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
        let checksum = crc32(&huge[12..29]);
        huge[29..33].copy_from_slice(&checksum.to_be_bytes());
        assert!(failure(read(&huge, None)).contains("too short"), "{}", failure(read(&huge, None)));
    }
}
