//! Rays at edges with exact crossings, triangles without area, and edges of many triangles.

use super::closed::point;
use caustica::accel::{Bvh, PrimitiveIndex, ShapeHit};
use caustica::math::{Ray, rounding_error_bound};
use glam::{DVec3, I64Vec3, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

fn never_hit(_: u32, _: &Ray) -> Option<ShapeHit> {
    None
}

fn grid(rng: &mut SmallRng, reach: i64) -> I64Vec3 {
    I64Vec3::from_array(std::array::from_fn(|_| rng.random_range(-reach..=reach)))
}

/// Returns six times the signed volume of the tetrahedron `o`, `a`, `b`, `c`.
///
/// It is exact for products of three numbers below 2¹³.
fn volume(o: I64Vec3, a: I64Vec3, b: I64Vec3, c: I64Vec3) -> i64 {
    (a - o).dot((b - o).cross(c - o))
}

/// Rays through and beside the common edge of two triangles hit the triangle on their side of the
/// edge.
///
/// Rays and triangles have integer coordinates. So the side on which a ray passes the edge is known
/// exactly: it is the sign of a tetrahedron's volume. The shear of the triangle test (Woop et al.
/// 2013) moves corners by γ(9) of their distance from the ray's origin. Cases with a smaller
/// relative volume may go either way. All others must be decided correctly. A ray through the edge
/// hits one of the triangles at t = 1, with this error divided by the cosine.
#[test]
fn edge_rays_hit_triangle_on_their_side() {
    let mut rng = SmallRng::seed_from_u64(1);
    let (mut through, mut beside, mut doubtful) = (0, 0, 0);
    for i in 0..400_000 {
        let [a, c, b, d, o] = std::array::from_fn(|_| grid(&mut rng, 1000));
        // The edge is an integer number of equal steps long.
        let edge = (c - a) / 8;
        let c = a + edge * 8;
        let on = a + edge * rng.random_range(1..8);
        let target = if i % 2 == 0 { on } else { on + grid(&mut rng, 2) };
        let (sides, spread) = ([b, d].map(|p| volume(o, a, c, p)), (c - a).length_squared());
        // Skip cases in which both triangles are on the same side of the edge, seen from the ray's
        // origin.
        if sides[0].signum() * sides[1].signum() >= 0 || spread == 0 || target == o {
            continue;
        }
        let to = |p: I64Vec3| p.as_vec3();
        let tree = Bvh::build(&[[to(a), to(c), to(b)], [to(a), to(c), to(d)]], &[]);
        let hit = tree.closest_hit(&Ray::new(to(o), to(target) - to(o)), never_hit);
        let side = volume(o, a, c, target);
        let reach = [a, c, b, d].map(|p| (p - o).as_dvec3().length()).into_iter().fold(0.0, f64::max);
        let blur = 4.0 * f64::from(rounding_error_bound(9)) * reach;
        let direction = (target - o).as_dvec3();
        if side == 0 && i % 2 == 0 {
            let hit = hit.unwrap_or_else(|| panic!("{a} {c} {b} {d} {o} {target}: through"));
            let slope = |p: I64Vec3| {
                let n = (c - a).as_dvec3().cross((p - a).as_dvec3());
                n.dot(direction).abs() / (n.length() * direction.length())
            };
            let flattest = slope(b).min(slope(d));
            let off = (f64::from(hit.t) - 1.0).abs() * direction.length();
            assert!(off <= blur / flattest + 1e-6 * direction.length(), "{off} of {blur} over {flattest}");
            through += 1;
            continue;
        }
        // A volume divided by its base area is a height. `base` is twice the area of the triangle
        // of the origin and the edge.
        let base = (a - o).as_dvec3().cross((c - o).as_dvec3()).length();
        if (side.unsigned_abs() as f64) <= blur * base {
            doubtful += 1;
            continue;
        }
        beside += 1;
        let expected = if side.signum() == sides[0].signum() { 0 } else { 1 };
        // A ray may pass beyond the other edges of its triangle and miss. It must not hit the other
        // triangle.
        assert!(hit.is_none_or(|h| h.primitive == PrimitiveIndex::Triangle(expected)), "{a} {c} {b} {d} {o} {target}");
    }
    assert!(through > 50_000 && beside > 50_000 && doubtful < 20_000, "{through} {beside} {doubtful}");
}

/// Scale factors that are powers of two, so that scaling rounds nothing.
const SCALES: [f32; 3] = [1.0 / 1_048_576.0, 1.0, 1_048_576.0];

/// Triangles without area are never hit.
///
/// Their corners are exactly collinear in f32, or two or three corners are equal. Rounding in the
/// shear of the triangle test moves corners off their line, and still there must be no hit.
/// Coordinates are multiples of 1/64 up to 3, so sums are exact.
#[test]
fn zero_area_triangles_are_never_hit() {
    let mut rng = SmallRng::seed_from_u64(2);
    for scale in SCALES {
        let mut aimed = [0; 3];
        for i in 0..60_000 {
            let whole = |rng: &mut SmallRng| grid(rng, 64).as_vec3() / 64.0 * scale;
            let (kind, a, d) = (i % 3, whole(&mut rng), whole(&mut rng));
            let (b, c) = [(a + d, a + d + d), (a + d, a), (a, a)][kind];
            let [p, q, r] = [a, b, c].map(Vec3::as_dvec3);
            assert_eq!((q - p).cross(r - p), DVec3::ZERO);
            let tree = Bvh::build(&[[a, b, c]], &[]);
            let o = point(&mut rng) * (2.0 * scale);
            let ray = Ray::new(o, a + (b - a) * rng.random::<f32>() - o);
            assert!(
                tree.closest_hit(&ray, never_hit).is_none() && !tree.occluded(&ray, |_, _| false),
                "{a} {b} {c} {ray:?}"
            );
            aimed[kind] += usize::from(d != Vec3::ZERO);
        }
        assert!(aimed.iter().all(|n| *n > 19_900), "{scale:e}: {aimed:?}");
    }
}

/// Returns the distance of `p` from a triangle.
fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let along = |a: DVec3, b: DVec3| {
        let part = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, part))
    };
    let n = (b - a).cross(c - a).normalize();
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(a, b)| (b - a).cross(p - a).dot(n) >= 0.0);
    if inside { (p - a).dot(n).abs() } else { along(a, b).min(along(b, c)).min(along(c, a)) }
}

/// Rays along an axis, or perpendicular to an axis, hit triangles correctly.
///
/// They go through the inside, beside it, at edges and in the triangle's plane. Coordinates are
/// integers up to 8, and ray origins often lie in the triangle's plane.
///
/// Edge functions are volumes, divided by the square of the largest direction component. They are 0
/// or at least 1/64. The shear moves corners by γ(9) of 28. So the error of an edge function is
/// less than 28²·γ(9)·4 < .002, and only rays exactly through an edge may go either way. The error
/// of `t` is this error divided by the slope. A ray in the plane of a triangle may hit or miss it,
/// but a hit must be on the triangle.
#[test]
fn axis_aligned_and_coplanar_rays_hit_correctly() {
    let mut rng = SmallRng::seed_from_u64(4);
    let mut counts = [0; 5];
    for i in 0..400_000usize {
        let [a, b, c, o] = std::array::from_fn(|_| grid(&mut rng, 8));
        // Every second triangle has corners on a lattice, and ray origins are points of this
        // lattice: inside the triangle, at its edges, and beside it in its plane.
        let (e, f) = (grid(&mut rng, 2), grid(&mut rng, 2));
        let (b, c, o) = match i % 2 {
            0 => (b, c, o),
            _ => (a + e * 3, a + f * 3, a + e * rng.random_range(0..4) + f * rng.random_range(0..4)),
        };
        let mut d = grid(&mut rng, 8);
        for axis in 0..3 {
            if axis == i % 3 || (axis == (i + 1) % 3 && i % 4 < 2) {
                d[axis] = 0;
            }
        }
        let n = (b - a).cross(c - a);
        if d == I64Vec3::ZERO || n == I64Vec3::ZERO {
            continue;
        }
        let scale = SCALES[i % SCALES.len()];
        let to = |p: I64Vec3| p.as_vec3() * scale;
        let tree = Bvh::build(&[[to(a), to(b), to(c)]], &[]);
        let ray = Ray::new(to(o), to(d));
        let hit = tree.closest_hit(&ray, never_hit);
        assert_eq!(tree.occluded(&ray, |_, _| false), hit.is_some(), "{a} {b} {c} {o} {d}");
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (p - o).cross(q - o).dot(d));
        let (up, way) = (n.dot(d), n.dot(a - o));
        let inside = sides.iter().all(|s| s.signum() == up.signum());
        let beside = sides.iter().any(|s| s.signum() == -up.signum());
        let reach = [a, b, c].map(|p| (p - o).as_dvec3().length()).into_iter().fold(0.0, f64::max);
        let blur = 4.0 * f64::from(rounding_error_bound(9)) * reach * n.as_dvec3().length() / up.abs() as f64;
        if let Some(hit) = hit {
            assert!(hit.t.is_finite() && hit.t > 0.0, "{a} {b} {c} {o} {d}: {hit:?}");
            let p = o.as_dvec3() + d.as_dvec3() * f64::from(hit.t);
            let off = distance(p, [a, b, c].map(|p| p.as_dvec3()));
            let most = if up == 0 { 4.0 * f64::from(rounding_error_bound(9)) * reach } else { blur };
            assert!(off <= most + 1e-6 * reach, "{a} {b} {c} {o} {d}: {hit:?} is off by {off}");
        }
        let kind = match () {
            () if up == 0 => 0,
            () if inside && way == 0 => 1,
            () if inside => {
                let t = way as f64 / up as f64;
                let off = |hit: caustica::accel::PrimitiveHit| (f64::from(hit.t) - t).abs() * d.as_dvec3().length();
                let ahead = t > 0.0;
                assert_eq!(hit.is_some(), ahead, "{a} {b} {c} {o} {d}: {hit:?} {t}");
                assert!(hit.is_none_or(|h| off(h) <= blur + 1e-6 * reach), "{a} {b} {c} {o} {d}: {hit:?} {t}");
                2
            }
            () if beside => {
                assert!(hit.is_none(), "{a} {b} {c} {o} {d}: {hit:?}");
                3
            }
            () => 4,
        };
        counts[kind] += 1;
    }
    assert!(counts.iter().all(|n| *n > 1_000), "{counts:?}");
}

/// A ray at the common edge of a fan of triangles hits a triangle, from any direction.
///
/// One triangle occurs twice. Half of the rays lie in a plane through the edge. All products of
/// their edge function are 0, so only the rule for edges decides.
#[test]
fn edges_of_many_triangles_are_watertight() {
    let mut rng = SmallRng::seed_from_u64(3);
    for i in 0..20_000 {
        let blades = rng.random_range(3..8);
        let scale = [1e-6, 1.0, 1e6][i % 3];
        let exactly = i % 2 == 0;
        let (low, high) = if exactly {
            (Vec3::NEG_Z * scale, Vec3::Z * scale)
        } else {
            (point(&mut rng) * scale, point(&mut rng) * scale)
        };
        let (s, t) = if exactly { (Vec3::X, Vec3::Y) } else { (high - low).normalize().any_orthonormal_pair() };
        let length = (high - low).length();
        let around = |sector: f32, r: f32| {
            let (sin, cos) = libm::sincosf(sector / blades as f32 * std::f32::consts::TAU);
            (s * cos + t * sin) * r
        };
        let blade = |k: i32| [low, high, (low + high) * 0.5 + around(k as f32 + 0.5, 3.0 * length)];
        let mut triangles: Vec<[Vec3; 3]> = (0..blades).map(blade).collect();
        triangles.push(triangles[0]);
        let tree = Bvh::build(&triangles, &[]);
        for _ in 0..20 {
            let sector =
                if exactly { 0.0 } else { rng.random_range(0..blades) as f32 + rng.random_range(-0.3f32..0.3) };
            let from = (low + high) * 0.5 + around(sector, length);
            let target = low + (high - low) * rng.random_range(0.1f32..0.9);
            let hit = tree.closest_hit(&Ray::new(from, target - from), never_hit);
            // The hit is at the edge itself or on a triangle beside it. Adjacent triangles are at
            // least .2/7 of a turn apart, where sin > .17. So the rounding of positions, a few ulps
            // of their size, is at most six times as long on them.
            let blur = 100.0 * f32::EPSILON * (from.length() + scale) / length;
            assert!(hit.is_some_and(|h| (h.t - 1.0).abs() <= blur), "{hit:?} {blur}");
        }
    }
}
