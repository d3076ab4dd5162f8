//! Meshes that are placed by maps of condition number 10⁸, and from afar.

use super::dd::{Affine, Dd, Dd3};
use super::maps::maps;
use crate::triangles::closed::globe;
use caustica::math::{Ray, Transform, offset_origin, warp};
use caustica::shape::{IndexedMesh, Instance, Mesh, Shape};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::sync::Arc;

/// Where a line enters |x| + |y| + |z| ≤ 1 and leaves it, each with the face's normal and how much later the next face is.
fn octahedron(o: Dd3, d: Dd3) -> ([Dd; 2], [DVec3; 2]) {
    let mut ends = [Dd::from(-1e300), Dd::from(1e300)];
    let mut normals = [DVec3::ZERO; 2];
    for i in 0..8 {
        let side = |bit: i32| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let n = DVec3::new(side(0), side(1), side(2));
        let slope = d.dot(n.into());
        let t = (Dd::ONE - o.dot(n.into())) / slope;
        if slope < Dd::ZERO && t > ends[0] {
            (ends[0], normals[0]) = (t, n);
        } else if slope > Dd::ZERO && t < ends[1] {
            (ends[1], normals[1]) = (t, n);
        }
    }
    (ends, normals)
}

/// An octahedron of triangles under maps of condition number 10⁸, seen from within 10⁶ sizes, is met where it is.
///
/// Rays are rounded to f32 where they come near the mesh, within 4 of its sizes, and the triangle's test rounds as much again: 16·2⁻²³ times
/// 4 in object space. That is what `t` may be off over |d·n|, beside the rounding of `t` itself and of f64 on the way there.
#[test]
fn instances_are_met_where_maps_put_them() {
    let ball = globe(0);
    let mesh = Mesh { positions: ball.vertices, triangles: ball.faces, ..Mesh::default() };
    let mesh = Arc::new(IndexedMesh::new(mesh));
    maps().into_par_iter().for_each(|(name, map)| {
        let exact = Affine::from(map);
        let transform = Transform::new(map).unwrap();
        let instance = Shape::Instance(Instance::new(Arc::clone(&mesh), transform));
        let size = map.matrix3.x_axis.length() + map.matrix3.y_axis.length() + map.matrix3.z_axis.length();
        let shrink = exact.inverse_rows().map(|r| r.value().length_squared()).iter().sum::<f64>().sqrt();
        let mut rng = SmallRng::seed_from_u64(5);
        let (mut hits, mut doubtful) = (0, 0);
        const RAYS: u32 = 10_000;
        for i in 0..RAYS {
            let mut place = || warp::sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
            let target = transform.point(place() * 0.6);
            let origin = match i % 3 {
                0 => transform.point(place() * 3.0),
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
            let (ends, normals) = octahedron(o, d);
            let [enter, leave] = ends.map(Dd::value);
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
            let (Some((t, u, v)), Some(exactly)) = (found, expected) else { continue };
            hits += 1;
            let off = (f64::from(t) - exactly).abs();
            assert!(
                off <= blur(end) + 1.2e-7 * exactly,
                "{name} {ray:?}: {t} {exactly}, off by {off:e} of {:e}",
                blur(end)
            );
            let s = instance.surface(&ray, t, Vec2::new(u, v));
            // One of the faces near there, by its exact normal: the mesh is convex, so the place on it tells which.
            let told = exact_faces(&exact).iter().map(|n| s.ng.as_dvec3().cross(*n).length()).fold(1.0, f64::min);
            assert!(told < 2e-7, "{name} {ray:?}: turned by {told:e}");
            let out = warp::sphere(Vec2::new(rng.random(), rng.random()));
            let out = if out.dot(s.ng) < 0.0 { -out } else { out };
            let next = Ray::new(offset_origin(s.p, s.error, s.ng, out), out);
            assert!(instance.intersect(&next).is_none(), "{name} {ray:?}: met again");
        }
        assert!(hits > RAYS / 10 && doubtful < RAYS / 2, "{name} {hits} {doubtful}");
    });
}

/// Unit normals of an octahedron's faces under a map.
fn exact_faces(exact: &Affine) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let side = |bit: usize| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
        exact.normal(DVec3::new(side(0), side(1), side(2)).into()).value().normalize()
    })
}

/// Rays from inside a mesh that is placed hit it, at edges and corners too.
#[test]
fn instances_do_not_leak() {
    let closed = globe(3);
    let positions = closed.vertices.clone();
    let mesh = Mesh { positions, triangles: closed.faces.clone(), ..Mesh::default() };
    let mesh = Arc::new(IndexedMesh::new(mesh));
    let turn = maps()[2].1;
    for map in [turn, DAffine3::from_scale(DVec3::splat(1e-6)) * turn, DAffine3::from_scale(DVec3::splat(1e6)) * turn] {
        let transform = Transform::new(map).unwrap();
        let instance = Shape::Instance(Instance::new(Arc::clone(&mesh), transform));
        let mut rng = SmallRng::seed_from_u64(6);
        for _ in 0..200_000 {
            let from = transform.point((closed.inside)(&mut rng).as_dvec3()).as_vec3();
            let [a, b, _] = closed.faces[rng.random_range(0..closed.faces.len())].map(|i| closed.vertices[i as usize]);
            let target = transform.point((a + (b - a) * rng.random::<f32>()).as_dvec3()).as_vec3();
            assert!(instance.occludes(&Ray::new(from, target - from)), "{from} {target}");
        }
    }
}
