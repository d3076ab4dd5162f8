//! Rendering of all pixels of a pass, in parallel by tiles.

use super::camera_ray::CameraRay;
use super::film_sampling::{FilmSampling, PixelRay};
use super::light_group::LightGroup;
use super::nested_differences::NestedDifferences;
use super::pass::{PassStage, ProgressMonitor};
use super::path_task::PathTask;
use crate::camera::{CropWindow, Filter};
use crate::color::Rgb;
use crate::math::{CompensatedSum, gcd};
use crate::sampling::{Key, Sampler};
use crate::stats::Counters;
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use std::iter;

/// Edge length of a tile \[pixels]. Neighbouring pixels need the same photons and BVH nodes, which
/// then stay in the CPU cache.
const TILE_SIZE: u32 = 16;

/// Rendered window of a picture: radiance and other data of each pixel, and the counters of the
/// camera rays.
pub(super) struct FilmImage {
    /// Radiance of each pixel of the window, by rows from the top \[W/(m² sr)].
    pub image: Vec<Rgb>,
    /// Differences between photon estimates with gather discs of full, half and quarter area, for
    /// each pixel; empty unless [`FilmSampling::repeats_in_nested_discs`] is true.
    pub nested: Vec<NestedDifferences>,
    /// Radiance of each pixel \[W/(m² sr)], for each light group in the order of
    /// [`LightGroup::ALL`]. The groups add up to `image`. Empty unless
    /// [`FilmSampling::groups_light`] is true.
    pub light_groups: Vec<Vec<Rgb>>,
    /// Radiance that clamping removed from each pixel \[W/(m² sr)]; empty unless light is clamped.
    pub removed_by_clamp: Vec<Rgb>,
    /// Indices in `image` of the rendered pixels if the picture has only one of every n tiles;
    /// empty if all tiles are rendered.
    pub rendered_pixel_indices: Vec<u32>,
    pub counters: Counters,
}

impl FilmImage {
    /// Crops this picture, which shows the window `outer`, to the window `inner`.
    fn cropped_to_window(self, outer: CropWindow, inner: CropWindow) -> Self {
        let Self {
            image,
            nested,
            light_groups: groups,
            removed_by_clamp: clamped,
            rendered_pixel_indices: pixels,
            counters,
        } = self;
        let pixels = pixels.into_iter().filter_map(|i| {
            let (x, y) = (outer.left + i % outer.size().0, outer.top + i / outer.size().0);
            let is_inside = (inner.left..inner.right).contains(&x) && (inner.top..inner.bottom).contains(&y);
            is_inside.then(|| (y - inner.top) * inner.size().0 + x - inner.left)
        });
        Self {
            image: cropped_pixels(&image, outer, inner),
            nested: cropped_pixels(&nested, outer, inner),
            light_groups: groups.iter().map(|group| cropped_pixels(group, outer, inner)).collect(),
            removed_by_clamp: cropped_pixels(&clamped, outer, inner),
            rendered_pixel_indices: pixels.collect(),
            counters,
        }
    }
}

/// Returns the part of `pixels` that lies in the window `inner`. `pixels` show the window `outer`,
/// or are empty.
fn cropped_pixels<T: Copy>(pixels: &[T], outer: CropWindow, inner: CropWindow) -> Vec<T> {
    let columns = (inner.left - outer.left) as usize..(inner.right - outer.left) as usize;
    let rows = pixels.chunks(outer.size().0 as usize).skip((inner.top - outer.top) as usize);
    rows.take(inner.size().1 as usize).flat_map(|row| &row[columns.clone()]).copied().collect()
}

/// One tile of a picture, as mutable slices of the picture's rows.
struct Tile<'a> {
    /// Index of the tile, by rows from the top.
    index: u32,
    /// Parts of the picture's rows that lie in the tile, from the top.
    image: Vec<&'a mut [Rgb]>,
    /// Differences between photon estimates with gather discs of full, half and quarter area, as
    /// rows of the tile from the top; empty unless [`FilmSampling::repeats_in_nested_discs`] is
    /// true.
    nested: Vec<&'a mut [NestedDifferences]>,
    /// Rows of each light group in the tile, from the top; empty unless
    /// [`FilmSampling::groups_light`] is true.
    light_groups: Vec<Vec<&'a mut [Rgb]>>,
    /// Rows of the radiance that clamping removes in the tile, from the top; empty unless light is
    /// clamped.
    removed_by_clamp: Vec<&'a mut [Rgb]>,
}

impl<'a> Tile<'a> {
    /// Splits a picture of `width` columns into tiles, in order of rows from the top.
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
            light_groups: (0..group_count).map(|_| Vec::new()).collect(),
            removed_by_clamp: Vec::new(),
        };
        let mut tiles: Vec<Self> = (0..width.div_ceil(TILE_SIZE) * height.div_ceil(TILE_SIZE)).map(empty).collect();
        row_pieces_by_tile(image, width).for_each(|(tile, row)| tiles[tile].image.push(row));
        row_pieces_by_tile(nested, width).for_each(|(tile, row)| tiles[tile].nested.push(row));
        row_pieces_by_tile(clamped, width).for_each(|(tile, row)| tiles[tile].removed_by_clamp.push(row));
        for (group, pixels) in groups.iter_mut().enumerate() {
            row_pieces_by_tile(pixels, width).for_each(|(tile, row)| tiles[tile].light_groups[group].push(row));
        }
        tiles
    }

    /// Stores `pixel` in column `column`, row `row` of the tile.
    fn store_pixel(&mut self, column: usize, row: usize, pixel: RenderedPixel) {
        let RenderedPixel { radiance, nested, light_groups: groups, removed_by_clamp: clamped } = pixel;
        self.image[row][column] = radiance;
        if let Some(pixels) = self.nested.get_mut(row) {
            pixels[column] = nested;
        }
        if let Some(pixels) = self.removed_by_clamp.get_mut(row) {
            pixels[column] = clamped;
        }
        self.light_groups.iter_mut().zip(groups).for_each(|(rows, light)| rows[row][column] = light);
    }
}

/// Cuts the rows of a picture of `width` columns at tile borders. Returns the pieces from the top,
/// each with the index of its tile.
fn row_pieces_by_tile<T>(picture: &mut [T], width: u32) -> impl Iterator<Item = (usize, &mut [T])> {
    let (width, edge) = (width as usize, TILE_SIZE as usize);
    let tile = move |x: usize, y: usize| y / edge * width.div_ceil(edge) + x;
    let rows = picture.chunks_mut(width).enumerate();
    rows.flat_map(move |(y, row)| row.chunks_mut(edge).enumerate().map(move |(x, piece)| (tile(x, y), piece)))
}

/// Renders the pixels in the window of `sampling`, in parallel by tiles. `key` is the random key of
/// the camera rays.
///
/// `trace_ray` returns the radiance along a camera ray \[W/(m² sr)]. For all algorithms except
/// `raycast`, it calls [`trace_camera_path`](super::camera_path::trace_camera_path). The arguments
/// of `trace_ray` are the ray, the task of the tile, and a stack of path branches that all rays of
/// a tile share.
pub(super) fn render_tiles<Stack: Default>(
    sampling: &FilmSampling<'_>,
    key: Key,
    monitor: &dyn ProgressMonitor,
    trace_ray: impl Fn(&CameraRay, &mut PathTask, &mut Stack) -> Rgb + Sync,
) -> FilmImage {
    // Tiles lie as in the whole picture, and all their pixels are rendered, so that a crop window
    // is bit-identical. The reason: a photon search starts with the radius of the pixel before it
    // in the tile, which can change last bits.
    let window = sampling.window.grown_to_tiles(TILE_SIZE, sampling.camera.size());
    let (width, height) = window.size();
    let (columns, stride) = (width.div_ceil(TILE_SIZE), sampling.tile_stride);
    let pixels = width as usize * height as usize;
    monitor.begin_stage(PassStage::Camera, pixels as u64 / u64::from(stride));

    // Cut the picture into tiles.
    let mut image = vec![Rgb::ZERO; pixels];
    let mut nested = vec![NestedDifferences::default(); if sampling.repeats_in_nested_discs { pixels } else { 0 }];
    let mut groups = vec![vec![Rgb::ZERO; pixels]; if sampling.groups_light { LightGroup::ALL.len() } else { 0 }];
    let mut clamped = vec![Rgb::ZERO; if sampling.clamp.is_some() { pixels } else { 0 }];
    let mut tiles = Tile::split_image_into_tiles(&mut image, &mut nested, &mut groups, &mut clamped, width);
    tiles.retain(|tile| is_tile_rendered(tile.index, columns, stride));
    let indices = |tile: &Tile<'_>| tile_pixels(tile.index, columns, width, height).map(|(x, y)| y * width + x);
    let rendered_pixels = if stride > 1 { tiles.iter().flat_map(indices).collect() } else { Vec::new() };

    let work = tiles.into_par_iter().map(|mut tile| {
        let mut task = PathTask::new(sampling.repeats_in_nested_discs, sampling.groups_light);
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
                    let camera_ray = CameraRay {
                        ray,
                        sampler,
                        weight_lookup_position: film_position,
                        shutter_slice,
                        prefix_weights,
                    };
                    task.counters.camera_rays += 1;
                    task.pixel.photon_radiance = Rgb::ZERO;
                    let radiance = trace_ray(&camera_ray, &mut task, &mut branches);
                    sums.add_ray(sampling, &camera_ray, radiance, filter_weight, &mut task);
                }
            }

            // Average the light of the pixel's rays.
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
    let picture = FilmImage {
        image,
        nested,
        light_groups: groups,
        removed_by_clamp: clamped,
        rendered_pixel_indices: rendered_pixels,
        counters,
    };
    if window == sampling.window { picture } else { picture.cropped_to_window(window, sampling.window) }
}

/// Light of one pixel, averaged over its rays.
struct RenderedPixel {
    /// Radiance \[W/(m² sr)].
    radiance: Rgb,
    /// Differences between photon estimates with gather discs of full, half and quarter area; 0
    /// unless [`FilmSampling::repeats_in_nested_discs`] is true.
    nested: NestedDifferences,
    /// Radiance by light group \[W/(m² sr)]; 0 unless [`FilmSampling::groups_light`] is true.
    light_groups: [Rgb; LightGroup::ALL.len()],
    /// Radiance that clamping removed \[W/(m² sr)].
    removed_by_clamp: Rgb,
}

/// Returns the stride n ≥ 2 between rendered tiles: with one of every n tiles, about `wanted` tiles
/// are rendered.
pub(super) fn rendered_tile_stride((width, height): (u32, u32), wanted: u32) -> u32 {
    (width.div_ceil(TILE_SIZE) * height.div_ceil(TILE_SIZE) / wanted).max(2)
}

/// True if the tile with index `tile` is one of the rendered tiles, when only one of every `stride`
/// tiles is rendered. `columns` is the number of tiles in a row.
///
/// Rendered tiles lie on diagonal lines, so they are spread over all rows and columns.
fn is_tile_rendered(tile: u32, columns: u32, stride: u32) -> bool {
    // A slant that shares a factor with the stride would leave out columns.
    let slant = (1..=stride.div_ceil(2)).rev().find(|slant| gcd(*slant, stride) == 1).unwrap_or(1);
    (tile % columns + tile / columns * slant).is_multiple_of(stride)
}

/// Returns the column and row of each pixel of tile `tile`, in a picture of `width` × `height`
/// pixels with `columns` tiles in a row.
fn tile_pixels(tile: u32, columns: u32, width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let (left, top) = (tile % columns * TILE_SIZE, tile / columns * TILE_SIZE);
    (top..height.min(top + TILE_SIZE)).flat_map(move |y| (left..width.min(left + TILE_SIZE)).map(move |x| (x, y)))
}

/// Sums of the light of one pixel over its rays: all radiance, the radiance of each light group,
/// and the radiance that clamping removed.
#[derive(Default)]
struct PixelSums {
    radiance: RaySums,
    light_groups: [RaySums; LightGroup::ALL.len()],
    /// Radiance that clamping removed from the rays.
    removed_by_clamp: RaySums,
}

impl PixelSums {
    /// Adds the light of `camera_ray`: its `radiance` \[W/(m² sr)], and the light that `task` kept
    /// apart, such as light groups. `weight` is the ray's weight by the pixel filter.
    ///
    /// If `sampling` has a bound for clamping, clamps `radiance` first. Leaves out a ray whose
    /// radiance is not finite, and counts it as rejected.
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
            self.removed_by_clamp.add_ray(clamp_path_light(&mut radiance, limit, task), weight, is_prefix_ray);
        }
        let groups = task.pixel.groups.take_sums();
        let is_finite = radiance.is_finite();
        if is_finite {
            self.radiance.add_ray(radiance, weight, is_prefix_ray);
            if sampling.groups_light {
                let sums = self.light_groups.iter_mut().zip(groups);
                sums.for_each(|(sum, light)| sum.add_ray(light, weight, is_prefix_ray));
            }
        } else {
            task.counters.rejected_samples += 1;
        }
        if sampling.repeats_in_nested_discs {
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
            light_groups: self.light_groups.map(|sum| sum.pixel_value(is_signed, samples)),
            removed_by_clamp: self.removed_by_clamp.pixel_value(is_signed, samples),
        }
    }
}

/// Sums of radiance over a pixel's camera rays, and over its prefix rays: extra camera paths that
/// end at the first surface that stores photons.
#[derive(Default)]
struct RaySums {
    camera_rays: FilteredSum,
    /// Sum of radiance times filter weight over the prefix rays: extra camera rays that stop at the
    /// first surface that stores photons.
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
    /// `is_signed` is true if the pixel filter has negative values. Camera rays then have different
    /// filter weights; otherwise all have weight 1.
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
    /// Sum of (filter weight − 1) over the samples: how far the sum of all weights is above the
    /// number of samples.
    weight_excess: f64,
    count: u32,
}

impl FilteredSum {
    #[inline]
    fn add(&mut self, value: Rgb, weight: f32) {
        let value = value.as_dvec3();
        self.values.add(value);
        self.weighted.add(value * f64::from(weight));
        self.weight_excess += f64::from(weight - 1.0);
        self.count += 1;
    }

    /// Returns the sum of the radiance values.
    fn unweighted_sum(&self) -> DVec3 {
        self.values.value()
    }

    /// Returns an unbiased estimate of the sum of radiance values Lᵢ times filter weights wᵢ.
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
        let correction = (weighted - values) - values * self.weight_excess;
        weighted + correction / others
    }
}

/// Scales down the part of `value` that does not come from photon estimates, so that its largest
/// channel is at most `limit` \[W/(m² sr)]. Returns the radiance that this removes from `value`.
///
/// The ray's light groups in `task` shrink by the same factor in each channel. A `value` that is
/// not finite stays as it is, because the caller rejects it.
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
