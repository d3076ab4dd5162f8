//! Keyed random numbers: each number is a hash of seed, purpose, pass, path, vertex and dimension.
//!
//! No number depends on the thread or on earlier draws. So a skipped effect changes no other
//! number, and any pass can be computed alone.
//!
//! # Map of the key space
//! A [`Key`] is a hash of its parent key and one 64-bit word. A random number is a hash of a key
//! and a [`Dimension`]. The table lists all words that the renderer uses. Two functions may use one
//! word of a parent only if they draw numbers of different dimensions. The last column says why
//! keys are distinct.
//!
//! In the table, a parent such as `CameraPaths` is the key of that [`Purpose`]. "Pilot" is the key
//! of the purpose of a pilot simulation. A trial is one repetition of a pilot simulation. A round
//! is one iteration of the training of guiding; environment guiding traces its camera paths in
//! round 0. A bounce counts the scattering events of a path.
//!
//! | parent | function | word | distinct because |
//! | --- | --- | --- | --- |
//! | – | `Key::new` | seed | root of a render |
//! | root, trial, pilot | `Key::purpose_key` | [`Purpose`] | one per purpose |
//! | purpose | `Key::pass_key` | pass | one per pass; a pilot counts down from `u32::MAX` |
//! | `CameraPaths` | `Key::shared_camera_paths_key` | 0 | for passes that share paths |
//! | `CameraPaths` | `Key::unshared_camera_paths_key` | pass + 1 | never the 0 of shared paths |
//! | pass, slice, round, pilot | `Key::photon_path_key` | path | one per photon path |
//! | pass of photon paths | `Key::shutter_slice_key` | 2³² + slice | above all words of paths |
//! | path | `Key::photon_vertex_key` | bounce | one per vertex of a photon path |
//! | vertex of a photon path | `Key::camera_connection_key` | 1 | the only child of its parent |
//! | pass of camera paths or prefix rays | `Key::pixel_key` | y · 2³² + x | one per pixel |
//! | `Shutter`, `SurfaceAovs`, `LampImages` | `Key::pixel_key` | y · 2³² + x | one per pixel |
//! | pixel of `Shutter` | `Key::pass_key` | pass | one per pass |
//! | pixel | `Sampler::next_vertex_sampler` | 2 · bounce + transmitted | two branches per split |
//! | vertex | `Sampler::shadow_ray_sampler` | pass · 2³² | other dimensions than the next vertex |
//! | vertex, sample | `Key::medium_tracking_key` | 2⁶³ + pass | above all words of vertices |
//! | vertex, sample | `Key::coincident_face_key` | 2⁶² + boundary · 2³² + group | below 2⁶³ |
//! | vertex, sample | `Key::nth_mix_choice_key` | 2⁶¹ + choice | below 2⁶²; choice 0 is parent |
//! | shadow rays | `Sampler::nth_shadow_ray_sampler` | light or ray | lights or chosen rays |
//! | shadow ray | `Key::shadow_ray_scatter_point_key` | 1 | transmittance uses the parent itself |
//! | film sample of a pilot | `Sampler::pilot_bounce_sampler` | bounce | one per vertex |
//! | any sampler | `Sampler::sample_key` | sample | one per sample of the pixel |
//! | `RayPhotonBalance`, `IndirectDivision` | `Key::pilot_trial_key` | trial | independent trials |
//! | `CameraPaths` of trial, pilot | `Key::film_point_key` | set · 2³² + point | one per point |
//! | `AimedLightPower` | `Key::light_power_pilot_key` | light | one per light |
//! | `EmissionGuiding` | `Key::training_round_key` | round | one per training round |
//! | `EnvironmentGuiding` | `Key::training_round_key` | round | one per training round |

use glam::Vec2;
use rand::{SeedableRng, rngs::SmallRng};

/// Part of a render that draws random numbers, such as camera paths or a pilot simulation. Each
/// part has random numbers of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Photon paths that are emitted in all directions, not towards chosen objects.
    UnaimedPhotons = 1,
    /// Photon paths that are emitted towards surfaces that cast caustics, such as glass or mirrors.
    AimedPhotons,
    /// Camera paths.
    CameraPaths,
    /// Pilot simulation that finds the radii of photon density estimates before the first pass.
    RadiusPilot,
    /// Pilot simulation that estimates the power that each light emits towards surfaces that cast
    /// caustics.
    AimedLightPower,
    /// Random numbers of tests.
    Test,
    /// Pilot simulation that finds surface points that the camera sees.
    VisiblePoints,
    /// Pilot simulation that finds which photon paths contribute to the picture. Lights then emit
    /// more photons from such positions in such directions (emission guiding).
    EmissionGuiding,
    /// Photon paths that guide the final gather rays of a pass, and are used for nothing else. The
    /// photons show from which directions indirect light arrives.
    GatherRayGuides,
    /// Pilot simulation that finds how many camera rays and how many photon paths a pass should
    /// trace.
    RayPhotonBalance,
    /// Shutter times of passes and of camera rays.
    Shutter,
    /// Pilot simulation that finds, for each pixel, how much of the caustics should come from
    /// photon density estimates and how much from light tracing.
    DensityEstimateShares,
    /// Extra camera paths of the algorithm `hybrid` that end at the first surface that stores
    /// photons (prefix rays).
    PrefixRays,
    /// Pilot simulation that finds how much of the indirect light camera paths should compute, and
    /// how much photons.
    IndirectDivision,
    /// Random choice of the photon beams that a pass keeps. The pass drops all other beams to save
    /// time.
    BeamThinning,
    /// Pilot simulation that finds the directions from which the environment light reaches each
    /// part of a scene.
    EnvironmentGuiding,
    /// Camera rays for AOVs of the first surface, such as albedo and depth.
    SurfaceAovs,
    /// Pilot simulation that finds where in media direct light arrives. More scattering points
    /// (points in media from which shadow rays start) are then chosen there.
    ScatterPointGuiding,
    /// Pilot simulation that finds lamp images: film regions in which a small lamp appears,
    /// directly or via specular surfaces.
    LampImages,
    /// Extra camera paths that are aimed at lamp images, the film regions in which a small lamp
    /// appears. They end at the first surface that stores photons (aimed prefix rays).
    AimedPrefixRays,
}

/// A random decision at one vertex of a path, such as the choice of a light. Each decision has its
/// own random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Dimension {
    /// Choice of a light, for photon emission or next-event estimation.
    Light = 1,
    /// Position on a light.
    LightPosition,
    /// Direction in which a light emits a photon.
    LightDirection,
    /// Spare dimension, which only tests use.
    LightTarget,
    /// Position within a pixel, or on the film.
    Film,
    /// Choice of the lobe of a BSDF.
    BsdfLobe,
    /// Direction sampled from a BSDF lobe.
    BsdfDirection,
    /// Russian roulette that decides whether a path continues.
    Roulette,
    /// Choice of one component of a mix material, which blends several materials.
    Mix,
    /// Position of a probe ray in the gather disc of a photon density estimate. Probe rays measure
    /// how much of the disc is surface.
    CoverageProbe,
    /// Choice that a camera path makes at a receiver: a surface or medium that stores photons.
    ///
    /// The algorithm `distributed` chooses the diffuse or the glossy lobe. The algorithm `hybrid`
    /// chooses whether the path ends or continues.
    ReceiverBranch,
    /// Russian roulette for shading. It takes place before a camera path of low throughput shades a
    /// surface, and before a shadow ray starts in a medium. It also takes place before a photon
    /// path continues after a caustic photon.
    ShadingRoulette,
    /// Position on the lens of the camera.
    Lens,
    /// Time of a pass or of a camera ray while the shutter is open.
    Time,
    /// Wavelength that a path samples at a dispersive interface.
    ///
    /// For the first wavelength of a path, camera paths use the key of their pixel, and photon
    /// paths use the key of their pass. A path that samples another wavelength later uses the key
    /// of the vertex.
    Wavelength,
    /// Direction after scattering in a medium, sampled from the phase function.
    Phase,
    /// Choice of a scattering point: a point in a medium from which a shadow ray starts.
    ScatterPoint,
}

/// A 64-bit hash from which independent random numbers are derived.
///
/// Hashing a key with a number gives a child key, such as the key of a pass, a pixel or a path
/// vertex. The module documentation lists all keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u64);

/// Bit that is set in the number from which [`Key::medium_tracking_key`] makes a child key. Numbers
/// without this bit are left to the keys of path vertices and shadow rays.
const MEDIUM_TRACKING_BIT: u64 = 1 << 63;

/// Bit that is set in the number from which [`Key::coincident_face_key`] makes a child key. Numbers
/// without this bit are left to the keys of path vertices and shadow rays.
const COINCIDENT_FACE_BIT: u64 = 1 << 62;

/// Bit that is set in the number from which [`Key::nth_mix_choice_key`] makes a child key. Numbers
/// without this bit are left to the keys of path vertices and shadow rays.
const MIX_CHOICE_BIT: u64 = 1 << 61;

/// Bit that is set in the number from which [`Key::shutter_slice_key`] makes a child key. Numbers
/// without this bit are left to the keys of photon paths.
const SHUTTER_SLICE_BIT: u64 = 1 << 32;

impl Key {
    /// Creates the key from which all other keys of a render derive.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(hash_bits(seed ^ 0x6a09_e667_f3bc_c909))
    }

    /// Returns the hash of this key and the number `n`. Other code should call a function with a
    /// specific name instead, such as [`Key::pass_key`].
    #[inline]
    #[must_use]
    pub fn child_key(self, n: u64) -> Self {
        Self(hash_bits(self.0.wrapping_add(n.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15))))
    }

    /// Key of the random numbers for `purpose`, derived from the root key of a render.
    #[must_use]
    pub fn purpose_key(self, purpose: Purpose) -> Self {
        self.child_key(purpose as u64)
    }

    /// Key of pass number `pass`, derived from the key of a purpose.
    #[must_use]
    pub fn pass_key(self, pass: u32) -> Self {
        self.child_key(u64::from(pass))
    }

    /// Key of the camera paths of an integrator that traces the same camera paths in every pass.
    /// `self` is the key of a purpose.
    #[must_use]
    pub fn shared_camera_paths_key(self) -> Self {
        self.child_key(0)
    }

    /// Key of camera paths that differ from pass to pass, for an integrator that otherwise traces
    /// the same camera paths in every pass. `self` is the key of a purpose.
    #[must_use]
    pub fn unshared_camera_paths_key(self, pass: u32) -> Self {
        self.child_key(u64::from(pass) + 1)
    }

    /// Key of photon path `index` of a pass.
    #[inline]
    #[must_use]
    pub fn photon_path_key(self, index: u32) -> Self {
        self.child_key(u64::from(index))
    }

    /// Key of the photon paths of slice `slice` of the shutter interval of a pass.
    #[must_use]
    pub fn shutter_slice_key(self, slice: u32) -> Self {
        self.child_key(SHUTTER_SLICE_BIT | u64::from(slice))
    }

    /// Key of a vertex of a photon path: the one after `bounce` scattering events. `self` is the
    /// key of the path.
    #[inline]
    #[must_use]
    pub fn photon_vertex_key(self, bounce: u32) -> Self {
        self.child_key(u64::from(bounce))
    }

    /// Key of the random numbers that estimate the transmittance from a photon path vertex to the
    /// camera, for light tracing. `self` is the key of the vertex.
    #[inline]
    #[must_use]
    pub fn camera_connection_key(self) -> Self {
        self.child_key(1)
    }

    /// Key of the pixel in column `x`, row `y`.
    #[inline]
    #[must_use]
    pub fn pixel_key(self, x: u32, y: u32) -> Self {
        self.child_key(u64::from(y) << 32 | u64::from(x))
    }

    /// Key of the random numbers that sample distances in media, along the path segment that ends
    /// at a vertex. `self` is the key of this vertex.
    ///
    /// Passes may share the vertex keys of camera paths. Their keys for distance sampling still
    /// differ, because they depend on the number `pass`.
    #[inline]
    #[must_use]
    pub fn medium_tracking_key(self, pass: u32) -> Self {
        self.child_key(MEDIUM_TRACKING_BIT | u64::from(pass))
    }

    /// Key of the random numbers for choice number `n` along a path segment. At each mix material
    /// that the segment meets, one choice picks a component of the mix.
    ///
    /// `self` is the key of the vertex at the end of the segment, and is also the key of choice 0.
    /// Further choices follow if the path crosses mixes that do not scatter it.
    #[inline]
    #[must_use]
    pub fn nth_mix_choice_key(self, n: u32) -> Self {
        if n == 0 { self } else { self.child_key(MIX_CHOICE_BIT | u64::from(n)) }
    }

    /// Key of the random numbers that choose a component of a mix material. Faces of this material
    /// coincide with a boundary that a path segment crosses.
    ///
    /// `self` is the key of the path vertex that ends the segment. `boundary` is the number of
    /// boundaries that the path has crossed since its last vertex. Faces with the same number
    /// `group` get the same key, so they choose the same component.
    #[must_use]
    pub fn coincident_face_key(self, boundary: u32, group: u32) -> Self {
        self.child_key(COINCIDENT_FACE_BIT | u64::from(boundary) << 32 | u64::from(group))
    }

    /// Key of the random numbers that choose a scattering point: a point in a medium from which a
    /// shadow ray starts. `self` is the key of the shadow ray.
    #[inline]
    #[must_use]
    pub fn shadow_ray_scatter_point_key(self) -> Self {
        self.child_key(1)
    }

    /// Key of one of several repetitions of a pilot simulation. `trial` is the number of the
    /// repetition; each has independent random numbers.
    #[must_use]
    pub fn pilot_trial_key(self, trial: u32) -> Self {
        self.child_key(u64::from(trial))
    }

    /// Key of point number `point` in set number `set` of random points on the film. Pilot
    /// simulations use several independent sets.
    #[must_use]
    pub fn film_point_key(self, set: u32, point: u32) -> Self {
        self.child_key(u64::from(set) << 32 | u64::from(point))
    }

    /// Key of the random numbers that estimate the power that the light with index `light` emits
    /// towards surfaces that cast caustics.
    #[must_use]
    pub fn light_power_pilot_key(self, light: usize) -> Self {
        self.child_key(light as u64)
    }

    /// Key of training iteration `round` of emission guiding or environment guiding.
    #[must_use]
    pub fn training_round_key(self, round: u32) -> Self {
        self.child_key(u64::from(round))
    }

    /// Returns 64 random bits for the decision `dimension`. Different decisions get different bits.
    #[inline]
    #[must_use]
    pub fn random_bits(self, dimension: Dimension) -> u64 {
        hash_bits(self.0 ^ (dimension as u64).wrapping_mul(0xd6e8_feb8_6659_fd93))
    }

    /// Returns a uniform random number in \[0, 1) for the decision `dimension`.
    #[inline]
    #[must_use]
    pub fn uniform_1d(self, dimension: Dimension) -> f32 {
        uniform_from_24_bits((self.random_bits(dimension) >> 40) as u32)
    }

    /// Returns a uniform random point in \[0, 1)² for the decision `dimension`.
    #[inline]
    #[must_use]
    pub fn uniform_2d(self, dimension: Dimension) -> Vec2 {
        let bits = self.random_bits(dimension);
        Vec2::new(uniform_from_24_bits((bits >> 40) as u32), uniform_from_24_bits((bits >> 8) as u32 & 0xff_ffff))
    }

    /// Creates a sequential random number generator with this key as seed, for loops that need an
    /// unknown count of numbers.
    #[must_use]
    pub fn rng(self) -> SmallRng {
        SmallRng::seed_from_u64(self.0)
    }
}

/// Returns `bits`·2⁻²⁴, which is in \[0, 1) and exact for `bits` below 2²⁴.
#[inline]
pub(super) fn uniform_from_24_bits(bits: u32) -> f32 {
    bits as f32 * (1.0 / 16_777_216.0)
}

/// Bijective 64-bit hash: Stafford's variant 13 of the MurmurHash3 finaliser.
#[inline]
fn hash_bits(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests;
