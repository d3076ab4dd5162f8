//! Scattering models of materials, with their parameters.

use crate::bsdf::{
    Bsdf, Conductor, DiffuseTransmission, MicrofacetScattering, ThinDielectric, conductor_index_of_reflectance,
    conductor_reflectance, dielectric_reflectance_and_cosine,
};
use crate::color::Rgb;
use crate::scene::interiors::Body;
use crate::scene::textured::{MaterialParameter, MeanParameterEvaluator, ParameterEvaluator};
use crate::texture::Texture;
use std::sync::Arc;

/// The scattering model of a material, with its parameters.
///
/// To add a kind, add an arm to each match. The compiler does not check three rules:
///
/// - Roughness may decide whether a surface stores photons, as on a metal. For a textured
///   roughness, `roughness_decides_photon_storage` must then be true, and `bsdf` must read the
///   roughness by `evaluate_photon_storage_roughness`. Camera and photon paths then agree on where
///   photons are stored.
/// - `visit_extreme_roughness_bsdfs` must visit each kind of BSDF that a roughness texture can
///   produce.
/// - `chooses_bsdf_randomly` must be true if each hit chooses at random between a coat and its
///   base.
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
        /// Single or multiple scattering of light between the microfacets of a rough metal.
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
    /// A dielectric boundary, such as the surface of glass or water, around a [`Body`].
    ///
    /// The refractive index on the outer side comes from the bodies that already surround the path.
    Dielectric {
        /// The dielectric body on the inner side.
        body: Body,
        /// Roughness α of the boundary in \[0, 1]; 0 is smooth.
        roughness: MaterialParameter<f32>,
        /// Single or multiple scattering of light between the microfacets of a rough boundary.
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
        /// True if repeated reflection between coat and base deepens colours. If false, the BSDF is
        /// proportional to `reflectance` (compare `nonlinear` of Mitsuba's `plastic`).
        nonlinear: bool,
    },
    /// A stochastic mix: each hit resolves to one of two materials.
    Mix {
        /// Material index of the first component.
        first: u32,
        /// Material index of the second component.
        second: u32,
        /// Probability in \[0, 1] that a hit resolves to the second component.
        amount: MaterialParameter<f32>,
    },
}

/// Complex refractive index of a metal, given directly or by the metal's reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConductorIndex {
    /// Complex index relative to the surroundings, per channel.
    Complex {
        /// Real part η of the index.
        eta: Rgb,
        /// Imaginary part k of the index.
        k: Rgb,
    },
    /// Reflectance at normal incidence, in \[0, 1], per channel. The index is computed from it by
    /// [`conductor_index_of_reflectance`].
    OfReflectance(MaterialParameter<Rgb>),
}

impl ConductorIndex {
    /// Returns the real part η and the imaginary part k of the index, per channel. `parameters`
    /// evaluates a textured reflectance.
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

/// Phong coefficients at a surface point, for algorithm `raycast`. This algorithm shades as MIT
/// course 6.837 does: without shadows, distance falloff or indirect light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongAppearance {
    /// Diffuse coefficient kd.
    pub diffuse: Rgb,
    /// Specular coefficient ks.
    pub specular: Rgb,
    /// Exponent of the specular highlight.
    pub shininess: f32,
}

/// Lower bound to which the roughness α of a coat is clamped, when [`PhongAppearance`] computes the
/// exponent of the coat's highlight. With a smaller α, the highlight would be too small to see.
const MIN_HIGHLIGHT_ALPHA: f32 = 0.05;

impl MaterialKind {
    /// The BSDF at a point, where `parameters` evaluates constant and textured parameters. Black
    /// for a mix, which must be resolved to one of its components first.
    pub(super) fn bsdf(&self, parameters: &impl ParameterEvaluator) -> Bsdf {
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

    /// Phong coefficients that stand for this material in algorithm `raycast`; black for a mix.
    /// `parameters` evaluates constant and textured parameters at a point.
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
    pub(super) fn as_dielectric(&self) -> Option<(&Body, &MaterialParameter<f32>)> {
        if let Self::Dielectric { body, roughness, .. } = self { Some((body, roughness)) } else { None }
    }

    /// Indices of both materials of a mix, and the probability of the second; `None` for other
    /// materials.
    #[inline]
    pub(in crate::scene) fn as_mix(&self) -> Option<([u32; 2], &MaterialParameter<f32>)> {
        if let Self::Mix { first, second, amount } = self { Some(([*first, *second], amount)) } else { None }
    }

    /// True if the BSDF at a hit may be chosen at random: from the components of a mix, or from
    /// coat and base.
    pub(super) fn chooses_bsdf_randomly(&self) -> bool {
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

    /// True for a conductor with a roughness texture: photons are stored only at points where the
    /// conductor is rough enough.
    pub(super) fn roughness_decides_photon_storage(&self) -> bool {
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

    /// True if a texture determines a parameter of the BSDF, or the amount of a mix.
    pub(super) fn is_textured(&self) -> bool {
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
    /// This kind with [`MicrofacetScattering::Single`]: light that meets a second microfacet is
    /// lost. Unchanged if it is neither a conductor nor a dielectric boundary.
    pub(super) fn with_single_microfacet_scattering(self) -> Self {
        let scattering = MicrofacetScattering::Single;
        match self {
            Self::Conductor { index, roughness, .. } => Self::Conductor { index, roughness, scattering },
            Self::Dielectric { body, roughness, .. } => Self::Dielectric { body, roughness, scattering },
            Self::Black
            | Self::Diffuse { .. }
            | Self::DiffuseTransmission { .. }
            | Self::Phong { .. }
            | Self::Mirror { .. }
            | Self::ThinDielectric { .. }
            | Self::CoatedDiffuse { .. }
            | Self::Mix { .. } => self,
        }
    }

    /// This kind with the body that it bounds replaced by `body`; unchanged if the kind bounds no
    /// body.
    pub(super) fn with_body(self, body: Body) -> Self {
        match self {
            Self::Dielectric { roughness, scattering, .. } => Self::Dielectric { body, roughness, scattering },
            Self::Black
            | Self::Diffuse { .. }
            | Self::DiffuseTransmission { .. }
            | Self::Phong { .. }
            | Self::Mirror { .. }
            | Self::Conductor { .. }
            | Self::ThinDielectric { .. }
            | Self::CoatedDiffuse { .. }
            | Self::Mix { .. } => self,
        }
    }

    /// Calls `visit` with the BSDFs for the least and the greatest value of a roughness texture.
    /// Other parameters are at their means. If the roughness cannot change whether the surface is
    /// specular or stores photons, `visit` is not called.
    pub(super) fn visit_extreme_roughness_bsdfs(&self, textures: &[Arc<Texture>], mut visit: impl FnMut(Bsdf)) {
        match *self {
            Self::CoatedDiffuse {
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
            Self::Conductor { index, roughness: MaterialParameter::Texture { texture, .. }, scattering } => {
                let (min, max) = textures[texture as usize].value_range();
                let (eta, k) = index.eta_and_k(&MeanParameterEvaluator);
                for alpha in [min, max] {
                    visit(Bsdf::Conductor(Conductor::new(eta, k, alpha, scattering)));
                }
            }
            // For these materials, textures do not change whether the BSDF is specular, stores
            // photons or transmits.
            Self::Conductor { roughness: MaterialParameter::Constant(_), .. }
            | Self::CoatedDiffuse { roughness: MaterialParameter::Constant(_), .. }
            | Self::Black
            | Self::Diffuse { .. }
            | Self::DiffuseTransmission { .. }
            | Self::Phong { .. }
            | Self::Mirror { .. }
            | Self::ThinDielectric { .. }
            | Self::Dielectric { .. }
            | Self::Mix { .. } => {}
        }
    }
}
