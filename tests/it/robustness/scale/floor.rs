//! A sphere of radius 10⁵ that serves as a floor.

use super::paired::{ROUNDING, mean_difference, summary};
use super::{PASSES, SIZE, low_cost_settings, pictures};
use caustica::color::Rgb;
use caustica::format::{SourceText, parse, resolve};
use caustica::integrate::{Algorithm, Settings};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
use std::path::Path;

/// Builds small objects on a floor with lights nearby.
///
/// Only the fraction (4/300)² of the light travels more than 300 units. So little of it returns
/// that single precision cannot resolve it.
fn scene_on_floor(floor: &str) -> Scene {
    let text = format!(
        "PerspectiveCamera {{ center 0 3.4 3  lookAt 0 .2 .1  angle 34  width {}  height {} }}
        Background {{ color .1 .1 .1 }}
        Lights {{
            SpotLight {{ position -1.5 4 1  lookAt 0 .3 0  angle 40  penumbra 8  intensity 60 55 50 }}
            SphereLight {{ center 1.8 2.5 -1  radius .1  power 60 60 70 }}
        }}
        Materials {{
            Diffuse ground {{ reflectance .6 .5 .4 }}
            Diffuse matte {{ reflectance .3 .6 .4 }}
            Dielectric glass {{ indexOfRefraction 1.5 }}
            Mirror silver {{ reflectance .9 .9 .9 }}
        }}
        Group {{
            MaterialName ground
            {floor}
            MaterialName glass
            Sphere {{ center -.6 .401 .4  radius .4 }}
            MaterialName matte
            Sphere {{ center .1 .2 -.6  radius .2 }}
            Transform {{ Translate .9 .36 .2  UniformScale .25  TriangleMesh {{ obj_file mesh/knot.obj }} }}
            MaterialName silver
            Transform {{ Translate .2 0 .7  Scale .2 .12 .2  TriangleMesh {{ obj_file mesh/ring.obj }} }}
        }}",
        SIZE.0, SIZE.1
    );
    resolved(&text)
}

fn resolved(text: &str) -> Scene {
    let name = "floor.txt";
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    resolve(&parse(name, text).unwrap(), &SourceText::new(name, text), &scenes).unwrap()
}

const FLAT: &str = "Disc { center 0 0 0  normal 0 1 0  radius 300 }";
const ROUND: &str = "Sphere { center 0 -100000 0  radius 100000 }";

/// A sphere of radius 10⁵ looks like a flat floor.
///
/// Where the objects stand, the sphere deviates from a plane by 2²/(2·10⁵) = 2·10⁻⁵. Pixels differ
/// only at edges of objects and shadows, which move by about 10⁻⁵. A pixel is 10⁻¹ wide. In glass
/// and mirrors, edges move ten times as far. So about one pixel in a thousand differs. The test
/// allows five times as many.
#[test]
#[ignore = "long: many samples of a hard case"]
fn sphere_of_radius_100000_acts_as_flat_floor() {
    let (flat, round) = (scene_on_floor(FLAT), scene_on_floor(ROUND));
    // `whitted` samples all lights and chooses none.
    let render = |scene| pictures(scene, Algorithm::Whitted, low_cost_settings(), PASSES);
    let (a, b) = (render(&flat), render(&round));
    let off = |(a, b): &(&Rgb, &Rgb)| (**a - **b).abs().max_element() > 1e-3 * b.max_element();
    let differ = a.iter().flatten().zip(b.iter().flatten()).filter(off).count();
    let all = a.len() * a[0].len();
    assert!(differ * 200 < all, "{differ} of {all} pixels differ");

    // The photons differ, because they are emitted towards a domain of another size.
    let settings = Settings { initial_gather_radius: Some(0.05), ..low_cost_settings() };
    let seen = |scene| -> Vec<Vec<f64>> {
        let images = pictures(scene, Algorithm::Hybrid, settings.clone(), 4 * PASSES);
        images.iter().map(|image| summary(image, SIZE)).collect()
    };
    let objection = mean_difference(&seen(&round), &seen(&flat), ROUNDING + 2e-5, 0.02);
    assert!(objection.is_none(), "{}", objection.unwrap());
}

/// Pilots derive gather radii from the objects on which photons lie, not from the size of the
/// floor.
///
/// Both pilots take the third quartile of 512 photons, whose rank has a standard deviation of 2 %.
/// Radii vary twofold over the ranks, so this is less than a tenth of a radius.
#[test]
#[ignore = "long: many samples of a hard case"]
fn huge_floor_does_not_blur_caustics() {
    let settings = || Settings { aimed_paths: 250_000, ..low_cost_settings() };
    let radius =
        |floor| Algorithm::Hybrid.prepare(&scene_on_floor(floor), settings()).initial_gather_radii().unwrap().caustic;
    let (flat, round) = (radius(FLAT), radius(ROUND));
    assert!((round / flat - 1.0).abs() < 0.1, "{round} on a sphere, {flat} on a disc");
}

/// Returns the flux \[W] of photons where `counts` is true.
///
/// The pass has 2¹⁷ photon paths, emitted in all directions.
fn flux(scene: &Scene, mask: StoreMask, counts: impl Fn(glam::DVec3) -> bool) -> f64 {
    let source = PhotonSource::emitting_in_all_directions(scene).unwrap();
    let tracer = PhotonTracer { scene, source: &source, mask, max_bounces: 20 };
    let photons = tracer.trace(Key::new(3).purpose_key(Purpose::Test), 1 << 17, &|_| {}).deposits.surface_photons;
    let landed = photons.iter().filter(|p| counts(p.position.as_dvec3() + scene.origin()));
    landed.map(|p| f64::from(p.attributes.flux().y)).sum()
}

/// Glass and stone half a unit below a light shade a floor of any size.
#[test]
fn occluder_near_light_shades_huge_floor() {
    let under_a_lamp = |floor: &str| {
        resolved(&format!(
            "PerspectiveCamera {{ center 0 3.4 3  lookAt 0 .2 .1  angle 34  width {}  height {} }}
            Background {{ color 0 0 0 }}
            Lights {{ PointLight {{ position 0 2 0  power 9 9 9 }} }}
            Materials {{
                Diffuse ground {{ reflectance .6 .5 .4 }}
                Dielectric glass {{ indexOfRefraction 1.5 }}
            }}
            Group {{
                MaterialName ground
                {floor}
                Sphere {{ center .35 1.4 0  radius .2 }}
                MaterialName glass
                Sphere {{ center -.35 1.4 0  radius .2 }}
            }}",
            SIZE.0, SIZE.1
        ))
    };
    let (flat, round) = (under_a_lamp(FLAT), under_a_lamp(ROUND));
    let render = |scene| pictures(scene, Algorithm::Whitted, low_cost_settings(), PASSES);
    let (a, b) = (render(&flat), render(&round));
    let off = |(a, b): &(&Rgb, &Rgb)| (**a - **b).abs().max_element() > 1e-3 * b.max_element();
    let differ = a.iter().flatten().zip(b.iter().flatten()).filter(off).count();
    assert!(differ * 200 < a.len() * a[0].len(), "{differ} pixels differ");

    // Seen from the light, the glass has the solid angle 2π(1 − √(1 − .2²/.4825)) sr, .0212 of the
    // sphere. So 2777 paths hit it, and as many hit the stone. The light through the glass agrees
    // on both floors within five sigma of the difference, 5·√2/√2777.
    let near = |p: glam::DVec3| p.length() < 3.0;
    for (mask, place) in
        [(StoreMask::CAUSTIC, &near as &dyn Fn(_) -> _), (StoreMask::DIRECT, &|p| near(p) && p.y > 1.0)]
    {
        let (flat, round) = (flux(&flat, mask, place), flux(&round, mask, place));
        assert!(flat > 9.0 * 0.01 && (round / flat - 1.0).abs() < 0.134, "{round} W on a sphere, {flat} W on a disc");
    }
}

/// A light that lies on a huge sphere lights a ceiling half a unit above.
///
/// Rounding may place the light inside the sphere. A disc of radius r receives the fraction (1 −
/// h/√(h² + r²))/2 of the light of a point at the distance h, here .276. 2¹⁷ paths measure it to
/// .0012.
#[test]
fn light_on_huge_floor_reaches_objects_above() {
    for x in [0.0f64, 0.3, -0.7, 1.1, 2.3] {
        let y = -x * x / (1e5 + (1e10 - x * x).sqrt());
        let scene = resolved(&format!(
            "PerspectiveCamera {{ center 0 .2 3  lookAt 0 .2 .1  angle 34  width 8  height 8 }}
            Background {{ color 0 0 0 }}
            Lights {{ PointLight {{ position {x} {y:e} 0  power 1 1 1 }} }}
            Group {{ {ROUND} Disc {{ center {x} .5 0  normal 0 -1 0  radius 1 }} }}"
        ));
        let seen = flux(&scene, StoreMask::DIRECT, |p| p.y > 0.25);
        let expected = 0.5 * (1.0 - 0.5 / 1.25f64.sqrt());
        assert!((seen - expected).abs() < 5.0 * 0.0013, "{x}: {seen} of {expected}");
    }
}
