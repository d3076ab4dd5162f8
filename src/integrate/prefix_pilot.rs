//! Pilot (small simulation before the first pass) that finds how many prefix rays each pixel needs.
//!
//! The *prefix* of a camera path is its part up to the first *receiver*, a surface or medium that
//! stores photons. A *prefix ray* is an extra camera path that ends there. Prefixes alone find
//! highlights of small lamps, and caustics seen in mirrors and through glass. These often cover a
//! fraction of a pixel, so their noise is large. A prefix ray reduces this noise and costs little.
//!
//! Suppose that a pixel has n camera paths and m prefix rays, and that one camera path and l prefix
//! rays read photon maps. The variance of the pixel is then σ_r²/n + σ_f²/(n + m) + σ_p²/(1 + l).
//! The first term is for light at and after the first receiver, the second for emission that
//! prefixes find, and the third for the photon estimate. The pilot estimates these variances and
//! the work of a ray and of a lookup. It minimizes the variance of the picture times the work of a
//! pass, which is the inverse of efficiency (Pharr, Jakob and Humphreys 2023, section 2.2.1).
//!
//! The first pictures of the pilot trace camera paths that do not end at the first receiver. They
//! show in which pixels the photon estimate may need prefix rays. In the next pictures, only the
//! prefix rays of these pixels read photon maps, because lookups are most of the work.
//!
//! No pass uses rays of the pilot, so the mean of the passes stays unbiased.

mod blocks;
mod efficient_counts;
mod variances;

use super::balance;
use super::camera_path;
use super::camera_ray::CameraRay;
use super::film_sampling::FilmSampling;
use super::lamp_image_pilot::{LampImageContribution, find_lamp_images};
use super::lamp_images::{LampImages, PixelLampImage};
use super::map_builder::MapBuildOptions;
use super::pass::{PassResult, SilentMonitor};
use super::pass_renderer::PassRenderer;
use super::photon_maps::PhotonMaps;
use super::prefix_rays::{LampImageRayCounts, PixelPrefixRayCounts, PrefixRayAllocation, PrefixWeights};
use super::tiles::{self, FilmImage};
use crate::color::{self, Rgb};
use crate::sampling::{Key, Purpose};
use crate::scene::{Effect, with_interior_type};
use crate::stats::Counters;
use blocks::PilotBlocks;
use efficient_counts::{PassWork, efficient_ray_counts};
use rayon::prelude::*;
use variances::{BlockLightStatistics, RelativePixelVariances, pixel_variances};

/// Number of pictures that the prefix-ray pilot traces first, with camera paths that do not end at
/// the first surface that stores photons.
///
/// The pilot is a small simulation before the first pass. Each of its pictures has one ray per
/// block of pixels.
const WHOLE_PICTURES: u32 = 2;

/// Number of pictures that the prefix-ray pilot (small simulation before the first pass) traces
/// after the [`WHOLE_PICTURES`], with [prefix rays](super::prefix_rays): camera paths that end at
/// the first surface that stores photons.
const PREFIX_PICTURES: u32 = 4;

/// Number of pictures, among the [`PREFIX_PICTURES`] pictures of prefix rays, in which prefix rays
/// also evaluate photon estimates. They do so only in pixels that [`find_lookup_candidates`]
/// selects.
const LOOKUP_PICTURES: u32 = 2;

/// Smallest ratio of the photon paths of a pass to those of the prefix-ray pilot (small simulation
/// before the first pass): the pilot traces at most 1/4 of the paths of a pass.
const MIN_PASS_TO_PILOT_PATH_RATIO: u32 = 4;

/// Largest number of photon paths that the prefix-ray pilot (small simulation before the first
/// pass) traces for one photon map.
const MAX_PHOTON_PATHS: u32 = 1 << 20;

/// Threshold on v·n²/V above which the prefix-ray pilot (small simulation before the first pass)
/// measures photon estimates at the prefix rays of a pixel: extra camera paths that end at the
/// first surface that stores photons.
///
/// Here v is the variance of the pixel's photon estimate, and n the number of camera paths per
/// pixel. V is the mean variance of one camera path over all pixels. In passes, more estimates pay
/// only at clearly larger values of v·n²/V. The threshold is low because the pilot's first estimate
/// of v is noisy.
const CANDIDATE_VARIANCE: f64 = 1.0 / 24.0;

/// Largest number of lamp images at which extra camera rays of one pixel are aimed. A lamp image is
/// the part of the film where camera rays meet a small lamp, directly or via specular surfaces.
const MAX_PIXEL_IMAGES: usize = 16;

/// Number of extra camera rays aimed at lamp images (film regions where camera rays meet a small
/// lamp) that the prefix-ray pilot assumes in each pixel with lamp images, while it measures
/// variances.
///
/// Such rays would take over most of the light of lamp images, which lowers the variance of other
/// rays.
const ASSUMED_AIMED_RAYS: u8 = 8;

/// Returns the number of [prefix rays](super::prefix_rays) that each pixel should get: extra camera
/// paths that end at the first surface that stores photons. Returns `None` if such rays do not pay,
/// or if media scatter or emit.
///
/// A pilot (small simulation before the first pass) finds the numbers. The pilot does not model the
/// light that prefix rays find in scattering or emitting media. The numbers suit passes with the
/// numbers of camera rays and photon paths of `renderer`.
pub(super) fn find_prefix_ray_counts(renderer: &PassRenderer<'_>) -> Option<PrefixRayAllocation> {
    let (scene, effects) = (renderer.scene, renderer.policy.effects);
    if effects.has(Effect::Media) && scene.media_in_use().iter().any(|medium| medium.scatters() || medium.emits()) {
        return None;
    }

    // Find lamp images.
    let (width, height) = scene.camera().size();
    let blocks = PilotBlocks::new((width, height));
    let found_images = find_lamp_images(renderer);
    let lamp_images = images_of_pixels(&found_images, width as usize * height as usize);

    // Trace photons and the pictures of the pilot.
    let key = Key::new(renderer.settings.camera_paths.seed).purpose_key(Purpose::PrefixRays);
    let mut photons = PassResult::default();
    let counts = renderer.map_builder.counts;
    let divisor = counts.unaimed.max(counts.aimed).div_ceil(MAX_PHOTON_PATHS).max(MIN_PASS_TO_PILOT_PATH_RATIO);
    let maps = renderer.map_builder.traces_photons().then(|| {
        let options = MapBuildOptions { connects_to_camera: true, ..MapBuildOptions::for_pilot(key, divisor) };
        renderer.map_builder.build(&options, &SilentMonitor, &mut photons)
    });
    let measured = trace_pictures(renderer, maps.as_ref(), &found_images, &lamp_images, &blocks);
    let work = measured.pass_work(renderer.samples_per_pixel, &blocks, &photons, divisor);

    // Choose the numbers of prefix rays.
    let variances = pixel_variances(&measured.light, &found_images, &blocks)?;
    let counts = efficient_ray_counts(&variances, renderer.samples_per_pixel, &work)?;
    let sum =
        |number: fn(&PixelPrefixRayCounts) -> u8| counts.iter().map(|count| u64::from(number(count))).sum::<u64>();
    let (rays, lookups) = (sum(|count| count.unaimed) + sum(|count| count.aimed), sum(|count| count.lookups));
    let scaled = |n: u64, total: u64, traced: f64| (n as f64 * total as f64 / traced).round() as u64;
    let PilotMeasurements { prefix_rays, lookups: traced, .. } = &measured;
    let (traced_rays, traced_lookups) = (measured.prefix_ray_count(&blocks), measured.lookup_count());
    let expected_work = Counters {
        camera_rays: rays,
        continuation_rays: scaled(prefix_rays.continuation_rays, rays, traced_rays),
        shadow_rays: scaled(prefix_rays.shadow_rays, rays, traced_rays),
        density_estimates: scaled(traced.density_estimates, lookups, traced_lookups),
        gathered_photons: scaled(traced.gathered_photons * u64::from(divisor), lookups, traced_lookups),
        ..Counters::default()
    };
    let lamp_images = lamp_images.in_pixels(|pixel| counts[pixel].aimed > 0);
    Some(PrefixRayAllocation { counts: counts.into(), lamp_images, expected_work })
}

/// Light and ray counts of the pictures of the prefix-ray pilot (small simulation before the first
/// pass).
struct PilotMeasurements {
    /// Light of each block of pixels, by rows from the top. In each block, a picture traces the ray
    /// of one pixel.
    light: Vec<BlockLightStatistics>,
    /// Ray and photon counts of the pilot's camera paths that do not end at the first surface that
    /// stores photons.
    whole_paths: Counters,
    /// Ray counts of the pilot's prefix rays (camera paths that end at the first surface that
    /// stores photons), without their photon estimates.
    prefix_rays: Counters,
    /// Counts of the photon estimates of the pilot's prefix rays, and of the photons in them.
    lookups: Counters,
    /// Number of the pilot's prefix rays (camera paths that end at the first surface that stores
    /// photons) that evaluated photon estimates.
    lookup_count: usize,
}

impl PilotMeasurements {
    /// Returns the number of prefix rays (camera paths that end at the first surface that stores
    /// photons) that the pilot traced.
    fn prefix_ray_count(&self, blocks: &PilotBlocks) -> f64 {
        blocks.count() as f64 * f64::from(PREFIX_PICTURES)
    }

    /// Returns the number of prefix rays (camera paths that end at the first surface that stores
    /// photons) that evaluated photon estimates, but at least 1.
    fn lookup_count(&self) -> f64 {
        self.lookup_count.max(1) as f64
    }

    /// Returns the work of the parts of a pass with `samples` camera paths per pixel. `photons`
    /// holds the photon counts of the pilot, which traces 1/`divisor` of the photon paths of a
    /// pass.
    fn pass_work(&self, samples: u32, blocks: &PilotBlocks, photons: &PassResult, divisor: u32) -> PassWork {
        let pixels = (blocks.film_size.0 * blocks.film_size.1) as f64;
        let part = f64::from(divisor);
        let lookup = |counters: &Counters| {
            balance::LOOKUP_WORK * counters.density_estimates as f64
                + balance::GATHERED_PHOTON_WORK * part * counters.gathered_photons as f64
        };
        let stored = photons.aimed.stored_photons + photons.unaimed.stored_photons;
        let photons = part * (photons.counters.photon_rays as f64 + balance::photon_storage_work(stored));
        let pixels_per_block = pixels / blocks.count() as f64;
        let scaled_to_all_pixels = |work: f64| pixels_per_block * work / f64::from(WHOLE_PICTURES);
        let camera = scaled_to_all_pixels(f64::from(samples) * balance::camera_path_work(&self.whole_paths));
        PassWork {
            camera_work_per_pixel: camera / pixels,
            photon_work_per_pixel: (photons + scaled_to_all_pixels(lookup(&self.whole_paths))) / pixels,
            work_per_prefix_ray: balance::camera_path_work(&self.prefix_rays) / self.prefix_ray_count(blocks),
            work_per_lookup: lookup(&self.lookups) / self.lookup_count(),
        }
    }
}

/// Traces the pictures of the prefix-ray pilot with the photon maps `maps`: first
/// [`WHOLE_PICTURES`] of complete camera paths, then [`PREFIX_PICTURES`] of prefix rays, which end
/// at the first surface that stores photons.
///
/// `found_images` are the lamp images of the film (film regions where camera rays meet a small
/// lamp), and `lamp_images` the same images by pixel.
fn trace_pictures(
    renderer: &PassRenderer<'_>,
    maps: Option<&PhotonMaps<'_>>,
    found_images: &[LampImageContribution],
    lamp_images: &LampImages,
    blocks: &PilotBlocks,
) -> PilotMeasurements {
    let mut light = vec![BlockLightStatistics::default(); blocks.count()];
    let mut whole_paths = Counters::default();
    for i in 0..WHOLE_PICTURES {
        let picture = render_light_parts(renderer, maps, lamp_images, blocks, i, |_| PathParts::Whole);
        light.par_iter_mut().enumerate().for_each(|(block, light)| {
            let parts = picture.image[blocks.traced_pixel(block, i)];
            let before = parts.x - light.from_receiver.mean;
            light.from_receiver.add(parts.x);
            light.up_to_receiver.add(parts.y);
            light.photon_estimate.add(parts.z);
            light.deviation_product_sum += f64::from(before) * f64::from(parts.y - light.up_to_receiver.mean);
        });
        whole_paths += picture.counters;
    }

    let candidates = pixel_variances(&light, found_images, blocks)
        .map(|variances| find_lookup_candidates(&variances, renderer.samples_per_pixel));
    let (mut prefix_rays, mut lookups, mut lookup_count) = (Counters::default(), Counters::default(), 0);
    for i in WHOLE_PICTURES..WHOLE_PICTURES + PREFIX_PICTURES {
        let is_candidate = |pixel: usize| candidates.as_ref().is_some_and(|candidates| candidates[pixel]);
        let looks_up = |pixel: usize| i < WHOLE_PICTURES + LOOKUP_PICTURES && is_candidate(pixel);
        let picture = render_light_parts(renderer, maps, lamp_images, blocks, i, |pixel| {
            if looks_up(pixel) { PathParts::PrefixWithLookup } else { PathParts::Prefix }
        });
        light.par_iter_mut().enumerate().for_each(|(block, light)| {
            let pixel = blocks.traced_pixel(block, i);
            let parts = picture.image[pixel];
            if blocks.starts_new_pixels(i) {
                light.up_to_receiver.start_group();
                light.photon_estimate.start_group();
            }
            light.up_to_receiver.add(parts.y);
            if looks_up(pixel) {
                light.photon_estimate.add(parts.z);
            }
        });
        lookup_count += (0..blocks.count()).filter(|block| looks_up(blocks.traced_pixel(*block, i))).count();
        let Counters { density_estimates, gathered_photons, .. } = picture.counters;
        lookups += Counters { density_estimates, gathered_photons, ..Counters::default() };
        prefix_rays += Counters { density_estimates: 0, gathered_photons: 0, ..picture.counters };
    }
    PilotMeasurements { light, whole_paths, prefix_rays, lookups, lookup_count }
}

/// Groups `found`, the lamp images sorted by pixel, into one list for each of the picture's
/// `pixels` pixels. A lamp image is a film region where camera rays meet a small lamp.
///
/// A ray aimed at lamp images chooses a lamp image of its pixel with a probability proportional to
/// the light of that lamp image in the pixel. At most [`MAX_PIXEL_IMAGES`] lamp images remain in a
/// pixel: those with most light.
fn images_of_pixels(found: &[LampImageContribution], pixels: usize) -> LampImages {
    let mut images = vec![Vec::new(); pixels];
    for in_pixel in found.chunk_by(|a, b| a.pixel == b.pixel) {
        let mut brightest: Vec<&LampImageContribution> = in_pixel.iter().collect();
        brightest.sort_by(|a, b| b.pixel_radiance.total_cmp(&a.pixel_radiance));
        brightest.truncate(MAX_PIXEL_IMAGES);
        let total: f64 = brightest.iter().map(|image| image.pixel_radiance).sum();
        let share = |image: &&LampImageContribution| PixelLampImage {
            image: image.image,
            aim_probability: (image.pixel_radiance / total) as f32,
        };
        images[in_pixel[0].pixel as usize] = brightest.iter().map(share).collect();
    }
    LampImages::from_pixels(&images)
}

/// Part of a camera path that the prefix-ray pilot (small simulation before the first pass) traces:
/// the whole path, or its *prefix* up to the first receiver (a surface or medium that stores
/// photons).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PathParts {
    /// The pilot traces the whole path.
    Whole,
    /// The pilot traces the path up to its first receiver (surface or medium that stores photons),
    /// with the photon estimate there.
    PrefixWithLookup,
    /// The pilot traces the path up to its first receiver (surface or medium that stores photons),
    /// without photon estimate.
    Prefix,
}

/// Returns a flag for each pixel: true if the prefix-ray pilot (small simulation before the first
/// pass) should measure photon estimates at prefix rays of that pixel.
///
/// A pass traces n = `samples` camera paths in each pixel, and only one of them reads photon maps.
/// Let V be the variance of one camera path, as a mean over all pixels. A second photon estimate
/// does not pay if the variance of the estimate is small against V/n². So the function selects the
/// pixels in which that variance is above [`CANDIDATE_VARIANCE`] times V/n². `variances` holds the
/// variances of each pixel's light for one camera path.
fn find_lookup_candidates(variances: &[RelativePixelVariances], samples: u32) -> Vec<bool> {
    let n = f64::from(samples);
    let total: f64 = variances.iter().map(|v| v.from_receiver + v.up_to_receiver).sum();
    let least = CANDIDATE_VARIANCE * total / variances.len() as f64;
    variances.iter().map(|v| v.photon_estimate * n * n > least).collect()
}

/// Renders picture `i` of the prefix-ray pilot (small simulation before the first pass), with one
/// ray in one pixel of each block. Other pixels stay black. `parts` tells which part of a camera
/// path to trace in a pixel, given the index of the pixel by rows from the top.
///
/// The three channels of a pixel hold three parts of its light, each averaged over RGB \[W/(m²
/// sr)]. Channel x is the light at and after the first receiver (surface or medium that stores
/// photons), without photon estimates. Channel y is emission, and direct light at casters, before
/// the receiver. Channel z is the photon estimate.
///
/// In pixels with lamp images (film regions where camera rays meet a small lamp), channel y has the
/// weight that it would have if [`ASSUMED_AIMED_RAYS`] rays were aimed at these lamp images.
fn render_light_parts(
    renderer: &PassRenderer<'_>,
    maps: Option<&PhotonMaps<'_>>,
    lamp_images: &LampImages,
    blocks: &PilotBlocks,
    i: u32,
    parts: impl Fn(usize) -> PathParts + Sync,
) -> FilmImage {
    // No render reaches these passes, so no random number is used twice.
    let pass = u32::MAX - i;
    let pilot = renderer.with_one_sample();
    let (paths, key) = (pilot.path_context(maps, pass), pilot.prefix_ray_key(pass));
    let sampling = FilmSampling { repeats_in_nested_discs: false, ..pilot.film_sampling(pass) };
    let (width, _) = renderer.scene.camera().size();
    let aimed = PixelPrefixRayCounts { aimed: ASSUMED_AIMED_RAYS, ..PixelPrefixRayCounts::default() };
    let weights = LampImageRayCounts::new(renderer.samples_per_pixel, aimed);
    with_interior_type!(pilot.policy.effects, <I> {
        tiles::render_tiles(&sampling, key, &SilentMonitor, |camera_ray, task, branches| {
            let center = camera_ray.weight_lookup_position;
            let pixel = center.y as usize * width as usize + center.x as usize;
            if blocks.traced_pixel(blocks.block_of_pixel(pixel), i) != pixel {
                // The tile has counted this ray, but nothing traces it.
                task.counters.camera_rays -= 1;
                return Rgb::ZERO;
            }
            let parts = parts(pixel);
            let images = lamp_images.of_pixel(pixel);
            let up_to_receiver = if images.is_empty() {
                1.0
            } else {
                sampling.up_to_receiver_weight(images, &weights, center - 0.5, camera_ray.sampler)
            };
            let prefix_weights = PrefixWeights {
                up_to_receiver,
                ends_at_receiver: parts != PathParts::Whole,
                lookup_count: u32::from(parts != PathParts::Prefix),
                ..PrefixWeights::default()
            };
            let camera_ray = CameraRay { prefix_weights, ..*camera_ray };
            let radiance = camera_path::trace_camera_path::<I>(&paths, &camera_ray, task, branches);
            let light = std::mem::take(&mut task.records.light);
            let total = color::channel_mean(radiance);
            let (up_to_receiver, photons) =
                (color::channel_mean(light.up_to_receiver), color::channel_mean(light.photon_estimates));
            Rgb::new((total - up_to_receiver - photons).max(0.0), up_to_receiver, photons)
        })
    })
}

#[cfg(test)]
mod tests;
