//! Tests of parametric surfaces against a reference by subdivision and against closed forms.

mod exact;
mod reference;

use super::super::Shape;
use super::{Patch, Revolution, SplineBasis};
use crate::accel::ShapeHit;
use crate::math::{Ray, warp};
use crate::sampling::{Dimension, Key, Purpose};
use glam::{DVec2, DVec4, Vec3};
use reference::{ReferenceHits, ReferencePiece, ReferenceSurface};

/// Parametric surface, and the reference pieces that describe the same surface.
struct TestSurface {
    name: &'static str,
    shape: Shape,
    pieces: Vec<ReferencePiece>,
    /// Factor by which this surface gets fewer test rays, as its reference is slow.
    thin: u64,
}

fn random_key(i: u64) -> Key {
    Key::new(11).purpose_key(Purpose::Test).child_key(i)
}

/// Pseudorandom number in \[−1, 1].
fn random_signed(i: u64) -> f64 {
    f64::from(random_key(i).uniform_1d(Dimension::LightPosition)) * 2.0 - 1.0
}

/// Surface of revolution with control points (x, y), and its reference.
fn revolution_test_surface(name: &'static str, basis: &SplineBasis, controls: &[[f64; 2]]) -> TestSurface {
    let points: Vec<DVec2> = controls.iter().map(|c| DVec2::from_array(*c)).collect();
    let shape = Shape::Revolution(Revolution::new(basis, &points).unwrap());
    let piece = |span| basis.bezier_control_points(span, controls, (0, 1)).into_iter().map(DVec2::from_array).collect();
    let pieces =
        basis.knot_spans().map(|span| ReferencePiece::new(ReferenceSurface::Revolution(piece(span)))).collect();
    TestSurface { name, shape, pieces, thin: 1 }
}

/// Patch with control points (x, y, z, weight), and its reference.
fn patch_test_surface(name: &'static str, bases: [&SplineBasis; 2], controls: &[DVec4]) -> TestSurface {
    let shape = Shape::Patch(Patch::new(bases, controls).unwrap());
    let columns = bases[1].control_count();
    let weighed: Vec<[f64; 4]> = controls.iter().map(|c| (c.truncate() * c.w).extend(c.w).to_array()).collect();
    let mut pieces = Vec::new();
    for u in bases[0].knot_spans() {
        let along: Vec<Vec<[f64; 4]>> =
            (0..columns).map(|j| bases[0].bezier_control_points(u, &weighed, (j, columns))).collect();
        for v in bases[1].knot_spans() {
            let rows = (0..=bases[0].degree()).flat_map(|i| {
                let row: Vec<[f64; 4]> = along.iter().map(|c| c[i]).collect();
                bases[1].bezier_control_points(v, &row, (0, 1))
            });
            let points = rows.map(|[x, y, z, w]| DVec4::new(x / w, y / w, z / w, w)).collect();
            pieces.push(ReferencePiece::new(ReferenceSurface::Patch(points, [bases[0].degree(), bases[1].degree()])));
        }
    }
    TestSurface { name, shape, pieces, thin: 1 }
}

/// Surface of revolution like a cup; nearly coincident control points make sharp bends.
fn cup_test_surface() -> TestSurface {
    let profile = [
        [0.0, -0.3],
        [0.0, -0.300001],
        [0.0, -0.300002],
        [-0.5, -0.25],
        [-0.9, 0.2],
        [-0.8, 1.1],
        [-0.85, 1.25],
        [-0.95, 1.1],
        [-1.05, 0.1],
        [-0.6, -0.45],
        [-0.1, -0.7],
        [-0.12, -1.2],
        [-0.7, -1.3],
        [-0.7, -1.4],
        [0.0, -1.4],
        [0.0, -1.400001],
        [0.0, -1.400002],
    ];
    revolution_test_surface("cup", &SplineBasis::uniform_spline_basis(3, profile.len()).unwrap(), &profile)
}

/// Surfaces with bends, poles, loops, axis crossings, collapsed edges, weights and high degrees.
fn parametric_test_surfaces() -> Vec<TestSurface> {
    let cubic = SplineBasis::bezier_basis(4).unwrap();
    let wave = |rows: usize, columns: usize, seed: u64, height: f64| -> Vec<DVec4> {
        let place = |i: usize, n: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
        let point = |k: usize| {
            let (i, j) = (k / columns, k % columns);
            DVec4::new(place(i, rows), height * random_signed(seed + k as u64), place(j, columns), 1.0)
        };
        (0..rows * columns).map(point).collect()
    };
    let weighed = |mut net: Vec<DVec4>, seed: u64| {
        for (i, c) in net.iter_mut().enumerate() {
            c.w = libm::exp(random_signed(seed + i as u64));
        }
        net
    };
    let (twenty, ten) = (SplineBasis::bezier_basis(21).unwrap(), SplineBasis::bezier_basis(11).unwrap());
    let coil: Vec<[f64; 2]> = (0..21)
        .map(|i| [1.5 + random_signed(600 + i), 0.3 * (i as f64 - 10.0) + 2.0 * random_signed(700 + i)])
        .collect();
    let uneven = SplineBasis::new(3, 7, vec![0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 3.0, 3.5, 4.0, 4.0, 9.0]).unwrap();
    let quadratic = SplineBasis::uniform_spline_basis(2, 5).unwrap();
    let mut collapsed = wave(4, 4, 900, 0.7);
    collapsed[..4].fill(DVec4::new(-1.0, 0.2, 0.0, 1.0));
    let mut loops = wave(4, 4, 950, 1.0);
    for (i, c) in loops.iter_mut().enumerate() {
        *c = DVec4::new(random_signed(1000 + i as u64), c.y, random_signed(1100 + i as u64), 1.0);
    }
    vec![
        cup_test_surface(),
        revolution_test_surface("arch", &cubic, &[[-2.0, 2.0], [-4.0, 0.0], [0.0, 0.0], [-2.0, -2.0]]),
        revolution_test_surface("crossing", &cubic, &[[-1.0, -1.0], [2.0, -0.5], [-2.0, 0.5], [1.0, 1.0]]),
        TestSurface { thin: 10, ..revolution_test_surface("degree 20", &twenty, &coil) },
        patch_test_surface("wave", [&cubic, &cubic], &wave(4, 4, 100, 0.8)),
        patch_test_surface("loops", [&cubic, &cubic], &loops),
        patch_test_surface("collapsed", [&cubic, &cubic], &collapsed),
        TestSurface {
            thin: 10,
            ..patch_test_surface("nurbs", [&uneven, &quadratic], &weighed(wave(7, 5, 300, 0.5), 400))
        },
        TestSurface { thin: 400, ..patch_test_surface("degrees 20 and 10", [&twenty, &ten], &wave(21, 11, 500, 1.0)) },
    ]
}

/// Test ray `i` for a shape: from outside, from inside its bounding box, or parallel to an axis.
fn random_ray_near_shape(shape: &Shape, i: u64) -> Ray {
    let (min, max) = shape.bounds_f64();
    let (middle, half) = ((0.5 * (min + max)).as_vec3(), (0.5 * (max - min)).as_vec3());
    let k = random_key(i);
    let inside = |seed: u64| {
        let (a, b) =
            (k.child_key(seed).uniform_2d(Dimension::LightPosition), k.child_key(seed).uniform_1d(Dimension::Light));
        middle + half * (Vec3::new(a.x, a.y, b) * 2.0 - 1.0)
    };
    let far = middle + warp::square_to_uniform_sphere(k.uniform_2d(Dimension::LightDirection)) * (2.0 * half.length());
    match i % 8 {
        0 => Ray::new(inside(1), warp::square_to_uniform_sphere(k.uniform_2d(Dimension::LightDirection)) * 0.7),
        1 => {
            let from = inside(1);
            Ray::new(Vec3::new(2.5 * half.max_element(), from.y, from.z), -Vec3::X)
        }
        2 => {
            let from = inside(1);
            Ray::new(Vec3::new(from.x, middle.y + 2.0 * half.y, from.z), Vec3::new(0.0, -2.0, 0.0))
        }
        _ => Ray::new(far, inside(2) - far),
    }
}

/// Numbers of rays in a comparison of the solver with the reference.
#[derive(Debug, Default)]
struct ComparisonCounts {
    rays: u64,
    hits: u64,
    /// Rays for which solver and reference may differ: tangent rays, and rays that pass an edge.
    undecided: u64,
}

/// Compares the solver with the reference for the test rays whose indices are in `rays`.
///
/// Panics if results differ, except where the ray grazes the surface or passes an edge. The
/// position error of the reference is at most 10⁻⁶ of the surface's size.
fn compare_with_reference(case: &TestSurface, rays: std::ops::Range<u64>) -> ComparisonCounts {
    let (min, max) = case.shape.bounds_f64();
    let size = 0.5 * (max - min).length();
    let error = 1e-6 * size;
    let grazing = 0.02;
    let mut counts = ComparisonCounts::default();
    let mut found = ReferenceHits { hit: None, near_quads: Vec::new() };
    for i in rays {
        let ray = random_ray_near_shape(&case.shape, i);
        (found.hit, counts.rays) = (None, counts.rays + 1);
        found.near_quads.clear();
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        case.pieces.iter().for_each(|p| p.find_quads_near_ray(o, d, error, &mut found));
        let ours = case.shape.intersect(&ray);
        let message = || format!("{} ray {i}: {ours:?} against {:?}", case.name, found.hit);
        if let Some(ShapeHit { t, shape_coords: uv }) = ours {
            counts.hits += 1;
            let surface = case.shape.surface_point(&ray, t, uv);
            let off = surface.p.as_dvec3() - o;
            let beside = (off - d * (off.dot(d) / d.length_squared())).length();
            assert!(beside <= 4e-6 * (size + o.length()), "{}: {beside} beside the ray", message());
        }
        let t = ours.map(|hit| f64::from(hit.t));
        let length = d.length();
        let near = |a: f64, b: f64| (a - b).abs() * length;
        let within = |[lo, hi]: [f64; 2], t: f64, by: f64| (lo - t) * length <= by && (t - hi) * length <= by;
        let rounding = 1e-6 * (o.length() + size);
        let agree = match (t, found.hit) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                let there = found.near_quads.iter().filter(|x| within(x.t, b, 4.0 * error));
                let cos = there.map(|x| x.cos).fold(1.0, f64::min).max(grazing);
                near(a, b) <= 4.0 * error / cos + rounding
            }
            _ => false,
        };
        if agree {
            continue;
        }
        // A difference is excused only if the ray grazes the surface, or passes an edge, near the
        // first of the two hits.
        let first = t.unwrap_or(f64::INFINITY).min(found.hit.unwrap_or(f64::INFINITY));
        let reach = 4.0 * error / grazing + rounding;
        let excuse = found.near_quads.iter().any(|x| within(x.t, first, reach) && (x.cos <= grazing || x.edge));
        let behind = first * length <= reach;
        assert!(excuse || behind, "{}", message());
        counts.undecided += 1;
    }
    counts
}

/// Compares all test surfaces with their references by up to `rays` rays each.
fn assert_agrees_with_reference(rays: u64) {
    for case in parametric_test_surfaces() {
        let start = std::time::Instant::now();
        let counts = compare_with_reference(&case, 0..rays / case.thin);
        eprintln!("{}: {counts:?} in {:.1?}", case.name, start.elapsed());
        assert!(counts.hits * 20 > counts.rays, "{}: hardly a hit in {counts:?}", case.name);
        assert!(counts.undecided * 2000 <= counts.rays, "{}: {counts:?}", case.name);
    }
}

#[test]
fn every_intersection_is_found() {
    assert_agrees_with_reference(16_000);
}

/// Long variant of [`every_intersection_is_found`].
///
/// The environment variable `CAUSTICA_ROOT_RAYS` sets the number of rays per surface. 2·10⁶ take
/// seven minutes on two cores.
#[test]
#[ignore = "long: half a million rays"]
fn every_intersection_is_found_with_many_rays() {
    let rays = std::env::var("CAUSTICA_ROOT_RAYS").ok();
    assert_agrees_with_reference(rays.map_or(500_000, |n| n.parse().expect("CAUSTICA_ROOT_RAYS is a number")));
}
