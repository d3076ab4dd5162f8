//! Builds the camera from its description in the scene file.

use super::aim_direction;
use crate::camera::{Camera, Lens};
use crate::format::description::{
    self, ApertureDescription, FocusDescription, ProjectionDescription, SceneDescription,
};
use crate::format::line_error::MessageAndRemedy;
use crate::format::{SceneError, SourceText};
use glam::DVec3;

/// Returns the camera of the scene description.
///
/// Fails if single precision cannot represent its view, or if `up` is parallel to the view.
pub(in crate::format) fn resolve_camera(
    description: &SceneDescription,
    source: &SourceText,
) -> Result<Camera, SceneError> {
    let described = &description.camera;
    let description::CameraDescription { center, up, width, height, .. } = described.value;
    let direction = aim_direction(described.aim, center);
    let refuse = |(message, help): MessageAndRemedy| {
        SceneError::error_at_span(source, described.span, message, "this camera", help)
    };
    let camera = match described.projection {
        ProjectionDescription::Perspective { angle, lens } => {
            check_field_of_view(angle, (width, height)).map_err(refuse)?;
            let camera = Camera::perspective(center, direction, up, angle.to_radians(), width, height);
            match lens {
                Some(lens) => {
                    let lens = resolve_lens(&lens, angle, center, direction);
                    check_lens(&lens).map_err(refuse)?;
                    camera.map(|camera| camera.with_lens(lens))
                }
                None => camera,
            }
        }
        ProjectionDescription::Orthographic { size } => {
            Camera::orthographic(center, direction, up, size, width, height)
        }
        ProjectionDescription::Environment => Camera::panorama(center, direction, up, width, height),
    };
    camera.map_err(|e| refuse((e.to_string(), "give another `up`")))
}

/// Greatest rounding error of a unit vector in single precision \[rad]: about 2⁻²⁴.
const MAX_DIRECTION_ERROR: f64 = 1.0 / 16_777_216.0;

/// Greatest tangent of the angle between the view direction and a corner of the picture.
///
/// At this angle, the rounding error of a ray direction moves a corner by 1/256 of its distance
/// from the picture's center.
const MAX_CORNER_TANGENT: f64 = 65_536.0;

/// Fails if single precision cannot distinguish the directions to the pixels of a perspective
/// picture.
///
/// `angle` is the vertical field of view in degrees. `width` and `height` are in pixels.
fn check_field_of_view(angle: f64, (width, height): (u32, u32)) -> Result<(), MessageAndRemedy> {
    let (width, height) = (f64::from(width), f64::from(height));
    let pixel = 2.0 * libm::tan(0.5 * angle.to_radians()) / height;
    if pixel < MAX_DIRECTION_ERROR {
        let message =
            format!("the pixels are {pixel:.1e} rad wide, less than the error of directions in single precision");
        return Err((message, "choose a larger `angle` or fewer pixels, or an OrthographicCamera"));
    }
    let corner = 0.5 * pixel * libm::hypot(width, height);
    if corner > MAX_CORNER_TANGENT {
        let message =
            format!("the corners lie {corner:.1e} times as far aside as ahead, which single precision cannot hold");
        return Err((message, "choose a smaller `angle` or a picture less long, or an EnvironmentCamera"));
    }
    Ok(())
}

/// Least focus distance \[length]. Squares of shorter lengths underflow in single precision.
const MIN_FOCUS_DISTANCE: f64 = 1e-12;

/// Greatest lens radius and focus distance \[length]. Single precision can hold their squares and
/// products.
const MAX_LENS_LENGTH: f64 = 1e12;

/// Fails if single precision cannot hold the squares of the lens radius and the focus distance.
fn check_lens(lens: &Lens) -> Result<(), MessageAndRemedy> {
    if !(lens.radius < MAX_LENS_LENGTH && lens.focus < MAX_LENS_LENGTH) {
        let message = "the lens is larger, or focused farther, than single precision can hold";
        return Err((message.to_owned(), "close it, or focus nearer"));
    }
    if lens.focus < MIN_FOCUS_DISTANCE {
        let message = "the lens is focused nearer than single precision can hold";
        return Err((message.to_owned(), "focus at a distance of at least 1e-12"));
    }
    Ok(())
}

/// Returns the lens of a camera at `center` that looks along `direction`.
///
/// `angle` is the vertical field of view in degrees.
fn resolve_lens(lens: &description::LensDescription, angle: f64, center: DVec3, direction: DVec3) -> Lens {
    let radius = match lens.aperture {
        ApertureDescription::Radius(radius) => radius,
        ApertureDescription::FNumber { number, sensor } => {
            let focal_length = 0.5 * sensor / libm::tan(0.5 * angle.to_radians());
            0.5 * focal_length / number
        }
    };
    let focus = match lens.focus {
        FocusDescription::Distance(distance) => distance,
        FocusDescription::Point(point) => (point - center).dot(direction.normalize()),
    };
    Lens { radius, focus, blades: lens.blades }
}
