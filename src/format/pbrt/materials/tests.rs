//! Tests of materials of pbrt: scopes of names, glass, mixes and errors.

use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricDescription, DiffuseDescription, GroupItem,
    MaterialKindDescription, PhongDescription, TexturedValue, ThinDielectricDescription,
};
use crate::format::import::ImportedScene;
use crate::format::pbrt::tests::{import_text, note_messages, try_import_text};

/// Returns the red reflectance of the diffuse material of each shape, in order.
fn diffuse_reds(scene: &ImportedScene) -> Vec<f64> {
    let red = |item: &GroupItem| {
        let GroupItem::MaterialName(name) = item else { return None };
        let materials = &scene.description.materials;
        let material = materials.iter().find(|material| material.name.as_ref() == Some(&name.value)).unwrap();
        match &material.kind {
            MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: TexturedValue::Constant(color) }) => {
                Some(color.x)
            }
            other => panic!("{other:?}"),
        }
    };
    scene.description.root.items.iter().filter_map(red).collect()
}

/// Returns directives that define the diffuse material `m` with red reflectance `red`, and use it
/// for a sphere.
fn defined_and_used(red: &str) -> String {
    format!(
        "MakeNamedMaterial \"m\" \"string type\" \"matte\" \"rgb Kd\" [{red} 0 0] NamedMaterial \"m\" \
         Shape \"sphere\" "
    )
}

#[test]
fn v3_material_names_end_with_their_block() {
    let scene = import_text(&format!(
        "Film \"image\" WorldBegin {} AttributeBegin {} AttributeEnd NamedMaterial \"m\" Shape \"sphere\" {}",
        defined_and_used(".1"),
        defined_and_used(".2"),
        defined_and_used(".3"),
    ));
    assert_eq!(diffuse_reds(&scene), [0.1, 0.2, 0.1, 0.3]);
    let ended = format!("Film \"image\" AttributeBegin {} AttributeEnd\nNamedMaterial \"m\" Shape \"sphere\"", {
        defined_and_used(".1")
    });
    assert!(try_import_text(&ended).unwrap_err().to_string().contains("line 2"));
}

#[test]
fn second_definitions_of_v4_materials_are_refused() {
    let text = format!("{}\n{}", defined_and_used(".1"), defined_and_used(".2"));
    let error = try_import_text(&text).unwrap_err().to_string();
    assert!(error.contains("line 2") && error.contains("defined twice"), "{error}");
}

#[test]
fn missing_textures_of_opacity_are_reported_with_their_line() {
    let error = try_import_text("WorldBegin\nShape \"sphere\" \"texture alpha\" \"missing\"").unwrap_err().to_string();
    assert!(error.contains("line 2") && error.contains("missing"), "{error}");
}

#[test]
fn ignored_glass_colors_have_a_note() {
    let has_note = |colors: &str| {
        let text = format!(
            "Film \"image\" WorldBegin Texture \"t\" \"spectrum\" \"constant\" Material \"glass\" {colors} \
             Shape \"sphere\""
        );
        note_messages(&import_text(&text)).contains("colors of glass")
    };
    assert!(has_note("\"rgb Kr\" [1 1 1] \"rgb Kt\" [.2 .9 .2]"));
    assert!(has_note("\"texture Kt\" \"t\"") && has_note("\"rgb Kr\" [.5 1 1]"));
    assert!(!has_note("") && !has_note("\"rgb Kr\" [1 1 1] \"rgb Kt\" [1 1 1]"));
}

#[test]
fn panes_and_coats_take_the_index_of_named_glasses() {
    let scene = import_text("WorldBegin Material \"thindielectric\" \"spectrum eta\" \"glass-BK7\" Shape \"sphere\"");
    assert!(note_messages(&scene).contains("one index for all wavelengths"));
    let MaterialKindDescription::Thin(ThinDielectricDescription { eta, .. }) = scene.description.materials[0].kind
    else {
        panic!()
    };
    assert!((eta - 1.5168).abs() < 1e-3, "{eta}");
    let scene = import_text("WorldBegin Material \"coateddiffuse\" \"spectrum eta\" \"glass-SF5\" Shape \"sphere\"");
    let MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription { eta, .. }) =
        scene.description.materials[0].kind
    else {
        panic!()
    };
    assert_eq!(eta, 1.6727);
}

#[test]
fn dielectric_mixes_become_the_component_of_larger_weight() {
    let glass = |name: &str, index: f64| {
        format!("MakeNamedMaterial \"{name}\" \"string type\" \"dielectric\" \"float eta\" {index} ")
    };
    let scene = import_text(&format!(
        "WorldBegin {}{}Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .7 Shape \"sphere\"",
        glass("a", 1.3),
        glass("b", 1.5)
    ));
    let (items, materials) = (&scene.description.root.items, &scene.description.materials);
    let used = materials.iter().filter(|material| {
        items
            .iter()
            .any(|item| matches!(item, GroupItem::MaterialName(name) if Some(&name.value) == material.name.as_ref()))
    });
    let kinds: Vec<_> = used.map(|material| &material.kind).collect();
    let [MaterialKindDescription::Dielectric(glass)] = kinds[..] else { panic!("{kinds:?}") };
    assert_eq!(glass.refraction, 1.5.into());
    assert!(note_messages(&scene).contains("mixes of two dielectrics"));
}

#[test]
fn too_deeply_nested_mixes_are_errors() {
    let mix = |level: u32| {
        format!(
            "MakeNamedMaterial \"m{level}\" \"string type\" \"mix\" \"string materials\" [\"m{}\" \"leaf\"]\n",
            level - 1
        )
    };
    let leaf = "MakeNamedMaterial \"leaf\" \"string type\" \"diffuse\" ";
    let chain = |depth: u32| {
        let first = "MakeNamedMaterial \"m0\" \"string type\" \"diffuse\" \"float reflectance\" .2\n";
        let mixes: String = (1..=depth).map(mix).collect();
        format!("WorldBegin {leaf}{first}{mixes}NamedMaterial \"m{depth}\" Shape \"sphere\"")
    };
    assert!(try_import_text(&chain(8)).is_ok());
    assert!(try_import_text(&chain(9)).unwrap_err().to_string().contains("nest too deep"));
}

#[test]
fn roughness_0_is_smooth_only_for_glass() {
    let kind = |directive: &str| {
        let text = format!("WorldBegin Material {directive} \"float roughness\" 0 Shape \"sphere\"");
        import_text(&text).description.materials[0].kind.clone()
    };
    let MaterialKindDescription::Conductor(ConductorDescription { roughness, .. }) = kind("\"metal\"") else {
        panic!()
    };
    let TexturedValue::Constant(alpha) = roughness else { panic!() };
    assert!((alpha - 0.0473).abs() < 1e-4, "{alpha}");
    let MaterialKindDescription::Dielectric(DielectricDescription { roughness, .. }) = kind("\"glass\"") else {
        panic!()
    };
    assert_eq!(roughness, TexturedValue::Constant(0.0));
    let MaterialKindDescription::Phong(PhongDescription { shininess, .. }) = kind("\"substrate\"") else { panic!() };
    assert!((shininess + 2.0 - 2.0 / (alpha * alpha)).abs() < 1e-9 * shininess, "{shininess}");
}

#[test]
fn gloss_of_uber_follows_its_index() {
    let specular = |index: &str| {
        let text = format!("WorldBegin Material \"uber\" {index} Shape \"sphere\"");
        let MaterialKindDescription::Phong(phong) = import_text(&text).description.materials[0].kind.clone() else {
            panic!()
        };
        let TexturedValue::Constant(specular) = phong.specular else { panic!() };
        specular.x
    };
    // Normal reflectances are 0.04 for index 1.5, and 0.25 for index 3.
    for name in ["index", "eta"] {
        let ratio = specular(&format!("\"float {name}\" 3")) / specular("");
        assert!((ratio - 0.25 / 0.04).abs() < 1e-9, "{name}: {ratio}");
    }
}
