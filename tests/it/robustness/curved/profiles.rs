//! Spline surfaces of degree 20 that have closed forms, with poles, cusps on the axis, and edges of
//! length 0.

use caustica::accel::ShapeHit;
use caustica::math::{Ray, warp};
use caustica::shape::parametric_surface::SplineBasis;
use caustica::shape::{Patch, Revolution, Shape};
use glam::{DVec2, DVec3, DVec4, Vec2, Vec3};
use libm::{cbrt, hypot};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Returns homogeneous control points of the same curve, one degree higher.
fn elevated_by_one_degree(controls: &[DVec4]) -> Vec<DVec4> {
    let n = controls.len() as f64;
    let end = DVec4::ZERO;
    (0..=controls.len())
        .map(|i| {
            let s = i as f64 / n;
            let (a, b) = (if i > 0 { controls[i - 1] } else { end }, controls.get(i).copied().unwrap_or(end));
            a * s + b * (1.0 - s)
        })
        .collect()
}

fn elevated_to_degree(mut controls: Vec<DVec4>, degree: usize) -> Vec<DVec4> {
    while controls.len() <= degree {
        controls = elevated_by_one_degree(&controls);
    }
    controls
}

fn surface_of_revolution(profile: &[(f64, f64)], degree: usize) -> Shape {
    let controls = elevated_to_degree(profile.iter().map(|(x, y)| DVec4::new(*x, *y, 0.0, 1.0)).collect(), degree);
    let points: Vec<DVec2> = controls.iter().map(|c| DVec2::new(c.x, c.y)).collect();
    Shape::Revolution(Revolution::new(&SplineBasis::bezier_basis(degree + 1).unwrap(), &points).unwrap())
}

/// Builds a Bézier patch of degrees `p` and `q` from homogeneous control points of a lower degree.
///
/// `points` holds rows of `columns` points along v.
fn patch_of_points(points: &[DVec4], columns: usize, [p, q]: [usize; 2]) -> Shape {
    let rows: Vec<Vec<DVec4>> = points.chunks(columns).map(|row| elevated_to_degree(row.to_vec(), q)).collect();
    let along: Vec<Vec<DVec4>> =
        (0..=q).map(|j| elevated_to_degree(rows.iter().map(|row| row[j]).collect(), p)).collect();
    let point = |c: DVec4| (c.truncate() / c.w).extend(c.w);
    let controls: Vec<DVec4> = (0..=p).flat_map(|i| along.iter().map(move |column| point(column[i]))).collect();
    let bases = [p, q].map(|n| SplineBasis::bezier_basis(n + 1).unwrap());
    Shape::Patch(Patch::new([&bases[0], &bases[1]], &controls).unwrap())
}

/// A surface with a closed form: the points where `value` is 0 and `inside` is at least 0.
///
/// Between the heights of its kinks, `value` is convex along lines.
struct KnownSurface {
    name: &'static str,
    shape: Shape,
    value: fn(DVec3) -> f64,
    inside: fn(DVec3) -> f64,
    kink: Option<f64>,
    /// Point without a normal, such as an apex, and a direction from it.
    ///
    /// The direction points towards the middle of the solid, or along the surface.
    tip: Option<(DVec3, DVec3)>,
}

fn known_surfaces() -> Vec<KnownSurface> {
    let w = std::f64::consts::FRAC_1_SQRT_2;
    let arc = [(1.0, 0.0, 1.0), (1.0, 1.0, w), (0.0, 1.0, 1.0)];
    let octant: Vec<DVec4> = arc
        .iter()
        .flat_map(|(r, h, w)| arc.iter().map(move |(c, s, v)| DVec4::new(r * c, *h, r * s, 1.0) * (w * v)))
        .collect();
    let wedge = [[-1.0, 0.0], [-1.0, 0.0], [1.0, -1.0], [1.0, 1.0]].map(|[x, z]| DVec4::new(x, 0.0, z, 1.0));
    let cone = |degree| KnownSurface {
        name: "cone",
        shape: surface_of_revolution(&[(1.0, -1.0), (0.0, 1.0)], degree),
        value: |p| hypot(p.x, p.z) - 0.5 * (1.0 - p.y),
        inside: |p| 1.0 - p.y.abs(),
        kink: None,
        tip: Some((DVec3::Y, DVec3::NEG_Y)),
    };
    let bowl = |degree| KnownSurface {
        name: "bowl",
        shape: surface_of_revolution(&[(0.0, 0.0), (0.5, 0.0), (1.0, 1.0)], degree),
        value: |p| p.x * p.x + p.z * p.z - p.y,
        inside: |p| 1.0 - p.y,
        kink: None,
        tip: None,
    };
    // The profile (s², s³) for s in [−1, 1] has a cusp on the axis. Both branches leave the axis
    // perpendicular to it.
    let cusp = |degree| KnownSurface {
        name: "cusp",
        shape: surface_of_revolution(&[(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)], degree),
        value: |p| hypot(p.x, p.z) - cbrt(p.y * p.y),
        inside: |p| 1.0 - p.y.abs(),
        kink: Some(0.0),
        tip: Some((DVec3::ZERO, DVec3::Y)),
    };
    let eighth = |degrees| KnownSurface {
        name: "eighth of a sphere",
        shape: patch_of_points(&octant, 3, degrees),
        value: |p| p.length_squared() - 1.0,
        inside: |p| p.min_element(),
        kink: None,
        tip: None,
    };
    let wedge = |degrees| KnownSurface {
        name: "wedge",
        shape: patch_of_points(&wedge, 2, degrees),
        value: |p| p.y,
        inside: |p| (0.5 * (p.x + 1.0) - p.z.abs()).min(1.0 - p.x),
        kink: None,
        tip: Some((DVec3::NEG_X, DVec3::X)),
    };
    vec![
        cone(1),
        cone(20),
        bowl(2),
        bowl(20),
        cusp(3),
        cusp(20),
        eighth([2, 2]),
        eighth([10, 8]),
        wedge([1, 1]),
        wedge([20, 3]),
    ]
}

/// Returns the zeros of a function that is convex on `lo..hi`, in ascending order, and its minimum.
fn roots(f: &dyn Fn(f64) -> f64, lo: f64, hi: f64) -> (Vec<f64>, f64) {
    let (mut a, mut b) = (lo, hi);
    for _ in 0..120 {
        let (p, q) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if f(p) < f(q) { b = q } else { a = p }
    }
    let low = 0.5 * (a + b);
    let least = [lo, low, hi].map(f).into_iter().fold(f64::INFINITY, f64::min);
    let mut found = Vec::new();
    if f(low) <= 0.0 {
        for (mut above, mut below) in [(lo, low), (hi, low)] {
            if f(above) <= 0.0 {
                continue;
            }
            for _ in 0..100 {
                let middle = 0.5 * (above + below);
                if f(middle) > 0.0 { above = middle } else { below = middle }
            }
            found.push(0.5 * (above + below));
        }
    }
    (found, least)
}

/// Distance from a tip \[length]. A ray that passes this far inside of the tip must hit.
///
/// The cone is half as wide there, and single-precision rounding is a 50th of this distance.
const TIP_DISTANCE: f64 = 1e-5;

/// Returns test ray `i` for a surface: through its tip, beside it, along its axis, or perpendicular
/// to it.
///
/// The ray starts far away or nearby.
fn ray(known: &KnownSurface, rng: &mut SmallRng, i: u32) -> Ray {
    let random = |rng: &mut SmallRng| Vec3::new(rng.random(), rng.random(), rng.random()) * 2.2 - 1.1;
    let target = match known.tip {
        Some((tip, _)) if i.is_multiple_of(16) => tip.as_vec3(),
        Some((tip, inwards)) if i.is_multiple_of(8) => (tip + inwards * TIP_DISTANCE).as_vec3(),
        // The target is the pole of the bowl. Poles of patches have their own test.
        None if i.is_multiple_of(8) && known.name == "bowl" => Vec3::ZERO,
        _ => random(rng),
    };
    let from = match i % 5 {
        0 => random(rng),
        1 => target + Vec3::Y * 3.0,
        2 => Vec3::new(3.0, target.y, target.z),
        _ => target + warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random())) * 4.0,
    };
    Ray::new(from, target - from)
}

/// Hits and normals of surfaces of degree 20 agree with bisection of the closed forms.
///
/// Some rays are along the axis or through poles and cusps. The solver counts a ray within 10⁻¹² of
/// the surface as touching it; lengths are relative to the surface's size. Rays that the reference
/// puts within 10⁻⁹ of touching the surface or its border may hit or miss. For all others, the
/// slope at a root is above √(2·10⁻⁹) times the curvature, which is about 1. So 10⁻¹² changes `t`
/// by less than 10⁻⁷ of it. The relative rounding error of `t` is 6·10⁻⁸.
#[test]
fn degree_20_surfaces_are_hit_correctly() {
    known_surfaces().par_iter().for_each(|known| {
        let mut rng = SmallRng::seed_from_u64(7);
        let (mut hits, mut tips, mut doubtful) = (0, 0, 0);
        const RAYS: u32 = 6_000;
        for i in 0..RAYS {
            let ray = ray(known, &mut rng, i);
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            if d == DVec3::ZERO {
                continue;
            }
            let value = |t: f64| (known.value)(o + d * t);
            let mut ends = vec![1e-9, 40.0];
            ends.extend(known.kink.map(|y| (y - o.y) / d.y).filter(|t| (1e-9..40.0).contains(t)));
            ends.sort_by(f64::total_cmp);
            let (mut truth, mut doubt) = (None, value(0.0).abs() < 1e-6);
            for part in ends.windows(2) {
                let (found, least) = roots(&value, part[0], part[1]);
                doubt |= least.abs() < 1e-9 || part.iter().any(|t| value(*t).abs() < 1e-9);
                for t in found {
                    let within = (known.inside)(o + d * t);
                    doubt |= within.abs() < 1e-9;
                    if within > 0.0 {
                        truth = truth.or(Some(t));
                    }
                }
            }
            let found = known.shape.intersect(&ray);
            let near = |p: DVec3, off: f64| known.tip.is_some_and(|(tip, _)| (p - tip).length() < off);
            let beside = known.tip.is_some() && i % 16 == 8;
            tips += u32::from(beside && truth.is_some() && !doubt);
            match (truth, found) {
                _ if doubt => doubtful += 1,
                (None, None) => {}
                (Some(t), Some(ShapeHit { t: f, shape_coords: uv })) => {
                    hits += 1;
                    assert!((f64::from(f) - t).abs() <= 6e-8 * t + 1e-7, "{} {ray:?}: {f} {t}", known.name);
                    let s = known.shape.surface_point(&ray, f, uv);
                    let p = o + d * t;
                    assert!((s.p.as_dvec3() - p).length() < 2e-6, "{} {ray:?}: {} {p}", known.name, s.p);
                    let h = 1e-6;
                    let slope = |e: DVec3| (known.value)(p + e * h) - (known.value)(p - e * h);
                    let n = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
                    assert!(
                        near(p, 1e-3) || s.ng.as_dvec3().dot(n).abs() > 1.0 - 1e-5,
                        "{} {p}: {} {n}",
                        known.name,
                        s.ng
                    );
                    assert!(s.ng.is_normalized(), "{} {p}", known.name);
                }
                // The tip is a point of the surface. A ray that passes it within its own rounding
                // may miss.
                (a, b) => {
                    let there = a.or(b.map(|b| f64::from(b.t))).is_some_and(|t| near(o + d * t, 1e-9));
                    assert!(there, "{} {ray:?}: {found:?} {truth:?}", known.name);
                    doubtful += 1;
                }
            }
        }
        assert!(hits > RAYS / 20 && doubtful < RAYS / 4, "{} {hits} {doubtful}", known.name);
        assert!(known.tip.is_none() || tips > RAYS / 16 / 2, "{} {tips}", known.name);
    });
}

/// Rays from inside a sphere, exactly through its poles, hit one of its two patches.
///
/// Each patch covers half of all longitudes from pole to pole. At a pole, one side of each patch
/// has length 0. Steep leaves around a pole reject such a ray most often, so one case has degree
/// 20.
#[test]
#[ignore = "long: many samples of a hard case"]
fn sphere_poles_are_hit_from_inside() {
    // The arc is half a circle, as a cubic: (1 − t², 2t)/(1 + t²) for t from −1 to 1.
    let arc =
        [(0.0, -2.0, 2.0), (4.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0), (4.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0), (0.0, 2.0, 2.0)];
    let half = |side: f64, degrees| {
        let along =
            |(r, h, w): (f64, f64, f64)| arc.map(|(x, z, v)| DVec4::new(side * r * x, h * v, side * r * z, w * v));
        let points: Vec<DVec4> = arc.iter().flat_map(|c| along(*c)).collect();
        patch_of_points(&points, 4, degrees)
    };
    let mut rng = SmallRng::seed_from_u64(8);
    // Returns a point that sees the pole at 60° to the axis, and the pole.
    let mut oblique = |pole: Vec3| {
        let (sin, cos) = libm::sincosf(rng.random_range(0.0..std::f32::consts::TAU));
        (pole * 1.5 + Vec3::new(cos, 0.0, sin) * 0.866, pole)
    };
    let (up, down) = (Vec3::Y, Vec3::NEG_Y);
    let many = vec![oblique(up), oblique(down), oblique(up), oblique(down), (Vec3::ZERO, up)];
    let cases = [([3, 3], many), ([20, 3], vec![oblique(up)])];
    cases.par_iter().for_each(|(degrees, rays)| {
        let halves = [half(1.0, *degrees), half(-1.0, *degrees)];
        rays.par_iter().for_each(|(from, pole)| {
            let ray = Ray::new(*from, pole - from);
            let hits = halves.iter().filter_map(|half| half.intersect(&ray));
            let t = hits.map(|hit| hit.t).fold(f32::INFINITY, f32::min);
            // The direction rounds to 2⁻²⁴ of itself, and so does t.
            assert!((t - 1.0).abs() <= 2.0 * f32::EPSILON, "{degrees:?} {ray:?}: {t}");
        });
    });
}
