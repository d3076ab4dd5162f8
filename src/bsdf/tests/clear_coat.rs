//! Tests of clear coats: energy, and the selection of coat or base.

use super::super::coat_albedo::{coat_albedo, mean_fresnel_reflectance};
use super::rough::mean_sample_weights;
use super::*;
use glam::DVec3;

/// Largest error of the mean weight of samples of a diffuse surface under a coat.
///
/// The weight is between 0 and 1, and never grows with the angle from the normal. The samples lie
/// on 128 rings around the normal. A ring holds at most 1/64 of the samples.
const LATTICE_ERROR: f64 = 1.0 / 64.0;

/// Mean weights of samples of the coat alone and of the surface under it.
fn coat_and_base_albedos(bsdf: Bsdf, wo: Vec3) -> (f64, f64) {
    (mean_sample_weights(&bsdf.coat_if_separate().unwrap(), wo).0, mean_sample_weights(&bsdf, wo).0)
}

/// Over a mirror, a smooth coat and its base together have albedo 1 at each angle.
///
/// Over a white diffuse base, their albedo for light along the normal is 1 + F − mean F, where F is
/// the coat's Fresnel reflectance along the normal.
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
    assert!((coat + base - expected).abs() < LATTICE_ERROR, "{coat} + {base}, not {expected}");
}

/// A sample of a white diffuse surface under a coat of albedo c has the weight 1 − max(c(wo),
/// c(wi)).
#[test]
fn diffuse_samples_under_coats_have_formula_weights() {
    for (coverage, alpha) in [(1.0, 0.0), (0.25, 0.05), (1.0, 0.2), (0.7, 0.6)] {
        let bsdf = ClearCoat::new(coverage, alpha).over(Bsdf::Diffuse(Rgb::ONE));
        let albedo = |cos: f32| coverage * coat_albedo(cos, 1.5, alpha);
        for cos in [1.0, 0.7, 0.3, 0.1] {
            for u in [0.1, 0.3, 0.5, 0.7, 0.9].map(|x| Vec2::new(x, 0.4)) {
                let wo = direction_with_cos(cos);
                let sample = bsdf.sample(wo, Vec3::Z, Vec3::Z, 0.5, u, TransportMode::Radiance).unwrap();
                let expected = 1.0 - albedo(cos).max(albedo(sample.wi.z));
                // Coverage and roughness are rounded to multiples of 1/65,535.
                assert!((sample.weight.x - expected).abs() < 1e-4, "{bsdf:?} at {cos}: {sample:?}, not {expected}");
            }
        }
    }
}

/// White metals under clear coats gain no light beyond the errors of the tables: 0.015 for the
/// albedo of a rough coat, and 0.01 for the light between the microfacets of rough metal.
#[test]
fn white_metals_gain_no_light_under_clear_coats() {
    for base in [0.2, 0.6].map(|alpha| Bsdf::Conductor(Conductor::new(Rgb::ZERO, Rgb::ONE, alpha, Multiple))) {
        for (coverage, alpha) in [(1.0, 0.0), (0.25, 0.05), (1.0, 0.2), (0.7, 0.6)] {
            let bsdf = ClearCoat::new(coverage, alpha).over(base);
            for cos in [1.0, 0.7, 0.3, 0.1] {
                let (coat, base) = coat_and_base_albedos(bsdf, direction_with_cos(cos));
                assert!(coat + base < 1.025, "{bsdf:?} at {cos}: {coat} + {base}");
            }
        }
    }
}

/// The mean over `u` of the BSDFs that `select_layer` returns is the sum of all layers.
#[test]
fn selected_layers_add_up_to_coat_and_base() {
    let n = 4096;
    let wi = Vec3::new(-0.6, 0.1, 0.7).normalize();
    for (bsdf, _) in clear_coated_bsdfs() {
        for cos in [1.0, 0.4, 0.05] {
            let wo = direction_with_cos(cos);
            let f = |bsdf: Bsdf| bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Radiance).as_dvec3();
            let (mut mean, mut largest) = (DVec3::ZERO, 0f64);
            for i in 0..n {
                let selected = bsdf.select_layer(wo, Vec3::Z, (i as f32 + 0.5) / n as f32);
                assert!(selected.stores_photons() != selected.casts_caustics());
                let value = f(selected);
                largest = largest.max(value.max_element());
                mean += value / f64::from(n);
            }
            // The clear coat attenuates a separate inner coat as it attenuates the base.
            let base = bsdf.base_under_clear_coat().unwrap();
            let inner = base.coat_if_separate().map_or(DVec3::ZERO, f) * (f(bsdf) / f(base));
            let expected = f(bsdf) + inner + f(bsdf.coat_if_separate().unwrap());
            // The first term is the error of the sum over `u`: at most half a step at each of the
            // two boundaries between layers. The second term covers rounding to f32.
            let tolerance = largest / f64::from(n) + 1e-5 * expected.max_element();
            let error = (mean - expected).abs().max_element();
            assert!(error < tolerance, "{bsdf:?}: {mean} {expected}, {error} of {tolerance}");
        }
    }
}

/// A random number of 1, which can result from rounding, never selects a coat of coverage 0.
#[test]
fn coats_without_coverage_are_never_selected() {
    let surface = ClearCoat::new(0.0, 0.0).over(Bsdf::Diffuse(Rgb::ONE));
    for u in [0.0, 0.5, 1.0] {
        assert_eq!(surface.select_layer(Vec3::Z, Vec3::Z, u), surface);
    }
}
