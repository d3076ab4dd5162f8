//! Schemas, parsing and writing of light blocks.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    AreaLightStrength, DirectionalLightStrength, EnvironmentRadiance, LightDescription, LightPattern,
    PointLightStrength, Spanned,
};
use super::super::error::SceneError;
use super::camera::{parse_direction_or_target, write_direction_or_target};
use super::fields::{BlockFields, parse_block_by_keyword};
use super::lexer::Token;
use super::parser::Parser;
use super::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, block_keywords, block_schema, field_schema,
};
use super::shapes::{parse_parallelogram, write_parallelogram};
use super::text::is_normalizable;
use super::transforms::{parse_moving_block, write_transform_steps};
use super::writer::SceneWriter;

/// Light blocks of the scene language, each with the function that converts its fields.
pub(super) static LIGHTS: &[BlockParser<ParseLight>] = &[
    BlockParser { block: &POINT, parse: parse_point_light },
    BlockParser { block: &DIRECTIONAL, parse: parse_directional_light },
    BlockParser { block: &SPOT, parse: parse_spot_light },
    BlockParser { block: &PROJECTOR, parse: parse_projector_light },
    BlockParser { block: &GONIOMETRIC, parse: parse_goniometric_light },
    BlockParser { block: &SPHERE, parse: parse_sphere_light },
    BlockParser { block: &DISC, parse: parse_disc_light },
    BlockParser { block: &RECTANGLE, parse: parse_rectangle_light },
    BlockParser { block: &ENVIRONMENT, parse: parse_environment_light },
];

/// Function that converts the parsed fields of a light block to a light.
type ParseLight = fn(&BlockFields<'_>) -> Result<LightDescription, SceneError>;

static POINT_STRENGTH_FIELDS: &[FieldSchema] = &[
    field_schema(
        "color",
        FieldKind::Color,
        "color of MIT course 6.837, without distance falloff; give one of the three",
    )
    .mark_as_course_syntax(),
    field_schema("intensity", FieldKind::Color, "radiant intensity; on the axis of a spotlight").with_unit("W/sr"),
    field_schema("power", FieldKind::Color, "radiant flux").with_unit("W"),
];

static AREA_STRENGTH_FIELDS: &[FieldSchema] = &[
    field_schema("radiance", FieldKind::Color, "radiance of the emitting side; give one of the two")
        .with_unit("W/(m² sr)"),
    field_schema("power", FieldKind::Color, "radiant flux").with_unit("W"),
];

static POINT: BlockSchema = block_schema("PointLight", "point light, equal in all directions")
    .with_fields(&[field_schema("position", FieldKind::Point, "position").make_required().mark_as_course_syntax()])
    .with_shared_fields(&[POINT_STRENGTH_FIELDS])
    .mark_as_course_syntax();

static DIRECTIONAL: BlockSchema = block_schema("DirectionalLight", "parallel light from infinity")
    .with_fields(&[
        field_schema("direction", FieldKind::Direction, "direction in which the light travels")
            .make_required()
            .mark_as_course_syntax(),
        field_schema("color", FieldKind::Color, "color of MIT course 6.837; give this or `irradiance`")
            .mark_as_course_syntax(),
        field_schema("irradiance", FieldKind::Color, "irradiance of a surface that faces the light").with_unit("W/m²"),
    ])
    .mark_as_course_syntax();

static SPOT: BlockSchema = block_schema("SpotLight", "point light limited to a cone")
    .with_fields(&[
        field_schema("position", FieldKind::Point, "apex of the cone").make_required(),
        field_schema("direction", FieldKind::Direction, "axis of the cone; give this or `lookAt`"),
        field_schema("lookAt", FieldKind::Point, "point on the axis of the cone"),
        field_schema("angle", FieldKind::Number, "full opening angle of the cone")
            .with_range(FieldRange::UpTo(0.0, 360.0))
            .make_required()
            .with_unit("degrees"),
        field_schema("penumbra", FieldKind::Number, "width of the soft rim inside the cone, at most half of `angle`")
            .with_range(FieldRange::Special("≥ 0"))
            .with_default_numbers(&[0.0])
            .with_unit("degrees"),
    ])
    .with_shared_fields(&[POINT_STRENGTH_FIELDS]);

static ORIENTATION_FIELDS: &[FieldSchema] = &[
    field_schema("position", FieldKind::Point, "position").make_required(),
    field_schema("direction", FieldKind::Direction, "axis of the light; give this or `lookAt`"),
    field_schema("lookAt", FieldKind::Point, "point on the axis of the light"),
    field_schema("up", FieldKind::Direction, "upper side of the picture")
        .with_default_description("0 1 0, or 0 0 -1 for a vertical axis"),
];

static PATTERN_STRENGTH_FIELDS: &[FieldSchema] = &[
    field_schema("intensity", FieldKind::Color, "radiant intensity where the picture or profile is 1")
        .with_unit("W/sr"),
    field_schema("power", FieldKind::Color, "radiant flux, of white light through the picture; give one of the two")
        .with_unit("W"),
];

static PROJECTOR: BlockSchema = block_schema("ProjectorLight", "pinhole that projects a picture")
    .with_fields(&[
        field_schema("angle", FieldKind::Number, "full vertical angle of the picture")
            .with_range(FieldRange::Between(0.0, 180.0))
            .make_required()
            .with_unit("degrees"),
        field_schema("file", FieldKind::Name, "projected picture: PNG, OpenEXR or Radiance HDR").make_required(),
    ])
    .with_shared_fields(&[ORIENTATION_FIELDS, PATTERN_STRENGTH_FIELDS]);

static GONIOMETRIC: BlockSchema =
    block_schema("GoniometricLight", "point light with a measured intensity distribution")
        .with_fields(&[
            field_schema(
                "file",
                FieldKind::Name,
                "picture of the intensity in all directions, its center along the axis; give this or `profile`",
            ),
            field_schema(
                "profile",
                FieldKind::Name,
                "text file with an angle from the axis in degrees and an intensity per line, in ascending order",
            ),
        ])
        .with_shared_fields(&[ORIENTATION_FIELDS, PATTERN_STRENGTH_FIELDS]);

static SPHERE: BlockSchema = block_schema("SphereLight", "sphere that emits outward")
    .with_fields(&[
        field_schema("center", FieldKind::Point, "center").make_required(),
        field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    ])
    .with_shared_fields(&[AREA_STRENGTH_FIELDS]);

static DISC: BlockSchema = block_schema("DiscLight", "disc that emits on the side of its normal")
    .with_fields(&[
        field_schema("center", FieldKind::Point, "center").make_required(),
        field_schema("normal", FieldKind::Direction, "normal of the emitting side").make_required(),
        field_schema("radius", FieldKind::Number, "radius").with_range(FieldRange::Positive).make_required(),
    ])
    .with_shared_fields(&[AREA_STRENGTH_FIELDS]);

static RECTANGLE: BlockSchema =
    block_schema("RectangleLight", "parallelogram that emits on the side of `edge0` × `edge1`")
        .with_fields(&[
            field_schema("corner", FieldKind::Point, "corner where both edges start").make_required(),
            field_schema("edge0", FieldKind::Direction, "vector to the first neighbouring corner").make_required(),
            field_schema("edge1", FieldKind::Direction, "vector to the other neighbouring corner").make_required(),
        ])
        .with_shared_fields(&[AREA_STRENGTH_FIELDS]);

static ENVIRONMENT: BlockSchema = block_schema(
    "EnvironmentLight",
    "light from infinity in all directions; at most one per scene, shown instead of the `Background`",
)
.with_fields(&[
    field_schema("radiance", FieldKind::Color, "constant radiance; give this or `file`").with_unit("W/(m² sr)"),
    field_schema("file", FieldKind::Name, "picture of all directions: PNG, OpenEXR or Radiance HDR"),
    field_schema("scale", FieldKind::Number, "with `file`: factor from picture values to radiance")
        .with_range(FieldRange::NonNegative)
        .with_default_numbers(&[1.0]),
    field_schema("rotate", FieldKind::Number, "with `file`: rotation about the y axis, right-handed")
        .with_default_numbers(&[0.0])
        .with_unit("degrees"),
]);

/// Parses a `Lights` block, which holds at most one `EnvironmentLight`.
pub(super) fn parse_lights_block<'a>(
    parser: &mut Parser<'a>,
    block: Token<'a>,
) -> Result<Vec<Spanned<LightDescription>>, SceneError> {
    let mut lights = Vec::new();
    let mut has_environment = false;
    parser.parse_list_block(
        block,
        ("numLights", "light"),
        &block_keywords(&["numLights", "Moving"], LIGHTS),
        |parser, word| {
            if word.text == ENVIRONMENT.keyword && std::mem::replace(&mut has_environment, true) {
                return Err(parser.repeated_word_error(word));
            }
            lights.push(parse_light(parser, word)?);
            Ok(())
        },
    )?;
    Ok(lights)
}

/// Parses a light, or a `Moving` block that holds a light. Its keyword `word` has been read.
fn parse_light<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Spanned<LightDescription>, SceneError> {
    if word.text == "Moving" {
        let mut movable = block_keywords(&["Moving"], LIGHTS);
        movable.retain(|keyword| *keyword != ENVIRONMENT.keyword);
        let (steps, light) = parse_moving_block(parser, word, &movable, parse_light)?;
        return Ok(Spanned::new(LightDescription::Moving { steps, light: Box::new(light) }, word.span()));
    }
    let (entry, fields) = parse_block_by_keyword(parser, word, LIGHTS)?;
    Ok(Spanned::new((entry.parse)(&fields)?, word.span()))
}

fn parse_point_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    Ok(LightDescription::Point { position: f.value("position")?, strength: parse_point_strength(f)? })
}

fn parse_directional_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    let strength = f.require_color_variant(&[
        ("color", DirectionalLightStrength::Color),
        ("irradiance", DirectionalLightStrength::Irradiance),
    ])?;
    Ok(LightDescription::Directional { direction: f.value("direction")?, strength })
}

fn parse_projector_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    let path = f.value("file")?;
    parse_oriented_light(f, LightPattern::Picture { path, angle: f.value("angle")? })
}

fn parse_goniometric_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    let pattern = f.require_one_field_of(&["file", "profile"])?;
    let path = pattern.value();
    let is_map = pattern.name() == "file";
    parse_oriented_light(f, if is_map { LightPattern::Map(path) } else { LightPattern::Profile(path) })
}

fn parse_sphere_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    Ok(LightDescription::Sphere {
        center: f.value("center")?,
        radius: f.value("radius")?,
        strength: parse_area_strength(f)?,
    })
}

fn parse_disc_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    Ok(LightDescription::Disc {
        center: f.value("center")?,
        normal: f.value("normal")?,
        radius: f.value("radius")?,
        strength: parse_area_strength(f)?,
    })
}

fn parse_rectangle_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    let (corner, edge0, edge1) = parse_parallelogram(f)?;
    Ok(LightDescription::Rectangle { corner, edge0, edge1, strength: parse_area_strength(f)? })
}

fn parse_spot_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    let position = f.value("position")?;
    let (aim, _) = parse_direction_or_target(f, "position", position)?;
    let (angle, penumbra) = (f.value("angle")?, f.value("penumbra")?);
    if let Some(field) = f.get("penumbra") {
        let is_valid = (0.0..=angle / 2.0).contains(&penumbra);
        field.ensure_valid(is_valid, "must lie between 0 and half of the cone's angle")?;
    }
    Ok(LightDescription::Spot { position, aim, angle, penumbra, strength: parse_point_strength(f)? })
}

/// Returns a projector or goniometric light with this `pattern` and the other fields of the block.
fn parse_oriented_light(f: &BlockFields<'_>, pattern: LightPattern) -> Result<LightDescription, SceneError> {
    let position = f.value("position")?;
    let (aim, direction) = parse_direction_or_target(f, "position", position)?;
    let up: Option<DVec3> = f.optional_value("up");
    if let (Some(field), Some(up)) = (f.get("up"), up) {
        field.ensure_valid(is_normalizable(up.cross(direction)), "must not be parallel to the axis of the light")?;
    }
    let strength =
        f.require_color_variant(&[("intensity", PointLightStrength::Intensity), ("power", PointLightStrength::Power)])?;
    Ok(LightDescription::Oriented { position, aim, up, pattern, strength })
}

fn parse_environment_light(f: &BlockFields<'_>) -> Result<LightDescription, SceneError> {
    let radiance = f.require_one_field_of(&["file", "radiance"])?;
    if radiance.name() == "radiance" {
        f.forbid_fields(&["scale", "rotate"], "has no effect without `file`")?;
        return Ok(LightDescription::Environment(EnvironmentRadiance::Constant(radiance.value())));
    }
    let (path, scale, rotate) = (radiance.value(), f.value("scale")?, f.value("rotate")?);
    Ok(LightDescription::Environment(EnvironmentRadiance::Picture { path, scale, rotate }))
}

/// Parses the strength of a point light or spotlight.
fn parse_point_strength(f: &BlockFields<'_>) -> Result<PointLightStrength, SceneError> {
    f.require_color_variant(&[
        ("color", PointLightStrength::Color),
        ("intensity", PointLightStrength::Intensity),
        ("power", PointLightStrength::Power),
    ])
}

fn parse_area_strength(f: &BlockFields<'_>) -> Result<AreaLightStrength, SceneError> {
    f.require_color_variant(&[("radiance", AreaLightStrength::Radiance), ("power", AreaLightStrength::Power)])
}

/// Writes a light as scene text.
pub(super) fn write_light(out: &mut SceneWriter<'_, '_>, light: &LightDescription) -> fmt::Result {
    match light {
        LightDescription::Moving { steps, light } => {
            out.begin_block("Moving")?;
            write_transform_steps(out, steps)?;
            write_light(out, light)?;
        }
        LightDescription::Point { position, strength } => {
            out.begin_schema_block(&POINT)?;
            out.write_vec3("position", *position)?;
            write_point_strength(out, *strength)?;
        }
        LightDescription::Directional { direction, strength } => {
            out.begin_schema_block(&DIRECTIONAL)?;
            out.write_vec3("direction", *direction)?;
            match *strength {
                DirectionalLightStrength::Color(c) => out.write_vec3("color", c)?,
                DirectionalLightStrength::Irradiance(c) => out.write_vec3("irradiance", c)?,
            }
        }
        LightDescription::Spot { position, aim, angle, penumbra, strength } => {
            out.begin_schema_block(&SPOT)?;
            out.write_vec3("position", *position)?;
            write_direction_or_target(out, *aim)?;
            out.write_number("angle", *angle)?;
            out.write_number("penumbra", *penumbra)?;
            write_point_strength(out, *strength)?;
        }
        LightDescription::Oriented { position, aim, up, pattern, strength } => {
            out.begin_schema_block(match pattern {
                LightPattern::Picture { .. } => &PROJECTOR,
                LightPattern::Map(_) | LightPattern::Profile(_) => &GONIOMETRIC,
            })?;
            out.write_vec3("position", *position)?;
            write_direction_or_target(out, *aim)?;
            if let Some(up) = up {
                out.write_vec3("up", *up)?;
            }
            match pattern {
                LightPattern::Picture { path, angle } => {
                    out.write_number("angle", *angle)?;
                    out.write_name("file", path)?;
                }
                LightPattern::Map(path) => out.write_name("file", path)?,
                LightPattern::Profile(path) => out.write_name("profile", path)?,
            }
            write_point_strength(out, *strength)?;
        }
        LightDescription::Sphere { center, radius, strength } => {
            out.begin_schema_block(&SPHERE)?;
            out.write_vec3("center", *center)?;
            out.write_number("radius", *radius)?;
            write_area_strength(out, *strength)?;
        }
        LightDescription::Disc { center, normal, radius, strength } => {
            out.begin_schema_block(&DISC)?;
            out.write_vec3("center", *center)?;
            out.write_vec3("normal", *normal)?;
            out.write_number("radius", *radius)?;
            write_area_strength(out, *strength)?;
        }
        LightDescription::Rectangle { corner, edge0, edge1, strength } => {
            out.begin_schema_block(&RECTANGLE)?;
            write_parallelogram(out, *corner, *edge0, *edge1)?;
            write_area_strength(out, *strength)?;
        }
        LightDescription::Environment(radiance) => {
            out.begin_schema_block(&ENVIRONMENT)?;
            match radiance {
                EnvironmentRadiance::Constant(radiance) => out.write_vec3("radiance", *radiance)?,
                EnvironmentRadiance::Picture { path, scale, rotate } => {
                    out.write_name("file", path)?;
                    out.write_number("scale", *scale)?;
                    out.write_number("rotate", *rotate)?;
                }
            }
        }
    }
    out.end_block()
}

fn write_point_strength(out: &mut SceneWriter<'_, '_>, strength: PointLightStrength) -> fmt::Result {
    match strength {
        PointLightStrength::Color(c) => out.write_vec3("color", c),
        PointLightStrength::Intensity(c) => out.write_vec3("intensity", c),
        PointLightStrength::Power(c) => out.write_vec3("power", c),
    }
}

fn write_area_strength(out: &mut SceneWriter<'_, '_>, strength: AreaLightStrength) -> fmt::Result {
    match strength {
        AreaLightStrength::Radiance(c) => out.write_vec3("radiance", c),
        AreaLightStrength::Power(c) => out.write_vec3("power", c),
    }
}
