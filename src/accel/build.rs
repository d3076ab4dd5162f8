//! The binary tree: surface area heuristic over binned centroids, and how best to cut it into wide nodes.

use super::bvh8::{ARITY, OTHER};
use super::packet::LANES;
use glam::Vec3A;

/// Depth at which the heuristic gives way to the median, so that no input grows a tree deeper than [`MAX_DEPTH`].
const HEURISTIC_DEPTH: u32 = 40;
/// Halving 2³¹ primitives takes 31 more levels.
pub(super) const MAX_DEPTH: u32 = HEURISTIC_DEPTH + 31;

const BINS: usize = 32;
/// Ranges below this are not worth another thread.
const PARALLEL: usize = 4096;

/// Costs of a packet of triangles and of a closure's call, in visits of a node; half or twice as much is no faster.
const PACKET_COST: f32 = 0.7;
const OTHER_COST: f32 = 1.0;

/// A padded box and its primitive: the index of a triangle, or `OTHER` and the index of another primitive.
#[derive(Clone, Copy)]
pub(super) struct Fragment {
    pub bounds: Slab,
    pub key: u32,
}

/// A box in vector registers.
#[derive(Clone, Copy)]
pub(super) struct Slab {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Slab {
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline]
    fn half_area(self) -> f32 {
        let e = self.max - self.min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Twice the centre.
    #[inline]
    fn center(self) -> Vec3A {
        self.min + self.max
    }
}

/// A node of the binary tree over `size` fragments, in preorder: the left child follows, the right one `2 · left` later.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    pub bounds: Slab,
    pub size: u32,
    /// Fragments in the left subtree.
    pub left: u32,
    /// For 2 to [`ARITY`] slots of a wide node: how many go to the left child; 0 where fewer slots serve as well.
    pub share: [u8; ARITY + 1],
    /// Whether one slot holds all as a leaf.
    pub leaf: bool,
}

impl Branch {
    pub const VACANT: Self = Self { bounds: Slab::EMPTY, size: 0, left: 0, share: [0; ARITY + 1], leaf: true };
}

/// How many of either kind lie in a range.
#[derive(Clone, Copy, Default)]
struct Count {
    triangles: u32,
    others: u32,
}

impl Count {
    #[inline]
    fn add(&mut self, other: Self) {
        self.triangles += other.triangles;
        self.others += other.others;
    }

    fn of(key: u32) -> Self {
        let others = u32::from(key & OTHER != 0);
        Self { triangles: 1 - others, others }
    }

    /// Cost of testing all, as full packets where there are triangles enough.
    fn cost(self) -> f32 {
        let packets = self.triangles.div_ceil(LANES as u32);
        packets as f32 * PACKET_COST + self.others as f32 * OTHER_COST
    }
}

/// What a parent must know of a subtree: its box, its contents, and its least cost in 1 to [`ARITY`] slots.
struct Summary {
    bounds: Slab,
    count: Count,
    cost: [f32; ARITY + 1],
}

/// Grows the tree over `fragments`, which it reorders, into `tree` of length `2 n − 1`.
pub(super) fn grow(fragments: &mut [Fragment], tree: &mut [Branch]) {
    if !fragments.is_empty() {
        branch(fragments, tree, 0);
    }
}

fn branch(fragments: &mut [Fragment], tree: &mut [Branch], depth: u32) -> Summary {
    let size = fragments.len();
    let Some((root, rest)) = tree.split_first_mut().filter(|_| size > 1) else {
        let Fragment { bounds, key } = fragments[0];
        tree[0] = Branch { bounds, size: 1, ..Branch::VACANT };
        let count = Count::of(key);
        return Summary { bounds, count, cost: [bounds.half_area() * count.cost(); ARITY + 1] };
    };
    let left = split(fragments, depth);
    let (low, high) = fragments.split_at_mut(left);
    let (low_tree, high_tree) = rest.split_at_mut(2 * left - 1);
    let (a, b) = if size > PARALLEL {
        rayon::join(|| branch(low, low_tree, depth + 1), || branch(high, high_tree, depth + 1))
    } else {
        (branch(low, low_tree, depth + 1), branch(high, high_tree, depth + 1))
    };
    *root = Branch { size: size as u32, left: left as u32, ..Branch::VACANT };
    cut(root, &a, &b)
}

/// Least cost of the branch in any number of slots: each number splits between the children as is cheapest, and one slot
/// holds a leaf or a wide node (after Ylitie, Karras and Laine 2017, section 3.1).
fn cut(root: &mut Branch, a: &Summary, b: &Summary) -> Summary {
    let bounds = a.bounds.union(b.bounds);
    let mut count = a.count;
    count.add(b.count);
    let area = bounds.half_area();
    let mut cost = [f32::INFINITY; ARITY + 1];
    for (slots, least) in cost.iter_mut().enumerate().skip(2) {
        // Costs may overflow; a share is then as good as any.
        root.share[slots] = 1;
        for share in 1..slots {
            let c = a.cost[share] + b.cost[slots - share];
            if c < *least {
                *least = c;
                root.share[slots] = share as u8;
            }
        }
    }
    let (node, leaf) = (area + cost[ARITY], area * count.cost());
    let fits = count.others == 0 && count.triangles <= LANES as u32;
    root.leaf = fits && leaf <= node;
    cost[1] = if root.leaf { leaf } else { node };
    for slots in 2..=ARITY {
        // Strictly: a wide node may then always be opened, even where areas vanish or overflow.
        if cost[slots - 1] < cost[slots] {
            cost[slots] = cost[slots - 1];
            root.share[slots] = 0;
        }
    }
    root.bounds = bounds;
    Summary { bounds, count, cost }
}

/// Reorders the fragments into a lower and an upper part and returns the size of the lower, neither being empty.
fn split(fragments: &mut [Fragment], depth: u32) -> usize {
    let size = fragments.len();
    let centers =
        fragments.iter().fold(Slab::EMPTY, |s, f| s.union(Slab { min: f.bounds.center(), max: f.bounds.center() }));
    let extent = centers.max - centers.min;
    if depth < HEURISTIC_DEPTH
        && size > 2
        && let Some((axis, edge)) = best_plane(fragments, centers)
    {
        let bins = Binning::new(centers, size);
        return partition(fragments, |f| bins.of(f)[axis] <= edge);
    }
    let axis = extent.max_position();
    let by_center = |a: &Fragment, b: &Fragment| {
        a.bounds.center()[axis].total_cmp(&b.bounds.center()[axis]).then(a.key.cmp(&b.key))
    };
    fragments.select_nth_unstable_by(size / 2, by_center);
    size / 2
}

/// Maps centres to bins along each axis.
struct Binning {
    origin: Vec3A,
    scale: Vec3A,
    last: Vec3A,
    bins: usize,
}

impl Binning {
    fn new(centers: Slab, size: usize) -> Self {
        let bins = BINS.min(4 + size / 8);
        // Just below the number of bins, so that the largest centre falls into the last.
        let scale = Vec3A::splat(bins as f32 * 0.999_99) / (centers.max - centers.min);
        Self { origin: centers.min, scale, last: Vec3A::splat((bins - 1) as f32), bins }
    }

    #[inline]
    fn of(&self, f: &Fragment) -> [usize; 3] {
        let at = ((f.bounds.center() - self.origin) * self.scale).min(self.last);
        [at.x as u32 as usize, at.y as u32 as usize, at.z as u32 as usize]
    }
}

/// The axis and the last lower bin of the cheapest partition; `None` where the centres coincide or costs overflow.
fn best_plane(fragments: &[Fragment], centers: Slab) -> Option<(usize, usize)> {
    let binning = Binning::new(centers, fragments.len());
    let mut bins = [[(Slab::EMPTY, Count::default()); BINS]; 3];
    for f in fragments {
        let (at, count) = (binning.of(f), Count::of(f.key));
        for axis in 0..3 {
            let bin = &mut bins[axis][at[axis].min(BINS - 1)];
            bin.0 = bin.0.union(f.bounds);
            bin.1.add(count);
        }
    }
    let cost = |bounds: Slab, count: Count| bounds.half_area() * (count.triangles + count.others) as f32;
    let (mut least, mut best) = (f32::INFINITY, None);
    let extent = centers.max - centers.min;
    for axis in (0..3).filter(|&a| extent[a] > 0.0) {
        let bins = &bins[axis][..binning.bins];
        let mut upper = [0.0; BINS];
        let (mut bounds, mut count) = (Slab::EMPTY, Count::default());
        for (at, bin) in bins.iter().enumerate().skip(1).rev() {
            bounds = bounds.union(bin.0);
            count.add(bin.1);
            upper[at - 1] = cost(bounds, count);
        }
        let (mut bounds, mut count) = (Slab::EMPTY, Count::default());
        for (at, bin) in bins[..bins.len() - 1].iter().enumerate() {
            bounds = bounds.union(bin.0);
            count.add(bin.1);
            let total = cost(bounds, count) + upper[at];
            // Empty bins repeat the partition before them.
            if bin.1.triangles + bin.1.others > 0 && total < least {
                (least, best) = (total, Some((axis, at)));
            }
        }
    }
    best
}

/// Moves those that satisfy `low` to the front, in an order that depends on nothing but the input, and counts them.
fn partition(fragments: &mut [Fragment], low: impl Fn(&Fragment) -> bool) -> usize {
    let mut end = 0;
    for at in 0..fragments.len() {
        if low(&fragments[at]) {
            fragments.swap(end, at);
            end += 1;
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(tree: &[Branch]) -> u32 {
        match tree[0] {
            Branch { size: 1, .. } => 0,
            Branch { left, .. } => 1 + depth(&tree[1..]).max(depth(&tree[2 * left as usize..])),
        }
    }

    /// Boxes that double in size and distance make the heuristic peel off the largest few, again and again.
    #[test]
    fn depth_is_bounded_where_the_heuristic_would_go_deeper() {
        let series = (0..126u32).map(|i| (f32::from_bits((i + 64) << 23), i));
        let fragment = |(x, key): (f32, u32)| {
            let bounds = Slab { min: Vec3A::splat(x * 0.9), max: Vec3A::splat(x) };
            Fragment { bounds, key }
        };
        let mut fragments: Vec<Fragment> = series.map(fragment).collect();
        let mut tree = vec![Branch::VACANT; 2 * fragments.len() - 1];
        grow(&mut fragments, &mut tree);
        let depth = depth(&tree);
        assert!(depth > HEURISTIC_DEPTH && depth <= HEURISTIC_DEPTH + 7, "{depth}");
    }
}
