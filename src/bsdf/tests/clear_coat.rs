//! Tests of clear coats: energy, and the selection of coat or base.

use super::super::coat_albedo::mean_fresnel_reflectance;
use super::rough::mean_sample_weights;
use super::*;

/// Mean weights of samples of the coat alone and of the surface under it.
fn coat_and_base_albedos(bsdf: Bsdf, wo: Vec3) -> (f64, f64) {
    (mean_sample_weights(&bsdf.separate_coat().unwrap(), wo).0, mean_sample_weights(&bsdf, wo).0)
}

/// With a smooth coat of Fresnel reflectance F over a white base, the albedo for light along the
/// normal is 1 over a mirror.
///
/// Over a diffuse base it is 1 + F − mean F, since F is least along the normal.
#[test]
fn clear_coats_over_white_bases_have_closed_form_albedos() {
    let coat = ClearCoat::new(1.0, 0.0);
    let mirror = coat.over(Bsdf::Conductor(Conductor::new(Rgb::ZERO, Rgb::ONE, 0.0, Single)));
    for cos in [1.0, 0.6, 0.1] {
        let (coat, base) = coat_and_base_albedos(mirror, direction_with_cos(cos));
        assert!((coat + base - 1.0).abs() < 1e-5, "{cos}: {coat} + {base}");
    }
    let (coat, base) = coat_and_base_albedos(coat.over(Bsdf::Diffuse(Rgb::ONE)), Vec3::Z);
    let expected = 1.0 + 0.04 - mean_fresnel_reflectance(1.5);
    assert!((coat + base - expected).abs() < 1e-3, "{coat} + {base}, not {expected}");
}

/// White surfaces under clear coats gain no light, and lose at most 8 %.
#[test]
fn clear_coats_gain_no_energy_and_lose_little() {
    let metal = |alpha| Bsdf::Conductor(Conductor::new(Rgb::ZERO, Rgb::ONE, alpha, Multiple));
    for base in [Bsdf::Diffuse(Rgb::ONE), metal(0.2), metal(0.6)] {
        for (coverage, alpha) in [(1.0, 0.0), (0.25, 0.05), (1.0, 0.2), (0.7, 0.6)] {
            let bsdf = ClearCoat::new(coverage, alpha).over(base);
            for cos in [1.0, 0.7, 0.3, 0.1] {
                let (coat, base) = coat_and_base_albedos(bsdf, direction_with_cos(cos));
                // The upper bound allows the errors of the tables of rough coats and rough metal.
                assert!((0.92..1.012).contains(&(coat + base)), "{bsdf:?} at {cos}: {coat} + {base}");
            }
        }
    }
}

/// The mean over `u` of the selected BSDFs is the sum of all layers.
#[test]
fn selected_layers_add_up_to_coat_and_base() {
    let n = 4096;
    let (wi, scale) = (Vec3::new(-0.6, 0.1, 0.7).normalize(), 1.0 / n as f32);
    for (bsdf, _) in clear_coated_bsdfs() {
        for cos in [1.0, 0.4, 0.05] {
            let wo = direction_with_cos(cos);
            let f = |bsdf: Bsdf| bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Radiance);
            let mut mean = Rgb::ZERO;
            for i in 0..n {
                let selected = bsdf.select_layer(wo, Vec3::Z, (i as f32 + 0.5) * scale);
                assert!(selected.stores_photons() != selected.casts_caustics());
                mean += f(selected) * scale;
            }
            // Under the clear coat, a coat with a BSDF of its own is attenuated like its base.
            let base = bsdf.under_coat().unwrap();
            let inner = base.separate_coat().map_or(Rgb::ZERO, f) * (f(bsdf) / f(base));
            let expected = f(bsdf) + inner + f(bsdf.separate_coat().unwrap());
            // At the boundaries between layers, a few values of `u` may select either.
            assert!(
                (mean - expected).abs().max_element() < 3e-3 * expected.max_element(),
                "{bsdf:?}: {mean} {expected}"
            );
        }
    }
}

/// A random number of 1, which rounding can give, does not select a coat that covers nothing.
#[test]
fn coats_without_coverage_are_never_selected() {
    let surface = ClearCoat::new(0.0, 0.0).over(Bsdf::Diffuse(Rgb::ONE));
    for u in [0.0, 0.5, 1.0] {
        assert_eq!(surface.select_layer(Vec3::Z, Vec3::Z, u), surface);
    }
}
