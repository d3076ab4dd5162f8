use super::decode;
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricDescription, EmissionDescription,
    MaterialKindDescription, MetalDescription, MixDescription, RefractiveIndexDescription, TextureKindDescription,
    TexturedValue, ThinDielectricDescription, WrapMode,
};
use crate::format::import::{ImportOptions, ImportedScene};
use crate::stats::MemoryLimit;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use std::path::Path;

/// Returns the JSON of a scene with one triangle, the material `material`, and the node `node`.
fn triangle_scene(material: Value, node: Value) -> Value {
    let corners: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let uv: [[u8; 4]; 3] = [[0, 0, 0, 0], [255, 0, 0, 0], [0, 51, 0, 0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(uv.iter().flatten());
    let mut node = node;
    node["mesh"] = 0.into();
    json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [node],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
        "materials": [material],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0] },
            { "bufferView": 1, "componentType": 5121, "count": 3, "type": "VEC2", "normalized": true },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 12, "byteStride": 4 },
        ],
        "buffers": [{ "byteLength": 48, "uri": data_uri(&bytes) }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "wrapS": 33071, "wrapT": 33071 }],
        "images": [{ "uri": data_uri(&two_pixel_png()) }],
    })
}

fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

/// Returns a PNG of two pixels with alpha: (255, 0, 51, 255) and (0, 255, 102, 0).
fn two_pixel_png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[255, 0, 51, 255, 0, 255, 102, 0]).unwrap();
    writer.finish().unwrap();
    file
}

fn import_json(scene: &Value) -> ImportedScene {
    decode(Path::new("a.gltf"), scene.to_string().as_bytes(), &ImportOptions::default()).unwrap()
}

#[track_caller]
fn assert_import_error(scene: &Value, part: &str) {
    let error = decode(Path::new("a.gltf"), scene.to_string().as_bytes(), &ImportOptions::default()).unwrap_err();
    assert!(error.to_string().contains(part), "{error}");
}

/// Returns the kind of the material that is called `name`, with its parameters.
fn material_kind<'a>(scene: &'a ImportedScene, name: &str) -> &'a MaterialKindDescription {
    let found = scene.description.materials.iter().find(|m| m.name.as_deref() == Some(name));
    &found.unwrap_or_else(|| panic!("{name}: {:#?}", scene.description.materials)).value.kind
}

#[test]
fn metals_reflect_their_base_color() {
    let material = json!({ "name": "gold", "pbrMetallicRoughness": { "baseColorFactor": [0.75, 0.5, 0.25, 1], "roughnessFactor": 0.5 } });
    let scene = import_json(&triangle_scene(material, json!({})));
    let MaterialKindDescription::Conductor(ConductorDescription {
        metal: MetalDescription::Reflectance(reflectance),
        roughness,
        ..
    }) = material_kind(&scene, "gold")
    else {
        panic!()
    };
    assert_eq!(*reflectance, DVec3::new(0.75, 0.5, 0.25).into());
    assert_eq!(*roughness, TexturedValue::Constant(0.25));
    assert!(scene.notes.iter().all(|note| !note.concerns_unsupported_content), "{:?}", scene.notes);
}

#[test]
fn textures_keep_factors_channels_and_transforms() {
    let transform = json!({ "KHR_texture_transform": { "scale": [2, 4], "rotation": 0.5, "offset": [0.25, 0.5] } });
    let material = json!({
        "name": "a", "alphaMode": "BLEND",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 1, 1, 0.5], "metallicFactor": 0.5, "roughnessFactor": 1,
            "baseColorTexture": { "index": 0, "extensions": transform },
            "metallicRoughnessTexture": { "index": 0 },
        },
    });
    let scene = import_json(&triangle_scene(material, json!({})));
    // Alpha mixes the surface with a transparent material. The blue channel of the texture mixes
    // metal with the rest of the surface.
    let MaterialKindDescription::Mix(MixDescription { second_probability: TexturedValue::Texture(alpha), .. }) =
        material_kind(&scene, "a")
    else {
        panic!()
    };
    let MaterialKindDescription::Mix(MixDescription { second_probability: TexturedValue::Texture(metal), .. }) =
        material_kind(&scene, "a solid")
    else {
        panic!()
    };
    let MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
        reflectance: TexturedValue::Texture(base),
        eta,
        ..
    }) = material_kind(&scene, "a dielectric")
    else {
        panic!()
    };
    assert!((eta - 1.5).abs() < 1e-12, "{eta}");
    let MaterialKindDescription::Conductor(ConductorDescription {
        metal: MetalDescription::Reflectance(color), ..
    }) = material_kind(&scene, "a metal")
    else {
        panic!()
    };
    assert_eq!(color.texture_name(), Some(base));
    let picture = |name: &str| {
        let texture = scene.description.textures.iter().find(|texture| texture.name == name).unwrap();
        let TextureKindDescription::Image { path, wrap, uv_transform: coordinates, .. } = &texture.kind else {
            panic!()
        };
        assert_eq!(*wrap, WrapMode::Clamp);
        (scene.assets.pictures[&path.value].pixels().to_vec(), *coordinates)
    };
    let (pixels, coordinates) = picture(base);
    let blue = [51.0f64, 102.0].map(|level| libm::pow((level / 255.0 + 0.055) / 1.055, 2.4));
    let expected = [DVec3::new(0.5, 0.0, blue[0]), DVec3::new(0.0, 1.0, blue[1])];
    for (pixel, expected) in pixels.iter().zip(expected) {
        assert!((pixel.as_dvec3() - expected).length() < 1e-6, "{pixel} {expected}");
    }
    // The lower left corner of the surface is (0, 1) in the file, where v grows downwards.
    let (sin, cos) = (libm::sin(0.5), libm::cos(0.5));
    assert_eq!(coordinates.scale, DVec2::new(2.0, 4.0));
    assert!((coordinates.offset - DVec2::new(0.25 + 4.0 * sin, 1.0 - (0.5 + 4.0 * cos))).length() < 1e-12);
    assert_eq!(picture(alpha).0.iter().map(|p| p.x).collect::<Vec<_>>(), [0.5, 0.0]);
    let metallic: Vec<f32> = picture(metal).0.iter().map(|p| p.x).collect();
    assert!((metallic[0] - 0.1).abs() < 1e-6 && (metallic[1] - 0.2).abs() < 1e-6, "{metallic:?}");
    assert_eq!((scene.description.textures.len(), scene.assets.pictures.len()), (4, 4), "unused ones are left out");
    let mesh = &scene.assets.meshes["mesh0-0"];
    assert_eq!(mesh.texcoords.as_deref(), Some(&[DVec2::new(0.0, 1.0), DVec2::ONE, DVec2::new(0.0, 0.8)][..]));
}

#[test]
fn transmission_makes_bodies_and_panes() {
    let glass = |volume: Value| {
        json!({
            "name": "g", "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_volume": volume,
                "KHR_materials_dispersion": { "dispersion": 0.5 },
            },
        })
    };
    let body = import_json(&triangle_scene(glass(json!({ "thicknessFactor": 1 })), json!({})));
    let MaterialKindDescription::Dielectric(DielectricDescription { refraction, .. }) = material_kind(&body, "g")
    else {
        panic!()
    };
    assert_eq!(*refraction, RefractiveIndexDescription::Abbe { index: 1.5, abbe: 40.0 });
    let pane = import_json(&triangle_scene(glass(json!({ "thicknessFactor": 0 })), json!({})));
    assert!(matches!(
        material_kind(&pane, "g"),
        MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.5, .. })
    ));
}

/// Returns a plastic material whose extension `name` has the value `extension`.
fn plastic_with(name: &str, extension: Value) -> Value {
    json!({
        "name": "p", "extensions": { name: extension },
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.25, 1], "metallicFactor": 0.5, "roughnessFactor": 0.5,
        },
    })
}

#[test]
fn clear_coats_make_principled_surfaces() {
    let coat = json!({
        "clearcoatFactor": 0.5, "clearcoatTexture": { "index": 0 }, "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": { "index": 0 }, "clearcoatNormalTexture": { "index": 0 },
    });
    let scene = import_json(&triangle_scene(plastic_with("KHR_materials_clearcoat", coat), json!({})));
    let MaterialKindDescription::Principled(surface) = material_kind(&scene, "p") else { panic!() };
    assert_eq!(surface.base_color, DVec3::new(0.5, 0.5, 0.25).into());
    assert_eq!(
        (&surface.metallic, &surface.roughness),
        (&TexturedValue::Constant(0.5), &TexturedValue::Constant(0.25))
    );
    assert!((surface.eta - 1.5).abs() < 1e-12);
    // The amount of the coat is the red channel of the texture, 255 and 0, times the factor.
    let TexturedValue::Texture(amount) = &surface.clearcoat else { panic!("{:?}", surface.clearcoat) };
    let texture = scene.description.textures.iter().find(|texture| texture.name == amount.value).unwrap();
    let TextureKindDescription::Image { path, .. } = &texture.kind else { panic!() };
    assert_eq!(scene.assets.pictures[&path.value].pixels().iter().map(|p| p.x).collect::<Vec<_>>(), [0.5, 0.0]);
    // The roughness of the coat is the mean of α. The green channel is 0 and 255, so α is 0 and
    // (0.5)².
    assert!((surface.clearcoat_roughness - 0.125).abs() < 1e-6, "{}", surface.clearcoat_roughness);
    let noted = |part: &str| scene.notes.iter().any(|note| note.message.contains(part));
    assert!(noted("become their mean") && noted("normals of the surface below"), "{:?}", scene.notes);

    let none = plastic_with("KHR_materials_clearcoat", json!({ "clearcoatRoughnessFactor": 0.5 }));
    let scene = import_json(&triangle_scene(none, json!({})));
    assert!(matches!(material_kind(&scene, "p"), MaterialKindDescription::Mix(_)), "the default factor is 0");
    let broken = plastic_with("KHR_materials_clearcoat", json!({ "clearcoatTexture": { "index": 7 } }));
    assert_import_error(&triangle_scene(broken, json!({})), "`clearcoatTexture` is no texture of this file");
}

#[test]
fn diffuse_transmission_takes_its_share_of_diffuse_reflection() {
    let transmission =
        |factor: f64| json!({ "diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": [1, 0.5, 0] });
    let mut material = plastic_with("KHR_materials_diffuse_transmission", transmission(0.25));
    material["pbrMetallicRoughness"]["metallicFactor"] = 0.into();
    let scene = import_json(&triangle_scene(material.clone(), json!({})));
    let MaterialKindDescription::Mix(mix) = material_kind(&scene, "p") else { panic!() };
    assert_eq!(mix.second_probability, TexturedValue::Constant(0.25));
    assert!(matches!(material_kind(&scene, &mix.first), MaterialKindDescription::CoatedDiffuse(_)));
    let MaterialKindDescription::DiffuseTransmission(sheet) = material_kind(&scene, &mix.second) else { panic!() };
    assert_eq!((&sheet.reflectance, &sheet.transmittance), (&DVec3::ZERO.into(), &DVec3::new(1.0, 0.5, 0.0).into()));

    material["extensions"]["KHR_materials_diffuse_transmission"] = transmission(1.0);
    let scene = import_json(&triangle_scene(material.clone(), json!({})));
    assert!(matches!(material_kind(&scene, "p"), MaterialKindDescription::DiffuseTransmission(_)));
    material["extensions"]["KHR_materials_diffuse_transmission"] = json!({});
    let scene = import_json(&triangle_scene(material, json!({})));
    assert!(matches!(material_kind(&scene, "p"), MaterialKindDescription::CoatedDiffuse(_)));
}

#[test]
fn unsupported_content_is_noted_once() {
    let material = json!({ "name": "a", "extensions": { "KHR_materials_sheen": {}, "KHR_materials_iridescence": {} } });
    let mut scene = triangle_scene(material, json!({ "weights": [0.5] }));
    scene["animations"] = json!([{}, {}]);
    let notes = import_json(&scene).notes;
    let count = |part: &str| {
        notes.iter().filter(|note| note.message.contains(part) && note.concerns_unsupported_content).count()
    };
    for part in ["sheen is ignored", "iridescence is ignored", "morph targets", "(2×: animations[0], animations[1])"] {
        assert_eq!(count(part), 1, "{part}: {notes:?}");
    }
    assert_eq!(
        notes.iter().filter(|note| !note.concerns_unsupported_content).count(),
        2,
        "no camera, no light: {notes:?}"
    );
}

#[test]
fn normal_maps_scaled_to_nothing_are_noted() {
    let transform = json!({ "KHR_texture_transform": { "scale": [0, 1] } });
    let material = json!({ "name": "a", "normalTexture": { "index": 0, "extensions": transform } });
    let notes = import_json(&triangle_scene(material, json!({}))).notes;
    assert!(notes.iter().any(|note| note.message.contains("scaled to nothing")), "{notes:?}");
}

#[test]
fn surfaces_emit_by_strength_and_alpha() {
    let material = json!({
        "name": "a", "emissiveFactor": [1, 0.5, 0.25], "alphaMode": "BLEND",
        "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.5] },
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } },
    });
    let scene = import_json(&triangle_scene(material, json!({})));
    let emission = scene.description.materials.iter().find_map(|material| material.emission.clone());
    assert_eq!(emission, Some(EmissionDescription::Constant(DVec3::new(4.0, 2.0, 1.0))));
    assert!(!scene.notes.iter().any(|note| note.message.contains("no light")), "{:?}", scene.notes);
}

#[test]
fn instances_become_objects() {
    let instancing = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } });
    let scene = import_json(&triangle_scene(json!({}), json!({ "extensions": instancing, "scale": [2, 2, 2] })));
    assert_eq!(scene.description.root.items.len(), 6);
    let printed = scene.description.to_string();
    assert!(printed.contains("2 0 0 0 0 2 0 0 0 0 2 0 0 4 0 1"), "{printed}");
    assert_eq!(scene.assets.meshes.len(), 1);
}

#[test]
fn broken_files_are_refused_with_their_place() {
    let with = |change: &dyn Fn(&mut Value)| {
        let mut scene = triangle_scene(json!({}), json!({}));
        change(&mut scene);
        scene
    };
    assert_import_error(
        &with(&|s| s["accessors"][0]["count"] = 4.into()),
        "accessors[0]: 4 elements of 12 bytes do not fit",
    );
    assert_import_error(
        &with(&|s| s["bufferViews"][0]["byteOffset"] = 20.into()),
        "bufferViews[0]: it ends beyond its buffer",
    );
    assert_import_error(
        &with(&|s| s["buffers"][0]["byteLength"] = 49.into()),
        "buffers[0]: it has 48 bytes instead of 49",
    );
    assert_import_error(
        &with(&|s| s["buffers"][0]["uri"] = "data:;base64,*".into()),
        "buffers[0]: its data URI is damaged",
    );
    assert_import_error(
        &with(&|s| s["buffers"][0]["uri"] = "none.bin".into()),
        "buffers[0]: the file `none.bin` does not",
    );
    assert_import_error(&with(&|s| s["buffers"][0]["uri"] = "http://a/b".into()), "`http://a/b` is not a local file");
    assert_import_error(&with(&|s| s["accessors"][0]["type"] = "VEC2".into()), "attributes.POSITION");
    assert_import_error(&with(&|s| s["nodes"][0]["mesh"] = 9.into()), "nodes[0].mesh is an index out of range");
    let attributes = "meshes[0].primitives[0].attributes.POSITION: it is an index out of range";
    assert_import_error(&with(&|s| s["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9.into()), attributes);
    assert_import_error(&with(&|s| s["nodes"][0]["children"] = json!([0])), "nodes[0]: it is reached twice");
    assert_import_error(
        &with(&|s| s["nodes"][0]["translation"] = json!([1e39, 0, 0])),
        "nodes[0]: its transform is not finite",
    );
    assert_import_error(
        &with(&|s| s["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
        "`KHR_draco_mesh_",
    );
    assert_import_error(&with(&|s| s["asset"]["version"] = "1.0".into()), "glTF 1.0 is not read");
    let mut indexed = with(&|s| s["meshes"][0]["primitives"][0]["indices"] = 1.into());
    assert_import_error(&indexed, "accessors[1]: indices must be unsigned integers");
    indexed["accessors"][1]["type"] = "SCALAR".into();
    indexed["accessors"][1]["normalized"] = false.into();
    assert_import_error(&indexed, "index 255 is out of range: there are 3 vertices");
    let sparse =
        json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5121 }, "values": { "bufferView": 0 } });
    let mut huge = with(&|s| s["accessors"][0]["sparse"] = sparse.clone());
    huge["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(
        import_json(&huge).assets.meshes["mesh0-0"].positions,
        [DVec3::ZERO],
        "one element is replaced, by zero"
    );
    huge["accessors"][0]["count"] = 1_000_000_000_u64.into();
    let options = ImportOptions { memory_limit: MemoryLimit::ProcessBytes(1 << 33), ..ImportOptions::default() };
    let error = decode(Path::new("a.gltf"), huge.to_string().as_bytes(), &options).unwrap_err();
    assert!(matches!(error, crate::format::SceneReadError::OutOfMemory { .. }), "{error}");
}

#[test]
fn files_outside_the_folder_need_permission() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("in");
    std::fs::create_dir(&inside).unwrap();
    let mut scene = triangle_scene(json!({}), json!({}));
    let bytes = STANDARD.decode(scene["buffers"][0]["uri"].as_str().unwrap().split(',').nth(1).unwrap()).unwrap();
    std::fs::write(folder.path().join("a b.bin"), bytes).unwrap();
    scene["buffers"][0]["uri"] = "../a%20b.bin".into();
    let import = |allows_outside_files| {
        let options = ImportOptions { allows_outside_files, ..ImportOptions::default() };
        decode(&inside.join("a.gltf"), scene.to_string().as_bytes(), &options)
    };
    assert!(import(false).unwrap_err().to_string().contains("`../a b.bin` is outside the folder of the scene"));
    assert_eq!(import(true).unwrap().assets.meshes.len(), 1);
}
