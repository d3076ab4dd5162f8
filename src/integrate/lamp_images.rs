//! Images of lamps: the parts of the film at which prefix rays are aimed.
//!
//! A small lamp that the camera sees in curved glass or in a mirror has an *image* on the film,
//! often much smaller than a pixel. Camera rays near the image pass the lamp at a point that is
//! nearly a linear function of their position on the film and on the lens. So the image is nearly
//! an ellipse, whose center moves with the lens position. *Prefix rays* are extra camera paths that
//! end at the first surface that stores photons.

use crate::sampling::{Dimension, Sampler};
use glam::{Mat2, Vec2};
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

/// Radius of the disc into which most rays aimed at the image of a lamp fall, in film coordinates
/// in which the image is the unit disc.
///
/// The radius exceeds 1, because images are only approximately ellipses.
const CORE_RADIUS: f32 = 1.25;

/// Probability that a ray that is aimed at the image of a lamp is sampled uniformly in the disc of
/// [`CORE_RADIUS`]. Other aimed rays follow a distribution with a heavy tail.
const CORE_SHARE: f32 = 0.75;

/// Median radius of the heavy-tailed distribution: half of its rays fall closer to the center of
/// the image. The film coordinates are those in which the image of the lamp is the unit disc.
const TAIL_RADIUS: f32 = 2.0;

/// Image of a lamp on the film, as an ellipse: the part of the film at which camera rays meet the
/// lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LampImage {
    /// Center of the image for rays through the center of the lens \[pixels from the top left].
    pub center: Vec2,
    /// Shift of the image on the film per shift of the lens point \[pixels/length].
    pub shift_per_lens_position: Mat2,
    /// Map from vectors on the film \[pixels] to coordinates in which the image is the unit disc.
    pub to_disc: Mat2,
}

impl LampImage {
    /// Returns the area of the image \[pixels²].
    pub fn area(&self) -> f32 {
        std::f32::consts::PI / self.to_disc.determinant().abs()
    }

    /// Returns half the width and half the height of the part of the film \[pixels] that the image
    /// covers as the lens point varies. `lens_radius` is the radius of the lens \[length].
    pub fn half_extent_over_lens(&self, lens_radius: f32) -> Vec2 {
        let from_disc = self.to_disc.inverse();
        let rows = |matrix: Mat2| Vec2::new(matrix.row(0).length(), matrix.row(1).length());
        rows(from_disc) + rows(self.shift_per_lens_position) * lens_radius
    }

    /// Returns the longest half axis of the ellipse, as a vector on the film \[pixels].
    pub fn longest_half_axis(&self) -> Vec2 {
        // Find the unit vector of the disc that maps to the longest half axis. That vector and its
        // perpendicular have perpendicular images.
        let from_disc = self.to_disc.inverse();
        let (a, b) = (from_disc.x_axis, from_disc.y_axis);
        let angle = 0.5 * libm::atan2f(2.0 * a.dot(b), a.length_squared() - b.length_squared());
        let (sin, cos) = libm::sincosf(angle);
        from_disc * Vec2::new(cos, sin)
    }

    /// Returns film point `film` \[pixels] in coordinates in which the image is the unit disc, for
    /// a ray through the lens point `on_lens` \[length].
    pub fn disc_point(&self, film: Vec2, on_lens: Vec2) -> Vec2 {
        self.to_disc * (film - self.center - self.shift_per_lens_position * on_lens)
    }

    /// Returns the film point \[pixels] of a point `disc` of the unit disc: the inverse of
    /// [`LampImage::disc_point`].
    pub fn film_point(&self, disc: Vec2, on_lens: Vec2) -> Vec2 {
        self.center + self.shift_per_lens_position * on_lens + self.to_disc.inverse() * disc
    }

    /// Returns the pdf \[1/pixel²] of film point `film`, for a ray through the lens point `on_lens`
    /// that is aimed at this image.
    fn pdf(&self, film: Vec2, on_lens: Vec2) -> f32 {
        let squared = self.disc_point(film, on_lens).length_squared();
        let core = if squared < CORE_RADIUS * CORE_RADIUS { CORE_SHARE / (CORE_RADIUS * CORE_RADIUS) } else { 0.0 };
        let tail = TAIL_RADIUS / (TAIL_RADIUS * TAIL_RADIUS + squared);
        (core + (1.0 - CORE_SHARE) * tail * tail) * FRAC_1_PI * self.to_disc.determinant().abs()
    }

    /// Samples the film point \[pixels] of a ray through the lens point `on_lens` that is aimed at
    /// this image, by `u` in \[0, 1)².
    fn sample(&self, u: Vec2, on_lens: Vec2) -> Vec2 {
        let radius = if u.x < CORE_SHARE {
            CORE_RADIUS * (u.x / CORE_SHARE).sqrt()
        } else {
            let x = ((u.x - CORE_SHARE) / (1.0 - CORE_SHARE)).min(1.0 - f32::EPSILON);
            TAIL_RADIUS * (x / (1.0 - x)).sqrt()
        };
        let (sin, cos) = libm::sincosf(TAU * u.y);
        self.film_point(radius * Vec2::new(cos, sin), on_lens)
    }
}

/// Image of a lamp in a pixel, and the probability with which an aimed ray of the pixel chooses
/// this image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelLampImage {
    pub image: LampImage,
    /// Probability that an aimed ray of the pixel is aimed at this image.
    pub aim_probability: f32,
}

/// Returns the pdf \[1/pixel²] of film point `film`, for a ray through the lens point `on_lens`.
/// The ray is aimed at one of `images`, chosen at random by `aim_probability`.
pub(super) fn aimed_pdf(images: &[PixelLampImage], film: Vec2, on_lens: Vec2) -> f32 {
    images.iter().map(|target| target.aim_probability * target.image.pdf(film, on_lens)).sum()
}

/// Samples the film point \[pixels] of a ray through the lens point `on_lens`. The ray is aimed at
/// one of `images`, chosen at random by `aim_probability`. `images` must not be empty.
pub(super) fn sample_aimed_film_point(images: &[PixelLampImage], sampler: Sampler, on_lens: Vec2) -> Vec2 {
    let mut u = sampler.get_2d(Dimension::Film);
    let (last, others) = images.split_last().expect("a pixel with aimed rays has an image");
    for target in others {
        if u.x < target.aim_probability {
            u.x /= target.aim_probability;
            return target.image.sample(u, on_lens);
        }
        u.x -= target.aim_probability;
    }
    u.x = (u.x / last.aim_probability).min(1.0 - f32::EPSILON / 2.0);
    last.image.sample(u, on_lens)
}

/// Images of lamps (film regions where camera rays meet a lamp) in each pixel of a picture.
#[derive(Clone, Debug)]
pub(super) struct LampImages {
    /// Images of all pixels, by rows from the top.
    images: Arc<[PixelLampImage]>,
    /// Index in `images` of each pixel's first image, by rows from the top. The last entry is the
    /// number of all images.
    starts: Arc<[u32]>,
}

impl LampImages {
    /// Stores the images of lamps in each pixel. `pixels` holds one list per pixel, by rows from
    /// the top.
    pub fn from_pixels(pixels: &[Vec<PixelLampImage>]) -> Self {
        let mut starts = Vec::with_capacity(pixels.len() + 1);
        starts.push(0);
        let mut total = 0;
        for images in pixels {
            total += images.len() as u32;
            starts.push(total);
        }
        Self { images: pixels.iter().flatten().copied().collect(), starts: starts.into() }
    }

    /// Returns a copy with the images of those pixels for which `keeps` is true. The other pixels
    /// have none.
    ///
    /// The argument of `keeps` is the index of a pixel, by rows from the top.
    pub fn in_pixels(&self, keeps: impl Fn(usize) -> bool) -> Self {
        let images = |pixel| if keeps(pixel) { self.of_pixel(pixel).to_vec() } else { Vec::new() };
        Self::from_pixels(&(0..self.starts.len() - 1).map(images).collect::<Vec<_>>())
    }

    /// Returns the images in the pixel with index `pixel`, counted by rows from the top.
    #[inline]
    pub fn of_pixel(&self, pixel: usize) -> &[PixelLampImage] {
        &self.images[self.starts[pixel] as usize..self.starts[pixel + 1] as usize]
    }
}

#[cfg(test)]
mod tests;
