//! Russian roulette with survival probabilities 0 and 1.
//!
//! A path with survival probability 0 ends, without a division by 0. A path with probability 1
//! always survives.

use crate::support::{assert_mean, render_passes, scene_from_text, test_key};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::photon::{Deposits, PhotonSource, PhotonTracer, StoreMask, TracedPhotons};
use caustica::scene::Scene;
use rayon::prelude::*;

/// Builds a closed room with a light, whose walls have the reflectance `albedo` and emit
/// `radiance`.
fn room(albedo: &str, radiance: f64) -> Scene {
    scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 0 .9  direction 0 0 -1  up 0 1 0  angle 60  width 6  height 6 }}
        Lights {{ PointLight {{ position .1 .2 .3  power 1 2 3 }} }}
        Materials {{ Diffuse wall {{ reflectance {albedo}  emission {radiance} {radiance} {radiance} }} }}
        Group {{ MaterialName wall
            Rectangle {{ corner -1 -1 -1  edge0 0 0 2  edge1 2 0 0 }}
            Rectangle {{ corner -1 1 -1  edge0 2 0 0  edge1 0 0 2 }}
            Rectangle {{ corner -1 -1 -1  edge0 0 2 0  edge1 0 0 2 }}
            Rectangle {{ corner 1 -1 -1  edge0 0 0 2  edge1 0 2 0 }}
            Rectangle {{ corner -1 -1 -1  edge0 2 0 0  edge1 0 2 0 }}
            Rectangle {{ corner -1 -1 1  edge0 0 2 0  edge1 2 0 0 }} }}"
    ))
}

const PATHS: u32 = 1 << 12;
const BOUNCES: u32 = 60;

fn trace(scene: &Scene, index: u64) -> TracedPhotons {
    let source = PhotonSource::emitting_in_all_directions(scene).unwrap();
    let tracer = PhotonTracer { scene, source: &source, mask: StoreMask::ALL, max_bounces: BOUNCES };
    tracer.trace(test_key(90).child_key(index), PATHS, &|_| {})
}

/// Between white walls, no photon path ends before the bounce limit, and its flux keeps all bits.
#[test]
fn white_surfaces_terminate_no_photon() {
    let TracedPhotons { deposits: Deposits { surface_photons: photons, .. }, audit, rays, .. } =
        trace(&room("1 1 1", 0.0), 0);
    assert_eq!((audit.stopped, audit.net_roulette_loss, audit.absorbed), (audit.emitted, [0.0; 3], [0.0; 3]));
    assert_eq!(photons.len() as u64, u64::from(PATHS) * u64::from(BOUNCES + 1));
    assert_eq!(rays, photons.len() as u64);
}

/// Between black walls, each photon lands once. A reflectance of the smallest positive number gives
/// the same result.
#[test]
fn black_surfaces_terminate_every_photon() {
    for albedo in ["0 0 0", "1e-45 1e-45 1e-45", "0 0 1e-40"] {
        let TracedPhotons { deposits: Deposits { surface_photons: photons, .. }, audit, rays, .. } =
            trace(&room(albedo, 0.0), 0);
        assert_eq!((photons.len() as u32, rays), (PATHS, u64::from(PATHS)), "{albedo}");
        assert_eq!((audit.absorbed, audit.stopped), (audit.emitted, [0.0; 3]), "{albedo}");
        assert!(audit.net_roulette_loss.iter().all(|r| r.is_finite() && r.abs() < 1e-30), "{albedo}: {audit:?}");
    }
}

/// Channels that walls absorb stay zero, and roulette conserves the mean flux.
///
/// Walls reflect one color channel, which has half of the light's flux, and absorb the others. Half
/// of the paths survive the first roulette with doubled flux; later roulette ends no path. The mean
/// flux over 16 passes of 2¹² paths is accurate to 1/256. A photon's flux rounds a few times, and
/// its stored color rounds to 2⁻¹⁷.
#[test]
fn zero_channel_stays_zero() {
    let scene = room("0 0 1", 0.0);
    let kept: Vec<f64> = (0..16)
        .map(|i| {
            let TracedPhotons { deposits: Deposits { surface_photons: photons, .. }, audit, .. } = trace(&scene, i);
            assert_eq!(audit.stopped[..2], [0.0; 2]);
            let on = photons[..].iter().filter(|p| p.attributes.flux().x == 0.0);
            let twice = 2.0 * 3.0 / f64::from(PATHS);
            let mut strengths = on.map(|p| f64::from(p.attributes.flux().z) / twice - 1.0);
            assert!(strengths.all(|off| off.abs() < 1e-5), "{audit:?}");
            // A surviving photon lands once more for each allowed bounce.
            let survivors = (photons.len() - PATHS as usize) / BOUNCES as usize;
            assert_eq!(photons.len(), PATHS as usize + survivors * BOUNCES as usize);
            assert!((audit.stopped[2] / (survivors as f64 * twice) - 1.0).abs() < 1e-5, "{audit:?}");
            audit.stopped[2] / audit.emitted[2]
        })
        .collect();
    assert_mean("flux of one channel", &kept, 1.0, 1e-5, 0.006);
}

fn settings(samples: u32, max_bounces: u32, seed: u64) -> Settings {
    Settings {
        camera_paths: CameraPathSettings {
            samples_per_pixel: Some(samples),
            max_bounces,
            seed,
            ..CameraPathSettings::default()
        },
        ..Settings::default()
    }
}

/// Camera paths also end or survive with certainty at survival probabilities 0 and 1.
///
/// Between walls that emit and reflect nothing, camera paths return exactly the emission for all
/// random numbers. Between walls that reflect everything, each allowed bounce adds the emission of
/// a wall, and next-event estimation adds it once more.
#[test]
fn camera_paths_follow_same_roulette() {
    let dark = room("0 0 0", 0.25);
    for algorithm in [Algorithm::Path, Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Distributed] {
        let quick = Settings {
            unaimed_paths: 100,
            aimed_paths: 100,
            initial_gather_radius: Some(0.1),
            allows_ray_photon_balance: false,
            ..settings(4, 10, 0)
        };
        let image = render_passes(&dark, algorithm, quick, 1);
        assert!(image.iter().all(|p| (*p - 0.25).abs().max_element() < 1e-6), "{algorithm:?}: {image:?}");
    }
    let white = room("1 1 1", 0.001);
    let lamp = room("1 1 1", 0.0);
    for (bounces, samples) in [(0u32, 512), (3, 192), (12, 96)] {
        let mean = |scene: &Scene, seed| {
            let image = render_passes(scene, Algorithm::Path, settings(samples, bounces, seed), 1);
            image.iter().map(|p| f64::from(p.x)).sum::<f64>() / image.len() as f64
        };
        // The difference removes the light of the lamp, which both rooms see by the same paths.
        let samples: Vec<f64> = (0..16).into_par_iter().map(|seed| mean(&white, seed) - mean(&lamp, seed)).collect();
        let expected = 0.001 * f64::from(bounces + 2);
        assert_mean(&format!("{bounces} bounces"), &samples, expected, 1e-6 * expected, 0.005);
    }
}
