//! Spectra of reflectance, emission and refractive indices, and their linear RGB values.
//!
//! The responses of the RGB channels are the CIE 1931 (2°) color matching functions in linear RGB
//! of Rec. 709. [`super::Wavelength`] uses the same functions, with white added.
//!
//! The color of a reflectance is its color under an equal-energy illuminant, scaled so that a
//! constant reflectance is gray. Paths with sampled wavelengths give the same gray. The color of an
//! emission has the luminance of its spectrum, and D65 is white.

use super::rgb::xyz_to_rgb;
use super::wavelength::color_matching_rgb;
use glam::DVec3;
use std::sync::LazyLock;

/// Shortest and longest wavelength over which spectra are integrated \[nm]. Beyond them, each RGB
/// color matching function is below 10⁻⁴ of its maximum.
const INTEGRATION_BAND_NM: [u32; 2] = [360, 830];

/// Constant 2hc² of Planck's law \[W m²/sr].
const FIRST_RADIATION_CONSTANT: f64 = 1.191_042_972e-16;

/// Constant hc/k of Planck's law \[m K]: the second radiation constant.
const SECOND_RADIATION_CONSTANT: f64 = 1.438_776_877e-2;

/// Wien's displacement constant \[m K]: the wavelength of a blackbody's peak times its temperature.
const WIEN_CONSTANT: f64 = 2.897_771_955e-3;

/// Bounds to which [`conductor_refractive_index`] clamps the reflectance at normal incidence. A
/// reflectance of 1 would need an infinite k.
const CONDUCTOR_REFLECTANCE_BOUNDS: [f64; 2] = [1e-4, 0.9999];

/// Least η (real part of the refractive index) that [`conductor_refractive_index`] returns.
const LEAST_ETA: f64 = 1e-4;

/// Components S₀ (the mean), S₁ and S₂ of CIE daylight spectra, from 380 nm in steps of 10 nm (CIE
/// 15).
const DAYLIGHT_COMPONENTS: [[f64; 41]; 3] = [
    [
        63.4, 65.8, 94.8, 104.8, 105.9, 96.8, 113.9, 125.6, 125.5, 121.3, 121.3, 113.5, 113.1, 110.8, 106.5, 108.8,
        105.3, 104.4, 100.0, 96.0, 95.1, 89.1, 90.5, 90.3, 88.4, 84.0, 85.1, 81.9, 82.6, 84.9, 81.3, 71.9, 74.3, 76.4,
        63.3, 71.7, 77.0, 65.2, 47.7, 68.6, 65.0,
    ],
    [
        38.5, 35.0, 43.4, 46.3, 43.9, 37.1, 36.7, 35.9, 32.6, 27.9, 24.3, 20.1, 16.2, 13.2, 8.6, 6.1, 4.2, 1.9, 0.0,
        -1.6, -3.5, -3.5, -5.8, -7.2, -8.6, -9.5, -10.9, -10.7, -12.0, -14.0, -13.6, -12.0, -13.3, -12.9, -10.6, -11.6,
        -12.2, -10.2, -7.8, -11.2, -10.4,
    ],
    [
        3.0, 1.2, -1.1, -0.5, -0.7, -1.2, -2.6, -2.9, -2.8, -2.6, -2.6, -1.8, -1.5, -1.3, -1.2, -1.0, -0.5, -0.3, 0.0,
        0.2, 0.5, 2.1, 3.2, 4.1, 4.7, 5.1, 6.7, 7.3, 8.6, 9.8, 10.2, 8.3, 9.6, 8.5, 7.0, 7.6, 8.0, 6.7, 5.2, 7.4, 6.8,
    ],
];

/// Chromaticities x and y of the fluorescent illuminants F1 to F12 (CIE 15).
const FLUORESCENT_CHROMATICITIES: [[f64; 2]; 12] = [
    [0.31310, 0.33727],
    [0.37208, 0.37529],
    [0.40910, 0.39430],
    [0.44018, 0.40329],
    [0.31379, 0.34531],
    [0.37790, 0.38835],
    [0.31292, 0.32933],
    [0.34588, 0.35875],
    [0.37417, 0.37281],
    [0.34609, 0.35986],
    [0.38052, 0.37713],
    [0.43695, 0.40441],
];

/// A tabulated function of wavelength: linear between samples, constant beyond the first and last.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Pairs of wavelength \[nm] and value, by increasing wavelength; at least one.
    samples: Vec<[f64; 2]>,
}

/// Color matching functions in linear RGB at the center of each nanometer of
/// [`INTEGRATION_BAND_NM`], and their sum over the band.
static RGB_RESPONSES_AND_SUM: LazyLock<(Vec<DVec3>, DVec3)> = LazyLock::new(|| {
    let responses: Vec<DVec3> = band_wavelengths_nm().map(color_matching_rgb).collect();
    let sum = responses.iter().sum();
    (responses, sum)
});

/// Luminance of the RGB color matching functions, summed over [`INTEGRATION_BAND_NM`] in steps of 1
/// nm \[nm].
static LUMINANCE_RESPONSE_SUM: LazyLock<f64> =
    LazyLock::new(|| RGB_RESPONSES_AND_SUM.0.iter().map(|rgb| luminance(*rgb)).sum());

fn band_wavelengths_nm() -> impl Iterator<Item = f64> {
    (INTEGRATION_BAND_NM[0]..INTEGRATION_BAND_NM[1]).map(|nm| f64::from(nm) + 0.5)
}

/// Luminance of a linear RGB color by the weights of Rec. 709.
fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

impl Spectrum {
    /// Returns the spectrum that has the same value at all wavelengths.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self { samples: vec![[550.0, value]] }
    }

    /// Returns the spectrum through pairs of wavelength \[nm] and value.
    ///
    /// Returns `None` if there is no pair, a number is not finite, or the wavelengths decrease. Two
    /// pairs of equal wavelength make a step: their values are the limits from below and from
    /// above.
    #[must_use]
    pub fn from_samples(samples: Vec<[f64; 2]>) -> Option<Self> {
        let is_finite = samples.iter().flatten().all(|number| number.is_finite());
        let is_sorted = samples.windows(2).all(|pair| pair[0][0] <= pair[1][0]);
        (!samples.is_empty() && is_finite && is_sorted).then_some(Self { samples })
    }

    /// Returns the spectral radiance of a blackbody by Planck's law \[W/(m² sr nm)].
    ///
    /// `kelvin` is the temperature, above 0. The samples cover 360 to 830 nm in steps of 1 nm.
    #[must_use]
    pub fn blackbody(kelvin: f64) -> Self {
        Self { samples: band_wavelengths_nm().map(|nm| [nm, planck(kelvin, nm)]).collect() }
    }

    /// Returns the spectrum of a blackbody, scaled to the maximum 1 over all wavelengths.
    ///
    /// `kelvin` is the temperature, above 0. The samples cover 360 to 830 nm in steps of 1 nm, so
    /// the maximum may lie outside of them.
    #[must_use]
    pub fn normalized_blackbody(kelvin: f64) -> Self {
        let peak = planck(kelvin, WIEN_CONSTANT / kelvin * 1e9);
        Self { samples: band_wavelengths_nm().map(|nm| [nm, planck(kelvin, nm) / peak]).collect() }
    }

    /// Returns the relative spectrum of CIE daylight with the correlated color temperature
    /// `kelvin`; the value at 560 nm is 1.
    ///
    /// The temperature is clamped to \[4000, 25000] K. D65 has 6504 K, and D50 has 5003 K.
    #[must_use]
    pub fn daylight(kelvin: f64) -> Self {
        let t = 1e3 / kelvin.clamp(4e3, 25e3);
        let x = if t >= 1.0 / 7.0 {
            0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
        } else {
            0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064))
        };
        let y = -3.0 * x * x + 2.870 * x - 0.275;
        let denominator = 0.0241 + 0.2562 * x - 0.7341 * y;
        let m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / denominator;
        let m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / denominator;
        let [s0, s1, s2] = DAYLIGHT_COMPONENTS;
        let value = |i: usize| (s0[i] + m1 * s1[i] + m2 * s2[i]) / 100.0;
        Self { samples: (0..s0.len()).map(|i| [380.0 + 10.0 * i as f64, value(i)]).collect() }
    }

    /// Returns the value at the wavelength `nm` \[nm].
    #[must_use]
    pub fn value(&self, nm: f64) -> f64 {
        let next = self.samples.partition_point(|sample| sample[0] < nm);
        match (next.checked_sub(1).map(|i| self.samples[i]), self.samples.get(next)) {
            (Some([start, first]), Some([end, second])) => first + (second - first) * ((nm - start) / (end - start)),
            (Some([_, value]), None) | (None, Some(&[_, value])) => value,
            (None, None) => 0.0,
        }
    }

    /// Returns the linear RGB color of a surface or filter with this spectrum, inside \[0, 1].
    ///
    /// A constant spectrum is gray. Colors outside the gamut are clamped.
    #[must_use]
    pub fn reflectance_rgb(&self) -> DVec3 {
        reflectance_rgb(|nm| self.value(nm))
    }

    /// Returns the linear RGB color of light with this spectrum, in the unit of the spectrum's
    /// values.
    ///
    /// The luminance of the color is the mean of the spectrum's values, weighted by the luminous
    /// efficiency. D65 is white, and a constant spectrum is slightly red. Negative channels become
    /// 0.
    #[must_use]
    pub fn radiance_rgb(&self) -> DVec3 {
        let sum: DVec3 = RGB_RESPONSES_AND_SUM
            .0
            .iter()
            .zip(band_wavelengths_nm())
            .map(|(response, nm)| *response * self.value(nm))
            .sum();
        (sum / *LUMINANCE_RESPONSE_SUM).max(DVec3::ZERO)
    }

    /// Returns the linear RGB color of light with this spectrum, scaled to luminance 1; white for a
    /// spectrum without luminance.
    #[must_use]
    pub fn normalized_radiance_rgb(&self) -> DVec3 {
        let rgb = self.radiance_rgb();
        if luminance(rgb) > 0.0 { rgb / luminance(rgb) } else { DVec3::ONE }
    }

    /// Returns the mean of the spectrum for each RGB channel, weighted by the positive part of the
    /// channel's color matching function.
    ///
    /// Use this for quantities that are not colors, such as refractive indices and absorption
    /// coefficients: each mean lies between the least and the greatest value.
    #[must_use]
    pub fn channel_means(&self) -> DVec3 {
        let (mut sum, mut weights) = (DVec3::ZERO, DVec3::ZERO);
        for (response, nm) in RGB_RESPONSES_AND_SUM.0.iter().zip(band_wavelengths_nm()) {
            let weight = response.max(DVec3::ZERO);
            sum += weight * self.value(nm);
            weights += weight;
        }
        sum / weights
    }
}

/// Returns the spectral radiance of a blackbody \[W/(m² sr nm)] at `nm` nanometers.
fn planck(kelvin: f64, nm: f64) -> f64 {
    let meters = nm * 1e-9;
    let exponent = SECOND_RADIATION_CONSTANT / (meters * kelvin);
    1e-9 * FIRST_RADIATION_CONSTANT / (libm::pow(meters, 5.0) * libm::expm1(exponent))
}

/// Returns the linear RGB color, inside \[0, 1], of a reflectance that is a function of wavelength
/// \[nm].
fn reflectance_rgb(reflectance: impl Fn(f64) -> f64) -> DVec3 {
    let (responses, total) = &*RGB_RESPONSES_AND_SUM;
    let sum: DVec3 =
        responses.iter().zip(band_wavelengths_nm()).map(|(response, nm)| *response * reflectance(nm)).sum();
    (sum / *total).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Returns the RGB refractive index (η, k) of a conductor from the spectra of η and k.
///
/// At normal incidence, a conductor with this index has the RGB color of the spectral reflectance.
/// Each channel of the color is clamped to \[10⁻⁴, 0.9999]. η is the mean of `eta` by
/// [`Spectrum::channel_means`], clamped to the range in which some k gives this color. k follows
/// from the color and η.
#[must_use]
pub fn conductor_refractive_index(eta: &Spectrum, k: &Spectrum) -> (DVec3, DVec3) {
    let reflectance = reflectance_rgb(|nm| {
        let (eta, k) = (eta.value(nm), k.value(nm));
        ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
    });
    let [least, greatest] = CONDUCTOR_REFLECTANCE_BOUNDS.map(DVec3::splat);
    let r = reflectance.clamp(least, greatest);
    let root = r.map(f64::sqrt);
    // With η outside of these bounds, no k ≥ 0 gives the reflectance r.
    let (low, high) = ((1.0 - root) / (1.0 + root), (1.0 + root) / (1.0 - root));
    let eta = eta.channel_means().clamp(low.max(DVec3::splat(LEAST_ETA)), high);
    let squared = (r * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - r);
    (eta, squared.max(DVec3::ZERO).map(f64::sqrt))
}

/// Returns the linear RGB color, of luminance 1, of the CIE standard illuminant `name`.
///
/// Names are `A`, `D50`, `D55`, `D65`, `D75`, `E`, and `F1` to `F12`; other names give `None`.
#[must_use]
pub fn illuminant_rgb(name: &str) -> Option<DVec3> {
    let spectrum = match name {
        // Illuminant A is a blackbody of 2848 K by definition, with the second radiation constant
        // of 1931.
        "A" => Spectrum::blackbody(2848.0 * SECOND_RADIATION_CONSTANT / 1.435e-2),
        "D50" => Spectrum::daylight(5003.0),
        "D55" => Spectrum::daylight(5503.0),
        "D65" => return Some(DVec3::ONE),
        "D75" => Spectrum::daylight(7504.0),
        "E" => Spectrum::constant(1.0),
        _ => {
            let number: usize = name.strip_prefix('F')?.parse().ok()?;
            let [x, y] = *FLUORESCENT_CHROMATICITIES.get(number.checked_sub(1)?)?;
            return Some(xyz_to_rgb(DVec3::new(x / y, 1.0, (1.0 - x - y) / y)).max(DVec3::ZERO));
        }
    };
    Some(spectrum.normalized_radiance_rgb())
}

#[cfg(test)]
mod tests;
