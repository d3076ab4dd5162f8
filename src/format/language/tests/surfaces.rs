//! Tests of dielectrics, conductors, thin panes, mixes, environments and patches.

use super::{assert_first_error, name_with_empty_span, parse_with_camera};
use crate::format::description::{
    BezierPatchesDescription, ConductorDescription, DielectricAbsorption, DielectricDescription, EnvironmentRadiance,
    GroupItem, LightDescription, MaterialKindDescription, MetalDescription, MixDescription, NurbsDescription,
    ObjectDescription, ShapeDescription, Spanned, ThinDielectricDescription,
};
use glam::DVec3;

pub(super) fn parse_material_kinds(body: &str) -> Vec<MaterialKindDescription> {
    let d = parse_with_camera(&format!("Materials {{ {body} }} Group {{ }}")).unwrap();
    d.materials.into_iter().map(|m| m.value.kind).collect()
}

#[track_caller]
pub(super) fn assert_material_error(body: &str, message: &str, help: &str) {
    assert_first_error(&format!("Materials {{ {body} }}"), message, help);
}

#[test]
fn dielectrics_read_roughness_and_priority() {
    let kinds = parse_material_kinds(
        "Dielectric { } Dielectric { priority 255 roughness .25 multipleScattering no indexOfRefraction 1000 }",
    );
    let absorption = DielectricAbsorption::None;
    assert_eq!(
        kinds[0],
        MaterialKindDescription::Dielectric(DielectricDescription {
            refraction: 1.5.into(),
            absorption,
            roughness: 0.0.into(),
            has_multiple_scattering: true,
            priority: 0
        })
    );
    assert_eq!(
        kinds[1],
        MaterialKindDescription::Dielectric(DielectricDescription {
            refraction: 1000.0.into(),
            absorption,
            roughness: 0.25.into(),
            has_multiple_scattering: false,
            priority: 255
        })
    );
    assert_material_error(
        "Dielectric { priority ‹256› }",
        "`priority` of `Dielectric` cannot be `256`",
        "from 0 to 255",
    );
    assert_material_error("Dielectric { priority ‹1.5› }", "wants a whole number, found `1.5`", "`priority 1`");
    assert_material_error(
        "Dielectric { roughness ‹1.1› }",
        "`roughness` of `Dielectric` cannot be `1.1`",
        "between 0 and 1",
    );
    assert_material_error("Dielectric { roughness ‹-.1› }", "`roughness`", "between 0 and 1");
    assert_material_error("Dielectric { ‹roughnes› .1 }", "unexpected `roughnes`", "did you mean `roughness`?");
    for index in ["0", "-1.5", "9e-4", "1e4"] {
        assert_material_error(
            &format!("Dielectric {{ indexOfRefraction ‹{index}› }}"),
            "`indexOfRefraction`",
            "between 0.001 and 1000",
        );
    }
}

#[test]
fn conductors_are_named_or_given_by_their_index() {
    let kinds = parse_material_kinds(
        "Conductor { metal gold } Conductor { k 3 4 0 roughness 1 eta .1 .2 .3 multipleScattering no }",
    );
    assert_eq!(
        kinds[0],
        MaterialKindDescription::Conductor(ConductorDescription {
            metal: MetalDescription::Named(name_with_empty_span("gold")),
            roughness: 0.0.into(),
            has_multiple_scattering: true
        })
    );
    let metal = MetalDescription::Index { eta: DVec3::new(0.1, 0.2, 0.3), k: DVec3::new(3.0, 4.0, 0.0) };
    assert_eq!(
        kinds[1],
        MaterialKindDescription::Conductor(ConductorDescription {
            metal,
            roughness: 1.0.into(),
            has_multiple_scattering: false
        })
    );
    assert_material_error("‹Conductor› { }", "has no `metal` or `eta` or `reflectance`", "add `metal` or `eta`");
    assert_material_error("‹Conductor› { eta 1 1 1 }", "`Conductor` has no `k`", "add `k`");
    assert_material_error("‹Conductor› { k 1 1 1 }", "`Conductor` has no `eta`", "add `eta`");
    assert_material_error("Conductor { eta 1 1 1 ‹metal› gold k 1 1 1 }", "both `eta` and `metal`", "keep one of");
    assert_material_error("Conductor { metal gold ‹k› 1 1 1 }", "both `metal` and `k`", "keep one of");
    assert_material_error(
        "Conductor { eta ‹1 0 1› k 1 1 1 }",
        "`eta` of `Conductor` cannot be `1 0 1`",
        "0.001 and 1000 in each",
    );
    assert_material_error("Conductor { eta 1 1 1 k ‹1 1 -1› }", "`k` of `Conductor`", "between 0 and 1000 in each");
    assert_material_error("Conductor { eta 1 1 1 k ‹1e4 0 0› }", "`k` of `Conductor`", "between 0 and 1000 in each");
    assert_material_error("Conductor { metal gold roughness ‹2› }", "`roughness` of `Conductor`", "between 0 and 1");
}

#[test]
fn thin_panes_read_their_fields() {
    let kinds = parse_material_kinds("Thin { } Thin { transmittance .5 1 .25 indexOfRefraction 1.3 }");
    assert_eq!(
        kinds[0],
        MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.5, transmittance: DVec3::ONE.into() })
    );
    assert_eq!(
        kinds[1],
        MaterialKindDescription::Thin(ThinDielectricDescription {
            eta: 1.3,
            transmittance: DVec3::new(0.5, 1.0, 0.25).into()
        })
    );
    assert_material_error("Thin { transmittance ‹1 0 1› }", "`transmittance` of `Thin`", "above 0 and at most at 1");
    assert_material_error("Thin { transmittance ‹1 1 1.1› }", "`transmittance` of `Thin`", "above 0 and at most at 1");
    assert_material_error("Thin { indexOfRefraction ‹0› }", "`indexOfRefraction` of `Thin`", "between 0.001 and 1000");
}

#[test]
fn mixes_refer_to_earlier_materials() {
    let parts = "Mirror a { } Diffuse \"b c\" { reflectance 1 1 1 }";
    let kinds = parse_material_kinds(&format!(
        "{parts} Mix m {{ first a second \"b c\" amount .3 }} Mix {{ amount 1 second m first m }}"
    ));
    assert_eq!(
        kinds[2],
        MaterialKindDescription::Mix(MixDescription {
            first: name_with_empty_span("a"),
            second: name_with_empty_span("b c"),
            second_probability: 0.3.into()
        })
    );
    assert_eq!(
        kinds[3],
        MaterialKindDescription::Mix(MixDescription {
            first: name_with_empty_span("m"),
            second: name_with_empty_span("m"),
            second_probability: 1.0.into()
        })
    );
    let mix = |fields: &str| format!("{parts} Mix glaze {{ {fields} }} Mirror later {{ }}");
    assert_material_error(&mix("first ‹later› second a amount 0"), "no material is called `later`", "stand before it");
    assert_material_error(&mix("first a second ‹B_C› amount 0"), "no material is called `B_C`", "did you mean `b c`?");
    assert_material_error(
        &mix("first a second ‹glaze› amount 0"),
        "`glaze` is a part of itself",
        "before it as `second`",
    );
    assert_material_error(
        &mix("first a second a amount ‹1.5›"),
        "`amount` of `Mix` cannot be `1.5`",
        "between 0 and 1",
    );
    assert_material_error(&mix("first a second a amount ‹-1›"), "`amount` of `Mix`", "between 0 and 1");
    for missing in ["first", "second", "amount"] {
        let given = ["first a", "second a", "amount 0"].into_iter().filter(|f| !f.starts_with(missing));
        let fields = given.collect::<Vec<_>>().join(" ");
        let help = format!("add `{missing}` to it");
        assert_material_error(&format!("{parts} ‹Mix› {{ {fields} }}"), &format!("`Mix` has no `{missing}`"), &help);
    }
    // References to replaced materials are errors.
    let body = "Materials { Mirror a { } Dielectric g { } } Materials { Mix { first ‹a› second g amount 0 } }";
    assert_first_error(body, "no material is called `a`", "stand before it");
}

#[test]
fn mixes_nest_up_to_a_depth() {
    let mix = |i: usize, part: &str| format!("Mix m{i} {{ first m{} second {part} amount .5 }} ", i - 1);
    let deepest: String = (1..=8).map(|i| mix(i, "m0")).collect();
    assert_eq!(parse_material_kinds(&format!("Mirror m0 {{ }} {deepest}")).len(), 9);
    assert_material_error(
        &format!("Mirror m0 {{ }} {deepest} Mix {{ first m0 second ‹m8› amount 0 }}"),
        "more than 8 deep",
        "fewer",
    );
}

#[test]
fn a_mix_has_at_most_one_dielectric() {
    let bodies = "Dielectric g { } Dielectric w { } Mirror a { } Mix ga { first g second a amount .5 }";
    parse_material_kinds(&format!(
        "{bodies} Mix {{ first ga second g amount .5 }} Mix {{ first a second w amount .5 }}"
    ));
    let mix = |second: &str| format!("{bodies} Mix {{ second {second} first ga amount 0 }}");
    assert_material_error(&mix("‹w›"), "cannot be two different Dielectrics", "or with itself");
    assert_material_error(
        &format!("{bodies} Mix x {{ first a second w amount 0 }} Mix {{ first ga second ‹x› amount 0 }}"),
        "two",
        "mix a",
    );
}

#[test]
fn environments_are_constant_or_a_picture() {
    let light = |fields: &str| {
        let d = parse_with_camera(&format!("Lights {{ EnvironmentLight {{ {fields} }} }} Group {{ }}")).unwrap();
        d.lights[0].value.clone()
    };
    let picture = |name: &str, scale: f64, rotate: f64| {
        LightDescription::Environment(EnvironmentRadiance::Picture { path: name_with_empty_span(name), scale, rotate })
    };
    assert_eq!(
        light("radiance 1 2 3"),
        LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::new(1.0, 2.0, 3.0)))
    );
    assert_eq!(light("file sky.exr"), picture("sky.exr", 1.0, 0.0));
    assert_eq!(light("rotate -400 scale 0 file \"my sky.png\""), picture("my sky.png", 0.0, -400.0));
    let rejects_light = |fields: &str, message: &str, help: &str| {
        assert_first_error(&format!("Lights {{ EnvironmentLight {{ {fields} }} }}"), message, help);
    };
    rejects_light("file a.exr ‹radiance› 1 1 1", "both `file` and `radiance`", "keep one of `file` or `radiance`");
    rejects_light("radiance ‹-1 0 0›", "`radiance` of `EnvironmentLight`", "not be negative");
    rejects_light("file a.exr scale ‹-1›", "`scale` of `EnvironmentLight`", "not be negative");
    rejects_light("radiance 1 1 1 scale ‹2›", "`scale` of `EnvironmentLight`", "no effect without `file`");
    rejects_light("rotate ‹90› radiance 1 1 1", "`rotate` of `EnvironmentLight`", "no effect without `file`");
    assert_first_error("Lights { ‹EnvironmentLight› { } }", "has no `file` or `radiance`", "add `file` or `radiance`");
    let one = "EnvironmentLight { radiance 1 1 1 }";
    assert_first_error(
        &format!("Lights {{ {one} ‹EnvironmentLight› {{ }} }}"),
        "`EnvironmentLight` is given twice",
        "keep one",
    );
    parse_with_camera(&format!("Lights {{ {one} }} Lights {{ {one} }} Group {{ }}")).unwrap();
}

#[test]
fn patch_control_points_must_fit_the_degrees() {
    let object = |body: &str| {
        let d = parse_with_camera(&format!("Group {{ {body} }}")).unwrap();
        match d.root.items.into_iter().next() {
            Some(GroupItem::Object(Spanned { value: ObjectDescription::Shape { shape, .. }, .. })) => shape,
            other => panic!("{other:?}"),
        }
    };
    let four = "[ 0 0 0 ] [ 0 0 1 2 ] [ 1 0 0 ] [ 1 0 1 .5 ]";
    match object(&format!("BezierPatch {{ degreeU 1 controls {four} {four} {four} {four} degreeV 1 }}")) {
        ShapeDescription::Patches(BezierPatchesDescription { degree, controls }) => {
            assert_eq!((degree, controls.len()), ([1, 1], 16));
            assert_eq!([controls[0].w, controls[1].w, controls[3].w], [1.0, 2.0, 0.5]);
        }
        other => panic!("{other:?}"),
    }
    let nurbs = |fields: &str| format!("NurbsSurface {{ degreeU 1 degreeV 1 countU 2 countV 2 {fields} }}");
    match object(&nurbs(&format!("knotsU 0 0 1.5 1.5 controls {four}"))) {
        ShapeDescription::Nurbs(NurbsDescription { knots: [u, v], control_counts: count, .. }) => {
            assert_eq!((u, v, count), (vec![0.0, 0.0, 1.5, 1.5], vec![], [2, 2]))
        }
        other => panic!("{other:?}"),
    }
    let rejects_shape =
        |body: &str, message: &str, help: &str| assert_first_error(&format!("Group {{ {body} }}"), message, help);
    rejects_shape(
        &format!("BezierPatch {{ ‹controls› {four} }}"),
        "`controls` of `BezierPatch`",
        "16 points for each patch",
    );
    rejects_shape("BezierPatch { ‹controls› }", "`controls` of `BezierPatch`", "16 points for each patch");
    rejects_shape("‹BezierPatch› { }", "`BezierPatch` has no `controls`", "add `controls`");
    rejects_shape("BezierPatch { degreeU ‹25› }", "`degreeU` of `BezierPatch` cannot be `25`", "from 1 to 24");
    rejects_shape("BezierPatch { degreeV ‹0› }", "`degreeV`", "from 1 to 24");
    rejects_shape(
        "BezierPatch { controls [ 0 0 0 ‹0› ] }",
        "the weight of a point of `controls` cannot be `0`",
        "above 0",
    );
    rejects_shape("BezierPatch { controls [ 0 0 0 ‹-1› ] }", "the weight", "above 0");
    rejects_shape(
        "NurbsSurface { countU ‹3› countV 4 }",
        "`countU` of `NurbsSurface` cannot be `3`",
        "above the degree",
    );
    rejects_shape(&nurbs("knotsU ‹0 1 2› controls"), "`knotsU`", "count + degree + 1 = 4 numbers, and holds 3");
    rejects_shape(&nurbs("knotsV ‹0 1 .5 2› controls"), "`knotsV`", "must not decrease");
    rejects_shape(&nurbs("‹controls› [ 0 0 0 ]"), "`controls`", "countU · countV = 4 points, and holds 1");
    rejects_shape("‹NurbsSurface› { countU 4 }", "has no `countV`", "add `countV`");
    rejects_shape(
        "NurbsSurface { countU ‹4294967295› countV 4294967295 degreeU 24 ‹controls› }"
            .replace("‹4294967295›", "4294967295")
            .as_str(),
        "`controls`",
        "and holds 0",
    );
}

#[test]
fn some_fields_at_their_default_are_not_written() {
    let written = |conductor: &str, cone: &str| {
        let materials = format!("Materials {{ Conductor {{ metal gold {conductor} }} }}");
        let group = format!("Group {{ Cone {{ bottom 0 0 0 top 0 1 0 radius 1 {cone} }} }}");
        parse_with_camera(&format!("{materials} {group}")).unwrap().to_string()
    };
    let default = written("multipleScattering yes", "topRadius 0 caps yes");
    let changed = written("multipleScattering no", "topRadius 0.5 caps no");
    for field in ["multipleScattering no", "topRadius 0.5", "caps no"] {
        let keyword = field.split(' ').next().unwrap();
        assert!(!default.contains(keyword), "{default}");
        assert!(changed.contains(field), "{changed}");
    }
}

#[test]
fn every_textured_field_names_its_texture() {
    let textures = "Textures { Checker a { } Checker b { } Checker c { } }";
    let names = |material: &str| -> Vec<String> {
        let scene = parse_with_camera(&format!("{textures} Materials {{ {material} }} Group {{ }}")).unwrap();
        scene.materials[0].texture_names().into_iter().map(|name| name.value.clone()).collect()
    };
    assert_eq!(names("Phong { diffuseColor a specularColor b texture c }"), ["a", "b", "c"]);
    assert_eq!(names("Diffuse { reflectance a bump b bumpHeight 1 emission c }"), ["a", "b", "c"]);
    assert_eq!(names("Mirror { reflectance b }"), ["b"]);
    assert_eq!(names("Dielectric { roughness a }"), ["a"]);
    assert_eq!(names("Conductor { metal gold roughness a }"), ["a"]);
    assert_eq!(names("Conductor { reflectance b roughness a }"), ["b", "a"]);
    assert_eq!(names("DiffuseTransmission { reflectance a transmittance b }"), ["a", "b"]);
    assert_eq!(
        names("Principled { clearcoat b baseColor a metallic b roughness c transmission a }"),
        ["a", "b", "c", "a", "b"]
    );
    assert_eq!(names("Thin { transmittance b }"), ["b"]);
    assert_eq!(names("CoatedDiffuse { roughness a reflectance b }"), ["b", "a"]);
    let mix = "Textures { Checker a { } } Materials { Mirror m { } Mix { first m second m amount a } } Group { }";
    let mix = &parse_with_camera(mix).unwrap().materials[1];
    assert_eq!(mix.texture_names().into_iter().map(|name| name.as_str()).collect::<Vec<_>>(), ["a"]);
}
