//! Effects: parts of light transport that can be simulated or left out.

use super::InteriorKind;

/// A part of light transport that a picture may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Effect {
    /// Camera paths that continue at mirrors, glass and smooth metal.
    Specular,
    /// Light that reaches a receiver by way of specular or glossy surfaces.
    Caustics,
    /// Caustic light that receivers reflect to other receivers.
    CausticBounces,
    /// Light that receivers reflect to each other.
    Interreflection,
    /// Final gathering: evaluating the global photon map through gather rays.
    Gathering,
    /// Occlusion of shadow rays.
    Shadows,
    /// Area lights: soft shadows, and lights hit by scattered rays.
    SoftShadows,
    /// Light from an environment.
    Environment,
    /// Bodies that absorb or overlap.
    Interiors,
    /// Depth of field: rays from the whole lens.
    Lens,
    /// Motion blur: objects that move while the shutter is open.
    Motion,
    /// Textures.
    Textures,
    /// Bump maps and normal maps.
    Bump,
    /// Participating media: scattering, absorption and emission between surfaces.
    Media,
    /// Dispersion: refractive indices that depend on the wavelength.
    Dispersion,
}

impl Effect {
    /// All effects, in the order of tables.
    pub const ALL: [Self; 15] = [
        Self::Specular,
        Self::Caustics,
        Self::CausticBounces,
        Self::Interreflection,
        Self::Gathering,
        Self::Shadows,
        Self::SoftShadows,
        Self::Environment,
        Self::Interiors,
        Self::Lens,
        Self::Motion,
        Self::Textures,
        Self::Bump,
        Self::Media,
        Self::Dispersion,
    ];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Specular => "casters",
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

    /// The fault of a picture that needs the effect but omits it.
    #[must_use]
    pub const fn lack(self) -> &'static str {
        match self {
            Self::Specular => "mirrors, glass and smooth metal are black",
            Self::Caustics => "light by way of glass and mirrors is missing: their shadows are too dark",
            Self::CausticBounces => "what caustics light is lit, but lights nothing in turn",
            Self::Interreflection => "matt surfaces do not light each other: what no light sees is black",
            Self::Gathering => "indirect light is blotched, and darkens in seams at edges",
            Self::Shadows => "light goes through everything that stands in its way",
            Self::SoftShadows => "lights shine from their middles: shadows and gloss have hard edges",
            Self::Environment => "the sky neither lights nor shows",
            Self::Interiors => {
                "glass keeps all light that goes through it, and bodies that overlap refract as if apart"
            }
            Self::Lens => "everything is sharp, near and far",
            Self::Motion => "what moves stands still where it is when the shutter is half way",
            Self::Textures => "textures show as their mean colours",
            Self::Bump => "surfaces with bumps are smooth",
            Self::Media => "fog, smoke and whatever else fills bodies is missing",
            Self::Dispersion => "glass bends all colours alike: no spectrum, no fire",
        }
    }
}

/// The effects compiled in: all but the one that `CAUSTICA_WITHOUT` names at build time.
///
/// `.ci/cost-of-effects` measures by it what the presence of an effect costs the others.
const BUILT: Effects = match option_env!("CAUSTICA_WITHOUT") {
    None => Effects::ALL,
    Some(name) => {
        let mut built = Effects::ALL;
        let mut i = 0;
        while i < Effect::ALL.len() {
            if same(name.as_bytes(), Effect::ALL[i].name().as_bytes()) {
                built = built.without(Effect::ALL[i]);
            }
            i += 1;
        }
        built
    }
};

const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

impl std::fmt::Display for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A set of effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects(u16);

impl Effects {
    /// No effect.
    pub const NONE: Self = Self(0);
    /// All effects.
    pub const ALL: Self = Self::of(&Effect::ALL);

    /// The set of `effects`.
    #[must_use]
    pub const fn of(effects: &[Effect]) -> Self {
        let mut set = Self(0);
        let mut i = 0;
        while i < effects.len() {
            set = set.with(effects[i]);
            i += 1;
        }
        set
    }

    /// True if the set contains `effect`.
    #[inline]
    #[must_use]
    pub const fn has(self, effect: Effect) -> bool {
        self.0 & BUILT.0 & Self::bit(effect) != 0
    }

    /// This set with `effect`.
    #[must_use]
    pub const fn with(self, effect: Effect) -> Self {
        Self(self.0 | Self::bit(effect))
    }

    /// This set without `effect`.
    #[must_use]
    pub const fn without(self, effect: Effect) -> Self {
        Self(self.0 & !Self::bit(effect))
    }

    /// The record of interiors that paths need to simulate these effects.
    #[must_use]
    pub const fn interior_kind(self) -> InteriorKind {
        match self.has(Effect::Interiors) {
            false => InteriorKind::Nothing,
            true if self.has(Effect::Media) || self.has(Effect::Dispersion) => InteriorKind::Spectral,
            true => InteriorKind::Bodies,
        }
    }

    /// The effects of the set, in the order of tables.
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |e| self.has(*e))
    }

    const fn bit(effect: Effect) -> u16 {
        1 << effect as u16
    }
}
