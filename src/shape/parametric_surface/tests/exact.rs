//! Surfaces with closed forms, difficult cases for solvers, and rays that leave a surface.

use super::{
    Patch, Revolution, SplineBasis, cup_test_surface, parametric_test_surfaces, patch_test_surface, random_key,
    random_ray_near_shape,
};
use crate::accel::ShapeHit;
use crate::math::{Frame, Ray, Transform, offset_ray_origin, warp};
use crate::sampling::Dimension;
use crate::shape::Shape;
use glam::{DAffine3, DQuat, DVec2, DVec3, DVec4, Vec2, Vec3};

/// Unit circle as a NURBS curve of degree 2: its basis, and its control points (x, y, weight).
fn unit_circle_nurbs() -> (SplineBasis, Vec<(f64, f64, f64)>) {
    let w = std::f64::consts::FRAC_1_SQRT_2;
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let weight = |i: usize| if i % 2 == 1 { w } else { 1.0 };
    let points = corners.iter().enumerate().map(|(i, (x, y))| (f64::from(*x), f64::from(*y), weight(i)));
    (SplineBasis::new(2, 9, knots).unwrap(), points.collect())
}

/// NURBS torus around the y axis, with the ring radius `large` and the tube radius `small`.
///
/// The outer side faces out of the tube.
pub fn torus_patch(large: f64, small: f64) -> Patch {
    let (basis, points) = unit_circle_nurbs();
    let mut controls = Vec::new();
    for (r, h, w) in &points {
        for (c, s, v) in &points {
            let radius = large + small * r;
            controls.push(DVec4::new(radius * c, small * h, radius * s, w * v));
        }
    }
    Patch::new([&basis, &basis], &controls).unwrap()
}

/// Unit sphere as a NURBS surface, with poles on the y axis.
fn sphere_patch() -> Patch {
    let (basis, points) = unit_circle_nurbs();
    let half = SplineBasis::new(2, 5, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let mut controls = Vec::new();
    for (h, r, w) in &points[..5] {
        for (c, s, v) in &points {
            controls.push(DVec4::new(r * c, *h, -r * s, w * v));
        }
    }
    Patch::new([&half, &basis], &controls).unwrap()
}

/// Hits of a NURBS sphere agree with the quadratic formula in f64.
///
/// Rays that are tangent within 10⁻¹² are left out.
#[test]
fn a_nurbs_sphere_matches_the_sphere() {
    let shape = Shape::Patch(sphere_patch());
    assert!((shape.area() / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9, "{}", shape.area());
    let mut hits = 0;
    for i in 0..60_000 {
        let ray = random_ray_near_shape(&shape, i);
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (a, b) = (d.length_squared(), o.dot(d));
        let nearest = (o - d * (b / a)).length_squared();
        let found = shape.intersect(&ray);
        if (nearest - 1.0).abs() < 1e-12 {
            continue;
        }
        let root = ((1.0 - nearest).max(0.0) * a).sqrt();
        let truth =
            if nearest > 1.0 { None } else { [(-b - root) / a, (-b + root) / a].into_iter().find(|t| *t > 1e-7) };
        match (found, truth) {
            (None, None) => {}
            (Some(ShapeHit { t, shape_coords: uv }), Some(truth)) => {
                hits += 1;
                assert!((f64::from(t) - truth).abs() <= 1e-7 * truth, "{i}: {t} {truth}");
                let p = shape.surface_point(&ray, t, uv);
                assert!((p.p.length() - 1.0).abs() < 2e-7 && p.ng.dot(p.p) > 1.0 - 1e-6, "{i}: {p:?}");
            }
            _ => panic!("{i}: {found:?} {truth:?} {nearest}"),
        }
    }
    assert!(hits > 20_000);
}

/// The implicit function of a torus keeps its sign along each ray up to the hit, and is 0 there.
#[test]
fn a_nurbs_torus_matches_the_torus() {
    let (large, small) = (1.0, 0.4);
    let shape = Shape::Patch(torus_patch(large, small));
    let area = 4.0 * std::f64::consts::PI * std::f64::consts::PI * large * small;
    assert!((shape.area() / area - 1.0).abs() < 1e-9, "{}", shape.area() / area);
    let value = |p: DVec3| libm::hypot(libm::hypot(p.x, p.z) - large, p.y) - small;
    let mut hits = 0;
    for i in 0..8_000 {
        let ray = random_ray_near_shape(&shape, i);
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let found = shape.intersect(&ray);
        let end = found.map_or(8.0 / d.length(), |hit| f64::from(hit.t));
        let side = value(o).signum();
        for k in 1..400 {
            let here = value(o + d * (end * f64::from(k) / 400.0));
            assert!(here * side > -1e-6, "{i}: {found:?} passes over {here}");
        }
        if let Some(ShapeHit { t, shape_coords: uv }) = found {
            hits += 1;
            assert!(value(o + d * f64::from(t)).abs() < 4e-7, "{i}");
            let p = shape.surface_point(&ray, t, uv);
            let step = p.p.as_dvec3() + p.ng.as_dvec3() * 1e-3;
            assert!((value(step) - 1e-3).abs() < 2e-6, "{i}: the normal points outward");
        }
    }
    assert!(hits > 2_000);
}

#[test]
fn revolved_lines_match_quadric_intersections() {
    let line = |a: [f64; 2], b: [f64; 2]| {
        let basis = SplineBasis::bezier_basis(2).unwrap();
        Shape::Revolution(Revolution::new(&basis, &[DVec2::from(a), DVec2::from(b)]).unwrap())
    };
    for (a, b) in
        [([1.0, -1.0], [1.0, 1.0]), ([0.0, 1.0], [-1.0, -0.5]), ([0.5, 0.5], [2.0, 0.2]), ([0.2, 0.0], [1.5, 0.0])]
    {
        let shape = line(a, b);
        let ([ra, ya], [rb, yb]) = (a.map(f64::abs), b.map(f64::abs));
        let (ya, yb) = (ya.copysign(a[1]), yb.copysign(b[1]));
        let mut hits = 0;
        for i in 0..20_000 {
            let ray = random_ray_near_shape(&shape, i);
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            // The profile is the line (ρ, y) = (ra, ya) + s·(rb − ra, yb − ya) with s in [0, 1]. s
            // is computed from y, or from ρ if the line is horizontal.
            let (dr, dy) = (rb - ra, yb - ya);
            let mut truth = f64::INFINITY;
            let (mut edge, mut grazes) = (false, false);
            let mut offer = |t: f64, s: f64| {
                edge |= (s * (s - 1.0)).abs() < 1e-9;
                if (0.0..=1.0).contains(&s) && t > 0.0 {
                    truth = truth.min(t);
                }
            };
            if dy == 0.0 {
                let t = (ya - o.y) / d.y;
                let p = o + d * t;
                offer(t, (libm::hypot(p.x, p.z) - ra) / dr);
            } else {
                // On the cone of the profile, ρ = p + q·t at the height of the ray at t.
                let (p, q) = (ra + dr * (o.y - ya) / dy, dr * d.y / dy);
                let a = d.x * d.x + d.z * d.z - q * q;
                let b = o.x * d.x + o.z * d.z - p * q;
                let c = o.x * o.x + o.z * o.z - p * p;
                let discriminant = b * b - a * c;
                grazes = discriminant.abs() < 1e-10;
                if discriminant > 0.0 {
                    for root in [(-b - discriminant.sqrt()) / a, (-b + discriminant.sqrt()) / a] {
                        if p + q * root >= 0.0 {
                            offer(root, (o.y + d.y * root - ya) / dy);
                        }
                    }
                }
            }
            let found = shape.intersect(&ray).map_or(f64::INFINITY, |hit| f64::from(hit.t));
            hits += u32::from(found.is_finite());
            let same = found == truth || (found - truth).abs() <= 1e-6 * truth.max(1.0);
            assert!(same || edge || grazes, "{a:?} {b:?} {i}: {found} {truth}");
        }
        assert!(hits > 1_000, "{a:?} {b:?} {hits}");
    }
}

#[test]
fn tangent_rays_terminate() {
    let hits = |shape: &Shape, o: DVec3, d: DVec3| shape.intersect(&Ray::new(o.as_vec3(), d.as_vec3()));
    let ring = Shape::Patch(torus_patch(1.0, 0.5));
    // First, a ray touches the torus along a whole circle on its top. Then a ray touches it at one
    // outer point. The last ray passes through the hole.
    for (height, expected) in [(0.5f32, None), (0.5f32.next_up(), Some(false)), (0.5f32.next_down(), Some(true))] {
        let found = hits(&ring, DVec3::new(-3.0, f64::from(height), 0.0), DVec3::X);
        assert!(expected.is_none_or(|e| e == found.is_some()), "{height} {found:?}");
        if let Some(ShapeHit { t, .. }) = found {
            assert!((t - 2.0).abs() < 2e-3, "{t}");
        }
    }
    for x in [1.5f32.next_up(), 1.5, 1.5f32.next_down()] {
        let found = hits(&ring, DVec3::new(f64::from(x), 0.0, 3.0), DVec3::NEG_Z);
        assert!(
            found.is_none_or(|hit| (hit.t - 3.0).abs() < 2e-3) && (x == 1.5 || found.is_some() == (x < 1.5)),
            "{x}"
        );
    }
    assert!(hits(&ring, DVec3::new(0.0, 3.0, 0.0), DVec3::NEG_Y).is_none());
    let cup = cup_test_surface().shape;
    // The rays run along the axis from above, from below and from within, and slightly beside it.
    for x in [0.0, 1e-30, 1e-9, 1e-7] {
        let ShapeHit { t, .. } = hits(&cup, DVec3::new(x, 3.0, 0.0), DVec3::NEG_Y).unwrap();
        assert!((t - 3.3).abs() < 2e-6, "{x} {t}");
        let ShapeHit { t, .. } = hits(&cup, DVec3::new(x, -3.0, x), DVec3::Y * 0.5).unwrap();
        assert!((t - 3.2).abs() < 4e-6, "{x} {t}");
        assert!(hits(&cup, DVec3::new(0.0, -0.8, x), DVec3::Y).is_some());
    }
}

/// A ray that lies in a flat patch misses it.
#[test]
fn rays_in_a_flat_patch_miss() {
    let linear = SplineBasis::bezier_basis(2).unwrap();
    let corner = |x: f64, z: f64| DVec4::new(x, 0.0, z, 1.0);
    let flat = patch_test_surface(
        "flat",
        [&linear, &linear],
        &[corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
    );
    for d in [Vec3::X, Vec3::new(1.0, 0.0, 0.3), Vec3::new(-1.0, 0.0, 1.0)] {
        assert!(flat.shape.intersect(&Ray::new(-d * 3.0, d)).is_none());
    }
    let ShapeHit { t, shape_coords: uv } =
        flat.shape.intersect(&Ray::new(Vec3::new(0.5, 2.0, -0.5), -Vec3::Y)).unwrap();
    assert!(t == 2.0 && uv == Vec2::new(0.75, 0.25));
}

/// Normals have unit length everywhere, also at poles and collapsed edges, where derivatives
/// vanish.
#[test]
fn poles_and_collapsed_edges_have_normals() {
    let ball = Shape::Patch(sphere_patch());
    for side in [1.0, -1.0] {
        let ray = Ray::new(Vec3::Y * (3.0 * side), Vec3::Y * -side);
        let ShapeHit { t, shape_coords: uv } = ball.intersect(&ray).unwrap();
        let p = ball.surface_point(&ray, t, uv);
        assert!((t - 2.0).abs() < 1e-6 && (p.ng - Vec3::Y * side).length() < 1e-4, "{p:?}");
    }
    for case in parametric_test_surfaces() {
        for i in 0..400 {
            let u = random_key(i).uniform_2d(Dimension::LightPosition);
            for uv in
                [u, Vec2::new(0.0, u.y), Vec2::new(1.0, u.y), Vec2::new(u.x, 0.0), Vec2::new(u.x, 1.0), Vec2::ZERO]
            {
                let ray = Ray::new(Vec3::splat(9.0), Vec3::new(-1.0, -0.9, -0.8));
                let p = case.shape.surface_point(&ray, 1.0, uv);
                assert!((p.ng.length() - 1.0).abs() < 1e-5 && p.p.is_finite(), "{} {uv}: {p:?}", case.name);
            }
        }
    }
}

/// All test surfaces, and their images under a map that stretches and mirrors them.
fn transformed_parametric_shapes() -> Vec<(&'static str, Shape)> {
    let squash = Transform::new(DAffine3::from_scale_rotation_translation(
        DVec3::new(30.0, -8.0, 55.0),
        DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5),
        DVec3::new(300.0, -2000.0, 100.0),
    ))
    .unwrap();
    let moved = |s: Shape| s.transformed(&squash).unwrap();
    let cases: Vec<(&str, Shape)> = parametric_test_surfaces().into_iter().map(|c| (c.name, c.shape)).collect();
    let mirrored: Vec<(&str, Shape)> = cases.iter().map(|(name, s)| (*name, moved(s.clone()))).collect();
    cases.into_iter().chain(mirrored).collect()
}

/// True if a point sampled with this pdf may lie near an apex, where two parts of the surface are
/// close.
fn may_be_near_apex(shape: &Shape, pdf: f32) -> bool {
    f64::from(pdf) * shape.area() > 30.0
}

/// Shapes of [`transformed_parametric_shapes`] that do not intersect themselves.
fn shapes_without_self_intersection() -> impl Iterator<Item = (&'static str, Shape)> {
    transformed_parametric_shapes().into_iter().filter(|(name, _)| *name != "loops")
}

/// A ray that leaves a surface point at a cosine above 0.1 to the normal has no hit close by.
///
/// Every hit is more than 2·10⁻⁵ of the surface's size away.
#[test]
fn leaving_rays_do_not_hit_their_surface_again() {
    for (name, shape) in shapes_without_self_intersection() {
        let (min, max) = shape.bounds_f64();
        let size = 0.5 * (max - min).length() as f32;
        for i in 0..6_000 {
            let sample = shape.sample(random_key(i).uniform_2d(Dimension::LightPosition));
            if may_be_near_apex(&shape, sample.pdf) {
                continue;
            }
            let s = sample.point;
            let d = warp::square_to_cosine_hemisphere(random_key(i).uniform_2d(Dimension::LightDirection));
            if d.z < 0.1 {
                continue;
            }
            let d = Frame::from_normal(s.ng).to_world(d);
            for d in [d, -d] {
                let origin = offset_ray_origin(s.p, s.position_error, s.ng, d);
                assert!((origin - s.p).length() < 1e-6 * (size + s.p.length()), "{name}");
                if let Some(ShapeHit { t, .. }) = shape.intersect(&Ray::new(origin, d)) {
                    assert!(t > 2e-5 * size, "{name} {i}: {t} of {size}");
                }
            }
        }
    }
}

/// The mean of 1/pdf over area samples is the area, within five standard errors.
///
/// A ray towards a sampled point hits the surface there, and the pdf of the hit agrees.
#[test]
fn area_samples_match_their_pdf() {
    for (name, shape) in shapes_without_self_intersection() {
        let (n, mut sum, mut squares, mut strays) = (20_000, 0.0, 0.0, 0);
        let size = (shape.bounds_f64().1 - shape.bounds_f64().0).length() as f32;
        for i in 0..u64::from(n) {
            let sample = shape.sample(random_key(i).uniform_2d(Dimension::LightPosition));
            let inverse = 1.0 / f64::from(sample.pdf);
            assert!(inverse.is_finite() && sample.shape_coords == sample.point.shape_coords, "{name}");
            sum += inverse;
            squares += inverse * inverse;
            let from = sample.point.p + sample.point.ng * (1e-3 * size);
            let ray = Ray::new(from, -sample.point.ng);
            let found = shape.intersect(&ray).filter(|hit| (hit.t - 1e-3 * size).abs() < 1e-5 * size);
            if let Some(ShapeHit { t, shape_coords: uv }) = found.filter(|_| !may_be_near_apex(&shape, sample.pdf)) {
                let again = shape.pdf(&shape.surface_point(&ray, t, uv));
                // The pdf jumps between leaves, and rounding may move a point into the next leaf.
                strays += u32::from((again / sample.pdf - 1.0).abs() > 0.05);
            }
        }
        assert!(strays * 500 < n, "{name}: {strays}");
        let mean = sum / f64::from(n);
        let sigma = ((squares / n as f64 - mean * mean).max(0.0) / f64::from(n)).sqrt();
        assert!((mean - shape.area()).abs() < 5.0 * sigma, "{name}: {mean} {}", shape.area());
    }
}

/// Texture gradients agree with differences of the coordinates along the surface.
#[test]
fn texture_gradients_match_finite_differences() {
    for (name, shape) in transformed_parametric_shapes() {
        let size = (shape.bounds_f64().1 - shape.bounds_f64().0).length();
        let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, 0.9, 0.8));
        let mut tried = 0;
        for i in 0..500 {
            let uv = random_key(i).uniform_2d(Dimension::LightPosition) * 0.9 + 0.05;
            let at = |uv: Vec2| match &shape {
                Shape::Revolution(s) => s.point_at_uv(uv),
                Shape::Patch(s) => s.point_at_uv(uv),
                _ => panic!("{ray:?}"),
            };
            let here = at(uv);
            let mapped = shape.tex_coord(here.as_vec3(), uv);
            for step in [Vec2::X, Vec2::Y] {
                let after = uv + step * 2e-4;
                let change = at(after) - here;
                let estimated = DVec2::new(mapped.grad_u.dot(change), mapped.grad_v.dot(change));
                // Steps across the axis are left out, since the azimuth jumps there.
                if change.length() > 1e-5 * size && mapped.grad_v.length() * size < 30.0 {
                    tried += 1;
                    let truth = (after - uv).as_dvec2();
                    assert!((estimated - truth).length() < 0.05 * truth.length(), "{name} {uv}: {estimated} {truth}");
                }
            }
        }
        assert!(tried > 100, "{name}");
    }
}
