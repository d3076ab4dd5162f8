//! Bounding volume hierarchy with up to eight children per node, and its box test.

use super::build::{ARITY, BinaryNode, BvhPrimitive, OTHER_PRIMITIVE_BIT, SimdBox, build_tree};
use super::packet::{LANES, TrianglePacket};
use super::ray_precalc::RayPrecalc;
use crate::math::{Bounds, rounding_error_bound};
use glam::{DVec3, Vec3, Vec3A};
use wide::f32x8;

/// Bit of a child reference: set if the child is a packet, which holds up to eight triangles.
///
/// If [`OTHER_PRIMITIVE_BIT`] is set instead, the child is another primitive. If neither bit is
/// set, the child is a node.
const PACKET_BIT: u32 = 1 << 30;

/// Child reference of the root: node index 0, without the bits that mark leaves.
pub(super) const ROOT: u32 = 0;

/// Padding of a primitive's box on each side, as a fraction of the box's longest edge.
///
/// Let γ(n) be [`rounding_error_bound`], the relative error of n operations. The triangle test errs
/// by up to γ(9) of the distance along the ray, plus γ(9) of the triangle's size. The box test errs
/// by γ(3) of the distance. `RELATIVE_PADDING` covers the error relative to the size, and
/// [`EXIT_FACTOR`] the errors relative to the distance.
const RELATIVE_PADDING: f32 = rounding_error_bound(16);
/// Factor by which the box test enlarges the ray parameter at which a ray leaves a box, so that
/// rounding errors cannot lose a hit.
pub(super) const EXIT_FACTOR: f32 = 1.0 + 2.0 * rounding_error_bound(16);

/// Eight axis-aligned boxes, as `[axis][side]` with eight lower planes (side 0) or upper planes
/// (1).
///
/// An unused slot holds an inverted box, which no ray enters.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Boxes8([[f32x8; 2]; 3]);

/// Node of the hierarchy: the boxes of its children, and references to them.
#[repr(C, align(64))]
struct Node8 {
    boxes: Boxes8,
    /// Child references, one for each child: the index of a node, or the index of a packet of
    /// triangles with [`PACKET_BIT`] set, or the index of another primitive with
    /// [`OTHER_PRIMITIVE_BIT`] set.
    children: [u32; ARITY],
}

/// Bounding volume hierarchy whose nodes have up to eight children.
pub(super) struct Bvh8 {
    nodes: Vec<Node8>,
    packets: Vec<TrianglePacket>,
}

impl Bvh8 {
    /// Builds the hierarchy over triangles, given by corners, and other primitives, given by boxes.
    pub fn build(triangles: &[[Vec3; 3]], others: &[Bounds]) -> Self {
        // Triangles without area are left out. Rounding could produce hits on them, but they have
        // no normal.
        let boxes =
            triangles.iter().map(|t| if has_area(t) { Bounds::from_points(*t) } else { Bounds::EMPTY }).zip(0..);
        let mut primitives: Vec<BvhPrimitive> = boxes
            .chain(others.iter().copied().zip(OTHER_PRIMITIVE_BIT..))
            .filter(|(b, _)| !b.is_empty())
            .map(padded_primitive)
            .collect();
        let mut tree = vec![BinaryNode::VACANT; (2 * primitives.len()).saturating_sub(1)];
        build_tree(&mut primitives, &mut tree);
        let mut bvh = Self { nodes: Vec::new(), packets: Vec::new() };
        if !tree.is_empty() {
            let source = WideNodeInput { triangles, primitives: &primitives, tree: &tree };
            bvh.append_wide_subtree(&source, 0, 0);
        }
        bvh.nodes.shrink_to_fit();
        bvh.packets.shrink_to_fit();
        bvh
    }

    /// Appends the eight-child node that replaces the binary node with index `at`, and all
    /// eight-child nodes below it.
    ///
    /// `start` is the index of the first primitive below the binary node.
    fn append_wide_subtree(&mut self, source: &WideNodeInput, at: usize, start: usize) {
        let mut chosen = [(0, 0); ARITY];
        let mut count = 0;
        source.select_wide_node_children(at, start, ARITY, &mut |child| {
            chosen[count] = child;
            count += 1;
        });
        let mut node = Node8 { boxes: Boxes8::VACANT, children: [0; ARITY] };
        let index = self.nodes.len();
        self.nodes.push(Node8 { ..node });
        for (slot, &(at, start)) in chosen[..count].iter().enumerate() {
            let branch = &source.tree[at];
            node.boxes.set_box(slot, branch.bounds.min.into(), branch.bounds.max.into());
            let members = &source.primitives[start..start + branch.primitive_count as usize];
            node.children[slot] = if !branch.is_leaf {
                let child = self.nodes.len() as u32;
                self.append_wide_subtree(source, at, start);
                child
            } else if members[0].primitive_code & OTHER_PRIMITIVE_BIT != 0 {
                members[0].primitive_code
            } else {
                let mut codes = [0; LANES];
                codes.iter_mut().zip(members).for_each(|(code, member)| *code = member.primitive_code);
                self.packets.push(TrianglePacket::new(source.triangles, &codes[..members.len()]));
                PACKET_BIT | (self.packets.len() - 1) as u32
            };
        }
        self.nodes[index] = node;
    }

    /// True if the hierarchy has no primitives.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// True if the child reference `child` refers to a leaf (a packet of triangles or one other
    /// primitive); false if it refers to a node.
    #[inline]
    pub fn is_leaf(child: u32) -> bool {
        child >= PACKET_BIT
    }

    /// Boxes and child references of the inner node that the child reference `node` names.
    #[inline]
    pub fn node(&self, node: u32) -> (&Boxes8, &[u32; ARITY]) {
        let node = &self.nodes[node as usize];
        (&node.boxes, &node.children)
    }

    /// Packet of triangles that the child reference `leaf` names.
    #[inline]
    pub fn packet_of_leaf(&self, leaf: u32) -> &TrianglePacket {
        &self.packets[(leaf ^ PACKET_BIT) as usize]
    }
}

/// Origin and reciprocal direction of a ray, repeated in each SIMD lane for slab tests of eight
/// boxes at a time.
///
/// The fields are those of [`RayPrecalc`].
pub(super) struct SlabTestRay {
    origin: [f32x8; 3],
    reciprocal_direction: [f32x8; 3],
    near_sides: [usize; 3],
}

impl SlabTestRay {
    /// Repeats the constants `precalc` of a ray for eight boxes.
    #[inline]
    pub fn new(precalc: &RayPrecalc) -> Self {
        let ([ox, oy, oz], [rx, ry, rz]) = (precalc.origin, precalc.reciprocal_direction);
        Self {
            origin: [f32x8::splat(ox), f32x8::splat(oy), f32x8::splat(oz)],
            reciprocal_direction: [f32x8::splat(rx), f32x8::splat(ry), f32x8::splat(rz)],
            near_sides: precalc.near_sides,
        }
    }
}

impl Boxes8 {
    /// Eight unused slots: inverted boxes.
    pub const VACANT: Self = Self([[f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY)]; 3]);

    /// Stores a box in slot `slot`, which is below 8.
    pub fn set_box(&mut self, slot: usize, min: Vec3, max: Vec3) {
        for (axis, [lower, upper]) in self.0.iter_mut().enumerate() {
            lower.as_mut_array()[slot] = min[axis];
            upper.as_mut_array()[slot] = max[axis];
        }
    }

    /// Lower and upper planes of the eight boxes along one axis.
    #[inline]
    pub fn planes(&self, axis: usize) -> [f32x8; 2] {
        self.0[axis]
    }

    /// Bit mask of the boxes that the ray enters at a ray parameter from 0 to `limit` (Ize 2013).
    ///
    /// Also returns the ray parameter at which the ray enters each box: 0 if the origin is inside.
    /// Ray parameters refer to the scaled direction of [`RayPrecalc`].
    #[inline]
    pub fn intersect_boxes(&self, slabs: &SlabTestRay, limit: f32) -> (u32, f32x8) {
        let at =
            |axis: usize, side: usize| (self.0[axis][side & 1] - slabs.origin[axis]) * slabs.reciprocal_direction[axis];
        let [nx, ny, nz] = slabs.near_sides;
        let near = at(0, nx).fast_max(at(1, ny)).fast_max(at(2, nz)).fast_max(f32x8::ZERO);
        let far = at(0, nx ^ 1).fast_min(at(1, ny ^ 1)).fast_min(at(2, nz ^ 1)).fast_min(f32x8::splat(limit));
        (near.simd_le(far * f32x8::splat(EXIT_FACTOR)).to_bitmask(), near)
    }
}

/// Binary tree and primitives from which the nodes with eight children are built.
struct WideNodeInput<'a> {
    triangles: &'a [[Vec3; 3]],
    primitives: &'a [BvhPrimitive],
    tree: &'a [BinaryNode],
}

impl WideNodeInput<'_> {
    /// Selects up to `slots` binary nodes that become the children of one node with eight children.
    ///
    /// The selected nodes are descendants of node `at`, whose first primitive has index `start`.
    /// `take` is called for each selected node, with the index of the node and the index of the
    /// node's first primitive.
    fn select_wide_node_children(
        &self,
        at: usize,
        start: usize,
        mut slots: usize,
        take: &mut impl FnMut((usize, usize)),
    ) {
        let branch = &self.tree[at];
        while slots > 1 && branch.left_slots[slots] == 0 {
            slots -= 1;
        }
        if slots == 1 {
            return take((at, start));
        }
        let (share, left) = (usize::from(branch.left_slots[slots]), branch.left_primitive_count as usize);
        self.select_wide_node_children(at + 1, start, share, take);
        self.select_wide_node_children(at + 2 * left, start + left, slots - share, take);
    }
}

/// True if the triangle has an area above zero, computed in f64.
fn has_area(corners: &[Vec3; 3]) -> bool {
    // In f64, these differences and products are exact, or their magnitudes differ so much that
    // they cannot cancel.
    let [a, b, c] = corners.map(|v| v.as_dvec3());
    (b - a).cross(c - a) != DVec3::ZERO
}

/// Returns the build primitive for a box and its code. The box is padded by [`RELATIVE_PADDING`] of
/// its longest edge.
fn padded_primitive((bounds, primitive_code): (Bounds, u32)) -> BvhPrimitive {
    let margin = Vec3::splat(bounds.extent().max_element() * RELATIVE_PADDING);
    let (min, max) = (bounds.min - margin, bounds.max + margin);
    let down = Vec3A::from(min.to_array().map(f32::next_down));
    let up = Vec3A::from(max.to_array().map(f32::next_up));
    BvhPrimitive { bounds: SimdBox { min: down, max: up }, primitive_code }
}
