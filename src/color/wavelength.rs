//! Sampled wavelengths and their weights in linear RGB.
//!
//! At the first dispersive interface, a path samples one wavelength, and usually keeps it. Each RGB
//! channel has a response over the wavelengths, which integrates to 1. The pdf of the wavelength is
//! the mean of the three responses. The path's throughput is multiplied by the responses over the
//! pdf, [`Wavelength::weight`]. So white light stays white on average.
//!
//! The responses are the CIE 1931 (2°) color matching functions in linear RGB of Rec. 709. They use
//! the fit of Wyman, Sloan and Shirley 2013 ("Simple Analytic Approximations to the CIE XYZ Color
//! Matching Functions", JCGT 2(2)). Spectral colors lie outside the gamut of Rec. 709, so white is
//! added to each until no channel is negative.

use super::rgb::{Rgb, xyz_to_rgb};
use glam::DVec3;
use std::sync::LazyLock;

/// Number of equal intervals into which the band of 380 to 720 nm is divided. The response of each
/// RGB channel is constant in each interval.
///
/// The number fits a byte: [`Wavelength::byte_code`] is the index of an interval plus 1.
const RESPONSE_INTERVAL_COUNT: usize = 255;
/// Width of a wavelength interval of constant response \[nm].
const RESPONSE_INTERVAL_NM: f32 = (Wavelength::LONGEST_NM - Wavelength::SHORTEST_NM) / RESPONSE_INTERVAL_COUNT as f32;
/// Least distance of a sampled wavelength from the ends of its interval, as a fraction of the
/// interval's width. Rounding to f32 then cannot move the wavelength into a neighboring interval.
const MIN_RELATIVE_EDGE_DISTANCE: f32 = 1.0 / 4096.0;

/// A sampled wavelength in \[380, 720] nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength(f32);

impl Wavelength {
    /// Shortest rendered wavelength \[nm].
    pub const SHORTEST_NM: f32 = 380.0;
    /// Longest rendered wavelength \[nm].
    pub const LONGEST_NM: f32 = 720.0;

    /// Samples a wavelength from a random number `u` in \[0, 1). The pdf is the mean of the three
    /// channel responses.
    #[must_use]
    pub fn sample(u: f32) -> Self {
        let sums = &RESPONSE_TABLE.cumulative_probabilities;
        let u = f64::from(u);
        let cell = sums.partition_point(|s| *s <= u).clamp(1, RESPONSE_INTERVAL_COUNT) - 1;
        let within = (u - sums[cell]) / (sums[cell + 1] - sums[cell]);
        Self(
            Self::SHORTEST_NM
                + (cell as f32 + (within as f32).clamp(MIN_RELATIVE_EDGE_DISTANCE, 1.0 - MIN_RELATIVE_EDGE_DISTANCE))
                    * RESPONSE_INTERVAL_NM,
        )
    }

    /// The wavelength in nanometers.
    #[inline]
    #[must_use]
    pub fn nanometres(self) -> f32 {
        self.0
    }

    /// Pdf \[1/nm] with which [`Wavelength::sample`] samples this wavelength.
    #[must_use]
    pub fn pdf(self) -> f32 {
        RESPONSE_TABLE.pdfs[self.response_interval_index()]
    }

    /// Factor on the RGB throughput of a path that sampled this wavelength: the response of each
    /// channel over the pdf.
    ///
    /// The mean of the factor over the three channels is 1. The expected value of each channel over
    /// all sampled wavelengths is 1 too.
    #[must_use]
    pub fn weight(self) -> Rgb {
        RESPONSE_TABLE.weights[self.response_interval_index()]
    }

    /// Code of the wavelength: the index of its interval, plus 1. The code is a number from 1 to
    /// 255.
    ///
    /// [`Wavelength::from_byte_code`] restores the wavelength within 2/3 nm.
    #[must_use]
    pub fn byte_code(self) -> u8 {
        1 + self.response_interval_index() as u8
    }

    /// Returns the wavelength of a code from [`Wavelength::byte_code`]. Returns `None` for the code
    /// 0, which marks light that carries all wavelengths.
    #[must_use]
    pub fn from_byte_code(code: u8) -> Option<Self> {
        let step = code.checked_sub(1)?;
        Some(Self(Self::SHORTEST_NM + (f32::from(step) + 0.5) * RESPONSE_INTERVAL_NM))
    }

    /// Index of the interval of constant response that contains the wavelength.
    fn response_interval_index(self) -> usize {
        ((self.0 - Self::SHORTEST_NM) / RESPONSE_INTERVAL_NM).min(RESPONSE_INTERVAL_COUNT as f32 - 1.0) as usize
    }
}

/// Table for sampling wavelengths by the responses of the RGB channels. The responses are constant
/// in each wavelength interval.
struct SpectralResponseTable {
    /// Cumulative probability at the start of each interval; the last entry is 1.
    cumulative_probabilities: [f64; RESPONSE_INTERVAL_COUNT + 1],
    /// Pdf of sampled wavelengths in each interval \[1/nm].
    pdfs: [f32; RESPONSE_INTERVAL_COUNT],
    /// Weight of a sampled wavelength in each interval: see [`Wavelength::weight`].
    weights: [Rgb; RESPONSE_INTERVAL_COUNT],
}

/// Responses of the RGB channels and sampling tables, computed at first use.
static RESPONSE_TABLE: LazyLock<SpectralResponseTable> = LazyLock::new(|| {
    let center =
        |cell: usize| f64::from(Wavelength::SHORTEST_NM) + (cell as f64 + 0.5) * f64::from(RESPONSE_INTERVAL_NM);
    let responses: [DVec3; RESPONSE_INTERVAL_COUNT] =
        std::array::from_fn(|cell| add_white_until_nonnegative(color_matching_rgb(center(cell))));
    let total: DVec3 = responses.iter().sum();
    let mut table = SpectralResponseTable {
        cumulative_probabilities: [0.0; RESPONSE_INTERVAL_COUNT + 1],
        pdfs: [0.0; RESPONSE_INTERVAL_COUNT],
        weights: [Rgb::ZERO; RESPONSE_INTERVAL_COUNT],
    };
    for (cell, response) in responses.iter().enumerate() {
        let response = response / total;
        let density = response.element_sum() / 3.0;
        table.cumulative_probabilities[cell + 1] = table.cumulative_probabilities[cell] + density;
        table.pdfs[cell] = (density / f64::from(RESPONSE_INTERVAL_NM)) as f32;
        table.weights[cell] = (response / density).as_vec3();
    }
    table
});

/// Adds just enough white to a linear RGB color that no channel is negative.
fn add_white_until_nonnegative(rgb: DVec3) -> DVec3 {
    rgb - rgb.min_element().min(0.0)
}

/// Color matching functions of linear Rec. 709 RGB at a wavelength \[nm]; they may be negative.
pub(super) fn color_matching_rgb(nm: f64) -> DVec3 {
    let lobe = |height: f64, peak: f64, below: f64, above: f64| {
        let t = (nm - peak) * if nm < peak { below } else { above };
        height * libm::exp(-0.5 * t * t)
    };
    let x =
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) - lobe(0.065, 501.1, 0.0490, 0.0382);
    let y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322);
    let z = lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725);
    xyz_to_rgb(DVec3::new(x, y, z))
}

#[cfg(test)]
mod tests;
