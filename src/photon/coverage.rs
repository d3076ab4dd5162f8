//! Coverage: the fraction of a density estimate's disc that is surface. Division by the coverage
//! corrects boundary bias.

use super::Kernel;
use super::estimate::{MAX_RELATIVE_HEIGHT, MIN_NORMAL_COSINE, NESTED_DISC_COUNT};
use crate::math::{Bounds, Frame, Ray, warp};
use crate::sampling::{Dimension, Key, sobol_2d};
use crate::scene::{NearPrimitives, Scene};
use glam::Vec3;

/// Number of probe rays that measure the *coverage* of a disc: the fraction of the disc that lies
/// on a surface. The photons of a density estimate are gathered in this disc.
const PROBES: u32 = 16;

/// Lower limit of the coverage. Density estimates are divided by the coverage; with this limit, the
/// division brightens an estimate at most 20 times.
///
/// On a surface, the coverage is the fraction of the kernel's disc that lies on the surface. In a
/// medium, it is the fraction of the kernel's integral that is visible from its center.
pub(super) const MIN_COVERAGE: f32 = 0.05;

/// Largest distance between a hit of a probe ray and the plane of the disc, divided by the disc's
/// radius, at which the hit counts as a hit in this plane.
///
/// On a flat surface, all hits lie in the plane, and their computed distances from it are rounding
/// errors.
const MAX_FLAT_RISE: f32 = 1e-3;

/// Upper bound of the rounding error in the origin of a coverage probe ray, divided by the largest
/// coordinate of the disc's center.
///
/// A second error, about 10⁻⁷ of the disc's radius, is not included, because it is far below
/// [`MAX_FLAT_RISE`].
const RELATIVE_PROBE_ERROR: f32 = 4.0 * f32::EPSILON;

/// Returns the coverage: the fraction of the disc of `radius` \[length] around `p` that is surface,
/// weighted by `kernel`. The coverage is the kernel's integral over the surface around `p`, divided
/// by the kernel's integral over the flat disc.
///
/// A density estimate assumes that the whole disc is surface. If the surface ends, bends or is
/// occluded, the estimate is too dark (boundary bias, Jensen 2001, section 7.2.3). Division by the
/// coverage corrects this bias. The coverage is measured by probe rays along −`normal`, at random
/// positions, which the random key `key` gives. If one flat shape contains the disc, no rays are
/// needed, and the coverage is 1. Hits on surfaces tilted by more than 60° do not count.
///
/// The coverage is at least 0.05. It is exactly 1 if the whole disc lies on a flat surface. It may
/// exceed 1 where the surface is tilted against `normal`, because a tilted surface has more area
/// than its projection on the disc.
#[must_use]
pub fn disc_coverage(scene: &Scene, p: Vec3, normal: Vec3, radius: f32, kernel: Kernel, key: Key) -> f32 {
    let primitives = NearPrimitives::new(scene, &probe_bounds(p, normal, radius));
    coverage_near(scene, &primitives, p, normal, radius, kernel, key)
}

/// Returns a box that contains all probe rays that measure the coverage of the disc of `radius`
/// \[length] around `p`.
fn probe_bounds(p: Vec3, normal: Vec3, radius: f32) -> Bounds {
    let height = normal.abs() * (radius * MAX_RELATIVE_HEIGHT);
    let around = (Vec3::ONE - normal * normal).max(Vec3::ZERO).map(f32::sqrt) * radius;
    let rounding = 1e-4 * radius + 1e-5 * p.abs().max_element();
    let half = height + around + rounding;
    Bounds { min: p - half, max: p + half }
}

/// Returns the coverage of the disc of `radius` \[length] around `p`, as [`disc_coverage`] defines
/// it. `primitives` must hold all primitives of the scene near the disc.
#[inline]
fn coverage_near(
    scene: &Scene,
    primitives: &NearPrimitives<'_>,
    p: Vec3,
    normal: Vec3,
    radius: f32,
    kernel: Kernel,
    key: Key,
) -> f32 {
    // Most discs lie in one large flat shape, far from its edges. All probe rays would hit this
    // shape within `MAX_FLAT_RISE` of the disc's plane, so the coverage would be 1. Half of this
    // limit is for the distance and the tilt of the shape, the other half for rounding errors of
    // the probe rays.
    let tolerance = radius * (0.5 * MAX_FLAT_RISE);
    let rounding = p.abs().max_element() * RELATIVE_PROBE_ERROR;
    if rounding < tolerance && primitives.only_shape_contains_disc(p, normal, radius, tolerance) {
        1.0
    } else {
        coverage_by_probes(scene, primitives, p, normal, radius, kernel, key)
    }
}

/// Returns the coverage of a disc, as [`disc_coverage`] defines it, measured by 16 probe rays. The
/// rays are intersected only with `primitives`, which must hold all primitives of the scene near
/// the disc.
fn coverage_by_probes(
    scene: &Scene,
    primitives: &NearPrimitives<'_>,
    p: Vec3,
    normal: Vec3,
    radius: f32,
    kernel: Kernel,
    key: Key,
) -> f32 {
    let frame = Frame::from_normal(normal);
    let height = radius * MAX_RELATIVE_HEIGHT;
    let (mut covered_integral, mut flat_integral) = (0.0, 0.0);
    for i in 0..PROBES {
        let d = warp::square_to_uniform_disc(sobol_2d(i, key, Dimension::CoverageProbe));
        let kernel_value = kernel.unnormalized_value(d.length_squared());
        flat_integral += kernel_value;
        let above = p + (frame.s * d.x + frame.t * d.y) * radius + normal * height;
        let ray = Ray { t_max: 2.0 * height, ..Ray::new(above, -normal) };
        let Some(hit) = primitives.intersect(&ray) else { continue };
        let cos = scene.geometric_normal_at(&ray, &hit).dot(normal).abs();
        if cos > MIN_NORMAL_COSINE {
            let rise = (height - hit.t) / radius;
            let kernel_value = if rise.abs() < MAX_FLAT_RISE {
                kernel_value
            } else {
                kernel.unnormalized_value_or_zero(d.length_squared() + rise * rise)
            };
            let cos = if cos > 0.999_999 { 1.0 } else { cos };
            covered_integral += kernel_value / cos;
        }
    }
    if flat_integral > 0.0 { (covered_integral / flat_integral).max(MIN_COVERAGE) } else { 1.0 }
}

/// Returns the coverage of each of the concentric discs of a
/// [`NestedRadianceEstimate`](super::NestedRadianceEstimate), largest disc first. The coverage is
/// the fraction of the disc that is surface ([`disc_coverage`]).
///
/// `radius` is the radius of the largest disc \[length]. Each disc that needs probe rays gets 16 of
/// its own. With fewer rays, the coverage would have more variance, and the division by it would
/// add more bias.
#[must_use]
pub fn nested_disc_coverage(
    scene: &Scene,
    p: Vec3,
    normal: Vec3,
    radius: f32,
    kernel: Kernel,
    key: Key,
) -> [f32; NESTED_DISC_COUNT] {
    let primitives = NearPrimitives::new(scene, &probe_bounds(p, normal, radius));
    let mut radius = radius;
    [(); NESTED_DISC_COUNT].map(|()| {
        let covered = coverage_near(scene, &primitives, p, normal, radius, kernel, key);
        radius *= std::f32::consts::FRAC_1_SQRT_2;
        covered
    })
}

#[cfg(test)]
mod tests;
