//! Path policies: the rules that distinguish the algorithms.
//!
//! A [`PathPolicy`] says how a camera path samples, shades and continues at its vertices. Each
//! algorithm's file makes a policy from the simulated effects. The policy also decides which photon
//! maps are built: see [`PathPolicy::photon_map_request`].

use super::settings::{IndirectPhotons, LightTracing, Settings};
use crate::photon::StoreMask;
use crate::scene::{Effect, Effects};

/// Function that makes an algorithm's path policy from the set of simulated effects and the
/// settings.
pub(super) type PolicyFn = fn(Effects, &Settings) -> PathPolicy;

/// Rules of one rendering algorithm for its camera paths and its lookups in photon maps.
///
/// *Receiver*: a surface or medium that stores photons, such as a diffuse wall. *Caster*: a surface
/// that passes photons on, such as glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathPolicy {
    /// Effects of light to simulate.
    pub effects: Effects,
    /// Default number of camera rays per pixel in each pass.
    pub default_samples_per_pixel: u32,
    /// True if every pass traces the same camera paths.
    pub passes_share_paths: bool,
    /// True if camera paths find direct light by next-event estimation.
    pub uses_nee: bool,
    /// Number and targets of the shadow rays of next-event estimation.
    pub light_sampling: LightSampling,
    /// Rule for the receivers (surfaces and media that store photons) from which a camera path
    /// continues.
    pub continuation: PathContinuation,
    /// Strategy by which a camera path samples its next direction at a receiver, a surface that
    /// stores photons.
    pub directions: DirectionSampling,
    /// True if camera paths add caustics: emission that they hit after a diffuse surface, for
    /// example, and then mirrors or glass. False leaves this light to photons.
    pub adds_caustics: bool,
    /// Throughput, as a mean over RGB, below which a path ends. The lost light is not made up for,
    /// so the picture gets slightly darker. If the value is 0, Russian roulette may end a faint
    /// path before a surface that stores photons is shaded.
    pub min_throughput: f32,
    /// Vertices at which camera paths read photon maps.
    pub lookups: PhotonLookups,
    /// True if gather radii shrink from pass to pass; false if they stay fixed.
    pub shrinking_radii: bool,
    /// Division of directly visible caustics between photon estimates and light tracing.
    pub light_tracing: LightTracing,
    /// Division of indirect light between camera paths and photon estimates, at a camera path's
    /// first receiver (surface or medium that stores photons).
    pub indirect_photons: IndirectPhotons,
}

/// Number and targets of the shadow rays of next-event estimation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightSampling {
    /// Each vertex sends about this many shadow rays. If there are more lights than rays, each ray
    /// goes to a randomly chosen light.
    Rays(u32),
    /// Each vertex sends one shadow ray to a randomly chosen light. In a scene with at most four
    /// lights, every vertex up to the first receiver (surface or medium that stores photons)
    /// instead sends one shadow ray to each light.
    OneRay,
    /// Each vertex sends one shadow ray to the center of every light.
    Centers,
}

/// Choice of the receivers from which a camera path continues. A receiver is a surface or medium
/// that stores photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathContinuation {
    /// Camera paths never scatter at a receiver. They end at the first surface that stores photons,
    /// and cross media without scattering.
    Never,
    /// Camera paths continue from a surface that stores photons only if the sampled BSDF lobe is
    /// glossy: neither diffuse nor a coat over a diffuse base. They cross media without scattering.
    Glossy,
    /// Camera paths continue from the first surface that stores photons by a final-gathering ray,
    /// and end at the next such surface. If the gather ray is too short to read the indirect map at
    /// its end, they continue from there. They cross media without scattering.
    GatherRays,
    /// Camera paths continue from all surfaces and media that store photons.
    Always,
}

/// Strategy by which a camera path samples its next direction at receivers: surfaces that store
/// photons, such as diffuse walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DirectionSampling {
    /// The direction is sampled from the BSDF.
    Bsdf,
    /// The direction is sampled from one randomly chosen BSDF lobe, which replaces the whole BSDF
    /// at this vertex.
    OneLobe,
    /// The direction is sampled from the BSDF or from the directions from which nearby photons
    /// arrived, with equal probability.
    Guided,
}

/// Vertices at which a camera path reads photon maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PhotonLookups {
    /// Camera paths read no photon maps.
    Never,
    /// A few camera paths of each pixel read the photon maps at their first receiver (surface or
    /// medium that stores photons): on surfaces one path per slice of the shutter interval, in
    /// media one path.
    ///
    /// The pixel's other paths would read almost the same photons. Some prefix rays, which are
    /// extra camera paths that end at their first receiver, may read the maps as well.
    FewPerPixel,
    /// Each path reads the caustic map and the indirect map at its first receiver, the surface or
    /// medium that stores photons.
    FirstReceiver,
    /// Each path reads the caustic map at the start of a final-gathering ray. At the end of that
    /// ray, it reads the caustic map and the indirect map.
    GatherRays,
    /// Camera paths read no photon maps. For a pilot (small simulation before the first pass), they
    /// record each point that they reach on a surface that stores photons.
    RecordVisible,
}

/// Kinds of photons that a pass must store for the maps that a policy reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PhotonMapRequest {
    /// Kinds of photons to store from photon paths that are aimed at casters, such as mirrors and
    /// glass.
    pub aimed: StoreMask,
    /// Kinds of photons to store from photon paths that start in all directions.
    pub unaimed: StoreMask,
    /// True if passes build a separate photon map whose photons guide the directions of
    /// final-gathering rays.
    pub builds_guide_map: bool,
}

impl PathPolicy {
    /// True if camera paths estimate radiance from photon maps.
    pub fn reads_photons(&self) -> bool {
        match self.lookups {
            PhotonLookups::FewPerPixel | PhotonLookups::FirstReceiver | PhotonLookups::GatherRays => true,
            PhotonLookups::Never | PhotonLookups::RecordVisible => false,
        }
    }

    /// True if every camera path reads photon maps; false if only a few paths per pixel and pass
    /// do. Meaningless if [`PathPolicy::reads_photons`] is false.
    pub fn reads_photons_each_sample(&self) -> bool {
        self.lookups != PhotonLookups::FewPerPixel
    }

    /// True if a pilot may add [prefix rays](super::prefix_rays): extra camera paths that end at
    /// the first surface that stores photons.
    pub fn allows_prefix_rays(&self) -> bool {
        self.lookups == PhotonLookups::FewPerPixel
    }

    /// True if a pilot may change the numbers of camera rays and photon paths, to get less noise
    /// for the same work. False if all passes share camera paths.
    pub fn allows_ray_photon_balance(&self) -> bool {
        !self.passes_share_paths
    }

    /// Returns the kinds of photons that passes must store for this policy. Photons of effects that
    /// are off are left out.
    pub fn photon_map_request(&self) -> PhotonMapRequest {
        let caustics = self.effects.has(Effect::Caustics);
        let bounces = self.effects.has(Effect::CausticBounces);
        let interreflection = self.effects.has(Effect::Interreflection);
        let unaimed = |direct: bool| StoreMask {
            direct: direct && interreflection,
            after_caustic: bounces,
            after_direct: interreflection,
            ..StoreMask::NONE
        };
        let (after_caustic, unaimed) = match self.lookups {
            PhotonLookups::Never | PhotonLookups::RecordVisible => {
                return PhotonMapRequest { aimed: StoreMask::NONE, unaimed: StoreMask::NONE, builds_guide_map: false };
            }
            PhotonLookups::FewPerPixel => {
                let merges = self.indirect_photons != IndirectPhotons::Off;
                (bounces, StoreMask { after_direct: merges && interreflection, ..StoreMask::NONE })
            }
            PhotonLookups::FirstReceiver => (false, unaimed(false)),
            // Next-event estimation is left out at the end of gather rays, so the map holds direct
            // light too.
            PhotonLookups::GatherRays => (false, unaimed(true)),
        };
        let aimed =
            StoreMask { caustic: caustics, after_caustic, separates_after_caustic: after_caustic, ..StoreMask::NONE };
        PhotonMapRequest {
            aimed,
            unaimed,
            builds_guide_map: self.directions == DirectionSampling::Guided && interreflection,
        }
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
        let maps = |make: PolicyFn, effects| make(effects, &settings).photon_map_request();
        let none = PhotonMapRequest { aimed: StoreMask::NONE, unaimed: StoreMask::NONE, builds_guide_map: false };
        assert_eq!(maps(path::path_policy, Effects::ALL), none);
        let aimed = StoreMask { after_caustic: true, separates_after_caustic: true, ..StoreMask::CAUSTIC };
        let unaimed = StoreMask { after_direct: true, ..StoreMask::NONE };
        assert_eq!(maps(hybrid::path_policy, Effects::ALL), PhotonMapRequest { aimed, unaimed, ..none });
        let settings = Settings { indirect_photons: IndirectPhotons::Off, ..settings.clone() };
        let without = hybrid::path_policy(Effects::ALL, &settings).photon_map_request();
        assert_eq!(without, PhotonMapRequest { aimed, ..none });
        let sppm =
            PhotonMapRequest { aimed: StoreMask::CAUSTIC, unaimed: StoreMask::INDIRECT, builds_guide_map: false };
        assert_eq!(maps(sppm::path_policy, Effects::ALL), sppm);
        let gathering = StoreMask { direct: true, ..StoreMask::INDIRECT };
        assert_eq!(
            maps(pm::path_policy, Effects::ALL),
            PhotonMapRequest { unaimed: gathering, builds_guide_map: true, ..sppm }
        );
        assert_eq!(maps(pm::path_policy, Effects::ALL.without_effect(Effect::Gathering)), sppm);
    }

    #[test]
    fn disabled_effects_request_no_photon_maps() {
        let settings = Settings::default();
        let direct = Effects::ALL
            .without_effect(Effect::Caustics)
            .without_effect(Effect::CausticBounces)
            .without_effect(Effect::Interreflection);
        for make in [hybrid::path_policy as PolicyFn, sppm::path_policy, pm::path_policy] {
            let PhotonMapRequest { aimed, unaimed, builds_guide_map: guides } =
                make(direct, &settings).photon_map_request();
            assert_eq!((aimed, unaimed, guides), (StoreMask::NONE, StoreMask::NONE, false));
        }
    }
}
