//! Cameras in the scene language: description, blocks with their parsing and writing, and
//! conversion to a [`Camera`].

use super::aim::{DirectionOrTarget, parse_direction_or_target, write_direction_or_target};
use super::error::{SceneError, SourceText};
use super::language::fields::{BlockFields, parse_block_by_keyword};
use super::language::lexer::Token;
use super::language::parser::Parser;
use super::language::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, block_keywords, block_schema, field_schema,
};
use super::language::transforms::{parse_moving_block, write_transform_steps};
use super::language::writer::SceneWriter;
use super::line_error::MessageAndRemedy;
use super::span::Spanned;
use super::transform_step::TransformStep;
use crate::camera::{Camera, Lens};
use glam::DVec3;
use std::fmt;

/// A camera as the scene file describes it, with its picture size and motion.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    /// Position of the camera in world space: the pinhole, the lens center, the center of an
    /// orthographic picture, or the viewpoint of a panorama.
    pub center: DVec3,
    /// View direction, or a point to look at.
    pub aim: DirectionOrTarget,
    /// Direction that appears upward in the picture; not parallel to the view.
    pub up: DVec3,
    /// Projection to the picture: perspective, orthographic, or a panorama.
    pub projection: ProjectionDescription,
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Steps of the motion while the shutter is open; empty for a camera at rest. The camera's own
    /// position is the origin of its rotations.
    ///
    /// The first listed step is applied last.
    pub motion: Vec<TransformStep>,
}

/// Projection of a scene to the camera's picture, with the parameters of its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProjectionDescription {
    /// Perspective through a pinhole or a thin lens.
    Perspective {
        /// Vertical field of view in degrees, inside (0, 180).
        vertical_fov_degrees: f64,
        /// Lens; `None` for a pinhole.
        lens: Option<LensDescription>,
    },
    /// Projection along parallel rays, so that size does not depend on distance.
    Orthographic {
        /// Height of the visible region in scene units, above 0.
        view_height: f64,
    },
    /// Equirectangular projection of all directions.
    Panorama,
}

/// A thin lens of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensDescription {
    /// Size of the aperture.
    pub aperture: ApertureDescription,
    /// Position of the plane in focus.
    pub focus: FocusDescription,
    /// Number of diaphragm blades, from 3 to 64; 0 for a round aperture.
    pub blades: u32,
}

/// Size of a lens aperture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApertureDescription {
    /// Lens radius in scene units, at least 0.
    Radius(f64),
    /// The f-number N: focal length f over lens diameter. The sensor height h and the vertical
    /// field of view θ give f = h/(2 tan(θ/2)), so the lens radius is f/(2N).
    FNumber {
        /// The f-number, above 0.
        number: f64,
        /// Height of the sensor in scene units, above 0.
        sensor_height: f64,
    },
}

/// Position of the plane in focus, which is perpendicular to the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusDescription {
    /// Distance of the plane in focus from the lens, along the view, in scene units; above 0.
    Distance(f64),
    /// A point on the plane in focus, in front of the camera.
    Point(DVec3),
}

/// Camera blocks of the scene language, each with the function that converts its fields.
pub(super) static CAMERA_BLOCK_PARSERS: &[BlockParser<ParseProjection>] = &[
    BlockParser { block: &PERSPECTIVE, parse: parse_perspective_projection },
    BlockParser { block: &ORTHOGRAPHIC, parse: parse_orthographic_projection },
    BlockParser { block: &PANORAMA, parse: parse_panorama_projection },
];

/// Function that converts the parsed fields of a camera block to the camera's projection. Its
/// second argument is the camera's position and view direction.
type ParseProjection = fn(&BlockFields<'_>, &CameraPose) -> Result<ProjectionDescription, SceneError>;

/// Position and view direction of a camera.
pub(super) struct CameraPose {
    center: DVec3,
    /// View direction, not normalized.
    direction: DVec3,
    /// The field `direction` or `lookAt`, as the scene text states it.
    aim: DirectionOrTarget,
}

const PICTURE_SIZE_RANGE: FieldRange = FieldRange::ClosedInterval(1.0, 65_536.0);

const VIEW_FIELDS: &[FieldSchema] = &[
    field_schema("center", FieldKind::Point, "the pinhole, the lens center, or the center of an orthographic picture")
        .make_required()
        .mark_as_mit_6837_syntax(),
    field_schema("direction", FieldKind::Direction, "direction of view; give this or `lookAt`")
        .mark_as_mit_6837_syntax(),
    field_schema("lookAt", FieldKind::Point, "point that the camera looks at"),
    field_schema("up", FieldKind::Direction, "direction that appears upward; not parallel to the view")
        .with_default_numbers(&[0.0, 1.0, 0.0])
        .mark_as_mit_6837_syntax(),
];

const PICTURE_SIZE_FIELDS: &[FieldSchema] = &[
    field_schema("width", FieldKind::WholeNumber, "picture width")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_numbers(&[960.0])
        .with_unit("pixels")
        .mark_as_mit_6837_syntax(),
    field_schema("height", FieldKind::WholeNumber, "picture height")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_numbers(&[720.0])
        .with_unit("pixels")
        .mark_as_mit_6837_syntax(),
];

static PERSPECTIVE: BlockSchema = block_schema("PerspectiveCamera", "perspective through a pinhole or a thin lens")
    .with_own_fields(&[
        field_schema("angle", FieldKind::Number, "vertical field of view")
            .with_range(FieldRange::OpenInterval(0.0, 180.0))
            .make_required()
            .with_unit("degrees")
            .mark_as_mit_6837_syntax(),
        field_schema("aperture", FieldKind::Number, "lens radius")
            .with_range(FieldRange::NonNegative)
            .make_optional("0: a pinhole"),
        field_schema("fNumber", FieldKind::Number, "instead of `aperture`: focal length over lens diameter")
            .with_range(FieldRange::Positive),
        field_schema("sensorHeight", FieldKind::Number, "with `fNumber`: sensor height; sets the focal length")
            .with_range(FieldRange::Positive)
            .make_optional("0.024: 24 mm if the unit is the metre"),
        field_schema("focusDistance", FieldKind::Number, "distance along the view of the plane in focus, 10⁻¹² … 10¹²")
            .with_range(FieldRange::Positive)
            .make_optional("none: a lens needs it with `direction` and without `focusAt`"),
        field_schema("focusAt", FieldKind::Point, "instead of `focusDistance`: a point of the plane in focus")
            .make_optional("the point of `lookAt`"),
        field_schema("blades", FieldKind::WholeNumber, "edges of the lens opening, visible in blurred highlights")
            .with_range(FieldRange::DescribedOnly("0 or 3 … 64"))
            .make_optional("0: round"),
    ])
    .with_shared_fields(&[VIEW_FIELDS, PICTURE_SIZE_FIELDS])
    .mark_as_mit_6837_syntax();

static ORTHOGRAPHIC: BlockSchema = block_schema("OrthographicCamera", "parallel projection")
    .with_own_fields(&[field_schema("size", FieldKind::Number, "height of the visible region")
        .with_range(FieldRange::LeftOpenInterval(0.0, 1e12))
        .make_required()])
    .with_shared_fields(&[VIEW_FIELDS, PICTURE_SIZE_FIELDS]);

static PANORAMA: BlockSchema = block_schema(
    "EnvironmentCamera",
    "all directions by longitude and latitude, with the direction of view in the middle",
)
.with_own_fields(&[
    field_schema("width", FieldKind::WholeNumber, "picture width")
        .with_range(PICTURE_SIZE_RANGE)
        .with_default_numbers(&[960.0])
        .with_unit("pixels"),
    field_schema("height", FieldKind::WholeNumber, "picture height")
        .with_range(PICTURE_SIZE_RANGE)
        .make_optional("half of the width")
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
    let allowed = block_keywords(&[], CAMERA_BLOCK_PARSERS);
    let (motion, mut camera) = parse_moving_block(parser, keyword, &allowed, read)?;
    if motion.iter().any(|map| matches!(map, TransformStep::Scale(_) | TransformStep::UniformScale(_))) {
        let message = "a camera cannot grow".to_owned();
        let help = "move it by Translate and Rotate only".to_owned();
        return Err(parser.lexer.error_at(keyword.span(), message, "this motion", help));
    }
    camera.value.motion = motion;
    Ok(camera)
}

/// Parses a camera block. The caller has read its keyword `word`.
pub(super) fn parse_camera<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<CameraDescription, SceneError> {
    let (entry, f) = parse_block_by_keyword(parser, word, CAMERA_BLOCK_PARSERS)?;
    let center = f.value_or_default("center")?;
    let (aim, direction) = parse_direction_or_target(&f, "center", center)?;
    let up: DVec3 = f.value_or_default("up")?;
    // If the sine of the angle between `up` and the view is smaller than this, rounding decides
    // which way is up.
    if up.normalize().cross(direction.normalize()).length() < 1e-9 {
        let culprit = f.get("up").or(f.get("direction")).or(f.get("lookAt"));
        let message = "`up` is parallel to the direction of view".to_owned();
        let help = "give an `up` that points elsewhere, e.g. `up 0 0 1`".to_owned();
        return Err(f.error_at(culprit.map_or(word.span(), |field| field.span()), message, "parallel", help));
    }
    let width: u32 = f.value_or_default("width")?;
    let projection = (entry.parse)(&f, &CameraPose { center, direction, aim })?;
    let height = match projection {
        ProjectionDescription::Panorama => f.optional_value("height").unwrap_or(width.div_ceil(2)),
        ProjectionDescription::Perspective { .. } | ProjectionDescription::Orthographic { .. } => {
            f.value_or_default("height")?
        }
    };
    Ok(CameraDescription { center, aim, up, projection, width, height, motion: Vec::new() })
}

fn parse_perspective_projection(f: &BlockFields<'_>, view: &CameraPose) -> Result<ProjectionDescription, SceneError> {
    Ok(ProjectionDescription::Perspective {
        vertical_fov_degrees: f.value_or_default("angle")?,
        lens: parse_lens(f, view)?,
    })
}

fn parse_orthographic_projection(f: &BlockFields<'_>, _: &CameraPose) -> Result<ProjectionDescription, SceneError> {
    Ok(ProjectionDescription::Orthographic { view_height: f.value_or_default("size")? })
}

fn parse_panorama_projection(_: &BlockFields<'_>, _: &CameraPose) -> Result<ProjectionDescription, SceneError> {
    Ok(ProjectionDescription::Panorama)
}

/// Parses the lens of a camera whose position and view direction are `view`. Returns `None` for a
/// pinhole.
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
        ApertureDescription::FNumber { number: aperture.value(), sensor_height: sensor }
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
            DirectionOrTarget::Target(point) => FocusDescription::Point(point),
            DirectionOrTarget::Direction(_) => FocusDescription::Distance(f.value_or_default("focusDistance")?),
        }
    };
    let blades = f.optional_value("blades").unwrap_or(0);
    if let Some(field) = f.get("blades") {
        let is_valid = blades == 0 || (3..=64).contains(&blades);
        field.ensure_valid(is_valid, "must be 0, for a round opening, or lie between 3 and 64")?;
    }
    Ok(Some(LensDescription { aperture, focus, blades }))
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
        ProjectionDescription::Panorama => &PANORAMA,
    })?;
    out.write_vec3("center", camera.center)?;
    write_direction_or_target(out, camera.aim)?;
    out.write_vec3("up", camera.up)?;
    match camera.projection {
        ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens } => {
            out.write_number("angle", angle)?;
            lens.map_or(Ok(()), |lens| write_lens(out, &lens))?;
        }
        ProjectionDescription::Orthographic { view_height: size } => out.write_number("size", size)?,
        ProjectionDescription::Panorama => {}
    }
    out.write_field("width", camera.width)?;
    out.write_field("height", camera.height)?;
    if !camera.motion.is_empty() {
        out.end_block()?;
    }
    out.end_block()
}

/// Writes the fields of a thin lens.
fn write_lens(out: &mut SceneWriter<'_, '_>, lens: &LensDescription) -> fmt::Result {
    match lens.aperture {
        ApertureDescription::Radius(radius) => out.write_number("aperture", radius)?,
        ApertureDescription::FNumber { number, sensor_height: sensor } => {
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

/// Returns the camera that a scene describes.
///
/// Fails if its field of view or its lens is too extreme for single precision, or if `up` is
/// parallel to the view direction.
pub(super) fn resolve_camera(
    described: &Spanned<CameraDescription>,
    source: &SourceText,
) -> Result<Camera, SceneError> {
    let CameraDescription { center, up, width, height, .. } = described.value;
    let direction = described.aim.direction_from(center);
    let refuse = |(message, help): MessageAndRemedy| {
        SceneError::error_at_span(source, described.span, message, "this camera", help)
    };
    let camera = match described.projection {
        ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens } => {
            check_field_of_view(angle, (width, height)).map_err(refuse)?;
            let camera = Camera::perspective(center, direction, up, angle.to_radians(), width, height);
            match lens {
                Some(lens) => {
                    let lens = resolve_lens(&lens, angle, center, direction);
                    check_lens(&lens).map_err(refuse)?;
                    camera.map(|camera| camera.with_lens(lens))
                }
                None => camera,
            }
        }
        ProjectionDescription::Orthographic { view_height: size } => {
            Camera::orthographic(center, direction, up, size, width, height)
        }
        ProjectionDescription::Panorama => Camera::panorama(center, direction, up, width, height),
    };
    camera.map_err(|e| refuse((e.to_string(), "give another `up`")))
}

/// Greatest rounding error of a unit vector in single precision \[rad]: about 2⁻²⁴.
const MAX_DIRECTION_ERROR: f64 = 1.0 / 16_777_216.0;

/// Greatest tangent of the angle between the view direction and a corner of the picture.
///
/// For a corner with this tangent, the rounding error of a ray direction moves the corner by 1/256
/// of its distance from the picture's center.
const MAX_CORNER_TANGENT: f64 = 65_536.0;

/// Fails if the field of view of a perspective picture is too narrow or too wide for single
/// precision.
///
/// The field of view is too narrow if the angle of a pixel is below [`MAX_DIRECTION_ERROR`]. The
/// field of view is too wide if the tangent at a corner exceeds [`MAX_CORNER_TANGENT`]. `angle` is
/// the vertical field of view in degrees. `width` and `height` are in pixels.
fn check_field_of_view(angle: f64, (width, height): (u32, u32)) -> Result<(), MessageAndRemedy> {
    let (width, height) = (f64::from(width), f64::from(height));
    let pixel = 2.0 * libm::tan(0.5 * angle.to_radians()) / height;
    if pixel < MAX_DIRECTION_ERROR {
        let message =
            format!("the pixels are {pixel:.1e} rad wide, less than the error of directions in single precision");
        return Err((message, "choose a larger `angle` or fewer pixels, or an OrthographicCamera"));
    }
    let corner = 0.5 * pixel * libm::hypot(width, height);
    if corner > MAX_CORNER_TANGENT {
        let message =
            format!("the corners lie {corner:.1e} times as far aside as ahead, which single precision cannot hold");
        return Err((message, "choose a smaller `angle` or a picture less long, or an EnvironmentCamera"));
    }
    Ok(())
}

/// Least focus distance \[length]. Its square is far from underflow in single precision.
const MIN_FOCUS_DISTANCE: f64 = 1e-12;

/// Greatest lens radius and focus distance \[length]. Up to this value, single precision can hold
/// the squares and products of both.
const MAX_RADIUS_OR_FOCUS: f64 = 1e12;

/// Fails unless the lens radius is below 10¹² and the focus distance inside \[10⁻¹², 10¹²).
fn check_lens(lens: &Lens) -> Result<(), MessageAndRemedy> {
    if !(lens.radius < MAX_RADIUS_OR_FOCUS && lens.focus_distance < MAX_RADIUS_OR_FOCUS) {
        let message = "the lens is larger, or focused farther, than single precision can hold";
        return Err((message.to_owned(), "close it, or focus nearer"));
    }
    if lens.focus_distance < MIN_FOCUS_DISTANCE {
        let message = "the lens is focused nearer than single precision can hold";
        return Err((message.to_owned(), "focus at a distance of at least 1e-12"));
    }
    Ok(())
}

/// Converts the description of a camera's lens to the renderer's [`Lens`]. The camera is at
/// `center` and looks along `direction`.
///
/// `angle` is the vertical field of view in degrees, from which the focal length follows.
fn resolve_lens(lens: &LensDescription, angle: f64, center: DVec3, direction: DVec3) -> Lens {
    let radius = match lens.aperture {
        ApertureDescription::Radius(radius) => radius,
        ApertureDescription::FNumber { number, sensor_height: sensor } => {
            let focal_length = 0.5 * sensor / libm::tan(0.5 * angle.to_radians());
            0.5 * focal_length / number
        }
    };
    let focus = match lens.focus {
        FocusDescription::Distance(distance) => distance,
        FocusDescription::Point(point) => (point - center).dot(direction.normalize()),
    };
    Lens { radius, focus_distance: focus, blades: lens.blades }
}
