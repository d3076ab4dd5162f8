//! Cameras and reconstruction filters.

mod filter;
mod lens;

pub use filter::{Filter, FilterKind, FilterSample, UnknownFilter};
pub use lens::Lens;

use crate::math::{Ray, Transform};
use glam::{DVec3, Vec2};

/// A camera: maps film points to rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    center: DVec3,
    forward: DVec3,
    /// Vectors of one pixel to the right and up, in the plane at distance 1. Unit vectors for a
    /// panorama.
    right: DVec3,
    up: DVec3,
    /// Length of `right` and of `up`.
    pixel: f64,
    projection: Projection,
    width: u32,
    height: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Projection {
    /// Through a pinhole, or through a lens.
    Perspective(Option<Lens>),
    /// Parallel rays.
    Orthographic,
    /// All directions: longitude across, latitude down.
    Panorama,
}

/// The up vector is parallel to the viewing direction, or one of them is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the up vector is parallel to the viewing direction: choose another one")]
pub struct DegenerateUpVector;

impl Camera {
    /// A pinhole camera at `center` with the full vertical angle of view `angle` \[radians] and an
    /// image of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`DegenerateUpVector`] if `direction × up` vanishes.
    pub fn perspective(
        center: DVec3,
        direction: DVec3,
        up: DVec3,
        angle: f64,
        width: u32,
        height: u32,
    ) -> Result<Self, DegenerateUpVector> {
        let pixel = 2.0 * libm::tan(0.5 * angle) / f64::from(height);
        Self::new(center, direction, up, pixel, Projection::Perspective(None), (width, height))
    }

    /// An orthographic camera: rays start in the plane through `center` and run along `direction`.
    /// The image shows `size` from top to bottom \[length].
    ///
    /// # Errors
    /// [`DegenerateUpVector`] if `direction × up` vanishes.
    pub fn orthographic(
        center: DVec3,
        direction: DVec3,
        up: DVec3,
        size: f64,
        width: u32,
        height: u32,
    ) -> Result<Self, DegenerateUpVector> {
        Self::new(center, direction, up, size / f64::from(height), Projection::Orthographic, (width, height))
    }

    /// A panoramic camera at `center` that covers all directions. Longitude runs across the image,
    /// with `direction` in the center. Latitude runs from `up` at the top to its opposite; `up` is
    /// first made perpendicular to `direction`.
    ///
    /// # Errors
    /// [`DegenerateUpVector`] if `direction × up` vanishes.
    pub fn panorama(
        center: DVec3,
        direction: DVec3,
        up: DVec3,
        width: u32,
        height: u32,
    ) -> Result<Self, DegenerateUpVector> {
        Self::new(center, direction, up, 1.0, Projection::Panorama, (width, height))
    }

    fn new(
        center: DVec3,
        direction: DVec3,
        up: DVec3,
        pixel: f64,
        projection: Projection,
        (width, height): (u32, u32),
    ) -> Result<Self, DegenerateUpVector> {
        let forward = direction.try_normalize().ok_or(DegenerateUpVector)?;
        let up = up.try_normalize().ok_or(DegenerateUpVector)?;
        let right = forward.cross(up);
        if right.length() < 1e-12 {
            return Err(DegenerateUpVector);
        }
        let right = right.normalize();
        let up = right.cross(forward) * pixel;
        Ok(Self { center, forward, right: right * pixel, up, pixel, projection, width, height })
    }

    /// The camera with a lens, if it is a perspective one. An aperture of radius 0 is a pinhole.
    #[must_use]
    pub fn with_lens(self, lens: Lens) -> Self {
        match self.projection {
            Projection::Perspective(_) => {
                Self { projection: Projection::Perspective((lens.radius > 0.0).then_some(lens)), ..self }
            }
            Projection::Orthographic | Projection::Panorama => self,
        }
    }

    /// The lens; `None` for a pinhole and for other projections.
    #[must_use]
    pub fn lens(&self) -> Option<Lens> {
        match self.projection {
            Projection::Perspective(lens) => lens,
            Projection::Orthographic | Projection::Panorama => None,
        }
    }

    /// True if all rays start at the center, or at a lens around it.
    #[must_use]
    pub fn has_single_viewpoint(&self) -> bool {
        self.projection != Projection::Orthographic
    }

    /// Image size (width, height) \[pixels].
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Position of the pinhole or of the lens center; for an orthographic camera, of the image
    /// center.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Width of a pixel footprint at the ray origin \[length], and its growth per length along the
    /// ray.
    #[inline]
    #[must_use]
    pub fn pixel(&self) -> (f32, f32) {
        let size = self.pixel as f32;
        match self.projection {
            Projection::Perspective(_) => (0.0, size),
            Projection::Orthographic => (size, 0.0),
            Projection::Panorama => (0.0, (std::f64::consts::TAU / f64::from(self.width)) as f32),
        }
    }

    /// The camera translated by `by`.
    #[must_use]
    pub fn translated(self, by: DVec3) -> Self {
        Self { center: self.center + by, ..self }
    }

    /// The camera under a rigid map.
    #[must_use]
    pub fn moved(self, map: &Transform) -> Self {
        let Self { center, forward, right, up, .. } = self;
        Self {
            center: map.transform_point(center),
            forward: map.transform_vector(forward),
            right: map.transform_vector(right),
            up: map.transform_vector(up),
            ..self
        }
    }

    /// The ray of unit direction through image point `p`, in pixels from the top left. It starts at
    /// the lens sample `lens` in \[0, 1)², or at the lens center.
    #[inline]
    #[must_use]
    pub fn ray(&self, p: Vec2, lens: Option<Vec2>) -> Ray {
        let x = f64::from(p.x) - 0.5 * f64::from(self.width);
        let y = 0.5 * f64::from(self.height) - f64::from(p.y);
        match (self.projection, lens) {
            (Projection::Perspective(Some(thin)), Some(u)) => {
                let on_lens = thin.sample(u) / self.pixel;
                let offset = self.right * on_lens.x + self.up * on_lens.y;
                // Relative to the center: a small aperture with near focus would lose its digits in
                // world coordinates.
                let in_focus = (self.right * x + self.up * y + self.forward) * thin.focus;
                Ray::new((self.center + offset).as_vec3(), (in_focus - offset).normalize().as_vec3())
            }
            (Projection::Perspective(_), _) => {
                let direction = (self.right * x + self.up * y + self.forward).normalize();
                Ray::new(self.center.as_vec3(), direction.as_vec3())
            }
            (Projection::Orthographic, _) => {
                let origin = self.center + self.right * x + self.up * y;
                Ray::new(origin.as_vec3(), self.forward.as_vec3())
            }
            (Projection::Panorama, _) => {
                let (sin_longitude, cos_longitude) = libm::sincos(std::f64::consts::TAU * x / f64::from(self.width));
                let (sin_latitude, cos_latitude) = libm::sincos(std::f64::consts::PI * y / f64::from(self.height));
                let level = self.right * sin_longitude + self.forward * cos_longitude;
                let direction = (level * cos_latitude + self.up * sin_latitude).normalize();
                Ray::new(self.center.as_vec3(), direction.as_vec3())
            }
        }
    }
}

#[cfg(test)]
mod tests;
