//! Projector lights: point lights that project a picture.

use super::EmissionPictureError;
use super::equirectangular_map::scale_and_validate_picture;
use super::light_bounds::{DirectionCone, NORMAL_ERROR};
use super::point::{PositionalLight, cone_may_illuminate};
use super::source::EmissionSample;
use crate::color::{self, Rgb};
use crate::image::Image;
use crate::math::{BoundingSphere, Ray};
use crate::sampling::PiecewiseConstant2d;
use glam::{DVec2, DVec3, UVec2, Vec2, Vec3};
use std::sync::Arc;

/// A point light that projects a picture through a pinhole. The intensity in a direction is `scale`
/// times the value of the picture's pixel in this direction.
#[derive(Clone, Debug)]
pub struct ProjectorLight {
    /// Position of the pinhole in world space.
    pub position: Vec3,
    /// World-space unit vectors: to the right of the picture, to its top, and along the axis of
    /// projection.
    axes: [Vec3; 3],
    picture: Arc<ProjectedPicture>,
    /// Factor from pixel value to radiant intensity \[W/sr].
    pub scale: Rgb,
}

/// Picture of a projector, in the plane at distance 1 in front of the pinhole.
///
/// The value is constant in each pixel. The components of *local* directions point to the right of
/// the picture, to its top, and forward along the axis of projection.
#[derive(Clone, Debug)]
pub struct ProjectedPicture {
    picture: Image,
    /// Half width and half height of the picture in the plane at distance 1.
    half_size: DVec2,
    /// Sampling distribution over the pixels, proportional to pixel value times solid angle.
    distribution: PiecewiseConstant2d,
    /// Integral of the picture's value over all directions \[pixel value · sr].
    integral: DVec3,
}

impl ProjectedPicture {
    /// Converts `picture` to the picture of a projector. `angle` is the full vertical angle of view
    /// \[radians], below π.
    ///
    /// Returns `None` if the picture is black.
    ///
    /// # Errors
    /// [`EmissionPictureError::InvalidPixel`] if a pixel is negative or not finite.
    pub fn new(picture: Image, angle: f64) -> Result<Option<Self>, EmissionPictureError> {
        let picture = scale_and_validate_picture(picture, Rgb::ONE)?;
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let y = libm::tan(0.5 * angle);
        let half_size = DVec2::new(y * width as f64 / height as f64, y);
        // Solid angle of the rectangle between the axis and the upper left corner of pixel (x, y).
        let corner_solid_angle = |x: usize, y: usize| {
            let p = half_size * (DVec2::new(x as f64 / width as f64, y as f64 / height as f64) * 2.0 - 1.0);
            libm::atan2(p.x * p.y, (1.0 + p.length_squared()).sqrt())
        };
        let solid_angle = |x: usize, y: usize| {
            corner_solid_angle(x + 1, y + 1)
                - corner_solid_angle(x, y + 1)
                - (corner_solid_angle(x + 1, y) - corner_solid_angle(x, y))
        };
        let value = |x: usize, y: usize| picture.pixels()[y * width + x];
        let weight = |x: usize, y: usize| f64::from(color::channel_mean(value(x, y))) * solid_angle(x, y);
        let Some(distribution) = PiecewiseConstant2d::new(width, height, weight) else { return Ok(None) };
        let pixels = (0..width * height).map(|i| (i % width, i / width));
        let integral = pixels.map(|(x, y)| value(x, y).as_dvec3() * solid_angle(x, y)).sum();
        Ok(Some(Self { picture, half_size, distribution, integral }))
    }

    /// Value of the picture at a pixel, given as column and row.
    fn pixel_value(&self, pixel: UVec2) -> Rgb {
        self.picture.pixels()[(pixel.y * self.picture.width() + pixel.x) as usize]
    }

    /// Column and row of the pixel that `local` points to; `None` if the direction misses the
    /// picture.
    ///
    /// `local` is a direction with the components right, up and forward.
    #[inline]
    fn pixel_in_direction(&self, local: Vec3) -> Option<UVec2> {
        let p = DVec2::new(f64::from(local.x), -f64::from(local.y)) / f64::from(local.z) / self.half_size;
        if local.z <= 0.0 || p.abs().max_element() > 1.0 {
            return None;
        }
        let size = UVec2::new(self.picture.width(), self.picture.height());
        Some(((0.5 * p + 0.5) * size.as_dvec2()).as_uvec2().min(size - 1))
    }

    /// Samples a unit direction in the local frame (right, up, forward) by `u` in \[0, 1)², in
    /// proportion to pixel values.
    ///
    /// Returns the direction, the value of its pixel and its pdf \[1/sr]; `None` if the pdf is 0.
    fn sample(&self, u: Vec2) -> Option<(Vec3, Rgb, f32)> {
        let (pixel, within, pdf) = self.distribution.sample(u);
        let size = DVec2::new(f64::from(self.picture.width()), f64::from(self.picture.height()));
        let p = self.half_size * ((pixel.as_dvec2() + within.as_dvec2()) / size * 2.0 - 1.0);
        let local = DVec3::new(p.x, -p.y, 1.0).normalize();
        let pdf = f64::from(pdf) * self.solid_angle_pdf_factor(local.z);
        (pdf > 0.0).then(|| (local.as_vec3(), self.pixel_value(pixel), pdf as f32))
    }

    /// Pdf \[1/sr] with which [`ProjectedPicture::sample`] samples the unit direction `local`, with
    /// the components right, up and forward.
    fn pdf(&self, local: Vec3) -> f32 {
        let factor = self.solid_angle_pdf_factor(f64::from(local.z)) as f32;
        self.pixel_in_direction(local).map_or(0.0, |pixel| self.distribution.pdf(pixel) * factor)
    }

    /// Factor that converts a pdf over the picture, seen as a unit square, to a pdf per solid angle
    /// \[1/sr].
    ///
    /// `cos` is the cosine of the angle between the direction and the axis of projection. An area
    /// dA in the plane at distance 1 subtends the solid angle dA cos³.
    fn solid_angle_pdf_factor(&self, cos: f64) -> f64 {
        1.0 / (4.0 * self.half_size.x * self.half_size.y * cos * cos * cos)
    }

    /// 1 − cosine of the angle between the axis of projection and a corner of the picture.
    fn one_minus_cos_to_corner(&self) -> f64 {
        let drop = self.half_size.length_squared();
        let hypotenuse = (1.0 + drop).sqrt();
        drop / (hypotenuse * (1.0 + hypotenuse))
    }
}

impl ProjectorLight {
    /// Creates a projector at `position` in world space. A pixel value of 1 gives the intensity
    /// `scale` \[W/sr].
    ///
    /// `direction` is the axis of projection. The top of the picture lies towards `up`, which must
    /// not be parallel to `direction`.
    #[must_use]
    pub fn new(position: Vec3, direction: DVec3, up: DVec3, picture: Arc<ProjectedPicture>, scale: Rgb) -> Self {
        let forward = direction.normalize();
        let right = forward.cross(up).normalize();
        let axes = [right, right.cross(forward), forward].map(|axis| axis.as_vec3());
        Self { position, axes, picture, scale }
    }

    /// Pdf \[1/sr] with which [`Light::sample_le`](super::Light::sample_le) samples unit direction
    /// `w`, in world space.
    #[must_use]
    pub fn pdf(&self, w: Vec3) -> f32 {
        self.picture.pdf(self.world_to_picture(w))
    }

    /// Transforms direction `w` from world space to the picture's components right, up and forward.
    #[inline]
    fn world_to_picture(&self, w: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(w)))
    }
}

impl PositionalLight for ProjectorLight {
    #[inline]
    fn position(&self) -> Vec3 {
        self.position
    }

    #[inline]
    fn intensity(&self, w: Vec3) -> Rgb {
        let pixel = self.picture.pixel_in_direction(self.world_to_picture(w));
        pixel.map_or(Rgb::ZERO, |pixel| self.picture.pixel_value(pixel) * self.scale)
    }

    fn sample_emission(&self, u: Vec2) -> Option<EmissionSample> {
        let (local, value, pdf) = self.picture.sample(u)?;
        let [right, up, forward] = self.axes;
        let w = (right * local.x + up * local.y + forward * local.z).normalize();
        Some(EmissionSample { ray: Ray::new(self.position, w), weight: value * self.scale / pdf })
    }

    fn flux(&self) -> Rgb {
        (self.picture.integral * self.scale.as_dvec3()).as_vec3()
    }

    fn nominal_intensity(&self) -> Rgb {
        self.scale
    }

    fn emission_cone(&self) -> (DirectionCone, f64) {
        let angle = libm::atan(self.picture.half_size.length()) + NORMAL_ERROR;
        (DirectionCone { axis: self.axes[2].as_dvec3(), half_angle: angle }, 0.0)
    }

    fn may_illuminate(&self, sphere: BoundingSphere) -> bool {
        cone_may_illuminate(self.position, self.axes[2], self.picture.one_minus_cos_to_corner() as f32, sphere)
    }
}
