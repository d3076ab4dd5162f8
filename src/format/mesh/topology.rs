//! Connectivity of triangles by the positions of their corners.

use super::TriangleMesh;
use rayon::prelude::*;

/// Side of a triangle along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct HalfEdge {
    /// Position numbers of the edge, the lower one first.
    pub places: [u32; 2],
    pub triangle: u32,
    /// Corner at which the side starts; it ends at the next corner.
    pub corner: u8,
    /// True if the side starts at the lower position.
    pub forward: bool,
}

impl HalfEdge {
    /// Indices, among all corners of the mesh, of the corners at the lower and at the higher
    /// position.
    pub fn corner_indices(&self) -> [usize; 2] {
        let base = 3 * self.triangle as usize;
        let (start, end) = (base + self.corner as usize, base + (self.corner as usize + 1) % 3);
        if self.forward { [start, end] } else { [end, start] }
    }
}

/// Positions and edges of a mesh.
#[derive(Debug)]
pub(super) struct MeshTopology {
    /// Position number of each vertex.
    pub places: Vec<u32>,
    /// Number of positions.
    pub place_count: usize,
    /// Sides of the triangles with three positions, sorted by edge.
    sides: Vec<HalfEdge>,
}

impl MeshTopology {
    pub fn new(mesh: &TriangleMesh) -> Self {
        let (places, place_count) = mesh.position_indices();
        let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| places[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            for (corner, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                let places = [from.min(to), from.max(to)];
                sides.push(HalfEdge { places, triangle: t as u32, corner: corner as u8, forward: from < to });
            }
        }
        sides.par_sort_unstable_by_key(|side| (side.places, side.triangle, side.corner));
        Self { places, place_count, sides }
    }

    /// Sides of each edge.
    pub fn edges(&self) -> impl Iterator<Item = &[HalfEdge]> {
        self.sides.chunk_by(|a, b| a.places == b.places)
    }

    /// True if a triangle has three different positions.
    pub fn has_distinct_positions(&self, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|v| self.places[v as usize]);
        a != b && b != c && c != a
    }
}

/// Union–find structure that also tracks which elements are flipped relative to each other.
///
/// Source: Tarjan 1975, extended by a parity.
#[derive(Debug)]
pub(super) struct ParityUnionFind {
    parent: Vec<u32>,
    /// True if the element is flipped relative to its parent.
    turned: Vec<bool>,
}

impl ParityUnionFind {
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), turned: vec![false; n] }
    }

    /// Lowest element of the set of `i`, and whether `i` is flipped relative to it.
    pub fn find(&mut self, i: usize) -> (usize, bool) {
        let (mut root, mut turned) = (i, false);
        while self.parent[root] as usize != root {
            turned ^= self.turned[root];
            root = self.parent[root] as usize;
        }
        let (mut at, mut left) = (i, turned);
        while self.parent[at] as usize != root {
            let (next, own) = (self.parent[at] as usize, self.turned[at]);
            self.parent[at] = root as u32;
            self.turned[at] = left;
            left ^= own;
            at = next;
        }
        (root, turned)
    }

    /// Joins the sets of `a` and `b`, `turned` relative to each other; false if that contradicts
    /// earlier joins.
    pub fn join(&mut self, a: usize, b: usize, turned: bool) -> bool {
        let ((a, a_turned), (b, b_turned)) = (self.find(a), self.find(b));
        let turned = turned ^ a_turned ^ b_turned;
        if a == b {
            return !turned;
        }
        // The least becomes the root, so that roots do not depend on the order of joins.
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high] = low as u32;
        self.turned[high] = turned;
        true
    }
}
