//! The rendering algorithms: their names, default numbers of passes and supported effects of light.

use super::integrator::Integrator;
use super::path_integrator::PathIntegrator;
use super::policy::PolicyFn;
use super::raycast::RaycastIntegrator;
use super::settings::Settings;
use super::{distributed, hybrid, path, pm, ppm, sppm, whitted};
use crate::plan::Plan;
use crate::scene::{Effect, Effects, Scene};

enum_with_all! {
    /// Rendering algorithm, the value of the option `--integrator`.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Algorithm {
        /// Path tracing with next-event estimation. Photons carry caustics and the light that
        /// surfaces reflect after a caustic. By default, photons also carry a part of the other
        /// indirect light.
        Hybrid,
        /// Path tracing with next-event estimation, without photons.
        Path,
        /// Stochastic progressive photon mapping (Hachisuka and Jensen 2009). Gather radii shrink
        /// from pass to pass, and each pass traces other camera paths.
        Sppm,
        /// Progressive photon mapping (Hachisuka, Ogaki and Jensen 2008). Gather radii shrink from
        /// pass to pass, and all passes trace the same camera paths.
        Ppm,
        /// Photon mapping with an indirect map (Jensen's global map) and a caustic map. Gather
        /// radii stay fixed over the passes.
        Pm,
        /// Distributed ray tracing (Cook, Porter and Carpenter 1984).
        Distributed,
        /// Recursive ray tracing (Whitted 1980).
        Whitted,
        /// Ray casting with Phong's shading model and without shadows, as in MIT course 6.837.
        Raycast,
    }
}

impl Algorithm {
    /// Returns the algorithm's name on the command line, such as `sppm`.
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
    pub fn traces_photons(self) -> bool {
        match self {
            Self::Hybrid | Self::Sppm | Self::Ppm | Self::Pm => true,
            Self::Path | Self::Distributed | Self::Whitted | Self::Raycast => false,
        }
    }

    /// Returns the default number of passes of a render. The default applies if a render limits
    /// neither its passes nor its time, and does not estimate its error. Ray casting makes this
    /// number of passes even with a time limit.
    #[must_use]
    pub fn default_passes(self) -> u32 {
        match self {
            Self::Hybrid | Self::Distributed | Self::Whitted => 16,
            Self::Path => 32,
            Self::Sppm | Self::Ppm | Self::Pm => 20,
            Self::Raycast => 1,
        }
    }

    /// Returns the effects of light that the algorithm can simulate.
    #[must_use]
    pub fn supported_effects(self) -> Effects {
        use Effect::{
            Bump, CausticBounces, Caustics, Dispersion, Environment, Gathering, Interiors, Interreflection, Lens,
            Media, Motion, Shadows, SoftShadows, Specular, Textures,
        };
        const RAYCAST: Effects = Effects::from_list(&[Textures, Bump]);
        const WHITTED: Effects =
            RAYCAST.with_effect(Specular).with_effect(Shadows).with_effect(Environment).with_effect(Interiors);
        const DISTRIBUTED: Effects = WHITTED
            .with_effect(SoftShadows)
            .with_effect(Lens)
            .with_effect(Motion)
            .with_effect(Media)
            .with_effect(Dispersion);
        const PATH: Effects = DISTRIBUTED.with_effect(Interreflection).with_effect(Caustics);
        const PHOTONS: Effects = PATH.with_effect(CausticBounces);
        match self {
            Self::Raycast => RAYCAST,
            Self::Whitted => WHITTED,
            Self::Distributed => DISTRIBUTED,
            Self::Path => PATH,
            Self::Hybrid | Self::Sppm | Self::Ppm => PHOTONS,
            Self::Pm => PHOTONS.with_effect(Gathering),
        }
    }

    /// Makes the integrator that renders `scene` with this algorithm, and runs its pilots: small
    /// simulations before the first pass.
    ///
    /// Settings that are `None` get the algorithm's default, or a value that a pilot finds.
    #[must_use]
    pub fn prepare(self, scene: &Scene, settings: Settings) -> Box<dyn Integrator + '_> {
        let plan = Plan::new(scene, self.supported_effects(), settings.camera_paths.effects);
        let policy: PolicyFn = match self {
            Self::Hybrid => hybrid::path_policy,
            Self::Path => path::path_policy,
            Self::Sppm => sppm::path_policy,
            Self::Ppm => ppm::path_policy,
            Self::Pm => pm::path_policy,
            Self::Distributed => distributed::path_policy,
            Self::Whitted => whitted::path_policy,
            Self::Raycast => return Box::new(RaycastIntegrator::new(scene, plan, &settings.camera_paths)),
        };
        Box::new(PathIntegrator::new(scene, plan, settings, policy))
    }
}
