use super::super::algorithm::Algorithm;
use super::super::hybrid;
use super::super::indirect_division::RelativeIndirectErrors;
use super::super::settings::CameraPathSettings;
use super::*;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::light::EnvironmentLight;
use crate::medium::{Medium, PhaseFunction};
use crate::plan::EffectOverrides;
use crate::scene::{Body, Material, SceneBuilder};
use crate::shape::{Shape, Sphere};
use glam::{DVec3, Vec2};

const PASSES: u32 = 400;

/// A ball of fog of radius 1 and a white ball in its center. They absorb nothing, and the light
/// around them has radiance 1, so the camera sees radiance 1 in each pixel.
fn white_ball_in_fog() -> Scene {
    let mut builder = SceneBuilder::new();
    let fog = Medium::homogeneous(Rgb::ZERO, Rgb::splat(2.0), Rgb::ZERO, PhaseFunction::Isotropic);
    let fog = builder.add_medium(fog);
    let air = builder.add_material(Material::smooth_boundary(Body::null_interface_with_medium(fog)));
    let white = builder.add_material(Material::diffuse(Rgb::ONE));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), air, Rgb::ZERO);
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 0.3)), white, Rgb::ZERO);
    builder.set_environment(EnvironmentLight::with_constant_radiance(Rgb::ONE).unwrap());
    builder.build(Camera::orthographic(DVec3::Z * 5.0, DVec3::NEG_Z, DVec3::Y, 1.0, 16, 16).unwrap()).unwrap()
}

/// In fog, camera paths and photon estimates share the indirect light without a change of the mean
/// radiance 1. Two of eight camera paths continue, with the factor 2 each. Photon estimates have
/// the weight 1/2.
///
/// The mean may differ from 1 by five standard errors, and by the bias of photon beams near
/// boundaries: their kernel has a radius of 0.03.
#[test]
#[ignore = "long: many samples of weights"]
fn indirect_light_weights_in_fog_sum_to_one() {
    const SAMPLES: u32 = 8;
    const PHOTONS: u32 = 4000;
    let scene = white_ball_in_fog();
    let camera_paths = CameraPathSettings { samples_per_pixel: Some(SAMPLES), max_bounces: 1000, ..Default::default() };
    let settings = Settings {
        camera_paths,
        unaimed_paths: PHOTONS,
        allows_ray_photon_balance: false,
        initial_gather_radius: Some(0.03),
        alpha: 1.0,
        indirect_photons: IndirectPhotons::Full,
        ..Settings::default()
    };
    let plan = Plan::new(&scene, Algorithm::Hybrid.supported_effects(), EffectOverrides::NO_OVERRIDES);
    let mut integrator = PathIntegrator::new(&scene, plan, settings, hybrid::path_policy);

    // Two of eight paths continue. Their mean has the variance 1/2, like the photon estimate.
    let errors = RelativeIndirectErrors {
        single_path_variance: 1.0,
        single_photon_path_variance: 0.5 * PHOTONS as f32,
        squared_bias: 0.0,
    };
    let division = IndirectDivision {
        columns: 1,
        cells: vec![errors],
        cell_size: 16.0,
        samples_per_pixel: SAMPLES,
        unaimed_paths: PHOTONS,
        path_price: 1.0 / 16.0,
        passes_with_photons: u32::MAX,
    };
    let renderer = &mut integrator.renderer;
    renderer.policy.indirect_photons = IndirectPhotons::Weighted;
    renderer.map_builder = renderer.map_builder.with_policy(&renderer.policy);
    renderer.map_builder.set_division(Some(division));
    let weights = renderer.map_builder.technique_of_pass(0).technique_weights(Vec2::ONE);
    assert_eq!((weights.photon_weight, weights.continued_paths, weights.continued_path_factor(SAMPLES)), (0.5, 2, 2.0));

    let mean_of_pass = |pass| {
        let image = integrator.render_pass(pass, &SilentMonitor).image;
        image.iter().map(|radiance| f64::from(radiance.x)).sum::<f64>() / image.len() as f64
    };
    let means: Vec<f64> = (0..PASSES).map(mean_of_pass).collect();
    let mean = means.iter().sum::<f64>() / f64::from(PASSES);
    let squares: f64 = means.iter().map(|m| (m - mean) * (m - mean)).sum();
    let error = (squares / f64::from(PASSES * (PASSES - 1))).sqrt();
    assert!(5.0 * error < 0.01, "too blunt: {error}");
    assert!((mean - 1.0).abs() < 5.0 * error + 0.005, "{mean} ± {error}");
}

/// Passes of `ppm` share their camera paths, so adaptive sampling has no effect on them.
#[test]
fn adaptive_sampling_changes_no_bit_of_ppm() {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Rgb::splat(0.5)));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 0.3)), white, Rgb::ZERO);
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::new(2.0, 1.0, 2.0), 0.5)), white, Rgb::splat(5.0));
    let camera = Camera::orthographic(DVec3::Z * 5.0, DVec3::NEG_Z, DVec3::Y, 1.0, 16, 16).unwrap();
    let scene = builder.build(camera).unwrap();
    let image = |adaptive: bool| {
        let camera_paths = CameraPathSettings { samples_per_pixel: Some(4), adaptive, ..Default::default() };
        let settings =
            Settings { camera_paths, unaimed_paths: 1000, initial_gather_radius: Some(0.1), ..Settings::default() };
        Algorithm::Ppm.prepare(&scene, settings).render_pass(0, &SilentMonitor).image
    };
    let plain = image(false);
    assert!(plain.iter().any(|radiance| *radiance != Rgb::ZERO));
    assert_eq!(plain, image(true));
}
