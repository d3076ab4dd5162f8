//! Transmission of a slab with and without absorption, and light that leaves a glass cube.

use crate::support::*;
use caustica::photon::StoreMask;
use caustica::scene::{LightStrength, Material, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Plane, Rectangle, Shape, Sphere};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const N: f64 = 1.5;
const THICKNESS: f64 = 0.4;
const ABSORPTION: DVec3 = DVec3::new(0.0, 0.5, 3.0);

/// Returns the transmitted and reflected fractions of light that hits a slab at `angle` \[rad] from
/// the normal.
///
/// They are (1−R)²τ/(1−R²τ²) and R + R(1−R)²τ²/(1−R²τ²). R is the mean reflectance of one face over
/// both polarisations, and τ = exp(−a·thickness/cosθt) with absorption coefficient a and refracted
/// angle θt.
fn slab_transmittance(angle: f64, absorption: f64) -> (f64, f64) {
    let r = fresnel_reflectance(libm::cos(angle), N);
    let sin_t = libm::sin(angle) / N;
    let tau = libm::exp(-absorption * THICKNESS / (1.0 - sin_t * sin_t).sqrt());
    let rest = (1.0 - r) * (1.0 - r) * tau / (1.0 - r * r * tau * tau);
    (rest, r + r * rest * tau)
}

fn per_channel(angle: f64) -> (DVec3, DVec3) {
    let [red, green, blue] = ABSORPTION.to_array().map(|a| slab_transmittance(angle, a));
    (DVec3::new(red.0, green.0, blue.0), DVec3::new(red.1, green.1, blue.1))
}

/// The slab formula gives published transmittances without absorption: .923077 at normal incidence
/// and .83623 at 60°.
#[test]
fn slab_formula_matches_literature() {
    assert!((slab_transmittance(0.0, 0.0).0 - 12.0 / 13.0).abs() < 1e-12);
    assert!((slab_transmittance(PI / 3.0, 0.0).0 - 0.83623).abs() < 5e-6);
    assert!((hemispherical_reflectance(N) - 0.091_778_0).abs() < 1e-7);
}

fn add_slab(b: &mut SceneBuilder) {
    let glass = b.add_material(Material::dielectric(N as f32, ABSORPTION.as_vec3()));
    b.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), glass, Vec3::ZERO);
    b.add_plane(Plane::new(-DVec3::Y * THICKNESS, -DVec3::Y), glass, Vec3::ZERO);
}

fn beam_direction(angle: f64) -> DVec3 {
    dvec3(libm::sin(angle), -libm::cos(angle), 0.0)
}

/// Collimated light hits a slab in front of a wall. The fluxes on the wall, reflected and absorbed
/// match the formulas.
#[test]
fn photons_pass_slab_by_its_transmittance() {
    for degrees in [0f64, 30.0, 60.0, 80.0] {
        let angle = degrees.to_radians();
        let mut b = SceneBuilder::new();
        add_slab(&mut b);
        let white = b.add_material(Material::diffuse(grey(0.5)));
        b.add_plane(Plane::new(-DVec3::Y, DVec3::Y), white, Vec3::ZERO);
        // Two tiny grains above the slab determine the width of the beam: photons start within four
        // times the radius of the grains' bounding sphere. One in 10⁶ photons hits a grain.
        for x in [-0.5, 0.5] {
            b.add_shape(Shape::Sphere(Sphere::new(dvec3(x, 5.0, 0.0), 1e-3)), white, Vec3::ZERO);
        }
        b.add_delta_light(
            UnscaledDeltaLight::Directional { direction: beam_direction(angle) },
            LightStrength::Physical(Vec3::ONE),
        );
        let scene = photon_only_scene(b);
        let passes = trace_photon_passes(&scene, StoreMask::CAUSTIC, 1000, PASSES, 1 << 15);
        let (through, back) = per_channel(angle);
        let share = |part: fn(&caustica::photon::EnergyAudit) -> [f64; 3]| {
            let of = |t: &caustica::photon::TracedPhotons| DVec3::from(part(&t.audit)) / DVec3::from(t.audit.emitted);
            passes.iter().map(of).collect::<Vec<DVec3>>()
        };
        assert_mean_rgb(&format!("through a slab at {degrees}°"), &share(|a| a.stopped), through, 4e-3);
        assert_mean_rgb(&format!("back from a slab at {degrees}°"), &share(|a| a.escaped), back, 0.03);
        let stored: Vec<DVec3> = passes
            .iter()
            .map(|t| flux_where(&scene, &t.deposits.surface_photons, |_| true) / DVec3::from(t.audit.emitted))
            .collect();
        assert_mean_rgb(&format!("stored behind a slab at {degrees}°"), &stored, through, 4e-3);
    }
}

/// A camera sees an emissive wall through the slab, under a sky: L = T·Le + R·sky.
///
/// T and R are the slab's transmittance and reflectance. The factors n² of radiance inside the slab
/// cancel.
#[test]
fn camera_sees_slab_transmittance() {
    let (emitted, sky) = (DVec3::new(2.0, 1.0, 3.0), DVec3::new(0.5, 1.0, 0.25));
    for degrees in [0f64, 30.0, 60.0, 80.0] {
        let angle = degrees.to_radians();
        let mut b = SceneBuilder::new();
        add_slab(&mut b);
        let black = b.add_material(Material::black());
        let corner = dvec3(-100.0, -1.0, -100.0);
        let wall = Rectangle::new(corner, DVec3::Z * 200.0, DVec3::X * 200.0);
        b.add_shape(Shape::Rectangle(wall), black, emitted.as_vec3());
        b.set_background(sky.as_vec3());
        let eye = -beam_direction(angle) * 2.0;
        let scene = b.build(square_camera(eye, DVec3::ZERO, 0.01, 8)).unwrap();
        let (through, back) = per_channel(angle);
        let settings = caustica::integrate::Settings {
            camera_paths: camera_ray_settings(1, 1000).camera_paths,
            ..fixed_radius_settings(0, 0, 0.1)
        };
        let samples = mean_radiance_per_pass(&scene, settings, 64);
        // Strong branches are split and weak ones sampled, so there is little noise. Over the field
        // of view, reflectance changes by at most 1.7·10⁻⁴ rad times its slope. This change is odd
        // about the middle of the view, so only its second order matters. It is below 10⁻⁶.
        assert_mean_rgb(&format!("seen through a slab at {degrees}°"), &samples, through * emitted + back * sky, 2e-3);
    }
}

/// Total internal reflection traps a known fraction of light in a glass cube.
///
/// An isotropic light stands at the center of the cube. Reflection in the faces keeps the direction
/// cosines of a ray up to sign. So the fraction 6·(1 − √(1 − 1/n²))/2 of the light, inside the
/// escape cones of six faces, leaves in the end. The rest is trapped.
#[test]
fn total_reflection_traps_light_in_cube() {
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(N as f32, Vec3::ZERO));
    for face in box_faces(-DVec3::ONE, DVec3::ONE, false) {
        b.add_shape(face, glass, Vec3::ZERO);
    }
    b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ZERO }, LightStrength::Power(Vec3::ONE));
    let scene = photon_only_scene(b);
    let escaped = |bounces, paths| {
        let passes = trace_photon_passes(&scene, StoreMask::CAUSTIC, bounces, PASSES, paths);
        passes.iter().map(|t| t.audit.escaped[0] / t.audit.emitted[0]).collect::<Vec<f64>>()
    };
    let critical = (1.0 - 1.0 / (N * N)).sqrt();
    let cone = 0.5 * (1.0 - critical);
    assert!((cone - 0.127_322).abs() < 5e-7);
    // The fraction that leaves at the first face is ∫ (1 − R) over the escape cones.
    let first = midpoint_integral(critical, 1.0, 100_000, |c| 3.0 * (1.0 - fresnel_reflectance(c, 1.0 / N)));
    assert_mean("out of a cube at once", &escaped(1, 1 << 15), first, 1e-5, 2e-3);
    // At least a quarter of 300 bounces are on the pair of faces through which a ray can leave. At
    // cosines within δ of the critical one, the transmittance is about 10√δ. So about 2/(75·10)² of
    // the light is still inside.
    assert_mean("out of a cube at last", &escaped(300, 1 << 12), 6.0 * cone, 2e-5, 3e-3);
}
