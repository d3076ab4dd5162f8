//! Kinds of photons by path history, and the selection of stored kinds.

/// Kind of a stored photon, which follows from the earlier vertices of its path.
///
/// A *receiver* is a surface with [`Bsdf::stores_photons`](crate::bsdf::Bsdf::stores_photons), or a
/// scattering medium. A *caster* is any other surface that is not black, such as glass or a mirror;
/// see [`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonKind {
    /// Direct light: the path has no vertex between light and photon.
    Direct,
    /// Caustic light: all vertices between light and photon are on casters.
    Caustic,
    /// Light that a caustic reflects: the path reached its first receiver over casters.
    AfterCaustic,
    /// Other indirect light: the path reached its first receiver directly from the light source.
    AfterDirect,
}

/// Selects the kinds of photons that a photon pass stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreMask {
    /// True to store [`PhotonKind::Direct`].
    pub direct: bool,
    /// True to store [`PhotonKind::Caustic`].
    pub caustic: bool,
    /// True to store [`PhotonKind::AfterCaustic`].
    pub after_caustic: bool,
    /// True to store [`PhotonKind::AfterDirect`].
    pub after_direct: bool,
    /// True to store photons of kind [`PhotonKind::AfterCaustic`] apart from the other kinds.
    ///
    /// Their density is smooth, so few of them suffice. Russian roulette continues one of
    /// [`AFTER_CAUSTIC_THINNING`] paths after a caustic, and multiplies its flux by that number.
    ///
    /// The separate photons fill the indirect map, in place of an unaimed photon pass. `hybrid`
    /// builds its indirect map so.
    pub separates_after_caustic: bool,
    /// True to store photon beams in homogeneous media; false to store photon points.
    pub beams: bool,
}

impl StoreMask {
    /// Stores direct photons only.
    pub const DIRECT: Self = Self { direct: true, ..Self::NONE };
    /// Stores caustic photons only, so a path ends at its first receiver.
    pub const CAUSTIC: Self = Self { caustic: true, ..Self::NONE };
    /// Stores photons of paths that have scattered at one or more receivers.
    pub const INDIRECT: Self = Self { after_caustic: true, after_direct: true, ..Self::NONE };
    /// Stores no photons.
    pub const NONE: Self = Self {
        direct: false,
        caustic: false,
        after_caustic: false,
        after_direct: false,
        separates_after_caustic: false,
        beams: true,
    };
    /// Stores all kinds of photons.
    pub const ALL: Self = Self { direct: true, caustic: true, after_caustic: true, after_direct: true, ..Self::NONE };

    /// True if photons of `kind` are stored on surfaces.
    pub(super) fn stores_on_surfaces(self, kind: PhotonKind) -> bool {
        match kind {
            PhotonKind::Direct => self.direct,
            PhotonKind::Caustic => self.caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::AfterDirect => self.after_direct,
        }
    }

    /// True if photons of `kind` are stored in media.
    ///
    /// Direct photons are never stored in media: next-event estimation computes their light.
    pub(super) fn stores_in_media(self, kind: PhotonKind) -> bool {
        kind != PhotonKind::Direct && self.stores_on_surfaces(kind)
    }

    /// True if a path whose next photon would be of kind `kind` may deposit it or a later photon
    /// that the mask stores.
    pub(super) fn can_reach_stored_kind(self, kind: PhotonKind) -> bool {
        match kind {
            PhotonKind::Direct => true,
            PhotonKind::Caustic => self.caustic || self.after_caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::AfterDirect => self.after_direct,
        }
    }
}

/// One of this many paths continues after a caustic if [`StoreMask::separates_after_caustic`] is
/// set.
pub const AFTER_CAUSTIC_THINNING: u32 = 8;

impl PhotonKind {
    /// Kind of the path's next photon after the path has crossed a caster's boundary without a
    /// vertex there.
    pub(super) fn after_crossed_caster(self) -> Self {
        if self == Self::Direct { Self::Caustic } else { self }
    }

    /// Kind of the path's next photon after it scattered at a receiver or, if `is_receiver` is
    /// false, at a caster.
    pub(super) fn after_scattering(self, is_receiver: bool) -> Self {
        match (is_receiver, self) {
            (false, Self::Direct) => Self::Caustic,
            (false, other) => other,
            (true, Self::Direct | Self::AfterDirect) => Self::AfterDirect,
            (true, Self::Caustic | Self::AfterCaustic) => Self::AfterCaustic,
        }
    }
}
