//! What photons have met, and which of them are stored.

/// History of a stored photon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonKind {
    /// Straight from a light.
    Direct,
    /// By bounces off casters only: see [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
    Caustic,
    /// As a caustic to a surface that stores photons, and on from there.
    AfterCaustic,
    /// Straight from a light to a surface that stores photons, and on from there.
    Global,
}

/// Which classes are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreMask {
    /// Store direct photons.
    pub direct: bool,
    /// Store caustic photons.
    pub caustic: bool,
    /// Store what caustic photons become.
    pub after_caustic: bool,
    /// Store global photons.
    pub global: bool,
    /// Keep what caustic photons become apart from the others; as it is smooth, only one of [`THINNING`] is followed, with the flux
    /// of all.
    pub apart: bool,
    /// Store ways through homogeneous media as beams; else points where light is scattered.
    pub beams: bool,
}

impl StoreMask {
    /// Direct photons only.
    pub const DIRECT: Self = Self { direct: true, ..Self::NONE };
    /// Caustic photons only: a path ends at the first surface that stores photons.
    pub const CAUSTIC: Self = Self { caustic: true, ..Self::NONE };
    /// Photons that met a surface that stores photons before.
    pub const GLOBAL: Self = Self { after_caustic: true, global: true, ..Self::NONE };
    /// Nothing.
    pub const NONE: Self =
        Self { direct: false, caustic: false, after_caustic: false, global: false, apart: false, beams: true };
    /// All classes.
    pub const ALL: Self = Self { direct: true, caustic: true, after_caustic: true, global: true, ..Self::NONE };

    pub(super) fn has(self, class: PhotonKind) -> bool {
        match class {
            PhotonKind::Direct => self.direct,
            PhotonKind::Caustic => self.caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::Global => self.global,
        }
    }

    /// Whether light of `class` is stored where a medium scatters it. What comes straight from a light is for connections to find.
    pub(super) fn has_in_media(self, class: PhotonKind) -> bool {
        class != PhotonKind::Direct && self.has(class)
    }

    /// Whether anything wanted can follow on a photon of `class` that goes on.
    pub(super) fn may_follow(self, class: PhotonKind) -> bool {
        match class {
            PhotonKind::Direct => true,
            PhotonKind::Caustic => self.caustic || self.after_caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::Global => self.global,
        }
    }
}

/// Of photons that go on after a caustic, so many are followed as one where they are kept apart.
pub const THINNING: u32 = 8;

impl PhotonKind {
    /// The class of light that has met a caster since.
    pub(super) fn beyond_casters(self) -> Self {
        if self == Self::Direct { Self::Caustic } else { self }
    }

    /// The class after a surface, or after scattering in a medium, which counts as a surface that stores.
    pub(super) fn after(self, stores: bool) -> Self {
        match (stores, self) {
            (false, Self::Direct) => Self::Caustic,
            (false, other) => other,
            (true, Self::Direct | Self::Global) => Self::Global,
            (true, Self::Caustic | Self::AfterCaustic) => Self::AfterCaustic,
        }
    }
}
