//! Removal of objects that bound bodies of air, which have no effect on light.

use super::object::{BoundsF64, MergedMeshes, ObjectGeometry, SceneObject};
use crate::scene::Material;

/// Removes objects that only bound air: a [`Body`](crate::scene::Body) of refractive index 1,
/// without absorption and without a medium.
///
/// Such a body changes light only where it overlaps another body or the ambient medium. In a scene
/// with an ambient medium, all objects are therefore kept. An object is also kept if it moves, if
/// it emits light, or if its box overlaps the box of a body other than air.
pub(super) fn cull_air_boundaries(
    mut objects: Vec<SceneObject>,
    mut mesh: MergedMeshes,
    materials: &[Material],
    has_ambient_medium: bool,
) -> (Vec<SceneObject>, MergedMeshes) {
    let is_air = |material: u32| materials[material as usize].enclosed_body().is_some_and(|body| body.is_air());
    if has_ambient_medium || !(0..materials.len() as u32).any(is_air) {
        return (objects, mesh);
    }
    let visible_bodies = objects.iter().filter(|object| may_bound_visible_body(materials, object.material));
    let visible_body_bounds: Vec<Option<BoundsF64>> =
        visible_bodies.map(|object| object.resting_bounds(&mesh)).collect();
    let is_culled = |object: &SceneObject| {
        let extent = object.resting_bounds(&mesh);
        let overlaps = |other: &Option<BoundsF64>| match (extent, other) {
            (Some((min, max)), Some((lo, hi))) => min.cmple(*hi).all() && lo.cmple(max).all(),
            // Planes and moving objects have no box here, so they count as overlapping.
            _ => true,
        };
        object.motion.is_none()
            && is_air(object.material)
            && !object.emits()
            && !visible_body_bounds.iter().any(overlaps)
    };
    let culled: Vec<bool> = objects.iter().map(is_culled).collect();
    let mut triangles = Vec::new();
    for (object, culled) in objects.iter_mut().zip(&culled) {
        if let (ObjectGeometry::Mesh(range), false) = (&mut object.geometry, culled) {
            let first = triangles.len() as u32;
            triangles.extend_from_slice(&mesh.triangles[range.start as usize..range.end as usize]);
            *range = first..triangles.len() as u32;
        }
    }
    mesh.triangles = triangles;
    let mut culled = culled.into_iter();
    objects.retain(|_| culled.next() != Some(true));
    (objects, mesh)
}

/// True if `material` bounds a dielectric body other than air. A mix counts if any component bounds
/// a dielectric body, even one of air.
fn may_bound_visible_body(materials: &[Material], material: u32) -> bool {
    let material = &materials[material as usize];
    match material.mix_component_indices() {
        Some(parts) => parts.into_iter().any(|part| may_bound_body(materials, part)),
        None => material.enclosed_body().is_some_and(|body| !body.is_air()),
    }
}

/// True if `material` bounds a dielectric body. For a mix: true if any component does.
pub(super) fn may_bound_body(materials: &[Material], material: u32) -> bool {
    let material = &materials[material as usize];
    match material.mix_component_indices() {
        Some(parts) => parts.into_iter().any(|part| may_bound_body(materials, part)),
        None => material.enclosed_body().is_some(),
    }
}
