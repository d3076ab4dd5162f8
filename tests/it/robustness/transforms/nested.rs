//! Transforms of the scene language: nested 64 deep, and singular ones.

use super::double_double::{Affine, DoubleDoubleVec};
use super::shapes::{UnitShape, exact_hit};
use caustica::format::{SceneError, SourceText, parse, resolve};
use caustica::math::{Ray, Transform, rotation_matrix};
use caustica::scene::{Effects, RayCone, Scene};
use glam::{DAffine3, DMat3, DVec3, Vec2};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use std::fmt::Write;
use std::path::Path;

const CAMERA: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 angle 30 }\n";

fn scene(text: &str) -> Result<Scene, SceneError> {
    let text = format!("{CAMERA}{text}");
    resolve(&parse("a.txt", &text)?, &SourceText::new("a.txt", &text), Path::new(""))
}

/// Returns one random transform as scene text and as a matrix.
///
/// Depending on the level, it is a rotation, translation, mirror, shear or scale. Scales of
/// different levels cancel in pairs.
fn step(rng: &mut SmallRng, level: u32) -> (String, DAffine3) {
    let mut number = || f64::from(rng.random_range(-100..=100)) / 64.0;
    let v = DVec3::new(number(), number(), number());
    let uneven = DVec3::new(-2.0, 0.5, 1.25);
    match level % 8 {
        0 => (format!("Translate {} {} {}", v.x, v.y, v.z), DAffine3::from_translation(v)),
        1 => {
            let axis = v + DVec3::X * 4.0;
            let map = rotation_matrix(axis.normalize(), 37f64.to_radians());
            (format!("Rotate {{ {} {} {} 37 }}", axis.x, axis.y, axis.z), DAffine3::from_mat3(map))
        }
        2 => (format!("Scale {} {} {}", uneven.x, uneven.y, uneven.z), DAffine3::from_scale(uneven)),
        3 => {
            let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.25, 1.0, 0.0), DVec3::Z);
            ("Matrix { 1 0 0 0  .25 1 0 0  0 0 1 0  0 0 0 1 }".to_owned(), DAffine3::from_mat3(shear))
        }
        4 => ("UniformScale 1e6".to_owned(), DAffine3::from_scale(DVec3::splat(1e6))),
        5 => ("YRotate -71".to_owned(), DAffine3::from_mat3(rotation_matrix(DVec3::Y, (-71f64).to_radians()))),
        6 => ("UniformScale 1e-6".to_owned(), DAffine3::from_scale(DVec3::splat(1e-6))),
        _ => {
            let back = DVec3::new(0.5, -2.0, 0.75);
            (format!("Scale {} {} {}", back.x, back.y, back.z), DAffine3::from_scale(back))
        }
    }
}

/// A shape in 64 nested transforms lies where the exact product of the transforms places it.
///
/// Each product rounds by about 4 ulps of ‖outer‖·‖inner‖. The inner transforms amplify this error
/// by their norms: 1 for a rotation, 2 for a scale, 1.14 for a shear. Scales by 10⁶ and 10⁻⁶
/// cancel. The total error is 64 · 4 · 2⁻⁵² · 4.6⁸ = 1.2·10⁻⁸, relative to positions, which are
/// within 10 of the origin.
#[test]
fn shapes_64_transforms_deep_are_placed_correctly() {
    let shapes = [
        (UnitShape::Ball, "Sphere { center 0 0 0 radius 1 }"),
        (UnitShape::Disc, "Disc { center 0 0 0 normal 0 1 0 radius 1 }"),
        (UnitShape::Square, "Rectangle { corner -1 0 -1 edge0 0 0 2 edge1 2 0 0 }"),
        (UnitShape::Tube, "RevSurface { profile BezierCurve { controls [ 1 -1 0 ] [ 1 1 0 ] } }"),
    ];
    for (seed, (own, written)) in shapes.into_iter().enumerate() {
        let mut rng = SmallRng::seed_from_u64(40 + seed as u64);
        let mut text = String::from("Group {\n");
        let mut exact = Affine::from(DAffine3::IDENTITY);
        for level in 0..64 {
            let (words, map) = step(&mut rng, level);
            writeln!(text, "Transform {{ {words} Group {{").unwrap();
            exact = exact.after(&map.into());
        }
        write!(text, "{written} {} }}", "} }".repeat(64)).unwrap();
        let scene = scene(&text).unwrap();
        let middle = DoubleDoubleVec::from(scene.origin());
        let whole = DAffine3::from_mat3_translation(
            DMat3::from_cols_array_2d(&exact.columns.map(|c| c.value().to_array())),
            exact.shift.value(),
        );
        let placed = Transform::new(whole).unwrap();
        let size = whole.matrix3.x_axis.length() + whole.matrix3.y_axis.length() + whole.matrix3.z_axis.length();
        let rows = placed.inverse().matrix3.transpose();
        let shrink = rows.x_axis.length() + rows.y_axis.length() + rows.z_axis.length();
        let (mut hits, mut doubtful) = (0, 0);
        const PRODUCTS: f64 = 1.2e-7;
        const RAYS: u32 = 10_000;
        for _ in 0..RAYS {
            let mut place =
                || placed.transform_point(own.point(Vec2::new(rng.random(), rng.random()))) - scene.origin();
            let (target, other) = (place(), place());
            let away = DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
            let origin = (if rng.random() { other + away * size } else { target + away * (3.0 * size) }).as_vec3();
            let Some(direction) = (target.as_vec3() - origin).try_normalize() else { continue };
            let ray = Ray::new(origin, direction);
            let mut known =
                exact_hit(own, &exact, DoubleDoubleVec::from(origin.as_dvec3()) + middle, direction.as_dvec3().into());
            if known.doubtful {
                doubtful += 1;
                continue;
            }
            let found = scene.intersect(&ray);
            assert_eq!(found.is_some(), known.t.is_some(), "{own:?} {ray:?}");
            let (Some(hit), Some(exactly)) = (found, known.t) else { continue };
            hits += 1;
            let off = (f64::from(hit.t) - exactly).abs();
            known.t_error += PRODUCTS / direction.as_dvec3().dot(known.normal).abs();
            known.normal_error += PRODUCTS * shrink;
            assert!(
                off <= known.t_error,
                "{own:?} {ray:?}: {} {exactly}, off by {off:e} of {:e}",
                hit.t,
                known.t_error
            );
            let s = scene.surface_interaction(&ray, &hit, &RayCone::zero_width_cone(Effects::NONE), || 0.0).point;
            let turned = s.ng.as_dvec3().cross(known.normal).length();
            assert!(turned <= known.normal_error, "{own:?} {ray:?}: turned by {turned:e} of {:e}", known.normal_error);
        }
        assert!(hits > RAYS / 5 && doubtful < RAYS / 10, "{own:?} {hits} {doubtful}");
    }
}

/// Only ill-conditioned transforms are refused.
///
/// A transform of condition number 10⁸ is accepted, even if its columns are almost collinear. One
/// that leaves no significant digits is refused, and the error gives its position in the text.
#[test]
fn only_ill_conditioned_transforms_are_refused() {
    let ball = "Sphere { center 0 0 0 radius 1 }";
    let needle = "Rotate { 1 2 3 40 } Scale 1e8 1 1 Rotate { 3 -1 2 70 }";
    assert!(scene(&format!("Group {{ Transform {{ {needle} {ball} }} }}")).is_ok());
    for flat in [
        "Scale 1 0 1",
        "UniformScale 0",
        "Scale 1e-320 1 1",
        "Matrix { 1 2 3 0  2 4 6 0  0 0 1 0  0 0 0 1 }",
        "Matrix { .1 .2 .3 0  .3 .2 .1 0  .4 .4 .4 0  0 0 0 1 }",
        "Rotate { 1 2 3 40 } Scale 1e16 1 1 Rotate { 3 -1 2 70 }",
    ] {
        let error = scene(&format!("Group {{\nTransform {{ {flat} {ball} }} }}")).unwrap_err();
        assert!(error.line() == 3 && error.message().contains("flattens") && !error.remedy().is_empty(), "{error}");
    }
    // Sixty-four transforms are valid alone, but their product is singular. The error points at the
    // innermost one.
    let squeeze = "Transform { Scale 1 1 1e-6\n".repeat(64);
    let error = scene(&format!("Group {{\n{squeeze} {ball} {} }}", "}".repeat(64))).unwrap_err();
    assert!(error.line() == 66 && !error.remedy().is_empty(), "{error}");
}
