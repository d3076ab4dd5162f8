//! Tests of light that microfacets scatter more than once: energy, color, and weak interfaces.

use super::rough::mean_sample_weights;
use super::*;

/// Roughnesses from the narrowest lobe to the widest, some between the nodes of the tables.
const ALPHAS: [f32; 9] = [MIN_ROUGH_ALPHA, 0.004, 0.02, 0.07, 0.15, 0.2, 0.37, 0.7, 1.0];

/// Cosines of incidence from the normal to near the horizon.
const COSINES: [f32; 8] = [1.0, 0.9, 0.7, 0.5, 0.3, 0.15, 0.06, 0.01];

/// Largest error of the reflected and transmitted energy, which comes from interpolation in the
/// tables.
const TOLERANCE: f64 = 0.01;

#[test]
fn white_rough_metal_keeps_all_light() {
    for alpha in ALPHAS {
        let white = Bsdf::Conductor(Conductor::new(Rgb::ZERO, Rgb::ONE, alpha, Multiple));
        for cos in COSINES {
            let (reflected, _) = mean_sample_weights(&white, direction_with_cos(cos));
            assert!((reflected - 1.0).abs() < TOLERANCE, "{alpha} at {cos}: {reflected}");
        }
    }
}

#[test]
fn rough_dielectrics_keep_all_light() {
    for alpha in ALPHAS.into_iter().skip(1).step_by(2).chain([1.0]) {
        for eta in [1.1, 1.5, 1.0 / 2.4] {
            let glass = Bsdf::dielectric(eta, alpha, Multiple);
            for cos in COSINES.into_iter().step_by(2).flat_map(|cos| [cos, -cos]) {
                let (reflected, transmitted) = mean_sample_weights(&glass, direction_with_cos(cos));
                let sum = reflected + transmitted;
                assert!((sum - 1.0).abs() < TOLERANCE, "{eta}, {alpha} at {cos}: {reflected} + {transmitted}");
            }
        }
    }
}

/// Reflections between microfacets make metal more saturated in color, and it still reflects less
/// than white metal.
///
/// The added light equals an independent series. Each reflection multiplies light by the
/// reflectance. After it, the lost fraction of diffuse light meets another microfacet.
#[test]
fn multiple_reflections_deepen_colors() {
    let (eta, k) = metal_refractive_index("copper").unwrap();
    let metal = |scattering| Conductor::new(eta, k, 0.8, scattering);
    let wo = direction_with_cos(0.8);
    let albedo = |scattering| {
        let n = 200_000u64;
        let bsdf = Bsdf::Conductor(metal(scattering));
        let weights = (0..n).filter_map(|i| sample_bsdf(&bsdf, wo, i, TransportMode::Importance));
        weights.fold(Rgb::ZERO, |sum, sample| sum + sample.weight) / n as f32
    };
    let (single, multiple) = (albedo(Single), albedo(Multiple));
    let added = multiple - single;
    assert!(added.min_element() > 0.0 && multiple.max_element() < 1.0, "{single} {multiple}");
    // Blue is reflected less than red at each reflection. So the added light, with two or more
    // reflections, is redder than light with one.
    assert!(added.z / added.x < 0.95 * single.z / single.x, "{single} {added}");
    let mean = conductor_reflectance(2.0 / 3.0, eta, k);
    let white = Bsdf::Conductor(Conductor::new(Rgb::ZERO, Rgb::ONE, 0.8, Single));
    let lost = |cos: f32| 1.0 - mean_sample_weights(&white, direction_with_cos(cos)).0 as f32;
    let steps = 16;
    let lost_mean = (0..steps).map(|i| lost(((i as f32 + 0.5) / steps as f32).sqrt())).sum::<f32>() / steps as f32;
    let mut series = Rgb::ZERO;
    let mut going_on = mean * lost(0.8);
    for _ in 0..200 {
        series += going_on * mean * (1.0 - lost_mean);
        going_on *= mean * lost_mean;
    }
    assert!((series - added).abs().max_element() < 0.01, "{series} {added}");
}

/// An interface that hardly refracts reflects hardly any light, at each roughness.
#[test]
fn weak_interfaces_reflect_almost_no_light() {
    for alpha in [0.2, 1.0] {
        let (reflected, transmitted) =
            mean_sample_weights(&Bsdf::dielectric(1.0005, alpha, Multiple), direction_with_cos(0.6));
        assert!(reflected < 0.01 && (reflected + transmitted - 1.0).abs() < TOLERANCE, "{alpha}: {reflected}");
    }
}
