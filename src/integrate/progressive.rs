//! The radius law of independent passes.

/// How fast the radius shrinks: variance falls as N^−α, squared bias as N^2(α−1); ⅔ balances both (Kaplanyan and Dachsbacher
/// 2013).
pub const ALPHA: f64 = 2.0 / 3.0;

/// Squared radius of pass `pass` (counted from 0) over that of the first: the product of (i + α)/(i + 1) for i = 1 … pass
/// (Knaus and Zwicker 2011, equation 15).
#[must_use]
pub fn shrink(pass: u32) -> f64 {
    (1..=pass).map(f64::from).map(|i| (i + ALPHA) / (i + 1.0)).product()
}

#[cfg(test)]
mod tests {
    use super::*;

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
