use super::*;

fn quantized_level(curve: ToneCurve, stops: f32, c: f32) -> u16 {
    let quantizer = Quantizer::new(ToneMap { curve, exposure_stops: stops }, 255).unwrap();
    quantizer.quantize_pixel(Vec3::splat(c), &mut ClippedPixelReport::default())[1]
}

#[test]
fn srgb_levels_are_the_nearest() {
    // 255 · (1.055 · 0.5^(1/2.4) − 0.055) = 187.516, which truncation would make 187.
    assert_eq!(quantized_level(ToneCurve::Srgb, 0.0, 0.5), 188);
    // The sRGB curve is linear near black: 0.002 · 12.92 · 255 = 6.589.
    assert_eq!(quantized_level(ToneCurve::Srgb, 0.0, 0.002), 7);
    assert_eq!([-1.0, 0.0, 1.0, 9.0].map(|c| quantized_level(ToneCurve::Srgb, 0.0, c)), [0, 0, 255, 255]);
}

#[test]
fn every_srgb_byte_survives_decoding_and_encoding() {
    for byte in 0..=255_u16 {
        assert_eq!(quantized_level(ToneCurve::Srgb, 0.0, srgb_decode(f64::from(byte) / 255.0) as f32), byte);
    }
}

#[test]
fn exposure_is_in_stops() {
    assert_eq!(quantized_level(ToneCurve::Srgb, 2.0, 0.125), quantized_level(ToneCurve::Srgb, 0.0, 0.5));
    assert_eq!(quantized_level(ToneCurve::Legacy, -1.0, 1.0), 127);
    for stops in [f32::NAN, f32::INFINITY, -64.5] {
        assert!(Quantizer::new(ToneMap { curve: ToneCurve::Srgb, exposure_stops: stops }, 255).is_err());
    }
}

#[test]
fn legacy_curve_truncates_without_gamma() {
    // 255 · .5 = 127.5 and 255 · .999 = 254.7 both lose their fraction.
    assert_eq!(
        [0.5, 0.999, 1.0, -3.0, 7.0].map(|c| quantized_level(ToneCurve::Legacy, 0.0, c)),
        [127, 254, 255, 0, 255]
    );
}

#[test]
fn filmic_follows_the_published_fit() {
    // The curve at x = 1 is 2.54 / 3.16 = 0.803797.
    assert!((filmic_curve(1.0) - 2.54 / 3.16).abs() < 1e-15);
    // The curve reaches 1 at the larger root of .08x² − .56x − .14.
    let white = (0.56 + f64::sqrt(0.56 * 0.56 + 4.0 * 0.08 * 0.14)) / 0.16;
    assert!((filmic_curve(white) - 1.0).abs() < 1e-12);
    // The sRGB signal of 0.803797 is 0.908046, which is level 231.55 of 255.
    assert_eq!(quantized_level(ToneCurve::Filmic, 0.0, 1.0), 232);
    assert_eq!(
        [f32::INFINITY, f32::MAX, -2.0, 0.0].map(|c| quantized_level(ToneCurve::Filmic, 9.0, c)),
        [255, 255, 0, 0]
    );
}

#[test]
fn clipped_pixels_count_once_per_report_field() {
    let quantizer = Quantizer::new(ToneMap { curve: ToneCurve::Srgb, exposure_stops: 60.0 }, 255).unwrap();
    let mut report = ClippedPixelReport::default();
    quantizer.quantize_pixel(Vec3::new(f32::NAN, f32::INFINITY, -1.0), &mut report);
    assert_eq!(report, ClippedPixelReport { non_finite: 1, too_bright: 0, negative: 0 });
    // 10³⁰ · 2⁶⁰ overflows f32, but the pixel itself is finite.
    quantizer.quantize_pixel(Vec3::new(1e30, 1e30, -1.0), &mut report);
    assert_eq!(report, ClippedPixelReport { non_finite: 1, too_bright: 1, negative: 1 });
}

#[test]
fn white_itself_is_not_too_bright() {
    for (curve, white) in [(ToneCurve::Srgb, 1.0), (ToneCurve::Legacy, 1.0), (ToneCurve::Filmic, 7.24)] {
        let quantizer = Quantizer::new(ToneMap { curve, exposure_stops: 0.0 }, 255).unwrap();
        let count = |c: f32| {
            let mut report = ClippedPixelReport::default();
            quantizer.quantize_pixel(Vec3::new(0.0, c, 0.0), &mut report);
            report.too_bright
        };
        assert_eq!((count(white), count(white * 1.001)), (0, 1), "{curve}");
    }
}

#[test]
fn tone_curves_are_found_by_name() {
    for curve in ToneCurve::ALL {
        assert_eq!(curve.name().parse::<ToneCurve>(), Ok(curve));
    }
    let message = "gamma".parse::<ToneCurve>().unwrap_err().to_string();
    assert!(message.contains("`gamma`") && ToneCurve::ALL.iter().all(|c| message.contains(c.name())), "{message}");
}
