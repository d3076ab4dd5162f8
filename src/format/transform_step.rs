//! Steps of a transform: scales, translations, rotations and matrices.

use crate::math::{self, MotionFactor};
use glam::{DAffine3, DMat4, DVec3};

/// One step of a transform or motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformStep {
    /// Scale factors along the x, y and z axis.
    Scale(DVec3),
    /// Scale factor along all axes.
    UniformScale(f64),
    /// Translation by this vector, in scene units.
    Translate(DVec3),
    /// Right-handed rotation about the x axis \[degrees].
    RotateX(f64),
    /// Right-handed rotation about the y axis \[degrees].
    RotateY(f64),
    /// Right-handed rotation about the z axis \[degrees].
    RotateZ(f64),
    /// Right-handed rotation about an axis through the origin.
    Rotate {
        /// Axis of rotation, of any length above 0.
        axis: DVec3,
        /// Angle of rotation \[degrees].
        angle: f64,
    },
    /// Affine map; its fourth row is 0 0 0 1.
    Matrix(DMat4),
}

impl TransformStep {
    /// Returns the affine map of this step alone, from object space to the surrounding space.
    #[must_use]
    pub fn matrix(&self) -> DAffine3 {
        match *self {
            Self::Scale(s) => DAffine3::from_scale(s),
            Self::UniformScale(s) => DAffine3::from_scale(DVec3::splat(s)),
            Self::Translate(t) => DAffine3::from_translation(t),
            Self::RotateX(angle) => rotation_about_axis(DVec3::X, angle),
            Self::RotateY(angle) => rotation_about_axis(DVec3::Y, angle),
            Self::RotateZ(angle) => rotation_about_axis(DVec3::Z, angle),
            Self::Rotate { axis, angle } => rotation_about_axis(axis.normalize_or_zero(), angle),
            Self::Matrix(m) => DAffine3::from_mat4(m),
        }
    }

    /// Returns the step as a motion: the identity at time 0 (the shutter opens), and the full step
    /// at time 1 (the shutter closes).
    ///
    /// A matrix step is not interpolated: it applies in full at all times.
    #[must_use]
    pub fn motion_factor(&self) -> MotionFactor {
        match *self {
            Self::Scale(s) => MotionFactor::Scale(s),
            Self::UniformScale(s) => MotionFactor::Scale(DVec3::splat(s)),
            Self::Translate(t) => MotionFactor::Translate(t),
            Self::RotateX(angle) => MotionFactor::RotateDegrees(DVec3::X, angle),
            Self::RotateY(angle) => MotionFactor::RotateDegrees(DVec3::Y, angle),
            Self::RotateZ(angle) => MotionFactor::RotateDegrees(DVec3::Z, angle),
            Self::Rotate { axis, angle } => MotionFactor::RotateDegrees(axis.normalize_or_zero(), angle),
            Self::Matrix(_) => MotionFactor::Fixed(self.matrix()),
        }
    }

    /// Returns the affine map M that applies all `steps`, composed as in the scene language.
    ///
    /// M starts as the identity. A step with the map T sets M ← M T, so T is applied before all
    /// earlier steps in the list. Only a matrix step sets M ← T M, so T is applied after them.
    #[must_use]
    pub fn composed_matrix(steps: &[Self]) -> DAffine3 {
        steps.iter().fold(DAffine3::IDENTITY, |m, step| match step {
            Self::Matrix(_) => step.matrix() * m,
            _ => m * step.matrix(),
        })
    }
}

/// Returns the rotation about a unit `axis` by `angle` \[degrees].
fn rotation_about_axis(axis: DVec3, angle: f64) -> DAffine3 {
    DAffine3::from_mat3(math::rotation_matrix_degrees(axis, angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_nearly_equal(a: DVec3, b: DVec3) -> bool {
        // The coordinates are below 10, so a few rounding errors stay below this bound.
        (a - b).abs().max_element() < 1e-14
    }

    #[test]
    fn rotations_are_right_handed() {
        assert!(is_nearly_equal(TransformStep::RotateX(90.0).matrix().transform_point3(DVec3::Y), DVec3::Z));
        assert!(is_nearly_equal(TransformStep::RotateY(90.0).matrix().transform_point3(DVec3::Z), DVec3::X));
        assert!(is_nearly_equal(TransformStep::RotateZ(90.0).matrix().transform_point3(DVec3::X), DVec3::Y));
        let diagonal = TransformStep::Rotate { axis: DVec3::splat(5.0), angle: 120.0 }.matrix();
        assert!(is_nearly_equal(diagonal.transform_point3(DVec3::X), DVec3::Y));
        assert!(is_nearly_equal(diagonal.transform_point3(DVec3::Y), DVec3::Z));
    }

    #[test]
    fn the_first_transform_step_is_applied_last() {
        let steps = [TransformStep::Translate(DVec3::X), TransformStep::Scale(DVec3::splat(2.0))];
        assert!(is_nearly_equal(
            TransformStep::composed_matrix(&steps).transform_point3(DVec3::ONE),
            DVec3::new(3.0, 2.0, 2.0)
        ));
    }

    #[test]
    fn a_matrix_step_is_applied_after_earlier_steps() {
        let double = TransformStep::Matrix(DMat4::from_scale(DVec3::splat(2.0)));
        let steps = [TransformStep::Translate(DVec3::X), double];
        assert!(is_nearly_equal(
            TransformStep::composed_matrix(&steps).transform_point3(DVec3::ZERO),
            DVec3::new(2.0, 0.0, 0.0)
        ));
    }
}
