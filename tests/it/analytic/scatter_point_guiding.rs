//! Guided sampling of the points in media from which shadow rays start.

use crate::support::*;
use caustica::integrate::{Algorithm, Settings};
use caustica::scene::Scene;

/// Scattering coefficient of the thin fog around a beam \[1/length].
const THIN: f64 = 1e-3;

/// Intensity of the spot light that makes the beam \[W/sr].
const INTENSITY: f64 = 5000.0;

/// A beam of a spot light in thin fog, seen from the side.
///
/// The light is at x = −5. Its cone has a half angle of 6°, and the fog reaches from x = −1 to 1.
fn beam_in_thin_fog() -> Scene {
    let text = format!(
        "OrthographicCamera {{ center 0 0 5  direction 0 0 -1  up 0 1 0  size 3  width 32  height 24 }}
         Background {{ color 0 0 0 }}
         Lights {{ SpotLight {{ position -5 0 0  direction 1 0 0  angle 12  intensity {INTENSITY} {INTENSITY} {INTENSITY} }} }}
         Media {{ Medium fog {{ scattering {THIN} {THIN} {THIN} }} }}
         Materials {{ Clear air {{ medium fog }} }}
         Group {{ MaterialName air  Box {{ min -1 -1.5 -1.5  max 1 1.5 1.5 }} }}"
    );
    scene_from_text_in("scenes", &text)
}

/// A lamp behind a slit sends a sheet of light through colored fog.
fn sheet_of_light_in_fog() -> Scene {
    scene_from_text_in(
        "scenes",
        "PerspectiveCamera { center 0 .3 3.4  direction 0 0 -1  angle 50  width 16  height 12 }
         Background { color 0 0 0 }
         Lights { RectangleLight { corner -.4 2.6 -.4  edge0 .8 0 0  edge1 0 0 .8  radiance 90 90 90 } }
         Media { Medium fog { scattering .1 .15 .25  absorption .05 0 0  anisotropy .4 } }
         Materials { Diffuse gray { reflectance .5 .5 .5 }  Clear air { medium fog } }
         Group {
             MaterialName gray
             Rectangle { corner -2 1.5 2  edge0 1.96 0 0  edge1 0 0 -4 }
             Rectangle { corner .04 1.5 2  edge0 1.96 0 0  edge1 0 0 -4 }
             Rectangle { corner -2 -1.2 2  edge0 4 0 0  edge1 0 0 -4 }
             Rectangle { corner -2 -1.2 -1.4  edge0 4 0 0  edge1 0 2.6 0 }
             MaterialName air
             Box { min -1.6 -1 -1.2  max 1.6 1.3 1.2 }
         }",
    )
}

/// Returns the mean red radiance over the picture for each pass, and the variance of a pixel
/// between passes, averaged over the picture.
///
/// Also checks that passes guide scattering points if and only if `guided` is true.
fn means_and_variance(scene: &Scene, guided: bool, max_bounces: u32, passes: u32) -> (Vec<f64>, f64) {
    let settings = Settings {
        allows_scatter_point_guiding: guided,
        allows_ray_photon_balance: false,
        ..camera_ray_settings(4, max_bounces)
    };
    let integrator = Algorithm::Path.prepare(scene, settings);
    let report = integrator.scatter_point_guiding_report();
    assert_eq!(report.is_some_and(|report| report.used), guided, "{report:?}");
    let red = |pass| render_one_pass(&*integrator, pass).iter().map(|l| f64::from(l.x)).collect::<Vec<f64>>();
    let pictures: Vec<Vec<f64>> = (0..passes).map(red).collect();
    let pixels = pictures[0].len();
    let variance = |i: usize| {
        let error = mean_and_error(&pictures.iter().map(|picture| picture[i]).collect::<Vec<f64>>()).1;
        error * error * f64::from(passes)
    };
    let means = pictures.iter().map(|picture| picture.iter().sum::<f64>() / pixels as f64).collect();
    (means, (0..pixels).map(variance).sum::<f64>() / pixels as f64)
}

/// Guided and unguided points give the closed form of light that is scattered once.
///
/// The integral of radiance over the picture is σ/(4π) ∫ I/r² dV over the part of the cone in the
/// fog. With I/r² dV = I dω dr, it is σ/2 · I · d · (−ln cos θ), where d is the depth of the fog
/// and θ the half angle. The mean transmittance of light and camera rays is exp(−2.5 σ), because
/// the mean distances are 1 and 1.5; the error is below 10⁻⁵.
#[test]
fn guided_points_keep_the_light_of_a_beam() {
    let scene = beam_in_thin_fog();
    let half_angle = 6.0f64.to_radians();
    let area = 4.0 * 3.0;
    let expected = 0.5 * THIN * INTENSITY * 2.0 * -libm::log(libm::cos(half_angle)) / area * libm::exp(-2.5 * THIN);
    let (means, variance) = means_and_variance(&scene, true, 0, 100);
    let (usual, usual_variance) = means_and_variance(&scene, false, 0, 100);
    assert_mean("guided", &means, expected, 1e-4 * expected, 0.01);
    assert_mean("unguided", &usual, expected, 1e-4 * expected, 0.02);
    assert!(variance < 0.3 * usual_variance, "{variance} guided, {usual_variance} unguided");
}

/// Guided and unguided points give the same mean in fog with multiple scattering, lit through a
/// slit.
#[test]
#[ignore = "long: statistics against a closed form"]
fn guided_points_keep_light_in_colored_fog() {
    let scene = sheet_of_light_in_fog();
    let (means, variance) = means_and_variance(&scene, true, 30, 1000);
    let (usual, usual_variance) = means_and_variance(&scene, false, 30, 1000);
    let ((mean, error), (usual, usual_error)) = (mean_and_error(&means), mean_and_error(&usual));
    let tolerance = 5.0 * error.hypot(usual_error);
    eprintln!("{mean} ± {error}, {usual} ± {usual_error}, variances {variance} {usual_variance}");
    assert!(tolerance < 0.04 * mean, "too blunt: {tolerance} of {mean}");
    assert!((mean - usual).abs() < tolerance, "{mean} ± {error} guided, {usual} ± {usual_error} unguided");
    assert!(variance < usual_variance, "{variance} guided, {usual_variance} unguided");
}
