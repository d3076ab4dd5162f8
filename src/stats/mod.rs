//! What a render did, by counters kept by each worker and added once, so that counting costs nothing between threads; and what memory
//! it may take.

mod memory;

pub use memory::{Memory, bytes, peak_memory};

use serde::Serialize;
use std::ops::AddAssign;

/// Work, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Rays through pixels.
    pub camera_rays: u64,
    /// Rays that continue a camera walk.
    pub onward_rays: u64,
    /// Rays towards lights.
    pub shadow_rays: u64,
    /// Rays of photons.
    pub photon_rays: u64,
    /// Density estimates.
    pub gathers: u64,
    /// Photons in them.
    pub gathered_photons: u64,
    /// Samples that were not finite and were left out.
    pub rejected_samples: u64,
    /// Photons that were not finite and were left out.
    pub rejected_photons: u64,
}

impl AddAssign for Counters {
    fn add_assign(&mut self, o: Self) {
        self.camera_rays += o.camera_rays;
        self.onward_rays += o.onward_rays;
        self.shadow_rays += o.shadow_rays;
        self.photon_rays += o.photon_rays;
        self.gathers += o.gathers;
        self.gathered_photons += o.gathered_photons;
        self.rejected_samples += o.rejected_samples;
        self.rejected_photons += o.rejected_photons;
    }
}

impl Counters {
    /// All rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.onward_rays + self.shadow_rays + self.photon_rays
    }
}

/// Processor time of all threads so far \[s], where the system tells (Unix).
#[must_use]
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}
