//! Bounding volume hierarchy of rings around the y axis, with eight children per node.

use super::cylindrical_ray::{ArcLengthInterval, CylindricalRay};
use arrayvec::ArrayVec;

/// Number of children of a node.
const ARITY: usize = 8;

/// Number of entries of the stack of a traversal. Each level replaces one entry by up to eight, so
/// 64 entries suffice for nine levels (1 + 9·7 = 64), which hold 8⁹ rings.
const MAX_STACK_ENTRIES: usize = 8 * ARITY;

/// Bit of a child reference in a node: set if the child is a leaf, which is a ring instead of
/// another node.
const LEAF_BIT: u32 = 1 << 31;

/// Node with eight children, each bounded by a ring around the y axis.
///
/// A ring is a range of squared radii and a range of heights. Both are expanded by the rounding
/// error of the intersection test.
#[derive(Debug)]
struct RingBvhNode {
    inner_radius2: [f64; ARITY],
    outer_radius2: [f64; ARITY],
    min_height: [f64; ARITY],
    max_height: [f64; ARITY],
    children: [u32; ARITY],
}

/// Ring around the y axis: a range of distances from the axis and a range of heights.
#[derive(Clone, Copy, Debug)]
pub struct RingBounds {
    pub radius: [f64; 2],
    pub height: [f64; 2],
}

impl RingBounds {
    /// The ring with all bounds moved outward by `margin`.
    pub fn expanded(self, margin: f64) -> Self {
        let expand = |[low, high]: [f64; 2]| [low - margin, high + margin];
        Self { radius: expand(self.radius), height: expand(self.height) }
    }

    /// True if the rings have a common point: their ranges of radii overlap, and so do their ranges
    /// of heights.
    pub fn overlaps(&self, other: &Self) -> bool {
        let meet = |a: [f64; 2], b: [f64; 2]| a[0] <= b[1] && b[0] <= a[1];
        meet(self.radius, other.radius) && meet(self.height, other.height)
    }

    /// Smallest ring that contains both rings.
    pub fn union(self, other: Self) -> Self {
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { radius: join(self.radius, other.radius), height: join(self.height, other.height) }
    }
}

/// Bounding volume hierarchy over rings. Nodes group rings that are adjacent along the profile.
#[derive(Debug)]
pub struct RingBvh {
    nodes: Vec<RingBvhNode>,
}

impl RingBvh {
    /// Builds a hierarchy over one or more rings; `size` bounds the distance of their points from
    /// the origin.
    pub fn new(rings: &[RingBounds], size: f64) -> Self {
        let mut tree = Self { nodes: Vec::new() };
        tree.build_subtree(rings, 0, 1e-12 * size);
        tree
    }

    /// Appends the node over `rings`, and all nodes below it. Returns the index of the topmost
    /// node.
    ///
    /// `first` is the index of `rings[0]` among all rings. Every ring is expanded by `margin`.
    fn build_subtree(&mut self, rings: &[RingBounds], first: usize, margin: f64) -> u32 {
        let index = self.nodes.len();
        let nowhere = [f64::INFINITY; ARITY];
        let (below, above) = (nowhere, nowhere.map(|x| -x));
        self.nodes.push(RingBvhNode {
            inner_radius2: nowhere,
            outer_radius2: above,
            min_height: below,
            max_height: above,
            children: [0; ARITY],
        });
        let share = rings.len().div_ceil(ARITY).max(1);
        for (i, part) in rings.chunks(share).enumerate() {
            let ring = part[1..].iter().fold(part[0], |a, b| a.union(*b));
            let start = first + i * share;
            let child = if part.len() == 1 { start as u32 | LEAF_BIT } else { self.build_subtree(part, start, margin) };
            let inner = (ring.radius[0] - margin).max(0.0);
            let outer = ring.radius[1] + margin;
            let node = &mut self.nodes[index];
            // The intersection test compares squared distances. Their rounding error is
            // proportional to the squared size of the surface.
            node.inner_radius2[i] = inner * inner - margin * margin * 1e6;
            node.outer_radius2[i] = outer * outer + margin * margin * 1e6;
            (node.min_height[i], node.max_height[i]) = (ring.height[0] - margin, ring.height[1] + margin);
            node.children[i] = child;
        }
        index as u32
    }

    /// Calls `visit` with the index of each ring that `ray` may hit within `t`, roughly from near
    /// to far.
    ///
    /// `t` is an interval of arc length τ. If `visit` finds a hit, it moves the end of the interval
    /// to that hit.
    #[inline]
    pub fn visit_hit_leaves(
        &self,
        ray: &CylindricalRay,
        mut t: ArcLengthInterval,
        mut visit: impl FnMut(usize, &mut ArcLengthInterval),
    ) {
        let dy = ray.direction.y;
        let inverse = if dy.abs() < 1e-300 { 1e300 } else { 1.0 / dy };
        let mut stack: ArrayVec<(u32, f64), MAX_STACK_ENTRIES> = ArrayVec::new();
        stack.push((0, t.lo));
        while let Some((child, entry)) = stack.pop() {
            if entry > t.hi {
                continue;
            }
            if child & LEAF_BIT != 0 {
                visit((child & !LEAF_BIT) as usize, &mut t);
                continue;
            }
            let node = &self.nodes[child as usize];
            let mut entries = [f64::INFINITY; ARITY];
            let [c0, c1, c2] = ray.radius2_coefficients;
            for (i, entry) in entries.iter_mut().enumerate() {
                let a = (node.min_height[i] - ray.base.y) * inverse;
                let b = (node.max_height[i] - ray.base.y) * inverse;
                let (lo, hi) = (t.lo.max(a.min(b)), t.hi.min(a.max(b)));
                let [p, q] = [lo, hi].map(|t| c0 + t * (2.0 * c1 + t * c2));
                let least =
                    if lo <= ray.tau_nearest_axis && ray.tau_nearest_axis <= hi { ray.min_radius2 } else { p.min(q) };
                let meets = lo <= hi && p.max(q) >= node.inner_radius2[i] && least <= node.outer_radius2[i];
                *entry = if meets { lo } else { f64::INFINITY };
            }
            // Pushes the children that the ray may hit, so that the nearest child is on top of the
            // stack.
            let start = stack.len();
            for (i, entry) in entries.into_iter().enumerate() {
                if entry < f64::INFINITY {
                    let mut at = stack.len();
                    stack.push((node.children[i], entry));
                    while at > start && stack[at - 1].1 < entry {
                        stack.swap(at, at - 1);
                        at -= 1;
                    }
                }
            }
        }
    }
}
