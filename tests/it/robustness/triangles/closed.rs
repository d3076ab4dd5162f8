//! Closed meshes, and points inside them.

use glam::{Quat, Vec3};
use rand::RngExt;
use rand::rngs::SmallRng;
use std::collections::HashMap;
use std::f32::consts::TAU;

/// A triangle mesh without a boundary. Its triangles are counter-clockwise seen from outside.
pub struct ClosedMesh {
    pub name: &'static str,
    pub vertices: Vec<Vec3>,
    pub faces: Vec<[u32; 3]>,
    /// Samples a point that is well inside the mesh.
    pub inside: fn(&mut SmallRng) -> Vec3,
}

impl ClosedMesh {
    /// Returns the corners of each triangle, mapped by `map`.
    pub fn corners(&self, map: impl Fn(Vec3) -> Vec3) -> Vec<[Vec3; 3]> {
        let placed: Vec<Vec3> = self.vertices.iter().map(|v| map(*v)).collect();
        self.faces.iter().map(|f| f.map(|i| placed[i as usize])).collect()
    }
}

/// Samples a point in \[−1, 1]³.
pub fn point(rng: &mut SmallRng) -> Vec3 {
    Vec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0
}

pub fn cube() -> ClosedMesh {
    let vertices =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ClosedMesh { name: "cube", vertices, faces, inside: |rng| point(rng) * 0.9 }
}

/// Returns a cube rotated so that no face is perpendicular to an axis.
pub fn turned_cube() -> ClosedMesh {
    let turn = Quat::from_xyzw(0.1, 0.5, -0.3, 0.8).normalize();
    let ClosedMesh { vertices, faces, .. } = cube();
    let vertices = vertices.into_iter().map(|v| turn * v).collect();
    ClosedMesh { name: "turned cube", vertices, faces, inside: |rng| point(rng) * 0.5 }
}

/// Returns a sphere: an octahedron whose faces are split in four `levels` times, projected to the
/// unit sphere.
pub fn sphere_mesh(levels: u32) -> ClosedMesh {
    let mut vertices = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let cut = |&[a, b, c]: &[u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(cut).collect();
    }
    ClosedMesh { name: "globe", vertices, faces, inside: |rng| point(rng) * 0.5 }
}

/// Returns a closed grid on a torus of radii 1 and .4.
pub fn torus_mesh(n: u32, m: u32) -> ClosedMesh {
    let turn = |i: u32, n: u32| libm::sincosf(TAU * i as f32 / n as f32);
    let place = |i: u32, j: u32| {
        let ((s, c), (h, r)) = (turn(i, n), turn(j, m));
        Vec3::new(c * (1.0 + 0.4 * r), s * (1.0 + 0.4 * r), 0.4 * h)
    };
    let cells = || (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let at = |i: u32, j: u32| i % n * m + j % m;
    let faces = cells().flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let inside = |rng: &mut SmallRng| {
        let (s, c) = libm::sincosf(rng.random_range(0.0..TAU));
        Vec3::new(c, s, 0.0) + point(rng) * 0.1
    };
    ClosedMesh { name: "torus", vertices: cells().map(|(i, j)| place(i, j)).collect(), faces: faces.collect(), inside }
}

/// Returns a cone around z. From ring to ring, its size grows tenfold, from 10⁻⁶ to 10⁶.
///
/// So adjacent triangles differ in size, and all sizes span twelve orders of magnitude.
pub fn growing_cone() -> ClosedMesh {
    const SIDES: u32 = 12;
    let rings = -6..=6;
    let mut vertices = vec![Vec3::ZERO];
    for k in rings.clone() {
        let r = libm::powf(10.0, k as f32);
        let on = |i| libm::sincosf(TAU * i as f32 / SIDES as f32);
        vertices.extend((0..SIDES).map(on).map(|(s, c)| Vec3::new(c, s, 1.0) * r));
    }
    vertices.push(Vec3::new(0.0, 0.0, 1e6));
    let last = rings.count() as u32 - 1;
    let at = |ring: u32, i: u32| 1 + ring * SIDES + i % SIDES;
    let end = vertices.len() as u32 - 1;
    let mut faces = Vec::new();
    for i in 0..SIDES {
        faces.extend([[0, at(0, i + 1), at(0, i)], [end, at(last, i), at(last, i + 1)]]);
        for ring in 0..last {
            let [a, b, c, d] = [at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    let inside = |rng: &mut SmallRng| {
        let z = libm::powf(10.0, rng.random_range(-5.5..5.5));
        Vec3::new(0.4 * point(rng).x, 0.4 * point(rng).y, 1.0) * z
    };
    ClosedMesh { name: "horn", vertices, faces, inside }
}
