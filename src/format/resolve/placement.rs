//! Adds placed shapes and meshes to the scene, with their texture mapping and emission.

use super::Resolver;
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::Span;
use crate::math::{Motion, Transform};
use crate::shape::{Instance, MappingKind, Mesh, MeshWithBvh, Shape};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use std::sync::Arc;

/// Emission of an object.
pub(super) struct EmissionOverride {
    /// Radiance in W/(m² sr); the mean of a texture.
    pub radiance: Rgb,
    /// True if the radiance is set on the object, not on its material.
    pub of_object: bool,
    /// Texture of the radiance, and the factor of its values.
    pub texture: Option<(u32, Rgb)>,
}

/// Placement of an object.
pub(super) struct Placing<'p> {
    pub to_world: &'p Motion,
    /// Map to the world when the shutter opens.
    pub map: &'p Transform,
    pub span: Span,
    pub emission: &'p EmissionOverride,
}

/// A mesh scaled and moved to a box around the origin.
pub(super) struct Instanced {
    mesh: Arc<MeshWithBvh>,
    /// Map back to the original position and size.
    place: DAffine3,
}

impl Instanced {
    pub(super) fn new(
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
        let place = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(size)), translation: middle };
        let mesh = Mesh {
            positions: positions.iter().map(|p| ((*p - middle) / size).as_vec3()).collect(),
            normals: normals.unwrap_or_default().iter().map(|n| n.normalize_or_zero().as_vec3()).collect(),
            texcoords: texcoords.unwrap_or_default().iter().map(|t| t.as_vec2()).collect(),
            triangles: triangles.to_vec(),
        };
        Self { mesh: Arc::new(MeshWithBvh::new(mesh)), place }
    }
}

/// Sets the emission texture of the object that was added last, if it has one.
pub(super) fn set_emission_texture(r: &mut Resolver<'_>, emission_override: &EmissionOverride) {
    if let Some((texture, scale)) = emission_override.texture {
        r.builder.emission_texture(texture, scale);
    }
}

/// Adds a shape under the motion `to_world`, which equals `map` when the shutter opens.
pub(super) fn place(
    r: &mut Resolver<'_>,
    shape: Shape,
    to_world: &Motion,
    map: &Transform,
    span: Span,
    emission: Rgb,
) -> Result<(), SceneError> {
    let placed =
        shape.transformed(map).ok_or_else(|| r.refuse(span, "this shape is squeezed flat", "scale it less"))?;
    if to_world.is_constant() {
        r.builder.shape(placed, r.material, emission);
    } else {
        r.builder.moving_shape(shape, to_world.clone(), r.material, emission);
    }
    Ok(())
}

/// True if the material in force has a texture.
fn is_textured(r: &Resolver<'_>) -> bool {
    r.texture_needs.get(r.material as usize).is_some_and(|needs| needs.textured)
}

/// Sets the texture mapping of the object that was added last, if its material has textures.
pub(super) fn set_mapping(r: &mut Resolver<'_>, kind: MappingKind, to_world: &Motion) {
    if is_textured(r) {
        r.builder.mapping(kind, to_world);
    }
}

/// Sets the texture coordinates of the mesh that was added last, if its material has textures.
pub(super) fn set_texcoords(r: &mut Resolver<'_>, texcoords: Option<&[DVec2]>) {
    if let Some(texcoords) = texcoords.filter(|_| is_textured(r)) {
        r.builder.texcoords(texcoords);
    }
}

/// Adds a mesh that is shared or moves.
pub(super) fn place_instance(
    r: &mut Resolver<'_>,
    instanced: &Instanced,
    to_world: &Motion,
    map: &Transform,
    span: Span,
    emission: Rgb,
) -> Result<(), SceneError> {
    if emission != Rgb::ZERO {
        let even = |time| Transform::new(to_world.at_time(time)).is_ok_and(|map| map.uniform_scale().is_some());
        if ![0.0, 0.3, 0.7, 1.0].into_iter().all(even) {
            let help = "stretch it alike in all directions, or let a shape of another kind emit";
            return Err(r.refuse(span, "a moving mesh that is stretched unevenly cannot emit light", help));
        }
    }
    let own = r.transform(instanced.place, span)?;
    let shape = Shape::Instance(Instance::new(Arc::clone(&instanced.mesh), own));
    place(r, shape, to_world, map, span, emission)
}

/// Adds a still mesh of triangles.
pub(super) fn place_mesh(
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
    // A mirroring map reverses the winding; the outer side must stay outside.
    let turned = |[a, b, c]: [u32; 3]| if map.swaps_handedness() { [a, c, b] } else { [a, b, c] };
    let triangles: Vec<[u32; 3]> = triangles.iter().copied().map(turned).collect();
    r.builder.mesh(&positions, &normals, &triangles, r.material, emission);
}
