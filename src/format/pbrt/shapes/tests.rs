//! Tests of the texture coordinates of shapes of pbrt.

use crate::format::description::{GroupItem, ObjectDescription, ShapeDescription, TransformStep};
use crate::format::import::ImportedScene;
use crate::format::pbrt::tests::{import_text, note_messages};
use glam::{DVec2, DVec3};

/// Returns a scene with `shapes` under a material with a checkerboard.
fn textured_shapes(shapes: &str) -> ImportedScene {
    import_text(&format!(
        "WorldBegin Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [.2 .2 .2] \
         Material \"diffuse\" \"texture reflectance\" \"t\" {shapes}"
    ))
}

#[test]
fn textured_spheres_have_pbrt_texture_coordinates() {
    let scene = textured_shapes("Shape \"sphere\"");
    let GroupItem::Object(object) = &scene.description.root.items[1] else { panic!() };
    let ObjectDescription::Transform { steps, object } = &object.value else { panic!() };
    assert!(matches!(object.value, ObjectDescription::Shape { shape: ShapeDescription::Sphere(_), .. }));
    let map = TransformStep::composed_matrix(steps).matrix3;
    // Left: Caustica's directions with u = 0, u = ¼ and v = 1. Right: pbrt's. The world is mirrored
    // along z.
    assert_eq!([DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y].map(|d| map * d), [DVec3::X, DVec3::Y, DVec3::NEG_Z]);
}

#[test]
fn textured_disks_and_cylinders_become_meshes_with_texcoords() {
    let shapes = "Shape \"disk\" Shape \"cylinder\"";
    let scene = textured_shapes(shapes);
    let meshes: Vec<_> = scene.assets.meshes.values().collect();
    assert_eq!(meshes.len(), 2);
    assert!(note_messages(&scene).contains("disks and cylinders with textures"));
    let disk = meshes[0];
    for (position, uv) in disk.positions.iter().zip(disk.texcoords.as_ref().unwrap()) {
        // Radius 1 has v = 0, and the center has v = 1.
        assert!((position.length() - (1.0 - uv.y)).abs() < 1e-9, "{position} {uv}");
    }
    let plain = import_text(&format!("WorldBegin {shapes}"));
    assert!(plain.assets.meshes.is_empty() && !note_messages(&plain).contains("facets"));
}

#[test]
fn textured_meshes_without_texcoords_get_pbrt_defaults() {
    let square = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 0 2 3]";
    let corner_of = |uv: DVec2| [DVec2::ZERO, DVec2::X, DVec2::ONE].iter().position(|corner| *corner == uv).unwrap();
    let file_triangles =
        [[DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)], [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]];
    // Normals that oppose the winding turn the triangles. The coordinates stay with the corners.
    for normals in ["", "\"normal N\" [0 0 -1 0 0 -1 0 0 -1 0 0 -1]"] {
        let scene = textured_shapes(&format!("{square} {normals}"));
        let mesh = scene.assets.meshes.values().next().unwrap();
        let texcoords = mesh.texcoords.as_ref().unwrap();
        for (triangle, expected) in mesh.triangles.iter().zip(file_triangles) {
            for vertex in triangle.map(|i| i as usize) {
                assert_eq!(mesh.positions[vertex], expected[corner_of(texcoords[vertex])], "{normals}");
            }
        }
    }
    let plain = import_text(&format!("WorldBegin {square}"));
    assert!(plain.assets.meshes.values().all(|mesh| mesh.texcoords.is_none() && mesh.positions.len() == 4));
}
