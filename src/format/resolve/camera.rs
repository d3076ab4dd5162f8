//! Resolves the camera of a description.

use super::aim;
use crate::camera::{Camera, Lens};
use crate::format::description::{
    self, ApertureDescription, FocusDescription, ProjectionDescription, SceneDescription,
};
use crate::format::{SceneError, SourceText};
use glam::DVec3;

pub(super) fn camera(description: &SceneDescription, source: &SourceText) -> Result<Camera, SceneError> {
    let described = &description.camera;
    let description::CameraDescription { center, up, width, height, .. } = described.value;
    let direction = aim(described.aim, center);
    let camera = match described.projection {
        ProjectionDescription::Perspective { angle, lens } => {
            check_angle(angle, (width, height))
                .map_err(|(message, help)| SceneError::at(source, described.span, message, "this camera", help))?;
            let camera = Camera::perspective(center, direction, up, angle.to_radians(), width, height);
            match lens {
                Some(lens) => {
                    let lens = resolve_lens(&lens, angle, center, direction);
                    if !(lens.radius < LARGEST && lens.focus < LARGEST) {
                        let help = "close it, or focus nearer";
                        let message = "the lens is larger, or focused farther, than single precision can hold";
                        return Err(SceneError::at(source, described.span, message, "this camera", help));
                    }
                    if lens.focus < NEAREST {
                        let help = "focus at a distance of at least 1e-12";
                        let message = "the lens is focused nearer than single precision can hold";
                        return Err(SceneError::at(source, described.span, message, "this camera", help));
                    }
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
    camera.map_err(|e| SceneError::at(source, described.span, e.to_string(), "this camera", "give another `up`"))
}

/// Greatest error of a direction in single precision, in rad: half an ulp below 1 in each
/// component, so √3 · 2⁻²⁵.
const ERROR: f64 = 1.0 / 16_777_216.0;

/// Tangent of the angle from picture center to corner at which that error moves the corner by 1/256
/// of the distance.
const WIDEST: f64 = 65_536.0;

/// Refuses an angle at which single precision cannot distinguish pixels; the error is message and
/// remedy.
fn check_angle(angle: f64, (width, height): (u32, u32)) -> Result<(), (String, &'static str)> {
    let (width, height) = (f64::from(width), f64::from(height));
    let pixel = 2.0 * libm::tan(0.5 * angle.to_radians()) / height;
    if pixel < ERROR {
        let message =
            format!("the pixels are {pixel:.1e} rad wide, less than the error of directions in single precision");
        return Err((message, "choose a larger `angle` or fewer pixels, or an OrthographicCamera"));
    }
    let corner = 0.5 * pixel * libm::hypot(width, height);
    if corner > WIDEST {
        let message =
            format!("the corners lie {corner:.1e} times as far aside as ahead, which single precision cannot hold");
        return Err((message, "choose a smaller `angle` or a picture less long, or an EnvironmentCamera"));
    }
    Ok(())
}

/// Least focus distance: squares of shorter lengths underflow in single precision.
const NEAREST: f64 = 1e-12;

/// Greatest length whose squares and products single precision can hold.
const LARGEST: f64 = 1e12;

fn resolve_lens(lens: &description::LensDescription, angle: f64, center: DVec3, direction: DVec3) -> Lens {
    let radius = match lens.opening {
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
