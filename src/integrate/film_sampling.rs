//! Sampling of the film: which rays go through each pixel of a picture, and with which weights.

use super::lamp_images::{LampImages, PixelLampImage, aimed_pdf, sample_aimed_film_point};
use super::prefix_rays::{FilmPointRayCounts, PixelPrefixRayCounts, PrefixWeights};
use super::shutter::{PixelRaySlices, SlicedCameras};
use crate::camera::{Camera, CropWindow, Filter, FilterSample};
use crate::math::Ray;
use crate::sampling::{Dimension, Key, Sampler};
use glam::Vec2;

/// Camera, pixel filter and numbers of camera rays of a picture.
pub(super) struct FilmSampling<'a> {
    pub camera: &'a Camera,
    /// Reconstruction filter; `None` sends one ray through the lower left corner of each pixel.
    pub filter: Option<&'a Filter>,
    /// Mean number of rays per pixel.
    pub samples_per_pixel: u32,
    /// True if rays start at random points of the lens; false if at its center.
    pub samples_lens: bool,
    /// Number of rays of each pixel, divided by the mean over all pixels; `None` gives all pixels
    /// the mean.
    pub relative_ray_counts: Option<&'a [f32]>,
    /// Numbers of [prefix rays](super::prefix_rays); `None` traces none.
    pub prefix_rays: Option<PrefixRays<'a>>,
    /// True if each photon estimate is repeated with smaller nested discs, to measure its bias.
    pub repeats_in_nested_discs: bool,
    /// True if the light of each pixel is also stored in three parts: direct, indirect and caustic
    /// light.
    pub groups_light: bool,
    /// Window of pixels to render.
    pub window: CropWindow,
    /// Upper bound \[W/(m² sr)] on the largest channel of the light of one camera path, without its
    /// photon estimates; `None` for no bound.
    pub clamp: Option<f32>,
    /// Slices of the shutter interval among which camera rays are divided; `None` sends all rays
    /// through `camera`.
    pub slices: Option<SlicedCameras<'a>>,
    /// Stride of the rendered tiles. With 1, all tiles are rendered; with n, one of every n tiles,
    /// and the others stay black.
    pub tile_stride: u32,
}

/// Numbers of [prefix rays](super::prefix_rays) of each pixel of a picture, the images of lamps at
/// which some are aimed, and the keys of their random numbers.
#[derive(Clone, Copy)]
pub(super) struct PrefixRays<'a> {
    /// Numbers of prefix rays of each pixel, by rows from the top.
    pub counts: &'a [PixelPrefixRayCounts],
    /// Random key of the rays that the pixel filter distributes.
    pub key: Key,
    /// Images of lamps in each pixel, at which some prefix rays are aimed.
    pub lamp_images: &'a LampImages,
    /// Random key of the rays that are aimed.
    pub aimed_key: Key,
}

/// Camera rays or prefix rays of one pixel: their number, shutter times, random key and weights.
pub(super) struct PixelRays<'a> {
    /// Random key of the rays.
    pub key: Key,
    /// Number of rays.
    pub count: u32,
    /// Division of the rays among the slices of the shutter interval.
    pub slices: PixelRaySlices,
    /// Weights of the light that the rays find up to their first receiver.
    ///
    /// If rays of the pixel are aimed at images of lamps, each ray has a weight `up_to_receiver` of
    /// its own.
    prefix_weights: PrefixWeights,
    /// Images of lamps at which prefix rays of the pixel are aimed, and the numbers of rays that
    /// share their light; `None` if no ray of the pixel is aimed.
    lamp_images: Option<(&'a [PixelLampImage], FilmPointRayCounts)>,
    /// True if these rays are aimed; false if the pixel filter distributes them.
    is_aimed: bool,
}

/// A camera ray or prefix ray of a pixel, with its weights.
pub(super) struct PixelRay {
    pub ray: Ray,
    /// Weight of the ray by the pixel filter.
    pub filter_weight: f32,
    /// Weights of the light that the ray finds up to its first receiver.
    pub prefix_weights: PrefixWeights,
}

impl<'a> FilmSampling<'a> {
    /// Returns the sampling of the whole picture of `camera` with `samples` rays per pixel; all
    /// other options are off.
    ///
    /// `filter` and `lens` set the fields `filter` and `samples_lens`.
    pub fn of_camera(camera: &'a Camera, filter: Option<&'a Filter>, samples: u32, lens: bool) -> Self {
        Self {
            camera,
            filter,
            samples_per_pixel: samples,
            samples_lens: lens,
            relative_ray_counts: None,
            prefix_rays: None,
            repeats_in_nested_discs: false,
            groups_light: false,
            window: CropWindow::of_whole_picture(camera.size()),
            clamp: None,
            slices: None,
            tile_stride: 1,
        }
    }
}

impl FilmSampling<'_> {
    /// Returns the number of camera rays of a pixel, at least one. `pixel` is an index by rows from
    /// the top.
    fn pixel_camera_ray_count(&self, pixel: usize) -> u32 {
        let exact = |counts: &[f32]| (self.samples_per_pixel as f32 * counts[pixel]).round().max(1.0) as u32;
        self.relative_ray_counts.map_or(self.samples_per_pixel, exact)
    }

    /// Returns the numbers of [prefix rays](super::prefix_rays) of a pixel. `pixel` is an index by
    /// rows from the top.
    fn pixel_prefix_ray_counts(&self, pixel: usize) -> PixelPrefixRayCounts {
        self.prefix_rays.map_or(PixelPrefixRayCounts::default(), |rays| rays.counts[pixel])
    }

    /// Returns the camera rays of the pixel in column `x`, row `y` of the whole picture, its
    /// unaimed prefix rays, and its prefix rays that are aimed at images of lamps. `None` stands
    /// for no such rays. `key` is the random key of the picture's camera rays.
    pub fn camera_and_prefix_rays(
        &self,
        key: Key,
        x: u32,
        y: u32,
    ) -> (PixelRays<'_>, Option<PixelRays<'_>>, Option<PixelRays<'_>>) {
        let index = y as usize * self.camera.size().0 as usize + x as usize;
        let (samples, prefix) = (self.pixel_camera_ray_count(index), self.pixel_prefix_ray_counts(index));
        let slices = self.divide_rays(x, y, samples);
        let used_slices = slices.used_slice_count();
        let has_aimed_rays = self.prefix_rays.filter(|_| prefix.aimed > 0);
        let lamp_images =
            has_aimed_rays.map(|rays| (rays.lamp_images.of_pixel(index), FilmPointRayCounts::new(samples, prefix)));
        let rays = |key: Key, count: u32, slices: PixelRaySlices, prefix_weights: PrefixWeights| PixelRays {
            key: key.pixel_key(x, y),
            count,
            slices,
            prefix_weights,
            lamp_images,
            is_aimed: false,
        };
        let camera_rays = rays(key, samples, slices, PrefixWeights::of_camera_paths(samples, used_slices, prefix));
        let prefix_rays = self.prefix_rays.filter(|_| prefix.unaimed > 0).map(|PrefixRays { key, .. }| {
            let count = prefix.unaimed.into();
            let weights = PrefixWeights::of_prefix_rays(samples, used_slices, prefix);
            rays(key, count, self.divide_rays(x, y, count), weights)
        });
        let aimed_rays = has_aimed_rays.map(|PrefixRays { aimed_key, .. }| {
            let count = prefix.aimed.into();
            let slices = self.divide_rays(x, y, count);
            PixelRays { is_aimed: true, ..rays(aimed_key, count, slices, PrefixWeights::of_aimed_rays()) }
        });
        (camera_rays, prefix_rays, aimed_rays)
    }

    /// Makes the ray of `sampler` in slice `slice` of the shutter interval, one of the `rays` of
    /// the pixel whose upper left corner is `corner`.
    #[inline]
    pub fn generate_pixel_ray(&self, rays: &PixelRays<'_>, slice: usize, corner: Vec2, sampler: Sampler) -> PixelRay {
        if let Some((images, weights)) = &rays.lamp_images {
            return self.generate_ray_near_lamp_images(rays, images, weights, slice, corner, sampler);
        }
        let (ray, filter_weight) = self.generate_ray(slice, corner, sampler);
        PixelRay { ray, filter_weight, prefix_weights: rays.prefix_weights }
    }

    /// Makes the ray of `sampler` in slice `slice` of the shutter interval, one of the `rays` of
    /// the pixel whose upper left corner is `corner`. Some rays of this pixel are aimed at
    /// `images`.
    ///
    /// The function is not inlined, so that the loop over rays stays small.
    #[inline(never)]
    fn generate_ray_near_lamp_images(
        &self,
        rays: &PixelRays<'_>,
        images: &[PixelLampImage],
        weights: &FilmPointRayCounts,
        slice: usize,
        corner: Vec2,
        sampler: Sampler,
    ) -> PixelRay {
        let on_lens = self.lens_point(sampler);
        let film = if rays.is_aimed {
            sample_aimed_film_point(images, sampler, on_lens)
        } else {
            self.sample_film_position(corner, sampler).0
        };
        let camera = self.slices.as_ref().map_or(self.camera, |slices| slices.cameras[slice]);
        let lens = self.samples_lens.then(|| sampler.get_2d(Dimension::Lens));
        let up_to_receiver = self.weight_near_lamp_images(images, weights, corner, film, on_lens);
        PixelRay {
            ray: camera.generate_ray(film, lens),
            filter_weight: self.filter.map_or(1.0, |filter| filter.sample_weight(film - (corner + 0.5))),
            prefix_weights: PrefixWeights { up_to_receiver, ..rays.prefix_weights },
        }
    }

    /// Returns the point of the lens through which the ray of `sampler` goes \[length right and up
    /// from its center].
    fn lens_point(&self, sampler: Sampler) -> Vec2 {
        if self.samples_lens { self.camera.sample_lens(sampler.get_2d(Dimension::Lens)).as_vec2() } else { Vec2::ZERO }
    }

    /// Returns the weight of light that the ray of `sampler` finds up to its first receiver. The
    /// ray goes through the pixel whose upper left corner is `corner`, and other rays of the pixel
    /// are aimed at `images`.
    pub fn up_to_receiver_weight(
        &self,
        images: &[PixelLampImage],
        weights: &FilmPointRayCounts,
        corner: Vec2,
        sampler: Sampler,
    ) -> f32 {
        let (film, _) = self.sample_film_position(corner, sampler);
        self.weight_near_lamp_images(images, weights, corner, film, self.lens_point(sampler))
    }

    /// Returns the weight of light that a ray through film point `film` and lens point `on_lens`
    /// finds up to its first receiver, in the pixel whose upper left corner is `corner`.
    fn weight_near_lamp_images(
        &self,
        images: &[PixelLampImage],
        weights: &FilmPointRayCounts,
        corner: Vec2,
        film: Vec2,
        on_lens: Vec2,
    ) -> f32 {
        let filter_pdf = self.filter.map_or(0.0, |filter| filter.sample_pdf(film - (corner + 0.5)));
        weights.up_to_receiver_weight(filter_pdf, aimed_pdf(images, film, on_lens))
    }

    /// Makes the camera ray of `sampler` in slice `slice` of the shutter interval, through the
    /// pixel whose upper left corner is `corner`.
    ///
    /// Returns the ray and its filter weight.
    #[inline]
    pub fn generate_ray(&self, slice: usize, corner: Vec2, sampler: Sampler) -> (Ray, f32) {
        let (film, weight) = self.sample_film_position(corner, sampler);
        let lens = self.samples_lens.then(|| sampler.get_2d(Dimension::Lens));
        let camera = self.slices.as_ref().map_or(self.camera, |slices| slices.cameras[slice]);
        (camera.generate_ray(film, lens), weight)
    }

    /// Returns the division of the `rays` rays of the pixel in column `x`, row `y` among the slices
    /// of the shutter interval.
    fn divide_rays(&self, x: u32, y: u32, rays: u32) -> PixelRaySlices {
        self.slices.as_ref().map_or(PixelRaySlices::WHOLE, |slices| slices.divide_rays(x, y, rays))
    }

    /// Samples a film position around the pixel whose upper left corner is `corner`, by the pixel
    /// filter.
    ///
    /// Returns the film position \[pixels from the top left] and the weight of the sample. Without
    /// a filter, these are the lower left corner of the pixel and 1.
    #[inline]
    fn sample_film_position(&self, corner: Vec2, sampler: Sampler) -> (Vec2, f32) {
        let Some(filter) = self.filter else { return (corner + Vec2::Y, 1.0) };
        // [`FilteredSum::weighted_sum`] is unbiased only for independent samples. It is used for
        // filters with negative values.
        let film = if filter.has_negative_values() {
            sampler.sample_key().uniform_2d(Dimension::Film)
        } else {
            sampler.get_2d(Dimension::Film)
        };
        let FilterSample { offset, weight } = filter.sample(film);
        (corner + 0.5 + offset, weight)
    }
}
