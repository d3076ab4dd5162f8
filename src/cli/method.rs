//! The algorithm that the command line names.

use super::RenderArguments;
use super::args::{GatheringName, IntegratorName};
use crate::camera::Filter;
use crate::integrate::{
    Distributed, EyeSettings, FinalGathering, Hybrid, Integrator, PathTracing, PhotonMapping, PhotonSettings, Ppm,
    RayCast, Sppm, Whitted,
};
use crate::scene::Scene;

impl IntegratorName {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hybrid => "hybrid",
            Self::Path => "path",
            Self::Sppm => "sppm",
            Self::Ppm => "ppm",
            Self::Pm => "pm",
            Self::Distributed => "distributed",
            Self::Whitted => "whitted",
            Self::Raycast => "raycast",
        }
    }

    /// Whether it traces photons.
    pub fn has_photons(self) -> bool {
        matches!(self, Self::Hybrid | Self::Sppm | Self::Ppm | Self::Pm)
    }

    /// Passes where neither passes nor time are given.
    pub fn passes(self) -> u32 {
        match self {
            Self::Hybrid => 16,
            Self::Path => 32,
            Self::Sppm | Self::Ppm | Self::Pm => 20,
            Self::Distributed | Self::Whitted => 16,
            Self::Raycast => 1,
        }
    }
}

/// Prepares the algorithm for a scene.
pub(super) fn prepare<'a>(arguments: &RenderArguments, scene: &'a Scene) -> Box<dyn Integrator + 'a> {
    match arguments.integrator {
        IntegratorName::Hybrid => Box::new(Hybrid::new(scene, photon_settings(arguments))),
        IntegratorName::Path => Box::new(PathTracing::new(scene, eye_settings(arguments))),
        IntegratorName::Sppm => Box::new(Sppm::new(scene, photon_settings(arguments))),
        IntegratorName::Ppm => Box::new(Ppm::new(scene, photon_settings(arguments))),
        IntegratorName::Pm => Box::new(PhotonMapping::new(scene, photon_settings(arguments))),
        IntegratorName::Distributed => Box::new(Distributed::new(scene, eye_settings(arguments))),
        IntegratorName::Whitted => Box::new(Whitted::new(scene, eye_settings(arguments))),
        IntegratorName::Raycast => {
            let filter = arguments.spp.filter(|n| *n > 1).map(|_| Filter::new(arguments.filter));
            Box::new(RayCast { scene, filter, samples: arguments.spp.unwrap_or(1), seed: arguments.seed })
        }
    }
}

fn eye_settings(arguments: &RenderArguments) -> EyeSettings {
    EyeSettings {
        samples: arguments.spp,
        max_bounces: arguments.max_bounces,
        seed: arguments.seed,
        filter: Filter::new(arguments.filter),
    }
}

pub(super) fn photon_settings(arguments: &RenderArguments) -> PhotonSettings {
    PhotonSettings {
        eye: eye_settings(arguments),
        photons: arguments.photons,
        caustic_photons: arguments.caustic_photons.unwrap_or(arguments.photons / 2),
        gather_k: arguments.gather_k,
        radius: arguments.radius,
        kernel: arguments.kernel,
        final_gathering: match arguments.final_gathering {
            GatheringName::None => FinalGathering::None,
            GatheringName::Bsdf => FinalGathering::Bsdf,
            GatheringName::Importance => FinalGathering::Importance,
        },
    }
}
