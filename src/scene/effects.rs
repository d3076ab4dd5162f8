//! Effects: parts of light transport that a render may simulate or leave out.

use super::InteriorKind;
use std::str::FromStr;

/// Expands to the text of [`CASTER_DESCRIPTION`], for use in `concat!`.
macro_rules! caster_description {
    () => {
        "mirrors, glass, panes, and conductors and coats of low roughness"
    };
}

/// List of all kinds of casters in English, for messages about a scene. Casters are materials that
/// focus light into caustics; [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics) has the
/// definition.
pub const CASTER_DESCRIPTION: &str = caster_description!();

/// Alias of the name of [`Effect::Specular`].
const SPECULAR_ALIAS: &str = "casters";

enum_with_all! {
    /// A part of light transport that a render may simulate or leave out.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u16)]
    pub enum Effect {
        /// Specular reflection and refraction of camera paths at casters: objects such as glass and
        /// mirrors. [`PhotonKind`](crate::photon::PhotonKind) defines casters.
        Specular,
        /// Caustics: light that mirrors, glass and other casters focus onto other surfaces.
        /// [`PhotonKind`](crate::photon::PhotonKind) defines casters.
        Caustics,
        /// Interreflection of caustics: light that diffuse or glossy surfaces reflect further after
        /// a caustic.
        CausticBounces,
        /// Interreflection between diffuse or glossy surfaces.
        Interreflection,
        /// Final gathering: rays leave a diffuse or glossy surface in sampled directions, and look
        /// up indirect light in a photon map where they hit.
        Gathering,
        /// Shadows: shadow rays test whether surfaces block the light.
        Shadows,
        /// Soft shadows: area lights have their true size. Without this effect, next-event
        /// estimation samples only their centers, and emission that a path hits afterwards does not
        /// count.
        SoftShadows,
        /// Light from an environment light.
        Environment,
        /// Nested dielectrics: absorption inside bodies, and refraction where bodies overlap.
        Interiors,
        /// Depth of field: camera rays from the whole lens instead of its center.
        Lens,
        /// Motion blur of objects, lights, textures and the camera.
        Motion,
        /// Textures of material parameters and of emission.
        Textures,
        /// Shading normals perturbed by bump maps and normal maps.
        Bump,
        /// Absorption, scattering and emission in participating media.
        Media,
        /// Dispersion: the refractive index of glass depends on the wavelength.
        Dispersion,
    }
}

impl Effect {
    /// Name of the effect on the command line and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Specular => "specular",
            Self::Caustics => "caustics",
            Self::CausticBounces => "caustic-bounces",
            Self::Interreflection => "interreflection",
            Self::Gathering => "gathering",
            Self::Shadows => "shadows",
            Self::SoftShadows => "soft-shadows",
            Self::Environment => "environment",
            Self::Interiors => "interiors",
            Self::Lens => "lens",
            Self::Motion => "motion",
            Self::Textures => "textures",
            Self::Bump => "bump",
            Self::Media => "media",
            Self::Dispersion => "dispersion",
        }
    }

    /// Describes the visible error of a picture that is rendered without this effect, in a scene
    /// that needs it.
    #[must_use]
    pub const fn symptom_if_missing(self) -> &'static str {
        match self {
            Self::Specular => concat!(caster_description!(), " are black"),
            Self::Caustics => {
                concat!("caustics of ", caster_description!(), " are missing: their shadows are too dark")
            }
            Self::CausticBounces => "surfaces lit by caustics do not light other surfaces",
            Self::Interreflection => {
                "diffuse surfaces do not light each other: surfaces without direct light are black"
            }
            Self::Gathering => "indirect light is blotchy, and too dark at edges and corners",
            Self::Shadows => "objects cast no shadows",
            Self::SoftShadows => "lights shrink to their centers: shadows and highlights have hard edges",
            Self::Environment => "the environment is neither visible nor lights the scene",
            Self::Interiors => "glass absorbs no light, and overlapping bodies refract as if they were apart",
            Self::Lens => "all distances are in focus",
            Self::Motion => "moving objects rest at their position when the shutter is half open",
            Self::Textures => "textures are replaced by their mean colors",
            Self::Bump => "bump-mapped surfaces are smooth",
            Self::Media => "fog, smoke and other participating media are missing",
            Self::Dispersion => "glass refracts all wavelengths alike: it shows no spectral colors",
        }
    }
}

/// The effects that this build of the program can simulate: all, or all except one.
///
/// The environment variable `CAUSTICA_WITHOUT` names an effect to leave out at build time.
/// `.ci/cost-of-effects` uses it to measure what the code of an effect costs in other scenes.
const COMPILED_EFFECTS: Effects = match option_env!("CAUSTICA_WITHOUT") {
    None => Effects::ALL,
    Some(name) => {
        let mut built = Effects::ALL;
        let mut i = 0;
        while i < Effect::ALL.len() {
            if bytes_equal(name.as_bytes(), Effect::ALL[i].name().as_bytes()) {
                built = built.without_effect(Effect::ALL[i]);
            }
            i += 1;
        }
        built
    }
};

const fn bytes_equal(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

impl FromStr for Effect {
    type Err = UnknownEffectError;

    /// Reads the name of an effect. `casters` is an alias of `specular`.
    fn from_str(name: &str) -> Result<Self, UnknownEffectError> {
        if name == SPECULAR_ALIAS {
            return Ok(Self::Specular);
        }
        Self::ALL.into_iter().find(|effect| effect.name() == name).ok_or(UnknownEffectError)
    }
}

/// Error: a text is not the name of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such effect")]
pub struct UnknownEffectError;

impl std::fmt::Display for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A set of effects, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects(u16);

impl Effects {
    /// The empty set of effects.
    pub const NONE: Self = Self(0);
    /// The set of all effects.
    pub const ALL: Self = Self::from_list(&Effect::ALL);

    /// Makes a set of the given effects.
    #[must_use]
    pub const fn from_list(effects: &[Effect]) -> Self {
        let mut set = Self(0);
        let mut i = 0;
        while i < effects.len() {
            set = set.with_effect(effects[i]);
            i += 1;
        }
        set
    }

    /// True if the set contains `effect` and this build can simulate it (see `COMPILED_EFFECTS`).
    #[inline]
    #[must_use]
    pub const fn has(self, effect: Effect) -> bool {
        self.0 & COMPILED_EFFECTS.0 & Self::bit_mask(effect) != 0
    }

    /// This set with `effect` added.
    #[must_use]
    pub const fn with_effect(self, effect: Effect) -> Self {
        Self(self.0 | Self::bit_mask(effect))
    }

    /// This set with `effect` removed.
    #[must_use]
    pub const fn without_effect(self, effect: Effect) -> Self {
        Self(self.0 & !Self::bit_mask(effect))
    }

    /// Selects the type that tracks the bodies and media around a path: the simplest type of
    /// [`Interior`](super::Interior) that suffices for these effects.
    #[must_use]
    pub const fn interior_kind(self) -> InteriorKind {
        match self.has(Effect::Interiors) {
            false => InteriorKind::Nothing,
            true if self.has(Effect::Media) || self.has(Effect::Dispersion) => InteriorKind::Spectral,
            true => InteriorKind::Bodies,
        }
    }

    /// Effects of the set, in the order of [`Effect::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |e| self.has(*e))
    }

    const fn bit_mask(effect: Effect) -> u16 {
        1 << effect as u16
    }
}
