//! Dispersion: refractive indices of glass and other transparent media by wavelength.

/// Wavelengths of the Fraunhofer lines F, d and C \[nm].
const FRAUNHOFER_LINES_NM: [f64; 3] = [486.13, 587.56, 656.27];
/// Shortest and longest rendered wavelength \[nm].
const RENDERED_BAND_NM: [u32; 2] = [380, 720];

/// A formula for the refractive index n of a transparent medium at the wavelength λ \[µm].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DispersionFormula {
    /// Cauchy's equation: n = a + b/λ² + c/λ⁴, with the wavelength λ \[µm].
    Cauchy {
        /// Refractive index at infinite wavelength.
        a: f64,
        /// Coefficient of 1/λ² \[µm²].
        b: f64,
        /// Coefficient of 1/λ⁴ \[µm⁴].
        c: f64,
    },
    /// Sellmeier's equation: n² = 1 + Σ bᵢ λ²/(λ² − cᵢ), with the wavelength λ \[µm].
    Sellmeier {
        /// Coefficients bᵢ, the strengths of the resonances; 0 for an unused term.
        b: [f64; 4],
        /// Coefficients cᵢ, the squared wavelengths of the resonances \[µm²].
        c: [f64; 4],
    },
}

impl DispersionFormula {
    /// Creates Cauchy's equation with two terms from the refractive index `nd` at the d line
    /// (587.56 nm) and the Abbe number `vd`.
    #[must_use]
    pub fn from_abbe_number(nd: f64, vd: f64) -> Self {
        let [f, d, c] = FRAUNHOFER_LINES_NM.map(inverse_squared_micrometres);
        let b = (nd - 1.0) / (vd * (f - c));
        Self::Cauchy { a: nd - b * d, b, c: 0.0 }
    }

    /// Refractive index at the wavelength `nm` \[nm].
    #[must_use]
    pub fn refractive_index(&self, nm: f32) -> f32 {
        self.refractive_index_f64(f64::from(nm)) as f32
    }

    /// Refractive index at the d line, 587.56 nm.
    #[must_use]
    pub fn refractive_index_at_d_line(&self) -> f32 {
        self.refractive_index_f64(FRAUNHOFER_LINES_NM[1]) as f32
    }

    /// Abbe number (n_d − 1)/(n_F − n_C); smaller numbers mean stronger dispersion.
    ///
    /// n_d, n_F and n_C are the refractive indices at 587.56, 486.13 and 656.27 nm.
    #[must_use]
    pub fn abbe_number(&self) -> f32 {
        let [f, d, c] = FRAUNHOFER_LINES_NM.map(|nm| self.refractive_index_f64(nm));
        ((d - 1.0) / (f - c)) as f32
    }

    /// Returns a lower and an upper bound of the refractive index between 380 and 720 nm.
    ///
    /// Returns `None` if the index is not positive and finite, for example near a resonance.
    #[must_use]
    pub fn refractive_index_range(&self) -> Option<[f64; 2]> {
        let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
        for nm in RENDERED_BAND_NM[0]..RENDERED_BAND_NM[1] {
            let [low, high] = self.refractive_index_bounds_between(f64::from(nm), f64::from(nm + 1))?;
            least = least.min(low);
            most = most.max(high);
        }
        Some([least, most])
    }

    /// Returns a lower and an upper bound of the refractive index between two wavelengths \[nm].
    ///
    /// Returns `None` if the index is not positive and finite at some wavelength between them.
    fn refractive_index_bounds_between(&self, from: f64, to: f64) -> Option<[f64; 2]> {
        // Each term is monotonic between the wavelengths, so its bounds are at the ends.
        let mut sum = [0.0f64; 2];
        let mut add = |p: f64, q: f64| {
            sum[0] += p.min(q);
            sum[1] += p.max(q);
        };
        let is_squared = match *self {
            Self::Cauchy { a, b, c } => {
                let [p, q] = [from, to].map(inverse_squared_micrometres);
                add(a, a);
                add(b * p, b * q);
                add(c * p * p, c * q * q);
                false
            }
            Self::Sellmeier { b, c } => {
                let [p, q] = [from, to].map(squared_micrometres);
                add(1.0, 1.0);
                for (b, c) in b.into_iter().zip(c) {
                    if b != 0.0 && p <= c && c <= q {
                        return None;
                    }
                    add(sellmeier_term(b, c, p), sellmeier_term(b, c, q));
                }
                true
            }
        };
        let sum = if is_squared { sum.map(f64::sqrt) } else { sum };
        (sum[0] > 0.0 && sum[1].is_finite()).then_some(sum)
    }

    /// Refractive index at the wavelength `nm` \[nm], in f64.
    fn refractive_index_f64(&self, nm: f64) -> f64 {
        match *self {
            Self::Cauchy { a, b, c } => {
                let t = inverse_squared_micrometres(nm);
                a + t * (b + t * c)
            }
            Self::Sellmeier { b, c } => {
                let x = squared_micrometres(nm);
                (1.0 + b.into_iter().zip(c).map(|(b, c)| sellmeier_term(b, c, x)).sum::<f64>()).sqrt()
            }
        }
    }
}

/// Returns λ² \[µm²] of the wavelength λ = `nm` \[nm].
fn squared_micrometres(nm: f64) -> f64 {
    nm * nm * 1e-6
}

/// Returns 1/λ² \[µm⁻²] of the wavelength λ = `nm` \[nm].
fn inverse_squared_micrometres(nm: f64) -> f64 {
    1.0 / squared_micrometres(nm)
}

/// Term b·x/(x − c) of Sellmeier's equation, where x is λ²; 0 if b is 0, even at x = c.
fn sellmeier_term(b: f64, c: f64, x: f64) -> f64 {
    if b == 0.0 { 0.0 } else { b * x / (x - c) }
}

/// Makes Sellmeier's equation from the coefficients bᵢ and cᵢ of three terms.
const fn three_term_sellmeier(b: [f64; 3], c: [f64; 3]) -> DispersionFormula {
    DispersionFormula::Sellmeier { b: [b[0], b[1], b[2], 0.0], c: [c[0], c[1], c[2], 0.0] }
}

/// Media that [`glass_by_name`] finds: (name, dispersion formula, source of the data), sorted by
/// name.
///
/// Refractive indices of water and diamond are relative to vacuum, all others to air. The
/// difference is below 0.0003 of the index. Coefficients are from the public-domain database of
/// refractiveindex.info.
pub const GLASSES: [(&str, DispersionFormula, &str); 9] = [
    (
        "BK7",
        three_term_sellmeier([1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653]),
        "N-BK7, SCHOTT's catalogue of optical glasses",
    ),
    (
        "F2",
        three_term_sellmeier([1.34533359, 0.209073176, 0.937357162], [0.00997743871, 0.0470450767, 111.886764]),
        "F2, SCHOTT's catalogue of optical glasses",
    ),
    (
        "LAK9",
        three_term_sellmeier([1.46231905, 0.344399589, 1.15508372], [0.00724270156, 0.0243353131, 85.4686868]),
        "N-LAK9, SCHOTT's catalogue of optical glasses",
    ),
    (
        "SF10",
        three_term_sellmeier([1.62153902, 0.256287842, 1.64447552], [0.0122241457, 0.0595736775, 147.468793]),
        "N-SF10, SCHOTT's catalogue of optical glasses",
    ),
    (
        "SF11",
        three_term_sellmeier([1.73759695, 0.313747346, 1.89878101], [0.013188707, 0.0623068142, 155.23629]),
        "N-SF11, SCHOTT's catalogue of optical glasses",
    ),
    (
        "diamond",
        three_term_sellmeier([0.3306, 4.3356, 0.0], [0.175 * 0.175, 0.106 * 0.106, 0.0]),
        "Peter 1923, Zeitschrift für Physik 15, 358",
    ),
    (
        "fusedSilica",
        three_term_sellmeier(
            [0.6961663, 0.4079426, 0.8974794],
            [0.0684043 * 0.0684043, 0.1162414 * 0.1162414, 9.896161 * 9.896161],
        ),
        "Malitson 1965, Journal of the Optical Society of America 55, 1205",
    ),
    (
        "sapphire",
        three_term_sellmeier(
            [1.4313493, 0.65054713, 5.3414021],
            [0.0726631 * 0.0726631, 0.1193242 * 0.1193242, 18.028251 * 18.028251],
        ),
        "the ordinary ray, Malitson and Dodge 1972, Journal of the Optical Society of America 62, 1405",
    ),
    (
        "water",
        DispersionFormula::Sellmeier {
            b: [0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688],
            c: [0.005101829712, 0.01821153936, 0.02620722293, 10.69792721],
        },
        "at 20 °C, Daimon and Masumura 2007, Applied Optics 46, 3811",
    ),
];

/// Returns the dispersion formula of the glass or other medium with this name; `None` if it is not
/// in [`GLASSES`].
#[must_use]
pub fn glass_by_name(name: &str) -> Option<DispersionFormula> {
    GLASSES.iter().find(|g| g.0 == name).map(|g| g.1)
}

#[cfg(test)]
mod tests;
