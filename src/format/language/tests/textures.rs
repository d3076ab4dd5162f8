//! Tests of textures and textured fields.

use super::*;
use crate::format::description::{
    ConductorDescription, DiffuseDescription, EmissionDescription, NormalPerturbationDescription, PhongDescription,
    PictureEncoding, SolidPatternDescription, TexcoordTransformDescription, TextureKindDescription, TexturedValue,
    TriangleDescription, WrapMode,
};
use glam::DVec2;

const TILES: &str = "Textures { Checker tiles { } }";

#[test]
fn textures_read_all_their_fields() {
    let text = "Textures { numTextures 3
        Image \"a b\" { file dir/a.png encoding linear wrap mirror scale 2 -3 rotate 90 offset .5 1 }
        Checker c { color0 1 2 3 }
        Marble m { color1 .5 .5 .5 octaves 16 frequency 2.5 amplitude 0 Transform { Scale 2 2 2 YRotate 30 } } }
        Group { }";
    let d = parse_with_camera(text).unwrap();
    let [a, c, m] = &d.textures[..] else { panic!("{:?}", d.textures) };
    let coordinates = TexcoordTransformDescription {
        scale: DVec2::new(2.0, -3.0),
        rotation_degrees: 90.0,
        offset: DVec2::new(0.5, 1.0),
    };
    let path = name_with_empty_span("dir/a.png");
    let kind = TextureKindDescription::Image {
        path,
        encoding: PictureEncoding::Linear,
        wrap: WrapMode::Mirror,
        uv_transform: coordinates,
    };
    assert_eq!((a.name.as_str(), &a.kind), ("a b", &kind));
    let colors = [DVec3::new(1.0, 2.0, 3.0), DVec3::ONE];
    assert_eq!(
        c.kind,
        TextureKindDescription::Checker { colors, uv_transform: TexcoordTransformDescription::default() }
    );
    match &m.kind {
        TextureKindDescription::Solid { pattern, colors, octaves, frequency, amplitude, steps } => {
            assert_eq!((*pattern, *octaves, *frequency, *amplitude), (SolidPatternDescription::Marble, 16, 2.5, 0.0));
            assert_eq!((colors[0], steps.len()), (DVec3::ZERO, 2));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn texture_names_replace_numbers() {
    let text = format!(
        "{TILES} Materials {{
            Diffuse {{ reflectance tiles emission \"tiles\" emissionScale 3 bump lumps.png bumpHeight -.5 }}
            Phong {{ texture wood.png normalMap tiles }}
            Conductor {{ metal gold roughness tiles }}
            Diffuse {{ reflectance 1 1 1 emission 1 2 3 }} }} Group {{ }}"
    );
    let d = parse_with_camera(&text).unwrap();
    let [a, b, c, e] = &d.materials[..] else { panic!("{:?}", d.materials) };
    assert_eq!(
        a.kind,
        MaterialKindDescription::Diffuse(DiffuseDescription {
            reflectance: TexturedValue::Texture(name_with_empty_span("tiles"))
        })
    );
    assert_eq!(a.emission, Some(EmissionDescription::Texture { name: name_with_empty_span("tiles"), scale: 3.0 }));
    assert_eq!(
        a.normal_perturbation,
        Some(NormalPerturbationDescription::Bump { texture: name_with_empty_span("lumps.png"), height: -0.5 })
    );
    assert_eq!(b.normal_perturbation, Some(NormalPerturbationDescription::NormalMap(name_with_empty_span("tiles"))));
    match (&b.kind, &c.kind) {
        (
            MaterialKindDescription::Phong(PhongDescription { texture, .. }),
            MaterialKindDescription::Conductor(ConductorDescription { roughness, .. }),
        ) => {
            assert_eq!(
                (texture, roughness),
                (&Some(name_with_empty_span("wood.png")), &TexturedValue::Texture(name_with_empty_span("tiles")))
            );
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(e.emission, Some(EmissionDescription::Constant(DVec3::new(1.0, 2.0, 3.0))));
    let uv = "uv0 0 1 uv1 1 1 uv2 .5 0";
    let triangle = format!("Group {{ Triangle {{ vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 {uv} }} }}");
    match &parse_with_camera(&triangle).unwrap().root.items[0] {
        GroupItem::Object(object) => match &object.value {
            ObjectDescription::Shape {
                shape: ShapeDescription::Triangle(TriangleDescription { texcoords: Some(uv), .. }),
                ..
            } => {
                assert_eq!(**uv, [DVec2::Y, DVec2::ONE, DVec2::new(0.5, 0.0)]);
            }
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn texture_errors_have_position_and_remedy() {
    assert_first_error("Textures { ‹Checker› { } }", "this `Checker` has no name", "`Checker name { … }`");
    assert_first_error("Textures { Checker a { } Noise ‹a› { } }", "two textures are called `a`", "another name");
    assert_first_error("Textures { ‹Cheker› a { } }", "unexpected `Cheker` in `Textures`", "did you mean `Checker`?");
    assert_first_error("Textures { Checker a { color0 ‹-1 0 0› } }", "`color0` of `Checker`", "not be negative");
    assert_first_error("Textures { Checker a { scale ‹1 0› } }", "`scale` of `Checker`", "must not be 0");
    assert_first_error("Textures { ‹Image› a { } }", "`Image` has no `file`", "add `file`");
    assert_first_error(
        "Textures { Image a { file b.png wrap ‹tile› } }",
        "`wrap` of `Image` cannot be `tile`",
        "`mirror`",
    );
    assert_first_error("Textures { Image a { file b.png encoding ‹gamma› } }", "`encoding`", "`srgb` or `linear`");
    assert_first_error("Textures { Noise a { octaves ‹0› } }", "`octaves` of `Noise`", "from 1 to 16");
    assert_first_error("Textures { Wood a { frequency ‹0› } }", "`frequency` of `Wood`", "above 0");
    assert_first_error("Textures { Wood a { amplitude ‹-1› } }", "`amplitude` of `Wood`", "not be negative");
    assert_first_error("Textures { Wood a { Transform { ‹Sphere› { } } } }", "unexpected `Sphere`", "may hold Scale");
    assert_first_error("Materials { Mirror { } } ‹Textures› { }", "behind the `Materials`", "ahead of the Materials");
    let refuse = |body: &str, message: &str, help: &str| assert_first_error(&format!("{TILES} {body}"), message, help);
    refuse("Materials { Diffuse { reflectance ‹tile› } }", "no texture is called `tile`", "did you mean `tiles`?");
    refuse("Materials { Diffuse { reflectance ‹wood› } }", "no texture is called `wood`", "`Textures {");
    refuse("Materials { Diffuse { reflectance ‹nan› 1 1 } }", "not a finite number", "finite");
    refuse("Materials { Mirror { emissionScale ‹2› } }", "`emissionScale` of `Mirror`", "without a texture");
    refuse("Materials { Mirror { emission tiles emissionScale ‹-2› } }", "`emissionScale`", "not be negative");
    refuse("Materials { Mirror { bumpHeight ‹2› } }", "`bumpHeight` of `Mirror`", "without `bump`");
    refuse("Materials { ‹Mirror› { bump tiles } }", "`Mirror` has no `bumpHeight`", "add `bumpHeight`");
    refuse("Materials { Mirror { bump a ‹normalMap› b bumpHeight 1 } }", "both `bump` and `normalMap`", "keep one");
    let mix = "Mirror a { } Mix { first a second a amount tiles ‹bump› tiles }";
    refuse(&format!("Materials {{ {mix} }}"), "unexpected `bump` in `Mix`", "may hold");
    let corners = "vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0";
    refuse(&format!("Group {{ ‹Triangle› {{ {corners} uv1 0 0 }} }}"), "has no `uv0`", "add `uv0`");
}
