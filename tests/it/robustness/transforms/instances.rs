//! Instances under transforms of condition number 10⁸, and seen from afar.

use super::double_double::{Affine, DoubleDouble, DoubleDoubleVec};
use super::maps::maps;
use crate::robustness::triangles::closed::sphere_mesh;
use caustica::accel::ShapeHit;
use caustica::math::{Ray, Transform, offset_ray_origin, warp};
use caustica::shape::{Mesh, MeshInstance, MeshWithBvh, Shape};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::sync::Arc;

/// Returns three pairs for the entry and the exit of a line through the octahedron |x| + |y| + |z|
/// ≤ 1.
///
/// They are the ray parameters, the face normals, and the distances along the line to the next
/// face.
fn octahedron(o: DoubleDoubleVec, d: DoubleDoubleVec) -> ([DoubleDouble; 2], [DVec3; 2], [f64; 2]) {
    let mut ends = [DoubleDouble::from(-1e300), DoubleDouble::from(1e300)];
    let mut normals = [DVec3::ZERO; 2];
    let mut crossings = [Vec::new(), Vec::new()];
    for n in FACES {
        let slope = d.dot(n.into());
        let t = (DoubleDouble::ONE - o.dot(n.into())) / slope;
        crossings[usize::from(slope > DoubleDouble::ZERO)].push(t);
        if slope < DoubleDouble::ZERO && t > ends[0] {
            (ends[0], normals[0]) = (t, n);
        } else if slope > DoubleDouble::ZERO && t < ends[1] {
            (ends[1], normals[1]) = (t, n);
        }
    }
    let gap = |end: usize| {
        let mut off: Vec<f64> = crossings[end].iter().map(|t| (*t - ends[end]).value().abs()).collect();
        off.sort_by(f64::total_cmp);
        off.get(1).copied().unwrap_or(f64::INFINITY)
    };
    (ends, normals, [gap(0), gap(1)])
}

/// Hits of a mesh instance under transforms of condition number 10⁸ have the right distance and
/// normal.
///
/// The mesh is an octahedron, seen from within 10⁶ sizes. Near the mesh, rays round to f32 at up to
/// 4 times its size. The triangle test rounds as much again: together 16·2⁻²³ times 4 in object
/// space. `t` may have this error divided by |d·n|, plus its own rounding and the rounding of
/// transforms in f64.
#[test]
fn instance_hits_match_double_double_transforms() {
    let ball = sphere_mesh(0);
    let mesh = Mesh { positions: ball.vertices, triangles: ball.faces, ..Mesh::default() };
    let mesh = Arc::new(MeshWithBvh::new(mesh));
    maps().into_par_iter().for_each(|(name, map)| {
        let exact = Affine::from(map);
        let transform = Transform::new(map).unwrap();
        let instance = Shape::Instance(MeshInstance::new(Arc::clone(&mesh), transform));
        let size = map.matrix3.x_axis.length() + map.matrix3.y_axis.length() + map.matrix3.z_axis.length();
        let shrink = exact.inverse_rows().map(|r| r.value().length_squared()).iter().sum::<f64>().sqrt();
        let mut rng = SmallRng::seed_from_u64(5);
        let (mut hits, mut decided, mut doubtful) = (0, 0, 0);
        const RAYS: u32 = 10_000;
        for i in 0..RAYS {
            let mut place = || warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
            let target = transform.transform_point(place() * 0.6);
            let origin = match i % 3 {
                0 => transform.transform_point(place() * 3.0),
                1 => target + place() * (size * 2.0),
                _ => target + place() * (size * 1e5),
            };
            let origin = origin.as_vec3();
            let ray = Ray::new(origin, target.as_vec3() - origin);
            if ray.direction == Vec3::ZERO {
                continue;
            }
            let o = exact.point_back(origin.as_dvec3().into());
            let d = exact.back(ray.direction.as_dvec3().into());
            let (ends, normals, gaps) = octahedron(o, d);
            let [enter, leave] = ends.map(DoubleDouble::value);
            let blur = |end: usize| {
                let along = d.value().dot(normals[end].normalize()).abs();
                let world = origin.as_dvec3().length() + ends[end].value().abs() * f64::from(ray.direction.length());
                let noise = 64.0 * f64::from(f32::EPSILON) + 16.0 * f64::EPSILON * shrink * (world + size + 4.0);
                noise / along
            };
            let widest = blur(0).max(blur(1));
            if (leave - enter).abs() < 4.0 * widest || enter.abs() < widest || leave.abs() < widest {
                doubtful += 1;
                continue;
            }
            let end = usize::from(enter < 0.0);
            let expected = (enter < leave && leave > 0.0).then_some(ends[end].value());
            let found = instance.intersect(&ray);
            assert_eq!(found.is_some(), expected.is_some(), "{name} {ray:?}: {found:?} {expected:?}");
            assert_eq!(instance.occludes(&ray), found.is_some(), "{name} {ray:?}");
            let (Some(ShapeHit { t, shape_coords: uv }), Some(exactly)) = (found, expected) else { continue };
            hits += 1;
            let off = (f64::from(t) - exactly).abs();
            assert!(
                off <= blur(end) + 1.2e-7 * exactly,
                "{name} {ray:?}: {t} {exactly}, off by {off:e} of {:e}",
                blur(end)
            );
            let s = instance.surface_point(&ray, t, uv);
            // If two faces are closer than the rounding of the test, either may be reported.
            // Otherwise, the reported face must be the one that the ray hits.
            let sure = gaps[end] > 4.0 * blur(end);
            decided += u32::from(sure);
            let is_it = |n: &DVec3| {
                let normal = exact.normal((*n).into()).value().normalize();
                // The plane of the face is that of one of its corners. The point must lie in it
                // within its stated error along each axis.
                let corner = exact.point((DVec3::X * n.x).into());
                let height = normal.dot((DoubleDoubleVec::from(s.p.as_dvec3()) - corner).value()).abs();
                (s.ng.as_dvec3() - normal).length() < 2e-7 && height <= normal.abs().dot(s.position_error.as_dvec3())
            };
            let right = if sure { is_it(&normals[end]) } else { FACES.iter().any(is_it) };
            assert!(right, "{name} {ray:?}: {s:?}, of {:?}", normals[end]);
            let out = warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random()));
            let out = if out.dot(s.ng) < 0.0 { -out } else { out };
            let next = Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, out), out);
            assert!(instance.intersect(&next).is_none(), "{name} {ray:?}: hit again");
        }
        assert!(hits > RAYS / 10 && decided > hits / 2 && doubtful < RAYS / 2, "{name} {hits} {decided} {doubtful}");
    });
}

/// Normals of an octahedron's faces.
const FACES: [DVec3; 8] = [
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, -1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(-1.0, -1.0, -1.0),
];

/// Rays from inside an instance hit it, also at edges and corners.
#[test]
fn instances_leak_no_rays() {
    let closed = sphere_mesh(3);
    let positions = closed.vertices.clone();
    let mesh = Mesh { positions, triangles: closed.faces.clone(), ..Mesh::default() };
    let mesh = Arc::new(MeshWithBvh::new(mesh));
    let turn = maps()[2].1;
    for map in [turn, DAffine3::from_scale(DVec3::splat(1e-6)) * turn, DAffine3::from_scale(DVec3::splat(1e6)) * turn] {
        let transform = Transform::new(map).unwrap();
        let instance = Shape::Instance(MeshInstance::new(Arc::clone(&mesh), transform));
        let mut rng = SmallRng::seed_from_u64(6);
        for _ in 0..200_000 {
            let from = transform.transform_point((closed.inside)(&mut rng).as_dvec3()).as_vec3();
            let [a, b, _] = closed.faces[rng.random_range(0..closed.faces.len())].map(|i| closed.vertices[i as usize]);
            let target = transform.transform_point((a + (b - a) * rng.random::<f32>()).as_dvec3()).as_vec3();
            assert!(instance.occludes(&Ray::new(from, target - from)), "{from} {target}");
        }
    }
}
