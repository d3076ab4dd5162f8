//! Effect overrides: an effect that is forced off is missing from the image and costs nothing.

use super::compare::{Picture, RenderSettings, difference, scene};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::plan::EffectOverrides;
use caustica::scene::{Effect, Effects, Scene};
use caustica::stats::Counters;

/// Integrators with distinct behaviour.
///
/// `Pm` stands for all integrators that read both photon maps directly, because its gather rays can
/// be forced off.
const ALGORITHMS: [Algorithm; 6] =
    [Algorithm::Hybrid, Algorithm::Path, Algorithm::Pm, Algorithm::Distributed, Algorithm::Whitted, Algorithm::Raycast];

const CAMERA: &str = "PerspectiveCamera { center 0 3 6  lookAt 0 .5 0  angle 40  width 16  height 12 }";

/// Builds a scene that needs every effect.
///
/// A body of coloured glass moves over a floor, under a uniform sky and a light. The camera has a
/// lens.
fn everything() -> Scene {
    scene(&format!(
        "{}
        Lights {{ RectangleLight {{ corner -1 4 -1  edge0 2 0 0  edge1 0 0 2  power 200 200 200 }}
                  EnvironmentLight {{ radiance .1 .2 .3 }} }}
        Textures {{ Checker tiles {{ color0 .7 .6 .5  color1 .2 .3 .4 }}  Noise lumps {{ frequency 3 }} }}
        Media {{ Medium smoke {{ scattering .2 .2 .2 }} }}
        Materials {{ Diffuse floor {{ reflectance tiles  bump lumps  bumpHeight .1 }}  Clear haze {{ medium smoke }}
                     Dielectric glass {{ glass SF11  absorption .5 .1 .9 }} }}
        Group {{ MaterialName floor  Plane {{ normal 0 1 0  offset 0 }}
                 Rectangle {{ corner -2 0 -2  edge0 4 0 0  edge1 0 3 0 }}
                 MaterialName haze  Sphere {{ center .5 1 1  radius .8 }}
                 MaterialName glass  Moving {{ Translate .5 0 0  Sphere {{ center 0 .8 0  radius .7 }} }} }}",
        CAMERA.replace("angle", "aperture .2  angle")
    ))
}

/// Builds a scene of two diffuse objects under a point light.
fn matt() -> Scene {
    scene(&format!(
        "{CAMERA}
        Lights {{ PointLight {{ position 1 4 2  power 200 200 200 }} }}
        Materials {{ Diffuse floor {{ reflectance .7 .6 .5 }} }}
        Group {{ MaterialName floor  Plane {{ normal 0 1 0  offset 0 }}  Sphere {{ center 0 .8 0  radius .7 }} }}"
    ))
}

/// Builds a scene of a mirror above a black surface.
fn dark() -> Scene {
    scene(&format!(
        "{CAMERA}
        Lights {{ PointLight {{ position 1 4 2  power 200 200 200 }} }}
        Materials {{ Diffuse velvet {{ reflectance 0 0 0 }}  Mirror silver {{ }} }}
        Group {{ MaterialName velvet  Plane {{ normal 0 1 0  offset 0 }}
                 MaterialName silver  Sphere {{ center 0 .8 0  radius .7 }} }}"
    ))
}

/// Builds a scene of one disc under a point light.
fn disc() -> Scene {
    scene(&format!(
        "{CAMERA}
        Lights {{ PointLight {{ position 1 4 2  power 200 200 200 }} }}
        Materials {{ Diffuse floor {{ reflectance .7 .6 .5 }} }}
        Group {{ MaterialName floor  Disc {{ center 0 0 0  normal 0 1 0  radius 2 }} }}"
    ))
}

/// Renders with so many photons that gather rays find interreflection of caustics.
fn picture(scene: &Scene, algorithm: Algorithm, effects: EffectOverrides) -> Picture {
    Picture::new(
        scene,
        &RenderSettings { radius: Some(0.3), samples: Some(4), photons: 20_000, ..RenderSettings::new(algorithm) },
        effects,
    )
}

fn called_for(picture: &Picture) -> Effects {
    let called = picture.decisions.iter().filter(|d| d.is_needed);
    called.fold(Effects::NONE, |all, d| all.with_effect(d.effect))
}

#[test]
#[ignore = "long: renders of many scenes"]
fn disabling_needed_effect_changes_image() {
    let scene = everything();
    for algorithm in ALGORITHMS {
        let planned = picture(&scene, algorithm, EffectOverrides::NO_OVERRIDES);
        assert_eq!(called_for(&planned), algorithm.supported_effects(), "{}", algorithm.name());
        for effect in algorithm.supported_effects().iter() {
            let without = picture(&scene, algorithm, EffectOverrides::NO_OVERRIDES.with_forced_off(effect));
            let decision = without.decisions.iter().find(|d| d.effect == effect).unwrap();
            assert!(decision.is_forced_against_need() && !decision.is_simulated);
            assert!(planned.difference(&without).is_some(), "{} without {effect}", algorithm.name());
        }
    }
}

#[test]
fn disabling_unneeded_effect_changes_nothing() {
    for scene in [matt(), dark(), disc()] {
        for algorithm in ALGORITHMS {
            let planned = picture(&scene, algorithm, EffectOverrides::NO_OVERRIDES);
            let off = planned.decisions.iter().filter(|d| !d.is_needed);
            assert!(
                algorithm == Algorithm::Raycast || off.clone().any(|d| algorithm.supported_effects().has(d.effect))
            );
            let overrides = off.fold(EffectOverrides::NO_OVERRIDES, |overrides, d| overrides.with_forced_off(d.effect));
            let without = picture(&scene, algorithm, overrides);
            assert_eq!(planned.difference(&without), None, "{}", algorithm.name());
            assert_eq!(planned.counters, without.counters, "{}", algorithm.name());
        }
    }
}

/// Returns the counters of a planned render with the effects `off` forced off.
fn work(scene: &Scene, algorithm: Algorithm, off: &[Effect]) -> Counters {
    picture(scene, algorithm, off.iter().fold(EffectOverrides::NO_OVERRIDES, |w, e| w.with_forced_off(*e))).counters
}

#[test]
fn disabled_effects_cost_nothing() {
    use Effect::{CausticBounces, Caustics, Environment, Interreflection, Shadows, Specular};
    let scene = everything();
    for algorithm in ALGORITHMS {
        let name = algorithm.name();
        let work = |off: &[Effect]| work(&scene, algorithm, off);
        let all = work(&[]);
        assert!(all.camera_rays > 0);
        assert_eq!(all.shadow_rays > 0, algorithm != Algorithm::Raycast, "{name}");
        assert_eq!(all.continuation_rays > 0, algorithm != Algorithm::Raycast, "{name}");
        assert_eq!(
            (all.photon_rays > 0, all.density_estimates > 0),
            (algorithm.traces_photons(), algorithm.traces_photons()),
            "{name}"
        );
        assert_eq!(work(&[Shadows]).shadow_rays, 0, "{name}");
        let flat = work(&[Specular, Interreflection]);
        assert_eq!(flat.continuation_rays, 0, "{name}");
        let direct = work(&[Caustics, CausticBounces, Interreflection]);
        assert_eq!((direct.photon_rays, direct.density_estimates, direct.gathered_photons), (0, 0, 0), "{name}");
        let nothing = work(&Effect::ALL);
        let camera = Counters { camera_rays: nothing.camera_rays, ..Counters::default() };
        assert_eq!(nothing, camera, "{name}");
        if algorithm.traces_photons() {
            let once = work(&[CausticBounces, Interreflection]);
            assert!(0 < once.photon_rays && once.photon_rays < all.photon_rays, "{name}");
        }
        if matches!(algorithm, Algorithm::Hybrid | Algorithm::Path | Algorithm::Distributed) {
            assert!(work(&[Environment]).shadow_rays < all.shadow_rays, "{name}");
        }
    }
}

#[test]
fn unneeded_effects_cost_nothing() {
    for algorithm in ALGORITHMS {
        let name = algorithm.name();
        let [matt, dark, disc] = [matt(), dark(), disc()].map(|s| work(&s, algorithm, &[]));
        if matches!(algorithm, Algorithm::Hybrid | Algorithm::Path) {
            assert_eq!((matt.photon_rays, matt.density_estimates), (0, 0), "{name}: no caster");
            assert!(matt.continuation_rays > 0, "{name}");
        }
        if algorithm == Algorithm::Path {
            assert!(
                dark.continuation_rays <= dark.camera_rays,
                "{name}: velvet sends nothing on, and a ball sees no ball"
            );
        }
        if matches!(algorithm, Algorithm::Whitted | Algorithm::Distributed) {
            assert_eq!(matt.continuation_rays, 0, "{name}: no caster and no gather ray");
        }
        assert_eq!(
            (disc.shadow_rays, disc.continuation_rays, disc.photon_rays, disc.density_estimates),
            (0, 0, 0, 0),
            "{name}"
        );
    }
}

/// A medium that no object contains does not change pilots, whatever effects are forced on.
#[test]
fn unused_media_change_nothing() {
    let scene = scene(&format!(
        "{CAMERA}
        Lights {{ PointLight {{ position 1 4 2  power 200 200 200 }} }}
        Media {{ Medium smoke {{ scattering .2 .2 .2 }} }}
        Materials {{ Diffuse floor {{ reflectance .7 .6 .5 }}  Dielectric glass {{ }}  Clear haze {{ medium smoke }} }}
        Group {{ MaterialName floor  Plane {{ normal 0 1 0  offset 0 }}
                 MaterialName glass  Sphere {{ center 0 .8 0  radius .7 }} }}"
    ));
    let distributions = |effects| {
        let camera_paths = CameraPathSettings { effects, ..CameraPathSettings::default() };
        Algorithm::Hybrid
            .prepare(&scene, Settings { camera_paths, allows_ray_photon_balance: false, ..Settings::default() })
            .emission_guiding_reports()
    };
    let planned = distributions(EffectOverrides::NO_OVERRIDES);
    assert!(planned.aimed.is_some());
    assert_eq!(planned, distributions(EffectOverrides::ALL_FORCED_ON));
}

/// A pilot chooses the number of camera rays and photons of a pass. Effects that the scene does not
/// need do not change its choice.
#[test]
fn unneeded_effects_do_not_change_the_balance() {
    let scene = scene(&format!(
        "{CAMERA}
        Lights {{ RectangleLight {{ corner -1 4 -1  edge0 2 0 0  edge1 0 0 2  power 200 200 200 }} }}
        Materials {{ Diffuse floor {{ reflectance .7 .6 .5 }}  Dielectric glass {{ }} }}
        Group {{ MaterialName floor  Plane {{ normal 0 1 0  offset 0 }}
                 Rectangle {{ corner -2 0 -2  edge0 4 0 0  edge1 0 3 0 }}
                 MaterialName glass  Sphere {{ center 0 .8 0  radius .7 }} }}"
    ));
    for algorithm in [Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Pm] {
        let settings = RenderSettings { samples: None, ..RenderSettings::new(algorithm) };
        assert_eq!(difference(&scene, &settings, EffectOverrides::ALL_FORCED_ON), None);
    }
}
