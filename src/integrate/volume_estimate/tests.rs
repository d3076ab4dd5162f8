//! Tests of photon estimates near walls, against closed forms.

use super::*;
use crate::camera::Camera;
use crate::medium::PhaseFunction;
use crate::photon::VolumePhoton;
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effects, Material, SceneBuilder, SpectralInterior};
use crate::shape::{Cuboid, Rectangle, Shape};
use glam::{DVec3, Vec2};
use std::f64::consts::PI;

/// Number of independent photon maps per mean.
const PASSES: u64 = 32;

/// Kernel radius \[length]; the room has edges of length 2.
const RADIUS: f32 = 0.2;

const EXTINCTION: f32 = 0.5;
const SCATTERING: f32 = 0.3;

fn test_key(pass: u64, i: u64) -> Key {
    Key::new(31).purpose_key(Purpose::Test).child_key(pass).child_key(i)
}

/// Returns a cube from −1 to 1 full of fog; if `divided`, with a thin wall in the plane y = 0.
fn foggy_room(divided: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    let black = builder.add_material(Material::black());
    let (absorption, scattering) = (Rgb::splat(EXTINCTION - SCATTERING), Rgb::splat(SCATTERING));
    let fog = Medium::homogeneous(absorption, scattering, Rgb::ZERO, PhaseFunction::Isotropic);
    let fog = builder.add_medium(fog);
    builder.set_ambient_medium(fog);
    builder.add_shape(Shape::Cuboid(Cuboid::new(-DVec3::ONE, DVec3::ONE).unwrap()), black, Rgb::ZERO);
    if divided {
        let wall = Rectangle::new(DVec3::new(-1.0, 0.0, -1.0), DVec3::X * 2.0, DVec3::Z * 2.0);
        builder.add_shape(Shape::Rectangle(wall), black, Rgb::ZERO);
    }
    builder.build(Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 4).unwrap()).unwrap()
}

/// Returns the mean and standard error of the radiance, and of each nested difference, over
/// independent maps of `photons`, along the ray from `origin` in the direction of x.
fn estimates_along_x(
    scene: &Scene,
    origin: Vec3,
    estimate: VolumeEstimator,
    photons: impl Fn(u64) -> VolumePhotons,
) -> [(f64, f64); NESTED_DISC_COUNT] {
    let mut samples = [const { Vec::new() }; NESTED_DISC_COUNT];
    for pass in 0..PASSES {
        let maps = BeamAndPointMaps::build(photons(pass), (RADIUS, RADIUS), estimate, 0.0);
        let mut means = [0.0; NESTED_DISC_COUNT];
        const RAYS: u32 = 64;
        for i in 0..RAYS {
            let sampler = Sampler::new(test_key(pass, 1 << 40), i, RAYS);
            let ray = Ray::new(origin, Vec3::X);
            let mut path_ray = scene.start_camera_path::<SpectralInterior>(ray, Effects::ALL);
            path_ray.next_vertex(scene, sampler.sample_key(), |segment| {
                let (history, throughput) = (crate::integrate::vertex::PathHistory::default(), Rgb::ONE);
                let segment = MediumPathSegment { segment, history, throughput, sampler, shadow_sampler: sampler };
                let mut task = PathTask::new(true, false);
                let mut rng = sampler.sample_key().medium_tracking_key(pass as u32).rng();
                let radiance = maps.radiance(scene, &segment, 1.0, &mut rng, &mut task);
                task.pixel.nested.finish_camera_ray(Some(1.0));
                let differences = task.pixel.nested.finish_pixel(1).differences;
                for (mean, value) in means.iter_mut().zip([radiance, differences[0], differences[1]]) {
                    *mean += f64::from(value.x) / f64::from(RAYS);
                }
                None
            });
        }
        samples.iter_mut().zip(means).for_each(|(all, mean)| all.push(mean));
    }
    samples.map(|all| {
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n;
        (mean, (all.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n * (n - 1.0))).sqrt())
    })
}

fn transmittance(distance: f32) -> f32 {
    libm::expf(-EXTINCTION * distance)
}

/// Returns the photons of parallel light of irradiance 1 along z, as beams or as points.
fn parallel_light(pass: u64, estimate: VolumeEstimator) -> VolumePhotons {
    let mut photons = VolumePhotons::default();
    let count = 40_000;
    for i in 0..count {
        let key = test_key(pass, i);
        let place = 2.0 * key.uniform_2d(Dimension::LightPosition) - Vec2::ONE;
        if estimate == VolumeEstimator::Beams {
            let flux = Rgb::splat(4.0 / count as f32);
            photons.beams.push(PhotonBeam::new(place.extend(-1.0), Vec3::Z, 2.0, flux, 0, 0).unwrap());
        } else {
            let depth = 2.0 * key.uniform_1d(Dimension::ScatterPoint);
            let flux = Rgb::splat(8.0 / count as f32 * SCATTERING * transmittance(depth));
            photons.points.push(VolumePhoton::new(place.extend(depth - 1.0), flux, Vec3::Z, 0, 0).unwrap());
        }
    }
    photons
}

/// Estimates with every kernel size agree with single scattering, although up to half of the kernel
/// lies behind a wall.
///
/// Along a ray beside the wall and across parallel light, the scattered radiance is σs/(4π) ·
/// exp(−σt s) · (1 − exp(−σt L))/σt.
#[test]
#[ignore = "long: statistics against a closed form"]
fn estimates_beside_a_wall_match_single_scattering() {
    for estimate in [VolumeEstimator::Beams, VolumeEstimator::BeamRadiance, VolumeEstimator::Points] {
        for part in [0.02, 0.5, 2.0f32] {
            let origin = Vec3::new(-0.99, RADIUS * part - 1.0, 0.2);
            let along = (1.0 - transmittance(1.99)) / EXTINCTION;
            let expected = f64::from(SCATTERING * transmittance(1.2) * along) / (4.0 * PI);
            let means = estimates_along_x(&foggy_room(false), origin, estimate, |pass| parallel_light(pass, estimate));
            // Coverages measured by 8 or 12 probe rays differ from the true ones by a few percent.
            let slack = if estimate == VolumeEstimator::Beams || part > 1.0 { 0.0 } else { 0.01 };
            for ((mean, error), (expected, sharp)) in
                means.into_iter().zip([(expected, 0.03), (0.0, 0.03), (0.0, 0.03)])
            {
                let tolerance = 5.0 * error + slack * expected;
                assert!(
                    (mean - expected).abs() < tolerance,
                    "{estimate:?} at {part} radii: {mean}, not {expected} ± {error}"
                );
                assert!(error < sharp * means[0].0, "{estimate:?} at {part} radii: {error}");
            }
        }
    }
}

/// A wall thinner than the kernel hides the light behind it: half of the room is lit, and a ray
/// beside the wall in the dark half finds no light.
#[test]
fn light_behind_a_thin_wall_does_not_leak() {
    for estimate in [VolumeEstimator::Beams, VolumeEstimator::BeamRadiance, VolumeEstimator::Points] {
        let lit = |pass| {
            let VolumePhotons { mut beams, mut points } = parallel_light(pass, estimate);
            beams.retain(|beam| beam.start.y > 0.0);
            points.retain(|point| point.position.y > 0.0);
            VolumePhotons { beams, points }
        };
        let shade = Vec3::new(-0.99, -0.3 * RADIUS, 0.2);
        let [(leaked, error), ..] = estimates_along_x(&foggy_room(false), shade, estimate, lit);
        let [(hidden, hidden_error), ..] = estimates_along_x(&foggy_room(true), shade, estimate, lit);
        assert!(leaked > 20.0 * error, "{estimate:?}: {leaked} ± {error}");
        assert!(hidden.abs() < 5.0 * hidden_error + 1e-6 * leaked, "{estimate:?}: {hidden} ± {hidden_error}");
    }
}
