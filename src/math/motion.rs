//! Motion: affine maps that depend on the time while the shutter is open.

use glam::{DAffine3, DMat3, DVec3};

/// One factor of a [`Motion`]: an affine map that is constant or changes with time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionFactor {
    /// A map that does not depend on time.
    Fixed(DAffine3),
    /// Translation by t times the given vector \[length], at time t in \[0, 1].
    Translate(DVec3),
    /// Right-handed rotation about the given unit axis through the origin.
    ///
    /// The angle at time t in \[0, 1] is t times the given number \[degrees].
    RotateDegrees(DVec3, f64),
    /// Scaling along the axes by factors that change linearly in time.
    ///
    /// The factors are 1 at time 0, and the given positive factors at time 1.
    Scale(DVec3),
}

impl MotionFactor {
    /// Returns the affine map at `time` in \[0, 1]: 0 is the opening of the shutter, 1 its closing.
    #[must_use]
    pub fn at_time(&self, time: f64) -> DAffine3 {
        match *self {
            Self::Fixed(map) => map,
            Self::Translate(by) => DAffine3::from_translation(by * time),
            Self::RotateDegrees(axis, angle) => DAffine3::from_mat3(rotation_matrix_degrees(axis, angle * time)),
            Self::Scale(by) => DAffine3::from_scale(DVec3::ONE + (by - 1.0) * time),
        }
    }
}

/// Affine map as a function of time: 0 is the opening of the shutter, 1 its closing.
///
/// The map is a product of factors, so points under a rotation move along true circles. If matrices
/// were interpolated instead, these points would move along chords.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Factors F₁ … Fₙ of the product map F₁·F₂·…·Fₙ. The last factor acts on points first.
    ///
    /// Adjacent factors that do not depend on time are merged.
    factors: Vec<MotionFactor>,
}

impl Motion {
    /// Creates a motion that equals `map` at all times.
    #[must_use]
    pub fn constant_motion(map: DAffine3) -> Self {
        Self::default().preceded_by_factors([MotionFactor::Fixed(map)])
    }

    /// Returns a motion that applies `factors` to points first, and then this motion. The last of
    /// `factors` acts on points before the others.
    #[must_use]
    pub fn preceded_by_factors(&self, factors: impl IntoIterator<Item = MotionFactor>) -> Self {
        let mut all = self.factors.clone();
        for factor in factors {
            match (all.last_mut(), factor) {
                (Some(MotionFactor::Fixed(outer)), MotionFactor::Fixed(inner)) => *outer *= inner,
                _ => all.push(factor),
            }
        }
        Self { factors: all }
    }

    /// Returns this motion with the point `pivot`, instead of the origin, as the center of its
    /// rotations and scalings.
    #[must_use]
    pub fn pivoted_at_point(&self, pivot: DVec3) -> Self {
        let back = MotionFactor::Fixed(DAffine3::from_translation(-pivot));
        self.followed_by_map(DAffine3::from_translation(pivot)).preceded_by_factors([back])
    }

    /// Returns a motion that applies this motion to points first, and then the constant `map`.
    #[must_use]
    pub fn followed_by_map(&self, map: DAffine3) -> Self {
        Self::constant_motion(map).preceded_by_factors(self.factors.iter().copied())
    }

    /// Returns the affine map at `time` in \[0, 1]: 0 is the opening of the shutter, 1 its closing.
    #[must_use]
    pub fn at_time(&self, time: f64) -> DAffine3 {
        self.factors.iter().fold(DAffine3::IDENTITY, |map, factor| map * factor.at_time(time))
    }

    /// True if the map does not depend on time.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.factors.iter().all(|factor| matches!(factor, MotionFactor::Fixed(_)))
    }
}

/// Rotation matrix about a unit `axis` by an angle in radians, right-handed (Rodrigues).
#[must_use]
pub fn rotation_matrix(axis: DVec3, radians: f64) -> DMat3 {
    rotation_from_sin_cos(axis, libm::sincos(radians))
}

/// Rotation matrix about a unit `axis` by an angle in degrees, right-handed.
///
/// Multiples of 90° are exact.
#[must_use]
pub fn rotation_matrix_degrees(axis: DVec3, degrees: f64) -> DMat3 {
    let sin_cos = if degrees % 90.0 == 0.0 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(degrees.rem_euclid(360.0) / 90.0) as usize]
    } else {
        libm::sincos(degrees.to_radians())
    };
    rotation_from_sin_cos(axis, sin_cos)
}

/// Right-handed rotation matrix about a unit `axis`, from sine and cosine of the angle.
///
/// Formula of Rodrigues: cos·I + (1 − cos)·aaᵀ + sin·\[a\]×.
fn rotation_from_sin_cos(axis: DVec3, (sin, cos): (f64, f64)) -> DMat3 {
    let column = |e: DVec3| e * cos + axis * ((1.0 - cos) * axis.dot(e)) + axis.cross(e) * sin;
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn rotations_move_points_along_circles() {
        let motion = Motion::constant_motion(DAffine3::from_translation(DVec3::Y)).preceded_by_factors([
            MotionFactor::RotateDegrees(DVec3::Y, 180.0),
            MotionFactor::Translate(DVec3::X),
            MotionFactor::Scale(DVec3::splat(3.0)),
        ]);
        for time in [0.0, 0.3, 1.0] {
            let p = motion.at_time(time).transform_point3(DVec3::ZERO);
            let expected = DVec3::new(libm::cos(PI * time) * time, 1.0, -libm::sin(PI * time) * time);
            // The tolerance allows for a few roundings of numbers near 1.
            assert!((p - expected).length() < 1e-15 * 8.0, "{time}: {p}");
            let edge = motion.at_time(time).transform_vector3(DVec3::Y);
            assert!((edge.length() - (1.0 + 2.0 * time)).abs() < 1e-14);
        }
        assert!(!motion.is_constant());
    }

    #[test]
    fn adjacent_fixed_factors_merge() {
        let (a, b) = (DAffine3::from_scale(DVec3::splat(2.0)), DAffine3::from_translation(DVec3::X));
        let motion = Motion::constant_motion(a).preceded_by_factors([MotionFactor::Fixed(b)]);
        assert!(motion.is_constant() && motion.factors.len() == 1);
        assert_eq!((motion.at_time(0.0), motion.at_time(0.7)), (a * b, a * b));
        assert_eq!(motion.followed_by_map(b).at_time(0.5), b * a * b);
    }
}
