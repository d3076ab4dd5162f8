//! The block `Rectangle` of the scene language: a parallelogram.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, block_schema};
use crate::format::parallelogram::{CORNER, EDGE0, EDGE1};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::{Rectangle, Shape, TextureMappingKind};
use glam::DVec3;

/// A parallelogram with normal `edge0 × edge1`.
#[derive(Clone, Debug, PartialEq)]
pub struct RectangleDescription {
    /// The corner where both edges start.
    pub corner: DVec3,
    /// Edge vector from `corner` to one neighboring corner.
    pub edge0: DVec3,
    /// Edge vector from `corner` to the other neighboring corner.
    pub edge1: DVec3,
}

field_table!(RectangleDescription { corner: CORNER, edge0: EDGE0, edge1: EDGE1 });

impl ShapeBlock for RectangleDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Rectangle", "parallelogram with normal `edge0` × `edge1`")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[EMISSION_FIELDS]);

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
