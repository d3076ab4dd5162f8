//! Cameras and reconstruction filters.

mod filter;

pub use filter::{Filter, FilterKind, UnknownFilter};

use crate::math::Ray;
use glam::{DVec3, Vec2};

/// A camera without a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    center: DVec3,
    forward: DVec3,
    /// One pixel to the right, and one pixel up, on the plane at distance 1.
    right: DVec3,
    up: DVec3,
    width: u32,
    height: u32,
}

/// `up` and the direction of view are parallel, or one of them is zero: the camera cannot tell which way is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the camera's up is parallel to its direction of view")]
pub struct NoUpright;

impl Pinhole {
    /// A camera at `center` looking along `direction` with full vertical `angle` \[radians] and an image of `width` × `height`
    /// pixels.
    ///
    /// # Errors
    /// [`NoUpright`] where `direction × up` vanishes.
    pub fn new(
        center: DVec3,
        direction: DVec3,
        up: DVec3,
        angle: f64,
        width: u32,
        height: u32,
    ) -> Result<Self, NoUpright> {
        let forward = direction.try_normalize().ok_or(NoUpright)?;
        let up = up.try_normalize().ok_or(NoUpright)?;
        let right = forward.cross(up);
        if right.length() < 1e-12 {
            return Err(NoUpright);
        }
        let right = right.normalize();
        let pixel = 2.0 * libm::tan(0.5 * angle) / f64::from(height);
        Ok(Self { center, forward, right: right * pixel, up: right.cross(forward) * pixel, width, height })
    }

    /// Image size in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Place of the eye.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Width of a pixel in the middle of the picture at distance 1.
    #[inline]
    #[must_use]
    pub fn pixel_angle(&self) -> f32 {
        self.right.length() as f32
    }

    /// The same camera, moved.
    #[must_use]
    pub fn translated(self, by: DVec3) -> Self {
        Self { center: self.center + by, ..self }
    }

    /// The ray through image point `p`, in pixels from the left and from the top; of unit direction.
    #[inline]
    #[must_use]
    pub fn ray(&self, p: Vec2) -> Ray {
        let x = f64::from(p.x) - 0.5 * f64::from(self.width);
        let y = 0.5 * f64::from(self.height) - f64::from(p.y);
        let direction = (self.right * x + self.up * y + self.forward).normalize();
        Ray::new(self.center.as_vec3(), direction.as_vec3())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_angle_is_vertical_and_rows_count_from_the_top() {
        let angle = 90f64.to_radians();
        let c = Pinhole::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, angle, 400, 200).unwrap();
        let close = |p: Vec2, d: Vec3| assert!((c.ray(p).direction - d.normalize()).length() < 1e-6);
        close(Vec2::new(200.0, 100.0), Vec3::NEG_Z);
        close(Vec2::new(200.0, 0.0), Vec3::new(0.0, 1.0, -1.0));
        close(Vec2::new(400.0, 100.0), Vec3::new(2.0, 0.0, -1.0));
    }

    #[test]
    fn an_up_along_the_view_is_refused() {
        let make = |d, up| Pinhole::new(DVec3::ZERO, d, up, 1.0, 4, 4);
        assert_eq!(make(DVec3::Y, DVec3::Y * 3.0), Err(NoUpright));
        assert_eq!(make(DVec3::ZERO, DVec3::Y), Err(NoUpright));
        assert!(make(DVec3::new(1e-9, 1.0, 0.0), DVec3::Y).is_ok());
    }
}
