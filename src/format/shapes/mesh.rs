//! The block `TriangleMesh` of the scene language: a mesh from a file.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::BlockCodec;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::mesh::MeshOptions;
use crate::format::resolve::Resolver;
use crate::format::resolve::meshes::add_mesh;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement};
use crate::format::span::Spanned;
use std::fmt;

/// A mesh in a file of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshDescription {
    /// Path of the mesh file, as the scene file states it: not empty, without line breaks.
    pub path: Spanned<String>,
    /// Options that select which materials and which normals the triangles get.
    pub options: MeshOptions,
}

impl BlockCodec for MeshDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let options = MeshOptions {
            uses_file_materials: f.field_word_or_default("materials")? == "file",
            ignores_normals: f.field_word_or_default("normals")? == "none",
            max_smoothing_angle: f.optional_value("smoothAngle"),
        };
        Ok(Self { path: f.value_or_default("obj_file")?, options })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        let ply = self.path.to_ascii_lowercase().ends_with(".ply");
        out.write_name_field(if ply { "file" } else { "obj_file" }, &self.path)?;
        if self.options.uses_file_materials {
            out.write_field("materials", "file")?;
        }
        if self.options.ignores_normals {
            out.write_field("normals", "none")?;
        }
        self.options.max_smoothing_angle.map_or(Ok(()), |angle| out.write_number("smoothAngle", angle))
    }
}

impl ShapeBlock for MeshDescription {
    const BLOCK: &'static BlockSchema = &block_schema("TriangleMesh", "triangle mesh in a file of its own")
        .with_own_fields(&[
            field_schema("obj_file", FieldKind::Name, "OBJ or PLY file")
                .with_alias("file")
                .make_required()
                .mark_as_mit_6837_syntax(),
            field_schema(
                "materials",
                FieldKind::Word(&["scene", "file"]),
                "materials of the scene or of the file's MTL files",
            )
            .with_default_word("scene"),
            field_schema("normals", FieldKind::Word(&["file", "none"]), "`none` ignores the file's normals")
                .with_default_word("file"),
            field_schema("smoothAngle", FieldKind::Number, "greatest angle between faces that are smoothed")
                .with_range(FieldRange::ClosedInterval(0.0, 180.0))
                .make_optional("faces without normals are flat")
                .with_unit("degrees"),
        ])
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_mit_6837_syntax();

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        add_mesh(r, placement, &self.path, self.options, emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        Some(&mut self.path.value)
    }
}
