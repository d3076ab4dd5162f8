//! Tests that no ray leaves a closed mesh without a hit.

use super::meshes::{
    cube_vertices_and_faces, icosphere_vertices_and_faces, mesh_of_faces, random_point, torus_vertices_and_faces,
};
use super::miss_other_primitive;
use crate::accel::Bvh;
use crate::math::Ray;
use glam::Vec3;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

/// Number of rays that start inside a closed mesh but do not hit it, out of `rays` rays.
///
/// The rays are aimed at vertices, edges and faces of the mesh.
fn count_leaking_rays(
    vertices: &[Vec3],
    faces: &[[u32; 3]],
    inside: impl Fn(&mut SmallRng) -> Vec3,
    rays: usize,
    seed: u64,
) -> usize {
    let mut rng = SmallRng::seed_from_u64(seed);
    let tree = Bvh::build(&mesh_of_faces(vertices, faces), &[]);
    let mut origin = inside(&mut rng);
    let miss = |i: usize| {
        if i.is_multiple_of(64) {
            origin = inside(&mut rng);
        }
        let [a, b, c] = faces[rng.random_range(0..faces.len())].map(|i| vertices[i as usize]);
        let target = match i % 4 {
            0 => a,
            1 => a + (b - a) * rng.random::<f32>(),
            2 => (a + b) * 0.5,
            _ => a + (b - a) * (0.5 * rng.random::<f32>()) + (c - a) * (0.5 * rng.random::<f32>()),
        };
        let ray = Ray::new(origin, target - origin);
        let ray = if i % 8 < 4 { ray } else { Ray::new(origin, ray.direction.normalize()) };
        tree.closest_hit(&ray, miss_other_primitive).is_none() || !tree.occluded(&ray, |_, _| false)
    };
    (0..rays).map(miss).filter(|&m| m).count()
}

#[test]
fn closed_meshes_do_not_leak() {
    let (rays, seed) = (20_000, 6);
    let mut rng = SmallRng::seed_from_u64(seed);
    let mut total = 0;
    for offset in [0.0, 1.0, 30.0, 1e3, 1e5] {
        for scale in [1.0, 1e-6, 1e6] {
            let place = |vertices: &[Vec3]| -> Vec<Vec3> {
                vertices.iter().map(|v| (*v + Vec3::new(offset, -0.7 * offset, 0.4 * offset)) * scale).collect()
            };
            let map = |p: Vec3| (p + Vec3::new(offset, -0.7 * offset, 0.4 * offset)) * scale;
            let (v, f) = cube_vertices_and_faces();
            total += count_leaking_rays(&place(&v), &f, |r| map(random_point(r) * 0.9), rays, seed);
            let (v, f) = icosphere_vertices_and_faces(4);
            total += count_leaking_rays(&place(&v), &f, |r| map(random_point(r) * 0.5), rays, seed);
            let (v, f) = torus_vertices_and_faces(&mut rng, 90, 40, 0.02);
            let inside = |r: &mut SmallRng| {
                let (s, c) = libm::sincosf(r.random_range(0.0..std::f32::consts::TAU));
                map(Vec3::new(c, s, 0.0) + random_point(r) * 0.1)
            };
            total += count_leaking_rays(&place(&v), &f, inside, rays, seed);
        }
    }
    assert_eq!(total, 0);
}
