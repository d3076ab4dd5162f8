//! Point lights.

use super::light_bounds::{DirectionCone, LightBounds};
use super::source::{DirectSample, EmissionSample, LightGeometry, LightSource, ShadowTarget};
use super::{POSITION_ERROR, PhotonAim};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Bounds, Ray, warp};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::f64::consts::FRAC_PI_2;

/// A point that emits with equal intensity in all directions.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    /// Position in world space.
    pub position: Vec3,
    /// Radiant intensity \[W/sr].
    pub intensity: Rgb,
}

impl LightSource for PointLight {
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        LightGeometry::Point(self.position)
    }

    #[inline]
    fn sample_li(&self, p: Vec3, _u: Vec2) -> Option<DirectSample> {
        sample_li_of_point(p, self.position, |_| self.intensity)
    }

    #[inline]
    fn pdf_li(&self, _p: Vec3, _wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        0.0
    }

    fn sample_le(&self, domain: BoundingSphere, _position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        Some(EmissionSample {
            ray: Ray::new(self.position, warp::square_to_uniform_sphere(direction)),
            flux: self.power(domain),
        })
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        _domain: BoundingSphere,
        _position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        sample_le_of_point(aim, self.position, direction, |_| self.intensity)
    }

    fn power(&self, _domain: BoundingSphere) -> Rgb {
        self.intensity * (4.0 * PI)
    }

    fn bounds(&self) -> Option<LightBounds> {
        let space = Bounds::from_points([self.position]);
        Some(LightBounds::new(space, DirectionCone::ALL, FRAC_PI_2, self.intensity * (4.0 * PI)))
    }

    fn peak_strength(&self) -> Option<Rgb> {
        Some(self.intensity)
    }

    fn may_illuminate(&self, _sphere: BoundingSphere) -> bool {
        true
    }
}

/// Samples direct light from a point; `intensity` takes the unit direction from the point.
#[inline]
pub(super) fn sample_li_of_point(p: Vec3, position: Vec3, intensity: impl Fn(Vec3) -> Rgb) -> Option<DirectSample> {
    let (d2, wi, _) = crate::math::direction_and_distance(p, position)?;
    let weight = intensity(-wi) / d2;
    (weight != Rgb::ZERO).then_some(DirectSample { wi, target: ShadowTarget::Point(position), weight, pdf: None })
}

/// False only if a cone of light around unit `axis` cannot reach `sphere`.
///
/// `outer` is 1 − cosine of the cone's half angle.
pub(super) fn cone_may_illuminate(position: Vec3, axis: Vec3, outer: f32, sphere: BoundingSphere) -> bool {
    let to = sphere.center - position;
    let distance = to.length();
    // A cone wider than a right angle is not convex: the test below does not hold for it.
    if distance <= sphere.radius || outer > 1.0 {
        return true;
    }
    // 2 asin of half the chord keeps its digits in narrow beams. The sphere subtends asin(r/d).
    let angle = 2.0 * libm::asinf((0.5 * (to / distance - axis).length()).min(1.0));
    angle <= 2.0 * libm::asinf((0.5 * outer).sqrt()) + libm::asinf(sphere.radius / distance) + POSITION_ERROR
}

/// Samples emission from a point towards the spheres of `aim`; `intensity` takes the unit direction
/// from the point.
pub(super) fn sample_le_of_point(
    aim: &PhotonAim,
    position: Vec3,
    u: Vec2,
    intensity: impl Fn(Vec3) -> Rgb,
) -> Option<EmissionSample> {
    let (w, pdf) = aim.sample_direction(position, None, u)?;
    let intensity = intensity(w);
    (intensity != Rgb::ZERO).then(|| EmissionSample { ray: Ray::new(position, w), flux: intensity / pdf })
}
