//! Surfaces of revolution, intersected in the plane of their profiles.

mod proximity;

use super::cylindrical_ray::{ArcLengthInterval, CylindricalRay, polar_radius_and_direction};
use super::polynomial::{Coefficient, evaluate_with_derivative};
use super::profile::ProfilePiece;
use super::revolution_build::{MAX_HALVINGS, ProfileBuilder, ProfileLeaf};
use super::ring_bvh::{RingBounds, RingBvh};
use super::root_finding::{GAUSS_LEGENDRE, PARAMETRIC_ERROR_FACTOR};
use super::spline::{SplineBasis, SplineError};
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform};
use crate::sampling::DiscreteDistribution;
use crate::shape::bounded_shape::BoundedShape;
use crate::shape::hit::round_t_if_in_range;
use crate::shape::object_ray::{ObjectRay, ray_to_object_space, world_coordinate_bound};
use crate::shape::surface_point::{ShapeSample, SurfacePoint};
use crate::shape::texture_mapping::TexCoord;
use glam::{DVec2, DVec3, Vec2, Vec3};
use libm::{atan2, hypot, sincos};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Longest accepted Newton step, relative to the surface's size, when a hit is refined along a ray.
///
/// A longer step means that the ray is nearly tangent.
const MAX_RELATIVE_NEWTON_STEP: f64 = 1e-4;

/// Number of azimuth steps of the sum that integrates the area of a surface of revolution.
const AREA_AZIMUTH_STEPS: u32 = 64;

/// Surface of revolution: the points (X cos θ, Y, X sin θ) of a profile curve (X, Y), affinely
/// mapped.
///
/// Surface parameters are the curve parameter of the profile in \[0, 1], and θ/2π. The outer side
/// is on the right of the profile's direction: a profile at X > 0 that goes up faces away from the
/// axis.
#[derive(Clone, Debug)]
pub struct Revolution {
    profile: Arc<RevolutionProfile>,
    /// Map from object space to world space. The object-space origin is on the axis, at the middle
    /// height of the profile.
    to_world: Transform,
    /// World-space area \[length²].
    area: f64,
    /// Upper bound on the absolute world-space coordinates of all points of the surface \[length].
    coordinate_bound: f64,
}

/// Hit of a ray on a leaf, a nearly straight piece of the profile curve.
struct LeafHit {
    leaf: usize,
    /// Parameter of the leaf at the hit, from −1 at the start of the leaf to 1 at its end.
    x: f64,
    /// Ray parameter t of the hit, within the ray's range (0, `t_max`).
    t: f32,
    /// Object-space point of the hit.
    point: DVec3,
}

/// Profile curve in object space, divided into nearly straight pieces, which are called leaves.
#[derive(Debug)]
struct RevolutionProfile {
    leaves: Vec<ProfileLeaf>,
    /// Polynomial coefficients (radius, height) of all leaves, one leaf after another.
    coefficients: Vec<Coefficient<2>>,
    leaf_bvh: RingBvh,
    /// Upper bound on the object-space distance of the surface from the origin.
    bounding_radius: f64,
    /// Upper bound on the rounding error of a point that is computed from the leaves' polynomials
    /// \[object-space length].
    point_error_bound: f64,
    /// Distribution that selects a leaf (a piece of the profile) in proportion to its object-space
    /// area.
    leaf_distribution: DiscreteDistribution,
}

impl Revolution {
    /// Surface of revolution around the y axis; the profile has the control points (x, y).
    ///
    /// # Errors
    ///
    /// [`SplineError`] if the number of control points does not match the basis, a value is too
    /// large, or the surface has no area.
    pub fn new(basis: &SplineBasis, controls: &[DVec2]) -> Result<Self, SplineError> {
        Self::with_memory_limit(basis, controls, None)
    }

    /// Creates a surface like [`Revolution::new`], with at most `free` bytes of memory; `None` for
    /// no limit.
    ///
    /// # Errors
    ///
    /// Those of [`Revolution::new`], and [`SplineError::MemoryLimitExceeded`] if the limit does not
    /// suffice.
    pub fn with_memory_limit(basis: &SplineBasis, controls: &[DVec2], free: Option<u64>) -> Result<Self, SplineError> {
        if controls.len() != basis.control_count() {
            return Err(SplineError::TooFewControlPoints { controls: controls.len(), degree: basis.degree() });
        }
        if !controls.iter().all(|c| c.abs().max_element() < 1e100) {
            return Err(SplineError::TooLarge);
        }
        let (low, high) =
            controls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c.y), h.max(c.y)));
        let middle = 0.5 * low + 0.5 * high;
        let points: Vec<Coefficient<2>> = controls.iter().map(|c| [c.x, c.y - middle]).collect();
        let mut builder = ProfileBuilder { leaves: Vec::new(), coefficients: Vec::new(), memory_limit: free };
        for span in basis.knot_spans() {
            builder.subdivide_bezier_curve(
                &basis.bezier_control_points(span, &points, (0, 1)),
                span.range,
                MAX_HALVINGS,
            )?;
        }
        let ProfileBuilder { leaves, coefficients: powers, .. } = builder;
        let rings: Vec<RingBounds> = leaves.iter().map(|l| l.ring).collect();
        let reach = |r: &RingBounds| hypot(r.radius[1], r.height[0].abs().max(r.height[1].abs()));
        let size = rings.iter().map(reach).fold(0.0, f64::max);
        if leaves.is_empty() {
            return Err(SplineError::NoArea);
        }
        let tree = RingBvh::new(&rings, size);
        let degree = basis.degree();
        let noise = size * f64::EPSILON * (64 + 4 * degree * degree) as f64;
        let placeholder = DiscreteDistribution::new([1.0]).ok_or(SplineError::NoArea)?;
        let mut profile = RevolutionProfile {
            leaves,
            coefficients: powers,
            leaf_bvh: tree,
            bounding_radius: size,
            point_error_bound: noise,
            leaf_distribution: placeholder,
        };
        let areas = (0..profile.leaves.len()).map(|i| profile.leaf_area(i, &Transform::IDENTITY));
        profile.leaf_distribution = DiscreteDistribution::new(areas).ok_or(SplineError::NoArea)?;
        let to_world = Transform::IDENTITY.translated(DVec3::new(0.0, middle, 0.0));
        let area = profile.leaf_distribution.weight_sum();
        Ok(Self::from_profile(Arc::new(profile), to_world, area))
    }

    /// Surface of a profile under the map `to_world`, with the world-space area `area`.
    fn from_profile(profile: Arc<RevolutionProfile>, to_world: Transform, area: f64) -> Self {
        let coordinate_bound = world_coordinate_bound(&to_world, profile.bounding_radius);
        Self { profile, to_world, area, coordinate_bound }
    }

    /// Returns three values: the line of `ray` in object space, [`ObjectRay::distance_to_base`] and
    /// [`ObjectRay::direction_length`].
    ///
    /// `None` if the line misses the bounding sphere of the surface.
    fn cylindrical_object_ray(&self, ray: &Ray) -> Option<(CylindricalRay, f64, f64)> {
        let ObjectRay { base, direction, distance_to_base: start, direction_length: length } =
            ObjectRay::new(ray, &self.to_world);
        let size = self.profile.bounding_radius * (1.0 + 1e-9);
        (base.length_squared() <= size * size).then(|| (CylindricalRay::new(base, direction), start, length))
    }

    /// Azimuth θ/2π in \[0, 1] of the object-space point `p` on a leaf (a piece of the profile).
    ///
    /// The point is (X cos θ, Y, X sin θ) for the profile point (X, Y). So θ differs by half a turn
    /// from the polar angle of `p` where X < 0.
    fn angle_in_turns(&self, p: DVec3, leaf: usize) -> f64 {
        let side = self.profile.leaves[leaf].side_sign;
        let turn = atan2(side * p.z, side * p.x) / TAU;
        if turn < 0.0 { turn + 1.0 } else { turn }
    }

    /// World-space surface point on a leaf, a nearly straight piece of the profile, at the leaf's
    /// parameter x in \[−1, 1].
    ///
    /// `radial` is the unit direction (x, z) from the axis to the point. The point stores the
    /// surface parameters `uv`.
    fn surface_at(&self, leaf: usize, x: f64, radial: DVec2, uv: Vec2) -> SurfacePoint {
        let profile = &self.profile;
        let p = self.to_world.transform_point(profile.leaf_point(leaf, x, radial));
        let normal = self.to_world.transform_normal(profile.leaf_normal(leaf, x, radial)).normalize();
        let scale = self.coordinate_bound * PARAMETRIC_ERROR_FACTOR;
        SurfacePoint { shape_coords: uv, ..SurfacePoint::from_f64(p, normal, scale) }
    }

    /// Nearest hit of `ray` with a ray parameter in (0, `ray.t_max`); `None` if there is none.
    #[inline]
    fn nearest_leaf_hit(&self, ray: &Ray) -> Option<LeafHit> {
        let (line, start, length) = self.cylindrical_object_ray(ray)?;
        let size = self.profile.bounding_radius;
        let end = f64::from(ray.t_max) * length - start;
        let t = ArcLengthInterval { lo: (-start).max(-size), hi: end.min(size) };
        let mut found: Option<(usize, f64, f64)> = None;
        self.profile.leaf_bvh.visit_hit_leaves(&line, t, |leaf, t| {
            let piece = ProfilePiece {
                coefficients: self.profile.leaf_polynomial_coefficients(leaf),
                point_error_bound: self.profile.point_error_bound,
            };
            if let Some((x, at)) = piece.nearest_hit(&line, t, size) {
                found = Some((leaf, x, at));
            }
        });
        let (leaf, x, at) = found?;
        let t = round_t_if_in_range(ray, (start + at) / length)?;
        Some(LeafHit { leaf, x, t, point: line.base + line.direction * at })
    }
}

impl BoundedShape for Revolution {
    fn transformed(&self, map: &Transform) -> Option<Self> {
        let to_world = Transform::new(*map.forward() * *self.to_world.forward()).ok()?;
        let profile = &self.profile;
        let area = match to_world.uniform_scale() {
            Some(scale) => scale * scale * profile.leaf_distribution.weight_sum(),
            None => (0..profile.leaves.len()).map(|i| profile.leaf_area(i, &to_world)).sum(),
        };
        Some(Self::from_profile(Arc::clone(profile), to_world, area))
    }

    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let LeafHit { leaf, x, t, point } = self.nearest_leaf_hit(ray)?;
        let (u, v) = (self.profile.leaf_to_profile_parameter(leaf, x), self.angle_in_turns(point, leaf));
        Some(ShapeHit { t, shape_coords: Vec2::new(u as f32, v as f32) })
    }

    fn occludes(&self, ray: &Ray) -> bool {
        self.nearest_leaf_hit(ray).is_some()
    }

    fn surface_point(&self, ray: &Ray, _t: f32, uv: Vec2) -> SurfacePoint {
        let (o, d) = ray_to_object_space(ray, &self.to_world);
        let (leaf, mut x) = self.profile.find_leaf(f64::from(uv.x));
        // `uv` is rounded to f32, so its point may lie beside the ray. Newton steps move it back
        // onto the ray. They start from `uv`, since the rounding error of the distance t may be
        // larger.
        let mut p = o + d
            * ((self.profile.leaf_point(leaf, x, self.profile.radial_direction(leaf, uv.y)) - o).dot(d)
                / d.length_squared());
        let most = DVec2::new(
            4.0 * f64::from(f32::EPSILON) / self.profile.leaves[leaf].parameter_half_width,
            MAX_RELATIVE_NEWTON_STEP * self.profile.bounding_radius,
        );
        for _ in 0..2 {
            let (radius, radial) = polar_radius_and_direction(p);
            let ([px, py], [dx, dh]) = evaluate_with_derivative(self.profile.leaf_polynomial_coefficients(leaf), x);
            let slope = radial.dot(DVec2::new(d.x, d.z));
            let (beside, above) = (radius - px, p.y - py);
            let steps = DVec2::new(slope * above - d.y * beside, dx * above - dh * beside) / (slope * dh - dx * d.y);
            if (steps.abs() * DVec2::new(1.0, d.length())).cmple(most).all() {
                (x, p) = ((x + steps.x).clamp(-1.0, 1.0), p + d * steps.y);
            }
        }
        self.surface_at(leaf, x, polar_radius_and_direction(p).1, uv)
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let rows = self.to_world.forward().matrix3.transpose();
        let place = self.to_world.forward().translation;
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for RingBounds { radius, height } in self.profile.leaves.iter().map(|l| l.ring) {
            let around = DVec3::from_array(rows.map(|r| hypot(r.x, r.z) * radius[1]));
            for h in height {
                let center = place + DVec3::from_array(rows.map(|r| r.y * h));
                (min, max) = (min.min(center - around), max.max(center + around));
            }
        }
        (min, max)
    }

    fn translated(&self, by: DVec3) -> Self {
        Self::from_profile(Arc::clone(&self.profile), self.to_world.translated(by), self.area)
    }

    fn area(&self) -> f64 {
        self.area
    }

    /// Chooses a leaf (a piece of the profile) with a probability proportional to its object-space
    /// area, then uniform parameters in that leaf.
    fn sample(&self, u: Vec2) -> ShapeSample {
        let (leaf, _) = self.profile.leaf_distribution.sample(u.x);
        let x = f64::from(self.profile.leaf_distribution.remapped_sample(u.x, leaf)) * 2.0 - 1.0;
        let uv = Vec2::new(self.profile.leaf_to_profile_parameter(leaf, x) as f32, u.y);
        let point = self.surface_at(leaf, x, self.profile.radial_direction(leaf, u.y), uv);
        ShapeSample { pdf: self.pdf(&point), point, shape_coords: uv }
    }

    fn tex_coord(&self, p: Vec3, uv: Vec2) -> TexCoord {
        let (leaf, x) = self.profile.find_leaf(f64::from(uv.x));
        let (_, radial) = polar_radius_and_direction(self.to_world.inverse().transform_point3(p.as_dvec3()));
        let ([radius, _], [dx, dh]) = evaluate_with_derivative(self.profile.leaf_polynomial_coefficients(leaf), x);
        let half = self.profile.leaves[leaf].parameter_half_width;
        let along = DVec3::new(dx * radial.x, dh, dx * radial.y) / half;
        let around = DVec3::new(-radial.y, 0.0, radial.x) * (TAU * radius);
        TexCoord::from_derivatives(uv, self.to_world.transform_vector(along), self.to_world.transform_vector(around))
    }

    fn pdf(&self, point: &SurfacePoint) -> f32 {
        let (leaf, x) = self.profile.find_leaf(f64::from(point.shape_coords.x));
        let m = self.to_world.forward().matrix3;
        let stretch = self.to_world.determinant().abs() / (m.transpose() * point.ng.as_dvec3()).length();
        let element = self.profile.area_element(leaf, x) * stretch;
        (f64::from(self.profile.leaf_distribution.probability(leaf)) / (2.0 * TAU * element)) as f32
    }
}

#[cfg(test)]
impl Revolution {
    /// World-space point at the surface parameters `uv`: curve parameter, and azimuth in turns.
    pub(super) fn point_at_uv(&self, uv: Vec2) -> DVec3 {
        let (leaf, x) = self.profile.find_leaf(f64::from(uv.x));
        self.to_world.transform_point(self.profile.leaf_point(leaf, x, self.profile.radial_direction(leaf, uv.y)))
    }
}

impl RevolutionProfile {
    /// Polynomial coefficients (radius, height) of a leaf, a nearly straight piece of the profile,
    /// for the powers of its parameter x in \[−1, 1].
    fn leaf_polynomial_coefficients(&self, leaf: usize) -> &[Coefficient<2>] {
        let end = self.leaves.get(leaf + 1).map_or(self.coefficients.len(), |l| l.first_coefficient as usize);
        &self.coefficients[self.leaves[leaf].first_coefficient as usize..end]
    }

    /// Object-space point on a leaf, a nearly straight piece of the profile, at the leaf's
    /// parameter x in \[−1, 1].
    ///
    /// `radial` is the unit direction (x, z) from the axis to the point.
    fn leaf_point(&self, leaf: usize, x: f64, radial: DVec2) -> DVec3 {
        let ([radius, height], _) = evaluate_with_derivative(self.leaf_polynomial_coefficients(leaf), x);
        DVec3::new(radius * radial.x, height, radius * radial.y)
    }

    /// Unit direction (x, z) from the axis to the surface points at the azimuth θ = 2π·`turns` on a
    /// leaf (a piece of the profile). The direction is (cos θ, sin θ), but −(cos θ, sin θ) on a
    /// leaf where the profile has x < 0.
    fn radial_direction(&self, leaf: usize, turns: f32) -> DVec2 {
        let (sin, cos) = sincos(f64::from(turns) * TAU);
        DVec2::new(cos, sin) * self.leaves[leaf].side_sign
    }

    /// Converts the parameter x in \[−1, 1] of a leaf to the profile's curve parameter in \[0, 1].
    fn leaf_to_profile_parameter(&self, leaf: usize, x: f64) -> f64 {
        let ProfileLeaf { parameter_center: middle, parameter_half_width: half, .. } = self.leaves[leaf];
        middle + half * x
    }

    /// Index of the leaf (piece of the profile) at a curve parameter in \[0, 1].
    ///
    /// Also returns the parameter x in \[−1, 1] within that leaf.
    fn find_leaf(&self, parameter: f64) -> (usize, f64) {
        let after = self.leaves.partition_point(|l| l.parameter_center - l.parameter_half_width <= parameter);
        let leaf = after.saturating_sub(1);
        let ProfileLeaf { parameter_center: middle, parameter_half_width: half, .. } = self.leaves[leaf];
        (leaf, ((parameter - middle) / half).clamp(-1.0, 1.0))
    }

    /// Object-space normal on a leaf, a nearly straight piece of the profile, at the leaf's
    /// parameter x. The normal points to the outer side and is not normalised.
    ///
    /// `radial` is the unit direction (x, z) from the axis to the point. Where the profile's
    /// derivative vanishes, the result is the normal at a point further inside the leaf.
    fn leaf_normal(&self, leaf: usize, x: f64, radial: DVec2) -> DVec3 {
        let powers = self.leaf_polynomial_coefficients(leaf);
        let extent = powers[1..].iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
        let mut away = 0.0;
        let [dx, dh] = loop {
            // If the derivative vanishes at x, the direction is taken from a point further inside
            // the leaf.
            let (_, slope) = evaluate_with_derivative(powers, x - f64::copysign(away, x));
            if slope[0].abs().max(slope[1].abs()) > 1e-7 * extent || away > 0.5 {
                break slope;
            }
            away = if away == 0.0 { 1e-5 } else { 10.0 * away };
        };
        let side = self.leaves[leaf].side_sign;
        DVec3::new(dh * radial.x, -dx, dh * radial.y) * side
    }

    /// Object-space area element of the surface at the parameter x of a leaf (a piece of the
    /// profile): area per unit of x and per radian of azimuth.
    fn area_element(&self, leaf: usize, x: f64) -> f64 {
        let ([radius, _], [dx, dh]) = evaluate_with_derivative(self.leaf_polynomial_coefficients(leaf), x);
        radius.abs() * hypot(dx, dh)
    }

    /// World-space area \[length²] of the surface that a leaf (a piece of the profile) sweeps
    /// around the axis, under `to_world`.
    fn leaf_area(&self, leaf: usize, to_world: &Transform) -> f64 {
        let determinant = to_world.determinant().abs();
        let mut sum = 0.0;
        for (x, weight) in GAUSS_LEGENDRE {
            let ring = self.area_element(leaf, x) * weight * TAU / f64::from(AREA_AZIMUTH_STEPS);
            for i in 0..AREA_AZIMUTH_STEPS {
                let (sin, cos) = sincos(f64::from(i) * TAU / f64::from(AREA_AZIMUTH_STEPS));
                let normal = self.leaf_normal(leaf, x, DVec2::new(cos, sin)).normalize_or_zero();
                sum += ring * determinant * to_world.transform_normal(normal).length();
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests;
