//! Sampled wavelengths and their weights in linear RGB.
//!
//! At a dispersive interface a path chooses one wavelength, and continues with this wavelength
//! alone. Each linear channel has a response over the wavelengths, a density of integral one. A
//! path samples the mean of the three responses, and its weight is [`Wavelength::weight`]. White
//! light stays white in the mean.
//!
//! Responses are the CIE 1931 (2°) colour matching functions in the fit of Wyman, Sloan and Shirley
//! 2013 ("Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2)), in
//! linear RGB of Rec. 709. Pure spectral colours are outside of this gamut; white is added to each
//! until its least channel is zero. Up to 690 nm, the hues of the fit match the functions. The last
//! thousandth of the light turns to orange.

use super::Rgb;
use glam::DVec3;
use std::sync::LazyLock;

/// Shortest wavelength \[nm\].
const SHORTEST: f32 = 380.0;
/// Longest wavelength \[nm\].
const LONGEST: f32 = 720.0;
/// Number of cells of constant response: one per code of a byte except 0.
const CELLS: usize = 255;
/// Width of a cell \[nm\].
const STEP: f32 = (LONGEST - SHORTEST) / CELLS as f32;
/// Distance of samples from cell edges, in cells: several f32 spacings at the longest wavelength.
const EDGE: f32 = 1.0 / 4096.0;

/// A sampled wavelength between 380 and 720 nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength(f32);

impl Wavelength {
    /// Shortest wavelength \[nm].
    pub const SHORTEST: f32 = SHORTEST;
    /// Longest wavelength \[nm].
    pub const LONGEST: f32 = LONGEST;

    /// Samples a wavelength by the mean response of the channels, for `u` in \[0, 1).
    #[must_use]
    pub fn sample(u: f32) -> Self {
        let sums = &RESPONSE_TABLE.sums;
        let u = f64::from(u);
        let response_cell = sums.partition_point(|s| *s <= u).clamp(1, CELLS) - 1;
        let within = (u - sums[response_cell]) / (sums[response_cell + 1] - sums[response_cell]);
        Self(SHORTEST + (response_cell as f32 + (within as f32).clamp(EDGE, 1.0 - EDGE)) * STEP)
    }

    /// Wavelength \[nm].
    #[inline]
    #[must_use]
    pub fn nanometres(self) -> f32 {
        self.0
    }

    /// Pdf of [`Wavelength::sample`] \[1/nm].
    #[must_use]
    pub fn pdf(self) -> f32 {
        RESPONSE_TABLE.pdfs[self.response_cell()]
    }

    /// Weight of a path that sampled this wavelength: the responses over the pdf.
    ///
    /// The mean over the channels is one, and so is the expectation of each channel.
    #[must_use]
    pub fn weight(self) -> Rgb {
        RESPONSE_TABLE.weights[self.response_cell()]
    }

    /// Code of the wavelength in a byte, from 1 to 255, precise to 2/3 nm.
    #[must_use]
    pub fn code(self) -> u8 {
        1 + self.response_cell() as u8
    }

    /// The central wavelength of a code, with the weight and pdf of the code; `None` for 0, which
    /// stands for all wavelengths.
    #[must_use]
    pub fn from_byte_code(code: u8) -> Option<Self> {
        let step = code.checked_sub(1)?;
        Some(Self(SHORTEST + (f32::from(step) + 0.5) * STEP))
    }

    fn response_cell(self) -> usize {
        ((self.0 - SHORTEST) / STEP).min(CELLS as f32 - 1.0) as usize
    }
}

struct ResponseTable {
    /// Cumulative probability at the lower edge of each cell, and 1 at the end.
    sums: [f64; CELLS + 1],
    /// Pdf in each cell \[1/nm].
    pdfs: [f32; CELLS],
    /// Weight in each cell.
    weights: [Rgb; CELLS],
}

static RESPONSE_TABLE: LazyLock<ResponseTable> = LazyLock::new(|| {
    let center = |response_cell: usize| f64::from(SHORTEST) + (response_cell as f64 + 0.5) * f64::from(STEP);
    let responses: [DVec3; CELLS] =
        std::array::from_fn(|response_cell| add_white_until_nonnegative(color_matching_rgb(center(response_cell))));
    let total: DVec3 = responses.iter().sum();
    let mut table = ResponseTable { sums: [0.0; CELLS + 1], pdfs: [0.0; CELLS], weights: [Rgb::ZERO; CELLS] };
    for (response_cell, response) in responses.iter().enumerate() {
        let response = response / total;
        let density = response.element_sum() / 3.0;
        table.sums[response_cell + 1] = table.sums[response_cell] + density;
        table.pdfs[response_cell] = (density / f64::from(STEP)) as f32;
        table.weights[response_cell] = (response / density).as_vec3();
    }
    table
});

/// Linear RGB with white added until no channel is negative.
fn add_white_until_nonnegative(rgb: DVec3) -> DVec3 {
    rgb - rgb.min_element().min(0.0)
}

/// Colour matching functions for linear RGB of Rec. 709 at a wavelength \[nm].
fn color_matching_rgb(nm: f64) -> DVec3 {
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
mod tests;
