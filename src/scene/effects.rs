//! What can be simulated or left out.

use super::InteriorKind;

/// A part of light transport that a picture may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Effect {
    /// Walking on from mirrors, glass and smooth metal that the camera sees.
    Specular,
    /// Light by way of casters to a receiver.
    Caustics,
    /// What caustics become on their way from receiver to receiver.
    CausticBounces,
    /// Light that receivers send to each other.
    Interreflection,
    /// Looking at the global map through gather rays.
    Gathering,
    /// Shadow rays that find something in their way.
    Shadows,
    /// Lights with an extent: soft shadows, and light met by chance.
    SoftShadows,
    /// Light from all around.
    Environment,
    /// Bodies that absorb or overlap.
    Interiors,
    /// Rays from all of the lens: depth of field.
    Lens,
    /// Things that move while the shutter is open.
    Motion,
    /// Textures.
    Textures,
    /// Bumps: shading normals that textures tilt.
    Bump,
    /// What fills bodies, or the open: light that is scattered, absorbed and emitted between surfaces.
    Media,
    /// Wavelengths that glass parts.
    Dispersion,
}

impl Effect {
    /// All of them, in the order of a table.
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

    /// As typed.
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

    /// What is wrong with a picture that calls for the effect and goes without.
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

/// The effects that are compiled in: all but that which `CAUSTICA_WITHOUT` named when the program was built, to measure what the
/// others pay for its presence (`.ci/cost-of-effects`).
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

    /// These effects.
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

    /// Whether `effect` is among them.
    #[inline]
    #[must_use]
    pub const fn has(self, effect: Effect) -> bool {
        self.0 & BUILT.0 & Self::bit(effect) != 0
    }

    /// With `effect`.
    #[must_use]
    pub const fn with(self, effect: Effect) -> Self {
        Self(self.0 | Self::bit(effect))
    }

    /// Without `effect`.
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

    /// They, in the order of a table.
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |e| self.has(*e))
    }

    const fn bit(effect: Effect) -> u16 {
        1 << effect as u16
    }
}
