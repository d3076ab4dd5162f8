//! The values that tell algorithms apart.
//!
//! A [`PathPolicy`] says what a camera path does at its vertices. Each algorithm's file makes one
//! from the effects of the plan. Everything else follows from the policy: see
//! [`PathPolicy::photon_maps`].

use super::settings::Settings;
use crate::photon::StoreMask;
use crate::plan::{Effect, Effects};

/// Makes the policy of an algorithm for a set of simulated effects.
pub(super) type PolicyFn = fn(Effects, &Settings) -> PathPolicy;

/// Rules of an algorithm for camera paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathPolicy {
    /// Effects to simulate, as the plan decided.
    pub effects: Effects,
    /// Camera rays per pixel and pass by default.
    pub samples: u32,
    /// True if every pass traces the same camera paths.
    pub shares_paths: bool,
    /// True if vertices do next-event estimation.
    pub direct_light: bool,
    /// How next-event estimation chooses its shadow rays.
    pub light_sampling: LightSampling,
    /// Receivers at which a path continues.
    pub continuation: Continuation,
    /// Direction sampling at receivers.
    pub directions: DirectionSampling,
    /// True if a path also counts emission that reaches it as a caustic; false leaves caustics to
    /// photons.
    pub counts_caustics: bool,
    /// Throughput below which a path ends; 0 uses Russian roulette instead.
    pub min_throughput: f32,
    /// Photon lookups of a path.
    pub photons: PhotonLookups,
    /// True if gather radii shrink from pass to pass.
    pub shrinking_radii: bool,
}

/// Rule by which next-event estimation chooses shadow rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightSampling {
    /// This many shadow rays per vertex.
    Rays(u32),
    /// One shadow ray per vertex. If the scene has few lights, one per light before the first
    /// receiver.
    OneRay,
    /// One shadow ray to the center of every light.
    Centers,
}

/// Receivers at which a path continues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Continuation {
    /// None: a path ends at its first receiver.
    Never,
    /// Receivers whose sampled lobe is not diffuse.
    Glossy,
    /// The first receiver, and those at the end of a gather ray too short to read the global map.
    GatherRays,
    /// All receivers and scattering events in media.
    Always,
}

/// Direction sampling at receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DirectionSampling {
    /// By the BSDF.
    Bsdf,
    /// By one stochastically chosen lobe of the BSDF, which alone is evaluated.
    OneLobe,
    /// In equal parts by the BSDF and by the directions of nearby photons.
    Guided,
}

/// Photon lookups of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PhotonLookups {
    /// None.
    Never,
    /// The caustic map and the map of light after caustics, at the first receiver, by one sample of
    /// each pixel.
    ///
    /// The other samples of the pixel would read the same photons.
    OncePerPixel,
    /// The caustic map and the global map, at the first receiver.
    FirstReceiver,
    /// The caustic map before a gather ray, both maps at its end.
    GatherRays,
    /// No lookup. Each first receiver is recorded as a visible point, for a pilot.
    RecordVisible,
}

/// Photon maps that a policy reads, as the photons to store from each source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MapRequest {
    /// Photons to store from paths aimed at caustic casters.
    pub aimed: StoreMask,
    /// Photons to store from paths in all directions.
    pub global: StoreMask,
    /// True if photons are needed that guide gather rays.
    pub guides: bool,
}

impl PathPolicy {
    /// True if paths estimate radiance from photons.
    pub fn reads_photons(&self) -> bool {
        match self.photons {
            PhotonLookups::OncePerPixel | PhotonLookups::FirstReceiver | PhotonLookups::GatherRays => true,
            PhotonLookups::Never | PhotonLookups::RecordVisible => false,
        }
    }

    /// True if every camera path estimates radiance from photons, false if one per pixel does.
    pub fn reads_photons_each_sample(&self) -> bool {
        self.photons != PhotonLookups::OncePerPixel
    }

    /// True if the numbers of camera rays and photons may be traded for each other.
    pub fn can_be_balanced(&self) -> bool {
        !self.shares_paths
    }

    /// The photon maps that this policy reads, without the light of effects that are off.
    pub fn photon_maps(&self) -> MapRequest {
        let caustics = self.effects.has(Effect::Caustics);
        let bounces = self.effects.has(Effect::CausticBounces);
        let interreflection = self.effects.has(Effect::Interreflection);
        let global = |direct: bool| StoreMask {
            direct: direct && interreflection,
            after_caustic: bounces,
            global: interreflection,
            ..StoreMask::NONE
        };
        let (after_caustic, global) = match self.photons {
            PhotonLookups::Never | PhotonLookups::RecordVisible => {
                return MapRequest { aimed: StoreMask::NONE, global: StoreMask::NONE, guides: false };
            }
            PhotonLookups::OncePerPixel => (bounces, StoreMask::NONE),
            PhotonLookups::FirstReceiver => (false, global(false)),
            // Gather rays do no next-event estimation where they end.
            PhotonLookups::GatherRays => (false, global(true)),
        };
        let aimed =
            StoreMask { caustic: caustics, after_caustic, separates_after_caustic: after_caustic, ..StoreMask::NONE };
        MapRequest { aimed, global, guides: self.directions == DirectionSampling::Guided && interreflection }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::settings::FinalGathering;
    use crate::integrate::{hybrid, path, pm, sppm};

    #[test]
    fn policies_request_the_maps_they_read() {
        let settings = Settings { final_gathering: FinalGathering::Importance, ..Settings::default() };
        let maps = |make: PolicyFn, effects| make(effects, &settings).photon_maps();
        let none = MapRequest { aimed: StoreMask::NONE, global: StoreMask::NONE, guides: false };
        assert_eq!(maps(path::policy, Effects::ALL), none);
        let aimed = StoreMask { after_caustic: true, separates_after_caustic: true, ..StoreMask::CAUSTIC };
        assert_eq!(maps(hybrid::policy, Effects::ALL), MapRequest { aimed, ..none });
        let sppm = MapRequest { aimed: StoreMask::CAUSTIC, global: StoreMask::GLOBAL, guides: false };
        assert_eq!(maps(sppm::policy, Effects::ALL), sppm);
        let gathering = StoreMask { direct: true, ..StoreMask::GLOBAL };
        assert_eq!(maps(pm::policy, Effects::ALL), MapRequest { global: gathering, guides: true, ..sppm });
        assert_eq!(maps(pm::policy, Effects::ALL.without(Effect::Gathering)), sppm);
    }

    #[test]
    fn effects_that_are_off_need_no_map() {
        let settings = Settings::default();
        let direct =
            Effects::ALL.without(Effect::Caustics).without(Effect::CausticBounces).without(Effect::Interreflection);
        for make in [hybrid::policy as PolicyFn, sppm::policy, pm::policy] {
            let MapRequest { aimed, global, guides } = make(direct, &settings).photon_maps();
            assert_eq!((aimed, global, guides), (StoreMask::NONE, StoreMask::NONE, false));
        }
    }
}
