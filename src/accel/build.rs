//! Binary hierarchy by the surface area heuristic over binned centroids, and its cut into wide
//! nodes.

use super::packet::LANES;
use glam::Vec3A;

/// Children of a wide node.
pub(super) const ARITY: usize = 8;

/// Bit of a key that marks a primitive other than a triangle; the other bits are its index.
pub(super) const OTHER: u32 = 1 << 31;

/// Depth from which on median splits replace the heuristic, which bounds the depth by
/// [`MAX_DEPTH`].
const HEURISTIC_DEPTH: u32 = 40;
/// Median splits of 2³¹ primitives take 31 more levels.
pub(super) const MAX_DEPTH: u32 = HEURISTIC_DEPTH + 31;

const BINS: usize = 32;
/// Ranges smaller than this are built on one thread.
const PARALLEL: usize = 4096;

/// Costs of a triangle packet and of a closure call, relative to a node visit.
///
/// Half or twice these values are no faster.
const PACKET_COST: f32 = 0.7;
const OTHER_COST: f32 = 1.0;

/// Padded box with its key: a triangle index, or [`OTHER`] and the index of another primitive.
#[derive(Clone, Copy)]
pub(super) struct Fragment {
    pub bounds: SimdBox,
    pub key: u32,
}

/// Box in vector registers.
#[derive(Clone, Copy)]
pub(super) struct SimdBox {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl SimdBox {
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

/// Node of the binary tree over `size` fragments, in preorder.
///
/// The left child follows; the right child comes `2 · left` nodes later.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub bounds: SimdBox,
    pub size: u32,
    /// Number of fragments in the left subtree.
    pub left: u32,
    /// Number of slots that go to the left child, for 2 to [`ARITY`] slots of a wide node; 0 if
    /// fewer slots cost as little.
    pub share: [u8; ARITY + 1],
    /// True if one slot holds all fragments as a leaf.
    pub leaf: bool,
}

impl BinaryNode {
    pub const VACANT: Self = Self { bounds: SimdBox::EMPTY, size: 0, left: 0, share: [0; ARITY + 1], leaf: true };
}

/// Number of triangles and of other primitives in a range.
#[derive(Clone, Copy, Default)]
struct PrimitiveCount {
    triangles: u32,
    others: u32,
}

impl PrimitiveCount {
    #[inline]
    fn add(&mut self, other: Self) {
        self.triangles += other.triangles;
        self.others += other.others;
    }

    fn of(key: u32) -> Self {
        let others = u32::from(key & OTHER != 0);
        Self { triangles: 1 - others, others }
    }

    /// Cost of testing all primitives, with triangles in packets.
    fn cost(self) -> f32 {
        let packets = self.triangles.div_ceil(LANES as u32);
        packets as f32 * PACKET_COST + self.others as f32 * OTHER_COST
    }
}

/// Result of building a subtree: its box, its contents, and its least cost in 1 to [`ARITY`] slots.
struct Subtree {
    bounds: SimdBox,
    count: PrimitiveCount,
    cost: [f32; ARITY + 1],
}

/// Builds the tree over `fragments`, which it reorders, into `tree` of length `2 n − 1`.
pub(super) fn build_tree(fragments: &mut [Fragment], tree: &mut [BinaryNode]) {
    if !fragments.is_empty() {
        build_node(fragments, tree, 0);
    }
}

fn build_node(fragments: &mut [Fragment], tree: &mut [BinaryNode], depth: u32) -> Subtree {
    let size = fragments.len();
    let Some((root, rest)) = tree.split_first_mut().filter(|_| size > 1) else {
        let Fragment { bounds, key } = fragments[0];
        tree[0] = BinaryNode { bounds, size: 1, ..BinaryNode::VACANT };
        let count = PrimitiveCount::of(key);
        return Subtree { bounds, count, cost: [bounds.half_area() * count.cost(); ARITY + 1] };
    };
    let left = split_fragments(fragments, depth);
    let (low, high) = fragments.split_at_mut(left);
    let (low_tree, high_tree) = rest.split_at_mut(2 * left - 1);
    let (a, b) = if size > PARALLEL {
        rayon::join(|| build_node(low, low_tree, depth + 1), || build_node(high, high_tree, depth + 1))
    } else {
        (build_node(low, low_tree, depth + 1), build_node(high, high_tree, depth + 1))
    };
    *root = BinaryNode { size: size as u32, left: left as u32, ..BinaryNode::VACANT };
    finish_inner_node(root, &a, &b)
}

/// Fills the node above subtrees `a` and `b`, and returns the summary of its own subtree.
///
/// Sets box, leaf flag and slot shares of `root`. For each number of slots of a wide node, the
/// share is the number of slots that `a` gets at the least cost. One slot holds a leaf or a wide
/// node (after Ylitie, Karras and Laine 2017, section 3.1).
fn finish_inner_node(root: &mut BinaryNode, a: &Subtree, b: &Subtree) -> Subtree {
    let bounds = a.bounds.union(b.bounds);
    let mut count = a.count;
    count.add(b.count);
    let area = bounds.half_area();
    let mut cost = [f32::INFINITY; ARITY + 1];
    for (slots, least) in cost.iter_mut().enumerate().skip(2) {
        // Costs may overflow; any division is then as good.
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
        // The strict comparison allows every wide node to be opened, even if areas vanish or
        // overflow.
        if cost[slots - 1] < cost[slots] {
            cost[slots] = cost[slots - 1];
            root.share[slots] = 0;
        }
    }
    root.bounds = bounds;
    Subtree { bounds, count, cost }
}

/// Reorders the fragments into two non-empty parts and returns the size of the first.
fn split_fragments(fragments: &mut [Fragment], depth: u32) -> usize {
    let size = fragments.len();
    let centers = fragments
        .iter()
        .fold(SimdBox::EMPTY, |s, f| s.union(SimdBox { min: f.bounds.center(), max: f.bounds.center() }));
    let extent = centers.max - centers.min;
    if depth < HEURISTIC_DEPTH
        && size > 2
        && let Some((axis, edge)) = best_split_plane(fragments, centers)
    {
        let bins = Binning::new(centers, size);
        return partition_fragments(fragments, |f| bins.of(f)[axis] <= edge);
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
    fn new(centers: SimdBox, size: usize) -> Self {
        let bins = BINS.min(4 + size / 8);
        // Just below the number of bins, so that the largest centre falls into the last bin.
        let scale = Vec3A::splat(bins as f32 * 0.999_99) / (centers.max - centers.min);
        Self { origin: centers.min, scale, last: Vec3A::splat((bins - 1) as f32), bins }
    }

    #[inline]
    fn of(&self, f: &Fragment) -> [usize; 3] {
        let at = ((f.bounds.center() - self.origin) * self.scale).min(self.last);
        [at.x as u32 as usize, at.y as u32 as usize, at.z as u32 as usize]
    }
}

/// Axis and last lower bin of the cheapest partition; `None` if centres coincide or costs overflow.
fn best_split_plane(fragments: &[Fragment], centers: SimdBox) -> Option<(usize, usize)> {
    let binning = Binning::new(centers, fragments.len());
    let mut bins = [[(SimdBox::EMPTY, PrimitiveCount::default()); BINS]; 3];
    for f in fragments {
        let (at, count) = (binning.of(f), PrimitiveCount::of(f.key));
        for axis in 0..3 {
            let bin = &mut bins[axis][at[axis].min(BINS - 1)];
            bin.0 = bin.0.union(f.bounds);
            bin.1.add(count);
        }
    }
    let cost = |bounds: SimdBox, count: PrimitiveCount| bounds.half_area() * (count.triangles + count.others) as f32;
    let (mut least, mut best) = (f32::INFINITY, None);
    let extent = centers.max - centers.min;
    for axis in (0..3).filter(|&a| extent[a] > 0.0) {
        let bins = &bins[axis][..binning.bins];
        let mut upper = [0.0; BINS];
        let (mut bounds, mut count) = (SimdBox::EMPTY, PrimitiveCount::default());
        for (at, bin) in bins.iter().enumerate().skip(1).rev() {
            bounds = bounds.union(bin.0);
            count.add(bin.1);
            upper[at - 1] = cost(bounds, count);
        }
        let (mut bounds, mut count) = (SimdBox::EMPTY, PrimitiveCount::default());
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

/// Moves fragments that satisfy `low` to the front and returns their number.
///
/// The order depends only on the input.
fn partition_fragments(fragments: &mut [Fragment], low: impl Fn(&Fragment) -> bool) -> usize {
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

    fn depth(tree: &[BinaryNode]) -> u32 {
        match tree[0] {
            BinaryNode { size: 1, .. } => 0,
            BinaryNode { left, .. } => 1 + depth(&tree[1..]).max(depth(&tree[2 * left as usize..])),
        }
    }

    /// Boxes that double in size and distance make the heuristic split off the largest few
    /// repeatedly.
    #[test]
    fn depth_is_bounded_where_the_heuristic_would_go_deeper() {
        let series = (0..126u32).map(|i| (f32::from_bits((i + 64) << 23), i));
        let fragment = |(x, key): (f32, u32)| {
            let bounds = SimdBox { min: Vec3A::splat(x * 0.9), max: Vec3A::splat(x) };
            Fragment { bounds, key }
        };
        let mut fragments: Vec<Fragment> = series.map(fragment).collect();
        let mut tree = vec![BinaryNode::VACANT; 2 * fragments.len() - 1];
        build_tree(&mut fragments, &mut tree);
        let depth = depth(&tree);
        assert!(depth > HEURISTIC_DEPTH && depth <= HEURISTIC_DEPTH + 7, "{depth}");
    }
}
