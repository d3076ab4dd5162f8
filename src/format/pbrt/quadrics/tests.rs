//! Tests of meshes of quadrics: areas and normals.

use super::*;
use crate::format::pbrt::files::PbrtSourceLocation;

fn quadric_mesh_of_numbers(kind: &str, numbers: &[(&str, &[f64])]) -> TriangleMesh {
    let place = PbrtSourceLocation { file: "test".into(), line: 1 };
    quadric_mesh(kind, &Parameters::of_numbers(place, numbers)).unwrap().unwrap()
}

fn mesh_area(mesh: &TriangleMesh) -> f64 {
    mesh.triangles.iter().map(|triangle| mesh.triangle_area(*triangle)).sum()
}

/// Compares the areas of meshes with the exact areas of the quadrics. Areas of meshes are smaller,
/// because their facets lie inside the curved surfaces.
#[test]
fn facets_have_the_area_of_their_surface() {
    let cases = [
        (
            quadric_mesh_of_numbers("sphere", &[("radius", &[2.0]), ("zmin", &[-1.0]), ("zmax", &[0.5])]),
            2.0 * PI * 2.0 * 1.5,
        ),
        (quadric_mesh_of_numbers("sphere", &[("phimax", &[90.0])]), PI),
        (quadric_mesh_of_numbers("cylinder", &[("radius", &[0.5]), ("zmax", &[3.0]), ("phimax", &[180.0])]), 2.0 * PI),
        (quadric_mesh_of_numbers("disk", &[("radius", &[2.0]), ("innerradius", &[1.0])]), 3.0 * PI),
        (quadric_mesh_of_numbers("cone", &[("radius", &[3.0]), ("height", &[4.0])]), PI * 3.0 * 5.0),
        // r = √z: the area is π/6 (5^(3/2) − 1).
        (quadric_mesh_of_numbers("paraboloid", &[]), PI / 6.0 * (5.0 * 5.0_f64.sqrt() - 1.0)),
    ];
    for (mesh, exact) in cases {
        let ratio = mesh_area(&mesh) / exact;
        assert!(ratio < 1.0 && ratio > 0.995, "{ratio}");
    }
}

/// Triangles face along their normals, and normals are perpendicular to the surface.
#[test]
fn normals_point_outwards() {
    for kind in ["sphere", "cylinder", "disk", "cone", "paraboloid", "hyperboloid"] {
        let mesh = quadric_mesh_of_numbers(kind, &[("phimax", &[270.0])]);
        let normals = mesh.normals.as_ref().unwrap();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let facet = (b - a).cross(c - a).normalize();
            let mean: DVec3 = triangle.iter().map(|i| normals[*i as usize] / 3.0).sum();
            assert!(facet.dot(mean) > 0.95, "{kind}: {facet} {mean}");
        }
        if kind == "sphere" {
            assert!(mesh.positions.iter().zip(normals).all(|(p, n)| p.abs_diff_eq(*n, 1e-12)));
        }
    }
    let line = quadric_mesh_of_numbers("hyperboloid", &[("p1", &[1.0, 0.0, 0.0]), ("p2", &[1.0, 0.0, 2.0])]);
    let tube = quadric_mesh_of_numbers("cylinder", &[("zmin", &[0.0]), ("zmax", &[2.0])]);
    assert!((mesh_area(&line) - mesh_area(&tube)).abs() < 1e-9);
}
