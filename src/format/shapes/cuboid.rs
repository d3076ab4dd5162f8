//! The block `Box`.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_solid};
use crate::shape::{Cuboid, Shape};
use glam::DVec3;
use std::fmt;

/// An axis-aligned box.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxDescription {
    /// Corner with the lowest coordinates.
    pub min: DVec3,
    /// Opposite corner, above `min` in every coordinate.
    pub max: DVec3,
}

static BOX: BlockSchema = block_schema("Box", "closed box with edges along the axes")
    .with_fields(&[
        field_schema("min", FieldKind::Point, "corner with the lowest coordinates").make_required(),
        field_schema("max", FieldKind::Point, "opposite corner; above `min` in every coordinate").make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

impl ShapeBlock for BoxDescription {
    const BLOCK: &'static BlockSchema = &BOX;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let (min, max): (DVec3, DVec3) = (f.value_or_default("min")?, f.value_or_default("max")?);
        f.require_field("max")?.ensure_valid(max.cmpgt(min).all(), "must be above `min` in every coordinate")?;
        Ok(Self { min, max })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_vec3("min", self.min)?;
        out.write_vec3("max", self.max)
    }

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        add_solid(r, placement, Cuboid::new(self.min, self.max).map(Shape::Cuboid), emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
