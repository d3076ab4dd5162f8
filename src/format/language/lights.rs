//! Lights.

use std::fmt;

use super::super::description::{
    AreaLightStrength, DirectionalLightStrength, EnvironmentRadiance, LightDescription, LightPattern,
    PointLightStrength, Spanned,
};
use super::super::error::SceneError;
use super::camera::{aim, write_aim};
use super::fields::{Fields, fields};
use super::lexer::Token;
use super::maps::{moving, write_maps};
use super::reader::Parser;
use super::schema::{Block, Entry, Field, Kind, Range, field, find, keywords};
use super::shapes::{parallelogram, write_parallelogram};
use super::text::has_direction;
use super::writer::Writer;

/// The lights. Lights that cannot move stand last.
pub(super) static LIGHTS: [Entry<ReadLight>; 9] = [
    Entry { block: &POINT, read: point },
    Entry { block: &DIRECTIONAL, read: directional },
    Entry { block: &SPOT, read: spot },
    Entry { block: &PROJECTOR, read: projector },
    Entry { block: &GONIOMETRIC, read: goniometric },
    Entry { block: &SPHERE, read: sphere },
    Entry { block: &DISC, read: disc },
    Entry { block: &RECTANGLE, read: rectangle },
    Entry { block: &ENVIRONMENT, read: environment },
];

/// Reader of the fields of a light.
type ReadLight = fn(&Fields<'_>) -> Result<LightDescription, SceneError>;

/// Number of kinds of light that have a position or direction to move.
const MOVABLE: usize = 8;

static POINT_STRENGTH: [Field; 3] = [
    field(
        "color",
        Kind::Color,
        Range::NonNegative,
        "color of MIT 6.837, without distance falloff; give one of the three",
    )
    .course(),
    field("intensity", Kind::Color, Range::NonNegative, "radiant intensity; on the axis of a spotlight").unit("W/sr"),
    field("power", Kind::Color, Range::NonNegative, "radiant flux").unit("W"),
];

static AREA_STRENGTH: [Field; 2] = [
    field("radiance", Kind::Color, Range::NonNegative, "radiance of the emitting side; give one of both")
        .unit("W/(m² sr)"),
    field("power", Kind::Color, Range::NonNegative, "radiant flux").unit("W"),
];

static POINT: Block = Block {
    keyword: "PointLight",
    aliases: &[],
    fields: &[field("position", Kind::Point, Range::Any, "position").required().course()],
    shared: &[&POINT_STRENGTH],
    help: "point light, equal in all directions",
    course: true,
};

static DIRECTIONAL: Block = Block {
    keyword: "DirectionalLight",
    aliases: &[],
    fields: &[
        field("direction", Kind::Direction, Range::Any, "direction in which the light travels").required().course(),
        field("color", Kind::Color, Range::NonNegative, "color of MIT 6.837; give this or `irradiance`").course(),
        field("irradiance", Kind::Color, Range::NonNegative, "irradiance of a surface that faces the light")
            .unit("W/m²"),
    ],
    shared: &[],
    help: "parallel light from infinity",
    course: true,
};

static SPOT: Block = Block {
    keyword: "SpotLight",
    aliases: &[],
    fields: &[
        field("position", Kind::Point, Range::Any, "apex of the cone").required(),
        field("direction", Kind::Direction, Range::Any, "axis of the cone; give this or `lookAt`"),
        field("lookAt", Kind::Point, Range::Any, "point on the axis of the cone"),
        field("angle", Kind::Number, Range::UpTo(0.0, 360.0), "full opening angle of the cone")
            .required()
            .unit("degrees"),
        field(
            "penumbra",
            Kind::Number,
            Range::Special("≥ 0"),
            "width of the soft rim inside the cone, at most half of `angle`",
        )
        .or(&[0.0])
        .unit("degrees"),
    ],
    shared: &[&POINT_STRENGTH],
    help: "point light limited to a cone",
    course: false,
};

static ORIENTATION: [Field; 4] = [
    field("position", Kind::Point, Range::Any, "position").required(),
    field("direction", Kind::Direction, Range::Any, "axis of the light; give this or `lookAt`"),
    field("lookAt", Kind::Point, Range::Any, "point on the axis of the light"),
    field("up", Kind::Direction, Range::Any, "upper side of the picture")
        .absent("0 1 0, or 0 0 -1 for a vertical axis"),
];

static PATTERN_STRENGTH: [Field; 2] = [
    field("intensity", Kind::Color, Range::NonNegative, "radiant intensity where the picture or profile is 1")
        .unit("W/sr"),
    field(
        "power",
        Kind::Color,
        Range::NonNegative,
        "radiant flux, of white light through the picture; give one of both",
    )
    .unit("W"),
];

static PROJECTOR: Block = Block {
    keyword: "ProjectorLight",
    aliases: &[],
    fields: &[
        field("angle", Kind::Number, Range::Between(0.0, 180.0), "full vertical angle of the picture")
            .required()
            .unit("degrees"),
        field("file", Kind::Name, Range::Any, "projected picture: PNG, OpenEXR or Radiance HDR").required(),
    ],
    shared: &[&ORIENTATION, &PATTERN_STRENGTH],
    help: "pinhole that projects a picture",
    course: false,
};

static GONIOMETRIC: Block = Block {
    keyword: "GoniometricLight",
    aliases: &[],
    fields: &[
        field(
            "file",
            Kind::Name,
            Range::Any,
            "picture of the intensity in all directions, its center along the axis; give this or `profile`",
        ),
        field(
            "profile",
            Kind::Name,
            Range::Any,
            "text file with an angle from the axis in degrees and an intensity per line, in ascending order",
        ),
    ],
    shared: &[&ORIENTATION, &PATTERN_STRENGTH],
    help: "point light with a measured intensity distribution",
    course: false,
};

static SPHERE: Block = Block {
    keyword: "SphereLight",
    aliases: &[],
    fields: &[
        field("center", Kind::Point, Range::Any, "center").required(),
        field("radius", Kind::Number, Range::Positive, "radius").required(),
    ],
    shared: &[&AREA_STRENGTH],
    help: "sphere that emits outward",
    course: false,
};

static DISC: Block = Block {
    keyword: "DiscLight",
    aliases: &[],
    fields: &[
        field("center", Kind::Point, Range::Any, "center").required(),
        field("normal", Kind::Direction, Range::Any, "normal of the emitting side").required(),
        field("radius", Kind::Number, Range::Positive, "radius").required(),
    ],
    shared: &[&AREA_STRENGTH],
    help: "disc that emits on the side of its normal",
    course: false,
};

static RECTANGLE: Block = Block {
    keyword: "RectangleLight",
    aliases: &[],
    fields: &[
        field("corner", Kind::Point, Range::Any, "corner where both edges start").required(),
        field("edge0", Kind::Direction, Range::Any, "vector to the first neighbouring corner").required(),
        field("edge1", Kind::Direction, Range::Any, "vector to the other neighbouring corner").required(),
    ],
    shared: &[&AREA_STRENGTH],
    help: "parallelogram that emits on the side of `edge0` × `edge1`",
    course: false,
};

static ENVIRONMENT: Block = Block {
    keyword: "EnvironmentLight",
    aliases: &[],
    fields: &[
        field("radiance", Kind::Color, Range::NonNegative, "constant radiance; give this or `file`").unit("W/(m² sr)"),
        field("file", Kind::Name, Range::Any, "picture of all directions: PNG, OpenEXR or Radiance HDR"),
        field("scale", Kind::Number, Range::NonNegative, "with `file`: factor from picture values to radiance")
            .absent("1"),
        field("rotate", Kind::Number, Range::Any, "with `file`: rotation about the y axis, right-handed")
            .absent("0")
            .unit("degrees"),
    ],
    shared: &[],
    help: "light from infinity in all directions; at most one a scene, shown instead of the `Background`",
    course: false,
};

/// Reads a `Lights` block.
pub(super) fn lights<'a>(
    parser: &mut Parser<'a>,
    block: Token<'a>,
) -> Result<Vec<Spanned<LightDescription>>, SceneError> {
    let mut lights = Vec::new();
    let mut has_environment = false;
    parser.list(block, ("numLights", "light"), &keywords(&["numLights", "Moving"], &LIGHTS), |parser, word| {
        if word.text == ENVIRONMENT.keyword && std::mem::replace(&mut has_environment, true) {
            return Err(parser.repeated(word));
        }
        lights.push(light(parser, word)?);
        Ok(())
    })?;
    Ok(lights)
}

/// Reads a light that starts with `word`.
fn light<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Spanned<LightDescription>, SceneError> {
    if word.text == "Moving" {
        let movable = keywords(&["Moving"], &LIGHTS[..MOVABLE]);
        let (maps, light) = moving(parser, word, &movable, light)?;
        return Ok(Spanned::new(LightDescription::Moving { maps, light: Box::new(light) }, word.span()));
    }
    let Some(entry) = find(&LIGHTS, word.text) else {
        return Err(parser.unexpected(word, &keywords(&["Moving"], &LIGHTS)));
    };
    let light = (entry.read)(&fields(parser, word, entry.block)?)?;
    Ok(Spanned::new(light, word.span()))
}

fn point(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    Ok(LightDescription::Point { position: f.vector("position")?, strength: point_strength(f)? })
}

fn directional(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    let strength = f.one_of(&["color", "irradiance"])?;
    let value = strength.vector();
    let strength = match strength.name() {
        "color" => DirectionalLightStrength::Color(value),
        _ => DirectionalLightStrength::Irradiance(value),
    };
    Ok(LightDescription::Directional { direction: f.vector("direction")?, strength })
}

fn projector(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    let path = f.require("file")?.text();
    oriented(f, LightPattern::Picture { path, angle: f.number("angle")? })
}

fn goniometric(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    let pattern = f.one_of(&["file", "profile"])?;
    let path = pattern.text();
    let is_map = pattern.name() == "file";
    oriented(f, if is_map { LightPattern::Map(path) } else { LightPattern::Profile(path) })
}

fn sphere(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    Ok(LightDescription::Sphere {
        center: f.vector("center")?,
        radius: f.number("radius")?,
        strength: area_strength(f)?,
    })
}

fn disc(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    Ok(LightDescription::Disc {
        center: f.vector("center")?,
        normal: f.vector("normal")?,
        radius: f.number("radius")?,
        strength: area_strength(f)?,
    })
}

fn rectangle(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    let (corner, edge0, edge1) = parallelogram(f)?;
    Ok(LightDescription::Rectangle { corner, edge0, edge1, strength: area_strength(f)? })
}

/// Returns the spotlight that the fields `f` describe.
fn spot(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    let position = f.vector("position")?;
    let (aim, _) = aim(f, "position", position)?;
    let (angle, penumbra) = (f.number("angle")?, f.number("penumbra")?);
    if let Some(rim) = f.get("penumbra") {
        let ok = (0.0..=angle / 2.0).contains(&penumbra);
        rim.ensure(ok, "must lie between 0 and half of the cone's angle")?;
    }
    Ok(LightDescription::Spot { position, aim, angle, penumbra, strength: point_strength(f)? })
}

/// Returns the oriented point light that the fields `f` describe.
fn oriented(f: &Fields<'_>, pattern: LightPattern) -> Result<LightDescription, SceneError> {
    let position = f.vector("position")?;
    let (aim, direction) = aim(f, "position", position)?;
    let up = f.get("up");
    if let Some(up) = up {
        up.ensure(has_direction(up.vector().cross(direction)), "must not be parallel to the axis of the light")?;
    }
    let up = up.map(|up| up.vector());
    let strength = f.one_of(&["intensity", "power"])?;
    let value = strength.vector();
    let strength = match strength.name() {
        "intensity" => PointLightStrength::Intensity(value),
        _ => PointLightStrength::Power(value),
    };
    Ok(LightDescription::Oriented { position, aim, up, pattern, strength })
}

fn environment(f: &Fields<'_>) -> Result<LightDescription, SceneError> {
    let radiance = f.one_of(&["file", "radiance"])?;
    if radiance.name() == "radiance" {
        f.refuse(&["scale", "rotate"], "has no effect without `file`")?;
        return Ok(LightDescription::Environment(EnvironmentRadiance::Constant(radiance.vector())));
    }
    Ok(LightDescription::Environment(EnvironmentRadiance::Picture {
        path: radiance.text(),
        scale: f.get("scale").map_or(1.0, |s| s.number()),
        rotate: f.get("rotate").map_or(0.0, |r| r.number()),
    }))
}

/// Returns the strength of a point light or spotlight.
fn point_strength(f: &Fields<'_>) -> Result<PointLightStrength, SceneError> {
    let strength = f.one_of(&["color", "intensity", "power"])?;
    Ok(match strength.name() {
        "color" => PointLightStrength::Color(strength.vector()),
        "intensity" => PointLightStrength::Intensity(strength.vector()),
        _ => PointLightStrength::Power(strength.vector()),
    })
}

/// Returns the strength of an area light.
fn area_strength(f: &Fields<'_>) -> Result<AreaLightStrength, SceneError> {
    let strength = f.one_of(&["radiance", "power"])?;
    Ok(match strength.name() {
        "radiance" => AreaLightStrength::Radiance(strength.vector()),
        _ => AreaLightStrength::Power(strength.vector()),
    })
}

/// Prints a light.
pub(super) fn write_light(out: &mut Writer<'_, '_>, light: &LightDescription) -> fmt::Result {
    match light {
        LightDescription::Moving { maps, light } => {
            out.open("Moving")?;
            write_maps(out, maps)?;
            write_light(out, light)?;
        }
        LightDescription::Point { position, strength } => {
            out.start(&POINT)?;
            out.vector("position", *position)?;
            write_point_strength(out, *strength)?;
        }
        LightDescription::Directional { direction, strength } => {
            out.start(&DIRECTIONAL)?;
            out.vector("direction", *direction)?;
            match *strength {
                DirectionalLightStrength::Color(c) => out.vector("color", c)?,
                DirectionalLightStrength::Irradiance(c) => out.vector("irradiance", c)?,
            }
        }
        LightDescription::Spot { position, aim, angle, penumbra, strength } => {
            out.start(&SPOT)?;
            out.vector("position", *position)?;
            write_aim(out, *aim)?;
            out.number("angle", *angle)?;
            out.number("penumbra", *penumbra)?;
            write_point_strength(out, *strength)?;
        }
        LightDescription::Oriented { position, aim, up, pattern, strength } => {
            out.start(if matches!(pattern, LightPattern::Picture { .. }) { &PROJECTOR } else { &GONIOMETRIC })?;
            out.vector("position", *position)?;
            write_aim(out, *aim)?;
            if let Some(up) = up {
                out.vector("up", *up)?;
            }
            match pattern {
                LightPattern::Picture { path, angle } => {
                    out.number("angle", *angle)?;
                    out.name("file", path)?;
                }
                LightPattern::Map(path) => out.name("file", path)?,
                LightPattern::Profile(path) => out.name("profile", path)?,
            }
            write_point_strength(out, *strength)?;
        }
        LightDescription::Sphere { center, radius, strength } => {
            out.start(&SPHERE)?;
            out.vector("center", *center)?;
            out.number("radius", *radius)?;
            write_area_strength(out, *strength)?;
        }
        LightDescription::Disc { center, normal, radius, strength } => {
            out.start(&DISC)?;
            out.vector("center", *center)?;
            out.vector("normal", *normal)?;
            out.number("radius", *radius)?;
            write_area_strength(out, *strength)?;
        }
        LightDescription::Rectangle { corner, edge0, edge1, strength } => {
            out.start(&RECTANGLE)?;
            write_parallelogram(out, *corner, *edge0, *edge1)?;
            write_area_strength(out, *strength)?;
        }
        LightDescription::Environment(radiance) => {
            out.start(&ENVIRONMENT)?;
            match radiance {
                EnvironmentRadiance::Constant(radiance) => out.vector("radiance", *radiance)?,
                EnvironmentRadiance::Picture { path, scale, rotate } => {
                    out.name("file", path)?;
                    out.number("scale", *scale)?;
                    out.number("rotate", *rotate)?;
                }
            }
        }
    }
    out.close()
}

fn write_point_strength(out: &mut Writer<'_, '_>, strength: PointLightStrength) -> fmt::Result {
    match strength {
        PointLightStrength::Color(c) => out.vector("color", c),
        PointLightStrength::Intensity(c) => out.vector("intensity", c),
        PointLightStrength::Power(c) => out.vector("power", c),
    }
}

fn write_area_strength(out: &mut Writer<'_, '_>, strength: AreaLightStrength) -> fmt::Result {
    match strength {
        AreaLightStrength::Radiance(c) => out.vector("radiance", c),
        AreaLightStrength::Power(c) => out.vector("power", c),
    }
}
