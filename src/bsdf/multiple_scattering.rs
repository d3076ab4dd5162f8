//! Light that GGX microfacets scatter more than once (Kulla and Conty 2017).
//!
//! A microfacet BSDF counts light that one microfacet scatters. The rest, the *lost* light, meets
//! further microfacets. It leaves in directions that depend little on where it came from, so it is
//! described by a product of two functions, one for each direction. The product is reciprocal, and
//! its integral is the lost light.

use super::coat_albedo::mean_fresnel_reflectance;
use super::fresnel::fresnel_reflectance;
use super::microfacet::Ggx;
use super::{SMOOTH_ALPHA, TransportMode};
use crate::math::{Frame, sin_cos_turns};
use glam::{DVec3, Vec2, Vec3};
use std::array;
use std::f64::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Treatment of light that several microfacets scatter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MicrofacetScattering {
    /// Light that a second microfacet meets is lost, as in pbrt-v4 and Mitsuba 3.
    Single,
    /// Light scatters at microfacets until it leaves the surface, so no light is lost to masking.
    Multiple,
}

/// Number of tabulated refractive indices, evenly spaced in √((η − 1)/(η + 1)) from 0 to 1.
const INDICES: usize = 25;

/// Number of tabulated roughnesses from [`SMOOTH_ALPHA`] to 1, evenly spaced in the fourth root of
/// α.
const ALPHAS: usize = 25;

/// Number of tabulated cosines, evenly spaced in [`grid_position`] from 0 to 1.
const COSINES: usize = 24;

/// Number of points and generator of a Fibonacci lattice, which selects visible microfacets.
const FACETS: (usize, usize) = (377, 144);

/// Refractive index of an interface that reflects all light, the last node of the table.
const REFLECTOR_INDEX: f64 = 1e9;

/// Cosine of the node for the horizon, as a fraction of α; a cosine of 0 would lead to 0/0.
const HORIZON: f64 = 1e-3;

/// Number of intervals between two nodes in means over directions.
const STEPS: usize = 16;

/// Index in arrays over the two sides of an interface: the side of lower refractive index.
const RARE: usize = 0;

/// Index in arrays over the two sides of an interface: the side of higher refractive index.
const DENSE: usize = 1;

/// Lost light at one refractive index and one roughness: light that one microfacet scatters so that
/// it meets another.
#[derive(Debug)]
struct LossCell {
    /// Lost fraction of light, for each side of arrival and each cosine of incidence.
    by_cosine: [[f32; COSINES]; 2],
    /// Eighth root of the lost fraction of diffuse light, for each side of arrival.
    ///
    /// The fraction is nearly proportional to α², and the nodes are spaced in the fourth root of α.
    /// So the root is nearly linear between the nodes.
    mean_root: [f32; 2],
    /// Fraction of diffuse light that a smooth interface transmits from the side of lower index.
    transmittance: f32,
}

impl LossCell {
    /// Computes the cell at node `index` of the refractive indices and node `alpha` of the
    /// roughnesses.
    fn new(index: usize, alpha: usize) -> Self {
        let ratio = (index as f64 / (INDICES - 1) as f64) * (index as f64 / (INDICES - 1) as f64);
        let eta = if index == INDICES - 1 { REFLECTOR_INDEX } else { (1.0 + ratio) / (1.0 - ratio) };
        let least = fourth_root(f64::from(SMOOTH_ALPHA));
        let root = least + (1.0 - least) * alpha as f64 / (ALPHAS - 1) as f64;
        let alpha = (root * root) * (root * root);
        let node = |k: usize| cosine_at_grid_position(k as f64 / (COSINES - 1) as f64, alpha);
        let by_cosine = [eta, 1.0 / eta]
            .map(|far_over_near| array::from_fn(|k| lost_fraction(node(k), far_over_near, alpha) as f32));
        let mean_root = by_cosine.map(|lost| fourth_root(mean_over_hemisphere(&lost, alpha)).sqrt() as f32);
        let transmittance = match index {
            0 => 1.0,
            _ if index == INDICES - 1 => 0.0,
            _ => 1.0 - mean_fresnel_reflectance(eta) as f32,
        };
        Self { by_cosine, mean_root, transmittance }
    }

    /// Returns the cell at two node numbers. It is computed at the first call.
    fn at_nodes(index: usize, alpha: usize) -> &'static Self {
        static CELLS: [[OnceLock<LossCell>; ALPHAS]; INDICES] =
            [const { [const { OnceLock::new() }; ALPHAS] }; INDICES];
        CELLS[index][alpha].get_or_init(|| Self::new(index, alpha))
    }
}

/// Lost light at any refractive index and roughness, as a weighted mean of the tabulated cells
/// around them.
#[derive(Clone, Copy, Debug)]
struct Loss {
    cells: [&'static LossCell; 4],
    weights: [f32; 4],
    alpha: f64,
}

impl Loss {
    /// Lost light at an interface of roughness `alpha` and refractive index `eta` ≥ 1, dense side
    /// over rare side.
    #[inline]
    fn of_interface(eta: f64, alpha: f64) -> Self {
        Self::between(node_position(((eta - 1.0) / (eta + 1.0)).sqrt(), INDICES), alpha)
    }

    /// Lost light at a surface of roughness `alpha` that reflects all light.
    #[inline]
    fn of_reflector(alpha: f64) -> Self {
        Self::between((INDICES - 1, 0.0), alpha)
    }

    /// Lost light between the node `index.0` of the refractive indices and the next, at the
    /// fraction `index.1` of the way.
    #[inline]
    fn between(index: (usize, f32), alpha: f64) -> Self {
        let least = fourth_root(f64::from(SMOOTH_ALPHA));
        let (j, v) = node_position((fourth_root(alpha) - least) / (1.0 - least), ALPHAS);
        let ((i, u), next) = (index, (index.0 + 1).min(INDICES - 1));
        let cells = [(i, j), (i, j + 1), (next, j), (next, j + 1)].map(|(i, j)| LossCell::at_nodes(i, j));
        Self { cells, weights: [(1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v], alpha }
    }

    /// Returns the weighted mean of `value` over the cells.
    #[inline]
    fn interpolate(&self, value: impl Fn(&LossCell) -> f32) -> f64 {
        f64::from(self.cells.iter().zip(self.weights).map(|(cell, weight)| value(cell) * weight).sum::<f32>())
    }

    /// Lost fraction of light that arrives on side `side` ([`RARE`] or [`DENSE`]) with the cosine
    /// of incidence `cos`.
    #[inline]
    fn fraction(&self, side: usize, cos: f64) -> f64 {
        let (node, u) = node_position(grid_position(cos, self.alpha), COSINES);
        self.interpolate(|cell| cell.by_cosine[side][node] * (1.0 - u) + cell.by_cosine[side][node + 1] * u)
    }

    /// Lost fraction of diffuse light that arrives on side `side` ([`RARE`] or [`DENSE`]), above 0.
    #[inline]
    fn mean(&self, side: usize) -> f64 {
        let root = self.interpolate(|cell| cell.mean_root[side]);
        let fourth = (root * root) * (root * root);
        fourth * fourth
    }
}

/// Reflection of light that microfacets of a metal scatter more than once.
#[derive(Clone, Copy, Debug)]
pub(super) struct MultipleReflection {
    loss: Loss,
    /// Lost fraction of light from `wo`: the probability of sampling this reflection.
    pub lost: f64,
}

impl MultipleReflection {
    /// Reflection at microfacets of roughness `alpha`. `cos_o` is the cosine of `wo`.
    #[inline]
    pub(super) fn new(alpha: f32, cos_o: f64) -> Self {
        let loss = Loss::of_reflector(f64::from(alpha));
        Self { loss, lost: loss.fraction(RARE, cos_o) }
    }

    /// BRDF \[1/sr] of microfacets that reflect all light, for `wi` of cosine `cos_i`.
    #[inline]
    pub(super) fn evaluate(&self, cos_i: f64) -> f64 {
        FRAC_1_PI * self.lost * self.loss.fraction(RARE, cos_i) / self.loss.mean(RARE)
    }

    /// Returns the factor of the BRDF for microfacets that reflect the fraction `reflectance`.
    ///
    /// It is the sum of a series: of the light, a part leaves after two reflections, a part of the
    /// rest after three, and so on (Kulla and Conty 2017; Hill 2018).
    #[inline]
    pub(super) fn repeated_reflectance(&self, reflectance: f64) -> f64 {
        let lost = self.loss.mean(RARE);
        reflectance * reflectance * (1.0 - lost) / (1.0 - reflectance * lost)
    }
}

/// Reflection and transmission of light that microfacets of a dielectric scatter more than once.
///
/// Let diffuse light arrive on both sides, in proportion to the squared index n². Then the light
/// that crosses the interface is T = t·min(b, b′) times the irradiance. b and b′ are the lost
/// fractions of light on both sides, and t is the transmittance of a smooth interface. T is the
/// same in both directions, so the BSDF is reciprocal up to n².
#[derive(Clone, Copy, Debug)]
pub(super) struct MultipleRefraction {
    loss: Loss,
    /// Side of `wo`: [`RARE`] or [`DENSE`].
    near: usize,
    /// Refractive index of the far side, relative to the side of `wo`.
    eta: f64,
    /// Part of the lost light that crosses the interface.
    crossing: f64,
    /// Lost fraction of light from `wo`: the probability of sampling this BSDF.
    pub lost: f64,
}

impl MultipleRefraction {
    /// Scattering at microfacets of roughness `alpha`.
    ///
    /// `eta` is the refractive index of the far side, relative to the side of `wo`. `cos_o` is the
    /// cosine of `wo`.
    #[inline]
    pub(super) fn new(eta: f64, alpha: f32, cos_o: f64) -> Self {
        let (near, ratio) = if eta < 1.0 { (DENSE, 1.0 / eta) } else { (RARE, eta) };
        let loss = Loss::of_interface(ratio, f64::from(alpha));
        let lost_by_side = [loss.mean(RARE), loss.mean(DENSE) * ratio * ratio];
        let transmittance = loss.interpolate(|cell| cell.transmittance);
        let crossing = transmittance * lost_by_side[RARE].min(lost_by_side[DENSE]) / lost_by_side[near];
        Self { loss, near, eta, crossing, lost: loss.fraction(near, cos_o) }
    }

    /// Returns the fraction of the lost light that leaves on the side of `wo`, or on the other side
    /// if `is_transmitted` is true.
    #[inline]
    pub(super) fn leaving_fraction(&self, is_transmitted: bool) -> f64 {
        if is_transmitted { self.crossing } else { 1.0 - self.crossing }
    }

    /// BSDF \[1/sr] for `wi` of absolute cosine `cos_i`.
    #[inline]
    pub(super) fn evaluate(&self, cos_i: f64, is_transmitted: bool, transport: TransportMode) -> f64 {
        let side = if is_transmitted { 1 - self.near } else { self.near };
        let f = FRAC_1_PI * self.lost * self.leaving_fraction(is_transmitted) * self.loss.fraction(side, cos_i)
            / self.loss.mean(side);
        if is_transmitted && transport == TransportMode::Radiance { f / (self.eta * self.eta) } else { f }
    }
}

/// Samples a direction for light that microfacets scatter more than once, by `u` in \[0, 1)².
///
/// The unit vector is on the side of the normal `n`. Its pdf is [`lost_direction_pdf`].
#[inline]
pub(super) fn sample_lost_direction(alpha: f32, n: Vec3, u: Vec2) -> Vec3 {
    let a2 = f64::from(alpha) * f64::from(alpha);
    // The cumulative distribution of c = cosθ is ln(1 + c²/α²)/ln(1 + 1/α²).
    let cos2 = (a2 * libm::expm1(f64::from(u.x) * libm::log1p(1.0 / a2))).clamp(0.0, 1.0);
    let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).sqrt());
    let (sin_phi, cos_phi) = sin_cos_turns(u.y);
    let local = DVec3::new(sin * f64::from(cos_phi), sin * f64::from(sin_phi), cos).as_vec3();
    Frame::from_normal(n).to_world(local).normalize()
}

/// Solid-angle pdf \[1/sr] of [`sample_lost_direction`] for a direction of cosine `cos` > 0.
///
/// It is proportional to cosθ/(cos²θ + α²), because lost light is about α²/(cos²θ + α²).
#[inline]
pub(super) fn lost_direction_pdf(alpha: f32, cos: f64) -> f64 {
    let a2 = f64::from(alpha) * f64::from(alpha);
    FRAC_1_PI * cos / ((cos * cos + a2) * libm::log1p(1.0 / a2))
}

/// Returns the fraction of light from a direction of cosine `cos` that is lost if each light path
/// scatters at one microfacet only.
///
/// `eta` is the refractive index of the far side, relative to the near side.
fn lost_fraction(cos: f64, eta: f64, alpha: f64) -> f64 {
    let cos = cos.max(HORIZON * alpha);
    let (ggx, wo) = (Ggx::new(alpha as f32), DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos));
    let (facets, generator) = FACETS;
    let mut kept = 0.0;
    for i in 0..facets {
        let u = (Vec2::new(i as f32, (i * generator % facets) as f32) + 0.5) / facets as f32;
        let m = ggx.sample_visible_normal(wo, Vec3::Z, u);
        let cos_m = wo.dot(m).min(1.0);
        if cos_m <= 0.0 {
            continue;
        }
        let (reflectance, cos_t) = fresnel_reflectance(cos_m, eta);
        let reflected = 2.0 * cos_m * m.z - wo.z;
        if reflected > 0.0 {
            let masking = ggx.reflection_masking_shadowing(cos, reflected);
            kept += reflectance * ggx.unshadowed_microfacet_fraction(masking, cos, reflected);
        }
        let refracted = wo.z / eta - m.z * (cos_m / eta - cos_t);
        if reflectance < 1.0 && refracted > 0.0 {
            let masking = ggx.transmission_masking_shadowing(cos, refracted);
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

/// Returns the place in \[0, 1] of a cosine between the first and the last node of a table.
///
/// The places are dense where the cosine is about α, because the loss varies most there.
#[inline]
fn grid_position(cos: f64, alpha: f64) -> f64 {
    0.5 * cos * (1.0 + (1.0 + alpha) / (cos + alpha))
}

/// Cosine whose [`grid_position`] is `x`.
fn cosine_at_grid_position(x: f64, alpha: f64) -> f64 {
    // A root of c² + b·c − 2xα. Of the two forms, each cancels no digits for its sign of b.
    let b = 1.0 + 2.0 * (alpha - x);
    let root = (b * b + 8.0 * x * alpha).sqrt();
    if b > 0.0 { 4.0 * x * alpha / (b + root) } else { 0.5 * (root - b) }
}

/// Cosine-weighted mean over the hemisphere of values at the nodes of the cosines.
fn mean_over_hemisphere(values: &[f32; COSINES], alpha: f64) -> f64 {
    let intervals = (COSINES - 1) * STEPS;
    let squared_cosine = |i: usize| {
        let cos = cosine_at_grid_position(i as f64 / intervals as f64, alpha);
        cos * cos
    };
    let part = |i: usize| {
        let (node, u) = (i / STEPS, ((i % STEPS) as f32 + 0.5) / STEPS as f32);
        let value = values[node] * (1.0 - u) + values[node + 1] * u;
        f64::from(value) * (squared_cosine(i + 1) - squared_cosine(i))
    };
    (0..intervals).map(part).sum()
}

/// Returns the number of the node at or below `x`, if `nodes` nodes are evenly spaced in \[0, 1].
///
/// Also returns the position of `x` between this node and the next one, in \[0, 1].
#[inline]
fn node_position(x: f64, nodes: usize) -> (usize, f32) {
    let position = x.clamp(0.0, 1.0) * (nodes - 1) as f64;
    let node = (position as usize).min(nodes - 2);
    (node, (position - node as f64) as f32)
}
