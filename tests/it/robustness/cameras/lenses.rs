//! Lenses of zero aperture, and focus distances of zero, near zero or near infinity.

use super::{assert_refused, resolved_scene};
use crate::support::render_one_pass;
use caustica::camera::{Camera, Lens};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use glam::{DVec3, Vec2};

const BALLS: &str = "Background { color .1 .2 .3 } \
    Lights { RectangleLight { corner -.4 1.99 -.4 edge0 .8 0 0 edge1 0 0 .8 radiance 9 8 7 } PointLight { position 0 1 2 power 5 5 5 } } \
    Materials { Diffuse white { reflectance .7 .6 .5 } Dielectric glass { indexOfRefraction 1.5 } Mirror silver { reflectance .9 .9 .9 } } \
    Group { MaterialName white Plane { normal 0 1 0 offset 0 } MaterialName glass Sphere { center .3 .4 .2 radius .4 } \
    MaterialName silver Sphere { center -.6 .4 -.3 radius .4 } }";

fn scene(lens: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0 1 4 direction 0 -.1 -1 up 0 1 0 angle 35 width 24 height 18 {lens} }} {BALLS}"
    )
}

/// A lens of zero aperture equals a pinhole in every bit of every integrator's image; an open lens
/// does not.
#[test]
fn zero_aperture_equals_pinhole_bit_for_bit() {
    let picture = |algorithm: Algorithm, lens: &str| {
        let camera_paths =
            CameraPathSettings { samples_per_pixel: Some(2), estimate_error: true, ..CameraPathSettings::default() };
        let settings = Settings {
            camera_paths,
            unaimed_paths: 2000,
            aimed_paths: 2000,
            allows_ray_photon_balance: false,
            ..Settings::default()
        };
        let scene = resolved_scene(&scene(lens)).unwrap();
        let image = render_one_pass(&*algorithm.prepare(&scene, settings), 0);
        assert!(image.iter().all(|p| p.is_finite()));
        image.iter().flat_map(|p| p.to_array().map(f32::to_bits)).collect::<Vec<_>>()
    };
    for algorithm in Algorithm::ALL {
        let pinhole = picture(algorithm, "");
        for shut in ["aperture 0 focusDistance 3", "aperture 0 focusAt 0 0 0 blades 6", "aperture 0 focusDistance 1e-9"]
        {
            assert!(picture(algorithm, shut) == pinhole, "{algorithm:?} {shut}");
        }
        // `Raycast` and `Whitted` trace only rays through the lens center.
        if !matches!(algorithm, Algorithm::Raycast | Algorithm::Whitted) {
            assert!(picture(algorithm, "aperture .1 focusDistance 3") != pinhole, "{algorithm:?}");
        }
    }
}

#[test]
fn zero_focus_distance_is_refused_with_remedy() {
    for (lens, place) in [
        ("aperture .1 focusDistance 0", "0"),
        ("aperture .1 focusDistance -2", "-2"),
        ("aperture 0 focusDistance 0", "0"),
        ("fNumber 2 focusDistance 0", "0"),
    ] {
        assert_refused(&scene(lens), place, &["focusDistance", "above 0"]);
    }
    // The points are the camera's center and a point behind it.
    for point in ["0 1 4", "0 1 5"] {
        assert_refused(&scene(&format!("aperture .1 focusAt {point}")), point, &["in front of the camera"]);
    }
    assert_refused(&scene("aperture .1"), "PerspectiveCamera", &["focusDistance"]);
    assert_refused(&scene("aperture -1 focusDistance 1"), "-1", &["negative"]);
    assert_refused(&scene("fNumber 0 focusDistance 1"), "0", &["fNumber"]);
    for lens in ["aperture .1 focusDistance 1e-13", "aperture 0 focusDistance 1e-300"] {
        assert_refused(&scene(lens), "PerspectiveCamera", &["focused nearer", "1e-12"]);
    }
    for lens in ["aperture .1 focusDistance 1e12", "aperture 1e13 focusDistance 1", "fNumber 1e-15 focusDistance 1"] {
        assert_refused(&scene(lens), "PerspectiveCamera", &["single precision", "focus nearer"]);
    }
}

/// Rays through all of a lens converge at the focus point, at any camera position and focus
/// distance.
///
/// A ray's origin has an error of 2⁻²⁴ of the camera's coordinates, and its direction of 2⁻²⁵ per
/// axis. Both points, on the lens and in focus, are relative to the lens center. So the direction
/// between them is accurate to 2⁻²⁵ and double-precision rounding.
#[test]
fn lens_rays_converge_at_any_focus_distance() {
    let (forward, up) = (DVec3::new(1.0, 2.0, -2.0) / 3.0, DVec3::Y);
    let right = forward.cross(up).normalize();
    let upright = right.cross(forward);
    for center in [DVec3::ZERO, DVec3::new(3e4, -1e5, 7.0)] {
        for focus in [1e-12, 1e-6, 1.0, 1e6, 9e11] {
            for radius in [1e-12, 1e-3, 1.0, 1e6] {
                let lens = Lens { radius, focus_distance: focus, blades: 0 };
                let camera = Camera::perspective(center, forward, up, 1.0, 8, 6).unwrap().with_lens(lens);
                // A camera at the origin that looks along −z has the same lens. The origins of its
                // rays are the lens points of the samples u.
                let flat = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 8, 6).unwrap().with_lens(lens);
                for u in [(0.5, 0.5), (0.0, 0.0), (0.9, 0.2), (0.51, 0.5)].map(Vec2::from) {
                    for p in [(0.0, 0.0), (4.0, 3.0), (7.5, 1.0)].map(Vec2::from) {
                        let on = flat.generate_ray(p, Some(u)).origin.as_dvec3();
                        let tangent = libm::tan(0.5) / 3.0;
                        let (x, y) = (tangent * (f64::from(p.x) - 4.0), tangent * (3.0 - f64::from(p.y)));
                        let to = (forward + x * right + y * upright) * focus - (on.x * right + on.y * upright);
                        let found = camera.generate_ray(p, Some(u));
                        let off = (found.direction.as_dvec3() - to.normalize()).abs().max_element();
                        // The lens point is accurate to 2⁻²⁴. Its error rotates the direction by at
                        // most as much.
                        assert!(
                            off <= libm::exp2(-25.0) + libm::exp2(-24.0) * 2f64.sqrt(),
                            "{center} {focus:e} {radius:e} {u} {p}: {off:e}"
                        );
                        assert!(found.origin.is_finite());
                    }
                }
            }
        }
    }
}

/// Extreme lenses give images without non-finite pixels or rejected samples.
#[test]
fn extreme_lenses_give_finite_images() {
    for lens in [
        "aperture 1e-12 focusDistance 1e-12",
        "aperture 1e-40 focusDistance 1e-11",
        "aperture .1 focusDistance 1e-12",
        "aperture .1 focusDistance 9e11",
        "aperture 1e6 focusDistance 1e-3",
        "fNumber 3e38 focusDistance 1",
        "fNumber 1.4 sensorHeight 1e-9 focusDistance 2 blades 3",
    ] {
        let camera_paths = CameraPathSettings { samples_per_pixel: Some(4), ..CameraPathSettings::default() };
        let settings = Settings {
            camera_paths,
            unaimed_paths: 500,
            aimed_paths: 500,
            allows_ray_photon_balance: false,
            ..Settings::default()
        };
        let scene = resolved_scene(&scene(lens)).unwrap();
        let image = render_one_pass(&*Algorithm::Hybrid.prepare(&scene, settings), 0);
        assert!(image.iter().all(|p| p.is_finite()), "{lens}");
    }
}
