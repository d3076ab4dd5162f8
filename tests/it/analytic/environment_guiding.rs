//! Guided shadow rays to the environment light.

use crate::support::*;
use caustica::integrate::{Algorithm, IndirectPhotons, Settings};
use caustica::scene::Scene;

/// Edge of the hole in the ceiling \[length].
const HOLE: f64 = 0.3;

/// Height of the ceiling above the floor \[length].
const HEIGHT: f64 = 2.0;

const REFLECTANCE: f64 = 0.8;

/// Radiance of the sky.
const RADIANCE: f64 = 3.0;

/// A black box with a white floor. The sky lights it through a square hole in the ceiling. The
/// camera sees the square from −1 to 1 of the floor. `inside` is further scene text.
fn box_with_hole(inside: &str) -> Scene {
    let (low, high) = (-0.5 * HOLE, 0.5 * HOLE);
    let side = |corner: &str, edges: &str| format!("Rectangle {{ corner {corner} {edges} }}\n");
    let ceiling = [
        side("-2 2 -2", &format!("edge0 4 0 0  edge1 0 0 {}", low + 2.0)),
        side(&format!("-2 2 {high}"), &format!("edge0 4 0 0  edge1 0 0 {}", 2.0 - high)),
        side(&format!("-2 2 {low}"), &format!("edge0 {} 0 0  edge1 0 0 {HOLE}", low + 2.0)),
        side(&format!("{high} 2 {low}"), &format!("edge0 {} 0 0  edge1 0 0 {HOLE}", 2.0 - high)),
    ];
    let text = format!(
        "OrthographicCamera {{ center 0 1.5 0  direction 0 -1 0  up 0 0 1  size 2  width 16  height 16 }}
         Background {{ color 0 0 0 }}
         Lights {{ EnvironmentLight {{ radiance {RADIANCE} {RADIANCE} {RADIANCE} }} }}
         Media {{ Medium fog {{ scattering .4 .4 .4  absorption .1 .1 .1 }} }}
         Materials {{
             Diffuse black {{ reflectance 0 0 0 }}
             Diffuse white {{ reflectance {REFLECTANCE} {REFLECTANCE} {REFLECTANCE} }}
             Clear air {{ medium fog }}
         }}
         Group {{
             MaterialName black
             {}
             Rectangle {{ corner -2 0 -2  edge0 4 0 0  edge1 0 2 0 }}
             Rectangle {{ corner -2 0 2  edge0 4 0 0  edge1 0 2 0 }}
             Rectangle {{ corner -2 0 -2  edge0 0 0 4  edge1 0 2 0 }}
             Rectangle {{ corner 2 0 -2  edge0 0 0 4  edge1 0 2 0 }}
             MaterialName white
             Rectangle {{ corner -2 0 -2  edge0 4 0 0  edge1 0 0 4 }}
             {inside}
         }}",
        ceiling.concat()
    );
    scene_from_text_in("scenes", &text)
}

/// Returns the mean over the picture for each pass, and the mean variance of a pixel between
/// passes.
///
/// Also checks that shadow rays are guided if `guided` is true, and only then.
fn means_and_variance(scene: &Scene, algorithm: Algorithm, guided: bool, passes: u32) -> (Vec<f64>, f64) {
    let settings = Settings {
        allows_environment_guiding: guided,
        allows_scatter_point_guiding: false,
        indirect_photons: IndirectPhotons::Off,
        allows_ray_photon_balance: false,
        ..camera_ray_settings(4, 20)
    };
    let integrator = algorithm.prepare(scene, settings);
    let report = integrator.environment_guiding_report();
    assert_eq!(report.is_some_and(|report| report.used), guided, "{report:?}");
    let red = |pass| render_one_pass(&*integrator, pass).iter().map(|l| f64::from(l.x)).collect::<Vec<f64>>();
    let pictures: Vec<Vec<f64>> = (0..passes).map(red).collect();
    let pixels = pictures[0].len();
    let variance = |i: usize| {
        let values: Vec<f64> = pictures.iter().map(|picture| picture[i]).collect();
        let error = mean_and_error(&values).1;
        error * error * f64::from(passes)
    };
    let means = pictures.iter().map(|picture| picture.iter().sum::<f64>() / pixels as f64).collect();
    (means, (0..pixels).map(variance).sum::<f64>() / pixels as f64)
}

/// Returns the mean radiance of the visible floor: the mean of (ρ/π)·L·∫ cos²θ/r² dA over the
/// floor.
///
/// The integral is over the hole, at distance r and angle θ. L is the sky's radiance, and ρ the
/// floor's albedo.
fn mean_floor_radiance() -> f64 {
    const STEPS: u32 = 24;
    let at = |i: u32, size: f64| size * ((f64::from(i) + 0.5) / f64::from(STEPS) - 0.5);
    let mut sum = 0.0;
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        for (k, l) in (0..STEPS).flat_map(|k| (0..STEPS).map(move |l| (k, l))) {
            let (x, z) = (at(i, 2.0) - at(k, HOLE), at(j, 2.0) - at(l, HOLE));
            let square = x * x + z * z + HEIGHT * HEIGHT;
            sum += HEIGHT * HEIGHT / (square * square);
        }
    }
    let pairs = f64::from(STEPS * STEPS) * f64::from(STEPS * STEPS);
    REFLECTANCE / std::f64::consts::PI * RADIANCE * HOLE * HOLE * sum / pairs
}

/// Guided and unguided shadow rays give the radiance of the closed form.
///
/// Guided rays have at most a tenth of the variance of unguided ones. The error of midpoint
/// quadrature is at most 10⁻⁴. The hole covers at most 1/100 of the hemisphere.
#[test]
fn guided_shadow_rays_keep_light_through_holes() {
    let scene = box_with_hole("");
    let expected = mean_floor_radiance();
    for algorithm in [Algorithm::Hybrid, Algorithm::Distributed] {
        let (means, variance) = means_and_variance(&scene, algorithm, true, 200);
        let (usual, usual_variance) = means_and_variance(&scene, algorithm, false, 800);
        assert_mean(&format!("{algorithm:?}, guided"), &means, expected, 1e-4 * expected, 0.02);
        assert_mean(&format!("{algorithm:?}, unguided"), &usual, expected, 1e-4 * expected, 0.05);
        eprintln!("variance {variance} guided, {usual_variance} unguided");
        assert!(variance < 0.1 * usual_variance, "{algorithm:?}: {variance} guided, {usual_variance} unguided");
    }
}

/// In fog too, guided and unguided shadow rays give the same mean, within five standard errors.
#[test]
#[ignore = "long: many passes in fog"]
fn guided_shadow_rays_keep_light_in_fog() {
    let scene = box_with_hole("MaterialName air  Box { min -1.5 .2 -1.5  max 1.5 1.2 1.5 }");
    let (means, variance) = means_and_variance(&scene, Algorithm::Path, true, 600);
    let (usual, usual_variance) = means_and_variance(&scene, Algorithm::Path, false, 3000);
    let ((mean, error), (usual, usual_error)) = (mean_and_error(&means), mean_and_error(&usual));
    let tolerance = 5.0 * error.hypot(usual_error);
    eprintln!("{mean} ± {error}, {usual} ± {usual_error}, variances {variance} {usual_variance}");
    assert!(tolerance < 0.06 * mean, "too blunt: {tolerance} of {mean}");
    assert!((mean - usual).abs() < tolerance, "{mean} ± {error} guided, {usual} ± {usual_error} unguided");
}

/// Shadow rays to an open sky are not guided, so the setting changes no bit.
///
/// Half of all shadow rays from a floor under the open sky reach the sky, so guiding is of no use.
#[test]
fn open_scenes_guide_no_shadow_rays() {
    let scene = scene_from_text_in(
        "scenes",
        "PerspectiveCamera { center 0 1 4  direction 0 -.2 -1  angle 60  width 16  height 12 }
         Lights { EnvironmentLight { radiance 1 1 1 } }
         Materials { Diffuse floor { reflectance .7 .7 .7 } }
         Group { MaterialName floor  Plane { normal 0 1 0  offset 0 }  Sphere { center 0 .5 0  radius .5 } }",
    );
    let picture = |guides_environment| {
        let settings = Settings {
            allows_environment_guiding: guides_environment,
            allows_ray_photon_balance: false,
            ..camera_ray_settings(2, 10)
        };
        let integrator = Algorithm::Hybrid.prepare(&scene, settings);
        assert!(!integrator.environment_guiding_report().is_some_and(|report| report.used));
        render_one_pass(&*integrator, 0)
    };
    assert_eq!(picture(true), picture(false));
}
