//! Tangent rays at silhouettes and double roots; integer arithmetic gives the exact answer.

use caustica::accel::ShapeHit;
use caustica::math::{Ray, Transform};
use caustica::shape::{Shape, Sphere};
use glam::{DAffine3, DVec3, I64Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

/// Returns a random rotation with integer entries: an orthogonal matrix times a scale factor, and
/// this factor.
///
/// The factor is the squared length of an integer quaternion.
fn turn(rng: &mut SmallRng) -> ([I64Vec3; 3], i64) {
    let [a, b, c, d] = std::array::from_fn(|_| rng.random_range(-6i64..=6));
    let columns = [
        I64Vec3::new(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)),
        I64Vec3::new(2 * (b * c - a * d), a * a - b * b + c * c - d * d, 2 * (c * d + a * b)),
        I64Vec3::new(2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d),
    ];
    (columns, a * a + b * b + c * c + d * d)
}

/// Rays that touch a sphere exactly, or are off a tangent by one part in up to 10⁷, are decided
/// correctly.
///
/// A non-zero discriminant is far above double-precision rounding, so its sign must be right. With
/// a zero discriminant, hit and miss are both right, but a hit must be at the root.
#[test]
#[ignore = "long: many samples of a hard case"]
fn silhouettes_match_closed_form() {
    let mut rng = SmallRng::seed_from_u64(6);
    // Scale factors that are powers of two turn a sphere into an ellipsoid without rounding.
    let stretch = DVec3::new(2.0, 0.25, 1.0);
    let map = Transform::new(DAffine3::from_scale(stretch)).unwrap();
    let (mut touched, mut decided) = ([0; 2], 0);
    for i in 0..300_000u32 {
        let ([x, y, _], q) = turn(&mut rng);
        if q == 0 {
            continue;
        }
        let radius = rng.random_range(1i64..=1000);
        let center = I64Vec3::from_array(std::array::from_fn(|_| rng.random_range(-500..=500)));
        let away = rng.random_range(1..=10_000i64);
        let nudge = |rng: &mut SmallRng| I64Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1..=1)));
        let from = center - x * away + y * radius + if i % 3 == 0 { I64Vec3::ZERO } else { nudge(&mut rng) };
        let (r, l, d) = (i128::from(radius * q), from - center, x);
        if d == I64Vec3::ZERO || from.abs().max_element() >= 1 << 22 {
            continue;
        }
        let dot = |a: I64Vec3, b: I64Vec3| i128::from(a.dot(b));
        let (a, b) = (dot(d, d), dot(l, d));
        let discriminant = b * b - a * (dot(l, l) - r * r);
        let sphere = Shape::Sphere(Sphere::new(center.as_dvec3(), r as f64));
        // An ellipsoid integrates its area when it is built, which takes as long as thousands of
        // rays.
        let egg = (i % 200 < 3).then(|| (sphere.transformed(&map).unwrap(), stretch));
        for (shape, s) in [Some((sphere, DVec3::ONE)), egg].into_iter().flatten() {
            let ray = Ray::new((from.as_dvec3() * s).as_vec3(), (d.as_dvec3() * s).as_vec3());
            let found = shape.intersect(&ray);
            // The squared distance rounds: the foot of the perpendicular has an error of some ulps
            // of |l|. It is multiplied by 2r and a.
            let blur = 64.0 * f64::EPSILON * (r as f64) * l.as_dvec3().length() * a as f64;
            let root = (discriminant.max(0) as f64).sqrt();
            // A ray that starts inside hits at the far root.
            let near = (-(b as f64) - root) / a as f64;
            let exact = if near > 0.0 { near } else { (root - b as f64) / a as f64 };
            let allowed = exact * 6e-8 + blur.sqrt().min(blur / root) / a as f64;
            if discriminant == 0 {
                touched[usize::from(found.is_some())] += 1;
            } else {
                assert!(discriminant.unsigned_abs() as f64 > blur, "this test decides what rounding cannot");
                assert_eq!(found.is_some(), discriminant > 0 && exact > 0.0, "{ray:?} {shape:?}: {discriminant}");
                decided += 1;
            }
            if let Some(ShapeHit { t, .. }) = found {
                assert!((f64::from(t) - exact).abs() <= allowed, "{ray:?} {shape:?}: {t} {exact} {allowed}");
            }
        }
    }
    assert!(touched[0] + touched[1] > 80_000 && decided > 150_000, "{touched:?} {decided}");
}
