//! Tests of mesh files: written meshes read back bit for bit.

use super::super::{LoadedMesh, MeshFormat, NO_MATERIAL, load, unit_normal};
use super::*;
use glam::DVec2;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use std::path::Path;

const FORMS: [(MeshFormat, &str); 3] =
    [(MeshFormat::Obj, "a.obj"), (MeshFormat::PlyBinary, "b.ply"), (MeshFormat::PlyText, "c.PLY")];

fn any_finite_number() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let any = POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO;
    prop_oneof![any, any.prop_map(|x| f64::from(x as f32)).prop_filter("finite", |x| x.is_finite()), -9.0..9.0]
}

fn any_point() -> impl Strategy<Value = DVec3> {
    [any_finite_number(), any_finite_number(), any_finite_number()].prop_map(DVec3::from_array)
}

/// Any mesh that a reader could return: each triangle has normals at all corners or at none.
fn any_mesh() -> impl Strategy<Value = TriangleMesh> {
    let single = any::<bool>();
    let shape = (1..12_usize, single).prop_flat_map(|(n, single)| {
        let round = move |p: DVec3| if single { p.as_vec3().as_dvec3() } else { p };
        let points = vec(any_point().prop_map(round), n).prop_filter("finite", |ps| ps.iter().all(|p| p.is_finite()));
        let normals = option::of(vec([-1.0..1.0, -1.0..1.0, -1.0..1.0], n));
        let texcoords = option::of(vec([any_finite_number(), any_finite_number()], n));
        let corner = 0..n as u32;
        let triangles = vec([corner.clone(), corner.clone(), corner], 1..12);
        (points, normals, texcoords, triangles, vec(0..3_u32, 12), any::<bool>())
    });
    shape.prop_map(|(positions, normals, texcoords, triangles, materials, made)| {
        let mut mesh = TriangleMesh { positions, triangles, ..TriangleMesh::default() };
        mesh.normals = normals.map(|list| {
            list.into_iter()
                .map(|n| if n[0] < -0.8 { DVec3::ZERO } else { unit_normal(DVec3::from_array(n)) })
                .collect()
        });
        mesh.texcoords = texcoords.map(|list| list.into_iter().map(DVec2::from_array).collect());
        if made {
            // Materials are numbered by first use, after the triangles without material.
            let mut sorted: Vec<u32> = materials[..mesh.triangles.len()].to_vec();
            sorted.sort_unstable();
            sorted.dedup();
            let place = |m: &u32| sorted.iter().position(|s| s == m).unwrap() as u32;
            let mut own: Vec<u32> = materials[..mesh.triangles.len()].iter().map(place).collect();
            own.sort_unstable();
            mesh.materials = sorted.iter().map(|m| format!("m {m}#")).collect();
            own[0] = if own.len() > 1 && own[1] == 0 { NO_MATERIAL } else { own[0] };
            mesh.triangle_materials = own;
        }
        mesh.merge_equal_vertices();
        mesh
    })
}

fn write_and_load(mesh: &TriangleMesh, folder: &Path, (form, name): (MeshFormat, &str)) -> LoadedMesh {
    let path = folder.join(name);
    assert_eq!(MeshFormat::from_path(&path, form == MeshFormat::PlyText), Some(form));
    mesh.write(&path, form, &["a b.mtl".to_owned()]).unwrap();
    load(&path, &()).unwrap()
}

fn bit_patterns_of_mesh(mesh: &TriangleMesh) -> Vec<u64> {
    let points = mesh.positions.iter().chain(mesh.normals.iter().flatten()).flat_map(|p| p.to_array());
    let texcoords = mesh.texcoords.iter().flatten().flat_map(|t| t.to_array());
    points.chain(texcoords).map(f64::to_bits).collect()
}

proptest! {
    #[test]
    fn meshes_read_back_bit_for_bit(mesh in any_mesh()) {
        let folder = tempfile::tempdir().unwrap();
        for form in FORMS {
            let read = write_and_load(&mesh, folder.path(), form);
            prop_assert_eq!(read.isolated_vertex_count, 0);
            let mut expected = mesh.clone();
            if form.0 == MeshFormat::Obj {
                prop_assert_eq!(&read.mtllib_arguments, &["a b.mtl"]);
            } else {
                (expected.materials, expected.triangle_materials) = (Vec::new(), Vec::new());
                prop_assert_eq!(read.file_vertex_count, mesh.positions.len());
            }
            prop_assert_eq!(bit_patterns_of_mesh(&read.mesh), bit_patterns_of_mesh(&expected));
            prop_assert_eq!(read.mesh, expected);
        }
    }
}

#[test]
fn ply_writes_single_precision_values_as_float() {
    let folder = tempfile::tempdir().unwrap();
    let long = torus_mesh(30, 20);
    let short =
        TriangleMesh { positions: long.positions.iter().map(|p| p.as_vec3().as_dvec3()).collect(), ..long.clone() };
    let size = |mesh: &TriangleMesh, name: &str| {
        write_and_load(mesh, folder.path(), (MeshFormat::PlyBinary, name));
        std::fs::metadata(folder.path().join(name)).unwrap().len()
    };
    // A single-precision file has four bytes less for each coordinate. Its header has `float`
    // instead of `double` in three lines, which is one letter less in each.
    assert_eq!(size(&long, "long.ply") - size(&short, "short.ply"), 600 * 3 * 4 + 3);
}

#[test]
fn the_report_counts_dropped_faces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 7 7 7\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\nf 4//2 5//2 3//2\n";
    std::fs::write(&path, text).unwrap();
    let loaded = load(&path, &()).unwrap();
    assert_eq!(
        (
            loaded.file_vertex_count,
            loaded.isolated_vertex_count,
            loaded.repeated_vertex_count(),
            loaded.mesh.positions.len()
        ),
        (6, 1, 1, 6)
    );
    let ply = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0 1 0 0 0 1 0 1 0 0 5 5 5\n4 0 1 2 3\n";
    std::fs::write(&path, ply).unwrap();
    let loaded = load(&path, &()).unwrap();
    assert_eq!(
        (
            loaded.file_vertex_count,
            loaded.isolated_vertex_count,
            loaded.repeated_vertex_count(),
            loaded.mesh.positions.len()
        ),
        (5, 1, 1, 3)
    );
}
