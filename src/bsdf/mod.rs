//! Bidirectional scattering distribution functions (BSDFs).
//!
//! Directions are unit vectors in world space that point away from the surface: `wo` to the
//! previous vertex of the path, `wi` to the next one. `ns` is the shading normal, `ng` the
//! geometric normal. Both normals are on the outer side of the surface.
//!
//! To add a BSDF and its material:
//!
//! - add a file in this folder, and a variant of [`Bsdf`] in this file; `Bsdf::properties` states
//!   whether it stores photons, transmits, and so on;
//! - add a variant of `MaterialKind` in `scene/material/kind.rs`;
//! - add a file in `format/materials/kinds/`, and its line in `format/materials/kinds/mod.rs`.

mod adjoint;
mod clear_coat;
mod coat_albedo;
mod coated_diffuse;
mod conductor;
mod dielectric;
mod diffuse_transmission;
mod fresnel;
mod lossy_coat;
mod metals;
mod microfacet;
mod multiple_scattering;
mod phong;
mod properties;
mod rough_dielectric;
mod sample;
mod thin;

pub use adjoint::{deposit_shading_normal_correction, shading_normal_correction};
pub use clear_coat::{ClearCoat, ClearCoated};
pub use coat_albedo::MAX_COAT_INDEX;
pub use coated_diffuse::{CoatedDiffuse, DielectricCoat};
pub use conductor::{Conductor, conductor_index_of_reflectance};
pub use dielectric::{Dielectric, DielectricSplit};
pub use diffuse_transmission::DiffuseTransmission;
pub use fresnel::{Refraction, conductor_reflectance, dielectric_reflectance_and_cosine, refract};
pub use lossy_coat::LossyCoat;
pub use metals::{METAL_NAMES, metal_refractive_index};
pub use multiple_scattering::MicrofacetScattering;
pub use phong::Phong;
pub(crate) use properties::DIFFUSE_CONE_SPREAD;
pub use properties::MIN_PHOTON_STORAGE_ALPHA;
pub use rough_dielectric::RoughDielectric;
pub use sample::BsdfSample;
pub use thin::ThinDielectric;

use crate::color::Rgb;
use crate::math::warp;
use clear_coat::CoatableBsdf;
use coated_diffuse::MIN_COAT_INDEX;
use glam::{Vec2, Vec3};
use properties::BsdfProperties;
use sample::NonSpecularSample;
use std::f32::consts::FRAC_1_PI;

/// Smallest GGX roughness α of a rough surface. A surface with a smaller α is smooth: it has only
/// delta lobes.
pub const MIN_ROUGH_ALPHA: f32 = 1e-3;

/// Width of a rough dielectric's refracted lobe \[radians], below which the dielectric counts as
/// smooth.
///
/// The width is about ten rounding errors of a unit vector in f32.
const MIN_LOBE_WIDTH: f32 = 1e-6;

/// The quantity that a path carries when a BSDF scatters it: radiance on camera paths, flux on
/// photon paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// Radiance, on camera paths. Refraction scales radiance by the squared relative index.
    Radiance,
    /// Flux, on photon paths. Refraction does not scale flux.
    Importance,
}

/// The BSDF at one point of a surface.
///
/// A BSDF that is not black either stores photons ([`stores_photons`](Self::stores_photons)) or
/// casts caustics ([`casts_caustics`](Self::casts_caustics)), never both. A BSDF that stores
/// photons has no delta lobe, because photon estimates would miss the light of that lobe. The
/// samples of such BSDFs have a private type that cannot describe a delta lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// A surface that absorbs all light.
    Black,
    /// Lambertian reflection on both sides; the value is the reflectance.
    Diffuse(Rgb),
    /// Lambertian reflection and transmission, on both sides.
    DiffuseTransmission(DiffuseTransmission),
    /// Lambertian reflection plus a Phong lobe, on both sides.
    Phong(Phong),
    /// Mirror reflection on both sides; the value is the reflectance.
    Mirror(Rgb),
    /// A smooth interface between two transparent media.
    Dielectric(Dielectric),
    /// A smooth or rough metal, which reflects on both sides.
    Conductor(Conductor),
    /// A rough interface between two transparent media.
    RoughDielectric(RoughDielectric),
    /// A thin transparent sheet, such as a window pane.
    ThinDielectric(ThinDielectric),
    /// A diffuse base under a dielectric coat.
    ///
    /// Reflection on the coat is included only if the coat's roughness α exceeds
    /// [`MIN_PHOTON_STORAGE_ALPHA`].
    CoatedDiffuse(CoatedDiffuse),
    /// Reflection on a dielectric coat, without the base under it.
    ///
    /// [`Bsdf::select_layer`] returns this BSDF for a clear coat of any roughness. For a coat over
    /// a diffuse base, it does so only if the coat's roughness α is at most
    /// [`MIN_PHOTON_STORAGE_ALPHA`].
    DielectricCoat(DielectricCoat),
    /// A surface under a clear coat, weakened by the coat's transmittance.
    ///
    /// Reflection on the coat itself is not included: [`Bsdf::select_layer`] chooses the surface or
    /// the coat.
    ClearCoated(ClearCoated),
}

impl Bsdf {
    /// Creates a dielectric interface with GGX roughness `alpha` in \[0, 1].
    ///
    /// `eta` is the refractive index of the inside, relative to the outside. `scattering` says
    /// whether light scatters between microfacets. The interface is smooth if `alpha` is below
    /// [`MIN_ROUGH_ALPHA`], or if `eta` is so near to 1 that roughness has no effect.
    #[must_use]
    pub fn dielectric(eta: f32, alpha: f32, scattering: MicrofacetScattering) -> Self {
        if alpha < MIN_ROUGH_ALPHA || alpha * (eta - 1.0).abs() < MIN_LOBE_WIDTH {
            Self::Dielectric(Dielectric { eta })
        } else {
            Self::RoughDielectric(RoughDielectric::new(eta, alpha, scattering))
        }
    }

    /// Creates a Phong BRDF from coefficients ≥ 0 and the exponent `shininess` ≥ 0, scaled to
    /// conserve energy.
    ///
    /// The BRDF is Lambertian if `specular` is zero.
    #[must_use]
    pub fn phong(diffuse: Rgb, specular: Rgb, shininess: f32) -> Self {
        if specular == Rgb::ZERO {
            Self::Diffuse(diffuse / diffuse.max_element().max(1.0))
        } else {
            Self::Phong(Phong::new(diffuse, specular, shininess))
        }
    }

    /// Creates a diffuse surface of `reflectance` in \[0, 1] under a dielectric coat.
    ///
    /// `eta` in \[1, 4] is the coat's index relative to the surroundings, `alpha` in \[0, 1] its
    /// GGX roughness. If `nonlinear` is true, interreflection between coat and base makes colors
    /// more saturated. The BSDF is Lambertian if `eta` is so near to 1 that the coat has no effect.
    #[must_use]
    pub fn coated_diffuse(reflectance: Rgb, eta: f32, alpha: f32, nonlinear: bool) -> Self {
        if eta < MIN_COAT_INDEX {
            Self::Diffuse(reflectance)
        } else {
            Self::CoatedDiffuse(CoatedDiffuse::new(reflectance, eta, alpha, nonlinear))
        }
    }

    /// Returns the properties of the BSDF.
    ///
    /// For a surface under a clear coat, they are those of the surface, except that it counts as
    /// not black.
    #[inline]
    fn properties(&self) -> BsdfProperties {
        match self {
            Self::Black => BsdfProperties::BLACK,
            Self::Diffuse(reflectance) => {
                BsdfProperties { is_black: *reflectance == Rgb::ZERO, ..BsdfProperties::DIFFUSE }
            }
            Self::DiffuseTransmission(sheet) => {
                BsdfProperties { is_black: sheet.is_black(), transmits: true, ..BsdfProperties::DIFFUSE }
            }
            Self::Phong(_) => BsdfProperties::RECEIVER,
            Self::Mirror(_) => BsdfProperties::SPECULAR,
            Self::Dielectric(_) | Self::ThinDielectric(_) => {
                BsdfProperties { transmits: true, ..BsdfProperties::SPECULAR }
            }
            Self::Conductor(conductor) => conductor.properties(),
            Self::RoughDielectric(glass) => BsdfProperties {
                transmits: true,
                ray_cone_spread: glass.alpha() * DIFFUSE_CONE_SPREAD,
                ..BsdfProperties::CASTER
            },
            Self::CoatedDiffuse(_) => BsdfProperties::DIFFUSE,
            Self::DielectricCoat(coat) => coat.properties(),
            Self::ClearCoated(coated) => coated.properties(),
        }
    }

    /// Converts the BSDF to the type of surfaces under a clear coat; `None` if the BSDF cannot lie
    /// under a clear coat.
    fn to_coatable(self) -> Option<CoatableBsdf> {
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

    /// Returns the base or the coat of a coated surface, chosen at random by `u` in \[0, 1). A
    /// small `u` chooses the base.
    ///
    /// The probabilities depend on `wo` and the shading normal `ns`. The returned BSDF is divided
    /// by its probability. A BSDF without a coat is returned unchanged. So is a diffuse base whose
    /// coat has a roughness α above [`MIN_PHOTON_STORAGE_ALPHA`], because that BSDF includes its
    /// coat.
    #[inline]
    #[must_use]
    pub fn select_layer(self, wo: Vec3, ns: Vec3, u: f32) -> Self {
        match self {
            Self::CoatedDiffuse(coated) => coated.select_layer(wo, ns, u),
            Self::ClearCoated(coated) => coated.select_layer(wo, ns, u),
            Self::Black
            | Self::Diffuse(_)
            | Self::DiffuseTransmission(_)
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::DielectricCoat(_) => self,
        }
    }

    /// Returns the surface under a clear coat, without the coat; `None` for a surface without a
    /// clear coat.
    #[must_use]
    pub fn base_under_clear_coat(&self) -> Option<Self> {
        if let Self::ClearCoated(coated) = self { Some(coated.base()) } else { None }
    }

    /// Returns the coat alone as a BSDF, if [`Bsdf::select_layer`] treats coat and base separately;
    /// else `None`.
    ///
    /// A clear coat, such as lacquer on metal, is always separate. The coat of a diffuse base, such
    /// as plastic, is separate if its roughness α is at most [`MIN_PHOTON_STORAGE_ALPHA`]. The
    /// returned BSDF is not divided by a selection probability.
    #[must_use]
    pub fn coat_if_separate(&self) -> Option<Self> {
        match self {
            Self::CoatedDiffuse(coated) => coated.coat_if_separate().map(Self::DielectricCoat),
            Self::ClearCoated(coated) => Some(Self::DielectricCoat(coated.coat())),
            Self::Black
            | Self::Diffuse(_)
            | Self::DiffuseTransmission(_)
            | Self::Phong(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::DielectricCoat(_) => None,
        }
    }

    /// Returns one lobe of the BSDF, selected by `u` in \[0, 1) and divided by its probability.
    ///
    /// Only a Phong BSDF is split, into its diffuse and its glossy lobe. Any other BSDF is returned
    /// unchanged.
    #[inline]
    #[must_use]
    pub fn select_lobe(self, u: f32) -> Self {
        match self {
            Self::Phong(phong) => phong.select_lobe(u),
            Self::Black
            | Self::Diffuse(_)
            | Self::DiffuseTransmission(_)
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::Conductor(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::CoatedDiffuse(_)
            | Self::DielectricCoat(_)
            | Self::ClearCoated(_) => self,
        }
    }

    /// BSDF f(wo, wi) \[1/sr], without the cosine; 0 for delta lobes.
    ///
    /// The value is also 0 if the shading normal `ns` and the geometric normal `ng` disagree on
    /// whether `wo` and `wi` lie on one side of the surface.
    #[inline]
    #[must_use]
    pub fn evaluate(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3, transport: TransportMode) -> Rgb {
        let Some(crosses) = directions_cross_surface(wo, wi, ns, ng) else { return Rgb::ZERO };
        if crosses && !self.transmits() {
            return Rgb::ZERO;
        }
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => Rgb::ZERO,
            Self::RoughDielectric(glass) => glass.evaluate(wo, wi, face_forward(ns, wo), ng, transport),
            Self::Diffuse(reflectance) => *reflectance * FRAC_1_PI,
            Self::DiffuseTransmission(sheet) => sheet.evaluate(crosses),
            Self::Phong(phong) => phong.evaluate(wo, wi, ns),
            Self::Conductor(conductor) => conductor.evaluate(wo, wi, ns),
            Self::CoatedDiffuse(coated) => coated.evaluate(wo, wi, ns),
            Self::DielectricCoat(coat) => coat.evaluate(wo, wi, ns),
            Self::ClearCoated(coated) => coated.evaluate(wo, wi, ns),
        }
    }

    /// Solid-angle pdf \[1/sr] with which [`Bsdf::sample`] samples `wi`, given `wo`; 0 for delta
    /// lobes.
    ///
    /// The pdf is the same for both transport modes.
    #[inline]
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        let Some(crosses) = directions_cross_surface(wo, wi, ns, ng) else { return 0.0 };
        if crosses && !self.transmits() {
            return 0.0;
        }
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => 0.0,
            Self::RoughDielectric(glass) => glass.pdf(wo, wi, face_forward(ns, wo), ng),
            Self::Diffuse(_) => warp::cosine_hemisphere_pdf(wi.dot(ns).abs()),
            Self::DiffuseTransmission(sheet) => sheet.pdf(wi.dot(ns).abs(), crosses),
            Self::Phong(phong) => phong.pdf(wo, wi, ns),
            Self::Conductor(conductor) => conductor.pdf(wo, wi, ns),
            Self::CoatedDiffuse(coated) => coated.pdf(wo, wi, ns),
            Self::DielectricCoat(coat) => coat.pdf(wo, wi, ns),
            Self::ClearCoated(coated) => coated.pdf(wo, wi, ns),
        }
    }

    /// Samples the direction in which a path continues; `None` if the path is absorbed.
    ///
    /// `lobe` in \[0, 1) selects the lobe, and `u` in \[0, 1)² the direction. With respect to `ng`,
    /// reflected directions are on the side of `wo` and transmitted directions on the other side.
    #[inline]
    #[must_use]
    pub fn sample(
        &self,
        wo: Vec3,
        ns: Vec3,
        ng: Vec3,
        lobe: f32,
        u: Vec2,
        transport: TransportMode,
    ) -> Option<BsdfSample> {
        let facing_ns = face_forward(ns, wo);
        let sample = if self.stores_photons() {
            self.sample_receiver_bsdf(wo, facing_ns, lobe, u)?.into()
        } else {
            self.sample_caster_bsdf(wo, ns, ng, lobe, u, transport)?
        };
        let crosses = (sample.wi.dot(ng) < 0.0) != (wo.dot(ng) < 0.0);
        (crosses == sample.is_transmitted).then_some(sample)
    }

    /// Returns the reflected and the refracted direction for `wo` at a smooth dielectric; `None`
    /// for all other BSDFs.
    #[inline]
    #[must_use]
    pub fn reflect_and_refract(
        &self,
        wo: Vec3,
        ns: Vec3,
        ng: Vec3,
        transport: TransportMode,
    ) -> Option<DielectricSplit> {
        if let Self::Dielectric(dielectric) = self {
            Some(dielectric.reflect_and_refract(wo, ns, ng, transport))
        } else {
            None
        }
    }

    /// Samples the direction in which a path continues, if this BSDF stores photons. Returns `None`
    /// if the BSDF stores no photons, or if the path is absorbed.
    ///
    /// The unit normal `facing_ns` is the shading normal on the side of `wo`. `lobe` in \[0, 1)
    /// selects the lobe, and `u` in \[0, 1)² the direction.
    #[inline]
    fn sample_receiver_bsdf(&self, wo: Vec3, facing_ns: Vec3, lobe: f32, u: Vec2) -> Option<NonSpecularSample> {
        match self {
            Self::Diffuse(reflectance) => NonSpecularSample::lambertian_sample(*reflectance, facing_ns, u),
            Self::DiffuseTransmission(sheet) => sheet.sample(facing_ns, lobe, u),
            Self::Phong(phong) => phong.sample(wo, facing_ns, lobe, u),
            Self::Conductor(conductor) => conductor.sample_rough(wo, facing_ns, lobe, u),
            Self::CoatedDiffuse(coated) => coated.sample(wo, facing_ns, lobe, u),
            Self::ClearCoated(coated) => coated.sample_receiver(wo, facing_ns, lobe, u),
            Self::Black
            | Self::Mirror(_)
            | Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::DielectricCoat(_) => None,
        }
    }

    /// Samples the direction in which a path continues, if this BSDF stores no photons. Returns
    /// `None` if the BSDF stores photons, or if the path is absorbed.
    ///
    /// The arguments are those of [`Bsdf::sample`].
    #[inline]
    fn sample_caster_bsdf(
        &self,
        wo: Vec3,
        ns: Vec3,
        ng: Vec3,
        lobe: f32,
        u: Vec2,
        transport: TransportMode,
    ) -> Option<BsdfSample> {
        let facing_ns = face_forward(ns, wo);
        match self {
            Self::Black | Self::Diffuse(_) | Self::DiffuseTransmission(_) | Self::Phong(_) | Self::CoatedDiffuse(_) => {
                None
            }
            Self::Mirror(reflectance) => {
                let (wi, uses_geometric_normal) = dielectric::reflect_above_surface(wo, facing_ns, ng);
                Some(BsdfSample::specular_sample(wi, *reflectance, false, uses_geometric_normal))
            }
            Self::Dielectric(dielectric) => Some(dielectric.sample(wo, ns, ng, lobe, transport)),
            Self::Conductor(conductor) => conductor.sample(wo, facing_ns, ng, lobe, u),
            Self::RoughDielectric(glass) => glass.sample(wo, facing_ns, ng, lobe, u, transport),
            Self::ThinDielectric(thin) => thin.sample(wo, facing_ns, ng, lobe),
            Self::DielectricCoat(coat) => coat.sample(wo, facing_ns, ng, u),
            Self::ClearCoated(coated) => coated.sample_caster(wo, facing_ns, ng, lobe, u),
        }
    }
}

/// Returns `n` or −`n`, whichever is on the side of `wo`.
#[inline]
fn face_forward(n: Vec3, wo: Vec3) -> Vec3 {
    if wo.dot(n) < 0.0 { -n } else { n }
}

/// True if `wo` and `wi` lie on different sides of the surface.
///
/// Returns `None` if the answer differs between the shading normal `ns` and the geometric normal
/// `ng`.
#[inline]
fn directions_cross_surface(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> Option<bool> {
    let (shading, geometric) = (wo.dot(ns) * wi.dot(ns), wo.dot(ng) * wi.dot(ng));
    if shading > 0.0 && geometric > 0.0 {
        Some(false)
    } else if shading < 0.0 && geometric < 0.0 {
        Some(true)
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
