//! Diffuse surfaces under a dielectric coat, such as plastic or varnished wood.

use super::coat_albedo::{coat_albedo, mean_coat_albedo};
use super::fresnel::fresnel_reflectance_and_cosine;
use super::microfacet::Ggx;
use super::properties::{BsdfProperties, DIFFUSE_CONE_SPREAD};
use super::sample::NonSpecularSample;
use super::{Bsdf, BsdfSample, MIN_PHOTON_STORAGE_ALPHA, MIN_ROUGH_ALPHA, dielectric, face_forward};
use crate::color::{self, Rgb};
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Refractive index below which a coat counts as absent. The coat's mean reflectance is then below
/// 10⁻⁴.
pub(super) const MIN_COAT_INDEX: f32 = 1.0001;

/// Refractive index below which a rough coat counts as smooth. Such a coat reflects less than 1 %
/// of diffuse light.
const MIN_ROUGH_COAT_INDEX: f32 = 1.01;

/// Reflection on the outside of a dielectric coat, smooth or with GGX microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricCoat {
    /// Refractive index relative to the surroundings.
    eta: f32,
    /// GGX roughness α; 0 if the coat is smooth.
    alpha: f32,
    /// Factor on the reflectance: the fraction of the surface that the coat covers, divided by p if
    /// [`Bsdf::select_layer`] chose the coat with probability p.
    reflectance_factor: f32,
}

/// A Lambertian base under a dielectric coat, including light that is reflected between base and
/// coat.
///
/// The base has the BRDF T(θₒ)·T(θᵢ)·ρ / (π η² (1 − ρF)). T is the transmittance of the coat from
/// the outside, ρ the reflectance of the base, and F the diffuse reflectance of the coat from the
/// inside. With a white base, coat and base together reflect all light. If the coat is rough, this
/// holds within the error of tabulated albedos.
///
/// If the roughness of the coat exceeds [`MIN_PHOTON_STORAGE_ALPHA`], this BSDF includes reflection
/// on the coat. Otherwise it is the base alone, and [`Bsdf::select_layer`] chooses base or coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatedDiffuse {
    /// Factor ρ / (η² (1 − ρF)) of the base's BRDF.
    ///
    /// The factor is divided by p if [`Bsdf::select_layer`] chose the base with probability p.
    base_brdf_factor: Rgb,
    /// Fraction of the light inside the coat that leaves the coat after reflection on the base,
    /// averaged over the color channels.
    ///
    /// The fraction is divided by p if [`Bsdf::select_layer`] chose the base with probability p.
    entered_light_albedo: f32,
    /// Refractive index of the coat relative to the surroundings.
    eta: f32,
    /// GGX roughness α of the coat; 0 if it is smooth.
    alpha: f32,
}

impl DielectricCoat {
    /// Creates a coat of relative index `eta`, GGX roughness `alpha`, and a factor on its
    /// reflectance.
    pub(super) fn new(eta: f32, alpha: f32, reflectance_factor: f32) -> Self {
        Self { eta, alpha, reflectance_factor }
    }

    /// Properties of the coat. It stores no photons at any roughness.
    #[inline]
    pub(super) fn properties(&self) -> BsdfProperties {
        BsdfProperties {
            is_specular: self.alpha == 0.0,
            ray_cone_spread: self.alpha * DIFFUSE_CONE_SPREAD,
            ..BsdfProperties::CASTER
        }
    }

    /// Returns the Fresnel reflectance at the cosine of incidence `cos`, multiplied by
    /// `reflectance_factor`.
    #[inline]
    fn reflectance(&self, cos: f64) -> f32 {
        self.reflectance_factor * fresnel_reflectance_and_cosine(cos.clamp(0.0, 1.0), f64::from(self.eta)).0 as f32
    }

    /// BRDF f(wo, wi) \[1/sr], multiplied by `reflectance_factor`; 0 for a smooth coat.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        if self.alpha == 0.0 {
            return Rgb::ZERO;
        }
        let (ggx, o, i, n) = (Ggx::new(self.alpha), wo.as_dvec3(), wi.as_dvec3(), n.as_dvec3());
        let facet = ggx.reflecting_facet(o, i, n);
        let g2 = ggx.reflection_g2_over_cosines(o.dot(n).abs(), i.dot(n).abs());
        Rgb::splat(self.reflectance(facet.wo_dot_m) * (0.25 * facet.normal_density * g2) as f32)
    }

    /// Solid-angle pdf \[1/sr] with which [`DielectricCoat::sample`] samples `wi`; 0 for a smooth
    /// coat.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        if self.alpha == 0.0 {
            return 0.0;
        }
        let (ggx, o, n) = (Ggx::new(self.alpha), wo.as_dvec3(), n.as_dvec3());
        ggx.scattered_direction_pdf(&ggx.reflecting_facet(o, wi.as_dvec3(), n), o.dot(n).abs()) as f32
    }

    /// Samples the direction of reflection on the coat, from random numbers `u` in \[0, 1)².
    ///
    /// `n` is the shading normal on the side of `wo`, and `ng` the geometric normal. Returns `None`
    /// if the reflected direction points into the surface.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, ng: Vec3, u: Vec2) -> Option<BsdfSample> {
        if self.alpha == 0.0 {
            let (wi, uses_geometric_normal) = dielectric::reflect_above_surface(wo, n, ng);
            let cos = f64::from(wo.dot((wo + wi).normalize_or_zero()));
            let weight = Rgb::splat(self.reflectance(cos));
            return Some(BsdfSample::specular_sample(wi, weight, false, uses_geometric_normal));
        }
        let wi = self.sample_reflected_direction(wo, n, u)?;
        let pdf = self.pdf(wo, wi, n);
        let weight = self.evaluate(wo, wi, n) * (wi.dot(n) / pdf);
        (pdf > 0.0).then(|| BsdfSample::non_specular_sample(wi, weight, pdf, false))
    }

    /// Samples a unit direction of reflection at a visible microfacet of a rough coat; `None` if it
    /// points into the surface. `n` is on the side of `wo`.
    #[inline]
    fn sample_reflected_direction(&self, wo: Vec3, n: Vec3, u: Vec2) -> Option<Vec3> {
        let o = wo.as_dvec3();
        let m = Ggx::new(self.alpha).sample_visible_normal(o, n, u);
        let wi = (m * (2.0 * o.dot(m)) - o).normalize().as_vec3();
        (wi.dot(n) > 0.0).then_some(wi)
    }
}

impl CoatedDiffuse {
    /// Creates the BSDF from the base's `reflectance` in \[0, 1], and the coat's relative index
    /// `eta` in \[1, 4] and roughness `alpha` in \[0, 1].
    ///
    /// If `nonlinear` is false, the factor 1 − ρF in the BRDF of [`CoatedDiffuse`] is replaced by 1
    /// − F, its value for a white base (compare Mitsuba's `plastic`). Interreflection between coat
    /// and base then does not make colors more saturated, and the BSDF is proportional to ρ.
    pub(super) fn new(reflectance: Rgb, eta: f32, alpha: f32, nonlinear: bool) -> Self {
        let alpha = if alpha < MIN_ROUGH_ALPHA || eta < MIN_ROUGH_COAT_INDEX { 0.0 } else { alpha };
        // Reciprocity: the transmittance from inside equals the transmittance from outside, divided
        // by η².
        let mean_transmittance = 1.0 - mean_coat_albedo(eta, alpha);
        let leaving = mean_transmittance / (eta * eta);
        // 1 − ρF is computed as 1 − ρ + ρ·`leaving`, where `leaving` = 1 − F. This sum does not
        // cancel if the base is nearly white.
        let absorbed = if nonlinear { Rgb::ONE - reflectance } else { Rgb::ZERO };
        let counted = if nonlinear { reflectance } else { Rgb::ONE };
        let base = reflectance / (absorbed + counted * leaving) / (eta * eta);
        Self {
            base_brdf_factor: base,
            entered_light_albedo: color::channel_mean(base) * mean_transmittance,
            eta,
            alpha,
        }
    }

    /// The BSDF of the coat alone, divided by the coat's selection probability `probability`.
    fn coat_divided_by_probability(&self, probability: f32) -> DielectricCoat {
        DielectricCoat { eta: self.eta, alpha: self.alpha, reflectance_factor: 1.0 / probability }
    }

    /// True if [`CoatedDiffuse::evaluate`] includes reflection on the coat, because the coat's
    /// roughness α exceeds [`MIN_PHOTON_STORAGE_ALPHA`].
    #[inline]
    fn includes_coat(&self) -> bool {
        self.alpha > MIN_PHOTON_STORAGE_ALPHA
    }

    /// The coat as a separate BSDF; `None` if the coat is so rough that this BSDF includes it.
    pub(super) fn coat_if_separate(&self) -> Option<DielectricCoat> {
        (!self.includes_coat()).then(|| self.coat_divided_by_probability(1.0))
    }

    /// Fraction of light from direction `w` that enters the coat; `n` is the shading normal.
    #[inline]
    fn transmittance(&self, w: Vec3, n: Vec3) -> f32 {
        1.0 - coat_albedo(w.dot(n).abs(), self.eta, self.alpha)
    }

    /// Returns (albedo of the coat, albedo of the base under the coat) for light from `wo`.
    #[inline]
    fn layer_albedos(&self, wo: Vec3, n: Vec3) -> (f32, f32) {
        let transmittance = self.transmittance(wo, n);
        (1.0 - transmittance, transmittance * self.entered_light_albedo)
    }

    /// Returns the base or the coat, chosen at random by `u` in \[0, 1) with probabilities
    /// proportional to their albedos for `wo`; see [`Bsdf::select_layer`].
    pub(super) fn select_layer(self, wo: Vec3, ns: Vec3, u: f32) -> Bsdf {
        if self.includes_coat() {
            return Bsdf::CoatedDiffuse(self);
        }
        let (coat, base) = self.layer_albedos(wo, ns);
        let base_probability = base / (coat + base);
        if u < base_probability {
            let scale = 1.0 / base_probability;
            Bsdf::CoatedDiffuse(Self {
                base_brdf_factor: self.base_brdf_factor * scale,
                entered_light_albedo: self.entered_light_albedo * scale,
                ..self
            })
        } else {
            Bsdf::DielectricCoat(self.coat_divided_by_probability(coat / (coat + base)))
        }
    }

    /// BRDF f(wo, wi) \[1/sr]. `wo` and `wi` must be on one side of the shading normal `n`.
    ///
    /// Reflection on the coat is included only if the coat's roughness α exceeds
    /// [`MIN_PHOTON_STORAGE_ALPHA`].
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        let base = self.base_brdf_factor * (self.transmittance(wo, n) * self.transmittance(wi, n) * FRAC_1_PI);
        if self.includes_coat() { base + self.coat_divided_by_probability(1.0).evaluate(wo, wi, n) } else { base }
    }

    /// Probability with which [`CoatedDiffuse::sample`] samples the coat instead of the base; 0 if
    /// this BSDF does not include the coat.
    #[inline]
    fn coat_probability(&self, wo: Vec3, n: Vec3) -> f32 {
        if !self.includes_coat() {
            return 0.0;
        }
        let (coat, base) = self.layer_albedos(wo, n);
        if base > 0.0 { coat / (coat + base) } else { 1.0 }
    }

    /// Solid-angle pdf \[1/sr] with which [`CoatedDiffuse::sample`] samples `wi`, given `wo`.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        let (cosine, coat) = (warp::cosine_hemisphere_pdf(wi.dot(n).abs()), self.coat_probability(wo, n));
        if coat == 0.0 {
            cosine
        } else {
            coat * self.coat_divided_by_probability(1.0).pdf(wo, wi, n) + (1.0 - coat) * cosine
        }
    }

    /// Samples a direction of reflection on the base or on the coat.
    ///
    /// `lobe` in \[0, 1) selects the layer, and `u` in \[0, 1)² the direction. `n` is the shading
    /// normal. Returns `None` if the direction points into the surface.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, lobe: f32, u: Vec2) -> Option<NonSpecularSample> {
        let n = face_forward(n, wo);
        let wi = if lobe < self.coat_probability(wo, n) {
            self.coat_divided_by_probability(1.0).sample_reflected_direction(wo, n, u)?
        } else {
            Frame::from_normal(n).to_world(warp::square_to_cosine_hemisphere(u))
        };
        let cos = wi.dot(n);
        if cos <= 0.0 {
            return None;
        }
        let pdf = self.pdf(wo, wi, n);
        let weight = self.evaluate(wo, wi, n) * (cos / pdf);
        (pdf > 0.0).then_some(NonSpecularSample { wi, weight, pdf, is_transmitted: false })
    }
}
