//! Materials of the resolved scene.

use super::interiors::Body;
use super::textured::{MaterialParameter, MeanParameterEvaluator, NormalPerturbation, ParameterEvaluator};
use crate::bsdf::{
    Bsdf, ClearCoat, Conductor, DiffuseTransmission, MicrofacetScattering, ThinDielectric,
    conductor_index_of_reflectance, conductor_reflectance, dielectric_reflectance_and_cosine,
};
use crate::color::Rgb;
use crate::texture::Texture;
use std::sync::Arc;

/// A surface material: the parameters of a scattering model, and a perturbation of shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    kind: MaterialKind,
    normal_perturbation: NormalPerturbation,
    clear_coat: Option<ClearCoatParameters>,
    /// The BSDF with textures replaced by their means. Untextured materials use it at each hit.
    mean_bsdf: Bsdf,
    /// True if a texture determines a parameter of the BSDF.
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

/// The scattering model of a material, with its parameters.
///
/// For a new kind, the compiler asks for an arm in each match, but not for the right one. If the
/// roughness decides whether the surface stores photons, `roughness_decides_photon_storage` is
/// true, and `bsdf` reads the roughness by `evaluate_photon_storage_roughness`: camera and photon
/// paths must find the same kind of BSDF at a point. `visit_bsdf_variants` visits each BSDF that a
/// texture can make of it. A coat over a base needs `chooses_bsdf_randomly`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialKind {
    /// A surface that absorbs all light.
    Black,
    /// Lambertian reflection on both sides.
    Diffuse {
        /// Diffuse reflectance in \[0, 1], per channel.
        reflectance: MaterialParameter<Rgb>,
    },
    /// Lambertian reflection and transmission: a thin sheet, such as paper or a leaf.
    DiffuseTransmission {
        /// Diffuse reflectance in \[0, 1], per channel.
        reflectance: MaterialParameter<Rgb>,
        /// Diffuse transmittance in \[0, 1], per channel.
        transmittance: MaterialParameter<Rgb>,
    },
    /// Lambertian reflection plus a Phong lobe.
    Phong {
        /// Diffuse coefficient kd of Phong's model.
        diffuse: MaterialParameter<Rgb>,
        /// Specular coefficient ks of Phong's model.
        specular: MaterialParameter<Rgb>,
        /// Exponent of the specular lobe of Phong's model.
        shininess: f32,
    },
    /// Perfect specular reflection.
    Mirror {
        /// Reflectance of the mirror in \[0, 1], per channel.
        reflectance: MaterialParameter<Rgb>,
    },
    /// A metal, smooth or rough.
    Conductor {
        /// Refractive index of the metal.
        index: ConductorIndex,
        /// Roughness α of the metal in \[0, 1]; 0 is smooth.
        roughness: MaterialParameter<f32>,
        /// Treatment of light that several microfacets of a rough metal scatter.
        scattering: MicrofacetScattering,
    },
    /// A thin dielectric sheet. Transmitted light continues without deflection or displacement.
    ThinDielectric {
        /// Refractive index of the sheet relative to its surroundings.
        eta: f32,
        /// Internal transmittance of the sheet along its normal, per channel, in (0, 1]; Fresnel
        /// reflection is not included.
        transmittance: MaterialParameter<Rgb>,
    },
    /// The dielectric boundary of a body.
    ///
    /// The refractive index on the outer side depends on the bodies around the path that arrives.
    Dielectric {
        /// The dielectric body on the inner side.
        body: Body,
        /// Roughness α of the boundary in \[0, 1]; 0 is smooth.
        roughness: MaterialParameter<f32>,
        /// Treatment of light that several microfacets of a rough boundary scatter.
        scattering: MicrofacetScattering,
    },
    /// A diffuse base under a dielectric coat, such as plastic.
    CoatedDiffuse {
        /// Reflectance of the base in \[0, 1].
        reflectance: MaterialParameter<Rgb>,
        /// Refractive index of the coat relative to the surroundings, from 1 to
        /// [`MAX_COAT_INDEX`](crate::bsdf::MAX_COAT_INDEX).
        eta: f32,
        /// Roughness α of the coat in \[0, 1]; 0 is smooth.
        roughness: MaterialParameter<f32>,
        /// True to include interreflection between coat and base, which makes colours deeper.
        nonlinear: bool,
    },
    /// A stochastic mix: each hit resolves to one of two materials.
    Mix {
        /// Index of the mix's first material.
        first: u32,
        /// Index of the mix's second material.
        second: u32,
        /// Probability with which a hit resolves to the second material.
        amount: MaterialParameter<f32>,
    },
}

/// Refractive index of a metal, or the reflectance from which it follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConductorIndex {
    /// Complex index relative to the surroundings, per channel.
    Complex {
        /// Real part η of the index.
        eta: Rgb,
        /// Imaginary part k of the index.
        k: Rgb,
    },
    /// Reflectance at normal incidence, in \[0, 1], per channel; see
    /// [`conductor_index_of_reflectance`].
    OfReflectance(MaterialParameter<Rgb>),
}

impl ConductorIndex {
    /// Real and imaginary part of the index, for parameter values from `parameters`.
    fn eta_and_k(&self, parameters: &impl ParameterEvaluator) -> (Rgb, Rgb) {
        match self {
            Self::Complex { eta, k } => (*eta, *k),
            Self::OfReflectance(reflectance) => conductor_index_of_reflectance(parameters.evaluate_color(reflectance)),
        }
    }

    /// True if a texture determines the reflectance.
    fn is_textured(&self) -> bool {
        match self {
            Self::Complex { .. } => false,
            Self::OfReflectance(reflectance) => reflectance.is_textured(),
        }
    }
}

/// Coefficients of the shading model of MIT course 6.837 at a surface point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongAppearance {
    /// Diffuse coefficient kd.
    pub diffuse: Rgb,
    /// Specular coefficient ks.
    pub specular: Rgb,
    /// Exponent of the specular highlight.
    pub shininess: f32,
}

/// Least roughness α of a highlight in the shading model of MIT course 6.837. The highlight of a
/// smoother coat would be too small to see.
const MIN_HIGHLIGHT_ALPHA: f32 = 0.05;

impl MaterialKind {
    /// The BSDF for parameter values from `parameters`; black for a mix, which must be resolved
    /// first.
    fn bsdf(&self, parameters: &impl ParameterEvaluator) -> Bsdf {
        match *self {
            Self::Black | Self::Mix { .. } => Bsdf::Black,
            Self::Diffuse { reflectance } => Bsdf::Diffuse(parameters.evaluate_color(&reflectance)),
            Self::DiffuseTransmission { reflectance, transmittance } => {
                Bsdf::DiffuseTransmission(DiffuseTransmission::new(
                    parameters.evaluate_color(&reflectance),
                    parameters.evaluate_color(&transmittance),
                ))
            }
            Self::Phong { diffuse, specular, shininess } => {
                Bsdf::phong(parameters.evaluate_color(&diffuse), parameters.evaluate_color(&specular), shininess)
            }
            Self::Mirror { reflectance } => Bsdf::Mirror(parameters.evaluate_color(&reflectance)),
            Self::Conductor { index, roughness, scattering } => {
                let alpha = parameters.evaluate_photon_storage_roughness(&roughness);
                let (eta, k) = index.eta_and_k(parameters);
                Bsdf::Conductor(Conductor::new(eta, k, alpha, scattering))
            }
            Self::ThinDielectric { eta, transmittance } => Bsdf::ThinDielectric(ThinDielectric {
                eta,
                internal_transmittance: parameters.evaluate_color(&transmittance),
            }),
            Self::Dielectric { body, roughness, scattering } => {
                Bsdf::dielectric(body.eta, parameters.evaluate_scalar(&roughness), scattering)
            }
            Self::CoatedDiffuse { reflectance, eta, roughness, nonlinear } => Bsdf::coated_diffuse(
                parameters.evaluate_color(&reflectance),
                eta,
                parameters.evaluate_photon_storage_roughness(&roughness),
                nonlinear,
            ),
        }
    }

    /// Appearance of the material in the shading model of MIT course 6.837, for parameter values
    /// from `parameters`; black for a mix.
    #[must_use]
    pub fn phong_appearance(&self, parameters: &impl ParameterEvaluator) -> PhongAppearance {
        let diffuse = match self {
            Self::Diffuse { reflectance }
            | Self::DiffuseTransmission { reflectance, .. }
            | Self::Mirror { reflectance } => parameters.evaluate_color(reflectance),
            Self::ThinDielectric { transmittance, .. } => parameters.evaluate_color(transmittance),
            Self::Phong { diffuse, specular, shininess } => {
                return PhongAppearance {
                    diffuse: parameters.evaluate_color(diffuse),
                    specular: parameters.evaluate_color(specular),
                    shininess: *shininess,
                };
            }
            Self::CoatedDiffuse { reflectance, eta, roughness, .. } => {
                // A Phong lobe of this exponent is about as wide as a GGX lobe of roughness α.
                let alpha = parameters.evaluate_scalar(roughness).max(MIN_HIGHLIGHT_ALPHA);
                return PhongAppearance {
                    diffuse: parameters.evaluate_color(reflectance),
                    specular: Rgb::splat(dielectric_reflectance_and_cosine(1.0, *eta).0),
                    shininess: 2.0 / (alpha * alpha) - 2.0,
                };
            }
            Self::Conductor { index, .. } => {
                let (eta, k) = index.eta_and_k(parameters);
                conductor_reflectance(1.0, eta, k)
            }
            Self::Dielectric { body, .. } => (-body.absorption).map(libm::expf),
            Self::Black | Self::Mix { .. } => Rgb::ZERO,
        };
        PhongAppearance { diffuse, specular: Rgb::ZERO, shininess: 0.0 }
    }

    /// The body and the roughness α of a dielectric boundary; `None` for other materials.
    #[inline]
    fn as_dielectric(&self) -> Option<(&Body, &MaterialParameter<f32>)> {
        if let Self::Dielectric { body, roughness, .. } = self { Some((body, roughness)) } else { None }
    }

    /// Indices of both materials of a mix, and the probability of the second; `None` for other
    /// materials.
    #[inline]
    pub(super) fn as_mix(&self) -> Option<([u32; 2], &MaterialParameter<f32>)> {
        if let Self::Mix { first, second, amount } = self { Some(([*first, *second], amount)) } else { None }
    }

    /// True if each hit chooses one of several BSDFs at random.
    fn chooses_bsdf_randomly(&self) -> bool {
        match self {
            Self::Mix { .. } | Self::CoatedDiffuse { .. } => true,
            Self::Black
            | Self::Diffuse { .. }
            | Self::DiffuseTransmission { .. }
            | Self::Phong { .. }
            | Self::Mirror { .. }
            | Self::Conductor { .. }
            | Self::ThinDielectric { .. }
            | Self::Dielectric { .. } => false,
        }
    }

    /// True if a roughness texture decides at each point whether photons are stored there, as on a
    /// conductor.
    fn roughness_decides_photon_storage(&self) -> bool {
        match self {
            Self::Conductor { roughness, .. } => roughness.is_textured(),
            // The base of a coated surface always stores photons.
            Self::CoatedDiffuse { .. }
            | Self::Black
            | Self::Diffuse { .. }
            | Self::DiffuseTransmission { .. }
            | Self::Phong { .. }
            | Self::Mirror { .. }
            | Self::ThinDielectric { .. }
            | Self::Dielectric { .. }
            | Self::Mix { .. } => false,
        }
    }

    /// True if a texture determines a parameter of the BSDF.
    fn is_textured(&self) -> bool {
        match self {
            Self::Black => false,
            Self::Diffuse { reflectance } | Self::Mirror { reflectance } => reflectance.is_textured(),
            Self::DiffuseTransmission { reflectance, transmittance } => {
                reflectance.is_textured() || transmittance.is_textured()
            }
            Self::Phong { diffuse, specular, .. } => diffuse.is_textured() || specular.is_textured(),
            Self::ThinDielectric { transmittance, .. } => transmittance.is_textured(),
            Self::Conductor { index, roughness, .. } => index.is_textured() || roughness.is_textured(),
            Self::Dielectric { roughness, .. } => roughness.is_textured(),
            Self::CoatedDiffuse { reflectance, roughness, .. } => reflectance.is_textured() || roughness.is_textured(),
            Self::Mix { amount, .. } => amount.is_textured(),
        }
    }
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

    /// This material with another scattering model, and with the same normals and clear coat.
    fn with_kind(self, kind: MaterialKind) -> Self {
        let uncoated = Self { normal_perturbation: self.normal_perturbation, ..Self::new(kind) };
        self.clear_coat.map_or(uncoated, |coat| uncoated.with_clear_coat(coat.coverage, coat.alpha))
    }

    /// This material under a clear coat of index 1.5 and roughness `alpha` in \[0, 1], which covers
    /// the fraction `coverage` of the surface.
    ///
    /// Only diffuse, coated diffuse and metal materials can have a clear coat. Other materials do
    /// not change; see [`ClearCoat::over`].
    #[must_use]
    pub fn with_clear_coat(self, coverage: impl Into<MaterialParameter<f32>>, alpha: f32) -> Self {
        let coat = ClearCoatParameters { coverage: coverage.into(), alpha };
        let coated = Self { clear_coat: Some(coat), textured: self.textured || coat.coverage.is_textured(), ..self };
        Self { mean_bsdf: coated.bsdf(&MeanParameterEvaluator), ..coated }
    }

    /// Returns this material with `may_store_photons` set for a mix: to true if one of its
    /// components may store photons. Other materials are returned unchanged.
    ///
    /// `materials` is the list that the component indices of the mix refer to.
    pub(super) fn with_mix_photon_storage(self, materials: &[Self]) -> Self {
        let Some(parts) = self.mix_component_indices() else { return self };
        let stores = |part: u32| materials.get(part as usize).is_some_and(|part| part.may_store_photons);
        Self { may_store_photons: parts.into_iter().any(stores), ..self }
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
    /// `reflectance` and `transmittance` lie in \[0, 1]. If their sum exceeds 1, they are scaled to
    /// conserve energy; see [`DiffuseTransmission`].
    #[must_use]
    pub fn diffuse_transmission(
        reflectance: impl Into<MaterialParameter<Rgb>>,
        transmittance: impl Into<MaterialParameter<Rgb>>,
    ) -> Self {
        let (reflectance, transmittance) = (reflectance.into(), transmittance.into());
        Self::new(MaterialKind::DiffuseTransmission { reflectance, transmittance })
    }

    /// A material of Phong's model. The BSDF is scaled to conserve energy (see
    /// [`crate::bsdf::Phong`]).
    #[must_use]
    pub fn phong(
        diffuse: impl Into<MaterialParameter<Rgb>>,
        specular: impl Into<MaterialParameter<Rgb>>,
        shininess: f32,
    ) -> Self {
        Self::new(MaterialKind::Phong { diffuse: diffuse.into(), specular: specular.into(), shininess })
    }

    /// A perfect mirror.
    #[must_use]
    pub fn mirror(reflectance: impl Into<MaterialParameter<Rgb>>) -> Self {
        Self::new(MaterialKind::Mirror { reflectance: reflectance.into() })
    }

    /// A material that is the smooth boundary of a dielectric body with refractive index `eta`
    /// and `absorption` \[1/length].
    #[must_use]
    pub fn dielectric(eta: f32, absorption: Rgb) -> Self {
        Self::smooth_boundary(Body { absorption, ..Body::new(eta) })
    }

    /// A material that is the smooth boundary of `body`.
    #[must_use]
    pub fn smooth_boundary(body: Body) -> Self {
        Self::rough_boundary(body, 0.0)
    }

    /// A material that is the boundary of `body`, with roughness α in \[0, 1].
    #[must_use]
    pub fn rough_boundary(body: Body, roughness: impl Into<MaterialParameter<f32>>) -> Self {
        let (roughness, scattering) = (roughness.into(), MicrofacetScattering::Multiple);
        Self::new(MaterialKind::Dielectric { body, roughness, scattering })
    }

    /// A mix, which resolves at each hit to material `second` with probability `amount`, else to
    /// `first`.
    ///
    /// Both are indices of materials of the scene, which may be added after the mix. No mix may
    /// contain itself.
    #[must_use]
    pub fn mix(first: u32, second: u32, amount: impl Into<MaterialParameter<f32>>) -> Self {
        Self::new(MaterialKind::Mix { first, second, amount: amount.into() })
    }

    /// A metal of refractive index `eta` + i`k` and roughness α in \[0, 1].
    #[must_use]
    pub fn conductor(eta: Rgb, k: Rgb, roughness: impl Into<MaterialParameter<f32>>) -> Self {
        Self::conductor_of_index(ConductorIndex::Complex { eta, k }, roughness)
    }

    /// A metal with the refractive index that `index` gives, and roughness α in \[0, 1].
    #[must_use]
    pub fn conductor_of_index(index: ConductorIndex, roughness: impl Into<MaterialParameter<f32>>) -> Self {
        let (roughness, scattering) = (roughness.into(), MicrofacetScattering::Multiple);
        Self::new(MaterialKind::Conductor { index, roughness, scattering })
    }

    /// This material without light that scatters between microfacets; unchanged if it is neither a
    /// metal nor the boundary of a body.
    #[must_use]
    pub fn with_single_microfacet_scattering(self) -> Self {
        let scattering = MicrofacetScattering::Single;
        let kind = match self.kind {
            MaterialKind::Conductor { index, roughness, .. } => {
                MaterialKind::Conductor { index, roughness, scattering }
            }
            MaterialKind::Dielectric { body, roughness, .. } => {
                MaterialKind::Dielectric { body, roughness, scattering }
            }
            MaterialKind::Black
            | MaterialKind::Diffuse { .. }
            | MaterialKind::DiffuseTransmission { .. }
            | MaterialKind::Phong { .. }
            | MaterialKind::Mirror { .. }
            | MaterialKind::ThinDielectric { .. }
            | MaterialKind::CoatedDiffuse { .. }
            | MaterialKind::Mix { .. } => return self,
        };
        self.with_kind(kind)
    }

    /// A thin sheet of refractive index `eta`. `transmittance` in (0, 1] is its internal
    /// transmittance along the normal, without Fresnel reflection.
    #[must_use]
    pub fn thin_dielectric(eta: f32, transmittance: impl Into<MaterialParameter<Rgb>>) -> Self {
        Self::new(MaterialKind::ThinDielectric { eta, transmittance: transmittance.into() })
    }

    /// A diffuse base of `reflectance` in \[0, 1] under a dielectric coat, such as plastic.
    ///
    /// `eta` is the refractive index of the coat relative to the surroundings, from 1 to
    /// [`MAX_COAT_INDEX`](crate::bsdf::MAX_COAT_INDEX), and `roughness` its GGX α in \[0, 1].
    /// Interreflection between coat and base makes colours deeper if `nonlinear` is true, as it
    /// does in nature; see [`CoatedDiffuse`](crate::bsdf::CoatedDiffuse).
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

    /// The perturbation of shading normals.
    #[must_use]
    pub fn normal_perturbation(&self) -> NormalPerturbation {
        self.normal_perturbation
    }

    /// The dielectric body that this material bounds; `None` if it bounds none.
    #[inline]
    #[must_use]
    pub fn bounded_body(&self) -> Option<&Body> {
        self.kind.as_dielectric().map(|(body, _)| body)
    }

    /// This material with `body` in place of the dielectric body that it bounds; unchanged if it
    /// bounds none.
    #[must_use]
    pub fn with_body(self, body: Body) -> Self {
        match self.kind {
            MaterialKind::Dielectric { roughness, scattering, .. } => {
                self.with_kind(MaterialKind::Dielectric { body, roughness, scattering })
            }
            MaterialKind::Black
            | MaterialKind::Diffuse { .. }
            | MaterialKind::DiffuseTransmission { .. }
            | MaterialKind::Phong { .. }
            | MaterialKind::Mirror { .. }
            | MaterialKind::Conductor { .. }
            | MaterialKind::ThinDielectric { .. }
            | MaterialKind::CoatedDiffuse { .. }
            | MaterialKind::Mix { .. } => self,
        }
    }

    /// Indices of both materials of a mix; `None` for other materials.
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

    /// The BSDF for parameter values from `parameters`; black for a mix.
    #[must_use]
    pub fn bsdf(&self, parameters: &impl ParameterEvaluator) -> Bsdf {
        let bsdf = self.kind.bsdf(parameters);
        match &self.clear_coat {
            None => bsdf,
            Some(coat) => ClearCoat::new(parameters.evaluate_scalar(&coat.coverage), coat.alpha).over(bsdf),
        }
    }

    /// True if a texture determines a parameter of the BSDF.
    #[inline]
    #[must_use]
    pub fn is_textured(&self) -> bool {
        self.textured
    }

    /// True if each hit chooses one of several BSDFs at random: at a mix, or at a surface with a
    /// coat.
    #[inline]
    pub(super) fn chooses_bsdf_randomly(&self) -> bool {
        self.kind.chooses_bsdf_randomly() || self.clear_coat.is_some()
    }

    /// True if a hit may resolve to a BSDF that stores photons: for a mix, if a component may.
    #[inline]
    pub(super) fn may_store_photons(&self) -> bool {
        self.may_store_photons
    }

    /// True if textures determine BSDF parameters or the shading normal, so that each hit must
    /// evaluate textures.
    #[inline]
    pub(super) fn needs_textures(&self) -> bool {
        self.textured || self.normal_perturbation != NormalPerturbation::None
    }

    /// Mean roughness α of a dielectric body's boundary; 0 for other materials.
    #[inline]
    pub(super) fn mean_boundary_roughness(&self) -> f32 {
        self.boundary_roughness(&MeanParameterEvaluator)
    }

    /// Treatment of light that several microfacets of a dielectric body's boundary scatter;
    /// `Multiple` for other materials.
    #[inline]
    pub(super) fn boundary_microfacet_scattering(&self) -> MicrofacetScattering {
        if let MaterialKind::Dielectric { scattering, .. } = self.kind {
            scattering
        } else {
            MicrofacetScattering::Multiple
        }
    }

    /// Roughness α of a dielectric body's boundary; 0 for other materials.
    #[inline]
    pub(super) fn boundary_roughness(&self, parameters: &impl ParameterEvaluator) -> f32 {
        self.kind.as_dielectric().map_or(0.0, |(_, roughness)| parameters.evaluate_scalar(roughness))
    }

    /// Calls `visit` with at least one BSDF of each kind that the material can have at a hit.
    ///
    /// Two BSDFs are of different kinds if they differ in being specular, in storing photons, or in
    /// transmitting. The method visits the BSDF with mean parameters. For a conductor or coat with
    /// a roughness texture, it also visits the BSDFs with the least and the greatest roughness. A
    /// coat with α up to [`MIN_PHOTON_STORAGE_ALPHA`](crate::bsdf::MIN_PHOTON_STORAGE_ALPHA) is
    /// also visited alone, without its base. So is a clear coat, and the surface under it.
    pub(super) fn visit_bsdf_variants(&self, textures: &[Arc<Texture>], mut visit: impl FnMut(Bsdf)) {
        let mut visit = |bsdf: Bsdf| {
            visit(bsdf);
            bsdf.separate_coat().into_iter().for_each(&mut visit);
        };
        visit(self.mean_bsdf);
        self.mean_bsdf.under_coat().into_iter().for_each(&mut visit);
        match self.kind {
            MaterialKind::CoatedDiffuse {
                reflectance,
                eta,
                roughness: MaterialParameter::Texture { texture, .. },
                nonlinear,
            } => {
                let (min, max) = textures[texture as usize].value_range();
                for alpha in [min, max] {
                    visit(Bsdf::coated_diffuse(reflectance.mean(), eta, alpha, nonlinear));
                }
            }
            MaterialKind::Conductor { index, roughness: MaterialParameter::Texture { texture, .. }, scattering } => {
                let (min, max) = textures[texture as usize].value_range();
                let (eta, k) = index.eta_and_k(&MeanParameterEvaluator);
                for alpha in [min, max] {
                    visit(Bsdf::Conductor(Conductor::new(eta, k, alpha, scattering)));
                }
            }
            // For these materials, textures do not change whether the BSDF is specular, stores
            // photons or transmits.
            MaterialKind::Conductor { roughness: MaterialParameter::Constant(_), .. }
            | MaterialKind::CoatedDiffuse { roughness: MaterialParameter::Constant(_), .. }
            | MaterialKind::Black
            | MaterialKind::Diffuse { .. }
            | MaterialKind::DiffuseTransmission { .. }
            | MaterialKind::Phong { .. }
            | MaterialKind::Mirror { .. }
            | MaterialKind::ThinDielectric { .. }
            | MaterialKind::Dielectric { .. }
            | MaterialKind::Mix { .. } => {}
        }
    }
}

#[cfg(test)]
mod tests;
