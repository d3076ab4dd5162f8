//! Conductors: smooth and rough metals.

use super::fresnel::conductor_reflectance;
use super::microfacet::Ggx;
use super::{BsdfSample, SMOOTH_ALPHA, dielectric};
use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// A conductor, reflecting on both sides: a mirror, or GGX facets that are mirrors.
///
/// Only single scattering between facets is modelled. The rest is lost: with reflectance 1 at
/// normal incidence, 1.2 % at α = 0.1, 5 % at 0.2, 31 % at 0.5 and 69 % at 1. At 85° it is 11, 10,
/// 13 and 22 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    eta: Rgb,
    k: Rgb,
    /// The GGX distribution; α is 0 for a mirror.
    alpha: f32,
}

impl Conductor {
    /// A conductor of complex relative index η + ik, each channel ≥ 0, and α in \[0, 1].
    ///
    /// Below [`SMOOTH_ALPHA`] it is a mirror.
    #[must_use]
    pub fn new(eta: Rgb, k: Rgb, alpha: f32) -> Self {
        Self { eta, k, alpha: if alpha < SMOOTH_ALPHA { 0.0 } else { alpha } }
    }

    /// [`Conductor::new`], but rough at any α.
    #[cfg(test)]
    pub(super) fn new_without_smooth_limit(eta: Rgb, k: Rgb, alpha: f32) -> Self {
        Self { eta, k, alpha }
    }

    /// Roughness α; 0 for a mirror.
    #[inline]
    #[must_use]
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// True if it is a mirror.
    #[inline]
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.alpha == 0.0
    }

    #[inline]
    fn reflectance(&self, cos: f64) -> Rgb {
        conductor_reflectance(cos as f32, self.eta, self.k)
    }

    /// f(wo, wi) \[1/sr] for directions on one side of `n`.
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        if self.is_smooth() {
            return Rgb::ZERO;
        }
        let (ggx, o, i, n) = (Ggx::new(self.alpha), wo.as_dvec3(), wi.as_dvec3(), n.as_dvec3());
        let facet = ggx.reflecting_facet(o, i, n);
        let g2 = ggx.reflection_masking_shadowing(o.dot(n).abs(), i.dot(n).abs());
        self.reflectance(facet.cos) * (0.25 * facet.density * g2) as f32
    }

    /// Solid-angle pdf of `wi` \[1/sr], for directions on one side of `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        if self.is_smooth() {
            return 0.0;
        }
        let (ggx, o, n) = (Ggx::new(self.alpha), wo.as_dvec3(), n.as_dvec3());
        ggx.scattered_direction_pdf(&ggx.reflecting_facet(o, wi.as_dvec3(), n), o.dot(n).abs()) as f32
    }

    /// Samples a visible facet, with `n` on the side of `wo`; `None` if it reflects into the
    /// surface.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, ng: Vec3, u: Vec2) -> Option<BsdfSample> {
        if self.is_smooth() {
            let (wi, uses_geometric_normal) = dielectric::reflect_above_surface(wo, n, ng);
            let cos = wo.dot((wo + wi).normalize_or_zero());
            let weight = conductor_reflectance(cos, self.eta, self.k);
            return Some(BsdfSample {
                wi,
                weight,
                pdf: 0.0,
                specular: true,
                transmitted: false,
                uses_geometric_normal,
            });
        }
        let (ggx, o) = (Ggx::new(self.alpha), wo.as_dvec3());
        let m = ggx.sample_visible_normal(o, n, u);
        let wi = (m * (2.0 * o.dot(m)) - o).normalize().as_vec3();
        let (i, n) = (wi.as_dvec3(), n.as_dvec3());
        let (cos_o, cos_i) = (o.dot(n), i.dot(n));
        if cos_i <= 0.0 {
            return None;
        }
        let facet = ggx.reflecting_facet(o, i, n);
        let pdf = ggx.scattered_direction_pdf(&facet, cos_o) as f32;
        let unshadowed_fraction = ggx.unshadowed_fraction(ggx.reflection_masking_shadowing(cos_o, cos_i), cos_o, cos_i);
        let weight = self.reflectance(facet.cos) * unshadowed_fraction as f32;
        (pdf > 0.0).then_some(BsdfSample {
            wi,
            weight,
            pdf,
            specular: false,
            transmitted: false,
            uses_geometric_normal: false,
        })
    }
}
