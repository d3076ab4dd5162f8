//! Pilot (small simulation before the first pass) for adaptive sampling: it finds how many camera
//! rays each pixel needs.
//!
//! The mean of n rays of a pixel has variance σ²/n. For a given total of rays, the mean relative
//! variance of the pixels is least if n is proportional to σ divided by the pixel's radiance. The
//! pilot estimates σ and the radiance from a few pictures. No pass uses rays of the pilot, so the
//! mean of the passes stays unbiased.

use super::camera_path;
use super::map_builder::MapBuildOptions;
use super::pass::{PassResult, SilentMonitor};
use super::pass_renderer::PassRenderer;
use super::tiles;
use crate::color;
use crate::math::{positive_median, square_mean};
use crate::sampling::{Key, Purpose};
use crate::scene::with_interior_type;
use std::sync::Arc;

/// Number of pictures that the adaptive-sampling pilot renders, with one camera ray per pixel each.
/// Differences between the pictures give the noise of each pixel.
const PILOT_PICTURES: u32 = 4;

/// Number of photon paths of a pass, divided by the number that the adaptive-sampling pilot traces.
const PHOTON_PATH_DIVISOR: u32 = 16;

/// Lower bound on the number of camera rays of a pixel, divided by the mean number over all pixels.
const MIN_RELATIVE_COUNT: f64 = 0.5;

/// Upper bound on the number of camera rays of a pixel, divided by the mean number over all pixels.
const MAX_RELATIVE_COUNT: f64 = 8.0;

/// Runs the adaptive-sampling pilot. Returns the number of camera rays that each pixel needs,
/// divided by the mean over all pixels, by rows from the top. Returns `None` if the pilot's
/// pictures have no noise.
pub(super) fn find_relative_ray_counts(renderer: &PassRenderer<'_>) -> Option<Arc<[f32]>> {
    let key = Key::new(renderer.settings.camera_paths.seed).purpose_key(Purpose::RayPhotonBalance);
    let options = MapBuildOptions::for_pilot(key, PHOTON_PATH_DIVISOR);
    let maps = renderer.map_builder.build(&options, &SilentMonitor, &mut PassResult::default());
    // Moving objects stay at one time, because the pilot does not slice the shutter interval.
    let pilot = renderer.with_one_sample();
    let pictures: Vec<Vec<f64>> = (0..PILOT_PICTURES)
        .map(|i| {
            // No render reaches passes with such high numbers, so no random number is used twice.
            let pass = u32::MAX - i;
            let (paths, sampling, key) =
                (pilot.path_context(Some(&maps), pass), pilot.film_sampling(pass), pilot.camera_path_key(pass));
            let picture = with_interior_type!(pilot.policy.effects, <I> {
                tiles::render_tiles(&sampling, key, &SilentMonitor, |camera_ray, task, branches| {
                    camera_path::trace_camera_path::<I>(&paths, camera_ray, task, branches)
                })
            });
            picture.image.iter().map(|v| f64::from(color::channel_mean(*v))).collect()
        })
        .collect();
    let (width, height) = renderer.scene.camera().size();
    relative_ray_counts(&pictures, width as usize, height as usize, renderer.samples_per_pixel)
}

/// Returns the number of camera rays that each pixel needs for the least mean relative variance,
/// divided by the mean over all pixels; `None` if the `pictures` have no noise.
///
/// `pictures` hold the radiance of each pixel, by rows from the top. They are independent, so their
/// differences are noise. `samples` is the mean number of rays per pixel in a pass.
fn relative_ray_counts(pictures: &[Vec<f64>], width: usize, height: usize, samples: u32) -> Option<Arc<[f32]>> {
    let n = pictures.len() as f64;
    let mean: Vec<f64> =
        (0..width * height).map(|i| pictures.iter().map(|picture| picture[i]).sum::<f64>() / n).collect();
    let variance = |i: usize| {
        let squares = pictures.iter().map(|picture| (picture[i] - mean[i]) * (picture[i] - mean[i]));
        squares.sum::<f64>() / (n - 1.0)
    };
    let variances: Vec<f64> = (0..width * height).map(variance).collect();
    let median = positive_median(mean.iter().copied())?;
    // A few pictures do not measure one pixel well, so means and variances are averaged over
    // neighbours. A small box keeps detail; a larger one includes rare bright samples.
    let box_mean =
        |values: &[f64], i: usize, half_width: usize| square_mean(|i| values[i], i, half_width, (width, height));
    let wanted: Vec<f64> = (0..width * height)
        .map(|i| {
            let light = box_mean(&mean, i, 1);
            let variance = 0.5 * (box_mean(&variances, i, 1) + box_mean(&variances, i, 4));
            let relative = variance / (light * light + median * median);
            if relative.is_finite() { relative.sqrt() } else { 0.0 }
        })
        .collect();
    let largest = wanted.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    // Give every pixel at least one ray.
    let least = MIN_RELATIVE_COUNT.max(1.0 / f64::from(samples));
    let share = |scale: f64, w: f64| (scale * w).clamp(least, MAX_RELATIVE_COUNT);
    let total = |scale: f64| wanted.iter().map(|w| share(scale, *w)).sum::<f64>() / wanted.len() as f64;
    let (mut low, mut high) = (0.0, 1.0 / largest);
    // The scale is the factor from `wanted` to relative ray counts. Raise its upper bound while it
    // leaves rays unused, as happens if few pixels need rays.
    while total(high) < 1.0 && high * largest < MAX_RELATIVE_COUNT * 1e6 {
        high *= 2.0;
    }
    // Bisect for the scale: the mean number of rays grows with it. Sixty steps exhaust double
    // precision.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if total(middle) > 1.0 { high = middle } else { low = middle }
    }
    Some(wanted.iter().map(|w| share(low, *w) as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In pictures that are constant on the left and noisy on the right, pixels on the right get
    /// more rays. The total number of rays stays the same.
    #[test]
    fn noisy_pixels_get_more_rays_of_fixed_total() {
        let (width, height) = (16, 8);
        let picture = |i: u64| {
            let value = |p: usize| {
                let (x, noise) =
                    (p % width, Key::new(i).child_key(p as u64).uniform_1d(crate::sampling::Dimension::Film));
                if x < width / 2 { 1.0 } else { 0.5 + f64::from(noise) }
            };
            (0..width * height).map(value).collect::<Vec<f64>>()
        };
        let pictures: Vec<Vec<f64>> = (0..64).map(picture).collect();
        let shares = relative_ray_counts(&pictures, width, height, 16).unwrap();
        let mean = shares.iter().map(|d| f64::from(*d)).sum::<f64>() / shares.len() as f64;
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
        for (i, share) in shares.iter().enumerate() {
            match i % width {
                0..4 => assert_eq!(*share, MIN_RELATIVE_COUNT as f32),
                // Each pixel of the noisy half gets about 1.5 times the mean number of rays. The
                // estimates of pixels near the middle mix both halves.
                12.. => assert!((1.2..1.6).contains(share), "{i}: {share}"),
                _ => {}
            }
        }
        // With one ray per pixel, no pixel can give one away.
        assert!(relative_ray_counts(&pictures, width, height, 1).unwrap().iter().all(|share| *share == 1.0));
        // Very little noise in one pixel does not change the ray counts of other pixels.
        let mut faint = pictures.clone();
        (0..64).for_each(|i| faint[i][0] = 1.0 + 1e-12 * i as f64);
        assert_eq!(relative_ray_counts(&faint, width, height, 16).unwrap()[20..], shares[20..]);
        assert!(relative_ray_counts(&[vec![1.0; 128], vec![1.0; 128]], width, height, 16).is_none());
        assert!(relative_ray_counts(&[vec![0.0; 128], vec![0.0; 128]], width, height, 16).is_none());
    }
}
