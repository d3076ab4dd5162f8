//! Surfaces of revolution, intersected by their profiles.

use super::axis_ray::{AxisRay, Interval};
use super::polynomial::{Vector, evaluate, split, to_powers};
use super::profile::Piece;
use super::ring_tree::{Ring, RingTree};
use super::spline::{Basis, SplineError};
use super::{GAUSS, Nearest, SLACK};
use crate::math::{Ray, Transform};
use crate::sampling::Discrete;
use crate::shape::{Crossing, Mapped, ShapeSample, SurfacePoint, widen, within};
use glam::{DVec2, DVec3, Vec2, Vec3};
use libm::{atan2, hypot, sincos};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Bends of a leaf, in parts of its length, below which rays that are not near grazing need no further cut.
const FLAT: f64 = 1.0 / 16.0;

/// Halvings of a Bézier piece at most, where it never gets flat: at cusps and where control points coincide.
const DEPTH: u32 = 9;

/// Points around the axis at which area is summed under maps that stretch; the sum converges as fast as for a Fourier series.
const AROUND: u32 = 64;

/// The points (X cos θ, Y, X sin θ) of a profile (X, Y), under an affine map.
///
/// The coordinates of a point are the place on the profile in \[0, 1], by its knots, and θ/2π. The outer side is on the right of the
/// profile's direction of travel, seen with x to the right and y up: a profile at x > 0 that goes up faces away from the axis.
#[derive(Clone, Debug)]
pub struct Revolution {
    profile: Arc<Profile>,
    /// From the profile's space, where y is counted from its middle.
    to_world: Transform,
    /// In the world.
    area: f64,
}

#[derive(Debug)]
struct Profile {
    leaves: Vec<Leaf>,
    powers: Vec<Vector<2>>,
    tree: RingTree,
    /// No point is farther from the origin.
    size: f64,
    noise: f64,
    /// Area of each leaf, in the profile's space.
    choice: Discrete,
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    first: u32,
    /// The profile's x over the distance from the axis: 1 or −1.
    side: f64,
    /// Middle and half width of its stretch of the profile.
    place: [f64; 2],
    ring: Ring,
}

impl Revolution {
    /// A profile of control points (x, y).
    ///
    /// # Errors
    /// [`SplineError`] where numbers do not fit, are too large, or the surface has no area.
    pub fn new(basis: &Basis, controls: &[DVec2]) -> Result<Self, SplineError> {
        if controls.len() != basis.controls() {
            return Err(SplineError::Controls { controls: controls.len(), degree: basis.degree() });
        }
        if !controls.iter().all(|c| c.abs().max_element() < 1e100) {
            return Err(SplineError::TooLarge);
        }
        let (low, high) =
            controls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c.y), h.max(c.y)));
        let middle = 0.5 * low + 0.5 * high;
        let points: Vec<Vector<2>> = controls.iter().map(|c| [c.x, c.y - middle]).collect();
        let mut builder = Builder { leaves: Vec::new(), powers: Vec::new() };
        for span in basis.spans() {
            builder.cut(&basis.piece(span, &points, (0, 1)), span.range, DEPTH);
        }
        let Builder { leaves, powers } = builder;
        let rings: Vec<Ring> = leaves.iter().map(|l| l.ring).collect();
        let reach = |r: &Ring| hypot(r.radius[1], r.height[0].abs().max(r.height[1].abs()));
        let size = rings.iter().map(reach).fold(0.0, f64::max);
        if leaves.is_empty() {
            return Err(SplineError::NoArea);
        }
        let tree = RingTree::new(&rings, size);
        let degree = basis.degree();
        let noise = size * f64::EPSILON * (64 + 4 * degree * degree) as f64;
        let nothing = Discrete::new([1.0]).ok_or(SplineError::NoArea)?;
        let mut profile = Profile { leaves, powers, tree, size, noise, choice: nothing };
        let areas = (0..profile.leaves.len()).map(|i| profile.leaf_area(i, &Transform::IDENTITY));
        profile.choice = Discrete::new(areas).ok_or(SplineError::NoArea)?;
        let to_world = Transform::IDENTITY.translated(DVec3::new(0.0, middle, 0.0));
        let area = profile.choice.total();
        Ok(Self { profile: Arc::new(profile), to_world, area })
    }

    /// The image under another map; `None` where the product is singular.
    pub(in crate::shape) fn transformed(&self, map: &Transform) -> Option<Self> {
        let to_world = Transform::new(*map.forward() * *self.to_world.forward()).ok()?;
        let profile = &self.profile;
        let area = match to_world.similarity() {
            Some(scale) => scale * scale * profile.choice.total(),
            None => (0..profile.leaves.len()).map(|i| profile.leaf_area(i, &to_world)).sum(),
        };
        Some(Self { profile: Arc::clone(profile), to_world, area })
    }

    pub(in crate::shape) fn intersect(&self, ray: &Ray) -> Option<Crossing> {
        let (line, start, length) = self.line(ray)?;
        let size = self.profile.size;
        let end = f64::from(ray.t_max) * length - start;
        let t = Interval { lo: (-start).max(-size), hi: end.min(size) };
        let mut found: Option<(usize, f64, f64)> = None;
        self.profile.tree.walk(&line, t, |leaf, t| {
            let piece = Piece { powers: self.profile.powers(leaf), noise: self.profile.noise };
            if let Some((x, at)) = piece.nearest(&line, t, size) {
                found = Some((leaf, x, at));
            }
        });
        let (leaf, x, at) = found?;
        let t = within(ray, (start + at) / length)?;
        let p = line.base + line.direction * at;
        Some((t, self.profile.place(leaf, x) as f32, self.turn(p, leaf) as f32))
    }

    /// The ray in the profile's space, the τ at which it is nearest to the middle less that at its origin, and τ for each unit of t.
    /// `None` where it passes the surface by.
    fn line(&self, ray: &Ray) -> Option<(AxisRay, f64, f64)> {
        let Nearest { base, direction, start, length } = Nearest::new(ray, &self.to_world);
        let size = self.profile.size * (1.0 + 1e-9);
        (base.length_squared() <= size * size).then(|| (AxisRay::new(base, direction), start, length))
    }

    /// θ/2π in \[0, 1) of a point of a leaf.
    fn turn(&self, p: DVec3, leaf: usize) -> f64 {
        let side = self.profile.leaves[leaf].side;
        let turn = atan2(side * p.z, side * p.x) / TAU;
        if turn < 0.0 { turn + 1.0 } else { turn }
    }

    pub(in crate::shape) fn surface(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        let (o, d) = widen(ray);
        let inverse = self.to_world.inverse();
        let (o, d) = (inverse.transform_point3(o), inverse.transform_vector3(d));
        let p = o + d * f64::from(t);
        let (leaf, x) = self.profile.find(f64::from(uv.x));
        let powers = self.profile.powers(leaf);
        // One step of Newton's method makes up for the rounding of the coordinate.
        let around = DVec2::new(p.x, p.z);
        let radial = around.try_normalize().unwrap_or(DVec2::X);
        let ([px, py], [dx, dh]) = evaluate(powers, x);
        let slope = radial.dot(DVec2::new(d.x, d.z));
        let step = (slope * (p.y - py) - d.y * (around.length() - px)) / (slope * dh - dx * d.y);
        let most = 4.0 * f64::from(f32::EPSILON) / self.profile.leaves[leaf].place[1];
        let x = if step.abs() <= most { (x + step).clamp(-1.0, 1.0) } else { x };
        self.at(leaf, x, radial, uv)
    }

    /// The surface of a leaf at x, in unit direction `radial` from the axis.
    fn at(&self, leaf: usize, x: f64, radial: DVec2, uv: Vec2) -> SurfacePoint {
        let profile = &self.profile;
        let ([radius, height], _) = evaluate(profile.powers(leaf), x);
        let p = self.to_world.point(DVec3::new(radius * radial.x, height, radius * radial.y));
        let m = self.to_world.forward().matrix3;
        let widest = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        let scale = widest * profile.size + self.to_world.forward().translation.abs().max_element();
        let normal = self.to_world.normal(profile.normal(leaf, x, radial)).normalize();
        SurfacePoint { uv, ..SurfacePoint::exact(p, normal, scale * SLACK) }
    }

    pub(in crate::shape) fn extent(&self) -> (DVec3, DVec3) {
        let rows = self.to_world.forward().matrix3.transpose();
        let place = self.to_world.forward().translation;
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for Ring { radius, height } in self.profile.leaves.iter().map(|l| l.ring) {
            let around = DVec3::from_array(rows.map(|r| hypot(r.x, r.z) * radius[1]));
            for h in height {
                let center = place + DVec3::from_array(rows.map(|r| r.y * h));
                (min, max) = (min.min(center - around), max.max(center + around));
            }
        }
        (min, max)
    }

    pub(in crate::shape) fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..self.clone() }
    }

    pub(in crate::shape) fn area(&self) -> f64 {
        self.area
    }

    /// A leaf by its area, then uniform in its coordinates.
    pub(in crate::shape) fn sample(&self, u: Vec2) -> ShapeSample {
        let (leaf, _) = self.profile.choice.sample(u.x);
        let x = f64::from(self.profile.choice.remainder(u.x, leaf)) * 2.0 - 1.0;
        let (sin, cos) = sincos(f64::from(u.y) * TAU);
        let side = self.profile.leaves[leaf].side;
        let uv = Vec2::new(self.profile.place(leaf, x) as f32, u.y);
        let point = self.at(leaf, x, DVec2::new(cos, sin) * side, uv);
        ShapeSample { pdf: self.pdf(&point), point, uv }
    }

    /// Coordinates of point `p` of the surface and how they grow in the world.
    pub(in crate::shape) fn mapped(&self, p: Vec3, uv: Vec2) -> Mapped {
        let (leaf, x) = self.profile.find(f64::from(uv.x));
        let own = self.to_world.inverse().transform_point3(p.as_dvec3());
        let radial = DVec2::new(own.x, own.z).try_normalize().unwrap_or(DVec2::X);
        let ([radius, _], [dx, dh]) = evaluate(self.profile.powers(leaf), x);
        let half = self.profile.leaves[leaf].place[1];
        let along = DVec3::new(dx * radial.x, dh, dx * radial.y) / half;
        let around = DVec3::new(-radial.y, 0.0, radial.x) * (TAU * radius);
        Mapped::of(uv, self.to_world.vector(along), self.to_world.vector(around))
    }

    /// Density per area of [`Revolution::sample`].
    pub(in crate::shape) fn pdf(&self, point: &SurfacePoint) -> f32 {
        let (leaf, x) = self.profile.find(f64::from(point.uv.x));
        let m = self.to_world.forward().matrix3;
        let stretch = m.determinant().abs() / (m.transpose() * point.ng.as_dvec3()).length();
        let element = self.profile.element(leaf, x) * stretch;
        (f64::from(self.profile.choice.probability(leaf)) / (2.0 * TAU * element)) as f32
    }
}

#[cfg(test)]
impl Revolution {
    /// The point of coordinates.
    pub(super) fn point_of(&self, uv: Vec2) -> DVec3 {
        let (leaf, x) = self.profile.find(f64::from(uv.x));
        let ([radius, height], _) = evaluate(self.profile.powers(leaf), x);
        let (sin, cos) = sincos(f64::from(uv.y) * TAU);
        let side = radius * self.profile.leaves[leaf].side;
        self.to_world.point(DVec3::new(side * cos, height, side * sin))
    }
}

impl Profile {
    fn powers(&self, leaf: usize) -> &[Vector<2>] {
        let end = self.leaves.get(leaf + 1).map_or(self.powers.len(), |l| l.first as usize);
        &self.powers[self.leaves[leaf].first as usize..end]
    }

    /// Where x of a leaf is on the whole profile.
    fn place(&self, leaf: usize, x: f64) -> f64 {
        let [middle, half] = self.leaves[leaf].place;
        middle + half * x
    }

    /// The leaf of a place on the whole profile, and its x.
    fn find(&self, place: f64) -> (usize, f64) {
        let after = self.leaves.partition_point(|l| l.place[0] - l.place[1] <= place);
        let leaf = after.saturating_sub(1);
        let [middle, half] = self.leaves[leaf].place;
        (leaf, ((place - middle) / half).clamp(-1.0, 1.0))
    }

    /// Normal of any length, on the right of the direction of travel.
    fn normal(&self, leaf: usize, x: f64, radial: DVec2) -> DVec3 {
        let powers = self.powers(leaf);
        let extent = powers[1..].iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
        let mut away = 0.0;
        let [dx, dh] = loop {
            // Where the profile stands still, its direction is the limit from inside the leaf.
            let (_, slope) = evaluate(powers, x - f64::copysign(away, x));
            if slope[0].abs().max(slope[1].abs()) > 1e-7 * extent || away > 0.5 {
                break slope;
            }
            away = if away == 0.0 { 1e-5 } else { 10.0 * away };
        };
        let side = self.leaves[leaf].side;
        DVec3::new(dh * radial.x, -dx, dh * radial.y) * side
    }

    /// Area for each unit of x and of θ.
    fn element(&self, leaf: usize, x: f64) -> f64 {
        let ([radius, _], [dx, dh]) = evaluate(self.powers(leaf), x);
        radius.abs() * hypot(dx, dh)
    }

    fn leaf_area(&self, leaf: usize, to_world: &Transform) -> f64 {
        let determinant = to_world.forward().matrix3.determinant().abs();
        let mut sum = 0.0;
        for (x, weight) in GAUSS {
            let ring = self.element(leaf, x) * weight * TAU / f64::from(AROUND);
            for i in 0..AROUND {
                let (sin, cos) = sincos(f64::from(i) * TAU / f64::from(AROUND));
                let normal = self.normal(leaf, x, DVec2::new(cos, sin)).normalize_or_zero();
                sum += ring * determinant * to_world.normal(normal).length();
            }
        }
        sum
    }
}

struct Builder {
    leaves: Vec<Leaf>,
    powers: Vec<Vector<2>>,
}

impl Builder {
    /// Cuts a Bézier curve until it is flat and on one side of the axis.
    fn cut(&mut self, controls: &[Vector<2>], [start, end]: [f64; 2], depth: u32) {
        let (left, right) =
            controls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), c| (l.min(c[0]), r.max(c[0])));
        let (low, high) =
            controls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), c| (l.min(c[1]), r.max(c[1])));
        if left == 0.0 && right == 0.0 || left == right && low == high {
            return;
        }
        let side = if -left > right { -1.0 } else { 1.0 };
        let degree = controls.len() - 1;
        let mut powers: Vec<Vector<2>> = controls.iter().map(|c| [side * c[0], c[1]]).collect();
        to_powers(&mut powers, 0, 1, degree);
        let crosses = left < 0.0 && right > 0.0;
        let bends = powers.iter().enumerate().skip(2).fold(0.0, |s, (k, c)| s + k as f64 * hypot(c[0], c[1]));
        if depth > 0 && (crosses || bends > FLAT * hypot(powers[1][0], powers[1][1])) {
            let at = axis_crossing(controls).filter(|_| crosses).unwrap_or(0.5);
            let (mut first, mut last) = split(controls, at);
            if crosses && at != 0.5 {
                // The root is known to rounding; on the axis is on the axis.
                (first[degree][0], last[0][0]) = (0.0, 0.0);
            }
            let middle = start + at * (end - start);
            self.cut(&first, [start, middle], depth - 1);
            self.cut(&last, [middle, end], depth - 1);
            return;
        }
        let place = [0.5 * (start + end), 0.5 * (end - start)];
        let ring = Ring { radius: [0.0, 0.0], height: [low, high] };
        let radius = if side < 0.0 { [-right, -left] } else { [left, right] };
        self.leaves.push(Leaf { first: self.powers.len() as u32, side, place, ring: Ring { radius, ..ring } });
        self.powers.extend(powers);
    }
}

/// Where a curve whose controls change sides once, so that it does so once, crosses the axis.
fn axis_crossing(controls: &[Vector<2>]) -> Option<f64> {
    let sides: Vec<bool> = controls.iter().map(|c| c[0]).filter(|x| *x != 0.0).map(|x| x > 0.0).collect();
    let [first, .., _] = sides[..] else { return None };
    if sides.windows(2).filter(|w| w[0] != w[1]).count() != 1 || controls[0][0] == 0.0 {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while let middle = 0.5 * (low + high)
        && low < middle
        && middle < high
    {
        let x = split(controls, middle).1[0][0];
        *(if (x > 0.0) == first { &mut low } else { &mut high }) = middle;
    }
    (0.0 < low && low < 1.0).then_some(low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn surface(basis: &Basis, controls: &[[f64; 2]]) -> Revolution {
        let controls: Vec<DVec2> = controls.iter().map(|c| DVec2::from_array(*c)).collect();
        Revolution::new(basis, &controls).unwrap()
    }

    fn line(controls: [[f64; 2]; 2]) -> Revolution {
        surface(&Basis::bezier(2).unwrap(), &controls)
    }

    fn hit(s: &Revolution, o: Vec3, d: Vec3) -> Option<f32> {
        s.intersect(&Ray::new(o, d)).map(|c| c.0)
    }

    #[test]
    fn turned_lines_are_cylinders_cones_and_discs() {
        let cylinder = line([[1.0, -1.0], [1.0, 1.0]]);
        assert_eq!(hit(&cylinder, Vec3::new(0.0, 0.0, 3.0), -Vec3::Z), Some(2.0));
        assert_eq!(hit(&cylinder, Vec3::new(0.0, 0.5, 0.0), Vec3::X * 0.5), Some(2.0));
        assert_eq!(hit(&cylinder, Vec3::new(0.6, -3.0, 3.0), Vec3::new(0.0, 1.0, -1.0)), Some(2.2));
        assert_eq!(hit(&cylinder, Vec3::new(0.5, -3.0, 0.2), Vec3::Y), None);
        assert_eq!(hit(&cylinder, Vec3::new(1.0f32.next_up(), 0.0, 3.0), -Vec3::Z), None);
        assert!(hit(&cylinder, Vec3::new(1.0f32.next_down(), 0.0, 3.0), -Vec3::Z).is_some());
        let cone = line([[0.0, 1.0], [-1.0, 0.0]]);
        assert_eq!(hit(&cone, Vec3::new(0.0, 3.0, 0.0), -Vec3::Y), Some(2.0));
        assert_eq!(hit(&cone, Vec3::new(0.25, 3.0, 0.0), -Vec3::Y), Some(2.25));
        assert_eq!(hit(&cone, Vec3::new(0.0, 0.5, 3.0), -Vec3::Z), Some(2.5));
        let disc = line([[0.0, 0.5], [2.0, 0.5]]);
        assert_eq!(hit(&disc, Vec3::new(1.0, 3.5, 1.0), -Vec3::Y), Some(3.0));
        assert_eq!(hit(&disc, Vec3::new(0.0, 3.5, 0.0), -Vec3::Y), Some(3.0));
        assert_eq!(hit(&disc, Vec3::new(1.0, 0.5, 4.0), -Vec3::Z), None, "edge-on");
        assert_eq!(hit(&disc, Vec3::new(1.5, 3.5, 1.5), -Vec3::Y), None);
    }
}
