//! Albedos of dielectric coats: how much light the outer side of a smooth or rough coat reflects.
//!
//! The albedo of a rough coat is tabulated over index, roughness α and cosine of incidence. It
//! counts light that one microfacet reflects. All other light enters the coat.

use super::fresnel::fresnel_reflectance_and_cosine;
use super::microfacet::Ggx;
use glam::{DVec3, Vec2, Vec3};
use std::sync::OnceLock;

/// Largest refractive index of a coat relative to its surroundings.
pub const MAX_COAT_INDEX: f32 = 4.0;

/// Number of tabulated refractive indices η, evenly spaced in the square root of (η − 1)/(η + 1).
const ETA_COUNT: usize = 21;

/// Value of (η − 1)/(η + 1), the Fresnel amplitude at normal incidence, for the last tabulated
/// refractive index η = [`MAX_COAT_INDEX`].
const MAX_NORMAL_FRESNEL_AMPLITUDE: f32 = 0.6;

/// Number of tabulated roughnesses from 0 to 1, evenly spaced in √α.
const ALPHA_COUNT: usize = 16;

/// Number of tabulated cosines of incidence from 0 to 1, evenly spaced in √cosθ.
const COSINE_COUNT: usize = 32;

/// Fibonacci lattice over \[0, 1)² that samples visible microfacets, as (number of points n,
/// generator g). Point i is ((i + ½)/n, ((i·g mod n) + ½)/n).
///
/// The albedo at each node of the table is a mean over these microfacets.
pub(super) const FACET_LATTICE: (usize, usize) = (610, 377);

/// Cosine that replaces 0 in the computation of the table, because 0 would lead to 0/0.
const HORIZON_COSINE: f64 = 1e-4;

/// Lookup table of coat albedos, by refractive index, roughness and cosine of incidence.
struct CoatAlbedoTable {
    /// Albedo by number of the refractive index, of the roughness α, and of the cosine of
    /// incidence.
    directional: Vec<[[f32; COSINE_COUNT]; ALPHA_COUNT]>,
    /// Cosine-weighted mean of the albedo over the hemisphere, by number of the refractive index
    /// and of the roughness α.
    mean: Vec<[f32; ALPHA_COUNT]>,
}

/// Returns the fraction of light at the cosine of incidence `cos` that a coat reflects.
///
/// `eta` in \[1, 4] is the refractive index relative to the surroundings, `alpha` in \[0, 1] the
/// GGX roughness. For a smooth coat, the result is the Fresnel reflectance. For a rough coat, it is
/// interpolated in a table. Its error is at most 0.015 at grazing angles, and below 0.001
/// elsewhere.
#[inline]
pub(super) fn coat_albedo(cos: f32, eta: f32, alpha: f32) -> f32 {
    if alpha == 0.0 {
        return fresnel_reflectance_and_cosine(f64::from(cos.min(1.0)), f64::from(eta)).0 as f32;
    }
    let (x, y) = (node_and_fraction(cos.min(1.0).sqrt(), COSINE_COUNT), node_and_fraction(alpha.sqrt(), ALPHA_COUNT));
    let table = coat_albedo_table();
    interpolate(eta_node_and_fraction(eta), |i| interpolate(y, |j| interpolate(x, |k| table.directional[i][j][k])))
}

/// Returns the fraction of diffuse light that a coat reflects on its outer side: the
/// cosine-weighted mean of [`coat_albedo`].
pub(super) fn mean_coat_albedo(eta: f32, alpha: f32) -> f32 {
    if alpha == 0.0 {
        return mean_fresnel_reflectance(f64::from(eta)) as f32;
    }
    let table = coat_albedo_table();
    interpolate(eta_node_and_fraction(eta), |i| {
        interpolate(node_and_fraction(alpha.sqrt(), ALPHA_COUNT), |j| table.mean[i][j])
    })
}

/// Cosine-weighted mean of the Fresnel reflectance over the hemisphere, at the refractive index
/// `eta` > 1, by the closed form of Walsh (1926).
pub(super) fn mean_fresnel_reflectance(eta: f64) -> f64 {
    let (n, n2) = (eta, eta * eta);
    let n4 = n2 * n2;
    let (minus, plus, rest) = (n2 - 1.0, n2 + 1.0, n4 - 1.0);
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * minus * minus / (plus * plus * plus) * libm::log((n - 1.0) / (n + 1.0))
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / (plus * rest)
        + 8.0 * n4 * (n4 + 1.0) / (plus * rest * rest) * libm::log(n)
}

/// Returns the table of coat albedos. The first call computes it.
fn coat_albedo_table() -> &'static CoatAlbedoTable {
    static TABLE: OnceLock<CoatAlbedoTable> = OnceLock::new();
    TABLE.get_or_init(|| {
        let fraction = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let node = |i: usize, j: usize, k: usize| {
            let (root, alpha, cos) = (fraction(i, ETA_COUNT), fraction(j, ALPHA_COUNT), fraction(k, COSINE_COUNT));
            let ratio = f64::from(MAX_NORMAL_FRESNEL_AMPLITUDE) * root * root;
            rough_albedo((cos * cos).max(HORIZON_COSINE), (1.0 + ratio) / (1.0 - ratio), alpha * alpha) as f32
        };
        let directional: Vec<_> =
            (0..ETA_COUNT).map(|i| std::array::from_fn(|j| std::array::from_fn(|k| node(i, j, k)))).collect();
        let mean = directional
            .iter()
            .map(|alphas: &[[f32; COSINE_COUNT]; ALPHA_COUNT]| alphas.map(|a| cosine_weighted_mean(&a)));
        CoatAlbedoTable { mean: mean.collect(), directional }
    })
}

/// Fraction of light at the cosine of incidence `cos` that GGX microfacets reflect in one
/// reflection.
///
/// Light that would meet a second microfacet is not included.
fn rough_albedo(cos: f64, eta: f64, alpha: f64) -> f64 {
    if alpha == 0.0 {
        return fresnel_reflectance_and_cosine(cos, eta).0;
    }
    let (ggx, wo) = (Ggx::new(alpha as f32), DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos));
    let mut sum = 0.0;
    let (facets, generator) = FACET_LATTICE;
    for i in 0..facets {
        let u = (Vec2::new(i as f32, (i * generator % facets) as f32) + 0.5) / facets as f32;
        let m = ggx.sample_visible_normal(wo, Vec3::Z, u);
        let cos_m = wo.dot(m);
        let cos_i = 2.0 * cos_m * m.z - wo.z;
        if cos_i > 0.0 && cos_m > 0.0 {
            let seen = ggx.unshadowed_microfacet_fraction(ggx.reflection_g2_over_cosines(cos, cos_i), cos, cos_i);
            sum += fresnel_reflectance_and_cosine(cos_m.min(1.0), eta).0 * seen;
        }
    }
    sum / facets as f64
}

/// Cosine-weighted mean ∫ 2 cosθ R dcosθ of tabulated values R.
///
/// R is interpolated linearly in √cosθ between the nodes.
fn cosine_weighted_mean(values: &[f32; COSINE_COUNT]) -> f32 {
    // With t = √cosθ, the integral is ∫ 4t³ R(t) dt.
    let step = 1.0 / (COSINE_COUNT - 1) as f64;
    let segment = |k: usize| {
        let (a, b) = (k as f64 * step, (k + 1) as f64 * step);
        let (low, high) = (f64::from(values[k]), f64::from(values[k + 1]));
        let slope = (high - low) / step;
        let power = |t: f64| t * t * t * t * (low - slope * a + 0.8 * slope * t);
        power(b) - power(a)
    };
    (0..COSINE_COUNT - 1).map(segment).sum::<f64>() as f32
}

/// Returns the table node at or below the refractive index `eta`, and the position of `eta` between
/// this node and the next one, in \[0, 1].
#[inline]
fn eta_node_and_fraction(eta: f32) -> (usize, f32) {
    node_and_fraction(((eta - 1.0) / (eta + 1.0) / MAX_NORMAL_FRESNEL_AMPLITUDE).max(0.0).sqrt(), ETA_COUNT)
}

/// Returns the number of the node at or below `x`, and the position of `x` between this node and
/// the next one, in \[0, 1].
///
/// The `nodes` nodes are evenly spaced in \[0, 1] and numbered from 0.
#[inline]
fn node_and_fraction(x: f32, nodes: usize) -> (usize, f32) {
    let position = x.clamp(0.0, 1.0) * (nodes - 1) as f32;
    let node = (position as usize).min(nodes - 2);
    (node, position - node as f32)
}

/// Interpolates `value`, a function of the node number, linearly between the nodes `node` and
/// `node` + 1. `fraction` in \[0, 1] is the position between them.
#[inline]
fn interpolate((node, fraction): (usize, f32), value: impl Fn(usize) -> f32) -> f32 {
    value(node) * (1.0 - fraction) + value(node + 1) * fraction
}

#[cfg(test)]
mod tests;
