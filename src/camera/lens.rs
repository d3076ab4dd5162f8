//! Thin lens of a camera, which blurs objects outside the focal plane.

use crate::math::warp;
use glam::Vec2;
use std::f32::consts::TAU;

/// A thin lens, which blurs objects outside the focal plane (Pharr, Jakob, Humphreys 2023, section
/// 5.2.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the aperture \[length].
    pub radius: f64,
    /// Distance from the lens to the focal plane, along the viewing direction \[length].
    pub focus_distance: f64,
    /// Number of edges of the aperture, a regular polygon with circumradius `radius`. Below 3, the
    /// aperture is a disc.
    pub blades: u32,
}

impl Lens {
    /// Samples a point of the aperture uniformly by area, by `u` in \[0, 1)².
    ///
    /// Returns the coordinates right and up from the lens center \[length]. One corner of a polygon
    /// points up.
    #[inline]
    pub(super) fn sample(&self, u: Vec2) -> glam::DVec2 {
        self.radius * self.sample_unit_aperture(u).as_dvec2()
    }

    /// Samples a point of the aperture, scaled to radius 1, uniformly by area, from random numbers
    /// `u` in \[0, 1)².
    fn sample_unit_aperture(&self, u: Vec2) -> Vec2 {
        if self.blades < 3 {
            return warp::square_to_uniform_disc(u);
        }
        let blades = self.blades as f32;
        let blade = (u.x * blades).floor().min(blades - 1.0);
        let corner = |i: f32| {
            let (sin, cos) = libm::sincosf(TAU * i / blades);
            Vec2::new(sin, cos)
        };
        // Inside the triangle `blade`, the remainder of u.x is uniform again.
        let weights =
            warp::square_to_uniform_triangle(Vec2::new((u.x * blades - blade).min(1.0 - f32::EPSILON / 2.0), u.y));
        corner(blade) * weights.x + corner(blade + 1.0) * weights.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::sobol_2d;
    use crate::sampling::{Dimension, Key, Purpose};

    /// Compares the second moments of samples with closed forms.
    ///
    /// A regular n-gon of circumradius 1 has the second moment (2 + cos(2π/n))/12 per area, about
    /// each axis through its center; the disc has ¼. The tolerance is five standard deviations of
    /// the mean of 2¹⁶ independent points. The Sobol' points used here have much smaller errors.
    #[test]
    fn aperture_samples_are_uniform_by_area() {
        let n = 1 << 16;
        for blades in [0u32, 3, 5, 6, 8] {
            let lens = Lens { radius: 2.0, focus_distance: 1.0, blades };
            let key = Key::new(2).purpose_key(Purpose::Test);
            let points: Vec<_> = (0..n).map(|i| lens.sample(sobol_2d(i, key, Dimension::Lens)) / 2.0).collect();
            let expected =
                if blades < 3 { 0.25 } else { (2.0 + libm::cos(std::f64::consts::TAU / f64::from(blades))) / 12.0 };
            let mean = |f: &dyn Fn(&glam::DVec2) -> f64| points.iter().map(f).sum::<f64>() / f64::from(n);
            let bound = 5.0 / f64::from(n).sqrt();
            for moment in [mean(&|p| p.x * p.x), mean(&|p| p.y * p.y)] {
                assert!((moment - expected).abs() < bound * 0.5, "{blades}: {moment} {expected}");
            }
            assert!(mean(&|p| p.x).abs() < bound && mean(&|p| p.y).abs() < bound && mean(&|p| p.x * p.y).abs() < bound);
            assert!(points.iter().all(|p| p.length() <= 1.0 + 1e-6));
        }
    }
}
