//! Intervals of a surface of revolution's profile in which it may touch a coaxial surface of
//! revolution.

use super::super::polynomial::{MAX_DEGREE, reparametrize};
use super::super::ring_bvh::RingBounds;
use super::{Revolution, RevolutionProfile};
use glam::{DMat3, DVec3};

/// Number of equal intervals of the profile parameter, for which
/// [`Revolution::near_profile_interval_flags`] returns flags.
const PROFILE_INTERVALS: usize = 1024;

/// Largest relative deviation from a coaxial map that counts as a rounding error. A coaxial map
/// maps the axis of revolution to itself, and circles around the axis to such circles.
///
/// Offsets of the axis are relative to the size of the surface, matrix entries to the largest
/// entry, and deviations from circles to the squared radius.
const COAXIAL_TOLERANCE: f64 = 1e-9;

/// Limit of the condition number of a surface's map to world space. Above this limit, surfaces
/// never count as coaxial.
///
/// The condition number uses the Frobenius norm, so it is 3 for a rotation. Up to this limit,
/// [`COAXIAL_TOLERANCE`] is far below the distance within which surfaces may touch.
const MAX_CONDITION_NUMBER: f64 = 10.0;

/// Map from the radii and heights of one surface of revolution to those of a coaxial one.
struct CoaxialMap {
    radius_factor: f64,
    height_factor: f64,
    height_offset: f64,
}

impl CoaxialMap {
    /// Map of radii and heights from the object space of `from` to the object space of `to`.
    ///
    /// `None` if their axes differ, or if circles around the axis of one are ellipses in the other.
    /// Also `None` if the condition number of a map to world space exceeds
    /// [`MAX_CONDITION_NUMBER`].
    fn new(from: &Revolution, to: &Revolution) -> Option<Self> {
        let is_even = |surface: &Revolution| {
            let (forward, inverse) = (surface.to_world.forward().matrix3, surface.to_world.inverse().matrix3);
            frobenius_norm(forward) * frobenius_norm(inverse) <= MAX_CONDITION_NUMBER
        };
        if !(is_even(from) && is_even(to)) {
            return None;
        }
        let map = *to.to_world.inverse() * *from.to_world.forward();
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = map.matrix3;
        let largest = x.abs().max(y.abs()).max(z.abs()).max_element();
        let is_zero = |value: f64, size: f64| value.abs() <= COAXIAL_TOLERANCE * size;
        let keeps_axis = [x.y, z.y, y.x, y.z].into_iter().all(|value| is_zero(value, largest));
        let across = x.length_squared();
        let keeps_circles = is_zero(x.dot(z), across) && is_zero(across - z.length_squared(), across);
        let DVec3 { x: aside, y: height_offset, z: behind } = map.translation;
        let same_line = is_zero(aside, to.profile.bounding_radius) && is_zero(behind, to.profile.bounding_radius);
        (keeps_axis && keeps_circles && same_line).then(|| Self {
            radius_factor: x.length(),
            height_factor: y.y,
            height_offset,
        })
    }

    fn map_ring(&self, ring: RingBounds) -> RingBounds {
        let [a, b] = ring.height.map(|y| y * self.height_factor + self.height_offset);
        RingBounds { radius: ring.radius.map(|r| r * self.radius_factor), height: [a.min(b), a.max(b)] }
    }
}

impl Revolution {
    /// True if both surfaces surely have a common axis. Circles around this axis must also be
    /// circles in the object spaces of both surfaces.
    pub(crate) fn shares_axis(&self, other: &Self) -> bool {
        CoaxialMap::new(other, self).is_some()
    }

    /// Number of leaves of the profile, the nearly straight pieces into which it is divided.
    pub(crate) fn profile_leaf_count(&self) -> usize {
        self.profile.leaves.len()
    }

    /// Index of the interval that holds the profile parameter `u`, in the result of
    /// [`Revolution::near_profile_interval_flags`].
    #[inline]
    pub(crate) fn profile_interval_index(u: f32) -> usize {
        ((u * PROFILE_INTERVALS as f32) as usize).min(PROFILE_INTERVALS - 1)
    }

    /// Divides the profile parameter into `PROFILE_INTERVALS` equal intervals, and returns a flag
    /// for each. False means that this part of the surface is farther than `margin` \[world length]
    /// from `other`.
    ///
    /// All flags are true unless [`Revolution::shares_axis`].
    pub(crate) fn near_profile_interval_flags(&self, other: &Self, margin: f64) -> Vec<bool> {
        let Some(map) = CoaxialMap::new(other, self) else { return vec![true; PROFILE_INTERVALS] };
        let reach = margin * frobenius_norm(self.to_world.inverse().matrix3) + self.profile.point_error_bound;
        let other_error = other.profile.point_error_bound;
        let in_own_space = |ring: RingBounds| map.map_ring(ring.expanded(other_error)).expanded(reach);
        let other_leaves: Vec<RingBounds> = other.profile.leaves.iter().map(|leaf| in_own_space(leaf.ring)).collect();
        let mut is_near = vec![false; PROFILE_INTERVALS];
        for (leaf, own) in self.profile.leaves.iter().enumerate() {
            let near_leaves = (0..other_leaves.len()).filter(|i| other_leaves[*i].overlaps(&own.ring));
            let pieces = near_leaves.flat_map(|i| other.profile.pieces_of_leaf(i));
            let pieces: Vec<RingBounds> = pieces.map(|(_, ring)| in_own_space(ring)).collect();
            for (interval, ring) in self.profile.pieces_of_leaf(leaf) {
                is_near[interval] |= pieces.iter().any(|piece| piece.overlaps(&ring));
            }
        }
        // A rounded parameter may lie in the interval beside its own.
        let with_neighbours = |i: usize| is_near[i.saturating_sub(1)..(i + 2).min(PROFILE_INTERVALS)].contains(&true);
        (0..PROFILE_INTERVALS).map(with_neighbours).collect()
    }
}

/// Frobenius norm: the root of the sum of the squares of all entries.
///
/// The norm is an upper bound on the factor by which the matrix scales lengths.
fn frobenius_norm(matrix: DMat3) -> f64 {
    matrix.to_cols_array().iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}

impl RevolutionProfile {
    /// Divides a leaf, a nearly straight piece of the profile, at the limits of the
    /// [`PROFILE_INTERVALS`] intervals of the profile parameter.
    ///
    /// For each piece, returns the index of its interval, and a ring around the axis that contains
    /// the piece.
    fn pieces_of_leaf(&self, leaf: usize) -> impl Iterator<Item = (usize, RingBounds)> + '_ {
        let (middle, half) = (self.leaves[leaf].parameter_center, self.leaves[leaf].parameter_half_width);
        let coefficients = self.leaf_polynomial_coefficients(leaf);
        let count = PROFILE_INTERVALS as f64;
        let interval = |parameter: f64| ((parameter * count) as usize).min(PROFILE_INTERVALS - 1);
        (interval(middle - half)..=interval(middle + half)).map(move |index| {
            let [start, end] = [index, index + 1].map(|i| ((i as f64 / count - middle) / half).clamp(-1.0, 1.0));
            let mut own = [[0.0; 2]; MAX_DEGREE + 1];
            let own = &mut own[..coefficients.len()];
            own.copy_from_slice(coefficients);
            reparametrize(own, 0.5 * (start + end), 0.5 * (end - start));
            let range = |axis: usize| {
                let reach: f64 = own[1..].iter().map(|c| c[axis].abs()).sum();
                [own[0][axis] - reach, own[0][axis] + reach]
            };
            (index, RingBounds { radius: range(0), height: range(1) })
        })
    }
}

#[cfg(test)]
mod tests;
