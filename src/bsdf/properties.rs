//! Properties of BSDFs: which lobes a BSDF has, whether a clear coat can lie over it, whether
//! photons are stored on the surface, and how far it widens ray cones.

use super::clear_coat::CoatableBsdf;
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

impl Bsdf {
    /// True if the BSDF is [`Bsdf::Black`], or a diffuse BSDF that scatters no light.
    ///
    /// Other BSDFs count as not black, even a mirror of reflectance 0.
    #[inline]
    #[must_use]
    pub fn is_black(&self) -> bool {
        match self {
            Self::Black => true,
            Self::Diffuse(reflectance) => *reflectance == Rgb::ZERO,
            Self::DiffuseTransmission(sheet) => sheet.is_black(),
            Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::CoatedDiffuse(_)
            | Self::DielectricCoat(_)
            | Self::ClearCoated(_) => false,
        }
    }

    /// True if the BSDF is Lambertian (reflecting, or also transmitting), or has a Lambertian base
    /// under a coat.
    #[inline]
    #[must_use]
    pub fn is_diffuse_or_coated(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::DiffuseTransmission(_) | Self::CoatedDiffuse(_) => true,
            Self::ClearCoated(coated) => coated.is_diffuse_or_coated(),
            Self::Black
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::DielectricCoat(_) => false,
        }
    }

    /// Converts the BSDF to the type of surfaces under a clear coat; `None` if the BSDF cannot lie
    /// under a clear coat.
    pub(super) fn to_coatable(self) -> Option<CoatableBsdf> {
        match self {
            Self::Diffuse(reflectance) => Some(CoatableBsdf::Diffuse(reflectance)),
            Self::CoatedDiffuse(coated) => Some(CoatableBsdf::CoatedDiffuse(coated)),
            Self::DielectricCoat(coat) => Some(CoatableBsdf::DielectricCoat(coat)),
            Self::Conductor(conductor) => Some(CoatableBsdf::Conductor(conductor)),
            Self::Black
            | Self::DiffuseTransmission(_)
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::ClearCoated(_) => None,
        }
    }

    /// True if the BSDF scatters light only in delta lobes. For a surface under a clear coat, only
    /// the surface counts, not the coat.
    #[inline]
    #[must_use]
    pub fn is_specular(&self) -> bool {
        match self {
            Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => true,
            Self::Conductor(conductor) => conductor.is_smooth(),
            Self::DielectricCoat(coat) => coat.alpha() == 0.0,
            Self::ClearCoated(coated) => coated.is_specular(),
            Self::Black
            | Self::Diffuse(_)
            | Self::DiffuseTransmission(_)
            | Self::Phong(_)
            | Self::RoughDielectric(_)
            | Self::CoatedDiffuse(_) => false,
        }
    }

    /// True if the BSDF has a transmitted lobe.
    #[inline]
    #[must_use]
    pub fn transmits(&self) -> bool {
        match self {
            Self::Dielectric(_) | Self::RoughDielectric(_) | Self::ThinDielectric(_) | Self::DiffuseTransmission(_) => {
                true
            }
            Self::Black
            | Self::Diffuse(_)
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Conductor(_)
            | Self::CoatedDiffuse(_)
            | Self::DielectricCoat(_)
            | Self::ClearCoated(_) => false,
        }
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
        match self {
            Self::Diffuse(_) | Self::DiffuseTransmission(_) | Self::Phong(_) | Self::CoatedDiffuse(_) => true,
            Self::Conductor(conductor) => conductor.stores_photons(),
            Self::ClearCoated(coated) => coated.stores_photons(),
            Self::Black
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::DielectricCoat(_) => false,
        }
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
        !self.stores_photons() && !self.is_black()
    }

    /// Tangent of the angle by which scattering widens the ray cone of texture filtering; 0 for
    /// delta lobes.
    ///
    /// The angle is only about a fifth of the lobe's width: many paths sample the lobe, so each
    /// path needs to filter only its own part of the texture.
    #[inline]
    #[must_use]
    pub fn ray_cone_spread(&self) -> f32 {
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => 0.0,
            Self::Diffuse(_) | Self::DiffuseTransmission(_) | Self::Phong(_) | Self::CoatedDiffuse(_) => {
                DIFFUSE_CONE_SPREAD
            }
            Self::DielectricCoat(coat) => coat.alpha() * DIFFUSE_CONE_SPREAD,
            Self::ClearCoated(coated) => coated.ray_cone_spread(),
            Self::Conductor(conductor) => conductor.alpha() * DIFFUSE_CONE_SPREAD,
            Self::RoughDielectric(glass) => glass.alpha() * DIFFUSE_CONE_SPREAD,
        }
    }
}
