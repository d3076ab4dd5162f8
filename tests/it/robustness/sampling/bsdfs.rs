//! BSDFs at extreme random numbers, roughnesses and angles.

use super::{ENDS, corners};
use caustica::bsdf::{
    Bsdf, Conductor, Dielectric, DiffuseTransmission, MIN_ROUGH_ALPHA, MicrofacetScattering, Phong, ThinDielectric,
    TransportMode, metal_refractive_index,
};
use glam::{Vec2, Vec3};

/// Returns BSDFs of each kind, each with an upper bound of its sample weight on photon paths.
///
/// The weight of diffuse surfaces, mirrors and visible microfacets is at most their reflectance.
/// The weight of a Phong lobe of exponent s is at most its albedo times (s + 2)/(s + 1). Panes and
/// diffuse sheets choose a lobe by the mean of three channels, so a channel's weight can be larger.
fn bsdf_kinds() -> Vec<(Bsdf, f32)> {
    let (eta, k) = metal_refractive_index("gold").unwrap();
    let mut kinds = vec![
        (Bsdf::Black, 0.0),
        (Bsdf::Diffuse(Vec3::ONE), 1.0),
        (Bsdf::Mirror(Vec3::ONE), 1.0),
        (Bsdf::DiffuseTransmission(DiffuseTransmission::new(Vec3::ONE, Vec3::new(1.0, 0.5, 0.0))), 3.0),
        (Bsdf::DiffuseTransmission(DiffuseTransmission::new(Vec3::ZERO, Vec3::ONE)), 1.0),
        (Bsdf::ThinDielectric(ThinDielectric { eta: 1.5, internal_transmittance: Vec3::new(1.0, 0.5, 0.0) }), 3.0),
        (Bsdf::ThinDielectric(ThinDielectric { eta: 1e6, internal_transmittance: Vec3::ONE }), 1.02),
    ];
    for shininess in [0.0, 1.0, 1e3, 1e6, 1e9, 1e20] {
        kinds.push((Bsdf::Phong(Phong::new(Vec3::splat(0.5), Vec3::splat(1e9), shininess)), 2.0));
        kinds.push((Bsdf::Phong(Phong::new(Vec3::ZERO, Vec3::ONE, shininess)), 2.0));
    }
    for alpha in [0.0, 1e-4, MIN_ROUGH_ALPHA, 0.1, 1.0] {
        kinds.push((Bsdf::Conductor(Conductor::new(eta, k, alpha, MicrofacetScattering::Single)), 1.0));
        kinds.push((Bsdf::Conductor(Conductor::new(Vec3::ZERO, Vec3::ONE, alpha, MicrofacetScattering::Single)), 1.0));
        // A transmittance of about 10⁻⁶ is sampled in steps of 2⁻²⁴. The weight corrects an error
        // of up to one step.
        kinds.extend(
            [1e-6, 0.5, 1.0, 1.0 + f32::EPSILON, 1.5, 1e6]
                .map(|eta| (Bsdf::dielectric(eta, alpha, MicrofacetScattering::Single), 1.02)),
        );
    }
    // For light that microfacets scatter more than once, the pdf is only an approximation.
    for alpha in [MIN_ROUGH_ALPHA, 0.01, 0.1, 1.0] {
        let multiple = MicrofacetScattering::Multiple;
        kinds.push((Bsdf::Conductor(Conductor::new(Vec3::ZERO, Vec3::ONE, alpha, multiple)), 5.0));
        kinds.extend([1e-6, 0.5, 1.0 + 1e-4, 1.5, 1e6].map(|eta| (Bsdf::dielectric(eta, alpha, multiple), 40.0)));
    }
    kinds
}

fn test_directions() -> Vec<Vec3> {
    let cosines = [1.0, 1.0 - f32::EPSILON, 0.7, 0.1, 1e-3, 1e-5, 1e-7, 1e-12, 1e-38, 0.0];
    let at =
        |cos: f32| Vec3::new(0.6 * ((1.0 - cos) * (1.0 + cos)).sqrt(), 0.8 * ((1.0 - cos) * (1.0 + cos)).sqrt(), cos);
    cosines.into_iter().flat_map(|c| [at(c), at(c) * Vec3::new(1.0, 1.0, -1.0)]).collect()
}

/// A sample is a unit vector on its stated side with a finite weight.
///
/// Unless it is of a delta lobe, its pdf is positive, since MIS divides by it.
#[test]
fn bsdf_samples_have_finite_weight_and_pdf() {
    let tilted = Vec3::new(0.3, -0.5, 0.6).normalize();
    let mut drawn = 0u64;
    for (bsdf, most) in bsdf_kinds() {
        for wo in test_directions() {
            for ns in [Vec3::Z, tilted] {
                for lobe in ENDS {
                    for u in corners() {
                        for transport in [TransportMode::Radiance, TransportMode::Importance] {
                            let what = || format!("{bsdf:?} from {wo} by {ns}, {lobe} {u}, {transport:?}");
                            let Some(s) = bsdf.sample(wo, ns, Vec3::Z, lobe, u, transport) else { continue };
                            assert!(s.wi.is_finite() && (s.wi.length() - 1.0).abs() < 1e-5, "{}: {s:?}", what());
                            assert!(s.weight.is_finite() && s.weight.min_element() >= 0.0, "{}: {s:?}", what());
                            // The bound allows about a hundred roundings.
                            let bound = most * (1.0 + 50.0 * f32::EPSILON);
                            assert!(
                                transport == TransportMode::Radiance || s.weight.max_element() <= bound,
                                "{}: {s:?}",
                                what()
                            );
                            assert!(s.is_specular || s.pdf > 0.0 && s.pdf.is_finite(), "{}: {s:?}", what());
                            assert_eq!(s.is_transmitted, (s.wi.z < 0.0) != (wo.z < 0.0), "{}: {s:?}", what());
                            let f = bsdf.evaluate(wo, s.wi, ns, Vec3::Z, transport);
                            let pdf = bsdf.pdf(wo, s.wi, ns, Vec3::Z);
                            assert!(
                                f.is_finite() && f.min_element() >= 0.0 && pdf.is_finite(),
                                "{}: {f} {pdf}",
                                what()
                            );
                            drawn += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(drawn > 400_000, "{drawn}");
}

/// The horizon is never sampled, since the pdf is 0 there.
///
/// The rim of the disc that cosine-weighted sampling uses corresponds to the horizon.
#[test]
fn bsdfs_never_sample_the_horizon() {
    let white = Bsdf::Diffuse(Vec3::ONE);
    let rim = [Vec2::new(0.0, 0.5), Vec2::new(0.5, 0.0)];
    for u in rim {
        assert!(white.sample(Vec3::Z, Vec3::Z, Vec3::Z, 0.0, u, TransportMode::Radiance).is_none(), "{u}");
    }
}

/// Lobes below the least roughness are delta lobes, so they need no chi-square test.
#[test]
fn narrowest_lobes_become_delta() {
    let alpha = MIN_ROUGH_ALPHA.next_down();
    for bsdf in [
        Bsdf::Conductor(Conductor::new(Vec3::ONE, Vec3::ONE, alpha, MicrofacetScattering::Single)),
        Bsdf::dielectric(1.5, alpha, MicrofacetScattering::Single),
        Bsdf::dielectric(1.5, 1e-4, MicrofacetScattering::Single),
    ] {
        assert!(bsdf.is_specular());
    }
    assert_eq!(Bsdf::dielectric(1.5, 1e-4, MicrofacetScattering::Single), Bsdf::Dielectric(Dielectric { eta: 1.5 }));
    assert!(!Bsdf::dielectric(1.5, MIN_ROUGH_ALPHA, MicrofacetScattering::Single).is_specular());
}
