//! Rectangles and parallelograms; rectangles are sampled by solid angle.

use super::bounded_shape::BoundedShape;
use super::hit::{ray_to_f64, round_t_if_in_range};
use super::surface_point::{EDGE_MARGIN, ShapeSample, SolidAngleSample, SolidAngleSampleResult, SurfacePoint};
use super::texture_mapping::TexCoord;
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform, exact_cross};
use glam::{DVec2, DVec3, Vec2, Vec3};
use libm::{atan2, sincos};

/// Largest cosine of the angle between two edges that count as perpendicular.
///
/// The value is above 0 because transforms cause rounding errors in the edges.
const PERPENDICULAR_COSINE: f64 = 1e-12;

/// Solid angle \[sr] below which a rectangle is sampled by area instead of by solid angle.
///
/// Such solid angles are computed as differences of larger angles, so they have few correct digits.
const MIN_SOLID_ANGLE: f64 = 1e-4;

/// Squared ratio of a rectangle's diagonal to its distance from the viewpoint, below which the
/// rectangle is sampled by area.
///
/// For such distant rectangles, sampling by area has little more variance than sampling by solid
/// angle, and takes a tenth of the time.
const FAR_SIZE_RATIO2: f64 = 0.2;

/// Rectangle or parallelogram: the points `corner + x·e0 + y·e1` with x, y in \[0, 1].
///
/// The outer side is the side of `e0 × e1`. `shape_coords` of a [`ShapeHit`] and the texture
/// coordinates are (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    /// Dual basis of the edge vectors: its dot products with an offset from the corner give (x, y).
    dual_basis: [DVec3; 2],
    /// True if the edges are perpendicular.
    is_right_angled: bool,
}

/// Rectangle as seen from a viewpoint.
///
/// The viewpoint's projection to the plane is the origin of coordinates x and y along the edges.
#[derive(Debug)]
struct RectangleView {
    /// Range of the rectangle along its first edge, relative to the viewpoint's projection
    /// \[length].
    x: [f64; 2],
    /// Range of the rectangle along its second edge, relative to the viewpoint's projection
    /// \[length].
    y: [f64; 2],
    /// Distance from the viewpoint to the rectangle's plane \[length].
    z: f64,
    /// Unit vectors along the first and second edge of the rectangle.
    axes: [DVec3; 2],
    /// Solid angle \[sr] of the strip from x = 0 to the smaller end of the range `x`, over the
    /// range `y`. It is negative if that end is negative.
    start_solid_angle: f64,
    /// Solid angle of the rectangle as seen from the viewpoint \[sr].
    solid_angle: f64,
}

impl Rectangle {
    /// Parallelogram with the corner `corner` and the edge vectors `e0` and `e1`, which must not be
    /// parallel.
    #[must_use]
    pub fn new(corner: DVec3, e0: DVec3, e1: DVec3) -> Self {
        let cross = exact_cross(e0, e1);
        let n2 = cross.length_squared();
        let is_right_angled = e0.dot(e1).abs() <= PERPENDICULAR_COSINE * e0.length() * e1.length();
        let dual = [exact_cross(e1, cross) / n2, exact_cross(cross, e0) / n2];
        Self { corner, edges: [e0, e1], normal: cross / n2.sqrt(), dual_basis: dual, is_right_angled }
    }

    /// Returns the point `p` of the rectangle, moved inward if it is too close to an edge.
    ///
    /// [`EDGE_MARGIN`] explains why surface points keep away from edges.
    #[inline]
    fn move_point_off_edges(&self, p: DVec3) -> DVec3 {
        let offset = p - self.corner;
        let at = DVec2::new(self.dual_basis[0].dot(offset), self.dual_basis[1].dot(offset));
        let widths = DVec2::new(self.dual_basis[0].length(), self.dual_basis[1].length());
        let margin = (widths * (EDGE_MARGIN * f64::from(f32::EPSILON) * p.abs().max_element())).min(DVec2::splat(0.25));
        let moved = at.clamp(margin, 1.0 - margin);
        if moved == at { p } else { self.corner + self.edges[0] * moved.x + self.edges[1] * moved.y }
    }

    /// Surface point at the world-space point `p` of the rectangle.
    #[inline]
    fn surface_at(&self, p: DVec3) -> SurfacePoint {
        let reach = self.edges[0].abs().max_element() + self.edges[1].abs().max_element();
        SurfacePoint::from_f64(p, self.normal, self.corner.abs().max_element() + reach)
    }

    /// The rectangle as seen from the world-space point `from`, in order to sample it by solid
    /// angle.
    ///
    /// `None` if `from` is on the inner side or the edges are not perpendicular. Also `None` if the
    /// rectangle looks so small that sampling by area is better.
    fn rectangle_view(&self, from: Vec3) -> Option<RectangleView> {
        let to = self.corner - from.as_dvec3();
        let z = -self.normal.dot(to);
        if !self.is_right_angled || z.is_nan() || z <= 0.0 {
            return None;
        }
        let middle = to + (self.edges[0] + self.edges[1]) * 0.5;
        if (self.edges[0] + self.edges[1]).length_squared() < FAR_SIZE_RATIO2 * middle.length_squared() {
            return None;
        }
        let lengths = self.edges.map(DVec3::length);
        let axes = [self.edges[0] / lengths[0], self.edges[1] / lengths[1]];
        let [x, y] = [0, 1].map(|i| {
            let first = axes[i].dot(to);
            [first, first + lengths[i]]
        });
        let [start_angle, end_angle] = x.map(|x| strip_solid_angle(x, y, z));
        let solid_angle = end_angle - start_angle;
        (solid_angle >= MIN_SOLID_ANGLE).then_some(RectangleView {
            x,
            y,
            z,
            axes,
            start_solid_angle: start_angle,
            solid_angle,
        })
    }
}

impl BoundedShape for Rectangle {
    #[inline]
    fn contains_disc(&self, center: Vec3, normal: Vec3, radius: f32, tolerance: f32) -> bool {
        let (offset, radius, tolerance) = (center.as_dvec3() - self.corner, f64::from(radius), f64::from(tolerance));
        let distance = self.normal.dot(offset).abs() + radius * self.normal.cross(normal.as_dvec3()).length();
        let is_within_edges = |dual: DVec3| {
            let (at, reach) = (dual.dot(offset), dual.length() * (radius + tolerance));
            at >= reach && at + reach <= 1.0
        };
        distance <= tolerance && self.dual_basis.into_iter().all(is_within_edges)
    }

    fn transformed(&self, map: &Transform) -> Option<Self> {
        let [e0, e1] = self.edges.map(|e| map.transform_vector(e));
        let (e0, e1) = if map.swaps_handedness() { (e1, e0) } else { (e0, e1) };
        Some(Self::new(map.transform_point(self.corner), e0, e1))
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (o, d) = ray_to_f64(ray);
        let t = self.normal.dot(self.corner - o) / self.normal.dot(d);
        let offset = o + d * t - self.corner;
        let (x, y) = (self.dual_basis[0].dot(offset), self.dual_basis[1].dot(offset));
        if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
            round_t_if_in_range(ray, t).map(|t| ShapeHit { t, shape_coords: Vec2::new(x as f32, y as f32) })
        } else {
            None
        }
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, t: f32, _uv: Vec2) -> SurfacePoint {
        let (o, d) = ray_to_f64(ray);
        let p = o + d * f64::from(t);
        self.surface_at(self.move_point_off_edges(p - self.normal * self.normal.dot(p - self.corner)))
    }

    fn tex_coord(&self, p: Vec3, _uv: Vec2) -> TexCoord {
        let (offset, [grad_u, grad_v]) = (p.as_dvec3() - self.corner, self.dual_basis);
        TexCoord { uv: DVec2::new(grad_u.dot(offset), grad_v.dot(offset)), grad_u, grad_v }
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        let [a, b] = self.edges;
        let zero = DVec3::ZERO;
        (self.corner + a.min(zero) + b.min(zero), self.corner + a.max(zero) + b.max(zero))
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { corner: self.corner + by, ..*self }
    }

    fn area(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length()
    }

    fn sample(&self, u: Vec2) -> ShapeSample {
        let p = self.corner + self.edges[0] * f64::from(u.x) + self.edges[1] * f64::from(u.y);
        ShapeSample { point: self.surface_at(p), pdf: (1.0 / self.area()) as f32, shape_coords: Vec2::ZERO }
    }

    fn point_if_planar(&self) -> Option<SurfacePoint> {
        Some(self.sample(Vec2::splat(0.5)).point)
    }

    #[inline]
    fn sample_solid_angle(&self, from: Vec3, u: Vec2) -> SolidAngleSampleResult {
        let Some(view) = self.rectangle_view(from) else { return SolidAngleSampleResult::Unsupported };
        let (x, y) = view.sample(u);
        let fraction = |i: usize, at: f64, [first, last]: [f64; 2]| self.edges[i] * ((at - first) / (last - first));
        let point = self.surface_at(self.corner + fraction(0, x, view.x) + fraction(1, y, view.y));
        // The direction is computed from x and y, not from `point`: rounding may move `point` into
        // a plane that contains `from`.
        let wi = (view.axes[0] * x + view.axes[1] * y - self.normal * view.z).normalize().as_vec3();
        SolidAngleSampleResult::Sampled(SolidAngleSample { point, wi, pdf: (1.0 / view.solid_angle) as f32 })
    }

    #[inline]
    fn solid_angle_pdf(&self, from: Vec3) -> Option<f32> {
        self.rectangle_view(from).map(|view| (1.0 / view.solid_angle) as f32)
    }
}

/// Solid angle \[sr] of a rectangle that covers 0 to `x` and `y[0]` to `y[1]` in its plane.
///
/// The viewpoint is in front of the point (0, 0), at the distance `z` > 0 from the plane. The
/// result has the sign of `x`.
///
/// Van Oosterom and Strackee (1983) give the solid angle of the rectangle between (0, 0) and (x, y)
/// as atan2(x y, z r), where r is the distance of (x, y) from the viewpoint. The product of two
/// complex numbers gives the difference of two such angles by one arc tangent.
#[inline]
fn strip_solid_angle(x: f64, [y0, y1]: [f64; 2], z: f64) -> f64 {
    let [r0, r1] = [y0, y1].map(|y| (x * x + y * y + z * z).sqrt());
    atan2(x * z * (y1 * r0 - y0 * r1), z * z * r0 * r1 + x * x * y0 * y1)
}

impl RectangleView {
    /// Maps `u` in \[0, 1)² to coordinates (x, y) on the rectangle, uniformly by solid angle.
    ///
    /// [`RectangleView`] defines x and y. Source: Ureña, Fajardo, King 2013, "An
    /// Area-Preserving Parametrization for Spherical Rectangles". Their equation for x becomes
    ///
    /// x = z sin A / √((cos A − cos(b₁ − b₀)) (cos A + cos(b₁ + b₀)))
    ///
    /// where A is the signed solid angle between 0 and x, and tan bᵢ = yᵢ / z. Half angles turn the
    /// differences of cosines into products, which keep their digits at grazing views. The sum and
    /// the difference of the vectors (z, yᵢ) give the half angles of b₁ ± b₀ without trigonometric
    /// functions.
    fn sample(&self, u: Vec2) -> (f64, f64) {
        let Self { x: [x0, x1], y: [y0, y1], z, .. } = *self;
        let (s, c) = sincos(0.5 * (self.start_solid_angle + f64::from(u.x) * self.solid_angle));
        // Both vectors are scaled to the length r₀ r₁. Their sum points along (b₁ + b₀) / 2 and is
        // longer than their difference by the factor cot((b₁ - b₀) / 2).
        let [r0, r1] = [y0, y1].map(|y| (y * y + z * z).sqrt());
        let (y1_scaled, y0_scaled) = (y1 * r0, y0 * r1);
        // Where the sum or the difference would cancel, compute it from the difference of squares.
        let squares = (y1 - y0) * (y1 + y0);
        let (sum_y, difference_y) = if y0 < 0.0 && y1 > 0.0 {
            (z * z * squares / (y1_scaled - y0_scaled), y1_scaled - y0_scaled)
        } else {
            (y1_scaled + y0_scaled, z * z * squares / (y1_scaled + y0_scaled))
        };
        let sum = DVec2::new(z * (r0 + r1), sum_y);
        let cosine = sum.length();
        let sine = DVec2::new(z * squares / (r0 + r1), difference_y).length();
        let first = (sine * c + cosine * s) * (sine * c - cosine * s);
        let second = (sum.x * c + sum.y * s) * (sum.x * c - sum.y * s);
        let x = 2.0 * z * (r0 * r1) * cosine * s * c / (first * second).max(0.0).sqrt();
        // At the far end of a grazing view, rounding may turn x into 0/0.
        let x = if x.is_nan() { x1 } else { x.clamp(x0, x1) };
        // Given x, the solid angle is linear in the sine of the elevation over the (x, z) plane.
        let d2 = x * x + z * z;
        let [h0, h1] = [y0, y1].map(|y| y / (d2 + y * y).sqrt());
        let h = h0 + f64::from(u.y) * (h1 - h0);
        let y = h * (d2 / ((1.0 - h) * (1.0 + h)).max(0.0)).sqrt();
        (x, if y.is_nan() { y1 } else { y.clamp(y0, y1) })
    }
}

#[cfg(test)]
mod tests;
