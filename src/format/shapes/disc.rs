//! The block `Disc` of the scene language: a flat disc.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::{Disc, Shape, TextureMappingKind};
use glam::DVec3;

/// A flat disc.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscDescription {
    /// Center of the disc.
    pub center: DVec3,
    /// Normal of the disc, of any length above 0.
    pub normal: DVec3,
    /// Radius of the disc, above 0.
    pub radius: f64,
}

field_table!(DiscDescription {
    center: field_schema("center", FieldKind::Point, "center").make_required(),
    normal: field_schema("normal", FieldKind::Direction, "normal").make_required(),
    radius: field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
});

impl ShapeBlock for DiscDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("Disc", "flat disc").with_table(Self::FIELDS).with_shared_fields(&[EMISSION_FIELDS]);

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let Self { center, normal, radius } = *self;
        let disc = Shape::Disc(Disc::circular_disc(center, normal, radius));
        add_shape_object(r, placement, disc, TextureMappingKind::disc_mapping(center, normal, radius), emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
