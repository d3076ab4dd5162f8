//! Scenes in glTF: values, pictures and conversion.
//!
//! Scenes by other people may not be distributed, so they are outside the repository: see
//! [`crate::support::world_data_folder`].

use crate::support::{project_path, world_data_folder};
use caustica::format::description::{
    CoatedDiffuseDescription, DielectricAbsorption, DielectricDescription, DirectionalLightDescription,
    DirectionalLightStrength, GroupItem, LightDescription, MaterialKindDescription, ObjectDescription,
    PointLightDescription, PointLightStrength, ProjectionDescription, RefractiveIndexDescription, SceneDescription,
    SpotLightDescription, TextureKindDescription, TransformStep,
};
use caustica::format::mesh::MeshFormat;
use caustica::format::{ConvertedScene, SceneFile, parse};
use caustica::image::{self, WriteOptions};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use glam::{DVec2, DVec3, Vec3};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

/// Renders one pass of a small picture.
fn small_picture(scene: &Path) -> Vec<Vec3> {
    let mut file = SceneFile::read(scene).unwrap_or_else(|e| panic!("{}: {e}", scene.display()));
    (file.description.camera.value.width, file.description.camera.value.height) = (30, 24);
    let scene = file.resolve().unwrap_or_else(|e| panic!("{}: {e}", scene.display()));
    Algorithm::Path.prepare(&scene, Settings::default()).render_pass(0, &SilentMonitor).image
}

/// Writes a scene as a text file with its meshes and pictures, as `caustica convert` does.
fn convert(scene: &Path, output: &Path) {
    let converted = ConvertedScene::new(&SceneFile::read(scene).unwrap(), output);
    fs::write(output, converted.text).unwrap();
    converted.meshes.iter().for_each(|(path, mesh)| mesh.write(path, MeshFormat::PlyBinary, &[]).unwrap());
    for (path, picture) in &converted.pictures {
        image::write(path, picture, &WriteOptions::default()).unwrap();
    }
}

/// Returns the glTF files of the folder of scenes by other people; empty if the data may be absent.
fn world_scenes() -> Vec<PathBuf> {
    let Some(folder) = world_data_folder("gltf") else { return Vec::new() };
    let folders = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir());
    let files = folders.flat_map(|folder| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|e| e == "gltf" || e == "glb");
    let mut scenes: Vec<PathBuf> = files.filter(is_scene).collect();
    scenes.sort();
    assert!(scenes.len() >= 29, "{scenes:?}");
    scenes
}

/// Returns the description and the JSON of a `.gltf` file by other people.
fn world_scene(name: &str) -> Option<(SceneDescription, Value)> {
    let path = world_data_folder("gltf")?.join(name).join(format!("{name}.gltf"));
    let json = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    Some((SceneFile::read(&path).unwrap().description, json))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// Fails unless `a` equals `b` up to the rounding of single precision.
#[track_caller]
fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-6 * b.abs().max(1e-3), "{a} instead of {b}");
}

#[track_caller]
fn assert_all_near(a: DVec3, b: &[f64]) {
    (0..3).for_each(|k| assert_near(a[k], b[k]));
}

#[test]
fn gltf_scenes_render_like_equal_scene_text() {
    let folder = project_path("tests/data/gltf");
    let (ours, theirs) = (small_picture(&folder.join("cell.txt")), small_picture(&folder.join("cell.gltf")));
    assert!(ours.iter().any(|pixel| *pixel != Vec3::ZERO));
    assert!(ours == theirs, "the pictures differ");
}

#[test]
#[ignore = "long: conversions of many scenes"]
fn converted_scenes_render_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = world_scenes();
    scenes.push(project_path("tests/data/gltf/cell.gltf"));
    for scene in scenes {
        let output = folder.path().join("converted.txt");
        convert(&scene, &output);
        let imported = small_picture(&scene);
        assert!(imported.iter().all(|pixel| pixel.is_finite()));
        assert!(small_picture(&output) == imported, "{}", scene.display());
    }
}

#[test]
fn imported_descriptions_can_be_printed_and_parsed() {
    for scene in world_scenes() {
        let description = SceneFile::read(&scene).unwrap().description;
        let printed = description.to_string();
        let again = parse("printed.txt", &printed).unwrap_or_else(|e| panic!("{}: {e}", scene.display()));
        assert!(again == description, "{}: {printed}", scene.display());
    }
}

/// Glass bodies have the index and absorption of their file.
///
/// Each is compared with the extensions of the glTF material of the same name.
#[test]
fn glass_has_index_and_absorption_of_its_file() {
    let mut bodies = 0;
    for name in ["16_volume", "24_animation_pointer"] {
        let Some((description, json)) = world_scene(name) else { return };
        for material in &description.materials {
            let MaterialKindDescription::Dielectric(DielectricDescription {
                refraction,
                absorption: attenuation,
                roughness,
                ..
            }) = &material.kind
            else {
                continue;
            };
            let full = material.name.as_deref().unwrap();
            let own = full.strip_suffix(" glass").unwrap_or(full);
            let source = json["materials"].as_array().unwrap().iter().find(|m| m["name"] == own).unwrap();
            let volume = &source["extensions"]["KHR_materials_volume"];
            let index = source["extensions"]["KHR_materials_ior"]["ior"].as_f64().unwrap_or(1.5);
            let RefractiveIndexDescription::Constant(found) = refraction else { panic!("{refraction:?}") };
            assert_near(*found, index);
            match attenuation {
                DielectricAbsorption::Tint { color, distance } => {
                    assert_all_near(*color, &numbers(&volume["attenuationColor"]));
                    assert_near(*distance, volume["attenuationDistance"].as_f64().unwrap());
                    // Beer's law gives σ from the attenuation color and distance, as the
                    // specification states.
                    let sigma = attenuation.absorption_coefficient();
                    assert_near(sigma.x, -libm::log(color.x) / distance);
                }
                _ => assert!(volume["attenuationDistance"].is_null() || volume["attenuationColor"].is_null()),
            }
            let own_roughness = source["pbrMetallicRoughness"]["roughnessFactor"].as_f64().unwrap_or(1.0);
            if let caustica::format::description::TexturedValue::Constant(alpha) = roughness {
                assert_near(*alpha, own_roughness * own_roughness);
            }
            bodies += 1;
        }
    }
    assert!(bodies >= 10, "{bodies}");
}

#[test]
fn punctual_lights_have_the_units_of_watts() {
    let Some(folder) = world_data_folder("gltf") else { return };
    let lights = SceneFile::read(&folder.join("blender_glass/blender_glass.glb")).unwrap().description.lights;
    // Blender exported a spot and a point light of 100 W, and a sun of 100 W/m². The files hold
    // photometric values at 683 lm/W.
    let watts = 5_435.141_306_588_225 / 683.0;
    let [spot, point, sun] = [0, 1, 2].map(|i| &lights[i].value);
    let LightDescription::Spot(SpotLightDescription {
        position,
        full_cone_angle_degrees: angle,
        penumbra_degrees: penumbra,
        strength,
        ..
    }) = spot
    else {
        panic!("{spot:?}")
    };
    assert_all_near(*position, &[3.0, 4.0, 0.0]);
    assert_near(*angle, 2.0 * 0.392_699_092_626_571_66 * 360.0 / TAU);
    assert_near(*penumbra, (0.392_699_092_626_571_66 - 0.333_794_226_391_919_7) * 360.0 / TAU);
    assert!(matches!(strength, PointLightStrength::Intensity(i) if (i.x / watts - 1.0).abs() < 1e-6));
    let LightDescription::Point(PointLightDescription { position, strength }) = point else { panic!("{point:?}") };
    assert_all_near(*position, &[-3.0, 4.0, 0.0]);
    assert!(matches!(strength, PointLightStrength::Intensity(i) if (i.y / watts - 1.0).abs() < 1e-6));
    let LightDescription::Directional(DirectionalLightDescription { direction, strength }) = sun else {
        panic!("{sun:?}")
    };
    assert!((*direction - DVec3::NEG_Y).length() < 1e-6, "{direction}");
    assert!(matches!(strength, DirectionalLightStrength::Irradiance(e) if (e.z - 100.0).abs() < 1e-4));
}

#[test]
fn cameras_and_nodes_have_their_transforms() {
    let Some(folder) = world_data_folder("gltf") else { return };
    let blender = SceneFile::read(&folder.join("blender_glass/blender_glass.glb")).unwrap().description;
    let camera = &blender.camera;
    assert_all_near(camera.center, &[0.0, 2.0, 8.0]);
    let ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens: None } = camera.projection else {
        panic!("{camera:?}")
    };
    assert_near(angle, 0.399_596_520_463_048_94 * 360.0 / TAU);
    assert_eq!((camera.width, camera.height), (1280, 720));
    let Some((hierarchy, json)) = world_scene("02_node_hierarchy") else { return };
    let nodes = json["nodes"].as_array().unwrap();
    let child = nodes.iter().position(|node| node["mesh"].is_u64() && node["children"].is_null()).unwrap();
    // The translations of the child and its parents add up, because none of them turns or scales.
    let mut expected = DVec3::ZERO;
    let mut next = Some(child);
    while let Some(index) = next {
        assert!(nodes[index]["rotation"].is_null() && nodes[index]["scale"].is_null());
        let translation = &nodes[index]["translation"];
        if !translation.is_null() {
            expected += DVec3::from_slice(&numbers(translation));
        }
        let is_parent = |node: &Value| node["children"].as_array().is_some_and(|c| c.contains(&index.into()));
        next = nodes.iter().position(is_parent);
    }
    let matrices = hierarchy.root.items.iter().filter_map(|item| match item {
        GroupItem::Object(object) => match &object.value {
            ObjectDescription::Transform { steps, .. } => match steps[..] {
                [TransformStep::Matrix(matrix)] => Some(matrix),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    });
    let positions: Vec<DVec3> = matrices.map(|matrix| matrix.w_axis.truncate()).collect();
    assert!(positions.iter().any(|p| (*p - expected).length() < 1e-5), "{positions:?} lack {expected}");
}

#[test]
fn factors_and_texture_transforms_match_the_file() {
    let Some((common, json)) = world_scene("04_common_materials") else { return };
    let mut compared = 0;
    for material in &common.materials {
        let name = material.name.as_deref().unwrap();
        let MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription { reflectance, eta, .. }) = &material.kind
        else {
            continue;
        };
        let Some(source) = json["materials"].as_array().unwrap().iter().find(|m| m["name"] == name) else { continue };
        let factor = &source["pbrMetallicRoughness"]["baseColorFactor"];
        let caustica::format::description::TexturedValue::Constant(reflectance) = reflectance else { continue };
        let base = if factor.is_null() { vec![1.0; 3] } else { numbers(factor) };
        assert_all_near(*reflectance, &base);
        assert_near(*eta, 1.5);
        compared += 1;
    }
    assert!(compared > 0);
    let Some((textured, json)) = world_scene("09_texture_transform") else { return };
    let info = &json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    let transform = &info["extensions"]["KHR_texture_transform"];
    let scale = numbers(&transform["scale"]);
    let coordinates = textured.textures.iter().filter_map(|texture| match &texture.kind {
        TextureKindDescription::Image { uv_transform: coordinates, .. } => Some(coordinates),
        _ => None,
    });
    let coordinates = coordinates.into_iter().find(|c| c.scale == DVec2::new(scale[0], scale[1])).unwrap();
    let rotation = transform["rotation"].as_f64().unwrap_or(0.0);
    assert_near(coordinates.rotation_degrees, rotation * 360.0 / TAU);
    // The lower left corner has the glTF texture coordinates (0, 1). The extension's formula maps
    // them to (u, v).
    let offset = if transform["offset"].is_null() { vec![0.0; 2] } else { numbers(&transform["offset"]) };
    let (u, v) = (offset[0] + libm::sin(rotation) * scale[1], offset[1] + libm::cos(rotation) * scale[1]);
    assert_near(coordinates.offset.x, u);
    assert_near(coordinates.offset.y, 1.0 - v);
}
