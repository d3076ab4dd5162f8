//! The block `Disc`.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::{Disc, Shape, TextureMappingKind};
use glam::DVec3;
use std::fmt;

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

static DISC: BlockSchema = block_schema("Disc", "flat disc")
    .with_fields(&[
        field_schema("center", FieldKind::Point, "center").make_required(),
        field_schema("normal", FieldKind::Direction, "normal").make_required(),
        field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

impl ShapeBlock for DiscDescription {
    const BLOCK: &'static BlockSchema = &DISC;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            center: f.value_or_default("center")?,
            normal: f.value_or_default("normal")?,
            radius: f.value_or_default("radius")?,
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_vec3("center", self.center)?;
        out.write_vec3("normal", self.normal)?;
        out.write_number("radius", self.radius)
    }

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
