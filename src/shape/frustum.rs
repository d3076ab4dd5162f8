//! Cylinders, cones and truncated cones, with open or capped ends.

use super::bounded_shape::BoundedShape;
use super::hit::{f64_ray_parameter, nearer_hit};
use super::object_ray::{ObjectRay, world_coordinate_bound};
use super::surface_point::{EDGE_MARGIN, ShapeSample, SurfacePoint};
use super::texture_mapping::{TexCoord, upright_texture_axes};
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform, quadratic_roots_half_b};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
use libm::{atan2, hypot, sincos};
use std::f64::consts::{PI, TAU};

/// Number of azimuth steps of the sum that integrates the area of a frustum's side.
const AREA_AZIMUTH_STEPS: u32 = 512;

/// Cylinder, cone or truncated cone: the surface of x² + z² ≤ ρ(y)², 0 ≤ y ≤ 1, under an affine
/// map.
///
/// The radius ρ is linear in y, and the larger of ρ(0) and ρ(1) is 1. `shape_coords.y` of a
/// [`ShapeHit`] is 0 for a hit on the side, 1 on the bottom cap and 2 on the top cap. The outer
/// side faces away from the axis, even if the ends are open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    to_world: Transform,
    /// Object-space radius ρ at y = 0 and at y = 1; the larger is 1, the smaller at least 0.
    object_radii: [f64; 2],
    /// True if discs close both ends.
    is_capped: bool,
    /// World-space areas of side, bottom and top \[length²]; 0 for missing caps.
    areas: [f64; 3],
}

/// Part of the surface of a [`Frustum`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FrustumPart {
    /// Curved side between the two ends.
    Side,
    /// Disc that closes the frustum at y = 0 in object space.
    Bottom,
    /// Disc that closes the frustum at y = 1 in object space.
    Top,
}

impl FrustumPart {
    /// Part of the surface that was hit; `uv` is `shape_coords` of the [`ShapeHit`].
    #[inline]
    fn from_hit_coordinates(uv: Vec2) -> Self {
        match uv.y as u32 {
            0 => Self::Side,
            1 => Self::Bottom,
            _ => Self::Top,
        }
    }
}

impl Frustum {
    /// Cylinder between the centres of its ends; `None` if its height or radius is 0.
    #[must_use]
    pub fn cylinder(bottom: DVec3, top: DVec3, radius: f64, is_capped: bool) -> Option<Self> {
        Self::new(bottom, top, [radius; 2], is_capped)
    }

    /// Cone from the centre of its base to its apex; `None` if its height or radius is 0.
    #[must_use]
    pub fn cone(base: DVec3, apex: DVec3, radius: f64, is_capped: bool) -> Option<Self> {
        Self::new(base, apex, [radius, 0.0], is_capped)
    }

    /// Truncated cone; `bottom` and `top` are the centres of its ends, `radii` their radii.
    ///
    /// One radius may be 0. `None` if the height or both radii are 0.
    #[must_use]
    pub fn new(bottom: DVec3, top: DVec3, radii: [f64; 2], is_capped: bool) -> Option<Self> {
        let (axis, radius) = (top - bottom, radii[0].max(radii[1]));
        let [u, v] = upright_texture_axes(axis);
        let matrix3 = DMat3::from_cols(u * radius, axis, v * -radius);
        let to_world = Transform::new(DAffine3 { matrix3, translation: bottom }).ok()?;
        Some(Self::from_transform(to_world, radii.map(|r| r / radius), is_capped))
    }

    /// Frustum with the given object-space radii, under the object-to-world map `to_world`.
    fn from_transform(to_world: Transform, radii: [f64; 2], is_capped: bool) -> Self {
        let mut frustum = Self { to_world, object_radii: radii, is_capped, areas: [0.0; 3] };
        let around: f64 = (0..AREA_AZIMUTH_STEPS)
            .map(|i| {
                let (sin, cos) = sincos(f64::from(i) * TAU / f64::from(AREA_AZIMUTH_STEPS));
                to_world.world_element_area(DVec3::new(cos, frustum.radius_decrease(), sin))
            })
            .sum();
        frustum.areas[0] = 0.5 * (radii[0] + radii[1]) * TAU * around / f64::from(AREA_AZIMUTH_STEPS);
        if is_capped {
            let m = to_world.forward().matrix3;
            let disc = PI * m.z_axis.cross(m.x_axis).length();
            frustum.areas[1] = disc * radii[0] * radii[0];
            frustum.areas[2] = disc * radii[1] * radii[1];
        }
        frustum
    }

    /// Decrease of the object-space radius ρ per unit of the height y.
    #[inline]
    fn radius_decrease(&self) -> f64 {
        self.object_radii[0] - self.object_radii[1]
    }

    /// Object-space radius ρ at the height `y` in \[0, 1].
    #[inline]
    fn radius_at(&self, y: f64) -> f64 {
        self.object_radii[0] - self.radius_decrease() * y
    }

    /// Interval of arc length τ in which the line of `ray` is inside the infinite cone around the
    /// side.
    ///
    /// [`ObjectRay`] defines τ. The interval may extend to −∞, +∞ or both, and may lie in the
    /// mirror image of the cone beyond its apex. `None` if the line misses the cone. The
    /// discriminant is computed from squared cross products, so it keeps its digits for grazing
    /// rays.
    #[inline]
    fn interval_inside_cone(&self, ray: &ObjectRay) -> Option<[f64; 2]> {
        const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        let (o, d) = (ray.base, ray.direction);
        let (rho, slope) = (self.radius_at(o.y), -self.radius_decrease() * d.y);
        let a = d.x * d.x + d.z * d.z - slope * slope;
        let b = o.x * d.x + o.z * d.z - rho * slope;
        let distance = hypot(o.x, o.z);
        let c = (distance - rho) * (distance + rho);
        if a == 0.0 {
            // The line is parallel to a generator (a straight line of the side) and crosses the
            // cone at most once.
            return match b {
                b if b > 0.0 => Some([f64::NEG_INFINITY, -0.5 * c / b]),
                b if b < 0.0 => Some([-0.5 * c / b, f64::INFINITY]),
                _ => (c <= 0.0).then_some(ALL),
            };
        }
        let (x, z, across) = (o.x * slope - rho * d.x, o.z * slope - rho * d.z, o.x * d.z - o.z * d.x);
        let discriminant = x * x + z * z - across * across;
        if a > 0.0 {
            return quadratic_roots_half_b(a, b, c, discriminant).map(|(near, far)| [near, far]);
        }
        // The line is steeper than the generators. It enters the cone and stays inside, or it
        // leaves the cone and never returns.
        let (before, after) = quadratic_roots_half_b(a, b, c, discriminant.max(0.0))?;
        Some(if slope > 0.0 { [after, f64::INFINITY] } else { [f64::NEG_INFINITY, before] })
    }

    /// Minimum distances that a surface point must keep from a rim: along y, and perpendicular to
    /// y.
    ///
    /// Both distances and the point `p` are in object space. [`EDGE_MARGIN`] explains why points
    /// keep away from rims.
    #[inline]
    fn rim_margins(&self, p: DVec3) -> (f64, f64) {
        let largest = self.to_world.transform_point(p).abs().max_element();
        let rows = self.to_world.inverse().matrix3.transpose();
        let unit = EDGE_MARGIN * f64::from(f32::EPSILON) * largest;
        let across = (rows.x_axis.length_squared() + rows.z_axis.length_squared()).sqrt();
        ((unit * rows.y_axis.length()).min(0.25), (unit * across).min(0.25))
    }

    /// World-space surface point of the side at the object-space height `y`.
    ///
    /// The unit vector `radial` = (x, z) is the direction from the axis to the point.
    #[inline]
    fn surface_point_on_side(&self, y: f64, radial: DVec2) -> SurfacePoint {
        let rho = self.radius_at(y);
        let normal = DVec3::new(radial.x, self.radius_decrease(), radial.y);
        self.surface_at(DVec3::new(radial.x * rho, y, radial.y * rho), normal, FrustumPart::Side)
    }

    /// World-space surface point of the cap `part` at the object-space position `p` = (x, z).
    #[inline]
    fn surface_point_on_cap(&self, p: DVec2, part: FrustumPart) -> SurfacePoint {
        let (y, normal) = if part == FrustumPart::Top { (1.0, DVec3::Y) } else { (0.0, DVec3::NEG_Y) };
        self.surface_at(DVec3::new(p.x, y, p.y), normal, part)
    }

    /// World-space surface point for the object-space point `p` on the part `part` of the surface.
    ///
    /// The object-space `normal` may have any length.
    #[inline]
    fn surface_at(&self, p: DVec3, normal: DVec3, part: FrustumPart) -> SurfacePoint {
        let normal = self.to_world.transform_normal(normal).normalize();
        let point = SurfacePoint::from_f64(
            self.to_world.transform_point(p),
            normal,
            world_coordinate_bound(&self.to_world, 1.0),
        );
        SurfacePoint { shape_coords: Vec2::new(0.0, part as u32 as f32), ..point }
    }

    /// Height y for which the part of the side below y has the fraction `v` of the side's
    /// object-space area.
    #[inline]
    fn height_at_area_fraction(&self, v: f64) -> f64 {
        let [bottom, top] = self.object_radii;
        let rho = (bottom * bottom * (1.0 - v) + top * top * v).sqrt();
        if v > 0.0 { (v * (bottom + top) / (bottom + rho)).min(1.0) } else { 0.0 }
    }
}

impl BoundedShape for Frustum {
    /// Nearest hit, at which the ray enters or leaves the solid.
    ///
    /// The solid is the part of the cone between the end planes. Side and caps are not tested
    /// separately, so no ray can escape at a rim.
    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let local = ObjectRay::new(ray, &self.to_world);
        let [side_near, side_far] = self.interval_inside_cone(&local)?;
        let (o, d) = (local.base.y, local.direction.y);
        let (mut near, mut far) = ((side_near, FrustumPart::Side), (side_far, FrustumPart::Side));
        if d == 0.0 {
            if !(0.0..=1.0).contains(&o) {
                return None;
            }
        } else {
            let (bottom, top) = ((-o / d, FrustumPart::Bottom), ((1.0 - o) / d, FrustumPart::Top));
            let (enter, exit) = if d > 0.0 { (bottom, top) } else { (top, bottom) };
            near = if enter.0 > near.0 { enter } else { near };
            far = if exit.0 < far.0 { exit } else { far };
        }
        if near.0 > far.0 {
            return None;
        }
        let hit = |(tau, part): (f64, FrustumPart)| {
            // A ray passes an open end without a hit. The parameter −∞ marks this crossing as
            // behind the ray.
            let t =
                if self.is_capped || part == FrustumPart::Side { local.ray_parameter(tau) } else { f64::NEG_INFINITY };
            (t, part as u32 as f32)
        };
        nearer_hit(ray, hit(near), hit(far))
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        let p = ObjectRay::new(ray, &self.to_world).at_ray_parameter(f64_ray_parameter(t, uv));
        let (along, across) = self.rim_margins(p);
        let from_axis = DVec2::new(p.x, p.z);
        match FrustumPart::from_hit_coordinates(uv) {
            FrustumPart::Side => {
                // The point keeps away from the rims and from an apex. `end_margin` is the minimum
                // distance along y from an end of radius `rho`.
                let end_margin = |rho: f64| {
                    if rho < across { ((across - rho) / self.radius_decrease().abs()).max(along) } else { along }
                };
                let (low, high) = (end_margin(self.object_radii[0]), 1.0 - end_margin(self.object_radii[1]));
                self.surface_point_on_side(
                    p.y.clamp(low.min(0.5), high.max(0.5)),
                    from_axis.try_normalize().unwrap_or(DVec2::X),
                )
            }
            part @ (FrustumPart::Bottom | FrustumPart::Top) => {
                let radius = self.object_radii[usize::from(part == FrustumPart::Top)];
                let most = (radius - across).max(0.75 * radius);
                let distance = from_axis.length();
                self.surface_point_on_cap(if distance > most { from_axis * (most / distance) } else { from_axis }, part)
            }
        }
    }

    /// Texture coordinates: on the side, u runs once around the axis, and v from bottom to top.
    ///
    /// Each cap is mapped to the disc inscribed in the unit square.
    fn tex_coord(&self, p: Vec3, uv: Vec2) -> TexCoord {
        let p = self.to_world.inverse().transform_point3(p.as_dvec3());
        let world = |row: DVec3| self.to_world.transform_normal(row);
        match FrustumPart::from_hit_coordinates(uv) {
            FrustumPart::Side => {
                let around2 = (p.x * p.x + p.z * p.z).max(f64::MIN_POSITIVE);
                let u = 0.5 + atan2(p.x, p.z) / TAU;
                let du = DVec3::new(p.z, 0.0, -p.x) / (around2 * TAU);
                TexCoord { uv: DVec2::new(u, p.y), grad_u: world(du), grad_v: world(DVec3::Y) }
            }
            part @ (FrustumPart::Bottom | FrustumPart::Top) => {
                let (radius, v) = match part {
                    FrustumPart::Top => (self.object_radii[1], DVec3::NEG_Z),
                    FrustumPart::Bottom | FrustumPart::Side => (self.object_radii[0], DVec3::Z),
                };
                let (u, v) = (DVec3::X / (2.0 * radius), v / (2.0 * radius));
                TexCoord { uv: DVec2::new(u.dot(p), v.dot(p)) + 0.5, grad_u: world(u), grad_v: world(v) }
            }
        }
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let m = self.to_world.forward().matrix3;
        let (a, b) = (m.x_axis, m.z_axis);
        let half = DVec3::new(hypot(a.x, b.x), hypot(a.y, b.y), hypot(a.z, b.z));
        let ends = [0.0, 1.0].map(|y| self.to_world.transform_point(DVec3::Y * y));
        let [r0, r1] = self.object_radii;
        let min = (ends[0] - half * r0).min(ends[1] - half * r1);
        (min, (ends[0] + half * r0).max(ends[1] + half * r1))
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..*self }
    }

    fn transformed(&self, map: &Transform) -> Option<Self> {
        let to_world = Transform::new(*map.forward() * *self.to_world.forward()).ok()?;
        Some(Self::from_transform(to_world, self.object_radii, self.is_capped))
    }

    fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// Chooses side or cap by area, then samples a point of that part uniformly in object space.
    fn sample(&self, u: Vec2) -> ShapeSample {
        let [side, bottom, _] = self.areas;
        let x = f64::from(u.x) * self.area();
        let turn = f64::from(u.y) * TAU;
        let (sin, cos) = sincos(turn);
        let radial = DVec2::new(cos, sin);
        // Given the part, `x` is uniform between 0 and the part's area. It is used in place of a
        // further random number.
        let cap = |area: f64, x: f64, radius: f64, part| {
            self.surface_point_on_cap(radial * (radius * (x / area).clamp(0.0, 1.0).sqrt()), part)
        };
        let point = if x < side || !self.is_capped {
            self.surface_point_on_side(self.height_at_area_fraction((x / side).min(1.0)), radial)
        } else if x - side < bottom || self.areas[2] == 0.0 {
            cap(bottom, x - side, self.object_radii[0], FrustumPart::Bottom)
        } else {
            cap(self.areas[2], x - side - bottom, self.object_radii[1], FrustumPart::Top)
        };
        ShapeSample { point, pdf: self.pdf(&point), shape_coords: point.shape_coords }
    }

    #[inline]
    fn pdf(&self, point: &SurfacePoint) -> f32 {
        let total = self.area();
        let pdf = match FrustumPart::from_hit_coordinates(point.shape_coords) {
            FrustumPart::Side => {
                // The pdf per world area is P(side) / (object-space area · area ratio). With the
                // linear part M of the object-to-world map and the object-space normal n, the ratio
                // is |det M|·|M⁻ᵀ n|/|n|. The unit world normal is ng = M⁻ᵀ n/|M⁻ᵀ n|, so the ratio
                // is |det M|/|Mᵀ ng|. The object-space area is π (ρ(0) + ρ(1))·|n|, with
                // |n| = √(1 + (ρ(0) − ρ(1))²). `stretch` is the ratio times |n|.
                let m = self.to_world.forward().matrix3;
                let back = (m.transpose() * point.ng.as_dvec3()).length();
                let stretch = self.to_world.determinant().abs() * hypot(1.0, self.radius_decrease()) / back;
                self.areas[0] / (total * PI * (self.object_radii[0] + self.object_radii[1]) * stretch)
            }
            FrustumPart::Bottom | FrustumPart::Top => 1.0 / total,
        };
        pdf as f32
    }
}
