//! Tests of the importer of Mitsuba scenes.

mod materials;
mod shapes;
mod versions;

use super::decode;
use crate::format::description::{
    ConductorDescription, DensityDescription, DielectricDescription, DiffuseDescription, DirectionOrTarget,
    DirectionalLightDescription, EmissionDescription, EnvironmentRadiance, GoniometricLightDescription, GroupItem,
    IntensityDistribution, LightDescription, MaterialDescription, MaterialKindDescription, MediumCoefficients,
    MetalDescription, MirrorDescription, MixDescription, NormalPerturbationDescription, ObjectDescription,
    PointLightDescription, PointLightStrength, ProjectionDescription, RefractiveIndexDescription, ShapeDescription,
    SphereDescription, TextureKindDescription, TexturedValue, ThinDielectricDescription,
};
use crate::format::import::{ImportOptions, ImportedScene};
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec2, DVec3};
use std::path::Path;

/// Returns the text of a scene file with the elements `content`.
fn scene_xml(content: &str) -> String {
    format!("<scene version=\"3.0.0\">{content}</scene>")
}

fn import_text(content: &str) -> ImportedScene {
    import_text_in_folder(Path::new("/nowhere"), content)
}

fn import_text_in_folder(folder: &Path, content: &str) -> ImportedScene {
    let result = decode(&folder.join("a.xml"), scene_xml(content).as_bytes(), &ImportOptions::default());
    result.unwrap_or_else(|error| panic!("{error}"))
}

fn import_error(content: &str) -> String {
    import_error_in_folder(Path::new("/nowhere"), content, &ImportOptions::default())
}

fn import_error_in_folder(folder: &Path, content: &str, options: &ImportOptions) -> String {
    decode(&folder.join("a.xml"), scene_xml(content).as_bytes(), options).unwrap_err().to_string()
}

#[track_caller]
fn assert_import_error(content: &str, part: &str) {
    let error = import_error(content);
    assert!(error.contains(part), "{error}");
}

/// Returns the material of the only shape, which is a sphere with `bsdf`.
fn sphere_material(bsdf: &str) -> MaterialDescription {
    let scene = import_text(&format!("<shape type=\"sphere\">{bsdf}</shape>"));
    scene.description.materials.last().unwrap().value.clone()
}

/// Returns all objects with their transforms.
fn placed_objects(scene: &ImportedScene) -> Vec<(DAffine3, ObjectDescription)> {
    let items = scene.description.root.items.iter();
    let object = |item: &GroupItem| match item {
        GroupItem::Object(object) => Some(match &object.value {
            ObjectDescription::Transform { steps, object } => {
                (crate::format::transform_step::TransformStep::composed_matrix(steps), object.value.clone())
            }
            other => (DAffine3::IDENTITY, other.clone()),
        }),
        _ => None,
    };
    items.filter_map(object).collect()
}

fn has_note(scene: &ImportedScene, part: &str) -> bool {
    scene.notes.iter().any(|note| note.message.contains(part))
}

#[test]
fn parameters_references_and_spellings_are_resolved() {
    let scene = import_text(
        r#"<default name="r" value="0.25"/><default name="r" value="9"/><default name="radius" value="2"/>
        <shape type="sphere"><float name="radius" value="$radius"/><ref id="paint"/>
          <transform name="toWorld"><translate x="$r"/></transform></shape>
        <bsdf type="diffuse" id="paint"><rgb name="reflectance" value="$r, .5 1"/></bsdf>
        <alias id="paint" as="other"/>
        <shape type="rectangle"><ref id="other"/></shape>"#,
    );
    let reflectance = DVec3::new(0.25, 0.5, 1.0).into();
    assert_eq!(
        scene.description.materials[0].kind,
        MaterialKindDescription::Diffuse(DiffuseDescription { reflectance })
    );
    assert_eq!(scene.description.materials.len(), 1);
    let (to_world, object) = &placed_objects(&scene)[0];
    assert_eq!(to_world.translation, DVec3::new(0.25, 0.0, 0.0));
    let ObjectDescription::Shape { shape: ShapeDescription::Sphere(SphereDescription { radius, .. }), .. } = object
    else {
        panic!()
    };
    assert_eq!(*radius, 2.0);
}

#[test]
fn files_are_included_once_and_never_in_circles() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    let part = scene_xml(
        r#"<default name="size" value="7"/><shape type="sphere"><float name="radius" value="$size"/></shape>"#,
    );
    std::fs::write(folder.path().join("parts/part.xml"), part).unwrap();
    std::fs::write(folder.path().join("circle.xml"), scene_xml(r#"<include filename="circle.xml"/>"#)).unwrap();
    let scene = import_text_in_folder(folder.path(), r#"<path value="parts"/><include filename="part.xml"/>"#);
    assert_eq!(placed_objects(&scene).len(), 1);
    let error = import_error_in_folder(folder.path(), r#"<include filename="circle.xml"/>"#, &ImportOptions::default());
    assert!(error.contains("includes itself"), "{error}");
    let inner = folder.path().join("parts");
    let error = import_error_in_folder(
        &inner,
        r#"<path value=".."/><include filename="circle.xml"/>"#,
        &ImportOptions::default(),
    );
    assert!(error.contains("outside the folder"), "{error}");
    let trusting = ImportOptions { allows_outside_files: true, ..ImportOptions::default() };
    assert!(
        import_error_in_folder(&inner, r#"<path value=".."/><include filename="circle.xml"/>"#, &trusting)
            .contains("itself")
    );
}

#[test]
fn exponentially_growing_includes_and_parameters_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    // Each file includes the next one ten times.
    for i in 0..15 {
        let text = format!(r#"<include filename="{}.xml"/>"#, i + 1).repeat(10);
        std::fs::write(folder.path().join(format!("{i}.xml")), scene_xml(&text)).unwrap();
    }
    std::fs::write(folder.path().join("15.xml"), scene_xml(&"<shape type=\"sphere\"/>".repeat(10))).unwrap();
    let error = import_error_in_folder(folder.path(), r#"<include filename="0.xml"/>"#, &ImportOptions::default());
    assert!(error.contains("more than 10000 includes"), "{error}");
    let limited = ImportOptions { memory_limit: MemoryLimit::ProcessBytes(0), ..ImportOptions::default() };
    let error = import_error_in_folder(folder.path(), "<shape type=\"sphere\"/>", &limited);
    assert!(error.contains("memory"), "{error}");
    let doubled = |i: usize| format!(r#"<default name="p{}_" value="$p{i}_$p{i}_"/>"#, i + 1);
    let doubling: String = (0..40).map(doubled).collect();
    assert_import_error(&format!(r#"<default name="p0_" value="laugh"/>{doubling}"#), "too long");
}

#[test]
fn damaged_documents_are_errors_with_a_place() {
    assert_import_error("<shape", "XML is damaged");
    assert_import_error(
        "\n\n<shape type=\"sphere\"><float name=\"radius\" value=\"x\"/></shape>",
        "a.xml:3:22: `x` is not a number",
    );
    assert_import_error("<shape type=\"sphere\"><ref id=\"a\"/></shape>", "no object has the id `a`");
    assert_import_error("<string name=\"a\" value=\"$b\"/>", "parameter `$b` has no value");
    assert_import_error("<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/>", "two objects");
    assert_import_error(
        "<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/></shape>",
        "`a.obj` does not exist",
    );
    assert_import_error("<emitter type=\"sunsky\"/>", "`sunsky` is not supported");
    let nested = "<bsdf type=\"twosided\">".repeat(100) + &"</bsdf>".repeat(100);
    assert_import_error(&nested, "nested deeper");
    let circle = r#"<bsdf type="twosided" id="a"><ref id="b"/></bsdf><bsdf type="twosided" id="b"><ref id="a"/></bsdf>
        <shape type="sphere"><ref id="a"/></shape>"#;
    assert_import_error(circle, "contain themselves");
    let group = r#"<shape type="shapegroup" id="g"><shape type="instance"><ref id="g"/></shape></shape>
        <shape type="instance"><ref id="g"/></shape>"#;
    assert_import_error(group, "contain themselves");
    let root = decode(Path::new("a.xml"), b"<svg/>", &ImportOptions::default()).unwrap_err().to_string();
    assert!(root.contains("the root of a Mitsuba scene is `scene`"), "{root}");
}

#[test]
fn fields_of_view_refer_to_their_axis() {
    let camera = |values: &str, size: [u32; 2]| {
        let scene = import_text(&format!(
            r#"<sensor type="perspective">{values}<transform name="to_world">
              <lookat origin="1, 2, 3" target="1, 2, -7" up="0, 1, 0"/></transform>
              <film type="hdrfilm"><integer name="width" value="{}"/><integer name="height" value="{}"/></film></sensor>"#,
            size[0], size[1]
        ));
        scene.description.camera.value
    };
    let angle = |values: &str, size| match camera(values, size).projection {
        ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens: None } => angle,
        other => panic!("{other:?}"),
    };
    let view = camera("<float name=\"fov\" value=\"90\"/>", [200, 100]);
    assert_eq!((view.center, view.up, view.width, view.height), (DVec3::new(1.0, 2.0, 3.0), DVec3::Y, 200, 100));
    assert_eq!(view.aim, DirectionOrTarget::Direction(DVec3::NEG_Z));
    let halved = 2.0 * libm::atan(0.5).to_degrees();
    let fov = |axis: &str| format!("<float name=\"fov\" value=\"90\"/><string name=\"fov_axis\" value=\"{axis}\"/>");
    for (axis, expected) in [("x", halved), ("larger", halved), ("y", 90.0), ("smaller", 90.0)] {
        let found = angle(&fov(axis), [200, 100]);
        assert!((found - expected).abs() < 1e-9, "{axis}: {found} instead of {expected}");
    }
    // Without `fov`, the focal length is 50 mm, on film of 36 × 24 mm. The height is 24 mm.
    let found = angle("", [300, 200]);
    assert!((found - 2.0 * libm::atan(12.0 / 50.0).to_degrees()).abs() < 1e-9, "{found}");
    assert_import_error("<sensor type=\"perspective\"><float name=\"fov\" value=\"180\"/></sensor>", "field of view");
}

#[test]
fn centered_crops_narrow_the_view() {
    let scene = |offset: u32| {
        import_text(&format!(
            r#"<sensor type="perspective"><float name="fov" value="90"/><film type="hdrfilm">
              <integer name="width" value="100"/><integer name="height" value="100"/>
              <integer name="crop_width" value="50"/><integer name="crop_height" value="50"/>
              <integer name="crop_offset_x" value="{offset}"/><integer name="crop_offset_y" value="25"/>
              </film></sensor>"#
        ))
    };
    let (centered, aside) = (scene(25), scene(0));
    let ProjectionDescription::Perspective { vertical_fov_degrees: angle, .. } = centered.description.camera.projection
    else {
        panic!()
    };
    assert!((angle - 2.0 * libm::atan(0.5).to_degrees()).abs() < 1e-9, "{angle}");
    assert_eq!((centered.description.camera.width, aside.description.camera.width), (50, 100));
    assert!(has_note(&aside, "crops") && !has_note(&centered, "crops"));
}

#[test]
fn smooth_and_rough_materials_have_their_parameters() {
    let glass = sphere_material(
        "<bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"diamond\"/><float name=\"extIOR\" value=\"1\"/></bsdf>",
    );
    let MaterialKindDescription::Dielectric(DielectricDescription { refraction, roughness, .. }) = glass.kind else {
        panic!()
    };
    assert_eq!((refraction, roughness), (RefractiveIndexDescription::Constant(2.419), TexturedValue::Constant(0.0)));
    // A dielectric is not nested in itself, so its index is relative to its own surroundings. With
    // equal indices, its surface has no effect.
    let matched = import_text(
        "<shape type=\"sphere\"><bsdf type=\"dielectric\">\
         <float name=\"intIOR\" value=\"1.33\"/><float name=\"extIOR\" value=\"1.33\"/></bsdf></shape>",
    );
    assert!(matched.description.materials.is_empty(), "{:?}", matched.description.materials);
    let pane = sphere_material("<bsdf type=\"thindielectric\"/>").kind;
    assert!(
        matches!(pane, MaterialKindDescription::Thin(ThinDielectricDescription { eta, .. }) if (eta - 1.5046 / 1.000_277).abs() < 1e-12)
    );
    let gold = sphere_material(
        r#"<bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/>
        <string name="distribution" value="ggx"/></bsdf>"#,
    );
    let MaterialKindDescription::Conductor(ConductorDescription {
        metal: MetalDescription::Named(name),
        roughness,
        ..
    }) = gold.kind
    else {
        panic!()
    };
    assert_eq!((&*name.value, roughness), ("gold", TexturedValue::Constant(0.3)));
    let index = sphere_material(
        r#"<bsdf type="conductor"><rgb name="eta" value="1 2 3"/><spectrum name="k" value="4"/></bsdf>"#,
    );
    let MaterialKindDescription::Conductor(ConductorDescription { metal: MetalDescription::Index { eta, k }, .. }) =
        index.kind
    else {
        panic!()
    };
    assert_eq!((eta, k), (DVec3::new(1.0, 2.0, 3.0), DVec3::splat(4.0)));
    let mirror = sphere_material(
        "<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/><rgb name=\"specular_reflectance\" value=\"0.5\"/></bsdf>",
    );
    assert_eq!(
        mirror.kind,
        MaterialKindDescription::Mirror(MirrorDescription { reflectance: DVec3::splat(0.5).into() })
    );
}

#[test]
fn tinted_metals_keep_their_reflectance_at_normal_incidence() {
    let tinted = sphere_material(
        r#"<bsdf type="conductor"><float name="eta" value="2"/><float name="k" value="3"/>
        <rgb name="specular_reflectance" value="0.5"/></bsdf>"#,
    );
    let MaterialKindDescription::Conductor(ConductorDescription {
        metal: MetalDescription::Reflectance(TexturedValue::Constant(found)),
        ..
    }) = tinted.kind
    else {
        panic!()
    };
    // The reflectance is the tint ½ times ((η − 1)² + k²) / ((η + 1)² + k²).
    let expected = DVec3::splat(0.5 * 10.0 / 18.0);
    assert!((found - expected).length() < 1e-12, "{found} instead of {expected}");
}

#[test]
fn wrapper_bsdfs_become_mixes_and_bump_maps() {
    let inner = "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.1\"/></bsdf>";
    let masked =
        sphere_material(&format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/>{inner}</bsdf>"));
    let MaterialKindDescription::Mix(MixDescription { first, second_probability: amount, .. }) = masked.kind else {
        panic!()
    };
    assert_eq!((&*first.value, amount), ("clear", TexturedValue::Constant(0.25)));
    let two = sphere_material(&format!("<bsdf type=\"twosided\">{inner}</bsdf>"));
    assert_eq!(
        two.kind,
        MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: DVec3::splat(0.1).into() })
    );
    let blend = sphere_material(&format!(
        "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.75\"/>{inner}<bsdf type=\"conductor\"/></bsdf>"
    ));
    let MaterialKindDescription::Mix(MixDescription { second_probability: amount, .. }) = blend.kind else { panic!() };
    assert_eq!(amount, TexturedValue::Constant(0.75));
    let bumps = sphere_material(&format!(
        "<bsdf type=\"bumpmap\"><float name=\"scale\" value=\"3\"/><texture type=\"checkerboard\"/>{inner}</bsdf>"
    ));
    assert!(matches!(bumps.normal_perturbation, Some(NormalPerturbationDescription::Bump { height: 3.0, .. })));
}

#[test]
fn unknown_plugins_give_one_note_per_kind() {
    let scene = import_text(
        r#"<shape type="hair"/><shape type="hair"/>
        <shape type="sphere"><boolean name="caustic_caster" value="true"/><bsdf type="velvet"/></shape>"#,
    );
    let notes: Vec<&str> =
        scene.notes.iter().filter(|n| n.concerns_unsupported_content).map(|n| n.message.as_str()).collect();
    assert_eq!(notes.len(), 3, "{notes:?}");
    assert!(has_note(&scene, "shapes of kind `hair` are left out (1×: line 1)"), "{notes:?}");
    assert!(has_note(&scene, "BSDFs of kind `velvet` become diffuse gray"));
    assert!(has_note(&scene, "`caustic_caster` of `sphere` is ignored"));
}

#[test]
fn checkerboard_scales_double_for_caustica() {
    let scene = import_text(
        r#"<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard">
          <rgb name="color0" value="0.1"/><rgb name="color1" value="0.9"/>
          <transform name="to_uv"><scale x="3" y="5"/></transform></texture></bsdf></shape>"#,
    );
    let TextureKindDescription::Checker { colors, uv_transform: coordinates } = &scene.description.textures[0].kind
    else {
        panic!()
    };
    assert_eq!(*colors, [DVec3::splat(0.1), DVec3::splat(0.9)]);
    assert_eq!(
        (coordinates.scale, coordinates.rotation_degrees, coordinates.offset),
        (DVec2::new(6.0, 10.0), 0.0, DVec2::ZERO)
    );
}

#[test]
fn bitmaps_are_decoded_and_upright() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 1, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0, 0, 0, 255]).unwrap();
    std::fs::write(folder.path().join("a.png"), file).unwrap();
    let texture = r#"type="bitmap"><string name="filename" value="a.png"/></texture>"#;
    let scene = import_text_in_folder(
        folder.path(),
        &format!(
            r#"<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" {texture}</bsdf>
              <emitter type="area"><texture name="radiance" {texture}</emitter></shape>"#
        ),
    );
    let [texture, _] = &scene.description.textures[..] else { panic!("{:?}", scene.description.textures) };
    let TextureKindDescription::Image { path, uv_transform: coordinates, .. } = &texture.kind else { panic!() };
    // The top of a picture has v = 0 in Mitsuba and v = 1 in Caustica, so v becomes 1 − v.
    assert_eq!((coordinates.scale, coordinates.offset), (DVec2::new(1.0, -1.0), DVec2::Y));
    assert_eq!(scene.assets.pictures[&path.value].pixels()[0], glam::Vec3::X);
    let emission = &scene.description.materials[0].emission;
    assert!(matches!(emission, Some(EmissionDescription::Texture { scale: 1.0, .. })), "{emission:?}");
}

#[test]
fn lights_have_the_strength_of_their_emitter() {
    let lights = |content: &str| import_text(content).description.lights;
    let point = lights(
        r#"<emitter type="point"><point name="position" value="1, 2, 3"/><rgb name="intensity" value="4"/></emitter>"#,
    );
    let strength = PointLightStrength::Intensity(DVec3::splat(4.0));
    assert_eq!(
        point[0].value,
        LightDescription::Point(PointLightDescription { position: DVec3::new(1.0, 2.0, 3.0), strength })
    );
    let sky = lights(r#"<emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>"#);
    assert_eq!(sky[0].value, LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::splat(0.5))));
    let sun = lights(r#"<emitter type="directional"><vector name="direction" x="0" y="-2" z="0"/></emitter>"#);
    assert!(
        matches!(sun[0].value, LightDescription::Directional(DirectionalLightDescription { direction, .. }) if direction == DVec3::NEG_Y)
    );
    assert!(matches!(lights("")[0].value, LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE))));
}

#[test]
fn a_white_sky_replaces_left_out_emitters() {
    let black = r#"<emitter type="constant"><rgb name="radiance" value="0"/></emitter>"#;
    for emitter in [black, "<emitter type=\"flashlight\"/>"] {
        let scene = import_text(emitter);
        let lights = &scene.description.lights;
        let sky = LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE));
        assert!(lights.len() == 1 && lights[0].value == sky, "{lights:?}");
        assert!(has_note(&scene, "no emitter of the file gives light: a white sky"));
    }
}

/// Compares the falloff with the formula in Mitsuba's documentation, which is linear in the angle.
#[test]
fn spotlights_fall_off_linearly_in_the_angle() {
    let scene = import_text(
        r#"<emitter type="spot"><float name="cutoff_angle" value="40"/><float name="beam_width" value="20"/>
          <transform name="to_world"><lookat origin="0,5,0" target="0,0,0" up="0,0,1"/></transform></emitter>"#,
    );
    let LightDescription::Goniometric(GoniometricLightDescription {
        pose,
        distribution: IntensityDistribution::MapFile(path),
        ..
    }) = &scene.description.lights[0].value
    else {
        panic!()
    };
    assert_eq!((pose.position, pose.up), (DVec3::new(0.0, 5.0, 0.0), Some(DVec3::NEG_Y)));
    let map = &scene.assets.pictures[&path.value];
    let value = |degrees: f64| f64::from(map.pixels()[(degrees * 8.0) as usize].x);
    for (degrees, expected) in [(10.0, 1.0), (19.0, 1.0), (30.0, 0.5), (35.0, 0.25), (41.0, 0.0), (170.0, 0.0)] {
        assert!((value(degrees) - expected).abs() < 0.01, "{degrees}: {} instead of {expected}", value(degrees));
    }
}

#[test]
fn media_fill_the_shapes_that_name_them() {
    let medium = r#"<medium name="interior" type="homogeneous"><rgb name="sigma_t" value="1 2 3"/>
        <rgb name="albedo" value="0.5"/><float name="scale" value="2"/><phase type="hg"><float name="g" value="0.3"/></phase></medium>"#;
    let scene = import_text(&format!("<shape type=\"sphere\"><bsdf type=\"null\"/>{medium}</shape>"));
    let expected =
        MediumCoefficients::ExtinctionAlbedo { extinction: DVec3::new(2.0, 4.0, 6.0), albedo: DVec3::splat(0.5) };
    assert_eq!(scene.description.media[0].coefficients, expected);
    assert_eq!(scene.description.materials[0].medium.as_ref().unwrap().value, scene.description.media[0].name);
    // A thin pane around a medium needs a second surface, just inside.
    let walled = import_text(&format!("<shape type=\"sphere\"><bsdf type=\"thindielectric\"/>{medium}</shape>"));
    let radii = placed_objects(&walled).into_iter().map(|(_, object)| match object {
        ObjectDescription::Shape { shape: ShapeDescription::Sphere(SphereDescription { radius, .. }), .. } => radius,
        other => panic!("{other:?}"),
    });
    assert_eq!(radii.collect::<Vec<f64>>(), [1.0, 0.9999]);
    assert!(placed_objects(&import_text("<shape type=\"sphere\"><bsdf type=\"null\"/></shape>")).is_empty());
}

#[test]
fn gridded_media_have_the_densities_of_their_volume() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = b"VOL\x03".to_vec();
    [1_u32, 2, 1, 1, 3].iter().for_each(|n| file.extend(n.to_le_bytes()));
    [0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 2.0, 4.0, 6.0].iter().for_each(|x| file.extend(x.to_le_bytes()));
    std::fs::write(folder.path().join("a.vol"), file).unwrap();
    let scene = import_text_in_folder(
        folder.path(),
        r#"<shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous"><float name="scale" value="10"/>
          <volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/></volume>
          <rgb name="albedo" value="0.9"/></medium></shape>"#,
    );
    let medium = &scene.description.media[0].value;
    let DensityDescription::Grid { path, .. } = &medium.density else { panic!() };
    assert_eq!(scene.assets.grids[&path.value].densities, [2.0, 4.0]);
    let MediumCoefficients::ExtinctionAlbedo { extinction, .. } = medium.coefficients else { panic!() };
    assert!((extinction - DVec3::new(5.0, 10.0, 15.0)).abs().max_element() < 1e-12, "{extinction}");
    assert!(has_note(&scene, "color of extinction"));
}

#[test]
fn instances_place_all_members_of_their_group() {
    let scene = import_text(
        r#"<shape type="shapegroup" id="g"><shape type="sphere"><transform name="to_world"><translate x="1"/></transform></shape>
          <shape type="rectangle"/></shape>
        <shape type="instance"><ref id="g"/></shape>
        <shape type="instance"><ref id="g"/><transform name="to_world"><scale value="2"/></transform></shape>"#,
    );
    let objects = placed_objects(&scene);
    assert_eq!(objects.len(), 4);
    assert_eq!(objects[2].0.transform_point3(DVec3::ZERO), DVec3::new(2.0, 0.0, 0.0));
}

#[test]
fn settings_of_the_file_become_suggested_flags() {
    let scene = import_text(
        r#"<integrator type="moment"><integrator type="volpath"><integer name="max_depth" value="6"/></integrator></integrator>
        <sensor type="perspective"><film type="hdrfilm"><rfilter type="tent"/></film></sensor>"#,
    );
    assert!(has_note(&scene, "`--integrator path --max-bounces 4 --filter tent`"), "{:?}", scene.notes);
}

#[test]
fn integrators_that_wrap_each_other_are_an_error() {
    let circle = r#"<integrator type="aov" id="a"><ref id="b"/></integrator>
        <integrator type="aov" id="b"><ref id="a"/></integrator>"#;
    assert_import_error(circle, "integrators are nested too deep, or contain themselves");
}
