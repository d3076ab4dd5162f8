//! Every box along a ray.

use super::probe::Probe;
use super::wide::{OTHER, Wide};
use crate::math::{Bounds, Ray};

/// A tree of boxes that finds all that a ray passes through.
///
/// No box is ever lost: all are padded by the errors of the test. So a few more may be found, by 10⁻⁶ of their size.
/// Coordinates must be below 10¹⁸ in magnitude.
pub struct Boxes {
    wide: Wide,
}

impl Boxes {
    /// Builds over at most 2³⁰ boxes. The tree does not depend on the number of threads. An empty box is never found.
    #[must_use]
    pub fn build(boxes: &[Bounds]) -> Self {
        Self { wide: Wide::build(&[], boxes) }
    }

    /// Shows `visit` the index of each box that the ray passes at `0 ≤ t ≤ t_max`, once, in an order that depends on the
    /// boxes and on the signs of the ray's direction only. Allocates nothing.
    #[inline]
    pub fn along(&self, ray: &Ray, visit: &mut impl FnMut(u32)) {
        if Probe::fits(ray) && ray.t_max >= 0.0 {
            self.wide.walk::<false, _>(&Probe::new(ray), |leaf, limit| {
                visit(leaf ^ OTHER);
                limit
            });
        }
    }
}
