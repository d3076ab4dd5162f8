//! Tests of resolved materials.

use super::{CAMERA, is_nearly_equal, resolve_error, resolve_scene_text};
use crate::bsdf::{METAL_NAMES, conductor_reflectance, metal_refractive_index};
use crate::color::{DispersionFormula, GLASSES};
use crate::format::description::{MaterialKindDescription, MixDescription};
use crate::format::{SourceText, parse, resolve};
use crate::scene::{Body, Material, Scene};
use glam::{Vec3, vec3};
use std::path::Path;

const BALL: &str = "Group { Sphere { center 0 0 0 radius 1 } }";

fn resolve_materials(materials: &str) -> Scene {
    resolve_scene_text(&format!("Materials {{ {materials} }} {BALL}"))
}

#[test]
fn materials_are_resolved() {
    let materials = "Materials {
        Dielectric { indexOfRefraction 1.7 roughness .25 priority 7 }
        Dielectric { absorption 1 2 3 }
        Dielectric { tint .5 1 .25 tintDistance 2 }
        Mirror { reflectance .9 .8 .7 }
        Phong { diffuseColor .1 .2 .3 specularColor .4 .5 .6 shininess 7 }
    }";
    let scene = resolve_scene_text(&format!("{materials} Group {{ Sphere {{ center 0 0 0 radius 1 }} }}"));
    let absorption = |i: usize| scene.materials()[i].enclosed_body().unwrap().absorption;
    let body = Body { priority: 7, ..Body::new(1.7) };
    assert_eq!(scene.materials()[0], Material::rough_boundary(body, 0.25));
    assert_eq!((absorption(0), absorption(1)), (Vec3::ZERO, vec3(1.0, 2.0, 3.0)));
    // Transmittance 1/2 over two units means ln 2 / 2 per unit; 1/4 over two units means ln 2.
    let ln2 = std::f32::consts::LN_2;
    assert!(is_nearly_equal(absorption(2), vec3(0.5 * ln2, 0.0, ln2)));
    assert_eq!(scene.materials()[3], Material::mirror(vec3(0.9, 0.8, 0.7)));
    assert_eq!(scene.materials()[4], Material::phong(vec3(0.1, 0.2, 0.3), vec3(0.4, 0.5, 0.6), 7.0));
}

#[test]
fn metals_have_the_named_or_given_index() {
    for name in METAL_NAMES {
        let (eta, k) = metal_refractive_index(name).unwrap();
        let scene = resolve_materials(&format!("Conductor {{ metal {name} roughness .5 }}"));
        assert_eq!(scene.materials()[0], Material::conductor(eta, k, 0.5), "{name}");
    }
    let scene = resolve_materials("Conductor { eta 1 2 3 k 4 5 6 }");
    assert_eq!(scene.materials()[0], Material::conductor(vec3(1.0, 2.0, 3.0), vec3(4.0, 5.0, 6.0), 0.0));
    // Reflectance at normal incidence is ((n − 1)² + k²) / ((n + 1)² + k²).
    let facing = conductor_reflectance(1.0, vec3(1.0, 2.0, 3.0), vec3(4.0, 5.0, 6.0));
    assert!(is_nearly_equal(facing, vec3(16.0 / 20.0, 26.0 / 34.0, 40.0 / 52.0)));
    let error = resolve_error(&format!("Materials {{\nConductor {{ metal unobtainium }} }} {BALL}"));
    assert_eq!((error.line(), error.column(), error.offending_text()), (3, 19, "unobtainium"));
    assert!(error.message().contains("no metal is called `unobtainium`"));
    assert!(METAL_NAMES.iter().all(|name| error.remedy().contains(name)), "{}", error.remedy());
}

#[test]
fn glasses_have_the_named_or_given_index() {
    let index = |scene: &Scene| {
        let body = scene.materials()[0].enclosed_body().unwrap();
        (body.eta, body.dispersion_formula.map(|g| scene.dispersion_formulas()[g as usize]))
    };
    for (name, glass, _) in GLASSES {
        let scene = resolve_materials(&format!("Dielectric {{ glass {name} }}"));
        assert_eq!(index(&scene), (glass.refractive_index_at_d_line(), Some(glass)), "{name}");
    }
    let crown = DispersionFormula::from_abbe_number(1.5, 60.0);
    assert_eq!(index(&resolve_materials("Dielectric { indexOfRefraction 1.5 abbe 60 }")), (1.5, Some(crown)));
    let cauchy = DispersionFormula::Cauchy { a: 1.5, b: 0.004, c: 1e-5 };
    assert_eq!(
        index(&resolve_materials("Dielectric { cauchy 1.5 .004 1e-5 }")),
        (cauchy.refractive_index_at_d_line(), Some(cauchy))
    );
    let sellmeier = DispersionFormula::Sellmeier { b: [1.0, 0.5, 0.0, 0.0], c: [0.01, 90.0, 0.0, 0.0] };
    let scene = resolve_materials("Dielectric { sellmeierB 1 .5 sellmeierC .01 90 }");
    assert_eq!(index(&scene), (sellmeier.refractive_index_at_d_line(), Some(sellmeier)));
    assert_eq!(index(&resolve_materials("Dielectric { indexOfRefraction 1.5 }")), (1.5, None));
}

#[test]
fn unknown_glasses_are_refused_with_suggestions() {
    let error = resolve_error(&format!("Materials {{\nDielectric {{ glass diamant }} }} {BALL}"));
    assert_eq!((error.line(), error.column(), error.offending_text()), (3, 20, "diamant"));
    assert!(error.message().contains("no glass is called `diamant`"));
    assert!(error.remedy().starts_with("did you mean `diamond`? known are BK7, "), "{}", error.remedy());
    assert!(GLASSES.iter().all(|g| error.remedy().contains(g.0)), "{}", error.remedy());
    let error = resolve_error(&format!("Materials {{ Dielectric {{ glass unobtainium }} }} {BALL}"));
    assert!(error.remedy().starts_with("known are BK7, "), "{}", error.remedy());
}

#[test]
fn panes_have_index_and_transmittance() {
    let scene = resolve_materials("Thin { indexOfRefraction 1.25 transmittance .5 1 .25 }");
    assert_eq!(scene.materials()[0], Material::thin_dielectric(1.25, vec3(0.5, 1.0, 0.25)));
}

#[test]
fn mixes_resolve_to_material_indices() {
    let scene = resolve_materials(
        "Diffuse { reflectance 0 0 0 } Diffuse a { reflectance 1 0 .5 }
        Phong b { diffuseColor 0 1 .5 specularColor .5 .5 .5 shininess 8 }
        Mix m { first a second b amount .25 } Mix { first m second a amount 1 }",
    );
    let mixes: Vec<_> = scene.materials()[3..].iter().map(Material::kind).collect();
    assert_eq!(mixes, [Material::mix(1, 2, 0.25).kind(), Material::mix(3, 1, 1.0).kind()]);
}

#[test]
fn a_mix_that_contains_itself_is_refused() {
    // The parser refuses a mix that contains itself. But a description may be changed after
    // parsing.
    let text = format!("{CAMERA}Materials {{ Mirror a {{ }}\nMix m {{ first a second a amount 0 }} }} {BALL}");
    let mut description = parse("a.txt", &text).unwrap();
    if let MaterialKindDescription::Mix(MixDescription { second, .. }) = &mut description.materials[1].value.kind {
        second.value = "m".to_owned();
    }
    let error = resolve(&description, &SourceText::new("a.txt", &text), Path::new("")).unwrap_err();
    assert_eq!((error.line(), error.column()), (3, 24));
    assert!(error.message().contains("no material named `m`") && !error.remedy().is_empty());
}
