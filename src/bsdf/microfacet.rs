//! Isotropic GGX microfacets (Trowbridge and Reitz 1975; Walter et al. 2007).
//!
//! α is the parameter of the distribution, not its square root. Directions are f32, computations
//! f64: at α = 10⁻³ a lobe spans only some ten thousand roundings of a direction. No formula here
//! uses 1 − cos² of a facet, or the tangent of a grazing angle.

use crate::math::{Frame, sin_cos_turns};
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::FRAC_1_PI;

/// The GGX distribution at one roughness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ggx {
    alpha: f64,
}

/// The facet that scatters one direction into another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacet {
    /// D: facet area per solid angle and surface area \[1/sr].
    pub density: f64,
    /// Cosine between `wo` and the facet normal.
    pub cos: f64,
    /// Jacobian: solid angle of facet normals over solid angle of `wi`.
    pub jacobian: f64,
}

impl Ggx {
    #[inline]
    pub(super) fn new(alpha: f32) -> Self {
        Self { alpha: f64::from(alpha) }
    }

    /// D(m) for the normal m along `h`, of any length, about unit `n` \[1/sr].
    #[inline]
    pub(super) fn density(self, h: DVec3, n: DVec3) -> f64 {
        let a2 = self.alpha * self.alpha;
        let (along, across, length2) = (h.dot(n), h.cross(n).length_squared(), h.length_squared());
        let slope = a2 * along * along + across;
        if slope > 0.0 { FRAC_1_PI * a2 * length2 * length2 / (slope * slope) } else { 0.0 }
    }

    /// cosθ·(1 + 2Λ(θ)) = √(cos²θ + α²sin²θ), with Smith's Λ of this distribution.
    #[inline]
    fn smith_root(self, cos: f64) -> f64 {
        let cos2 = cos * cos;
        (cos2 + self.alpha * self.alpha * (1.0 - cos2).max(0.0)).sqrt()
    }

    /// Smith masking G₁ = 1/(1 + Λ), over the cosine.
    #[inline]
    fn masking_over_cos(self, cos: f64) -> f64 {
        2.0 / (cos + self.smith_root(cos))
    }

    /// Masking-shadowing G₂ over both cosines, for directions on one side: height-correlated, 1/(1
    /// + Λₒ + Λᵢ) (Heitz 2014, section 5.3).
    #[inline]
    pub(super) fn reflection_masking_shadowing(self, cos_o: f64, cos_i: f64) -> f64 {
        2.0 / (cos_i * self.smith_root(cos_o) + cos_o * self.smith_root(cos_i))
    }

    /// Masking-shadowing G₂ over both cosines, for directions on opposite sides: G₁G₁ (Walter et
    /// al. 2007).
    ///
    /// A facet that is high for one side is low for the other, so height correlation would transmit
    /// too much. The exact Beta function costs two gammas.
    #[inline]
    pub(super) fn transmission_masking_shadowing(self, cos_o: f64, cos_i: f64) -> f64 {
        self.masking_over_cos(cos_o) * self.masking_over_cos(cos_i)
    }

    /// Unshadowed fraction of light that leaves a facet visible from `wo`: G₂/G₁(wo).
    #[inline]
    pub(super) fn unshadowed_fraction(self, masking_shadowing: f64, cos_o: f64, cos_i: f64) -> f64 {
        masking_shadowing * cos_i / self.masking_over_cos(cos_o)
    }

    /// Solid-angle pdf of `wi` if [`Ggx::sample_visible_normal`] samples the facet \[1/sr].
    #[inline]
    pub(super) fn scattered_direction_pdf(self, facet: &Microfacet, cos_o: f64) -> f64 {
        self.masking_over_cos(cos_o) * facet.cos * facet.density * facet.jacobian
    }

    /// Samples a unit facet normal by the area visible from `wo`, which is on the side of `n`.
    ///
    /// The method samples the spherical cap of directions that a unit hemisphere reflects (Dupuy
    /// and Benyoub 2023).
    #[inline]
    pub(super) fn sample_visible_normal(self, wo: DVec3, n: Vec3, u: Vec2) -> DVec3 {
        let frame = Frame::from_normal(n);
        let (s, t, n) = (frame.s.as_dvec3(), frame.t.as_dvec3(), n.as_dvec3());
        let o = DVec3::new(self.alpha * wo.dot(s), self.alpha * wo.dot(t), wo.dot(n)).normalize();
        // The cap has height 1 + o.z. Measured from its top, nothing cancels.
        let (cap, u_z) = (1.0 + o.z, f64::from(u.x));
        let drop = u_z * cap;
        let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turns(u.y);
        let (x, y) = (radius * f64::from(cos) + o.x, radius * f64::from(sin) + o.y);
        (s * (self.alpha * x) + t * (self.alpha * y) + n * (cap - drop)).normalize()
    }

    /// The facet that reflects `wi` to `wo`.
    #[inline]
    pub(super) fn reflecting_facet(self, wo: DVec3, wi: DVec3, n: DVec3) -> Microfacet {
        let h = wo + wi;
        // wo · m is half the length of wo + wi.
        let cos = 0.5 * h.length();
        Microfacet { density: self.density(h, n), cos, jacobian: 0.25 / cos }
    }

    /// The facet that refracts `wi`, on the side of relative index `eta`, to `wo` on the side of
    /// `n`.
    ///
    /// Also returns the cosine between `wi` and the far side of the facet; `None` if no upward
    /// facet does.
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
        Some((Microfacet { density: self.density(h, n), cos: o * inverse, jacobian }, cos_t))
    }
}
