//! Cameras, and the aim of cameras and spotlights.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    ApertureDescription, CameraDescription, DirectionOrTarget, FocusDescription, LensDescription,
    ProjectionDescription, Spanned, TransformStep,
};
use super::super::error::SceneError;
use super::fields::{Fields, fields};
use super::lexer::Token;
use super::maps::{moving, write_maps};
use super::reader::Parser;
use super::schema::{Block, Entry, Field, Kind, Range, field, find, keywords};
use super::text::has_direction;
use super::writer::Writer;

/// The cameras.
pub(super) static CAMERAS: [Entry<ReadCamera>; 3] = [
    Entry { block: &PERSPECTIVE, read: perspective },
    Entry { block: &ORTHOGRAPHIC, read: orthographic },
    Entry { block: &ENVIRONMENT, read: environment },
];

/// Reader of a camera with this view: its projection and the height of its picture \[pixels].
type ReadCamera = fn(&Fields<'_>, &View) -> Result<(ProjectionDescription, u32), SceneError>;

/// Position and direction of a camera.
pub(super) struct View {
    center: DVec3,
    direction: DVec3,
    aim: DirectionOrTarget,
}

const PIXELS: Range = Range::Within(1.0, 65_536.0);

static VIEW: [Field; 4] = [
    field("center", Kind::Point, Range::Any, "the pinhole, the lens center, or the center of an orthographic picture")
        .required()
        .course(),
    field("direction", Kind::Direction, Range::Any, "direction of view; give this or `lookAt`").course(),
    field("lookAt", Kind::Point, Range::Any, "point that the camera looks at"),
    field("up", Kind::Direction, Range::Any, "direction that appears upward; not parallel to the view")
        .or(&[0.0, 1.0, 0.0])
        .course(),
];

static SIZE: [Field; 2] = [
    field("width", Kind::Whole, PIXELS, "picture width").or(&[960.0]).unit("pixels").course(),
    field("height", Kind::Whole, PIXELS, "picture height").or(&[720.0]).unit("pixels").course(),
];

static PERSPECTIVE: Block = Block {
    keyword: "PerspectiveCamera",
    aliases: &[],
    fields: &[
        field("angle", Kind::Number, Range::Between(0.0, 180.0), "vertical field of view")
            .required()
            .unit("degrees")
            .course(),
        field("aperture", Kind::Number, Range::NonNegative, "lens radius").absent("0: a pinhole"),
        field("fNumber", Kind::Number, Range::Positive, "instead of `aperture`: focal length over lens diameter"),
        field("sensorHeight", Kind::Number, Range::Positive, "with `fNumber`: sensor height; sets the focal length")
            .absent("0.024: 24 mm if the unit is the metre"),
        field(
            "focusDistance",
            Kind::Number,
            Range::Positive,
            "distance along the view of the plane in focus, 10⁻¹² … 10¹²",
        ),
        field("focusAt", Kind::Point, Range::Any, "instead of `focusDistance`: a point of the plane in focus")
            .absent("the point of `lookAt`"),
        field(
            "blades",
            Kind::Whole,
            Range::Special("0 or 3 … 64"),
            "edges of the lens opening, visible in blurred highlights",
        )
        .absent("0: round"),
    ],
    shared: &[&VIEW, &SIZE],
    help: "perspective through a pinhole or a thin lens",
    course: true,
};

static ORTHOGRAPHIC: Block = Block {
    keyword: "OrthographicCamera",
    aliases: &[],
    fields: &[field("size", Kind::Number, Range::UpTo(0.0, 1e12), "height of the visible region").required()],
    shared: &[&VIEW, &SIZE],
    help: "parallel projection",
    course: false,
};

static ENVIRONMENT: Block = Block {
    keyword: "EnvironmentCamera",
    aliases: &[],
    fields: &[
        field("width", Kind::Whole, PIXELS, "picture width").or(&[960.0]).unit("pixels"),
        field("height", Kind::Whole, PIXELS, "picture height").absent("half of the width").unit("pixels"),
    ],
    shared: &[&VIEW],
    help: "all directions by longitude and latitude, with the direction of view in the middle",
    course: false,
};

/// Height of a sensor of 36 × 24 mm, if the unit is the metre.
const SENSOR_HEIGHT: f64 = 0.024;

/// Reads a `Moving` block with a camera.
pub(super) fn moving_camera<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
) -> Result<Spanned<CameraDescription>, SceneError> {
    let read = |parser: &mut Parser<'a>, word: Token<'a>| Ok(Spanned::new(camera(parser, word)?, word.span()));
    let allowed = keywords(&[], &CAMERAS);
    let (motion, mut camera) = moving(parser, keyword, &allowed, read)?;
    if motion.iter().any(|map| matches!(map, TransformStep::Scale(_) | TransformStep::UniformScale(_))) {
        let message = "a camera cannot grow".to_owned();
        let help = "move it by Translate and Rotate only".to_owned();
        return Err(parser.lexer.error(keyword.span(), message, "this motion", help));
    }
    camera.value.motion = motion;
    Ok(camera)
}

/// Reads a camera block.
pub(super) fn camera<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<CameraDescription, SceneError> {
    let Some(entry) = find(&CAMERAS, word.text) else {
        return Err(parser.unexpected(word, &keywords(&[], &CAMERAS)));
    };
    let f = fields(parser, word, entry.block)?;
    let center = f.vector("center")?;
    let (aim, direction) = aim(&f, "center", center)?;
    let up = f.vector("up")?;
    // Below this sine of their angle, rounding decides which way is up.
    if up.normalize().cross(direction.normalize()).length() < 1e-9 {
        let culprit = f.get("up").or(f.get("direction")).or(f.get("lookAt"));
        let message = "`up` is parallel to the direction of view".to_owned();
        let help = "give an `up` that points elsewhere, e.g. `up 0 0 1`".to_owned();
        return Err(f.error(culprit.map_or(word.span(), |p| p.span()), message, "parallel", help));
    }
    let width = f.whole("width")?;
    let (projection, height) = (entry.read)(&f, &View { center, direction, aim })?;
    Ok(CameraDescription { center, aim, up, projection, width, height, motion: Vec::new() })
}

fn perspective(f: &Fields<'_>, view: &View) -> Result<(ProjectionDescription, u32), SceneError> {
    let angle = f.number("angle")?;
    let lens = lens(f, view.center, view.direction, view.aim)?;
    Ok((ProjectionDescription::Perspective { angle, lens }, f.whole("height")?))
}

fn orthographic(f: &Fields<'_>, _: &View) -> Result<(ProjectionDescription, u32), SceneError> {
    Ok((ProjectionDescription::Orthographic { size: f.number("size")? }, f.whole("height")?))
}

fn environment(f: &Fields<'_>, _: &View) -> Result<(ProjectionDescription, u32), SceneError> {
    let half = f.whole("width")?.div_ceil(2);
    Ok((ProjectionDescription::Environment, f.get("height").map_or(half, |height| height.number() as u32)))
}

/// Returns the lens of a camera at `center` with that direction of view; `None` for a pinhole.
fn lens(
    f: &Fields<'_>,
    center: DVec3,
    direction: DVec3,
    aim: DirectionOrTarget,
) -> Result<Option<LensDescription>, SceneError> {
    if f.get("aperture").is_none() && f.get("fNumber").is_none() {
        let rule = "has no effect without `aperture` or `fNumber`";
        f.refuse(&["sensorHeight", "focusDistance", "focusAt", "blades"], rule)?;
        return Ok(None);
    }
    let opening = f.one_of(&["aperture", "fNumber"])?;
    let opening = if opening.name() == "aperture" {
        f.refuse(&["sensorHeight"], "has no effect without `fNumber`")?;
        ApertureDescription::Radius(opening.number())
    } else {
        let sensor = f.get("sensorHeight").map_or(SENSOR_HEIGHT, |sensor| sensor.number());
        ApertureDescription::FNumber { number: opening.number(), sensor }
    };
    let focus = match (f.get("focusDistance").or(f.get("focusAt")), aim) {
        (Some(_), _) => {
            let focus = f.one_of(&["focusDistance", "focusAt"])?;
            if focus.name() == "focusDistance" {
                FocusDescription::Distance(focus.number())
            } else {
                let in_front = (focus.vector() - center).dot(direction) > 0.0;
                focus.ensure(in_front, "must lie in front of the camera")?;
                FocusDescription::Point(focus.vector())
            }
        }
        (None, DirectionOrTarget::LookAt(point)) => FocusDescription::Point(point),
        (None, DirectionOrTarget::Direction(_)) => FocusDescription::Distance(f.require("focusDistance")?.number()),
    };
    let blades = match f.get("blades") {
        None => 0,
        Some(blades) => {
            let n = blades.number();
            let ok = n == 0.0 || (3.0..=64.0).contains(&n);
            blades.ensure(ok, "must be 0, for a round opening, or lie between 3 and 64")?;
            n as u32
        }
    };
    Ok(Some(LensDescription { opening, focus, blades }))
}

/// Returns `direction` or `lookAt`, and the direction from `center`, which is the value of the
/// field `from`.
pub(super) fn aim(f: &Fields<'_>, from: &str, center: DVec3) -> Result<(DirectionOrTarget, DVec3), SceneError> {
    let aim = f.one_of(&["direction", "lookAt"])?;
    if aim.name() == "direction" {
        return Ok((DirectionOrTarget::Direction(aim.vector()), aim.vector()));
    }
    let direction = aim.vector() - center;
    aim.ensure(has_direction(direction), &format!("must lie at some distance from `{from}`"))?;
    Ok((DirectionOrTarget::LookAt(aim.vector()), direction))
}

/// Prints a camera.
pub(super) fn write_camera(out: &mut Writer<'_, '_>, camera: &CameraDescription) -> fmt::Result {
    if !camera.motion.is_empty() {
        out.open("Moving")?;
        write_maps(out, &camera.motion)?;
    }
    out.start(match camera.projection {
        ProjectionDescription::Perspective { .. } => &PERSPECTIVE,
        ProjectionDescription::Orthographic { .. } => &ORTHOGRAPHIC,
        ProjectionDescription::Environment => &ENVIRONMENT,
    })?;
    out.vector("center", camera.center)?;
    write_aim(out, camera.aim)?;
    out.vector("up", camera.up)?;
    match camera.projection {
        ProjectionDescription::Perspective { angle, lens } => {
            out.number("angle", angle)?;
            lens.map_or(Ok(()), |lens| write_lens(out, &lens))?;
        }
        ProjectionDescription::Orthographic { size } => out.number("size", size)?,
        ProjectionDescription::Environment => {}
    }
    out.field("width", camera.width)?;
    out.field("height", camera.height)?;
    if !camera.motion.is_empty() {
        out.close()?;
    }
    out.close()
}

/// Prints a direction of view or its target.
pub(super) fn write_aim(out: &mut Writer<'_, '_>, aim: DirectionOrTarget) -> fmt::Result {
    match aim {
        DirectionOrTarget::Direction(direction) => out.vector("direction", direction),
        DirectionOrTarget::LookAt(point) => out.vector("lookAt", point),
    }
}

/// Prints the fields of a lens.
fn write_lens(out: &mut Writer<'_, '_>, lens: &LensDescription) -> fmt::Result {
    match lens.opening {
        ApertureDescription::Radius(radius) => out.number("aperture", radius)?,
        ApertureDescription::FNumber { number, sensor } => {
            out.number("fNumber", number)?;
            out.number("sensorHeight", sensor)?;
        }
    }
    match lens.focus {
        FocusDescription::Distance(distance) => out.number("focusDistance", distance)?,
        FocusDescription::Point(point) => out.vector("focusAt", point)?,
    }
    out.field("blades", lens.blades)
}
