//! Materials of the resolved scene, from which the BSDF at a hit is made.

mod kind;

pub use kind::{ConductorIndex, MaterialKind, PhongAppearance};

use super::interiors::Body;
use super::textured::{MaterialParameter, MeanParameterEvaluator, NormalPerturbation, ParameterEvaluator};
use crate::bsdf::{Bsdf, ClearCoat, MicrofacetScattering};
use crate::color::Rgb;
use crate::texture::Texture;
use std::sync::Arc;

/// A surface material: the parameters of a scattering model, a perturbation of shading normals, and
/// possibly a clear coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    kind: MaterialKind,
    normal_perturbation: NormalPerturbation,
    clear_coat: Option<ClearCoatParameters>,
    /// The BSDF with textures replaced by their means. Untextured materials use it at each hit.
    mean_bsdf: Bsdf,
    /// True if a texture determines a parameter of the BSDF, or the amount of a mix.
    textured: bool,
    /// True if a hit may resolve to a BSDF that stores photons.
    may_store_photons: bool,
}

/// Parameters of a clear coat over a material.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ClearCoatParameters {
    /// Fraction of the surface that the coat covers, in \[0, 1].
    coverage: MaterialParameter<f32>,
    /// GGX roughness α of the coat, in \[0, 1]; 0 is smooth.
    alpha: f32,
}

impl Material {
    /// A material of `kind` with unperturbed normals.
    #[must_use]
    pub fn new(kind: MaterialKind) -> Self {
        let (mean_bsdf, textured) = (kind.bsdf(&MeanParameterEvaluator), kind.is_textured());
        let may_store_photons = mean_bsdf.stores_photons() || kind.roughness_decides_photon_storage();
        let (normal_perturbation, clear_coat) = (NormalPerturbation::None, None);
        Self { kind, normal_perturbation, clear_coat, mean_bsdf, textured, may_store_photons }
    }

    /// This material with another scattering model, and the same clear coat and perturbation of
    /// shading normals.
    fn with_kind(self, kind: MaterialKind) -> Self {
        if kind == self.kind {
            return self;
        }
        let uncoated = Self { normal_perturbation: self.normal_perturbation, ..Self::new(kind) };
        self.clear_coat.map_or(uncoated, |coat| uncoated.with_clear_coat(coat.coverage, coat.alpha))
    }

    /// This material under a clear coat of refractive index 1.5. The coat covers the fraction
    /// `coverage` of the surface, and has the GGX roughness `alpha` in \[0, 1].
    ///
    /// Only diffuse, coated diffuse and metal materials can have a clear coat. Other materials do
    /// not change; see [`ClearCoat::over`].
    #[must_use]
    pub fn with_clear_coat(self, coverage: impl Into<MaterialParameter<f32>>, alpha: f32) -> Self {
        let coat = ClearCoatParameters { coverage: coverage.into(), alpha };
        let coated = Self { clear_coat: Some(coat), textured: self.textured || coat.coverage.is_textured(), ..self };
        let mean_bsdf = coated.bsdf(&MeanParameterEvaluator);
        if mean_bsdf.base_under_clear_coat().is_none() { self } else { Self { mean_bsdf, ..coated } }
    }

    /// Returns a mix with `may_store_photons` recomputed: true if one of its components may store
    /// photons. Other materials are returned unchanged.
    ///
    /// `materials` is the list that the component indices of the mix refer to.
    pub(super) fn with_mix_photon_storage(self, materials: &[Self]) -> Self {
        let Some(parts) = self.mix_component_indices() else { return self };
        Self { may_store_photons: parts.into_iter().any(|part| materials[part as usize].may_store_photons), ..self }
    }

    /// This material with shading normals perturbed by `normal_perturbation`.
    #[must_use]
    pub fn with_normal_perturbation(self, normal_perturbation: NormalPerturbation) -> Self {
        Self { normal_perturbation, ..self }
    }

    /// A diffuse (Lambertian) material.
    #[must_use]
    pub fn diffuse(reflectance: impl Into<MaterialParameter<Rgb>>) -> Self {
        Self::new(MaterialKind::Diffuse { reflectance: reflectance.into() })
    }

    /// A thin sheet that reflects and transmits light diffusely.
    ///
    /// `reflectance` and `transmittance` lie in \[0, 1]. If their sum exceeds 1 in a color channel,
    /// both are divided by the largest sum; see [`crate::bsdf::DiffuseTransmission`].
    #[must_use]
    pub fn diffuse_transmission(
        reflectance: impl Into<MaterialParameter<Rgb>>,
        transmittance: impl Into<MaterialParameter<Rgb>>,
    ) -> Self {
        let (reflectance, transmittance) = (reflectance.into(), transmittance.into());
        Self::new(MaterialKind::DiffuseTransmission { reflectance, transmittance })
    }

    /// A Phong material: Lambertian coefficient `diffuse`, and a specular lobe with coefficient
    /// `specular` and exponent `shininess`. The BSDF is scaled to conserve energy (see
    /// [`crate::bsdf::Phong`]).
    #[must_use]
    pub fn phong(
        diffuse: impl Into<MaterialParameter<Rgb>>,
        specular: impl Into<MaterialParameter<Rgb>>,
        shininess: f32,
    ) -> Self {
        Self::new(MaterialKind::Phong { diffuse: diffuse.into(), specular: specular.into(), shininess })
    }

    /// A perfect mirror of `reflectance` in \[0, 1], per channel.
    #[must_use]
    pub fn mirror(reflectance: impl Into<MaterialParameter<Rgb>>) -> Self {
        Self::new(MaterialKind::Mirror { reflectance: reflectance.into() })
    }

    /// A smooth dielectric, such as clear glass: the boundary of a body with absolute refractive
    /// index `eta` and absorption coefficient `absorption` \[1/length].
    #[must_use]
    pub fn dielectric(eta: f32, absorption: Rgb) -> Self {
        Self::smooth_boundary(Body { absorption, ..Body::new(eta) })
    }

    /// A smooth dielectric boundary around `body`.
    #[must_use]
    pub fn smooth_boundary(body: Body) -> Self {
        Self::rough_boundary(body, 0.0)
    }

    /// A dielectric boundary around `body`, with GGX roughness α in \[0, 1]; 0 is smooth.
    #[must_use]
    pub fn rough_boundary(body: Body, roughness: impl Into<MaterialParameter<f32>>) -> Self {
        let (roughness, scattering) = (roughness.into(), MicrofacetScattering::Multiple);
        Self::new(MaterialKind::Dielectric { body, roughness, scattering })
    }

    /// A mix, which resolves at each hit to material `second` with probability `amount`, else to
    /// `first`.
    ///
    /// Both are indices of materials of the scene, which may be added after the mix. No mix may
    /// contain itself, directly or through other mixes.
    #[must_use]
    pub fn mix(first: u32, second: u32, amount: impl Into<MaterialParameter<f32>>) -> Self {
        Self::new(MaterialKind::Mix { first, second, amount: amount.into() })
    }

    /// A metal of complex refractive index `eta` + i`k` and GGX roughness α in \[0, 1]; 0 is
    /// smooth.
    #[must_use]
    pub fn conductor(eta: Rgb, k: Rgb, roughness: impl Into<MaterialParameter<f32>>) -> Self {
        Self::conductor_of_index(ConductorIndex::Complex { eta, k }, roughness)
    }

    /// A metal whose refractive index or reflectance is `index`, with GGX roughness α in \[0, 1].
    #[must_use]
    pub fn conductor_of_index(index: ConductorIndex, roughness: impl Into<MaterialParameter<f32>>) -> Self {
        let (roughness, scattering) = (roughness.into(), MicrofacetScattering::Multiple);
        Self::new(MaterialKind::Conductor { index, roughness, scattering })
    }

    /// This material with [`MicrofacetScattering::Single`]: light that meets a second microfacet is
    /// lost, as in pbrt-v4. Unchanged if it is neither a metal nor a dielectric boundary.
    #[must_use]
    pub fn with_single_microfacet_scattering(self) -> Self {
        self.with_kind(self.kind.with_single_microfacet_scattering())
    }

    /// A thin dielectric sheet, such as a window pane, of refractive index `eta`. `transmittance`
    /// in (0, 1] is its internal transmittance along the normal, without Fresnel reflection.
    #[must_use]
    pub fn thin_dielectric(eta: f32, transmittance: impl Into<MaterialParameter<Rgb>>) -> Self {
        Self::new(MaterialKind::ThinDielectric { eta, transmittance: transmittance.into() })
    }

    /// A diffuse base of `reflectance` in \[0, 1] under a dielectric coat, such as plastic.
    ///
    /// `eta` is the refractive index of the coat relative to the surroundings, from 1 to
    /// [`MAX_COAT_INDEX`](crate::bsdf::MAX_COAT_INDEX). `roughness` is the coat's GGX α in \[0, 1].
    /// If `nonlinear` is true, repeated reflection between coat and base deepens colours, as in
    /// nature; see [`CoatedDiffuse`](crate::bsdf::CoatedDiffuse).
    #[must_use]
    pub fn coated_diffuse(
        reflectance: impl Into<MaterialParameter<Rgb>>,
        eta: f32,
        roughness: impl Into<MaterialParameter<f32>>,
        nonlinear: bool,
    ) -> Self {
        let (reflectance, roughness) = (reflectance.into(), roughness.into());
        Self::new(MaterialKind::CoatedDiffuse { reflectance, eta, roughness, nonlinear })
    }

    /// A material that absorbs all light.
    #[must_use]
    pub fn black() -> Self {
        Self::new(MaterialKind::Black)
    }

    /// The scattering model of this material, with its parameters.
    #[must_use]
    pub fn kind(&self) -> &MaterialKind {
        &self.kind
    }

    /// The bump map or normal map that perturbs shading normals, or [`NormalPerturbation::None`].
    #[must_use]
    pub fn normal_perturbation(&self) -> NormalPerturbation {
        self.normal_perturbation
    }

    /// The dielectric body that a surface of this material encloses; `None` if it encloses none.
    #[inline]
    #[must_use]
    pub fn enclosed_body(&self) -> Option<&Body> {
        self.kind.as_dielectric().map(|(body, _)| body)
    }

    /// This material with the body that it bounds replaced by `body`; unchanged if the material
    /// bounds no body.
    #[must_use]
    pub fn with_body(self, body: Body) -> Self {
        self.with_kind(self.kind.with_body(body))
    }

    /// Material indices of both components of a mix; `None` for other materials.
    #[must_use]
    pub fn mix_component_indices(&self) -> Option<[u32; 2]> {
        self.kind.as_mix().map(|(parts, _)| parts)
    }

    /// The BSDF of this material with textures replaced by their means.
    #[inline]
    #[must_use]
    pub fn mean_bsdf(&self) -> Bsdf {
        self.mean_bsdf
    }

    /// The BSDF at a point, where `parameters` evaluates constant and textured parameters; black
    /// for a mix, which must be resolved to one of its components first.
    #[must_use]
    pub fn bsdf(&self, parameters: &impl ParameterEvaluator) -> Bsdf {
        let bsdf = self.kind.bsdf(parameters);
        match &self.clear_coat {
            None => bsdf,
            Some(coat) => ClearCoat::new(parameters.evaluate_scalar(&coat.coverage), coat.alpha).over(bsdf),
        }
    }

    /// True if a texture determines a parameter of the BSDF, or the amount of a mix.
    #[inline]
    #[must_use]
    pub fn is_textured(&self) -> bool {
        self.textured
    }

    /// True if the BSDF at a hit may be chosen at random: from the components of a mix, or from
    /// coat and base.
    #[inline]
    pub(super) fn chooses_bsdf_randomly(&self) -> bool {
        self.kind.chooses_bsdf_randomly() || self.clear_coat.is_some()
    }

    /// True if photons may be stored at some hits on this material. For a mix: true if this holds
    /// for a component.
    #[inline]
    pub(super) fn may_store_photons(&self) -> bool {
        self.may_store_photons
    }

    /// True if textures determine BSDF parameters, the amount of a mix or the shading normal, so
    /// that each hit must evaluate textures.
    #[inline]
    pub(super) fn needs_textures(&self) -> bool {
        self.textured || self.normal_perturbation != NormalPerturbation::None
    }

    /// Roughness α of a dielectric boundary, with a texture replaced by its mean; 0 for other
    /// materials.
    #[inline]
    pub(super) fn mean_boundary_roughness(&self) -> f32 {
        self.boundary_roughness(&MeanParameterEvaluator)
    }

    /// Single or multiple scattering between the microfacets of a rough dielectric boundary;
    /// `Multiple` for other materials.
    #[inline]
    pub(super) fn boundary_microfacet_scattering(&self) -> MicrofacetScattering {
        if let MaterialKind::Dielectric { scattering, .. } = self.kind {
            scattering
        } else {
            MicrofacetScattering::Multiple
        }
    }

    /// Roughness α of a dielectric boundary at a point, evaluated by `parameters`; 0 for other
    /// materials.
    #[inline]
    pub(super) fn boundary_roughness(&self, parameters: &impl ParameterEvaluator) -> f32 {
        self.kind.as_dielectric().map_or(0.0, |(_, roughness)| parameters.evaluate_scalar(roughness))
    }

    /// Calls `visit` with at least one BSDF of each kind that the material can have at a hit. Two
    /// BSDFs are of different kinds if only one of them is specular, only one stores photons, or
    /// only one transmits.
    ///
    /// The visited BSDFs have mean parameters. A conductor or coat with a roughness texture is also
    /// visited with its least and its greatest roughness. A coat that is too smooth to store
    /// photons is also visited alone, without its base: its α is at most
    /// [`MIN_PHOTON_STORAGE_ALPHA`](crate::bsdf::MIN_PHOTON_STORAGE_ALPHA). For a clear coat of any
    /// roughness, the coat alone and the surface under it are also visited.
    pub(super) fn visit_bsdf_variants(&self, textures: &[Arc<Texture>], mut visit: impl FnMut(Bsdf)) {
        let mut visit = |bsdf: Bsdf| {
            visit(bsdf);
            bsdf.coat_if_separate().into_iter().for_each(&mut visit);
        };
        visit(self.mean_bsdf);
        self.mean_bsdf.base_under_clear_coat().into_iter().for_each(&mut visit);
        self.kind.visit_extreme_roughness_bsdfs(textures, visit);
    }
}

#[cfg(test)]
mod tests;
