//! Tests of the conversion of shapes and of their emission.

use super::{has_note, import_text, import_text_in_folder, placed_objects};
use crate::format::description::{
    MaterialKindDescription, MeshDescription, ObjectDescription, RectangleDescription, ShapeDescription,
    TextureKindDescription,
};
use crate::format::import::ImportedScene;
use crate::format::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Writes a PNG file with one row of sRGB-encoded pixels.
fn write_png(path: &Path, pixels: &[[u8; 3]]) {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, pixels.len() as u32, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(pixels.as_flattened()).unwrap();
    std::fs::write(path, file).unwrap();
}

/// Returns the mesh of each object, in order. All objects must be meshes.
fn meshes_of_objects(scene: &ImportedScene) -> Vec<&TriangleMesh> {
    let mesh = |(_, object)| match object {
        ObjectDescription::Shape { shape: ShapeDescription::Mesh(MeshDescription { path, .. }), .. } => {
            &*scene.assets.meshes[&path.value]
        }
        other => panic!("{other:?}"),
    };
    placed_objects(scene).into_iter().map(mesh).collect()
}

#[test]
fn area_lights_with_uniform_pictures_have_their_color() {
    let folder = tempfile::tempdir().unwrap();
    write_png(&folder.path().join("a.png"), &[[255, 0, 255]; 2]);
    let scene = import_text_in_folder(
        folder.path(),
        r#"<shape type="sphere"><emitter type="area"><texture name="radiance" type="bitmap">
          <string name="filename" value="a.png"/></texture></emitter></shape>"#,
    );
    let ObjectDescription::Shape { emission, .. } = placed_objects(&scene)[0].1 else { panic!() };
    assert_eq!(emission, Some(DVec3::new(1.0, 0.0, 1.0)));
}

#[test]
fn textures_keep_their_place_on_rectangles_with_flipped_normals() {
    let scene = import_text(
        r#"<shape type="rectangle"><boolean name="flip_normals" value="true"/><bsdf type="diffuse">
          <texture name="reflectance" type="checkerboard"><transform name="to_uv"><scale x="3" y="5"/></transform>
          </texture></bsdf></shape>"#,
    );
    let ObjectDescription::Shape { shape: ShapeDescription::Rectangle(rectangle), .. } = &placed_objects(&scene)[0].1
    else {
        panic!()
    };
    let RectangleDescription { corner, edge0, edge1 } = *rectangle;
    assert_eq!(edge0.cross(edge1).normalize(), DVec3::NEG_Z);
    let TextureKindDescription::Checker { uv_transform, .. } = &scene.description.textures[0].kind else { panic!() };
    assert_eq!(uv_transform.rotation_degrees, 0.0);
    // Mitsuba's (u, v) at (x, y) is ((x + 1) / 2, (y + 1) / 2), and the checkerboard has period 1.
    for uv in [DVec2::ZERO, DVec2::X, DVec2::new(0.25, 0.75)] {
        let position = corner + edge0 * uv.x + edge1 * uv.y;
        let expected = DVec2::new(3.0, 5.0) * (position.truncate() + 1.0);
        let found = uv_transform.scale * uv + uv_transform.offset;
        assert!((found - expected).length() < 1e-12, "{uv}: {found} instead of {expected}");
    }
}

#[test]
fn textures_on_inward_spheres_lie_by_longitude_and_latitude() {
    let scene = import_text(
        r#"<shape type="sphere"><boolean name="flip_normals" value="true"/><bsdf type="diffuse">
          <texture name="reflectance" type="checkerboard"/></bsdf></shape>"#,
    );
    let mesh = meshes_of_objects(&scene)[0];
    let texcoords = mesh.texcoords.as_ref().unwrap();
    for (position, uv) in mesh.positions.iter().zip(texcoords) {
        // Mitsuba's v is the angle from the z axis over π. Caustica's v is 1 minus Mitsuba's.
        let (phi, theta) = (std::f64::consts::TAU * uv.x, std::f64::consts::PI * (1.0 - uv.y));
        let (sin_phi, cos_phi) = libm::sincos(phi);
        let (sin_theta, cos_theta) = libm::sincos(theta);
        let expected = DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
        assert!((*position - expected).length() < 1e-12, "{uv}: {position} instead of {expected}");
    }
    // No triangle spans the seam, where u jumps from 1 to 0.
    for triangle in &mesh.triangles {
        let u = triangle.map(|v| texcoords[v as usize].x);
        let [low, high] = [u[0].min(u[1]).min(u[2]), u[0].max(u[1]).max(u[2])];
        assert!(high - low < 0.01, "{u:?}");
    }
    let TextureKindDescription::Checker { uv_transform, .. } = &scene.description.textures[0].kind else { panic!() };
    assert_eq!((uv_transform.scale, uv_transform.offset), (DVec2::new(2.0, -2.0), DVec2::new(0.0, 2.0)));
}

#[test]
fn textured_meshes_without_texcoords_get_mitsuba_defaults() {
    let folder = tempfile::tempdir().unwrap();
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\n";
    std::fs::write(folder.path().join("a.obj"), file).unwrap();
    let shape =
        |content: &str| format!("<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/>{content}</shape>");
    let flips = |value: &str| format!("<boolean name=\"flip_tex_coords\" value=\"{value}\"/>");
    let texture = r#"<bsdf type="diffuse"><texture name="reflectance" type="checkerboard"/></bsdf>"#;
    let scene = import_text_in_folder(
        folder.path(),
        &[shape(""), shape(&(flips("false") + texture)), shape(&(flips("true") + texture))].concat(),
    );
    let meshes = meshes_of_objects(&scene);
    assert_eq!(meshes[0].texcoords, None);
    // With flipped coordinates, Caustica's v is 1 minus Mitsuba's.
    for (mesh, [start, end]) in meshes[1..].iter().zip([[0.0, 1.0], [1.0, 0.0]]) {
        let expected = [DVec2::new(0.0, start), DVec2::new(1.0, start), DVec2::new(0.0, end)];
        let texcoords = mesh.texcoords.as_ref().unwrap();
        let found = mesh.triangles.iter().map(|triangle| triangle.map(|v| texcoords[v as usize]));
        assert_eq!(found.collect::<Vec<_>>(), [expected; 2]);
        let positions = mesh.triangles[1].map(|v| mesh.positions[v as usize]);
        assert_eq!(positions, [DVec3::X, DVec3::ZERO, DVec3::Z]);
    }
}

#[test]
fn named_bsdfs_cover_the_faces_of_their_obj_material() {
    let folder = tempfile::tempdir().unwrap();
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl WallPaint\nf 1 2 3\nusemtl Glass\nf 1 2 4\nf 1 3 4\n\
        usemtl other\nf 2 3 4\n";
    std::fs::write(folder.path().join("a.obj"), file).unwrap();
    let scene = import_text_in_folder(
        folder.path(),
        r#"<shape type="obj"><string name="filename" value="a.obj"/><bsdf type="dielectric" name="Glass"/>
          <bsdf type="plastic" name="WallPaint"/><bsdf type="difftrans" name="absent"/></shape>"#,
    );
    let counts: Vec<usize> = meshes_of_objects(&scene).iter().map(|mesh| mesh.triangles.len()).collect();
    assert_eq!(counts, [1, 2, 1]);
    let kinds: Vec<&MaterialKindDescription> = scene.description.materials.iter().map(|m| &m.value.kind).collect();
    assert!(
        matches!(
            kinds[..],
            [
                MaterialKindDescription::CoatedDiffuse(_),
                MaterialKindDescription::Dielectric(_),
                MaterialKindDescription::Diffuse(_)
            ]
        ),
        "{kinds:?}"
    );
    assert!(has_note(&scene, "faces without a BSDF of their name become diffuse gray"));
    assert!(has_note(&scene, "BSDFs without faces of their name are ignored"));
}
