//! Goniometric lights: points with a measured intensity distribution.

use super::light_bounds::{DirectionCone, LightBounds};
use super::point::{sample_le_of_point, sample_li_of_point};
use super::source::{DirectSample, EmissionSample, LightGeometry, LightSource};
use super::{EmissionPictureError, EquirectangularMap, PhotonAim};
use crate::color::Rgb;
use crate::image::Image;
use crate::math::{BoundingSphere, Bounds, Ray};
use crate::shape::SurfacePoint;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Rows of the map that a profile is resampled to: a quarter of a degree each.
const PROFILE_ROWS: u32 = 720;

/// A point with an intensity that depends on the direction, given by an equirectangular map.
#[derive(Clone, Debug)]
pub struct GoniometricLight {
    /// Position in world space.
    pub position: Vec3,
    /// Unit axes of the map: +x is right of its center, +y its top, −z its center.
    axes: [Vec3; 3],
    /// Distribution of the intensity over directions.
    map: Arc<EquirectangularMap>,
    /// Factor from map value to intensity \[W/sr].
    pub scale: Rgb,
}

impl GoniometricLight {
    /// A light with a map whose value 1 means intensity `scale` \[W/sr].
    ///
    /// `direction` is the center of the map and `up` its top, which is not parallel to `direction`.
    #[must_use]
    pub fn new(position: Vec3, direction: DVec3, up: DVec3, map: Arc<EquirectangularMap>, scale: Rgb) -> Self {
        let forward = direction.normalize();
        let right = forward.cross(up).normalize();
        let axes = [right, right.cross(forward), -forward].map(|axis| axis.as_vec3());
        Self { position, axes, map, scale }
    }

    /// World direction in the frame of the map.
    #[inline]
    fn world_to_map(&self, w: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(w)))
    }

    /// Intensity in unit direction `w` \[W/sr].
    #[inline]
    #[must_use]
    pub fn intensity(&self, w: Vec3) -> Rgb {
        self.map.value_in_direction(self.world_to_map(w)) * self.scale
    }

    /// Pdf \[1/sr] with which emission samples unit `w`.
    #[must_use]
    pub fn pdf(&self, w: Vec3) -> f32 {
        self.map.pdf(self.world_to_map(w))
    }
}

/// Map of a profile that is symmetric about +y.
///
/// `profile` lists angles from +y \[degrees], ascending from at least 0 to at most 180, with the
/// value at each. Values are linear between angles, and zero outside of them.
///
/// # Errors
/// [`EmissionPictureError`] if a value is negative or not finite.
pub fn map_from_intensity_profile(profile: &[(f64, f64)]) -> Result<EquirectangularMap, EmissionPictureError> {
    let value = |row: u32| {
        let angle = (f64::from(row) + 0.5) * 180.0 / f64::from(PROFILE_ROWS);
        let next = profile.partition_point(|(a, _)| *a < angle);
        match (next.checked_sub(1).and_then(|i| profile.get(i)), profile.get(next)) {
            (Some((a, x)), Some((b, y))) => x + (y - x) * (angle - a) / (b - a),
            (None, _) | (_, None) => 0.0,
        }
    };
    let pixels = (0..PROFILE_ROWS).map(|row| Rgb::splat(value(row) as f32)).collect();
    EquirectangularMap::new(Image::from_pixels(1, PROFILE_ROWS, pixels)?, Rgb::ONE)
}

impl LightSource for GoniometricLight {
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
        let d = self.map.sample(direction)?;
        let [x, y, z] = self.axes;
        let w = (x * d.x + y * d.y + z * d.z).normalize();
        let pdf = self.pdf(w);
        (pdf > 0.0).then(|| EmissionSample { ray: Ray::new(self.position, w), flux: self.intensity(w) / pdf })
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

    /// Flux \[W]: the exact integral of the interpolated map.
    fn power(&self, _domain: BoundingSphere) -> Rgb {
        self.map.integral() * self.scale
    }

    fn bounds(&self) -> Option<LightBounds> {
        let flux = self.map.integral() * self.scale;
        Some(LightBounds::new(Bounds::from_points([self.position]), DirectionCone::ALL, FRAC_PI_2, flux))
    }

    fn peak_strength(&self) -> Option<Rgb> {
        Some(self.scale)
    }

    fn may_illuminate(&self, _sphere: BoundingSphere) -> bool {
        true
    }
}
