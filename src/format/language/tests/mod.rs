mod errors;
mod media;
mod refraction;
mod surfaces;
mod textures;

use super::*;
use crate::format::MAX_NESTING_DEPTH;
use crate::format::description::{
    DirectionOrTarget, GroupItem, LightDescription, MaterialKindDescription, MeshDescription, MeshOptions,
    MirrorDescription, ObjectDescription, PhongDescription, PointLightStrength, ProjectionDescription,
    ShapeDescription, SpotLightDescription,
};

const CAMERA: &str = "PerspectiveCamera { center 0 0 10 direction 0 0 -1 up 0 1 0 angle 30 width 200 height 200 }";

/// Parses a scene text that has `CAMERA` in line 1 and `body` from line 2 on.
fn parse_with_camera(body: &str) -> Result<SceneDescription, SceneError> {
    parse("scene.txt", &format!("{CAMERA}\n{body}"))
}

/// Asserts that `result` is an error at this line and column, and that it marks `text`.
///
/// Also asserts that its message contains `message`, and its remedy contains `help`.
fn assert_error(
    result: Result<SceneDescription, SceneError>,
    (line, column): (usize, usize),
    text: &str,
    message: &str,
    help: &str,
) {
    let error = result.expect_err(message);
    assert_eq!((error.line(), error.column(), error.offending_text()), (line, column, text), "{error}");
    assert!(error.message().contains(message), "`{message}` is not in `{}`", error.message());
    assert!(error.remedy().contains(help), "`{help}` is not in `{}`", error.remedy());
}

/// Asserts that the first error of `body` marks the text between `‹` and `›`.
///
/// Also asserts that its message contains `message`, and its remedy contains `help`.
#[track_caller]
fn assert_first_error(body: &str, message: &str, help: &str) {
    let (before, rest) = body.split_once('‹').unwrap();
    let (text, after) = rest.split_once('›').unwrap();
    let line = 2 + before.matches('\n').count();
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    assert_error(parse_with_camera(&format!("{before}{text}{after}")), (line, column), text, message, help);
}

fn name_with_empty_span(name: &str) -> Spanned<String> {
    Spanned::new(name.to_owned(), Span::default())
}

/// Parses `CAMERA` followed by `body`. Returns the first object of the root group.
fn first_object(body: &str) -> ObjectDescription {
    let d = parse_with_camera(body).unwrap();
    let object = d.root.items.into_iter().find_map(|item| match item {
        GroupItem::Object(object) => Some(object.value),
        _ => None,
    });
    object.unwrap()
}

#[test]
fn numbers_need_no_white_space_after_them() {
    let text = "PerspectiveCamera{center 0 0 10direction 0 0-1up 0 1 0angle 20width 200height 100}Group{}";
    let camera = parse("a", text).unwrap().camera;
    assert_eq!(camera.projection, ProjectionDescription::Perspective { vertical_fov_degrees: 20.0, lens: None });
    assert_eq!((camera.width, camera.height), (200, 100));
    assert_eq!(camera.aim, DirectionOrTarget::Direction(DVec3::NEG_Z));
}

#[test]
fn values_beyond_single_precision_are_refused() {
    let largest = "below 3.4e38";
    for (before, value) in [
        ("Materials { Phong { diffuseColor", "1 1e39 1"),
        ("Materials { Phong { specularColor", "1 1 1e300"),
        ("Materials { Phong { shininess", "1e39"),
        ("Materials { Phong { emission", "1e39 0 0"),
        ("Materials { Phong { bump a bumpHeight", "-1e39"),
        ("Group { Sphere { center 0 0 0 radius", "1e39"),
        ("Group { Sphere { center 0 0 0 radius 1 emission", "0 0 1e39"),
        ("Lights { PointLight { position 0 0 0 power", "1e39 0 0"),
        ("Lights { EnvironmentLight { file a scale", "1e39"),
        ("Background { color", "1e39 0 0"),
    ] {
        let textures = if before.contains("bump") { "Textures { Checker a { } } " } else { "" };
        let name = before.rsplit(' ').next().unwrap();
        assert_first_error(&format!("{textures}{before} ‹{value}› }} }}"), &format!("`{name}` of"), largest);
    }
    assert_first_error("Materials { Dielectric { absorption ‹0 2e12 0› } }", "`absorption` of", "between 0 and 1e12");
    // The absorption coefficient would be ln 2 / 1e-13, which is 7e12.
    assert_first_error(
        "Materials { Dielectric { tint 1 .5 1 tintDistance ‹1e-13› } }",
        "`tintDistance` of",
        "an absorption above 1e12",
    );
    assert!(
        parse_with_camera(
            "Materials { Dielectric { tint 1 .5 1 tintDistance 1e-12 } Phong { shininess 3e38 } } Group { }"
        )
        .is_ok()
    );
}

#[test]
fn absent_fields_take_their_defaults() {
    let text = "\u{feff}\r\n# c\r\nGroup{Sphere{radius 2 center 0 0 0}} // d\nMaterials{Phong{}Mirror m{}}
        PerspectiveCamera{angle 9 lookAt 0 0 0 center 0 0 1}";
    let d = parse("a", text).unwrap();
    assert_eq!((d.camera.up, d.camera.width, d.camera.height), (DVec3::Y, 960, 720));
    assert_eq!(d.background, DVec3::splat(0.5));
    let (diffuse, specular) = (DVec3::ONE, DVec3::ZERO);
    assert_eq!(
        d.materials[0].kind,
        MaterialKindDescription::Phong(PhongDescription {
            diffuse: diffuse.into(),
            specular: specular.into(),
            shininess: 0.0,
            texture: None
        })
    );
    assert_eq!(
        d.materials[1].kind,
        MaterialKindDescription::Mirror(MirrorDescription { reflectance: DVec3::ONE.into() })
    );
    assert_eq!(d.materials[1].name.as_deref(), Some("m"));
    assert_eq!(parse("a", &format!("{CAMERA} Background {{}} Group {{}}")).unwrap().background, DVec3::splat(0.5));
}

#[test]
fn the_last_group_replaces_earlier_ones() {
    let d = parse_with_camera("Group { Sphere { center 0 0 0 radius 1 } } Group { }").unwrap();
    assert!(d.root.items.is_empty());
    let d = parse_with_camera("Lights { PointLight { position 0 0 0 power 1 1 1 } } Lights { } Group { }").unwrap();
    assert!(d.lights.is_empty());
    parse_with_camera("Materials { Mirror a { } } Materials { Mirror a { } } Group { MaterialName a }").unwrap();
    // The second `Materials` and the second `Group` replace the first ones.
    parse_with_camera("Materials { Mirror {} } Group { MaterialIndex 0 } Materials { } Group { }").unwrap();
    assert_first_error(
        "Materials { Mirror {} } Group { MaterialIndex 0 } ‹Materials› { }",
        "replace those that the `Group` before them uses",
        "one block before the Group",
    );
}

#[test]
fn names_may_be_quoted_or_bare() {
    let mesh = |body: &str| match first_object(body) {
        ObjectDescription::Shape { shape: ShapeDescription::Mesh(MeshDescription { path, .. }), .. } => path.value,
        other => panic!("{other:?}"),
    };
    assert_eq!(mesh("Group { TriangleMesh { obj_file mesh/cube.obj } }"), "mesh/cube.obj");
    assert_eq!(mesh("Group{TriangleMesh{obj_file mesh/cube.obj}}"), "mesh/cube.obj");
    assert_eq!(mesh(r#"Group { TriangleMesh { obj_file "my \"mesh\" \\ {.obj" } }"#), r#"my "mesh" \ {.obj"#);
    assert_first_error(
        "Group { TriangleMesh { obj_file ‹}› }",
        "`obj_file` wants a name",
        "write a name after `obj_file`",
    );
    assert_first_error(
        "Group { TriangleMesh { obj_file ‹\"\"› } }",
        "`obj_file` wants a name",
        "in quotes if it holds spaces",
    );
    assert_first_error("Group { TriangleMesh { obj_file ‹\"›a.obj\n\" } }", "does not end on its line", "close it");
    assert_first_error(
        r#"Group { TriangleMesh { obj_file "C:‹\›a.obj" } }"#,
        "a backslash in quotes",
        "`/` between folders",
    );
}

#[test]
fn stated_counts_must_match_the_entries() {
    parse_with_camera("Lights { numLights 0 } Materials { numMaterials 0 } Group { numObjects 0 }").unwrap();
    // Entries that set a material do not count as objects.
    parse_with_camera("Materials { Mirror { } } Group { MaterialIndex 0 numObjects 1 MaterialIndex 0 Group { } }")
        .unwrap();
    assert_first_error(
        "Group { numObjects ‹2›\n Group { } }",
        "`numObjects` is 2, but 1 object follows",
        "write `numObjects 1`",
    );
    assert_first_error(
        "Lights { numLights ‹4000000000› } Group { }",
        "is 4000000000, but 0 lights",
        "write `numLights 0`",
    );
    assert_first_error(
        "Materials { numMaterials ‹1› Mirror { } Mirror { } }",
        "is 1, but 2 materials",
        "leave the count out",
    );
    assert_first_error("Group { numObjects 0 ‹numObjects› 0 }", "given twice in `Group`", "keep one");
    assert_first_error("Group { numObjects ‹-1› }", "lies outside 0 … 4294967295", "whole number");
    assert_first_error("Group { numObjects ‹1.5› Group { } }", "wants a whole number, found `1.5`", "`numObjects 1`");
    assert_first_error("Group { numObjects ‹one› }", "wants a whole number, found `one`", "`numObjects 1`");
}

#[test]
fn numbers_must_be_finite() {
    let sphere = |radius: &str| format!("Group {{ Sphere {{ center 0 0 0 radius ‹{radius}› }} }}");
    assert_first_error(&sphere("nan"), "`nan` is not a finite number", "give `radius` a finite value");
    assert_first_error(&sphere("-Inf"), "`-Inf` is not a finite number", "finite");
    assert_first_error(&sphere("1e999"), "`1e999` is too large", "1.7e308");
    assert_first_error(&sphere("abc"), "`radius` wants a number, found `abc`", "`radius 1`");
    assert_first_error(
        "Group { Sphere { center 0 0 ‹radius› 1 } }",
        "`center` wants 3 numbers, found `radius`",
        "three numbers",
    );
    assert_first_error("Group { Sphere { center 1‹,2,3› radius 1 } }", "found `,2,3`", "not by commas");
    assert_first_error("Group { Transform { Matrix4f { 1 0 ‹}› } }", "wants 16 numbers, found `}`", "write 16 numbers");
}

#[test]
fn impossible_shapes_are_refused() {
    for radius in ["0", "-1"] {
        let body = format!("Group {{ Sphere {{ center 0 0 0 radius ‹{radius}› }} }}");
        assert_first_error(&body, &format!("`radius` of `Sphere` cannot be `{radius}`"), "must be above 0");
    }
    assert_first_error("Group { Disc { center 0 0 0 normal 0 0 1 radius ‹0› } }", "`radius` of `Disc`", "above 0");
    assert_first_error(
        "Group { Plane { normal ‹0 0 0› offset 1 } }",
        "`normal` of `Plane` cannot be `0 0 0`",
        "length above 0",
    );
    assert_first_error("Group { Plane { normal ‹1e200 0 0› offset 1 } }", "cannot be `1e200 0 0`", "below 1e154");
    assert_first_error(
        "Group { Rectangle { corner 0 0 0 edge0 1 2 3 edge1 ‹.1 .2 .3› } }",
        "`edge1` of `Rectangle`",
        "the area would be 0",
    );
    assert_first_error("Group { Rectangle { corner 0 0 0 edge0 ‹0 0 0› edge1 1 0 0 } }", "`edge0`", "length above 0");
    // A triangle without area is no error, because meshes contain such triangles too.
    parse_with_camera("Group { Triangle { vertex0 0 0 0 vertex1 0 0 0 vertex2 0 0 0 } }").unwrap();
    let three = "vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0";
    assert_first_error(
        &format!("Group {{ ‹Triangle› {{ {three} normal1 0 0 1 }} }}"),
        "has no `normal0`",
        "add `normal0`",
    );
    assert_first_error(
        "Group { BsplineCurve { ‹controls› [0 0 0] } }",
        "`controls` of `BsplineCurve`",
        "at least 4 points",
    );
    assert_first_error(
        "Group { RevSurface { profile BezierCurve { ‹controls› } } }",
        "`controls`",
        "at least 2 points",
    );
    assert_first_error(
        "Group { RevSurface { profile ‹Sphere› } }",
        "`profile` wants a curve",
        "`profile BezierCurve { … }`",
    );
}

#[test]
fn impossible_colors_are_refused() {
    assert_first_error("Background { color ‹0 -1 0› }", "cannot be `0 -1 0`", "negative");
    assert_first_error(
        "Lights { PointLight { position 0 0 0 power ‹-1 0 0› } }",
        "`power` of `PointLight`",
        "not be negative",
    );
    assert_first_error("Group { Sphere { center 0 0 0 radius 1 emission ‹-1 0 0› } }", "`emission`", "not be negative");
    assert_first_error("Materials { Phong { diffuseColor ‹-1 0 0› } }", "`diffuseColor` of `Phong`", "not be negative");
    assert_first_error(
        "Materials { Phong { shininess ‹-1› } }",
        "`shininess` of `Phong` cannot be `-1`",
        "not be negative",
    );
    assert_first_error("Materials { Diffuse { reflectance ‹1 1.1 1› } }", "cannot be `1 1.1 1`", "between 0 and 1");
    assert_first_error(
        "Materials { Dielectric { tint ‹1 0 1› } }",
        "`tint` of `Dielectric`",
        "above 0 and at most at 1",
    );
    assert_first_error("Materials { Dielectric { absorption ‹-1 0 1› } }", "`absorption`", "between 0 and 1e12");
    assert_first_error("Materials { Dielectric { tint 1 1 1 tintDistance ‹0› } }", "`tintDistance`", "above 0");
    assert_first_error("Materials { Dielectric { tintDistance ‹1› } }", "`tintDistance`", "no effect without `tint`");
}

#[test]
fn impossible_cameras_are_refused() {
    let camera = |fields: &str| {
        let (before, rest) = fields.split_once('‹').unwrap();
        let (text, after) = rest.split_once('›').unwrap();
        let source = format!("PerspectiveCamera {{\n{before}{text}{after}\n}} Group {{ }}");
        (parse("scene.txt", &source), (2, before.chars().count() + 1), text.to_owned())
    };
    for (fields, message, help) in [
        ("center 0 0 0 direction 0 0 1 angle ‹180›", "`angle` of `PerspectiveCamera` cannot be `180`", "0 and 180"),
        ("center 0 0 0 direction 0 0 1 angle ‹0›", "cannot be `0`", "0 and 180"),
        ("center 0 0 0 direction 0 0 1 angle 9 width ‹0›", "cannot be `0`", "from 1 to 65536"),
        ("center 0 0 0 direction 0 0 1 angle 9 height ‹65537›", "cannot be `65537`", "from 1 to 65536"),
        ("center 0 0 0 direction 0 0 1 angle 9 height ‹99999999999›", "`height` lies outside", "whole number"),
        ("center 0 0 0 direction ‹0 0 0› angle 9", "`direction` of", "length above 0"),
        ("center 0 0 0 direction 0 0 1 up ‹0 0 0› angle 9", "`up` of", "length above 0"),
        ("center 0 0 0 direction 0 0 1 up ‹0 0 -3› angle 9", "parallel", "points elsewhere"),
        ("center 0 0 0 direction ‹0 1 0› angle 9", "parallel", "points elsewhere"),
        ("center 1 2 3 lookAt ‹1 2 3› angle 9", "`lookAt` of", "at some distance from `center`"),
        ("center 1 2 3 lookAt 0 0 0 ‹direction› 0 0 1 angle 9", "has both `lookAt` and `direction`", "keep one of"),
        ("center 1 2 3 ‹center› 1 2 3", "`center` is given twice", "keep one"),
    ] {
        let (result, place, text) = camera(fields);
        assert_error(result, place, &text, message, help);
    }
    let result = parse("scene.txt", "Group { }\n PerspectiveCamera { center 0 0 0 angle 9 }");
    assert_error(result, (2, 2), "PerspectiveCamera", "has no `direction` or `lookAt`", "add `direction` or `lookAt`");
    let result = parse("scene.txt", "PerspectiveCamera { center 0 0 0 direction 0 0 1 }");
    assert_error(result, (1, 1), "PerspectiveCamera", "has no `angle`", "add `angle` to it");
}

#[test]
fn lights_need_exactly_one_strength() {
    let body = "Lights { SpotLight { position 0 0 0 lookAt 0 0 1 angle 60 penumbra 9 intensity 1 2 3 } } Group { }";
    let d = parse_with_camera(body).unwrap();
    assert_eq!(
        d.lights[0].value,
        LightDescription::Spot(SpotLightDescription {
            position: DVec3::ZERO,
            aim: DirectionOrTarget::Target(DVec3::Z),
            full_cone_angle_degrees: 60.0,
            penumbra_degrees: 9.0,
            strength: PointLightStrength::Intensity(DVec3::new(1.0, 2.0, 3.0)),
        })
    );
    let spot = |fields: &str| format!("Lights {{ SpotLight {{ position 0 0 0 {fields} }} }}");
    assert_first_error(
        &spot("direction 0 0 1 angle ‹0› power 1 1 1"),
        "cannot be `0`",
        "above 0 and at most at 360 degrees",
    );
    assert_first_error(
        &spot("direction 0 0 1 angle 60 penumbra ‹31› power 1 1 1"),
        "cannot be `31`",
        "half of the cone's angle",
    );
    assert_first_error(&spot("lookAt ‹0 0 0› angle 60 power 1 1 1"), "`lookAt`", "some distance from `position`");
    assert_first_error(
        "Lights { ‹PointLight› { position 0 0 0 } }",
        "has no `color` or `intensity` or `power`",
        "add `color` or `intensity` or `power`",
    );
    assert_first_error(
        "Lights { PointLight { position 0 0 0 color 1 1 1 ‹power› 1 1 1 } }",
        "both `color` and `power`",
        "keep one",
    );
    assert_first_error("Lights { ‹DirectionalLight› { direction 0 0 1 } }", "has no `color` or `irradiance`", "add");
    assert_first_error("Lights { ‹SphereLight› { center 0 0 1 radius 1 } }", "has no `radiance` or `power`", "add");
    assert_first_error("Lights { SphereLight { center 0 0 1 radius ‹0› power 1 1 1 } }", "`radius`", "above 0");
    assert_first_error(
        "Materials { Dielectric { tint 1 1 1 ‹absorption› 1 1 1 } }",
        "both `tint` and `absorption`",
        "keep one",
    );
}

#[test]
fn singular_transforms_are_refused() {
    let transform = |maps: &str| format!("Group {{ Transform {{ {maps} Sphere {{ center 0 0 0 radius 1 }} }} }}");
    assert_first_error(&transform("Scale ‹1 0 1›"), "`Scale` flattens its object", "scales must not be 0");
    assert_first_error(&transform("UniformScale ‹0›"), "`UniformScale` flattens", "scales must not be 0");
    assert_first_error(
        &transform("Matrix { ‹1 0 0 0 0 1 0 0 1 1 0 0 0 0 0 1› }"),
        "`Matrix` flattens",
        "columns of a matrix",
    );
    assert_first_error(
        &transform("Matrix4f { ‹1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1› }"),
        "fourth row of `Matrix4f`",
        "the last is 1",
    );
    assert_first_error(&transform("Rotate { ‹0 0 0 90› }"), "the axis of `Rotate`", "axis and degrees");
    assert_first_error(
        &transform("Rotate { 0 0 1 90 ‹5› }"),
        "expected `}` in `Rotate`, found `5`",
        "put `}` before it",
    );
    let thin = "Scale 1e-15 1 1";
    assert_first_error(
        &format!("Group {{ ‹Transform› {{ {thin} ZRotate 45 {thin} Group {{ }} }} }}"),
        "this `Transform` flattens",
        "scales must not be 0",
    );
    assert_first_error("Group { ‹Transform› { Scale 1 1 1 } }", "holds no object", "put one after its maps");
    assert_first_error(
        "Group { Transform { Group { } ‹Group› { } } }",
        "unexpected `Group` after the object",
        "several objects into a Group",
    );
    assert_first_error(
        "Group { Transform { Group { } ‹Scale› 1 1 1 } }",
        "unexpected `Scale` after the object",
        "maps stand before",
    );
}

#[test]
fn unknown_materials_are_refused() {
    let two = "Materials { Diffuse red { reflectance 1 0 0 } Mirror \"blue sky\" { } }";
    parse_with_camera(&format!("{two} Group {{ MaterialName red MaterialName \"blue sky\" MaterialIndex 1 }}"))
        .unwrap();
    assert_first_error(
        &format!("{two} Group {{ MaterialIndex ‹2› }}"),
        "there is no material 2",
        "numbered from 0 to 1",
    );
    assert_first_error(
        &format!("{two} Group {{ MaterialName ‹rde› }}"),
        "no material is called `rde`",
        "did you mean `red`?",
    );
    assert_first_error(
        &format!("{two} Group {{ MaterialName ‹green› }}"),
        "no material is called",
        "ahead of the Group",
    );
    assert_first_error(
        "Materials { Mirror { } } Group { MaterialIndex ‹1› }",
        "no material 1",
        "the one material is number 0",
    );
    assert_first_error(
        "Group { MaterialIndex ‹0› } Materials { Mirror { } }",
        "no material 0",
        "put `Materials { … }` ahead",
    );
    assert_first_error("Materials { Mirror a { } Mirror ‹a› { } }", "two materials are called `a`", "another name");
    assert_first_error("Materials { Mirror ‹1a› { } }", "`1a` is not a plain name", "put it in quotes");
    assert_first_error("Materials { Mirror ‹\"\"› { } }", "name is empty", "leave the quotes out");
}

#[test]
fn mesh_options_are_read() {
    let options = |fields: &str| match first_object(&format!("Group {{ TriangleMesh {{ {fields} }} }}")) {
        ObjectDescription::Shape { shape: ShapeDescription::Mesh(MeshDescription { path, options }), .. } => {
            assert_eq!(path.value, "a.obj");
            options
        }
        other => panic!("{other:?}"),
    };
    let default = MeshOptions { uses_file_materials: false, ignores_normals: false, max_smoothing_angle: None };
    assert_eq!((options("obj_file a.obj"), MeshOptions::default()), (default, default));
    assert_eq!(options("file a.obj materials scene normals file"), default);
    let all = MeshOptions { uses_file_materials: true, ignores_normals: true, max_smoothing_angle: Some(40.0) };
    assert_eq!(options("smoothAngle 40 normals none materials file file a.obj"), all);
    assert_first_error("Group { TriangleMesh { obj_file a ‹file› b } }", "both `obj_file` and `file`", "keep one of");
    assert_first_error("Group { ‹TriangleMesh› { } }", "no `obj_file` or `file`", "add");
    assert_first_error("Group { TriangleMesh { file a materials ‹mine› } }", "cannot be `mine`", "`scene` or `file`");
    assert_first_error("Group { TriangleMesh { file a normals ‹smooth› } }", "cannot be `smooth`", "`file` or `none`");
    assert_first_error("Group { TriangleMesh { file a smoothAngle ‹181› } }", "cannot be `181`", "between 0 and 180");
    assert_first_error("Group { TriangleMesh { file a smoothAngle ‹-1› } }", "cannot be `-1`", "between 0 and 180");
}
