use super::*;
use crate::format::mesh;

fn load_obj_file(path: &Path) -> Result<TriangleMesh, MeshError> {
    mesh::load(path, &()).map(|loaded| loaded.mesh)
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read_obj_text(text: &str) -> Result<TriangleMesh, MeshError> {
    super::read(Path::new("a.obj"), text.into(), &(), None).map(|loaded| loaded.mesh)
}

fn read_mesh_text(text: &str) -> TriangleMesh {
    read_obj_text(&format!("{SQUARE}{text}")).unwrap()
}

#[track_caller]
fn assert_refused(text: &str, message: &str) {
    let error = read_obj_text(&format!("{SQUARE}{text}")).unwrap_err().to_string();
    assert!(error.contains(message), "`{message}` is not in `{error}`");
    assert!(error.contains("a.obj"));
}

#[test]
fn polygons_are_triangulated_as_fans() {
    let mesh = read_mesh_text("f 1 2 3 4");
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
    assert_eq!((mesh.normals, mesh.texcoords), (None, None));
    assert_eq!(read_mesh_text("v 0 .5 0 # w\nf 1 2 3 4 5").triangles.len(), 3);
    assert_eq!(read_mesh_text("f 1 2 \\\r\n 3 4").triangles.len(), 2);
    assert_eq!(read_mesh_text("f -4 -3 -2"), read_mesh_text("f 1 2 3"));
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let text = format!("{SQUARE}f 1 2 3 4");
    assert_eq!(read_obj_text(&format!("\u{feff}{text}")).unwrap(), read_obj_text(&text).unwrap());
}

#[test]
fn unsupported_obj_statements_are_skipped() {
    let odd = "mtllib none.mtl\n# C:\\\no \u{fffd}\ng a b\ns off\nl 1 2\np 1\ncurv 0 1 2\nvp 1\n";
    assert_eq!(read_mesh_text(&format!("{odd}f 1 2 3\n{odd}f 1 3 4")), read_mesh_text("f 1 2 3\nf 1 3 4"));
    assert_eq!(read_mesh_text("g a \\\nf \\\nv 9 9 9\nf 1 2 3"), read_mesh_text("f 1 2 3"));
    // The first vertex has a weight, and the second a colour. Both are ignored.
    let coloured = "v 0 0 0 2\nv 1 0 0 1 0 0\nv 0 1 0\nf 1 2 3";
    assert_eq!(read_obj_text(coloured).unwrap(), read_obj_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3").unwrap());
}

#[test]
fn only_bitwise_equal_vertices_are_merged() {
    let again = "v 0 0 0\nv 1 1 0\nv -0 0 0\n";
    assert_eq!(read_mesh_text(&format!("{again}f 1 2 3\nf 5 6 4")).positions.len(), 4);
    assert_eq!(read_mesh_text(&format!("{again}f 1 2 3\ng b\nf 5 6 4")).positions.len(), 4);
    // 0 and −0 have different bits, so vertices that differ in this sign stay separate.
    assert_eq!(read_mesh_text(&format!("{again}f 1 2 3\nf 7 3 4")).positions.len(), 5);
    // A vertex on a crease becomes two vertices, one for each of its two normals.
    let crease = read_mesh_text("vn 0 0 1\nvn 0 1 1\nf 1//1 2//1 3//1\nf 1//2 3//1 4//1");
    assert_eq!(crease.positions.len(), 5);
}

#[test]
fn normals_stay_with_their_faces() {
    // `tobj` alone would give the last face's normals to the first face's vertices.
    let mesh = read_mesh_text("vn 0 0 2\nf 1 2 3\nf 1//1 3//1 4//1");
    let normals = mesh.normals.unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(normals[..3], [DVec3::ZERO; 3]);
    assert_eq!(normals[3..], [DVec3::Z; 3]);
}

#[test]
fn zero_length_normals_make_faces_flat() {
    let normals = "vn 0 0 1\nvn 0 0 0\nvn 1e-200 0 0\nvn 1e300 0 0\n";
    assert_eq!(read_mesh_text(&format!("{normals}f 1//1 2//2 3//1\nf 1//1 3//3 4//1\nf 1//4 2//1 4//1")).normals, None);
    let mesh = read_mesh_text(&format!("{normals}f 1//1 2//1 3//1\nf 1//1 3//2 4//1"));
    let normals = mesh.normals.unwrap();
    for (triangle, normal) in mesh.triangles.iter().zip([DVec3::Z, DVec3::ZERO]) {
        assert!(triangle.iter().all(|&i| normals[i as usize] == normal));
    }
}

#[test]
fn texture_coordinates_are_read() {
    let mesh = read_mesh_text("vt 0 0\nvt 1 0 5\nvt .5\nf 1/1 2/2 3/3\nf 1 3 4");
    let texcoords = mesh.texcoords.unwrap();
    assert_eq!(texcoords[..3], [DVec2::ZERO, DVec2::X, DVec2::new(0.5, 0.0)]);
    assert_eq!(texcoords.len(), mesh.positions.len());
}

#[test]
fn invalid_lines_are_reported() {
    let remedy = "indices count from 1, or from -1 backwards";
    assert_refused("f 1 2 5", "a.obj:5: `5` names no vertex (4 stand before it)");
    assert_refused("f 1 2 5", remedy);
    for index in ["0", "-5", "9223372036854775807", "-9223372036854775808", "99999999999999999999", "x", "1.5"] {
        assert_refused(&format!("\nf 1 2 {index}"), "a.obj:6: ");
        assert_refused(&format!("f 1 2 {index}"), remedy);
        assert_refused(&format!("vn 0 0 1\nf 1//1 2//1 3//{index}"), "names no normal (1 stand before it)");
        assert_refused(&format!("vt 0 0\nf 1/1 2/1 3/{index}"), "names no texture coordinate");
    }
    for face in ["f", "f 1", "f 1 2", "f # 1 2 3"] {
        assert_refused(face, "a face needs at least 3");
    }
    for corner in ["/", "//1", "1/1/1/1"] {
        assert_refused(&format!("vn 0 0 1\nvt 0 0\nf {corner} 2 3"), "write v, v/vt, v//vn or v/vt/vn");
    }
    assert_refused("vn 0 0 1\nf 1//1 2//1 3", "write all corners of a face alike");
    for number in ["nan", "inf", "-1e999", "one"] {
        assert_refused(&format!("v 0 0 {number}"), &format!("a.obj:5: `{number}` is not a finite number"));
        assert_refused(&format!("vn 0 0 {number}"), "is not a finite number");
        assert_refused(&format!("vt 0 {number}"), "is not a finite number");
    }
    assert_refused("v 0 0", "`v` holds 2 numbers");
}

#[test]
fn a_file_without_faces_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    for text in ["", "l 1 2\n", "usemtl a\n"] {
        std::fs::write(&path, format!("{SQUARE}{text}")).unwrap();
        assert!(load_obj_file(&path).unwrap_err().to_string().contains("has no faces"));
    }
}

#[test]
fn usemtl_sets_the_material_of_later_faces() {
    let text = "mtllib a.mtl\nf 1 2 3\nusemtl red paint\nf 1 2 3\nusemtl b\nusemtl c#1\nf 1 2 3\nf 1 3 4\nusemtl red paint\n\
                f -1 -2 -3\nusemtl\nf 1 2 3\nmtllib b.mtl c.mtl\n";
    let loaded = super::read(Path::new("a.obj"), format!("{SQUARE}{text}").into(), &(), None).unwrap();
    assert_eq!(loaded.mtllib_arguments, ["a.mtl", "b.mtl c.mtl"]);
    assert_eq!(loaded.mesh.materials, ["red paint", "c#1"]);
    assert_eq!(loaded.mesh.triangle_materials, [NO_MATERIAL, 0, 1, 1, 0, NO_MATERIAL]);
    assert_eq!((loaded.file_vertex_count, loaded.isolated_vertex_count, loaded.mesh.positions.len()), (4, 0, 4));
    let plain = read_mesh_text("mtllib a.mtl\nf 1 2 3");
    assert!(plain.materials.is_empty() && plain.triangle_materials.is_empty());
}

#[test]
fn chunks_of_a_large_file_join_exactly() {
    let row = |i: usize, name: &str| format!("usemtl {name}\nv {i} 0 0\nv {i} 1 0\nv {i}.5 0 1\nf -3 -2 \\\n -1\n");
    // Chunks of 4 MB each; a material continues into the next chunk.
    let n = 200_000;
    let mut text: String = (0..n / 2).map(|i| row(i, "a")).collect();
    text.extend((n / 2..n).map(|i| row(i, "b").replace("usemtl b\n", if i == n / 2 { "usemtl b\n" } else { "" })));
    assert!(text.len() > 2 * (1 << 22));
    let mesh = read_obj_text(&text).unwrap();
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (n, 3 * n));
    assert!(mesh.triangles.iter().enumerate().all(|(i, t)| *t == [0, 1, 2].map(|k| 3 * i as u32 + k)));
    assert!(mesh.triangle_materials.iter().enumerate().all(|(i, m)| *m == u32::from(i >= n / 2)));
    let lines = text.lines().count();
    let error = read_obj_text(&format!("{text}f 1 2 0\n")).unwrap_err().to_string();
    assert!(error.starts_with(&format!("a.obj:{}: ", lines + 1)), "{error}");
}

#[test]
fn unreadable_files_are_reported_by_path() {
    let folder = tempfile::tempdir().unwrap();
    let missing = load_obj_file(&folder.path().join("none.obj")).unwrap_err();
    assert!(matches!(missing, MeshError::MissingMeshFile { .. }) && missing.to_string().contains("none.obj"));
    assert!(matches!(load_obj_file(folder.path()).unwrap_err(), MeshError::Unreadable { .. }));
    let latin = folder.path().join("latin.obj");
    std::fs::write(&latin, [b"# caf\xe9\n", SQUARE.as_bytes(), b"f 1 2 3"].concat()).unwrap();
    assert_eq!(load_obj_file(&latin).unwrap().triangles.len(), 1);
}

proptest::proptest! {
    #[test]
    fn random_text_never_panics_the_reader(words in proptest::collection::vec("v|vt|vn|f|g|\n|\\\\|#|-?[0-9]{1,2}|[0-9]/[0-9]?/-?[0-9]|nan|.{0,3}", 0..60)) {
        let _ = read_obj_text(&format!("{SQUARE}vn 0 0 1\nvt 0 0\n{}", words.join(" ")));
    }
}
