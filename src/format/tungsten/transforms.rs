//! Reads the transforms of a Tungsten scene file.

use super::object::{ReadResult, TungstenObject};
use crate::math::rotation_matrix_degrees;
use glam::{DAffine3, DMat3, DMat4, DVec3};
use serde_json::Value;

/// Squared length below which a vector counts as parallel to those before it.
const MIN_SQUARED_LENGTH: f64 = 1e-5;

/// Returns the transform in the member `transform` of `object`, from the object's own space to its
/// surroundings; the identity if the member is missing.
///
/// A list of 16 numbers is a matrix by rows. An object states axes, scale, rotation and position.
/// The axes are those of `look_at` and `up`, or `x_axis`, `y_axis` and `z_axis`.
///
/// # Errors
/// If the transform is neither a list nor an object, is not affine, or has wrong members.
pub(super) fn read_transform(object: &TungstenObject<'_>) -> ReadResult<DAffine3> {
    let Some(value) = object.value("transform") else { return Ok(DAffine3::IDENTITY) };
    let help = "write 16 numbers by rows, or an object with `position`, `scale` and `rotation`";
    let transform = match value {
        Value::Array(_) => {
            let numbers = object.number_list("transform").unwrap_or_default();
            let numbers: [f64; 16] = numbers.try_into().map_err(|_| object.error("`transform` is no matrix", help))?;
            let matrix = DMat4::from_cols_array(&numbers).transpose();
            if matrix.row(3) != glam::DVec4::W {
                return Err(object.error("the last row of the matrix `transform` is not 0 0 0 1", "correct the matrix"));
            }
            DAffine3::from_mat4(matrix)
        }
        Value::Object(members) => transform_from_parts(&object.nested(members, "transform"))?,
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
            return Err(object.error("`transform` is no matrix", help));
        }
    };
    if transform.is_finite() {
        return Ok(transform);
    }
    Err(object.error("the transform is not finite", "correct its numbers"))
}

/// Returns the transform that axes, scale, rotation and position state. The scale applies first,
/// then the axes, the rotation and the position.
fn transform_from_parts(parts: &TungstenObject<'_>) -> ReadResult<DAffine3> {
    let position = parts.vector("position")?.unwrap_or(DVec3::ZERO);
    let mut axes = read_axes(parts, position)?;
    if let Some(scale) = parts.vector("scale")? {
        axes *= DMat3::from_diagonal(scale);
    }
    if let Some(angles) = parts.vector("rotation")? {
        axes = rotation_yxz(angles) * axes;
    }
    Ok(DAffine3 { matrix3: axes, translation: position })
}

/// Returns the rotation by the Euler angles of Tungsten \[degrees]: about z first, then about x,
/// then about y.
///
/// The rotations about x and z are right-handed. The rotation about y is left-handed.
pub(super) fn rotation_yxz(angles: DVec3) -> DMat3 {
    rotation_matrix_degrees(DVec3::Y, -angles.y)
        * rotation_matrix_degrees(DVec3::X, angles.x)
        * rotation_matrix_degrees(DVec3::Z, angles.z)
}

/// Returns the orthonormal axes of a transform as columns. Axes that the file does not state follow
/// from the others, so that the frame is right-handed.
fn read_axes(parts: &TungstenObject<'_>, position: DVec3) -> ReadResult<DMat3> {
    let target = parts.vector("look_at")?.map(|target| target - position);
    let stated =
        [parts.vector("x_axis")?, parts.vector("y_axis")?.or(parts.vector("up")?), parts.vector("z_axis")?.or(target)];
    let is_stated = stated.map(|axis| axis.is_some());
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for (axis, stated) in axes.iter_mut().zip(stated) {
        *axis = stated.unwrap_or(*axis);
    }
    // The first axis in this order keeps its direction. The second one is made orthogonal to it.
    let order = match is_stated {
        [true, false, false] => [0, 2, 1],
        [false, true, false] => [1, 2, 0],
        [true, true, false] => [1, 0, 2],
        [true, false, true] => [2, 0, 1],
        [false, false, _] | [false, true, true] | [true, true, true] => [2, 1, 0],
    };
    let [first, second, third] = order.map(|axis| axes[axis]);
    let Some(first) = first.try_normalize() else {
        return Err(
            parts.error("an axis of the transform has no length", "state axes, or a target other than `position`")
        );
    };
    let second = orthogonal_part(second, &[first], any_orthogonal(first));
    let third = orthogonal_part(third, &[first, second], first.cross(second));
    for (axis, vector) in order.into_iter().zip([first, second, third]) {
        axes[axis] = vector;
    }
    if axes[0].cross(axes[1]).dot(axes[2]) < 0.0 {
        let flipped = is_stated.iter().position(|stated| !stated).unwrap_or(2);
        axes[flipped] = -axes[flipped];
    }
    Ok(DMat3::from_cols(axes[0], axes[1], axes[2]))
}

/// Returns the normalized part of `vector` that is orthogonal to `others`; `fallback` if this part
/// is too short.
fn orthogonal_part(vector: DVec3, others: &[DVec3], fallback: DVec3) -> DVec3 {
    let rest = others.iter().fold(vector, |rest, other| rest - *other * other.dot(rest));
    if rest.length_squared() < MIN_SQUARED_LENGTH { fallback } else { rest.normalize() }
}

/// Returns a unit vector orthogonal to the unit vector `axis`.
fn any_orthogonal(axis: DVec3) -> DVec3 {
    let other = if axis.x.abs() > axis.y.abs() { DVec3::Y } else { DVec3::X };
    axis.cross(other).normalize()
}
