//! What light of one wavelength gives each channel.
//!
//! Where an index of refraction depends on the wavelength, a walk chooses one and goes on as light of that wavelength alone. In
//! each linear channel light counts as spread over the wavelengths by a response, a density of integral one, so a walk that
//! chooses by the mean of the three responses is worth [`Wavelength::weight`] afterwards, and white light comes out white.
//!
//! Responses are the colour matching functions of CIE 1931 (2°) in the fit of Wyman, Sloan and Shirley (Simple Analytic
//! Approximations to the CIE XYZ Color Matching Functions, JCGT 2(2), 2013), turned into linear RGB of Rec. 709. No mixture of
//! the three primaries gives a pure spectral colour; as much white is added to each as makes its least channel zero. The fit's hues
//! are those of the functions up to 690 nm; the thousandth of the light beyond turns to orange.

use super::Rgb;
use glam::DVec3;
use std::sync::LazyLock;

/// Shortest wavelength \[nm\].
const SHORTEST: f32 = 380.0;
/// Longest wavelength \[nm\].
const LONGEST: f32 = 720.0;
/// Cells in each of which responses are constant: one for each code of a byte but 0.
const CELLS: usize = 255;
/// Width of a cell \[nm\].
const STEP: f32 = (LONGEST - SHORTEST) / CELLS as f32;
/// Some spacings of f32 at the longest wavelength, so that a point in a cell never rounds into another.
const EDGE: f32 = 1.0 / 4096.0;

/// A wavelength that a walk chose, between 380 and 720 nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength(f32);

impl Wavelength {
    /// The shortest there is \[nm].
    pub const SHORTEST: f32 = SHORTEST;
    /// The longest there is \[nm].
    pub const LONGEST: f32 = LONGEST;

    /// By the mean of the channels' responses, for `u` in \[0, 1).
    #[must_use]
    pub fn sample(u: f32) -> Self {
        let sums = &TABLE.sums;
        let u = f64::from(u);
        let cell = sums.partition_point(|s| *s <= u).clamp(1, CELLS) - 1;
        let within = (u - sums[cell]) / (sums[cell + 1] - sums[cell]);
        Self(SHORTEST + (cell as f32 + (within as f32).clamp(EDGE, 1.0 - EDGE)) * STEP)
    }

    /// The wavelength \[nm\].
    #[inline]
    #[must_use]
    pub fn nanometres(self) -> f32 {
        self.0
    }

    /// Density of [`Wavelength::sample`] \[1/nm\].
    #[must_use]
    pub fn density(self) -> f32 {
        TABLE.densities[self.cell()]
    }

    /// What white light of unit radiance is worth in each channel once it is of this wavelength only: the responses over the
    /// density. The mean over channels is one, and so is the expectation of each channel.
    #[must_use]
    pub fn weight(self) -> Rgb {
        TABLE.weights[self.cell()]
    }

    /// The wavelength in a byte, from 1 to 255, to within 2/3 nm.
    #[must_use]
    pub fn code(self) -> u8 {
        1 + self.cell() as u8
    }

    /// The middle of the wavelengths with this code, which has their weight and density; `None` for 0, which stands for light that
    /// chose none.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        let step = code.checked_sub(1)?;
        Some(Self(SHORTEST + (f32::from(step) + 0.5) * STEP))
    }

    fn cell(self) -> usize {
        ((self.0 - SHORTEST) / STEP).min(CELLS as f32 - 1.0) as usize
    }
}

struct Table {
    /// Probability of a wavelength before each cell, and one at the end.
    sums: [f64; CELLS + 1],
    /// Density in each cell \[1/nm\].
    densities: [f32; CELLS],
    weights: [Rgb; CELLS],
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let middle = |cell: usize| f64::from(SHORTEST) + (cell as f64 + 0.5) * f64::from(STEP);
    let responses: [DVec3; CELLS] = std::array::from_fn(|cell| in_gamut(matching(middle(cell))));
    let total: DVec3 = responses.iter().sum();
    let mut table = Table { sums: [0.0; CELLS + 1], densities: [0.0; CELLS], weights: [Rgb::ZERO; CELLS] };
    for (cell, response) in responses.iter().enumerate() {
        let response = response / total;
        let density = response.element_sum() / 3.0;
        table.sums[cell + 1] = table.sums[cell] + density;
        table.densities[cell] = (density / f64::from(STEP)) as f32;
        table.weights[cell] = (response / density).as_vec3();
    }
    table
});

/// Linear RGB with as much white added as leaves no channel negative.
fn in_gamut(rgb: DVec3) -> DVec3 {
    rgb - rgb.min_element().min(0.0)
}

/// The matching functions for linear RGB of Rec. 709 at a wavelength \[nm\].
fn matching(nm: f64) -> DVec3 {
    let lobe = |height: f64, peak: f64, below: f64, above: f64| {
        let t = (nm - peak) * if nm < peak { below } else { above };
        height * libm::exp(-0.5 * t * t)
    };
    let x =
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) - lobe(0.065, 501.1, 0.0490, 0.0382);
    let y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322);
    let z = lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725);
    // The inverse of the matrix of Rec. 709's primaries and white, D65.
    DVec3::new(
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::SmallRng;
    use rand::{RngExt, SeedableRng};

    fn at(nm: f32) -> Wavelength {
        Wavelength(nm)
    }

    /// Degrees round the colour wheel from red over green to blue, from −90 to 270.
    fn hue(c: Rgb) -> f32 {
        let angle = libm::atan2f(3.0f32.sqrt() * (c.y - c.z), 2.0 * c.x - c.y - c.z).to_degrees();
        if angle < -90.0 { angle + 360.0 } else { angle }
    }

    /// The midpoint rule errs by at most the variation of a weight, below 20, over twice the points.
    #[test]
    fn white_light_stays_white() {
        let n = 1u32 << 22;
        let mut sum = DVec3::ZERO;
        for i in 0..n {
            sum += Wavelength::sample((i as f32 + 0.5) / n as f32).weight().as_dvec3();
        }
        let mean = sum / f64::from(n);
        assert!((mean - 1.0).abs().max_element() < 1e-5, "{mean}");
    }

    #[test]
    fn weights_are_of_the_channels_and_average_one() {
        let mut integral = 0.0;
        for cell in 0..CELLS {
            let w = at(SHORTEST + (cell as f32 + 0.5) * STEP);
            assert!((w.weight().element_sum() / 3.0 - 1.0).abs() < 1e-6 && w.weight().min_element() >= 0.0);
            assert!(w.density() > 0.0 && w == at(w.nanometres()));
            integral += f64::from(w.density()) * f64::from(STEP);
        }
        // Each of 255 densities is rounded to f32.
        assert!((integral - 1.0).abs() < 6e-8 && (TABLE.sums[CELLS] - 1.0).abs() < 1e-12, "{integral}");
    }

    #[test]
    fn colours_come_in_their_order() {
        let (red, yellow, green, blue) = (at(650.0), at(580.0), at(530.0), at(450.0));
        assert!(red.weight().x > 2.4, "{}", red.weight());
        assert!(yellow.weight().x.min(yellow.weight().y) > 2.0 * yellow.weight().z, "{}", yellow.weight());
        assert!(green.weight().y > 1.8, "{}", green.weight());
        assert!(blue.weight().z > 2.2, "{}", blue.weight());
        // Outside these the spectral colours hardly change, and the fit's hue wanders by degrees.
        let cells = at(440.0).cell()..=at(640.0).cell();
        let hues: Vec<f32> = cells.map(|cell| hue(TABLE.weights[cell])).collect();
        assert!(hues.windows(2).all(|pair| pair[0] > pair[1]), "{hues:?}");
        for nm in 400..440 {
            assert!((hue(at(nm as f32).weight()) - 250.0).abs() < 10.0, "{nm}");
        }
        for nm in 640..690 {
            assert!(hue(at(nm as f32).weight()).abs() < 10.0, "{nm}");
        }
        let beyond = TABLE.sums[at(690.0).cell()];
        assert!(beyond > 0.999, "{beyond}");
    }

    /// Chi-square over the cells of a million wavelengths; false alarm 10⁻⁴.
    #[test]
    fn wavelengths_follow_their_density() {
        let n = 1_000_000u32;
        let mut rng = SmallRng::seed_from_u64(11);
        let mut counts = [0u32; CELLS];
        for _ in 0..n {
            counts[Wavelength::sample(rng.random()).cell()] += 1;
        }
        // Neighbours are put together up to twenty expected, below which a count is not normal.
        let (mut chi2, mut nu) = (0.0, -1.0);
        let (mut count, mut expected) = (0.0, 0.0);
        for (cell, c) in counts.iter().enumerate() {
            count += f64::from(*c);
            expected += f64::from(n) * f64::from(TABLE.densities[cell]) * f64::from(STEP);
            if expected >= 20.0 {
                chi2 += (count - expected) * (count - expected) / expected;
                nu += 1.0;
                (count, expected) = (0.0, 0.0);
            }
        }
        // Wilson–Hilferty, as for the keys.
        let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
        assert!(nu > 190.0 && z.abs() < 3.9, "z = {z}, nu = {nu}");
    }

    #[test]
    fn the_ends_of_sampling_lie_in_the_range() {
        let last = Wavelength::sample(1.0 - f32::EPSILON / 2.0);
        assert_eq!(Wavelength::sample(0.0).cell(), 0);
        assert!(last.nanometres() < 720.0 && last.nanometres() > 700.0, "{last:?}");
        assert_eq!(last.cell(), ((last.nanometres() - SHORTEST) / STEP) as usize);
    }

    #[test]
    fn codes_keep_the_wavelength() {
        assert_eq!(Wavelength::from_code(0), None);
        for i in 0..=3400 {
            let w = at(SHORTEST + i as f32 * 0.1);
            let back = Wavelength::from_code(w.code()).unwrap();
            // Half a cell of 340/255 nm, and f32.
            assert!((back.nanometres() - w.nanometres()).abs() < 0.667, "{w:?} {back:?}");
            assert_eq!((back.weight(), back.density()), (w.weight(), w.density()));
        }
        for code in 1..=255 {
            assert_eq!(Wavelength::from_code(code).map(Wavelength::code), Some(code));
        }
    }
}
