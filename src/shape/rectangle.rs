//! Rectangles, and the parallelograms that affine maps make of them.

use super::{Crossing, ShapeSample, SurfacePoint, widen, within};
use crate::math::{Ray, Transform};
use glam::{DVec3, Vec2};

/// The points `corner + x·e0 + y·e1` with x, y in \[0, 1]; its outer side is that of `e0 × e1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    /// Rows that take an offset in the plane to (x, y).
    dual: [DVec3; 2],
}

impl Rectangle {
    /// A parallelogram spanned by two edges, which must not be parallel.
    #[must_use]
    pub fn new(corner: DVec3, e0: DVec3, e1: DVec3) -> Self {
        let cross = e0.cross(e1);
        let n2 = cross.length_squared();
        Self { corner, edges: [e0, e1], normal: cross / n2.sqrt(), dual: [e1.cross(cross) / n2, cross.cross(e0) / n2] }
    }

    /// The image under an affine map, with the same outer side.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Self {
        let [e0, e1] = self.edges.map(|e| map.vector(e));
        let (e0, e1) = if map.mirrors() { (e1, e0) } else { (e0, e1) };
        Self::new(map.point(self.corner), e0, e1)
    }

    #[inline]
    pub(super) fn intersect(&self, ray: &Ray) -> Option<Crossing> {
        let (o, d) = widen(ray);
        let t = self.normal.dot(self.corner - o) / self.normal.dot(d);
        let offset = o + d * t - self.corner;
        let (x, y) = (self.dual[0].dot(offset), self.dual[1].dot(offset));
        if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
            within(ray, t).map(|t| (t, x as f32, y as f32))
        } else {
            None
        }
    }

    #[inline]
    pub(super) fn surface(&self, ray: &Ray, t: f32) -> SurfacePoint {
        let (o, d) = widen(ray);
        let p = o + d * f64::from(t);
        self.at(p - self.normal * self.normal.dot(p - self.corner))
    }

    #[inline]
    fn at(&self, p: DVec3) -> SurfacePoint {
        let reach = self.edges[0].abs().max_element() + self.edges[1].abs().max_element();
        SurfacePoint::exact(p, self.normal, self.corner.abs().max_element() + reach)
    }

    pub(super) fn extent(&self) -> (DVec3, DVec3) {
        let [a, b] = self.edges;
        let zero = DVec3::ZERO;
        (self.corner + a.min(zero) + b.min(zero), self.corner + a.max(zero) + b.max(zero))
    }

    pub(super) fn translated(self, by: DVec3) -> Self {
        Self { corner: self.corner + by, ..self }
    }

    pub(super) fn area(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length()
    }

    pub(super) fn sample(&self, u: Vec2) -> ShapeSample {
        let p = self.corner + self.edges[0] * f64::from(u.x) + self.edges[1] * f64::from(u.y);
        ShapeSample { point: self.at(p), pdf: (1.0 / self.area()) as f32 }
    }
}
