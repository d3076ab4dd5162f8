//! Connectivity of triangles. Vertices with equal positions are one vertex.

use super::TriangleMesh;
use rayon::prelude::*;

/// Half-edge: one side of a triangle, from one corner to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct HalfEdge {
    /// Position indices of both ends, the lower one first. Half-edges of one edge have the same
    /// pair.
    pub position_indices: [u32; 2],
    pub triangle: u32,
    /// Corner of the triangle, 0 to 2, at which the half-edge starts; it ends at the next corner.
    pub corner: u8,
    /// True if the half-edge starts at the lower position index.
    pub is_forward: bool,
}

impl HalfEdge {
    /// Returns the triangle corners at the two ends of the half-edge, in the order of
    /// `position_indices`.
    ///
    /// A corner is given by its index 3t + k, for corner k of triangle t.
    pub fn corners_in_position_order(&self) -> [usize; 2] {
        let base = 3 * self.triangle as usize;
        let (start, end) = (base + self.corner as usize, base + (self.corner as usize + 1) % 3);
        if self.is_forward { [start, end] } else { [end, start] }
    }
}

/// Distinct positions and edges of a mesh.
#[derive(Debug)]
pub(super) struct MeshTopology {
    /// Number of each vertex's position in the list of distinct positions, counted from 0. Vertices
    /// at equal positions have equal numbers.
    pub vertex_position_indices: Vec<u32>,
    /// Number of distinct positions.
    pub position_count: usize,
    /// Half-edges of all triangles with three different positions, sorted by edge.
    half_edges: Vec<HalfEdge>,
}

impl MeshTopology {
    pub fn new(mesh: &TriangleMesh) -> Self {
        let (vertex_positions, position_count) = mesh.distinct_position_indices();
        let mut half_edges = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| vertex_positions[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            for (corner, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                let positions = [from.min(to), from.max(to)];
                half_edges.push(HalfEdge {
                    position_indices: positions,
                    triangle: t as u32,
                    corner: corner as u8,
                    is_forward: from < to,
                });
            }
        }
        half_edges
            .par_sort_unstable_by_key(|half_edge| (half_edge.position_indices, half_edge.triangle, half_edge.corner));
        Self { vertex_position_indices: vertex_positions, position_count, half_edges }
    }

    /// Returns one slice per edge of the mesh, with all half-edges of this edge.
    pub fn half_edges_by_edge(&self) -> impl Iterator<Item = &[HalfEdge]> {
        self.half_edges.chunk_by(|a, b| a.position_indices == b.position_indices)
    }

    /// True if the corners of `triangle` have three different positions.
    pub fn has_distinct_positions(&self, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|v| self.vertex_position_indices[v as usize]);
        a != b && b != c && c != a
    }
}

/// Union-find of triangles or triangle corners (Tarjan 1975) that also tracks relative winding.
///
/// Each element stores a flag: whether its winding is opposite to the winding of its parent.
#[derive(Debug)]
pub(super) struct ParityUnionFind {
    parent: Vec<u32>,
    /// True for each element whose winding is opposite to the winding of its parent.
    flipped_to_parent: Vec<bool>,
}

impl ParityUnionFind {
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), flipped_to_parent: vec![false; n] }
    }

    /// Returns the root of the set that contains `i`, and whether the winding of `i` is opposite to
    /// that of the root.
    ///
    /// The root is the lowest element of the set.
    pub fn find_root(&mut self, i: usize) -> (usize, bool) {
        let (mut root, mut is_flipped) = (i, false);
        while self.parent[root] as usize != root {
            is_flipped ^= self.flipped_to_parent[root];
            root = self.parent[root] as usize;
        }
        let (mut at, mut left) = (i, is_flipped);
        while self.parent[at] as usize != root {
            let (next, own) = (self.parent[at] as usize, self.flipped_to_parent[at]);
            self.parent[at] = root as u32;
            self.flipped_to_parent[at] = left;
            left ^= own;
            at = next;
        }
        (root, is_flipped)
    }

    /// Joins the sets of `a` and `b`. `is_flipped` is true if the winding of `a` is flipped
    /// relative to `b`.
    ///
    /// Returns false if `a` and `b` are in one set already, and their relative winding in this set
    /// differs from `is_flipped`; else true.
    pub fn union_sets(&mut self, a: usize, b: usize, is_flipped: bool) -> bool {
        let ((a, a_is_flipped), (b, b_is_flipped)) = (self.find_root(a), self.find_root(b));
        let is_flipped = is_flipped ^ a_is_flipped ^ b_is_flipped;
        if a == b {
            return !is_flipped;
        }
        // The lowest element becomes the root, so roots do not depend on the order of joins.
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high] = low as u32;
        self.flipped_to_parent[high] = is_flipped;
        true
    }
}
