//! The graphics state of pbrt: current transforms, material, media and area light.

use super::files::{PbrtSourceLocation, ReadResult};
use super::parameters::Parameters;
use crate::format::description::TransformStep;
use crate::math::Transform;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use std::rc::Rc;

/// Greatest angle of a rotation that counts as no rotation \[radians].
const MIN_ROTATION_RADIANS: f64 = 1e-9;

/// Transform of a moving object or camera: two affine maps, at the start and the end of its motion.
///
/// Unless stated otherwise, the maps go from object space to world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MovingTransform(pub [DAffine3; 2]);

impl MovingTransform {
    /// Identity map at the start and at the end of the motion.
    pub const IDENTITY: Self = Self([DAffine3::IDENTITY; 2]);

    /// Returns the inverse transforms; `None` if one of the transforms is singular.
    pub fn inverse(&self) -> Option<Self> {
        let inverse = |map: DAffine3| Transform::new(map).is_ok().then(|| map.inverse());
        Some(Self([inverse(self.0[0])?, inverse(self.0[1])?]))
    }

    /// Returns the transforms at two times of the motion. A time is a fraction of the motion's
    /// duration: 0 at its start, and 1 at its end.
    ///
    /// Fractions are clamped to \[0, 1]. Translation and rotation have constant speed. If scale or
    /// shear change too, the matrices are interpolated linearly; a singular result is replaced by
    /// the start transform.
    pub fn at_fractions(&self, fractions: [f64; 2]) -> Self {
        let Some(motion) = object_motion(self).filter(|_| fractions != [0.0, 1.0]) else { return *self };
        let [start, end] = self.0;
        let (center, target) = (DAffine3::from_translation(motion.rotation_center), end.translation);
        Self(fractions.map(|fraction| fraction.clamp(0.0, 1.0)).map(|time| {
            if time == 0.0 || time == 1.0 {
                return self.0[time as usize];
            }
            if motion.omits_deformation {
                let [from, to] = [start, end].map(|map| map.to_cols_array());
                let map = DAffine3::from_cols_array(&std::array::from_fn(|i| from[i] + (to[i] - from[i]) * time));
                return if Transform::new(map).is_ok() { map } else { start };
            }
            let moved = DAffine3::from_translation((target - start.translation) * time);
            let turned = motion.steps.iter().find_map(|step| match step {
                TransformStep::Rotate { axis, angle } => {
                    Some(TransformStep::Rotate { axis: *axis, angle: angle * time }.matrix())
                }
                _ => None,
            });
            center * moved * turned.unwrap_or(DAffine3::IDENTITY) * center.inverse() * start
        }))
    }

    /// True if the transforms at both times are equal.
    pub fn is_still(&self) -> bool {
        self.0[0] == self.0[1]
    }
}

/// Motion of an object from its start to its end transform: a rotation about `rotation_center`,
/// then a translation.
pub(super) struct ObjectMotion {
    /// Center of the rotation in world space: the object's origin at the start.
    pub rotation_center: DVec3,
    /// Translation, and the rotation if there is any. The last step of the list applies first.
    pub steps: Vec<TransformStep>,
    /// True if the object's scale, shear or handedness also changes.
    ///
    /// `steps` do not contain this change. If shear or handedness changes, `steps` contain only the
    /// translation.
    pub omits_deformation: bool,
}

/// Returns the motion from the start transform to the end transform; `None` if they are equal.
pub(super) fn object_motion(transform: &MovingTransform) -> Option<ObjectMotion> {
    let [start, end] = transform.0;
    if transform.is_still() {
        return None;
    }
    let relative = end.matrix3 * start.matrix3.inverse();
    let scale = DVec3::new(relative.x_axis.length(), relative.y_axis.length(), relative.z_axis.length());
    let unscaled = DMat3::from_cols(relative.x_axis / scale.x, relative.y_axis / scale.y, relative.z_axis / scale.z);
    let is_rotation = (unscaled.transpose() * unscaled).abs_diff_eq(DMat3::IDENTITY, 1e-6);
    let omits_scale = !is_rotation || !scale.abs_diff_eq(DVec3::ONE, 1e-6) || unscaled.determinant() < 0.0;
    let mut steps = vec![TransformStep::Translate(end.translation - start.translation)];
    if is_rotation && unscaled.determinant() > 0.0 {
        let rotation = DQuat::from_mat3(&unscaled);
        // q and −q are one rotation. This one has the smaller angle.
        let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
        let angle = 2.0 * libm::atan2(rotation.xyz().length(), rotation.w);
        if angle > MIN_ROTATION_RADIANS {
            steps.push(TransformStep::Rotate { axis: rotation.xyz().normalize(), angle: angle.to_degrees() });
        }
    }
    Some(ObjectMotion { rotation_center: start.translation, steps, omits_deformation: omits_scale })
}

/// Directive `AreaLightSource`, which makes the shapes that follow emit light.
#[derive(Clone, Debug)]
pub(super) struct AreaLightDirective {
    /// Parameters of the directive.
    pub parameters: Rc<Parameters>,
}

/// Material that applies to the shapes that follow.
#[derive(Clone, Debug)]
pub(super) enum MaterialReference {
    /// Index of a material among all that the file has defined so far; 0 for pbrt's default
    /// material.
    Numbered(usize),
    /// Name of a material that the file has not defined so far, and the position of the directive
    /// that uses it.
    ///
    /// The definition must follow before a shape uses the material.
    Named(Rc<str>, PbrtSourceLocation),
}

/// pbrt's graphics state: the current values that apply to the shapes and lights that follow.
#[derive(Clone, Debug)]
pub(super) struct GraphicsState {
    /// Current transform from object to world space.
    pub transform: MovingTransform,
    /// Two flags, one for the start transform and one for the end transform: true if transform
    /// directives change this transform (`ActiveTransform`).
    pub is_transform_active: [bool; 2],
    /// True if the shapes that follow are turned inside out (`ReverseOrientation`).
    pub is_reversed: bool,
    /// Material of the shapes that follow.
    pub material: MaterialReference,
    /// Emission of the shapes that follow; `None` if they emit nothing.
    pub area_light: Option<AreaLightDirective>,
    /// Names of the media inside and outside of the shapes that follow; empty for vacuum.
    pub medium_interface: [Rc<str>; 2],
    /// Number of definitions of named materials at the time this state was saved, at the start of a
    /// block; 0 in pbrt-v4.
    ///
    /// In pbrt-v3, the end of the attribute or object block undoes all definitions after these.
    pub named_definition_count: usize,
}

impl GraphicsState {
    /// Returns the graphics state before the first directive.
    pub fn new() -> Self {
        Self {
            transform: MovingTransform::IDENTITY,
            is_transform_active: [true; 2],
            is_reversed: false,
            material: MaterialReference::Numbered(0),
            area_light: None,
            medium_interface: ["".into(), "".into()],
            named_definition_count: 0,
        }
    }

    /// Replaces the current transform T by T · `map`, so that `map` applies to points first.
    ///
    /// Changes the start transform and the end transform, each only if its flag in
    /// `is_transform_active` is true.
    pub fn concatenate(&mut self, map: DAffine3, place: &PbrtSourceLocation) -> ReadResult<()> {
        for i in 0..2 {
            if self.is_transform_active[i] {
                let product = self.transform.0[i] * map;
                if !(product.is_finite() && product.matrix3.determinant() != 0.0) {
                    return Err(place.error("the transform is singular or too large", "use scales other than 0"));
                }
                self.transform.0[i] = product;
            }
        }
        Ok(())
    }

    /// Replaces the current transform by `transform`.
    ///
    /// Changes the start transform and the end transform, each only if its flag in
    /// `is_transform_active` is true.
    pub fn set_transform(&mut self, transform: MovingTransform) {
        for i in 0..2 {
            if self.is_transform_active[i] {
                self.transform.0[i] = transform.0[i];
            }
        }
    }
}

/// Returns the affine map of a transform directive, such as `Rotate`, with the arguments `n`.
pub(super) fn directive_transform(directive: &str, n: &[f64], place: &PbrtSourceLocation) -> ReadResult<DAffine3> {
    let vector = |i: usize| DVec3::new(n[i], n[i + 1], n[i + 2]);
    let invalid = |message: &str| place.error(message, "correct the numbers of the transform");
    match directive {
        "Translate" => Ok(DAffine3::from_translation(vector(0))),
        "Scale" => Ok(DAffine3::from_scale(vector(0))),
        "Rotate" => {
            if vector(1) == DVec3::ZERO {
                return Err(invalid("the axis of a rotation is zero"));
            }
            Ok(TransformStep::Rotate { axis: vector(1), angle: n[0] }.matrix())
        }
        "LookAt" => {
            let (eye, target, up) = (vector(0), vector(3), vector(6));
            let forward = (target - eye).try_normalize().ok_or_else(|| invalid("LookAt: both points are equal"))?;
            let up = up.try_normalize().ok_or_else(|| invalid("LookAt: the up vector is zero"))?;
            let right =
                up.cross(forward).try_normalize().ok_or_else(|| invalid("LookAt: the view is parallel to up"))?;
            let axes = DMat3::from_cols(right, forward.cross(right), forward);
            Ok(DAffine3::from_mat3_translation(axes, eye).inverse())
        }
        _ => {
            let matrix: [f64; 16] = n.try_into().map_err(|_| invalid("a matrix has 16 numbers"))?;
            let matrix = DMat4::from_cols_array(&matrix);
            let row = matrix.row(3);
            if row.w == 0.0 || row.truncate().abs().max_element() > 1e-9 * row.w.abs() {
                return Err(invalid("the matrix is not affine"));
            }
            Ok(DAffine3::from_mat4(matrix * (1.0 / row.w)))
        }
    }
}

#[cfg(test)]
mod tests;
