//! Morton order: a linear order of points that keeps close points together.

use super::Bounds;
use glam::Vec3;
use rayon::prelude::*;

/// Number of items whose bounding box one Rayon task computes.
const ITEMS_PER_TASK: usize = 4096;

/// Returns the indices of `items`, sorted by the Morton codes of their positions.
///
/// `position` returns an item's position, which must be finite. The grid of the codes covers the
/// bounding box of all positions, with about 2²⁰ cells along each axis. Items in one cell keep
/// their order. The result does not depend on the number of threads.
#[must_use]
pub fn morton_order<T: Sync>(items: &[T], position: impl Fn(&T) -> Vec3 + Sync) -> Vec<u32> {
    let bounds = items.par_chunks(ITEMS_PER_TASK).map(|items| Bounds::from_points(items.iter().map(&position)));
    let bounds = bounds.reduce(|| Bounds::EMPTY, Bounds::union);
    let scale = Vec3::splat(f32::from(u16::MAX) * 16.0) / bounds.extent().max(Vec3::splat(f32::MIN_POSITIVE));
    let key = |(i, item)| (morton_code((position(item) - bounds.min) * scale), i as u32);
    let mut keyed: Vec<(u64, u32)> = items.par_iter().enumerate().map(key).collect();
    keyed.par_sort_unstable();
    keyed.par_iter().map(|(_, i)| *i).collect()
}

/// Morton code of the cell coordinates `p`, rounded down.
///
/// It interleaves the lowest 21 bits of x, y and z.
#[inline]
fn morton_code(p: Vec3) -> u64 {
    let spread = |x: f32| {
        let mut v = (x as u64) & 0x1f_ffff;
        v = (v | v << 32) & 0x001f_0000_0000_ffff;
        v = (v | v << 16) & 0x001f_0000_ff00_00ff;
        v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
        v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
        (v | v << 2) & 0x1249_2492_4924_9249
    };
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}
