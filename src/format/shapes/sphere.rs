//! The block `Sphere` of the scene language: a sphere.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_shape_object};
use crate::shape::{Shape, Sphere, TextureMappingKind};
use glam::DVec3;

/// A sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereDescription {
    /// Center of the sphere.
    pub center: DVec3,
    /// Radius of the sphere, above 0.
    pub radius: f64,
}

field_table!(SphereDescription {
    center: field_schema("center", FieldKind::Point, "center").make_required().mark_as_mit_6837_syntax(),
    radius: field_schema("radius", FieldKind::Number, "radius")
        .with_range(FieldRange::Positive)
        .make_required()
        .mark_as_mit_6837_syntax(),
});

impl ShapeBlock for SphereDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Sphere", "all points at distance `radius` from `center`")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_mit_6837_syntax();

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
