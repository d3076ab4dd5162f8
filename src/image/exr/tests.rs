use super::*;

fn image_of_extreme_values() -> Image {
    let values = [0.0, -0.0, 1.0, -1.0, f32::MAX, f32::MIN_POSITIVE, 1e-45, 0.1, f32::INFINITY, f32::NAN];
    let pixels = (0..40 * 33).map(|i| Vec3::new(values[i % 10], i as f32, values[(i / 10) % 10])).collect();
    Image::from_pixels(40, 33, pixels).unwrap()
}

fn unwrap_decoded(result: Result<Image, DecodeFailure>) -> Image {
    result.unwrap_or_else(|failure| panic!("{}", failure.into_read_error("memory".into())))
}

#[test]
fn single_precision_is_lossless() {
    let (file, report) = encode(&image_of_extreme_values(), ExrPrecision::Single, &[]).unwrap();
    let image = unwrap_decoded(decode(&file, None));
    assert_eq!((image.width(), image.height()), (40, 33));
    let bits =
        |image: &Image| -> Vec<[u32; 3]> { image.pixels().iter().map(|p| p.to_array().map(f32::to_bits)).collect() };
    assert_eq!(bits(&image), bits(&image_of_extreme_values()));
    let non_finite = image_of_extreme_values().pixels().iter().filter(|p| !p.is_finite()).count();
    assert_eq!(report, ClippedPixelReport { non_finite, too_bright: 0, negative: 0 });
}

#[test]
fn metadata_is_stored_and_bytes_repeat() {
    let pairs = [("Seed".to_owned(), "42".to_owned()), ("Scene".to_owned(), format!("Ω{}", "x".repeat(900)))];
    let (file, _) = encode(&image_of_extreme_values(), ExrPrecision::Single, &pairs).unwrap();
    assert_eq!(encode(&image_of_extreme_values(), ExrPrecision::Single, &pairs).unwrap().0, file);
    let headers = MetaData::read_from_buffered(Cursor::new(&file), true).unwrap().headers;
    let comments = headers[0].own_attributes.comments.as_ref().unwrap();
    assert_eq!(comments.as_slice(), format!("Seed: 42\nScene: {}", pairs[1].1).as_bytes());
    assert_eq!(headers[0].shared_attributes.chromaticities, Some(REC_709));
}

/// Returns the OpenEXR `file` with another size of the window `name` in its header.
fn exr_with_replaced_window(file: &[u8], name: &[u8], (width, height): (i32, i32)) -> Vec<u8> {
    let window = file.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    let mut file = file.to_vec();
    // A window is stored as first column, first row, last column, last row.
    file[window + 8..window + 12].copy_from_slice(&(width - 1).to_le_bytes());
    file[window + 12..window + 16].copy_from_slice(&(height - 1).to_le_bytes());
    file
}

const DATA: &[u8] = b"dataWindow\0box2i\0";
const DISPLAY: &[u8] = b"displayWindow\0box2i\0";

#[test]
fn an_implausible_size_is_refused() {
    let (file, _) = encode(&image_of_extreme_values(), ExrPrecision::Single, &[]).unwrap();
    for window in [DATA, DISPLAY] {
        for (side, expected) in [(16_384, "too short"), (20_000, "too large")] {
            let huge = exr_with_replaced_window(&file, window, (side, side));
            let message = decode(&huge, None).err().unwrap().into_read_error("memory".into()).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
    // A display window of four megapixels takes 192 MB of memory, although the file has little
    // data.
    let framed = exr_with_replaced_window(&file, DISPLAY, (2000, 2000));
    assert!(matches!(decode(&framed, Some(191_000_000)), Err(DecodeFailure::Memory { needed: 192_000_000, .. })));
    let image = unwrap_decoded(decode(&framed, Some(192_000_000)));
    assert_eq!((image.width(), image.pixels()[2003].x), (2000, image_of_extreme_values().pixels()[43].x));
    assert_eq!(image.pixels()[40], Vec3::ZERO);
}

/// A picture is read although it takes more memory than the decoder's default limit of half a
/// gigabyte.
#[test]
fn pictures_may_exceed_the_limit_of_the_decoder() {
    let noise = |i: u32| Vec3::splat((i.wrapping_mul(2_654_435_761) >> 8) as f32);
    let image = Image::from_pixels(256, 256, (0..256 * 256).map(noise).collect()).unwrap();
    let (file, _) = encode(&image, ExrPrecision::Single, &[]).unwrap();
    let read = unwrap_decoded(decode(&exr_with_replaced_window(&file, DISPLAY, (6720, 6720)), None));
    assert_eq!((read.width(), read.height(), read.pixels()[255]), (6720, 6720, image.pixels()[255]));
}

#[test]
fn damaged_files_never_panic() {
    let (file, _) = encode(&image_of_extreme_values(), ExrPrecision::Single, &[("Seed".into(), "42".into())]).unwrap();
    for cut in (4..file.len()).step_by(7) {
        assert!(decode(&file[..cut], None).is_err(), "cut at {cut}");
    }
    for at in 0..file.len().min(700) {
        for flip in [0x01, 0x80, 0xff] {
            let mut broken = file.clone();
            broken[at] ^= flip;
            // A change in a comment or a pixel leaves a valid file, so only a panic is an error
            // here.
            drop(decode(&broken, None));
        }
    }
}
