//! Boxes, cylinders and cones, tested against bisection of implicit functions and against formulas.

use super::*;
use crate::math::warp;
use glam::{DMat3, DQuat};
use std::f64::consts::PI;

/// A convex solid in object space.
#[derive(Clone, Copy, Debug)]
enum TestSolid {
    /// The cube \[−1, 1]³.
    Cube,
    /// The solid x² + z² ≤ ρ(y)², 0 ≤ y ≤ 1. `radii` are ρ(0) and ρ(1), and ρ is linear.
    Frustum { radii: [f64; 2], capped: bool },
}

/// Cube, cylinders, cones and truncated cones, some of them open.
const SOLIDS: [TestSolid; 7] = [
    TestSolid::Cube,
    TestSolid::Frustum { radii: [1.0, 1.0], capped: true },
    TestSolid::Frustum { radii: [1.0, 1.0], capped: false },
    TestSolid::Frustum { radii: [1.0, 0.0], capped: true },
    TestSolid::Frustum { radii: [0.0, 1.0], capped: false },
    TestSolid::Frustum { radii: [0.4, 1.0], capped: true },
    TestSolid::Frustum { radii: [1.0, 1.0 - 1e-9], capped: true },
];

impl TestSolid {
    fn to_transformed_shape(self, map: &Transform) -> Shape {
        let own = match self {
            Self::Cube => Shape::Cuboid(Cuboid::new(DVec3::NEG_ONE, DVec3::ONE).unwrap()),
            Self::Frustum { radii, capped } => frustum_shape(DVec3::ZERO, DVec3::Y, radii, capped),
        };
        own.transformed(map).unwrap()
    }

    fn is_closed(self) -> bool {
        !matches!(self, Self::Frustum { capped: false, .. })
    }

    /// Object-space point in the middle of the solid.
    fn center(self) -> DVec3 {
        match self {
            Self::Cube => DVec3::ZERO,
            Self::Frustum { .. } => DVec3::Y * 0.5,
        }
    }

    /// Convex function that is negative inside the solid and 0 on its surface.
    fn implicit_value(self, p: DVec3) -> f64 {
        match self {
            Self::Cube => p.abs().max_element() - 1.0,
            Self::Frustum { .. } => self.side_implicit_value(p).max(-p.y).max(p.y - 1.0),
        }
    }

    /// Convex function that is negative inside the infinite cone or cylinder around the side, and 0
    /// on it.
    ///
    /// For a cube, it equals [`TestSolid::implicit_value`].
    fn side_implicit_value(self, p: DVec3) -> f64 {
        match self {
            Self::Cube => self.implicit_value(p),
            Self::Frustum { radii: [a, b], .. } => libm::hypot(p.x, p.z) - (a + (b - a) * p.y),
        }
    }

    /// Ray parameters at which `ray` enters and leaves the solid under `map`; `None` if the ray
    /// misses.
    ///
    /// Also returns the minimum of [`TestSolid::implicit_value`] along the line of the ray. Ternary
    /// search finds the minimum, and bisection finds entry and exit.
    fn entry_and_exit(self, map: &Transform, ray: &Ray) -> (Option<[f64; 2]>, f64) {
        let o = map.inverse().transform_point3(ray.origin.as_dvec3());
        let d = map.inverse().transform_vector3(ray.direction.as_dvec3());
        let value = |t: f64| self.implicit_value(o + d * t);
        let nearest = (self.center() - o).dot(d) / d.length_squared();
        let reach = 4.0 / d.length();
        let (mut low, mut high) = (nearest - reach, nearest + reach);
        for _ in 0..90 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if value(a) < value(b) { high = b } else { low = a }
        }
        let deepest = 0.5 * (low + high);
        let least = value(deepest);
        if least > 0.0 {
            return (None, least);
        }
        let bisect = |mut outside: f64| {
            let mut inside = deepest;
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                if value(middle) > 0.0 { outside = middle } else { inside = middle }
            }
            outside
        };
        (Some([bisect(nearest - reach), bisect(nearest + reach)]), least)
    }
}

/// Object-to-world maps of the test shapes, with uniform and uneven scales, among them extreme
/// scales, a shear and a mirror image.
fn affine_test_transforms() -> Vec<Transform> {
    let turn = DQuat::from_xyzw(0.1, -0.5, 0.7, 0.5).normalize();
    let shear = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(-0.5, 0.8, 0.2), DVec3::new(0.0, 0.4, 1.5));
    let affine = [
        DAffine3::IDENTITY,
        DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 0.2, 2.5), turn, DVec3::new(0.3, -2.0, 1.0)),
        DAffine3 { matrix3: shear, translation: DVec3::new(-1.0, 2.0, 3.0) },
        DAffine3::from_scale_rotation_translation(DVec3::splat(1e-6), turn, DVec3::splat(1e-6)),
        DAffine3::from_scale_rotation_translation(DVec3::splat(-1e7), turn, DVec3::new(1e7, 0.0, -3e6)),
        DAffine3::from_scale_rotation_translation(DVec3::new(1.0, 1e-3, 1.0), turn, DVec3::new(0.5, 0.0, 2.0)),
    ];
    affine.into_iter().map(|map| Transform::new(map).unwrap()).collect()
}

fn random_key(i: u64) -> Key {
    Key::new(21).purpose_key(Purpose::Test).child_key(i)
}

fn random_direction(i: u64) -> DVec3 {
    warp::square_to_uniform_sphere(random_key(i).uniform_2d(Dimension::LightDirection)).as_dvec3()
}

/// Point `i` of a sequence of random points on the edges or rims of a solid.
fn random_point_on_edge(solid: TestSolid, i: u64) -> DVec3 {
    let u = random_key(i).uniform_2d(Dimension::LightPosition).as_dvec2();
    match solid {
        TestSolid::Cube => {
            let mut p = DVec3::new(1.0, if (i / 4).is_multiple_of(2) { 1.0 } else { -1.0 }, 2.0 * u.x - 1.0);
            (0..i % 3).for_each(|_| p = DVec3::new(p.y, p.z, p.x));
            p
        }
        TestSolid::Frustum { radii, .. } => {
            let (sin, cos) = libm::sincos(u.x * 2.0 * PI);
            let y = (i / 4 % 2) as usize;
            DVec3::new(cos * radii[y], y as f64, sin * radii[y])
        }
    }
}

/// Hits of solids agree with bisection of their implicit functions.
///
/// The rays start outside and inside, and pass through faces, edges and apexes.
#[test]
fn hits_agree_with_bisection() {
    for solid in SOLIDS {
        for (m, map) in affine_test_transforms().into_iter().enumerate() {
            let shape = solid.to_transformed_shape(&map);
            let (mut hits, mut compared) = (0, 0);
            for i in 0..4_000 {
                let target = match i % 4 {
                    0 => random_point_on_edge(solid, i),
                    1 => solid.center() + 1.2 * random_direction(i),
                    _ => solid.center() + random_direction(i + 1_000_000) * 0.7,
                };
                let distance = [0.3, 3.0, 30.0][i as usize % 3];
                let from = map.transform_point(solid.center() + random_direction(i + 2_000_000) * distance).as_vec3();
                let ray = Ray::new(from, map.transform_point(target).as_vec3() - from);
                let (interval, least) = solid.entry_and_exit(&map, &ray);
                // Skip rays that touch the surface within rounding: a hit and a miss are both
                // correct.
                if least.abs() < 1e-9 || ray.direction == Vec3::ZERO {
                    continue;
                }
                let at = |t: f64| {
                    let world = ray.origin.as_dvec3() + ray.direction.as_dvec3() * t;
                    map.inverse().transform_point3(world)
                };
                let on_side = |t: f64| solid.side_implicit_value(at(t)) > -1e-9;
                let mut candidates = interval.into_iter().flatten();
                // Skip rays that cross the surface within rounding of their origin, or near a rim
                // of an open solid.
                let doubtful = |t: f64| {
                    let (p, y) = (at(t), at(t).y);
                    let at_rim = solid.side_implicit_value(p).abs() < 1e-6 && y.abs().min((y - 1.0).abs()) < 1e-6;
                    t.abs() < 1e-6 || !solid.is_closed() && at_rim
                };
                if candidates.clone().any(doubtful) {
                    continue;
                }
                let expected = candidates.find(|t| *t > 0.0 && (solid.is_closed() || on_side(*t)));
                let found = shape.intersect(&ray);
                assert_eq!(found.is_some(), expected.is_some(), "{solid:?} {m} {i} {ray:?} {found:?} {expected:?}");
                compared += 1;
                let (Some(ShapeHit { t, shape_coords: uv }), Some(expected)) = (found, expected) else { continue };
                hits += 1;
                assert!((f64::from(t) / expected - 1.0).abs() < 1e-6, "{solid:?} {m} {i}: {t} {expected}");
                let point = shape.surface_point(&ray, t, uv);
                let p = map.inverse().transform_point3(point.p.as_dvec3());
                let rows = map.inverse().matrix3.transpose();
                let widest = rows.x_axis.length().max(rows.y_axis.length()).max(rows.z_axis.length());
                let off = widest * f64::from(point.position_error.max_element()) * 2.0;
                assert!(
                    solid.implicit_value(p).abs() <= off,
                    "{solid:?} {m} {i}: {p} is off by {} of {off}",
                    solid.implicit_value(p)
                );
                // Where the ray enters the solid, the outer normal points against the ray.
                let enters = solid.implicit_value(at(0.0)) > 0.0 && Some(expected) == interval.map(|i| i[0]);
                assert_eq!(point.ng.dot(ray.direction) < 0.0, enters, "{solid:?} {m} {i} {point:?}");
            }
            assert!(hits > 1_200 && compared > 2_500, "{solid:?} {m}: {hits} {compared}");
        }
    }
}

/// Rays that start inside a closed solid hit it, even if they point at its edges and rims.
#[test]
fn inner_rays_never_escape() {
    for solid in SOLIDS.into_iter().filter(|s| s.is_closed()) {
        for map in affine_test_transforms() {
            let shape = solid.to_transformed_shape(&map);
            for i in 0..20_000 {
                let from = map.transform_point(solid.center() + 0.1 * random_direction(i)).as_vec3();
                let ray = Ray::new(from, map.transform_point(random_point_on_edge(solid, i)).as_vec3() - from);
                assert!(shape.intersect(&ray).is_some() && shape.occludes(&ray), "{solid:?} {i} {ray:?}");
            }
        }
    }
}

/// Rays from offset origins on a solid do not hit the solid at their origin.
///
/// An outward ray misses the solid, and an inward ray hits the far side.
#[test]
fn offset_origins_prevent_self_intersection_of_solids() {
    let scales = [1e-6, 1.0, 1e6];
    for solid in SOLIDS.into_iter().filter(|s| s.is_closed()) {
        for (scale, center) in scales.into_iter().flat_map(|s| [(s, DVec3::ZERO), (s, DVec3::new(3.0, -50.0, 9.0) * s)])
        {
            let turn = DQuat::from_xyzw(0.3, 0.5, -0.2, 0.7).normalize();
            let map = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, center);
            let map = Transform::new(map).unwrap();
            let shape = solid.to_transformed_shape(&map);
            for i in 0..10_000 {
                // Half of the points are on edges, where the neighbouring face is near.
                let target = if i % 2 == 0 {
                    random_point_on_edge(solid, i)
                } else {
                    solid.center() + 0.6 * random_direction(i)
                };
                let inner = map.transform_point(solid.center() + 0.1 * random_direction(i + 7)).as_vec3();
                let ray = Ray::new(inner, map.transform_point(target).as_vec3() - inner);
                let ShapeHit { t, shape_coords: uv } = shape.intersect(&ray).expect("inner rays hit");
                let s = shape.surface_point(&ray, t, uv);
                let d = warp::square_to_cosine_hemisphere(random_key(i).uniform_2d(Dimension::LightPosition));
                let d = crate::math::Frame::from_normal(s.ng).to_world(d);
                let out = Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, d), d);
                assert!(shape.intersect(&out).is_none(), "{solid:?} {scale} {i} {out:?}");
                let back = Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, -d), -d);
                let ShapeHit { t, shape_coords: uv } = shape.intersect(&back).expect("an inward ray hits the far side");
                let far = shape.surface_point(&back, t, uv);
                assert!(far.ng.dot(back.direction) > 0.0, "{solid:?} {scale} {i} {back:?}");
            }
        }
    }
}

/// Rays along faces, along axes, and along the straight lines of a cone's side hit at known
/// distances.
#[test]
fn grazing_and_axial_rays_hit_at_known_distances() {
    let cube = Shape::Cuboid(Cuboid::new(DVec3::NEG_ONE, DVec3::ONE).unwrap());
    let hit = |shape: &Shape, o: Vec3, d: Vec3| shape.intersect(&Ray::new(o, d)).map(|hit| hit.t);
    assert_eq!(hit(&cube, Vec3::new(-3.0, 0.0, 0.0), Vec3::X), Some(2.0));
    assert_eq!(hit(&cube, Vec3::ZERO, Vec3::X * 0.5), Some(2.0));
    assert_eq!(hit(&cube, Vec3::new(-3.0, 1.0f32.next_up(), 0.0), Vec3::X), None);
    assert_eq!(hit(&cube, Vec3::new(-3.0, 1.0f32.next_down(), 0.0), Vec3::X), Some(2.0));
    assert_eq!(hit(&cube, Vec3::new(3.0, 0.0, 0.0), Vec3::X), None);
    let tube = frustum_shape(DVec3::ZERO, DVec3::Y, [1.0, 1.0], false);
    assert_eq!(hit(&tube, Vec3::new(0.0, -3.0, 0.0), Vec3::Y), None, "through both open ends");
    assert_eq!(hit(&tube, Vec3::new(0.5, -1.0, 0.0), Vec3::new(0.5, 1.5, 0.0)), Some(1.0), "the inside of the side");
    assert_eq!(hit(&tube, Vec3::new(0.0, 0.5, 3.0), -Vec3::Z), Some(2.0));
    let can = frustum_shape(DVec3::ZERO, DVec3::Y, [1.0, 1.0], true);
    assert_eq!(hit(&can, Vec3::new(0.25, -3.0, 0.5), Vec3::Y), Some(3.0));
    assert_eq!(hit(&can, Vec3::new(0.25, 0.5, 0.5), Vec3::Y), Some(0.5));
    assert_eq!(hit(&can, Vec3::new(1.0f32.next_up(), -3.0, 0.0), Vec3::Y), None);
    let pointed = frustum_shape(DVec3::ZERO, DVec3::Y, [1.0, 0.0], true);
    assert_eq!(hit(&pointed, Vec3::new(0.0, 3.0, 0.0), -Vec3::Y), Some(2.0), "the apex from above");
    assert_eq!(hit(&pointed, Vec3::new(0.25, 3.0, 0.0), -Vec3::Y), Some(2.25));
    // The first ray is parallel to a generator inside the cone, the second beside the cone.
    let along = Vec3::new(-1.0, 1.0, 0.0);
    assert_eq!(hit(&pointed, Vec3::new(1.5, -1.0, 0.0), along), Some(1.0), "through the base, then out at the side");
    assert_eq!(hit(&pointed, Vec3::new(2.5, -1.0, 0.0), along), None);
    // The mirror image of the cone above its apex is not a part of the shape.
    assert_eq!(hit(&pointed, Vec3::new(0.0, 1.5, 3.0), -Vec3::Z), None);
}

/// Areas agree with closed forms.
///
/// The area of an elliptical cylinder uses Ramanujan's formula for the perimeter, whose relative
/// error is below 10⁻⁹ here.
#[test]
fn areas_match_formulas() {
    let near = |shape: Shape, area: f64| assert!((shape.area() / area - 1.0).abs() < 1e-8, "{shape:?} {area}");
    near(Shape::Cuboid(Cuboid::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)).unwrap()), 22.0);
    let (r, h) = (0.7, 1.3);
    near(frustum_shape(DVec3::ONE, DVec3::ONE + DVec3::X * h, [r, r], false), 2.0 * PI * r * h);
    near(frustum_shape(DVec3::ONE, DVec3::ONE + DVec3::X * h, [r, r], true), 2.0 * PI * r * (h + r));
    near(frustum_shape(DVec3::ONE, DVec3::ONE - DVec3::Z * h, [r, 0.0], false), PI * r * libm::hypot(r, h));
    near(frustum_shape(DVec3::ZERO, DVec3::Y * h, [0.0, r], true), PI * r * (libm::hypot(r, h) + r));
    let (a, b) = (0.2, r);
    let side = PI * (a + b) * libm::hypot(b - a, h);
    near(frustum_shape(DVec3::ZERO, DVec3::Y * h, [a, b], true), side + PI * (a * a + b * b));
    let stretch = Transform::new(DAffine3::from_scale(DVec3::new(1.2, 2.0, 1.0))).unwrap();
    let (a, b) = (1.2, 1.0);
    let q = (a - b) * (a - b) / ((a + b) * (a + b));
    let perimeter = PI * (a + b) * (1.0 + 3.0 * q / (10.0 + (4.0 - 3.0 * q).sqrt()));
    near(frustum_shape(DVec3::ZERO, DVec3::Y, [1.0, 1.0], false).transformed(&stretch).unwrap(), 2.0 * perimeter);
}

/// Samples of solids are uniform by area: a chi-square test with a false-alarm rate of 10⁻⁶.
#[test]
fn samples_are_uniform_by_area() {
    let turn = DQuat::from_xyzw(0.1, -0.5, 0.7, 0.5).normalize();
    let map = DAffine3::from_scale_rotation_translation(DVec3::splat(0.3), turn, DVec3::new(1.0, 2.0, 3.0));
    let map = Transform::new(map).unwrap();
    for solid in SOLIDS {
        let shape = solid.to_transformed_shape(&map);
        // Bins divide the surface by face or part and by two coordinates. On a face these are x and
        // y, on other parts an angle and a height or radius. `expected` holds the areas of the
        // bins.
        let mut expected: Vec<f64> = Vec::new();
        match solid {
            TestSolid::Cube => expected.resize(6 * 16, 1.0),
            TestSolid::Frustum { radii: [a, b], capped } => {
                let slope = libm::hypot(1.0, a - b);
                for bin in 0..48 {
                    let (part, level) = (bin / 16, f64::from(bin % 4));
                    let (low, high) = (level / 4.0, (level + 1.0) / 4.0);
                    let rho = |y: f64| a + (b - a) * y;
                    let cap = |r: f64| if capped { PI / 4.0 * r * r * (high * high - low * low) } else { 0.0 };
                    expected.push(match part {
                        0 => PI / 4.0 * (rho(low) + rho(high)) * (high - low) * slope,
                        1 => cap(a),
                        _ => cap(b),
                    });
                }
            }
        }
        let total: f64 = expected.iter().sum();
        let mut counts = vec![0.0; expected.len()];
        let n = 200_000;
        for i in 0..n {
            let sample = shape.sample(random_key(i).uniform_2d(Dimension::LightPosition));
            let p = map.inverse().transform_point3(sample.point.p.as_dvec3());
            let part = sample.shape_coords.y as usize;
            let quarter = |x: f64| ((x * 4.0) as usize).min(3);
            let bin = match solid {
                TestSolid::Cube => {
                    let (u, v) = (p[(part / 2 + 1) % 3], p[(part / 2 + 2) % 3]);
                    16 * part + 4 * quarter(0.5 + 0.5 * u) + quarter(0.5 + 0.5 * v)
                }
                TestSolid::Frustum { radii, .. } => {
                    let turns = 0.5 + libm::atan2(p.z, p.x) / (2.0 * PI);
                    let level = if part == 0 { p.y } else { libm::hypot(p.x, p.z) / radii[part - 1].max(1e-9) };
                    16 * part + 4 * quarter(turns) + quarter(level)
                }
            };
            counts[bin] += 1.0;
        }
        let mut degrees = -1.0;
        let mut chi2 = 0.0;
        for (count, area) in counts.into_iter().zip(expected) {
            let mean = area / total * n as f64;
            if mean < 1e-3 {
                assert!(count == 0.0, "{solid:?}: samples where there is no area");
                continue;
            }
            degrees += 1.0;
            chi2 += (count - mean) * (count - mean) / mean;
        }
        // The normal approximation is Wilson and Hilferty's. 4.75 standard deviations are exceeded
        // with a probability of 10⁻⁶.
        let k = 2.0 / (9.0 * degrees);
        let deviations = (libm::cbrt(chi2 / degrees) - 1.0 + k) / k.sqrt();
        assert!(deviations < 4.75, "{solid:?}: χ² is {chi2} for {degrees}");
    }
}

/// Two estimates of the solid angle seen from a point agree within five standard errors.
///
/// One is the mean over area samples, the other the fraction of random directions that hit.
#[test]
fn area_samples_measure_the_visible_solid_angle() {
    let map = &affine_test_transforms()[1];
    for solid in SOLIDS.into_iter().filter(|s| s.is_closed()) {
        let shape = solid.to_transformed_shape(map);
        let from = map.transform_point(DVec3::new(0.8, 1.9, -1.4)).as_vec3();
        let n = 400_000;
        let [mut sum, mut squares, mut hits] = [0.0f64; 3];
        for i in 0..n {
            let s = shape.sample(random_key(i).uniform_2d(Dimension::LightPosition));
            let to = s.point.p - from;
            let (d2, w) = (to.length_squared(), to.normalize());
            let term = f64::from((-w.dot(s.point.ng)).max(0.0) / (d2 * s.pdf));
            sum += term;
            squares += term * term;
            hits += f64::from(u8::from(shape.occludes(&Ray::new(from, random_direction(i).as_vec3()))));
        }
        let n = n as f64;
        let (mean, share) = (sum / n, hits / n);
        let variance = (squares / n - mean * mean) / n + 16.0 * PI * PI * share * (1.0 - share) / n;
        let off = (mean - 4.0 * PI * share).abs();
        assert!(off < 5.0 * variance.sqrt(), "{solid:?}: {mean} {}", 4.0 * PI * share);
    }
}

/// Texture gradients agree with differences of the coordinates along the surface.
#[test]
fn texture_gradients_match_differences() {
    for solid in SOLIDS {
        let map = &affine_test_transforms()[2];
        let shape = solid.to_transformed_shape(map);
        for i in 0..2000 {
            let s = shape.sample(random_key(i).uniform_2d(Dimension::LightPosition));
            let at = |p: DVec3| shape.tex_coord(p.as_vec3(), s.shape_coords);
            let p = s.point.p.as_dvec3();
            let own = map.inverse().transform_point3(p);
            // Near the axis, gradients of the azimuth have no bound.
            if libm::hypot(own.x, own.z) < 0.2 {
                continue;
            }
            let here = at(p);
            assert!(
                here.uv.cmpge(glam::DVec2::splat(-1e-6)).all() && here.uv.cmple(glam::DVec2::splat(1.0 + 1e-6)).all()
            );
            let (t, b) = s.point.ng.any_orthonormal_pair();
            for step in [t.as_dvec3(), b.as_dvec3()] {
                let length = 1.0 / 256.0;
                let change = (at(p + step * length).uv - at(p - step * length).uv) / (2.0 * length);
                // The azimuth is continuous except at its seam.
                if change.length() > 20.0 {
                    continue;
                }
                let expected = glam::DVec2::new(here.grad_u.dot(step), here.grad_v.dot(step));
                assert!((change - expected).length() < 2e-3, "{solid:?} {i} {change} {expected}");
            }
        }
    }
}

#[test]
fn shapes_without_extent_are_refused() {
    assert!(Cuboid::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)).is_none());
    assert!(Cuboid::new(DVec3::ZERO, DVec3::splat(f64::NAN)).is_none());
    assert!(Frustum::cylinder(DVec3::ONE, DVec3::ONE, 1.0, true).is_none());
    assert!(Frustum::cone(DVec3::ONE, DVec3::ZERO, 0.0, true).is_none());
}

/// Normals of a mirrored solid point outward.
#[test]
fn mirrored_solids_face_outward() {
    let mirror = Transform::new(DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1.0))).unwrap();
    for solid in SOLIDS {
        let shape = solid.to_transformed_shape(&mirror);
        let ray = Ray::new(Vec3::new(9.0, 0.8, 0.0), Vec3::NEG_X);
        let ShapeHit { t, shape_coords: uv } = shape.intersect(&ray).unwrap();
        assert!(shape.surface_point(&ray, t, uv).ng.x > 0.5, "{solid:?}");
    }
}
