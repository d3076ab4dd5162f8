//! Cameras for imported scenes whose file states no picture size or no camera.

use super::description::{CameraDescription, DirectionOrTarget, ProjectionDescription};
use glam::DVec3;

/// Picture height of imported cameras \[pixels], for formats that do not state it, such as glTF.
const DEFAULT_PICTURE_HEIGHT: f64 = 720.0;

/// Aspect ratio (width : height) of the picture if the imported camera does not give one.
pub(super) const DEFAULT_ASPECT_RATIO: f64 = 4.0 / 3.0;

/// Largest aspect ratio (width : height) of a picture. The smallest is its inverse.
const MAX_ASPECT_RATIO: f64 = 20.0;

/// Returns a camera whose picture is [`DEFAULT_PICTURE_HEIGHT`] high and has the aspect ratio
/// `aspect` (width : height).
///
/// `aspect` is clamped to \[1/20, 20]. An `aspect` that is not above 0 means
/// [`DEFAULT_ASPECT_RATIO`].
pub(super) fn camera_with_aspect_ratio(
    center: DVec3,
    direction: DVec3,
    up: DVec3,
    (projection, aspect): (ProjectionDescription, f64),
) -> CameraDescription {
    let aspect =
        if aspect > 0.0 { aspect.clamp(1.0 / MAX_ASPECT_RATIO, MAX_ASPECT_RATIO) } else { DEFAULT_ASPECT_RATIO };
    CameraDescription {
        center,
        aim: DirectionOrTarget::Direction(direction),
        up,
        projection,
        width: (DEFAULT_PICTURE_HEIGHT * aspect).round() as u32,
        height: DEFAULT_PICTURE_HEIGHT as u32,
        motion: Vec::new(),
    }
}

/// Returns a perspective camera that sees all of a scene with bounds from `low` to `high`.
///
/// The camera stands above and to the right of the center of the bounds, on the side of +z. It
/// looks at the center, with +y up. Empty bounds count as a sphere of radius 1 about the origin.
pub(super) fn framing_camera((low, high): (DVec3, DVec3)) -> CameraDescription {
    const FIELD_OF_VIEW_DEGREES: f64 = 40.0;
    let (center, radius) =
        if low.cmple(high).all() { (0.5 * low + 0.5 * high, 0.5 * (high - low).length()) } else { (DVec3::ZERO, 1.0) };
    let radius = if radius > 0.0 && radius.is_finite() { radius } else { 1.0 };
    let direction = DVec3::new(-0.5, -0.4, -1.0).normalize();
    let distance = 1.05 * radius / libm::sin((0.5 * FIELD_OF_VIEW_DEGREES).to_radians());
    let projection = ProjectionDescription::Perspective { vertical_fov_degrees: FIELD_OF_VIEW_DEGREES, lens: None };
    camera_with_aspect_ratio(center - direction * distance, direction, DVec3::Y, (projection, DEFAULT_ASPECT_RATIO))
}
