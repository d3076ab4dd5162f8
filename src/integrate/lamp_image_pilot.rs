//! Pilot (small simulation before the first pass) that finds lamp images: film regions where camera
//! rays meet a small lamp, directly or via specular surfaces.
//!
//! The pilot traces camera rays, together with close neighbours, along all chains of specular
//! vertices. Where a linear approximation predicts a lamp image nearby, the pilot moves the film
//! point to that lamp image by Newton's method. The point on the lens stays fixed. So the pilot
//! finds lamp images that cover a tiny part of a pixel. This is the search of Zeltner, Georgiev and
//! Jakob 2020 ("Specular manifold sampling"), with the film point as unknown. A lamp image counts
//! only if a camera ray there hits the lamp. Each lamp image is stored as an ellipse; several
//! ellipses cover one of another shape.

mod image_set;

use super::lamp_images::LampImage;
use super::pass_renderer::PassRenderer;
use super::specular_chain::{CameraPoint, LampPassage, LampSphere, RayBundle, SpecularChain};
use crate::camera::{Camera, Filter};
use crate::color;
use crate::light::{Light, LightSurface};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effect, Effects, Interior, PathEvent, Scene, with_interior_type};
use glam::{DVec2, Vec2};
use image_set::{FoundLampImage, ImageSet};
use rayon::prelude::*;
use std::collections::HashSet;
use std::ops::Range;

/// Largest number of camera rays per pixel that search for lamp images: film regions where camera
/// rays meet a small lamp, directly or via specular surfaces.
const MAX_RAYS_PER_PIXEL: u32 = 16;

/// Largest number of lamps for whose lamp images the pilot searches. A lamp image is a film region
/// where camera rays meet a small lamp.
const MAX_LAMPS: usize = 64;

/// Number of camera rays through every pixel with which the lamp-image pilot starts. Its other
/// rays, up to [`MAX_RAYS_PER_PIXEL`], go only through pixels near predicted lamp images, film
/// regions where camera rays meet a small lamp.
const MIN_RAYS_PER_PIXEL: u32 = 2;

/// Fraction of the predicted noise up to which the pilot ignores the faintest lamp images. A lamp
/// image is a film region where camera rays meet a small lamp.
///
/// Each tile first drops its faintest lamp images, up to half of this fraction. Then the picture as
/// a whole drops its faintest, up to the other half. Most lamp images have little noise: without
/// this limit, nine of ten searches would be for a thousandth of the noise.
const MAX_OMITTED_NOISE_FRACTION: f64 = 1e-3;

/// Throughput, as a mean over RGB, below which the lamp-image pilot does not follow a chain of
/// specular vertices.
///
/// The noise of a lamp image (film region where camera rays meet a small lamp) is proportional to
/// the squared throughput. This value keeps chains with one reflection at glass, and leaves out
/// chains with two.
const MIN_THROUGHPUT: f32 = 0.02;

/// Largest distance on the film, along each axis, from a camera ray of the pilot to a predicted
/// lamp image (film region where camera rays meet a small lamp) \[pixels]. The pilot searches no
/// lamp image farther away, because other camera rays are closer to it.
const MAX_FILM_DISTANCE: f64 = 1.0;

/// Largest area \[pixels²] of a lamp image (film region where camera rays meet a small lamp) at
/// which prefix rays are aimed. Ordinary rays find larger lamp images often enough.
const MAX_AREA: f64 = 1.0;

/// Edge length \[pixels] of square tiles of the film. The pilot searches for the lamp images (film
/// regions where camera rays meet a small lamp) of a tile together.
const TILE_SIZE: u32 = 16;

/// Largest number of searches for lamp images (film regions where camera rays meet a small lamp) in
/// a tile, divided by the number of pixels of the tile. The limit bounds the work of the pilot;
/// searches with the most predicted noise come first.
const MAX_SEARCHES_PER_PIXEL: f64 = 3.0;

/// Largest number of Newton steps of a search for a lamp image, the film region where camera rays
/// meet a small lamp.
const MAX_STEPS: u32 = 8;

/// Largest half width and half height \[pixels] of the film region that a lamp image (film region
/// where camera rays meet a small lamp) sweeps as the lens point varies. Prefix rays are not aimed
/// at larger lamp images: these are blurred or thin, so that no pixel gets much of their light.
const MAX_IMAGE_HALF_EXTENT: f32 = 12.0;

/// Target of the Newton steps of a search for a lamp image: the distance at which the camera ray
/// shall pass the lamp's center, divided by the lamp's radius.
///
/// The target lies on the near side of the lamp, so that searches from several sides find several
/// parts of a lamp image (film region where camera rays meet a small lamp).
const TARGET_RELATIVE_MISS: f64 = 0.5;

/// Threshold at which the search for a lamp image has converged, in lamp radii: the ray passes the
/// lamp's center at no more than this distance.
const CONVERGED_RELATIVE_MISS: f64 = 0.75;

/// Light that a lamp image (film region where camera rays meet a small lamp) adds to one pixel,
/// averaged over RGB.
#[derive(Clone, Copy, Debug)]
pub(super) struct LampImageContribution {
    /// Index of the pixel, by rows from the top.
    pub pixel: u32,
    pub image: LampImage,
    /// Radiance that the lamp image adds to the pixel \[W/(m² sr)].
    pub pixel_radiance: f64,
    /// Mean square of the radiance that one camera ray of the pixel finds in the lamp image
    /// \[(W/(m² sr))²].
    pub mean_square: f64,
}

/// Start of a search for a lamp image (film region where camera rays meet a small lamp): a camera
/// ray of the pilot that passes near the lamp.
struct ImageSearchStart {
    /// Film point and lens point of the camera ray from which the search starts.
    point: CameraPoint,
    /// Sampler of the camera ray from which the search starts.
    sampler: Sampler,
    chain: SpecularChain,
    lamp: LampSphere,
    /// Vector on the film from the camera ray to the predicted lamp image \[pixels].
    to_image: Vec2,
    /// Predicted integral of the squared radiance over the lamp image \[pixels² (W/(m² sr))²]. The
    /// noise of the lamp image is proportional to this integral.
    noise: f64,
}

/// Returns the lamp images in each pixel, sorted by pixel. A lamp image is a film region where
/// camera rays meet a small lamp. It is listed in every pixel whose filter reaches it.
///
/// Returns no lamp images if no light is an analytic shape, or if the effect of specular surfaces
/// is off.
pub(super) fn find_lamp_images(renderer: &PassRenderer<'_>) -> Vec<LampImageContribution> {
    let scene = renderer.scene;
    let lamps = lamp_spheres(scene);
    if lamps.is_empty() || !renderer.policy.effects.has(Effect::Specular) {
        return Vec::new();
    }
    let key = Key::new(renderer.settings.camera_paths.seed).purpose_key(Purpose::LampImages);
    let effects = renderer.policy.effects;
    let search = ImageSearch { scene, effects, lamps, key };
    let images = with_interior_type!(effects, <I> search.distinct_images::<I>());
    let lens_radius = search.lens_radius() as f32;
    images_by_pixel(&images, scene.camera(), &renderer.settings.camera_paths.filter, lens_radius)
}

/// Returns a sphere for each area light of `scene` that is an analytic shape. The sphere has the
/// center of the light's bounding box, and the longest edge of the box as diameter. If there are
/// more than [`MAX_LAMPS`] such lights, only those with the largest radiance are returned.
fn lamp_spheres(scene: &Scene) -> Vec<LampSphere> {
    let mut lamps: Vec<(f32, LampSphere)> = Vec::new();
    for (light, area) in scene.lights().iter().map(Light::as_area_light).enumerate() {
        let Some(area) = area else { continue };
        let LightSurface::Shape(shape) = &area.surface else { continue };
        let bounds = shape.bounds();
        let sphere = LampSphere {
            center: bounds.center().as_dvec3(),
            radius: 0.5 * f64::from(bounds.extent().max_element()),
            light: light as u32,
        };
        lamps.push((color::channel_mean(area.radiance), sphere));
    }
    lamps.sort_by(|a, b| b.0.total_cmp(&a.0));
    lamps.into_iter().map(|(_, lamp)| lamp).take(MAX_LAMPS).collect()
}

/// Search for lamp images: film regions where camera rays meet a small lamp, directly or via
/// specular surfaces.
struct ImageSearch<'a> {
    scene: &'a Scene,
    effects: Effects,
    lamps: Vec<LampSphere>,
    key: Key,
}

impl ImageSearch<'_> {
    /// Returns the lamp images of all lamps, without repetitions. A lamp image is a film region
    /// where camera rays meet a small lamp.
    fn distinct_images<I: Interior>(&self) -> Vec<FoundLampImage> {
        let (width, height) = self.scene.camera().size();
        let corners: Vec<(u32, u32)> = (0..height)
            .step_by(TILE_SIZE as usize)
            .flat_map(|top| (0..width).step_by(TILE_SIZE as usize).map(move |left| (left, top)))
            .collect();
        let tile_pixels = |&(left, top): &(u32, u32)| -> Vec<(u32, u32)> {
            let columns = left..width.min(left + TILE_SIZE);
            (top..height.min(top + TILE_SIZE)).flat_map(|y| columns.clone().map(move |x| (x, y))).collect()
        };

        // Find lamps near a few camera rays through each pixel. Leave out search starts with little
        // predicted noise; do so in each tile first, to save memory.
        let first_starts = |corner: &(u32, u32)| {
            let mut search_starts = self.search_starts_near_rays::<I>(&tile_pixels(corner), 0..MIN_RAYS_PER_PIXEL);
            let least = least_searched_noise(&search_starts, 0.5 * MAX_OMITTED_NOISE_FRACTION);
            search_starts.retain(|search_start| search_start.noise >= least);
            search_starts.shrink_to_fit();
            search_starts
        };
        let first: Vec<Vec<ImageSearchStart>> = corners.par_iter().map(first_starts).collect();
        let least = least_searched_noise(first.iter().flatten(), 0.5 * MAX_OMITTED_NOISE_FRACTION);

        // Trace more camera rays near the predicted lamp images, and search from all starts.
        let images = |(corner, mut search_starts): (&(u32, u32), Vec<ImageSearchStart>)| {
            let tile = tile_pixels(corner);
            search_starts.retain(|search_start| search_start.noise >= least);
            let near = pixels_near_images(&tile, &search_starts);
            let more = self.search_starts_near_rays::<I>(&near, MIN_RAYS_PER_PIXEL..MAX_RAYS_PER_PIXEL);
            search_starts.extend(more.into_iter().filter(|search_start| search_start.noise >= least));
            self.search_images::<I>(search_starts, (MAX_SEARCHES_PER_PIXEL * tile.len() as f64) as u32)
        };
        let found: Vec<FoundLampImage> = corners.par_iter().zip(first).flat_map_iter(images).collect();
        let mut distinct = ImageSet::new(self.lens_radius() as f32);
        for image in found {
            distinct.insert(image);
        }
        distinct.images
    }

    /// Returns starts of searches for lamp images (film regions where camera rays meet a small
    /// lamp): camera rays through `pixels` that pass near lamps. `indices` selects the rays of each
    /// pixel, by numbers below [`MAX_RAYS_PER_PIXEL`].
    fn search_starts_near_rays<I: Interior>(
        &self,
        pixels: &[(u32, u32)],
        indices: Range<u32>,
    ) -> Vec<ImageSearchStart> {
        let camera = self.scene.camera();
        let has_lens = self.lens_radius() > 0.0;
        let (mut search_starts, mut stack) = (Vec::new(), Vec::new());
        for (index, &(x, y)) in indices.flat_map(|index| pixels.iter().map(move |pixel| (index, pixel))) {
            let sampler = Sampler::new(self.key.pixel_key(x, y), index, MAX_RAYS_PER_PIXEL);
            let point = CameraPoint {
                film: Vec2::new(x as f32, y as f32) + sampler.get_2d(Dimension::Film),
                on_lens: has_lens.then(|| camera.sample_lens(sampler.get_2d(Dimension::Lens))),
            };
            self.push_search_starts::<I>(point, sampler, &mut search_starts, &mut stack);
        }
        search_starts
    }

    /// Searches for lamp images (film regions where camera rays meet a small lamp) from
    /// `search_starts`, those with the most predicted noise first. Skips starts that a found lamp
    /// image already covers. After each lamp image that it finds, searches from the ends of this
    /// lamp image for further parts, before the next start. Makes at most `searches` searches in
    /// all. Returns the distinct lamp images.
    fn search_images<I: Interior>(
        &self,
        mut search_starts: Vec<ImageSearchStart>,
        mut searches: u32,
    ) -> Vec<FoundLampImage> {
        search_starts.sort_by(|a: &ImageSearchStart, b: &ImageSearchStart| b.noise.total_cmp(&a.noise));
        let mut images = ImageSet::new(self.lens_radius() as f32);
        let mut parts = Vec::new();
        for search_start in search_starts {
            parts.push(search_start);
            while let Some(search_start) = parts.pop() {
                let ImageSearchStart { point, to_image, lamp, chain, .. } = search_start;
                if images.covers(point.film + to_image, point.lens_point(), lamp.light, chain) {
                    continue;
                }
                if searches == 0 {
                    return images.images;
                }
                searches -= 1;
                let Some(image) = self.search_image::<I>(&search_start) else { continue };
                if images.insert(image) {
                    parts.extend(image.ends().map(|film| {
                        let point = CameraPoint { film, ..image.point };
                        ImageSearchStart { point, sampler: image.sampler, to_image: Vec2::ZERO, ..search_start }
                    }));
                }
            }
        }
        images.images
    }

    /// Returns the radius of the lens \[length]; 0 if all camera rays start at the lens center.
    fn lens_radius(&self) -> f64 {
        let lens = self.scene.camera().lens().filter(|_| self.effects.has(Effect::Lens));
        lens.map_or(0.0, |lens| lens.radius)
    }

    /// Adds starts of searches to `search_starts`: one for each lamp near the camera ray through
    /// `point`, or near the rays into which specular surfaces split it. Leaves out rays that carry
    /// a single wavelength after dispersive glass.
    ///
    /// `stack` is empty before and after.
    fn push_search_starts<I: Interior>(
        &self,
        point: CameraPoint,
        sampler: Sampler,
        search_starts: &mut Vec<ImageSearchStart>,
        stack: &mut Vec<RayBundle<I>>,
    ) {
        stack.push(RayBundle::from_camera(self.scene, self.effects, point, sampler));
        while let Some(bundle) = stack.pop() {
            let mut traced = bundle;
            let event = traced.next_vertex(self.scene);
            if bundle.has_wavelength() {
                continue;
            }
            let hit_distance = match &event {
                PathEvent::Surface(vertex) => f64::from(vertex.distance),
                PathEvent::Escaped { .. } => f64::INFINITY,
                PathEvent::Scattered { .. } => 0.0,
            };
            for lamp in &self.lamps {
                let Some(passage) = bundle.lamp_passage(lamp, hit_distance) else { continue };
                let area = std::f64::consts::PI / passage.to_disc.determinant().abs();
                let to_image = vector_to_near_side(&passage);
                if to_image.abs().max_element() <= MAX_FILM_DISTANCE && area <= MAX_AREA {
                    let radiance = color::channel_mean(bundle.throughput) * self.lamp_radiance(lamp);
                    let noise = area * (f64::from(radiance) * f64::from(radiance));
                    let to_image = to_image.as_vec2();
                    search_starts.push(ImageSearchStart {
                        point,
                        sampler,
                        chain: bundle.chain,
                        lamp: *lamp,
                        to_image,
                        noise,
                    });
                }
            }
            if let PathEvent::Surface(vertex) = event {
                stack.extend(traced.scatter(self.scene, &vertex, MIN_THROUGHPUT).into_iter().flatten());
            }
        }
    }

    /// Returns the radiance of `lamp`, averaged over RGB and its surface \[W/(m² sr)].
    fn lamp_radiance(&self, lamp: &LampSphere) -> f32 {
        let area = self.scene.lights()[lamp.light as usize].as_area_light();
        area.map_or(0.0, |area| color::channel_mean(area.radiance))
    }

    /// Moves the film point of `search_start` to the predicted lamp image (film region where camera
    /// rays meet a small lamp) by Newton's method. Returns the lamp image; `None` if the search
    /// fails, if the lamp is hidden or black, or if the lamp image is too large.
    fn search_image<I: Interior>(&self, search_start: &ImageSearchStart) -> Option<FoundLampImage> {
        let ImageSearchStart { point: start, sampler, chain, lamp, .. } = *search_start;
        let mut from = start.film;
        let mut step = search_start.to_image;
        for _ in 0..MAX_STEPS {
            let point = CameraPoint { film: from + step, ..start };
            let bundle = RayBundle::<I>::follow(self.scene, self.effects, point, sampler, chain);
            let passage = bundle.and_then(|bundle| Some((bundle, bundle.lamp_passage(&lamp, f64::INFINITY)?)));
            let Some((mut bundle, passage)) = passage else {
                step *= 0.5;
                continue;
            };
            if passage.relative_miss > CONVERGED_RELATIVE_MISS {
                from = point.film;
                let to_image = vector_to_near_side(&passage);
                let largest = to_image.abs().max_element();
                step = (to_image * (MAX_FILM_DISTANCE / largest).min(1.0)).as_vec2();
                let moved = (from + step - start.film).abs().max_element();
                if moved.is_nan() || moved > 3.0 * MAX_FILM_DISTANCE as f32 {
                    return None;
                }
                continue;
            }
            let PathEvent::Surface(hit) = bundle.next_vertex(self.scene) else { return None };
            if hit.surface.area_light_index != Some(lamp.light) {
                return None;
            }
            let radiance =
                color::channel_mean(bundle.throughput * hit.absorption_and_wavelength_weight * hit.surface.emission);
            let lens_shift = passage.shift_per_lens_position.as_mat2();
            let image = LampImage {
                center: point.film + passage.to_image.as_vec2() - lens_shift * point.lens_point(),
                shift_per_lens_position: lens_shift,
                to_disc: passage.to_disc.as_mat2(),
            };
            let lens_radius = self.lens_radius() as f32;
            let extent = image.half_extent_over_lens(lens_radius).max_element();
            let valid = image.area() <= MAX_AREA as f32 && extent <= MAX_IMAGE_HALF_EXTENT && radiance > 0.0;
            return valid.then_some(FoundLampImage { image, point, sampler, light: lamp.light, chain, radiance });
        }
        None
    }
}

/// Returns the lowest predicted noise of a search start from which the pilot still searches.
///
/// The starts with less noise hold together at most the fraction `omitted_fraction` of the
/// predicted noise of all `search_starts`.
fn least_searched_noise<'a>(
    search_starts: impl IntoIterator<Item = &'a ImageSearchStart>,
    omitted_fraction: f64,
) -> f64 {
    let mut noises: Vec<f64> = search_starts.into_iter().map(|search_start| search_start.noise).collect();
    noises.sort_by(f64::total_cmp);
    let mut rest = omitted_fraction * noises.iter().sum::<f64>();
    let searched = noises.into_iter().find(|noise| {
        rest -= noise;
        rest < 0.0
    });
    searched.unwrap_or(0.0)
}

/// Returns the pixels of `tile`, as (column, row), that are at most one pixel away from a lamp
/// image (film region where camera rays meet a small lamp) that `search_starts` predict.
fn pixels_near_images(tile: &[(u32, u32)], search_starts: &[ImageSearchStart]) -> Vec<(u32, u32)> {
    let around = |search_start: &ImageSearchStart| {
        let at = (search_start.point.film + search_start.to_image).floor().as_ivec2();
        (at.y - 1..=at.y + 1).flat_map(move |y| (at.x - 1..=at.x + 1).map(move |x| (x, y)))
    };
    let near: HashSet<(i32, i32)> = search_starts.iter().flat_map(around).collect();
    tile.iter().copied().filter(|(x, y)| near.contains(&(*x as i32, *y as i32))).collect()
}

/// Returns the vector on the film \[pixels] from a camera ray to the near side of a lamp image
/// (film region where camera rays meet a small lamp). `passage` describes how far the ray passes
/// from the lamp.
fn vector_to_near_side(passage: &LampPassage) -> DVec2 {
    passage.to_image * (1.0 - TARGET_RELATIVE_MISS / passage.relative_miss).max(0.0)
}

/// Returns the light that each of the lamp images `images` (film regions where camera rays meet a
/// small lamp) adds to each pixel whose filter reaches it, sorted by pixel.
///
/// `lens_radius` is the radius of the lens \[length]; 0 if all camera rays start at the lens
/// center.
fn images_by_pixel(
    images: &[FoundLampImage],
    camera: &Camera,
    filter: &Filter,
    lens_radius: f32,
) -> Vec<LampImageContribution> {
    let (width, height) = camera.size();
    let grid = |steps: [f32; 4]| steps.into_iter().flat_map(move |y| steps.map(|x| Vec2::new(x, y)));
    let disc_points = || grid([-0.75, -0.25, 0.25, 0.75]).filter(|p| p.length_squared() < 1.0);
    let lens_points: Vec<Vec2> = if lens_radius > 0.0 {
        grid([0.125, 0.375, 0.625, 0.875]).map(|u| camera.sample_lens(u).as_vec2()).collect()
    } else {
        vec![Vec2::ZERO]
    };
    let mut in_pixels = Vec::new();
    for FoundLampImage { image, radiance, .. } in images {
        let area = f64::from(image.area());
        let points = lens_points.iter().flat_map(|on_lens| disc_points().map(|p| image.film_point(p, *on_lens)));
        let points: Vec<Vec2> = points.collect();
        let half_extent = image.half_extent_over_lens(lens_radius) + filter.radius() + 0.5;
        let (low, high) = (image.center - half_extent, image.center + half_extent);
        let range =
            |low: f32, high: f32, end: u32| (low.max(0.0) as u32).min(end)..(high.max(0.0).ceil() as u32).min(end);
        for y in range(low.y, high.y, height) {
            for x in range(low.x, high.x, width) {
                let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let value = |p: &Vec2| {
                    let offset = *p - center;
                    f64::from((filter.normalized_axis_value(offset.x) * filter.normalized_axis_value(offset.y)).abs())
                };
                let covered = area * points.iter().map(value).sum::<f64>() / points.len() as f64;
                if covered > 0.0 {
                    let radiance = f64::from(*radiance);
                    in_pixels.push(LampImageContribution {
                        pixel: y * width + x,
                        image: *image,
                        pixel_radiance: radiance * covered,
                        mean_square: radiance * radiance * covered,
                    });
                }
            }
        }
    }
    in_pixels.sort_by_key(|image| image.pixel);
    in_pixels
}

#[cfg(test)]
mod tests;
