//! Tests of meshes in scenes: file materials, normals, textures.

use super::*;
use crate::image::{self, Image, WriteOptions};

const OBJ_VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\nv 0 2 0\n";

struct TemporaryMeshFolder(tempfile::TempDir);

impl TemporaryMeshFolder {
    fn new(obj: &str, mtl: &str) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write_test_file("a.obj", &format!("mtllib a.mtl\n{OBJ_VERTICES}{obj}"));
        folder.write_test_file("a.mtl", mtl);
        folder
    }

    fn write_test_file(&self, name: &str, text: &str) {
        std::fs::write(self.0.path().join(name), text).unwrap();
    }

    fn resolve_scene_with_objects(&self, body: &str) -> Scene {
        resolve_in_folder(self.0.path(), &format!("{MATERIAL_BLOCK_PARSERS}Group {{ MaterialName b {body} }}")).unwrap()
    }

    fn resolve_error_message(&self, body: &str) -> String {
        let error = resolve_in_folder(self.0.path(), &format!("Group {{\n{body} }}")).unwrap_err();
        assert_eq!((error.line(), error.offending_text()), (3, "a.obj"));
        error.message().to_owned()
    }
}

/// Returns the surface that a ray in direction −z hits first at (x, y), and the hit point.
fn surface_seen_from_front(scene: &Scene, x: f64, y: f64) -> (SurfaceInteraction<'_>, DVec3) {
    visible_surface(scene, dvec3(x, y, 9.0), Vec3::NEG_Z).unwrap()
}

fn reflectance_seen_from_front(scene: &Scene, x: f64) -> Vec3 {
    visible_reflectance(scene, dvec3(x, 0.25, 9.0), Vec3::NEG_Z)
}

const OBJ_FACES: &str = "f 1 2 3\nusemtl red\nf 2 5 6 3\nusemtl lamp\nf 1 3 4\nusemtl red\nf 4 3 7\n";
const MTL_TEXT: &str = "newmtl red\nKd .9 .1 .1\nillum 1\nnewmtl lamp\nKe 3 2 1\nKd .5\n";

#[test]
fn a_mesh_uses_scene_or_file_materials() {
    let folder = TemporaryMeshFolder::new(OBJ_FACES, MTL_TEXT);
    let plain = folder.resolve_scene_with_objects("TriangleMesh { obj_file a.obj }");
    assert_eq!((plain.materials().len(), plain.lights().len(), plain.triangle_count()), (2, 0, 5));
    assert_eq!(
        (reflectance_seen_from_front(&plain, 0.5), reflectance_seen_from_front(&plain, 1.5)),
        (Vec3::splat(0.2), Vec3::splat(0.2))
    );
    assert_eq!(visible_reflectance(&plain, dvec3(0.1, 0.8, 9.0), Vec3::NEG_Z), Vec3::splat(0.2));
    let own = folder
        .resolve_scene_with_objects("TriangleMesh { file a.obj materials file } Sphere { center 9 0 0 radius 1 }");
    assert_eq!((own.materials().len(), own.triangle_count()), (4, 5));
    // Faces without a file material, and the objects that follow, keep the scene's material.
    assert_eq!(
        (reflectance_seen_from_front(&own, 0.5), reflectance_seen_from_front(&own, 1.5)),
        (Vec3::splat(0.2), vec3(0.9, 0.1, 0.1))
    );
    assert_eq!(reflectance_seen_from_front(&own, 9.0), Vec3::splat(0.2));
    assert_eq!(visible_reflectance(&own, dvec3(0.1, 0.8, 9.0), Vec3::NEG_Z), Vec3::splat(0.5));
    let [Light::Area(lamp)] = own.lights() else { panic!("{:?}", own.lights()) };
    assert_eq!(lamp.radiance, vec3(3.0, 2.0, 1.0));
    // The materials of a file that two shapes use are added once.
    let twice = "TriangleMesh { file a.obj materials file }".repeat(2);
    assert_eq!(folder.resolve_scene_with_objects(&twice).materials().len(), 4);
}

#[test]
fn object_emission_overrides_file_emission() {
    let folder = TemporaryMeshFolder::new(OBJ_FACES, MTL_TEXT);
    let scene = folder.resolve_scene_with_objects("TriangleMesh { file a.obj materials file emission 7 7 7 }");
    assert_eq!(scene.lights().len(), 3);
    let emits = |light: &Light| matches!(light, Light::Area(area) if area.radiance == Vec3::splat(7.0));
    assert!(scene.lights().iter().all(emits));
    let dark = folder.resolve_scene_with_objects("TriangleMesh { file a.obj materials file emission 0 0 0 }");
    assert!(dark.lights().is_empty());
}

#[test]
fn moving_and_instanced_meshes_use_file_materials() {
    let folder = TemporaryMeshFolder::new(OBJ_FACES, MTL_TEXT);
    let still = "Transform { Scale 2 2 2 TriangleMesh { file a.obj materials file emission 0 0 0 } }";
    let moving = still.replace("Transform { Scale", "Moving { Translate 0 0 -.001 Scale");
    for body in [still, &moving] {
        let scene = folder.resolve_scene_with_objects(body);
        assert_eq!(
            (reflectance_seen_from_front(&scene, 1.0), reflectance_seen_from_front(&scene, 3.0)),
            (Vec3::splat(0.2), vec3(0.9, 0.1, 0.1))
        );
    }
}

#[test]
fn invalid_file_materials_are_reported_at_the_mesh() {
    let body = "TriangleMesh { file a.obj materials file }";
    let folder = TemporaryMeshFolder::new(OBJ_FACES, "newmtl red\n");
    let message = folder.resolve_error_message(body);
    assert!(message.contains("names a material `lamp` that its material files do not hold"), "{message}");
    folder.write_test_file("a.mtl", "newmtl red\nd 0\nNi 0\nnewmtl lamp\n");
    assert!(folder.resolve_error_message(body).contains("`red` is transparent and its `Ni` is 0"));
    folder.write_test_file("a.mtl", "newmtl red\nd 2\n");
    assert!(folder.resolve_error_message(body).contains("a.mtl:2: `d` is 2"));
    std::fs::remove_file(folder.0.path().join("a.mtl")).unwrap();
    assert!(folder.resolve_error_message(body).contains("there is no material file"));
    // Without `materials file`, the mesh keeps the material of the scene, so its material file may
    // be missing.
    folder.resolve_scene_with_objects("TriangleMesh { file a.obj }");
}

#[test]
fn mesh_options_select_the_normals() {
    let folder = TemporaryMeshFolder::new("vn 0 1 1\nf 1//1 2//1 3//1\nf 2 5 6 3\n", "");
    let normal = |options: &str, x: f64| {
        let scene = folder.resolve_scene_with_objects(&format!("TriangleMesh {{ file a.obj {options} }}"));
        surface_seen_from_front(&scene, x, 0.25).0.point.ns
    };
    let (written, flat) = (Vec3::new(0.0, 1.0, 1.0).normalize(), Vec3::new(-1.0, 0.0, 1.0).normalize());
    assert!(is_nearly_equal(normal("", 0.9), written) && is_nearly_equal(normal("", 1.5), flat));
    assert!(is_nearly_equal(normal("normals none", 0.9), Vec3::Z));
    // The normals of the two faces are 45° apart, so an angle of 44° smooths nothing.
    assert!(
        is_nearly_equal(normal("smoothAngle 44", 1.5), flat) && is_nearly_equal(normal("smoothAngle 44", 0.9), written)
    );
    // The normals at both ends of the edge lie between the two face normals, so all normals along
    // the edge do.
    let mean = normal("normals none smoothAngle 46", 1.000_001);
    assert!(mean.dot(Vec3::Z) < 0.999 && mean.dot(flat) < 0.999 && mean.y.abs() < 1e-6, "{mean}");
    assert!(is_nearly_equal(normal("normals none smoothAngle 44", 1.000_001), flat));
}

#[test]
fn ply_files_are_read_as_meshes() {
    let folder = TemporaryMeshFolder::new(OBJ_FACES, MTL_TEXT);
    let mesh = crate::format::mesh::load(&folder.0.path().join("a.obj"), &()).unwrap().mesh;
    mesh.write(&folder.0.path().join("a.ply"), crate::format::mesh::MeshFormat::PlyBinary, &[]).unwrap();
    let scene = folder.resolve_scene_with_objects("TriangleMesh { file a.ply materials file }");
    assert_eq!((scene.triangle_count(), reflectance_seen_from_front(&scene, 1.5)), (5, Vec3::splat(0.2)));
    // A PLY file is recognized by its content.
    std::fs::rename(folder.0.path().join("a.ply"), folder.0.path().join("b.obj")).unwrap();
    assert_eq!(folder.resolve_scene_with_objects("TriangleMesh { obj_file b.obj }").triangle_count(), 5);
}

#[test]
fn file_materials_can_have_textures() {
    let faces = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl tile\nf 1/1 2/2 3/3 4/4\n";
    let folder = TemporaryMeshFolder::new(faces, "newmtl tile\nKd .5 .5 .5\nmap_Kd pictures/tile.exr\nillum 1\n");
    std::fs::create_dir(folder.0.path().join("pictures")).unwrap();
    let picture = Image::from_pixels(2, 1, vec![Vec3::X, Vec3::Y]).unwrap();
    let path = folder.0.path().join("pictures/tile.exr");
    image::write(&path, &picture, &WriteOptions::default()).unwrap();
    let body = "TriangleMesh { file a.obj materials file }";
    // The rays hit the middles of the two texels, off the edge between the triangles. The mesh is
    // at rest or moves, and the scene has materials or none.
    let reflectance_seen_from_front =
        |scene: &Scene, x: f64| visible_reflectance(scene, dvec3(x, 0.3, 9.0), Vec3::NEG_Z);
    for text in [body.to_owned(), format!("Moving {{ Translate 0 0 -.001 {body} }}")] {
        for materials in ["", MATERIAL_BLOCK_PARSERS] {
            let scene = resolve_in_folder(folder.0.path(), &format!("{materials}Group {{ {text} }}")).unwrap();
            assert!(
                is_nearly_equal(reflectance_seen_from_front(&scene, 0.25), vec3(0.5, 0.0, 0.0))
                    && is_nearly_equal(reflectance_seen_from_front(&scene, 0.75), vec3(0.0, 0.5, 0.0))
            );
        }
    }
    std::fs::remove_file(path).unwrap();
    assert!(folder.resolve_error_message(body).contains("tile.exr` does not exist"));
    folder.write_test_file("a.obj", &format!("mtllib a.mtl\n{OBJ_VERTICES}usemtl tile\nf 1 2 3\n"));
    image::write(&folder.0.path().join("pictures/tile.exr"), &picture, &WriteOptions::default()).unwrap();
    let message = folder.resolve_error_message(body);
    assert!(message.contains("`a.obj` has no texture coordinates, which the material `tile` needs"), "{message}");
}

#[test]
fn textured_emission_applies_to_its_material_only() {
    let folder = TemporaryMeshFolder::new(OBJ_FACES, "newmtl red\nKd .9 .1 .1\nillum 1\nnewmtl lamp\nKd .5\n");
    let textures = "Textures { Marble veins { color0 1 1 1 color1 2 2 2 } }";
    let materials = "Materials { Diffuse b { reflectance .2 .2 .2 emission veins } }";
    let text = format!("{textures}{materials}Group {{ TriangleMesh {{ file a.obj materials file }} }}");
    let scene = resolve_in_folder(folder.0.path(), &text).unwrap();
    // Only the part without a file material emits.
    let [Light::Area(lamp)] = scene.lights() else { panic!("{:?}", scene.lights()) };
    assert!(lamp.texture.is_some());
}
