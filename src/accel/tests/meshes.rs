//! Meshes, random points and random directions for the tests of the hierarchy.

use crate::math::{Bounds, warp};
use glam::{Vec2, Vec3};
use rand::RngExt;
use rand::rngs::SmallRng;
use std::collections::HashMap;

pub(super) type Mesh = Vec<[Vec3; 3]>;

/// Uniform random point of the cube \[−1, 1]³.
pub(super) fn random_point(rng: &mut SmallRng) -> Vec3 {
    Vec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0
}

pub(super) fn random_direction(rng: &mut SmallRng) -> Vec3 {
    warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random()))
}

/// Mesh of `count` separate random triangles. The components of two edges of each triangle are at
/// most `size`; those of the third edge are at most 2·`size`.
pub(super) fn random_triangle_mesh(rng: &mut SmallRng, count: usize, size: f32) -> Mesh {
    (0..count)
        .map(|_| {
            let p = random_point(rng);
            [p, p + random_point(rng) * size, p + random_point(rng) * size]
        })
        .collect()
}

/// Triangles whose corners are given by `faces` as indices into `vertices`.
pub(super) fn mesh_of_faces(vertices: &[Vec3], faces: &[[u32; 3]]) -> Mesh {
    faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
}

/// Icosahedron whose triangles are divided into four, `levels` times, with all vertices on the unit
/// sphere.
pub(super) fn icosphere_vertices_and_faces(levels: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let g = 0.5 + 1.25f32.sqrt();
    let mut vertices: Vec<Vec3> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        vertices.extend([Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)].map(Vec3::normalize));
    }
    // Faces are the triples of mutually nearest vertices: edges of the unit icosahedron have length
    // 1.05.
    let near = |i: usize, j: usize| vertices[i].distance(vertices[j]) < 1.1;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            faces.extend(
                (j + 1..12).filter(|&k| near(i, j) && near(j, k) && near(i, k)).map(|k| [i, j, k].map(|x| x as u32)),
            );
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    (vertices, faces)
}

/// Torus with the radii 1 and 0.4: a grid of `n` by `m` quads, each divided into two triangles.
///
/// Each coordinate of a vertex is displaced at random by at most `noise`.
pub(super) fn torus_vertices_and_faces(rng: &mut SmallRng, n: u32, m: u32, noise: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let turn = |i: u32, n: u32| libm::sincosf(std::f32::consts::TAU * i as f32 / n as f32);
    let mut vertices = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let ((s, c), (h, r)) = (turn(i, n), turn(j, m));
            vertices.push(Vec3::new(c * (1.0 + 0.4 * r), s * (1.0 + 0.4 * r), 0.4 * h) + random_point(rng) * noise);
        }
    }
    let at = |i: u32, j: u32| i % n * m + j % m;
    let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let faces = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    (vertices, faces.collect())
}

/// Surface of the cube \[−1, 1]³, as eight vertices and twelve triangles.
pub(super) fn cube_vertices_and_faces() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let vertices = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE }.corners().to_vec();
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    (vertices, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}
