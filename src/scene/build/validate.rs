//! Checks that objects and lights of a scene can be rendered in single precision.

use super::object::{MergedMeshes, ObjectGeometry, SceneObject};
use super::place::PlacedGeometry;
use crate::color;
use crate::math::Bounds;
use crate::scene::animation::{Animation, shape_at_time};
use crate::scene::{BuildError, Scene};
use crate::shape::Shape;

/// Largest accepted absolute coordinate \[length]. The product of three coordinates stays finite in
/// single precision.
const MAX_COORDINATE: f32 = 1e12;

/// Smallest accepted value of a scene's greatest absolute coordinate, 2⁻³⁹ \[length].
///
/// Single precision rounds such a coordinate by up to 2⁻⁶³. The square of this error, 2⁻¹²⁶, is the
/// least normal f32, so squared lengths of this order do not underflow.
const MIN_FARTHEST_COORDINATE: f32 = 1.0 / 549_755_813_888.0;

/// Checks that no unbounded plane emits, and that triangle indices fit 31 bits. Else the error is
/// [`BuildError::EmissivePlane`] or [`BuildError::TooManyTriangles`].
pub(super) fn validate_objects(objects: &[SceneObject], mesh: &MergedMeshes) -> Result<(), BuildError> {
    let emits = |object: &SceneObject| matches!(object.geometry, ObjectGeometry::Plane(_)) && object.emits();
    if objects.iter().any(emits) {
        return Err(BuildError::EmissivePlane);
    }
    let triangles = mesh.triangles.len();
    if triangles > i32::MAX as usize { Err(BuildError::TooManyTriangles(triangles)) } else { Ok(()) }
}

/// Checks that the greatest absolute coordinate of triangles and shapes lies between
/// [`MIN_FARTHEST_COORDINATE`] and [`MAX_COORDINATE`].
///
/// Moving shapes are checked at mid-shutter and at both ends of the shutter interval. The error is
/// [`BuildError::ExtentTooSmall`] or [`BuildError::ExtentTooLarge`].
pub(super) fn validate_coordinate_range(geometry: &PlacedGeometry, animation: &Animation) -> Result<(), BuildError> {
    let at = |time| {
        animation.shapes.iter().filter_map(move |(shape, motion)| Some(shape_at_time(shape, motion, time)?.bounds()))
    };
    let boxes = geometry.shapes.iter().map(Shape::bounds).chain(at(0.0)).chain(at(1.0));
    let corners = (0..geometry.mesh.triangles.len()).flat_map(|i| geometry.mesh.corners(i));
    let farthest = corners
        .chain(boxes.flat_map(|Bounds { min, max }| [min, max]))
        .flat_map(|p| p.abs().to_array())
        // A coordinate that is NaN counts as the farthest.
        .max_by(f32::total_cmp);
    match farthest {
        Some(far) if !far.is_finite() => Err(BuildError::ExtentTooLarge(f64::INFINITY)),
        Some(far) if far > MAX_COORDINATE => Err(BuildError::ExtentTooLarge(f64::from(far))),
        Some(far) if far < MIN_FARTHEST_COORDINATE => Err(BuildError::ExtentTooSmall(f64::from(far))),
        _ => Ok(()),
    }
}

/// Checks that the power of each light, averaged over the channels, is finite. Else the error is
/// [`BuildError::TooBright`].
pub(super) fn validate_light_power(scene: &Scene) -> Result<(), BuildError> {
    let domain = scene.photon_domain();
    match scene.lights.iter().position(|light| !color::channel_mean(light.power(domain)).is_finite()) {
        Some(i) => Err(BuildError::TooBright(i)),
        None => Ok(()),
    }
}
