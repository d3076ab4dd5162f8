//! Energy audit: no flux is lost or created, and Russian roulette changes no mean.

use crate::support::*;
use caustica::photon::{StoreMask, TracedPhotons};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Shape, Sphere};
use glam::{DVec3, Vec3};

/// Builds a room with coloured walls and an open front. It holds a light, an absorbing ball, a
/// mirror and a glossy ball.
fn scene_of_all_kinds() -> Scene {
    let mut b = SceneBuilder::new();
    let walls = b.add_material(Material::diffuse(Vec3::new(0.9, 0.4, 0.1)));
    let gloss = b.add_material(Material::phong(Vec3::new(0.2, 0.3, 0.4), Vec3::splat(2.0), 20.0));
    let glass = b.add_material(Material::dielectric(1.5, Vec3::new(0.1, 1.0, 3.0)));
    let mirror = b.add_material(Material::mirror(Vec3::new(0.95, 0.8, 0.6)));
    for face in box_faces(-DVec3::ONE, DVec3::ONE, true).into_iter().take(5) {
        b.add_shape(face, walls, Vec3::ZERO);
    }
    let mut ball = |p, m, e| {
        b.add_shape(Shape::Sphere(Sphere::new(p, 0.3)), m, e);
    };
    ball(dvec3(-0.5, -0.5, 0.0), gloss, Vec3::ZERO);
    ball(dvec3(0.5, -0.5, 0.0), glass, Vec3::ZERO);
    ball(dvec3(0.0, 0.5, -0.5), mirror, Vec3::ZERO);
    ball(dvec3(-0.6, 0.6, 0.6), walls, Vec3::new(3.0, 2.0, 1.0));
    b.add_delta_light(
        UnscaledDeltaLight::Point { position: DVec3::ZERO },
        LightStrength::Power(Vec3::new(5.0, 6.0, 7.0)),
    );
    photon_only_scene(b)
}

/// Emitted flux equals absorbed, escaped, stopped and roulette flux, up to rounding.
///
/// Each vertex adds at most four differences to the audit: absorbed in the medium, absorbed at the
/// surface, roulette, and the rest. Each difference has the relative rounding error u = 2⁻²⁴.
/// Roulette keeps the mean of the channels and nothing raises it. So no channel exceeds three times
/// the mean of the emitted flux, and the balance holds within 4u · 3 · mean · (rays per path). Sums
/// are in double precision.
#[test]
fn flux_is_conserved_up_to_rounding() {
    let scene = scene_of_all_kinds();
    for (mask, bounces) in
        [(StoreMask::ALL, 1000), (StoreMask::INDIRECT, 3), (StoreMask::CAUSTIC, 1000), (StoreMask::ALL, 0)]
    {
        for TracedPhotons { audit, rays, paths, .. } in trace_photon_passes(&scene, mask, bounces, 4, 1 << 14) {
            let mean = audit.emitted.iter().sum::<f64>() / 3.0;
            let bound = 12.0 * mean * rays as f64 / paths as f64 / 16_777_216.0;
            for c in 0..3 {
                let gone = audit.absorbed[c] + audit.escaped[c] + audit.stopped[c] + audit.net_roulette_loss[c];
                assert!((audit.emitted[c] - gone).abs() <= bound, "{mask:?} {c}: {audit:?}");
            }
        }
    }
}

/// Roulette removes and adds the same flux on average.
///
/// The measured standard error must be below 2·10⁻³ of the emitted flux, so that the test can find
/// an error.
#[test]
fn roulette_is_unbiased() {
    let passes = trace_photon_passes(&scene_of_all_kinds(), StoreMask::ALL, 1000, 64, 1 << 13);
    for c in 0..3 {
        let share: Vec<f64> = passes.iter().map(|t| 1.0 + t.audit.net_roulette_loss[c] / t.audit.emitted[c]).collect();
        assert_mean(&format!("roulette's share, channel {c}"), &share, 1.0, 0.0, 2e-3);
    }
}

/// In a closed grey room, the number of surfaces that a path visits has a geometric distribution.
///
/// A path survives each surface with the probability ρ. So N paths hit N/(1 − ρ) surfaces on
/// average, with variance Nρ/(1 − ρ)². The law depends neither on geometry nor on the scrambled
/// emission. The roulette account is f·(N − (1 − ρ)·surfaces), where f is the flux of a path. Its
/// variance is f²Nρ: Σ X²(1/p − 1) over the N/(1 − ρ) surfaces, with X = ρf and p = ρ.
#[test]
fn path_lengths_in_grey_room_are_geometric() {
    const N: f64 = 16.0;
    for albedo in [0.3, 0.75] {
        let mut b = SceneBuilder::new();
        let wall = b.add_material(Material::diffuse(grey(albedo)));
        for face in box_faces(-DVec3::ONE, DVec3::ONE, true) {
            b.add_shape(face, wall, Vec3::ZERO);
        }
        b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::splat(0.2) }, LightStrength::Power(grey(N)));
        let passes = trace_photon_passes(&photon_only_scene(b), StoreMask::ALL, 10_000, 20_000, N as u32);
        let landed: Vec<f64> = passes.iter().map(|t| t.deposits.surface_photons.len() as f64).collect();
        assert_mean(&format!("photons a path, ρ = {albedo}"), &landed, N / (1.0 - albedo), 0.0, 2e-3);
        let variance = N * albedo / ((1.0 - albedo) * (1.0 - albedo));
        let squares: Vec<f64> = landed.iter().map(|n| n - N / (1.0 - albedo)).map(|d| d * d).collect();
        assert_mean(&format!("their variance, ρ = {albedo}"), &squares, variance, 0.0, 0.015);
        let roulette: Vec<f64> = passes.iter().map(|t| t.audit.net_roulette_loss[0]).map(|r| r * r).collect();
        assert_mean(&format!("variance of roulette, ρ = {albedo}"), &roulette, N * albedo, 1e-5, 0.015);
        assert!(
            passes.iter().all(|t| t.rays == t.deposits.surface_photons.len() as u64),
            "each ray lands in a closed room"
        );
    }
}
