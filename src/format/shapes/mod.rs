//! Shapes in the scene language.
//!
//! Each kind of shape has a file with its description, its fields, and its conversion to a shape
//! of the scene. Most kinds state their fields in a table, which also reads and writes them. The
//! list in this file is the only other place that names the kind.

mod cuboid;
mod curve;
mod disc;
mod emission;
mod frustum;
mod mesh;
mod plane;
mod rectangle;
mod revolution;
mod sphere;
mod spline;
mod triangle;

pub use cuboid::BoxDescription;
pub use curve::{BezierCurveDescription, BsplineCurveDescription};
pub use disc::DiscDescription;
pub use frustum::{ConeDescription, CylinderDescription};
pub use mesh::MeshDescription;
pub use plane::PlaneDescription;
pub use rectangle::RectangleDescription;
pub use revolution::RevolutionDescription;
pub use sphere::SphereDescription;
pub use spline::{BezierPatchesDescription, NurbsDescription};
pub use triangle::TriangleDescription;

use super::error::SceneError;
use super::language::field_table::BlockCodec;
use super::language::fields::{BlockFields, parse_block_by_keyword};
use super::language::lexer::Token;
use super::language::parser::Parser;
use super::language::schema::{BlockParser, BlockSchema};
use super::language::writer::SceneWriter;
use super::resolve::Resolver;
use super::resolve::placement::{ObjectEmission, ObjectPlacement};
use super::span::Span;
use crate::math::Motion;
use glam::DVec3;
use std::fmt;

/// A kind of shape in the scene language: the schema of its block, and its conversion to a shape of
/// the scene. Its [`BlockCodec`] skips the field `emission`, which the caller reads and writes.
trait ShapeBlock: BlockCodec {
    /// Schema of the block: keyword, fields and help.
    const BLOCK: &'static BlockSchema;

    /// Adds the shape to the scene with the material at `r.current_material_index`, the texture
    /// mapping of this kind of shape, and `emission`.
    fn add(
        &self,
        r: &mut Resolver<'_>,
        placement: &ObjectPlacement<'_>,
        emission: &ObjectEmission,
    ) -> Result<(), SceneError>;

    /// Returns the path of the file that the shape reads; `None` if it reads no file.
    fn file_path_mut(&mut self) -> Option<&mut String>;
}

/// Function that converts the parsed fields of a shape block to a shape.
type ParseShape = fn(&BlockFields<'_>) -> Result<ShapeDescription, SceneError>;

/// Defines [`ShapeDescription`] and [`SHAPE_BLOCK_PARSERS`] from a list of all kinds of shapes.
/// Each entry states the enum variant and the type that implements [`ShapeBlock`]. The language
/// reference has the same order as the list.
macro_rules! shape_kinds {
    ($($(#[$doc:meta])* $kind:ident($description:ident),)*) => {
        /// Geometry of a surface, in object space.
        #[derive(Clone, Debug, PartialEq)]
        pub enum ShapeDescription {
            $($(#[$doc])* $kind($description),)*
        }

        $(impl From<$description> for ShapeDescription {
            fn from(shape: $description) -> Self {
                Self::$kind(shape)
            }
        })*

        /// Shape blocks of the scene language, each with the function that converts its fields.
        pub(super) static SHAPE_BLOCK_PARSERS: &[BlockParser<ParseShape>] = &[
            $(BlockParser { block: $description::BLOCK, parse: |f| $description::parse_fields(f).map(Into::into) },)*
        ];

        impl ShapeDescription {
            /// Returns the path of the file that the shape reads; `None` if it reads no file.
            #[must_use]
            pub fn file_path_mut(&mut self) -> Option<&mut String> {
                match self {
                    $(Self::$kind(shape) => shape.file_path_mut(),)*
                }
            }
        }

        /// Writes a shape as scene text. `emission` is the radiance \[W/(m² sr)] that is set on the
        /// shape; `None` if the shape emits like its material.
        // Not inlined: its callers recurse, and their stack frames must stay small.
        #[inline(never)]
        pub(super) fn write_shape(
            out: &mut SceneWriter<'_, '_>,
            shape: &ShapeDescription,
            emission: Option<DVec3>,
        ) -> fmt::Result {
            match shape {
                $(ShapeDescription::$kind(shape) => {
                    out.begin_schema_block($description::BLOCK)?;
                    shape.write_fields(out)?;
                })*
            }
            emission.map_or(Ok(()), |emission| out.write_vec3("emission", emission))?;
            out.end_block()
        }

        /// Adds a shape of the description with the material at `r.current_material_index` and the
        /// given `emission`. Fails if the shape's transform to world space is singular when the
        /// shutter opens.
        // Not inlined: its callers recurse, and their stack frames must stay small.
        #[inline(never)]
        pub(super) fn add_shape(
            r: &mut Resolver<'_>,
            shape: &ShapeDescription,
            span: Span,
            to_world: &Motion,
            emission: &ObjectEmission,
        ) -> Result<(), SceneError> {
            let to_world_at_open = r.invertible_transform(to_world.at_time(0.0), span)?;
            let placement = ObjectPlacement { to_world, to_world_at_open, span };
            match shape {
                $(ShapeDescription::$kind(shape) => shape.add(r, &placement, emission),)*
            }
        }
    };
}

shape_kinds! {
    /// A sphere.
    Sphere(SphereDescription),
    /// An infinite plane.
    Plane(PlaneDescription),
    /// A flat disc.
    Disc(DiscDescription),
    /// A parallelogram.
    Rectangle(RectangleDescription),
    /// An axis-aligned box.
    Box(BoxDescription),
    /// A cylinder.
    Cylinder(CylinderDescription),
    /// A cone or truncated cone.
    Cone(ConeDescription),
    /// A triangle.
    Triangle(TriangleDescription),
    /// A mesh in a file of its own.
    Mesh(MeshDescription),
    /// A surface of revolution.
    Revolution(RevolutionDescription),
    /// A Bézier curve of the scene format of MIT course 6.837. It has no surface, so the renderer
    /// skips it.
    BezierCurve(BezierCurveDescription),
    /// A B-spline curve of the scene format of MIT course 6.837. It has no surface, so the renderer
    /// skips it.
    BsplineCurve(BsplineCurveDescription),
    /// Rational Bézier patches that have the same degrees.
    Patches(BezierPatchesDescription),
    /// A rational B-spline surface (NURBS).
    Nurbs(NurbsDescription),
}

/// Parses a shape. The caller has read its keyword `word`.
///
/// Returns the shape, and the radiance \[W/(m² sr)] that is set on the shape; `None` if the shape
/// emits like its material.
// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn parse_shape<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
) -> Result<(ShapeDescription, Option<DVec3>), SceneError> {
    let (entry, f) = parse_block_by_keyword(parser, word, SHAPE_BLOCK_PARSERS)?;
    Ok(((entry.parse)(&f)?, f.optional_value("emission")))
}
