//! The camera of the description.

use super::aim;
use crate::camera::{Camera, Lens};
use crate::format::description::{self, Description, Focus, Opening, Projection};
use crate::format::{SceneError, Source};
use glam::DVec3;

pub(super) fn camera(description: &Description, source: &Source) -> Result<Camera, SceneError> {
    let described = &description.camera;
    let description::Camera { center, up, width, height, .. } = described.value;
    let direction = aim(described.aim, center);
    let camera = match described.projection {
        Projection::Perspective { angle, lens } => {
            let camera = Camera::perspective(center, direction, up, angle.to_radians(), width, height);
            match lens {
                Some(lens) => {
                    let lens = resolve_lens(&lens, angle, center, direction);
                    if !(lens.radius < LARGEST && lens.focus < LARGEST) {
                        let help = "close it, or focus nearer";
                        let message = "the lens is larger, or focused farther, than single precision can hold";
                        return Err(SceneError::at(source, described.span, message, "this camera", help));
                    }
                    camera.map(|camera| camera.with_lens(lens))
                }
                None => camera,
            }
        }
        Projection::Orthographic { size } => Camera::orthographic(center, direction, up, size, width, height),
        Projection::Environment => Camera::panorama(center, direction, up, width, height),
    };
    camera.map_err(|e| SceneError::at(source, described.span, e.to_string(), "this camera", "give another `up`"))
}

/// Lengths whose squares and products single precision can hold.
const LARGEST: f64 = 1e12;

fn resolve_lens(lens: &description::Lens, angle: f64, center: DVec3, direction: DVec3) -> Lens {
    let radius = match lens.opening {
        Opening::Radius(radius) => radius,
        Opening::FNumber { number, sensor } => {
            let focal_length = 0.5 * sensor / libm::tan(0.5 * angle.to_radians());
            0.5 * focal_length / number
        }
    };
    let focus = match lens.focus {
        Focus::Distance(distance) => distance,
        Focus::Point(point) => (point - center).dot(direction.normalize()),
    };
    Lens { radius, focus, blades: lens.blades }
}
