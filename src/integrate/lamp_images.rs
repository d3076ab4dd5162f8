//! Lamp images: film regions where camera rays meet a small lamp. Prefix rays are aimed at them.
//!
//! A small lamp that the camera sees in curved glass or in a mirror covers a region of the film
//! that is often much smaller than a pixel. Camera rays near this *lamp image* pass the lamp at a
//! point that is nearly a linear function of their position on the film and on the lens. So the
//! lamp image is nearly an ellipse, whose center moves with the lens position. *Prefix rays* are
//! extra camera paths that end at the first surface that stores photons.

use crate::sampling::{Dimension, Sampler};
use glam::{Mat2, Vec2};
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

/// Radius of the disc into which most rays aimed at a lamp image (film region where camera rays
/// meet a small lamp) fall. The unit is that of film coordinates in which the lamp image is the
/// unit disc.
///
/// The radius exceeds 1, because lamp images are only approximately ellipses.
const CORE_RADIUS: f32 = 1.25;

/// Probability that a ray aimed at a lamp image (film region where camera rays meet a small lamp)
/// is sampled uniformly in the disc of [`CORE_RADIUS`]. The other aimed rays follow a distribution
/// with a heavy tail.
const CORE_SHARE: f32 = 0.75;

/// Median radius of the heavy-tailed distribution of rays aimed at a lamp image (film region where
/// camera rays meet a small lamp): half of these rays fall closer to its center. The unit is that
/// of film coordinates in which the lamp image is the unit disc.
const TAIL_RADIUS: f32 = 2.0;

/// Lamp image, as an ellipse on the film: the film region where camera rays meet a small lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LampImage {
    /// Center of the lamp image for rays through the center of the lens \[pixels from the top
    /// left].
    pub center: Vec2,
    /// Shift of the lamp image on the film per shift of the lens point \[pixels/length].
    pub shift_per_lens_position: Mat2,
    /// Map from vectors on the film \[pixels] to coordinates in which the lamp image is the unit
    /// disc.
    pub to_disc: Mat2,
}

impl LampImage {
    /// Returns the area of the lamp image (film region where camera rays meet a small lamp)
    /// \[pixels²].
    pub fn area(&self) -> f32 {
        std::f32::consts::PI / self.to_disc.determinant().abs()
    }

    /// Returns half the width and half the height of the part of the film \[pixels] that the lamp
    /// image covers as the lens point varies. `lens_radius` is the radius of the lens \[length].
    pub fn half_extent_over_lens(&self, lens_radius: f32) -> Vec2 {
        let from_disc = self.to_disc.inverse();
        let rows = |matrix: Mat2| Vec2::new(matrix.row(0).length(), matrix.row(1).length());
        rows(from_disc) + rows(self.shift_per_lens_position) * lens_radius
    }

    /// Returns the longest half axis of the lamp image's ellipse, as a vector on the film
    /// \[pixels].
    pub fn longest_half_axis(&self) -> Vec2 {
        // Find the unit vector of the disc that `from_disc` maps to the longest half axis.
        // `from_disc` maps that vector and its perpendicular to perpendicular vectors.
        let from_disc = self.to_disc.inverse();
        let (a, b) = (from_disc.x_axis, from_disc.y_axis);
        let angle = 0.5 * libm::atan2f(2.0 * a.dot(b), a.length_squared() - b.length_squared());
        let (sin, cos) = libm::sincosf(angle);
        from_disc * Vec2::new(cos, sin)
    }

    /// Returns film point `film` \[pixels] in coordinates in which the lamp image is the unit disc,
    /// for a ray through the lens point `on_lens` \[length].
    pub fn disc_point(&self, film: Vec2, on_lens: Vec2) -> Vec2 {
        self.to_disc * (film - self.center - self.shift_per_lens_position * on_lens)
    }

    /// Returns the film point \[pixels] that corresponds to the point `disc` of the unit disc, for
    /// a ray through the lens point `on_lens` \[length]. Inverse of [`LampImage::disc_point`].
    pub fn film_point(&self, disc: Vec2, on_lens: Vec2) -> Vec2 {
        self.center + self.shift_per_lens_position * on_lens + self.to_disc.inverse() * disc
    }

    /// Returns the pdf \[1/pixel²] of film point `film`, for a ray that goes through the lens point
    /// `on_lens` and is aimed at this lamp image.
    fn pdf(&self, film: Vec2, on_lens: Vec2) -> f32 {
        let squared = self.disc_point(film, on_lens).length_squared();
        let core = if squared < CORE_RADIUS * CORE_RADIUS { CORE_SHARE / (CORE_RADIUS * CORE_RADIUS) } else { 0.0 };
        let tail = TAIL_RADIUS / (TAIL_RADIUS * TAIL_RADIUS + squared);
        (core + (1.0 - CORE_SHARE) * tail * tail) * FRAC_1_PI * self.to_disc.determinant().abs()
    }

    /// Samples the film point \[pixels] of a ray that goes through the lens point `on_lens` and is
    /// aimed at this lamp image. `u` is uniform in \[0, 1)².
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

/// Lamp image (film region where camera rays meet a small lamp) in a pixel, and the probability
/// with which an aimed prefix ray of the pixel chooses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelLampImage {
    pub image: LampImage,
    /// Probability with which an aimed prefix ray of the pixel is aimed at this lamp image. The
    /// probabilities of all lamp images in a pixel sum to 1.
    pub aim_probability: f32,
}

/// Returns the pdf \[1/pixel²] of film point `film`, for a ray through the lens point `on_lens`.
/// The ray is aimed at one of the lamp images `images` (film regions where camera rays meet a small
/// lamp), chosen at random by `aim_probability`.
pub(super) fn aimed_pdf(images: &[PixelLampImage], film: Vec2, on_lens: Vec2) -> f32 {
    images.iter().map(|target| target.aim_probability * target.image.pdf(film, on_lens)).sum()
}

/// Samples the film point \[pixels] of a ray through the lens point `on_lens`. The ray is aimed at
/// one of the lamp images `images` (film regions where camera rays meet a small lamp), chosen at
/// random by `aim_probability`. `images` must not be empty.
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

/// Lamp images (film regions where camera rays meet a small lamp) in each pixel of a picture.
#[derive(Clone, Debug)]
pub(super) struct LampImages {
    /// Lamp images of all pixels, by rows from the top.
    images: Arc<[PixelLampImage]>,
    /// Index in `images` of each pixel's first lamp image, by rows from the top. The last entry is
    /// the number of all lamp images.
    starts: Arc<[u32]>,
}

impl LampImages {
    /// Stores the lamp images (film regions where camera rays meet a small lamp) in each pixel.
    /// `pixels` holds one list per pixel, by rows from the top.
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

    /// Returns a copy that keeps only the lamp images (film regions where camera rays meet a small
    /// lamp) of the pixels for which `keeps` is true.
    ///
    /// The argument of `keeps` is the index of a pixel, by rows from the top.
    pub fn in_pixels(&self, keeps: impl Fn(usize) -> bool) -> Self {
        let images = |pixel| if keeps(pixel) { self.of_pixel(pixel).to_vec() } else { Vec::new() };
        Self::from_pixels(&(0..self.starts.len() - 1).map(images).collect::<Vec<_>>())
    }

    /// Returns the lamp images (film regions where camera rays meet a small lamp) in the pixel with
    /// index `pixel`, counted by rows from the top.
    #[inline]
    pub fn of_pixel(&self, pixel: usize) -> &[PixelLampImage] {
        &self.images[self.starts[pixel] as usize..self.starts[pixel + 1] as usize]
    }
}

#[cfg(test)]
mod tests;
