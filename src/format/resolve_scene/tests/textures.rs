//! Tests of textures in scenes: files, value ranges, texture coordinates, emission.

use super::*;
use crate::image::{self, Image, WriteOptions};

/// Returns the text of a scene with a ball of the first material.
fn ball_scene_text(textures: &str, materials: &str) -> String {
    format!(
        "Textures {{ {textures} }}\nMaterials {{ {materials} }}\nGroup {{ MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
    )
}

fn write_picture(path: &Path, value: f32) {
    let pixels = Image::from_pixels(2, 2, vec![Vec3::splat(value); 4]).unwrap();
    image::write(path, &pixels, &WriteOptions::default()).unwrap();
}

fn bsdf_seen_from_front(scene: &Scene) -> Bsdf {
    visible_surface(scene, dvec3(0.0, 0.0, 5.0), Vec3::NEG_Z).unwrap().0.bsdf
}

#[test]
fn texture_values_out_of_range_are_refused() {
    for (field, kind) in [("reflectance", "Diffuse"), ("transmittance", "Thin"), ("roughness", "Dielectric")] {
        let error =
            resolve_error(&ball_scene_text("Checker loud { color1 2 0 0 }", &format!("{kind} {{ {field} loud }}")));
        assert_eq!((error.line(), error.offending_text()), (3, "loud"), "{error}");
        assert!(error.message().contains("from 0 to 2") && error.remedy().contains("between 0 and 1"), "{error}");
    }
    // Radiance has no upper bound. Neither has the diffuse color of `Phong`, because too bright a
    // material is scaled down.
    resolve_scene_text(&ball_scene_text("Checker loud { color1 2 0 0 }", "Phong { diffuseColor loud emission loud }"));
}

#[test]
fn pictures_are_decoded_as_color_or_numbers() {
    let folder = tempfile::tempdir().unwrap();
    write_picture(&folder.path().join("half.png"), 0.5);
    write_picture(&folder.path().join("half.exr"), 0.5);
    let with = |textures: &str, material: &str| resolve_in_folder(folder.path(), &ball_scene_text(textures, material));
    let front_reflectance =
        |textures: &str, material: &str| match bsdf_seen_from_front(&with(textures, material).unwrap()) {
            Bsdf::Diffuse(reflectance) => reflectance.x,
            other => panic!("{other:?}"),
        };
    // Eight bits round by up to half a level; 0.5 is level 188 of the sRGB curve.
    assert!((front_reflectance("Image t { file half.png }", "Diffuse { reflectance t }") - 0.5).abs() < 0.003);
    let numbers = front_reflectance("Image t { file half.png encoding linear }", "Diffuse { reflectance t }");
    assert!((numbers - 188.0 / 255.0).abs() < 1e-6, "{numbers}");
    assert_eq!(front_reflectance("Image t { file half.exr }", "Diffuse { reflectance t }"), 0.5);
    // `texture` names a texture, or else a picture, which multiplies `diffuseColor`.
    assert_eq!(front_reflectance("", "Phong { diffuseColor .5 1 1 texture half.exr }"), 0.25);
    assert_eq!(front_reflectance("Checker half.exr { color0 1 1 1 }", "Phong { texture half.exr }"), 1.0);

    let error = with("Image t { file half.png }", "Diffuse { reflectance t normalMap t }").unwrap_err();
    assert!(error.offending_text() == "t" && error.remedy().contains("encoding linear"), "{error}");
    with("Image t { file half.png encoding linear }", "Diffuse { reflectance t normalMap t }").unwrap();
    with("", "Diffuse { reflectance 1 1 1 normalMap half.png }").unwrap();
}

#[test]
fn unreadable_pictures_are_reported_at_their_path() {
    let folder = tempfile::tempdir().unwrap();
    write_picture(&folder.path().join("dark.exr"), -1.0);
    let with = |textures: &str, material: &str| {
        resolve_in_folder(folder.path(), &ball_scene_text(textures, material)).unwrap_err()
    };
    let missing = with("Image t { file no.png }", "Mirror { }");
    assert_eq!((missing.line(), missing.offending_text()), (2, "no.png"), "{missing}");
    assert!(missing.message().contains("does not exist"));
    for (field, text) in [("bump no.png bumpHeight 1", "no.png"), ("normalMap no.png", "no.png")] {
        let error = with("", &format!("Mirror {{ {field} }}"));
        assert_eq!((error.line(), error.offending_text()), (3, text), "{error}");
        assert!(error.message().contains("texture or picture"), "{error}");
    }
    let dark = with("Image t { file dark.exr }", "Mirror { }");
    assert!(dark.offending_text() == "dark.exr" && dark.message().contains("negative"), "{dark}");
}

#[test]
fn meshes_without_texcoords_take_solid_textures_only() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bare.obj"), "v -1 -1 0\nv 1 -1 0\nv -1 1 0\nf 1 2 3\n").unwrap();
    let with = |texture: &str, material: &str| {
        let text = format!(
            "Textures {{ {texture} }} Materials {{ {material} }}\nGroup {{ MaterialIndex 0 TriangleMesh {{ obj_file bare.obj }} }}"
        );
        resolve_in_folder(folder.path(), &text)
    };
    let error = with("Checker t { }", "Diffuse tiled { reflectance t }").unwrap_err();
    assert_eq!((error.line(), error.offending_text()), (3, "bare.obj"), "{error}");
    assert!(error.message().contains("`tiled`") && error.remedy().contains("Marble"), "{error}");
    assert!(
        with("Noise t { }", "Diffuse { reflectance .5 .5 .5 normalMap t }").is_err(),
        "directions go by coordinates"
    );
    with("Noise t { }", "Diffuse { reflectance t bump t bumpHeight .1 }").unwrap();
}

/// A solid texture is in object space: a rotated object keeps its pattern.
#[test]
fn solid_textures_move_with_their_objects() {
    let of = |steps: &str| {
        resolve_scene_text(&format!(
            "Textures {{ Wood t {{ frequency 3 }} }} Materials {{ Diffuse {{ reflectance t }} }}
             Group {{ MaterialIndex 0 Transform {{ {steps} Sphere {{ center 0 0 0 radius 1 }} }} }}"
        ))
    };
    let plain = of("UniformScale 1");
    let (moved, turned) = (of("Translate 5 0 0 UniformScale 2"), of("XRotate 90"));
    for (x, y) in [(0.1, 0.2), (-0.5, 0.3), (0.0, -0.7)] {
        let at = |scene: &Scene, p: DVec3| visible_surface(scene, p, Vec3::NEG_Z).unwrap().0.bsdf;
        let expected = at(&plain, dvec3(x, y, 9.0));
        let is_nearly_equal = |found: Bsdf| match (found, expected) {
            (Bsdf::Diffuse(a), Bsdf::Diffuse(b)) => assert!((a - b).abs().max_element() < 1e-4, "{a} {b}"),
            other => panic!("{other:?}"),
        };
        is_nearly_equal(at(&moved, dvec3(5.0 + 2.0 * x, 2.0 * y, 9.0)));
        // `XRotate 90` takes (x, y, z) to (x, −z, y). So a view from −y at the turned sphere shows
        // the side that faced +z before.
        is_nearly_equal(visible_surface(&turned, dvec3(x, -9.0, y), Vec3::Y).unwrap().0.bsdf);
    }
}

/// The emission texture applies to each patch of its object. An object without a surface does not
/// change the emission texture of the previous object.
#[test]
fn all_patches_of_an_object_have_textured_emission() {
    let net = |x: f64| {
        let at = |i: u32| format!("[ {} {} 0 ]", x + f64::from(i / 4), i % 4);
        (0..16).map(at).collect::<Vec<_>>().join(" ")
    };
    let emits = |objects: &str| -> Vec<bool> {
        let materials = "Diffuse plain { reflectance 0 0 0 } Diffuse panel { reflectance 0 0 0 emission t }";
        let text = format!("Textures {{ Checker t {{ }} }} Materials {{ {materials} }} Group {{ {objects} }}");
        resolve_scene_text(&text).object_summaries().map(|o| o.has_emission_texture).collect()
    };
    let patches = format!("MaterialName panel BezierPatch {{ controls {} {} }}", net(0.0), net(5.0));
    assert_eq!(emits(&patches), [true, true]);
    let before = "MaterialName plain Sphere { center 0 0 0 radius 1 emission 5 5 5 }";
    let curve = "MaterialName panel BezierCurve { controls [ 3 0 0 ] [ 3 1 0 ] [ 1 1 0 ] }";
    assert_eq!(emits(&format!("{before} {curve}")), [false]);
}
