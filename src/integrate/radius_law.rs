//! Law by which gather radii of photon estimates shrink from pass to pass (Knaus and Zwicker 2011).

use crate::photon::Kernel;

/// Default exponent α of shrinking gather radii: the squared radius falls as N^(α−1) over N passes.
///
/// The variance of the mean of N passes falls as N^−α, and its squared bias as N^(2(α−1)). The
/// value ⅔ balances both (Kaplanyan and Dachsbacher 2013).
pub const DEFAULT_ALPHA: f64 = 2.0 / 3.0;

/// Law by which gather radii shrink from pass to pass, and the kernel of density estimates.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RadiusLaw {
    /// Exponent α in (0, 1] of shrinking gather radii: the squared radius falls as n^(α−1) with the
    /// number of passes n, so 1 keeps radii fixed.
    pub alpha: f64,
    /// Kernel of photon density estimates.
    pub kernel: Kernel,
}

/// Returns the squared gather radius of pass `pass`, counted from 0, divided by the squared radius
/// of the first pass.
///
/// This ratio is the product of (i + α)/(i + 1) for i = 1 … pass (Knaus and Zwicker 2011, equation
/// 15).
#[must_use]
pub fn squared_radius_ratio(alpha: f64, pass: u32) -> f64 {
    (1..=pass).map(f64::from).map(|i| (i + alpha) / (i + 1.0)).product()
}

/// Returns the kernel radius of pass `pass`, counted from 0, divided by the radius of the first
/// pass, for a kernel in `dimensions` (d) dimensions.
///
/// The kernel's length, area or volume shrinks by [`squared_radius_ratio`], with 1 − (1 −
/// `alpha`)·3d/(4 + d) in place of `alpha`. With the default `alpha`, this exponent is 4/(4 + d),
/// which balances variance and squared bias in d dimensions.
#[must_use]
pub(super) fn kernel_radius_ratio(dimensions: u32, alpha: f64, pass: u32) -> f32 {
    let d = f64::from(dimensions);
    let dimension_alpha = 1.0 - (1.0 - alpha) * 3.0 * d / (4.0 + d);
    libm::pow(squared_radius_ratio(dimension_alpha, pass), 1.0 / d) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_shrink_by_their_dimension() {
        for pass in [0, 1, 17, 1000] {
            assert!(
                (f64::from(kernel_radius_ratio(2, DEFAULT_ALPHA, pass))
                    - squared_radius_ratio(DEFAULT_ALPHA, pass).sqrt())
                .abs()
                    < 1e-6
            );
        }
        // The radius falls as N^((α−1)/d), which gives the powers −1/5, −1/6 and −1/7.
        for (dimensions, power) in [(1, -0.2), (2, -1.0 / 6.0), (3, -1.0 / 7.0)] {
            let ratio = f64::from(
                kernel_radius_ratio(dimensions, DEFAULT_ALPHA, 99_999)
                    / kernel_radius_ratio(dimensions, DEFAULT_ALPHA, 9999),
            );
            assert!((libm::log10(ratio) - power).abs() < 1e-3, "{dimensions}: {ratio}");
        }
    }

    /// The squared radius ratio agrees with its closed form Γ(N+α)/(Γ(1+α)Γ(N+1)). It also agrees
    /// with the asymptote N^(α−1)/Γ(1+α), up to a relative error of 1/N.
    #[test]
    fn squared_radius_ratio_is_a_ratio_of_gammas() {
        assert_eq!(
            (
                squared_radius_ratio(DEFAULT_ALPHA, 0),
                squared_radius_ratio(1.0, 1000),
                kernel_radius_ratio(3, 1.0, 1000)
            ),
            (1.0, 1.0, 1.0)
        );
        for pass in [1u32, 10, 1000, 1_000_000] {
            let n = f64::from(pass) + 1.0;
            let closed =
                libm::exp(libm::lgamma(n + DEFAULT_ALPHA) - libm::lgamma(1.0 + DEFAULT_ALPHA) - libm::lgamma(n + 1.0));
            assert!((squared_radius_ratio(DEFAULT_ALPHA, pass) / closed - 1.0).abs() < 1e-7);
            let asymptote = libm::pow(n, DEFAULT_ALPHA - 1.0) / libm::tgamma(1.0 + DEFAULT_ALPHA);
            assert!((squared_radius_ratio(DEFAULT_ALPHA, pass) / asymptote - 1.0).abs() < 1.0 / n);
        }
    }
}
