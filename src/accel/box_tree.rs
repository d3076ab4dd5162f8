//! Hierarchy of boxes that finds every box that a ray crosses.

use super::build::ARITY;
use super::bvh8::{Boxes8, SlabTestRay};
use super::ray_precalc::RayPrecalc;
use crate::math::{Bounds, Ray, morton_order};
use rayon::prelude::*;

/// Hierarchy of axis-aligned boxes. Its query finds every box that a ray crosses.
///
/// Rounding errors never hide a box from a query. A query may report a box that the ray misses by
/// up to about 2·10⁻⁶ of the distance from the ray's origin. Coordinates must be below 10¹⁸ in
/// magnitude.
///
/// The build sorts the boxes along a Morton curve, and packs eight consecutive boxes or nodes into
/// each node. Such a build is several times faster than a build by the surface area heuristic. A
/// better tree would gain little, because most boxes that a query visits are in its result.
pub struct BoxTree {
    /// Indices of the boxes, in the order of their centers along a Morton curve.
    sorted_box_indices: Vec<u32>,
    /// Nodes by level. Nodes of level 0 hold the boxes; the last level has one node, the root.
    ///
    /// Child i of node n is node 8n + i of the level below or, at level 0, box 8n + i of
    /// `sorted_box_indices`.
    levels: Vec<Vec<Boxes8>>,
}

/// Largest number of levels of a [`BoxTree`], enough for 8¹⁰ = 2³⁰ boxes.
const MAX_LEVELS: usize = 10;
/// Number of low bits of a traversal-stack entry. They hold the index of a node in its level; the
/// bits above them hold the level.
const NODE_INDEX_BITS: u32 = 28;
/// Capacity of the traversal stack. At each level, up to seven children of the visited node wait on
/// the stack while the eighth is visited.
const MAX_STACK_ENTRIES: usize = (ARITY - 1) * MAX_LEVELS + 1;

/// Distance by which each side of a box in a [`BoxTree`] is moved outwards, as a fraction of the
/// largest absolute coordinate of all boxes.
///
/// A ray along an axis has direction components of 0, whose infinite reciprocals are clamped to the
/// largest f32. With the padding, such a ray still hits a flat box at distances up to 10¹⁹ times
/// this coordinate.
const RELATIVE_PADDING: f32 = 1.0 / (1u64 << 63) as f32;

impl BoxTree {
    /// Builds a tree over at most 2³⁰ boxes. Queries report indices into `boxes`; empty boxes are
    /// never reported.
    ///
    /// The tree does not depend on the number of threads.
    #[must_use]
    pub fn build(boxes: &[Bounds]) -> Self {
        let at = |i: &u32| &boxes[*i as usize];
        let order: Vec<u32> = if boxes.par_iter().any(Bounds::is_empty) {
            let present: Vec<u32> = (0..boxes.len() as u32).filter(|i| !at(i).is_empty()).collect();
            morton_order(&present, |i| at(i).center()).par_iter().map(|&i| present[i as usize]).collect()
        } else {
            morton_order(boxes, Bounds::center)
        };
        let largest = order.par_iter().map(|i| at(i).min.abs().max(at(i).max.abs()).max_element());
        let margin = largest.reduce(|| 0.0, f32::max) * RELATIVE_PADDING;
        let mut bounds: Vec<Bounds> = order.par_iter().map(|i| padded_box(at(i), margin)).collect();
        let mut levels = Vec::new();
        while !bounds.is_empty() {
            levels.push(bounds.par_chunks(ARITY).map(boxes8_from_bounds).collect());
            let around = |run: &[Bounds]| run.iter().fold(Bounds::EMPTY, |all, b| all.union(*b));
            bounds = if bounds.len() > ARITY { bounds.par_chunks(ARITY).map(around).collect() } else { Vec::new() };
        }
        Self { sorted_box_indices: order, levels }
    }

    /// Calls `visit` once with the index of each box that the ray crosses at `0 ≤ t ≤ ray.t_max`.
    ///
    /// The order of the calls depends only on the boxes and the ray.
    #[inline]
    pub fn visit_boxes_along_ray(&self, ray: &Ray, visit: &mut impl FnMut(u32)) {
        if !(RayPrecalc::can_hit_anything(ray) && ray.t_max >= 0.0) || self.levels.is_empty() {
            return;
        }
        let precalc = RayPrecalc::new(ray);
        let slabs = SlabTestRay::new(&precalc);
        let mut stack = [0u32; MAX_STACK_ENTRIES];
        stack[0] = ((self.levels.len() - 1) as u32) << NODE_INDEX_BITS;
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (level, number) = (stack[top] >> NODE_INDEX_BITS, stack[top] & ((1 << NODE_INDEX_BITS) - 1));
            let (mut hits, _) = self.levels[level as usize][number as usize].intersect_boxes(&slabs, precalc.t_max);
            while hits != 0 {
                let child = number * ARITY as u32 + hits.trailing_zeros();
                hits &= hits - 1;
                if level == 0 {
                    visit(self.sorted_box_indices[child as usize]);
                } else {
                    stack[top] = (level - 1) << NODE_INDEX_BITS | child;
                    top += 1;
                }
            }
        }
    }
}

/// Packs up to eight boxes into one node.
fn boxes8_from_bounds(run: &[Bounds]) -> Boxes8 {
    let mut boxes = Boxes8::VACANT;
    run.iter().enumerate().for_each(|(slot, b)| boxes.set_box(slot, b.min, b.max));
    boxes
}

/// Returns the box `b` with each side moved outwards by `margin` and then rounded to the next f32
/// outwards.
fn padded_box(b: &Bounds, margin: f32) -> Bounds {
    let wider = b.expanded(margin);
    let down = wider.min.to_array().map(f32::next_down);
    let up = wider.max.to_array().map(f32::next_up);
    Bounds { min: down.into(), max: up.into() }
}

#[cfg(test)]
mod tests;
