//! Phase functions: distributions of directions after scattering in a medium.

use crate::math::{Frame, sin_cos_turns};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// A phase function: the distribution of directions after scattering in a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunction {
    /// Isotropic scattering: equal in all directions.
    Isotropic,
    /// Phase function of Henyey and Greenstein 1941. Its parameter is the mean cosine g in (−1, 1);
    /// positive g scatters forwards.
    HenyeyGreenstein(f32),
    /// Rayleigh scattering, by particles much smaller than the wavelength.
    Rayleigh,
}

impl PhaseFunction {
    /// Value of the phase function \[1/sr]. `cos` is the cosine between the directions of travel
    /// before and after scattering; 1 is forwards.
    #[inline]
    #[must_use]
    pub fn evaluate(&self, cos: f32) -> f32 {
        match *self {
            Self::Isotropic => 1.0 / (4.0 * PI),
            Self::HenyeyGreenstein(g) => {
                // `square` is 1 + g² − 2g·cos. This sum of two non-negative terms keeps its digits
                // at the peak.
                let a = g.abs();
                let drop = (1.0 - cos.copysign(cos * g)).max(0.0);
                let square = (1.0 - a) * (1.0 - a) + 2.0 * a * drop;
                (1.0 - a) * (1.0 + a) / (4.0 * PI * square * square.sqrt())
            }
            Self::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cos * cos),
        }
    }

    /// Samples the unit direction of travel after scattering, by `u` in \[0, 1)². Returns this
    /// direction and its pdf \[1/sr].
    ///
    /// `direction` is the unit direction of travel before scattering. The pdf equals
    /// [`evaluate`](Self::evaluate), so the weight of a sample is 1.
    #[inline]
    #[must_use]
    pub fn sample(&self, direction: Vec3, u: Vec2) -> (Vec3, f32) {
        let (cos, sin) = match *self {
            Self::Isotropic => (1.0 - 2.0 * u.x, 2.0 * (u.x * (1.0 - u.x)).sqrt()),
            Self::HenyeyGreenstein(g) => sample_henyey_greenstein(g, u.x),
            Self::Rayleigh => sample_rayleigh(u.x),
        };
        let (s, c) = sin_cos_turns(u.y);
        let next = Frame::from_normal(direction).to_world(Vec3::new(sin * c, sin * s, cos));
        // Normalized, because rounding errors would accumulate over thousands of scattering events.
        (next.normalize(), self.evaluate(cos))
    }

    /// Mean cosine g of the scattering angle, in (−1, 1).
    #[must_use]
    pub fn mean_cosine(&self) -> f32 {
        match *self {
            Self::HenyeyGreenstein(g) => g,
            Self::Isotropic | Self::Rayleigh => 0.0,
        }
    }
}

/// Samples the scattering angle of the Henyey–Greenstein function by inversion; returns its cosine
/// and its sine.
///
/// With D = 1 − g + 2gu, the inverse (Witt 1977) gives 1 − cos = 2(1−g)²(1−u)(1+gu)/D² and 1 + cos
/// = 2(1+g)²u(1−g(1−u))/D². Neither formula suffers cancellation for g from 0 to 1. For negative g,
/// the cosine for −g is negated.
fn sample_henyey_greenstein(g: f32, u: f32) -> (f32, f32) {
    let a = g.abs();
    let rest = 1.0 - a;
    let d = rest + 2.0 * a * u;
    let drop = 2.0 * (rest / d) * (rest / d) * (1.0 - u) * (1.0 + a * u);
    let rise = 2.0 * ((1.0 + a) / d) * ((1.0 + a) / d) * u * (rest + a * u);
    let cos = if drop < rise { 1.0 - drop } else { rise - 1.0 };
    let cos = if g < 0.0 { -cos } else { cos };
    (cos, (drop * rise).max(0.0).sqrt())
}

/// Samples the scattering angle of Rayleigh scattering by inversion; returns its cosine and its
/// sine. The cosine is the real root of cos³ + 3 cos = 8u − 4.
fn sample_rayleigh(u: f32) -> (f32, f32) {
    let q = 4.0 * f64::from(u) - 2.0;
    let root = libm::cbrt(q.abs() + (q * q + 1.0).sqrt());
    let cos = (root - 1.0 / root).min(1.0).copysign(q);
    (cos as f32, ((1.0 - cos) * (1.0 + cos)).sqrt() as f32)
}
