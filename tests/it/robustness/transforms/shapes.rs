//! Shapes under transforms of condition number 10⁸, against double-double references.

use super::double_double::{Affine, DoubleDouble, DoubleDoubleVec};
use super::maps::maps;
use caustica::accel::ShapeHit;
use caustica::math::{Ray, Transform, offset_ray_origin, warp};
use caustica::shape::parametric_surface::SplineBasis;
use caustica::shape::{Disc, Patch, Rectangle, Revolution, Shape, Sphere, SurfacePoint};
use glam::{DAffine3, DVec2, DVec3, DVec4, Vec2, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Test shapes in object space.
#[derive(Clone, Copy, Debug)]
pub enum UnitShape {
    /// The sphere |p| = 1.
    Ball,
    /// The disc y = 0 for x² + z² ≤ 1.
    Disc,
    /// The square y = 0 for |x| and |z| ≤ 1.
    Square,
    /// The cylinder x² + z² = 1 for |y| ≤ 1.
    Tube,
    /// The paraboloid y = x² + z² for |x| and |z| ≤ 1.
    Bowl,
}

impl UnitShape {
    pub fn shape(self) -> Shape {
        match self {
            Self::Ball => Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)),
            Self::Disc => Shape::Disc(Disc::circular_disc(DVec3::ZERO, DVec3::Y, 1.0)),
            Self::Square => {
                Shape::Rectangle(Rectangle::new(DVec3::new(-1.0, 0.0, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0))
            }
            Self::Tube => {
                let line = SplineBasis::bezier_basis(2).unwrap();
                let controls = [DVec2::new(1.0, -1.0), DVec2::new(1.0, 1.0)];
                Shape::Revolution(Revolution::new(&line, &controls).unwrap())
            }
            Self::Bowl => {
                let basis = SplineBasis::bezier_basis(3).unwrap();
                // Bézier control values of x and x², from their blossoms.
                let (place, square) = ([-1.0, 0.0, 1.0], [1.0, -1.0, 1.0]);
                let control = |k: usize| DVec4::new(place[k % 3], square[k / 3] + square[k % 3], place[k / 3], 1.0);
                let controls: Vec<DVec4> = (0..9).map(control).collect();
                Shape::Patch(Patch::new([&basis, &basis], &controls).unwrap())
            }
        }
    }

    /// Returns a point of the shape.
    pub fn point(self, u: Vec2) -> DVec3 {
        let (a, b) = (f64::from(u.x) * 2.0 - 1.0, f64::from(u.y) * 2.0 - 1.0);
        match self {
            Self::Ball => warp::square_to_uniform_sphere(u).as_dvec3().normalize(),
            Self::Disc => {
                let d = warp::square_to_uniform_disc(u).as_dvec2();
                DVec3::new(d.x, 0.0, d.y)
            }
            Self::Square => DVec3::new(a, 0.0, b),
            Self::Tube => {
                let (s, c) = libm::sincos(a * std::f64::consts::PI);
                DVec3::new(c, b, s)
            }
            Self::Bowl => DVec3::new(a, a * a + b * b, b),
        }
    }

    /// Returns the coefficients \[c, b, a] of F(o + t d) = c + 2 b t + a t².
    ///
    /// F is a function that is 0 on the surface, without regard to its borders.
    fn quadratic(self, o: DoubleDoubleVec, d: DoubleDoubleVec) -> [DoubleDouble; 3] {
        let ([ox, oy, oz], [dx, dy, dz]) = (o.0, d.0);
        let half = DoubleDouble::from(0.5);
        let round = [ox * ox + oz * oz, ox * dx + oz * dz, dx * dx + dz * dz];
        match self {
            Self::Ball => [o.dot(o) - DoubleDouble::ONE, o.dot(d), d.dot(d)],
            Self::Disc | Self::Square => [oy, dy * half, DoubleDouble::ZERO],
            Self::Tube => [round[0] - DoubleDouble::ONE, round[1], round[2]],
            Self::Bowl => [round[0] - oy, round[1] - dy * half, round[2]],
        }
    }

    fn gradient(self, p: DoubleDoubleVec) -> DoubleDoubleVec {
        let [x, _, z] = p.0;
        let two = DoubleDouble::from(2.0);
        match self {
            Self::Ball => p,
            Self::Disc | Self::Square => DoubleDoubleVec([DoubleDouble::ZERO, DoubleDouble::ONE, DoubleDouble::ZERO]),
            Self::Tube => DoubleDoubleVec([x, DoubleDouble::ZERO, z]),
            Self::Bowl => DoubleDoubleVec([two * x, -DoubleDouble::ONE, two * z]),
        }
    }

    /// Returns how far inside the borders of the surface a point is; negative if it is outside.
    fn within(self, p: DoubleDoubleVec) -> f64 {
        let [x, y, z] = p.0.map(DoubleDouble::value);
        match self {
            Self::Ball => 1.0,
            Self::Disc => 1.0 - libm::hypot(x, z),
            Self::Tube => 1.0 - y.abs(),
            Self::Square | Self::Bowl => 1.0 - x.abs().max(z.abs()),
        }
    }
}

/// Exact result of intersecting a ray with a transformed shape, and the allowed errors.
pub struct ExactHit {
    /// Ray parameter of the hit; `None` for a miss.
    pub t: Option<f64>,
    /// Allowed error of `t`.
    pub t_error: f64,
    /// Position of the hit in object space.
    pub hit: DVec3,
    /// Unit normal in world space, of either sign.
    pub normal: DVec3,
    /// Allowed error of `normal` \[rad].
    pub normal_error: f64,
    /// True if the ray touches the shape, or passes a border, within rounding: hit and miss are
    /// both right.
    pub doubtful: bool,
}

/// Relative rounding error in f64 of coordinates that are transformed to object space.
const TRANSFORM_ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Error of positions on a spline shape of size 2: 256 · 32 ulps.
const SPLINE_ROUNDING: f64 = 256.0 * 32.0 * f64::EPSILON * 2.0;

/// Returns the nearest hit beyond `t = 0` of a ray from `origin`, with its allowed errors.
///
/// The errors are bounded as follows. n is the unit normal and d the direction of the ray, both in
/// object space; M is the transform to world space.
///
/// - An error e of positions in object space changes t by e/|d·n|.
/// - The hit point then moves by e + |d| · (change of t).
/// - The object normal turns by at most twice as much, because no radius of curvature is below ½.
/// - The world normal turns by |M⁻¹|/|M⁻ᵀn| times as much as the object normal.
/// - A flat shape is stored as two edge vectors in world space. Each edge has an error of some ulps
///   of |M|, divided by its distance from the other edge.
pub fn exact_hit(own: UnitShape, exact: &Affine, origin: DoubleDoubleVec, direction: DoubleDoubleVec) -> ExactHit {
    let (o, d) = (exact.point_back(origin), exact.back(direction));
    let [c, b, a] = own.quadratic(o, d);
    let discriminant = b * b - a * c;
    let roots = if a.value() == 0.0 {
        vec![-(c / (b + b))]
    } else if discriminant < DoubleDouble::ZERO {
        vec![]
    } else {
        let root = discriminant.sqrt();
        vec![(-b - root) / a, (-b + root) / a]
    };
    let lengths = |v: [DoubleDoubleVec; 3]| v.map(|c| c.value().length_squared()).iter().sum::<f64>().sqrt();
    let (stretch, shrink) = (lengths(exact.columns), lengths(exact.inverse_rows()));
    let place = exact.shift.value().length();
    let (from, pace) = (origin.value().length(), direction.value().length());
    let flat = matches!(own, UnitShape::Disc | UnitShape::Square);
    let splines = if matches!(own, UnitShape::Tube | UnitShape::Bowl) { SPLINE_ROUNDING } else { 0.0 };
    let [x, y, z] = exact.columns;
    let volume = x.dot(y.cross(z)).value().abs();
    // For a miss, `middle` is where the ray is nearest to the shape.
    let middle = if a.value() == 0.0 { DoubleDouble::ZERO } else { -(b / a) };
    let mut result =
        ExactHit { t: None, t_error: 0.0, hit: DVec3::ZERO, normal: DVec3::Y, normal_error: 0.0, doubtful: false };
    let reach = |t: f64| from + t.abs() * pace + place + stretch;
    let noise = |t: f64| TRANSFORM_ROUNDING * shrink * reach(t) + splines;
    // The gradient of F is at most 6 long in the relevant region.
    let touch = discriminant.value().abs() / a.value().abs().max(d.value().length_squared() * 1e-30);
    result.doubtful |= !flat && touch < 40.0 * noise(middle.value());
    for t in roots {
        let p = o + d.scaled(t);
        let at = t.value();
        let gradient = own.gradient(p);
        let n = gradient.value().normalize();
        let along = d.value().dot(n).abs();
        let world = exact.normal(gradient).value();
        let turned = world.length() / gradient.value().length();
        let (t_error, normal_error) = if flat {
            let cos = direction.value().dot(world.normalize()).abs();
            (TRANSFORM_ROUNDING * reach(at) / cos, TRANSFORM_ROUNDING * stretch * stretch / (volume * turned))
        } else {
            let t_error = noise(at) / along;
            (t_error, 2.0 * shrink * (noise(at) + d.value().length() * t_error) / turned)
        };
        let moved = if flat {
            noise(at) + d.value().length() * t_error
        } else {
            noise(at) * (1.0 + d.value().length() / along)
        };
        let within = own.within(p);
        result.doubtful |= at > -t_error && within.abs() <= 2.0 * moved || at.abs() <= t_error;
        if at > 0.0 && within >= 0.0 && result.t.is_none_or(|t| at < t) {
            (result.t, result.t_error) = (Some(at), t_error + 6e-8 * at);
            result.hit = p.value();
            (result.normal, result.normal_error) = (world.normalize(), normal_error + 2e-7);
        }
    }
    result
}

/// Returns the distance of the point `s` from the shape along its normal, divided by the error
/// bound that `s` states.
///
/// The hit is expected at `hit` in object space. `None` if rounding to f32 moves the point so far
/// that the curvature of the shape matters.
fn distance_off_shape(own: UnitShape, exact: &Affine, s: &SurfacePoint, hit: DVec3) -> Option<f64> {
    let p = exact.point_back(DoubleDoubleVec::from(s.p.as_dvec3()));
    let [value, ..] = own.quadratic(p, DoubleDoubleVec::from(DVec3::ZERO));
    let gradient = own.gradient(p);
    let half = if matches!(own, UnitShape::Ball | UnitShape::Tube) { 0.5 } else { 1.0 };
    let moved = (p.value() - hit).length();
    let off = half * (value.value().abs() - 2.0 * moved * moved).max(0.0) / exact.normal(gradient).value().length();
    (moved < 0.1).then(|| off / f64::from(s.ng.abs().dot(s.position_error)))
}

/// Hits of shapes under transforms of condition number 10⁸ have the right distance and normal.
///
/// The hit point lies within its stated error, and a ray that leaves it outwards does not hit the
/// shape again.
#[test]
#[ignore = "long: many rays in exact arithmetic"]
fn shape_hits_match_double_double_transforms() {
    let shapes = [UnitShape::Ball, UnitShape::Disc, UnitShape::Square, UnitShape::Tube, UnitShape::Bowl];
    let cases: Vec<(UnitShape, &str, DAffine3)> =
        shapes.into_iter().flat_map(|own| maps().into_iter().map(move |(name, map)| (own, name, map))).collect();
    cases.into_par_iter().for_each(|(own, name, map)| {
        let transform = Transform::new(map).unwrap();
        let shape = own.shape().transformed(&transform).unwrap();
        let exact = Affine::from(map);
        let size = map.matrix3.x_axis.length() + map.matrix3.y_axis.length() + map.matrix3.z_axis.length();
        let mut rng = SmallRng::seed_from_u64(5);
        let (mut hits, mut doubtful) = (0, 0);
        const RAYS: u32 = 10_000;
        for _ in 0..RAYS {
            let mut place = || own.point(Vec2::new(rng.random(), rng.random()));
            let (target, other) = (transform.transform_point(place()), place() * 2.0);
            let away = warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random())).as_dvec3();
            let near = transform.transform_point(other + away);
            let origin = (if rng.random() { near } else { target + away * (size * 2.0) }).as_vec3();
            let ray = Ray::new(origin, target.as_vec3() - origin);
            if ray.direction == Vec3::ZERO {
                continue;
            }
            let known = exact_hit(own, &exact, origin.as_dvec3().into(), ray.direction.as_dvec3().into());
            if known.doubtful {
                doubtful += 1;
                continue;
            }
            let found = shape.intersect(&ray);
            assert_eq!(found.is_some(), known.t.is_some(), "{own:?} {name} {ray:?}: {found:?} {:?}", known.t);
            let (Some(ShapeHit { t, shape_coords: uv }), Some(exactly)) = (found, known.t) else { continue };
            hits += 1;
            let off = (f64::from(t) - exactly).abs();
            assert!(
                off <= known.t_error,
                "{own:?} {name} {ray:?}: {t} {exactly}, off by {off:e} of {:e}",
                known.t_error
            );
            let s = shape.surface_point(&ray, t, uv);
            let turned = s.ng.as_dvec3().cross(known.normal).length();
            assert!(
                turned <= known.normal_error,
                "{own:?} {name} {ray:?}: turned by {turned:e} of {:e}",
                known.normal_error
            );
            if let Some(off) = distance_off_shape(own, &exact, &s, known.hit) {
                assert!(off <= 1.0, "{own:?} {name} {ray:?}: {off} errors off");
            }
            if matches!(own, UnitShape::Ball | UnitShape::Disc | UnitShape::Square) {
                let out = warp::square_to_uniform_sphere(Vec2::new(rng.random(), rng.random()));
                let out = if out.dot(s.ng) < 0.0 { -out } else { out };
                let next = Ray::new(offset_ray_origin(s.p, s.position_error, s.ng, out), out);
                assert!(shape.intersect(&next).is_none(), "{own:?} {name} {ray:?}: hit again");
            }
        }
        assert!(hits > RAYS / 5 && doubtful < RAYS / 3, "{own:?} {name} {hits} {doubtful}");
    });
}
