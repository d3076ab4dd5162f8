//! Goniometric lights: point lights with a measured intensity distribution.

use super::point::PositionalLight;
use super::source::EmissionSample;
use super::{EmissionPictureError, EquirectangularMap};
use crate::color::Rgb;
use crate::image::Image;
use crate::math::Ray;
use glam::{DVec3, Vec2, Vec3};
use std::sync::Arc;

/// Number of rows of the map that [`map_from_intensity_profile`] creates: 4 rows per degree.
const PROFILE_ROWS: u32 = 720;

/// A point light whose intensity in each direction is the value of an equirectangular map.
#[derive(Clone, Debug)]
pub struct GoniometricLight {
    /// Position of the light in world space.
    pub position: Vec3,
    /// Axes x, y and z of the map's frame, as unit vectors in world space. The center of the map
    /// lies at −z, its top at +y.
    axes: [Vec3; 3],
    /// Relative intensity over all directions. The intensity is the value of this map times
    /// `scale`.
    map: Arc<EquirectangularMap>,
    /// Factor from map value to intensity \[W/sr].
    pub scale: Rgb,
}

impl GoniometricLight {
    /// Creates a light at `position` in world space. A map value of 1 gives the intensity `scale`
    /// \[W/sr].
    ///
    /// The center of the map lies in world direction `direction`, its top towards `up`. These two
    /// vectors must not be parallel.
    #[must_use]
    pub fn new(position: Vec3, direction: DVec3, up: DVec3, map: Arc<EquirectangularMap>, scale: Rgb) -> Self {
        let forward = direction.normalize();
        let right = forward.cross(up).normalize();
        let axes = [right, right.cross(forward), -forward].map(|axis| axis.as_vec3());
        Self { position, axes, map, scale }
    }

    /// Transforms a direction from world space to the frame of the map.
    #[inline]
    fn world_to_map(&self, w: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(w)))
    }

    /// Pdf \[1/sr] with which [`Light::sample_le`](super::Light::sample_le) samples the emitted
    /// unit direction `w`.
    #[must_use]
    pub fn pdf(&self, w: Vec3) -> f32 {
        self.map.pdf(self.world_to_map(w))
    }
}

/// Converts an intensity profile, which is symmetric about +y, to a map over all directions.
///
/// `profile` lists pairs of an angle from +y \[degrees] and the intensity at this angle, in any
/// unit. Angles ascend, from 0 or more to 180 or less. The intensity is linear between listed
/// angles, and 0 beyond the first and the last.
///
/// # Errors
/// [`EmissionPictureError`] if an intensity is negative or not finite.
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

impl PositionalLight for GoniometricLight {
    #[inline]
    fn position(&self) -> Vec3 {
        self.position
    }

    #[inline]
    fn intensity(&self, w: Vec3) -> Rgb {
        self.map.value_in_direction(self.world_to_map(w)) * self.scale
    }

    fn sample_emission(&self, u: Vec2) -> Option<EmissionSample> {
        let d = self.map.sample(u)?;
        let [x, y, z] = self.axes;
        let w = (x * d.x + y * d.y + z * d.z).normalize();
        let pdf = self.pdf(w);
        (pdf > 0.0).then(|| EmissionSample { ray: Ray::new(self.position, w), weight: self.intensity(w) / pdf })
    }

    fn flux(&self) -> Rgb {
        self.map.integral() * self.scale
    }

    fn nominal_intensity(&self) -> Rgb {
        self.scale
    }
}
