//! The block `EnvironmentLight` of the scene language: light from infinity in all directions.

use super::LightBlock;
use crate::color::Rgb;
use crate::format::error::SceneError;
use crate::format::language::field_table::BlockCodec;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::{Span, Spanned};
use crate::image::PixelMeaning;
use crate::light::EnvironmentLight;
use crate::math::Motion;
use glam::DVec3;
use std::fmt;

/// Radiance of an environment light: constant, or given by a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentRadiance {
    /// Constant radiance in W/(m² sr).
    Constant(DVec3),
    /// Radiance given by an equirectangular picture of all directions.
    Picture {
        /// Path of the picture, as the scene file states it: not empty, without line breaks.
        path: Spanned<String>,
        /// Factor from picture values to radiance in W/(m² sr), at least 0.
        scale: f64,
        /// Right-handed rotation of the picture about the y axis in degrees.
        rotate: f64,
    },
}

impl BlockCodec for EnvironmentRadiance {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let radiance = f.require_one_field_of(&["file", "radiance"])?;
        if radiance.name() == "radiance" {
            f.forbid_fields(&["scale", "rotate"], "has no effect without `file`")?;
            return Ok(Self::Constant(radiance.value()));
        }
        Ok(Self::Picture {
            path: radiance.value(),
            scale: f.value_or_default("scale")?,
            rotate: f.value_or_default("rotate")?,
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        match self {
            Self::Constant(radiance) => out.write_vec3("radiance", *radiance),
            Self::Picture { path, scale, rotate } => {
                out.write_name_field("file", path)?;
                out.write_number("scale", *scale)?;
                out.write_number("rotate", *rotate)
            }
        }
    }
}

impl LightBlock for EnvironmentRadiance {
    const BLOCK: &'static BlockSchema = &block_schema(
        "EnvironmentLight",
        "light from infinity in all directions; at most one per scene, shown instead of the `Background`",
    )
    .with_own_fields(&[
        field_schema("radiance", FieldKind::Color, "constant radiance; give this or `file`").with_unit("W/(m² sr)"),
        field_schema("file", FieldKind::Name, "picture of all directions: PNG, OpenEXR or Radiance HDR"),
        field_schema("scale", FieldKind::Number, "with `file`: factor from picture values to radiance")
            .with_range(FieldRange::NonNegative)
            .with_default_numbers(&[1.0]),
        field_schema("rotate", FieldKind::Number, "with `file`: rotation about the y axis, right-handed")
            .with_default_numbers(&[0.0])
            .with_unit("degrees"),
    ]);
    const IS_INFINITE: bool = true;

    fn add(&self, r: &mut Resolver<'_>, _: &Motion, span: Span) -> Result<(), SceneError> {
        let environment = match self {
            Self::Constant(radiance) => EnvironmentLight::with_constant_radiance(rgb(*radiance))
                .map_err(|e| r.error_at(span, &e.to_string(), "give a radiance that single precision can hold"))?,
            Self::Picture { path, scale, rotate } => {
                let map = r.read_picture(path, PixelMeaning::Color)?;
                EnvironmentLight::new(map, rotate.to_radians(), Rgb::splat(*scale as f32))
                    .map_err(|e| r.file_error(path, &e, "repair the picture, or scale it less"))?
            }
        };
        r.builder.set_environment(environment);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Constant(_) => None,
            Self::Picture { path, .. } => Some(&mut path.value),
        }
    }
}
