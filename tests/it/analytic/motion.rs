//! Motion blur by slices of the shutter interval, at default settings.

use crate::support::{mean_and_error, scene_from_text_in};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use caustica::scene::Scene;
use glam::Vec3;

/// Builds a disc of radius R = 8 pixels and emission 1 that moves by L = 160 pixels, ten times its
/// diameter.
fn moving_disc() -> Scene {
    scene_from_text_in(
        "scenes",
        "OrthographicCamera { center 0 0 5  direction 0 0 -1  size 24  width 240  height 24 }
         Background { color 0 0 0 }
         Group { Moving { Translate 160 0 0  Disc { center -80 0 0  normal 0 0 1  radius 8  emission 1 1 1 } } }",
    )
}

/// A moving disc leaves an even streak, and the estimated noise agrees with the true noise.
///
/// The disc covers a point at distance y from its path for 2√(R² − y²)/L of the time. The sum over
/// a column of pixels is πR²/L, wherever the whole disc passes. The filter of pixels does not
/// change it.
///
/// Let p = 2R/L be the largest fraction of time. The mean of n rays of a pixel, independent or
/// stratified, has a variance of at most p(1 − p)/n. In a column, 2R + 3 pixels can see the disc,
/// because the filter reaches 1½ pixels beyond it. Each pixel has its own rays. So the root mean
/// square error of K columns is at most √((2R + 3)·p(1 − p)/n), with a relative error of 1/√(2K) if
/// columns are independent.
///
/// A faulty renderer could show copies of the disc at 16 times only, 10 pixels apart. Their sum
/// would vary by 0.2 from column to column, far more than this. If each pass showed the disc at one
/// place only, the noise estimated between passes would be five times too large.
#[test]
fn moving_disc_leaves_an_even_streak() {
    const RADIUS: f64 = 8.0;
    const LENGTH: f64 = 160.0;
    let scene = moving_disc();
    let passes = Algorithm::Hybrid.default_passes();
    let prepared = Algorithm::Hybrid.prepare(&scene, Settings::default());
    let columns_of = |i: u32| -> Vec<f64> {
        let image = prepared.render_pass(i, &SilentMonitor).image;
        (0..240).map(|x| (0..24).map(|y| f64::from(image[y * 240 + x].x)).sum()).collect()
    };
    let passes: Vec<Vec<f64>> = (0..passes).map(columns_of).collect();
    // Columns from 60 pixels left to 60 pixels right of the center.
    let middle: Vec<(f64, f64)> =
        (60..180).map(|x| mean_and_error(&passes.iter().map(|pass| pass[x]).collect::<Vec<f64>>())).collect();
    let expected = std::f64::consts::PI * RADIUS * RADIUS / LENGTH;
    let count = middle.len() as f64;
    let mean = middle.iter().map(|(mean, _)| mean).sum::<f64>() / count;
    let square = |f: &dyn Fn(&(f64, f64)) -> f64| (middle.iter().map(|v| f(v) * f(v)).sum::<f64>() / count).sqrt();
    let (found, estimated) = (square(&|(mean, _)| mean - expected), square(&|(_, error)| *error));

    let share = 2.0 * RADIUS / LENGTH;
    let rays = f64::from(8 * passes.len() as u32);
    let most = ((2.0 * RADIUS + 3.0) * share * (1.0 - share) / rays).sqrt();
    assert!((mean - expected).abs() < 5.0 * most / count.sqrt(), "{mean}, not {expected}");
    let bound = most * (1.0 + 5.0 / (2.0 * count).sqrt());
    assert!(found < bound, "columns differ by {found}, more than {bound} of noise");
    assert!(estimated < 2.0 * found, "passes estimate an error of {estimated}, not {found}");
}

/// The density grid of a medium moves and rotates with the sphere that the medium fills.
#[test]
fn density_grid_moves_with_its_body() {
    let scene = scene_from_text_in(
        "scenes",
        "PerspectiveCamera { center 0 0 8  direction 0 0 -1  angle 30  width 4  height 4 }
         Lights { EnvironmentLight { radiance 1 1 1 } }
         Media { Cloud smoke { scattering 2 2 2  cover .7  resolution 24  min -1 -1 -1  max 1 1 1 } }
         Materials { Clear cloud { medium smoke } }
         Group { MaterialName cloud  Moving { Translate 3 0 0  ZRotate 90  Sphere { center 0 0 0  radius 1 } } }",
    );
    let density = |time: f64, p: Vec3| scene.at_time(time).media()[0].density_at(p);
    let origin = scene.origin().as_vec3();
    let mut greatest = 0.0f32;
    for i in 0..64 {
        let at = |n: i32| (i * n % 64) as f32 / 64.0 - 0.5;
        let p = Vec3::new(at(5), at(11), at(27));
        let opening = density(0.0, p - origin);
        let closing = density(1.0, Vec3::new(3.0 - p.y, p.x, p.z) - origin);
        // Positions round to 2⁻²² here, and the density changes by less than 100 per unit of
        // length.
        assert!((opening - closing).abs() < 1e-4, "{p}: {opening} becomes {closing}");
        greatest = greatest.max(opening);
    }
    assert!(greatest > 0.1, "the cloud is empty");
}
