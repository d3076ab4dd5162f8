//! Discs, and ellipses in a plane.

use super::bounded_shape::BoundedShape;
use super::hit::{ray_to_f64, round_t_if_in_range};
use super::surface_point::{EDGE_MARGIN, ShapeSample, SurfacePoint};
use super::texture_mapping::TexCoord;
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform, exact_cross, warp};
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Disc or ellipse: the points c + x·a + y·b with x² + y² ≤ 1, where c is `center`, a is
/// `semi_axis_a` and b is `semi_axis_b`.
///
/// The outer side is the side of a × b. `shape_coords` of a [`ShapeHit`] and the texture
/// coordinates are (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    center: DVec3,
    semi_axis_a: DVec3,
    semi_axis_b: DVec3,
    normal: DVec3,
    /// Dual basis of `semi_axis_a` and `semi_axis_b`: its dot products with an offset from the
    /// centre give (x, y).
    dual_basis: [DVec3; 2],
}

impl Disc {
    /// Ellipse of the points `center + x·a + y·b` with x² + y² ≤ 1; `a` and `b` must not be
    /// parallel.
    #[must_use]
    pub fn new(center: DVec3, a: DVec3, b: DVec3) -> Self {
        let cross = exact_cross(a, b);
        let n2 = cross.length_squared();
        Self {
            center,
            semi_axis_a: a,
            semi_axis_b: b,
            normal: cross / n2.sqrt(),
            dual_basis: [exact_cross(b, cross) / n2, exact_cross(cross, a) / n2],
        }
    }

    /// Circular disc whose outer side faces along `normal`, which may have any length above zero.
    #[must_use]
    pub fn circular_disc(center: DVec3, normal: DVec3, radius: f64) -> Self {
        let (a, b) = normal.normalize().any_orthonormal_pair();
        // The basis (a, b, normal) is right-handed, so a × b points along the normal.
        Self::new(center, a * radius, b * radius)
    }

    /// Returns the point `p` of the disc, moved towards the centre if it is too close to the rim.
    ///
    /// [`EDGE_MARGIN`] explains why surface points keep away from rims.
    #[inline]
    fn move_point_off_rim(&self, p: DVec3) -> DVec3 {
        let offset = p - self.center;
        let at = DVec2::new(self.dual_basis[0].dot(offset), self.dual_basis[1].dot(offset));
        let steepest = (self.dual_basis[0].length_squared() + self.dual_basis[1].length_squared()).sqrt();
        let most = 1.0 - (EDGE_MARGIN * f64::from(f32::EPSILON) * p.abs().max_element() * steepest).min(0.25);
        let from_middle = at.length();
        if from_middle <= most { p } else { self.center + offset * (most / from_middle) }
    }

    /// Surface point at the world-space point `p` of the disc.
    #[inline]
    fn surface_at(&self, p: DVec3) -> SurfacePoint {
        let scale = self.center.abs().max_element()
            + self.semi_axis_a.abs().max_element()
            + self.semi_axis_b.abs().max_element();
        SurfacePoint::from_f64(p, self.normal, scale)
    }
}

impl BoundedShape for Disc {
    #[inline]
    fn contains_disc(&self, center: Vec3, normal: Vec3, radius: f32, tolerance: f32) -> bool {
        let (offset, radius, tolerance) = (center.as_dvec3() - self.center, f64::from(radius), f64::from(tolerance));
        let distance = self.normal.dot(offset).abs() + radius * self.normal.cross(normal.as_dvec3()).length();
        let [a, b] = self.dual_basis;
        let steepest = (a.length_squared() + b.length_squared()).sqrt();
        let at = DVec2::new(a.dot(offset), b.dot(offset)).length();
        distance <= tolerance && at + steepest * (radius + tolerance) <= 1.0
    }

    fn transformed(&self, map: &Transform) -> Option<Self> {
        let (a, b) = (map.transform_vector(self.semi_axis_a), map.transform_vector(self.semi_axis_b));
        let (a, b) = if map.swaps_handedness() { (b, a) } else { (a, b) };
        Some(Self::new(map.transform_point(self.center), a, b))
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (o, d) = ray_to_f64(ray);
        let t = self.normal.dot(self.center - o) / self.normal.dot(d);
        let offset = o + d * t - self.center;
        let (x, y) = (self.dual_basis[0].dot(offset), self.dual_basis[1].dot(offset));
        if x * x + y * y <= 1.0 {
            round_t_if_in_range(ray, t).map(|t| ShapeHit { t, shape_coords: Vec2::new(x as f32, y as f32) })
        } else {
            None
        }
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, t: f32, _uv: Vec2) -> SurfacePoint {
        let (o, d) = ray_to_f64(ray);
        let p = o + d * f64::from(t);
        self.surface_at(self.move_point_off_rim(p - self.normal * self.normal.dot(p - self.center)))
    }

    fn tex_coord(&self, p: Vec3, _uv: Vec2) -> TexCoord {
        let (offset, [grad_u, grad_v]) = (p.as_dvec3() - self.center, self.dual_basis);
        TexCoord { uv: DVec2::new(grad_u.dot(offset), grad_v.dot(offset)), grad_u, grad_v }
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let half = DVec3::new(
            libm::hypot(self.semi_axis_a.x, self.semi_axis_b.x),
            libm::hypot(self.semi_axis_a.y, self.semi_axis_b.y),
            libm::hypot(self.semi_axis_a.z, self.semi_axis_b.z),
        );
        (self.center - half, self.center + half)
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { center: self.center + by, ..*self }
    }

    fn area(&self) -> f64 {
        std::f64::consts::PI * self.semi_axis_a.cross(self.semi_axis_b).length()
    }

    fn sample(&self, u: Vec2) -> ShapeSample {
        let d = warp::square_to_uniform_disc(u).as_dvec2();
        ShapeSample {
            point: self.surface_at(self.center + self.semi_axis_a * d.x + self.semi_axis_b * d.y),
            pdf: (1.0 / self.area()) as f32,
            shape_coords: Vec2::ZERO,
        }
    }

    fn point_if_planar(&self) -> Option<SurfacePoint> {
        Some(self.sample(Vec2::splat(0.5)).point)
    }
}
