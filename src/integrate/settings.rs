//! What a user may set.

use super::{ALPHA, VolumeEstimate};
use crate::camera::{Filter, FilterKind};
use crate::photon::Kernel;
use crate::plan::EffectOverrides;

/// Settings of the camera walk.
#[derive(Clone, Debug)]
pub struct EyeSettings {
    /// Camera rays a pixel and pass; `None`: what suits the algorithm.
    pub samples: Option<u32>,
    /// Bounces after which a path is cut.
    pub max_bounces: u32,
    /// Seed of all randomness.
    pub seed: u64,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Whether pixels get camera rays in proportion to their noise, as a pilot sees it.
    pub adaptive: bool,
    /// Whether passes tell of the error of their estimates. The picture is the same.
    pub gauge: bool,
    /// Effects that are simulated or left out whatever the scene calls for.
    pub effects: EffectOverrides,
}

impl Default for EyeSettings {
    fn default() -> Self {
        Self {
            samples: None,
            max_bounces: 100,
            seed: 0,
            filter: Filter::new(FilterKind::default()),
            adaptive: false,
            gauge: false,
            effects: EffectOverrides::PLANNED,
        }
    }
}

/// All settings; algorithms without photons use those of the camera walk alone.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Settings of the camera walk.
    pub eye: EyeSettings,
    /// Paths of the global map a pass.
    pub photons: u32,
    /// Paths aimed at casters a pass.
    pub caustic_photons: u32,
    /// Whether a pilot may change camera rays and photon paths so that the same work gives less noise. Numbers that the user
    /// sets stay only without.
    pub balance: bool,
    /// Most photons an estimate takes, 0 for no limit; `None`: [`CAUSTIC_K`](super::CAUSTIC_K) in the caustic map, no limit in the
    /// global one, whose light is smooth. The last only bounds the disc, so 1 counts as 2.
    pub gather_k: Option<u32>,
    /// Largest radius of the first pass \[length]; `None` lets a pilot find one for each map.
    pub radius: Option<f32>,
    /// How fast radii shrink from pass to pass, in (0, 1]; 1: not at all. Those of [`Algorithm::Pm`](super::Algorithm::Pm) stay anyway.
    pub alpha: f64,
    /// Kernel of the estimates.
    pub kernel: Kernel,
    /// How light in media is estimated from photons.
    pub volume: VolumeEstimate,
    /// How [`Algorithm::Pm`](super::Algorithm::Pm) looks at the global map.
    pub final_gathering: FinalGathering,
}

/// How a global map is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FinalGathering {
    /// Directly at the first receiver.
    None,
    /// Through a gather ray, drawn from the BSDF.
    #[default]
    Bsdf,
    /// Through a gather ray, drawn in equal parts from the BSDF and from where the photons around came from.
    Importance,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            eye: EyeSettings::default(),
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
