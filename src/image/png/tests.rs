use super::*;
use crate::image::ToneMap;

fn png_write_options(curve: ToneCurve, depth: BitDepth) -> WriteOptions {
    WriteOptions { tone: ToneMap { curve, exposure_stops: 0.0 }, bit_depth: depth, ..WriteOptions::default() }
}

fn color_ramp_image() -> Image {
    let pixels = (0..35).map(|i| Vec3::new(i as f32 / 34.0, 0.5, 1.0 - i as f32 / 34.0)).collect();
    Image::from_pixels(7, 5, pixels).unwrap()
}

fn unwrap_decoded<T>(result: Result<T, DecodeFailure>) -> T {
    result.unwrap_or_else(|failure| panic!("{}", failure.into_read_error("memory".into())))
}

fn decode_failure_message<T>(result: Result<T, DecodeFailure>) -> String {
    result.err().expect("a failure").into_read_error("memory".into()).to_string()
}

#[test]
fn eight_bit_levels_are_read_back() {
    let (file, report) = encode(&color_ramp_image(), &png_write_options(ToneCurve::Legacy, BitDepth::Eight)).unwrap();
    let bytes = unwrap_decoded(decode_rgb8(&file));
    for (i, rgb) in bytes.pixels().iter().enumerate() {
        let up = (255.0 * (i as f32 / 34.0)) as u8;
        let down = (255.0 * (1.0 - i as f32 / 34.0)) as u8;
        assert_eq!(*rgb, [up, 127, down], "pixel {i}");
    }
    assert_eq!(report, ClippedPixelReport::default());
}

#[test]
fn reading_undoes_srgb_to_half_a_level() {
    for (depth, levels) in [(BitDepth::Eight, 255.0), (BitDepth::Sixteen, 65_535.0)] {
        let (file, _) = encode(&color_ramp_image(), &png_write_options(ToneCurve::Srgb, depth)).unwrap();
        let image = unwrap_decoded(decode(&file, None));
        // The slope of the decoding curve is at most 2.4 / 1.055 = 2.275. Rounding to f32 adds at
        // most 2⁻²³.
        let bound = (0.5 / levels * 2.275 + f64::from(f32::EPSILON)) as f32;
        for (a, b) in image.pixels().iter().zip(color_ramp_image().pixels()) {
            assert!((*a - *b).abs().max_element() <= bound, "{a} {b} {depth:?}");
        }
    }
}

#[test]
fn only_the_legacy_curve_omits_srgb_chunk() {
    for (curve, stated) in [(ToneCurve::Srgb, true), (ToneCurve::Filmic, true), (ToneCurve::Legacy, false)] {
        let (file, _) = encode(&color_ramp_image(), &png_write_options(curve, BitDepth::Eight)).unwrap();
        assert_eq!(file.windows(4).any(|w| w == b"sRGB"), stated, "{curve}");
        assert!(!file.windows(4).any(|w| w == b"gAMA"), "{curve}");
    }
}

#[test]
fn metadata_is_stored_as_text() {
    let mut options = png_write_options(ToneCurve::Srgb, BitDepth::Eight);
    options.metadata = vec![("Seed".into(), "42".into()), ("Scene".into(), "Glas-Ω".into())];
    let (file, _) = encode(&color_ramp_image(), &options).unwrap();
    let reader = Decoder::new(Cursor::new(&file)).read_info().unwrap();
    let (plain, wide) = (&reader.info().uncompressed_latin1_text, &reader.info().utf8_text);
    assert_eq!((plain[0].keyword.as_str(), plain[0].text.as_str()), ("Seed", "42"));
    assert_eq!((wide[0].keyword.as_str(), wide[0].get_text().unwrap().as_str()), ("Scene", "Glas-Ω"));
}

fn encode_png_variant(color: ColorType, depth: Depth, gamma: Option<f32>, data: &[u8]) -> Vec<u8> {
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
    let gray = encode_png_variant(ColorType::Grayscale, Depth::Eight, None, &[10, 200]);
    assert_eq!(unwrap_decoded(decode_rgb8(&gray)).pixels(), [[10; 3], [200; 3]]);
    let opaque = encode_png_variant(ColorType::Rgba, Depth::Eight, None, &[1, 2, 3, 255, 4, 5, 6, 255]);
    assert_eq!(unwrap_decoded(decode_rgb8(&opaque)).pixels(), [[1, 2, 3], [4, 5, 6]]);
    let clear = encode_png_variant(ColorType::Rgba, Depth::Eight, None, &[1, 2, 3, 255, 4, 5, 6, 254]);
    assert!(decode_failure_message(decode(&clear, None)).contains("flatten"));
    let deep =
        encode_png_variant(ColorType::Rgb, Depth::Sixteen, Some(1.0), &[128, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255]);
    assert!(decode_failure_message(decode_rgb8(&deep)).contains("16 bits"));
    // A gamma of 1 is linear, so level 32768 reads as 32768 / 65535.
    let image = unwrap_decoded(decode(&deep, None));
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
    let (file, _) = encode(&color_ramp_image(), &png_write_options(ToneCurve::Srgb, BitDepth::Eight)).unwrap();
    for cut in 8..file.len() - 13 {
        assert!(decode(&file[..cut], None).is_err(), "cut at {cut}");
    }
    // Write a header that claims 16384 × 16384 pixels, with a valid checksum.
    let mut huge = file;
    huge[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
    let checksum = crc32(&huge[12..29]);
    huge[29..33].copy_from_slice(&checksum.to_be_bytes());
    assert!(
        decode_failure_message(decode(&huge, None)).contains("too short"),
        "{}",
        decode_failure_message(decode(&huge, None))
    );
}
