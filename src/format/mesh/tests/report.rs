//! Reports of meshes against closed forms.

use super::super::SolidDefect;
use super::*;

#[track_caller]
fn assert_near(a: f64, b: f64) {
    // The values are sums of up to some thousand terms, which err by rounding.
    assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} is not {b}");
}

#[test]
fn closed_solids_have_their_area_volume_and_genus() {
    let report = cube_mesh().mesh_report();
    assert_near(report.area, 24.0);
    assert_near(report.volume.unwrap(), 8.0);
    assert_eq!((report.bounds_min, report.bounds_max), ([-1.0; 3], [1.0; 3]));
    assert_eq!((report.euler_characteristic, report.genus, report.components), (2, Some(0), 1));
    assert!(report.is_closed && report.is_manifold && report.is_orientable);
    let report = tetrahedron_mesh().mesh_report();
    assert_near(report.area, 1.5 + libm::sqrt(3.0) / 2.0);
    assert_near(report.volume.unwrap(), 1.0 / 6.0);
    assert_eq!((report.vertices, report.triangles, report.genus), (4, 4, Some(0)));
    let (n, m) = (40, 30);
    let report = torus_mesh(n, m).mesh_report();
    // The mesh is a torus whose two circles are regular polygons. Its volume is 2π² R r², times the
    // area of each polygon as a fraction of its circle.
    let inscribed = |n: u32| f64::from(n) / TAU * libm::sin(TAU / f64::from(n));
    let ring = 2.0 * libm::pow(std::f64::consts::PI, 2.0) * 2.0 * inscribed(n) * inscribed(m);
    // The two triangles of a quad are not coplanar: an error of second order in 1/(n m).
    assert!((report.volume.unwrap() - ring).abs() < 1e-3 * ring, "{:?} {ring}", report.volume);
    assert_eq!((report.euler_characteristic, report.genus), (0, Some(1)));
}

#[test]
fn open_and_one_sided_surfaces_are_reported() {
    let report = moebius_band_mesh(20).mesh_report();
    assert!(!report.is_orientable && !report.is_closed && report.is_manifold);
    // The band has one border, which runs around it twice.
    assert_eq!((report.boundary_edges, report.euler_characteristic, report.volume, report.genus), (40, 0, None, None));
    let mut open = cube_mesh();
    open.triangles.truncate(10);
    let report = open.mesh_report();
    assert_eq!((report.is_closed, report.boundary_edges, report.euler_characteristic), (false, 4, 1));
    assert_eq!(report.volume, None);
}

#[test]
fn defects_are_counted() {
    let mut odd = cube_mesh();
    odd.triangles[0].swap(1, 2);
    let report = odd.mesh_report();
    assert_eq!((report.inconsistent_edges, report.is_orientable, report.volume), (3, true, None));
    // The edge that two cubes share has four triangles. The surface is pinched nowhere else.
    let two = union_of_meshes(cube_mesh(), &scaled_and_translated_mesh(cube_mesh(), 1.0, DVec3::new(2.0, 2.0, 0.0)));
    let report = two.mesh_report();
    assert_eq!((report.non_manifold_edges, report.is_manifold, report.components, report.genus), (1, false, 1, None));
    assert_eq!((report.repeated_vertices, report.non_manifold_vertices), (2, 0));
    assert_near(report.volume.unwrap(), 16.0);
    // Two cubes that share a corner.
    let two = union_of_meshes(cube_mesh(), &scaled_and_translated_mesh(cube_mesh(), 1.0, DVec3::splat(2.0)));
    let report = two.mesh_report();
    assert_eq!((report.non_manifold_edges, report.non_manifold_vertices, report.components), (0, 1, 2));
    let mut worn = cube_mesh();
    worn.positions.push(DVec3::ZERO);
    worn.triangles.extend([[0, 0, 1], [3, 1, 0], [0, 3, 1]]);
    let report = worn.mesh_report();
    assert_eq!((report.isolated_vertices, report.degenerate_triangles, report.duplicate_triangles), (1, 1, 2));
}

#[test]
fn texture_seams_are_not_borders() {
    let mut seam = cube_mesh();
    seam.compute_missing_smooth_normals(30.0);
    assert_eq!(seam.positions.len(), 24);
    let report = seam.mesh_report();
    assert!(report.is_closed && report.has_normals);
    assert_eq!((report.genus, report.repeated_vertices), (Some(0), 0));
    // Vertices at 0 and at −0 have one position.
    let mut zeros = tetrahedron_mesh();
    zeros.positions.push(-DVec3::ZERO);
    zeros.triangles[0][0] = 4;
    assert!(zeros.mesh_report().is_closed);
}

#[test]
fn solid_meshes_have_no_defect() {
    assert_eq!(cube_mesh().solid_defect(), None);
    assert_eq!(tetrahedron_mesh().solid_defect(), None);
    assert_eq!(torus_mesh(8, 6).solid_defect(), None);
    assert_eq!(scaled_and_translated_mesh(cube_mesh(), 1e-3, DVec3::splat(1e4)).solid_defect(), None);
    // A hollow: the inner wall faces inward.
    let mut inner = scaled_and_translated_mesh(cube_mesh(), 0.5, DVec3::ZERO);
    inner.reverse_orientation();
    assert_eq!(union_of_meshes(cube_mesh(), &inner).solid_defect(), None);
}

#[test]
fn open_and_reversed_meshes_have_defects() {
    let mut open = cube_mesh();
    open.triangles.truncate(10);
    assert_eq!(open.solid_defect(), Some(SolidDefect::Open { boundary_edges: 4 }));
    let mut odd = cube_mesh();
    odd.triangles[0].swap(1, 2);
    assert_eq!(odd.solid_defect(), Some(SolidDefect::InconsistentWinding { edges: 3 }));
    let mut reversed = cube_mesh();
    reversed.reverse_orientation();
    assert_eq!(reversed.solid_defect(), Some(SolidDefect::InsideOut));
    // Shading normals decide the outer side, as in the renderer.
    reversed.compute_missing_smooth_normals(0.0);
    reversed.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert_eq!(reversed.solid_defect(), Some(SolidDefect::InsideOut));
}
