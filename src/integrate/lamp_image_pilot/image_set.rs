//! Set of the lamp images that the pilot has found: film regions where camera rays meet a small
//! lamp.

use crate::integrate::lamp_images::LampImage;
use crate::integrate::specular_chain::{CameraPoint, SpecularChain};
use crate::sampling::Sampler;
use glam::Vec2;
use std::collections::HashMap;

/// Distance from the center of an elliptic lamp image to a point just beyond an end of its longest
/// axis, relative to the longest half axis of the ellipse. From that point, the pilot searches for
/// other parts of the lamp image, a film region where camera rays meet a small lamp.
const RELATIVE_IMAGE_END_DISTANCE: f32 = 1.1;

/// Lamp image (film region where camera rays meet a small lamp) that the pilot has found.
#[derive(Clone, Copy, Debug)]
pub(super) struct FoundLampImage {
    pub image: LampImage,
    /// Film point and lens point of the camera ray by which the pilot found the lamp image. This
    /// ray hits the lamp.
    pub point: CameraPoint,
    /// Sampler of the camera ray through `point`.
    pub sampler: Sampler,
    /// Index of the lamp's light in the scene.
    pub light: u32,
    pub chain: SpecularChain,
    /// Radiance that the camera ray through `point` finds, averaged over RGB \[W/(m² sr)].
    pub radiance: f32,
}

impl FoundLampImage {
    /// Returns two film points \[pixels], one just beyond each end of the longest axis of the lamp
    /// image: the elliptic film region where camera rays meet a small lamp. From there, the pilot
    /// searches for other parts of the lamp image.
    ///
    /// The ellipse is for rays through the lens point at which the lamp image was found.
    pub fn ends(&self) -> [Vec2; 2] {
        let longest = self.image.longest_half_axis() * RELATIVE_IMAGE_END_DISTANCE;
        let center = self.image.film_point(Vec2::ZERO, self.point.lens_point());
        [center - longest, center + longest]
    }
}

/// Set of the lamp images that the pilot has found, without repetitions. A lamp image is a film
/// region where camera rays meet a small lamp.
pub(super) struct ImageSet {
    pub images: Vec<FoundLampImage>,
    /// Radius of the lens \[length]; 0 if all camera rays start at the lens center.
    lens_radius: f32,
    /// Indices in `images`, by column and row of a pixel. A pixel lists the lamp images that reach
    /// it from at least one point of the lens.
    by_pixel: HashMap<(i32, i32), Vec<u32>>,
}

impl ImageSet {
    pub fn new(lens_radius: f32) -> Self {
        Self { images: Vec::new(), lens_radius, by_pixel: HashMap::new() }
    }

    /// Adds the lamp image `image` (film region where camera rays meet a small lamp) and returns
    /// true. Returns false if the set already has a lamp image of the same lamp, over the same
    /// chain of specular vertices, that covers the film point at which `image` was found.
    pub fn insert(&mut self, image: FoundLampImage) -> bool {
        let FoundLampImage { point, light, chain, .. } = image;
        if self.covers(point.film, point.lens_point(), light, chain) {
            return false;
        }
        let center = image.image.center;
        let half_extent = image.image.half_extent_over_lens(self.lens_radius);
        let (low, high) = ((center - half_extent).floor().as_ivec2(), (center + half_extent).floor().as_ivec2());
        let index = self.images.len() as u32;
        for pixel in (low.y..=high.y).flat_map(|y| (low.x..=high.x).map(move |x| (x, y))) {
            self.by_pixel.entry(pixel).or_default().push(index);
        }
        self.images.push(image);
        true
    }

    /// True if a lamp image (film region where camera rays meet a small lamp) of light `light`,
    /// seen via the specular vertices `chain`, covers film point `film` \[pixels], for rays through
    /// the point `on_lens` of the lens.
    pub fn covers(&self, film: Vec2, on_lens: Vec2, light: u32, chain: SpecularChain) -> bool {
        let pixel = film.floor().as_ivec2();
        let images = self.by_pixel.get(&(pixel.x, pixel.y)).into_iter().flatten().map(|i| &self.images[*i as usize]);
        images.into_iter().any(|image| {
            image.light == light && image.chain == chain && image.image.disc_point(film, on_lens).length_squared() < 1.0
        })
    }
}
