//! The block `Triangle` of the scene language: a single triangle.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::BlockCodec;
use crate::format::language::field_value::FieldValue;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{
    NormalizedMesh, ObjectEmission, ObjectPlacement, add_instance, add_still_mesh, set_emission_texture,
    set_texcoords_if_needed, set_texture_mapping_if_needed,
};
use crate::shape::TextureMappingKind;
use glam::{DVec2, DVec3};
use std::fmt;

/// A triangle; its area may be 0.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleDescription {
    /// Corners of the triangle.
    pub vertices: [DVec3; 3],
    /// Shading normals at the corners, of any length; `None` means the triangle's geometric normal
    /// at all corners.
    pub normals: Option<[DVec3; 3]>,
    /// Texture coordinates at the corners; `None` means (0, 0), (1, 0) and (0, 1).
    pub texcoords: Option<Box<[DVec2; 3]>>,
}

impl BlockCodec for TriangleDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            vertices: [f.value_or_default("vertex0")?, f.value_or_default("vertex1")?, f.value_or_default("vertex2")?],
            normals: parse_three_optional_fields(f, ["normal0", "normal1", "normal2"])?,
            texcoords: parse_three_optional_fields(f, ["uv0", "uv1", "uv2"])?.map(Box::new),
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        for (i, vertex) in self.vertices.iter().enumerate() {
            out.write_vec3(&format!("vertex{i}"), *vertex)?;
        }
        for (i, normal) in self.normals.iter().flatten().enumerate() {
            out.write_vec3(&format!("normal{i}"), *normal)?;
        }
        for (i, uv) in self.texcoords.iter().flat_map(|uv| uv.iter()).enumerate() {
            out.write_vec2(&format!("uv{i}"), *uv)?;
        }
        Ok(())
    }
}

impl ShapeBlock for TriangleDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Triangle", "triangle; its area may be 0")
        .with_own_fields(&[
            field_schema("vertex0", FieldKind::Point, "first vertex").make_required().mark_as_mit_6837_syntax(),
            field_schema("vertex1", FieldKind::Point, "second vertex").make_required().mark_as_mit_6837_syntax(),
            field_schema("vertex2", FieldKind::Point, "third vertex").make_required().mark_as_mit_6837_syntax(),
            field_schema("normal0", FieldKind::Direction, "shading normal at the first vertex; give all three or none"),
            field_schema("normal1", FieldKind::Direction, "shading normal at the second vertex"),
            field_schema("normal2", FieldKind::Direction, "shading normal at the third vertex"),
            field_schema("uv0", FieldKind::Pair, "texture coordinates at the first vertex; give all three or none")
                .make_optional("0 0"),
            field_schema("uv1", FieldKind::Pair, "texture coordinates at the second vertex").make_optional("1 0"),
            field_schema("uv2", FieldKind::Pair, "texture coordinates at the third vertex").make_optional("0 1"),
        ])
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_mit_6837_syntax();

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let (vertices, to_world) = (&self.vertices, placement.to_world);
        let normals = self.normals.as_ref().map(|n| n.as_slice());
        let uv = self.texcoords.as_deref().copied().unwrap_or([DVec2::ZERO, DVec2::X, DVec2::Y]);
        if to_world.is_constant() {
            add_still_mesh(r, &placement.to_world_at_open, vertices, normals, &[[0, 1, 2]], emission.radiance);
            set_texcoords_if_needed(r, Some(&uv));
        } else {
            let mesh = NormalizedMesh::new(vertices, normals, Some(&uv), &[[0, 1, 2]]);
            add_instance(r, placement, &mesh, emission.radiance)?;
        }
        set_texture_mapping_if_needed(r, TextureMappingKind::Uv, to_world);
        set_emission_texture(r, emission);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

/// Returns the values of the three fields `names`; `None` if all three are absent.
///
/// # Errors
/// If only one or two of the fields are present.
fn parse_three_optional_fields<T: FieldValue>(
    f: &BlockFields<'_>,
    names: [&str; 3],
) -> Result<Option<[T; 3]>, SceneError> {
    if names.iter().all(|name| f.get(name).is_none()) {
        return Ok(None);
    }
    Ok(Some([f.value_or_default(names[0])?, f.value_or_default(names[1])?, f.value_or_default(names[2])?]))
}
