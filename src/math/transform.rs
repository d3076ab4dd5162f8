//! Invertible affine maps in f64, each stored with its inverse.

use super::double_double::DoubleDoubleVec3;
use super::exact_dot;
use glam::{DAffine3, DMat3, DVec3};

/// Error: the linear part of an affine map has no inverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the transform is singular: it flattens space")]
pub struct SingularTransformError;

/// Invertible affine map from object space to world space, with its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    forward: DAffine3,
    inverse: DAffine3,
    /// Determinant of the linear part of the object-to-world map; negative if the map mirrors.
    determinant: f64,
}

/// Largest absolute entry that the inverse of a matrix may have. If an entry is larger, the matrix
/// counts as singular. Before this test, the columns of the matrix are scaled to about unit length.
///
/// Below this limit, rounding errors of the matrix entries change the inverse by less than 2 %.
const MAX_INVERSE_ENTRY: f64 = 1e14;

impl Transform {
    /// The identity map.
    pub const IDENTITY: Self = Self { forward: DAffine3::IDENTITY, inverse: DAffine3::IDENTITY, determinant: 1.0 };

    /// Creates the transform with the object-to-world map `forward`, and computes the inverse.
    ///
    /// Cofactors and determinant are computed in double-double arithmetic, since they cancel if the
    /// columns are nearly coplanar. Each entry of the inverse is correct to its last two bits.
    ///
    /// # Errors
    ///
    /// [`SingularTransformError`] if an entry of `forward` or of the inverse is not finite, or if
    /// the columns are too close to coplanar. For this test, the columns are scaled to about unit
    /// length; entries of their inverse above 10¹⁴ are an error. So very long or short columns are
    /// allowed.
    pub fn new(forward: DAffine3) -> Result<Self, SingularTransformError> {
        let m = forward.matrix3;
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|v| floor_power_of_two(overflow_safe_length(v)));
        // Scaling by powers of two is exact.
        let [a, b, c] = [m.x_axis / x, m.y_axis / y, m.z_axis / z];
        let cofactors = [DoubleDoubleVec3::cross(b, c), DoubleDoubleVec3::cross(c, a), DoubleDoubleVec3::cross(a, b)];
        let volume = cofactors[0].dot(a);
        let rows = cofactors.map(|row| row.round_to_dvec3() / volume);
        let largest = rows.iter().map(|row| row.abs().max_element()).fold(0.0, f64::max);
        if !(forward.is_finite()
            && volume != 0.0
            && rows.iter().all(|row| row.is_finite())
            && largest <= MAX_INVERSE_ENTRY)
        {
            return Err(SingularTransformError);
        }
        // M is U·D: U has the scaled columns a, b and c, and the diagonal matrix D has their scales
        // x, y and z. The inverse of M is D⁻¹·U⁻¹. This product overflows or underflows only if
        // entries of the inverse do.
        let inverse = DMat3::from_cols(rows[0] / x, rows[1] / y, rows[2] / z).transpose();
        let inverse = DAffine3::from_mat3_translation(inverse, inverse_translation(inverse, forward.translation));
        let determinant = volume * x * y * z;
        if inverse.is_finite() { Ok(Self { forward, inverse, determinant }) } else { Err(SingularTransformError) }
    }

    /// Map from object space to world space.
    #[must_use]
    pub fn forward(&self) -> &DAffine3 {
        &self.forward
    }

    /// Map from world space to object space.
    #[must_use]
    pub fn inverse(&self) -> &DAffine3 {
        &self.inverse
    }

    /// Transforms a point from object space to world space.
    #[inline]
    #[must_use]
    pub fn transform_point(&self, p: DVec3) -> DVec3 {
        self.forward.transform_point3(p)
    }

    /// Transforms a vector from object space to world space, without the translation.
    #[inline]
    #[must_use]
    pub fn transform_vector(&self, v: DVec3) -> DVec3 {
        self.forward.transform_vector3(v)
    }

    /// Transforms a normal from object space to world space by the inverse transpose.
    ///
    /// The result is not normalised.
    #[inline]
    #[must_use]
    pub fn transform_normal(&self, n: DVec3) -> DVec3 {
        self.inverse.matrix3.transpose() * n
    }

    /// Returns this map, followed by a world-space translation by `by`.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        let (mut forward, mut inverse) = (self.forward, self.inverse);
        forward.translation += by;
        inverse.translation = inverse_translation(inverse.matrix3, forward.translation);
        Self { forward, inverse, ..*self }
    }

    /// Determinant of the linear part of the object-to-world map; negative if the map mirrors.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        self.determinant
    }

    /// World-space area of a surface element that has the object-space area vector `n`.
    ///
    /// An area vector is the unit normal times the area. The result is |det M|·|M⁻ᵀ n|, where M is
    /// the linear part.
    #[inline]
    #[must_use]
    pub fn world_element_area(&self, n: DVec3) -> f64 {
        self.determinant.abs() * self.transform_normal(n).length()
    }

    /// Positive factor by which the map scales all lengths; `None` if the factor depends on the
    /// direction.
    ///
    /// The map may also rotate and mirror. Squared factors that differ by a relative rounding error
    /// up to 10⁻¹² count as equal.
    #[must_use]
    pub fn uniform_scale(&self) -> Option<f64> {
        let m: DMat3 = self.forward.matrix3;
        let s2 = m.x_axis.length_squared();
        let gram = m.transpose() * m;
        let off = (gram - DMat3::from_diagonal(DVec3::splat(s2))).to_cols_array();
        off.iter().all(|x| x.abs() <= 1e-12 * s2).then(|| s2.sqrt())
    }

    /// True if the map turns right-handed frames into left-handed ones: its determinant is
    /// negative.
    #[must_use]
    pub fn swaps_handedness(&self) -> bool {
        self.determinant < 0.0
    }
}

/// Translation of the inverse map: −M⁻¹t, in double-double arithmetic.
fn inverse_translation(inverse: DMat3, t: DVec3) -> DVec3 {
    let rows = inverse.transpose();
    -DVec3::new(exact_dot(rows.x_axis, t), exact_dot(rows.y_axis, t), exact_dot(rows.z_axis, t))
}

/// Largest power of two that is at most `x`, for a normal number `x` above 0.
///
/// Returns 0 for 0 and subnormal numbers, and infinity for infinity and NaN.
fn floor_power_of_two(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

/// Length of `v`, computed without overflow or underflow of the squares.
fn overflow_safe_length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 { largest * (v / largest).length() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    #[test]
    fn singular_maps_are_refused() {
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(Transform::new(flat), Err(SingularTransformError));
        assert_eq!(Transform::new(DAffine3::from_scale(DVec3::splat(f64::NAN))), Err(SingularTransformError));
        let dependent = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
        assert_eq!(Transform::new(DAffine3::from_mat3(dependent)), Err(SingularTransformError));
        let close = DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1e-15, 0.0), DVec3::Z);
        assert_eq!(Transform::new(DAffine3::from_mat3(close)), Err(SingularTransformError));
        // Very small or unequal scales do not make a transform singular.
        for scale in [DVec3::splat(1e-150), DVec3::new(1e300, 1.0, 1e-300)] {
            let t = Transform::new(DAffine3::from_scale(scale)).unwrap();
            let back = t.inverse().transform_vector3(t.transform_vector(DVec3::ONE));
            assert!((back - DVec3::ONE).abs().max_element() <= 4.0 * f64::EPSILON, "{back}");
        }
    }

    #[test]
    fn normals_stay_perpendicular_under_shear() {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.0), DVec3::new(0.0, -0.4, 2.0));
        let t = Transform::new(DAffine3::from_mat3(shear)).unwrap();
        let (a, b) = (DVec3::new(1.0, 2.0, -1.0), DVec3::new(0.5, -1.0, 3.0));
        let n = t.transform_normal(a.cross(b));
        assert!(n.dot(t.transform_vector(a)).abs() < 1e-12 && n.dot(t.transform_vector(b)).abs() < 1e-12);
    }

    #[test]
    fn similarity_is_recognised() {
        let turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z) * 3.0;
        assert_eq!(Transform::new(DAffine3::from_mat3(turn)).unwrap().uniform_scale(), Some(3.0));
        let stretch = DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.001));
        assert_eq!(Transform::new(stretch).unwrap().uniform_scale(), None);
        assert!(Transform::new(DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0))).unwrap().swaps_handedness());
    }
}
