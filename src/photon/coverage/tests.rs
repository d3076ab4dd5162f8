//! Tests of coverage: the fraction of a density estimate's disc that is surface.

use super::*;
use crate::camera::Camera;
use crate::color::Rgb;
use crate::sampling::Purpose;
use crate::scene::{Material, SceneBuilder};
use crate::shape::{Disc, Rectangle, Shape, Sphere};
use glam::DVec3;

fn scene_of_shapes(shapes: &[Shape]) -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Rgb::ONE));
    for shape in shapes {
        builder.add_shape(shape.clone(), white, Rgb::ZERO);
    }
    builder.build(Camera::perspective(DVec3::Z * 9.0, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap()).unwrap()
}

fn rectangle_shape(corner: [f64; 3], edge0: DVec3, edge1: DVec3) -> Shape {
    Shape::Rectangle(Rectangle::new(DVec3::from(corner), edge0, edge1))
}

/// A square of edge 2 in the plane y = 0, around the origin.
fn square_scene() -> Scene {
    scene_of_shapes(&[rectangle_shape([-1.0, 0.0, 1.0], DVec3::X * 2.0, DVec3::Z * -2.0)])
}

const KERNELS: [Kernel; 3] = [Kernel::Box, Kernel::Cone, Kernel::Epanechnikov];

/// Mean of [`disc_coverage`] over 2000 random keys, and its standard error. `p` is in the frame of
/// the scene description.
fn mean_coverage(scene: &Scene, p: DVec3, normal: Vec3, radius: f32, kernel: Kernel) -> (f64, f64) {
    let (n, p) = (2000u64, (p - scene.origin()).as_vec3());
    let one = |i| {
        f64::from(disc_coverage(scene, p, normal, radius, kernel, Key::new(3).purpose_key(Purpose::Test).child_key(i)))
    };
    let values: Vec<f64> = (0..n).map(one).collect();
    let mean = values.iter().sum::<f64>() / n as f64;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1) as f64;
    (mean, (variance / n as f64).sqrt())
}

/// Asserts that the mean coverage for radius 0.5 is `expected`, within five standard errors plus
/// 0.02. The measured coverage is a ratio of two random sums, and 0.02 allows for the bias of this
/// ratio.
#[track_caller]
fn assert_coverage(scene: &Scene, p: DVec3, kernel: Kernel, expected: f64) {
    let (mean, sigma) = mean_coverage(scene, p, Vec3::Y, 0.5, kernel);
    assert!((mean - expected).abs() < 5.0 * sigma + 0.02, "{kernel:?}: {mean} ± {sigma}, not {expected}");
}

/// Coverage is exactly 1 on level and oblique planes, from both sides, in spite of rounding.
#[test]
fn flat_surface_has_full_coverage() {
    let oblique = |i| (DVec3::new(5.0, 2.0, 0.3 * f64::from(i) - 1.0), DVec3::new(1.0, -4.0, 3.0));
    for (edge0, edge1) in (0..20).map(oblique).chain([(DVec3::X * 4.0, DVec3::Z * -4.0)]) {
        let flat = scene_of_shapes(&[rectangle_shape([0.0; 3], edge0, edge1)]);
        let normal = edge0.cross(edge1).normalize().as_vec3();
        let p = (edge0 * 0.1 - edge1 * 0.05).as_vec3();
        for (i, kernel) in (0..90).zip(KERNELS.into_iter().cycle()) {
            let key = Key::new(i).purpose_key(Purpose::Test);
            for radius in [0.5, 0.001] {
                assert_eq!(disc_coverage(&flat, p, normal, radius, kernel, key), 1.0);
                assert_eq!(disc_coverage(&flat, p, -normal, radius, kernel, key), 1.0);
            }
        }
    }
}

/// By symmetry, coverage is ½ at an edge and ¼ at a corner of a square, for every kernel.
#[test]
fn coverage_is_half_at_edges_quarter_at_corners() {
    for kernel in KERNELS {
        assert_coverage(&square_scene(), DVec3::X, kernel, 0.5);
        assert_coverage(&square_scene(), DVec3::new(1.0, 0.0, 1.0), kernel, 0.25);
    }
}

/// Compares the coverage at half a radius from an edge with a numerical integral of the kernel K.
///
/// Distances are relative to the radius of the disc. A circle of radius t around the point, t in
/// \[½, 1], has an arc of angle 2 acos(1/(2t)) beyond the edge. The uncovered part is the integral
/// over t of 2 acos(1/(2t)) K(t) t. The midpoint rule with 2000 steps errs by less than 10⁻⁴.
#[test]
fn edge_coverage_matches_kernel_integral() {
    for kernel in KERNELS {
        let beyond = (0..2000).map(|i| {
            let t = 0.5 + (f64::from(i) + 0.5) / 4000.0;
            2.0 * libm::acos(0.5 / t)
                * f64::from(kernel.unnormalized_value((t * t) as f32) * kernel.normalization_factor(1.0))
                * t
                / 4000.0
        });
        assert_coverage(&square_scene(), DVec3::X * 0.75, kernel, 1.0 - beyond.sum::<f64>());
    }
}

/// A neighbouring face does not count in the coverage if it is tilted by 75°, or lies 0.4 radii
/// higher or lower.
#[test]
fn other_orientations_and_heights_are_not_covered() {
    let floor = rectangle_shape([0.0, 0.0, 1.0], DVec3::X, DVec3::Z * -2.0);
    let down = DVec3::new(-0.258_819, -0.965_926, 0.0);
    let slope = rectangle_shape([0.0, 0.0, 1.0], DVec3::Z * -2.0, down);
    let step = |y: f64| rectangle_shape([-1.0, y, 1.0], DVec3::X, DVec3::Z * -2.0);
    for other in [slope, step(0.2), step(-0.2)] {
        let scene = scene_of_shapes(&[floor.clone(), other]);
        for kernel in KERNELS {
            assert_coverage(&scene, DVec3::ZERO, kernel, 0.5);
        }
    }
}

/// An edge at distance 0.3 reduces the coverage of discs with radius 0.5 and 0.354, but not of the
/// disc with radius 0.25.
#[test]
fn nested_discs_are_probed_independently() {
    let p = DVec3::X * 0.7;
    let levels = |i| {
        let key = Key::new(5).purpose_key(Purpose::Test).child_key(i);
        nested_disc_coverage(&square_scene(), p.as_vec3(), Vec3::Y, 0.5, Kernel::Box, key)
    };
    let all: Vec<[f32; NESTED_DISC_COUNT]> = (0..500).map(levels).collect();
    assert!(all.iter().all(|levels| levels[2] == 1.0), "a quarter is nearer than the edge");
    assert!(all.iter().any(|levels| levels[0] < 1.0) && all.iter().any(|levels| levels[1] < 1.0));
    let level_mean = |level: usize| all.iter().map(|l| f64::from(l[level])).sum::<f64>() / 500.0;
    assert!(level_mean(0) < level_mean(1) && level_mean(1) < 1.0);
}

#[test]
fn coverage_has_a_lower_bound() {
    let key = Key::new(0).purpose_key(Purpose::Test);
    assert_eq!(disc_coverage(&square_scene(), Vec3::new(0.0, 2.0, 0.0), Vec3::Y, 0.5, Kernel::Box, key), MIN_COVERAGE);
}

/// The cap of a sphere within distance r of its pole has area πr², so its coverage with the box
/// kernel is 1.
#[test]
fn sphere_has_full_box_coverage() {
    let ball = scene_of_shapes(&[Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0))]);
    for p in [DVec3::Y, DVec3::NEG_Y] {
        let (mean, sigma) = mean_coverage(&ball, p, Vec3::Y, 0.45, Kernel::Box);
        assert!((mean - 1.0).abs() < 5.0 * sigma + 1e-3, "{mean} ± {sigma}");
    }
}

/// Where [`NearPrimitives::only_shape_contains_disc`] is true, probe rays measure a coverage of
/// exactly 1. The function is false for tilted normals.
#[test]
fn discs_within_one_flat_shape_are_covered_without_probes() {
    let shapes = [
        rectangle_shape([3.0, 0.5, 1.0], DVec3::new(2.0, 1.0, 0.2), DVec3::new(-0.5, 0.3, 2.0)),
        Shape::Disc(Disc::new(DVec3::new(3.5, 1.0, 2.0), DVec3::new(1.2, 0.4, 0.0), DVec3::new(0.1, 0.3, 1.5))),
    ];
    for shape in shapes {
        let scene = scene_of_shapes(std::slice::from_ref(&shape));
        let shape = shape.translated(-scene.origin());
        let (mut certain, mut partial) = (0, 0);
        for i in 0..4000u64 {
            let key = Key::new(5).purpose_key(Purpose::Test).child_key(i);
            let u = sobol_2d(0, key, Dimension::CoverageProbe);
            let point = shape.sample(u).point;
            let radius = [0.5, 0.2, 0.05, 0.01][i as usize % 4];
            let sign = if i % 3 == 0 { -1.0 } else { 1.0 };
            // Some normals are tilted by more than the tolerance.
            let tilt = if i % 7 == 0 { 1e-3 } else { 1e-5 };
            let normal = (point.ng * sign + Frame::from_normal(point.ng).s * tilt).normalize();
            let primitives = NearPrimitives::new(&scene, &probe_bounds(point.p, normal, radius));
            let tolerance = radius * (0.5 * MAX_FLAT_RISE);
            let found = coverage_by_probes(&scene, &primitives, point.p, normal, radius, Kernel::Epanechnikov, key);
            let contains = primitives.only_shape_contains_disc(point.p, normal, radius, tolerance);
            assert!(!contains || found == 1.0, "{i}: {found}");
            assert!(!contains || i % 7 != 0, "{i}: tilted");
            certain += u32::from(contains);
            partial += u32::from(found < 1.0);
        }
        assert!(certain > 1500 && partial > 500, "{certain} {partial}");
    }
}

/// A second shape near the disc may hide a part of it, so probe rays must measure the coverage.
#[test]
fn further_shapes_near_a_disc_need_probes() {
    let floor = rectangle_shape([-1.0, 0.0, 1.0], DVec3::X * 2.0, DVec3::Z * -2.0);
    let ball = |x: f64| Shape::Sphere(Sphere::new(DVec3::new(x, 0.05, 0.0), 0.05));
    for (x, expected) in [(0.05, false), (0.5, true)] {
        let scene = scene_of_shapes(&[floor.clone(), ball(x)]);
        let p = (-scene.origin()).as_vec3();
        let primitives = NearPrimitives::new(&scene, &probe_bounds(p, Vec3::Y, 0.1));
        assert_eq!(primitives.only_shape_contains_disc(p, Vec3::Y, 0.1, 1e-4), expected, "{x}");
    }
}
