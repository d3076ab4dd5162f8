//! Which blocks of a grid a ray passes.

use glam::DVec3;

/// The walk of a ray over unit blocks, from face to face (Amanatides and Woo 1987). Every step enters another block, so it ends.
pub(super) struct MajorantIterator {
    origin: DVec3,
    step: DVec3,
    count: [u32; 3],
    cell: [u32; 3],
    /// Where the ray meets the next face across each axis.
    next: [f64; 3],
    t: f64,
    end: f64,
}

impl MajorantIterator {
    /// The blocks that `origin + t·step` passes, 0 < t < `distance`, inside the box from 0 to `far`, of which `count` blocks
    /// cover each side.
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
        let mut blocks = Self { origin, step, count, cell, next: [0.0; 3], t, end };
        blocks.next = std::array::from_fn(|axis| blocks.face(axis));
        blocks
    }

    /// Where the ray leaves its block across `axis`.
    fn face(&self, axis: usize) -> f64 {
        let (o, s, cell) = (self.origin[axis], self.step[axis], f64::from(self.cell[axis]));
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
    /// Where the ray enters a block, where it leaves it, and the block's number, x running fastest.
    type Item = (f64, f64, usize);

    fn next(&mut self) -> Option<Self::Item> {
        while self.t < self.end {
            let [x, y, z] = self.next;
            let axis = if x <= y && x <= z {
                0
            } else if y <= z {
                1
            } else {
                2
            };
            let (start, stop) = (self.t, self.next[axis].min(self.end));
            let [cx, cy, cz] = self.cell.map(|c| c as usize);
            let index = (cz * self.count[1] as usize + cy) * self.count[0] as usize + cx;
            let forward = self.step[axis] > 0.0;
            let edge = if forward { self.count[axis] - 1 } else { 0 };
            if self.cell[axis] == edge {
                // What rounding left before the far side of the box belongs to the last block.
                self.t = self.end;
                return Some((start, self.end, index));
            }
            self.cell[axis] = if forward { self.cell[axis] + 1 } else { self.cell[axis] - 1 };
            self.next[axis] = self.face(axis);
            if stop > start {
                self.t = stop;
                return Some((start, stop, index));
            }
        }
        None
    }
}
