//! Values that a file format cannot hold are counted and reported.

use caustica::image::{
    self, BitDepth, ClippedPixelReport, ExrLayer, ExrPrecision, Image, OutputFormat, ToneCurve, ToneMap, WriteOptions,
};
use glam::Vec3;
use std::path::Path;
use std::process::Command;

/// Values around the range of 16-bit floats.
///
/// They are the largest 16-bit float, the next 32-bit float, the 32-bit floats on both sides of the
/// rounding limit to infinity, and larger values.
const EDGES: [f32; 6] = [65_504.0, 65_504.004, 65_519.996, 65_520.0, 1e30, f32::MAX];

fn write_and_read_pixel(value: f32, options: &WriteOptions, name: &str) -> (Vec3, ClippedPixelReport) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let report = image::write(&path, &Image::from_pixels(1, 1, vec![Vec3::new(0.5, value, 0.25)]).unwrap(), options);
    (image::read(&path).unwrap().pixels()[0], report.unwrap())
}

#[test]
fn half_floats_saturate_at_65504_with_report() {
    let options = WriteOptions { exr_precision: ExrPrecision::Half, ..WriteOptions::default() };
    for value in EDGES.into_iter().flat_map(|x| [x, -x]) {
        let (found, report) = write_and_read_pixel(value, &options, "a.exr");
        assert_eq!(found, Vec3::new(0.5, 65_504f32.copysign(value), 0.25), "{value}");
        let beyond = usize::from(value.abs() > 65_504.0);
        assert_eq!(report, ClippedPixelReport { too_bright: beyond, ..ClippedPixelReport::default() }, "{value}");
        let (found, report) = write_and_read_pixel(value, &WriteOptions::default(), "a.exr");
        assert_eq!((found.y, report), (value, ClippedPixelReport::default()), "32 bits hold {value}");
    }
    // Values in range are rounded to 11 bits by at most half a step. Below 2⁻¹⁴, the step is 2⁻²⁴.
    for value in [1.0 / 3.0, 1234.567, libm::exp2f(-14.0) * 1.3, 6e-8] {
        let (found, report) = write_and_read_pixel(value, &options, "a.exr");
        let step = libm::exp2f((libm::log2f(value).floor() - 10.0).max(-24.0));
        assert!((found.y - value).abs() <= 0.5 * step && report == ClippedPixelReport::default(), "{value}: {found}");
    }
    for value in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        let (found, report) = write_and_read_pixel(value, &options, "a.exr");
        assert!(found.y.to_bits() == value.to_bits() || found.y.is_nan() && value.is_nan(), "{value}: {found}");
        assert_eq!(report, ClippedPixelReport { non_finite: 1, ..ClippedPixelReport::default() }, "{value}");
    }
}

#[test]
fn sixteen_bit_png_saturates_at_white_with_report() {
    for curve in [ToneCurve::Srgb, ToneCurve::Legacy] {
        let tone = ToneMap { curve, exposure_stops: 0.0 };
        let options = WriteOptions { tone, bit_depth: BitDepth::Sixteen, ..WriteOptions::default() };
        let report = |value: f32| {
            let image = Image::from_pixels(1, 1, vec![Vec3::new(0.5, value, 0.25)]).unwrap();
            image::encode(OutputFormat::Png, &image, &options).unwrap().1
        };
        let clean = ClippedPixelReport::default();
        assert_eq!([report(0.0), report(-0.0), report(1.0)], [clean; 3]);
        for value in EDGES.into_iter().chain([1f32.next_up()]) {
            assert_eq!(report(value), ClippedPixelReport { too_bright: 1, ..clean }, "{value}");
            assert_eq!(report(-value), ClippedPixelReport { negative: 1, ..clean }, "{value}");
        }
        assert_eq!(report(f32::NAN), ClippedPixelReport { non_finite: 1, ..clean });
    }
}

#[test]
fn layers_report_non_finite_values() {
    let folder = tempfile::tempdir().unwrap();
    let values = vec![1.0, f32::INFINITY, f32::NAN, f32::MAX];
    let layer = ExrLayer { name: "noise".to_owned(), channels: vec![("R".to_owned(), values)] };
    assert_eq!(image::write_layers(&folder.path().join("a.exr"), (2, 2), &[layer], &[]).unwrap(), 2);
}

fn run_messages(scene: &str, folder: &Path, arguments: &str) -> (Option<i32>, String) {
    std::fs::write(folder.join("scene.txt"), scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.current_dir(folder).args(["render", "scene.txt"]).args(arguments.split(' '));
    let ended = command.output().unwrap();
    (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
}

/// The program reports values that a file format cuts off.
///
/// A light fills the upper half of the image with radiance 10⁵, as bright as a flame.
#[test]
fn program_reports_clipped_values() {
    let scene = "PerspectiveCamera { center 0 0 5  direction 0 0 -1  up 0 1 0  angle 30  width 8 height 8 }
        Background { color .5 .5 .5 }
        Lights { RectangleLight { corner -9 0 0  edge0 18 0 0  edge1 0 9 0  radiance 1e5 1e5 1e5 } }
        Materials { Diffuse grey { reflectance .5 .5 .5 } }
        Group { Sphere { center 0 -9 0 radius 1 } }";
    let folder = tempfile::tempdir().unwrap();
    let small = "--passes 2 --filter box --photons 1k --caustic-photons 1k";
    let say = |more: &str| run_messages(scene, folder.path(), &format!("{small} {more}"));
    let (code, text) = say("-o a.png --png-bits 16 -o half.exr --exr-bits 16");
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("note: 32 pixels of a.png: clipped to white"), "{text}");
    assert!(text.contains("warning: 32 pixels of half.exr: clipped to 65504; --exr-bits 32"), "{text}");
    let half = image::read(&folder.path().join("half.exr")).unwrap();
    assert_eq!((half.pixels()[0], half.pixels()[63]), (Vec3::splat(65_504.0), Vec3::splat(0.5)));
    // The report must be a warning, because `-q` hides notes.
    let (_, text) = say("-q -o a.png -o half.exr --exr-bits 16");
    assert!(text.contains("32 pixels of half.exr") && !text.contains("a.png"), "{text}");
    let (_, text) = say("-o whole.exr");
    assert!(!text.contains("cut off"), "{text}");
    let (code, text) = say("-o a.exr --exr-bits 12");
    assert!(code == Some(2) && text.contains("16 or 32"), "{text}");
}
