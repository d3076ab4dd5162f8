//! Complex refractive indices of metals, measured in vacuum or air.
//!
//! The red, green and blue values are the indices at 650, 550 and 450 nm, interpolated in the
//! source's table. For gold and copper, full spectra are converted to linear Rec. 709 instead. All
//! tables are in the database of refractiveindex.info, which is in the public domain.

use crate::color::Rgb;

/// Name of a metal, and the real part η and imaginary part k of its refractive index.
type Metal = (&'static str, Rgb, Rgb);

/// Refractive indices of metals, sorted by name.
const METAL_TABLE: [Metal; 8] = [
    // Rakić 1995, Applied Optics 34, 4755.
    ("aluminium", Rgb::new(1.558, 1.015, 0.633), Rgb::new(7.712, 6.627, 5.454)),
    // Johnson and Christy 1974, Physical Review B 9, 5056.
    ("chromium", Rgb::new(3.107, 3.181, 2.323), Rgb::new(3.331, 3.329, 3.135)),
    // Johnson and Christy 1972, Physical Review B 6, 4370.
    ("copper", Rgb::new(0.2004, 0.9240, 1.1022), Rgb::new(3.9129, 2.4528, 2.1421)),
    // Johnson and Christy 1972.
    ("gold", Rgb::new(0.143, 0.375, 1.442), Rgb::new(3.983, 2.386, 1.603)),
    // Johnson and Christy 1974.
    ("iron", Rgb::new(2.911, 2.950, 2.584), Rgb::new(3.089, 2.932, 2.767)),
    // Johnson and Christy 1974.
    ("nickel", Rgb::new(1.990, 1.921, 1.729), Rgb::new(4.209, 3.616, 2.944)),
    // Rakić, Djurišić, Elazar and Majewski 1998, Applied Optics 37, 5271, their fit of Lorentz and
    // Drude's model.
    ("silver", Rgb::new(0.146, 0.134, 0.136), Rgb::new(3.937, 3.172, 2.328)),
    // Johnson and Christy 1974.
    ("titanium", Rgb::new(2.741, 2.542, 2.267), Rgb::new(3.814, 3.435, 3.038)),
];

/// Names of the metals that [`metal_refractive_index`] accepts, in alphabetical order.
pub const METALS: [&str; METAL_TABLE.len()] = {
    let mut names = [""; METAL_TABLE.len()];
    let mut i = 0;
    while i < METAL_TABLE.len() {
        names[i] = METAL_TABLE[i].0;
        i += 1;
    }
    names
};

/// Complex refractive index η + ik of the metal `name`; `None` if the name is not in [`METALS`].
///
/// Returns η and k, each for linear red, green and blue.
#[must_use]
pub fn metal_refractive_index(name: &str) -> Option<(Rgb, Rgb)> {
    METAL_TABLE.iter().find(|m| m.0 == name).map(|m| (m.1, m.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::conductor_reflectance;

    /// Reflectances at normal incidence agree with values in common use for clean metals.
    ///
    /// Sources differ by up to 0.1 for dull metals and by a few hundredths for bright ones, because
    /// polish and oxide vary.
    #[test]
    fn metal_reflectances_match_common_values() {
        let known = [
            ("aluminium", [0.91, 0.92, 0.92]),
            ("chromium", [0.55, 0.55, 0.55]),
            ("copper", [0.95, 0.64, 0.54]),
            ("gold", [1.00, 0.78, 0.34]),
            ("iron", [0.56, 0.57, 0.58]),
            ("nickel", [0.66, 0.61, 0.53]),
            ("silver", [0.97, 0.96, 0.92]),
            ("titanium", [0.54, 0.50, 0.45]),
        ];
        assert_eq!(known.map(|k| k.0), METALS);
        for (name, expected) in known {
            let (eta, k) = metal_refractive_index(name).unwrap();
            let r = conductor_reflectance(1.0, eta, k);
            let error = (r - Rgb::from_array(expected)).abs().max_element();
            let bright = ["aluminium", "copper", "gold", "silver"].contains(&name);
            assert!(error < if bright { 0.04 } else { 0.1 }, "{name}: {r}");
        }
        assert_eq!(metal_refractive_index("unobtainium"), None);
    }
}
