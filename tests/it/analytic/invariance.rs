//! Invariances: transforms and settings that must change no bit of the result, or change it only
//! within noise.

use crate::support::*;
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use caustica::photon::{PhotonSource, StoreMask};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Disc, Rectangle, Shape, Sphere};
use glam::{DQuat, DVec2, DVec3, Vec3};

/// A similarity transform of space.
#[derive(Clone, Copy)]
struct Placement {
    turn: DQuat,
    scale: f64,
    origin: DVec3,
}

const HERE: Placement = Placement { turn: DQuat::IDENTITY, scale: 1.0, origin: DVec3::ZERO };

impl Placement {
    fn point(&self, p: DVec3) -> DVec3 {
        self.origin + self.vector(p)
    }

    fn vector(&self, v: DVec3) -> DVec3 {
        self.turn * v * self.scale
    }
}

/// Builds a room with a glass ball, a mirror ball, a curved mirror mesh, an area light and a point
/// light, transformed by `at`.
fn room_scene(at: Placement) -> Scene {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Vec3::new(0.7, 0.6, 0.4)));
    let glass = b.add_material(Material::dielectric(1.5, Vec3::ZERO));
    let mirror = b.add_material(Material::mirror(Vec3::new(0.9, 0.8, 0.7)));
    let black = b.add_material(Material::black());
    let (x, y, z) = (DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0);
    for (e0, e1) in [(z, x), (y, z), (x, y)] {
        let wall = Rectangle::new(at.point(-DVec3::ONE), at.vector(e0), at.vector(e1));
        b.add_shape(Shape::Rectangle(wall), white, Vec3::ZERO);
    }
    let mut ball = |p, radius: f64, material| {
        b.add_shape(Shape::Sphere(Sphere::new(at.point(p), radius * at.scale)), material, Vec3::ZERO);
    };
    ball(dvec3(-0.3, -0.4, 0.3), 0.35, glass);
    ball(dvec3(0.5, -0.6, -0.3), 0.3, mirror);
    let lamp = Disc::circular_disc(at.point(dvec3(0.2, 0.9, 0.2)), at.vector(-DVec3::Y), 0.15 * at.scale);
    b.add_shape(Shape::Disc(lamp), black, Vec3::new(20.0, 30.0, 40.0));
    let sail = [dvec3(-0.9, -0.9, -0.4), dvec3(-0.4, -0.9, -0.9), dvec3(-0.9, 0.3, -0.8)].map(|p| at.point(p));
    b.add_mesh(&sail, &[], &[[0, 1, 2]], mirror, Vec3::ZERO);
    let point = UnscaledDeltaLight::Point { position: at.point(dvec3(0.6, 0.5, 0.8)) };
    // Intensity scales with area, like the power of an area light of given radiance.
    b.add_delta_light(point, LightStrength::Physical(grey(0.4 * at.scale * at.scale)));
    let (eye, target) = (at.point(dvec3(2.5, 1.0, 2.5)), at.point(dvec3(0.0, -0.4, 0.0)));
    let up = at.turn * DVec3::Y;
    let view = caustica::camera::Camera::perspective(eye, target - eye, up, 0.8, 48, 48).unwrap();
    b.build(view).unwrap()
}

fn estimates_at_photons() -> Settings {
    Settings {
        gather_k: Some(30),
        initial_gather_radius: None,
        camera_paths: camera_ray_settings(2, 1000).camera_paths,
        ..fixed_radius_settings(20_000, 20_000, 1.0)
    }
}

fn mean_image(scene: &Scene, pass: u32) -> Vec<Vec3> {
    Algorithm::Sppm.prepare(scene, estimates_at_photons()).render_pass(pass, &SilentMonitor).image
}

/// Fails if the passes of two settings differ in their mean.
///
/// Passes are compared in pairs. `max_relative_error` limits the noise, as in [`assert_mean`].
fn assert_same_images(what: &str, a: &[DVec3], b: &[DVec3], max_relative_error: f64) {
    for c in 0..3 {
        let level = b.iter().map(|v| v[c]).sum::<f64>() / b.len() as f64;
        let samples: Vec<f64> = a.iter().zip(b).map(|(a, b)| level + a[c] - b[c]).collect();
        assert_mean(
            &format!("{what}, channel {c}"),
            &samples,
            level,
            level * STORED_COLOR_ROUNDING,
            max_relative_error,
        );
    }
}

#[test]
fn thread_count_changes_no_bit() {
    let scene = room_scene(HERE);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| mean_image(&scene, 1))
    };
    let one = on(1);
    assert!(one.iter().all(|v| v.is_finite()) && one.iter().any(|v| v.x > 0.0));
    for threads in [2, 3, 8] {
        assert!(on(threads) == one, "{threads} threads");
    }
}

/// Scaling a scene by a power of two changes no bit of the image.
///
/// It changes exponents only, so no rounding differs.
#[test]
fn scaling_by_powers_of_two_changes_no_bit() {
    let here = mean_image(&room_scene(HERE), 0);
    for scale in [0.125, 4.0, 1024.0] {
        let there = mean_image(&room_scene(Placement { scale, ..HERE }), 0);
        let differ = here.iter().zip(&there).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "pixels that differ at scale {scale}");
    }
}

/// Returns the flux that reaches a patch of the floor through the glass ball in each pass, divided
/// by the squared scale.
///
/// The patch is fixed in the coordinates of the room before it is placed by `at`.
fn stored_photon_fluxes(at: Placement, aimed: bool, mask: StoreMask, passes: u32, paths: u32) -> Vec<DVec3> {
    let scene = room_scene(at);
    let source =
        if aimed { PhotonSource::aimed_at_casters(&scene) } else { PhotonSource::emitting_in_all_directions(&scene) };
    let inside = |p: DVec3| {
        let local = at.turn.inverse() * (p - at.origin) / at.scale;
        let floor = DVec2::new(local.x, local.z);
        local.y < -0.999 && (floor - DVec2::new(-0.4, 0.25)).length() < 0.3
    };
    trace_passes_from_source(&scene, &source.unwrap(), mask, 50, passes, paths)
        .iter()
        .map(|t| flux_where(&scene, &t.deposits.surface_photons, inside) / (at.scale * at.scale))
        .collect()
}

#[test]
#[ignore = "long: statistics against a closed form"]
fn similarity_transforms_preserve_flux() {
    let here = stored_photon_fluxes(HERE, true, StoreMask::CAUSTIC, PASSES, 1 << 15);
    let all = stored_photon_fluxes(HERE, false, StoreMask::ALL, PASSES, 1 << 15);
    let turn = DQuat::from_axis_angle(dvec3(1.0, 2.0, -1.0).normalize(), 1.0);
    for (name, place) in [
        ("turned", Placement { turn, ..HERE }),
        ("scaled by 1000", Placement { scale: 1000.0, ..HERE }),
        ("scaled by 1/3000", Placement { scale: 1.0 / 3000.0, ..HERE }),
        ("moved", Placement { origin: dvec3(2e5, -1e5, 3e5), ..HERE }),
        ("all at once", Placement { turn, scale: 37.0, origin: dvec3(2e7, 3e6, -1e7) }),
    ] {
        assert_same_images(
            &format!("{name}, caustics"),
            &stored_photon_fluxes(place, true, StoreMask::CAUSTIC, PASSES, 1 << 15),
            &here,
            5e-3,
        );
        assert_same_images(
            &format!("{name}, all"),
            &stored_photon_fluxes(place, false, StoreMask::ALL, PASSES, 1 << 15),
            &all,
            0.02,
        );
    }
}

/// Images of scaled, moved and rotated rooms differ only by rounding.
///
/// Random numbers depend only on the seed. So paths are equal, except for a few photons that
/// rounding sends on another path.
#[test]
#[ignore = "long: statistics against a closed form"]
fn similarity_transforms_preserve_radiance() {
    let mean = |at: Placement| mean_radiance_per_pass(&room_scene(at), estimates_at_photons(), 8);
    let here = mean(HERE);
    for (name, place) in [
        ("scaled by 1000", Placement { scale: 1000.0, ..HERE }),
        ("moved", Placement { origin: dvec3(2e5, -1e5, 3e5), ..HERE }),
        ("turned", Placement { turn: DQuat::from_axis_angle(dvec3(1.0, 2.0, -1.0).normalize(), 1.0), ..HERE }),
    ] {
        assert_same_images(&format!("{name}, picture"), &mean(place), &here, 0.01);
    }
}

/// Aiming changes which photons are sampled, but not their mean flux.
///
/// Unaimed passes that store photons of every kind hold the same caustic photons as unaimed passes
/// that store only caustics.
#[test]
#[ignore = "long: statistics against a closed form"]
fn aimed_emission_preserves_caustics() {
    let aimed = stored_photon_fluxes(HERE, true, StoreMask::CAUSTIC, 32, 1 << 15);
    let everywhere = stored_photon_fluxes(HERE, false, StoreMask::CAUSTIC, 32, 1 << 17);
    assert_same_images("aimed against everywhere", &aimed, &everywhere, 5e-3);
    let scene = room_scene(HERE);
    let count = |mask| trace_photon_passes(&scene, mask, 50, 1, 1 << 14)[0].deposits.surface_photons.len();
    let apart = [StoreMask::DIRECT, StoreMask::CAUSTIC, StoreMask::INDIRECT];
    assert_eq!(apart.map(count).iter().sum::<usize>(), count(StoreMask::ALL), "classes are disjoint and complete");
    assert_eq!(count(apart[1]), count(StoreMask::CAUSTIC));
}
