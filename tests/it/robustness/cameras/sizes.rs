//! Images of one pixel, one column and one row.

use super::resolved_scene;
use crate::support::render_one_pass;
use caustica::camera::{Filter, FilterKind};
use caustica::color::Rgb;
use caustica::image::flip::{FlipMetricOptions, flip_metric};
use caustica::image::{
    BitDepth, Image, OutputFormat, PixelMeaning, ToneCurve, ToneMap, WriteOptions, decode, encode, metrics,
};
use caustica::integrate::{Algorithm, CameraPathSettings, FinalGathering, Settings, SilentMonitor};
use caustica::render::{RenderResult, StopCriteria, render};
use std::path::Path;
use std::sync::atomic::AtomicBool;

const SIZES: [(u32, u32); 3] = [(1, 1), (1, 20_000), (20_000, 1)];

const ROOM: &str = "Background { color .1 .2 .3 } \
    Lights { RectangleLight { corner -.4 1.99 -.4 edge0 .8 0 0 edge1 0 0 .8 radiance 9 8 7 } } \
    Materials { Diffuse white { reflectance .7 .6 .5 } Dielectric glass { indexOfRefraction 1.5 } } \
    Group { MaterialName white Plane { normal 0 1 0 offset 0 } MaterialName glass Sphere { center 0 .5 0 radius .5 } }";

fn cameras((width, height): (u32, u32)) -> [String; 3] {
    let common = format!("center 0 1 4 direction 0 -.1 -1 up 0 1 0 width {width} height {height}");
    [
        format!("PerspectiveCamera {{ {common} angle 35 aperture .05 focusDistance 4 }}"),
        format!("OrthographicCamera {{ {common} size {} }}", if width > height { 1e-4 } else { 2.0 }),
        format!("EnvironmentCamera {{ {common} }}"),
    ]
}

/// Every integrator renders images of one pixel, one column and one row with error estimation.
///
/// All results are finite.
#[test]
fn tiny_images_are_finite_with_every_integrator() {
    for size in SIZES {
        for (i, camera) in cameras(size).into_iter().enumerate() {
            let scene = resolved_scene(&format!("{camera} {ROOM}")).unwrap();
            for algorithm in Algorithm::ALL {
                // Images of one pixel are cheap, so every integrator renders them with all cameras.
                // Each integrator renders long images with one camera.
                if size != (1, 1) && i != algorithm as usize % 3 {
                    continue;
                }
                let estimated = algorithm != Algorithm::Raycast;
                let camera_paths = CameraPathSettings {
                    samples_per_pixel: Some(1),
                    estimate_error: estimated,
                    max_bounces: 8,
                    ..CameraPathSettings::default()
                };
                let settings = Settings {
                    camera_paths,
                    unaimed_paths: 2000,
                    aimed_paths: 2000,
                    allows_ray_photon_balance: false,
                    final_gathering: FinalGathering::Bsdf,
                    ..Settings::default()
                };
                let integrator = algorithm.prepare(&scene, settings);
                let passes = if estimated { 4 } else { 1 };
                let interrupted = AtomicBool::new(false);
                let stop = StopCriteria { max_passes: Some(passes), ..StopCriteria::unlimited(&interrupted) };
                let start = RenderResult::without_passes(integrator.as_ref(), size);
                let rendered = render(start, 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |_| {});
                let what = format!("{algorithm:?} {camera}");
                let mean = rendered.film.mean_picture();
                assert_eq!(mean.len() as u64, u64::from(size.0) * u64::from(size.1), "{what}");
                assert!(mean.iter().all(|p| p.is_finite()), "{what}");
                let counters = rendered.counters;
                assert_eq!((counters.rejected_samples, counters.rejected_photons), (0, 0), "{what}");
                let Some(estimator) = rendered.estimator else { continue };
                let estimate = estimator.estimate(&rendered.film);
                let numbers =
                    [estimate.error, estimate.noise, estimate.bias, estimate.blur, estimate.shared_paths, estimate.low];
                assert!(numbers.iter().all(|x| x.is_finite() && *x >= 0.0), "{what}: {estimate:?}");
                let maps = estimator.error_maps(&rendered.film);
                assert!(maps.noise.iter().chain(&maps.blur).all(|x| x.is_finite()), "{what}");
            }
        }
    }
}

/// Pixels of images with 20,000 rows or columns are at the right place.
///
/// A light fills the view from one row or column on. Pixels before it are black, and pixels after
/// it bright. With the box filter, a pixel covers nothing beyond itself.
#[test]
fn images_20000_pixels_long_are_correct() {
    let edge = 12_345u32;
    for (width, height) in [(1u32, 20_000u32), (20_000, 1)] {
        let column = height > width;
        // The camera's film is 10⁻⁴ × 2 or 2 × 10⁻⁴. The light begins in the middle of pixel
        // `edge`.
        let begin = 2.0 * (f64::from(edge) + 0.5) / 20_000.0 - 1.0;
        let size = if column { 2.0 } else { 1e-4 };
        let (corner, e0, e1) = match column {
            true => (format!("-9 {} -1", -begin - 9.0), "18 0 0", "0 9 0"),
            false => (format!("{begin} -9 -1"), "9 0 0", "0 18 0"),
        };
        let scene = resolved_scene(&format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 width {width} height {height} size {size} }} \
             Background {{ color 0 0 0 }} \
             Lights {{ RectangleLight {{ corner {corner} edge0 {e0} edge1 {e1} radiance 1 1 1 }} }} Group {{ }}"
        ))
        .unwrap();
        let camera_paths = CameraPathSettings {
            samples_per_pixel: Some(4),
            filter: Filter::new(FilterKind::Box),
            ..CameraPathSettings::default()
        };
        let settings = Settings { camera_paths, allows_ray_photon_balance: false, ..Settings::default() };
        let image = render_one_pass(&*Algorithm::Path.prepare(&scene, settings), 0);
        for (i, pixel) in image.iter().enumerate() {
            match i as u32 {
                i if i < edge => assert_eq!(*pixel, Rgb::ZERO, "{width}×{height}: pixel {i}"),
                i if i > edge => assert_eq!(*pixel, Rgb::ONE, "{width}×{height}: pixel {i}"),
                // The pixel is half bright: of four stratified samples, at most one lies on the
                // wrong side of the middle.
                _ => assert!((0.25..=0.75).contains(&pixel.x), "{width}×{height}: {pixel}"),
            }
        }
    }
}

/// Tiny images are written, read and compared like others.
#[test]
fn tiny_images_have_files_and_metrics() {
    for (width, height) in SIZES {
        let count = width * height;
        let value = |i: u32| Rgb::new(i as f32 / count as f32, 0.5, 1.0 - i as f32 / count as f32);
        let image = Image::from_pixels(width, height, (0..count).map(value).collect()).unwrap();
        let tone = ToneMap { curve: ToneCurve::Srgb, exposure_stops: 0.0 };
        for (format, depth) in [
            (OutputFormat::Exr, BitDepth::Eight),
            (OutputFormat::Png, BitDepth::Eight),
            (OutputFormat::Png, BitDepth::Sixteen),
        ] {
            let options = WriteOptions { tone, bit_depth: depth, ..WriteOptions::default() };
            let (file, report) = encode(format, &image, &options).unwrap();
            assert_eq!(report.non_finite, 0);
            let (back, _) = decode(Path::new("memory"), &file, PixelMeaning::Color, None).unwrap();
            assert_eq!((back.width(), back.height()), (width, height));
            // The bound is half a level times the greatest slope of the inverse sRGB curve,
            // 2.4/1.055 (see `reading_undoes_srgb_to_half_a_level`).
            let bound = match (format, depth) {
                (OutputFormat::Exr, _) => 0.0,
                (_, BitDepth::Eight) => 0.5 / 255.0 * 2.275,
                (_, BitDepth::Sixteen) => 0.5 / 65_535.0 * 2.275 + f64::from(f32::EPSILON),
            };
            let differences = metrics::largest_differences(&back, &image).unwrap().largest;
            let off = differences.iter().flatten().map(|largest| largest.difference).fold(0.0, f64::max);
            assert!(off <= bound, "{width}×{height} {format:?}: {off:e}");
        }
        let other = Image::new(width, height).unwrap();
        let looks = flip_metric(&image, &other, &FlipMetricOptions::default()).unwrap();
        assert!(looks.mean.is_finite() && looks.mean > 0.0, "{width}×{height}: {}", looks.mean);
        assert_eq!(flip_metric(&image, &image, &FlipMetricOptions::default()).unwrap().mean, 0.0);
    }
}
