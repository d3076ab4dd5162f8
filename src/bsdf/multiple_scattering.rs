//! Energy compensation for GGX microfacets: light that they scatter more than once (Kulla and Conty
//! 2017).
//!
//! A microfacet BSDF counts only light that scatters at one microfacet. The rest meets further
//! microfacets and is *lost* from that BSDF. This module adds it back.
//!
//! Lost light leaves in directions that depend little on its direction of arrival. So its BSDF is a
//! product of one function of `wo` and one of `wi`. The product is reciprocal, and its albedo is
//! the lost fraction.

use super::coat_albedo::mean_fresnel_reflectance;
use super::fresnel::fresnel_reflectance_and_cosine;
use super::microfacet::Ggx;
use super::{MIN_ROUGH_ALPHA, TransportMode};
use crate::math::{Frame, sin_cos_turns};
use glam::{DVec3, Vec2, Vec3};
use std::array;
use std::f64::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Treatment of light that meets more than one microfacet of a rough surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MicrofacetScattering {
    /// Light that meets a second microfacet is lost, as in pbrt-v4 and Mitsuba 3.
    Single,
    /// Light scatters at microfacets until it leaves the surface, so no light is lost to masking.
    Multiple,
}

/// Number of tabulated refractive indices, evenly spaced in √((η − 1)/(η + 1)) from 0 to 1.
const ETA_COUNT: usize = 25;

/// Number of tabulated roughnesses from [`MIN_ROUGH_ALPHA`] to 1, evenly spaced in the fourth root
/// of α.
const ALPHA_COUNT: usize = 25;

/// Number of tabulated cosines. Their grid positions ([`cosine_grid_position`]) are evenly spaced
/// from 0 to 1.
const COSINE_COUNT: usize = 24;

/// Fibonacci lattice over \[0, 1)² that samples visible microfacets, as (number of points n,
/// generator g). Point i is ((i + ½)/n, ((i·g mod n) + ½)/n).
const FACET_LATTICE: (usize, usize) = (377, 144);

/// Refractive index that stands for a surface that reflects all light. It is the last refractive
/// index of the table of lost light.
const REFLECTOR_INDEX: f64 = 1e9;

/// Least ratio of the cosine of incidence to α for which the table computes the fraction of lost
/// light. Smaller cosines are replaced, because a cosine of 0 would lead to 0/0.
const HORIZON_COSINE_PER_ALPHA: f64 = 1e-3;

/// Number of integration intervals between two neighboring cosine nodes, for means over the
/// hemisphere.
const INTERVALS_PER_NODE: usize = 16;

/// Index in arrays over the two sides of an interface: the side of lower refractive index.
const RARE_SIDE: usize = 0;

/// Index in arrays over the two sides of an interface: the side of higher refractive index.
const DENSE_SIDE: usize = 1;

/// Table entry for one refractive index and one roughness: fractions of light that meet a second
/// microfacet. Without multiple scattering, this light is lost.
#[derive(Debug)]
struct LostLightEntry {
    /// Lost fraction of light, by side of arrival ([`RARE_SIDE`], [`DENSE_SIDE`]) and by number of
    /// the cosine node.
    fraction_by_cosine: [[f32; COSINE_COUNT]; 2],
    /// Eighth root of the lost fraction of diffuse light, for each side of arrival.
    ///
    /// The fraction is nearly proportional to α², and roughness nodes are evenly spaced in the
    /// fourth root of α. So this root is nearly linear between the nodes.
    mean_fraction_eighth_root: [f32; 2],
    /// Fraction of diffuse light that a smooth interface transmits from the side of lower index.
    smooth_diffuse_transmittance: f32,
}

impl LostLightEntry {
    /// Computes the entry for refractive index number `index` < [`ETA_COUNT`] and roughness number
    /// `alpha` < [`ALPHA_COUNT`].
    fn new(index: usize, alpha: usize) -> Self {
        let ratio = (index as f64 / (ETA_COUNT - 1) as f64) * (index as f64 / (ETA_COUNT - 1) as f64);
        let eta = if index == ETA_COUNT - 1 { REFLECTOR_INDEX } else { (1.0 + ratio) / (1.0 - ratio) };
        let least = fourth_root(f64::from(MIN_ROUGH_ALPHA));
        let root = least + (1.0 - least) * alpha as f64 / (ALPHA_COUNT - 1) as f64;
        let alpha = (root * root) * (root * root);
        let node = |k: usize| cosine_at_grid_position(k as f64 / (COSINE_COUNT - 1) as f64, alpha);
        let by_cosine = [eta, 1.0 / eta]
            .map(|far_over_near| array::from_fn(|k| lost_fraction(node(k), far_over_near, alpha) as f32));
        let mean_root = by_cosine.map(|lost| fourth_root(cosine_weighted_mean(&lost, alpha)).sqrt() as f32);
        let transmittance = match index {
            0 => 1.0,
            _ if index == ETA_COUNT - 1 => 0.0,
            _ => 1.0 - mean_fresnel_reflectance(eta) as f32,
        };
        Self {
            fraction_by_cosine: by_cosine,
            mean_fraction_eighth_root: mean_root,
            smooth_diffuse_transmittance: transmittance,
        }
    }

    /// Returns the cached entry for refractive index number `index` and roughness number `alpha`.
    /// The first call computes it.
    fn at_nodes(index: usize, alpha: usize) -> &'static Self {
        static ENTRIES: [[OnceLock<LostLightEntry>; ALPHA_COUNT]; ETA_COUNT] =
            [const { [const { OnceLock::new() }; ALPHA_COUNT] }; ETA_COUNT];
        ENTRIES[index][alpha].get_or_init(|| Self::new(index, alpha))
    }
}

/// Lost light at any refractive index and roughness: the fractions of light that meet a second
/// microfacet. The fractions are interpolated bilinearly between four table entries.
#[derive(Clone, Copy, Debug)]
struct LostLight {
    entries: [&'static LostLightEntry; 4],
    weights: [f32; 4],
    alpha: f64,
}

impl LostLight {
    /// Lost light at an interface of roughness `alpha`. `eta` ≥ 1 is the refractive index of the
    /// dense side, divided by the index of the rare side.
    #[inline]
    fn of_interface(eta: f64, alpha: f64) -> Self {
        Self::between_eta_nodes(node_and_fraction(((eta - 1.0) / (eta + 1.0)).sqrt(), ETA_COUNT), alpha)
    }

    /// Lost light at a surface of roughness `alpha` that reflects all light.
    #[inline]
    fn of_reflector(alpha: f64) -> Self {
        Self::between_eta_nodes((ETA_COUNT - 1, 0.0), alpha)
    }

    /// Interpolates the table at roughness `alpha`, and at a refractive index between the nodes
    /// `index.0` and `index.0` + 1.
    ///
    /// `index.1` in \[0, 1] is the position between these nodes.
    #[inline]
    fn between_eta_nodes(index: (usize, f32), alpha: f64) -> Self {
        let least = fourth_root(f64::from(MIN_ROUGH_ALPHA));
        let (j, v) = node_and_fraction((fourth_root(alpha) - least) / (1.0 - least), ALPHA_COUNT);
        let ((i, u), next) = (index, (index.0 + 1).min(ETA_COUNT - 1));
        let entries = [(i, j), (i, j + 1), (next, j), (next, j + 1)].map(|(i, j)| LostLightEntry::at_nodes(i, j));
        Self { entries, weights: [(1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v], alpha }
    }

    /// Returns the mean of `value` over the four table entries, with the weights of bilinear
    /// interpolation.
    #[inline]
    fn interpolate(&self, value: impl Fn(&LostLightEntry) -> f32) -> f64 {
        f64::from(self.entries.iter().zip(self.weights).map(|(entry, weight)| value(entry) * weight).sum::<f32>())
    }

    /// Fraction of light that meets a second microfacet, if it arrives on side `side`
    /// ([`RARE_SIDE`] or [`DENSE_SIDE`]) with the cosine of incidence `cos`.
    #[inline]
    fn fraction(&self, side: usize, cos: f64) -> f64 {
        let (node, u) = node_and_fraction(cosine_grid_position(cos, self.alpha), COSINE_COUNT);
        self.interpolate(|entry| {
            entry.fraction_by_cosine[side][node] * (1.0 - u) + entry.fraction_by_cosine[side][node + 1] * u
        })
    }

    /// Fraction of diffuse light that meets a second microfacet, if it arrives on side `side`
    /// ([`RARE_SIDE`] or [`DENSE_SIDE`]). The result is above 0, so it can be a divisor.
    #[inline]
    fn mean_fraction(&self, side: usize) -> f64 {
        let root = self.interpolate(|entry| entry.mean_fraction_eighth_root[side]);
        let fourth = (root * root) * (root * root);
        fourth * fourth
    }
}

/// Reflection of light that microfacets of a metal scatter more than once, for one direction `wo`.
#[derive(Clone, Copy, Debug)]
pub(super) struct MultipleConductorScattering {
    lost_light: LostLight,
    /// Fraction of light from `wo` that meets a second microfacet. It is also the probability of
    /// sampling this reflection.
    pub lost_fraction: f64,
}

impl MultipleConductorScattering {
    /// Creates the reflection at microfacets of roughness `alpha`. `cos_o` is the cosine between
    /// `wo` and the normal.
    #[inline]
    pub(super) fn new(alpha: f32, cos_o: f64) -> Self {
        let loss = LostLight::of_reflector(f64::from(alpha));
        Self { lost_light: loss, lost_fraction: loss.fraction(RARE_SIDE, cos_o) }
    }

    /// BRDF \[1/sr] of light that is reflected more than once, if microfacets reflect all light.
    ///
    /// `cos_i` is the cosine of `wi`.
    #[inline]
    pub(super) fn evaluate(&self, cos_i: f64) -> f64 {
        FRAC_1_PI * self.lost_fraction * self.lost_light.fraction(RARE_SIDE, cos_i)
            / self.lost_light.mean_fraction(RARE_SIDE)
    }

    /// Returns the factor on [`Self::evaluate`] for microfacets that reflect the fraction
    /// `reflectance`.
    ///
    /// Let r be `reflectance`, and b the fraction of diffuse light that meets another microfacet.
    /// Light that leaves after k + 2 reflections contributes r²·(1 − b)·(r·b)ᵏ. The factor is the
    /// sum over k ≥ 0 (Kulla and Conty 2017; Hill 2018).
    #[inline]
    pub(super) fn repeated_reflectance(&self, reflectance: f64) -> f64 {
        let lost = self.lost_light.mean_fraction(RARE_SIDE);
        reflectance * reflectance * (1.0 - lost) / (1.0 - reflectance * lost)
    }
}

/// Reflection and transmission of light that microfacets of a dielectric scatter more than once,
/// for one direction `wo`.
///
/// Suppose diffuse light arrives on both sides, with radiance proportional to the squared
/// refractive index n². Let E be the irradiance on the side of lower index. Of the arriving light,
/// b·E meets a second microfacet on this side, and b′·E on the other side. Of this light, T·E
/// crosses the interface in each direction, where T = t·min(b, b′), and t is the diffuse
/// transmittance of a smooth interface. Equal T in both directions makes the BSDF reciprocal up to
/// n².
#[derive(Clone, Copy, Debug)]
pub(super) struct MultipleDielectricScattering {
    lost_light: LostLight,
    /// Side of `wo`: [`RARE_SIDE`] or [`DENSE_SIDE`].
    near_side: usize,
    /// Refractive index of the far side, relative to the side of `wo`.
    eta: f64,
    /// Transmitted fraction of the light that meets a second microfacet: this fraction leaves on
    /// the side opposite to `wo`, and the rest on the side of `wo`.
    crossing_fraction: f64,
    /// Fraction of light from `wo` that meets a second microfacet. It is also the probability of
    /// sampling this BSDF.
    pub lost_fraction: f64,
}

impl MultipleDielectricScattering {
    /// Creates the scattering at microfacets of roughness `alpha`.
    ///
    /// `eta` is the refractive index of the far side, relative to the side of `wo`. `cos_o` is the
    /// cosine between `wo` and the normal.
    #[inline]
    pub(super) fn new(eta: f64, alpha: f32, cos_o: f64) -> Self {
        let (near, ratio) = if eta < 1.0 { (DENSE_SIDE, 1.0 / eta) } else { (RARE_SIDE, eta) };
        let loss = LostLight::of_interface(ratio, f64::from(alpha));
        let lost_by_side = [loss.mean_fraction(RARE_SIDE), loss.mean_fraction(DENSE_SIDE) * ratio * ratio];
        let transmittance = loss.interpolate(|entry| entry.smooth_diffuse_transmittance);
        let crossing = transmittance * lost_by_side[RARE_SIDE].min(lost_by_side[DENSE_SIDE]) / lost_by_side[near];
        Self {
            lost_light: loss,
            near_side: near,
            eta,
            crossing_fraction: crossing,
            lost_fraction: loss.fraction(near, cos_o),
        }
    }

    /// Returns the fraction of the light with repeated scattering that leaves on the side of `wo`.
    /// If `is_transmitted` is true, returns the fraction that leaves on the other side.
    #[inline]
    pub(super) fn leaving_fraction(&self, is_transmitted: bool) -> f64 {
        if is_transmitted { self.crossing_fraction } else { 1.0 - self.crossing_fraction }
    }

    /// BSDF \[1/sr] of light that scatters more than once, for `wi` of absolute cosine `cos_i`.
    #[inline]
    pub(super) fn evaluate(&self, cos_i: f64, is_transmitted: bool, transport: TransportMode) -> f64 {
        let side = if is_transmitted { 1 - self.near_side } else { self.near_side };
        let f = FRAC_1_PI
            * self.lost_fraction
            * self.leaving_fraction(is_transmitted)
            * self.lost_light.fraction(side, cos_i)
            / self.lost_light.mean_fraction(side);
        if is_transmitted && transport == TransportMode::Radiance { f / (self.eta * self.eta) } else { f }
    }
}

/// Samples a direction for light that microfacets scatter more than once, from random numbers `u`
/// in \[0, 1)².
///
/// The unit vector is on the side of the normal `n`. Its pdf is
/// [`multiple_scattering_direction_pdf`].
#[inline]
pub(super) fn sample_multiple_scattering_direction(alpha: f32, n: Vec3, u: Vec2) -> Vec3 {
    let a2 = f64::from(alpha) * f64::from(alpha);
    // The cumulative distribution of c = cosθ is ln(1 + c²/α²)/ln(1 + 1/α²).
    let cos2 = (a2 * libm::expm1(f64::from(u.x) * libm::log1p(1.0 / a2))).clamp(0.0, 1.0);
    let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).sqrt());
    let (sin_phi, cos_phi) = sin_cos_turns(u.y);
    let local = DVec3::new(sin * f64::from(cos_phi), sin * f64::from(sin_phi), cos).as_vec3();
    Frame::from_normal(n).to_world(local).normalize()
}

/// Solid-angle pdf \[1/sr] of [`sample_multiple_scattering_direction`] for a direction of cosine
/// `cos` > 0.
///
/// The pdf is proportional to cosθ/(cos²θ + α²), because the fraction of light that meets a second
/// microfacet is about α²/(cos²θ + α²).
#[inline]
pub(super) fn multiple_scattering_direction_pdf(alpha: f32, cos: f64) -> f64 {
    let a2 = f64::from(alpha) * f64::from(alpha);
    FRAC_1_PI * cos / ((cos * cos + a2) * libm::log1p(1.0 / a2))
}

/// Returns the fraction of light that is lost if each light path scatters at one microfacet only.
/// The light arrives with the cosine of incidence `cos`.
///
/// `eta` is the refractive index of the far side, relative to the near side.
fn lost_fraction(cos: f64, eta: f64, alpha: f64) -> f64 {
    let cos = cos.max(HORIZON_COSINE_PER_ALPHA * alpha);
    let (ggx, wo) = (Ggx::new(alpha as f32), DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos));
    let (facets, generator) = FACET_LATTICE;
    let mut kept = 0.0;
    for i in 0..facets {
        let u = (Vec2::new(i as f32, (i * generator % facets) as f32) + 0.5) / facets as f32;
        let m = ggx.sample_visible_normal(wo, Vec3::Z, u);
        let cos_m = wo.dot(m).min(1.0);
        if cos_m <= 0.0 {
            continue;
        }
        let (reflectance, cos_t) = fresnel_reflectance_and_cosine(cos_m, eta);
        let reflected = 2.0 * cos_m * m.z - wo.z;
        if reflected > 0.0 {
            let masking = ggx.reflection_g2_over_cosines(cos, reflected);
            kept += reflectance * ggx.unshadowed_microfacet_fraction(masking, cos, reflected);
        }
        let refracted = wo.z / eta - m.z * (cos_m / eta - cos_t);
        if reflectance < 1.0 && refracted > 0.0 {
            let masking = ggx.transmission_g2_over_cosines(cos, refracted);
            kept += (1.0 - reflectance) * ggx.unshadowed_microfacet_fraction(masking, cos, refracted);
        }
    }
    (1.0 - kept / facets as f64).max(0.0)
}

/// Fourth root of `x` ≥ 0.
#[inline]
fn fourth_root(x: f64) -> f64 {
    x.sqrt().sqrt()
}

/// Maps a cosine to its position in \[0, 1] on the cosine axis of the table: 0 is the first node, 1
/// the last.
///
/// Nodes are dense at cosines about α, where the fraction of light that meets a second microfacet
/// varies most.
#[inline]
fn cosine_grid_position(cos: f64, alpha: f64) -> f64 {
    0.5 * cos * (1.0 + (1.0 + alpha) / (cos + alpha))
}

/// Cosine whose [`cosine_grid_position`] is `x`.
fn cosine_at_grid_position(x: f64, alpha: f64) -> f64 {
    // The result is a root of c² + b·c − 2xα. The form depends on the sign of b, so that no digits
    // cancel.
    let b = 1.0 + 2.0 * (alpha - x);
    let root = (b * b + 8.0 * x * alpha).sqrt();
    if b > 0.0 { 4.0 * x * alpha / (b + root) } else { 0.5 * (root - b) }
}

/// Cosine-weighted mean of a function over the hemisphere. `values` are the values of the function
/// at the cosine nodes.
fn cosine_weighted_mean(values: &[f32; COSINE_COUNT], alpha: f64) -> f64 {
    let intervals = (COSINE_COUNT - 1) * INTERVALS_PER_NODE;
    let squared_cosine = |i: usize| {
        let cos = cosine_at_grid_position(i as f64 / intervals as f64, alpha);
        cos * cos
    };
    let part = |i: usize| {
        let (node, u) = (i / INTERVALS_PER_NODE, ((i % INTERVALS_PER_NODE) as f32 + 0.5) / INTERVALS_PER_NODE as f32);
        let value = values[node] * (1.0 - u) + values[node + 1] * u;
        f64::from(value) * (squared_cosine(i + 1) - squared_cosine(i))
    };
    (0..intervals).map(part).sum()
}

/// Returns the number of the node at or below `x`, and the position of `x` between this node and
/// the next one, in \[0, 1].
///
/// The `nodes` nodes are evenly spaced in \[0, 1] and numbered from 0.
#[inline]
fn node_and_fraction(x: f64, nodes: usize) -> (usize, f32) {
    let position = x.clamp(0.0, 1.0) * (nodes - 1) as f64;
    let node = (position as usize).min(nodes - 2);
    (node, (position - node as f64) as f32)
}
