//! Counters of rays and photons, memory limits, and measurement of processor time.
//!
//! Each parallel task has its own counters, which are summed at the end.

mod memory;

pub use memory::{AllocationCounter, MemoryLimit, format_bytes, peak_memory, set_allocation_counter};

use serde::Serialize;
use std::ops::AddAssign;

/// Counts of the work of a render, such as rays and photon density estimates. Also counts samples
/// and photons that were rejected as invalid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Counters {
    /// Number of camera rays through pixels.
    pub camera_rays: u64,
    /// Number of camera path rays after the first: each starts at a surface or at a scattering
    /// event in a medium.
    pub continuation_rays: u64,
    /// Number of shadow rays.
    pub shadow_rays: u64,
    /// Number of rays of photon paths: path segments, and connections from photons to the camera.
    pub photon_rays: u64,
    /// Number of photon density estimates. Each one sums the photons near one point or along one
    /// ray.
    #[serde(rename = "gathers")]
    pub density_estimates: u64,
    /// Number of photons summed by all photon density estimates.
    pub gathered_photons: u64,
    /// Number of camera samples rejected because their radiance was not finite.
    pub rejected_samples: u64,
    /// Number of photons, photon beams and splats that were rejected as invalid: their position or
    /// flux was not finite, or their flux was negative.
    pub rejected_photons: u64,
}

impl AddAssign for Counters {
    fn add_assign(&mut self, o: Self) {
        self.camera_rays += o.camera_rays;
        self.continuation_rays += o.continuation_rays;
        self.shadow_rays += o.shadow_rays;
        self.photon_rays += o.photon_rays;
        self.density_estimates += o.density_estimates;
        self.gathered_photons += o.gathered_photons;
        self.rejected_samples += o.rejected_samples;
        self.rejected_photons += o.rejected_photons;
    }
}

impl Counters {
    /// Returns the sum of all camera, continuation, shadow and photon rays.
    #[must_use]
    pub fn total_rays(&self) -> u64 {
        self.camera_rays + self.continuation_rays + self.shadow_rays + self.photon_rays
    }
}

/// Returns the processor time of all threads of this process so far \[s]; `None` if the system is
/// not Unix.
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
