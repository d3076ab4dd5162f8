//! Rays that start where others end: on a surface, at an edge, or in a corner.

use super::closed::{ClosedMesh, cube, point, sphere_mesh, torus_mesh, turned_cube};
use caustica::accel::ShapeHit;
use caustica::accel::{Bvh, PrimitiveIndex};
use caustica::math::{Ray, Transform, offset_ray_origin, rotation_matrix};
use caustica::shape::{Mesh, Rectangle, Shape, SurfacePoint};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

struct Walls {
    mesh: Mesh,
    tree: Bvh,
}

impl Walls {
    fn new(closed: &ClosedMesh, map: impl Fn(Vec3) -> Vec3) -> Self {
        let positions: Vec<Vec3> = closed.vertices.iter().map(|v| map(*v)).collect();
        let mesh = Mesh { positions, triangles: closed.faces.clone(), ..Mesh::default() };
        Self { mesh, tree: Bvh::build(&closed.corners(map), &[]) }
    }

    fn closest_hit(&self, ray: &Ray) -> Option<(u32, SurfacePoint)> {
        let hit = self.tree.closest_hit(ray, |_, _| None)?;
        let PrimitiveIndex::Triangle(i) = hit.primitive else { return None };
        Some((i, self.mesh.surface_point(i as usize, Vec2::new(hit.u, hit.v))))
    }

    /// Returns a random point on an edge or at a corner of the mesh.
    fn target(&self, rng: &mut SmallRng) -> Vec3 {
        let [a, b, _] = self.mesh.corners(rng.random_range(0..self.mesh.triangles.len()));
        match rng.random_range(0..4) {
            0 => a,
            1 => (a + b) * 0.5,
            _ => a + (b - a) * rng.random::<f32>(),
        }
    }
}

fn leaving_ray(s: &SurfacePoint, d: Vec3) -> Ray {
    Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, d), d)
}

fn placements() -> Vec<fn(Vec3) -> Vec3> {
    const BESIDE: Vec3 = Vec3::new(30.0, -70.0, 40.0);
    vec![|p| p, |p| p * 1e-6, |p| p * 1e6, |p| (p + BESIDE) * 3.0]
}

fn walled_scene() -> [ClosedMesh; 4] {
    [cube(), turned_cube(), sphere_mesh(3), torus_mesh(40, 20)]
}

/// A ray that leaves a triangle never hits it again.
///
/// A ray that leaves towards the inside of a closed mesh hits the mesh. This holds even if it
/// starts within rounding of a right-angled edge or of a corner.
#[test]
fn rays_leaving_edge_inwards_do_not_escape() {
    let run = |(closed, map): (ClosedMesh, fn(Vec3) -> Vec3)| {
        let walls = Walls::new(&closed, map);
        let mut rng = SmallRng::seed_from_u64(3);
        let (mut left, mut lost, mut again) = (0, 0, 0);
        for _ in 0..100_000 {
            let from = map((closed.inside)(&mut rng));
            let to = walls.target(&mut rng) - from;
            let to = if rng.random() { to } else { to.normalize() };
            let Some((i, s)) = walls.closest_hit(&Ray::new(from, to)) else { continue };
            let d = map(point(&mut rng)) - map(Vec3::ZERO);
            let d = if d.dot(s.ng) > 0.0 { -d } else { d };
            left += 1;
            match walls.closest_hit(&leaving_ray(&s, d)) {
                None => lost += 1,
                Some((j, _)) => again += u32::from(i == j),
            }
            again += u32::from(walls.closest_hit(&leaving_ray(&s, -d)).is_some_and(|(j, _)| i == j));
        }
        assert!(left > 99_000, "{} {left}", closed.name);
        assert_eq!((lost, again), (0, 0), "{}: lost, hit again, of {left}", closed.name);
    };
    placements().into_par_iter().for_each(|map| walled_scene().into_iter().for_each(|closed| run((closed, map))));
}

/// Along a ray through the edges of a body, entries and exits alternate, and the last one is an
/// exit.
///
/// Bodies are convex. At a silhouette edge, the ray enters one face and leaves its neighbour at the
/// same `t`. The lower index wins.
#[test]
fn entries_and_exits_of_bodies_balance() {
    let run = |(closed, map): (ClosedMesh, fn(Vec3) -> Vec3)| {
        let walls = Walls::new(&closed, map);
        let mut rng = SmallRng::seed_from_u64(4);
        let mut crossings = 0;
        for _ in 0..100_000 {
            let inside = map((closed.inside)(&mut rng));
            let back = walls.target(&mut rng) - inside;
            let d = -back.normalize();
            let mut ray = Ray::new(inside + back * 20.0, d);
            let mut depth = 0;
            while let Some((_, s)) = walls.closest_hit(&ray) {
                depth += if d.dot(s.ng) < 0.0 { 1 } else { -1 };
                assert!(depth == 0 || depth == 1, "{}: inside {depth} times at {}", closed.name, s.p);
                ray = leaving_ray(&s, d);
                crossings += 1;
            }
            assert_eq!(depth, 0, "{} from {}", closed.name, ray.origin);
        }
        assert!(crossings > 199_000, "{} {crossings}", closed.name);
    };
    placements()
        .into_par_iter()
        .for_each(|map| walled_scene().into_iter().take(3).for_each(|closed| run((closed, map))));
}

/// Rays from the edges of a room of rectangles, axis-aligned and rotated, hit the room.
#[test]
fn rectangle_rooms_trap_rays_from_their_edges() {
    for turned in [0.0, 0.7] {
        let turn = rotation_matrix(DVec3::new(1.0, 2.0, 0.5).normalize(), turned);
        let map = Transform::new(DAffine3::from_mat3_translation(turn, DVec3::new(0.3, 0.1, 0.7))).unwrap();
        let (low, high) = (DVec3::new(-1.1, -0.9, -1.3), DVec3::new(1.2, 0.7, 0.8));
        let (x, y, z) = (DVec3::X * (high.x - low.x), DVec3::Y * (high.y - low.y), DVec3::Z * (high.z - low.z));
        let face = |at, e0, e1| Shape::Rectangle(Rectangle::new(at, e0, e1)).transformed(&map).unwrap();
        let faces = [
            face(low, z, x),
            face(low + y, x, z),
            face(low, y, z),
            face(low + x, z, y),
            face(low, x, y),
            face(low + z, y, x),
        ];
        let corner = |i: u32| low + x * f64::from(i & 1) + y * f64::from(i >> 1 & 1) + z * f64::from(i >> 2);
        let near = |ray: &Ray| {
            let hits = faces.iter().filter_map(|f| f.intersect(ray).map(|hit| (hit, f)));
            hits.min_by(|a, b| a.0.t.total_cmp(&b.0.t))
                .map(|(ShapeHit { t, shape_coords: uv }, f)| f.surface_point(ray, t, uv))
        };
        let mut rng = SmallRng::seed_from_u64(9);
        let (mut left, mut lost) = (0, 0);
        for _ in 0..200_000 {
            let i = rng.random_range(0..8u32);
            let (a, b) = (corner(i), corner(i ^ 1 << rng.random_range(0..3)));
            let target = map.transform_point(a + (b - a) * rng.random::<f64>()).as_vec3();
            let from = map.transform_point((low + high) * 0.5 + point(&mut rng).as_dvec3() * 0.5).as_vec3();
            // Skip rays that miss: at an edge, a ray may pass between two rectangles. They share no
            // vertices, so they touch only up to rounding.
            let Some(s) = near(&Ray::new(from, (target - from).normalize())) else { continue };
            let d = point(&mut rng);
            let d = if d.dot(s.ng) < 0.0 { -d } else { d };
            left += 1;
            lost += u32::from(near(&leaving_ray(&s, d)).is_none());
        }
        assert!(left > 190_000, "{left}");
        assert_eq!(lost, 0, "of {left}");
    }
}
