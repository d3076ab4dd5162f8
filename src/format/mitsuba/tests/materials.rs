//! Tests of the conversion of BSDFs.

use super::{assert_import_error, has_note, import_text, placed_objects, sphere_material};
use crate::format::description::{
    DielectricDescription, MaterialKindDescription, MixDescription, NormalPerturbationDescription, ObjectDescription,
    PrincipledDescription, RefractiveIndexDescription, TextureKindDescription, TexturedValue,
};
use glam::DVec3;

/// Returns a chain of `count` blends that ends at a diffuse BSDF. Each blend mixes the next one
/// with itself.
///
/// The outermost blend has the identifier `b0`.
fn doubling_blends(count: usize) -> String {
    let blend = |i: usize| {
        let next = format!("<ref id=\"b{}\"/>", i + 1);
        format!("<bsdf type=\"blendbsdf\" id=\"b{i}\">{next}{next}</bsdf>")
    };
    (0..count).map(blend).collect::<String>() + &format!("<bsdf type=\"diffuse\" id=\"b{count}\"/>")
}

#[test]
fn principled_has_the_parameters_of_the_file() {
    let found = sphere_material(
        r#"<bsdf type="principled"><rgb name="base_color" value=".1 .2 .3"/><float name="metallic" value=".25"/>
        <float name="roughness" value=".5"/><float name="specular" value=".5"/><float name="spec_trans" value=".75"/>
        <float name="clearcoat" value=".8"/><float name="clearcoat_gloss" value="1"/></bsdf>"#,
    );
    let MaterialKindDescription::Principled(principled) = found.kind else { panic!() };
    let PrincipledDescription { base_color, metallic, roughness, eta, transmission, clearcoat, .. } = principled;
    assert_eq!(base_color, DVec3::new(0.1, 0.2, 0.3).into());
    assert_eq!([metallic, roughness, transmission], [0.25, 0.25, 0.75].map(TexturedValue::Constant));
    // A `specular` of 0.5 is a reflectance of 0.04 at normal incidence, so the index is 1.5.
    assert!((eta - 1.5).abs() < 1e-12, "{eta}");
    assert_eq!(clearcoat, TexturedValue::Constant(0.2));
    assert!((principled.clearcoat_roughness - 0.001).abs() < 1e-12);
    let glass = sphere_material(r#"<bsdf type="principled"><float name="spec_trans" value="1"/></bsdf>"#).kind;
    assert!(matches!(glass, MaterialKindDescription::Dielectric(_)), "{glass:?}");
}

#[test]
fn numbers_are_the_channel_mean_of_constant_colors() {
    let opacity = r#"<rgb name="opacity" value="0.75 0 0"/>"#;
    let masked = sphere_material(&format!("<bsdf type=\"mask\">{opacity}<bsdf type=\"diffuse\"/></bsdf>"));
    let MaterialKindDescription::Mix(MixDescription { second_probability, .. }) = masked.kind else { panic!() };
    assert_eq!(second_probability, TexturedValue::Constant(0.25));
}

#[test]
fn spectra_in_scale_textures_keep_bright_radiance() {
    let spectrum = r#"<texture type="regular"><string name="range" value="300, 900"/>
        <string name="values" value="4, 4"/></texture>"#;
    let radiance = format!("<texture type=\"scale\" name=\"radiance\">{spectrum}</texture>");
    let scene = import_text(&format!("<shape type=\"sphere\"><emitter type=\"area\">{radiance}</emitter></shape>"));
    let ObjectDescription::Shape { emission: Some(radiance), .. } = placed_objects(&scene)[0].1 else { panic!() };
    assert!(radiance.min_element() > 2.0, "{radiance}");
}

#[test]
fn a_bsdf_of_many_blends_is_converted_once() {
    let scene = import_text(&(doubling_blends(8) + "<shape type=\"sphere\"><ref id=\"b0\"/></shape>"));
    // The materials are eight mixes and the diffuse BSDF.
    assert_eq!(scene.description.materials.len(), 9, "{:?}", scene.description.materials);
}

#[test]
fn too_deeply_nested_mixes_are_errors() {
    let shape = "\n<shape type=\"sphere\"><ref id=\"b0\"/></shape>";
    assert_import_error(&(doubling_blends(9) + shape), "mixes nest more than 8 deep");
    assert_import_error(&(doubling_blends(22) + shape), "mixes nest more than 8 deep");
    let masks = "<bsdf type=\"mask\">".repeat(9) + "<bsdf type=\"diffuse\"/>" + &"</bsdf>".repeat(9);
    assert_import_error(&format!("<shape type=\"sphere\">{masks}</shape>"), "mixes nest more than 8 deep");
}

#[test]
fn blends_of_two_dielectrics_become_the_one_of_larger_weight() {
    let glass = |index: &str| {
        format!(
            "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"{index}\"/>\
             <float name=\"ext_ior\" value=\"1\"/></bsdf>"
        )
    };
    for (weight, expected) in [("0.25", 1.5), ("0.75", 1.25)] {
        let (first, second) = (glass("1.5"), glass("1.25"));
        let scene = import_text(&format!(
            "<shape type=\"sphere\"><bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"{weight}\"/>{first}\
             <bsdf type=\"mask\">{second}</bsdf></bsdf></shape>
             <shape type=\"sphere\"><bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"{weight}\"/>\
             {first}{second}</bsdf></shape>"
        ));
        let found = &scene.description.materials.last().unwrap().value.kind;
        let MaterialKindDescription::Dielectric(DielectricDescription { refraction, .. }) = found else {
            panic!("{found:?}")
        };
        assert_eq!(*refraction, RefractiveIndexDescription::Constant(expected));
        assert!(has_note(&scene, "blends of two dielectrics become the one with the larger weight (2×"));
        // The parser refuses a mix of two dielectrics.
        let text = scene.description.to_string();
        assert!(crate::format::parse("a.txt", &text).is_ok(), "{text}");
    }
}

#[test]
fn negative_factors_of_bump_textures_negate_the_height() {
    let scene = import_text(
        r#"<shape type="sphere"><bsdf type="bumpmap"><float name="scale" value="3"/><bsdf type="diffuse"/>
          <texture type="scale"><float name="scale" value="-2"/><texture type="checkerboard">
          <rgb name="color0" value="0.5"/><rgb name="color1" value="0.25"/></texture></texture></bsdf></shape>"#,
    );
    let bump = &scene.description.materials[0].normal_perturbation;
    assert!(matches!(bump, Some(NormalPerturbationDescription::Bump { height: -3.0, .. })), "{bump:?}");
    let TextureKindDescription::Checker { colors, .. } = scene.description.textures[0].kind else { panic!() };
    assert_eq!(colors, [DVec3::splat(1.0), DVec3::splat(0.5)]);
}
