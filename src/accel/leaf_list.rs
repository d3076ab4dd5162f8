//! Short lists of the leaves near a box, for many short rays in that box.

use super::build::{ARITY, OTHER_PRIMITIVE_BIT};
use super::bvh8::{Boxes8, Bvh8};
use crate::math::Bounds;
use wide::f32x8;

/// Largest number of BVH leaves in a [`LeafList`].
///
/// If more leaves overlap a box, a BVH traversal per ray is faster than a test of all these leaves.
const MAX_LEAVES: usize = 6;

/// Capacity of the stack of BVH nodes that the search for leaves has still to visit.
///
/// A query box that needs more entries very likely overlaps more than [`MAX_LEAVES`] leaves.
const MAX_STACK_ENTRIES: usize = 4 * ARITY;

/// List of the leaves of a [`Bvh`](super::Bvh) whose boxes overlap a query box. A leaf is a packet
/// of triangles or one other primitive.
///
/// A ray segment inside the query box can hit only primitives of these leaves. If many short rays
/// stay in one box, they test these leaves and skip the traversal of the hierarchy.
#[derive(Clone, Copy, Debug)]
pub struct LeafList {
    /// Child references of the leaves: numbers that encode kind and index of a child of a BVH node.
    /// Only the first `count` are valid.
    leaves: [u32; MAX_LEAVES],
    count: usize,
}

impl LeafList {
    /// Finds the leaves of `bvh` whose boxes overlap `bounds`.
    ///
    /// Returns `None` if there are more than [`MAX_LEAVES`], or if the search needs more than
    /// [`MAX_STACK_ENTRIES`].
    pub(super) fn new(bvh: &Bvh8, bounds: &Bounds) -> Option<Self> {
        let mut list = Self { leaves: [0; MAX_LEAVES], count: 0 };
        let overlap = OverlapTest::new(bounds);
        let mut stack = [0u32; MAX_STACK_ENTRIES];
        // The root has index 0. An empty hierarchy has no root.
        let mut top = usize::from(!bvh.is_empty());
        while top > 0 {
            top -= 1;
            let (boxes, children) = bvh.node(stack[top]);
            let mut hits = overlap.overlapping_boxes(boxes);
            while hits != 0 {
                let child = children[hits.trailing_zeros() as usize & (ARITY - 1)];
                hits &= hits - 1;
                if Bvh8::is_leaf(child) {
                    *list.leaves.get_mut(list.count)? = child;
                    list.count += 1;
                } else {
                    *stack.get_mut(top)? = child;
                    top += 1;
                }
            }
        }
        Some(list)
    }

    /// True if no leaf overlaps the query box, so no primitive is in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the index of the primitive if the list is one leaf that holds a primitive other than
    /// a triangle. A ray segment in the query box can then hit nothing else.
    ///
    /// Returns `None` for an empty list, for several leaves, and for a leaf of triangles.
    #[must_use]
    pub fn single_other_primitive(&self) -> Option<u32> {
        match self.leaves() {
            [leaf] if leaf & OTHER_PRIMITIVE_BIT != 0 => Some(leaf ^ OTHER_PRIMITIVE_BIT),
            _ => None,
        }
    }

    /// Child references of the leaves in this list: numbers that encode kind and index of a child
    /// of a BVH node.
    #[inline]
    pub(super) fn leaves(&self) -> &[u32] {
        &self.leaves[..self.count]
    }
}

/// A box, repeated in each SIMD lane for overlap tests with eight boxes at a time.
struct OverlapTest {
    min: [f32x8; 3],
    max: [f32x8; 3],
}

impl OverlapTest {
    /// Repeats `bounds` in each SIMD lane.
    fn new(bounds: &Bounds) -> Self {
        Self { min: bounds.min.to_array().map(f32x8::splat), max: bounds.max.to_array().map(f32x8::splat) }
    }

    /// Bit mask of those of the eight `boxes` that overlap this box; boxes that only touch count
    /// too.
    #[inline]
    fn overlapping_boxes(&self, boxes: &Boxes8) -> u32 {
        let on_axis = |axis: usize| {
            let [lower, upper] = boxes.planes(axis);
            lower.simd_le(self.max[axis]) & upper.simd_ge(self.min[axis])
        };
        (on_axis(0) & on_axis(1) & on_axis(2)).to_bitmask()
    }
}
