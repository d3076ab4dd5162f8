//! Indirect light at first receivers, divided between camera paths and photon estimates.

use crate::support::*;
use caustica::camera::Camera;
use caustica::integrate::{Algorithm, IndirectPhotons, LightTracing, Settings};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::DVec3;
use std::f64::consts::PI;

const FLUX: f64 = 8.0;
const RADIUS: f64 = 2.0;
const ALBEDO: f64 = 0.7;

/// Height of the light above the center of the sphere \[length].
const HEIGHT: f64 = 1.5;

/// Full field of view of the camera in the sphere \[rad].
const VIEW: f64 = 0.7;

/// A diffuse sphere around a point light. The camera in its center sees a part of the wall.
///
/// Light that was reflected k times lights the whole wall uniformly with ρᵏΦ/(4πR²). A cap of the
/// sphere with chord r has exactly the area πr², so photon estimates have no bias.
fn wall_scene() -> Scene {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(Material::diffuse(grey(ALBEDO)));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, RADIUS)), wall, grey(0.0));
    let kind = UnscaledDeltaLight::Point { position: DVec3::Z * HEIGHT };
    b.add_delta_light(kind, LightStrength::Power(grey(FLUX)));
    b.build(Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, VIEW, 32, 32).unwrap()).unwrap()
}

/// Returns the mean irradiance of direct light over the picture of [`wall_scene`].
fn mean_direct_irradiance() -> f64 {
    const STEPS: u32 = 200;
    let edge = libm::tan(0.5 * VIEW);
    let film = |i: u32| edge * (f64::from(2 * i + 1) / f64::from(STEPS) - 1.0);
    let irradiance = |x: f64, y: f64| {
        let inwards = -dvec3(x, y, -1.0).normalize();
        let to_light = DVec3::Z * HEIGHT + inwards * RADIUS;
        FLUX / (4.0 * PI) * to_light.dot(inwards) / libm::pow(to_light.length(), 3.0)
    };
    let sum = (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| irradiance(film(i), film(j)))).sum::<f64>();
    sum / f64::from(STEPS * STEPS)
}

/// Returns the mean over the picture for each pass, and the mean variance of a pixel between
/// passes.
fn picture_means_and_variance(scene: &Scene, settings: &Settings, passes: u32) -> (Vec<f64>, f64) {
    let integrator = Algorithm::Hybrid.prepare(scene, settings.clone());
    let uses_photons = settings.indirect_photons != IndirectPhotons::Off;
    assert_eq!(integrator.interreflection_photon_weight(0) > 0.0, uses_photons, "{:?}", settings.indirect_photons);
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

/// Photon estimates keep the radiance of the wall, with less than half of the variance of camera
/// paths.
///
/// The radiance is ρ/π times the irradiance by the light and by all reflections.
#[test]
#[ignore = "long: statistics against a closed form"]
fn photon_estimates_keep_indirect_light_in_a_sphere() {
    let scene = wall_scene();
    let direct = mean_direct_irradiance();
    let indirect = FLUX / (4.0 * PI * RADIUS * RADIUS) * ALBEDO / (1.0 - ALBEDO);
    let expected = ALBEDO / PI * (direct + indirect);
    let means = |indirect_photons| {
        let settings = Settings {
            indirect_photons,
            unaimed_paths: 4000,
            allows_ray_photon_balance: false,
            ..camera_ray_settings(1, 1000)
        };
        picture_means_and_variance(&scene, &settings, 100)
    };
    let variances = [(IndirectPhotons::Off, 0.03), (IndirectPhotons::Weighted, 0.015), (IndirectPhotons::Full, 0.015)]
        .map(|(technique, tolerance)| {
            let (values, variance) = means(technique);
            assert_mean(&format!("{technique:?}"), &values, expected, 0.0, tolerance);
            variance
        });
    let [off, weighted, full] = variances;
    assert!(weighted < 0.5 * off && full < 0.5 * off, "{off} {weighted} {full}");
}

/// Photon estimates keep the radiance 1 of white fog under a sky of radiance 1.
///
/// A ball of fog and a white ball in its center absorb nothing. So the camera sees radiance 1 in
/// each pixel. Photon beams near the boundaries have the bias of their kernel, which is .03 wide.
#[test]
fn photon_estimates_keep_indirect_light_in_fog() {
    let scene = scene_from_text_in(
        "scenes",
        "OrthographicCamera { center 0 0 5  direction 0 0 -1  size 1  width 16  height 16 }
         Background { color 0 0 0 }
         Lights { EnvironmentLight { radiance 1 1 1 } }
         Media { Medium fog { scattering 2 2 2 } }
         Materials { Clear air { medium fog }  Diffuse white { reflectance 1 1 1 } }
         Group {
             MaterialName air
             Sphere { center 0 0 0  radius 1 }
             MaterialName white
             Sphere { center 0 0 0  radius .3 }
         }",
    );
    for indirect_photons in [IndirectPhotons::Off, IndirectPhotons::Full] {
        let radius = Some(0.03);
        let settings = Settings {
            indirect_photons,
            initial_gather_radius: radius,
            unaimed_paths: 4000,
            allows_ray_photon_balance: false,
            ..camera_ray_settings(1, 1000)
        };
        let (values, _) = picture_means_and_variance(&scene, &settings, 60);
        assert_mean(&format!("{indirect_photons:?}"), &values, 1.0, 0.005, 0.01);
    }
}

/// A foggy room with a small lamp keeps its mean radiance if photon estimates share its indirect
/// light.
///
/// The reference leaves all indirect light to camera paths. Sharing more than halves the variance
/// of pixels. The tolerance is five standard errors of the difference, plus the bias of kernels of
/// width .05 in a room of size 2.
#[test]
#[ignore = "long: statistics against a closed form"]
fn shared_indirect_light_in_fog_keeps_its_mean() {
    let scene = scene_from_text_in(
        "scenes",
        "PerspectiveCamera { center 0 0 .95  direction 0 0 -1  angle 60  width 48  height 48 }
         Background { color 0 0 0  medium fog }
         Lights { SphereLight { center -.5 .6 -.4  radius .05  power 20 20 20 } }
         Media { Medium fog { scattering .7 .7 .7  anisotropy .3 } }
         Materials { Diffuse wall { reflectance .7 .7 .7 } }
         Group {
             MaterialName wall
             Rectangle { corner -1 -1 -1  edge0 2 0 0  edge1 0 2 0 }
             Rectangle { corner -1 -1 1  edge0 2 0 0  edge1 0 2 0 }
             Rectangle { corner -1 -1 -1  edge0 2 0 0  edge1 0 0 2 }
             Rectangle { corner -1 1 -1  edge0 2 0 0  edge1 0 0 2 }
             Rectangle { corner -1 -1 -1  edge0 0 2 0  edge1 0 0 2 }
             Rectangle { corner 1 -1 -1  edge0 0 2 0  edge1 0 0 2 }
         }",
    );
    let picture_means = |indirect_photons, passes| {
        let radius = Some(0.05);
        let settings = Settings {
            indirect_photons,
            initial_gather_radius: radius,
            unaimed_paths: 5000,
            allows_ray_photon_balance: false,
            ..camera_ray_settings(4, 1000)
        };
        let (values, variance) = picture_means_and_variance(&scene, &settings, passes);
        (mean_and_error(&values), variance)
    };
    let ((off, off_error), off_variance) = picture_means(IndirectPhotons::Off, 150);
    let ((weighted, error), variance) = picture_means(IndirectPhotons::Weighted, 30);
    let tolerance = 5.0 * off_error.hypot(error);
    eprintln!("{off} ± {off_error}, {weighted} ± {error}, variances {off_variance} {variance}");
    assert!(tolerance < 0.04 * off, "too blunt: {tolerance} of {off}");
    assert!((weighted - off).abs() < tolerance + 0.005 * off, "{off} ± {off_error}, {weighted} ± {error}");
    assert!(variance < 0.5 * off_variance, "{off_variance} {variance}");
}

/// A room with a glass ball, a mirror and a small lamp, seen by a camera that sees all of them.
fn room_with_glass() -> Scene {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(Material::diffuse(grey(0.6)));
    let glass = b.add_material(Material::dielectric(1.5, grey(0.0)));
    let mirror = b.add_material(Material::mirror(grey(0.9)));
    let lamp = b.add_material(Material::black());
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, RADIUS)), wall, grey(0.0));
    b.add_shape(Shape::Sphere(Sphere::new(dvec3(0.4, -0.3, -0.6), 0.4)), glass, grey(0.0));
    let corner = dvec3(-1.2, -0.6, -0.9);
    b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::X * 0.7, DVec3::Y * 0.9)), mirror, grey(0.0));
    b.add_shape(Shape::Sphere(Sphere::new(dvec3(0.3, 1.0, 0.4), 0.1)), lamp, grey(30.0));
    let camera = Camera::perspective(dvec3(0.0, 0.0, 1.6), DVec3::NEG_Z, DVec3::Y, 1.2, 12, 12).unwrap();
    b.build(camera).unwrap()
}

/// All 18 combinations of the techniques for caustics and indirect light give the same mean
/// picture.
///
/// Each combination has 12 seeds. Student's t between a combination and all others must stay below
/// 4.9. With a probability of 1/1000, a correct program exceeds this limit in any of the
/// combinations.
#[test]
#[ignore = "long: 216 renders"]
fn every_subset_of_techniques_has_the_same_mean() {
    let scene = room_with_glass();
    let mut means = Vec::new();
    for indirect_photons in [IndirectPhotons::Off, IndirectPhotons::Weighted, IndirectPhotons::Full] {
        for light_tracing in [LightTracing::Off, LightTracing::Weighted, LightTracing::Full] {
            for prefix_rays in [false, true] {
                let picture = |seed| {
                    let mut settings = Settings {
                        indirect_photons,
                        light_tracing,
                        allows_prefix_rays: prefix_rays,
                        unaimed_paths: 20_000,
                        aimed_paths: 10_000,
                        gather_k: Some(0),
                        initial_gather_radius: Some(0.05),
                        ..camera_ray_settings(4, 1000)
                    };
                    settings.camera_paths.seed = seed;
                    let integrator = Algorithm::Hybrid.prepare(&scene, settings);
                    let pixels = (0..4).flat_map(|pass| render_one_pass(&*integrator, pass));
                    pixels.map(|l| f64::from(l.x)).sum::<f64>() / (4.0 * 144.0)
                };
                let values: Vec<f64> = (0..12).map(|seed| picture(100 * means.len() as u64 + seed)).collect();
                means.push((format!("{indirect_photons:?} {light_tracing:?} {prefix_rays}"), values));
            }
        }
    }
    let all: Vec<f64> = means.iter().flat_map(|(_, values)| values).copied().collect();
    for (name, values) in &means {
        let others: Vec<f64> = all.iter().copied().filter(|v| !values.contains(v)).collect();
        let ((mean, error), (other, other_error)) = (mean_and_error(values), mean_and_error(&others));
        let t = (mean - other) / error.hypot(other_error);
        eprintln!("{name}: {mean:.6} ± {error:.6}, t = {t:.2}");
        assert!(t.abs() < 4.9, "{name}: {mean} ± {error}, all others {other} ± {other_error}");
    }
}
