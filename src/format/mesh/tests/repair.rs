//! Tests of mesh repair on meshes with known defects.

use super::super::normals::face_normal;
use super::super::{MeshRepairOptions, MeshReport};
use super::*;

fn all_mesh_repairs(mesh: &TriangleMesh) -> MeshRepairOptions {
    MeshRepairOptions {
        weld_tolerance: Some(MeshRepairOptions::DEFAULT_RELATIVE_WELD_TOLERANCE * mesh.bounds_diagonal()),
        removes_duplicates: true,
        removes_degenerates: true,
        orients_outward: true,
    }
}

#[track_caller]
fn repaired_mesh(mut broken: TriangleMesh, whole: &MeshReport) -> TriangleMesh {
    assert_ne!(broken.mesh_report(), *whole, "nothing is broken");
    let repair = all_mesh_repairs(&broken);
    broken.repair(&repair);
    let report = broken.mesh_report();
    // The repaired mesh may have its triangles in another order, so that the sums round
    // differently.
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
    assert!(near(report.area, whole.area) && near(report.volume.unwrap(), whole.volume.unwrap()), "{report:?}");
    let (area, volume, bounds_min, bounds_max) = (whole.area, whole.volume, whole.bounds_min, whole.bounds_max);
    assert_eq!(MeshReport { area, volume, bounds_min, bounds_max, ..report }, *whole);
    broken
}

#[test]
fn every_kind_of_defect_is_repaired() {
    for whole in [cube_mesh(), torus_mesh(12, 8), sphere_mesh(5)] {
        let report = whole.mesh_report();
        let mut turned = whole.clone();
        turned.triangles.iter_mut().step_by(3).for_each(|t| t.swap(0, 1));
        repaired_mesh(turned, &report);
        let mut inside_out = whole.clone();
        inside_out.reverse_orientation();
        assert!(inside_out.mesh_report().volume.unwrap() < 0.0);
        repaired_mesh(inside_out, &report);
        let mut split = whole.clone();
        for (i, t) in split.triangles.iter_mut().enumerate() {
            let shift = 1e-10 * (i % 3) as f64;
            split.positions.push(split.positions[t[0] as usize] + DVec3::splat(shift));
            t[0] = split.positions.len() as u32 - 1;
        }
        assert!(!split.mesh_report().is_closed);
        repaired_mesh(split, &report);
        let mut worn = whole.clone();
        let [a, b, c] = worn.triangles[5];
        worn.triangles.insert(2, [a, a, b]);
        worn.triangles.insert(0, [b, a, c]);
        worn.positions.push(DVec3::splat(9.0));
        // Add a degenerate triangle with its third corner on the line of an edge, if rounding
        // permits an exact position.
        let beyond = 2.0 * worn.positions[b as usize] - worn.positions[a as usize];
        if (beyond - worn.positions[b as usize]) == worn.positions[b as usize] - worn.positions[a as usize] {
            worn.positions.push(beyond);
            worn.triangles.push([a, b, worn.positions.len() as u32 - 1]);
        }
        repaired_mesh(worn, &report);
    }
}

#[test]
fn an_intact_mesh_stays_unchanged() {
    for mut whole in [cube_mesh(), torus_mesh(12, 8), sphere_mesh(4), moebius_band_mesh(9)] {
        whole.merge_equal_vertices();
        let before = whole.clone();
        let repair = all_mesh_repairs(&whole);
        assert_eq!(whole.repair(&repair), Default::default());
        assert_eq!(whole, before);
    }
}

#[test]
fn cavities_face_inward() {
    let shells = [(1.0, 1.0), (0.5, -1.0), (0.25, 1.0)];
    let mut nested = TriangleMesh::default();
    for (i, (size, _)) in shells.into_iter().enumerate() {
        let mut shell = scaled_and_translated_mesh(cube_mesh(), size, DVec3::splat(0.01));
        if i != 1 {
            shell.reverse_orientation();
        }
        nested = union_of_meshes(nested, &shell);
    }
    nested = union_of_meshes(nested, &scaled_and_translated_mesh(cube_mesh(), 1.0, DVec3::new(5.0, 0.0, 0.0)));
    nested.orient_outward();
    let volume: f64 = shells.iter().map(|(size, sign)| 8.0 * sign * size * size * size).sum();
    assert!((nested.mesh_report().volume.unwrap() - volume - 8.0).abs() < 1e-12);
    // A shell of another material is not a hollow of the first.
    let mut other = union_of_meshes(cube_mesh(), &scaled_and_translated_mesh(cube_mesh(), 0.5, DVec3::ZERO));
    other.materials = vec!["a".to_owned(), "b".to_owned()];
    other.triangle_materials = [[0; 12], [1; 12]].concat();
    other.orient_outward();
    assert!((other.mesh_report().volume.unwrap() - 9.0).abs() < 1e-12);
}

#[test]
fn open_surfaces_keep_the_majority_orientation() {
    let mut open = cube_mesh();
    open.reverse_orientation();
    open.triangles.truncate(10);
    open.triangles[4].swap(0, 1);
    let turned = open.orient_outward();
    assert_eq!((turned, open.mesh_report().inconsistent_edges), (1, 0));
    let mut one_sided = moebius_band_mesh(9);
    let before = one_sided.clone();
    assert_eq!(one_sided.orient_outward(), 0);
    assert_eq!(one_sided.triangles, before.triangles);
}

#[test]
fn only_wrong_normals_are_flipped() {
    let mut right = sphere_mesh(3);
    right.compute_missing_smooth_normals(180.0);
    let mut wound = right.clone();
    wound.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_eq!(wound.orient_outward(), right.triangles.len());
    for (t, p) in wound.triangles.iter().zip(&right.triangles) {
        assert!(face_normal(&wound, *t).dot(face_normal(&right, *p)) > 0.999);
    }
    let sides = |mesh: &TriangleMesh| {
        let normals = mesh.normals.clone().unwrap();
        mesh.positions.iter().zip(normals).all(|(p, n)| p.dot(n) > 0.0)
    };
    assert!(sides(&wound));
    let mut flipped = right.clone();
    flipped.reverse_orientation();
    flipped.orient_outward();
    assert!(sides(&flipped) && flipped.positions.len() == right.positions.len());
}

#[test]
fn welding_keeps_the_first_vertex_in_range() {
    let points = [[0.0; 3], [0.9, 0.0, 0.0], [1.8, 0.0, 0.0], [1.8, 5.0, 0.0]];
    let mut row = triangle_mesh(&points, &[[0, 1, 3], [1, 2, 3]]);
    assert_eq!(row.weld_vertices(1.0), 1);
    assert_eq!(row.positions, [[0.0; 3], [1.8, 5.0, 0.0], [1.8, 0.0, 0.0]].map(DVec3::from_array));
    assert_eq!(row.triangles, [[0, 0, 1], [0, 2, 1]]);
    let mut far = scaled_and_translated_mesh(cube_mesh(), 1e100, DVec3::ZERO);
    assert_eq!((far.weld_vertices(0.0), far.weld_vertices(1e-300)), (0, 0));
    assert_eq!(far.weld_vertices(f64::MAX), 7);
}

#[test]
fn a_degenerate_triangle_that_closes_a_slit_stays() {
    // Vertex 3 lies on the edge 0–1 of the first face. The degenerate face (0, 3, 1) joins this
    // edge to the edges 0–3 and 3–1 of the other faces; without it, the mesh would have a slit.
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, -1.0, 0.0]];
    let mut slit = triangle_mesh(&points, &[[0, 1, 2], [0, 4, 3], [3, 4, 1], [0, 3, 1]]);
    let before = slit.mesh_report();
    let repair = all_mesh_repairs(&slit);
    assert_eq!((slit.repair(&repair).removed_degenerates, before.boundary_edges), (0, 4));
    assert_eq!(slit.mesh_report(), before);
}

#[test]
fn triangles_keep_their_materials() {
    let mut cube = cube_mesh();
    cube.materials = ["a", "b", "c"].map(str::to_owned).to_vec();
    cube.triangle_materials = (0..12).map(|t| [0, 1, 2, super::super::NO_MATERIAL][t / 3]).collect();
    cube.triangles[3] = [0, 0, 1];
    cube.triangles[4] = cube.triangles[0];
    cube.triangles[5] = [1, 1, 1];
    cube.repair(&MeshRepairOptions {
        removes_duplicates: true,
        removes_degenerates: true,
        ..MeshRepairOptions::default()
    });
    assert_eq!(cube.materials, ["a", "c"]);
    assert_eq!(cube.triangle_materials, [[0; 3], [1; 3], [super::super::NO_MATERIAL; 3]].concat());
    let parts: Vec<(u32, usize)> =
        cube.split_by_material().iter().map(|(m, part)| (*m, part.triangles.len())).collect();
    assert_eq!(parts, [(0, 3), (1, 3), (super::super::NO_MATERIAL, 3)]);
}
