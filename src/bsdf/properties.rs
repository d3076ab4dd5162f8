//! Properties of BSDFs, and what follows from them. One `match`, [`Bsdf::properties`] in `mod.rs`,
//! states the properties of each kind of BSDF.

use super::{Bsdf, ThinDielectric, face_forward};
use crate::color::Rgb;
use glam::Vec3;

/// Threshold of the GGX roughness α: photons are stored on a conductor, or on a coat over a diffuse
/// base, only if its α exceeds this value.
///
/// Photon estimates then include the light that the conductor or coat reflects. A smoother one
/// casts caustics instead; [`Bsdf::select_layer`] splits such a coat from its base.
pub const MIN_PHOTON_STORAGE_ALPHA: f32 = 0.3;

/// Tangent of the angle by which diffuse scattering widens the ray cone of a path. The cone sets
/// the filter width of texture lookups.
pub(crate) const DIFFUSE_CONE_SPREAD: f32 = 0.2;

/// Properties by which integrators distinguish BSDFs.
#[derive(Clone, Copy, Debug)]
pub(super) struct BsdfProperties {
    /// True if the BSDF scatters no light.
    pub is_black: bool,
    /// True if the BSDF is Lambertian, or has a Lambertian base under a coat.
    pub is_diffuse_or_coated: bool,
    /// True if the BSDF scatters light only in delta lobes.
    pub is_specular: bool,
    /// True if the BSDF has a transmitted lobe.
    pub transmits: bool,
    /// True if photons are stored on the surface.
    pub stores_photons: bool,
    /// Tangent of the angle by which scattering widens the ray cone of texture filtering.
    pub ray_cone_spread: f32,
}

impl BsdfProperties {
    /// Properties of a surface that absorbs all light. Other BSDFs state what differs from it.
    pub const BLACK: Self = Self {
        is_black: true,
        is_diffuse_or_coated: false,
        is_specular: false,
        transmits: false,
        stores_photons: false,
        ray_cone_spread: 0.0,
    };
    /// Properties of a BSDF that casts caustics by reflection. If the lobe is rough, the BSDF also
    /// states its cone spread.
    pub const CASTER: Self = Self { is_black: false, ..Self::BLACK };
    /// Properties of a BSDF that scatters light only in delta lobes, all of them by reflection.
    pub const SPECULAR: Self = Self { is_specular: true, ..Self::CASTER };
    /// Properties of a BSDF that stores photons, and that scatters light into wide lobes of
    /// reflection.
    pub const RECEIVER: Self = Self { stores_photons: true, ray_cone_spread: DIFFUSE_CONE_SPREAD, ..Self::CASTER };
    /// Properties of a Lambertian BSDF, and of one with a Lambertian base under a coat.
    pub const DIFFUSE: Self = Self { is_diffuse_or_coated: true, ..Self::RECEIVER };
}

impl Bsdf {
    /// True if the BSDF is [`Bsdf::Black`], or a diffuse BSDF that scatters no light.
    ///
    /// Other BSDFs count as not black, even a mirror of reflectance 0.
    #[inline]
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.properties().is_black
    }

    /// True if the BSDF is Lambertian (reflecting, or also transmitting), or has a Lambertian base
    /// under a coat.
    #[inline]
    #[must_use]
    pub fn is_diffuse_or_coated(&self) -> bool {
        self.properties().is_diffuse_or_coated
    }

    /// True if the BSDF scatters light only in delta lobes. For a surface under a clear coat, only
    /// the surface counts, not the coat.
    #[inline]
    #[must_use]
    pub fn is_specular(&self) -> bool {
        self.properties().is_specular
    }

    /// True if the BSDF has a transmitted lobe.
    #[inline]
    #[must_use]
    pub fn transmits(&self) -> bool {
        self.properties().transmits
    }

    /// Transmittance for light that crosses the surface without a change of direction; `None` if
    /// the surface does not transmit in this way.
    ///
    /// Only a [`ThinDielectric`] does. Shadow rays cross it, so light that it transmits counts as
    /// direct light, not as a caustic.
    #[inline]
    #[must_use]
    pub fn straight_transmittance(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> Option<Rgb> {
        self.as_thin_dielectric().map(|thin| thin.straight_transmittance(wo, face_forward(ns, wo), ng))
    }

    /// True if the surface transmits light without a change of direction, so that shadow rays cross
    /// it: see [`Bsdf::straight_transmittance`].
    #[inline]
    #[must_use]
    pub fn transmits_straight(&self) -> bool {
        self.as_thin_dielectric().is_some()
    }

    #[inline]
    fn as_thin_dielectric(&self) -> Option<&ThinDielectric> {
        if let Self::ThinDielectric(thin) = self { Some(thin) } else { None }
    }

    /// True if photons are stored on the surface. Density estimates then evaluate this BSDF.
    ///
    /// Diffuse BSDFs store photons, with or without transmission or a coat. So do Phong BSDFs, and
    /// conductors rougher than [`MIN_PHOTON_STORAGE_ALPHA`]. On smoother conductors, few photons
    /// fall into the lobe, so BSDF sampling has less noise. Dielectrics store none, because a
    /// density estimate would blur the objects behind them.
    #[inline]
    #[must_use]
    pub fn stores_photons(&self) -> bool {
        self.properties().stores_photons
    }

    /// True if the BSDF is a caustic caster: it scatters light, but stores no photons.
    ///
    /// Mirrors, dielectrics, thin dielectrics and clear coats are casters at any roughness.
    /// Conductors, and coats over a diffuse base, are casters if their roughness α is at most
    /// [`MIN_PHOTON_STORAGE_ALPHA`]. For a coated surface, the result describes the base:
    /// [`Bsdf::select_layer`] returns the coat as another BSDF. A thin dielectric casts only the
    /// light that it reflects: see [`Bsdf::straight_transmittance`].
    #[inline]
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        let properties = self.properties();
        !properties.stores_photons && !properties.is_black
    }

    /// Tangent of the angle by which scattering widens the ray cone of texture filtering; 0 for
    /// delta lobes.
    ///
    /// The angle is only about a fifth of the lobe's width: many paths sample the lobe, so each
    /// path needs to filter only its own part of the texture.
    #[inline]
    #[must_use]
    pub fn ray_cone_spread(&self) -> f32 {
        self.properties().ray_cone_spread
    }
}
