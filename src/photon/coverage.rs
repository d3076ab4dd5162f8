//! Boundary bias of density estimates: the fraction of the disc that is surface.

use super::Kernel;
use super::estimate::{FLATNESS, LEVELS, SAME_SIDE};
use crate::math::{Frame, Ray, warp};
use crate::sampling::{Dimension, Key, sobol_2d};
use crate::scene::Scene;
use glam::Vec3;

/// Number of probe rays per disc.
const PROBES: u32 = 16;

/// Lower bound of the coverage; it limits the correction of an estimate.
const MIN_COVERAGE: f32 = 0.05;

/// Integral of the kernel over the surface around `p`, relative to the integral over the flat disc.
///
/// A density estimate divides by the area of a disc. Where the surface ends, bends or is occluded,
/// fewer photons contribute (Jensen 2001, section 7.2.3: boundary bias); on a slope, more do. Probe
/// rays across the disc measure the ratio. The estimate over this ratio is the mean over the
/// surface. On a flat surface the result is exactly 1.
#[must_use]
pub fn coverage(scene: &Scene, p: Vec3, normal: Vec3, radius: f32, kernel: Kernel, key: Key) -> f32 {
    let frame = Frame::from_normal(normal);
    let height = radius * FLATNESS;
    let (mut covered, mut whole) = (0.0, 0.0);
    for i in 0..PROBES {
        let d = warp::square_to_uniform_disc(sobol_2d(i, key, Dimension::Probe));
        let shape = kernel.shape(d.length_squared());
        whole += shape;
        let above = p + (frame.s * d.x + frame.t * d.y) * radius + normal * height;
        let ray = Ray { t_max: 2.0 * height, ..Ray::new(above, -normal) };
        let Some(hit) = scene.intersect(&ray) else { continue };
        let cos = scene.normal_at(&ray, &hit).dot(normal).abs();
        if cos > SAME_SIDE {
            let rise = (height - hit.t) / radius;
            // The plane itself is hit within rounding, and must count as flat.
            let shape = if rise.abs() < 1e-3 { shape } else { kernel.shape_within(d.length_squared() + rise * rise) };
            let cos = if cos > 0.999_999 { 1.0 } else { cos };
            covered += shape / cos;
        }
    }
    if whole > 0.0 { (covered / whole).max(MIN_COVERAGE) } else { 1.0 }
}

/// Coverage of the disc and of the finer discs in it, see
/// [`NestedRadianceEstimate`](super::NestedRadianceEstimate).
///
/// Each disc has its own probe rays: the mean of the inverse is biased for few rays.
#[must_use]
pub fn nested_disc_coverage(
    scene: &Scene,
    p: Vec3,
    normal: Vec3,
    radius: f32,
    kernel: Kernel,
    key: Key,
) -> [f32; LEVELS] {
    let mut radius = radius;
    [(); LEVELS].map(|()| {
        let covered = coverage(scene, p, normal, radius, kernel, key);
        radius *= std::f32::consts::FRAC_1_SQRT_2;
        covered
    })
}

#[cfg(test)]
mod tests;
