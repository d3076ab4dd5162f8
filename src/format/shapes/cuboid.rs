//! The block `Box` of the scene language: an axis-aligned box.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldWithCheck, field_table};
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_solid};
use crate::shape::{Cuboid, Shape};
use glam::DVec3;

/// An axis-aligned box.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxDescription {
    /// Corner with the lowest coordinates.
    pub min: DVec3,
    /// Opposite corner, above `min` in every coordinate.
    pub max: DVec3,
}

field_table!(BoxDescription {
    min: field_schema("min", FieldKind::Point, "corner with the lowest coordinates").make_required(),
    max: FieldWithCheck::new(
        field_schema("max", FieldKind::Point, "opposite corner; above `min` in every coordinate").make_required(),
        check_corners,
    ),
});

impl ShapeBlock for BoxDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Box", "closed box with edges along the axes")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[EMISSION_FIELDS]);

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

/// Fails unless the corner `max` is above the corner `min` in every coordinate.
fn check_corners(f: &BlockFields<'_>, max: &ParsedField<'_, '_>) -> Result<(), SceneError> {
    let is_above = max.value::<DVec3>().cmpgt(f.value_or_default("min")?).all();
    max.ensure_valid(is_above, "must be above `min` in every coordinate")
}
