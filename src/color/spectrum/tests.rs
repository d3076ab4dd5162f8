//! Tests of spectra: closed forms, standard illuminants, and metals.

use super::*;

/// Returns x and y of the chromaticity of a linear RGB color.
fn chromaticity(rgb: DVec3) -> [f64; 2] {
    let x = rgb.dot(DVec3::new(0.4124564, 0.3575761, 0.1804375));
    let y = rgb.dot(DVec3::new(0.2126729, 0.7151522, 0.0721750));
    let z = rgb.dot(DVec3::new(0.0193339, 0.1191920, 0.9503041));
    [x / (x + y + z), y / (x + y + z)]
}

#[test]
fn values_are_linear_between_samples() {
    let spectrum = Spectrum::from_samples(vec![[400.0, 1.0], [500.0, 3.0], [500.0, 7.0], [600.0, 5.0]]).unwrap();
    let values = [300.0, 400.0, 425.0, 500.0, 550.0, 600.0, 900.0].map(|nm| spectrum.value(nm));
    assert_eq!(values, [1.0, 1.0, 1.5, 3.0, 6.0, 5.0, 5.0]);
    assert_eq!(Spectrum::from_samples(Vec::new()), None);
    assert_eq!(Spectrum::from_samples(vec![[500.0, 1.0], [400.0, 1.0]]), None);
    assert_eq!(Spectrum::from_samples(vec![[500.0, f64::NAN]]), None);
}

#[test]
fn constant_reflectances_are_gray() {
    for gray in [0.0, 0.25, 1.0] {
        let spectrum = Spectrum::constant(gray);
        assert!((spectrum.reflectance_rgb() - gray).abs().max_element() < 1e-12);
        assert!((spectrum.channel_means() - gray).abs().max_element() < 1e-12);
    }
    let red = Spectrum::from_samples(vec![[590.0, 0.05], [600.0, 0.8]]).unwrap().reflectance_rgb();
    assert!(red.x > 0.6 && red.y < 0.1 && red.z < 0.06, "{red}");
}

/// The integral of Planck's law over all wavelengths is σT⁴/π (Stefan and Boltzmann).
#[test]
fn blackbodies_obey_stefan_and_boltzmann() {
    for kelvin in [1000.0, 3000.0, 6500.0] {
        let peak = WIEN_CONSTANT / kelvin * 1e9;
        let step = peak / 500.0;
        let sum: f64 = (0..200_000).map(|i| step * planck(kelvin, (f64::from(i) + 0.5) * step)).sum();
        let expected = 5.670_374_419e-8 * libm::pow(kelvin, 4.0) / std::f64::consts::PI;
        // The spectrum beyond 400 times the wavelength of its peak has less than 10⁻⁶ of the
        // integral.
        assert!((sum / expected - 1.0).abs() < 2e-6, "{kelvin}: {sum} {expected}");
        let normalized = Spectrum::normalized_blackbody(kelvin);
        let ratio = Spectrum::blackbody(kelvin).value(600.0) / normalized.value(600.0);
        assert!((ratio / planck(kelvin, peak) - 1.0).abs() < 1e-12);
    }
}

/// Chromaticities of illuminants agree with the tables of CIE 15.
///
/// The fit of the color matching functions has errors up to 0.003 in x and y.
#[test]
fn illuminants_have_their_published_chromaticities() {
    let known = [("A", [0.44757, 0.40745]), ("D50", [0.34567, 0.35850]), ("D75", [0.29902, 0.31485])];
    for (name, expected) in known.into_iter().chain([("E", [1.0 / 3.0; 2]), ("F2", [0.37208, 0.37529])]) {
        let rgb = illuminant_rgb(name).unwrap();
        let found = chromaticity(rgb);
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 0.004), "{name}: {found:?}");
        assert!((luminance(rgb) - 1.0).abs() < 1e-3, "{name}: {rgb}");
    }
    let d65 = Spectrum::daylight(6504.0).normalized_radiance_rgb();
    assert!((d65 - 1.0).abs().max_element() < 0.02, "{d65}");
    assert_eq!(illuminant_rgb("F13"), None);
    assert_eq!(illuminant_rgb("F0"), None);
    assert_eq!(illuminant_rgb("moon"), None);
}

#[test]
fn conductors_keep_their_color_at_normal_incidence() {
    // Brass (70 % copper): Querry 1985, from refractiveindex.info.
    let eta = [1.445, 1.094, 0.686, 0.527, 0.450, 0.444, 0.446];
    let k = [1.805, 1.829, 2.250, 2.765, 3.253, 3.695, 4.106];
    let samples = |values: [f64; 7]| (0..7).map(|i| [400.0 + 50.0 * i as f64, values[i]]).collect();
    let (eta, k) = (Spectrum::from_samples(samples(eta)).unwrap(), Spectrum::from_samples(samples(k)).unwrap());
    let reflectance = |n: f64, k: f64| ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
    let expected = super::reflectance_rgb(|nm| reflectance(eta.value(nm), k.value(nm)));
    let (e, k) = conductor_refractive_index(&eta, &k);
    for i in 0..3 {
        assert!((reflectance(e[i], k[i]) - expected[i]).abs() < 1e-9, "{i}");
        assert!(e[i] > 0.4 && e[i] < 1.5);
    }
    assert!(expected.x > expected.y && expected.y > expected.z);
    // The index of a perfect mirror and of a surface that reflects nothing is finite.
    for (eta, k) in [(0.0, 1e30), (1.0, 0.0), (1e30, 0.0)] {
        let (eta, k) = conductor_refractive_index(&Spectrum::constant(eta), &Spectrum::constant(k));
        assert!(eta.is_finite() && k.is_finite() && eta.min_element() > 0.0, "{eta} {k}");
    }
}
