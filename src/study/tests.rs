//! Tests of studies of effects, on scenes with known results.

use super::{EffectReportHeader, EffectStudy, EffectStudyResult, effects_html_page, expected_work};
use crate::camera::Camera;
use crate::integrate::{Algorithm, Settings, SilentMonitor};
use crate::plan::EffectOverrides;
use crate::scene::{Effect, LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use crate::shape::{Rectangle, Shape, Sphere};
use glam::{DVec3, Vec3};
use std::sync::atomic::AtomicBool;

/// Makes a scene of a sphere on a floor under a point light.
fn sphere_on_floor(material: Material, width: u32, height: u32) -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Vec3::splat(0.5)));
    let own = builder.add_material(material);
    let floor = Rectangle::new(DVec3::new(-3.0, 0.0, -3.0), DVec3::Z * 6.0, DVec3::X * 6.0);
    builder
        .add_shape(Shape::Rectangle(floor), white, Vec3::ZERO)
        .add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, 1.0, 0.0), 0.8)), own, Vec3::ZERO)
        .add_delta_light(
            UnscaledDeltaLight::Point { position: DVec3::new(2.0, 4.0, 0.0) },
            LightStrength::Power(Vec3::splat(200.0)),
        );
    let (eye, view) = (DVec3::new(0.0, 2.0, 6.0), DVec3::new(0.0, -0.2, -1.0));
    builder.build(Camera::perspective(eye, view, DVec3::Y, 0.7, width, height).unwrap()).unwrap()
}

pub(super) fn diffuse_sphere_on_floor(width: u32, height: u32) -> Scene {
    sphere_on_floor(Material::diffuse(Vec3::splat(0.8)), width, height)
}

pub(super) fn glass_sphere_on_floor(width: u32, height: u32) -> Scene {
    sphere_on_floor(Material::dielectric(1.5, Vec3::ZERO), width, height)
}

fn settings_with_few_photons(effects: EffectOverrides) -> Settings {
    let mut settings =
        Settings { unaimed_paths: 0, aimed_paths: 4000, allows_ray_photon_balance: false, ..Settings::default() };
    settings.camera_paths.effects = effects;
    settings
}

fn run_effect_study(scene: &Scene, algorithm: Algorithm, settings: &Settings, passes: u32) -> EffectStudyResult {
    let study = EffectStudy::prepare(scene, algorithm, settings);
    study.run(passes, &AtomicBool::new(false), &SilentMonitor, |_| {}).unwrap()
}

/// Simulating caustics in a scene without casters (glass, mirrors) costs rays and changes no bit of
/// the picture.
#[test]
fn unneeded_caustics_cost_rays_and_change_no_bit() {
    let overrides = EffectOverrides::NO_OVERRIDES.with_forced_on(Effect::Caustics);
    let found =
        run_effect_study(&diffuse_sphere_on_floor(24, 18), Algorithm::Hybrid, &settings_with_few_photons(overrides), 2);
    let caustics = found.effects.iter().find(|f| f.decision.effect == Effect::Caustics).unwrap();
    assert_eq!(
        (caustics.contribution.rmse, caustics.contribution.added_radiance, caustics.contribution.removed_radiance),
        (0.0, 0.0, 0.0)
    );
    // Each of the 4,000 photon paths of the caustic map has at least one ray.
    assert!(caustics.added_cost.rays >= 4000.0, "{:?}", caustics.added_cost);
    let scene = diffuse_sphere_on_floor(24, 18);
    let work = expected_work(Algorithm::Hybrid.prepare(&scene, settings_with_few_photons(overrides)).as_ref());
    assert!(work.work_of_effect(Effect::Caustics).unwrap().rays >= 4000);
}

/// The algorithm `whitted` samples point lights without noise. So no pixel is brighter with shadows
/// than without.
#[test]
fn shadows_only_remove_light() {
    let found = run_effect_study(
        &diffuse_sphere_on_floor(24, 18),
        Algorithm::Whitted,
        &settings_with_few_photons(EffectOverrides::NO_OVERRIDES),
        1,
    );
    let shadows = found.effects.iter().find(|f| f.decision.effect == Effect::Shadows).unwrap();
    assert_eq!(shadows.contribution.added_radiance, 0.0);
    assert!(
        shadows.contribution.removed_radiance > 0.0
            && shadows.contribution.rmse > shadows.contribution.removed_radiance
    );
    assert!(shadows.difference.pixels().iter().all(|d| d.max_element() <= 0.0));
    // Only the picture with all effects has shadow rays.
    assert!(shadows.added_cost.rays > 0.0);
    assert_eq!((shadows.added_cost.seconds_standard_error, found.full_picture_cost.pass_seconds.len()), (None, 1));
}

#[test]
fn contributions_equal_differences_of_means() {
    let scene = glass_sphere_on_floor(24, 18);
    let found =
        run_effect_study(&scene, Algorithm::Hybrid, &settings_with_few_photons(EffectOverrides::NO_OVERRIDES), 3);
    let names: Vec<Effect> = found.effects.iter().map(|f| f.decision.effect).collect();
    assert_eq!(names, found.effect_plan.simulated_effects().iter().collect::<Vec<_>>());
    let caustics = found.effects.iter().find(|f| f.decision.effect == Effect::Caustics).unwrap();
    let settings = settings_with_few_photons(EffectOverrides::NO_OVERRIDES.with_forced_off(Effect::Caustics));
    let integrator = Algorithm::Hybrid.prepare(&scene, settings);
    let images = (0..3).map(|i| integrator.render_pass(i, &SilentMonitor).image);
    let sum: f64 = images.flatten().map(|p| p.as_dvec3().element_sum()).sum();
    let mean_without = sum / (3.0 * 3.0 * 24.0 * 18.0);
    // Pixels are stored in f32, which rounds them by at most 2⁻²⁴ of their value.
    let expected = found.mean_radiance - caustics.contribution.added_radiance + caustics.contribution.removed_radiance;
    assert!((expected / mean_without - 1.0).abs() < 1e-6, "{expected} {mean_without}");
    assert!(
        caustics.contribution.added_radiance > caustics.contribution.removed_radiance
            && caustics.added_cost.gathered_photons > 0.0
    );
    let again =
        run_effect_study(&scene, Algorithm::Hybrid, &settings_with_few_photons(EffectOverrides::NO_OVERRIDES), 3);
    assert_eq!(
        again.effects.iter().map(|f| f.contribution).collect::<Vec<_>>(),
        found.effects.iter().map(|f| f.contribution).collect::<Vec<_>>()
    );
}

#[test]
fn interrupted_effect_studies_finish_one_pass() {
    let scene = diffuse_sphere_on_floor(8, 6);
    let study =
        EffectStudy::prepare(&scene, Algorithm::Whitted, &settings_with_few_photons(EffectOverrides::NO_OVERRIDES));
    let pictures = study.picture_count();
    let found = study.run(9, &AtomicBool::new(true), &SilentMonitor, |_| {}).unwrap();
    assert!(found.interrupted && found.effects.len() + 1 == pictures);
    assert!(
        found.full_picture_cost.pass_seconds.len() == 1
            && found.effects.iter().all(|f| f.cost_without_effect.pass_seconds.len() == 1)
    );
}

#[test]
fn page_lists_every_effect() {
    let about = EffectReportHeader { scene_name: "<a> & b".into(), integrator: "whitted", seed: 3, exposure: -1.0 };
    let overrides = EffectOverrides::NO_OVERRIDES.with_forced_on(Effect::Environment).with_forced_off(Effect::Shadows);
    let found =
        run_effect_study(&diffuse_sphere_on_floor(8, 6), Algorithm::Whitted, &settings_with_few_photons(overrides), 1);
    let environment = found.effect_plan.decisions.iter().find(|d| d.effect == Effect::Environment).unwrap();
    let page = effects_html_page(&about, &found).unwrap();
    assert!(
        Effect::ALL.iter().all(|e| page.contains(&format!("<dt>{e}</dt>")) || page.contains(&format!("id=\"{e}\"")))
    );
    assert!(page.contains("&lt;a&gt; &amp; b") && !page.contains("<a>"));
    for part in ["exposure -1 stop.", &environment.reason.to_string(), "forced off, though", "equal bit for bit"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("<script") && !page.contains("http"), "it needs nothing else");
}
