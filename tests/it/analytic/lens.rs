//! Depth of field and motion blur, against closed forms.

use crate::support::{assert_mean, camera_ray_settings, mean_and_error, scene_from_text_in};
use caustica::integrate::{Algorithm, SilentMonitor};
use caustica::math::Ray;
use caustica::sampling::{Dimension, Key, Purpose};
use caustica::scene::{Effects, RayCone, Scene};
use glam::{DVec2, Vec3};

fn scene(text: &str) -> Scene {
    scene_from_text_in("scenes", text)
}

/// Renders passes and returns the red channel of their pixels, row by row, for each pass.
fn lens_images(scene: &Scene, algorithm: Algorithm, samples: u32, passes: u32) -> Vec<Vec<f64>> {
    let prepared = algorithm.prepare(scene, camera_ray_settings(samples, 4));
    let pass = |i| prepared.render_pass(i, &SilentMonitor).image.iter().map(|v| f64::from(v.x)).collect();
    (0..passes).map(pass).collect()
}

/// A small light out of focus becomes a disc with the diameter of the thin-lens formula.
///
/// At distance S, the diameter is A |S − f|/(S p f) pixels. A is the diameter of the lens, f the
/// focus distance, and p the size of a pixel at distance 1. The second moment of a disc about each
/// axis is a quarter of its squared radius. The light's own size and the pixel's 1/12 add to it.
#[test]
#[ignore = "long: statistics against a closed form"]
fn circle_of_confusion_matches_thin_lens() {
    const PIXELS: f64 = 64.0;
    let (aperture, angle) = (0.5, 20f64.to_radians());
    let pixel = 2.0 * libm::tan(0.5 * angle) / PIXELS;
    let lamp = 0.05;
    for (distance, focus) in [(20.0f64, 4.0f64), (3.0, 4.0), (6.0, 10.0)] {
        for opening in [
            format!("aperture {}", 0.5 * aperture),
            // The f-number describes the same lens: focal length over diameter.
            format!("fNumber {}  sensorHeight .3", 0.15 / libm::tan(0.5 * angle) / aperture),
        ] {
            let scene = scene(&format!(
                "PerspectiveCamera {{ center 0 0 0  direction 0 0 -1  angle 20  width 64  height 64
                                      {opening}  focusDistance {focus} }}
                 Background {{ color 0 0 0 }}
                 Lights {{ DiscLight {{ center 0 0 -{distance}  normal 0 0 1  radius {lamp}  radiance 1 1 1 }} }}
                 Group {{ }}"
            ));
            let moments: Vec<DVec2> = lens_images(&scene, Algorithm::Path, 64, 24)
                .iter()
                .map(|image| {
                    let at = |i: usize| DVec2::new((i % 64) as f64 + 0.5 - 32.0, (i / 64) as f64 + 0.5 - 32.0);
                    let weighted = |f: &dyn Fn(DVec2) -> DVec2| {
                        image.iter().enumerate().map(|(i, v)| f(at(i)) * *v).sum::<DVec2>()
                    };
                    weighted(&|p| p * p) / image.iter().sum::<f64>()
                })
                .collect();
            let blur = 0.5 * aperture * (distance - focus).abs() / (distance * pixel * focus);
            let own = lamp / (distance * pixel);
            let expected = 0.25 * (blur * blur + own * own) + 1.0 / 12.0;
            for axis in [0, 1] {
                let found: Vec<f64> = moments.iter().map(|m| m[axis]).collect();
                assert_mean(&format!("{opening}, {distance} away"), &found, expected, 1e-5 * expected, 0.03);
            }
        }
    }
}

/// The edge of a moving white half plane leaves a linear ramp, which is as wide as the movement of
/// 16 pixels.
///
/// The 64 pass times are 1/64 apart. So their mean of a function that falls from 1 to 0 has an
/// error below 1/64. The edge is within a given pixel for 4 passes. In these passes, each of 16 · 4
/// rays has a variance of at most ¼. The mean of all passes has the variance 4 · (¼/64)/64².
#[test]
fn moving_edge_blurs_to_a_ramp() {
    const PASSES: u32 = 64;
    // One pixel is one unit wide. The edge moves from x = −8 to 8 pixels.
    let scene = scene(
        "OrthographicCamera { center 0 0 5  direction 0 0 -1  size 4  width 32  height 4 }
         Background { color 0 0 0 }
         Group { Moving { Translate 16 0 0  Rectangle { corner -108 -50 0  edge0 100 0 0  edge1 0 100 0  emission 1 1 1 } } }",
    );
    let images = lens_images(&scene, Algorithm::Path, 16, PASSES);
    for x in 0..32 {
        let pixels = images.iter().map(|image| (0..4).map(|y| image[y * 32 + x]).sum::<f64>() / 4.0);
        let found = pixels.sum::<f64>() / f64::from(PASSES);
        let (left, right) = (x as f64 - 16.0, x as f64 - 15.0);
        // At time t the edge is at x = 16 t − 8. Pixels left of it are white.
        let white = |p: f64| ((8.0 - p) / 16.0).clamp(0.0, 1.0);
        let expected = 0.5 * (white(left) + white(right));
        let sigma = (4.0 * 0.25 / 64.0f64).sqrt() / f64::from(PASSES);
        let step = 1.0 / f64::from(PASSES);
        assert!((found - expected).abs() < step + 5.0 * sigma, "pixel {x}: {found}, not {expected}");
    }
}

/// A moving point light gives the floor the time mean of its irradiance.
///
/// A light of intensity I at height h and offset x gives I h/(h² + x²)^(3/2). The mean is the
/// change of I x/(h √(h² + x²)) from end to end, over the length of the path. The mean over 64
/// equal time steps has an error of less than 1/64 of the total variation: a rise and a fall by at
/// most the peak I/h² each. No density estimate is involved.
#[test]
#[ignore = "long: statistics against a closed form"]
fn moving_light_gives_mean_irradiance_over_time() {
    const PASSES: u32 = 64;
    let scene = scene(
        "OrthographicCamera { center 0 1 0  direction 0 -1 0  up 0 0 1  size .001  width 1  height 1 }
         Lights { Moving { Translate 4 0 0  PointLight { position -1 2 0  intensity 3 3 3 } } }
         Materials { Diffuse white { reflectance 1 1 1 } }
         Group { MaterialName white  Plane { normal 0 1 0  offset 0 } }",
    );
    let integral = |x: f64| x / (2.0 * (4.0 + x * x).sqrt());
    let expected = 3.0 * (integral(3.0) - integral(-1.0)) / 4.0 / std::f64::consts::PI;
    let peak = 3.0 / 4.0 / std::f64::consts::PI;
    for algorithm in [Algorithm::Path, Algorithm::Distributed, Algorithm::Hybrid, Algorithm::Sppm] {
        let images = lens_images(&scene, algorithm, 1, PASSES);
        let found = images.iter().map(|image| image[0]).sum::<f64>() / f64::from(PASSES);
        assert!((found - expected).abs() < 2.0 * peak / f64::from(PASSES), "{algorithm:?}: {found}, not {expected}");
    }
}

/// Adaptive camera rays give the same image of a blurred light on black, with less noise.
///
/// All noise is on less than a tenth of the image. This part gets up to eight times the rays, so
/// the variance at least halves.
#[test]
fn adaptive_rays_change_only_noise() {
    const PASSES: u32 = 24;
    let scene = scene(
        "PerspectiveCamera { center 0 0 0  direction 0 0 -1  angle 20  width 64  height 64  aperture .25  focusDistance 4 }
         Background { color 0 0 0 }
         Lights { DiscLight { center 0 0 -20  normal 0 0 1  radius .3  radiance 1 1 1 } }
         Group { }",
    );
    let look = |adaptive| {
        let mut settings = camera_ray_settings(16, 4);
        settings.camera_paths.adaptive = adaptive;
        let prepared = Algorithm::Path.prepare(&scene, settings);
        let passes: Vec<_> = (0..PASSES).map(|i| prepared.render_pass(i, &SilentMonitor)).collect();
        let rays = passes.iter().map(|pass| pass.counters.camera_rays).sum::<u64>() as f64;
        let at = |i: usize| passes.iter().map(|pass| f64::from(pass.image[i].x)).collect::<Vec<f64>>();
        let noise = (0..64 * 64).map(|i| mean_and_error(&at(i)).1).map(|e| e * e).sum::<f64>();
        let totals: Vec<f64> = passes.iter().map(|p| p.image.iter().map(|v| f64::from(v.x)).sum()).collect();
        (rays, noise, totals)
    };
    let ((rays, noise, totals), (even_rays, even_noise, even_totals)) = (look(true), look(false));
    assert!(rays < 1.05 * even_rays, "{rays} rays, not {even_rays}");
    assert!(noise < 0.5 * even_noise, "{noise} is not much below {even_noise}");
    let differences: Vec<f64> = totals.iter().zip(&even_totals).map(|(a, b)| 100.0 + a - b).collect();
    assert_mean("light", &differences, 100.0, 1e-6, 0.05);
}

/// A light of MIT course 6.837 that moves keeps its strength.
///
/// The light's `color` is the radiance of a white floor at the scene's center, at the middle of the
/// light's movement. At other times, irradiance falls with the squared distance.
#[test]
fn mit_6837_light_keeps_its_strength_in_motion() {
    let scene = scene(
        "OrthographicCamera { center 0 1 0  direction 0 -1 0  up 0 0 1  size .001  width 1  height 1 }
         Lights { Moving { Translate 0 4 0  PointLight { position 0 2 0  color .5 .5 .5 } } }
         Materials { Diffuse white { reflectance 1 1 1 } }
         Group { MaterialName white  Rectangle { corner -1 0 1  edge0 2 0 0  edge1 0 0 -2 } }",
    );
    // In the middle of the movement, the light is at height 4, and the floor has the light's
    // `color`.
    for (time, height) in [(0.0, 2.0), (0.5, 4.0), (1.0, 6.0)] {
        let placed = scene.at_time(time);
        let seen = lens_images(&placed, Algorithm::Whitted, 1, 1)[0][0];
        let expected = 0.5 * 16.0 / (height * height);
        assert!((seen / expected - 1.0).abs() < 1e-5, "{time}: {seen}, not {expected}");
    }
}

/// Each orthographic ray determines on its own whether it starts inside a body.
///
/// A dark body surrounds the camera's center. Rays that start beside it are outside.
#[test]
fn orthographic_rays_start_in_correct_medium() {
    let scene = scene(
        "OrthographicCamera { center 0 0 0  direction 0 0 -1  size 4  width 101  height 101 }
         Background { color 1 1 1 }
         Materials { Dielectric dark { indexOfRefraction 1  absorption 9 9 9 } }
         Group { MaterialName dark  Sphere { center 0 0 0  radius .7 } }",
    );
    let image = &lens_images(&scene, Algorithm::Whitted, 1, 1)[0];
    // The filter is two pixels wide. Rays of the middle pixel pass through at least .69 of the dark
    // body. Rays at the corners miss it.
    assert!(image[50 * 101 + 50] < libm::exp(-9.0 * 0.69), "{}", image[50 * 101 + 50]);
    assert!([0, 100, 100 * 101, 101 * 101 - 1].iter().all(|i| image[*i] == 1.0));
}

/// At each time, a moving object lies where the same transforms place a resting object.
///
/// Hit distances differ only by rounding.
#[test]
fn moving_objects_follow_their_transforms() {
    let body = |what: &str| {
        format!(
            "PerspectiveCamera {{ center 0 1 9  direction 0 0 -1  angle 40  width 4  height 4 }}
             Group {{ Plane {{ normal 0 1 0  offset -3 }}  {what} }}"
        )
    };
    let objects = [
        "Sphere { center 1 0 0  radius .6 }",
        "Transform { Scale 1 .4 .7  Sphere { center 1 0 0  radius .6 } }",
        "Disc { center 1 0 0  normal 1 2 3  radius .8 }",
        "Rectangle { corner 0 -1 0  edge0 1 0 .3  edge1 0 2 0 }",
        "Triangle { vertex0 0 0 0  vertex1 2 0 .3  vertex2 0 2 0 }",
        "Transform { UniformScale .8  TriangleMesh { obj_file mesh/gem.obj } }",
        "Transform { Scale 1 -.5 .7  TriangleMesh { obj_file mesh/knot.obj } }",
    ];
    for object in objects {
        let moving = scene(&body(&format!(
            "Transform {{ Translate 0 .3 0  Moving {{ Translate 1 0 .5  YRotate 140  UniformScale 1.5  {object} }} }}"
        )));
        assert!(moving.has_motion());
        for time in [0.0, 0.25, 1.0] {
            let maps = format!(
                "Translate 0 .3 0  Translate {} 0 {}  YRotate {}  UniformScale {}",
                time,
                0.5 * time,
                140.0 * time,
                1.0 + 0.5 * time
            );
            let still = scene(&body(&format!("Transform {{ {maps}  {object} }}")));
            let placed = moving.at_time(time);
            let (mut hits, mut turned, mut missed) = (0, 0, 0);
            for i in 0..2000 {
                let key = Key::new(i).purpose_key(Purpose::Test);
                let (a, b) = (key.uniform_2d(Dimension::Film), key.uniform_2d(Dimension::Lens));
                // Rays go from a frame around the object to points near it.
                let from = Vec3::new(8.0 * a.x - 4.0, 8.0 * a.y - 4.0, 6.0);
                let to = Vec3::new(4.0 * b.x - 1.5, 3.0 * b.y - 1.5, 0.0);
                let look = |scene: &Scene| {
                    let ray = Ray::new(from - scene.origin().as_vec3(), (to - from).normalize());
                    let hit = scene.intersect(&ray)?;
                    let surface =
                        scene.surface_interaction(&ray, &hit, &RayCone::zero_width_cone(Effects::ALL), || 0.5);
                    let shadowed = scene.occluded(&Ray { t_max: hit.t * 1.01, ..ray });
                    assert!(shadowed, "{object} at {time}: a hit that casts no shadow");
                    Some((surface.point.p + scene.origin().as_vec3(), surface.point.ng))
                };
                match (look(&still), look(&placed)) {
                    (None, None) => {}
                    // The tolerances are rounding errors in single precision, of positions below 10
                    // and of directions. Rays hit edges only by chance.
                    (Some((p, n)), Some((q, m))) if (p - q).length() < 1e-5 * p.length().max(10.0) => {
                        hits += u32::from(p.y > -2.9);
                        turned += u32::from(n.dot(m) < 0.999);
                    }
                    _ => missed += 1,
                }
            }
            assert!(hits > 50, "{object} at {time}: only {hits} rays hit it");
            // Rounding changes positions by 10⁻⁷. At most one ray in thousands passes an edge or
            // outline at such a distance, so fewer than five of 2000 rays differ.
            assert!(missed < 5, "{object} at {time}: {missed} rays differ");
            // If a ray hits an edge between triangles, rounding may choose either triangle.
            assert!(turned < 5, "{object} at {time}: {turned} of {hits} normals differ");
        }
    }
}
