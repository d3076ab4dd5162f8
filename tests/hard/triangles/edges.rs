//! Rays at edges whose crossings are known exactly, triangles without area, and edges of many triangles.

use super::closed::point;
use caustica::accel::{Hierarchy, Primitive};
use caustica::math::{Ray, gamma};
use glam::{DVec3, I64Vec3, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

fn none(_: u32, _: &Ray) -> Option<(f32, f32, f32)> {
    None
}

fn grid(rng: &mut SmallRng, reach: i64) -> I64Vec3 {
    I64Vec3::from_array(std::array::from_fn(|_| rng.random_range(-reach..=reach)))
}

/// Six times the volume that four places span: exact, as products of three numbers below 2¹³ are.
fn volume(o: I64Vec3, a: I64Vec3, b: I64Vec3, c: I64Vec3) -> i64 {
    (a - o).dot((b - o).cross(c - o))
}

/// Two triangles on either side of an edge, and rays through it and beside it, all of whole numbers.
///
/// Which side of the edge a ray passes is the sign of a volume, known exactly. Shearing moves corners by γ(9) of their distance from the ray's
/// start, so a volume this much below the largest that such corners span is in doubt; all others must be told rightly. A ray through the
/// edge itself meets one of the two at t = 1, off by as much over the cosine, in parts of the way.
#[test]
fn rays_at_an_edge_meet_the_triangle_on_their_side() {
    let mut rng = SmallRng::seed_from_u64(1);
    let (mut through, mut beside, mut doubtful) = (0, 0, 0);
    for i in 0..400_000 {
        let [a, c, b, d, o] = std::array::from_fn(|_| grid(&mut rng, 1000));
        // A whole number of steps along the edge.
        let edge = (c - a) / 8;
        let c = a + edge * 8;
        let on = a + edge * rng.random_range(1..8);
        let target = if i % 2 == 0 { on } else { on + grid(&mut rng, 2) };
        let (sides, spread) = ([b, d].map(|p| volume(o, a, c, p)), (c - a).length_squared());
        // Seen from the start, the triangles must lie on different sides of the edge.
        if sides[0].signum() * sides[1].signum() >= 0 || spread == 0 || target == o {
            continue;
        }
        let to = |p: I64Vec3| p.as_vec3();
        let tree = Hierarchy::build(&[[to(a), to(c), to(b)], [to(a), to(c), to(d)]], &[]);
        let hit = tree.closest(&Ray::new(to(o), to(target) - to(o)), none);
        let side = volume(o, a, c, target);
        let reach = [a, c, b, d].map(|p| (p - o).as_dvec3().length()).into_iter().fold(0.0, f64::max);
        let blur = 4.0 * f64::from(gamma(9)) * reach;
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
        // The volume over the area of its base is a height; the base of two edges from the start is twice a triangle.
        let base = (a - o).as_dvec3().cross((c - o).as_dvec3()).length();
        if (side.unsigned_abs() as f64) <= blur * base {
            doubtful += 1;
            continue;
        }
        beside += 1;
        let expected = if side.signum() == sides[0].signum() { 0 } else { 1 };
        // Beyond the other edges of its triangle a ray may miss, but it must not meet the other triangle.
        assert!(hit.is_none_or(|h| h.primitive == Primitive::Triangle(expected)), "{a} {c} {b} {d} {o} {target}");
    }
    assert!(through > 50_000 && beside > 50_000 && doubtful < 20_000, "{through} {beside} {doubtful}");
}

/// Corners on a line, or in one point, as f32 has them: shearing rounds them off the line, but there is nothing to meet and no normal.
#[test]
fn triangles_without_area_are_never_met() {
    let mut rng = SmallRng::seed_from_u64(2);
    for i in 0..200_000 {
        let scale = [1e-6, 1.0, 1e6][i % 3];
        let whole = |rng: &mut SmallRng, n: i64| grid(rng, n).as_vec3() / 64.0 * scale;
        let (a, d) = (whole(&mut rng, 64), whole(&mut rng, 64));
        let (b, c) = (a + d, if i % 5 == 0 { a } else { a + d + d });
        // Sums of such numbers are exact where the scale is a power of two; elsewhere cross products tell.
        let [p, q, r] = [a, b, c].map(Vec3::as_dvec3);
        if (q - p).cross(r - p) != DVec3::ZERO {
            continue;
        }
        let tree = Hierarchy::build(&[[a, b, c]], &[]);
        let o = point(&mut rng) * (2.0 * scale);
        let ray = Ray::new(o, a + d * rng.random::<f32>() - o);
        assert!(tree.closest(&ray, none).is_none() && !tree.occluded(&ray, |_, _| false), "{a} {b} {c} {ray:?}");
    }
}

/// A fan of triangles around one edge, one of them twice: from any sector, a ray at the edge must not pass it. Half of the rays run in a
/// plane through the edge in which all products of its edge function are 0, so that only what counts as inside decides.
#[test]
fn edges_of_many_triangles_hold() {
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
        let tree = Hierarchy::build(&triangles, &[]);
        for _ in 0..20 {
            let sector =
                if exactly { 0.0 } else { rng.random_range(0..blades) as f32 + rng.random_range(-0.3f32..0.3) };
            let from = (low + high) * 0.5 + around(sector, length);
            let target = low + (high - low) * rng.random_range(0.1f32..0.9);
            let hit = tree.closest(&Ray::new(from, target - from), none);
            // It is met at the edge itself, or on a blade beside it: blades are at least .2/7 of a turn away, where sin > .17, so that the
            // rounding of places, a few ulps of their size, is at most six times as long on them.
            let blur = 100.0 * f32::EPSILON * (from.length() + scale) / length;
            assert!(hit.is_some_and(|h| (h.t - 1.0).abs() <= blur), "{hit:?} {blur}");
        }
    }
}
