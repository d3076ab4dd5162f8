//! Collimated light in a half-cylindrical mirror of radius 1, whose caustic is a nephroid.

use crate::support::*;
use caustica::photon::{Kernel, Photon, PhotonMap, StoreMask, TracedPhotons};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Rectangle, Shape};
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::PI;

const REFLECTANCE: f64 = 0.9;
const IRRADIANCE: f64 = 2.0;

/// Number of flat facets of the mirror.
///
/// Each facet spans an angle of π/2000 and has the cylinder's normals as shading normals. Facets
/// deviate from the cylinder by up to their sagitta, 3·10⁻⁷.
const FACETS: u32 = 2000;

/// Builds the mirror x² + z² = 1 for z > 0 and 0 < y < 1, with its concave side inwards.
///
/// Adds a `screen`, and collimated light along `direction`.
fn cup_scene(screen: Rectangle, direction: DVec3) -> Scene {
    let mut b = SceneBuilder::new();
    let mirror = b.add_material(Material::mirror(grey(REFLECTANCE)));
    let white = b.add_material(Material::diffuse(grey(0.5)));
    let (mut corners, mut normals, mut triangles) = (vec![], vec![], vec![]);
    for i in 0..=FACETS {
        let (sin, cos) = libm::sincos(PI * (f64::from(i) / f64::from(FACETS) - 0.5));
        for y in [0.0, 1.0] {
            corners.push(dvec3(sin, y, cos));
            normals.push(Vec3::new(-sin as f32, 0.0, -cos as f32));
        }
        if i > 0 {
            let a = 2 * i - 2;
            triangles.extend([[a, a + 1, a + 2], [a + 1, a + 3, a + 2]]);
        }
    }
    b.add_mesh(&corners, &normals, &triangles, mirror, grey(0.0));
    b.add_shape(Shape::Rectangle(screen), white, grey(0.0));
    b.add_delta_light(UnscaledDeltaLight::Directional { direction }, LightStrength::Physical(grey(IRRADIANCE)));
    photon_only_scene(b)
}

/// Traces passes and returns their photons after one reflection.
fn reflected_ray(scene: &Scene) -> Vec<TracedPhotons> {
    trace_photon_passes(scene, StoreMask::CAUSTIC, 1, PASSES, 1 << 17)
}

/// The flux of reflected light along the axis of the cup has a closed form.
///
/// The light is parallel to a screen in the plane of the axis, so only reflected light lands there.
/// A ray with the angle of incidence θ has the distance sin θ from the middle of the beam, and
/// crosses the axis at 1/(2 cos θ). So the fraction sin(acos(1/(2z))) of the beam lands between 1/2
/// and z.
#[test]
fn flux_along_cup_axis_matches_closed_form() {
    let screen = Rectangle::new(dvec3(0.0, 0.0, 0.4), DVec3::Z * 0.59, DVec3::Y);
    let scene = cup_scene(screen, DVec3::Z);
    let passes = reflected_ray(&scene);
    let part = |z: f64| (1.0 - 1.0 / (4.0 * z * z)).max(0.0).sqrt();
    for (from, to) in [(0.5, 0.51), (0.51, 0.55), (0.55, 0.7), (0.7, 0.95), (0.5, 0.95)] {
        let inside = |p: DVec3| p.z > from && p.z <= to;
        let samples: Vec<f64> =
            passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, inside).x).collect();
        let expected = 2.0 * IRRADIANCE * REFLECTANCE * (part(to) - part(from));
        // The sagitta of a facet moves the crossing with the axis by 10⁻⁶. Near 1/2, this affects
        // at most √(4·10⁻⁶) of the beam. The width of facets causes no error in the mean.
        let slack = if from == 0.5 { 4e-3 * 0.5 } else { 1e-4 } * expected;
        assert_mean(&format!("axis from {from} to {to}"), &samples, expected, slack, 0.012);
    }
    // Hit points are moved away from edges of facets by 16 position errors of 5·2⁻²³. This moves a
    // ray sideways by at most 10⁻⁵.
    let sideways =
        |p: &Photon| (0.5 - 1e-5 - photon_position(&scene, p).z) * f64::from(p.attributes.incident_direction().x.abs());
    let most = passes.iter().flat_map(|t| &t.deposits.surface_photons).map(sideways).fold(0.0, f64::max);
    assert!(most < 1e-5, "no ray crosses the axis before half the radius: {most}");
}

const SLOPE: f64 = 0.5;

/// Builds the cup's floor under oblique light, which falls by `SLOPE` per unit of z.
fn floor_scene() -> Scene {
    let screen = Rectangle::new(dvec3(-1.0, 0.0, 0.0), DVec3::Z, DVec3::X * 2.0);
    cup_scene(screen, dvec3(0.0, -SLOPE, 1.0))
}

/// Returns the floor's irradiance at the point `at` = (x, z), averaged by a kernel.
///
/// Seen from above, a ray that hits the wall at the angle θ is reflected along (−sin 2θ, −cos 2θ).
/// Let s be the distance from the wall in this direction. The rays at θ hit the wall at all
/// heights, so they light the floor evenly along s: dΦ = E sin α cos θ dθ ds, where α is the angle
/// at which the light falls. A ray ends at the opposite wall, s = 2 cos θ, or after it has fallen
/// by the cup's height.
fn floor_point(at: DVec2, kernel: Kernel, radius: f64) -> f64 {
    let falling = IRRADIANCE * REFLECTANCE * SLOPE / (1.0 + SLOPE * SLOPE).sqrt();
    let ray = |theta: f64| {
        let (sin, cos) = libm::sincos(theta);
        let (sin2, cos2) = libm::sincos(2.0 * theta);
        // Intersects the ray with the disc of the kernel.
        let (start, along) = (DVec2::new(sin, cos), -DVec2::new(sin2, cos2));
        let nearest = (at - start).dot(along);
        let off2 = (start + along * nearest - at).length_squared();
        if off2 >= radius * radius {
            return 0.0;
        }
        let half = (radius * radius - off2).sqrt();
        let (from, to) = ((nearest - half).max(0.0), (nearest + half).min((2.0 * cos).min(1.0 / SLOPE)));
        if from >= to {
            return 0.0;
        }
        cos * midpoint_integral(from, to, 60, |s| kernel_at(kernel, (start + along * s - at).length(), radius))
    };
    falling * midpoint_integral(-0.5 * PI, 0.5 * PI, 40_000, ray)
}

/// Returns the point (x, z) of the caustic's fold, the nephroid (3cos t − cos 3t, 3sin t − sin
/// 3t)/4.
fn nephroid_fold(t: f64) -> DVec2 {
    DVec2::new(3.0 * libm::sin(t) - libm::sin(3.0 * t), 3.0 * libm::cos(t) - libm::cos(3.0 * t)) * 0.25
}

#[test]
fn cup_floor_flux_matches_ray_tracing() {
    let scene = floor_scene();
    let maps: Vec<PhotonMap> =
        reflected_ray(&scene).into_iter().map(|t| PhotonMap::build(t.deposits.surface_photons)).collect();
    // The points are at the cusp, on both sides of it, on the fold, and away from it.
    for at in
        [DVec2::new(0.0, 0.5), DVec2::new(0.0, 0.56), DVec2::new(0.0, 0.42), nephroid_fold(0.6), DVec2::new(-0.5, 0.2)]
    {
        for kernel in KERNELS {
            let expected = floor_point(at, kernel, 0.05);
            let probe =
                EstimatePoint { scene: &scene, at: dvec3(at.x, 0.0, at.y), normal: DVec3::Y, radius: 0.05, kernel };
            assert_estimates("floor of a cup", &probe, &maps, expected, 1e-3, 0.03);
        }
    }
}

/// The flux has its peak at the nephroid.
///
/// The test counts flux in cells of width .01 across the fold. On the wall's side, the density
/// falls as 1/√distance. So the cell at the fold has 1/(√2 − 1) = 2.4 times the flux of the next
/// cell, apart from uniform light. Cells extend ±.03 along the fold, where the curve is within
/// .03²/2 = 5·10⁻⁴ of its tangent.
#[test]
fn flux_peaks_at_the_nephroid() {
    let scene = floor_scene();
    let passes = reflected_ray(&scene);
    for t in [0.4, 0.6, -0.8] {
        let tangent = (nephroid_fold(t + 1e-5) - nephroid_fold(t - 1e-5)).normalize();
        // `outward` is the normal of the fold that points to the wall.
        let outward = if tangent.perp().dot(nephroid_fold(t)) > 0.0 { tangent.perp() } else { -tangent.perp() };
        let mut cells = [0f64; 12];
        for p in passes.iter().flat_map(|t| &t.deposits.surface_photons) {
            let p = photon_position(&scene, p);
            let d = DVec2::new(p.x, p.z) - nephroid_fold(t);
            let cell = (d.dot(outward) * 100.0 + 6.0).floor();
            if d.dot(tangent).abs() < 0.03 && (0.0..12.0).contains(&cell) {
                cells[cell as usize] += 1.0;
            }
        }
        eprintln!("across the fold at t = {t}: {cells:?}");
        let brightest = (0..12).max_by(|a, b| cells[*a].total_cmp(&cells[*b])).unwrap();
        assert_eq!(brightest, 6, "t = {t}: {cells:?}");
        // The brightest cell holds 3000 photons, so its relative noise is 1/√3000. The limit of 1.4
        // times the next cell is far above this noise.
        assert!(cells[6] > 1.4 * cells[7] && cells[6] > 2.0 * cells[5], "t = {t}: {cells:?}");
    }
}
