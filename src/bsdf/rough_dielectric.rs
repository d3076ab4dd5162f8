//! Rough dielectric interfaces with GGX microfacets.

use super::fresnel::{fresnel_reflectance_and_cosine, fresnel_transmittance};
use super::microfacet::{Ggx, Microfacet};
use super::multiple_scattering::{
    MultipleDielectricScattering, multiple_scattering_direction_pdf, sample_multiple_scattering_direction,
};
use super::{BsdfSample, MicrofacetScattering, TransportMode};
use crate::color::Rgb;
use glam::{DVec3, Vec2, Vec3};

/// A rough interface between two transparent media, with GGX microfacets (Walter et al. 2007).
///
/// The normal points to the outside. With [`MicrofacetScattering::Multiple`], all light is
/// reflected or transmitted, within 1 %. With [`MicrofacetScattering::Single`], light that meets a
/// second microfacet is lost. The losses below are for index 1.5, normal incidence, and roughness
/// α of 0.1, 0.5 and 1. From the outside, 0.1, 3.2 and 11 % are lost. From the inside, 1.2, 25 and
/// 58 % are lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// Refractive index of the inside, relative to the outside.
    eta: f32,
    /// GGX roughness α.
    alpha: f32,
    scattering: MicrofacetScattering,
}

/// Factors of the single-scattering BSDF: density, Fresnel factor and masking of the microfacets
/// that reflect or refract `wi` to `wo`.
struct FacetScattering {
    facet: Microfacet,
    /// Fresnel reflectance or transmittance.
    fresnel_factor: f64,
    /// G₂/(cosθₒ·cosθᵢ), where G₂ is the masking-shadowing function.
    g2_over_cosines: f64,
}

impl RoughDielectric {
    /// Creates an interface with relative index `eta`, inside over outside, and roughness `alpha`.
    ///
    /// `eta` is not 1, and `alpha` is at least [`super::MIN_ROUGH_ALPHA`].
    #[inline]
    pub(super) fn new(eta: f32, alpha: f32, scattering: MicrofacetScattering) -> Self {
        Self { eta, alpha, scattering }
    }

    /// GGX roughness α, at least [`super::MIN_ROUGH_ALPHA`].
    #[inline]
    pub(super) fn alpha(&self) -> f32 {
        self.alpha
    }

    /// Refractive index of the far side, relative to the side of `wo`.
    ///
    /// `ng` is the geometric normal on the outer side.
    #[inline]
    fn far_over_near_index(&self, wo: Vec3, ng: Vec3) -> f64 {
        let eta = f64::from(self.eta);
        if wo.dot(ng) >= 0.0 { eta } else { 1.0 / eta }
    }

    /// Returns the factors of the single-scattering BSDF for the unit directions `o` (as `wo`) and
    /// `i` (as `wi`).
    ///
    /// Returns `None` if no microfacet refracts `i` to `o`. `o` is on the side of the normal `n`.
    /// `eta` is the refractive index of the far side, relative to the side of `o`.
    #[inline]
    fn facet_scattering(&self, o: DVec3, i: DVec3, n: DVec3, eta: f64) -> Option<FacetScattering> {
        let ggx = Ggx::new(self.alpha);
        let (cos_o, cos_i) = (o.dot(n), i.dot(n));
        Some(if cos_i > 0.0 {
            let facet = ggx.reflecting_facet(o, i, n);
            let fresnel = fresnel_reflectance_and_cosine(facet.wo_dot_m, eta).0;
            FacetScattering {
                facet,
                fresnel_factor: fresnel,
                g2_over_cosines: ggx.reflection_g2_over_cosines(cos_o, cos_i),
            }
        } else {
            let (facet, cos_t) = ggx.refracting_facet(o, i, n, eta)?;
            // The transmittance is computed from both cosines, so that f(wo, wi) and f(wi, wo)
            // agree even if one direction grazes.
            let fresnel = fresnel_transmittance(facet.wo_dot_m, cos_t, eta);
            FacetScattering {
                facet,
                fresnel_factor: fresnel,
                g2_over_cosines: ggx.transmission_g2_over_cosines(cos_o, -cos_i),
            }
        })
    }

    /// Returns the BSDF of light that scatters at several microfacets, for `wo` of cosine `cos_o`.
    /// Returns `None` if the surface has only single scattering.
    ///
    /// `eta` is the refractive index of the far side, relative to the side of `wo`.
    #[inline]
    fn multiple_scattering(&self, eta: f64, cos_o: f64) -> Option<MultipleDielectricScattering> {
        match self.scattering {
            MicrofacetScattering::Single => None,
            MicrofacetScattering::Multiple => Some(MultipleDielectricScattering::new(eta, self.alpha, cos_o)),
        }
    }

    /// BSDF f(wo, wi) \[1/sr], without the cosine.
    ///
    /// `n` is the shading normal on the side of `wo`, and `ng` the outer geometric normal. `n` and
    /// `ng` must agree on whether `wi` is on the side of `wo`.
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3, ng: Vec3, transport: TransportMode) -> Rgb {
        let (eta, o, i, n) = (self.far_over_near_index(wo, ng), wo.as_dvec3(), wi.as_dvec3(), n.as_dvec3());
        let is_transmitted = i.dot(n) < 0.0;
        let single = self.facet_scattering(o, i, n, eta).map_or(0.0, |scattering| {
            let FacetScattering { facet, fresnel_factor: fresnel, g2_over_cosines: masking_shadowing } = scattering;
            fresnel * facet.normal_density * facet.wo_dot_m * facet.jacobian * masking_shadowing
                / transmitted_radiance_divisor(eta, is_transmitted, transport)
        });
        let multiple = self
            .multiple_scattering(eta, o.dot(n))
            .map_or(0.0, |multiple| multiple.evaluate(i.dot(n).abs(), is_transmitted, transport));
        Rgb::splat((single + multiple) as f32)
    }

    /// Solid-angle pdf \[1/sr] with which [`Self::sample`] samples `wi`, given `wo`.
    ///
    /// The arguments are those of [`Self::evaluate`].
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3, ng: Vec3) -> f32 {
        let (eta, o, i, n) = (self.far_over_near_index(wo, ng), wo.as_dvec3(), wi.as_dvec3(), n.as_dvec3());
        let (cos_o, cos_i) = (o.dot(n), i.dot(n));
        let single = self
            .facet_scattering(o, i, n, eta)
            .map_or(0.0, |m| m.fresnel_factor * Ggx::new(self.alpha).scattered_direction_pdf(&m.facet, cos_o));
        let pdf = self.multiple_scattering(eta, cos_o).map_or(single, |multiple| {
            let part = multiple.lost_fraction * multiple.leaving_fraction(cos_i < 0.0);
            (1.0 - multiple.lost_fraction) * single + part * multiple_scattering_direction_pdf(self.alpha, cos_i.abs())
        });
        pdf as f32
    }

    /// Samples a direction of reflection or refraction.
    ///
    /// `lobe` in \[0, 1) chooses single or multiple scattering, and reflection or refraction. `u`
    /// in \[0, 1)² selects one of the microfacets visible from `wo`, or the direction after
    /// multiple scattering. `n` is the shading normal on the side of `wo`, and `ng` the outer
    /// geometric normal. Returns `None` if the microfacet reflects through the surface, or refracts
    /// to the side of `wo`.
    #[inline]
    pub(super) fn sample(
        &self,
        wo: Vec3,
        n: Vec3,
        ng: Vec3,
        lobe: f32,
        u: Vec2,
        transport: TransportMode,
    ) -> Option<BsdfSample> {
        let (ggx, o, eta) = (Ggx::new(self.alpha), wo.as_dvec3(), self.far_over_near_index(wo, ng));
        let multiple = self.multiple_scattering(eta, o.dot(n.as_dvec3()));
        let (lost, lobe) = (multiple.map_or(0.0, |multiple| multiple.lost_fraction), f64::from(lobe));
        let (wi, is_transmitted) = match multiple {
            Some(multiple) if lobe < lost => {
                let is_transmitted = lobe < lost * multiple.leaving_fraction(true);
                (
                    sample_multiple_scattering_direction(self.alpha, if is_transmitted { -n } else { n }, u),
                    is_transmitted,
                )
            }
            Some(_) | None => {
                let m = ggx.sample_visible_normal(o, n, u);
                let cos = o.dot(m);
                let (reflectance, cos_t) = fresnel_reflectance_and_cosine(cos, eta);
                let is_transmitted = lobe - lost >= reflectance * (1.0 - lost);
                let wi = if is_transmitted { m * (cos / eta - cos_t) - o / eta } else { m * (2.0 * cos) - o };
                (wi.normalize().as_vec3(), is_transmitted)
            }
        };

        // Use the rounded direction, as `evaluate` and `pdf` do.
        let (i, shading) = (wi.as_dvec3(), n.as_dvec3());
        let (cos_o, cos_i) = (o.dot(shading), i.dot(shading));
        if (cos_i < 0.0) != is_transmitted || cos_i == 0.0 {
            return None;
        }
        let (pdf, weight) = if multiple.is_some() {
            let pdf = self.pdf(wo, wi, n, ng);
            (pdf, self.evaluate(wo, wi, n, ng, transport) * (cos_i.abs() as f32 / pdf))
        } else {
            let FacetScattering { facet, fresnel_factor: fresnel, g2_over_cosines: masking_shadowing } =
                self.facet_scattering(o, i, shading, eta)?;
            let unshadowed = ggx.unshadowed_microfacet_fraction(masking_shadowing, cos_o, cos_i.abs());
            let divisor = transmitted_radiance_divisor(eta, is_transmitted, transport);
            ((fresnel * ggx.scattered_direction_pdf(&facet, cos_o)) as f32, Rgb::splat((unshadowed / divisor) as f32))
        };
        (pdf > 0.0).then(|| BsdfSample::non_specular_sample(wi, weight, pdf, is_transmitted))
    }
}

/// Number by which a path's throughput is divided: `eta`² for transmitted radiance, else 1.
///
/// `eta` is the refractive index of the far side, relative to the near side.
#[inline]
fn transmitted_radiance_divisor(eta: f64, is_transmitted: bool, transport: TransportMode) -> f64 {
    if is_transmitted && transport == TransportMode::Radiance { eta * eta } else { 1.0 }
}
