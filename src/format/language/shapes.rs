//! Schemas, parsing and writing of shape blocks.

use std::fmt;

use glam::DVec3;

use super::super::description::{CurveBasis, MeshOptions, ProfileCurve, ShapeDescription};
use super::super::error::SceneError;
use super::curves::{BEZIER_CONTROLS, BSPLINE_CONTROLS};
use super::fields::{BlockFields, FromFieldValue, parse_block_by_keyword};
use super::lexer::Token;
use super::parser::Parser;
use super::schema::{BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, block_schema, field_schema};
use super::writer::{SceneWriter, SpacedNumbers};
use crate::shape::parametric::MAX_DEGREE;

/// Shape blocks of the scene language, each with the function that converts its fields.
pub(super) static SHAPES: &[BlockParser<ParseShape>] = &[
    BlockParser { block: &SPHERE, parse: parse_sphere },
    BlockParser { block: &PLANE, parse: parse_plane },
    BlockParser { block: &DISC, parse: parse_disc },
    BlockParser { block: &RECTANGLE, parse: parse_rectangle },
    BlockParser { block: &BOX, parse: parse_box },
    BlockParser { block: &CYLINDER, parse: parse_cylinder },
    BlockParser { block: &CONE, parse: parse_cone },
    BlockParser { block: &TRIANGLE, parse: parse_triangle },
    BlockParser { block: &MESH, parse: parse_mesh },
    BlockParser { block: &REVOLUTION, parse: parse_revolution_surface },
    BlockParser { block: &BEZIER_CURVE, parse: parse_bezier_curve },
    BlockParser { block: &BSPLINE_CURVE, parse: parse_bspline_curve },
    BlockParser { block: &BEZIER_PATCH, parse: parse_bezier_patches },
    BlockParser { block: &NURBS, parse: parse_nurbs_surface },
];

/// Function that converts the parsed fields of a shape block to a shape.
type ParseShape = fn(&BlockFields<'_>) -> Result<ShapeDescription, SceneError>;

const DEGREE_RANGE: FieldRange = FieldRange::Within(1.0, MAX_DEGREE as f64);

static EMISSION_FIELDS: &[FieldSchema] =
    &[field_schema("emission", FieldKind::Color, "radiance instead of the material's; not for a `Plane`")
        .with_default_description("the material's")
        .with_unit("W/(m² sr)")];

static DEGREE_FIELDS: &[FieldSchema] = &[
    field_schema("degreeU", FieldKind::Whole, "degree along u").with_range(DEGREE_RANGE).with_default_numbers(&[3.0]),
    field_schema("degreeV", FieldKind::Whole, "degree along v").with_range(DEGREE_RANGE).with_default_numbers(&[3.0]),
];

static SPHERE: BlockSchema = block_schema("Sphere", "all points at distance `radius` from `center`")
    .with_fields(&[
        field_schema("center", FieldKind::Point, "center").make_required().mark_as_course_syntax(),
        field_schema("radius", FieldKind::Number, "radius")
            .with_range(FieldRange::Positive)
            .make_required()
            .mark_as_course_syntax(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS])
    .mark_as_course_syntax();

static PLANE: BlockSchema = block_schema("Plane", "infinite plane")
    .with_fields(&[
        field_schema("normal", FieldKind::Direction, "normal; its length scales `offset`")
            .make_required()
            .mark_as_course_syntax(),
        field_schema("offset", FieldKind::Number, "normal · x of the points x of the plane")
            .make_required()
            .mark_as_course_syntax(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS])
    .mark_as_course_syntax();

static DISC: BlockSchema = block_schema("Disc", "flat disc")
    .with_fields(&[
        field_schema("center", FieldKind::Point, "center").make_required(),
        field_schema("normal", FieldKind::Direction, "normal").make_required(),
        field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

static RECTANGLE: BlockSchema = block_schema("Rectangle", "parallelogram with normal `edge0` × `edge1`")
    .with_fields(&[
        field_schema("corner", FieldKind::Point, "corner where both edges start").make_required(),
        field_schema("edge0", FieldKind::Direction, "vector to the first neighbouring corner").make_required(),
        field_schema("edge1", FieldKind::Direction, "vector to the other neighbouring corner").make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

static BOX: BlockSchema = block_schema("Box", "closed box with edges along the axes")
    .with_fields(&[
        field_schema("min", FieldKind::Point, "corner with the lowest coordinates").make_required(),
        field_schema("max", FieldKind::Point, "opposite corner; above `min` in every coordinate").make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

static CAPS_FIELDS: &[FieldSchema] =
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

static TRIANGLE: BlockSchema = block_schema("Triangle", "triangle; its area may be 0")
    .with_fields(&[
        field_schema("vertex0", FieldKind::Point, "first vertex").make_required().mark_as_course_syntax(),
        field_schema("vertex1", FieldKind::Point, "second vertex").make_required().mark_as_course_syntax(),
        field_schema("vertex2", FieldKind::Point, "third vertex").make_required().mark_as_course_syntax(),
        field_schema("normal0", FieldKind::Direction, "shading normal at the first vertex; give all three or none"),
        field_schema("normal1", FieldKind::Direction, "shading normal at the second vertex"),
        field_schema("normal2", FieldKind::Direction, "shading normal at the third vertex"),
        field_schema("uv0", FieldKind::Pair, "texture coordinates at the first vertex; give all three or none")
            .with_default_description("0 0"),
        field_schema("uv1", FieldKind::Pair, "texture coordinates at the second vertex")
            .with_default_description("1 0"),
        field_schema("uv2", FieldKind::Pair, "texture coordinates at the third vertex").with_default_description("0 1"),
    ])
    .with_shared_fields(&[EMISSION_FIELDS])
    .mark_as_course_syntax();

static MESH: BlockSchema = block_schema("TriangleMesh", "triangle mesh in a file of its own")
    .with_fields(&[
        field_schema("obj_file", FieldKind::Name, "OBJ or PLY file")
            .with_alias("file")
            .make_required()
            .mark_as_course_syntax(),
        field_schema(
            "materials",
            FieldKind::Word(&["scene", "file"]),
            "materials of the scene or of the file's MTL files",
        )
        .with_default_word("scene"),
        field_schema("normals", FieldKind::Word(&["file", "none"]), "`none` ignores the file's normals")
            .with_default_word("file"),
        field_schema("smoothAngle", FieldKind::Number, "greatest angle between faces that are smoothed")
            .with_range(FieldRange::Within(0.0, 180.0))
            .with_default_description("faces without normals are flat")
            .with_unit("degrees"),
    ])
    .with_shared_fields(&[EMISSION_FIELDS])
    .mark_as_course_syntax();

static REVOLUTION: BlockSchema =
    block_schema("RevSurface", "surface of revolution: the points (x cos θ, y, x sin θ) of a profile")
        .with_fields(&[field_schema("profile", FieldKind::Curve, "curve of points (x, y), turned about the y axis")
            .make_required()
            .mark_as_course_syntax()])
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_course_syntax();

static BEZIER_CURVE: BlockSchema =
    block_schema("BezierCurve", "one Bézier curve; without `profile` it has no surface and is not visible")
        .with_fields(&[BEZIER_CONTROLS])
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_course_syntax();

static BSPLINE_CURVE: BlockSchema =
    block_schema("BsplineCurve", "a uniform cubic B-spline; without `profile` it has no surface and is not visible")
        .with_fields(&[BSPLINE_CONTROLS])
        .with_shared_fields(&[EMISSION_FIELDS])
        .mark_as_course_syntax();

static BEZIER_PATCH: BlockSchema = block_schema("BezierPatch", "one or more Bézier patches of the same degrees")
    .with_fields(&[field_schema(
        "controls",
        FieldKind::WeightedPoints,
        "control points, patch after patch, those along v first",
    )
    .make_required()])
    .with_shared_fields(&[DEGREE_FIELDS, EMISSION_FIELDS]);

static NURBS: BlockSchema = block_schema("NurbsSurface", "rational B-spline surface")
    .with_fields(&[
        field_schema("countU", FieldKind::Whole, "number of control points along u")
            .with_range(FieldRange::Special("above the degree"))
            .make_required(),
        field_schema("countV", FieldKind::Whole, "number of control points along v")
            .with_range(FieldRange::Special("above the degree"))
            .make_required(),
        field_schema("knotsU", FieldKind::Numbers, "`countU` + `degreeU` + 1 knots along u")
            .with_range(FieldRange::Special("nondecreasing"))
            .with_default_description("uniform"),
        field_schema("knotsV", FieldKind::Numbers, "`countV` + `degreeV` + 1 knots along v")
            .with_range(FieldRange::Special("nondecreasing"))
            .with_default_description("uniform"),
        field_schema("controls", FieldKind::WeightedPoints, "control points, those along v first").make_required(),
    ])
    .with_shared_fields(&[DEGREE_FIELDS, EMISSION_FIELDS]);

/// Parses a shape. Its keyword `word` has been read.
///
/// Returns the shape, and the emitted radiance \[W/(m² sr)] that replaces its material's, if any.
// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn parse_shape<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
) -> Result<(ShapeDescription, Option<DVec3>), SceneError> {
    let (entry, f) = parse_block_by_keyword(parser, word, SHAPES)?;
    Ok(((entry.parse)(&f)?, f.optional_value("emission")))
}

fn parse_sphere(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Sphere { center: f.value("center")?, radius: f.value("radius")? })
}

fn parse_plane(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Plane { normal: f.value("normal")?, offset: f.value("offset")? })
}

fn parse_disc(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Disc { center: f.value("center")?, normal: f.value("normal")?, radius: f.value("radius")? })
}

fn parse_rectangle(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let (corner, edge0, edge1) = parse_parallelogram(f)?;
    Ok(ShapeDescription::Rectangle { corner, edge0, edge1 })
}

fn parse_box(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let (min, max): (DVec3, DVec3) = (f.value("min")?, f.value("max")?);
    f.require_field("max")?.ensure_valid(max.cmpgt(min).all(), "must be above `min` in every coordinate")?;
    Ok(ShapeDescription::Box { min, max })
}

fn parse_cylinder(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let (ends, is_capped) = parse_ends_and_caps(f)?;
    Ok(ShapeDescription::Cylinder { ends, radius: f.value("radius")?, is_capped })
}

fn parse_cone(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let (ends, is_capped) = parse_ends_and_caps(f)?;
    Ok(ShapeDescription::Cone { ends, radii: [f.value("radius")?, f.value("topRadius")?], is_capped })
}

fn parse_mesh(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let options = MeshOptions {
        uses_file_materials: f.field_word_or_default("materials")? == "file",
        ignores_normals: f.field_word_or_default("normals")? == "none",
        max_smoothing_angle: f.optional_value("smoothAngle"),
    };
    Ok(ShapeDescription::Mesh { path: f.value("obj_file")?, options })
}

fn parse_revolution_surface(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Revolution { profile: f.require_field("profile")?.profile_curve() })
}

fn parse_bezier_curve(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Curve(f.require_field("controls")?.curve_with_basis(CurveBasis::Bezier)?))
}

fn parse_bspline_curve(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Curve(f.require_field("controls")?.curve_with_basis(CurveBasis::Bspline)?))
}

/// Returns the corner and both edge vectors of a parallelogram; an error if its area is 0.
pub(super) fn parse_parallelogram(f: &BlockFields<'_>) -> Result<(DVec3, DVec3, DVec3), SceneError> {
    let (corner, edge0, edge1): (_, DVec3, DVec3) = (f.value("corner")?, f.value("edge0")?, f.value("edge1")?);
    // Rounding alone gives parallel edges a sine of about 1e-16.
    let sine = edge0.normalize().cross(edge1.normalize()).length();
    f.require_field("edge1")?.ensure_valid(sine > 1e-12, "must not be parallel to `edge0`: the area would be 0")?;
    Ok((corner, edge0, edge1))
}

/// Returns the centers of both ends of a cylinder or cone, and true if discs close the ends.
fn parse_ends_and_caps(f: &BlockFields<'_>) -> Result<([DVec3; 2], bool), SceneError> {
    let ends = [f.value("bottom")?, f.value("top")?];
    f.require_field("top")?.ensure_valid(ends[0] != ends[1], "must differ from `bottom`")?;
    Ok((ends, f.field_word_or_default("caps")? == "yes"))
}

fn parse_triangle(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Triangle {
        vertices: [f.value("vertex0")?, f.value("vertex1")?, f.value("vertex2")?],
        normals: parse_three_optional_fields(f, ["normal0", "normal1", "normal2"])?,
        uv: parse_three_optional_fields(f, ["uv0", "uv1", "uv2"])?.map(Box::new),
    })
}

/// Returns the values of the three fields `names`; `None` if all three are absent.
///
/// # Errors
/// If only one or two of the fields are present.
fn parse_three_optional_fields<T: FromFieldValue>(
    f: &BlockFields<'_>,
    names: [&str; 3],
) -> Result<Option<[T; 3]>, SceneError> {
    if names.iter().all(|name| f.get(name).is_none()) {
        return Ok(None);
    }
    Ok(Some([f.value(names[0])?, f.value(names[1])?, f.value(names[2])?]))
}

fn parse_bezier_patches(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let degree: [u32; 2] = [f.value("degreeU")?, f.value("degreeV")?];
    let points_per_patch = (degree[0] as usize + 1) * (degree[1] as usize + 1);
    let controls = f.require_field("controls")?;
    let found = controls.weighted_points().len();
    let rule = format!("must hold {points_per_patch} points for each patch of these degrees, and holds {found}");
    controls.ensure_valid(found > 0 && found.is_multiple_of(points_per_patch), &rule)?;
    Ok(ShapeDescription::Patches { degree, controls: controls.weighted_points().to_vec() })
}

fn parse_nurbs_surface(f: &BlockFields<'_>) -> Result<ShapeDescription, SceneError> {
    let degree = [f.value("degreeU")?, f.value("degreeV")?];
    let parse_count = |name: &str, degree: u32| {
        let count: u32 = f.value(name)?;
        f.require_field(name)?.ensure_valid(count > degree, "must be above the degree")?;
        Ok(count)
    };
    let count = [parse_count("countU", degree[0])?, parse_count("countV", degree[1])?];
    let knot_count = |axis: usize| u64::from(count[axis]) + u64::from(degree[axis]) + 1;
    let knots = [parse_knots(f, "knotsU", knot_count(0))?, parse_knots(f, "knotsV", knot_count(1))?];
    let controls = f.require_field("controls")?;
    let (wanted, found) = (u64::from(count[0]) * u64::from(count[1]), controls.weighted_points().len() as u64);
    let rule = format!("must hold countU · countV = {wanted} points, and holds {found}");
    controls.ensure_valid(found == wanted, &rule)?;
    Ok(ShapeDescription::Nurbs { degree, count, knots, controls: controls.weighted_points().to_vec() })
}

/// Returns the knots of the field `name`; empty if the field is absent.
///
/// # Errors
/// If the field does not hold `wanted` knots, or if the knots decrease.
fn parse_knots(f: &BlockFields<'_>, name: &str, wanted: u64) -> Result<Vec<f64>, SceneError> {
    let Some(knots) = f.get(name) else { return Ok(Vec::new()) };
    let list = knots.number_list();
    let rule = format!("must hold count + degree + 1 = {wanted} numbers, and holds {}", list.len());
    knots.ensure_valid(list.len() as u64 == wanted, &rule)?;
    knots.ensure_valid(list.windows(2).all(|w| w[0] <= w[1]), "must not decrease")?;
    Ok(list.to_vec())
}

/// Writes a shape, and the emitted radiance that replaces its material's, if any.
// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn write_shape(
    out: &mut SceneWriter<'_, '_>,
    shape: &ShapeDescription,
    emission: Option<DVec3>,
) -> fmt::Result {
    match shape {
        ShapeDescription::Sphere { center, radius } => {
            out.begin_schema_block(&SPHERE)?;
            out.write_vec3("center", *center)?;
            out.write_number("radius", *radius)?;
        }
        ShapeDescription::Plane { normal, offset } => {
            out.begin_schema_block(&PLANE)?;
            out.write_vec3("normal", *normal)?;
            out.write_number("offset", *offset)?;
        }
        ShapeDescription::Disc { center, normal, radius } => {
            out.begin_schema_block(&DISC)?;
            out.write_vec3("center", *center)?;
            out.write_vec3("normal", *normal)?;
            out.write_number("radius", *radius)?;
        }
        ShapeDescription::Rectangle { corner, edge0, edge1 } => {
            out.begin_schema_block(&RECTANGLE)?;
            write_parallelogram(out, *corner, *edge0, *edge1)?;
        }
        ShapeDescription::Box { min, max } => {
            out.begin_schema_block(&BOX)?;
            out.write_vec3("min", *min)?;
            out.write_vec3("max", *max)?;
        }
        ShapeDescription::Cylinder { ends, radius, is_capped } => {
            out.begin_schema_block(&CYLINDER)?;
            write_ends_and_radius(out, ends, *radius)?;
            write_caps(out, *is_capped)?;
        }
        ShapeDescription::Cone { ends, radii, is_capped } => {
            out.begin_schema_block(&CONE)?;
            write_ends_and_radius(out, ends, radii[0])?;
            if radii[1] != 0.0 {
                out.write_number("topRadius", radii[1])?;
            }
            write_caps(out, *is_capped)?;
        }
        ShapeDescription::Triangle { vertices, normals, uv } => {
            out.begin_schema_block(&TRIANGLE)?;
            for (i, vertex) in vertices.iter().enumerate() {
                out.write_vec3(&format!("vertex{i}"), *vertex)?;
            }
            for (i, normal) in normals.iter().flatten().enumerate() {
                out.write_vec3(&format!("normal{i}"), *normal)?;
            }
            for (i, uv) in uv.iter().flat_map(|uv| uv.iter()).enumerate() {
                out.write_vec2(&format!("uv{i}"), *uv)?;
            }
        }
        ShapeDescription::Mesh { path, options } => {
            out.begin_schema_block(&MESH)?;
            let ply = path.to_ascii_lowercase().ends_with(".ply");
            out.write_name(if ply { "file" } else { "obj_file" }, path)?;
            if options.uses_file_materials {
                out.write_field("materials", "file")?;
            }
            if options.ignores_normals {
                out.write_field("normals", "none")?;
            }
            options.max_smoothing_angle.map_or(Ok(()), |angle| out.write_number("smoothAngle", angle))?;
        }
        ShapeDescription::Revolution { profile } => {
            out.begin_schema_block(&REVOLUTION)?;
            out.begin_block(format_args!("profile {}", curve_block_schema(profile).keyword))?;
            out.write_points("controls", &profile.controls)?;
            out.end_block()?;
        }
        ShapeDescription::Curve(curve) => {
            out.begin_schema_block(curve_block_schema(curve))?;
            out.write_points("controls", &curve.controls)?;
        }
        ShapeDescription::Patches { degree, controls } => {
            out.begin_schema_block(&BEZIER_PATCH)?;
            write_surface_degrees(out, degree)?;
            out.write_weighted_points("controls", controls)?;
        }
        ShapeDescription::Nurbs { degree, count, knots, controls } => {
            out.begin_schema_block(&NURBS)?;
            write_surface_degrees(out, degree)?;
            out.write_field("countU", count[0])?;
            out.write_field("countV", count[1])?;
            for (name, knots) in ["knotsU", "knotsV"].into_iter().zip(knots).filter(|(_, k)| !k.is_empty()) {
                out.write_field(name, SpacedNumbers(knots))?;
            }
            out.write_weighted_points("controls", controls)?;
        }
    }
    emission.map_or(Ok(()), |emission| out.write_vec3("emission", emission))?;
    out.end_block()
}

fn curve_block_schema(curve: &ProfileCurve) -> &'static BlockSchema {
    match curve.basis {
        CurveBasis::Bezier => &BEZIER_CURVE,
        CurveBasis::Bspline => &BSPLINE_CURVE,
    }
}

/// Writes the fields of a parallelogram: its corner and both edges.
pub(super) fn write_parallelogram(
    out: &mut SceneWriter<'_, '_>,
    corner: DVec3,
    edge0: DVec3,
    edge1: DVec3,
) -> fmt::Result {
    out.write_vec3("corner", corner)?;
    out.write_vec3("edge0", edge0)?;
    out.write_vec3("edge1", edge1)
}

fn write_surface_degrees(out: &mut SceneWriter<'_, '_>, degree: &[u32; 2]) -> fmt::Result {
    out.write_field("degreeU", degree[0])?;
    out.write_field("degreeV", degree[1])
}

fn write_ends_and_radius(out: &mut SceneWriter<'_, '_>, [bottom, top]: &[DVec3; 2], radius: f64) -> fmt::Result {
    out.write_vec3("bottom", *bottom)?;
    out.write_vec3("top", *top)?;
    out.write_number("radius", radius)
}

fn write_caps(out: &mut SceneWriter<'_, '_>, is_capped: bool) -> fmt::Result {
    if is_capped { Ok(()) } else { out.write_field("caps", "no") }
}
