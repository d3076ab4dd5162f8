//! Sampling of the film: the rays that go through each pixel of a picture, and their weights.

use super::lamp_images::{LampImages, PixelLampImage, aimed_pdf, sample_aimed_film_point};
use super::prefix_rays::{LampImageRayCounts, PixelPrefixRayCounts, PrefixWeights};
use super::shutter::{PixelRaySlices, SlicedCameras};
use crate::camera::{Camera, CropWindow, Filter, FilterSample};
use crate::math::Ray;
use crate::sampling::{Dimension, Key, Sampler};
use glam::Vec2;

/// Camera, pixel filter, window and numbers of camera rays with which a picture is rendered.
pub(super) struct FilmSampling<'a> {
    pub camera: &'a Camera,
    /// Reconstruction filter; `None` sends each ray through the lower left corner of its pixel, as
    /// `raycast` does by default.
    pub filter: Option<&'a Filter>,
    /// Mean number of rays per pixel.
    pub samples_per_pixel: u32,
    /// True if rays start at random points of the lens; false if at its center.
    pub samples_lens: bool,
    /// Number of rays of each pixel, divided by the mean over all pixels. `None` if all pixels get
    /// `samples_per_pixel` rays.
    pub relative_ray_counts: Option<&'a [f32]>,
    /// Numbers and random keys of [prefix rays](super::prefix_rays), extra camera paths that end at
    /// the first surface that stores photons; `None` for no prefix rays.
    pub prefix_rays: Option<PrefixRays<'a>>,
    /// True if each photon estimate is repeated in smaller gather discs with the same center. The
    /// differences between these estimates show the bias.
    pub repeats_in_nested_discs: bool,
    /// True if the light of each pixel is also stored in three parts: direct, indirect and caustic
    /// light.
    pub groups_light: bool,
    /// Window of pixels to render.
    pub window: CropWindow,
    /// Upper bound on the light that one camera path finds, except its photon estimates \[W/(m²
    /// sr)]. Light with a larger RGB channel is scaled down; `None` for no bound.
    pub clamp: Option<f32>,
    /// Cameras of the slices of the shutter interval. Each slice has a camera and a share of the
    /// camera rays. `None` for an undivided shutter interval: all rays then start from the camera
    /// in the field `camera`.
    pub slices: Option<SlicedCameras<'a>>,
    /// Stride of the rendered tiles: one of every `tile_stride` tiles is rendered, and the others
    /// stay black. With 1, all tiles are rendered.
    pub tile_stride: u32,
}

/// Numbers of [prefix rays](super::prefix_rays) of each pixel of a picture, the lamp images at
/// which some prefix rays are aimed, and random keys.
///
/// Prefix rays are extra camera paths that end at the first surface that stores photons. A lamp
/// image is a film region where camera rays meet a small lamp.
#[derive(Clone, Copy)]
pub(super) struct PrefixRays<'a> {
    /// Numbers of prefix rays (extra camera rays that stop at the first surface that stores
    /// photons) of each pixel, by rows from the top.
    pub counts: &'a [PixelPrefixRayCounts],
    /// Random key of the prefix rays that are not aimed at lamp images (film regions where camera
    /// rays meet a small lamp). The pixel filter distributes their film points.
    pub key: Key,
    /// Lamp images at which some prefix rays are aimed, for each pixel. A lamp image is a film
    /// region where camera rays meet a small lamp.
    pub lamp_images: &'a LampImages,
    /// Random key of the prefix rays that are aimed at lamp images, the film regions where camera
    /// rays meet a small lamp.
    pub aimed_key: Key,
}

/// Set of rays of one pixel: camera rays, or prefix rays (extra camera rays that stop at the first
/// surface that stores photons). Holds their number, shutter times, random key and weights.
pub(super) struct PixelRays<'a> {
    /// Random key of the rays in the set.
    pub key: Key,
    /// Number of rays in the set.
    pub count: u32,
    /// Division of the rays in the set among the slices of the shutter interval.
    pub slices: PixelRaySlices,
    /// Weights of the light that the rays in the set find up to their first receiver (surface or
    /// medium that stores photons).
    ///
    /// If some prefix rays of the pixel are aimed at lamp images (film regions where camera rays
    /// meet a small lamp), the MIS weight of each ray replaces the weight `up_to_receiver`.
    prefix_weights: PrefixWeights,
    /// Lamp images (film regions where camera rays meet a small lamp) at which some prefix rays of
    /// the pixel are aimed, and the pixel's numbers of rays with and without aim. They determine
    /// the MIS weight of each ray. `None` if no prefix ray of the pixel is aimed.
    lamp_images: Option<(&'a [PixelLampImage], LampImageRayCounts)>,
    /// True if the film points of the rays in the set are aimed at lamp images (film regions where
    /// camera rays meet a small lamp); false if the pixel filter distributes the film points.
    is_aimed: bool,
}

/// A camera ray of a pixel, or a prefix ray, with its weights. Prefix rays are extra camera paths
/// that end at the first surface that stores photons.
pub(super) struct PixelRay {
    pub ray: Ray,
    /// Weight of the ray by the pixel filter. It multiplies all light of the ray, in addition to
    /// `prefix_weights`.
    pub filter_weight: f32,
    /// Weights of the light that the ray finds up to its first receiver (surface or medium that
    /// stores photons).
    pub prefix_weights: PrefixWeights,
}

impl<'a> FilmSampling<'a> {
    /// Returns the sampling of the whole picture of `camera` with `samples` rays per pixel. All
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

    /// Returns the numbers of [prefix rays](super::prefix_rays) of a pixel: extra camera rays that
    /// stop at the first surface that stores photons. `pixel` is an index by rows from the top.
    fn pixel_prefix_ray_counts(&self, pixel: usize) -> PixelPrefixRayCounts {
        self.prefix_rays.map_or(PixelPrefixRayCounts::default(), |rays| rays.counts[pixel])
    }

    /// Returns the rays of the pixel in column `x`, row `y` of the whole picture, in three sets.
    /// The first holds its camera rays. The second holds *prefix rays*, extra camera rays that stop
    /// at the first surface that stores photons. The third holds prefix rays that are aimed at lamp
    /// images, film regions where camera rays meet a small lamp.
    ///
    /// `None` stands for an empty set. `key` is the random key of the picture's camera rays.
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
            has_aimed_rays.map(|rays| (rays.lamp_images.of_pixel(index), LampImageRayCounts::new(samples, prefix)));
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

    /// Makes one ray of a pixel, with its weights. `rays` is the set of the pixel's camera rays or
    /// prefix rays from which the ray comes. `sampler` chooses the film point and lens point of the
    /// ray.
    ///
    /// `corner` is the upper left corner of the pixel \[pixels from the top left]. `slice` is the
    /// index of the slice of the shutter interval in which the ray is traced.
    #[inline]
    pub fn generate_pixel_ray(&self, rays: &PixelRays<'_>, slice: usize, corner: Vec2, sampler: Sampler) -> PixelRay {
        if let Some((images, weights)) = &rays.lamp_images {
            return self.generate_ray_near_lamp_images(rays, images, weights, slice, corner, sampler);
        }
        let (ray, filter_weight) = self.generate_ray(slice, corner, sampler);
        PixelRay { ray, filter_weight, prefix_weights: rays.prefix_weights }
    }

    /// Makes one ray of the set `rays` of a pixel in which some prefix rays are aimed at the lamp
    /// images `images`: film regions where camera rays meet a small lamp. The ray gets an MIS
    /// weight, because both aimed rays and rays that the pixel filter distributes find the same
    /// light.
    ///
    /// `weights` holds the numbers of both kinds of rays. The other arguments are those of
    /// [`FilmSampling::generate_pixel_ray`]. The function is not inlined, so that the loop over
    /// rays stays small.
    #[inline(never)]
    fn generate_ray_near_lamp_images(
        &self,
        rays: &PixelRays<'_>,
        images: &[PixelLampImage],
        weights: &LampImageRayCounts,
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

    /// Samples the lens point of a ray with `sampler` \[length right and up from the lens center];
    /// 0 if all rays start at the lens center.
    fn lens_point(&self, sampler: Sampler) -> Vec2 {
        if self.samples_lens { self.camera.sample_lens(sampler.get_2d(Dimension::Lens)).as_vec2() } else { Vec2::ZERO }
    }

    /// Returns the MIS weight of the light that a camera ray finds up to its first receiver
    /// (surface or medium that stores photons). `sampler` generates the ray through the pixel whose
    /// upper left corner is `corner`.
    ///
    /// Some prefix rays of the pixel are aimed at the lamp images `images`: film regions where
    /// camera rays meet a small lamp. `weights` holds the pixel's numbers of rays with and without
    /// aim.
    pub fn up_to_receiver_weight(
        &self,
        images: &[PixelLampImage],
        weights: &LampImageRayCounts,
        corner: Vec2,
        sampler: Sampler,
    ) -> f32 {
        let (film, _) = self.sample_film_position(corner, sampler);
        self.weight_near_lamp_images(images, weights, corner, film, self.lens_point(sampler))
    }

    /// Returns the MIS weight of the light that a ray through film point `film` and lens point
    /// `on_lens` finds up to its first receiver (surface or medium that stores photons). `corner`
    /// is the upper left corner of its pixel.
    ///
    /// Some prefix rays of the pixel are aimed at the lamp images `images`: film regions where
    /// camera rays meet a small lamp. `weights` holds the pixel's numbers of rays with and without
    /// aim.
    fn weight_near_lamp_images(
        &self,
        images: &[PixelLampImage],
        weights: &LampImageRayCounts,
        corner: Vec2,
        film: Vec2,
        on_lens: Vec2,
    ) -> f32 {
        let filter_pdf = self.filter.map_or(0.0, |filter| filter.sample_pdf(film - (corner + 0.5)));
        weights.up_to_receiver_weight(filter_pdf, aimed_pdf(images, film, on_lens))
    }

    /// Generates a camera ray with `sampler`, through the pixel whose upper left corner is
    /// `corner`, in slice `slice` of the shutter interval. Returns the ray and its filter weight.
    #[inline]
    pub fn generate_ray(&self, slice: usize, corner: Vec2, sampler: Sampler) -> (Ray, f32) {
        let (film, weight) = self.sample_film_position(corner, sampler);
        let lens = self.samples_lens.then(|| sampler.get_2d(Dimension::Lens));
        let camera = self.slices.as_ref().map_or(self.camera, |slices| slices.cameras[slice]);
        (camera.generate_ray(film, lens), weight)
    }

    /// Returns how the `rays` rays of the pixel in column `x`, row `y` are divided among the slices
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
        // `FilteredSum::weighted_sum`, which averages pixels if the filter has negative values, is
        // unbiased only for independent samples.
        let film = if filter.has_negative_values() {
            sampler.sample_key().uniform_2d(Dimension::Film)
        } else {
            sampler.get_2d(Dimension::Film)
        };
        let FilterSample { offset, weight } = filter.sample(film);
        (corner + 0.5 + offset, weight)
    }
}
