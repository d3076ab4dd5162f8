//! Furnace tests: in surroundings of radiance 1, no surface with shading normals is brighter than
//! 1.

use crate::support::{mean_and_error, render_passes, scene_from_text, student_t_tail};
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::scene::Scene;
use rayon::prelude::*;

/// Builds an object of a lossless material under a uniform sky.
///
/// `relief` perturbs the normals of the material, and `view` describes the camera.
fn furnace(object: &str, relief: &str, material: &str, view: &str) -> Scene {
    scene_from_text(&format!(
        "PerspectiveCamera {{ {view}  up 0 0 1  width {SIDE}  height {SIDE} }}
        Lights {{ EnvironmentLight {{ radiance 1 1 1 }} }}
        Textures {{ Noise lumps {{ frequency 5  octaves 3 }} Checker down {{ color0 .9 .2 0  color1 .9 .2 0 }} }}
        Materials {{ {material} m {{ {} {relief} }} }}
        Group {{ MaterialName m {object} }}",
        match material {
            "Diffuse" | "Mirror" => "reflectance 1 1 1",
            "Phong" => "diffuseColor .5 .5 .5  specularColor 8 8 8  shininess 30",
            "Conductor" => "eta .001 .001 .001  k 1000 1000 1000  roughness .6",
            _ => "indexOfRefraction 1.5",
        }
    ))
}

const PASSES: u32 = 8;
const SIDE: usize = 8;

const BALL: &str = "TriangleMesh { obj_file coarse-ball.obj }";
const FLOOR: &str = "Rectangle { corner -50 0 -50  edge0 0 0 100  edge1 100 0 0 }";
const AROUND: &str = "center 0 3 0  direction 0 -1 0  angle 45";
/// Camera that looks along the floor, at an angle of 1 to 6° to it.
const GRAZING: &str = "center -3 .2 0  direction 1 -.06 0  angle 5";

/// Shading normals make no surface brighter than 1 under a sky of radiance 1, by any integrator.
///
/// The albedo is at most 1, so the mean of all passes exceeds 1 only by chance. Student's test over
/// passes has a false-alarm rate of 10⁻⁶.
#[test]
#[ignore = "long: many samples of a hard case"]
fn shading_normals_never_exceed_furnace() {
    let mut cases = Vec::new();
    for material in ["Diffuse", "Phong", "Mirror", "Conductor", "Dielectric", "Thin"] {
        for (object, view) in [(BALL, AROUND), (FLOOR, GRAZING)] {
            for relief in ["", "bump lumps  bumpHeight .3", "bump lumps  bumpHeight 30", "normalMap down"] {
                // A plane without a bump map has only one normal. A normal map needs texture
                // coordinates, which the ball lacks.
                if (object == FLOOR) != relief.is_empty() && !(object == BALL && relief == "normalMap down")
                    || (object == BALL && relief == "bump lumps  bumpHeight .3")
                {
                    cases.push((material, object, view, relief));
                }
            }
        }
    }
    cases.par_iter().for_each(|(material, object, view, relief)| {
        let scene = furnace(object, relief, material, view);
        for algorithm in [Algorithm::Path, Algorithm::Hybrid, Algorithm::Sppm] {
            let what = format!("{material}, {relief}, {algorithm:?}");
            let camera_paths = CameraPathSettings {
                samples_per_pixel: Some(if matches!(*material, "Mirror" | "Thin") { 2 } else { 64 }),
                ..CameraPathSettings::default()
            };
            let settings = Settings {
                unaimed_paths: 1000,
                aimed_paths: 1000,
                initial_gather_radius: Some(0.2),
                allows_ray_photon_balance: false,
                camera_paths,
                ..Settings::default()
            };
            let all = render_passes(&scene, algorithm, settings, PASSES);
            assert!(all.iter().all(|p| p.is_finite() && p.min_element() >= 0.0), "{what}");
            let of = |part: fn(usize) -> bool| {
                let mean = |image: &[Rgb]| {
                    let kept = image.iter().enumerate().filter(|(i, _)| part(i / SIDE)).map(|(_, p)| f64::from(p.x));
                    let (n, sum) = kept.fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x));
                    sum / n
                };
                let means: Vec<f64> = all.chunks(SIDE * SIDE).map(mean).collect();
                mean_and_error(&means)
            };
            // The parts are the whole image, its farthest rows and its nearest rows. The angles at
            // the floor are extreme in these rows.
            for (part, max_relative_error) in
                [(of(|_| true), 0.005), (of(|row| row < 2), 0.015), (of(|row| row >= SIDE - 2), 0.015)]
            {
                let (mean, error) = part;
                // The tolerance of 10⁻⁵ covers colours and sums in single precision.
                let excess = mean - 1.0 - 1e-5;
                let p = if excess <= 0.0 { 1.0 } else { student_t_tail(excess / error, f64::from(PASSES - 1)) };
                assert!(p >= 2e-6, "{what}: {mean} ± {error}");
                assert!(mean > 0.2 && error < max_relative_error, "{what}: {mean} ± {error}");
            }
        }
    });
}
