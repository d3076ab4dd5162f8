//! Receivers and casters, kinds of photons by path history, and the mask that selects the kinds to
//! store.

/// Kind of a stored photon: direct, caustic or indirect, by the earlier vertices of its path.
///
/// - *Receiver*: a surface that stores photons, such as a matte one
///   ([`Bsdf::stores_photons`](crate::bsdf::Bsdf::stores_photons)), or a scattering event in a
///   medium.
/// - *Caster*: any other surface that is not black, such as glass or a mirror
///   ([`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics)). A path has no vertex on a thin
///   sheet that it crosses straight on, since shadow rays cross the sheet, too
///   ([`Bsdf::straight_transmittance`](crate::bsdf::Bsdf::straight_transmittance)).
/// - *Caustic*: light that goes from its source via one or more casters to a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonKind {
    /// Direct light: the path has no vertex between the light and the photon.
    Direct,
    /// Caustic: the path has one or more vertices between the light and the photon, all on casters
    /// (mirrors, glass and the like).
    Caustic,
    /// Indirect light of a caustic: the path has reached its first receiver (a surface or medium
    /// that stores photons) via one or more casters, such as glass, and has scattered there.
    AfterCaustic,
    /// Indirect light that does not come from a caustic: the path went straight from the light to
    /// its first receiver (a surface or medium that stores photons), and has scattered there. Later
    /// vertices may lie on casters, such as glass.
    AfterDirect,
}

/// Selects the kinds of photons that a photon pass stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreMask {
    /// True to store photons of direct light ([`PhotonKind::Direct`]).
    pub direct: bool,
    /// True to store caustic photons ([`PhotonKind::Caustic`]).
    pub caustic: bool,
    /// True to store photons of the indirect light that caustics cause
    /// ([`PhotonKind::AfterCaustic`]).
    pub after_caustic: bool,
    /// True to store photons of indirect light that does not come from caustics
    /// ([`PhotonKind::AfterDirect`]): their paths went straight from the light to a surface or
    /// medium that stores photons.
    pub after_direct: bool,
    /// True to store only one in [`AFTER_CAUSTIC_THINNING`] photons of
    /// [`PhotonKind::AfterCaustic`], in separate lists.
    ///
    /// The algorithm `hybrid` builds its map of indirect light from these photons, which saves a
    /// second photon pass. Few photons suffice, because this light is smooth. So Russian roulette
    /// ends most paths at their caustic photon. It continues one in [`AFTER_CAUSTIC_THINNING`]
    /// paths, and multiplies its flux by this number.
    pub separates_after_caustic: bool,
    /// True to store photon beams in homogeneous media; false to store photons at scattering
    /// points.
    pub stores_beams: bool,
}

impl StoreMask {
    /// Mask that stores only direct photons.
    pub const DIRECT: Self = Self { direct: true, ..Self::NONE };
    /// Mask that stores only caustic photons. Each path then ends at the first surface or medium
    /// that stores photons.
    pub const CAUSTIC: Self = Self { caustic: true, ..Self::NONE };
    /// Mask that stores only indirect light: photons whose paths have scattered at one or more
    /// surfaces that store photons, or in media.
    pub const INDIRECT: Self = Self { after_caustic: true, after_direct: true, ..Self::NONE };
    /// Mask that stores no photons. The field `stores_beams` is true, so that masks derived from
    /// this one store beams in homogeneous media by default.
    pub const NONE: Self = Self {
        direct: false,
        caustic: false,
        after_caustic: false,
        after_direct: false,
        separates_after_caustic: false,
        stores_beams: true,
    };
    /// Mask that stores photons of all four kinds.
    pub const ALL: Self = Self { direct: true, caustic: true, after_caustic: true, after_direct: true, ..Self::NONE };

    /// True if the mask stores photons of `kind` on surfaces.
    pub(super) fn stores_on_surfaces(self, kind: PhotonKind) -> bool {
        match kind {
            PhotonKind::Direct => self.direct,
            PhotonKind::Caustic => self.caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::AfterDirect => self.after_direct,
        }
    }

    /// True if the mask stores photons of `kind` in media.
    ///
    /// Direct photons are never stored in media: next-event estimation computes direct light.
    pub(super) fn stores_in_media(self, kind: PhotonKind) -> bool {
        kind != PhotonKind::Direct && self.stores_on_surfaces(kind)
    }

    /// True if a photon path may still store a photon under this mask. `kind` is the kind of its
    /// next photon.
    ///
    /// Always true for [`PhotonKind::Direct`], because such a path can still store photons of any
    /// kind.
    pub(super) fn can_reach_stored_kind(self, kind: PhotonKind) -> bool {
        match kind {
            PhotonKind::Direct => true,
            PhotonKind::Caustic => self.caustic || self.after_caustic,
            PhotonKind::AfterCaustic => self.after_caustic,
            PhotonKind::AfterDirect => self.after_direct,
        }
    }
}

/// Thinning factor of the indirect light of caustics: one in 8 photon paths continues after its
/// caustic photon, with 8 times the flux ([`StoreMask::separates_after_caustic`]).
pub const AFTER_CAUSTIC_THINNING: u32 = 8;

impl PhotonKind {
    /// Returns the kind of a path's later photons after the path has crossed the boundary of a
    /// caster, such as glass, without scattering there. `self` is the kind before the crossing.
    pub(super) fn kind_after_crossed_caster(self) -> Self {
        if self == Self::Direct { Self::Caustic } else { self }
    }

    /// Returns the kind of a path's later photons after the path has scattered. `self` is the kind
    /// before this scattering event.
    ///
    /// `is_receiver` is true if the path scattered at a receiver, such as a diffuse surface or a
    /// medium; false if at a caster, such as glass.
    pub(super) fn kind_after_scattering(self, is_receiver: bool) -> Self {
        match (is_receiver, self) {
            (false, Self::Direct) => Self::Caustic,
            (false, other) => other,
            (true, Self::Direct | Self::AfterDirect) => Self::AfterDirect,
            (true, Self::Caustic | Self::AfterCaustic) => Self::AfterCaustic,
        }
    }
}
