//! The blocks `Cylinder` and `Cone` of the scene language.

use super::ShapeBlock;
use super::emission::EMISSION_FIELDS;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldEntry, FieldGroup, field_table};
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{
    BlockSchema, FieldKind, FieldList, FieldRange, FieldSchema, block_schema, field_schema,
};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::placement::{ObjectEmission, ObjectPlacement, add_solid};
use crate::shape::{Frustum, Shape};
use glam::DVec3;
use std::fmt;

/// A cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct CylinderDescription {
    /// Centers of both ends of the cylinder. They differ.
    pub ends: [DVec3; 2],
    /// Radius of the cylinder, above 0.
    pub radius: f64,
    /// True if discs close both ends.
    pub is_capped: bool,
}

/// A cone or truncated cone.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeDescription {
    /// Centers of both ends of the cone. They differ.
    pub ends: [DVec3; 2],
    /// Radii of both ends: the first above 0, the second at least 0.
    pub radii: [f64; 2],
    /// True if discs close both ends.
    pub is_capped: bool,
}

field_table!(CylinderDescription {
    ends: CYLINDER_ENDS,
    radius: field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    is_capped: CAPS,
});

/// Fields for the centers of both ends of a cylinder.
const CYLINDER_ENDS: FieldGroup<[DVec3; 2]> = FieldGroup {
    list: FieldList::own(&[
        field_schema("bottom", FieldKind::Point, "center of one end").make_required(),
        field_schema("top", FieldKind::Point, "center of the other end").make_required(),
    ]),
    parse: parse_ends,
    write: write_ends,
    texture_name: |_| None,
};

field_table!(ConeDescription { ends: CONE_ENDS, radii: CONE_RADII, is_capped: CAPS });

/// Fields for the centers of both ends of a cone.
const CONE_ENDS: FieldGroup<[DVec3; 2]> = FieldGroup {
    list: FieldList::own(&[
        field_schema("bottom", FieldKind::Point, "center of the base").make_required(),
        field_schema("top", FieldKind::Point, "apex, or center of the other end").make_required(),
    ]),
    parse: parse_ends,
    write: write_ends,
    texture_name: |_| None,
};

/// Fields for the radii of both ends of a cone.
const CONE_RADII: FieldGroup<[f64; 2]> = FieldGroup {
    list: FieldList::own(&[CONE_RADIUS, CONE_TOP_RADIUS]),
    parse: |f| Ok([CONE_RADIUS.parse(f)?, CONE_TOP_RADIUS.parse(f)?]),
    write: |[radius, top_radius], out| {
        CONE_RADIUS.write(out, radius)?;
        CONE_TOP_RADIUS.write(out, top_radius)
    },
    texture_name: |_| None,
};

const CONE_RADIUS: FieldSchema =
    field_schema("radius", FieldKind::Number, "radius of the base").with_range(FieldRange::Positive).make_required();

const CONE_TOP_RADIUS: FieldSchema = field_schema("topRadius", FieldKind::Number, "radius of the other end")
    .with_range(FieldRange::NonNegative)
    .with_default_numbers(&[0.0])
    .omit_default();

const CAPS_FIELD: FieldSchema = field_schema("caps", FieldKind::Word(&["yes", "no"]), "`no` leaves both ends open")
    .with_default_word("yes")
    .omit_default();

/// The field `caps`, which cylinders and cones share.
const CAPS: FieldGroup<bool> = FieldGroup {
    list: FieldList::shared(&[CAPS_FIELD]),
    parse: |f| CAPS_FIELD.parse(f),
    write: |is_capped, out| CAPS_FIELD.write(out, is_capped),
    texture_name: |_| None,
};

impl ShapeBlock for CylinderDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("Cylinder", "cylinder of any direction, closed unless `caps` is `no`")
            .with_table(Self::FIELDS)
            .with_shared_fields(&[EMISSION_FIELDS]);

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
    const BLOCK: &'static BlockSchema =
        &block_schema("Cone", "cone or truncated cone of any direction, closed unless `caps` is `no`")
            .with_table(Self::FIELDS)
            .with_shared_fields(&[EMISSION_FIELDS]);

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

/// Returns the centers of both ends of a cylinder or cone. Fails if the centers coincide.
fn parse_ends(f: &BlockFields<'_>) -> Result<[DVec3; 2], SceneError> {
    let ends = [f.value_or_default("bottom")?, f.value_or_default("top")?];
    f.require_field("top")?.ensure_valid(ends[0] != ends[1], "must differ from `bottom`")?;
    Ok(ends)
}

fn write_ends([bottom, top]: &[DVec3; 2], out: &mut SceneWriter<'_, '_>) -> fmt::Result {
    out.write_vec3("bottom", *bottom)?;
    out.write_vec3("top", *top)
}
