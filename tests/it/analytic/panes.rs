//! Light through thin sheets (`Thin`), which shadow rays cross.

use crate::support::*;
use caustica::camera::Camera;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::light::EnvironmentLight;
use caustica::scene::{Material, SceneBuilder};
use caustica::shape::{Shape, Sphere};
use glam::DVec3;
use std::f64::consts::PI;

const REFLECTANCE: f64 = 0.5;
const IRRADIANCE: f64 = 3.0;

/// Returns the radiance of each pixel in a picture of the floor, from one camera ray per pixel.
fn radiance_of_floor(objects: &str, algorithm: Algorithm) -> Vec<DVec3> {
    let scene = scene_from_text(&format!(
        "OrthographicCamera {{ center 9 3 0  direction -3 -1 0  up 0 1 0  size .1  width 4  height 4 }}
         Lights {{ DirectionalLight {{ direction 3 -4 0  irradiance {IRRADIANCE} {IRRADIANCE} {IRRADIANCE} }} }}
         Textures {{ Checker tiles {{ color0 .9 .5 .1  color1 0 0 0  scale 2 1 }} }}
         Materials {{ Diffuse floor {{ reflectance {REFLECTANCE} {REFLECTANCE} {REFLECTANCE} }}
                      Thin pane {{ indexOfRefraction 1.5 }}  Thin stained {{ indexOfRefraction 1  transmittance tiles }} }}
         Group {{ MaterialName floor  Plane {{ normal 0 1 0  offset 0 }}  {objects} }}"
    ));
    let camera_paths =
        CameraPathSettings { samples_per_pixel: Some(1), max_bounces: 0, ..CameraPathSettings::default() };
    let settings = Settings { camera_paths, unaimed_paths: 0, aimed_paths: 0, ..Settings::default() };
    render_passes(&scene, algorithm, settings, 1).into_iter().map(|radiance| radiance.as_dvec3()).collect()
}

fn pane(height: f64, material: &str) -> String {
    format!("MaterialName {material}  Rectangle {{ corner -6 {height} -4  edge0 0 0 8  edge1 6 0 0 }}")
}

/// Sunlight at the angle θ = atan(3/4) crosses a sheet with the transmittance T = (1 − R)/(1 + R),
/// where R is the Fresnel reflectance of one face. One camera ray finds it without noise.
#[test]
fn sunlight_through_panes_needs_no_photons() {
    let r = fresnel_reflectance(0.8, 1.5);
    let through = (1.0 - r) / (1.0 + r);
    for (panes, transmittance) in
        [(pane(0.5, "pane"), through), (pane(0.5, "pane") + &pane(0.75, "pane"), through * through)]
    {
        let expected = REFLECTANCE / PI * IRRADIANCE * 0.8 * transmittance;
        for algorithm in [Algorithm::Path, Algorithm::Distributed, Algorithm::Hybrid] {
            for value in radiance_of_floor(&panes, algorithm) {
                let error = (value - expected).abs().max_element() / expected;
                assert!(error < 1e-4, "{}: {value} instead of {expected}", algorithm.name());
            }
        }
    }
}

/// A shadow ray takes the color of the stained glass at the point where it crosses the sheet.
///
/// The light crosses the sheet at u = ½ ± 1/32, beside the border of two tiles. Its way through the
/// sheet, at the angle θ with cos θ = .8, is 1/.8 times as long as along the normal.
#[test]
fn shadow_rays_read_textures_of_panes() {
    let tint = DVec3::new(0.9, 0.5, 0.1).powf(1.0 / 0.8);
    for (shift, expected) in [(0.25, DVec3::ZERO), (-0.25, tint)] {
        let sheet = format!(
            "MaterialName stained  Rectangle {{ corner {} 4 -4  edge0 8 0 0  edge1 0 0 8 }}",
            -3.0 - 4.0 - shift
        );
        let expected = REFLECTANCE / PI * IRRADIANCE * 0.8 * expected;
        for value in radiance_of_floor(&sheet, Algorithm::Path) {
            assert!((value - expected).abs().max_element() < 1e-4, "{shift}: {value} instead of {expected}");
        }
    }
}

/// A white ball in a ball of lossless sheets, under light of radiance 1, has radiance 1.
///
/// Shadow rays and continued paths both find the light that crosses a sheet, so their weights must
/// add up to 1.
#[test]
fn furnace_behind_a_pane_has_radiance_one() {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(grey(1.0)));
    let sheet = builder.add_material(Material::thin_dielectric(1.5, grey(1.0)));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 0.5)), white, grey(0.0));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), sheet, grey(0.0));
    builder.set_environment(EnvironmentLight::with_constant_radiance(grey(1.0)).unwrap());
    let camera = Camera::orthographic(DVec3::Z * 5.0, DVec3::NEG_Z, DVec3::Y, 0.5, 8, 8).unwrap();
    let scene = builder.build(camera).unwrap();
    let samples: Vec<f64> = (0..40)
        .map(|pass| {
            let mut settings = camera_ray_settings(16, 1000);
            settings.camera_paths.seed = pass;
            let image = render_passes(&scene, Algorithm::Path, settings, 1);
            image.iter().map(|radiance| f64::from(radiance.x)).sum::<f64>() / image.len() as f64
        })
        .collect();
    assert_mean("white ball behind a sheet", &samples, 1.0, 0.0, 0.01);
}
