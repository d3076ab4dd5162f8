mod chi_square;
mod clear_coat;
mod coated;
mod kinds;
mod multiple_scattering;
mod rough;

use super::MicrofacetScattering::{Multiple, Single};
use super::*;
use crate::math::Frame;
use crate::sampling::{Dimension, Key, Purpose};

/// Sample `i` of `bsdf` at a surface with both normals along z.
fn sample_bsdf(bsdf: &Bsdf, wo: Vec3, i: u64, transport: TransportMode) -> Option<BsdfSample> {
    let key = Key::new(11).purpose_key(Purpose::Test).child_key(i);
    let (lobe, u) = (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
    bsdf.sample(wo, Vec3::Z, Vec3::Z, lobe, u, transport)
}

/// Unit direction in the (x, z) plane with the cosine `cos` to z.
fn direction_with_cos(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

fn basic_bsdfs() -> [Bsdf; 5] {
    let rgb = Vec3::new(0.7, 0.2, 0.5);
    [
        Bsdf::Diffuse(rgb),
        Bsdf::Phong(Phong::new(rgb, Vec3::splat(1.0), 20.0)),
        Bsdf::Phong(Phong::new(Vec3::ONE, Vec3::ONE, 0.0)),
        Bsdf::Mirror(rgb),
        Bsdf::Dielectric(Dielectric { eta: 1.5 }),
    ]
}

/// Coated BSDFs that store photons. If the coat is rough, the BSDF includes it; otherwise the BSDF
/// is the base without its coat, which is a separate BSDF.
fn coated_bsdfs() -> Vec<Bsdf> {
    let rgb = Vec3::new(1.0, 0.2, 0.5);
    [(1.5, 0.0), (2.5, 0.1), (1.5, 0.31), (1.2, 1.0)]
        .map(|(eta, alpha)| Bsdf::coated_diffuse(rgb, eta, alpha, true))
        .to_vec()
}

/// Diffuse sheets that reflect and transmit, only reflect, and only transmit.
fn diffuse_sheets() -> Vec<Bsdf> {
    let (rgb, other) = (Vec3::new(0.7, 0.2, 0.5), Vec3::new(0.3, 0.6, 0.5));
    [(rgb, other), (rgb, Rgb::ZERO), (Rgb::ZERO, other)]
        .map(|(reflectance, transmittance)| {
            Bsdf::DiffuseTransmission(DiffuseTransmission::new(reflectance, transmittance))
        })
        .to_vec()
}

/// Surfaces under clear coats, each with the width of its lobe \[radians].
fn clear_coated_bsdfs() -> Vec<(Bsdf, f64)> {
    let rgb = Vec3::new(1.0, 0.2, 0.5);
    let metal = |alpha| {
        let (eta, k) = conductor_index_of_reflectance(rgb);
        Bsdf::Conductor(Conductor::new(eta, k, alpha, Multiple))
    };
    let coats = [(1.0, 0.0), (0.6, 0.1), (1.0, 0.7)];
    let bases = [
        (Bsdf::Diffuse(rgb), 1.0),
        (Bsdf::coated_diffuse(rgb, 1.5, 0.2, false), 1.0),
        (Bsdf::coated_diffuse(rgb, 1.5, 0.5, false), 1.0),
        (metal(0.2), 0.4),
        (metal(0.6), 1.0),
    ];
    let coated =
        |(bsdf, width): (Bsdf, f64)| coats.map(|(coverage, alpha)| (ClearCoat::new(coverage, alpha).over(bsdf), width));
    bases.into_iter().flat_map(coated).collect()
}

/// Coats of α from 0 to 0.2, without their bases.
fn coats() -> Vec<Bsdf> {
    [0.0, MIN_ROUGH_ALPHA, 0.2]
        .map(|a| Bsdf::coated_diffuse(Rgb::ZERO, 1.5, a, true).coat_if_separate().unwrap())
        .to_vec()
}

/// One or more BSDFs of each kind that scatters light; rough ones have small, medium and large α.
fn all_bsdf_kinds() -> Vec<Bsdf> {
    let (eta, k) = metal_refractive_index("copper").unwrap();
    let mut all = basic_bsdfs().to_vec();
    all.extend([0.0, MIN_ROUGH_ALPHA, 0.2, 1.0].map(|alpha| Bsdf::Conductor(Conductor::new(eta, k, alpha, Single))));
    all.extend([MIN_ROUGH_ALPHA, 0.2, 1.0].map(|alpha| Bsdf::dielectric(1.5, alpha, Single)));
    all.extend([MIN_ROUGH_ALPHA, 0.2, 1.0].map(|alpha| Bsdf::dielectric(1.0 / 1.5, alpha, Single)));
    for alpha in [MIN_ROUGH_ALPHA, 0.2, 1.0] {
        all.push(Bsdf::Conductor(Conductor::new(eta, k, alpha, Multiple)));
        all.extend([1.5, 1.0 / 1.5].map(|eta| Bsdf::dielectric(eta, alpha, Multiple)));
    }
    all.extend(coated_bsdfs());
    all.extend(coats());
    all.extend(diffuse_sheets());
    all.extend(clear_coated_bsdfs().into_iter().map(|(bsdf, _)| bsdf));
    all.push(ClearCoat::new(1.0, 0.2).over(Bsdf::Conductor(Conductor::new(eta, k, 0.0, Single))));
    all.push(Bsdf::ThinDielectric(ThinDielectric { eta: 1.5, internal_transmittance: Rgb::new(1.0, 0.5, 0.1) }));
    all
}

/// No BSDF gains energy, at any angle, from either side: on photon paths, the mean sample weight is
/// at most 1, within five standard errors.
#[test]
fn bsdfs_gain_no_energy() {
    let n = 40_000u64;
    for bsdf in all_bsdf_kinds() {
        for cos in [1.0, 0.7, 0.2, 0.01, 1e-4, -0.5, -0.01] {
            let (mut sum, mut squares) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
            for i in 0..n {
                let w = sample_bsdf(&bsdf, direction_with_cos(cos), i, TransportMode::Importance)
                    .map_or(Rgb::ZERO, |s| s.weight);
                assert!(w.is_finite() && w.min_element() >= 0.0);
                sum += w.as_dvec3();
                squares += w.as_dvec3() * w.as_dvec3();
            }
            let mean = sum / n as f64;
            let sigma = ((squares / n as f64 - mean * mean).max(glam::DVec3::ZERO).max_element() / n as f64).sqrt();
            assert!(mean.max_element() <= 1.0 + 5.0 * sigma + 1e-6, "{bsdf:?} at {cos}: {mean}");
        }
    }
}

/// The mean sample weight equals the integral of f·cosθ over the hemisphere, which is estimated by
/// uniform sampling.
#[test]
fn sampling_and_evaluation_agree() {
    let n = 200_000u64;
    for bsdf in basic_bsdfs()[..3].iter().chain(&coated_bsdfs()) {
        for cos in [0.95, 0.4] {
            let wo = direction_with_cos(cos);
            let moments = |f: &dyn Fn(u64) -> f64| {
                let (mut s, mut q) = (0.0, 0.0);
                for i in 0..n {
                    let x = f(i);
                    s += x;
                    q += x * x;
                }
                let m = s / n as f64;
                (m, (q / n as f64 - m * m) / n as f64)
            };
            let (a, va) = moments(&|i| {
                f64::from(sample_bsdf(bsdf, wo, i, TransportMode::Importance).map_or(0.0, |s| s.weight.y))
            });
            let (b, vb) = moments(&|i| {
                let u = Key::new(12).purpose_key(Purpose::Test).child_key(i).uniform_2d(Dimension::BsdfDirection);
                let wi = warp::square_to_uniform_cone(u, 1.0);
                f64::from(
                    bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Importance).y * wi.z
                        / warp::uniform_cone_pdf(1.0),
                )
            });
            // Five sigma of the difference: one false alarm in a million comparisons.
            assert!((a - b).abs() < 5.0 * (va + vb).sqrt() + 1e-5, "{bsdf:?} at {cos}: {a} {b}");
        }
    }
}

#[test]
fn diffuse_and_coated_scattering_is_reciprocal() {
    let clear_coated: Vec<Bsdf> = clear_coated_bsdfs().into_iter().map(|(bsdf, _)| bsdf).collect();
    let mut bsdfs = basic_bsdfs()[..3].to_vec();
    bsdfs.extend([coated_bsdfs(), coats(), diffuse_sheets(), clear_coated].concat());
    for bsdf in &bsdfs {
        for (a, b) in [(0.9, 0.3), (0.1, 0.99), (0.5, 0.5), (0.9, -0.3), (-0.2, 0.7)] {
            let (wo, wi) = (
                direction_with_cos(a),
                Frame::from_normal(Vec3::Z).to_world(direction_with_cos(b) * Vec3::new(-0.8, 1.0, 1.0)).normalize(),
            );
            let (there, back) = (
                bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Importance),
                bsdf.evaluate(wi, wo, Vec3::Z, Vec3::Z, TransportMode::Importance),
            );
            assert!((there - back).abs().max_element() < 1e-5, "{bsdf:?}");
        }
    }
}

/// A smooth dielectric reflects with the probability that Fresnel's equations give. Transmitted
/// radiance is divided by the squared relative index.
#[test]
fn dielectrics_reflect_by_fresnel_probability() {
    let glass = Bsdf::Dielectric(Dielectric { eta: 1.5 });
    let n = 100_000u64;
    for cos in [0.8f32, 0.3, -0.9] {
        let eta = if cos > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let (r, _) = dielectric_reflectance_and_cosine(cos.abs(), eta);
        let reflected = (0..n)
            .filter(|i| {
                sample_bsdf(&glass, direction_with_cos(cos), *i, TransportMode::Importance)
                    .is_some_and(|s| !s.is_transmitted)
            })
            .count();
        let sigma = (f64::from(r * (1.0 - r)) / n as f64).sqrt();
        assert!((reflected as f64 / n as f64 - f64::from(r)).abs() < 5.0 * sigma);
        let through = (0..n).find_map(|i| {
            sample_bsdf(&glass, direction_with_cos(cos), i, TransportMode::Radiance).filter(|s| s.is_transmitted)
        });
        assert!((through.unwrap().weight.x * eta * eta - 1.0).abs() < 1e-6);
    }
}

/// With a tilted shading normal, each sample lies on that side of the geometric surface that
/// `is_transmitted` states.
#[test]
fn shading_normals_never_leak_light() {
    let ns = Vec3::new(0.9, 0.0, 0.3).normalize();
    for bsdf in all_bsdf_kinds() {
        for i in 0..20_000u64 {
            let key = Key::new(13).purpose_key(Purpose::Test).child_key(i);
            let wo = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
            let (lobe, u) = (key.uniform_1d(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
            if let Some(s) = bsdf.sample(wo, ns, Vec3::Z, lobe, u, TransportMode::Importance) {
                assert_eq!(s.is_transmitted, (s.wi.z < 0.0) != (wo.z < 0.0), "{bsdf:?}");
                assert!((s.wi.length() - 1.0).abs() < 1e-4);
            }
        }
    }
}
