//! Isotropic GGX microfacets (Trowbridge and Reitz 1975; Walter et al. 2007).
//!
//! Roughness α is the parameter of the distribution, not its square root. Computations are in f64:
//! at α = 10⁻³, the width of a lobe is only 10⁴ rounding errors of an f32 direction.
//!
//! Unit vectors `wo` and `wi` point away from the surface. `n` is the macroscopic normal on the
//! side of `wo`.

use crate::math::{Frame, sin_cos_turns};
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::FRAC_1_PI;

/// The GGX distribution of microfacet normals with roughness `alpha`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ggx {
    alpha: f64,
}

/// Normal density and geometry of the microfacets that scatter light from `wi` to `wo`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacet {
    /// Normal distribution function D(m): area of the microfacets per surface area and per solid
    /// angle of normals \[1/sr].
    pub normal_density: f64,
    /// Cosine between `wo` and the microfacet normal m.
    pub wo_dot_m: f64,
    /// Jacobian dω(m)/dω(wi): solid angle of microfacet normals over solid angle of `wi`.
    pub jacobian: f64,
}

impl Ggx {
    /// Distribution with roughness `alpha` > 0.
    #[inline]
    pub(super) fn new(alpha: f32) -> Self {
        Self { alpha: f64::from(alpha) }
    }

    /// Returns the density D(m) \[1/sr] of microfacets with the unit normal m = `h`/|`h`|.
    ///
    /// `n` is the macroscopic normal.
    #[inline]
    pub(super) fn microfacet_normal_density(self, h: DVec3, n: DVec3) -> f64 {
        let a2 = self.alpha * self.alpha;
        let (along, across, length2) = (h.dot(n), h.cross(n).length_squared(), h.length_squared());
        let slope = a2 * along * along + across;
        if slope > 0.0 { FRAC_1_PI * a2 * length2 * length2 / (slope * slope) } else { 0.0 }
    }

    /// Returns √(cos²θ + α² sin²θ), for the cosine `cos` of θ.
    ///
    /// The value is cosθ·(1 + 2Λ(θ)), where Λ is Smith's function.
    #[inline]
    fn smith_square_root(self, cos: f64) -> f64 {
        let cos2 = cos * cos;
        (cos2 + self.alpha * self.alpha * (1.0 - cos2).max(0.0)).sqrt()
    }

    /// Returns G₁(θ)/cosθ for the cosine `cos` of θ, where G₁ = 1/(1 + Λ) is Smith's masking
    /// function.
    #[inline]
    fn g1_over_cos(self, cos: f64) -> f64 {
        2.0 / (cos + self.smith_square_root(cos))
    }

    /// Returns G₂/(cosθₒ·cosθᵢ) for directions on one side, from their cosines to the normal.
    ///
    /// G₂ = 1/(1 + Λₒ + Λᵢ) is the height-correlated masking-shadowing function, with Smith's
    /// function Λ (Heitz 2014, section 5.3).
    #[inline]
    pub(super) fn reflection_g2_over_cosines(self, cos_o: f64, cos_i: f64) -> f64 {
        2.0 / (cos_i * self.smith_square_root(cos_o) + cos_o * self.smith_square_root(cos_i))
    }

    /// Returns G₂/(cosθₒ·cosθᵢ) for directions on opposite sides, from their absolute cosines.
    ///
    /// The masking-shadowing function G₂ is the product of the masking functions G₁ of both
    /// directions (Walter et al. 2007). Height correlation would transmit too much, because a
    /// microfacet that is high for one side is low for the other.
    #[inline]
    pub(super) fn transmission_g2_over_cosines(self, cos_o: f64, cos_i: f64) -> f64 {
        self.g1_over_cos(cos_o) * self.g1_over_cos(cos_i)
    }

    /// Returns G₂/G₁(wo): of the microfacets visible from `wo`, the fraction that is also visible
    /// from `wi`.
    ///
    /// `masking_shadowing` is G₂/(cosθₒ·cosθᵢ), where G₂ is the masking-shadowing function.
    #[inline]
    pub(super) fn unshadowed_microfacet_fraction(self, masking_shadowing: f64, cos_o: f64, cos_i: f64) -> f64 {
        masking_shadowing * cos_i / self.g1_over_cos(cos_o)
    }

    /// Solid-angle pdf \[1/sr] of `wi`, if `wi` is computed from a microfacet normal that
    /// [`Ggx::sample_visible_normal`] samples.
    ///
    /// `facet` describes the microfacets that scatter `wi` to `wo`. `cos_o` is the cosine between
    /// `wo` and the macroscopic normal.
    #[inline]
    pub(super) fn scattered_direction_pdf(self, facet: &Microfacet, cos_o: f64) -> f64 {
        self.g1_over_cos(cos_o) * facet.wo_dot_m * facet.normal_density * facet.jacobian
    }

    /// Samples the unit normal of a microfacet visible from `wo`, by `u` in \[0, 1)².
    ///
    /// The pdf is proportional to the visible area of the microfacets. Source: Dupuy and Benyoub
    /// 2023, "Sampling Visible GGX Normals with Spherical Caps".
    #[inline]
    pub(super) fn sample_visible_normal(self, wo: DVec3, n: Vec3, u: Vec2) -> DVec3 {
        let frame = Frame::from_normal(n);
        let (s, t, n) = (frame.s.as_dvec3(), frame.t.as_dvec3(), n.as_dvec3());
        let o = DVec3::new(self.alpha * wo.dot(s), self.alpha * wo.dot(t), wo.dot(n)).normalize();
        // The spherical cap has height 1 + o.z. `drop` is the depth of the sampled point below the
        // cap's top, where digits do not cancel.
        let (cap, u_z) = (1.0 + o.z, f64::from(u.x));
        let drop = u_z * cap;
        let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turns(u.y);
        let (x, y) = (radius * f64::from(cos) + o.x, radius * f64::from(sin) + o.y);
        (s * (self.alpha * x) + t * (self.alpha * y) + n * (cap - drop)).normalize()
    }

    /// Returns the density and geometry of the microfacets that reflect `wi` to `wo`.
    ///
    /// Both directions are on the side of the macroscopic normal `n`.
    #[inline]
    pub(super) fn reflecting_facet(self, wo: DVec3, wi: DVec3, n: DVec3) -> Microfacet {
        let h = wo + wi;
        // wo · m is half the length of wo + wi.
        let cos = 0.5 * h.length();
        Microfacet { normal_density: self.microfacet_normal_density(h, n), wo_dot_m: cos, jacobian: 0.25 / cos }
    }

    /// Returns the microfacets that refract `wi` to `wo`, and the cosine between −m and `wi`.
    ///
    /// m is the normal of these microfacets. `wi` is on the side opposite to the macroscopic normal
    /// `n`. `eta` is the refractive index on the side of `wi`, relative to the side of `wo`.
    /// Returns `None` if no microfacet refracts `wi` to `wo`.
    #[inline]
    pub(super) fn refracting_facet(self, wo: DVec3, wi: DVec3, n: DVec3, eta: f64) -> Option<(Microfacet, f64)> {
        let h = wo + wi * eta;
        let h = if h.dot(n) < 0.0 { -h } else { h };
        let (o, i, length2) = (wo.dot(h), wi.dot(h), h.length_squared());
        if o <= 0.0 || i >= 0.0 {
            return None;
        }
        let inverse = 1.0 / length2.sqrt();
        let cos_t = -i * inverse;
        let jacobian = eta * eta * cos_t / length2;
        Some((
            Microfacet { normal_density: self.microfacet_normal_density(h, n), wo_dot_m: o * inverse, jacobian },
            cos_t,
        ))
    }
}
