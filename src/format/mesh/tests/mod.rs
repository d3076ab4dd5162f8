//! Tests of mesh processing, on meshes with known properties.

mod files;
mod normals;
mod repair;
mod report;

use super::TriangleMesh;
use glam::DVec3;
use std::f64::consts::TAU;

fn triangle_mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriangleMesh {
    TriangleMesh {
        positions: positions.iter().copied().map(DVec3::from_array).collect(),
        triangles: triangles.to_vec(),
        ..TriangleMesh::default()
    }
}

fn tetrahedron_mesh() -> TriangleMesh {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    triangle_mesh(&points, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

/// Cube from −1 to 1.
fn cube_mesh() -> TriangleMesh {
    let points: Vec<[f64; 3]> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| f64::from(2 * bit - 1))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    triangle_mesh(&points, &triangles)
}

/// Torus of `n` by `m` quads around the z axis, each divided into two triangles.
fn torus_mesh(n: u32, m: u32) -> TriangleMesh {
    let circle = |i: u32, n: u32| libm::sincos(TAU * f64::from(i) / f64::from(n));
    let point = |i: u32, j: u32| {
        let ((s, c), (t, d)) = (circle(i, n), circle(j, m));
        [(2.0 + d) * c, (2.0 + d) * s, t]
    };
    let points: Vec<[f64; 3]> = (0..n).flat_map(|i| (0..m).map(move |j| point(i, j))).collect();
    let k = |i: u32, j: u32| i % n * m + j % m;
    let quad = |i, j| [k(i, j), k(i + 1, j), k(i + 1, j + 1), k(i, j + 1)];
    let quads = (0..n).flat_map(|i| (0..m).map(move |j| quad(i, j)));
    triangle_mesh(&points, &quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect::<Vec<_>>())
}

/// Moebius band of `n` quads.
fn moebius_band_mesh(n: u32) -> TriangleMesh {
    let point = |i: u32, side: f64| {
        let angle = TAU * f64::from(i) / f64::from(n);
        let ((s, c), (t, d)) = (libm::sincos(angle), libm::sincos(0.5 * angle));
        let radius = 2.0 + side * d;
        [radius * c, radius * s, side * t]
    };
    let points: Vec<[f64; 3]> = (0..n).flat_map(|i| [point(i, 0.5), point(i, -0.5)]).collect();
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (1, 0) };
            [[a, b, c], [b, d, c]]
        })
        .collect();
    triangle_mesh(&points, &triangles)
}

/// Unit sphere: a cube with faces of `n` by `n` quads, projected.
fn sphere_mesh(n: u32) -> TriangleMesh {
    let mut ball = TriangleMesh::default();
    let cube = cube_mesh();
    for face in cube.triangles.chunks(2) {
        let [a, b, c] = face[0].map(|v| cube.positions[v as usize]);
        let base = ball.positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                ball.positions.push((a + (b - a) * u + (c - b) * v).normalize());
                if i < n && j < n {
                    let p = base + i * (n + 1) + j;
                    let [q, r, s] = [p + n + 1, p + n + 2, p + 1];
                    ball.triangles.extend([[p, q, r], [p, r, s]]);
                }
            }
        }
    }
    // The edges of neighbouring faces differ by rounding.
    ball.weld_vertices(1e-12);
    ball
}

/// Returns a mesh of the triangles of both meshes.
fn union_of_meshes(mut a: TriangleMesh, b: &TriangleMesh) -> TriangleMesh {
    let base = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + base)));
    a
}

fn scaled_and_translated_mesh(mut mesh: TriangleMesh, scale: f64, offset: DVec3) -> TriangleMesh {
    mesh.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
    mesh
}
