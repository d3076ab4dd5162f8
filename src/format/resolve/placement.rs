//! Adds shapes and meshes to the scene, with their transform to world space, texture mapping and
//! emission.

use super::Resolver;
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::span::Span;
use crate::math::{Motion, Transform};
use crate::shape::{Mesh, MeshInstance, MeshWithBvh, Shape, TextureMappingKind};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use std::sync::Arc;

/// Emission of an object, set on the object itself or on its material.
pub(in crate::format) struct ObjectEmission {
    /// Radiance in W/(m² sr); the mean radiance if a texture varies it.
    pub radiance: Rgb,
    /// True if the radiance is set on the object, not on its material.
    pub is_set_on_object: bool,
    /// Index of the texture that varies the emission, and the factor from texture values to
    /// radiance \[W/(m² sr)]; `None` for constant emission.
    pub texture: Option<(u32, Rgb)>,
}

/// Placement of an object: its motion and transform to world space, and its position in the scene
/// text.
pub(in crate::format) struct ObjectPlacement<'p> {
    /// Motion from object space to world space.
    pub to_world: &'p Motion,
    /// Transform from object space to world space at the time when the shutter opens.
    pub to_world_at_open: Transform,
    /// Span of the object, for errors.
    pub span: Span,
}

/// A mesh in normalized coordinates, with its BVH.
///
/// The center of its bounding box is the origin, and the longest side is in \[1, 2). Single
/// precision then suffices for its coordinates.
pub(in crate::format) struct NormalizedMesh {
    mesh: Arc<MeshWithBvh>,
    /// Map from normalized coordinates back to the coordinates of the original mesh.
    to_original: DAffine3,
}

impl NormalizedMesh {
    /// Normalizes the mesh of `positions` and `triangles`, and builds its BVH. If all positions
    /// coincide, the mesh is moved to the origin but not scaled.
    pub(in crate::format) fn new(
        positions: &[DVec3],
        normals: Option<&[DVec3]>,
        texcoords: Option<&[DVec2]>,
        triangles: &[[u32; 3]],
    ) -> Self {
        let fold = |f: fn(DVec3, DVec3) -> DVec3| positions.iter().copied().reduce(f).unwrap_or(DVec3::ZERO);
        let (min, max) = (fold(DVec3::min), fold(DVec3::max));
        let middle = 0.5 * min + 0.5 * max;
        let extent = (max - min).max_element();
        // Scaling by a power of two is exact.
        let size = if extent > 0.0 { libm::exp2(libm::log2(extent).floor()) } else { 1.0 };
        let to_original = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(size)), translation: middle };
        let mesh = Mesh {
            positions: positions.iter().map(|p| ((*p - middle) / size).as_vec3()).collect(),
            normals: normals.unwrap_or_default().iter().map(|n| n.normalize_or_zero().as_vec3()).collect(),
            texcoords: texcoords.unwrap_or_default().iter().map(|t| t.as_vec2()).collect(),
            triangles: triangles.to_vec(),
        };
        Self { mesh: Arc::new(MeshWithBvh::new(mesh)), to_original }
    }
}

/// Sets the emission texture of the object that was added last, if the emission has a texture.
pub(in crate::format) fn set_emission_texture(r: &mut Resolver<'_>, emission: &ObjectEmission) {
    if let Some((texture, scale)) = emission.texture {
        r.builder.set_last_emission_texture(texture, scale);
    }
}

/// Adds a shape with the current material of `r` and the emitted radiance `emission`. Sets no
/// texture mapping and no emission texture.
///
/// Fails if the transform at shutter opening squeezes the shape flat.
pub(in crate::format) fn add_placed_shape(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    shape: Shape,
    emission: Rgb,
) -> Result<(), SceneError> {
    let flat = || r.error_at(placement.span, "this shape is squeezed flat", "scale it less");
    let placed = shape.transformed(&placement.to_world_at_open).ok_or_else(flat)?;
    if placement.to_world.is_constant() {
        r.builder.add_shape(placed, r.current_material_index, emission);
    } else {
        r.builder.add_moving_shape(shape, placement.to_world.clone(), r.current_material_index, emission);
    }
    Ok(())
}

/// True if the material at `r.current_material_index` has a texture.
fn is_current_material_textured(r: &Resolver<'_>) -> bool {
    r.current_material().is_some_and(|material| material.texture_requirements.uses_textures)
}

/// Sets the texture mapping of the object that was added last, if its material has textures.
pub(in crate::format) fn set_texture_mapping_if_needed(
    r: &mut Resolver<'_>,
    kind: TextureMappingKind,
    to_world: &Motion,
) {
    if is_current_material_textured(r) {
        r.builder.set_last_texture_mapping(kind, to_world);
    }
}

/// Sets the texture coordinates of the mesh that was added last, if its material has textures.
pub(in crate::format) fn set_texcoords_if_needed(r: &mut Resolver<'_>, texcoords: Option<&[DVec2]>) {
    if let Some(texcoords) = texcoords.filter(|_| is_current_material_textured(r)) {
        r.builder.set_last_mesh_texcoords(texcoords);
    }
}

/// Adds an instance of a mesh. Instances are used for a mesh that moves, and for several meshes
/// that share triangles.
///
/// Fails if the mesh emits light and its transform to world space scales the axes unequally. This
/// is tested at four times of the shutter interval.
pub(in crate::format) fn add_instance(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    mesh: &NormalizedMesh,
    emission: Rgb,
) -> Result<(), SceneError> {
    let ObjectPlacement { to_world, span, .. } = *placement;
    if emission != Rgb::ZERO {
        let is_similarity =
            |time| Transform::new(to_world.at_time(time)).is_ok_and(|map| map.uniform_scale().is_some());
        if ![0.0, 0.3, 0.7, 1.0].into_iter().all(is_similarity) {
            let help = "stretch it alike in all directions, or let a shape of another kind emit";
            return Err(r.error_at(span, "a moving mesh that is stretched unevenly cannot emit light", help));
        }
    }
    let to_original = r.invertible_transform(mesh.to_original, span)?;
    let shape = Shape::Instance(MeshInstance::new(Arc::clone(&mesh.mesh), to_original));
    add_placed_shape(r, placement, shape, emission)
}

/// Adds the triangles of a mesh at rest, with the material at `r.current_material_index` and the
/// emitted radiance `emission`. `map` is the transform from object space to world space.
pub(in crate::format) fn add_still_mesh(
    r: &mut Resolver<'_>,
    map: &Transform,
    positions: &[DVec3],
    normals: Option<&[DVec3]>,
    triangles: &[[u32; 3]],
    emission: Rgb,
) {
    let positions: Vec<DVec3> = positions.iter().map(|p| map.transform_point(*p)).collect();
    let unit = |n: &DVec3| map.transform_normal(*n).normalize_or_zero().as_vec3();
    let normals: Vec<Vec3> = normals.unwrap_or_default().iter().map(unit).collect();
    // A mirroring map reverses the winding. Swapping two corners keeps the outer side outside.
    let orient = |[a, b, c]: [u32; 3]| if map.swaps_handedness() { [a, c, b] } else { [a, b, c] };
    let triangles: Vec<[u32; 3]> = triangles.iter().copied().map(orient).collect();
    r.builder.add_mesh(&positions, &normals, &triangles, r.current_material_index, emission);
}

/// Adds a shape with the material at `r.current_material_index`. Sets `mapping`, the texture
/// mapping of this kind of shape, and the emission, which a texture may vary.
pub(in crate::format) fn add_shape_object(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    shape: Shape,
    mapping: TextureMappingKind,
    emission: &ObjectEmission,
) -> Result<(), SceneError> {
    add_placed_shape(r, placement, shape, emission.radiance)?;
    set_texture_mapping_if_needed(r, mapping, placement.to_world);
    set_emission_texture(r, emission);
    Ok(())
}

/// Adds a box, cylinder or cone. Fails if `solid` is `None`, which means that the solid would have
/// no volume.
pub(in crate::format) fn add_solid(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    solid: Option<Shape>,
    emission: &ObjectEmission,
) -> Result<(), SceneError> {
    let no_extent = || r.error_at(placement.span, "this shape has no extent", "make it larger");
    add_shape_object(r, placement, solid.ok_or_else(no_extent)?, TextureMappingKind::Uv, emission)
}
