//! Bounding volume hierarchy: nearest hits, occlusion, and all hits of a ray.
//!
//! The build makes a binary tree by the surface area heuristic. It then merges binary nodes into
//! nodes with up to eight children.
//!
//! A leaf is a packet of up to eight triangles, or one other primitive. The hit of a triangle
//! depends only on the ray and on its corners, and box tests never lose a hit. So the shape of the
//! tree affects only the order in which hits are found, not the hits themselves.

mod box_tree;
mod build;
mod bvh8;
mod leaf_list;
mod packet;
mod ray_precalc;
#[cfg(test)]
mod tests;
mod traversal_stack;

pub use box_tree::BoxTree;
pub use leaf_list::LeafList;

use crate::math::{Bounds, Ray};
use build::OTHER_PRIMITIVE_BIT;
use bvh8::{Bvh8, ROOT, SlabTestRay};
use glam::{Vec2, Vec3};
use packet::LeafHit;
use ray_precalc::RayPrecalc;
use std::ops::ControlFlow;
use traversal_stack::TraversalStack;

/// Index of a primitive in one of the two slices that [`Bvh::build`] received.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PrimitiveIndex {
    /// Index in the slice of triangles.
    Triangle(u32),
    /// Index in the slice of boxes, which enclose primitives other than triangles.
    Other(u32),
}

/// Intersection of a ray with one primitive of a [`Bvh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Ray parameter t in (0, `t_max`): the hit is at origin + t · direction of the ray that the
    /// query received.
    pub t: f32,
    /// The primitive that was hit.
    pub primitive: PrimitiveIndex,
    /// Barycentric weight of a triangle's second corner.
    ///
    /// For other primitives: `shape_coords.x` of the [`ShapeHit`].
    pub u: f32,
    /// Barycentric weight of a triangle's third corner.
    ///
    /// For other primitives: `shape_coords.y` of the [`ShapeHit`].
    pub v: f32,
}

/// Intersection of a ray with one shape.
///
/// Each kind of shape defines `shape_coords`, for example as surface parameters or as the index of
/// a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// Ray parameter t: the hit is at origin + t · direction.
    pub t: f32,
    /// Two numbers that locate the hit on the shape, in a form that each kind of shape defines.
    pub shape_coords: Vec2,
}

/// Bounding volume hierarchy over triangles and other primitives.
///
/// The hierarchy intersects triangles itself. For each other primitive, it stores a box. The caller
/// of a query passes a closure that intersects the primitive.
///
/// The triangle test is watertight: a ray cannot pass between two triangles that share an edge or a
/// corner. This holds at any scale and distance (Woop, Benthin and Wald 2013), since boxes are
/// padded to cover the rounding errors of the test. Coordinates must be finite and below 10¹⁸ in
/// magnitude. Memory is about 72 bytes per triangle of a mesh, and 180 more during the build.
pub struct Bvh {
    bvh: Bvh8,
    bounds: Bounds,
}

impl Bvh {
    /// Builds a hierarchy over `triangles`, given by their corners, and `others`, given by boxes.
    ///
    /// Each box of `others` encloses one primitive, which is intersected by closures that the
    /// queries receive. A hit on this primitive may lie outside the box by at most 10⁻⁶ of the
    /// box's size. There may be at most 2³⁰ triangles and 2³⁰ boxes. Corners must be finite.
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

    /// Returns the nearest hit of `ray` with a ray parameter in (0, `ray.t_max`); `None` if there
    /// is none.
    ///
    /// Among hits of equal t, triangles win over other primitives, then the lowest index wins.
    ///
    /// `other(i, r)` intersects `r` with the primitive in box `i`, where `r` is `ray` with `t_max`
    /// lowered to the nearest hit so far.
    #[inline]
    pub fn closest_hit<F>(&self, ray: &Ray, mut other: F) -> Option<PrimitiveHit>
    where
        F: FnMut(u32, &Ray) -> Option<ShapeHit>,
    {
        if self.bvh.is_empty() || !RayPrecalc::can_hit_anything(ray) {
            return None;
        }
        let precalc = RayPrecalc::new(ray);
        let slabs = SlabTestRay::new(&precalc);
        let mut best = NearestHit::before_any_hit(&precalc);
        let mut stack = TraversalStack::new();
        let mut next = Some(ROOT);
        while let Some(child) = next {
            next = if Bvh8::is_leaf(child) {
                // Test the primitives of a leaf.
                best.keep_nearest_hit_of_leaf(&self.bvh, child, ray, &precalc, &mut other);
                stack.pop(best.hit.t)
            } else {
                // Test the boxes of a node's children. Visit the nearest child first.
                let (boxes, children) = self.bvh.node(child);
                match boxes.intersect_boxes(&slabs, best.hit.t) {
                    (0, _) => stack.pop(best.hit.t),
                    (hits, near) => Some(stack.push_all_but_next::<true>(children, hits, near)),
                }
            };
        }
        best.to_primitive_hit(ray, &precalc)
    }

    /// Returns the nearest hit of `ray`, testing only the leaves in `leaves`. The ray up to its
    /// `t_max` must stay in the box for which [`Bvh::leaves_overlapping_bounds`] returned `leaves`.
    ///
    /// The other arguments and the result are as in [`Bvh::closest_hit`].
    #[inline]
    pub fn closest_hit_in_leaves<F>(&self, leaves: &LeafList, ray: &Ray, mut other: F) -> Option<PrimitiveHit>
    where
        F: FnMut(u32, &Ray) -> Option<ShapeHit>,
    {
        if !RayPrecalc::can_hit_anything(ray) {
            return None;
        }
        let precalc = RayPrecalc::new(ray);
        let mut best = NearestHit::before_any_hit(&precalc);
        for leaf in leaves.leaves() {
            best.keep_nearest_hit_of_leaf(&self.bvh, *leaf, ray, &precalc, &mut other);
        }
        best.to_primitive_hit(ray, &precalc)
    }

    /// Returns the leaves whose boxes overlap `bounds`, for [`Bvh::closest_hit_in_leaves`].
    ///
    /// Returns `None` if there are so many leaves that [`Bvh::closest_hit`] is faster.
    #[must_use]
    pub fn leaves_overlapping_bounds(&self, bounds: &Bounds) -> Option<LeafList> {
        LeafList::new(&self.bvh, bounds)
    }

    /// Calls `visit` with every hit of `ray` at a ray parameter in (0, `ray.t_max`).
    ///
    /// The order of the hits depends on the tree. `other(i, ray)` intersects `ray` with the
    /// primitive in box `i`.
    pub fn for_each_hit<F>(&self, ray: &Ray, mut other: F, mut visit: impl FnMut(PrimitiveHit))
    where
        F: FnMut(u32, &Ray) -> Option<ShapeHit>,
    {
        if self.bvh.is_empty() || !RayPrecalc::can_hit_anything(ray) {
            return;
        }
        let precalc = RayPrecalc::new(ray);
        let mut report = |primitive_code: u32, hit: LeafHit| {
            let mut only = NearestHit::before_any_hit(&precalc);
            only.keep_nearer_hit(primitive_code, hit);
            if let Some(hit) = only.to_primitive_hit(ray, &precalc) {
                visit(hit);
            }
        };
        let _ = self.visit_leaves(&precalc, |leaf| {
            if leaf & OTHER_PRIMITIVE_BIT == 0 {
                self.bvh.packet_of_leaf(leaf).for_each_line_hit(&precalc, &mut report);
            } else if let Some(hit) = other(leaf ^ OTHER_PRIMITIVE_BIT, ray) {
                report(leaf, LeafHit::of_other_primitive(hit, &precalc));
            }
            ControlFlow::Continue(())
        });
    }

    /// True if any primitive blocks `ray` at a ray parameter in (0, `ray.t_max`).
    ///
    /// `other(i, ray)` returns true if `ray` hits the primitive in box `i`.
    #[inline]
    pub fn occluded<F>(&self, ray: &Ray, mut other: F) -> bool
    where
        F: FnMut(u32, &Ray) -> bool,
    {
        if self.bvh.is_empty() || !RayPrecalc::can_hit_anything(ray) {
            return false;
        }
        let precalc = RayPrecalc::new(ray);
        let blocked = self.visit_leaves(&precalc, |leaf| {
            let is_blocked = if leaf & OTHER_PRIMITIVE_BIT == 0 {
                self.bvh.packet_of_leaf(leaf).any_hit(&precalc)
            } else {
                other(leaf ^ OTHER_PRIMITIVE_BIT, ray)
            };
            if is_blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        blocked.is_break()
    }

    /// Calls `visit` with each leaf whose box the ray enters before the ray ends at `t_max`, in no
    /// particular order. A leaf is given by its child reference, a number that encodes kind and
    /// index.
    ///
    /// The traversal ends early if `visit` returns [`ControlFlow::Break`].
    #[inline]
    fn visit_leaves(&self, precalc: &RayPrecalc, mut visit: impl FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> {
        let slabs = SlabTestRay::new(precalc);
        let mut stack = TraversalStack::new();
        let mut next = Some(ROOT);
        while let Some(child) = next {
            next = if Bvh8::is_leaf(child) {
                visit(child)?;
                stack.pop(precalc.t_max)
            } else {
                let (boxes, children) = self.bvh.node(child);
                match boxes.intersect_boxes(&slabs, precalc.t_max) {
                    (0, _) => stack.pop(precalc.t_max),
                    (hits, near) => Some(stack.push_all_but_next::<false>(children, hits, near)),
                }
            };
        }
        ControlFlow::Continue(())
    }
}

/// Nearest hit that a traversal has found so far, with the code of the primitive that was hit.
///
/// Among hits of equal t, the hit with the lowest code is kept; see [`OTHER_PRIMITIVE_BIT`] for
/// codes. The ray parameter t refers to the scaled direction of [`RayPrecalc`].
struct NearestHit {
    primitive_code: u32,
    hit: LeafHit,
}

impl NearestHit {
    /// State at the start of a traversal: t is `t_max`, and the code is 0, the lowest one. A later
    /// hit at exactly `t_max` therefore does not replace this state.
    #[inline]
    fn before_any_hit(precalc: &RayPrecalc) -> Self {
        Self { primitive_code: 0, hit: LeafHit { t: precalc.t_max, unnormalized_weights: [0.0; 2], weight_sum: 1.0 } }
    }

    /// Tests the primitives of the leaf with child reference `leaf`, and keeps the nearest hit.
    ///
    /// `other` intersects primitives other than triangles, as in [`Bvh::closest_hit`].
    #[inline(always)]
    fn keep_nearest_hit_of_leaf(
        &mut self,
        bvh: &Bvh8,
        leaf: u32,
        ray: &Ray,
        precalc: &RayPrecalc,
        other: &mut impl FnMut(u32, &Ray) -> Option<ShapeHit>,
    ) {
        if leaf & OTHER_PRIMITIVE_BIT == 0 {
            bvh.packet_of_leaf(leaf).for_each_line_hit(precalc, |triangle, hit| self.keep_nearer_hit(triangle, hit));
        } else {
            // `t_max` is exclusive, but this primitive wins a tie with a kept hit of higher code.
            let t_max = if leaf < self.primitive_code { self.hit.t.next_up() } else { self.hit.t };
            let shrunk = Ray { t_max: t_max * precalc.direction_scale, ..*ray };
            if let Some(hit) = other(leaf ^ OTHER_PRIMITIVE_BIT, &shrunk) {
                self.keep_nearer_hit(leaf, LeafHit::of_other_primitive(hit, precalc));
            }
        }
    }

    /// Replaces the kept hit by `hit` if `hit.t` > 0 and `hit` is nearer, or equally near with a
    /// lower code.
    #[inline]
    fn keep_nearer_hit(&mut self, primitive_code: u32, hit: LeafHit) {
        let (t, least) = (hit.t, self.hit.t);
        if t > 0.0 && (t < least || t == least && primitive_code < self.primitive_code) {
            *self = Self { primitive_code, hit };
        }
    }

    /// Returns the kept hit with its ray parameter for the unscaled direction of `ray`; `None` if
    /// there was no hit.
    #[inline]
    fn to_primitive_hit(&self, ray: &Ray, precalc: &RayPrecalc) -> Option<PrimitiveHit> {
        let t = self.hit.t * precalc.direction_scale;
        // For the unscaled direction, t may underflow to 0 or round up to `t_max`. The ray then has
        // no hit.
        if !(self.hit.t < precalc.t_max && 0.0 < t && t < ray.t_max) {
            return None;
        }
        let index = self.primitive_code & !OTHER_PRIMITIVE_BIT;
        let primitive =
            if self.primitive_code == index { PrimitiveIndex::Triangle(index) } else { PrimitiveIndex::Other(index) };
        let (u, v) = self.hit.barycentric();
        Some(PrimitiveHit { t, primitive, u, v })
    }
}
