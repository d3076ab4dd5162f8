//! Bounding volume hierarchy: nearest hits, occlusion, and all hits of a ray.
//!
//! A binary tree is built by the surface area heuristic, then collapsed into nodes of eight boxes.
//! Leaves are packets of triangles. The hit of a triangle depends only on the ray and its corners,
//! and the boxes never lose a hit. So no result depends on the tree.

mod along;
mod build;
mod bvh8;
mod packet;
mod ray_precalc;
#[cfg(test)]
mod tests;

pub use along::BoxTree;

use crate::math::{Bounds, Ray};
use build::OTHER;
use bvh8::{Bvh8, with_stack_size};
use glam::Vec3;
use packet::TriangleHit;
use ray_precalc::RayPrecalc;

/// Primitive, by its index in the slice given to [`Hierarchy::build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Primitive {
    /// A triangle.
    Triangle(u32),
    /// Any other primitive, known by its box.
    Other(u32),
}

/// Hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Ray parameter, in units of the direction's length, `0 < t < t_max`.
    pub t: f32,
    /// The primitive that was hit.
    pub primitive: Primitive,
    /// Weight of a triangle's second corner; for other primitives, the second value of the closure.
    pub u: f32,
    /// Weight of a triangle's third corner; for other primitives, the third value of the closure.
    pub v: f32,
}

/// Hierarchy over triangles and over other primitives that are known by their boxes.
///
/// Triangles are watertight: a ray through a closed mesh hits it, at edges and corners too. This
/// holds at any scale and distance (Woop, Benthin and Wald 2013, with boxes padded to match).
/// Coordinates must be finite and below 10¹⁸ in magnitude. Memory is about 72 bytes per triangle of
/// a mesh, and 180 more during the build.
pub struct Hierarchy {
    bvh: Bvh8,
    bounds: Bounds,
}

impl Hierarchy {
    /// Builds a hierarchy over `triangles`, given by their corners, and `others`, given by boxes.
    ///
    /// The boxes enclose what the closures of [`closest`](Self::closest) and
    /// [`occluded`](Self::occluded) intersect. There may be at most 2³⁰ of either. Corners must be
    /// finite. A hit of another primitive must lie in its box, up to 10⁻⁶ of the box's size.
    /// Triangles without area and empty boxes are never hit.
    #[must_use]
    pub fn build(triangles: &[[Vec3; 3]], others: &[Bounds]) -> Self {
        let bounds = Bounds::from_points(triangles.iter().flatten().copied());
        let bounds = others.iter().filter(|b| !b.is_empty()).fold(bounds, |all, b| all.union(*b));
        Self { bvh: Bvh8::build(triangles, others), bounds }
    }

    /// Box around all primitives; empty if there are none.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Nearest hit with `0 < t < t_max`.
    ///
    /// Among hits of equal `t`, the lowest primitive wins, triangles before others.
    ///
    /// `other` intersects the other primitive of the given index. It returns `t`, and two
    /// coordinates that are passed through to the hit. Its ray has `t_max` reduced to the nearest
    /// hit so far; a hit beyond is ignored.
    #[inline]
    pub fn closest<F>(&self, ray: &Ray, mut other: F) -> Option<PrimitiveHit>
    where
        F: FnMut(u32, &Ray) -> Option<(f32, f32, f32)>,
    {
        if !RayPrecalc::can_hit_anything(ray) {
            return None;
        }
        let precalc = RayPrecalc::new(ray);
        let mut best = NearestHit { key: 0, hit: TriangleHit { t: precalc.t_max, weights: [0.0; 2], total: 1.0 } };
        let test_leaf = |leaf, _| {
            if leaf & OTHER == 0 {
                self.bvh.packet(leaf).for_each_hit(&precalc, |triangle, hit| best.keep_nearer(triangle, hit));
            } else {
                // `t_max` is exclusive, but this primitive wins ties against a higher key.
                let t_max = if leaf < best.key { best.hit.t.next_up() } else { best.hit.t };
                let shrunk = Ray { t_max: t_max * precalc.unit, ..*ray };
                if let Some((t, u, v)) = other(leaf ^ OTHER, &shrunk) {
                    let weights = [u, v].map(f64::from);
                    best.keep_nearer(leaf, TriangleHit { t: t * precalc.per_unit, weights, total: 1.0 });
                }
            }
            best.hit.t
        };
        with_stack_size!(self.bvh, <STACK> self.bvh.traverse::<true, STACK>(&precalc, test_leaf));
        best.to_primitive_hit(ray, &precalc)
    }

    /// Calls `visit` with every hit with `0 < t < t_max`, in an order that depends on the tree.
    ///
    /// `other` works like that of [`closest`](Self::closest), but its ray is not shortened.
    pub fn for_each_hit<F>(&self, ray: &Ray, mut other: F, mut visit: impl FnMut(PrimitiveHit))
    where
        F: FnMut(u32, &Ray) -> Option<(f32, f32, f32)>,
    {
        if !RayPrecalc::can_hit_anything(ray) {
            return;
        }
        let precalc = RayPrecalc::new(ray);
        let mut show = |key: u32, hit: TriangleHit| {
            let mut only = NearestHit { key: 0, hit: TriangleHit { t: precalc.t_max, weights: [0.0; 2], total: 1.0 } };
            only.keep_nearer(key, hit);
            if let Some(hit) = only.to_primitive_hit(ray, &precalc) {
                visit(hit);
            }
        };
        let test_leaf = |leaf, limit| {
            if leaf & OTHER == 0 {
                self.bvh.packet(leaf).for_each_hit(&precalc, &mut show);
            } else if let Some((t, u, v)) = other(leaf ^ OTHER, ray) {
                show(leaf, TriangleHit { t: t * precalc.per_unit, weights: [u, v].map(f64::from), total: 1.0 });
            }
            limit
        };
        with_stack_size!(self.bvh, <STACK> self.bvh.traverse::<false, STACK>(&precalc, test_leaf));
    }

    /// True if there is a hit with `0 < t < t_max`.
    ///
    /// `other` returns true if the other primitive of the given index is hit.
    #[inline]
    pub fn occluded<F>(&self, ray: &Ray, mut other: F) -> bool
    where
        F: FnMut(u32, &Ray) -> bool,
    {
        if !RayPrecalc::can_hit_anything(ray) {
            return false;
        }
        let precalc = RayPrecalc::new(ray);
        let mut found = false;
        let test_leaf = |leaf, limit| {
            found = if leaf & OTHER == 0 { self.bvh.packet(leaf).has_hit(&precalc) } else { other(leaf ^ OTHER, ray) };
            if found { f32::NEG_INFINITY } else { limit }
        };
        with_stack_size!(self.bvh, <STACK> self.bvh.traverse::<false, STACK>(&precalc, test_leaf));
        found
    }
}

/// Nearest hit so far, in the units of [`RayPrecalc`].
///
/// The key breaks ties of `t`. Key 0 at the start excludes `t_max` itself.
struct NearestHit {
    key: u32,
    hit: TriangleHit,
}

impl NearestHit {
    #[inline]
    fn keep_nearer(&mut self, key: u32, hit: TriangleHit) {
        let (t, least) = (hit.t, self.hit.t);
        if t > 0.0 && (t < least || t == least && key < self.key) {
            *self = Self { key, hit };
        }
    }

    #[inline]
    fn to_primitive_hit(&self, ray: &Ray, precalc: &RayPrecalc) -> Option<PrimitiveHit> {
        let t = self.hit.t * precalc.unit;
        // A distance that the caller's unit cannot express is no hit.
        if !(self.hit.t < precalc.t_max && 0.0 < t && t < ray.t_max) {
            return None;
        }
        let index = self.key & !OTHER;
        let primitive = if self.key == index { Primitive::Triangle(index) } else { Primitive::Other(index) };
        let (u, v) = self.hit.barycentric();
        Some(PrimitiveHit { t, primitive, u, v })
    }
}
