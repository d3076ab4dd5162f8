//! Division of the shutter interval of a pass into slices.
//!
//! A pass of a moving scene has *slices* of the shutter interval, all of equal length. Each slice
//! has a copy of the scene at one time, its share of the photon paths, and its share of the camera
//! rays. A camera ray meets only photons of its own slice.

use crate::camera::Camera;
use crate::math::gcd;
use crate::sampling::{Dimension, Key, Purpose};

/// Distance on the film that the fastest part of the scene moves during one slice of the shutter
/// interval \[pixels].
///
/// Each pass samples another time within the slice. So after four passes, the positions of the
/// fastest part are about one pixel apart.
pub(super) const SLICE_PIXELS: f32 = 4.0;

/// Largest number of slices of the shutter interval in a pass without photons.
pub(super) const MAX_SLICES: u32 = 64;

/// Largest number of slices of the shutter interval in a pass that traces photons. With more
/// slices, photon maps would take longer to search, and hold too few photons for an estimate.
pub(super) const MAX_PHOTON_SLICES: u32 = 8;

/// One slice of the shutter interval of a pass. A slice has a copy of the scene at one time, with
/// its own photons and camera rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ShutterSlice {
    /// Index of this slice of the shutter interval, in order of time.
    pub index: u32,
    /// Number of slices of the shutter interval in each pass.
    pub count: u32,
}

impl ShutterSlice {
    /// The whole shutter interval as a single slice.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Returns the time of the slice in pass `pass`, as a fraction in \[0, 1) of the shutter
    /// interval.
    ///
    /// The times are stratified: within the slice, the times of the first 2ⁿ passes are equally
    /// spaced.
    pub fn time(self, seed: u64, pass: u32) -> f64 {
        let start = Key::new(seed).purpose_key(Purpose::Shutter).uniform_1d(Dimension::Time);
        let step = f64::from(pass.reverse_bits()) / 4_294_967_296.0;
        let within = f64::from(start) + step;
        (f64::from(self.index) + within - within.floor()) / f64::from(self.count)
    }

    /// Returns the random key of the photon paths of this slice of the shutter interval. `pass_key`
    /// is the key of the whole pass.
    pub fn photon_key(self, pass_key: Key) -> Key {
        if self.count == 1 { pass_key } else { pass_key.shutter_slice_key(self.index) }
    }
}

/// Cameras of all slices of the shutter interval, and the random key for the division of camera
/// rays among the slices.
pub(super) struct SlicedCameras<'a> {
    /// Camera at the time of each slice of the shutter interval.
    pub cameras: Vec<&'a Camera>,
    /// Random key for the division of camera rays among the slices ([`Purpose::Shutter`]).
    pub key: Key,
    pub pass: u32,
}

/// Division of the camera rays of one pixel among the slices of the shutter interval.
///
/// Ray i of n takes stratum i·s mod n of the interval, where the stride s is coprime to n. So the
/// first few rays already spread over the interval. A random offset for each pixel shifts the
/// strata, so each ray takes each slice with the same probability. If there are more slices than
/// rays, neighbouring pixels take different slices.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRaySlices {
    slices: u32,
    rays: u32,
    stride: u32,
    /// Offset of the strata of the shutter interval, in units of a stratum.
    offset: f64,
}

impl PixelRaySlices {
    /// Division of the camera rays of a pass with a single slice of the shutter interval.
    pub const WHOLE: Self = Self { slices: 1, rays: 1, stride: 1, offset: 0.0 };

    /// Returns the number of slices of the shutter interval in which the pixel has at least one
    /// camera ray.
    pub fn used_slice_count(self) -> u32 {
        self.slices.min(self.rays)
    }

    /// Returns the index of the slice of the shutter interval in which camera ray `ray` is traced.
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
    /// Returns how the `rays` camera rays of the pixel in column `x`, row `y` are divided among the
    /// slices of the shutter interval.
    pub fn divide_rays(&self, x: u32, y: u32, rays: u32) -> PixelRaySlices {
        let (key, rays) = (self.key.pixel_key(x, y), rays.max(1));
        // Multiples of the golden ratio shift the strata evenly from pass to pass.
        let shift = f64::from(self.pass.wrapping_mul(0x9e37_79b9)) / 4_294_967_296.0;
        let within = (f64::from(key.uniform_1d(Dimension::Time)) + shift).fract();
        let whole = (key.pass_key(self.pass).uniform_1d(Dimension::Time) * rays as f32).floor();
        PixelRaySlices {
            slices: self.cameras.len() as u32,
            rays,
            stride: spreading_stride(rays),
            offset: f64::from(whole) + within,
        }
    }
}

/// Returns a number coprime to `count`, close to `count` divided by the golden ratio.
fn spreading_stride(count: u32) -> u32 {
    let near = ((u64::from(count) * 0x9e37_79b9) >> 32) as u32;
    (near.max(1)..).find(|stride| gcd(*stride, count) == 1).unwrap_or(1)
}

#[cfg(test)]
mod tests;
