use super::*;
use crate::image::{ToneCurve, ToneMap, read};
use glam::Vec3;
use std::fs;

#[test]
fn the_extension_chooses_the_format() {
    let format = |path: &str| OutputFormat::from_path(Path::new(path)).ok();
    assert_eq!([format("a.png"), format("b/c.EXR")], [Some(OutputFormat::Png), Some(OutputFormat::Exr)]);
    for path in ["a.jpg", "png", ".png", ""] {
        let message = check_writable(Path::new(path)).unwrap_err().to_string();
        assert!(message.contains(".png") && message.contains(".exr"), "{message}");
    }
}

#[test]
fn written_pictures_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_pixels(2, 1, vec![Vec3::new(1.0, 0.0, 4.0), Vec3::splat(f32::NAN)]).unwrap();
    let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    let options = WriteOptions::default();
    let report = write(&png, &image, &options).unwrap();
    assert_eq!(report, ClippedPixelReport { non_finite: 1, too_bright: 1, negative: 0 });
    assert_eq!(read(&png).unwrap().pixels(), [Vec3::new(1.0, 0.0, 1.0), Vec3::ZERO]);
    assert_eq!(write(&exr, &image, &options).unwrap().non_finite, 1);
    assert_eq!(read(&exr).unwrap().pixels()[0], image.pixels()[0]);
}

#[test]
fn bad_options_leave_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    let image = Image::new(1, 1).unwrap();
    let long = "k".repeat(80);
    for (key, text) in [("", "x"), (long.as_str(), "x"), (" k", "x"), ("Ω", "x"), ("a  b", "x"), ("k", "a\0b")] {
        let options = WriteOptions { metadata: vec![(key.to_owned(), text.to_owned())], ..Default::default() };
        assert!(matches!(write(&path, &image, &options), Err(WriteError::Metadata { .. })), "{key:?} {text:?}");
    }
    let tone = ToneMap { curve: ToneCurve::Srgb, exposure_stops: f32::NAN };
    let options = WriteOptions { tone, ..Default::default() };
    assert!(matches!(write(&path, &image, &options), Err(WriteError::Exposure { .. })));
    assert_eq!(fs::read(&path).unwrap(), b"old");
}

#[test]
fn both_formats_store_the_longest_metadata_key() {
    let image = Image::new(1, 1).unwrap();
    let options = WriteOptions { metadata: vec![("k".repeat(79), "line\nline".to_owned())], ..Default::default() };
    for format in [OutputFormat::Png, OutputFormat::Exr] {
        encode(format, &image, &options).unwrap();
    }
}
