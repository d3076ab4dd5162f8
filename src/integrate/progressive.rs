//! The radius law of independent passes.

/// How fast the radius shrinks: variance falls as N^−α, squared bias as N^2(α−1); ⅔ balances both (Kaplanyan and Dachsbacher
/// 2013).
pub const ALPHA: f64 = 2.0 / 3.0;

/// Squared radius of pass `pass` (counted from 0) over that of the first: the product of (i + α)/(i + 1) for i = 1 … pass
/// (Knaus and Zwicker 2011, equation 15).
#[must_use]
pub fn shrink(pass: u32) -> f64 {
    product(ALPHA, pass)
}

/// The radius of pass `pass` over that of the first, of a kernel in so many dimensions: its measure shrinks by the same law with
/// α = 4/(4 + d), where variance N^−α and squared bias N^4(α−1)/d fall alike.
#[must_use]
pub(super) fn shrink_in(dimensions: u32, pass: u32) -> f32 {
    let d = f64::from(dimensions);
    libm::pow(product(4.0 / (4.0 + d), pass), 1.0 / d) as f32
}

fn product(alpha: f64, pass: u32) -> f64 {
    (1..=pass).map(f64::from).map(|i| (i + alpha) / (i + 1.0)).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_shrink_by_the_law_of_surfaces() {
        for pass in [0, 1, 17, 1000] {
            assert!((f64::from(shrink_in(2, pass)) - shrink(pass).sqrt()).abs() < 1e-6);
        }
        // N^(α−1)/d: −1/5, −1/6 and −1/7.
        for (dimensions, power) in [(1, -0.2), (2, -1.0 / 6.0), (3, -1.0 / 7.0)] {
            let ratio = f64::from(shrink_in(dimensions, 99_999) / shrink_in(dimensions, 9999));
            assert!((libm::log10(ratio) - power).abs() < 1e-3, "{dimensions}: {ratio}");
        }
    }

    /// The closed form Γ(N+α)/(Γ(1+α)Γ(N+1)) and its asymptote N^(α−1)/Γ(1+α), whose relative error is below 1/N.
    #[test]
    fn the_product_is_the_ratio_of_gammas() {
        assert_eq!(shrink(0), 1.0);
        for pass in [1u32, 10, 1000, 1_000_000] {
            let n = f64::from(pass) + 1.0;
            let closed = libm::exp(libm::lgamma(n + ALPHA) - libm::lgamma(1.0 + ALPHA) - libm::lgamma(n + 1.0));
            assert!((shrink(pass) / closed - 1.0).abs() < 1e-7);
            let asymptote = libm::pow(n, ALPHA - 1.0) / libm::tgamma(1.0 + ALPHA);
            assert!((shrink(pass) / asymptote - 1.0).abs() < 1.0 / n);
        }
    }
}
