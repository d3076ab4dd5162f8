//! Division of the shutter interval of a pass into slices.
//!
//! A pass of a moving scene has *slices* of the shutter interval, all of equal length. Each slice
//! has a copy of the scene at one time, its share of the photon paths, and its share of the camera
//! rays. A camera ray meets only photons of its own slice.

use super::pass_renderer::PassRenderer;
use crate::camera::Camera;
use crate::math::gcd;
use crate::sampling::{Dimension, Key, Purpose};

/// Way on the film that the fastest part of the scene moves in one slice \[pixels]. The times of
/// passes interleave, so the mean of four passes has one position for each pixel.
const SLICE_PIXELS: f32 = 4.0;

/// Largest number of slices of a pass.
const MAX_SLICES: u32 = 64;

/// Largest number of slices of a pass that traces photons. The photon maps of more slices would
/// cost more to search, and hold too few photons for an estimate.
const MAX_PHOTON_SLICES: u32 = 8;

/// One slice of the shutter interval of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ShutterSlice {
    /// Index of the slice.
    pub index: u32,
    /// Number of slices of the pass.
    pub count: u32,
}

impl ShutterSlice {
    /// The whole shutter interval.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Returns the time of the slice in pass `pass`, in \[0, 1).
    ///
    /// The times are stratified: the first 2ⁿ passes divide each slice into equal steps.
    pub fn time(self, seed: u64, pass: u32) -> f64 {
        let start = Key::new(seed).purpose_key(Purpose::Shutter).uniform_1d(Dimension::Time);
        let step = f64::from(pass.reverse_bits()) / 4_294_967_296.0;
        let within = f64::from(start) + step;
        (f64::from(self.index) + within - within.floor()) / f64::from(self.count)
    }

    /// Returns the random key of the photon paths of this slice, from that of the pass.
    pub fn photon_key(self, pass_key: Key) -> Key {
        if self.count == 1 { pass_key } else { pass_key.shutter_slice_key(self.index) }
    }
}

/// Cameras of the slices of a pass, and the key by which camera rays are divided among them.
pub(super) struct SlicedCameras<'a> {
    /// The camera of each slice.
    pub cameras: Vec<&'a Camera>,
    /// Random key of purpose [`Purpose::Shutter`].
    pub key: Key,
    pub pass: u32,
}

/// Division of the camera rays of one pixel among the slices of a pass.
///
/// Ray i of n takes stratum i·s mod n of the shutter interval, where s is coprime to n. So the
/// first rays spread over the interval. The strata are shifted by an offset that each pixel draws
/// for itself. So each ray takes each slice with the same probability, and if there are more
/// slices than rays, neighbouring pixels take different ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaySlices {
    slices: u32,
    rays: u32,
    stride: u32,
    /// Offset of the strata \[strata].
    offset: f64,
}

impl RaySlices {
    /// Division of the rays of a pass with one slice.
    pub const WHOLE: Self = Self { slices: 1, rays: 1, stride: 1, offset: 0.0 };

    /// Returns the number of slices among which `rays` rays of a pixel are divided.
    pub fn distinct(self) -> u32 {
        self.slices.min(self.rays)
    }

    /// Returns the slice of ray `ray`.
    #[inline]
    pub fn slice(self, ray: u32) -> usize {
        if self.slices == 1 {
            return 0;
        }
        let stratum = u64::from(ray) * u64::from(self.stride) % u64::from(self.rays);
        let time = (stratum as f64 + self.offset) / f64::from(self.rays);
        ((time.fract() * f64::from(self.slices)) as u32).min(self.slices - 1) as usize
    }
}

impl SlicedCameras<'_> {
    /// Returns the division of the `rays` rays of the pixel in column `x`, row `y`.
    pub fn divide_rays(&self, x: u32, y: u32, rays: u32) -> RaySlices {
        let (key, rays) = (self.key.pixel_key(x, y), rays.max(1));
        // Multiples of the golden ratio shift the strata evenly from pass to pass.
        let shift = f64::from(self.pass.wrapping_mul(0x9e37_79b9)) / 4_294_967_296.0;
        let within = (f64::from(key.uniform_1d(Dimension::Time)) + shift).fract();
        let whole = (key.pass_key(self.pass).uniform_1d(Dimension::Time) * rays as f32).floor();
        RaySlices {
            slices: self.cameras.len() as u32,
            rays,
            stride: spreading_stride(rays),
            offset: f64::from(whole) + within,
        }
    }
}

/// Returns a number coprime to `count`, near `count` over the golden ratio.
fn spreading_stride(count: u32) -> u32 {
    let near = ((u64::from(count) * 0x9e37_79b9) >> 32) as u32;
    (near.max(1)..).find(|stride| gcd(*stride, count) == 1).unwrap_or(1)
}

/// Returns the number of slices of each pass of `renderer`: one for each [`SLICE_PIXELS`] pixels
/// that things move, as far as cost allows; 1 if nothing moves.
pub(super) fn find_slice_count(renderer: &PassRenderer<'_>) -> u32 {
    if !renderer.has_motion() {
        return 1;
    }
    let scene = renderer.scene;
    let wanted = (scene.motion_on_film() / SLICE_PIXELS).ceil();
    // Placing a moving part must not cost more than tracing a camera ray.
    let (width, height) = scene.camera().size();
    let rays = u64::from(width) * u64::from(height) * u64::from(renderer.samples);
    let affordable = rays / (scene.unshared_part_count() as u64).max(1);
    let samples = renderer.samples;
    let most = if !renderer.map_builder.traces_photons() {
        MAX_SLICES
    } else if renderer.policy.reads_photons_each_sample() {
        // All indirect light is that of photons, and a ray meets those of its slice only.
        samples.min(MAX_PHOTON_SLICES)
    } else {
        samples.saturating_mul(2).min(MAX_PHOTON_SLICES)
    };
    (wanted as u32).min(most).min(u32::try_from(affordable).unwrap_or(u32::MAX)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Returns the number of rays in each slice, over the pixels of a picture of 64 × 64 pixels.
    fn rays_in_slices(slices: usize, rays: u32, pass: u32) -> (Vec<u32>, bool) {
        let camera = Camera::orthographic(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 1.0, 64, 64).unwrap();
        let key = Key::new(5).purpose_key(Purpose::Shutter);
        let cameras = SlicedCameras { cameras: vec![&camera; slices], key, pass };
        let (mut all, mut distinct) = (vec![0; slices], true);
        for pixel in 0..64 * 64 {
            let division = cameras.divide_rays(pixel % 64, pixel / 64, rays);
            let mut own = vec![0; slices];
            (0..rays).for_each(|ray| own[division.slice(ray)] += 1);
            distinct &= own.iter().filter(|n| **n > 0).count() == division.distinct() as usize;
            all.iter_mut().zip(own).for_each(|(sum, n)| *sum += n);
        }
        (all, distinct)
    }

    /// Each pixel has rays in as many slices as possible. The share of a slice that pixels draw by
    /// chance has a variance of at most ¼ per pixel.
    #[test]
    fn slices_share_the_rays_of_each_pixel() {
        for (slices, rays, pass) in [(8, 8, 0), (4, 8, 3), (32, 8, 1), (8, 2, 9), (7, 15, 2), (64, 1, 4)] {
            let (all, distinct) = rays_in_slices(slices, rays, pass);
            assert!(distinct, "{slices} slices, {rays} rays");
            let expected = 4096.0 * f64::from(rays) / slices as f64;
            let tolerance = if (rays as usize).is_multiple_of(slices) { 0.0 } else { 5.0 * (0.25 * 4096.0f64).sqrt() };
            assert!(all.iter().all(|n| (f64::from(*n) - expected).abs() <= tolerance), "{all:?}");
        }
    }

    #[test]
    fn slice_times_of_passes_interleave() {
        let times = |count: u32, passes: u32| {
            let slice = |i: u32| ShutterSlice { index: i % count, count }.time(3, i / count);
            let mut times: Vec<f64> = (0..count * passes).map(slice).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        for (count, passes) in [(1, 8), (5, 4), (8, 16)] {
            let step = 1.0 / f64::from(count * passes);
            for pair in times(count, passes).windows(2) {
                assert!((pair[1] - pair[0] - step).abs() < 1e-12, "{count} {passes}: {pair:?}");
            }
        }
    }
}
