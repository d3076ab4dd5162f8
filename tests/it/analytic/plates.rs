//! Form factors, infinite plates between mirrors, and image sources.

use crate::support::*;
use caustica::photon::{Kernel, PhotonKind, PhotonMap, StoreMask, TracedPhotons};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::Plane;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// The faces of a cube exchange flux by the form factors of unit squares.
///
/// These are .199825 for opposite faces and .200044 for adjacent ones, known to half of the last
/// digit.
#[test]
fn cube_faces_exchange_flux_by_form_factors() {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(grey(0.5)));
    for (i, face) in box_faces(DVec3::ZERO, DVec3::ONE, true).into_iter().enumerate() {
        b.add_shape(face, white, grey(if i == 1 { 1.0 } else { 0.0 }));
    }
    let scene = photon_only_scene(b);
    let passes = trace_photon_passes(&scene, StoreMask::DIRECT, 0, PASSES, 1 << 16);
    // Assigns photons to the nearest face.
    let on = |face: usize| {
        move |p: DVec3| {
            let distances = [p.y, 1.0 - p.y, p.x, 1.0 - p.x, p.z, 1.0 - p.z];
            distances.iter().all(|d| distances[face] <= *d)
        }
    };
    for (face, name, factor) in [(0, "floor", 0.199_825), (2, "left", 0.200_044), (5, "front", 0.200_044)] {
        let samples: Vec<f64> =
            passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, on(face)).x / PI).collect();
        assert_mean(
            &format!("form factor of the {name}"),
            &samples,
            factor,
            5e-7 + factor * STORED_COLOR_ROUNDING,
            2e-3,
        );
    }
    let total: f64 = passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, |_| true).x / PI).sum();
    // All flux that leaves the ceiling lands, up to the rounding of stored colors.
    assert!((total / f64::from(PASSES) - 1.0).abs() < 2.0 * STORED_COLOR_ROUNDING, "{total}");
}

const FLOOR: DVec3 = DVec3::new(0.8, 0.5, 0.3);
const CEILING: DVec3 = DVec3::new(0.4, 0.9, 0.6);
const LIGHT: DVec3 = DVec3::new(1.0, 2.0, 0.5);

/// Builds a diffuse floor and an emissive diffuse ceiling between four perfect mirrors, equivalent
/// to two infinite plates.
fn plates_scene() -> Scene {
    let mut b = SceneBuilder::new();
    let floor = b.add_material(Material::diffuse(FLOOR.as_vec3()));
    let ceiling = b.add_material(Material::diffuse(CEILING.as_vec3()));
    let mirror = b.add_material(Material::mirror(Vec3::ONE));
    for (i, face) in box_faces(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 0.7, 1.0), true).into_iter().enumerate() {
        let (material, light) = match i {
            0 => (floor, Vec3::ZERO),
            1 => (ceiling, LIGHT.as_vec3()),
            _ => (mirror, Vec3::ZERO),
        };
        b.add_shape(face, material, light);
    }
    // The view covers |x|, |z| < 0.5 of the floor.
    b.build(square_camera(dvec3(0.0, 0.6, 0.0), DVec3::ZERO, 2.0 * libm::atan(0.5 / 0.6) * 180.0 / PI, 12)).unwrap()
}

/// Flux between infinite plates is a geometric series.
///
/// The floor's irradiance is the ceiling's radiosity, E/(1 − ρ₁ρ₂) with E = πL. ρ₁ is the floor's
/// albedo, and ρ₂ the ceiling's. The ceiling's irradiance is ρ₁ times that of the floor.
#[test]
fn infinite_plates_have_geometric_series_of_flux() {
    let scene = plates_scene();
    let passes = trace_photon_passes(&scene, StoreMask::ALL, 10_000, PASSES, 1 << 15);
    let floor = LIGHT * PI / (DVec3::ONE - FLOOR * CEILING);
    for (name, low, expected) in [("floor", true, floor), ("ceiling", false, floor * FLOOR)] {
        let on = |t: &TracedPhotons| flux_where(&scene, &t.deposits.surface_photons, |p| (p.y < 0.35) == low) / 4.0;
        assert_mean_rgb(
            &format!("irradiance of the {name}"),
            &passes.iter().map(on).collect::<Vec<_>>(),
            expected,
            6e-3,
        );
    }
}

/// Direct light, the caustic map and the global map add up to the light of infinite plates.
///
/// Shadow rays carry direct light, the caustic map carries light from mirrors, and the global map
/// carries the rest.
#[test]
#[ignore = "long: t-tests over many bounces"]
fn direct_caustic_and_global_light_sum_to_total() {
    let scene = plates_scene();
    let expected = LIGHT / (DVec3::ONE - FLOOR * CEILING) * FLOOR;
    let settings = fixed_radius_settings(1 << 16, 1 << 16, 0.2);
    assert_mean_rgb("radiance of the floor", &mean_radiance_per_pass(&scene, settings, PASSES), expected, 6e-3);
}

/// A point light between two infinite mirrors over a floor acts like a row of image lights.
///
/// Image k is at 2ka + (−1)ᵏx and has the factor ρ^|k|. Image k = 0 is direct light; all others are
/// caustics.
#[test]
fn parallel_mirrors_show_row_of_lights() {
    const A: f64 = 1.0;
    const RHO: f64 = 0.8;
    const H: f64 = 0.7;
    const X: f64 = 0.3;
    const R: f64 = 0.4;
    let mut b = SceneBuilder::new();
    let floor = b.add_material(Material::diffuse(grey(0.5)));
    let mirror = b.add_material(Material::mirror(grey(RHO)));
    b.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), floor, grey(0.0));
    b.add_plane(Plane::new(DVec3::X * A, -DVec3::X), mirror, grey(0.0));
    b.add_plane(Plane::new(-DVec3::X * A, DVec3::X), mirror, grey(0.0));
    b.add_delta_light(UnscaledDeltaLight::Point { position: dvec3(X, H, 0.0) }, LightStrength::Physical(grey(1.0)));
    let scene = photon_only_scene(b);
    let at = dvec3(-0.2, 0.0, 0.1);
    let irradiance_of = |k: i32, p: DVec3| {
        let image = 2.0 * f64::from(k) * A + if k % 2 == 0 { X } else { -X };
        let d2 = H * H + (p.x - image) * (p.x - image) + p.z * p.z;
        libm::pow(RHO, f64::from(k.abs())) * H / (d2 * d2.sqrt())
    };
    let bent = |p: DVec3| (1..60).map(|k| irradiance_of(k, p) + irradiance_of(-k, p)).sum::<f64>();
    for class in [PhotonKind::Direct, PhotonKind::Caustic] {
        let mask =
            StoreMask { direct: class == PhotonKind::Direct, caustic: class == PhotonKind::Caustic, ..StoreMask::NONE };
        let passes = trace_photon_passes(&scene, mask, 1000, PASSES, 1 << 16);
        let maps: Vec<PhotonMap> = passes.into_iter().map(|t| PhotonMap::build(t.deposits.surface_photons)).collect();
        for kernel in [Kernel::Box, Kernel::Epanechnikov] {
            let expected = kernel_weighted_mean(kernel, R, |d| {
                let p = at + dvec3(d.x, 0.0, d.y);
                if class == PhotonKind::Direct { irradiance_of(0, p) } else { bent(p) }
            });
            let probe = EstimatePoint { scene: &scene, at, normal: DVec3::Y, radius: R, kernel };
            assert_estimates(&format!("{class:?} light of a row"), &probe, &maps, expected, 1e-5, 0.01);
        }
    }
}
