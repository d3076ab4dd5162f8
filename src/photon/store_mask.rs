//! Kinds of photons by their path history, and the choice of stored kinds.

/// Path history of a photon. A caster is defined by
/// [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonKind {
    /// The path leads directly from a light.
    Direct,
    /// The path has only scattered at casters.
    Caustic,
    /// The path has continued from a storing surface that it reached as a caustic path.
    AfterCaustic,
    /// The path has continued from a storing surface that it reached directly.
    Global,
}

/// Which kinds of photons are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreMask {
    /// Store direct photons.
    pub direct: bool,
    /// Store caustic photons.
    pub caustic: bool,
    /// Store photons that continue after a caustic.
    pub after_caustic: bool,
    /// Store global photons.
    pub global: bool,
    /// Store photons after a caustic apart from the others. Their density is smooth, so only one in
    /// [`AFTER_CAUSTIC_THINNING`] paths is continued, with the flux of all.
    pub separates_after_caustic: bool,
    /// Store beams in homogeneous media; otherwise store points.
    pub beams: bool,
}

impl StoreMask {
    /// Direct photons only.
    pub const DIRECT: Self = Self { direct: true, ..Self::NONE };
    /// Caustic photons only: a path ends at the first storing surface.
    pub const CAUSTIC: Self = Self { caustic: true, ..Self::NONE };
    /// Photons that continue from a storing surface.
    pub const GLOBAL: Self = Self { after_caustic: true, global: true, ..Self::NONE };
    /// No photons.
    pub const NONE: Self = Self {
        direct: false,
        caustic: false,
        after_caustic: false,
        global: false,
        separates_after_caustic: false,
        beams: true,
    };
    /// All kinds.
    pub const ALL: Self = Self { direct: true, caustic: true, after_caustic: true, global: true, ..Self::NONE };

    /// True if photons of `kind` are stored on surfaces.
    pub(super) fn stores_on_surfaces(self, kind: PhotonKind) -> bool {
        match kind {
            PhotonKind::Direct => self.direct,
            PhotonKind::Caustic => self.caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::Global => self.global,
        }
    }

    /// True if photons of `kind` are stored in media. Next-event estimation covers direct light.
    pub(super) fn stores_in_media(self, kind: PhotonKind) -> bool {
        kind != PhotonKind::Direct && self.stores_on_surfaces(kind)
    }

    /// True if a path that continues as `kind` can deposit a stored photon.
    pub(super) fn can_reach_stored_kind(self, kind: PhotonKind) -> bool {
        match kind {
            PhotonKind::Direct => true,
            PhotonKind::Caustic => self.caustic || self.after_caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::Global => self.global,
        }
    }
}

/// Number of paths after a caustic that are represented by one.
pub const AFTER_CAUSTIC_THINNING: u32 = 8;

impl PhotonKind {
    /// The kind after a caster that the path passed without a vertex.
    pub(super) fn after_crossed_caster(self) -> Self {
        if self == Self::Direct { Self::Caustic } else { self }
    }

    /// The kind after scattering at a surface or in a medium; media count as storing surfaces.
    pub(super) fn after_scattering(self, stores: bool) -> Self {
        match (stores, self) {
            (false, Self::Direct) => Self::Caustic,
            (false, other) => other,
            (true, Self::Direct | Self::Global) => Self::Global,
            (true, Self::Caustic | Self::AfterCaustic) => Self::AfterCaustic,
        }
    }
}
