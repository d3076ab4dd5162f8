//! Kernels of photon density estimation: box, cone and Epanechnikov.

use std::f32::consts::FRAC_1_PI;
use std::str::FromStr;

/// Kernel of a density estimate: a radially symmetric weight on a disc of radius r, with integral
/// 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Kernel {
    /// Constant kernel, 1/(πr²).
    Box,
    /// 3(1 − d/r)/(πr²) at distance d: Jensen's cone filter with k = 1 (Jensen 2001, section 7.2).
    Cone,
    /// 2(1 − d²/r²)/(πr²) at distance d. It has the least asymptotic mean squared error (Silverman
    /// 1986, section 4.2).
    #[default]
    Epanechnikov,
}

/// Error: the contained text is not the name of a [`Kernel`].
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
    /// Kernel value at x, up to the factor [`Kernel::normalization_factor`].
    ///
    /// `x` is d²/r² < 1, for distance d and disc radius r.
    #[inline]
    #[must_use]
    pub fn unnormalized_value(self, x: f32) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => (1.0 - x.sqrt()).max(0.0),
            Self::Epanechnikov => (1.0 - x).max(0.0),
        }
    }

    /// Kernel value at x, up to the factor [`Kernel::normalization_factor`]; 0 outside the disc.
    ///
    /// `x` is d²/r² ≥ 0, for distance d and disc radius r.
    #[inline]
    #[must_use]
    pub fn unnormalized_value_or_zero(self, x: f32) -> f32 {
        if x < 1.0 { self.unnormalized_value(x) } else { 0.0 }
    }

    /// Returns the factor \[1/length²] that makes the integral of [`Kernel::unnormalized_value`]
    /// over a disc of squared radius `r2` equal to 1.
    #[inline]
    #[must_use]
    pub fn normalization_factor(self, r2: f32) -> f32 {
        let norm = match self {
            Self::Box => 1.0,
            Self::Cone => 3.0,
            Self::Epanechnikov => 2.0,
        };
        norm * FRAC_1_PI / r2
    }

    /// True if the kernel is zero at the edge of its disc.
    ///
    /// In a k-nearest-neighbour estimate, the k-th photon lies at the edge. It must have no weight,
    /// or the estimate is biased. If this function returns false, the caller must leave out the
    /// k-th photon.
    #[must_use]
    pub fn vanishes_at_edge(self) -> bool {
        self != Self::Box
    }

    /// Returns Var(E(r) − E(r/√2)) / Var(E(r)), where E(r) is the density estimate with radius r.
    ///
    /// Both estimates use the same photons. Their difference measures the bias of E(r).
    #[must_use]
    pub fn nested_difference_variance_ratio(self) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Cone => std::f32::consts::SQRT_2 - 1.0,
            Self::Epanechnikov => 0.5,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks two constants of each kernel against midpoint sums over the distance: the integral
    /// over the disc, and `nested_difference_variance_ratio`. The error of these sums is O(n⁻²).
    #[test]
    fn kernel_constants_match_quadrature() {
        let n = 100_000;
        let r = 1.7f32;
        for kernel in [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov] {
            let (mut integral, mut square, mut step) = (0.0f64, 0.0f64, 0.0f64);
            for i in 0..n {
                let d = (i as f32 + 0.5) / n as f32 * r;
                let ring = f64::from(std::f32::consts::TAU * d * r / n as f32);
                let k = f64::from(kernel.unnormalized_value(d * d / (r * r)) * kernel.normalization_factor(r * r));
                integral += k * ring;
                square += k * k * ring * f64::from(std::f32::consts::PI * r * r);
                let x = 2.0 * d * d / (r * r);
                let finer = f64::from(kernel.unnormalized_value_or_zero(x) * kernel.normalization_factor(0.5 * r * r));
                step += (k - finer) * (k - finer) * ring * f64::from(std::f32::consts::PI * r * r);
            }
            assert!((integral - 1.0).abs() < 1e-5, "{kernel:?} {integral}");
            // The edge of the smaller box kernel lies within one ring of the midpoint sum. The
            // weight of this ring is about 1/n, so the sum errs by up to 1/n.
            let expected = f64::from(kernel.nested_difference_variance_ratio());
            assert!((step / square - expected).abs() < 5e-5, "{kernel:?} {}", step / square);
        }
    }
}
