//! Complex refractive indices of metals, measured in vacuum or air.
//!
//! The red, green and blue values are the indices at 650, 550 and 450 nm, interpolated in the
//! source's table. For brass, copper and gold, full spectra are converted to linear Rec. 709
//! instead. All tables are in the database of refractiveindex.info, which is in the public domain.

use crate::color::Rgb;

/// Name and chemical symbol of a metal, and the real part η and imaginary part k of its refractive
/// index.
type Metal = (&'static str, &'static str, Rgb, Rgb);

/// Refractive indices of metals, sorted by name.
const METAL_TABLE: [Metal; 13] = [
    // Rakić 1995, Applied Optics 34, 4755.
    ("aluminium", "Al", Rgb::new(1.558, 1.015, 0.633), Rgb::new(7.712, 6.627, 5.454)),
    // Querry 1985, report CRDC-CR-85034 of the US Army: 70 % copper and 30 % zinc.
    ("brass", "CuZn", Rgb::new(0.4909, 0.5617, 1.0744), Rgb::new(4.0653, 2.8054, 1.7388)),
    // Johnson and Christy 1974, Physical Review B 9, 5056.
    ("chromium", "Cr", Rgb::new(3.107, 3.181, 2.323), Rgb::new(3.331, 3.329, 3.135)),
    // Johnson and Christy 1972, Physical Review B 6, 4370.
    ("copper", "Cu", Rgb::new(0.2004, 0.9240, 1.1022), Rgb::new(3.9129, 2.4528, 2.1421)),
    // Johnson and Christy 1972.
    ("gold", "Au", Rgb::new(0.143, 0.375, 1.442), Rgb::new(3.983, 2.386, 1.603)),
    // Schmitt and others 2022, Optical Materials Express 12, 545: a film made by atomic layer
    // deposition.
    ("iridium", "Ir", Rgb::new(2.991, 2.574, 2.119), Rgb::new(5.575, 5.096, 4.377)),
    // Johnson and Christy 1974.
    ("iron", "Fe", Rgb::new(2.911, 2.950, 2.584), Rgb::new(3.089, 2.932, 2.767)),
    // Kirillova, Nomerovannaya and Noskov 1971, Soviet Physics JETP 33, 1210.
    ("molybdenum", "Mo", Rgb::new(3.45, 3.47, 2.84), Rgb::new(3.67, 3.56, 3.51)),
    // Johnson and Christy 1974.
    ("nickel", "Ni", Rgb::new(1.990, 1.921, 1.729), Rgb::new(4.209, 3.616, 2.944)),
    // Rakić, Djurišić, Elazar and Majewski 1998, Applied Optics 37, 5271, their fit of Lorentz and
    // Drude's model.
    ("silver", "Ag", Rgb::new(0.146, 0.134, 0.136), Rgb::new(3.937, 3.172, 2.328)),
    // Johnson and Christy 1974.
    ("titanium", "Ti", Rgb::new(2.741, 2.542, 2.267), Rgb::new(3.814, 3.435, 3.038)),
    // Weaver, Olson and Lynch 1975, Physical Review B 12, 1293.
    ("tungsten", "W", Rgb::new(3.671, 3.522, 3.315), Rgb::new(2.933, 2.740, 2.516)),
    // Johnson and Christy 1974.
    ("vanadium", "V", Rgb::new(3.312, 3.995, 3.586), Rgb::new(3.075, 3.039, 3.462)),
];

/// Names of the metals that [`metal_refractive_index`] accepts, in alphabetical order.
pub const METAL_NAMES: [&str; METAL_TABLE.len()] = {
    let mut names = [""; METAL_TABLE.len()];
    let mut i = 0;
    while i < METAL_TABLE.len() {
        names[i] = METAL_TABLE[i].0;
        i += 1;
    }
    names
};

/// Returns the complex refractive index η + ik of a metal, as the pair (η, k) for linear red, green
/// and blue.
///
/// `name` is one of [`METAL_NAMES`] or a chemical symbol, such as "Au". Returns `None` for other
/// names.
#[must_use]
pub fn metal_refractive_index(name: &str) -> Option<(Rgb, Rgb)> {
    METAL_TABLE.iter().find(|m| m.0 == name || m.1 == name).map(|m| (m.2, m.3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::conductor_reflectance;

    /// Computed reflectances at normal incidence agree with published values for clean metals.
    ///
    /// Sources differ by up to 0.1 for dull metals and by a few hundredths for bright ones, because
    /// polish and oxide vary.
    #[test]
    fn metal_reflectances_match_common_values() {
        let known = [
            ("aluminium", [0.91, 0.92, 0.92]),
            ("brass", [0.91, 0.78, 0.42]),
            ("chromium", [0.55, 0.55, 0.55]),
            ("copper", [0.95, 0.64, 0.54]),
            ("gold", [1.00, 0.78, 0.34]),
            ("iridium", [0.76, 0.73, 0.71]),
            ("iron", [0.56, 0.57, 0.58]),
            ("molybdenum", [0.58, 0.57, 0.59]),
            ("nickel", [0.66, 0.61, 0.53]),
            ("silver", [0.97, 0.96, 0.92]),
            ("titanium", [0.54, 0.50, 0.45]),
            ("tungsten", [0.51, 0.49, 0.46]),
            ("vanadium", [0.54, 0.54, 0.57]),
        ];
        assert_eq!(known.map(|k| k.0), METAL_NAMES);
        for (name, expected) in known {
            let (eta, k) = metal_refractive_index(name).unwrap();
            let r = conductor_reflectance(1.0, eta, k);
            let error = (r - Rgb::from_array(expected)).abs().max_element();
            let bright = ["aluminium", "copper", "gold", "silver"].contains(&name);
            assert!(error < if bright { 0.04 } else { 0.1 }, "{name}: {r}");
        }
        assert_eq!(metal_refractive_index("Au"), metal_refractive_index("gold"));
        assert_eq!(metal_refractive_index("unobtainium"), None);
    }
}
