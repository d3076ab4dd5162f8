//! Tests of sampled wavelengths.

use super::*;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

fn wavelength_of_nanometres(nm: f32) -> Wavelength {
    Wavelength(nm)
}

/// Returns the hue of a color in degrees from −90 to 270; red is 0, green 120, blue 240.
fn hue_degrees(c: Rgb) -> f32 {
    let angle = libm::atan2f(3.0f32.sqrt() * (c.y - c.z), 2.0 * c.x - c.y - c.z).to_degrees();
    if angle < -90.0 { angle + 360.0 } else { angle }
}

/// Averages the weight over all wavelengths: the mean is white.
///
/// For n points, the error of the midpoint rule is at most V/(2n). V is the total variation of the
/// weight, which is below 20.
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
fn wavelength_weights_and_pdf_are_normalized() {
    let mut integral = 0.0;
    for cell in 0..RESPONSE_INTERVAL_COUNT {
        let w = wavelength_of_nanometres(Wavelength::SHORTEST_NM + (cell as f32 + 0.5) * RESPONSE_INTERVAL_NM);
        assert!((w.weight().element_sum() / 3.0 - 1.0).abs() < 1e-6 && w.weight().min_element() >= 0.0);
        assert!(w.pdf() > 0.0 && w == wavelength_of_nanometres(w.nanometres()));
        integral += f64::from(w.pdf()) * f64::from(RESPONSE_INTERVAL_NM);
    }
    // The tolerance allows for the rounding of the 255 pdfs to f32.
    assert!(
        (integral - 1.0).abs() < 6e-8
            && (RESPONSE_TABLE.cumulative_probabilities[RESPONSE_INTERVAL_COUNT] - 1.0).abs() < 1e-12,
        "{integral}"
    );
}

#[test]
fn wavelength_hues_follow_the_spectrum() {
    let (red, yellow, green, blue) = (
        wavelength_of_nanometres(650.0),
        wavelength_of_nanometres(580.0),
        wavelength_of_nanometres(530.0),
        wavelength_of_nanometres(450.0),
    );
    assert!(red.weight().x > 2.4, "{}", red.weight());
    assert!(yellow.weight().x.min(yellow.weight().y) > 2.0 * yellow.weight().z, "{}", yellow.weight());
    assert!(green.weight().y > 1.8, "{}", green.weight());
    assert!(blue.weight().z > 2.2, "{}", blue.weight());
    // Hues must decrease from 440 to 640 nm. Beyond these limits, spectral colors hardly change,
    // and the fitted hue varies by a few degrees.
    let cells = wavelength_of_nanometres(440.0).response_interval_index()
        ..=wavelength_of_nanometres(640.0).response_interval_index();
    let hues: Vec<f32> = cells.map(|cell| hue_degrees(RESPONSE_TABLE.weights[cell])).collect();
    assert!(hues.windows(2).all(|pair| pair[0] > pair[1]), "{hues:?}");
    for nm in 400..440 {
        assert!((hue_degrees(wavelength_of_nanometres(nm as f32).weight()) - 250.0).abs() < 10.0, "{nm}");
    }
    for nm in 640..690 {
        assert!(hue_degrees(wavelength_of_nanometres(nm as f32).weight()).abs() < 10.0, "{nm}");
    }
    let beyond = RESPONSE_TABLE.cumulative_probabilities[wavelength_of_nanometres(690.0).response_interval_index()];
    assert!(beyond > 0.999, "{beyond}");
}

/// Applies a chi-square test to a million sampled wavelengths; its false-alarm rate is 10⁻⁴.
#[test]
fn wavelength_samples_follow_the_pdf() {
    let n = 1_000_000u32;
    let mut rng = SmallRng::seed_from_u64(11);
    let mut counts = [0u32; RESPONSE_INTERVAL_COUNT];
    for _ in 0..n {
        counts[Wavelength::sample(rng.random()).response_interval_index()] += 1;
    }
    // Neighboring intervals are pooled until they expect 20 samples, so that counts are nearly
    // normal.
    let (mut chi2, mut nu) = (0.0, -1.0);
    let (mut count, mut expected) = (0.0, 0.0);
    for (cell, c) in counts.iter().enumerate() {
        count += f64::from(*c);
        expected += f64::from(n) * f64::from(RESPONSE_TABLE.pdfs[cell]) * f64::from(RESPONSE_INTERVAL_NM);
        if expected >= 20.0 {
            chi2 += (count - expected) * (count - expected) / expected;
            nu += 1.0;
            (count, expected) = (0.0, 0.0);
        }
    }
    // Wilson–Hilferty: the cube root of χ²/ν is normal with mean 1 − 2/(9ν) and variance 2/(9ν).
    let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
    assert!(nu > 190.0 && z.abs() < 3.9, "z = {z}, nu = {nu}");
}

#[test]
fn extreme_random_numbers_give_wavelengths_in_range() {
    let last = Wavelength::sample(1.0 - f32::EPSILON / 2.0);
    assert_eq!(Wavelength::sample(0.0).response_interval_index(), 0);
    assert!(last.nanometres() < 720.0 && last.nanometres() > 700.0, "{last:?}");
    assert_eq!(
        last.response_interval_index(),
        ((last.nanometres() - Wavelength::SHORTEST_NM) / RESPONSE_INTERVAL_NM) as usize
    );
}

#[test]
fn wavelength_byte_codes_round_trip() {
    assert_eq!(Wavelength::from_byte_code(0), None);
    for i in 0..=3400 {
        let w = wavelength_of_nanometres(Wavelength::SHORTEST_NM + i as f32 * 0.1);
        let back = Wavelength::from_byte_code(w.byte_code()).unwrap();
        // The largest error is half an interval of 340/255 nm, plus rounding to f32.
        assert!((back.nanometres() - w.nanometres()).abs() < 0.667, "{w:?} {back:?}");
        assert_eq!((back.weight(), back.pdf()), (w.weight(), w.pdf()));
    }
    for code in 1..=255 {
        assert_eq!(Wavelength::from_byte_code(code).map(Wavelength::byte_code), Some(code));
    }
}
