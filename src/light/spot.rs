//! Spotlights.

use super::PhotonAim;
use super::light_bounds::{DirectionCone, LightBounds, NORMAL_ERROR};
use super::point::{cone_may_illuminate, sample_le_of_point, sample_li_of_point};
use super::source::{DirectSample, EmissionSample, LightGeometry, LightSource};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Bounds, Frame, Ray, warp};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use std::f64::consts::FRAC_PI_2;

/// A point with full intensity inside an inner cone and a smooth falloff to zero at an outer cone.
#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    /// Position in world space.
    pub position: Vec3,
    /// Unit axis of the beam.
    pub axis: Vec3,
    /// 1 − cosine of the half angle at which the falloff begins. A cosine alone loses its digits in
    /// narrow beams.
    pub inner: f32,
    /// 1 − cosine of the half angle beyond which the intensity is zero.
    pub outer: f32,
    /// Intensity inside the inner cone \[W/sr].
    pub peak: Rgb,
}

impl SpotLight {
    /// Intensity in unit direction `w` \[W/sr].
    #[inline]
    #[must_use]
    pub fn intensity(&self, w: Vec3) -> Rgb {
        // |w − a|² = 2(1 − cos) keeps its digits in narrow beams.
        self.intensity_at_one_minus_cos(0.5 * (w - self.axis).length_squared())
    }

    /// Intensity \[W/sr] where 1 − cosine of the angle to the axis is `one_minus_cos`.
    ///
    /// The falloff is a smooth step in the cosine (Pharr, Jakob, Humphreys 2023, section 12.2.1).
    #[inline]
    #[must_use]
    pub fn intensity_at_one_minus_cos(&self, one_minus_cos: f32) -> Rgb {
        if one_minus_cos <= self.inner {
            return self.peak;
        }
        let x = (self.outer - one_minus_cos) / (self.outer - self.inner);
        if x > 0.0 { self.peak * (x * x * (3.0 - 2.0 * x)) } else { Rgb::ZERO }
    }

    /// Flux \[W]. The mean of the smooth step over the rim is one half.
    #[must_use]
    pub fn flux(&self) -> Rgb {
        self.peak * (TAU * (self.inner + 0.5 * (self.outer - self.inner)))
    }
}

impl LightSource for SpotLight {
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        LightGeometry::Point(self.position)
    }

    #[inline]
    fn sample_li(&self, p: Vec3, _u: Vec2) -> Option<DirectSample> {
        sample_li_of_point(p, self.position, |w| self.intensity(w))
    }

    #[inline]
    fn pdf_li(&self, _p: Vec3, _wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        0.0
    }

    fn sample_le(&self, _domain: BoundingSphere, _position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        let w = Frame::from_normal(self.axis).to_world(warp::square_to_uniform_cone(direction, self.outer));
        // The sampled cosine is exact; in a narrow beam, the rounding of `w` is a large part of its
        // width.
        let intensity = self.intensity_at_one_minus_cos(direction.x * self.outer);
        Some(EmissionSample { ray: Ray::new(self.position, w), flux: intensity * (TAU * self.outer) })
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        _domain: BoundingSphere,
        _position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        sample_le_of_point(aim, self.position, direction, |w| self.intensity(w))
    }

    fn power(&self, _domain: BoundingSphere) -> Rgb {
        self.flux()
    }

    fn bounds(&self) -> Option<LightBounds> {
        let [inner, outer] =
            [self.inner, self.outer].map(|drop| 2.0 * libm::asin((0.5 * f64::from(drop)).sqrt().min(1.0)));
        let spread = (outer - inner).min(FRAC_PI_2);
        let normals = DirectionCone { axis: self.axis.as_dvec3(), angle: outer - spread + NORMAL_ERROR };
        Some(LightBounds::new(Bounds::from_points([self.position]), normals, spread, self.flux()))
    }

    fn peak_strength(&self) -> Option<Rgb> {
        Some(self.peak)
    }

    fn may_illuminate(&self, sphere: BoundingSphere) -> bool {
        cone_may_illuminate(self.position, self.axis, self.outer, sphere)
    }
}
