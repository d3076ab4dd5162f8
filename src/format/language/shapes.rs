//! Shapes.

use std::fmt;

use glam::DVec3;

use super::super::description::{CurveBasis, MeshOptions, ProfileCurve, ShapeDescription};
use super::super::error::SceneError;
use super::curves::{BEZIER_CONTROLS, BSPLINE_CONTROLS};
use super::fields::{Fields, fields};
use super::lexer::Token;
use super::reader::Parser;
use super::schema::{Block, Entry, Field, Kind, Range, field, find, keywords};
use super::writer::{Numbers, Writer};
use crate::shape::parametric::MAX_DEGREE;

/// The shapes.
pub(super) static SHAPES: [Entry<ReadShape>; 14] = [
    Entry { block: &SPHERE, read: sphere },
    Entry { block: &PLANE, read: plane },
    Entry { block: &DISC, read: disc },
    Entry { block: &RECTANGLE, read: rectangle },
    Entry { block: &BOX, read: cuboid },
    Entry { block: &CYLINDER, read: cylinder },
    Entry { block: &CONE, read: cone },
    Entry { block: &TRIANGLE, read: triangle },
    Entry { block: &MESH, read: mesh },
    Entry { block: &REVOLUTION, read: revolution },
    Entry { block: &BEZIER_CURVE, read: bezier_curve },
    Entry { block: &BSPLINE_CURVE, read: bspline_curve },
    Entry { block: &BEZIER_PATCH, read: patches },
    Entry { block: &NURBS, read: nurbs },
];

/// Reader of the geometry of a shape.
type ReadShape = fn(&Fields<'_>) -> Result<ShapeDescription, SceneError>;

const DEGREE: Range = Range::Within(1.0, MAX_DEGREE as f64);

static EMISSION: [Field; 1] =
    [field("emission", Kind::Color, Range::NonNegative, "radiance instead of the material's; not for a `Plane`")
        .absent("the material's")
        .unit("W/(m² sr)")];

static DEGREES: [Field; 2] = [
    field("degreeU", Kind::Whole, DEGREE, "degree along u").or(&[3.0]),
    field("degreeV", Kind::Whole, DEGREE, "degree along v").or(&[3.0]),
];

static SPHERE: Block = Block {
    keyword: "Sphere",
    aliases: &[],
    fields: &[
        field("center", Kind::Point, Range::Any, "center").required().course(),
        field("radius", Kind::Number, Range::Positive, "radius").required().course(),
    ],
    shared: &[&EMISSION],
    help: "all points at distance `radius` from `center`",
    course: true,
};

static PLANE: Block = Block {
    keyword: "Plane",
    aliases: &[],
    fields: &[
        field("normal", Kind::Direction, Range::Any, "normal; its length scales `offset`").required().course(),
        field("offset", Kind::Number, Range::Any, "normal · x of the points x of the plane").required().course(),
    ],
    shared: &[&EMISSION],
    help: "infinite plane",
    course: true,
};

static DISC: Block = Block {
    keyword: "Disc",
    aliases: &[],
    fields: &[
        field("center", Kind::Point, Range::Any, "center").required(),
        field("normal", Kind::Direction, Range::Any, "normal").required(),
        field("radius", Kind::Number, Range::Positive, "radius").required(),
    ],
    shared: &[&EMISSION],
    help: "flat disc",
    course: false,
};

static RECTANGLE: Block = Block {
    keyword: "Rectangle",
    aliases: &[],
    fields: &[
        field("corner", Kind::Point, Range::Any, "corner where both edges start").required(),
        field("edge0", Kind::Direction, Range::Any, "vector to the first neighbouring corner").required(),
        field("edge1", Kind::Direction, Range::Any, "vector to the other neighbouring corner").required(),
    ],
    shared: &[&EMISSION],
    help: "parallelogram with normal `edge0` × `edge1`",
    course: false,
};

static BOX: Block = Block {
    keyword: "Box",
    aliases: &[],
    fields: &[
        field("min", Kind::Point, Range::Any, "corner with the lowest coordinates").required(),
        field("max", Kind::Point, Range::Any, "opposite corner; above `min` in every coordinate").required(),
    ],
    shared: &[&EMISSION],
    help: "closed box with edges along the axes",
    course: false,
};

static CAPS: [Field; 1] =
    [field("caps", Kind::Word(&["yes", "no"]), Range::Any, "`no` leaves both ends open").or_word("yes")];

static CYLINDER: Block = Block {
    keyword: "Cylinder",
    aliases: &[],
    fields: &[
        field("bottom", Kind::Point, Range::Any, "center of one end").required(),
        field("top", Kind::Point, Range::Any, "center of the other end").required(),
        field("radius", Kind::Number, Range::Positive, "radius").required(),
    ],
    shared: &[&CAPS, &EMISSION],
    help: "cylinder of any direction, closed unless `caps` is `no`",
    course: false,
};

static CONE: Block = Block {
    keyword: "Cone",
    aliases: &[],
    fields: &[
        field("bottom", Kind::Point, Range::Any, "center of the base").required(),
        field("top", Kind::Point, Range::Any, "apex, or center of the other end").required(),
        field("radius", Kind::Number, Range::Positive, "radius of the base").required(),
        field("topRadius", Kind::Number, Range::NonNegative, "radius of the other end").or(&[0.0]),
    ],
    shared: &[&CAPS, &EMISSION],
    help: "cone or truncated cone of any direction, closed unless `caps` is `no`",
    course: false,
};

static TRIANGLE: Block = Block {
    keyword: "Triangle",
    aliases: &[],
    fields: &[
        field("vertex0", Kind::Point, Range::Any, "first vertex").required().course(),
        field("vertex1", Kind::Point, Range::Any, "second vertex").required().course(),
        field("vertex2", Kind::Point, Range::Any, "third vertex").required().course(),
        field("normal0", Kind::Direction, Range::Any, "shading normal at the first vertex; give all three or none"),
        field("normal1", Kind::Direction, Range::Any, "shading normal at the second vertex"),
        field("normal2", Kind::Direction, Range::Any, "shading normal at the third vertex"),
        field("uv0", Kind::Pair, Range::Any, "texture coordinates at the first vertex; give all three or none")
            .absent("0 0"),
        field("uv1", Kind::Pair, Range::Any, "texture coordinates at the second vertex").absent("1 0"),
        field("uv2", Kind::Pair, Range::Any, "texture coordinates at the third vertex").absent("0 1"),
    ],
    shared: &[&EMISSION],
    help: "triangle; its area may be 0",
    course: true,
};

static MESH: Block = Block {
    keyword: "TriangleMesh",
    aliases: &[],
    fields: &[
        field("obj_file", Kind::Name, Range::Any, "OBJ or PLY file").alias("file").required().course(),
        field(
            "materials",
            Kind::Word(&["scene", "file"]),
            Range::Any,
            "materials of the scene or of the file's MTL files",
        )
        .or_word("scene"),
        field("normals", Kind::Word(&["file", "none"]), Range::Any, "`none` ignores the file's normals")
            .or_word("file"),
        field("smoothAngle", Kind::Number, Range::Within(0.0, 180.0), "greatest angle between faces that are smoothed")
            .absent("faces without normals are flat")
            .unit("degrees"),
    ],
    shared: &[&EMISSION],
    help: "triangle mesh in a file of its own",
    course: true,
};

static REVOLUTION: Block = Block {
    keyword: "RevSurface",
    aliases: &[],
    fields: &[field("profile", Kind::Curve, Range::Any, "curve of points (x, y), turned about the y axis")
        .required()
        .course()],
    shared: &[&EMISSION],
    help: "surface of revolution: the points (x cos θ, y, x sin θ) of a profile",
    course: true,
};

static BEZIER_CURVE: Block = Block {
    keyword: "BezierCurve",
    aliases: &[],
    fields: &[BEZIER_CONTROLS],
    shared: &[&EMISSION],
    help: "one Bézier curve; without `profile` it has no surface and is not visible",
    course: true,
};

static BSPLINE_CURVE: Block = Block {
    keyword: "BsplineCurve",
    aliases: &[],
    fields: &[BSPLINE_CONTROLS],
    shared: &[&EMISSION],
    help: "a uniform cubic B-spline; without `profile` it has no surface and is not visible",
    course: true,
};

static BEZIER_PATCH: Block = Block {
    keyword: "BezierPatch",
    aliases: &[],
    fields: &[field(
        "controls",
        Kind::WeightedPoints,
        Range::Any,
        "control points, patch after patch, those along v first",
    )
    .required()],
    shared: &[&DEGREES, &EMISSION],
    help: "one or more Bézier patches of the same degrees",
    course: false,
};

static NURBS: Block = Block {
    keyword: "NurbsSurface",
    aliases: &[],
    fields: &[
        field("countU", Kind::Whole, Range::Special("above the degree"), "number of control points along u").required(),
        field("countV", Kind::Whole, Range::Special("above the degree"), "number of control points along v").required(),
        field("knotsU", Kind::Numbers, Range::Special("nondecreasing"), "`countU` + `degreeU` + 1 knots along u")
            .absent("uniform"),
        field("knotsV", Kind::Numbers, Range::Special("nondecreasing"), "`countV` + `degreeV` + 1 knots along v")
            .absent("uniform"),
        field("controls", Kind::WeightedPoints, Range::Any, "control points, those along v first").required(),
    ],
    shared: &[&DEGREES, &EMISSION],
    help: "rational B-spline surface",
    course: false,
};

/// Reads a shape and the radiance that replaces its material's.
// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn shape<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
) -> Result<(ShapeDescription, Option<DVec3>), SceneError> {
    let Some(entry) = find(&SHAPES, word.text) else {
        return Err(parser.unexpected(word, &keywords(&[], &SHAPES)));
    };
    let f = &fields(parser, word, entry.block)?;
    let shape = (entry.read)(f)?;
    Ok((shape, f.get("emission").map(|emission| emission.vector())))
}

fn sphere(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Sphere { center: f.vector("center")?, radius: f.number("radius")? })
}

fn plane(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Plane { normal: f.vector("normal")?, offset: f.number("offset")? })
}

fn disc(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Disc { center: f.vector("center")?, normal: f.vector("normal")?, radius: f.number("radius")? })
}

fn rectangle(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let (corner, edge0, edge1) = parallelogram(f)?;
    Ok(ShapeDescription::Rectangle { corner, edge0, edge1 })
}

fn cuboid(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let (min, max) = (f.vector("min")?, f.require("max")?);
    max.ensure(max.vector().cmpgt(min).all(), "must be above `min` in every coordinate")?;
    Ok(ShapeDescription::Box { min, max: max.vector() })
}

fn cylinder(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let (ends, is_capped) = ends(f)?;
    Ok(ShapeDescription::Cylinder { ends, radius: f.number("radius")?, is_capped })
}

fn cone(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let (ends, is_capped) = ends(f)?;
    Ok(ShapeDescription::Cone { ends, radii: [f.number("radius")?, f.number("topRadius")?], is_capped })
}

fn mesh(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Mesh { path: f.require("obj_file")?.text(), options: mesh_options(f)? })
}

fn revolution(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Revolution { profile: f.require("profile")?.curve() })
}

fn bezier_curve(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Curve(f.require("controls")?.curve_of(CurveBasis::Bezier)?))
}

fn bspline_curve(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    Ok(ShapeDescription::Curve(f.require("controls")?.curve_of(CurveBasis::Bspline)?))
}

/// Returns corner and edges of a parallelogram that has an area.
pub(super) fn parallelogram(f: &Fields<'_>) -> Result<(DVec3, DVec3, DVec3), SceneError> {
    let (corner, edge0, edge1) = (f.vector("corner")?, f.vector("edge0")?, f.require("edge1")?);
    // Rounding of parallel edges alone gives a sine of about 1e-16.
    let sine = edge0.normalize().cross(edge1.vector().normalize()).length();
    edge1.ensure(sine > 1e-12, "must not be parallel to `edge0`: the area would be 0")?;
    Ok((corner, edge0, edge1.vector()))
}

/// Returns the centers of both ends of a cylinder or cone, and true if caps close them.
fn ends(f: &Fields<'_>) -> Result<([DVec3; 2], bool), SceneError> {
    let (bottom, top) = (f.vector("bottom")?, f.require("top")?);
    top.ensure(top.vector() != bottom, "must differ from `bottom`")?;
    Ok(([bottom, top.vector()], f.word("caps")? == "yes"))
}

fn triangle(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let vertices = [f.vector("vertex0")?, f.vector("vertex1")?, f.vector("vertex2")?];
    let any = |names: [&str; 3]| names.iter().any(|name| f.get(name).is_some());
    let normals = match any(["normal0", "normal1", "normal2"]) {
        true => Some([f.vector("normal0")?, f.vector("normal1")?, f.vector("normal2")?]),
        false => None,
    };
    let uv = match any(["uv0", "uv1", "uv2"]) {
        true => Some(Box::new([f.pair("uv0")?, f.pair("uv1")?, f.pair("uv2")?])),
        false => None,
    };
    Ok(ShapeDescription::Triangle { vertices, normals, uv })
}

fn mesh_options(f: &Fields<'_>) -> Result<MeshOptions, SceneError> {
    Ok(MeshOptions {
        uses_file_materials: f.word("materials")? == "file",
        ignores_normals: f.word("normals")? == "none",
        max_smoothing_angle: f.get("smoothAngle").map(|angle| angle.number()),
    })
}

fn patches(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let degree = [f.whole("degreeU")?, f.whole("degreeV")?];
    let each = (degree[0] as usize + 1) * (degree[1] as usize + 1);
    let controls = f.require("controls")?;
    let found = controls.weighted_points().len();
    let rule = format!("must hold {each} points for each patch of these degrees, and holds {found}");
    controls.ensure(found > 0 && found.is_multiple_of(each), &rule)?;
    Ok(ShapeDescription::Patches { degree, controls: controls.weighted_points().to_vec() })
}

fn nurbs(f: &Fields<'_>) -> Result<ShapeDescription, SceneError> {
    let degree = [f.whole("degreeU")?, f.whole("degreeV")?];
    let count = |name: &str, degree: u32| {
        let count = f.require(name)?;
        count.ensure(count.number() > f64::from(degree), "must be above the degree")?;
        Ok(count.number() as u32)
    };
    let count = [count("countU", degree[0])?, count("countV", degree[1])?];
    let knots = |name: &str, axis: usize| knots(f, name, u64::from(count[axis]) + u64::from(degree[axis]) + 1);
    let knots = [knots("knotsU", 0)?, knots("knotsV", 1)?];
    let controls = f.require("controls")?;
    let (wanted, found) = (u64::from(count[0]) * u64::from(count[1]), controls.weighted_points().len() as u64);
    let rule = format!("must hold countU · countV = {wanted} points, and holds {found}");
    controls.ensure(found == wanted, &rule)?;
    Ok(ShapeDescription::Nurbs { degree, count, knots, controls: controls.weighted_points().to_vec() })
}

/// Returns knots along one direction; none if they are not given.
fn knots(f: &Fields<'_>, name: &str, wanted: u64) -> Result<Vec<f64>, SceneError> {
    let Some(knots) = f.get(name) else { return Ok(Vec::new()) };
    let list = knots.list();
    let rule = format!("must hold count + degree + 1 = {wanted} numbers, and holds {}", list.len());
    knots.ensure(list.len() as u64 == wanted, &rule)?;
    knots.ensure(list.windows(2).all(|w| w[0] <= w[1]), "must not decrease")?;
    Ok(list.to_vec())
}

/// Prints a shape and the radiance that replaces its material's.
// Not inlined: its callers recurse, and their stack frames must stay small.
#[inline(never)]
pub(super) fn write_shape(out: &mut Writer<'_, '_>, shape: &ShapeDescription, emission: Option<DVec3>) -> fmt::Result {
    match shape {
        ShapeDescription::Sphere { center, radius } => {
            out.start(&SPHERE)?;
            out.vector("center", *center)?;
            out.number("radius", *radius)?;
        }
        ShapeDescription::Plane { normal, offset } => {
            out.start(&PLANE)?;
            out.vector("normal", *normal)?;
            out.number("offset", *offset)?;
        }
        ShapeDescription::Disc { center, normal, radius } => {
            out.start(&DISC)?;
            out.vector("center", *center)?;
            out.vector("normal", *normal)?;
            out.number("radius", *radius)?;
        }
        ShapeDescription::Rectangle { corner, edge0, edge1 } => {
            out.start(&RECTANGLE)?;
            write_parallelogram(out, *corner, *edge0, *edge1)?;
        }
        ShapeDescription::Box { min, max } => {
            out.start(&BOX)?;
            out.vector("min", *min)?;
            out.vector("max", *max)?;
        }
        ShapeDescription::Cylinder { ends, radius, is_capped } => {
            out.start(&CYLINDER)?;
            write_ends(out, ends, *radius)?;
            write_caps(out, *is_capped)?;
        }
        ShapeDescription::Cone { ends, radii, is_capped } => {
            out.start(&CONE)?;
            write_ends(out, ends, radii[0])?;
            if radii[1] != 0.0 {
                out.number("topRadius", radii[1])?;
            }
            write_caps(out, *is_capped)?;
        }
        ShapeDescription::Triangle { vertices, normals, uv } => {
            out.start(&TRIANGLE)?;
            for (i, vertex) in vertices.iter().enumerate() {
                out.vector(&format!("vertex{i}"), *vertex)?;
            }
            for (i, normal) in normals.iter().flatten().enumerate() {
                out.vector(&format!("normal{i}"), *normal)?;
            }
            for (i, uv) in uv.iter().flat_map(|uv| uv.iter()).enumerate() {
                out.pair(&format!("uv{i}"), *uv)?;
            }
        }
        ShapeDescription::Mesh { path, options } => {
            out.start(&MESH)?;
            let ply = path.to_ascii_lowercase().ends_with(".ply");
            out.name(if ply { "file" } else { "obj_file" }, path)?;
            if options.uses_file_materials {
                out.field("materials", "file")?;
            }
            if options.ignores_normals {
                out.field("normals", "none")?;
            }
            options.max_smoothing_angle.map_or(Ok(()), |angle| out.number("smoothAngle", angle))?;
        }
        ShapeDescription::Revolution { profile } => {
            out.start(&REVOLUTION)?;
            out.open(format_args!("profile {}", curve_block(profile).keyword))?;
            out.points("controls", &profile.controls)?;
            out.close()?;
        }
        ShapeDescription::Curve(curve) => {
            out.start(curve_block(curve))?;
            out.points("controls", &curve.controls)?;
        }
        ShapeDescription::Patches { degree, controls } => {
            out.start(&BEZIER_PATCH)?;
            write_degrees(out, degree)?;
            out.weighted_points("controls", controls)?;
        }
        ShapeDescription::Nurbs { degree, count, knots, controls } => {
            out.start(&NURBS)?;
            write_degrees(out, degree)?;
            out.field("countU", count[0])?;
            out.field("countV", count[1])?;
            for (name, knots) in ["knotsU", "knotsV"].into_iter().zip(knots).filter(|(_, k)| !k.is_empty()) {
                out.field(name, Numbers(knots))?;
            }
            out.weighted_points("controls", controls)?;
        }
    }
    emission.map_or(Ok(()), |emission| out.vector("emission", emission))?;
    out.close()
}

/// Returns the block of a curve.
fn curve_block(curve: &ProfileCurve) -> &'static Block {
    match curve.basis {
        CurveBasis::Bezier => &BEZIER_CURVE,
        CurveBasis::Bspline => &BSPLINE_CURVE,
    }
}

/// Prints corner and edges of a parallelogram.
pub(super) fn write_parallelogram(out: &mut Writer<'_, '_>, corner: DVec3, edge0: DVec3, edge1: DVec3) -> fmt::Result {
    out.vector("corner", corner)?;
    out.vector("edge0", edge0)?;
    out.vector("edge1", edge1)
}

fn write_degrees(out: &mut Writer<'_, '_>, degree: &[u32; 2]) -> fmt::Result {
    out.field("degreeU", degree[0])?;
    out.field("degreeV", degree[1])
}

fn write_ends(out: &mut Writer<'_, '_>, [bottom, top]: &[DVec3; 2], radius: f64) -> fmt::Result {
    out.vector("bottom", *bottom)?;
    out.vector("top", *top)?;
    out.number("radius", radius)
}

fn write_caps(out: &mut Writer<'_, '_>, is_capped: bool) -> fmt::Result {
    if is_capped { Ok(()) } else { out.field("caps", "no") }
}
