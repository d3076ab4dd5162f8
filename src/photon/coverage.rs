//! How much of an estimate's disc is surface.

use super::Kernel;
use super::estimate::{FLATNESS, SAME_SIDE};
use crate::math::{Frame, Ray, warp};
use crate::sampling::{Dimension, Key, sobol_2d};
use crate::scene::Scene;
use glam::Vec3;

/// Probes of a disc.
const PROBES: u32 = 16;

/// No estimate is raised by more than one over this.
const LEAST: f32 = 0.05;

/// The kernel's integral over the surface on which photons count for an estimate at `p`, over its integral over the whole disc.
///
/// A density estimate divides by the area of a disc; where the surface ends, bends or is hidden within it, photons come from less
/// (Jensen 2001, section 7.2.3: the boundary bias), and on a slope from more. Rays across the disc measure how much, and the
/// estimate over this is the kernel's mean of the light on the surface that is there. On a flat surface it is exactly 1.
#[must_use]
pub fn coverage(scene: &Scene, p: Vec3, normal: Vec3, radius: f32, kernel: Kernel, key: Key) -> f32 {
    let frame = Frame::around(normal);
    let height = radius * FLATNESS;
    let (mut covered, mut whole) = (0.0, 0.0);
    for i in 0..PROBES {
        let d = warp::disc(sobol_2d(i, key, Dimension::Probe));
        let shape = kernel.shape(d.length_squared());
        whole += shape;
        let above = p + (frame.s * d.x + frame.t * d.y) * radius + normal * height;
        let ray = Ray { t_max: 2.0 * height, ..Ray::new(above, -normal) };
        let Some(hit) = scene.intersect(&ray) else { continue };
        let cos = scene.normal_at(&ray, &hit).dot(normal).abs();
        if cos > SAME_SIDE {
            let rise = (height - hit.t) / radius;
            // The plane itself is met within rounding: it must count as flat.
            let shape = if rise.abs() < 1e-3 { shape } else { kernel.shape(d.length_squared() + rise * rise) };
            let cos = if cos > 0.999_999 { 1.0 } else { cos };
            covered += shape / cos;
        }
    }
    if whole > 0.0 { (covered / whole).max(LEAST) } else { 1.0 }
}
