//! A hundred million rays at edges and corners of closed meshes hit the meshes.

use super::closed::{ClosedMesh, cube, growing_cone, sphere_mesh, torus_mesh, turned_cube};
use caustica::accel::Bvh;
use caustica::math::Ray;
use glam::Vec3;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Smallest number of rays that the test traces.
const RAYS: u64 = 100_000_000;

/// Returns how many of `rays` rays miss the mesh, although all should hit.
///
/// Targets are corners, middles of edges and other points on edges. Rounding to f32 moves most of
/// them slightly off their edge. From inside, every ray must hit. From outside a `convex` mesh,
/// every segment to a point inside must hit.
fn count_missed_rays(mesh: &ClosedMesh, convex: bool, map: impl Fn(Vec3) -> Vec3, rays: u64, seed: u64) -> u64 {
    let mut rng = SmallRng::seed_from_u64(seed);
    let corners = mesh.corners(&map);
    let tree = Bvh::build(&corners, &[]);
    let mut inside = Vec3::ZERO;
    let mut missed = 0;
    for i in 0..rays {
        if i % 32 == 0 {
            inside = map((mesh.inside)(&mut rng));
        }
        let [a, b, _] = corners[rng.random_range(0..corners.len())];
        let target = match i % 4 {
            0 => a,
            1 => (a + b) * 0.5,
            _ => a + (b - a) * rng.random::<f32>(),
        };
        let out = target - inside;
        let hit = match i % 8 {
            // Both queries are tested, because closest-hit and any-hit traverse the tree
            // differently.
            0 => tree.closest_hit(&Ray::new(inside, out), |_, _| None).is_some(),
            5 | 6 if convex => tree.occluded(&Ray::between_points(target + out * 0.25, inside), |_, _| false),
            _ => tree.occluded(&Ray::new(inside, out), |_, _| false),
        };
        missed += u64::from(!hit);
    }
    missed
}

/// No ray passes between triangles, for meshes of all sizes and places.
///
/// Triangles have sizes from 10⁻⁶ to 10⁶, are far from the origin, and are mixed in one mesh. Some
/// are slivers with aspect ratio 10⁵.
#[test]
#[ignore = "long: a hundred million rays"]
fn hundred_million_rays_pass_no_edge() {
    type Place = fn(Vec3) -> Vec3;
    const BESIDE: Vec3 = Vec3::new(1.0, -0.7, 0.4);
    let places: [Place; 6] = [
        |p| p,
        |p| p * 1e-6,
        |p| p * 1e6,
        |p| (p + 30.0 * BESIDE) * 1e-6,
        |p| p + 1e3 * BESIDE,
        |p| (p + 1e4 * BESIDE) * 1e6,
    ];
    let slivers: [Place; 2] = [|p| p * Vec3::new(1.0, 1.0, 1e5), |p| p * Vec3::new(1.0, 1e-5, 1.0)];
    let (box_, turned, ball, fine, ring) = (cube(), turned_cube(), sphere_mesh(2), sphere_mesh(5), torus_mesh(60, 30));
    let mut cases: Vec<(&ClosedMesh, bool, Place)> = Vec::new();
    for place in places {
        cases.extend([(&box_, true, place), (&turned, true, place), (&ball, true, place), (&ring, false, place)]);
    }
    cases.extend(slivers.iter().flat_map(|place| [(&box_, true, *place), (&ball, true, *place)]));
    cases.push((&fine, true, places[0]));
    let cone = growing_cone();
    // The cone is not tested from outside: from afar, the rounding error of a direction is wider
    // than its tip.
    cases.push((&cone, false, places[0]));
    const CHUNKS: u64 = 4;
    let each = RAYS.div_ceil(cases.len() as u64 * CHUNKS);
    let missed = (0..cases.len() as u64 * CHUNKS).into_par_iter().map(|i| {
        let (mesh, convex, place) = cases[(i / CHUNKS) as usize];
        let missed = count_missed_rays(mesh, convex, place, each, i);
        assert_eq!(missed, 0, "{} of case {}", mesh.name, i / CHUNKS);
        each
    });
    assert!(missed.sum::<u64>() >= RAYS);
}
