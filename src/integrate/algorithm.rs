//! Names, defaults and effects of the algorithms.

use super::integrator::Integrator;
use super::path_integrator::PathIntegrator;
use super::policy::PolicyFn;
use super::raycast::RayCast;
use super::settings::Settings;
use super::{distributed, hybrid, path, pm, ppm, sppm, whitted};
use crate::plan::{Effect, Effects, Plan};
use crate::scene::Scene;

/// Rendering algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Path tracing for what next-event estimation finds, photons for the rest.
    Hybrid,
    /// Path tracing.
    Path,
    /// Stochastic progressive photon mapping.
    Sppm,
    /// Progressive photon mapping.
    Ppm,
    /// Photon mapping with two maps of fixed radii.
    Pm,
    /// Distributed ray tracing.
    Distributed,
    /// Recursive ray tracing.
    Whitted,
    /// Ray casting with Phong's model, as the course defines it.
    Raycast,
}

impl Algorithm {
    /// All algorithms.
    pub const ALL: [Self; 8] =
        [Self::Hybrid, Self::Path, Self::Sppm, Self::Ppm, Self::Pm, Self::Distributed, Self::Whitted, Self::Raycast];

    /// Name on the command line.
    #[must_use]
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

    /// True if the algorithm traces photons.
    #[must_use]
    pub fn has_photons(self) -> bool {
        match self {
            Self::Hybrid | Self::Sppm | Self::Ppm | Self::Pm => true,
            Self::Path | Self::Distributed | Self::Whitted | Self::Raycast => false,
        }
    }

    /// Default number of passes.
    #[must_use]
    pub fn passes(self) -> u32 {
        match self {
            Self::Hybrid | Self::Distributed | Self::Whitted => 16,
            Self::Path => 32,
            Self::Sppm | Self::Ppm | Self::Pm => 20,
            Self::Raycast => 1,
        }
    }

    /// Effects that the algorithm can simulate.
    #[must_use]
    pub fn simulates(self) -> Effects {
        use Effect::{
            Bump, CausticBounces, Caustics, Dispersion, Environment, Gathering, Interiors, Interreflection, Lens,
            Media, Motion, Shadows, SoftShadows, Specular, Textures,
        };
        const RAYCAST: Effects = Effects::from_list(&[Textures, Bump]);
        const WHITTED: Effects = RAYCAST.with(Specular).with(Shadows).with(Environment).with(Interiors);
        const DISTRIBUTED: Effects = WHITTED.with(SoftShadows).with(Lens).with(Motion).with(Media).with(Dispersion);
        const PATH: Effects = DISTRIBUTED.with(Interreflection).with(Caustics);
        const PHOTONS: Effects = PATH.with(CausticBounces);
        match self {
            Self::Raycast => RAYCAST,
            Self::Whitted => WHITTED,
            Self::Distributed => DISTRIBUTED,
            Self::Path => PATH,
            Self::Hybrid | Self::Sppm | Self::Ppm => PHOTONS,
            Self::Pm => PHOTONS.with(Gathering),
        }
    }

    /// Prepares the algorithm for `scene`. Pilots find the settings that are not set.
    #[must_use]
    pub fn prepare(self, scene: &Scene, settings: Settings) -> Box<dyn Integrator + '_> {
        let plan = Plan::new(scene, self.simulates(), settings.camera_paths.effects);
        let policy: PolicyFn = match self {
            Self::Hybrid => hybrid::policy,
            Self::Path => path::policy,
            Self::Sppm => sppm::policy,
            Self::Ppm => ppm::policy,
            Self::Pm => pm::policy,
            Self::Distributed => distributed::policy,
            Self::Whitted => whitted::policy,
            Self::Raycast => return Box::new(RayCast::new(scene, plan, &settings.camera_paths)),
        };
        Box::new(PathIntegrator::new(scene, plan, settings, policy))
    }
}
