//! Bounding volume hierarchy over f64 boxes, with eight children per node.

use glam::DVec3;

/// Number of children of a node.
const ARITY: usize = 8;

/// Bit of a child reference in a node: set if the child is a leaf, which is a box instead of
/// another node.
const LEAF_BIT: u32 = 1 << 31;

/// Node with eight children. An unused slot has the lower corner +∞ and the upper corner −∞, so no
/// line hits it.
#[derive(Debug)]
struct BoxBvhNode {
    /// Bounds of the children, as `bounds[axis][side][child]` with side 0 lower and side 1 upper.
    bounds: [[[f64; ARITY]; 2]; 3],
    /// Child references: the index of a node or, with [`LEAF_BIT`], of a box.
    children: [u32; ARITY],
}

/// Lower and upper corner of an axis-aligned box.
pub type BoxCorners = [DVec3; 2];

/// Line in object space, with arc length τ as parameter.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Point of the line at arc length τ = 0.
    pub base: DVec3,
    /// Unit direction of the line.
    pub direction: DVec3,
    /// Reciprocal of each component of the direction; 10³⁰⁰ for a component within ±10⁻³⁰⁰.
    pub reciprocal_direction: DVec3,
}

impl Line {
    /// Line along the unit vector `direction`, with τ = 0 at its point `base`.
    pub fn new(base: DVec3, direction: DVec3) -> Self {
        let inverse = direction.map(|d| if d.abs() < 1e-300 { 1e300 } else { 1.0 / d });
        Self { base, direction, reciprocal_direction: inverse }
    }
}

/// Bounding volume hierarchy over boxes, with eight children per node.
#[derive(Debug)]
pub struct BoxBvh {
    nodes: Vec<BoxBvhNode>,
}

impl BoxBvh {
    /// Builds a hierarchy over one or more boxes, each expanded by `margin` on every side.
    pub fn new(boxes: &[BoxCorners], margin: f64) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut tree = Self { nodes: Vec::new() };
        tree.build_subtree(boxes, &mut order, margin);
        tree
    }

    /// Appends the node over `boxes[i]` for all i in `order`, and all nodes below it. Returns the
    /// index of the topmost node.
    ///
    /// Every box is expanded by `margin`. Reorders `order`.
    fn build_subtree(&mut self, boxes: &[BoxCorners], order: &mut [u32], margin: f64) -> u32 {
        let index = self.nodes.len();
        // Unused slots keep this inverted box, which no line hits.
        let empty = [[f64::INFINITY; ARITY], [f64::NEG_INFINITY; ARITY]];
        self.nodes.push(BoxBvhNode { bounds: [empty; 3], children: [0; ARITY] });
        let mut rest = order;
        let mut parts = Vec::new();
        if rest.len() <= ARITY {
            parts.extend(rest.chunks_mut(1));
        } else {
            let group_size = rest.len().div_ceil(ARITY);
            group_nearby_boxes(boxes, rest, group_size);
            while rest.len() > group_size {
                let (part, more) = rest.split_at_mut(group_size);
                parts.push(part);
                rest = more;
            }
            parts.push(rest);
        }
        for (i, part) in parts.into_iter().enumerate() {
            let [min, max] = enclosing_box(boxes, part);
            let child = if let [leaf] = part { *leaf | LEAF_BIT } else { self.build_subtree(boxes, part, margin) };
            let node = &mut self.nodes[index];
            for axis in 0..3 {
                node.bounds[axis][0][i] = min[axis] - margin;
                node.bounds[axis][1][i] = max[axis] + margin;
            }
            node.children[i] = child;
        }
        index as u32
    }

    /// Calls `visit` with the index of each box that `line` hits within `range`, in order roughly
    /// from near to far.
    ///
    /// `range` is an interval of arc length τ. If `visit` finds a hit, it moves the end of the
    /// interval to that hit.
    #[inline]
    pub fn visit_hit_leaves(&self, line: &Line, mut range: [f64; 2], mut visit: impl FnMut(usize, &mut [f64; 2])) {
        let mut stack = [(0u32, 0.0); 12 * ARITY];
        stack[0] = (0, range[0]);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (child, entry) = stack[count];
            if entry > range[1] {
                continue;
            }
            if child & LEAF_BIT != 0 {
                visit((child & !LEAF_BIT) as usize, &mut range);
                continue;
            }
            let node = &self.nodes[child as usize];
            let (mut lo, mut hi) = ([range[0]; ARITY], [range[1]; ARITY]);
            for axis in 0..3 {
                let (base, inverse) = (line.base[axis], line.reciprocal_direction[axis]);
                let [min, max] = &node.bounds[axis];
                for i in 0..ARITY {
                    let (a, b) = ((min[i] - base) * inverse, (max[i] - base) * inverse);
                    lo[i] = lo[i].max(a.min(b));
                    hi[i] = hi[i].min(a.max(b));
                }
            }
            // Pushes the children that the line hits, so that the nearest child is on top of the
            // stack.
            let start = count;
            for i in 0..ARITY {
                if lo[i] <= hi[i] && node.bounds[0][0][i] < f64::INFINITY {
                    let mut at = count;
                    while at > start && stack[at - 1].1 < lo[i] {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = (node.children[i], lo[i]);
                    count += 1;
                }
            }
        }
    }
}

/// Smallest box around the boxes with the indices `part`.
fn enclosing_box(boxes: &[BoxCorners], part: &[u32]) -> BoxCorners {
    part.iter()
        .map(|i| boxes[*i as usize])
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], [a, b]| [min.min(a), max.max(b)])
}

/// Reorders the box indices `part` so that each run of `group_size` indices has boxes close
/// together.
///
/// The indices are split recursively at the median along the longest axis.
fn group_nearby_boxes(boxes: &[BoxCorners], part: &mut [u32], group_size: usize) {
    if part.len() <= group_size {
        return;
    }
    let [min, max] = enclosing_box(boxes, part);
    let axis = (max - min).max_position();
    let center = |i: &u32| boxes[*i as usize][0][axis] + boxes[*i as usize][1][axis];
    let middle = (part.len().div_ceil(group_size) / 2) * group_size;
    part.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)).then(a.cmp(b)));
    let (first, last) = part.split_at_mut(middle);
    group_nearby_boxes(boxes, first, group_size);
    group_nearby_boxes(boxes, last, group_size);
}
