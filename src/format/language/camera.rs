//! Schemas, parsing and writing of camera blocks.
//!
//! The fields `direction` and `lookAt`, which cameras and lights share, are here, too.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    ApertureDescription, CameraDescription, DirectionOrTarget, FocusDescription, LensDescription,
    ProjectionDescription, Spanned, TransformStep,
};
use super::super::error::SceneError;
use super::fields::{BlockFields, parse_block_by_keyword};
use super::lexer::Token;
use super::parser::Parser;
use super::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, block_keywords, block_schema, field_schema,
};
use super::text::is_normalizable;
use super::transforms::{parse_moving_block, write_transform_steps};
use super::writer::SceneWriter;

/// Camera blocks of the scene language, each with the function that converts its fields.
pub(super) static CAMERAS: &[BlockParser<ParseProjection>] = &[
    BlockParser { block: &PERSPECTIVE, parse: parse_perspective_projection },
    BlockParser { block: &ORTHOGRAPHIC, parse: parse_orthographic_projection },
    BlockParser { block: &ENVIRONMENT, parse: parse_environment_projection },
];

/// Function that converts the parsed fields of a camera block to the camera's projection.
type ParseProjection = fn(&BlockFields<'_>, &CameraPose) -> Result<ProjectionDescription, SceneError>;

/// Position and view direction of a camera.
pub(super) struct CameraPose {
    center: DVec3,
    /// View direction, of any length.
    direction: DVec3,
    /// The field `direction` or `lookAt`, as the scene text states it.
    aim: DirectionOrTarget,
}

const PICTURE_SIZE_RANGE: FieldRange = FieldRange::Within(1.0, 65_536.0);

static VIEW_FIELDS: &[FieldSchema] = &[
    field_schema("center", FieldKind::Point, "the pinhole, the lens center, or the center of an orthographic picture")
        .make_required()
        .mark_as_course_syntax(),
    field_schema("direction", FieldKind::Direction, "direction of view; give this or `lookAt`").mark_as_course_syntax(),
    field_schema("lookAt", FieldKind::Point, "point that the camera looks at"),
    field_schema("up", FieldKind::Direction, "direction that appears upward; not parallel to the view")
        .with_default_numbers(&[0.0, 1.0, 0.0])
        .mark_as_course_syntax(),
];

static PICTURE_SIZE_FIELDS: &[FieldSchema] = &[
    field_schema("width", FieldKind::Whole, "picture width")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_numbers(&[960.0])
        .with_unit("pixels")
        .mark_as_course_syntax(),
    field_schema("height", FieldKind::Whole, "picture height")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_numbers(&[720.0])
        .with_unit("pixels")
        .mark_as_course_syntax(),
];

static PERSPECTIVE: BlockSchema = block_schema("PerspectiveCamera", "perspective through a pinhole or a thin lens")
    .with_fields(&[
        field_schema("angle", FieldKind::Number, "vertical field of view")
            .with_range(FieldRange::Between(0.0, 180.0))
            .make_required()
            .with_unit("degrees")
            .mark_as_course_syntax(),
        field_schema("aperture", FieldKind::Number, "lens radius")
            .with_range(FieldRange::NonNegative)
            .with_default_description("0: a pinhole"),
        field_schema("fNumber", FieldKind::Number, "instead of `aperture`: focal length over lens diameter")
            .with_range(FieldRange::Positive),
        field_schema("sensorHeight", FieldKind::Number, "with `fNumber`: sensor height; sets the focal length")
            .with_range(FieldRange::Positive)
            .with_default_description("0.024: 24 mm if the unit is the metre"),
        field_schema("focusDistance", FieldKind::Number, "distance along the view of the plane in focus, 10⁻¹² … 10¹²")
            .with_range(FieldRange::Positive),
        field_schema("focusAt", FieldKind::Point, "instead of `focusDistance`: a point of the plane in focus")
            .with_default_description("the point of `lookAt`"),
        field_schema("blades", FieldKind::Whole, "edges of the lens opening, visible in blurred highlights")
            .with_range(FieldRange::Special("0 or 3 … 64"))
            .with_default_description("0: round"),
    ])
    .with_shared_fields(&[VIEW_FIELDS, PICTURE_SIZE_FIELDS])
    .mark_as_course_syntax();

static ORTHOGRAPHIC: BlockSchema = block_schema("OrthographicCamera", "parallel projection")
    .with_fields(&[field_schema("size", FieldKind::Number, "height of the visible region")
        .with_range(FieldRange::UpTo(0.0, 1e12))
        .make_required()])
    .with_shared_fields(&[VIEW_FIELDS, PICTURE_SIZE_FIELDS]);

static ENVIRONMENT: BlockSchema = block_schema(
    "EnvironmentCamera",
    "all directions by longitude and latitude, with the direction of view in the middle",
)
.with_fields(&[
    field_schema("width", FieldKind::Whole, "picture width")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_numbers(&[960.0])
        .with_unit("pixels"),
    field_schema("height", FieldKind::Whole, "picture height")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_description("half of the width")
        .with_unit("pixels"),
])
.with_shared_fields(&[VIEW_FIELDS]);

/// Default sensor height in scene units: 24 mm if the unit is the metre.
const DEFAULT_SENSOR_HEIGHT: f64 = 0.024;

/// Parses a `Moving` block that holds a camera. A scale in the block is an error.
pub(super) fn parse_moving_camera<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
) -> Result<Spanned<CameraDescription>, SceneError> {
    let read = |parser: &mut Parser<'a>, word: Token<'a>| Ok(Spanned::new(parse_camera(parser, word)?, word.span()));
    let allowed = block_keywords(&[], CAMERAS);
    let (motion, mut camera) = parse_moving_block(parser, keyword, &allowed, read)?;
    if motion.iter().any(|map| matches!(map, TransformStep::Scale(_) | TransformStep::UniformScale(_))) {
        let message = "a camera cannot grow".to_owned();
        let help = "move it by Translate and Rotate only".to_owned();
        return Err(parser.lexer.error_at(keyword.span(), message, "this motion", help));
    }
    camera.value.motion = motion;
    Ok(camera)
}

/// Parses a camera block. Its keyword `word` has been read.
pub(super) fn parse_camera<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<CameraDescription, SceneError> {
    let (entry, f) = parse_block_by_keyword(parser, word, CAMERAS)?;
    let center = f.value("center")?;
    let (aim, direction) = parse_direction_or_target(&f, "center", center)?;
    let up: DVec3 = f.value("up")?;
    // For a smaller sine of the angle between `up` and the view, rounding decides which way is up.
    if up.normalize().cross(direction.normalize()).length() < 1e-9 {
        let culprit = f.get("up").or(f.get("direction")).or(f.get("lookAt"));
        let message = "`up` is parallel to the direction of view".to_owned();
        let help = "give an `up` that points elsewhere, e.g. `up 0 0 1`".to_owned();
        return Err(f.error_at(culprit.map_or(word.span(), |field| field.span()), message, "parallel", help));
    }
    let width: u32 = f.value("width")?;
    let projection = (entry.parse)(&f, &CameraPose { center, direction, aim })?;
    let height = match projection {
        ProjectionDescription::Environment => f.optional_value("height").unwrap_or(width.div_ceil(2)),
        ProjectionDescription::Perspective { .. } | ProjectionDescription::Orthographic { .. } => f.value("height")?,
    };
    Ok(CameraDescription { center, aim, up, projection, width, height, motion: Vec::new() })
}

fn parse_perspective_projection(f: &BlockFields<'_>, view: &CameraPose) -> Result<ProjectionDescription, SceneError> {
    Ok(ProjectionDescription::Perspective { angle: f.value("angle")?, lens: parse_lens(f, view)? })
}

fn parse_orthographic_projection(f: &BlockFields<'_>, _: &CameraPose) -> Result<ProjectionDescription, SceneError> {
    Ok(ProjectionDescription::Orthographic { size: f.value("size")? })
}

fn parse_environment_projection(_: &BlockFields<'_>, _: &CameraPose) -> Result<ProjectionDescription, SceneError> {
    Ok(ProjectionDescription::Environment)
}

/// Parses the lens of a camera that looks along `view`; `None` for a pinhole.
fn parse_lens(f: &BlockFields<'_>, view: &CameraPose) -> Result<Option<LensDescription>, SceneError> {
    if f.get("aperture").is_none() && f.get("fNumber").is_none() {
        let rule = "has no effect without `aperture` or `fNumber`";
        f.forbid_fields(&["sensorHeight", "focusDistance", "focusAt", "blades"], rule)?;
        return Ok(None);
    }
    let aperture = f.require_one_field_of(&["aperture", "fNumber"])?;
    let aperture = if aperture.name() == "aperture" {
        f.forbid_fields(&["sensorHeight"], "has no effect without `fNumber`")?;
        ApertureDescription::Radius(aperture.value())
    } else {
        let sensor = f.optional_value("sensorHeight").unwrap_or(DEFAULT_SENSOR_HEIGHT);
        ApertureDescription::FNumber { number: aperture.value(), sensor }
    };
    let focus = if f.get("focusDistance").is_some() || f.get("focusAt").is_some() {
        let focus = f.require_one_field_of(&["focusDistance", "focusAt"])?;
        if focus.name() == "focusDistance" {
            FocusDescription::Distance(focus.value())
        } else {
            let point: DVec3 = focus.value();
            let is_in_front = (point - view.center).dot(view.direction) > 0.0;
            focus.ensure_valid(is_in_front, "must lie in front of the camera")?;
            FocusDescription::Point(point)
        }
    } else {
        match view.aim {
            DirectionOrTarget::LookAt(point) => FocusDescription::Point(point),
            DirectionOrTarget::Direction(_) => FocusDescription::Distance(f.value("focusDistance")?),
        }
    };
    let blades = f.optional_value("blades").unwrap_or(0);
    if let Some(field) = f.get("blades") {
        let is_valid = blades == 0 || (3..=64).contains(&blades);
        field.ensure_valid(is_valid, "must be 0, for a round opening, or lie between 3 and 64")?;
    }
    Ok(Some(LensDescription { aperture, focus, blades }))
}

/// Parses the field `direction` or `lookAt` of a camera or light at the position `center`.
///
/// Returns the field as written, and the direction that results, of any length. `center_name` is
/// the keyword of the field that holds `center`, for error messages.
pub(super) fn parse_direction_or_target(
    f: &BlockFields<'_>,
    center_name: &str,
    center: DVec3,
) -> Result<(DirectionOrTarget, DVec3), SceneError> {
    let field = f.require_one_field_of(&["direction", "lookAt"])?;
    let value: DVec3 = field.value();
    if field.name() == "direction" {
        return Ok((DirectionOrTarget::Direction(value), value));
    }
    let direction = value - center;
    field.ensure_valid(is_normalizable(direction), &format!("must lie at some distance from `{center_name}`"))?;
    Ok((DirectionOrTarget::LookAt(value), direction))
}

/// Writes a camera as scene text, within a `Moving` block if it moves.
pub(super) fn write_camera(out: &mut SceneWriter<'_, '_>, camera: &CameraDescription) -> fmt::Result {
    if !camera.motion.is_empty() {
        out.begin_block("Moving")?;
        write_transform_steps(out, &camera.motion)?;
    }
    out.begin_schema_block(match camera.projection {
        ProjectionDescription::Perspective { .. } => &PERSPECTIVE,
        ProjectionDescription::Orthographic { .. } => &ORTHOGRAPHIC,
        ProjectionDescription::Environment => &ENVIRONMENT,
    })?;
    out.write_vec3("center", camera.center)?;
    write_direction_or_target(out, camera.aim)?;
    out.write_vec3("up", camera.up)?;
    match camera.projection {
        ProjectionDescription::Perspective { angle, lens } => {
            out.write_number("angle", angle)?;
            lens.map_or(Ok(()), |lens| write_lens(out, &lens))?;
        }
        ProjectionDescription::Orthographic { size } => out.write_number("size", size)?,
        ProjectionDescription::Environment => {}
    }
    out.write_field("width", camera.width)?;
    out.write_field("height", camera.height)?;
    if !camera.motion.is_empty() {
        out.end_block()?;
    }
    out.end_block()
}

/// Writes the field `direction` or `lookAt`.
pub(super) fn write_direction_or_target(out: &mut SceneWriter<'_, '_>, aim: DirectionOrTarget) -> fmt::Result {
    match aim {
        DirectionOrTarget::Direction(direction) => out.write_vec3("direction", direction),
        DirectionOrTarget::LookAt(point) => out.write_vec3("lookAt", point),
    }
}

/// Writes the fields of a thin lens.
fn write_lens(out: &mut SceneWriter<'_, '_>, lens: &LensDescription) -> fmt::Result {
    match lens.aperture {
        ApertureDescription::Radius(radius) => out.write_number("aperture", radius)?,
        ApertureDescription::FNumber { number, sensor } => {
            out.write_number("fNumber", number)?;
            out.write_number("sensorHeight", sensor)?;
        }
    }
    match lens.focus {
        FocusDescription::Distance(distance) => out.write_number("focusDistance", distance)?,
        FocusDescription::Point(point) => out.write_vec3("focusAt", point)?,
    }
    out.write_field("blades", lens.blades)
}
