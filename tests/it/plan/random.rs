//! Plans of random scenes: switching off unneeded effects changes no bit of the picture, and the
//! stated features of the scene are true.

use super::compare::{RenderSettings, difference, scene};
use super::generate::{Random, sketch, with_one_more};
use super::judge;
use super::sketch::{Light, LightKind, Material, Object, Shape, Sketch};
use caustica::integrate::{Algorithm, FinalGathering};
use caustica::plan::{EffectOverrides, EffectReason, Plan};
use caustica::scene::{Effect, Effects};
use glam::DVec3;
use std::mem::{Discriminant, discriminant};

/// All reasons for which a plan switches an effect off, except that the integrator cannot simulate
/// the effect.
const OFF: [EffectReason; 13] = [
    EffectReason::NoLight,
    EffectReason::NoCaster,
    EffectReason::NoLitCaster,
    EffectReason::NoReceiver,
    EffectReason::BlackReceivers,
    EffectReason::OneFlatObject,
    EffectReason::NoSoftLight,
    EffectReason::NoEnvironmentLight,
    EffectReason::NoBody,
    EffectReason::NoTexture,
    EffectReason::NoBump,
    EffectReason::RequiredEffectUnneeded(Effect::Caustics),
    EffectReason::RequiredEffectUnneeded(Effect::Interreflection),
];

fn seeds(usual: u64) -> std::ops::Range<u64> {
    let given = std::env::var("CAUSTICA_PLAN_SEEDS").ok().map(|n| n.parse().expect("CAUSTICA_PLAN_SEEDS is a number"));
    0..given.unwrap_or(usual)
}

/// Panics with the number of findings and the first of them; does nothing if there are none.
fn report(wrong: &[String]) {
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong[..wrong.len().min(5)].join("\n\n"));
}

#[test]
fn random_plans_match_scene_contents() {
    let mut wrong = Vec::new();
    let mut reasons: Vec<Discriminant<EffectReason>> = Vec::new();
    let mut on = Effects::NONE;
    for seed in seeds(1000) {
        let sketch = sketch(seed);
        let text = sketch.text();
        let scene = scene(&text);
        let plan = Plan::new(&scene, Effects::ALL, EffectOverrides::NO_OVERRIDES);
        wrong.extend(judge::plan_contradiction(&sketch, &scene, &plan).map(|o| format!("seed {seed}: {o}\n{text}")));
        for decision in &plan.decisions {
            if decision.is_simulated {
                on = on.with_effect(decision.effect);
            } else {
                reasons.push(discriminant(&decision.reason));
            }
        }
    }
    report(&wrong);
    for reason in OFF {
        assert!(reasons.contains(&discriminant(&reason)), "no scene was without something because {reason}");
    }
    assert_eq!(on, Effects::ALL, "some effect was never on");
}

#[test]
fn adding_objects_removes_no_effect() {
    let mut wrong = Vec::new();
    for seed in seeds(1000) {
        let (less, more) = (sketch(seed), with_one_more(&sketch(seed), seed + 7));
        let [before, after] =
            [&less, &more].map(|s| Plan::new(&scene(&s.text()), Effects::ALL, EffectOverrides::NO_OVERRIDES));
        // Skip empty scenes. There, the effect of shadows is on although nothing casts one, and
        // adding an object may switch it off.
        if before.features.objects == 0 {
            continue;
        }
        for (before, after) in before.decisions.iter().zip(&after.decisions) {
            if before.is_simulated && !after.is_simulated {
                wrong.push(format!("seed {seed}: {}: {}\n{}", before.effect, after.reason, more.text()));
            }
        }
    }
    report(&wrong);
}

/// Returns random settings, on which the plan must not depend.
fn random_settings(r: &mut Random, algorithm: Algorithm) -> RenderSettings {
    RenderSettings {
        passes: 1 + r.below(2) as u32,
        samples: r.pick(&[None, Some(1), Some(3)]),
        max_bounces: r.pick(&[0, 1, 2, 100, 100]),
        seed: r.next(),
        gather_k: r.pick(&[None, None, Some(0), Some(20)]),
        gathering: r.pick(&[FinalGathering::None, FinalGathering::Bsdf, FinalGathering::Importance]),
        ..RenderSettings::new(algorithm)
    }
}

const CHEAP: [Algorithm; 4] = [Algorithm::Path, Algorithm::Distributed, Algorithm::Whitted, Algorithm::Raycast];
const PHOTONS: [Algorithm; 4] = [Algorithm::Hybrid, Algorithm::Pm, Algorithm::Sppm, Algorithm::Ppm];

/// Returns overrides that force all effects on, or only one that the plan switches off.
fn random_forced_effects(r: &mut Random, plan: &Plan) -> EffectOverrides {
    let off: Vec<Effect> = plan.decisions.iter().filter(|d| !d.is_simulated).map(|d| d.effect).collect();
    if off.is_empty() || r.chance(0.6) {
        EffectOverrides::ALL_FORCED_ON
    } else {
        EffectOverrides::NO_OVERRIDES.with_forced_on(r.pick(&off))
    }
}

fn check(seed: u64, algorithm: Algorithm, change: impl FnOnce(&mut RenderSettings)) -> Option<String> {
    let text = sketch(seed).text();
    let scene = scene(&text);
    let r = &mut Random::new(!seed ^ algorithm as u64);
    let mut how = random_settings(r, algorithm);
    change(&mut how);
    let plan = Plan::new(&scene, algorithm.supported_effects(), EffectOverrides::NO_OVERRIDES);
    let found = difference(&scene, &how, random_forced_effects(r, &plan)).map(|d| format!("seed {seed}: {d}\n{text}"));
    // A finding is printed at once, because a search through many seeds takes long.
    found.inspect(|found| eprintln!("{found}"))
}

#[test]
#[ignore = "long: renders of many random scenes"]
fn path_images_match_with_all_effects_on() {
    let each = |seed| CHEAP.into_iter().filter_map(move |algorithm| check(seed, algorithm, |_| {}));
    report(&seeds(1000).flat_map(each).collect::<Vec<_>>());
}

/// Images by integrators with photons are the same bits with all effects on, at fixed radii.
///
/// Photons are not aimed, so scenes without caustics need no pilot.
#[test]
fn fixed_radius_images_match_with_all_effects_on() {
    let each = |seed| check(seed, PHOTONS[seed as usize % 4], |how| (how.radius, how.caustic_photons) = (Some(0.2), 0));
    report(&seeds(60).filter_map(each).collect::<Vec<_>>());
}

#[test]
fn photon_images_match_with_all_effects_on() {
    report(&seeds(60).filter_map(|seed| check(seed, PHOTONS[seed as usize % 4], |_| {})).collect::<Vec<_>>());
}

/// Images with many lights are the same bits with all effects on.
///
/// The scene has a floor, a ball, and many point lights. Effects that are off must not change the
/// probabilities of lights, not even by rounding.
#[test]
fn many_light_images_match_with_all_effects_on() {
    let picture = |seed| {
        let r = &mut Random::new(seed);
        let count = 3 + r.below(60);
        let lamp = |_| {
            let place = DVec3::new(r.between(-3.0, 3.0), r.between(2.0, 4.0), r.between(-3.0, 3.0));
            Light { kind: LightKind::Point(place), strength: DVec3::splat(r.between(0.1, 9.0)) }
        };
        let object = |shape| Object { material: 0, emission: DVec3::ZERO, shape };
        let sketch = Sketch {
            lights: (0..count).map(lamp).collect(),
            materials: vec![Material::Diffuse(DVec3::splat(0.5))],
            objects: vec![object(Shape::Plane(DVec3::ZERO, DVec3::Y)), object(Shape::Sphere(DVec3::Y, 0.8))],
            camera: "center -6.631 0 0  lookAt -0.337 0.646 -0.01  angle 25  width 12  height 9".to_owned(),
            background: DVec3::ZERO,
            filling: None,
            motion: None,
        };
        let how = RenderSettings {
            radius: Some(0.2),
            caustic_photons: 0,
            photons: 20_000,
            ..RenderSettings::new(Algorithm::Sppm)
        };
        difference(&scene(&sketch.text()), &how, EffectOverrides::ALL_FORCED_ON).map(|d| format!("seed {seed}: {d}"))
    };
    report(&(25..30).filter_map(picture).collect::<Vec<_>>());
}
