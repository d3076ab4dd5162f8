//! Kernels of the density estimate.

use std::f32::consts::FRAC_1_PI;
use std::str::FromStr;

/// A radially symmetric kernel on a disc, of integral 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Kernel {
    /// 1/(πr²).
    Box,
    /// 3(1 − d/r)/(πr²): Jensen's cone filter with k = 1 (Jensen 2001, section 7.2).
    Cone,
    /// 2(1 − d²/r²)/(πr²), of least mean squared error among kernels (Silverman 1986, section 4.2).
    #[default]
    Epanechnikov,
}

/// A name that is no kernel's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no kernel `{0}`; known are box, cone, epanechnikov")]
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
    /// Weight at squared distance `x`, in squares of the radius, up to [`Kernel::scale`].
    #[inline]
    #[must_use]
    pub fn shape(self, x: f32) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => (1.0 - x.sqrt()).max(0.0),
            Self::Epanechnikov => (1.0 - x).max(0.0),
        }
    }

    /// The same, but zero from the edge on, for discs within a search.
    #[inline]
    #[must_use]
    pub fn shape_within(self, x: f32) -> f32 {
        if x < 1.0 { self.shape(x) } else { 0.0 }
    }

    /// What turns [`Kernel::shape`] into a density \[1/length²].
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

    /// Whether the kernel falls to zero at its edge. Then the k-th neighbour, which defines the edge, weighs nothing and the
    /// estimate over k neighbours is unbiased as it stands; else it must be left out.
    #[must_use]
    pub fn vanishes_at_edge(self) -> bool {
        self != Self::Box
    }

    /// π∫K²: the variance of an estimate from n photons of equal flux is this over n, relative to its square (analytic-truths
    /// 28 and 31 in the project's notes).
    #[must_use]
    pub fn noise_factor(self) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => 1.5,
            Self::Epanechnikov => 4.0 / 3.0,
        }
    }

    /// Variance of the difference to the same kernel on a disc of half the area, by the same photons, over the variance of the estimate.
    #[must_use]
    pub fn step_noise(self) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => std::f32::consts::SQRT_2 - 1.0,
            Self::Epanechnikov => 0.5,
        }
    }

    /// Second moment µ₂ per axis of the unit kernel: the estimate's bias is (r²/2)·µ₂·∇²E.
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
    fn constants_are_the_kernels_own() {
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
