//! Tests of photon storage and caustics by kind of BSDF, of thin sheets, and of interfaces that
//! barely refract.

use super::*;

/// BSDFs of each kind that scatters light, with roughnesses around the limit of photon storage.
fn representative_bsdfs() -> Vec<Bsdf> {
    let (eta, k) = metal_refractive_index("nickel").unwrap();
    let mut family = basic_bsdfs().to_vec();
    family.extend(
        [0.0, 0.05, MIN_PHOTON_STORAGE_ALPHA, 0.31, 1.0].map(|a| Bsdf::Conductor(Conductor::new(eta, k, a, Single))),
    );
    family.extend([0.0, 0.05, 0.31, 1.0].map(|a| Bsdf::dielectric(1.5, a, Single)));
    family.push(Bsdf::ThinDielectric(ThinDielectric { eta: 1.5, internal_transmittance: Rgb::new(0.9, 0.5, 0.1) }));
    family.extend(diffuse_sheets());
    family.extend(clear_coated_bsdfs().into_iter().map(|(bsdf, _)| bsdf));
    family
}

#[test]
fn every_bsdf_stores_photons_or_casts_caustics() {
    for bsdf in representative_bsdfs() {
        assert!(bsdf.stores_photons() != bsdf.casts_caustics(), "{bsdf:?}");
        assert!(!bsdf.is_specular() || bsdf.casts_caustics(), "{bsdf:?}");
    }
    assert!(!Bsdf::Black.stores_photons() && !Bsdf::Black.casts_caustics() && !Bsdf::Black.is_specular());
}

#[test]
fn roughness_decides_photon_storage_of_conductors() {
    let (eta, k) = metal_refractive_index("nickel").unwrap();
    for (alpha, is_specular, stores) in [
        (0.0, true, false),
        (0.05, false, false),
        (MIN_PHOTON_STORAGE_ALPHA, false, false),
        (MIN_PHOTON_STORAGE_ALPHA + 0.01, false, true),
        (1.0, false, true),
    ] {
        let metal = Bsdf::Conductor(Conductor::new(eta, k, alpha, Single));
        assert_eq!((metal.is_specular(), metal.stores_photons()), (is_specular, stores), "{alpha}");
    }
}

#[test]
fn dielectrics_of_all_roughnesses_cast_caustics() {
    for alpha in [0.0, 0.05, 0.31, 1.0] {
        let glass = Bsdf::dielectric(1.5, alpha, Single);
        assert_eq!((glass.is_specular(), glass.casts_caustics()), (alpha == 0.0, true), "{alpha}");
    }
    let sheet = Bsdf::ThinDielectric(ThinDielectric { eta: 1.5, internal_transmittance: Rgb::ONE });
    assert!(sheet.is_specular() && sheet.casts_caustics());
}

/// Index of the BSDF's variant in the enum [`Bsdf`].
///
/// A new variant does not compile here, which reminds its author to add it to
/// [`every_bsdf_variant_is_tested`].
fn index_of_bsdf_variant(bsdf: &Bsdf) -> usize {
    match bsdf {
        Bsdf::Black => 0,
        Bsdf::Diffuse(_) => 1,
        Bsdf::Phong(_) => 2,
        Bsdf::Mirror(_) => 3,
        Bsdf::Dielectric(_) => 4,
        Bsdf::Conductor(_) => 5,
        Bsdf::RoughDielectric(_) => 6,
        Bsdf::ThinDielectric(_) => 7,
        Bsdf::CoatedDiffuse(_) => 8,
        Bsdf::DielectricCoat(_) => 9,
        Bsdf::DiffuseTransmission(_) => 10,
        Bsdf::ClearCoated(_) => 11,
    }
}

/// One or more BSDFs of every variant, on which [`receivers_never_sample_delta_lobes`] is tested.
fn bsdfs_of_every_variant() -> Vec<Bsdf> {
    [vec![Bsdf::Black], representative_bsdfs(), all_bsdf_kinds()].concat()
}

#[test]
fn every_bsdf_variant_is_tested() {
    let mut is_tested = [false; 12];
    bsdfs_of_every_variant().iter().for_each(|bsdf| is_tested[index_of_bsdf_variant(bsdf)] = true);
    assert_eq!(is_tested, [true; 12]);
}

/// A BSDF that stores photons never samples a delta lobe, because density estimates would miss its
/// light.
#[test]
fn receivers_never_sample_delta_lobes() {
    for bsdf in bsdfs_of_every_variant().into_iter().filter(Bsdf::stores_photons) {
        for (cos, i) in [1.0, 0.6, 0.1, -0.6].into_iter().flat_map(|cos| (0..500).map(move |i| (cos, i))) {
            let sample = sample_bsdf(&bsdf, direction_with_cos(cos), i, TransportMode::Importance);
            assert!(sample.is_none_or(|sample| !sample.is_specular), "{bsdf:?} at {cos}");
        }
    }
}

/// A sheet scatters its reflectance to the side of `wo` and its transmittance to the other side.
#[test]
fn diffuse_sheets_scatter_to_both_sides() {
    let (reflectance, transmittance) = (Rgb::new(0.7, 0.2, 0.5), Rgb::new(0.1, 0.6, 0.4));
    let sheet = Bsdf::DiffuseTransmission(DiffuseTransmission::new(reflectance, transmittance));
    let n = 50_000u64;
    for cos in [0.9, -0.3] {
        let wo = direction_with_cos(cos);
        let (mut back, mut through) = (Rgb::ZERO, Rgb::ZERO);
        for i in 0..n {
            let s = sample_bsdf(&sheet, wo, i, TransportMode::Radiance).unwrap();
            *if s.is_transmitted { &mut through } else { &mut back } += s.weight / n as f32;
        }
        // Each weight is in [0, 2], so its standard deviation is at most 1. The tolerance is five
        // standard errors.
        let tolerance = 5.0 / (n as f32).sqrt();
        assert!((back - reflectance).abs().max_element() < tolerance, "{cos}: {back}");
        assert!((through - transmittance).abs().max_element() < tolerance, "{cos}: {through}");
    }
    let bright = DiffuseTransmission::new(Rgb::ONE, Rgb::new(1.0, 0.5, 0.0));
    assert_eq!(bright, DiffuseTransmission::new(Rgb::splat(0.5), Rgb::new(0.5, 0.25, 0.0)));
    let black = Bsdf::DiffuseTransmission(DiffuseTransmission::new(Rgb::ZERO, Rgb::ZERO));
    assert!(black.is_black() && sample_bsdf(&black, Vec3::Z, 0, TransportMode::Radiance).is_none());
}

#[test]
fn delta_lobes_have_zero_pdf() {
    for bsdf in representative_bsdfs().iter().filter(|b| b.is_specular()) {
        let wo = direction_with_cos(0.6);
        for wi in [Vec3::new(-wo.x, 0.0, wo.z), -wo] {
            assert_eq!(bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Radiance), Rgb::ZERO);
            assert_eq!(bsdf.pdf(wo, wi, Vec3::Z, Vec3::Z), 0.0);
        }
    }
}

/// Limits the size of a BSDF, because it is copied at each hit.
#[test]
fn bsdfs_are_small() {
    assert!(size_of::<Bsdf>() <= 40, "{}", size_of::<Bsdf>());
}

/// An interface with index 1, or with very small roughness, becomes smooth. At index 1, light
/// passes straight on.
#[test]
fn an_index_of_one_transmits_all_light() {
    let none = Bsdf::dielectric(1.0, 0.5, Single);
    assert_eq!(none, Bsdf::Dielectric(Dielectric { eta: 1.0 }));
    assert_eq!(Bsdf::dielectric(1.5, 0.0009, Single), Bsdf::Dielectric(Dielectric { eta: 1.5 }));
    assert!(matches!(Bsdf::dielectric(1.5, 0.001, Single), Bsdf::RoughDielectric(_)));
    assert!(Bsdf::Conductor(Conductor::new(Rgb::ONE, Rgb::ONE, 0.0009, Single)).is_specular());
    for i in 0..100 {
        let wo = direction_with_cos(0.3);
        let s = sample_bsdf(&none, wo, i, TransportMode::Radiance).unwrap();
        assert_eq!((s.wi, s.weight, s.is_transmitted), (-wo, Rgb::ONE, true));
    }
}

/// The transmittance of a clear sheet is (1−R)/(1+R), where R is the reflectance of one interface.
///
/// For a tinted sheet, it equals an explicit sum over the reflections between both interfaces.
#[test]
fn thin_sheets_match_the_slab_formula() {
    let clear = ThinDielectric { eta: 1.5, internal_transmittance: Rgb::ONE };
    let (r, t) = clear.reflectance_and_transmittance(1.0);
    assert!((t.x - 0.923_077).abs() < 1e-6 && (r + t - 1.0).abs().max_element() < 1e-6);
    assert!((clear.reflectance_and_transmittance(0.5).1.x - 0.836_23).abs() < 1e-5);

    let tinted = ThinDielectric { eta: 1.5, internal_transmittance: Rgb::new(0.9, 0.5, 0.0) };
    for cos in [1.0f32, 0.5, 0.05] {
        let (reflectance, cos_t) = dielectric_reflectance_and_cosine(cos, 1.5);
        let (r, t) = tinted.reflectance_and_transmittance(cos);
        for channel in 0..3 {
            let kept = libm::powf(tinted.internal_transmittance[channel], 1.0 / cos_t);
            let (mut back, mut through, mut inside) = (reflectance, 0.0, 1.0 - reflectance);
            for bounce in 0..200 {
                inside *= kept;
                let left = inside * (1.0 - reflectance);
                *if bounce % 2 == 0 { &mut through } else { &mut back } += left;
                inside *= reflectance;
            }
            assert!((r[channel] - back).abs() < 2e-6 && (t[channel] - through).abs() < 2e-6, "{cos}: {r} {t}");
        }
    }
    // A sheet of lower index than its surroundings reflects all light beyond the critical angle.
    assert_eq!(ThinDielectric { eta: 1.0 / 1.5, ..clear }.reflectance_and_transmittance(0.1), (Rgb::ONE, Rgb::ZERO));
    assert_eq!(ThinDielectric { eta: 1.0, ..tinted }.reflectance_and_transmittance(0.4).0, Rgb::ZERO);
}

/// The mean weights of reflected and of transmitted samples equal the sheet's reflectance and
/// transmittance, from either side.
#[test]
fn thin_sheets_sample_both_directions() {
    let pane = ThinDielectric { eta: 1.5, internal_transmittance: Rgb::new(0.9, 0.5, 0.2) };
    let n = 50_000u64;
    for cos in [0.8, -0.8, 0.1] {
        let wo = direction_with_cos(cos);
        let (r, t) = pane.reflectance_and_transmittance(f32::abs(cos));
        let (mut back, mut through) = (Rgb::ZERO, Rgb::ZERO);
        for i in 0..n {
            let s = sample_bsdf(&Bsdf::ThinDielectric(pane), wo, i, TransportMode::Radiance).unwrap();
            if s.is_transmitted {
                assert_eq!(s.wi, -wo);
                through += s.weight / n as f32;
            } else {
                assert!((s.wi - Vec3::new(-wo.x, -wo.y, wo.z)).length() < 1e-6);
                back += s.weight / n as f32;
            }
        }
        // Each weight is in [0, 2], so its standard deviation is at most 1. The tolerance is five
        // standard errors.
        let tolerance = 5.0 / (n as f32).sqrt();
        assert!((back - r).abs().max_element() < tolerance, "{cos}: {back} {r}");
        assert!((through - t).abs().max_element() < tolerance, "{cos}: {through} {t}");
    }
    let opaque = Bsdf::ThinDielectric(ThinDielectric { eta: 1.0, internal_transmittance: Rgb::ZERO });
    assert!(sample_bsdf(&opaque, Vec3::Z, 0, TransportMode::Radiance).is_none());
}

/// A metal with the refractive index of [`conductor_index_of_reflectance`] has the given
/// reflectance at normal incidence.
///
/// The tolerance is eight rounding errors of a number just below 1.
#[test]
fn metal_index_reproduces_the_given_reflectance() {
    for reflectance in [0.0, 0.04, 0.3, 0.5, 0.95, 0.9999] {
        let (eta, k) = conductor_index_of_reflectance(Rgb::splat(reflectance));
        let found = conductor_reflectance(1.0, eta, k).x;
        assert!((found - reflectance).abs() <= 4.0 * f32::EPSILON, "{found} not {reflectance}");
    }
}
