//! How triangles hang together: by the places of their corners, whatever normals and texture
//! coordinates these have.

use super::TriangleMesh;
use rayon::prelude::*;

/// One triangle's side of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    /// The numbers of the edge's places, the lower one first.
    pub places: [u32; 2],
    pub triangle: u32,
    /// The corner where the side starts; it ends at the next.
    pub corner: u8,
    /// Whether it starts at the lower place.
    pub forward: bool,
}

impl Side {
    /// The numbers of its corners, among all of the mesh, at the lower and the higher place.
    pub fn corners(&self) -> [usize; 2] {
        let base = 3 * self.triangle as usize;
        let (start, end) = (base + self.corner as usize, base + (self.corner as usize + 1) % 3);
        if self.forward { [start, end] } else { [end, start] }
    }
}

/// Places and edges of a mesh.
#[derive(Debug)]
pub(super) struct Topology {
    /// The number of each vertex's place.
    pub places: Vec<u32>,
    /// How many places there are.
    pub place_count: usize,
    /// Sides of triangles that have three places, sorted by edge.
    sides: Vec<Side>,
}

impl Topology {
    pub fn new(mesh: &TriangleMesh) -> Self {
        let (places, place_count) = mesh.places();
        let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| places[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            for (corner, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                let places = [from.min(to), from.max(to)];
                sides.push(Side { places, triangle: t as u32, corner: corner as u8, forward: from < to });
            }
        }
        sides.par_sort_unstable_by_key(|side| (side.places, side.triangle, side.corner));
        Self { places, place_count, sides }
    }

    /// The sides of each edge.
    pub fn edges(&self) -> impl Iterator<Item = &[Side]> {
        self.sides.chunk_by(|a, b| a.places == b.places)
    }

    /// Whether a triangle has three places.
    pub fn is_whole(&self, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|v| self.places[v as usize]);
        a != b && b != c && c != a
    }
}

/// Which of many things belong together, and which of these are turned against each other (Tarjan
/// 1975, with a parity).
#[derive(Debug)]
pub(super) struct Union {
    parent: Vec<u32>,
    /// Whether it is turned against its parent.
    turned: Vec<bool>,
}

impl Union {
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), turned: vec![false; n] }
    }

    /// The least one of those that it belongs to, and whether it is turned against that.
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

    /// Joins two, turned against each other or not; false where they are joined the other way round
    /// already.
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
