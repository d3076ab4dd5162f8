//! A clear dielectric coat over another surface, such as lacquer on metal.

use super::coat_albedo::coat_albedo;
use super::coated_diffuse::{CoatedDiffuse, DielectricCoat};
use super::properties::BsdfProperties;
use super::sample::NonSpecularSample;
use super::{Bsdf, BsdfSample, Conductor, MIN_ROUGH_ALPHA};
use crate::color::Rgb;
use crate::math::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Refractive index of clear coats relative to the surroundings.
const CLEAR_COAT_INDEX: f32 = 1.5;

/// Number of steps into which the range \[0, 1] of a clear coat's parameters is divided.
///
/// Integers of 16 bits keep [`Bsdf`] small.
const QUANTIZATION_STEPS: f32 = 65_535.0;

/// A clear coat of refractive index 1.5, given by its coverage of the surface and its roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClearCoat {
    /// Fraction of the surface that the coat covers, in steps of 1/[`QUANTIZATION_STEPS`].
    coverage_steps: u16,
    /// GGX roughness α of the coat, in steps of 1/[`QUANTIZATION_STEPS`]; 0 if the coat is smooth.
    alpha_steps: u16,
}

/// The BSDF of a surface under a clear coat. Reflection on the coat itself is not included:
/// [`Bsdf::select_layer`] chooses either the surface or the coat.
///
/// The BRDF of the surface is multiplied by 1 − max(c(wo), c(wi)). c is the fraction of light that
/// the coat reflects: its coverage times its albedo. The product is reciprocal. The factor is at
/// most 1 − c(wo), so coat and surface together gain no light beyond the error of tabulated
/// albedos. Under a smooth coat, a lossless mirror loses no light. A white diffuse surface loses 5
/// % of the light that arrives along the normal, because the factor weakens light that leaves at
/// grazing angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearCoated {
    base: CoatableBsdf,
    coat: ClearCoat,
    /// Factor on the BRDF: 1/p if [`Bsdf::select_layer`] chose this surface, with probability p; 1
    /// if no layer has been chosen.
    inverse_selection_probability: f32,
}

/// A BSDF that can lie under a clear coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CoatableBsdf {
    Diffuse(Rgb),
    CoatedDiffuse(CoatedDiffuse),
    DielectricCoat(DielectricCoat),
    Conductor(Conductor),
}

impl ClearCoat {
    /// Creates a coat from the fraction `coverage` of the surface that it covers and its GGX
    /// roughness `alpha`, both in \[0, 1]. The coat is smooth if `alpha` is below
    /// [`MIN_ROUGH_ALPHA`]. Coverage and roughness are rounded to multiples of 1/65,535.
    #[must_use]
    pub fn new(coverage: f32, alpha: f32) -> Self {
        let alpha = if alpha < MIN_ROUGH_ALPHA { 0.0 } else { alpha };
        let [coverage_steps, alpha_steps] = [coverage, alpha].map(|x| (x * QUANTIZATION_STEPS).round() as u16);
        Self { coverage_steps, alpha_steps }
    }

    /// Returns `surface` under this coat. Only diffuse, coated diffuse and metal surfaces, and
    /// separate dielectric coats, can have a clear coat; any other BSDF is returned unchanged.
    #[must_use]
    pub fn over(self, surface: Bsdf) -> Bsdf {
        surface.to_coatable().map_or(surface, |base| {
            Bsdf::ClearCoated(ClearCoated { base, coat: self, inverse_selection_probability: 1.0 })
        })
    }

    #[inline]
    fn coverage(&self) -> f32 {
        f32::from(self.coverage_steps) / QUANTIZATION_STEPS
    }

    #[inline]
    fn alpha(&self) -> f32 {
        f32::from(self.alpha_steps) / QUANTIZATION_STEPS
    }

    /// Fraction of light from direction `w` that the coat reflects: the coverage times the albedo
    /// of the covered part. `n` is the shading normal.
    #[inline]
    fn albedo(&self, w: Vec3, n: Vec3) -> f32 {
        self.coverage() * coat_albedo(w.dot(n).abs(), CLEAR_COAT_INDEX, self.alpha())
    }

    /// The BSDF of the coat alone, divided by the coat's selection probability `probability`.
    fn bsdf_divided_by_probability(&self, probability: f32) -> DielectricCoat {
        DielectricCoat::new(CLEAR_COAT_INDEX, self.alpha(), self.coverage() / probability)
    }
}

impl CoatableBsdf {
    /// Converts to the general [`Bsdf`], without a clear coat.
    fn to_bsdf(self) -> Bsdf {
        match self {
            Self::Diffuse(reflectance) => Bsdf::Diffuse(reflectance),
            Self::CoatedDiffuse(coated) => Bsdf::CoatedDiffuse(coated),
            Self::DielectricCoat(coat) => Bsdf::DielectricCoat(coat),
            Self::Conductor(conductor) => Bsdf::Conductor(conductor),
        }
    }
}

impl ClearCoated {
    /// The surface under the coat, as a BSDF without the coat.
    pub(super) fn base(&self) -> Bsdf {
        self.base.to_bsdf()
    }

    /// The coat alone as a BSDF, not divided by a probability.
    pub(super) fn coat(&self) -> DielectricCoat {
        self.coat.bsdf_divided_by_probability(1.0)
    }

    /// Properties of the surface under the coat.
    #[inline]
    pub(super) fn properties(&self) -> BsdfProperties {
        match &self.base {
            CoatableBsdf::Diffuse(_) | CoatableBsdf::CoatedDiffuse(_) => BsdfProperties::DIFFUSE,
            CoatableBsdf::DielectricCoat(coat) => coat.properties(),
            CoatableBsdf::Conductor(conductor) => conductor.properties(),
        }
    }

    /// Factor on the BRDF of the surface under the coat: the coat's factor 1 − max(c(wo), c(wi)),
    /// divided by the probability with which [`Bsdf::select_layer`] chose that surface.
    ///
    /// c is the fraction of light that the coat reflects. `n` is the shading normal.
    #[inline]
    fn coat_factor(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        (1.0 - self.coat.albedo(wo, n).max(self.coat.albedo(wi, n))) * self.inverse_selection_probability
    }

    /// Returns one layer of the surface, chosen at random by `u` in \[0, 1): the clear coat, or the
    /// surface under it. If that surface is itself split into coat and base, chooses between these
    /// two as well; see [`Bsdf::select_layer`].
    pub(super) fn select_layer(self, wo: Vec3, ns: Vec3, u: f32) -> Bsdf {
        let coat_probability = self.coat.albedo(wo, ns);
        let base_probability = 1.0 - coat_probability;
        if coat_probability > 0.0 && u >= base_probability {
            return Bsdf::DielectricCoat(self.coat.bsdf_divided_by_probability(coat_probability));
        }
        let base = match self.base {
            CoatableBsdf::CoatedDiffuse(coated) => {
                coated.select_layer(wo, ns, u / base_probability).to_coatable().unwrap_or(self.base)
            }
            CoatableBsdf::Diffuse(_) | CoatableBsdf::DielectricCoat(_) | CoatableBsdf::Conductor(_) => self.base,
        };
        let inverse_selection_probability = self.inverse_selection_probability / base_probability;
        Bsdf::ClearCoated(Self { base, inverse_selection_probability, ..self })
    }

    /// BRDF f(wo, wi) \[1/sr] of the surface, weakened by the coat. Reflection on the coat itself
    /// is not included.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        let base = match &self.base {
            CoatableBsdf::Diffuse(reflectance) => *reflectance * FRAC_1_PI,
            CoatableBsdf::CoatedDiffuse(coated) => coated.evaluate(wo, wi, n),
            CoatableBsdf::DielectricCoat(coat) => coat.evaluate(wo, wi, n),
            CoatableBsdf::Conductor(conductor) => conductor.evaluate(wo, wi, n),
        };
        base * self.coat_factor(wo, wi, n)
    }

    /// Solid-angle pdf \[1/sr] with which `wi` is sampled, given `wo`; 0 for delta lobes.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        match &self.base {
            CoatableBsdf::Diffuse(_) => warp::cosine_hemisphere_pdf(wi.dot(n).abs()),
            CoatableBsdf::CoatedDiffuse(coated) => coated.pdf(wo, wi, n),
            CoatableBsdf::DielectricCoat(coat) => coat.pdf(wo, wi, n),
            CoatableBsdf::Conductor(conductor) => conductor.pdf(wo, wi, n),
        }
    }

    /// Samples a direction if the surface under the coat stores photons. Returns `None` if the path
    /// is absorbed, or if that surface is a dielectric coat without its base, which stores no
    /// photons.
    ///
    /// `lobe` in \[0, 1) selects the lobe, and `u` in \[0, 1)² the direction. `n` is the shading
    /// normal on the side of `wo`.
    #[inline]
    pub(super) fn sample_receiver(&self, wo: Vec3, n: Vec3, lobe: f32, u: Vec2) -> Option<NonSpecularSample> {
        let sample = match &self.base {
            CoatableBsdf::Diffuse(reflectance) => NonSpecularSample::lambertian_sample(*reflectance, n, u)?,
            CoatableBsdf::CoatedDiffuse(coated) => coated.sample(wo, n, lobe, u)?,
            CoatableBsdf::Conductor(conductor) => conductor.sample_rough(wo, n, lobe, u)?,
            CoatableBsdf::DielectricCoat(_) => return None,
        };
        Some(NonSpecularSample { weight: sample.weight * self.coat_factor(wo, sample.wi, n), ..sample })
    }

    /// Samples a direction if the surface under the coat stores no photons. Returns `None` if the
    /// path is absorbed, or if that surface is diffuse, with or without a coat.
    ///
    /// `ng` is the geometric normal. The other arguments are those of
    /// [`ClearCoated::sample_receiver`].
    #[inline]
    pub(super) fn sample_caster(&self, wo: Vec3, n: Vec3, ng: Vec3, lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let sample = match &self.base {
            CoatableBsdf::Conductor(conductor) => conductor.sample(wo, n, ng, lobe, u)?,
            CoatableBsdf::DielectricCoat(coat) => coat.sample(wo, n, ng, u)?,
            CoatableBsdf::Diffuse(_) | CoatableBsdf::CoatedDiffuse(_) => return None,
        };
        Some(BsdfSample { weight: sample.weight * self.coat_factor(wo, sample.wi, n), ..sample })
    }
}
