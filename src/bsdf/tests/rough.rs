//! Tests of microfacet BSDFs: energy, symmetry, and the limit of small roughness.

use super::*;

/// Refractive index of glass.
const GLASS: f32 = 1.5;

/// `count` pairs of unit directions, uniform over the sphere.
fn random_direction_pairs(count: u64) -> impl Iterator<Item = (Vec3, Vec3)> {
    (0..count).map(|i| {
        let key = Key::new(19).purpose_key(Purpose::Test).child_key(i);
        let wo = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
        (wo, warp::square_to_uniform_sphere(key.uniform_2d(Dimension::BsdfDirection)))
    })
}

/// True if `a` and `b` differ by at most a relative error of 10⁻⁵.
fn is_close_within_rounding(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-5 * a.abs().max(b.abs()) + 1e-12
}

fn rough_bsdfs() -> [Bsdf; 8] {
    let (eta, k) = metal_refractive_index("copper").unwrap();
    [
        Bsdf::Conductor(Conductor::new(eta, k, 0.2, Single)),
        Bsdf::Conductor(Conductor::new(eta, k, 1.0, Single)),
        Bsdf::dielectric(GLASS, 0.2, Single),
        Bsdf::dielectric(1.0 / GLASS, 0.7, Single),
        Bsdf::Conductor(Conductor::new(eta, k, 0.2, Multiple)),
        Bsdf::Conductor(Conductor::new(eta, k, 1.0, Multiple)),
        Bsdf::dielectric(GLASS, 0.2, Multiple),
        Bsdf::dielectric(1.0 / GLASS, 0.7, Multiple),
    ]
}

/// Samples the BSDF for photons (importance mode), and returns the mean weights of reflected and of
/// transmitted samples. In each mean, samples of the other kind count as 0.
///
/// Each mean estimates the integral of f·cosθ over its hemisphere. The random numbers form a
/// lattice.
pub(super) fn mean_sample_weights(bsdf: &Bsdf, wo: Vec3) -> (f64, f64) {
    let steps = 256u32;
    let (mut reflected, mut transmitted) = (0.0, 0.0);
    for i in 0..steps * steps {
        let u = (Vec2::new((i % steps) as f32, (i / steps) as f32) + 0.5) / steps as f32;
        // The third coordinate of the lattice is a sequence of multiples of the golden ratio,
        // modulo 1.
        let lobe = (f64::from(i) * 0.618_033_988_749_895).fract() as f32;
        if let Some(s) = bsdf.sample(wo, Vec3::Z, Vec3::Z, lobe, u, TransportMode::Importance) {
            *if s.is_transmitted { &mut transmitted } else { &mut reflected } += f64::from(s.weight.x);
        }
    }
    let n = f64::from(steps * steps);
    (reflected / n, transmitted / n)
}

/// The weight and pdf of samples agree with `evaluate` and `pdf`, also with tilted normals and for
/// the narrowest lobes.
#[test]
fn samples_agree_with_evaluation_and_pdf() {
    let (eta, k) = metal_refractive_index("iron").unwrap();
    let mut checked = 0;
    for alpha in [MIN_ROUGH_ALPHA, 0.05, 0.3, 1.0] {
        for bsdf in [
            Bsdf::Conductor(Conductor::new(eta, k, alpha, Single)),
            Bsdf::dielectric(GLASS, alpha, Single),
            Bsdf::dielectric(1.0 / GLASS, alpha, Single),
            Bsdf::dielectric(1.01, alpha, Single),
            Bsdf::Conductor(Conductor::new(eta, k, alpha, Multiple)),
            Bsdf::dielectric(GLASS, alpha, Multiple),
            Bsdf::dielectric(1.0 / GLASS, alpha, Multiple),
            Bsdf::dielectric(1.01, alpha, Multiple),
            Bsdf::Diffuse(eta * 0.2),
            diffuse_sheets()[0],
            ClearCoat::new(0.9, alpha).over(Bsdf::coated_diffuse(k * 0.2, GLASS, 0.5, true)),
            ClearCoat::new(0.9, 0.1).over(Bsdf::Conductor(Conductor::new(eta, k, alpha, Multiple))),
            Bsdf::Phong(Phong::new(eta, k, 30.0)),
            Bsdf::coated_diffuse(k * 0.2, GLASS, alpha, true),
        ] {
            for (i, (wo, other)) in random_direction_pairs(2000).enumerate() {
                let key = Key::new(23).purpose_key(Purpose::Test).child_key(i as u64);
                let (lobe, u) = (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
                let ns = (Vec3::Z + 0.5 * other * (i % 2) as f32).normalize();
                for transport in [TransportMode::Radiance, TransportMode::Importance] {
                    let Some(s) = bsdf.sample(wo, ns, Vec3::Z, lobe, u, transport) else { continue };
                    let (f, pdf) = (bsdf.evaluate(wo, s.wi, ns, Vec3::Z, transport), bsdf.pdf(wo, s.wi, ns, Vec3::Z));
                    assert!(s.pdf > 0.0 && s.pdf.is_finite() && s.weight.is_finite(), "{bsdf:?} {wo}: {s:?}");
                    assert!((s.pdf - pdf).abs() <= 1e-3 * pdf, "{bsdf:?} {wo}: {} {pdf}", s.pdf);
                    let weight = f * (s.wi.dot(ns).abs() / pdf);
                    let error = (weight - s.weight).abs().max_element();
                    assert!(error <= 1e-3 * weight.max_element(), "{bsdf:?} {wo} {ns}: {weight} {s:?}");
                    assert_eq!(s.is_transmitted, s.wi.z * wo.z < 0.0);
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 50_000, "{checked}");
}

/// Reflection is reciprocal. Refraction satisfies f(wo, wi)/n²(wo) = f(wi, wo)/n²(wi), where n(w)
/// is the refractive index on the side of w (Veach 1997, section 5.2).
#[test]
fn interfaces_are_reciprocal_up_to_squared_index() {
    let mut through = 0;
    for bsdf in rough_bsdfs() {
        let outer_over_inner = match bsdf {
            Bsdf::RoughDielectric(_) if [2, 6].map(|i| rough_bsdfs()[i]).contains(&bsdf) => 1.0 / GLASS,
            Bsdf::RoughDielectric(_) => GLASS,
            _ => 1.0,
        };
        let index = |v: Vec3| if v.z > 0.0 { outer_over_inner } else { 1.0 };
        for (wo, wi) in random_direction_pairs(10_000) {
            let f = |o, i, transport| bsdf.evaluate(o, i, Vec3::Z, Vec3::Z, transport).x;
            let (there, back) = (f(wo, wi, TransportMode::Radiance), f(wi, wo, TransportMode::Radiance));
            let (n_o, n_i) = (index(wo), index(wi));
            assert!(
                is_close_within_rounding(there / (n_o * n_o), back / (n_i * n_i)),
                "{bsdf:?} {wo} {wi}: {there} {back}"
            );
            // The adjoint: flux from wo to wi equals radiance seen from wi along wo.
            let adjoint = f(wo, wi, TransportMode::Importance);
            assert!(is_close_within_rounding(adjoint, back), "{bsdf:?} {wo} {wi}: {adjoint} {back}");
            assert!(is_close_within_rounding(adjoint / (n_i * n_i), there / (n_o * n_o)), "{bsdf:?} {wo} {wi}");
            through += u32::from(wo.z * wi.z < 0.0 && there > 0.0);
        }
    }
    assert!(through > 1000, "{through}");
}

/// A rough metal of reflectance 1 loses as much light as the documentation of [`Conductor`] states.
///
/// The expected losses come from an independent quadrature. At α = 1 and normal incidence, the loss
/// has the closed form 1 − ∫₀^½ (1−2s)/(1−s) ds = ln 2, because sin²θ of the visible microfacets is
/// uniform.
#[test]
fn a_white_conductor_has_the_documented_loss() {
    let grazing = libm::cosf(85f32.to_radians());
    let stated = [
        (0.1, 0.012_43, 0.113_35),
        (0.2, 0.052_42, 0.100_09),
        (0.5, 0.312_14, 0.127_97),
        (1.0, std::f64::consts::LN_2, 0.219_94),
    ];
    for (alpha, along, across) in stated {
        let white = Bsdf::Conductor(Conductor::new(Rgb::ZERO, Rgb::ONE, alpha, Single));
        for (cos, stated) in [(1.0, along), (grazing, across)] {
            let lost = 1.0 - mean_sample_weights(&white, direction_with_cos(cos)).0;
            assert!((lost - stated).abs() < 5e-4, "{alpha} at {cos}: {lost}, stated {stated}");
        }
    }
}

/// A rough dielectric gains no light from either side, and loses as much as the documentation of
/// [`RoughDielectric`] states.
///
/// The expected losses come from an independent quadrature.
#[test]
fn a_rough_dielectric_has_the_documented_loss() {
    let grazing = libm::cosf(85f32.to_radians());
    let stated = [
        (0.1, [0.000_99, 0.079_62], [0.011_74, 0.136_15]),
        (0.5, [0.031_77, 0.288_24], [0.246_37, 0.324_27]),
        (1.0, [0.106_60, 0.589_42], [0.582_87, 0.534_92]),
    ];
    for (alpha, outside, inside) in stated {
        let glass = Bsdf::dielectric(GLASS, alpha, Single);
        for (sign, stated) in [(1.0, outside), (-1.0, inside)] {
            for (cos, stated) in [1.0, grazing].into_iter().zip(stated) {
                let (r, t) = mean_sample_weights(&glass, direction_with_cos(sign * cos));
                // `lobe` selects reflection or refraction, so the fractions have an error of about
                // 1/√65,536.
                assert!((1.0 - r - t - stated).abs() < 2e-3, "{alpha} at {}: {r} + {t}, {stated}", sign * cos);
            }
            for cos in [0.7, 0.2, 0.05] {
                let (r, t) = mean_sample_weights(&glass, direction_with_cos(sign * cos));
                assert!(r + t < 1.0, "{alpha} at {}: {r} + {t}", sign * cos);
            }
        }
    }
}

/// With a narrow lobe, a rough dielectric splits energy like a smooth one, and a rough conductor
/// reflects like a mirror.
#[test]
fn narrow_lobes_approach_delta_lobes() {
    let (eta, k) = metal_refractive_index("silver").unwrap();
    let metal = |alpha| Bsdf::Conductor(Conductor::new(eta, k, alpha, Single));
    let glass = Bsdf::dielectric(GLASS, MIN_ROUGH_ALPHA, Single);
    assert!(!glass.is_specular() && !metal(MIN_ROUGH_ALPHA).is_specular());
    for cos in [1.0, 0.6, 0.3, -0.9, -0.3] {
        let wo = direction_with_cos(cos);
        let smooth = Dielectric { eta: GLASS }.reflect_and_refract(wo, Vec3::Z, Vec3::Z, TransportMode::Importance);
        let (r, t) = mean_sample_weights(&glass, wo);
        // A lattice of 65,536 points has an error of at most 1/√65,536. The curvature of Fresnel's
        // equations within a lobe adds 10⁻⁵.
        let tolerance = 1.0 / 256.0;
        assert!((r - f64::from(smooth.reflected.1)).abs() < tolerance, "{cos}: {r} {smooth:?}");
        assert!((t - f64::from(smooth.transmitted.1)).abs() < tolerance, "{cos}: {t} {smooth:?}");
        let mirror = metal(0.0).sample(wo, Vec3::Z, Vec3::Z, 0.0, Vec2::ZERO, TransportMode::Radiance).unwrap();
        assert!(mirror.is_specular && (mirror.wi - (Vec3::Z * (2.0 * wo.z) - wo)).length() < 1e-6);
        assert!((mean_sample_weights(&metal(MIN_ROUGH_ALPHA), wo).0 - f64::from(mirror.weight.x)).abs() < 1e-4);
        let fresnel = conductor_reflectance(cos.abs(), eta, k);
        assert!((mirror.weight - fresnel).abs().max_element() < 1e-6);
    }
}

/// The projected area of all microfacets is 1: ∫ D(m) cosθ dω(m) = 1, even at the smallest
/// roughness.
#[test]
fn projected_facet_area_is_one() {
    for alpha in [1e-4f32, 1e-3, 0.1, 1.0] {
        let ggx = microfacet::Ggx::new(alpha);
        // With tan²θ = α² x/(1−x), the integrand does not depend on x. The sum then has rounding
        // errors only.
        let steps = 1000;
        let total: f64 = (0..steps)
            .map(|i| {
                let x = (f64::from(i) + 0.5) / f64::from(steps);
                let a2 = f64::from(alpha) * f64::from(alpha);
                let tan2 = a2 * x / (1.0 - x);
                let cos2 = 1.0 / (1.0 + tan2);
                let h = glam::DVec3::new(tan2.sqrt(), 0.0, 1.0);
                // cosθ dω = π d(sin²θ) = π cos⁴θ d(tan²θ).
                let measure = std::f64::consts::PI * cos2 * cos2 * a2 / ((1.0 - x) * (1.0 - x));
                ggx.microfacet_normal_density(h, glam::DVec3::Z) * measure / f64::from(steps)
            })
            .sum();
        assert!((total - 1.0).abs() < 1e-9, "{alpha}: {total}");
    }
}
