//! The blocks `SphereLight`, `DiscLight` and `RectangleLight`: shapes that emit, and reflect
//! nothing.

use super::LightBlock;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldGroup, field_table};
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldList, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::parallelogram::{CORNER, EDGE0, EDGE1};
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::Span;
use crate::math::Motion;
use crate::scene::Material;
use crate::shape::{Disc, Rectangle, Shape, Sphere};
use glam::DVec3;
use std::fmt;

/// Strength of an area light: its radiance or its flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaLightStrength {
    /// Radiance in W/(m² sr), equal in all directions on the emitting side.
    Radiance(DVec3),
    /// Radiant flux in W.
    Power(DVec3),
}

/// A sphere that emits outward.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereLightDescription {
    /// Center of the sphere.
    pub center: DVec3,
    /// Radius of the sphere, above 0.
    pub radius: f64,
    /// Strength of the light: radiance or flux.
    pub strength: AreaLightStrength,
}

/// A disc that emits on the side of its normal.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscLightDescription {
    /// Center of the disc.
    pub center: DVec3,
    /// Normal of the emitting side, of any length.
    pub normal: DVec3,
    /// Radius of the disc, above 0.
    pub radius: f64,
    /// Strength of the light: radiance or flux.
    pub strength: AreaLightStrength,
}

/// A parallelogram that emits on the side of `edge0 × edge1`.
#[derive(Clone, Debug, PartialEq)]
pub struct RectangleLightDescription {
    /// The corner where both edges start.
    pub corner: DVec3,
    /// Edge vector from `corner` to one neighboring corner.
    pub edge0: DVec3,
    /// Edge vector from `corner` to the other neighboring corner.
    pub edge1: DVec3,
    /// Strength of the light: radiance or flux.
    pub strength: AreaLightStrength,
}

field_table!(SphereLightDescription {
    center: field_schema("center", FieldKind::Point, "center").make_required(),
    radius: field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    strength: AREA_STRENGTH,
});

field_table!(DiscLightDescription {
    center: field_schema("center", FieldKind::Point, "center").make_required(),
    normal: field_schema("normal", FieldKind::Direction, "normal of the emitting side").make_required(),
    radius: field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    strength: AREA_STRENGTH,
});

field_table!(RectangleLightDescription { corner: CORNER, edge0: EDGE0, edge1: EDGE1, strength: AREA_STRENGTH });

/// Fields for the strength of an area light; a block has exactly one of them.
const AREA_STRENGTH: FieldGroup<AreaLightStrength> = FieldGroup {
    list: FieldList::shared(&[
        field_schema("radiance", FieldKind::Color, "radiance of the emitting side; give one of the two")
            .with_unit("W/(m² sr)"),
        field_schema("power", FieldKind::Color, "radiant flux").with_unit("W"),
    ]),
    parse: AreaLightStrength::parse,
    write: AreaLightStrength::write,
    texture_name: |_| None,
};

impl AreaLightStrength {
    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        f.require_one_color_field(&[("radiance", Self::Radiance), ("power", Self::Power)])
    }

    fn write(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        match *self {
            Self::Radiance(c) => out.write_vec3("radiance", c),
            Self::Power(c) => out.write_vec3("power", c),
        }
    }
}

impl LightBlock for SphereLightDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("SphereLight", "sphere that emits outward").with_table(Self::FIELDS);
    const IS_INFINITE: bool = false;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, span: Span) -> Result<(), SceneError> {
        let sphere = Shape::Sphere(Sphere::new(self.center, self.radius));
        add_area_light(r, sphere, self.center, self.strength, motion, span)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

impl LightBlock for DiscLightDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("DiscLight", "disc that emits on the side of its normal").with_table(Self::FIELDS);
    const IS_INFINITE: bool = false;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, span: Span) -> Result<(), SceneError> {
        let disc = Shape::Disc(Disc::circular_disc(self.center, self.normal, self.radius));
        add_area_light(r, disc, self.center, self.strength, motion, span)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

impl LightBlock for RectangleLightDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("RectangleLight", "parallelogram that emits on the side of `edge0` × `edge1`")
            .with_table(Self::FIELDS);
    const IS_INFINITE: bool = false;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, span: Span) -> Result<(), SceneError> {
        let rectangle = Shape::Rectangle(Rectangle::new(self.corner, self.edge0, self.edge1));
        let center = self.corner + 0.5 * (self.edge0 + self.edge1);
        add_area_light(r, rectangle, center, self.strength, motion, span)
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}

/// Adds a light-emitting shape that reflects nothing. `motion` moves the shape while the shutter is
/// open; its rotations and scales are about `center`.
fn add_area_light(
    r: &mut Resolver<'_>,
    shape: Shape,
    center: DVec3,
    strength: AreaLightStrength,
    motion: &Motion,
    span: Span,
) -> Result<(), SceneError> {
    let radiance = match strength {
        AreaLightStrength::Radiance(l) => l,
        AreaLightStrength::Power(w) => w / (std::f64::consts::PI * shape.area()),
    };
    r.require_finite_radiance(rgb(radiance), span)?;
    let black = r.builder.add_material(Material::black());
    if motion.is_constant() {
        r.builder.add_shape(shape, black, rgb(radiance));
    } else {
        r.builder.add_moving_shape(shape, motion.pivoted_at_point(center), black, rgb(radiance));
    }
    Ok(())
}
