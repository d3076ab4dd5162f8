//! Random key, pass and number of photon paths for building photon maps.

use crate::integrate::shutter::ShutterSlice;
use crate::sampling::{Key, Purpose};

/// Smallest limit k on the number of photons of a density estimate, for passes and pilots.
///
/// The k-th nearest photon only sets the radius, so k = 1 gives no density.
const MIN_PHOTON_LIMIT: u32 = 2;

/// Numbers of photon paths of a pass: paths that start in all directions, and paths aimed at
/// casters, such as mirrors and glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::integrate) struct PhotonPathCounts {
    /// Number of paths that start in all directions.
    pub unaimed: u32,
    /// Number of paths aimed at casters, such as mirrors and glass.
    pub aimed: u32,
}

impl PhotonPathCounts {
    /// Returns the numbers of photon paths divided by `divisor`, rounded up.
    pub fn divided_by(self, divisor: u32) -> Self {
        Self { unaimed: self.unaimed.div_ceil(divisor), aimed: self.aimed.div_ceil(divisor) }
    }
}

/// Returns the limit on the number of photons of a density estimate when only 1/`divisor` of a
/// pass's photon paths are traced; 0 for no limit.
///
/// `k` is the limit when all photon paths of the pass are traced.
pub(super) fn photon_limit(k: u32, divisor: u32) -> u32 {
    if k == 0 { 0 } else { k.div_ceil(divisor).max(MIN_PHOTON_LIMIT) }
}

/// Options for building photon maps, for a pass or for a pilot (small simulation before the first
/// pass): random key, pass number and number of photon paths.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrate) struct MapBuildOptions {
    /// Random key from which the keys of all photon paths derive.
    pub key: Key,
    /// Number of the pass, counted from 0.
    pub pass: u32,
    /// Divisor d of the number of photon paths: 1/d of a pass's photon paths are traced. For a
    /// whole pass, d is 1; for a pilot or a slice of the shutter interval, d is larger.
    pub photon_path_divisor: u32,
    /// Slice of the shutter interval in which photons are traced.
    pub slice: ShutterSlice,
    /// True if density estimates use at most the k nearest photons; false if they use all photons
    /// within the gather radius.
    pub has_photon_limit: bool,
    /// True if light tracing connects caustic photons to the camera.
    pub connects_to_camera: bool,
}

impl MapBuildOptions {
    /// Returns the options of slice `slice` (a part of the shutter interval) of pass `pass`, in a
    /// render with random seed `seed`.
    ///
    /// All slices use the gather radii of the whole pass. So the mean of their estimates has the
    /// noise and bias of one estimate from the photons of all slices.
    pub fn for_slice(seed: u64, pass: u32, slice: ShutterSlice) -> Self {
        let (key, divisor) = (Key::new(seed), slice.count);
        Self { key, pass, photon_path_divisor: divisor, slice, has_photon_limit: true, connects_to_camera: true }
    }

    /// Returns the options of a pilot (small simulation before the first pass). The pilot traces
    /// 1/`divisor` of the photon paths of the first pass, and connects no photons to the camera.
    pub fn for_pilot(key: Key, divisor: u32) -> Self {
        Self {
            key,
            pass: 0,
            photon_path_divisor: divisor,
            slice: ShutterSlice::WHOLE,
            has_photon_limit: true,
            connects_to_camera: false,
        }
    }

    /// Returns the random key of the photon paths that are traced for `purpose` in this pass.
    pub(super) fn photon_path_key(&self, purpose: Purpose) -> Key {
        self.slice.photon_key(self.key.purpose_key(purpose).pass_key(self.pass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_photon_limits_are_at_least_two() {
        assert_eq!([0, 1, 2, 5, 50].map(|k| photon_limit(k, 4)), [0, 2, 2, 2, 13]);
        assert_eq!([0, 2, 50].map(|k| photon_limit(k, 1)), [0, 2, 50]);
    }
}
