//! Every box along a ray.

use super::bvh8::{ARITY, Node8, Slabs};
use super::ray_precalc::RayPrecalc;
use crate::math::{Bounds, Ray, morton_order};
use rayon::prelude::*;

/// A tree of boxes that finds all that a ray passes through.
///
/// No box is lost to rounding, and few are found that the ray misses, by 10⁻⁶ of their distance at most. Coordinates must be
/// below 10¹⁸ in magnitude.
///
/// Boxes lie in the order of their centres along a Morton curve, eight to a node, and so do the nodes above: that builds in a
/// fraction of the time of the surface area heuristic, whose better tree gains little where most of what is asked for is found.
pub struct Boxes {
    /// Indices of the boxes in the order of the curve.
    order: Vec<u32>,
    /// Nodes from the boxes up to the root: child i of node n is node 8n + i of the level below.
    levels: Vec<Vec<Node8>>,
}

/// 8¹⁰ boxes: a node's level and number share 32 bits.
const MOST_LEVELS: usize = 10;
const NUMBER_BITS: u32 = 28;
/// Each level leaves seven of its nodes behind while one is open.
const STACK: usize = (ARITY - 1) * MOST_LEVELS + 1;

/// By which part of the largest coordinate all boxes are padded: so little that a ray along an axis, whose reciprocals are cut off
/// at the largest number, still crosses a flat box at 10¹⁹ times the largest coordinate.
const PADDING: f32 = 1.0 / (1u64 << 63) as f32;

impl Boxes {
    /// Builds over at most 2³⁰ boxes. The tree does not depend on the number of threads. An empty box is never found.
    #[must_use]
    pub fn build(boxes: &[Bounds]) -> Self {
        let present: Vec<u32> = (0..boxes.len() as u32).filter(|&i| !boxes[i as usize].is_empty()).collect();
        let at = |i: &u32| &boxes[*i as usize];
        let order: Vec<u32> =
            morton_order(&present, |i| at(i).center()).par_iter().map(|&i| present[i as usize]).collect();
        let largest = order.par_iter().map(|i| at(i).min.abs().max(at(i).max.abs()).max_element());
        let margin = largest.reduce(|| 0.0, f32::max) * PADDING;
        let mut bounds: Vec<Bounds> = order.par_iter().map(|i| padded(at(i), margin)).collect();
        let mut levels = Vec::new();
        while !bounds.is_empty() {
            levels.push(bounds.par_chunks(ARITY).map(octet).collect());
            let around = |run: &[Bounds]| run.iter().fold(Bounds::EMPTY, |all, b| all.union(*b));
            bounds = if bounds.len() > ARITY { bounds.par_chunks(ARITY).map(around).collect() } else { Vec::new() };
        }
        Self { order, levels }
    }

    /// Shows `visit` the index of each box that the ray passes at `0 ≤ t ≤ t_max`, once, in an order that depends on nothing but
    /// the boxes. Allocates nothing.
    #[inline]
    pub fn along(&self, ray: &Ray, visit: &mut impl FnMut(u32)) {
        if !(RayPrecalc::fits(ray) && ray.t_max >= 0.0) || self.levels.is_empty() {
            return;
        }
        let probe = RayPrecalc::new(ray);
        let slabs = Slabs::new(&probe);
        let mut stack = [0u32; STACK];
        stack[0] = ((self.levels.len() - 1) as u32) << NUMBER_BITS;
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (level, number) = (stack[top] >> NUMBER_BITS, stack[top] & ((1 << NUMBER_BITS) - 1));
            let (mut hits, _) = self.levels[level as usize][number as usize].enter(&slabs, probe.t_max);
            while hits != 0 {
                let child = number * ARITY as u32 + hits.trailing_zeros();
                hits &= hits - 1;
                if level == 0 {
                    visit(self.order[child as usize]);
                } else {
                    stack[top] = (level - 1) << NUMBER_BITS | child;
                    top += 1;
                }
            }
        }
    }
}

fn octet(run: &[Bounds]) -> Node8 {
    let mut octet = Node8::VACANT;
    run.iter().enumerate().for_each(|(slot, b)| octet.set(slot, b.min, b.max));
    octet
}

/// A little outwards, and at least to the next number.
fn padded(b: &Bounds, margin: f32) -> Bounds {
    let wider = b.expanded(margin);
    let down = wider.min.to_array().map(f32::next_down);
    let up = wider.max.to_array().map(f32::next_up);
    Bounds { min: down.into(), max: up.into() }
}

#[cfg(test)]
mod tests;
