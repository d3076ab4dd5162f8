//! The block `Sphere`.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::{Shape, Sphere, TextureMappingKind};
use glam::DVec3;
use std::fmt;

/// A sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereDescription {
    /// Center of the sphere.
    pub center: DVec3,
    /// Radius of the sphere, above 0.
    pub radius: f64,
}

static SPHERE: BlockSchema = block_schema("Sphere", "all points at distance `radius` from `center`")
    .with_fields(&[
        field_schema("center", FieldKind::Point, "center").make_required().mark_as_mit_6837_syntax(),
        field_schema("radius", FieldKind::Number, "radius")
            .with_range(FieldRange::Positive)
            .make_required()
            .mark_as_mit_6837_syntax(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS])
    .mark_as_mit_6837_syntax();

impl ShapeBlock for SphereDescription {
    const BLOCK: &'static BlockSchema = &SPHERE;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        Ok(Self { center: f.value_or_default("center")?, radius: f.value_or_default("radius")? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_vec3("center", self.center)?;
        out.write_number("radius", self.radius)
    }

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let sphere = Shape::Sphere(Sphere::new(self.center, self.radius));
        add_shape_object(r, placement, sphere, TextureMappingKind::Spherical { center: self.center }, emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
