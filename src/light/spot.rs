//! Spotlights: point lights limited to a cone with a smooth edge.

use super::light_bounds::{DirectionCone, NORMAL_ERROR};
use super::point::{PositionalLight, cone_may_illuminate};
use super::source::EmissionSample;
use crate::color::Rgb;
use crate::math::{BoundingSphere, Frame, Ray, warp};
use glam::{DVec3, Vec2, Vec3};
use std::f32::consts::TAU;
use std::f64::consts::FRAC_PI_2;

/// A point light with full intensity in an inner cone, and a smooth falloff to zero at an outer
/// cone.
#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    /// Position of the light in world space.
    pub position: Vec3,
    /// Unit axis of both cones.
    pub axis: Vec3,
    /// 1 − cosine of the inner cone's half angle. In narrow cones, this number is more precise than
    /// the cosine itself, which is close to 1.
    pub inner_one_minus_cos: f32,
    /// 1 − cosine of the outer cone's half angle.
    pub outer_one_minus_cos: f32,
    /// Radiant intensity inside the inner cone \[W/sr].
    pub peak_intensity: Rgb,
}

impl SpotLight {
    /// Creates a spotlight at `position` in world space. Its `axis` has any length above zero.
    ///
    /// `inner` and `outer` are the half angles of the cones \[radians]. `peak` is the intensity
    /// inside the inner cone \[W/sr].
    #[must_use]
    pub fn new(position: Vec3, axis: DVec3, inner: f64, outer: f64, peak: Rgb) -> Self {
        let (inner_one_minus_cos, outer_one_minus_cos) = (one_minus_cos(inner) as f32, one_minus_cos(outer) as f32);
        Self {
            position,
            axis: axis.normalize().as_vec3(),
            inner_one_minus_cos,
            outer_one_minus_cos,
            peak_intensity: peak,
        }
    }

    /// Intensity \[W/sr] in directions at the angle θ from the axis. `one_minus_cos` is 1 − cos θ.
    ///
    /// Between the inner and the outer cone, the intensity falls as a smooth step of cos θ (Pharr,
    /// Jakob, Humphreys 2023, section 12.2.1).
    #[inline]
    fn intensity_at_one_minus_cos(&self, one_minus_cos: f32) -> Rgb {
        let (inner, outer) = (self.inner_one_minus_cos, self.outer_one_minus_cos);
        if one_minus_cos <= inner {
            return self.peak_intensity;
        }
        let x = (outer - one_minus_cos) / (outer - inner);
        if x > 0.0 { self.peak_intensity * (x * x * (3.0 - 2.0 * x)) } else { Rgb::ZERO }
    }

    /// Radiant flux of the light \[W].
    #[must_use]
    pub fn flux(&self) -> Rgb {
        let (inner, outer) = (self.inner_one_minus_cos, self.outer_one_minus_cos);
        // The mean of the smooth step over the falloff is one half.
        self.peak_intensity * (TAU * (inner + 0.5 * (outer - inner)))
    }
}

impl PositionalLight for SpotLight {
    #[inline]
    fn position(&self) -> Vec3 {
        self.position
    }

    #[inline]
    fn intensity(&self, w: Vec3) -> Rgb {
        // For unit vectors, |w − axis|² = 2(1 − cos), which keeps its digits in narrow beams.
        self.intensity_at_one_minus_cos(0.5 * (w - self.axis).length_squared())
    }

    fn sample_emission(&self, u: Vec2) -> Option<EmissionSample> {
        let w = Frame::from_normal(self.axis).to_world(warp::square_to_uniform_cone(u, self.outer_one_minus_cos));
        // `intensity(w)` would be imprecise: in a narrow beam, the rounding error of `w` is not
        // small against the beam's width.
        let intensity = self.intensity_at_one_minus_cos(u.x * self.outer_one_minus_cos);
        let flux = intensity * (TAU * self.outer_one_minus_cos);
        Some(EmissionSample { ray: Ray::new(self.position, w), weight: flux })
    }

    fn flux(&self) -> Rgb {
        self.flux()
    }

    fn nominal_intensity(&self) -> Rgb {
        self.peak_intensity
    }

    fn emission_cone(&self) -> (DirectionCone, f64) {
        let [inner, outer] = [self.inner_one_minus_cos, self.outer_one_minus_cos]
            .map(|drop| 2.0 * libm::asin((0.5 * f64::from(drop)).sqrt().min(1.0)));
        let spread = (outer - inner).min(FRAC_PI_2);
        (DirectionCone { axis: self.axis.as_dvec3(), half_angle: outer - spread + NORMAL_ERROR }, spread)
    }

    fn may_illuminate(&self, sphere: BoundingSphere) -> bool {
        cone_may_illuminate(self.position, self.axis, self.outer_one_minus_cos, sphere)
    }
}

/// 1 − cos x, for x in radians, computed without cancellation.
fn one_minus_cos(x: f64) -> f64 {
    let sin = libm::sin(0.5 * x);
    2.0 * sin * sin
}
