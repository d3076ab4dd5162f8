//! Stack of nodes and leaves to visit in a BVH traversal.

use super::build::{ARITY, MAX_DEPTH};
use super::bvh8::EXIT_FACTOR;
use arrayvec::ArrayVec;
use wide::f32x8;

/// Largest number of entries on the stack, reached in the deepest tree. At each level, the visited
/// node leaves all its children except one on the stack. At the last level, all children are on the
/// stack for a moment, until they are sorted and the nearest one is popped.
const MAX_ENTRIES: usize = (ARITY - 1) * (MAX_DEPTH as usize + 1) + ARITY;

/// Nodes and leaves that a ray enters and that a traversal has still to visit.
///
/// The upper 32 bits of an entry are the ray parameter (f32) at which the ray enters the child, the
/// lower 32 bits the child reference. The parameter is not negative, so entries that are compared
/// as integers sort by this parameter.
pub(super) struct TraversalStack(ArrayVec<u64, MAX_ENTRIES>);

impl TraversalStack {
    /// Returns an empty stack.
    #[inline]
    pub fn new() -> Self {
        Self(ArrayVec::new_const())
    }

    /// Returns the child to visit next, and pushes all others that the ray enters onto the stack.
    ///
    /// A set bit in `hits` marks a child that the ray enters; `hits` must not be 0. `near` holds
    /// the ray parameter at which the ray enters each child. If `SORTED`, children are visited from
    /// near to far.
    #[inline(always)]
    pub fn push_all_but_next<const SORTED: bool>(
        &mut self,
        children: &[u32; ARITY],
        mut hits: u32,
        near: f32x8,
    ) -> u32 {
        let Self(entries) = self;
        let slot = |hits: u32| hits.trailing_zeros() as usize & (ARITY - 1);
        let entry = |slot: usize| u64::from(near.as_array()[slot].to_bits()) << 32 | u64::from(children[slot]);

        // Most rays enter one or two children: these need no loop.
        let rest = hits & (hits - 1);
        if rest == 0 {
            return children[slot(hits)];
        }
        if SORTED && rest & (rest - 1) == 0 {
            let (a, b) = (entry(slot(hits)), entry(slot(rest)));
            entries.push(a.max(b));
            return a.min(b) as u32;
        }

        // Insert each child below the nearer ones.
        let base = entries.len();
        while hits != 0 {
            let entry = entry(slot(hits));
            hits &= hits - 1;
            let mut at = entries.len();
            entries.push(entry);
            while SORTED && at > base && entries[at - 1] < entry {
                entries[at] = entries[at - 1];
                at -= 1;
            }
            entries[at] = entry;
        }
        entries.pop().map_or(0, |nearest| nearest as u32)
    }

    /// Pops entries until it finds a child that the ray enters at a ray parameter of at most
    /// `limit`, and returns the reference of this child.
    ///
    /// Returns `None` if no such child is left. The comparison has a margin for rounding errors.
    #[inline(always)]
    pub fn pop(&mut self, limit: f32) -> Option<u32> {
        loop {
            let entry = self.0.pop()?;
            if f32::from_bits((entry >> 32) as u32) <= limit * EXIT_FACTOR {
                return Some(entry as u32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_are_visited_from_near_to_far() {
        let children = [10, 11, 12, 13, 14, 15, 16, 17];
        let near = f32x8::from([5.0, 2.0, 7.0, 1.0, 4.0, 0.0, 3.0, 6.0]);
        let visited = |hits: u32, limit: f32| {
            let mut stack = TraversalStack::new();
            let mut visited = vec![stack.push_all_but_next::<true>(&children, hits, near)];
            visited.extend(std::iter::from_fn(|| stack.pop(limit)));
            visited
        };
        assert_eq!(visited(0b1111_1111, 10.0), [15, 13, 11, 16, 14, 10, 17, 12]);
        // Child 11 is missed, and three children begin beyond the limit.
        assert_eq!(visited(0b1111_1101, 4.5), [15, 13, 16, 14]);
        assert_eq!(visited(0b0000_0011, 10.0), [11, 10]);
        assert_eq!(visited(0b0000_0001, 10.0), [10]);
    }
}
