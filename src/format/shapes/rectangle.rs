//! The block `Rectangle`.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::parallelogram::{parse_parallelogram, write_parallelogram};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::{Rectangle, Shape, TextureMappingKind};
use glam::DVec3;
use std::fmt;

/// A parallelogram with normal `edge0 × edge1`.
#[derive(Clone, Debug, PartialEq)]
pub struct RectangleDescription {
    /// The corner where both edges start.
    pub corner: DVec3,
    /// Edge vector from the corner to one neighbor.
    pub edge0: DVec3,
    /// Edge vector from the corner to the other neighbor.
    pub edge1: DVec3,
}

static RECTANGLE: BlockSchema = block_schema("Rectangle", "parallelogram with normal `edge0` × `edge1`")
    .with_fields(&[
        field_schema("corner", FieldKind::Point, "corner where both edges start").make_required(),
        field_schema("edge0", FieldKind::Direction, "vector to the first neighbouring corner").make_required(),
        field_schema("edge1", FieldKind::Direction, "vector to the other neighbouring corner").make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

impl ShapeBlock for RectangleDescription {
    const BLOCK: &'static BlockSchema = &RECTANGLE;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let (corner, edge0, edge1) = parse_parallelogram(f)?;
        Ok(Self { corner, edge0, edge1 })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        write_parallelogram(out, self.corner, self.edge0, self.edge1)
    }

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let Self { corner, edge0, edge1 } = *self;
        let rectangle = Shape::Rectangle(Rectangle::new(corner, edge0, edge1));
        add_shape_object(r, placement, rectangle, TextureMappingKind::rectangle_mapping(corner, edge0, edge1), emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
