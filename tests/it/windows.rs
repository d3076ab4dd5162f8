//! Windows of pictures, and clamped light.

use crate::support::{scene_from_file, scene_from_text};
use caustica::camera::CropWindow;
use caustica::integrate::{
    Algorithm, AovSurface, CameraPathSettings, PassResult, Settings, SilentMonitor, render_surface_aovs,
};
use caustica::render::{RenderResult, StopCriteria, render};
use caustica::scene::{Effects, Scene};
use glam::Vec3;
use std::sync::atomic::AtomicBool;

/// Returns the pixels of `whole`, a picture of `width` columns, that lie in `window`.
fn cut<T: Clone>(whole: &[T], width: u32, window: CropWindow) -> Vec<T> {
    let pixels = (window.top..window.bottom).flat_map(|y| (window.left..window.right).map(move |x| y * width + x));
    pixels.map(|i| whole[i as usize].clone()).collect()
}

fn cheap(camera_paths: CameraPathSettings) -> Settings {
    Settings { camera_paths, unaimed_paths: 3000, aimed_paths: 3000, ..Settings::default() }
}

#[test]
fn windows_have_the_bits_of_the_whole_picture() {
    let window = CropWindow { left: 5, top: 7, right: 38, bottom: 26 };
    check_windows(&["glass-ball"], window);
}

#[test]
#[ignore = "long: windows of many scenes"]
fn windows_of_many_scenes_have_their_bits() {
    check_windows(&["lens-in-fog", "motion", "ring"], CropWindow { left: 17, top: 1, right: 48, bottom: 30 });
}

/// Checks `window` of pictures of 48 × 36 pixels of scenes of the repository.
fn check_windows(scenes: &[&str], window: CropWindow) {
    for name in scenes {
        let scene = scene_from_file(&format!("scenes/{name}.txt"), (48, 36));
        for algorithm in Algorithm::ALL {
            let pass = |crop: Option<CropWindow>| -> PassResult {
                let settings = CameraPathSettings {
                    crop,
                    groups_light: true,
                    estimate_error: algorithm != Algorithm::Raycast,
                    ..CameraPathSettings::default()
                };
                algorithm.prepare(&scene, cheap(settings)).render_pass(1, &SilentMonitor)
            };
            let (whole, part) = (pass(None), pass(Some(window)));
            let what = format!("{name}, {}", algorithm.name());
            assert_eq!(part.image, cut(&whole.image, 48, window), "{what}");
            for (part, whole) in part.light_groups.iter().zip(&whole.light_groups) {
                assert_eq!(*part, cut(whole, 48, window), "{what}");
            }
            if !whole.nested.is_empty() {
                assert_eq!(part.nested, cut(&whole.nested, 48, window), "{what}");
            }
        }
        let aovs = |crop| {
            let settings = CameraPathSettings { crop, ..CameraPathSettings::default() };
            render_surface_aovs(&scene, Effects::ALL, &settings, AovSurface::First, 8, &SilentMonitor).unwrap()
        };
        let (whole, part) = (aovs(None), aovs(Some(window)));
        assert_eq!(part.albedo, cut(&whole.albedo, 48, window), "{name}");
        assert_eq!(part.depth, cut(&whole.depth, 48, window), "{name}");
    }
}

fn render_with(scene: &Scene, algorithm: Algorithm, settings: CameraPathSettings, passes: u32) -> RenderResult {
    // Aimed prefix rays would divide the light of a small lamp among many rays, so that no ray
    // exceeds the clamping limit.
    let settings = Settings { allows_prefix_rays: false, ..cheap(settings) };
    let integrator = algorithm.prepare(scene, settings);
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { max_passes: Some(passes), ..StopCriteria::unlimited(&interrupted) };
    let start = RenderResult::without_passes(integrator.as_ref(), scene.camera().size());
    render(start, 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |_| {})
}

#[test]
fn clamped_and_removed_light_add_up() {
    let scene = scene_from_file("scenes/glass-ball.txt", (24, 18));
    for algorithm in [Algorithm::Path, Algorithm::Hybrid, Algorithm::Sppm] {
        let settings = |clamp| CameraPathSettings { clamp, groups_light: true, ..CameraPathSettings::default() };
        let whole = render_with(&scene, algorithm, settings(None), 2);
        let clamped = render_with(&scene, algorithm, settings(Some(1.5)), 2);
        let removed = clamped.clamping_loss_film.as_ref().unwrap().mean_picture();
        let groups: Vec<Vec<Vec3>> = clamped.light_group_films.iter().map(|film| film.mean_picture()).collect();
        for (i, ((picture, removed), whole)) in
            clamped.film.mean_picture().iter().zip(&removed).zip(whole.film.mean_picture()).enumerate()
        {
            assert!((*picture + *removed - whole).abs().max_element() <= 1e-5 * whole.max_element(), "{i}");
            let sum = groups[0][i] + groups[1][i] + groups[2][i];
            assert!((sum - *picture).abs().max_element() <= 1e-5 * picture.max_element(), "{i}: {sum} {picture}");
        }
        let fraction = clamped.clamping_loss_fraction().unwrap();
        // The lamp, whose radiance is 15, covers a part of the picture.
        assert!(fraction > 0.01 && fraction < 0.5, "{}: {fraction}", algorithm.name());
        assert_eq!(whole.clamping_loss_fraction(), None);
    }
}

/// A background of radiance 1.1 clamped to 1 loses 0.1 everywhere, and its error is known.
#[test]
fn clamped_background_has_known_bias() {
    let scene = scene_from_text(
        "PerspectiveCamera { center 0 0 5  lookAt 0 0 0  angle 40  width 8  height 8 }\n\
         Background { color 1.1 1.1 1.1 }\n\
         Lights { PointLight { position 3 3 30  intensity 1 1 1 } }\n\
         Materials { Diffuse white { reflectance .7 .7 .7 } }\n\
         Group { MaterialName white  Sphere { center 0 0 50  radius 1 } }\n",
    );
    let settings = CameraPathSettings { clamp: Some(1.0), estimate_error: true, ..CameraPathSettings::default() };
    let rendered = render_with(&scene, Algorithm::Path, settings, 4);
    assert!(rendered.film.mean_picture().iter().all(|pixel| (*pixel - Vec3::ONE).abs().max_element() < 1e-6));
    assert!((rendered.clamping_loss_fraction().unwrap() - 0.1 / 1.1).abs() < 1e-6);
    let estimate = rendered.estimator.as_ref().unwrap().estimate(&rendered.film);
    // Errors are relative to √(L² + median²), which is √2 here.
    let expected = 0.1 / std::f64::consts::SQRT_2;
    assert!((estimate.clamping - expected).abs() < 1e-6, "{} {expected}", estimate.clamping);
    assert_eq!((estimate.bias, estimate.noise), (estimate.clamping, 0.0));
    assert!([estimate.error, estimate.low, estimate.high].iter().all(|end| (end - expected).abs() < 1e-6));
    let forecast = rendered.estimator.as_ref().unwrap().forecast(&estimate).unwrap();
    assert!((forecast.error_after_passes(1000) - expected).abs() < 1e-6, "more passes do not help");
}
