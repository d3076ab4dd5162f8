//! Point lights, and [`PositionalLight`], the interface of all lights at one point.

use super::light_bounds::{DirectionCone, LightBounds};
use super::source::{DirectLightSample, EmissionSample, LightGeometry, LightSource, ShadowTarget};
use super::{PhotonAim, RELATIVE_POSITION_ERROR};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Bounds, Ray, warp};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::f64::consts::FRAC_PI_2;

/// A point that emits with equal intensity in all directions.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    /// Position of the light in world space.
    pub position: Vec3,
    /// Radiant intensity, equal in all directions \[W/sr].
    pub intensity: Rgb,
}

/// A light at one point, with an intensity that depends on the direction.
///
/// Its emitted rays depend only on `direction`, one of the two random points that
/// [`LightSource::sample_le`] gets. The other one, `position`, is not used.
pub(super) trait PositionalLight {
    /// Position of the light in world space.
    fn position(&self) -> Vec3;

    /// Radiant intensity of the light in unit direction `w` \[W/sr].
    fn intensity(&self, w: Vec3) -> Rgb;

    /// Samples a ray that leaves the light, by `u` in \[0, 1)²; `None` if the ray carries no light.
    fn sample_emission(&self, u: Vec2) -> Option<EmissionSample>;

    /// Radiant flux of the light \[W].
    fn flux(&self) -> Rgb;

    /// Radiant intensity \[W/sr] that a scene file states for the light: the largest intensity of
    /// any direction. For a projector or goniometric light, it is the intensity where the picture
    /// or map has the value 1.
    fn nominal_intensity(&self) -> Rgb;

    /// Returns a cone and an angle \[radians] that bound the emitted directions: each emitted
    /// direction lies within this angle of some direction in the cone.
    ///
    /// The two values become `normal_cone` and `spread` of [`LightBounds::new`]. The default bounds
    /// contain all directions, so they are correct for every light.
    fn emission_cone(&self) -> (DirectionCone, f64) {
        (DirectionCone::ALL, FRAC_PI_2)
    }

    /// True if the light may shine into `sphere`, ignoring occlusion; false only if it certainly
    /// does not. The default `true` is correct for every light.
    fn may_illuminate(&self, _sphere: BoundingSphere) -> bool {
        true
    }
}

impl PositionalLight for PointLight {
    #[inline]
    fn position(&self) -> Vec3 {
        self.position
    }

    #[inline]
    fn intensity(&self, _w: Vec3) -> Rgb {
        self.intensity
    }

    fn sample_emission(&self, u: Vec2) -> Option<EmissionSample> {
        Some(EmissionSample { ray: Ray::new(self.position, warp::square_to_uniform_sphere(u)), weight: self.flux() })
    }

    fn flux(&self) -> Rgb {
        self.intensity * (4.0 * PI)
    }

    fn nominal_intensity(&self) -> Rgb {
        self.intensity
    }
}

impl<L: PositionalLight> LightSource for L {
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        LightGeometry::Point(self.position())
    }

    #[inline]
    fn sample_li(&self, p: Vec3, _u: Vec2) -> Option<DirectLightSample> {
        let (d2, wi, _) = crate::math::distance2_direction_distance(p, self.position())?;
        let irradiance = self.intensity(-wi) / d2;
        let target = ShadowTarget::Point(self.position());
        (irradiance != Rgb::ZERO).then_some(DirectLightSample { wi, target, weight: irradiance, pdf: None })
    }

    #[inline]
    fn pdf_li(&self, _p: Vec3, _wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        0.0
    }

    fn sample_le(&self, _domain: BoundingSphere, _position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        self.sample_emission(direction)
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        _domain: BoundingSphere,
        _position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        let (w, pdf) = aim.sample_direction(self.position(), None, direction)?;
        let intensity = self.intensity(w);
        (intensity != Rgb::ZERO).then(|| EmissionSample { ray: Ray::new(self.position(), w), weight: intensity / pdf })
    }

    fn power(&self, _domain: BoundingSphere) -> Rgb {
        self.flux()
    }

    fn bounds(&self) -> Option<LightBounds> {
        let (axes, spread) = self.emission_cone();
        Some(LightBounds::new(Bounds::from_points([self.position()]), axes, spread, self.flux()))
    }

    fn nominal_strength(&self) -> Option<Rgb> {
        Some(self.nominal_intensity())
    }

    fn may_illuminate(&self, sphere: BoundingSphere) -> bool {
        PositionalLight::may_illuminate(self, sphere)
    }
}

/// True if a ray from `position` inside the cone around the unit vector `axis` may enter `sphere`;
/// false only if no such ray enters it.
///
/// `one_minus_cos` is 1 − cosine of the cone's half angle.
pub(super) fn cone_may_illuminate(position: Vec3, axis: Vec3, one_minus_cos: f32, sphere: BoundingSphere) -> bool {
    let to = sphere.center - position;
    let distance = to.length();
    // The test below assumes a convex cone: a half angle of at most 90°.
    if distance <= sphere.radius || one_minus_cos > 1.0 {
        return true;
    }
    // The angle between unit vectors, 2 asin(chord/2), is accurate in narrow cones; acos is not.
    // The sphere subtends asin(r/d).
    let angle = 2.0 * libm::asinf((0.5 * (to / distance - axis).length()).min(1.0));
    angle
        <= 2.0 * libm::asinf((0.5 * one_minus_cos).sqrt())
            + libm::asinf(sphere.radius / distance)
            + RELATIVE_POSITION_ERROR
}
