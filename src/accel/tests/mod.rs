//! Tests of the hierarchy against brute force and against f64.

mod leaks;
mod meshes;

use super::packet::TrianglePacket;
use super::ray_precalc::RayPrecalc;
use super::*;
use crate::math::warp;
use glam::{DVec3, Vec2};
use meshes::{Mesh, cube_vertices_and_faces, mesh_of_faces, random_direction, random_point, random_triangle_mesh};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

/// Intersection closure that reports no hit, for hierarchies of triangles only.
fn miss_other_primitive(_: u32, _: &Ray) -> Option<ShapeHit> {
    None
}

/// Nearest hit of a sphere by the quadratic formula in f64.
///
/// Returns t, and two arbitrary constants in place of u and v.
fn intersect_sphere(center: Vec3, radius: f32, ray: &Ray) -> Option<ShapeHit> {
    let (o, d) = ((ray.origin - center).as_dvec3(), ray.direction.as_dvec3());
    let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - f64::from(radius * radius));
    let root = (b * b - a * c).sqrt();
    let t = [(-b - root) / a, (-b + root) / a].map(|t| t as f32);
    t.into_iter().find(|&t| t > 0.0 && t < ray.t_max).map(|t| ShapeHit { t, shape_coords: Vec2::new(0.25, 0.75) })
}

/// Nearest hit of a ray, by testing every triangle and every sphere.
fn brute_force_hit(triangles: &Mesh, balls: &[(Vec3, f32)], ray: &Ray) -> Option<PrimitiveHit> {
    let precalc = RayPrecalc::new(ray);
    let solid = |i: u32| {
        let packet = TrianglePacket::new(triangles, &[i]);
        let hit = packet
            .intersect_lane(0, &precalc)
            .map(|hit| ShapeHit { t: hit.t * precalc.direction_scale, shape_coords: hit.barycentric().into() });
        (PrimitiveIndex::Triangle(i), hit)
    };
    let round = |i: u32| (PrimitiveIndex::Other(i), intersect_sphere(balls[i as usize].0, balls[i as usize].1, ray));
    (0..triangles.len() as u32)
        .map(solid)
        .chain((0..balls.len() as u32).map(round))
        .filter_map(|(primitive, hit)| {
            hit.map(|ShapeHit { t, shape_coords: uv }| PrimitiveHit { t, primitive, u: uv.x, v: uv.y })
        })
        .filter(|hit| 0.0 < hit.t && hit.t < ray.t_max)
        .min_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)))
}

/// Boxes around spheres, larger than needed by a factor that grows with the index.
///
/// The last of several equal spheres has the largest box, so a traversal visits it first.
fn boxes_around_spheres(balls: &[(Vec3, f32)]) -> Vec<Bounds> {
    let slack = |i: usize| 1.0 + i as f32 / balls.len() as f32 * 0.5;
    balls.iter().enumerate().map(|(i, &(c, r))| Bounds { min: c, max: c }.expanded(r * slack(i))).collect()
}

/// Asserts that nearest hit and occlusion agree with brute force, bit for bit, for all `rays`.
///
/// Returns the number of rays that hit, and the number of rays.
fn assert_agrees_with_brute_force(
    triangles: &Mesh,
    balls: &[(Vec3, f32)],
    rays: impl Iterator<Item = Ray>,
) -> (usize, usize) {
    let tree = Bvh::build(triangles, &boxes_around_spheres(balls));
    let (mut hits, mut total) = (0, 0);
    for ray in rays {
        let expected = brute_force_hit(triangles, balls, &ray);
        let solve = |i: u32, r: &Ray| intersect_sphere(balls[i as usize].0, balls[i as usize].1, r);
        assert_eq!(tree.closest_hit(&ray, solve), expected, "{ray:?}");
        assert_eq!(tree.occluded(&ray, |i, r| solve(i, r).is_some()), expected.is_some(), "{ray:?}");
        total += 1;
        hits += usize::from(expected.is_some());
    }
    (hits, total)
}

#[test]
fn empty_hierarchy_has_no_hit() {
    let tree = Bvh::build(&[], &[]);
    assert!(tree.bounds().is_empty());
    assert_eq!(tree.closest_hit(&Ray::new(Vec3::ZERO, Vec3::X), miss_other_primitive), None);
    assert!(!tree.occluded(&Ray::new(Vec3::ZERO, Vec3::X), |_, _| true));
    let tree = Bvh::build(&[], &[Bounds::EMPTY]);
    assert!(!tree.occluded(&Ray::new(Vec3::ZERO, Vec3::X), |_, _| true));
}

#[test]
fn rays_with_invalid_origin_or_direction_hit_nothing() {
    let (v, f) = cube_vertices_and_faces();
    let tree = Bvh::build(&mesh_of_faces(&v, &f), &[]);
    for ray in [
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::ZERO, Vec3::splat(f32::NAN)),
        Ray::new(Vec3::ZERO, Vec3::splat(f32::INFINITY)),
        Ray::new(Vec3::splat(f32::NAN), Vec3::X),
        Ray { t_max: f32::NAN, ..Ray::new(Vec3::ZERO, Vec3::X) },
        Ray { t_max: -1.0, ..Ray::new(Vec3::ZERO, Vec3::X) },
    ] {
        assert_eq!(tree.closest_hit(&ray, miss_other_primitive), None);
    }
}

#[test]
fn triangle_soups_agree_with_brute_force() {
    let mut rng = SmallRng::seed_from_u64(1);
    for (count, size, spheres) in
        [(1, 1.0, 0), (3, 1.0, 1), (9, 0.7, 4), (60, 0.5, 0), (500, 0.2, 40), (3000, 0.05, 3), (0, 0.0, 17)]
    {
        let triangles = random_triangle_mesh(&mut rng, count, size);
        let balls: Vec<(Vec3, f32)> =
            (0..spheres).map(|_| (random_point(&mut rng), rng.random_range(0.0..0.3))).collect();
        let rays: Vec<Ray> = (0..1500)
            .map(|i| {
                let length = [1.0, 1e-20, 3e15][i % 3];
                let t_max = if i % 2 == 0 { f32::INFINITY } else { rng.random_range(0.0..1.5) / length };
                Ray { origin: random_point(&mut rng) * 1.5, direction: random_direction(&mut rng) * length, t_max }
            })
            .collect();
        let (hits, total) = assert_agrees_with_brute_force(&triangles, &balls, rays.into_iter());
        assert!(hits > 0 && hits < total, "{count}: {hits} of {total}");
    }
}

/// For ray segments in a small box, the list of leaves that overlap the box gives the same hits as
/// the whole hierarchy, bit for bit.
#[test]
fn leaves_near_a_box_hold_all_its_hits() {
    let mut rng = SmallRng::seed_from_u64(5);
    let (mut short_lists, mut long_lists, mut hits) = (0, 0, 0);
    for (count, size, spheres) in
        [(1, 1.0, 0), (9, 0.7, 4), (60, 0.5, 0), (500, 0.2, 40), (3000, 0.05, 3), (0, 0.0, 17)]
    {
        let triangles = random_triangle_mesh(&mut rng, count, size);
        let balls: Vec<(Vec3, f32)> =
            (0..spheres).map(|_| (random_point(&mut rng), rng.random_range(0.0..0.3))).collect();
        let tree = Bvh::build(&triangles, &boxes_around_spheres(&balls));
        let solve = |i: u32, r: &Ray| intersect_sphere(balls[i as usize].0, balls[i as usize].1, r);
        for _ in 0..300 {
            let center = random_point(&mut rng);
            let half = rng.random_range(0.001..0.3);
            let Some(leaves) =
                tree.leaves_overlapping_bounds(&Bounds { min: center, max: center }.expanded(half * 1.001))
            else {
                long_lists += 1;
                continue;
            };
            short_lists += 1;
            for _ in 0..20 {
                let [from, to] = [0; 2].map(|_| center + random_point(&mut rng) * half);
                let ray = Ray { t_max: 1.0, ..Ray::new(from, to - from) };
                let expected = tree.closest_hit(&ray, solve);
                assert_eq!(tree.closest_hit_in_leaves(&leaves, &ray, solve), expected, "{ray:?}");
                hits += usize::from(expected.is_some());
            }
        }
    }
    assert!(short_lists > 500 && long_lists > 100 && hits > 1000, "{short_lists} {long_lists} {hits}");
}

/// Hits agree with Cramer's rule in f64, up to the error of the triangle test.
///
/// The shear moves a corner by at most γ(9) of its distance, which is below 6 here. γ is
/// [`rounding_error_bound`](crate::math::rounding_error_bound). The error of barycentric weights is
/// this displacement, divided by the height of the triangle as seen along the ray.
#[test]
fn hits_agree_with_double_precision() {
    let mut rng = SmallRng::seed_from_u64(9);
    let triangles = random_triangle_mesh(&mut rng, 1, 0.8)
        .into_iter()
        .chain(random_triangle_mesh(&mut rng, 5000, 0.8))
        .collect::<Mesh>();
    let mut hits = 0;
    for triangle in &triangles {
        let tree = Bvh::build(&[*triangle], &[]);
        let ray = Ray::new(random_point(&mut rng) * 2.0, random_direction(&mut rng) * 0.3);
        let ray = Ray {
            direction: if rng.random() { triangle[0].midpoint(triangle[2]) - ray.origin } else { ray.direction },
            ..ray
        };
        let [a, b, c] = triangle.map(|p| p.as_dvec3() - ray.origin.as_dvec3());
        let d = ray.direction.as_dvec3();
        let normal = (b - a).cross(c - a);
        let solve = |x: DVec3, y: DVec3| x.cross(y).dot(d) / normal.dot(d);
        let (u, v, t) = (solve(c, a), solve(a, b), normal.dot(a) / normal.dot(d));
        let longest = [b - a, c - b, a - c].iter().map(|e| e.length()).fold(0.0, f64::max);
        let height = normal.dot(d).abs() / (d.length() * longest);
        let error = 6.0 * f64::from(crate::math::rounding_error_bound(9)) / height;
        let margin = u.min(v).min(1.0 - u - v);
        match tree.closest_hit(&ray, miss_other_primitive) {
            Some(hit) => {
                assert!(margin > -error && t > 0.0, "{margin} {error} {t}");
                assert!(
                    (f64::from(hit.u) - u).abs() < error && (f64::from(hit.v) - v).abs() < error,
                    "{hit:?} {u} {v}"
                );
                assert!((f64::from(hit.t) - t).abs() * d.length() < 3.0 * error + 1e-6, "{hit:?} {t} {error}");
                hits += 1;
            }
            None => assert!(margin < error || t < error / d.length() || !margin.is_finite(), "{margin} {error} {t}"),
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// Among primitives at equal distance, the one with the lowest index is hit.
///
/// Triangles come before other primitives.
#[test]
fn equal_distances_go_to_the_lowest_primitive_index() {
    let mut rng = SmallRng::seed_from_u64(2);
    let mut triangles = random_triangle_mesh(&mut rng, 40, 1.0);
    triangles.extend(triangles.clone());
    triangles.extend_from_within(10..50);
    let balls: Vec<(Vec3, f32)> = (0..10).flat_map(|_| [(random_point(&mut rng), 0.4); 2]).collect();
    let mut shuffled = balls.clone();
    shuffled.rotate_left(7);
    for balls in [balls, shuffled] {
        assert_agrees_with_brute_force(
            &triangles,
            &balls,
            (0..2000).map(|_| Ray::new(random_point(&mut rng), random_direction(&mut rng))),
        );
    }
    // A triangle and another primitive in the same plane.
    let wall = [[Vec3::new(-1.0, -1.0, 2.0), Vec3::new(3.0, -1.0, 2.0), Vec3::new(-1.0, 3.0, 2.0)]];
    let tree = Bvh::build(&wall, &[Bounds::from_points(wall[0])]);
    let hit = tree.closest_hit(&Ray::new(Vec3::ZERO, Vec3::Z), |_, ray| {
        (2.0 < ray.t_max).then_some(ShapeHit { t: 2.0, shape_coords: Vec2::ZERO })
    });
    assert_eq!(hit.map(|h| h.primitive), Some(PrimitiveIndex::Triangle(0)));
}

/// Rays from up to 10⁷ triangle sizes away give the hits of brute force.
///
/// At that distance, rounding errors exceed the padding of boxes.
#[test]
fn distant_rays_agree_with_brute_force() {
    let mut rng = SmallRng::seed_from_u64(10);
    let triangles = random_triangle_mesh(&mut rng, 1000, 1e-4);
    let rays: Vec<Ray> = (0..5000)
        .map(|i| {
            let [a, b, c] = triangles[i % 1000];
            let target = [a, a.midpoint(b), (a + b + c) / 3.0][i % 3];
            let origin = target + random_direction(&mut rng) * [10.0, 100.0, 1000.0][i % 3];
            Ray::new(origin, target - origin)
        })
        .collect();
    let (hits, _) = assert_agrees_with_brute_force(&triangles, &[], rays.into_iter());
    assert!(hits > 500, "{hits}");
}

/// Rays along axes, in planes of faces, through edges and from corners agree with brute force.
#[test]
fn degenerate_rays_agree_with_brute_force() {
    let mut rng = SmallRng::seed_from_u64(3);
    let (mut vertices, faces) = cube_vertices_and_faces();
    for scale in [1.0, 3.0] {
        vertices.iter_mut().for_each(|v| *v *= scale);
        let triangles = mesh_of_faces(&vertices, &faces);
        let grid = |rng: &mut SmallRng| {
            Vec3::from_array(std::array::from_fn(|_| rng.random_range(-2i32..=2) as f32 * 0.5 * scale))
        };
        let rays = (0..20_000).filter_map(|_| {
            let (origin, target) = (grid(&mut rng) * [1.0, 2.0][rng.random_range(0..2)], grid(&mut rng));
            // Make direction components that are zeros of both signs.
            let sign = if rng.random() { 1.0 } else { -1.0 };
            (origin != target).then(|| Ray::new(origin, (origin - target) * sign))
        });
        let (hits, total) = assert_agrees_with_brute_force(&triangles, &[], rays);
        assert!(hits > total / 4);
    }
}

#[test]
fn slivers_and_degenerate_triangles_agree_with_brute_force() {
    let mut rng = SmallRng::seed_from_u64(4);
    let mut triangles = Mesh::new();
    for i in 0..600 {
        let (p, d) = (random_point(&mut rng), random_point(&mut rng));
        let thin = random_point(&mut rng) * [1e-3, 1e-6, 1e-9, 0.0][i % 4];
        triangles.push([p, p + d, p + d * rng.random::<f32>() + thin]);
        triangles.push([p; 3]);
        triangles.push([p, p + d, p]);
    }
    let targets = triangles.clone();
    let rays: Vec<Ray> = (0..2000)
        .map(|i| {
            let origin = if i % 3 == 0 { targets[i % 600][0] } else { random_point(&mut rng) * 2.0 };
            let [a, b, c] = targets[rng.random_range(0..600)];
            let w = warp::square_to_uniform_triangle(Vec2::new(rng.random(), rng.random()));
            Ray::new(origin, a + (b - a) * w.x + (c - a) * w.y - origin)
        })
        .filter(|r| r.direction != Vec3::ZERO)
        .collect();
    let (hits, _) = assert_agrees_with_brute_force(&triangles, &[], rays.into_iter());
    assert!(hits > 300, "{hits}");
}

/// Scaling the scene or the ray direction by a power of two scales `t` exactly and changes no other
/// bit of a hit.
#[test]
fn power_of_two_scales_change_no_bit() {
    let mut rng = SmallRng::seed_from_u64(5);
    let triangles = random_triangle_mesh(&mut rng, 400, 0.3);
    let rays: Vec<Ray> = (0..2000).map(|_| Ray::new(random_point(&mut rng), random_direction(&mut rng))).collect();
    let tree = Bvh::build(&triangles, &[]);
    for (size, length) in [(2f32, 1f32), (1.0, 2.0), (1.0 / 1024.0, 1.0), (2e-20, 1e-24), (1e-20, 1e20), (1e17, 1e-3)] {
        let power = |x: f32| f32::from_bits(x.to_bits() & 0x7f80_0000);
        let (size, length) = (power(size), power(length));
        let scaled: Mesh = triangles.iter().map(|t| t.map(|p| p * size)).collect();
        let other = Bvh::build(&scaled, &[]);
        for ray in &rays {
            let expected =
                tree.closest_hit(ray, miss_other_primitive).map(|h| PrimitiveHit { t: h.t * (size / length), ..h });
            let scaled_ray = Ray::new(ray.origin * size, ray.direction * length);
            assert_eq!(other.closest_hit(&scaled_ray, miss_other_primitive), expected, "{size} {length}");
        }
    }
}

#[test]
fn identical_primitives_build_fast_and_shallow() {
    let mut rng = SmallRng::seed_from_u64(7);
    let triangle = [random_point(&mut rng), random_point(&mut rng), random_point(&mut rng)];
    let middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
    let start = std::time::Instant::now();
    let tree = Bvh::build(&vec![triangle; 100_000], &vec![Bounds::from_points(triangle); 100_000]);
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < 1.0, "{seconds}");
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let hit = tree
        .closest_hit(&Ray::between_points(middle + normal, middle - normal), miss_other_primitive)
        .map(|h| h.primitive);
    assert_eq!(hit, Some(PrimitiveIndex::Triangle(0)));
}

/// A tree of triangles that grow by a constant factor does not overflow the traversal stack.
///
/// The surface area heuristic splits off one such triangle at a time, so the tree is deep.
#[test]
fn deep_trees_do_not_overflow_the_stack() {
    let triangles: Mesh = (0..240)
        .map(|i| {
            let s = libm::powf(1.4, i as f32 - 120.0);
            [Vec3::new(s, -s, -s), Vec3::new(s, s, -s), Vec3::new(s, 0.0, s)]
        })
        .collect();
    let mut rng = SmallRng::seed_from_u64(8);
    assert_agrees_with_brute_force(
        &triangles,
        &[],
        (0..2000).map(|_| Ray::new(random_point(&mut rng) * 1e-3, random_direction(&mut rng))),
    );
}
