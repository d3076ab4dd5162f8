//! Settings of all algorithms.

use super::radius_law::ALPHA;
use super::volume_estimate::VolumeEstimate;
use crate::camera::{Filter, FilterKind};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;

/// Settings of camera paths.
#[derive(Clone, Debug)]
pub struct CameraPathSettings {
    /// Camera rays per pixel and pass; `None` uses the default of the algorithm.
    pub samples: Option<u32>,
    /// Bounces after which a path ends.
    pub max_bounces: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Reconstruction filter.
    pub filter: Filter,
    /// True if a pilot distributes camera rays over the pixels by their noise.
    pub adaptive: bool,
    /// True if passes return nested photon estimates, for error estimation. The picture stays the
    /// same.
    pub estimate_error: bool,
    /// Effects forced on or off against the plan.
    pub effects: EffectOverrides,
}

impl Default for CameraPathSettings {
    fn default() -> Self {
        Self {
            samples: None,
            max_bounces: 100,
            seed: 0,
            filter: Filter::new(FilterKind::default()),
            adaptive: false,
            estimate_error: false,
            effects: EffectOverrides::PLANNED,
        }
    }
}

/// All settings. Algorithms without photons use those of camera paths alone.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Settings of camera paths.
    pub camera_paths: CameraPathSettings,
    /// Photon paths of the global map per pass.
    pub photons: u32,
    /// Photon paths aimed at caustic casters per pass.
    pub caustic_photons: u32,
    /// True if a pilot may trade camera rays for photon paths, to get less noise for the same work.
    ///
    /// The three counts above then are starting values.
    pub balance: bool,
    /// Limit on the photons of an estimate, 0 for no limit.
    ///
    /// `None` sets [`CAUSTIC_K`](super::CAUSTIC_K) in the caustic map, and no limit in the global
    /// global map. The last photon only bounds the disc, so 1 counts as 2.
    pub gather_k: Option<u32>,
    /// Largest gather radius of the first pass \[length]; `None` lets a pilot find one for each
    /// map.
    pub radius: Option<f32>,
    /// Exponent of the radius law in (0, 1]; 1 keeps radii fixed.
    /// [`Algorithm::Pm`](super::Algorithm::Pm) ignores it.
    pub alpha: f64,
    /// Kernel of the estimates.
    pub kernel: Kernel,
    /// Estimator of photon light in media.
    pub volume: VolumeEstimate,
    /// How [`Algorithm::Pm`](super::Algorithm::Pm) reads the global map.
    pub final_gathering: FinalGathering,
}

/// Lookup of the global map in photon mapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FinalGathering {
    /// Direct visualization: lookup at the first receiver.
    None,
    /// Lookup at the end of a gather ray, sampled by the BSDF.
    #[default]
    Bsdf,
    /// Lookup at the end of a gather ray, sampled in equal parts by the BSDF and by the directions
    /// of nearby photons.
    Importance,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            camera_paths: CameraPathSettings::default(),
            photons: 500_000,
            caustic_photons: 250_000,
            balance: true,
            gather_k: None,
            radius: None,
            alpha: ALPHA,
            kernel: Kernel::default(),
            volume: VolumeEstimate::default(),
            final_gathering: FinalGathering::default(),
        }
    }
}
