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
pub struct Truth {
    /// Ray parameter of the hit; `None` for a miss.
    pub t: Option<f64>,
    /// Allowed error of `t`.
    pub blur: f64,
    /// Position of the hit in object space.
    ///
    /// The next fields are the unit normal, of either sign, and its allowed error.
    pub hit: DVec3,
    pub normal: DVec3,
    pub turn: f64,
    /// True if the ray touches the shape, or passes a border, within rounding: hit and miss are
    /// both right.
    pub doubtful: bool,
}

/// Rounding error in f64 of coordinates on their way into object space.
///
/// The next constant is the error of a spline shape of size 2 (256 · 32 ulps).
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;
const SPLINES: f64 = 256.0 * 32.0 * f64::EPSILON * 2.0;

/// Returns the nearest hit beyond `t = 0` of a ray from `origin`, with its allowed errors.
///
/// An error e of positions in object space changes t by e/|d·n|. n is the unit object normal, and d
/// the ray's direction in object space. The point then moves by e and by |d| times the change of t.
/// It turns the object normal by at most twice as much, since no shape bends more sharply than
/// radius ½. World normals turn by |M⁻¹| times that, over the length |M⁻ᵀn|. Flat shapes are stored
/// by two world edges. The error of each edge is some ulps of |M|, over its distance from the
/// other.
pub fn truth(own: UnitShape, exact: &Affine, origin: DoubleDoubleVec, direction: DoubleDoubleVec) -> Truth {
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
    let splines = if matches!(own, UnitShape::Tube | UnitShape::Bowl) { SPLINES } else { 0.0 };
    let [x, y, z] = exact.columns;
    let volume = x.dot(y.cross(z)).value().abs();
    // For a miss, `middle` is where the ray is nearest to the shape.
    let middle = if a.value() == 0.0 { DoubleDouble::ZERO } else { -(b / a) };
    let mut truth = Truth { t: None, blur: 0.0, hit: DVec3::ZERO, normal: DVec3::Y, turn: 0.0, doubtful: false };
    let reach = |t: f64| from + t.abs() * pace + place + stretch;
    let noise = |t: f64| ROUNDINGS * shrink * reach(t) + splines;
    // The gradient of F is at most 6 long in the relevant region.
    let touch = discriminant.value().abs() / a.value().abs().max(d.value().length_squared() * 1e-30);
    truth.doubtful |= !flat && touch < 40.0 * noise(middle.value());
    for t in roots {
        let p = o + d.scaled(t);
        let at = t.value();
        let gradient = own.gradient(p);
        let n = gradient.value().normalize();
        let along = d.value().dot(n).abs();
        let world = exact.normal(gradient).value();
        let turned = world.length() / gradient.value().length();
        let (blur, turn) = if flat {
            let cos = direction.value().dot(world.normalize()).abs();
            (ROUNDINGS * reach(at) / cos, ROUNDINGS * stretch * stretch / (volume * turned))
        } else {
            let blur = noise(at) / along;
            (blur, 2.0 * shrink * (noise(at) + d.value().length() * blur) / turned)
        };
        let moved =
            if flat { noise(at) + d.value().length() * blur } else { noise(at) * (1.0 + d.value().length() / along) };
        let within = own.within(p);
        truth.doubtful |= at > -blur && within.abs() <= 2.0 * moved || at.abs() <= blur;
        if at > 0.0 && within >= 0.0 && truth.t.is_none_or(|t| at < t) {
            (truth.t, truth.blur) = (Some(at), blur + 6e-8 * at);
            truth.hit = p.value();
            (truth.normal, truth.turn) = (world.normalize(), turn + 2e-7);
        }
    }
    truth
}

/// Returns the distance of a reported point from the shape along its normal, relative to its stated
/// error.
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
            let known = truth(own, &exact, origin.as_dvec3().into(), ray.direction.as_dvec3().into());
            if known.doubtful {
                doubtful += 1;
                continue;
            }
            let found = shape.intersect(&ray);
            assert_eq!(found.is_some(), known.t.is_some(), "{own:?} {name} {ray:?}: {found:?} {:?}", known.t);
            let (Some(ShapeHit { t, shape_coords: uv }), Some(exactly)) = (found, known.t) else { continue };
            hits += 1;
            let off = (f64::from(t) - exactly).abs();
            assert!(off <= known.blur, "{own:?} {name} {ray:?}: {t} {exactly}, off by {off:e} of {:e}", known.blur);
            let s = shape.surface_point(&ray, t, uv);
            let turned = s.ng.as_dvec3().cross(known.normal).length();
            assert!(turned <= known.turn, "{own:?} {name} {ray:?}: turned by {turned:e} of {:e}", known.turn);
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
