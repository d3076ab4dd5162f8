//! Kernels of density estimation.

use std::f32::consts::FRAC_1_PI;
use std::str::FromStr;

/// A radially symmetric kernel on a disc, with integral 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kernel {
    /// 1/(πr²).
    Box,
    /// 3(1 − d/r)/(πr²): Jensen's cone filter with k = 1 (Jensen 2001, section 7.2).
    Cone,
    /// 2(1 − d²/r²)/(πr²): least mean squared error among all kernels (Silverman 1986, section
    /// 4.2).
    #[default]
    Epanechnikov,
}

/// The name is not that of a kernel.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown kernel `{0}`: use box, cone or epanechnikov")]
pub struct UnknownKernel(String);

impl FromStr for Kernel {
    type Err = UnknownKernel;

    fn from_str(name: &str) -> Result<Self, UnknownKernel> {
        Ok(match name {
            "box" => Self::Box,
            "cone" => Self::Cone,
            "epanechnikov" => Self::Epanechnikov,
            _ => return Err(UnknownKernel(name.to_owned())),
        })
    }
}

impl Kernel {
    /// Unnormalised weight at squared distance `x` over the squared radius. [`Kernel::scale`]
    /// normalises it.
    #[inline]
    #[must_use]
    pub fn shape(self, x: f32) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => (1.0 - x.sqrt()).max(0.0),
            Self::Epanechnikov => (1.0 - x).max(0.0),
        }
    }

    /// Unnormalised kernel value at squared distance `x` over the squared radius; 0 for x ≥ 1.
    #[inline]
    #[must_use]
    pub fn shape_within(self, x: f32) -> f32 {
        if x < 1.0 { self.shape(x) } else { 0.0 }
    }

    /// Factor from [`Kernel::shape`] to the normalised kernel \[1/length²].
    #[inline]
    #[must_use]
    pub fn scale(self, r2: f32) -> f32 {
        let norm = match self {
            Self::Box => 1.0,
            Self::Cone => 3.0,
            Self::Epanechnikov => 2.0,
        };
        norm * FRAC_1_PI / r2
    }

    /// True if the kernel is zero at its edge.
    ///
    /// The k-th neighbour defines the edge. Such a kernel gives it no weight, and the estimate over
    /// k neighbours is unbiased. Other kernels must leave it out.
    #[must_use]
    pub fn vanishes_at_edge(self) -> bool {
        self != Self::Box
    }

    /// π∫K²: relative variance of an estimate, times the number of photons, for photons of equal
    /// flux.
    #[must_use]
    pub fn noise_factor(self) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => 1.5,
            Self::Epanechnikov => 4.0 / 3.0,
        }
    }

    /// Variance of the difference to the same kernel on half the area, over the variance of the
    /// estimate.
    ///
    /// Both estimates use the same photons.
    #[must_use]
    pub fn step_noise(self) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => std::f32::consts::SQRT_2 - 1.0,
            Self::Epanechnikov => 0.5,
        }
    }

    /// Second moment µ₂ of the unit kernel along an axis. The bias of an estimate is (r²/2)·µ₂·∇²E.
    #[must_use]
    pub fn second_moment(self) -> f32 {
        match self {
            Self::Box => 0.25,
            Self::Cone => 0.15,
            Self::Epanechnikov => 1.0 / 6.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral, noise factor and second moment by the midpoint rule in d, error O(n⁻²).
    #[test]
    fn kernel_constants_match_quadrature() {
        let n = 100_000;
        let r = 1.7f32;
        for kernel in [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov] {
            let (mut integral, mut square, mut second, mut step) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
            for i in 0..n {
                let d = (i as f32 + 0.5) / n as f32 * r;
                let ring = f64::from(std::f32::consts::TAU * d * r / n as f32);
                let k = f64::from(kernel.shape(d * d / (r * r)) * kernel.scale(r * r));
                integral += k * ring;
                square += k * k * ring * f64::from(std::f32::consts::PI * r * r);
                let x = 2.0 * d * d / (r * r);
                let finer = f64::from(kernel.shape_within(x) * kernel.scale(0.5 * r * r));
                step += (k - finer) * (k - finer) * ring * f64::from(std::f32::consts::PI * r * r);
                second += k * ring * f64::from(d * d / (r * r)) * 0.5;
            }
            assert!((integral - 1.0).abs() < 1e-5, "{kernel:?} {integral}");
            assert!((square - f64::from(kernel.noise_factor())).abs() < 1e-5, "{kernel:?} {square}");
            // The box ends within a ring of the sum, whose weight is 1/n.
            let share = f64::from(kernel.step_noise());
            assert!((step / square - share).abs() < 5e-5, "{kernel:?} {}", step / square);
            assert!((second - f64::from(kernel.second_moment())).abs() < 1e-5, "{kernel:?} {second}");
        }
    }
}
