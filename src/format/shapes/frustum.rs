//! The blocks `Cylinder` and `Cone`.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, FieldSchema, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_solid};
use crate::shape::{Frustum, Shape};
use glam::DVec3;
use std::fmt;

/// A cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct CylinderDescription {
    /// Centers of both ends, which differ.
    pub ends: [DVec3; 2],
    /// Radius of the cylinder, above 0.
    pub radius: f64,
    /// True if discs close both ends.
    pub is_capped: bool,
}

/// A cone or truncated cone.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeDescription {
    /// Centers of both ends, which differ.
    pub ends: [DVec3; 2],
    /// Radii of both ends: the first above 0, the second at least 0.
    pub radii: [f64; 2],
    /// True if discs close both ends.
    pub is_capped: bool,
}

const CAPS_FIELDS: &[FieldSchema] =
    &[field_schema("caps", FieldKind::Word(&["yes", "no"]), "`no` leaves both ends open").with_default_word("yes")];

static CYLINDER: BlockSchema = block_schema("Cylinder", "cylinder of any direction, closed unless `caps` is `no`")
    .with_fields(&[
        field_schema("bottom", FieldKind::Point, "center of one end").make_required(),
        field_schema("top", FieldKind::Point, "center of the other end").make_required(),
        field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    ])
    .with_shared_fields(&[CAPS_FIELDS, EMISSION_FIELDS]);

static CONE: BlockSchema =
    block_schema("Cone", "cone or truncated cone of any direction, closed unless `caps` is `no`")
        .with_fields(&[
            field_schema("bottom", FieldKind::Point, "center of the base").make_required(),
            field_schema("top", FieldKind::Point, "apex, or center of the other end").make_required(),
            field_schema("radius", FieldKind::Number, "radius of the base")
                .with_range(FieldRange::Positive)
                .make_required(),
            field_schema("topRadius", FieldKind::Number, "radius of the other end")
                .with_range(FieldRange::NonNegative)
                .with_default_numbers(&[0.0]),
        ])
        .with_shared_fields(&[CAPS_FIELDS, EMISSION_FIELDS]);

impl ShapeBlock for CylinderDescription {
    const BLOCK: &'static BlockSchema = &CYLINDER;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let (ends, is_capped) = parse_ends_and_caps(f)?;
        Ok(Self { ends, radius: f.value_or_default("radius")?, is_capped })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        write_ends_and_radius(out, &self.ends, self.radius)?;
        write_caps(out, self.is_capped)
    }

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let [bottom, top] = self.ends;
        let cylinder = Frustum::cylinder(bottom, top, self.radius, self.is_capped);
        add_solid(r, placement, cylinder.map(Shape::Frustum), emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

impl ShapeBlock for ConeDescription {
    const BLOCK: &'static BlockSchema = &CONE;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let (ends, is_capped) = parse_ends_and_caps(f)?;
        Ok(Self { ends, radii: [f.value_or_default("radius")?, f.value_or_default("topRadius")?], is_capped })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        write_ends_and_radius(out, &self.ends, self.radii[0])?;
        if self.radii[1] != 0.0 {
            out.write_number("topRadius", self.radii[1])?;
        }
        write_caps(out, self.is_capped)
    }

    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError> {
        let [bottom, top] = self.ends;
        let cone = Frustum::new(bottom, top, self.radii, self.is_capped);
        add_solid(r, placement, cone.map(Shape::Frustum), emission)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

/// Returns the centers of both ends of a cylinder or cone, and true if discs close the ends.
fn parse_ends_and_caps(f: &BlockFields<'_>) -> Result<([DVec3; 2], bool), SceneError> {
    let ends = [f.value_or_default("bottom")?, f.value_or_default("top")?];
    f.require_field("top")?.ensure_valid(ends[0] != ends[1], "must differ from `bottom`")?;
    Ok((ends, f.field_word_or_default("caps")? == "yes"))
}

fn write_ends_and_radius(out: &mut SceneWriter<'_, '_>, [bottom, top]: &[DVec3; 2], radius: f64) -> fmt::Result {
    out.write_vec3("bottom", *bottom)?;
    out.write_vec3("top", *top)?;
    out.write_number("radius", radius)
}

fn write_caps(out: &mut SceneWriter<'_, '_>, is_capped: bool) -> fmt::Result {
    if is_capped { Ok(()) } else { out.write_field("caps", "no") }
}
