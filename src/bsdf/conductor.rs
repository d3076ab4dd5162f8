//! BSDF of conductors: smooth and rough metals.

use super::fresnel::conductor_reflectance;
use super::microfacet::Ggx;
use super::multiple_scattering::{
    MultipleConductorScattering, multiple_scattering_direction_pdf, sample_multiple_scattering_direction,
};
use super::properties::{BsdfProperties, DIFFUSE_CONE_SPREAD};
use super::sample::NonSpecularSample;
use super::{BsdfSample, MIN_PHOTON_STORAGE_ALPHA, MIN_ROUGH_ALPHA, MicrofacetScattering, dielectric};
use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// Cosine of incidence at which the Fresnel reflectance is evaluated for light that microfacets
/// reflect repeatedly.
///
/// The value is the mean cosine of diffuse light, as a stand-in for the mean over all microfacets
/// that light meets.
const MEAN_COSINE: f32 = 2.0 / 3.0;

/// Largest reflectance at normal incidence that [`conductor_index_of_reflectance`] converts. A
/// reflectance of 1 would need an infinite k.
const MAX_NORMAL_REFLECTANCE: f32 = 0.9999;

/// Returns a refractive index η + ik, by color channel, with which a metal has this `reflectance`
/// in \[0, 1] at normal incidence. The result is the pair (η, k).
///
/// η is 1, so the reflectance is k²/(4 + k²). A reflectance above 0.9999 counts as 0.9999.
#[must_use]
pub fn conductor_index_of_reflectance(reflectance: Rgb) -> (Rgb, Rgb) {
    let reflectance = reflectance.clamp(Rgb::ZERO, Rgb::splat(MAX_NORMAL_REFLECTANCE));
    (Rgb::ONE, 2.0 * (reflectance / (Rgb::ONE - reflectance)).map(f32::sqrt))
}

/// A smooth metal, or a rough metal with GGX microfacets. Both sides of the surface reflect.
///
/// With [`MicrofacetScattering::Multiple`], a metal of Fresnel reflectance 1 reflects all light,
/// within 1 %. With [`MicrofacetScattering::Single`], light that meets a second microfacet is lost.
/// The losses below are for a Fresnel reflectance of 1 and roughness α of 0.1, 0.2, 0.5 and 1. At
/// normal incidence, 1.2, 5, 31 and 69 % are lost. At an incidence angle of 85°, 11, 10, 13 and 22
/// % are lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Real part of the refractive index relative to the surroundings, by color channel.
    eta: Rgb,
    /// Imaginary part of the refractive index relative to the surroundings, by color channel.
    k: Rgb,
    /// GGX roughness α; 0 if the surface is smooth.
    alpha: f32,
    scattering: MicrofacetScattering,
}

impl Conductor {
    /// Creates a conductor with relative refractive index `eta` + i`k` and roughness `alpha` in
    /// \[0, 1].
    ///
    /// Both parts of the index are at least 0. Below [`MIN_ROUGH_ALPHA`], the surface is smooth.
    #[must_use]
    pub fn new(eta: Rgb, k: Rgb, alpha: f32, scattering: MicrofacetScattering) -> Self {
        Self { eta, k, alpha: if alpha < MIN_ROUGH_ALPHA { 0.0 } else { alpha }, scattering }
    }

    /// Creates a conductor that stays rough even if `alpha` is below [`MIN_ROUGH_ALPHA`].
    #[cfg(test)]
    pub(super) fn new_without_smooth_limit(eta: Rgb, k: Rgb, alpha: f32) -> Self {
        Self { eta, k, alpha, scattering: MicrofacetScattering::Single }
    }

    /// GGX roughness α; 0 if the surface is smooth.
    #[inline]
    #[must_use]
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// Properties of the metal. It stores photons if its roughness α exceeds
    /// [`MIN_PHOTON_STORAGE_ALPHA`].
    #[inline]
    pub(super) fn properties(&self) -> BsdfProperties {
        BsdfProperties {
            is_specular: self.is_smooth(),
            stores_photons: self.alpha > MIN_PHOTON_STORAGE_ALPHA,
            ray_cone_spread: self.alpha * DIFFUSE_CONE_SPREAD,
            ..BsdfProperties::CASTER
        }
    }

    /// True if the surface reflects like a mirror.
    #[inline]
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.alpha == 0.0
    }

    /// Returns the Fresnel reflectance of a microfacet at the cosine of incidence `cos`.
    #[inline]
    fn reflectance(&self, cos: f64) -> Rgb {
        conductor_reflectance(cos as f32, self.eta, self.k)
    }

    /// Returns the BRDF of light that is reflected at several microfacets, for `wo` of cosine
    /// `cos_o`. Returns `None` if the metal has only single scattering.
    #[inline]
    fn multiple_scattering(&self, cos_o: f64) -> Option<MultipleConductorScattering> {
        match self.scattering {
            MicrofacetScattering::Single => None,
            MicrofacetScattering::Multiple => Some(MultipleConductorScattering::new(self.alpha, cos_o)),
        }
    }

    /// BRDF f(wo, wi) \[1/sr]; 0 for a smooth metal.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        if self.is_smooth() {
            return Rgb::ZERO;
        }
        let (ggx, o, i, n) = (Ggx::new(self.alpha), wo.as_dvec3(), wi.as_dvec3(), n.as_dvec3());
        let (cos_o, cos_i) = (o.dot(n).abs(), i.dot(n).abs());
        let facet = ggx.reflecting_facet(o, i, n);
        let g2 = ggx.reflection_g2_over_cosines(cos_o, cos_i);
        let single = self.reflectance(facet.wo_dot_m) * (0.25 * facet.normal_density * g2) as f32;
        self.multiple_scattering(cos_o).map_or(single, |multiple| {
            let mean = conductor_reflectance(MEAN_COSINE, self.eta, self.k);
            let color = mean.map(|mean| multiple.repeated_reflectance(f64::from(mean)) as f32);
            single + color * multiple.evaluate(cos_i) as f32
        })
    }

    /// Solid-angle pdf \[1/sr] with which [`Conductor::sample`] samples `wi`; 0 for a smooth metal.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        if self.is_smooth() {
            return 0.0;
        }
        let (ggx, o, i, n) = (Ggx::new(self.alpha), wo.as_dvec3(), wi.as_dvec3(), n.as_dvec3());
        let cos_o = o.dot(n).abs();
        let single = ggx.scattered_direction_pdf(&ggx.reflecting_facet(o, i, n), cos_o);
        let pdf = self.multiple_scattering(cos_o).map_or(single, |multiple| {
            let lost = multiple.lost_fraction;
            (1.0 - lost) * single + lost * multiple_scattering_direction_pdf(self.alpha, i.dot(n).abs())
        });
        pdf as f32
    }

    /// Samples the direction in which a smooth or rough metal reflects, by `lobe` in \[0, 1) and
    /// `u` in \[0, 1)².
    ///
    /// `n` is the shading normal on the side of `wo`, and `ng` the geometric normal. Returns `None`
    /// if the reflected direction points into the surface.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, ng: Vec3, lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if self.is_smooth() {
            let (wi, uses_geometric_normal) = dielectric::reflect_above_surface(wo, n, ng);
            let cos = wo.dot((wo + wi).normalize_or_zero());
            let weight = conductor_reflectance(cos, self.eta, self.k);
            return Some(BsdfSample::specular_sample(wi, weight, false, uses_geometric_normal));
        }
        self.sample_rough(wo, n, lobe, u).map(BsdfSample::from)
    }

    /// Samples the direction of reflection of a rough metal; `None` if it points into the surface.
    ///
    /// `lobe` in \[0, 1) chooses single or multiple reflection. `u` in \[0, 1)² selects a
    /// microfacet visible from `wo`, or the direction after multiple reflection. `n` is the shading
    /// normal on the side of `wo`.
    #[inline]
    pub(super) fn sample_rough(&self, wo: Vec3, n: Vec3, lobe: f32, u: Vec2) -> Option<NonSpecularSample> {
        let (ggx, o, shading) = (Ggx::new(self.alpha), wo.as_dvec3(), n.as_dvec3());
        let cos_o = o.dot(shading);
        let multiple = self.multiple_scattering(cos_o.abs());
        let wi = if multiple.is_some_and(|multiple| f64::from(lobe) < multiple.lost_fraction) {
            sample_multiple_scattering_direction(self.alpha, n, u)
        } else {
            let m = ggx.sample_visible_normal(o, n, u);
            (m * (2.0 * o.dot(m)) - o).normalize().as_vec3()
        };
        let i = wi.as_dvec3();
        let cos_i = i.dot(shading);
        if cos_i <= 0.0 {
            return None;
        }
        let (pdf, weight) = if multiple.is_some() {
            let pdf = self.pdf(wo, wi, n);
            (pdf, self.evaluate(wo, wi, n) * (cos_i as f32 / pdf))
        } else {
            let facet = ggx.reflecting_facet(o, i, shading);
            let masking_shadowing = ggx.reflection_g2_over_cosines(cos_o, cos_i);
            let unshadowed = ggx.unshadowed_microfacet_fraction(masking_shadowing, cos_o, cos_i);
            (ggx.scattered_direction_pdf(&facet, cos_o) as f32, self.reflectance(facet.wo_dot_m) * unshadowed as f32)
        };
        (pdf > 0.0).then_some(NonSpecularSample { wi, weight, pdf, is_transmitted: false })
    }
}
