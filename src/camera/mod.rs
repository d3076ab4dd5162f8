//! Cameras, lenses and pixel reconstruction filters.

mod connect;
mod crop_window;
mod filter;
mod lens;

pub use connect::CameraConnection;
pub use crop_window::{CropWindow, CropWindowError};
pub use filter::{Filter, FilterKind, FilterSample, UnknownFilter};
pub use lens::Lens;

use crate::math::{Ray, Transform};
use glam::{DVec2, DVec3, Vec2};

/// A camera, which maps positions on the film to rays in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    center: DVec3,
    forward: DVec3,
    /// World-space vector of length `pixel_size` that points to the right in the picture.
    pixel_right: DVec3,
    /// World-space vector of length `pixel_size` that points to the top of the picture.
    pixel_up: DVec3,
    /// Width of a pixel \[length]. For a perspective camera, it is measured in the plane at
    /// distance 1; for an orthographic camera, in the image plane. A panorama's pixels have no such
    /// width; the value 1 only makes `pixel_right` and `pixel_up` unit vectors.
    pixel_size: f64,
    projection: CameraProjection,
    width: u32,
    height: u32,
}

/// The projection of a camera: where its rays start, and in which directions they run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CameraProjection {
    /// Rays that start at a pinhole (`None`) or on a lens.
    Perspective(Option<Lens>),
    /// Parallel rays that start in a plane.
    Orthographic,
    /// Rays in all directions (equirectangular): columns are longitudes, rows are latitudes.
    Panorama,
}

/// Error: the up vector is parallel to the viewing direction, or one of the two is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the up vector is parallel to the viewing direction: choose another one")]
pub struct DegenerateUpVector;

impl Camera {
    /// Creates a pinhole camera at `center` that looks along `direction`.
    ///
    /// `angle` is the full vertical angle of view \[radians]. The picture has `width` × `height`
    /// pixels, and its top is towards `up`.
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
        let pixel_size = 2.0 * libm::tan(0.5 * angle) / f64::from(height);
        Self::new(center, direction, up, pixel_size, CameraProjection::Perspective(None), (width, height))
    }

    /// Creates an orthographic camera, whose rays start in a plane through `center` and run along
    /// `direction`.
    ///
    /// `size` is the height of the picture in world space \[length].
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
        Self::new(center, direction, up, size / f64::from(height), CameraProjection::Orthographic, (width, height))
    }

    /// Creates a camera at `center` whose equirectangular picture covers all directions.
    ///
    /// The center of the picture shows `direction`. The top of the picture shows `up`, made
    /// perpendicular to `direction`.
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
        Self::new(center, direction, up, 1.0, CameraProjection::Panorama, (width, height))
    }

    fn new(
        center: DVec3,
        direction: DVec3,
        up: DVec3,
        pixel_size: f64,
        projection: CameraProjection,
        (width, height): (u32, u32),
    ) -> Result<Self, DegenerateUpVector> {
        let forward = direction.try_normalize().ok_or(DegenerateUpVector)?;
        let up = up.try_normalize().ok_or(DegenerateUpVector)?;
        let right = forward.cross(up);
        if right.length() < 1e-12 {
            return Err(DegenerateUpVector);
        }
        let right = right.normalize();
        let up = right.cross(forward) * pixel_size;
        Ok(Self {
            center,
            forward,
            pixel_right: right * pixel_size,
            pixel_up: up,
            pixel_size,
            projection,
            width,
            height,
        })
    }

    /// Returns a copy of the camera with the lens `lens`; a lens of radius 0 is a pinhole.
    ///
    /// Orthographic cameras and panoramas ignore the lens.
    #[must_use]
    pub fn with_lens(self, lens: Lens) -> Self {
        match self.projection {
            CameraProjection::Perspective(_) => {
                Self { projection: CameraProjection::Perspective((lens.radius > 0.0).then_some(lens)), ..self }
            }
            CameraProjection::Orthographic | CameraProjection::Panorama => self,
        }
    }

    /// The thin lens of a perspective camera; `None` for a pinhole or another projection.
    #[must_use]
    pub fn lens(&self) -> Option<Lens> {
        match self.projection {
            CameraProjection::Perspective(lens) => lens,
            CameraProjection::Orthographic | CameraProjection::Panorama => None,
        }
    }

    /// True for an orthographic camera. The rays of all others start at one point or on a lens.
    #[must_use]
    pub fn is_orthographic(&self) -> bool {
        self.projection == CameraProjection::Orthographic
    }

    /// Width and height of the picture \[pixels].
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// World-space position of the pinhole, of the lens center, or of a panorama's center.
    ///
    /// For an orthographic camera, it is the origin of the ray through the picture's center.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Returns the width of a pixel's footprint at the ray origin \[length], and its growth per
    /// unit of distance along the ray.
    ///
    /// Both values are for the pixel at the center of the picture. An orthographic footprint does
    /// not grow. All others have width 0 at the origin.
    #[inline]
    #[must_use]
    pub fn pixel_footprint_and_growth(&self) -> (f32, f32) {
        let size = self.pixel_size as f32;
        match self.projection {
            CameraProjection::Perspective(_) => (0.0, size),
            CameraProjection::Orthographic => (size, 0.0),
            CameraProjection::Panorama => (0.0, (std::f64::consts::TAU / f64::from(self.width)) as f32),
        }
    }

    /// Returns a copy of the camera, translated by the world-space vector `by` \[length].
    #[must_use]
    pub fn translated(self, by: DVec3) -> Self {
        Self { center: self.center + by, ..self }
    }

    /// Returns the cameras of a left and a right eye, `distance` \[length] apart along the rows of
    /// the picture; `None` unless the projection is perspective.
    ///
    /// This camera is halfway between them, and all viewing directions are parallel. A point at
    /// depth `z` lies `distance / (z * w)` pixels further right in the left picture, where `w` is
    /// the width of a pixel at distance 1.
    #[must_use]
    pub fn stereo_pair(&self, distance: f64) -> Option<[Self; 2]> {
        match self.projection {
            CameraProjection::Perspective(_) => {
                let to_right = self.pixel_right.normalize() * (0.5 * distance);
                Some([self.translated(-to_right), self.translated(to_right)])
            }
            CameraProjection::Orthographic | CameraProjection::Panorama => None,
        }
    }

    /// Returns a copy of the camera, moved by the rigid transform `map`.
    #[must_use]
    pub fn transformed(self, map: &Transform) -> Self {
        let Self { center, forward, pixel_right: right, pixel_up: up, .. } = self;
        Self {
            center: map.transform_point(center),
            forward: map.transform_vector(forward),
            pixel_right: map.transform_vector(right),
            pixel_up: map.transform_vector(up),
            ..self
        }
    }

    /// Returns a copy of the camera with a picture of `width` × `height` pixels.
    ///
    /// The vertical angle of view, or the height of an orthographic picture in world space, does
    /// not change.
    #[must_use]
    pub fn with_size(self, width: u32, height: u32) -> Self {
        let ratio = match self.projection {
            CameraProjection::Perspective(_) | CameraProjection::Orthographic => {
                f64::from(self.height) / f64::from(height)
            }
            CameraProjection::Panorama => 1.0,
        };
        self.with_scaled_pixels(ratio, (width, height))
    }

    fn with_scaled_pixels(self, ratio: f64, (width, height): (u32, u32)) -> Self {
        let Self { pixel_right: right, pixel_up: up, pixel_size, .. } = self;
        Self { pixel_right: right * ratio, pixel_up: up * ratio, pixel_size: pixel_size * ratio, width, height, ..self }
    }

    /// Unit vector of the viewing direction, in world space.
    #[must_use]
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// Returns a copy of the camera that orbits the point `pivot`: position and viewing direction
    /// rotate together.
    ///
    /// `yaw` rotates about the unit vector `axis`, then `pitch` about the camera's right vector
    /// \[radians]. The factor `distance` > 0 multiplies the distance from `pivot`, the focus
    /// distance of a lens, and the size of an orthographic picture.
    #[must_use]
    pub fn orbited(self, pivot: DVec3, axis: DVec3, yaw: f64, pitch: f64, distance: f64) -> Self {
        let right = rotated_vector(self.pixel_right.normalize(), axis, yaw);
        let turned = |v: DVec3| rotated_vector(rotated_vector(v, axis, yaw), right, pitch);
        let moved = Self {
            center: pivot + turned(self.center - pivot) * distance,
            forward: turned(self.forward),
            pixel_right: turned(self.pixel_right),
            pixel_up: turned(self.pixel_up),
            ..self
        };
        match self.projection {
            CameraProjection::Perspective(lens) => {
                let lens = lens.map(|lens| Lens { focus_distance: lens.focus_distance * distance, ..lens });
                Self { projection: CameraProjection::Perspective(lens), ..moved }
            }
            CameraProjection::Orthographic => moved.with_scaled_pixels(distance, self.size()),
            CameraProjection::Panorama => moved,
        }
    }

    /// Generates the world-space ray through the film position `p` \[pixels from the top left].
    ///
    /// The ray has a unit direction. `lens` in \[0, 1)² samples the point of the lens where the ray
    /// starts; `None` is the lens center. Cameras without a lens ignore it.
    #[inline]
    #[must_use]
    pub fn generate_ray(&self, p: Vec2, lens: Option<Vec2>) -> Ray {
        if let (CameraProjection::Perspective(Some(_)), Some(u)) = (self.projection, lens) {
            return self.generate_ray_through_lens_point(p, self.sample_lens(u));
        }
        let (x, y) = self.centered_coordinates(p);
        match self.projection {
            CameraProjection::Perspective(_) => {
                let direction = (self.pixel_right * x + self.pixel_up * y + self.forward).normalize();
                Ray::new(self.center.as_vec3(), direction.as_vec3())
            }
            CameraProjection::Orthographic => {
                let origin = self.center + self.pixel_right * x + self.pixel_up * y;
                Ray::new(origin.as_vec3(), self.forward.as_vec3())
            }
            CameraProjection::Panorama => {
                let (sin_longitude, cos_longitude) = libm::sincos(std::f64::consts::TAU * x / f64::from(self.width));
                let (sin_latitude, cos_latitude) = libm::sincos(std::f64::consts::PI * y / f64::from(self.height));
                let level = self.pixel_right * sin_longitude + self.forward * cos_longitude;
                let direction = (level * cos_latitude + self.pixel_up * sin_latitude).normalize();
                Ray::new(self.center.as_vec3(), direction.as_vec3())
            }
        }
    }

    /// Generates the world-space ray that starts at the point `on_lens` of the lens \[length right
    /// and up from its center], for the film position `p` \[pixels from the top left].
    ///
    /// The ray has a unit direction. Cameras without a lens ignore `on_lens`.
    #[inline]
    #[must_use]
    pub fn generate_ray_through_lens_point(&self, p: Vec2, on_lens: DVec2) -> Ray {
        let CameraProjection::Perspective(Some(thin)) = self.projection else { return self.generate_ray(p, None) };
        let (x, y) = self.centered_coordinates(p);
        let on_lens = on_lens / self.pixel_size;
        let offset = self.pixel_right * on_lens.x + self.pixel_up * on_lens.y;
        // These vectors are relative to the camera center. In world coordinates, a small aperture
        // with near focus would lose digits.
        let in_focus = (self.pixel_right * x + self.pixel_up * y + self.forward) * thin.focus_distance;
        Ray::new((self.center + offset).as_vec3(), (in_focus - offset).normalize().as_vec3())
    }

    /// Samples a point of the lens uniformly by area, by `u` in \[0, 1)².
    ///
    /// Returns the coordinates right and up from the lens center \[length]; zero without a lens.
    #[inline]
    #[must_use]
    pub fn sample_lens(&self, u: Vec2) -> DVec2 {
        self.lens().map_or(DVec2::ZERO, |lens| lens.sample(u))
    }

    /// Converts the film position `p` \[pixels from the top left] to coordinates right and up from
    /// the film's center \[pixels].
    #[inline]
    fn centered_coordinates(&self, p: Vec2) -> (f64, f64) {
        (f64::from(p.x) - 0.5 * f64::from(self.width), 0.5 * f64::from(self.height) - f64::from(p.y))
    }
}

/// Returns `v`, rotated by `angle` \[radians] around the unit vector `axis` (Rodrigues' formula).
fn rotated_vector(v: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle);
    v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos))
}

#[cfg(test)]
mod tests;
