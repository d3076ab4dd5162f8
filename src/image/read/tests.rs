use super::*;
use crate::image::ExrPrecision;
use std::fs;

#[test]
fn signatures_select_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("text.png");
    fs::write(&text, "P3 1 1 255 0 0 0").unwrap();
    assert!(matches!(read(&text), Err(ReadError::UnknownFormat { .. })));
    assert!(matches!(read_rgb8(&text), Err(ReadError::UnknownFormat { .. })));
    assert!(matches!(read(&folder.path().join("none.png")), Err(ReadError::Io { .. })));

    let image = Image::new(2, 3).unwrap();
    let misnamed = folder.path().join("misnamed.png");
    fs::write(&misnamed, exr::encode(&image, ExrPrecision::Single, &[]).unwrap().0).unwrap();
    assert_eq!(read(&misnamed).unwrap(), image);
    assert!(read_rgb8(&misnamed).unwrap_err().to_string().contains("8-bit PNG"));
}

/// Returns a Radiance HDR file with `header` and two RGBE pixels. A channel is mantissa / 256 ·
/// 2^(exponent − 128).
fn two_pixel_hdr(header: &str) -> Vec<u8> {
    let mut file = format!("{header}\n\n-Y 1 +X 2\n").into_bytes();
    file.extend([128, 64, 32, 129, 200, 100, 50, 138]);
    file
}

#[test]
fn radiance_hdr_exposures_are_undone() {
    let read = |header| {
        decode_hdr(&two_pixel_hdr(header), None)
            .unwrap_or_else(|failure| panic!("{}", failure.into_read_error("memory".into())))
    };
    let plain = read("#?RADIANCE\nFORMAT=32-bit_rle_rgbe");
    assert_eq!(plain.pixels(), [Vec3::new(1.0, 0.5, 0.25), Vec3::new(800.0, 400.0, 200.0)]);
    let exposed = read("#?RGBE\nEXPOSURE=2\nEXPOSURE=4");
    assert_eq!(exposed.pixels()[0] * 8.0, plain.pixels()[0]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.hdr");
    fs::write(&path, two_pixel_hdr("#?RADIANCE")).unwrap();
    assert_eq!(super::read(&path).unwrap(), plain);
    assert!(read_rgb8(&path).unwrap_err().to_string().contains("8-bit PNG"));
}

#[test]
fn damaged_radiance_hdr_is_refused() {
    let good = two_pixel_hdr("#?RADIANCE");
    for cut in 0..good.len() {
        assert!(decode_hdr(&good[..cut], None).is_err(), "cut at {cut}");
    }
    let huge = |size: &str| [b"#?RADIANCE\n\n".as_slice(), size.as_bytes(), b"\n\x01\x01\x01\x80"].concat();
    for size in ["-Y 16000 +X 16000", "-Y 99999999 +X 99999999", "-Y 0 +X 5", "-Y -1 +X 5"] {
        assert!(decode_hdr(&huge(size), None).is_err(), "{size}");
    }
    for header in ["#?RADIANCE\nEXPOSURE=0", "#?RADIANCE\nEXPOSURE=inf", "#?RADIANCE\nFORMAT=32-bit_rle_xyze"] {
        assert!(decode_hdr(&two_pixel_hdr(header), None).is_err(), "{header}");
    }
}
