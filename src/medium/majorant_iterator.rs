//! Traversal of a majorant grid by a ray.

use glam::DVec3;

/// Iterator over the blocks of a majorant grid along a ray, by 3D-DDA (Amanatides and Woo 1987). A
/// block is a unit cube in the frame of the iterator.
///
/// Every step enters another block, so the iterator ends.
pub(super) struct MajorantIterator {
    origin: DVec3,
    /// Change of the position, in units of blocks, per unit of distance along the ray.
    direction: DVec3,
    /// Number of blocks along each axis.
    block_counts: [u32; 3],
    /// Current block: its index along each axis.
    block: [u32; 3],
    /// Distance along the ray to the next block face perpendicular to each axis; infinite for an
    /// axis perpendicular to the ray.
    next_face_t: [f64; 3],
    /// Distance along the ray where the ray enters the current block.
    t: f64,
    /// Distance along the ray where the iteration ends: the ray leaves the grid, or reaches its own
    /// end.
    end: f64,
}

impl MajorantIterator {
    /// Creates an iterator over the blocks along the ray `origin` + t·`step` for 0 < t <
    /// `distance`.
    ///
    /// `step` is the change of position, in blocks, per unit of t. The grid is the box from 0 to
    /// `far` \[blocks]. `count` is the number of blocks along each axis.
    pub(super) fn new(origin: DVec3, step: DVec3, far: DVec3, count: [u32; 3], distance: f64) -> Self {
        let (mut t, mut end) = (0.0, distance);
        for axis in 0..3 {
            let (o, s) = (origin[axis], step[axis]);
            if s == 0.0 {
                if !(o >= 0.0 && o <= far[axis]) {
                    end = t;
                }
            } else {
                let (a, b) = (-o / s, (far[axis] - o) / s);
                t = f64::max(t, a.min(b));
                end = f64::min(end, a.max(b));
            }
        }
        let start = origin + step * t;
        let cell = std::array::from_fn(|axis| (start[axis].max(0.0) as u32).min(count[axis] - 1));
        let mut blocks =
            Self { origin, direction: step, block_counts: count, block: cell, next_face_t: [0.0; 3], t, end };
        blocks.next_face_t = std::array::from_fn(|axis| blocks.distance_to_block_face(axis));
        blocks
    }

    /// Distance along the ray to the face, perpendicular to `axis`, through which the ray would
    /// leave the current block; infinite if the ray is parallel to the face.
    fn distance_to_block_face(&self, axis: usize) -> f64 {
        let (o, s, cell) = (self.origin[axis], self.direction[axis], f64::from(self.block[axis]));
        if s > 0.0 {
            (cell + 1.0 - o) / s
        } else if s < 0.0 {
            (cell - o) / s
        } else {
            f64::INFINITY
        }
    }
}

impl Iterator for MajorantIterator {
    /// Distance where the ray enters a block, distance where it leaves the block, and the block's
    /// index (x fastest).
    type Item = (f64, f64, usize);

    fn next(&mut self) -> Option<Self::Item> {
        while self.t < self.end {
            let [x, y, z] = self.next_face_t;
            let axis = if x <= y && x <= z {
                0
            } else if y <= z {
                1
            } else {
                2
            };
            let (start, stop) = (self.t, self.next_face_t[axis].min(self.end));
            let [cx, cy, cz] = self.block.map(|c| c as usize);
            let index = (cz * self.block_counts[1] as usize + cy) * self.block_counts[0] as usize + cx;
            let forward = self.direction[axis] > 0.0;
            let edge = if forward { self.block_counts[axis] - 1 } else { 0 };
            if self.block[axis] == edge {
                // Rounding may place the last block face before the end of the ray. The last block
                // ends where the ray leaves the grid.
                self.t = self.end;
                return Some((start, self.end, index));
            }
            self.block[axis] = if forward { self.block[axis] + 1 } else { self.block[axis] - 1 };
            self.next_face_t[axis] = self.distance_to_block_face(axis);
            if stop > start {
                self.t = stop;
                return Some((start, stop, index));
            }
        }
        None
    }
}
