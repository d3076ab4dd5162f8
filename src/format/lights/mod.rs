//! Lights in the scene language.
//!
//! Each kind of light has a file with its description, its fields, and its conversion to a light
//! of the scene. Most kinds state their fields in a table, which also reads and writes them. The
//! list in this file is the only other place that names the kind.

mod area;
mod delta;
mod directional;
mod environment;
mod goniometric;
mod oriented;
mod point;
mod projector;
mod spot;

pub use area::{AreaLightStrength, DiscLightDescription, RectangleLightDescription, SphereLightDescription};
pub use delta::PointLightStrength;
pub use directional::{DirectionalLightDescription, DirectionalLightStrength};
pub use environment::EnvironmentRadiance;
pub use goniometric::{GoniometricLightDescription, IntensityDistribution};
pub use oriented::LightPose;
pub use point::PointLightDescription;
pub use projector::ProjectorLightDescription;
pub use spot::SpotLightDescription;

use super::error::SceneError;
use super::language::field_table::BlockCodec;
use super::language::fields::{BlockFields, parse_block_by_keyword};
use super::language::lexer::Token;
use super::language::parser::Parser;
use super::language::schema::{BlockParser, BlockSchema, block_keywords};
use super::language::transforms::{parse_moving_block, write_transform_steps};
use super::language::writer::SceneWriter;
use super::resolve::Resolver;
use super::span::{Span, Spanned};
use super::transform_step::TransformStep;
use crate::math::Motion;
use std::fmt;

/// A kind of light in the scene language: the schema of its block, and its conversion to a light of
/// the scene.
trait LightBlock: BlockCodec {
    /// Schema of the block: keyword, fields and help.
    const BLOCK: &'static BlockSchema;

    /// True if lights of this kind are infinitely far away.
    const IS_INFINITE: bool;

    /// Adds the light to the scene. `motion` moves the light while the shutter is open; its
    /// rotations and scales are about the light's own position. An environment light ignores
    /// `motion`. `span` is the position of the block in the scene text, for errors.
    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, span: Span) -> Result<(), SceneError>;

    /// Returns the path of the file that the light reads; `None` if it reads no file.
    fn file_path_mut(&mut self) -> Option<&mut String>;
}

/// Function that converts the parsed fields of a light block to a light.
type ParseLight = fn(&BlockFields<'_>) -> Result<LightDescription, SceneError>;

/// Defines [`LightDescription`] and [`LIGHT_BLOCK_PARSERS`] from a list of all kinds of lights.
/// Each entry states the enum variant and the type that implements [`LightBlock`]. The language
/// reference has the same order as the list.
macro_rules! light_kinds {
    ($($(#[$doc:meta])* $kind:ident($description:ident),)*) => {
        /// A light as the scene file describes it.
        #[derive(Clone, Debug, PartialEq)]
        pub enum LightDescription {
            $($(#[$doc])* $kind($description),)*
            /// A light that moves while the shutter is open.
            Moving {
                /// Steps of the motion. Rotations and scales are about the light's own position.
                ///
                /// The first listed step is applied last.
                steps: Vec<TransformStep>,
                /// The light as it is when the shutter opens.
                light: Box<Spanned<LightDescription>>,
            },
        }

        $(impl From<$description> for LightDescription {
            fn from(light: $description) -> Self {
                Self::$kind(light)
            }
        })*

        /// Light blocks of the scene language, each with the function that converts its fields.
        pub(super) static LIGHT_BLOCK_PARSERS: &[BlockParser<ParseLight>] = &[
            $(BlockParser { block: $description::BLOCK, parse: |f| $description::parse_fields(f).map(Into::into) },)*
        ];

        impl LightDescription {
            /// Returns the path of the file that the light reads, such as a picture; `None` if it
            /// reads no file.
            #[must_use]
            pub fn file_path_mut(&mut self) -> Option<&mut String> {
                match self {
                    $(Self::$kind(light) => light.file_path_mut(),)*
                    Self::Moving { light, .. } => light.value.file_path_mut(),
                }
            }

            /// True if the light is infinitely far away: a directional or environment light.
            #[must_use]
            pub fn is_infinite(&self) -> bool {
                match self {
                    $(Self::$kind(_) => $description::IS_INFINITE,)*
                    Self::Moving { light, .. } => light.value.is_infinite(),
                }
            }
        }

        /// Writes a light as scene text.
        pub(super) fn write_light(out: &mut SceneWriter<'_, '_>, light: &LightDescription) -> fmt::Result {
            match light {
                $(LightDescription::$kind(light) => {
                    out.begin_schema_block($description::BLOCK)?;
                    light.write_fields(out)?;
                })*
                LightDescription::Moving { steps, light } => {
                    out.begin_block("Moving")?;
                    write_transform_steps(out, steps)?;
                    write_light(out, light)?;
                }
            }
            out.end_block()
        }

        /// Adds a described light to the scene. `motion` moves the light while the shutter is open;
        /// its rotations and scales are about the light's own position.
        pub(super) fn add_light(
            r: &mut Resolver<'_>,
            light: &Spanned<LightDescription>,
            motion: &Motion,
        ) -> Result<(), SceneError> {
            match &light.value {
                $(LightDescription::$kind(kind) => kind.add(r, motion, light.span),)*
                LightDescription::Moving { steps, light } => {
                    let motion = motion.preceded_by_factors(steps.iter().map(TransformStep::motion_factor));
                    add_light(r, light, &motion)
                }
            }
        }
    };
}

light_kinds! {
    /// A point light with equal intensity in all directions.
    Point(PointLightDescription),
    /// A directional light: parallel light from infinity.
    Directional(DirectionalLightDescription),
    /// A spotlight: a point light limited to a cone.
    Spot(SpotLightDescription),
    /// A point light that casts a picture.
    Projector(ProjectorLightDescription),
    /// A point light with a measured intensity distribution.
    Goniometric(GoniometricLightDescription),
    /// A sphere that emits outward.
    Sphere(SphereLightDescription),
    /// A disc that emits on the side of its normal.
    Disc(DiscLightDescription),
    /// A parallelogram that emits on one side.
    Rectangle(RectangleLightDescription),
    /// An environment light: radiance that arrives from infinity in all directions. A scene has at
    /// most one.
    Environment(EnvironmentRadiance),
}

impl LightDescription {
    /// Returns `light` itself, or the light inside if `light` is [`LightDescription::Moving`],
    /// however often nested.
    pub(super) fn innermost_light(mut light: &Spanned<Self>) -> &Spanned<Self> {
        while let Self::Moving { light: inner, .. } = &light.value {
            light = inner;
        }
        light
    }
}

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
        &block_keywords(&["numLights", "Moving"], LIGHT_BLOCK_PARSERS),
        |parser, word| {
            if word.text == EnvironmentRadiance::BLOCK.keyword && std::mem::replace(&mut has_environment, true) {
                return Err(parser.repeated_word_error(word));
            }
            lights.push(parse_light(parser, word)?);
            Ok(())
        },
    )?;
    Ok(lights)
}

/// Parses a light, or a `Moving` block that holds a light. The caller has read its keyword `word`.
fn parse_light<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Spanned<LightDescription>, SceneError> {
    if word.text == "Moving" {
        let mut movable = block_keywords(&["Moving"], LIGHT_BLOCK_PARSERS);
        movable.retain(|keyword| *keyword != EnvironmentRadiance::BLOCK.keyword);
        let (steps, light) = parse_moving_block(parser, word, &movable, parse_light)?;
        return Ok(Spanned::new(LightDescription::Moving { steps, light: Box::new(light) }, word.span()));
    }
    let (entry, fields) = parse_block_by_keyword(parser, word, LIGHT_BLOCK_PARSERS)?;
    Ok(Spanned::new((entry.parse)(&fields)?, word.span()))
}
