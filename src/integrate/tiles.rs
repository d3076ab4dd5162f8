//! Rendering of all pixels of a pass, in parallel by tiles.

use super::camera_ray::CameraRay;
use super::lamp_images::{LampImages, PixelLampImage, aimed_pdf, sample_aimed_film_point};
use super::light_group::LightGroup;
use super::nested_differences::NestedDifferences;
use super::pass::{PassStage, ProgressMonitor};
use super::path_task::PathTask;
use super::prefix_rays::{AimedRayWeights, PrefixRayCount, PrefixWeights};
use super::shutter::{PixelRaySlices, SlicedCameras};
use crate::camera::{Camera, CropWindow, Filter, FilterSample};
use crate::color::Rgb;
use crate::math::{CompensatedSum, Ray, gcd};
use crate::sampling::{Dimension, Key, Sampler};
use crate::stats::Counters;
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use std::iter;

/// Edge length of a tile \[pixels]. Pixels of a tile share cached photons and bounding boxes.
const TILE_SIZE: u32 = 16;

/// Camera, pixel filter and numbers of camera rays of a picture.
pub(super) struct FilmSampling<'a> {
    pub camera: &'a Camera,
    /// Reconstruction filter; `None` sends one ray through the lower left corner of each pixel.
    pub filter: Option<&'a Filter>,
    /// Mean number of rays per pixel.
    pub samples: u32,
    /// True if rays start at random points of the lens; false if at its center.
    pub lens: bool,
    /// Number of rays of each pixel, divided by the mean over all pixels; `None` gives all pixels
    /// the mean.
    pub relative_ray_counts: Option<&'a [f32]>,
    /// Numbers of [prefix rays](super::prefix_rays); `None` traces none.
    pub prefix_rays: Option<PrefixRays<'a>>,
    /// True if each photon estimate is repeated with smaller nested discs, to measure its bias.
    pub nested: bool,
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

/// Number of [prefix rays](super::prefix_rays) of each pixel of a picture, and the key of their
/// random numbers.
#[derive(Clone, Copy)]
pub(super) struct PrefixRays<'a> {
    /// Number of prefix rays of each pixel, and how many of them read photon maps, by rows from the
    /// top.
    pub counts: &'a [PrefixRayCount],
    pub key: Key,
    /// Images of lamps in each pixel, at which some prefix rays are aimed.
    pub lamp_images: &'a LampImages,
    /// Random key of the rays that are aimed.
    pub aimed_key: Key,
}

/// Camera rays or prefix rays of one pixel: their number, shutter times, random key and weights.
struct PixelRays<'a> {
    /// Random key of the rays.
    key: Key,
    /// Number of rays.
    count: u32,
    /// Division of the rays among the slices of the shutter interval.
    slices: PixelRaySlices,
    /// Weights of the light that the rays find up to their first receiver.
    ///
    /// If rays of the pixel are aimed at images of lamps, each ray has a weight `up_to_receiver` of
    /// its own.
    prefix_weights: PrefixWeights,
    /// Images of lamps at which prefix rays of the pixel are aimed, and the numbers of rays that
    /// share their light; `None` if no ray of the pixel is aimed.
    lamp_images: Option<(&'a [PixelLampImage], AimedRayWeights)>,
    /// True if these rays are aimed; false if the pixel filter distributes them.
    is_aimed: bool,
}

/// A camera ray or prefix ray of a pixel, with its weights.
struct PixelRay {
    ray: Ray,
    /// Weight of the ray by the pixel filter.
    filter_weight: f32,
    /// Weights of the light that the ray finds up to its first receiver.
    prefix_weights: PrefixWeights,
}

/// Rendered window of a picture with the counters of its camera rays.
pub(super) struct FilmImage {
    /// Radiance of each pixel of the window, by rows from the top \[W/(m² sr)].
    pub image: Vec<Rgb>,
    /// Nested photon estimates of each pixel; empty unless [`FilmSampling::nested`] is true.
    pub nested: Vec<NestedDifferences>,
    /// Radiance of each pixel by light group, which adds up to `image`, in the order of
    /// [`LightGroup::ALL`] \[W/(m² sr)]; empty unless [`FilmSampling::groups_light`] is true.
    pub groups: Vec<Vec<Rgb>>,
    /// Radiance that clamping removed from each pixel \[W/(m² sr)]; empty unless light is clamped.
    pub clamped: Vec<Rgb>,
    /// Indices in `image` of the rendered pixels, if only one of several tiles is rendered; else
    /// empty.
    pub pixels: Vec<u32>,
    pub counters: Counters,
}

impl FilmImage {
    /// Crops this picture, which shows the window `outer`, to the window `inner`.
    fn cropped_to_window(self, outer: CropWindow, inner: CropWindow) -> Self {
        let Self { image, nested, groups, clamped, pixels, counters } = self;
        let pixels = pixels.into_iter().filter_map(|i| {
            let (x, y) = (outer.left + i % outer.size().0, outer.top + i / outer.size().0);
            let is_inside = (inner.left..inner.right).contains(&x) && (inner.top..inner.bottom).contains(&y);
            is_inside.then(|| (y - inner.top) * inner.size().0 + x - inner.left)
        });
        Self {
            image: cropped_pixels(&image, outer, inner),
            nested: cropped_pixels(&nested, outer, inner),
            groups: groups.iter().map(|group| cropped_pixels(group, outer, inner)).collect(),
            clamped: cropped_pixels(&clamped, outer, inner),
            pixels: pixels.collect(),
            counters,
        }
    }
}

/// Returns the part of `pixels` in the window `inner`; `pixels` show the window `outer` or are
/// empty.
fn cropped_pixels<T: Copy>(pixels: &[T], outer: CropWindow, inner: CropWindow) -> Vec<T> {
    let columns = (inner.left - outer.left) as usize..(inner.right - outer.left) as usize;
    let rows = pixels.chunks(outer.size().0 as usize).skip((inner.top - outer.top) as usize);
    rows.take(inner.size().1 as usize).flat_map(|row| &row[columns.clone()]).copied().collect()
}

/// One tile of a picture: mutable slices of the rows of the picture.
struct Tile<'a> {
    /// Index of the tile, by rows from the top.
    index: u32,
    /// Parts of the picture's rows that lie in the tile, from the top.
    image: Vec<&'a mut [Rgb]>,
    /// Rows of nested estimates in the tile; empty unless [`FilmSampling::nested`] is true.
    nested: Vec<&'a mut [NestedDifferences]>,
    /// Rows of each light group in the tile; empty unless [`FilmSampling::groups_light`] is true.
    groups: Vec<Vec<&'a mut [Rgb]>>,
    /// Rows of the radiance that clamping removes, in the tile; empty unless light is clamped.
    clamped: Vec<&'a mut [Rgb]>,
}

impl<'a> Tile<'a> {
    /// Splits a picture of `width` columns into tiles, by rows from the top.
    fn split_image_into_tiles(
        image: &'a mut [Rgb],
        nested: &'a mut [NestedDifferences],
        groups: &'a mut [Vec<Rgb>],
        clamped: &'a mut [Rgb],
        width: u32,
    ) -> Vec<Self> {
        let height = image.len() as u32 / width;
        let group_count = groups.len();
        let empty = |index| Tile {
            index,
            image: Vec::new(),
            nested: Vec::new(),
            groups: (0..group_count).map(|_| Vec::new()).collect(),
            clamped: Vec::new(),
        };
        let mut tiles: Vec<Self> = (0..width.div_ceil(TILE_SIZE) * height.div_ceil(TILE_SIZE)).map(empty).collect();
        row_pieces_by_tile(image, width).for_each(|(tile, row)| tiles[tile].image.push(row));
        row_pieces_by_tile(nested, width).for_each(|(tile, row)| tiles[tile].nested.push(row));
        row_pieces_by_tile(clamped, width).for_each(|(tile, row)| tiles[tile].clamped.push(row));
        for (group, pixels) in groups.iter_mut().enumerate() {
            row_pieces_by_tile(pixels, width).for_each(|(tile, row)| tiles[tile].groups[group].push(row));
        }
        tiles
    }

    /// Stores `pixel` in column `column`, row `row` of the tile.
    fn store_pixel(&mut self, column: usize, row: usize, pixel: RenderedPixel) {
        let RenderedPixel { radiance, nested, groups, clamped } = pixel;
        self.image[row][column] = radiance;
        if let Some(pixels) = self.nested.get_mut(row) {
            pixels[column] = nested;
        }
        if let Some(pixels) = self.clamped.get_mut(row) {
            pixels[column] = clamped;
        }
        self.groups.iter_mut().zip(groups).for_each(|(rows, light)| rows[row][column] = light);
    }
}

/// Cuts the rows of a picture at tile borders. Returns the pieces from the top, each with the index
/// of its tile.
fn row_pieces_by_tile<T>(picture: &mut [T], width: u32) -> impl Iterator<Item = (usize, &mut [T])> {
    let (width, edge) = (width as usize, TILE_SIZE as usize);
    let tile = move |x: usize, y: usize| y / edge * width.div_ceil(edge) + x;
    let rows = picture.chunks_mut(width).enumerate();
    rows.flat_map(move |(y, row)| row.chunks_mut(edge).enumerate().map(move |(x, piece)| (tile(x, y), piece)))
}

impl<'a> FilmSampling<'a> {
    /// Returns the sampling of the whole picture of `camera` with `samples` rays per pixel; all
    /// other options are off.
    ///
    /// `filter` and `lens` set the fields of these names.
    pub fn of_camera(camera: &'a Camera, filter: Option<&'a Filter>, samples: u32, lens: bool) -> Self {
        Self {
            camera,
            filter,
            samples,
            lens,
            relative_ray_counts: None,
            prefix_rays: None,
            nested: false,
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
    fn ray_count(&self, pixel: usize) -> u32 {
        let exact = |counts: &[f32]| (self.samples as f32 * counts[pixel]).round().max(1.0) as u32;
        self.relative_ray_counts.map_or(self.samples, exact)
    }

    /// Returns the number of [prefix rays](super::prefix_rays) of a pixel. `pixel` is an index by
    /// rows from the top.
    fn prefix_ray_count(&self, pixel: usize) -> PrefixRayCount {
        self.prefix_rays.map_or(PrefixRayCount::default(), |rays| rays.counts[pixel])
    }

    /// Returns the camera rays of the pixel in column `x`, row `y` of the whole picture, its prefix
    /// rays, and its aimed prefix rays, if it has any. `key` is the random key of the picture's
    /// camera rays.
    fn camera_and_prefix_rays(
        &self,
        key: Key,
        x: u32,
        y: u32,
    ) -> (PixelRays<'_>, Option<PixelRays<'_>>, Option<PixelRays<'_>>) {
        let index = y as usize * self.camera.size().0 as usize + x as usize;
        let (samples, prefix) = (self.ray_count(index), self.prefix_ray_count(index));
        let slices = self.divide_rays(x, y, samples);
        let used_slices = slices.used_slice_count();
        let has_aimed_rays = self.prefix_rays.filter(|_| prefix.aimed > 0);
        let lamp_images =
            has_aimed_rays.map(|rays| (rays.lamp_images.of_pixel(index), AimedRayWeights::new(samples, prefix)));
        let camera_rays = PixelRays {
            key: key.pixel_key(x, y),
            count: samples,
            slices,
            prefix_weights: PrefixWeights::of_camera_paths(samples, used_slices, prefix),
            lamp_images,
            is_aimed: false,
        };
        let prefix_rays = self.prefix_rays.filter(|_| prefix.rays > 0).map(|PrefixRays { key, .. }| PixelRays {
            key: key.pixel_key(x, y),
            count: prefix.rays.into(),
            slices: self.divide_rays(x, y, prefix.rays.into()),
            prefix_weights: PrefixWeights::of_prefix_rays(samples, used_slices, prefix),
            lamp_images,
            is_aimed: false,
        });
        let aimed_rays = self.prefix_rays.filter(|_| prefix.aimed > 0).map(|PrefixRays { aimed_key, .. }| PixelRays {
            key: aimed_key.pixel_key(x, y),
            count: prefix.aimed.into(),
            slices: self.divide_rays(x, y, prefix.aimed.into()),
            prefix_weights: PrefixWeights::of_aimed_rays(),
            lamp_images,
            is_aimed: true,
        });
        (camera_rays, prefix_rays, aimed_rays)
    }

    /// Makes the ray of `sampler` in slice `slice` of the shutter interval, one of the `rays` of
    /// the pixel whose upper left corner is `corner`.
    #[inline]
    fn generate_pixel_ray(&self, rays: &PixelRays<'_>, slice: usize, corner: Vec2, sampler: Sampler) -> PixelRay {
        if rays.lamp_images.is_some() {
            return self.generate_ray_near_lamp_images(rays, slice, corner, sampler);
        }
        let (ray, filter_weight) = self.generate_ray(slice, corner, sampler);
        PixelRay { ray, filter_weight, prefix_weights: rays.prefix_weights }
    }

    /// Makes a ray as [`FilmSampling::generate_pixel_ray`] does, in a pixel of which prefix rays
    /// are aimed at images of lamps.
    ///
    /// The function is not inlined, so that the loop over rays stays small.
    #[inline(never)]
    fn generate_ray_near_lamp_images(
        &self,
        rays: &PixelRays<'_>,
        slice: usize,
        corner: Vec2,
        sampler: Sampler,
    ) -> PixelRay {
        let (images, weights) = rays.lamp_images.as_ref().expect("rays of the pixel are aimed at images");
        let on_lens = self.lens_point(sampler);
        let film = if rays.is_aimed {
            sample_aimed_film_point(images, sampler, on_lens)
        } else {
            self.sample_film_position(corner, sampler).0
        };
        let camera = self.slices.as_ref().map_or(self.camera, |slices| slices.cameras[slice]);
        let lens = self.lens.then(|| sampler.get_2d(Dimension::Lens));
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
        if self.lens { self.camera.sample_lens(sampler.get_2d(Dimension::Lens)).as_vec2() } else { Vec2::ZERO }
    }

    /// Returns the weight of light that the ray of `sampler` finds up to its first receiver. The
    /// ray goes through the pixel whose upper left corner is `corner`, and other rays of the pixel
    /// are aimed at `images`.
    pub fn up_to_receiver_weight(
        &self,
        images: &[PixelLampImage],
        weights: &AimedRayWeights,
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
        weights: &AimedRayWeights,
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
        let lens = self.lens.then(|| sampler.get_2d(Dimension::Lens));
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
    /// Returns the film position \[pixels from the top left] and the weight of the sample.
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

/// Renders the pixels in the window of `sampling` by tiles, in parallel.
///
/// `trace_ray` returns the radiance along a camera ray \[W/(m² sr)]. For all algorithms except
/// `raycast`, it calls [`trace_camera_path`](super::camera_path::trace_camera_path). Its arguments
/// are the ray, the task of the tile, and a stack of branches that all rays of a tile share.
pub(super) fn render_tiles<Stack: Default>(
    sampling: &FilmSampling<'_>,
    key: Key,
    monitor: &dyn ProgressMonitor,
    trace_ray: impl Fn(&CameraRay, &mut PathTask, &mut Stack) -> Rgb + Sync,
) -> FilmImage {
    // Searches for photons begin with the radius of the pixel before in the tile, which can change
    // last bits. So tiles lie as in the whole picture, and all their pixels are rendered.
    let window = sampling.window.grown_to_tiles(TILE_SIZE, sampling.camera.size());
    let (width, height) = window.size();
    let (columns, stride) = (width.div_ceil(TILE_SIZE), sampling.tile_stride);
    let pixels = width as usize * height as usize;
    monitor.begin_stage(PassStage::Camera, pixels as u64 / u64::from(stride));

    // Cut the picture into tiles.
    let mut image = vec![Rgb::ZERO; pixels];
    let mut nested = vec![NestedDifferences::default(); if sampling.nested { pixels } else { 0 }];
    let mut groups = vec![vec![Rgb::ZERO; pixels]; if sampling.groups_light { LightGroup::ALL.len() } else { 0 }];
    let mut clamped = vec![Rgb::ZERO; if sampling.clamp.is_some() { pixels } else { 0 }];
    let mut tiles = Tile::split_image_into_tiles(&mut image, &mut nested, &mut groups, &mut clamped, width);
    tiles.retain(|tile| is_tile_rendered(tile.index, columns, stride));
    let indices = |tile: &Tile<'_>| tile_pixels(tile.index, columns, width, height).map(|(x, y)| y * width + x);
    let rendered_pixels = if stride > 1 { tiles.iter().flat_map(indices).collect() } else { Vec::new() };

    let work = tiles.into_par_iter().map(|mut tile| {
        let mut task = PathTask::new(sampling.nested, sampling.groups_light);
        let mut branches = Stack::default();
        let mut rendered = 0;
        let tile_pixels = tile_pixels(tile.index, columns, width, height).take_while(|_| !monitor.is_cancelled());
        for (column, row) in tile_pixels {
            // Trace the camera rays of a pixel, and then its prefix rays.
            let (x, y) = (window.left + column, window.top + row);
            let corner = Vec2::new(x as f32, y as f32);
            let film_position = corner + 0.5;
            let (camera_rays, prefix_rays, aimed_rays) = sampling.camera_and_prefix_rays(key, x, y);
            let samples = camera_rays.count;
            let mut sums = PixelSums::default();
            for rays in iter::once(camera_rays).chain(prefix_rays).chain(aimed_rays) {
                for index in 0..rays.count {
                    let sampler = Sampler::new(rays.key, index, rays.count);
                    let shutter_slice = rays.slices.slice(index);
                    let PixelRay { ray, filter_weight, prefix_weights } =
                        sampling.generate_pixel_ray(&rays, shutter_slice, corner, sampler);
                    let camera_ray = CameraRay { ray, sampler, film_position, shutter_slice, prefix_weights };
                    task.counters.camera_rays += 1;
                    task.pixel.photon_radiance = Rgb::ZERO;
                    let radiance = trace_ray(&camera_ray, &mut task, &mut branches);
                    sums.add_ray(sampling, &camera_ray, radiance, filter_weight, &mut task);
                }
            }

            // Average the light of its rays.
            let pixel = sums.average(sampling, samples, &mut task);
            tile.store_pixel((column % TILE_SIZE) as usize, (row % TILE_SIZE) as usize, pixel);
            rendered += 1;
        }
        monitor.report_progress(rendered);
        task.counters
    });
    let counters = work.reduce(Counters::default, |mut a, b| {
        a += b;
        a
    });
    let picture = FilmImage { image, nested, groups, clamped, pixels: rendered_pixels, counters };
    if window == sampling.window { picture } else { picture.cropped_to_window(window, sampling.window) }
}

/// Light of one pixel, averaged over its rays.
struct RenderedPixel {
    /// Radiance \[W/(m² sr)].
    radiance: Rgb,
    /// Differences of nested photon estimates; 0 unless [`FilmSampling::nested`] is true.
    nested: NestedDifferences,
    /// Radiance by light group \[W/(m² sr)]; 0 unless [`FilmSampling::groups_light`] is true.
    groups: [Rgb; LightGroup::ALL.len()],
    /// Radiance that clamping removed \[W/(m² sr)].
    clamped: Rgb,
}

/// Returns the stride n ≥ 2 for which rendering one of every n tiles renders about `wanted` tiles.
pub(super) fn rendered_tile_stride((width, height): (u32, u32), wanted: u32) -> u32 {
    (width.div_ceil(TILE_SIZE) * height.div_ceil(TILE_SIZE) / wanted).max(2)
}

/// True if the tile with index `tile` is rendered, when only one of `stride` tiles is rendered.
///
/// Rendered tiles lie on diagonal lines, so they are spread over all rows and columns.
fn is_tile_rendered(tile: u32, columns: u32, stride: u32) -> bool {
    // A slant that shares a factor with the stride would leave out columns.
    let slant = (1..=stride.div_ceil(2)).rev().find(|slant| gcd(*slant, stride) == 1).unwrap_or(1);
    (tile % columns + tile / columns * slant).is_multiple_of(stride)
}

/// Returns the column and row of each pixel of a tile.
fn tile_pixels(tile: u32, columns: u32, width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let (left, top) = (tile % columns * TILE_SIZE, tile / columns * TILE_SIZE);
    (top..height.min(top + TILE_SIZE)).flat_map(move |y| (left..width.min(left + TILE_SIZE)).map(move |x| (x, y)))
}

/// Sums over the rays of one pixel, of all light that the pixel reports.
#[derive(Default)]
struct PixelSums {
    radiance: RaySums,
    groups: [RaySums; LightGroup::ALL.len()],
    /// Radiance that clamping removed.
    clamped: RaySums,
}

impl PixelSums {
    /// Adds the light of `camera_ray`: its `radiance` \[W/(m² sr)], and the light that `task` kept
    /// apart. `weight` is the weight of the pixel filter.
    #[inline]
    fn add_ray(
        &mut self,
        sampling: &FilmSampling<'_>,
        camera_ray: &CameraRay,
        mut radiance: Rgb,
        weight: f32,
        task: &mut PathTask,
    ) {
        let is_prefix_ray = camera_ray.prefix_weights.ends_at_receiver;
        if let Some(limit) = sampling.clamp {
            self.clamped.add_ray(clamp_path_light(&mut radiance, limit, task), weight, is_prefix_ray);
        }
        let groups = task.pixel.groups.take_sums();
        let is_finite = radiance.is_finite();
        if is_finite {
            self.radiance.add_ray(radiance, weight, is_prefix_ray);
            if sampling.groups_light {
                let sums = self.groups.iter_mut().zip(groups);
                sums.for_each(|(sum, light)| sum.add_ray(light, weight, is_prefix_ray));
            }
        } else {
            task.counters.rejected_samples += 1;
        }
        if sampling.nested {
            task.pixel.nested.finish_camera_ray(is_finite.then_some(weight));
        }
    }

    /// Returns the light of a pixel with `samples` camera rays, and resets the sums in `task` for
    /// the next pixel.
    fn average(self, sampling: &FilmSampling<'_>, samples: u32, task: &mut PathTask) -> RenderedPixel {
        let is_signed = sampling.filter.is_some_and(Filter::has_negative_values);
        RenderedPixel {
            radiance: self.radiance.pixel_value(is_signed, samples),
            nested: task.pixel.nested.finish_pixel(samples),
            groups: self.groups.map(|sum| sum.pixel_value(is_signed, samples)),
            clamped: self.clamped.pixel_value(is_signed, samples),
        }
    }
}

/// Sum of radiance over a pixel's camera rays, and over its prefix rays.
#[derive(Default)]
struct RaySums {
    camera_rays: FilteredSum,
    /// Sum over the prefix rays of radiance times filter weight.
    prefix_rays: CompensatedSum,
}

impl RaySums {
    /// Adds the radiance `value` of a ray with filter weight `weight`.
    #[inline]
    fn add_ray(&mut self, value: Rgb, weight: f32, is_prefix_ray: bool) {
        if is_prefix_ray {
            self.prefix_rays.add(value.as_dvec3() * f64::from(weight));
        } else {
            self.camera_rays.add(value, weight);
        }
    }

    /// Returns the radiance of a pixel with `samples` camera rays \[W/(m² sr)].
    ///
    /// `is_signed` is true if the pixel filter has negative values.
    fn pixel_value(&self, is_signed: bool, samples: u32) -> Rgb {
        let camera_rays = if is_signed { self.camera_rays.weighted_sum() } else { self.camera_rays.unweighted_sum() };
        ((camera_rays + self.prefix_rays.value()) / f64::from(samples)).as_vec3()
    }
}

/// Sums of radiance and filter weights over a pixel's camera rays.
#[derive(Default)]
struct FilteredSum {
    /// Sum of radiance values.
    values: CompensatedSum,
    /// Sum of radiance values, each times its filter weight.
    weighted: CompensatedSum,
    /// Sum of (filter weight − 1) over the samples.
    excess: f64,
    count: u32,
}

impl FilteredSum {
    #[inline]
    fn add(&mut self, value: Rgb, weight: f32) {
        let value = value.as_dvec3();
        self.values.add(value);
        self.weighted.add(value * f64::from(weight));
        self.excess += f64::from(weight - 1.0);
        self.count += 1;
    }

    /// Returns the sum of the radiance values.
    fn unweighted_sum(&self) -> DVec3 {
        self.values.value()
    }

    /// Returns an unbiased estimate of the sum of radiance values times filter weights.
    ///
    /// Each sample adds wᵢLᵢ + (1 − wᵢ)·(mean of the other values), which has less noise than wᵢLᵢ
    /// alone. The sum is unbiased, because weights have mean 1. It is exact if all values are
    /// equal.
    fn weighted_sum(&self) -> DVec3 {
        let (values, weighted) = (self.values.value(), self.weighted.value());
        let others = f64::from(self.count) - 1.0;
        if others < 1.0 {
            return weighted;
        }
        // Add Σ (1 − wᵢ)(S − Lᵢ)/(n − 1) for n values Lᵢ with weights wᵢ, where S is the sum of all
        // values.
        let lacks = (weighted - values) - values * self.excess;
        weighted + lacks / others
    }
}

/// Scales the part of `value` that does not come from photon estimates, so that none of its
/// channels exceeds `limit` \[W/(m² sr)]. Returns the radiance that this removes from `value`.
///
/// Each channel of the ray's light groups in `task` shrinks by the same factor as that channel of
/// `value`. A `value` that is not finite stays as it is, because the caller rejects it.
fn clamp_path_light(value: &mut Rgb, limit: f32, task: &mut PathTask) -> Rgb {
    let found = *value - task.pixel.photon_radiance;
    let largest = found.max_element();
    if !(value.is_finite() && largest > limit) {
        return Rgb::ZERO;
    }
    let clamped = task.pixel.photon_radiance + found * (limit / largest);
    let removed = *value - clamped;
    task.pixel.groups.scale(Rgb::select(value.cmpgt(Rgb::ZERO), clamped / *value, Rgb::ONE));
    *value = clamped;
    removed
}

#[cfg(test)]
mod tests;
