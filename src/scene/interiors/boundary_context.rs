//! Random choices and texture lookups at a boundary that a path meets.

use crate::sampling::{Dimension, Key};
use crate::scene::geometry::CoincidenceGroup;
use crate::scene::{Hit, RayCone, Scene};
use crate::shape::SurfacePoint;
use glam::Vec3;

/// Data that determine the random choice of a mix component, and the lookup of textures, where a
/// path meets a boundary.
#[derive(Clone, Copy, Debug)]
pub struct BoundaryContext {
    /// Random key of the path segment that meets the boundary: the key of the vertex at which the
    /// segment ends.
    pub key: Key,
    /// Number of boundaries that the path has crossed since its last vertex. Mixes at different
    /// boundaries use it to choose their components independently.
    pub crossed_boundary_count: u32,
    /// The ray cone over which textures are filtered, at the boundary.
    pub cone: RayCone,
}

impl BoundaryContext {
    /// Returns the index of the material at `hit`. A mix is resolved at random to a leaf material:
    /// a component that is not a mix itself.
    ///
    /// `point` is the surface point of the hit, and `group` its coincidence group. `wo` is the
    /// direction from which the path arrives. All faces of one group make the same choice, because
    /// a path through a common edge can hit two faces of one object. Choices for different groups
    /// are independent of each other, and of the choice at the boundary that the path's ray hit.
    pub(super) fn leaf_material_at(
        &self,
        scene: &Scene,
        hit: &Hit,
        (point, wo): (&SurfacePoint, Vec3),
        group: CoincidenceGroup,
    ) -> u32 {
        let material = scene.geometry.object_attributes(hit.primitive).material;
        if scene.materials[material as usize].mix_component_indices().is_none() {
            return material;
        }
        let key = self.key.coincident_face_key(self.crossed_boundary_count, group.index());
        let context = || scene.texture_context(hit, point, wo, &self.cone);
        let u = key.uniform_1d(Dimension::Mix);
        scene.resolve_mix_to_leaf(material, u, self.cone.effects, &context).0
    }
}
