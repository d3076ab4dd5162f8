//! Scenes with few or no objects and lights.

use super::{CliSandbox, read};
use glam::Vec3;

const CAMERA: &str = "PerspectiveCamera { center 0 0 5 lookAt 0 0 0 angle 30 width 12 height 10 }\n";

/// Renders by ray casting and by the default integrator. Returns the pixels and messages of the
/// second render.
///
/// Fails if a render fails or the second one prints a warning.
fn pixels(text: &str) -> (Vec<Vec3>, String) {
    let sandbox = CliSandbox::new();
    sandbox.put("a.txt", format!("{CAMERA}{text}"));
    sandbox.render("a.txt", "-o a.exr --passes 2 --integrator raycast").expect(0, &[]);
    let ended = sandbox.render("a.txt", "-o a.exr -o a.png --passes 2 --stats a.json");
    ended.expect(0, &["wrote a.exr", "wrote a.png", "2 passes"]);
    assert!(!ended.stderr.contains("warning"), "{}", ended.stderr);
    (read(&sandbox.path("a.exr")).pixels().to_vec(), ended.stderr)
}

const LIGHT: &str = "Lights { PointLight { position 0 5 5 power 90 90 90 } }\n";
const BALL: &str = "Group { Sphere { center 0 0 0 radius 1 } }\n";

#[test]
fn scene_without_lights_renders_with_warning() {
    let (pixels, words) = pixels(&format!("Background {{ color .5 .25 1 }} {BALL}"));
    assert!(words.contains("note: the scene has no lights: all objects are black"), "{words}");
    assert!(pixels.iter().all(|p| p.cmple(Vec3::new(0.5, 0.25, 1.0)).all()));
    // The corners show the background, the center shows the ball.
    assert_eq!((pixels[0], pixels[5 * 12 + 6]), (Vec3::new(0.5, 0.25, 1.0), Vec3::ZERO));
}

#[test]
fn scene_without_objects_renders_background() {
    let (pixels, words) = pixels(&format!("Background {{ color .5 .25 1 }} {LIGHT} Group {{ }}"));
    assert!(words.contains("note: the scene has no objects: the picture shows only the background"), "{words}");
    assert!(pixels.iter().all(|p| *p == Vec3::new(0.5, 0.25, 1.0)));
}

#[test]
fn black_objects_render_black() {
    for text in [
        format!("Background {{ color 0 0 0 }} {BALL}"),
        "Background { color 0 0 0 } Group { }".to_owned(),
        format!("Background {{ color 0 0 0 }} {LIGHT} Materials {{ Diffuse {{ reflectance 0 0 0 }} }} {BALL}"),
        format!("Background {{ color 0 0 0 }} Lights {{ PointLight {{ position 0 5 5 power 0 0 0 }} }} {BALL}"),
        "Background { color 0 0 0 } Lights { SphereLight { center 0 0 0 radius 1 radiance 0 0 0 } } Group { }"
            .to_owned(),
    ] {
        let (pixels, words) = pixels(&text);
        assert!(words.contains("note: every pixel is black"), "{words}");
        assert!(pixels.iter().all(|p| *p == Vec3::ZERO));
    }
}

#[test]
fn lit_image_gives_no_black_warning() {
    let (pixels, words) = pixels(&format!("Background {{ color 0 0 0 }} {LIGHT} {BALL}"));
    assert!(!words.contains("note:"), "{words}");
    assert!(pixels.iter().any(|p| p.min_element() > 0.0));
}

#[test]
fn zero_photons_leave_direct_light() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o a.exr --photons 0 --caustic-photons 0 --stats a.json").expect(0, &[]);
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
    for map in ["global", "caustic"] {
        assert_eq!((&stats["photons"][map]["emitted"], &stats["photons"][map]["stored"]), (&0.into(), &0.into()));
    }
    assert_eq!((&stats["counters"]["photon_rays"], &stats["counters"]["gathers"]), (&0.into(), &0.into()));
    assert_eq!(stats["rates"]["photons_per_second"], 0.0);
    sandbox.render("box.txt", "-o b.exr").expect(0, &[]);
    let sum = |name: &str| read(&sandbox.path(name)).pixels().iter().map(|p| p.element_sum()).sum::<f32>();
    assert!(0.0 < sum("a.exr") && sum("a.exr") < sum("b.exr"), "indirect light is missing, direct light is not");
}

#[test]
fn one_pixel_with_one_photon_renders() {
    let sandbox = CliSandbox::new();
    sandbox.render("box.txt", "-o a.png --size 1x1 --photons 1 --caustic-photons 1").expect(0, &["wrote a.png"]);
}

#[test]
fn light_beyond_float_range_is_refused() {
    let sandbox = CliSandbox::new();
    let refused = |power: &str, texts: &[&str]| {
        let light = format!("Lights {{ PointLight {{ position 0 5 5 power {power} }} }}");
        sandbox.put("a.txt", format!("{CAMERA}{light}{BALL}"));
        sandbox.render("a.txt", "-o a.png --quiet").expect(1, texts);
    };
    refused("1e300 1 1", &["a.txt:2:44", "below 3.4e38"]);
    refused("3e38 3e38 1", &["light 0", "stronger than single precision"]);
}
