//! The algorithms by name.

use super::prepared::{Prepared, Strategy};
use super::raycast::RayCast;
use super::{Integrator, Settings, distributed, hybrid, path, pm, ppm, sppm, whitted};
use crate::plan::{Effect, Effects, Plan};
use crate::scene::Scene;
use std::sync::Arc;

/// An algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Path tracing for what connections find, photons for the rest.
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
    /// Ray tracing.
    Whitted,
    /// Ray casting with Phong's model.
    Raycast,
}

impl Algorithm {
    /// All of them.
    pub const ALL: [Self; 8] =
        [Self::Hybrid, Self::Path, Self::Sppm, Self::Ppm, Self::Pm, Self::Distributed, Self::Whitted, Self::Raycast];

    /// As typed.
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

    /// Whether it traces photons.
    #[must_use]
    pub fn has_photons(self) -> bool {
        matches!(self, Self::Hybrid | Self::Sppm | Self::Ppm | Self::Pm)
    }

    /// Passes that make a picture, where the user does not say.
    #[must_use]
    pub fn passes(self) -> u32 {
        match self {
            Self::Hybrid | Self::Distributed | Self::Whitted => 16,
            Self::Path => 32,
            Self::Sppm | Self::Ppm | Self::Pm => 20,
            Self::Raycast => 1,
        }
    }

    /// The effects that it can simulate.
    #[must_use]
    pub fn simulates(self) -> Effects {
        use Effect::{
            Bump, CausticBounces, Caustics, Dispersion, Environment, Gathering, Interiors, Interreflection, Lens,
            Media, Motion, Shadows, SoftShadows, Specular, Textures,
        };
        const RAYCAST: Effects = Effects::of(&[Textures, Bump]);
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

    /// Weighs the lights of a scene and finds by pilots what is not set.
    #[must_use]
    pub fn prepare(self, scene: &Scene, settings: Settings) -> Box<dyn Integrator + '_> {
        let plan = Plan::new(scene, self.simulates(), settings.eye.effects);
        let strategy: Arc<dyn Strategy> = match self {
            Self::Hybrid => Arc::new(hybrid::Hybrid),
            Self::Path => Arc::new(path::PathTracing),
            Self::Sppm => Arc::new(sppm::Sppm),
            Self::Ppm => Arc::new(ppm::Ppm),
            Self::Pm => Arc::new(pm::PhotonMapping { gathering: settings.final_gathering }),
            Self::Distributed => Arc::new(distributed::Distributed),
            Self::Whitted => Arc::new(whitted::Whitted),
            Self::Raycast => return Box::new(RayCast::new(scene, plan, &settings.eye)),
        };
        Box::new(Prepared::new(scene, plan, settings, strategy))
    }
}
