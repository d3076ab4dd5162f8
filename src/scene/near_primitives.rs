//! Intersection of many short rays in a small part of a scene.

use super::Scene;
use super::geometry::{Geometry, Hit};
use crate::accel::LeafList;
use crate::math::{Bounds, Ray};
use glam::Vec3;

/// The primitives of a scene that may meet a box, for many rays that stay in this box.
///
/// The bounding volume hierarchies are searched once for all rays. Hits are equal to those of
/// [`Scene::intersect`] bit for bit.
pub struct NearPrimitives<'a> {
    geometry: &'a Geometry,
    /// Leaves (small groups of primitives) whose bounding boxes overlap the given box, from the
    /// bounding volume hierarchy over triangles and shapes at rest. `None` if there are too many
    /// for a list; rays then search the whole hierarchies.
    resting: Option<LeafList>,
    /// Leaves (small groups of primitives) whose bounding boxes overlap the given box, from the
    /// hierarchy over moving shapes. `None` if there are too many for a list, or if the scene has
    /// no moving shapes.
    moving: Option<LeafList>,
}

impl<'a> NearPrimitives<'a> {
    /// Finds the primitives of `scene` that may meet the box `bounds`.
    #[must_use]
    pub fn new(scene: &'a Scene, bounds: &Bounds) -> Self {
        let geometry = &scene.geometry;
        let moving = geometry.moving_hierarchy.as_ref().and_then(|moving| moving.leaves_overlapping_bounds(bounds));
        Self { geometry, resting: geometry.resting_hierarchy.leaves_overlapping_bounds(bounds), moving }
    }

    /// True if only one primitive may meet the box, and this primitive is a flat shape at rest that
    /// contains the whole disc of `radius` \[length] around `center` with the unit `normal`.
    ///
    /// The disc must lie within `tolerance` \[length] of the shape's plane, and at least
    /// `tolerance` inside its edges. The result is also false if too many primitives may meet the
    /// box.
    #[inline]
    #[must_use]
    pub fn only_shape_contains_disc(&self, center: Vec3, normal: Vec3, radius: f32, tolerance: f32) -> bool {
        let Self { geometry, resting: Some(resting), moving } = self else { return false };
        let nothing_moves = geometry.moving_hierarchy.is_none() || moving.as_ref().is_some_and(LeafList::is_empty);
        nothing_moves
            && geometry.planes.is_empty()
            && resting
                .single_other_primitive()
                .is_some_and(|i| geometry.shapes.resting()[i as usize].contains_disc(center, normal, radius, tolerance))
    }

    /// The nearest intersection of `ray`, for 0 < t < `ray.t_max`; `None` if the ray hits nothing.
    ///
    /// The ray must stay in the box `bounds` of [`NearPrimitives::new`].
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let Self { geometry, resting: Some(leaves), moving } = self else { return self.geometry.intersect(ray) };
        let (resting, in_motion) = (geometry.shapes.resting(), geometry.shapes.moving());
        let bounded =
            geometry.resting_hierarchy.closest_hit_in_leaves(leaves, ray, |i, ray| resting[i as usize].intersect(ray));
        let mut hit = bounded.map(Hit::from_resting_primitive);
        if let Some(hierarchy) = &geometry.moving_hierarchy {
            let (within, test) = (Hit::limit_ray(hit, ray), |i: u32, ray: &Ray| in_motion[i as usize].intersect(ray));
            let nearer = match moving {
                Some(leaves) => hierarchy.closest_hit_in_leaves(leaves, &within, test),
                None => hierarchy.closest_hit(&within, test),
            };
            hit = nearer.map(|h| Hit::from_moving_primitive(h, geometry.shapes.first_moving_index())).or(hit);
        }
        geometry.nearest_plane_hit(&Hit::limit_ray(hit, ray)).or(hit)
    }
}
