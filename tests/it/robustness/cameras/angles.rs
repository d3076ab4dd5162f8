//! Fields of view from a millionth of a degree to nearly 180°, and up directions.

use super::{assert_refused, resolved_scene};
use crate::support::render_one_pass;
use caustica::camera::{Camera, Filter, FilterKind};
use caustica::color;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use glam::{DVec2, DVec3, Vec2};

/// Returns pairs of a view direction and an up direction.
fn views() -> [(DVec3, DVec3); 4] {
    let oblique = DVec3::new(1.0, 2.0, -2.0) / 3.0;
    [(DVec3::NEG_Z, DVec3::Y), (DVec3::X, DVec3::Z), (oblique, DVec3::Y), (-oblique, DVec3::new(0.3, 5.0, 1.0))]
}

/// Returns points of an image: its corners, the middles of its sides, and others.
fn points(width: u32, height: u32) -> impl Iterator<Item = DVec2> {
    let (w, h) = (f64::from(width), f64::from(height));
    [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h), (0.5 * w, 0.0), (0.0, 0.5 * h), (0.25 * w, 0.75 * h), (0.5 * w, 0.5 * h)]
        .into_iter()
        .map(|(x, y)| DVec2::new(x, y))
}

/// A ray through a point of the image has the tangents that the field of view gives it.
///
/// Rows are evenly spaced in the tangent. Each component of a unit direction rounds to single
/// precision once, by at most 2⁻²⁵, half an ulp below 1. The errors of steps in double precision
/// are near 10⁻¹⁵.
#[test]
fn perspective_directions_match_tangent_at_every_angle() {
    for angle in [1e-6, 1e-3, 0.1, 1.0, 60.0, 120.0, 179.0, 179.9, 179.999] {
        for (width, height) in [(1, 1), (4, 3), (960, 720), (1, 20_000)] {
            for (forward, up) in views() {
                let camera =
                    Camera::perspective(DVec3::ONE, forward, up, f64::to_radians(angle), width, height).unwrap();
                let right = forward.cross(up).normalize();
                let up = right.cross(forward);
                let tangent = libm::tan(0.5 * angle.to_radians());
                for p in points(width, height) {
                    let y = tangent * (1.0 - 2.0 * p.y / f64::from(height));
                    let x = tangent * (2.0 * p.x - f64::from(width)) / f64::from(height);
                    let expected = (forward + x * right + y * up).normalize();
                    let found = camera.generate_ray(p.as_vec2(), None).direction.as_dvec3();
                    let off = (found - expected).abs().max_element();
                    assert!(off <= libm::exp2(-25.0) + 1e-14, "{angle}° {width}×{height} {p}: {off:e}");
                }
            }
        }
    }
}

/// A camera that looks along an axis keeps its field of view, however narrow it is.
///
/// The small components of directions keep all their digits. So the angle from top to bottom is
/// accurate to 2⁻²³, two roundings.
#[test]
fn narrow_images_keep_their_field_of_view() {
    for angle in [1e-300, 1e-30, 1e-6, 1e-3] {
        let radians = f64::to_radians(angle);
        let camera = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, radians, 3, 3).unwrap();
        let ends = [0.0, 3.0].map(|y| camera.generate_ray(Vec2::new(1.5, y), None).direction);
        assert!(ends.iter().all(|d| d.is_finite() && d.z == -1.0), "{ends:?}");
        let found = f64::from(ends[0].y) - f64::from(ends[1].y);
        // Angles below the range of single precision become zero.
        if angle > 1e-35 {
            assert!((found / radians - 1.0).abs() < libm::exp2(-23.0), "{angle}: {found:e}");
        } else {
            assert_eq!(found, 0.0);
        }
    }
}

/// A light that covers .6 × .6 of the image has the right mean at every field of view.
///
/// The mean is .36 of the light's radiance. Rays are evenly spread over the pixels, and each one
/// sees the light or not. For n independent rays, Hoeffding's bound is √(ln(2/10⁻⁶)/2n). Let T be
/// the tangent of half the field of view. A direction error of 2⁻²⁵ √3 moves an edge of the light
/// by (T + 1/T) 2⁻²⁴, relative to half the image width. There are two edges per axis.
#[test]
fn visible_light_has_correct_mean_at_extreme_angles() {
    let side = 16u32;
    let mut tried = 0;
    for angle in [0.001, 0.1, 30.0, 120.0, 179.0, 179.9, 179.99] {
        for (i, (forward, up)) in views().into_iter().enumerate() {
            let tangent = libm::tan(0.5 * f64::to_radians(angle));
            let right = forward.cross(up).normalize();
            let upright = right.cross(forward);
            let corner = forward - 0.6 * tangent * (right + upright);
            let (e0, e1) = (1.2 * tangent * right, 1.2 * tangent * upright);
            let words = |v: DVec3| format!("{:e} {:e} {:e}", v.x, v.y, v.z);
            let scene = resolved_scene(&format!(
                "PerspectiveCamera {{ center 0 0 0 direction {} up {} angle {angle} width {side} height {side} }} \
                 Background {{ color 0 0 0 }} \
                 Lights {{ RectangleLight {{ corner {} edge0 {} edge1 {} radiance 2 2 2 }} }} Group {{ }}",
                words(forward),
                words(up),
                words(corner),
                words(e0),
                words(e1)
            ))
            .unwrap();
            let camera_paths = CameraPathSettings {
                samples_per_pixel: Some(256),
                filter: Filter::new(FilterKind::Box),
                seed: 7 + i as u64,
                ..CameraPathSettings::default()
            };
            let settings = Settings { camera_paths, allows_ray_photon_balance: false, ..Settings::default() };
            let image = render_one_pass(&*Algorithm::Path.prepare(&scene, settings), 0);
            assert!(image.iter().all(|p| p.is_finite()), "{angle}°");
            let mean = image.iter().map(|p| f64::from(color::channel_mean(*p))).sum::<f64>() / image.len() as f64 / 2.0;
            let rays = f64::from(side * side * 256);
            let chance = (libm::log(2.0 / 1e-6) / (2.0 * rays)).sqrt();
            let moved = 4.0 * (tangent + 1.0 / tangent) * libm::exp2(-24.0);
            assert!((mean - 0.36).abs() < chance + moved, "{angle}° along {forward}: {mean} ± {chance} ± {moved}");
            tried += 1;
        }
    }
    assert_eq!(tried, 28);
}

/// Invalid angles are refused, and so are pixels so narrow that their rays would coincide.
///
/// The error points at the angle in the scene text.
#[test]
fn impossible_angles_are_refused_with_remedy() {
    let camera = |angle: &str, size: &str| {
        format!("PerspectiveCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 angle {angle} {size} }} Group {{ }}")
    };
    for angle in ["0", "-1", "180", "181", "1e300"] {
        assert_refused(&camera(angle, ""), angle, &["between 0 and 180 degrees"]);
    }
    // The limit is a width of 2⁻²⁴: 2 tan(a/2)/720 for a = 720 · 2⁻²⁴ rad = .002459°.
    for (angle, size) in [("1e-6", "width 1 height 1"), ("2.45e-3", ""), ("5e-324", "width 1 height 1")] {
        assert_refused(
            &camera(angle, size),
            "PerspectiveCamera",
            &["rad wide", "larger `angle`", "OrthographicCamera"],
        );
    }
    for (angle, size) in
        [("4e-6", "width 1 height 1"), ("2.47e-3", ""), ("179.9", ""), ("179.9", "width 1 height 20000")]
    {
        assert!(resolved_scene(&camera(angle, size)).is_ok(), "{angle} {size}");
    }
    // At 60°, a row of 20,000 pixels reaches 11,547 times as far sideways as ahead. At 179.9°, it
    // would reach two thousand times further.
    assert!(resolved_scene(&camera("60", "width 20000 height 1")).is_ok());
    for (angle, size) in [("179.9", "width 20000 height 1"), ("179.9999", "")] {
        assert_refused(&camera(angle, size), "PerspectiveCamera", &["aside", "smaller `angle`", "EnvironmentCamera"]);
    }
}

const KINDS: [&str; 3] = ["PerspectiveCamera { angle 40", "OrthographicCamera { size 2", "EnvironmentCamera {"];

#[test]
fn up_along_view_is_refused_with_remedy() {
    for kind in KINDS {
        for (aim, up) in [
            ("direction 0 0 -1", "0 0 -2"),
            ("direction 0 0 -1", "0 0 7"),
            ("direction 1 2 -2", "-2 -4 4"),
            // The sine of the angle between view direction and `up` is 10⁻¹⁰.
            ("direction 0 0 -1", "0 1e-10 1"),
            ("lookAt 1 3 3", "0 3 -2"),
        ] {
            let center = if aim.starts_with("lookAt") { "1 0 5" } else { "0 0 5" };
            assert_refused(
                &format!("{kind} center {center} {aim} up {up} }} Group {{ }}"),
                up,
                &["parallel", "`up`", "0 0 1"],
            );
        }
        // Without `up`, the up vector is 0 1 0. So the error points at the direction.
        assert_refused(&format!("{kind} center 0 0 5 direction 0 1 0 }} Group {{ }}"), "0 1 0", &["parallel", "`up`"]);
        assert_refused(&format!("{kind} center 0 0 5 direction 0 1 0 up 0 0 0 }} Group {{ }}"), "0 0 0", &[]);
    }
}

/// An `up` that is nearly the view direction is accepted, and determines the vertical axis of the
/// image.
///
/// `up` is the view direction plus a perpendicular step, with sine s of the angle between both. The
/// image's up vector is a product whose terms cancel down to s. So its error is a few times 2⁻⁵³/s:
/// 4 · 1.1·10⁻¹⁶ / 10⁻⁸ = 4.4·10⁻⁸. Directions round by 2⁻²⁵ = 3·10⁻⁸.
#[test]
fn up_nearly_along_view_is_kept() {
    for sine in [1e-2, 1e-5, 1e-8] {
        for (forward, across) in [
            (DVec3::NEG_Z, DVec3::X),
            (DVec3::new(0.6, 0.8, 0.0), DVec3::Z),
            (DVec3::new(1.0, 2.0, -2.0) / 3.0, DVec3::new(2.0, 1.0, 2.0) / 3.0),
        ] {
            let up = forward + sine * across;
            let camera = Camera::perspective(DVec3::ZERO, forward, up, 1.0, 2, 2).unwrap();
            let found = camera.generate_ray(Vec2::new(1.0, 0.0), None).direction.as_dvec3();
            let expected = (forward + libm::tan(0.5) * across).normalize();
            assert!((found - expected).abs().max_element() < 8e-8, "{sine} {forward}: {found} {expected}");
        }
    }
}

/// Orthographic rays start at the positions of rows and columns, up to one rounding of each
/// coordinate.
#[test]
fn orthographic_images_of_any_size_are_correct() {
    for size in [1e-30, 1e-6, 1.0, 1e12] {
        for (width, height) in [(1, 1), (1, 20_000), (20_000, 1)] {
            for (forward, up) in views() {
                let camera = Camera::orthographic(DVec3::ZERO, forward, up, size, width, height).unwrap();
                let right = forward.cross(up).normalize();
                let up = right.cross(forward);
                for p in points(width, height) {
                    let pixel = size / f64::from(height);
                    let middle = 0.5 * DVec2::new(f64::from(width), f64::from(height));
                    let expected = pixel * ((p.x - middle.x) * right + (middle.y - p.y) * up);
                    let ray = camera.generate_ray(p.as_vec2(), None);
                    let off = (ray.origin.as_dvec3() - expected).abs().max_element();
                    let bound = expected.abs().max_element() * libm::exp2(-24.0) + 1e-15 * pixel * middle.length();
                    assert!(off <= bound, "{size} {width}×{height} {p}: {off:e}");
                    assert!((ray.direction.as_dvec3() - forward).abs().max_element() <= libm::exp2(-25.0));
                }
            }
        }
    }
}

/// Panoramas of one pixel, a row or a column cover the whole sphere of directions.
///
/// Each pixel has the right longitude and latitude, whatever the image's other side length.
#[test]
fn panoramas_of_any_size_cover_the_sphere() {
    for (width, height) in [(1, 1), (2, 1), (1, 20_000), (20_000, 1)] {
        for (forward, up) in views() {
            let camera = Camera::panorama(DVec3::ZERO, forward, up, width, height).unwrap();
            let right = forward.cross(up).normalize();
            let up = right.cross(forward);
            for p in points(width, height) {
                let longitude = (p.x / f64::from(width) - 0.5) * std::f64::consts::TAU;
                let latitude = (0.5 - p.y / f64::from(height)) * std::f64::consts::PI;
                let level = right * libm::sin(longitude) + forward * libm::cos(longitude);
                let expected = level * libm::cos(latitude) + up * libm::sin(latitude);
                let found = camera.generate_ray(p.as_vec2(), None).direction.as_dvec3();
                let off = (found - expected).abs().max_element();
                assert!(off <= libm::exp2(-25.0) + 1e-14, "{width}×{height} {p}: {off:e}");
            }
        }
    }
}
