//! Build of a binary BVH by the surface area heuristic over binned centroids.
//!
//! The build also decides which binary nodes become the children of one wide node, which has up to
//! eight children.

use super::packet::LANES;
use glam::Vec3A;

/// Number of child slots of a wide node: a node of the finished hierarchy, which is made from
/// several nodes of the binary tree.
pub(super) const ARITY: usize = 8;

/// Bit that is set in the code of a primitive other than a triangle, and not set in the code of a
/// triangle.
///
/// The other 31 bits of the code are the index among the triangles, or among the other primitives.
pub(super) const OTHER_PRIMITIVE_BIT: u32 = 1 << 31;

/// Depth of the binary tree from which nodes are split at the median instead of by the surface area
/// heuristic.
///
/// A median split halves the number of primitives, so the depth of the tree cannot exceed
/// [`MAX_DEPTH`].
const MEDIAN_SPLIT_DEPTH: u32 = 40;
/// Largest depth of the binary tree: median splits of 2³¹ primitives take 31 more levels.
pub(super) const MAX_DEPTH: u32 = MEDIAN_SPLIT_DEPTH + 31;

/// Largest number of bins along each axis, into which the surface area heuristic sorts primitives
/// by their centers.
const MAX_BINS: usize = 32;
/// Largest number of primitives of a node whose two subtrees are built by one thread, one after the
/// other. Subtrees of larger nodes are built in parallel.
const MAX_SERIAL_BUILD_PRIMITIVES: usize = 4096;

/// Cost of intersecting a packet (up to eight triangles that are tested together), relative to the
/// cost of visiting a node.
///
/// The value is tuned: neither half nor twice this value makes renders faster.
const PACKET_COST: f32 = 0.7;
/// Cost of intersecting one primitive other than a triangle, relative to visiting a node.
const OTHER_PRIMITIVE_COST: f32 = 1.0;

/// A primitive during the build: its padded box, and the code that identifies it.
///
/// The code is a triangle's index, or another primitive's index with the bit
/// [`OTHER_PRIMITIVE_BIT`] set.
#[derive(Clone, Copy)]
pub(super) struct BvhPrimitive {
    pub bounds: SimdBox,
    pub primitive_code: u32,
}

/// Axis-aligned box in SIMD registers.
#[derive(Clone, Copy)]
pub(super) struct SimdBox {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl SimdBox {
    /// Inverted box, which contains no point.
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// Smallest box around the boxes `self` and `other`.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface area of a box that is not empty.
    #[inline]
    fn half_area(self) -> f32 {
        let e = self.max - self.min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Sum of both corners, which is twice the center. The build only compares centers, so it
    /// leaves out the factor ½.
    #[inline]
    fn doubled_center(self) -> Vec3A {
        self.min + self.max
    }
}

/// Node of the binary tree, which is stored in preorder.
///
/// The left child is the next node. A left subtree of n = `left_primitive_count` primitives has 2n
/// − 1 nodes, so the right child is 2n nodes after this one.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub bounds: SimdBox,
    /// Number of primitives in the subtree of this node.
    pub primitive_count: u32,
    /// Number of primitives in the left subtree; 0 for a single primitive.
    pub left_primitive_count: u32,
    /// Best division of child slots between the two subtrees of this node, for the conversion to
    /// wide nodes, which have [`ARITY`] child slots.
    ///
    /// If descendants of this node fill n slots of a wide node (2 ≤ n ≤ [`ARITY`]), `left_slots[n]`
    /// of them are from the left subtree, and the others from the right subtree. This division has
    /// the least traversal cost. If `left_slots[n]` is 0, fewer than n slots cost less, and the
    /// entry of n − 1 applies.
    pub left_slots: [u8; ARITY + 1],
    /// True if all primitives of this node become one leaf of the finished hierarchy: a packet of
    /// triangles or one other primitive.
    pub is_leaf: bool,
}

impl BinaryNode {
    /// Placeholder for a node that is not built yet.
    pub const VACANT: Self = Self {
        bounds: SimdBox::EMPTY,
        primitive_count: 0,
        left_primitive_count: 0,
        left_slots: [0; ARITY + 1],
        is_leaf: true,
    };
}

/// Number of triangles and number of other primitives in a subtree or bin.
#[derive(Clone, Copy, Default)]
struct PrimitiveCounts {
    triangles: u32,
    others: u32,
}

impl PrimitiveCounts {
    #[inline]
    fn add(&mut self, other: Self) {
        self.triangles += other.triangles;
        self.others += other.others;
    }

    /// Counts one primitive: a triangle or another primitive, as its code `primitive_code` tells.
    fn from_primitive_code(primitive_code: u32) -> Self {
        let others = u32::from(primitive_code & OTHER_PRIMITIVE_BIT != 0);
        Self { triangles: 1 - others, others }
    }

    /// Cost of intersecting the counted primitives, relative to the cost of visiting a node.
    fn intersection_cost(self) -> f32 {
        let packets = self.triangles.div_ceil(LANES as u32);
        packets as f32 * PACKET_COST + self.others as f32 * OTHER_PRIMITIVE_COST
    }
}

/// Box, primitive counts and traversal costs of a subtree that has been built.
///
/// `min_cost_by_slots[n]` is the least traversal cost of the subtree if its nodes fill at most n
/// child slots of a wide node, with n from 1 to [`ARITY`]. The cost of each node is multiplied by
/// half the surface area of its box, because a ray meets large boxes more often.
struct SubtreeSummary {
    bounds: SimdBox,
    count: PrimitiveCounts,
    min_cost_by_slots: [f32; ARITY + 1],
}

/// Builds the binary tree over n `primitives` into `tree`, which must have 2 n − 1 nodes.
///
/// The primitives are reordered, so that those of each node are consecutive.
pub(super) fn build_tree(primitives: &mut [BvhPrimitive], tree: &mut [BinaryNode]) {
    if !primitives.is_empty() {
        build_subtree(primitives, tree, 0);
    }
}

/// Builds the subtree over the non-empty slice `primitives` into `tree`. Its root has depth `depth`
/// in the whole tree.
fn build_subtree(primitives: &mut [BvhPrimitive], tree: &mut [BinaryNode], depth: u32) -> SubtreeSummary {
    let size = primitives.len();
    let Some((root, rest)) = tree.split_first_mut().filter(|_| size > 1) else {
        let BvhPrimitive { bounds, primitive_code } = primitives[0];
        tree[0] = BinaryNode { bounds, primitive_count: 1, ..BinaryNode::VACANT };
        let count = PrimitiveCounts::from_primitive_code(primitive_code);
        return SubtreeSummary {
            bounds,
            count,
            min_cost_by_slots: [bounds.half_area() * count.intersection_cost(); ARITY + 1],
        };
    };
    let left = split_primitives(primitives, depth);
    let (low, high) = primitives.split_at_mut(left);
    let (low_tree, high_tree) = rest.split_at_mut(2 * left - 1);
    let (a, b) = if size > MAX_SERIAL_BUILD_PRIMITIVES {
        rayon::join(|| build_subtree(low, low_tree, depth + 1), || build_subtree(high, high_tree, depth + 1))
    } else {
        (build_subtree(low, low_tree, depth + 1), build_subtree(high, high_tree, depth + 1))
    };
    *root = BinaryNode { primitive_count: size as u32, left_primitive_count: left as u32, ..BinaryNode::VACANT };
    finish_inner_node(root, &a, &b)
}

/// Sets box, leaf flag and [`left_slots`](BinaryNode::left_slots) of `root`, whose subtrees are `a`
/// and `b`.
///
/// Returns the summary of the subtree of `root`. The values of `left_slots` minimize the traversal
/// cost of the finished hierarchy, whose nodes have eight children (after Ylitie, Karras and Laine
/// 2017, section 3.1).
fn finish_inner_node(root: &mut BinaryNode, a: &SubtreeSummary, b: &SubtreeSummary) -> SubtreeSummary {
    let bounds = a.bounds.union(b.bounds);
    let mut count = a.count;
    count.add(b.count);
    let area = bounds.half_area();
    let mut cost = [f32::INFINITY; ARITY + 1];
    for (slots, least) in cost.iter_mut().enumerate().skip(2) {
        // Costs may overflow to infinity. Any division is then equally good.
        root.left_slots[slots] = 1;
        for share in 1..slots {
            let c = a.min_cost_by_slots[share] + b.min_cost_by_slots[slots - share];
            if c < *least {
                *least = c;
                root.left_slots[slots] = share as u8;
            }
        }
    }
    let (node, leaf) = (area + cost[ARITY], area * count.intersection_cost());
    let fits = count.others == 0 && count.triangles <= LANES as u32;
    root.is_leaf = fits && leaf <= node;
    cost[1] = if root.is_leaf { leaf } else { node };
    for slots in 2..=ARITY {
        // The comparison is strict: of equal costs, the one that fills more slots wins. So a wide
        // node gets two or more children even if all areas are 0 or infinite.
        if cost[slots - 1] < cost[slots] {
            cost[slots] = cost[slots - 1];
            root.left_slots[slots] = 0;
        }
    }
    root.bounds = bounds;
    SubtreeSummary { bounds, count, min_cost_by_slots: cost }
}

/// Splits a node: reorders its primitives into two non-empty parts and returns the size of the
/// first.
///
/// The split is by the surface area heuristic or, from [`MEDIAN_SPLIT_DEPTH`] on, at the median.
fn split_primitives(primitives: &mut [BvhPrimitive], depth: u32) -> usize {
    let size = primitives.len();
    let centers = primitives.iter().fold(SimdBox::EMPTY, |s, primitive| {
        s.union(SimdBox { min: primitive.bounds.doubled_center(), max: primitive.bounds.doubled_center() })
    });
    let extent = centers.max - centers.min;
    if depth < MEDIAN_SPLIT_DEPTH
        && size > 2
        && let Some((axis, edge)) = best_split_axis_and_bin(primitives, centers)
    {
        let bins = CentroidBinning::new(centers, size);
        return partition_primitives(primitives, |primitive| bins.bin_indices(primitive)[axis] <= edge);
    }
    let axis = extent.max_position();
    let by_center = |a: &BvhPrimitive, b: &BvhPrimitive| {
        a.bounds.doubled_center()[axis]
            .total_cmp(&b.bounds.doubled_center()[axis])
            .then(a.primitive_code.cmp(&b.primitive_code))
    };
    primitives.select_nth_unstable_by(size / 2, by_center);
    size / 2
}

/// Map from the center of a primitive to its bin along each axis, for the surface area heuristic.
///
/// Center coordinates are doubled, as in [`SimdBox::doubled_center`].
struct CentroidBinning {
    origin: Vec3A,
    scale: Vec3A,
    last_bin: Vec3A,
    bin_count: usize,
}

impl CentroidBinning {
    /// Binning for `size` primitives whose doubled centers lie in the box `centers`.
    fn new(centers: SimdBox, size: usize) -> Self {
        let bins = MAX_BINS.min(4 + size / 8);
        // The factor is just below the number of bins, so that the largest center falls into the
        // last bin.
        let scale = Vec3A::splat(bins as f32 * 0.999_99) / (centers.max - centers.min);
        Self { origin: centers.min, scale, last_bin: Vec3A::splat((bins - 1) as f32), bin_count: bins }
    }

    /// Index of the bin that contains the center of `primitive`, along each axis.
    #[inline]
    fn bin_indices(&self, primitive: &BvhPrimitive) -> [usize; 3] {
        let at = ((primitive.bounds.doubled_center() - self.origin) * self.scale).min(self.last_bin);
        [at.x as u32 as usize, at.y as u32 as usize, at.z as u32 as usize]
    }
}

/// Finds the cheapest split by the surface area heuristic. Returns the axis of the split, and the
/// index of the last bin below the split.
///
/// Returns `None` if all centers coincide or the costs overflow. `centers` is the box around the
/// doubled centers of `primitives`.
fn best_split_axis_and_bin(primitives: &[BvhPrimitive], centers: SimdBox) -> Option<(usize, usize)> {
    let binning = CentroidBinning::new(centers, primitives.len());
    let mut bins = [[(SimdBox::EMPTY, PrimitiveCounts::default()); MAX_BINS]; 3];
    for primitive in primitives {
        let (at, count) =
            (binning.bin_indices(primitive), PrimitiveCounts::from_primitive_code(primitive.primitive_code));
        for axis in 0..3 {
            let bin = &mut bins[axis][at[axis].min(MAX_BINS - 1)];
            bin.0 = bin.0.union(primitive.bounds);
            bin.1.add(count);
        }
    }
    let cost = |bounds: SimdBox, count: PrimitiveCounts| bounds.half_area() * (count.triangles + count.others) as f32;
    let (mut least, mut best) = (f32::INFINITY, None);
    let extent = centers.max - centers.min;
    for axis in (0..3).filter(|&a| extent[a] > 0.0) {
        let bins = &bins[axis][..binning.bin_count];
        let mut upper = [0.0; MAX_BINS];
        let (mut bounds, mut count) = (SimdBox::EMPTY, PrimitiveCounts::default());
        for (at, bin) in bins.iter().enumerate().skip(1).rev() {
            bounds = bounds.union(bin.0);
            count.add(bin.1);
            upper[at - 1] = cost(bounds, count);
        }
        let (mut bounds, mut count) = (SimdBox::EMPTY, PrimitiveCounts::default());
        for (at, bin) in bins[..bins.len() - 1].iter().enumerate() {
            bounds = bounds.union(bin.0);
            count.add(bin.1);
            let total = cost(bounds, count) + upper[at];
            // A split after an empty bin equals the split before it.
            if bin.1.triangles + bin.1.others > 0 && total < least {
                (least, best) = (total, Some((axis, at)));
            }
        }
    }
    best
}

/// Moves the primitives for which `low` returns true to the front of the slice, and returns how
/// many there are.
fn partition_primitives(primitives: &mut [BvhPrimitive], low: impl Fn(&BvhPrimitive) -> bool) -> usize {
    let mut end = 0;
    for at in 0..primitives.len() {
        if low(&primitives[at]) {
            primitives.swap(end, at);
            end += 1;
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of levels below the root of `tree`.
    fn tree_depth(tree: &[BinaryNode]) -> u32 {
        match tree[0] {
            BinaryNode { primitive_count: 1, .. } => 0,
            BinaryNode { left_primitive_count: left, .. } => {
                1 + tree_depth(&tree[1..]).max(tree_depth(&tree[2 * left as usize..]))
            }
        }
    }

    /// The depth of a tree over boxes that double in size and distance is bounded.
    ///
    /// The surface area heuristic splits off only a few of these boxes at a time.
    #[test]
    fn bvh_depth_is_bounded() {
        let series = (0..126u32).map(|i| (f32::from_bits((i + 64) << 23), i));
        let primitive = |(x, primitive_code): (f32, u32)| {
            let bounds = SimdBox { min: Vec3A::splat(x * 0.9), max: Vec3A::splat(x) };
            BvhPrimitive { bounds, primitive_code }
        };
        let mut primitives: Vec<BvhPrimitive> = series.map(primitive).collect();
        let mut tree = vec![BinaryNode::VACANT; 2 * primitives.len() - 1];
        build_tree(&mut primitives, &mut tree);
        let depth = tree_depth(&tree);
        assert!(depth > MEDIAN_SPLIT_DEPTH && depth <= MEDIAN_SPLIT_DEPTH + 7, "{depth}");
    }
}
