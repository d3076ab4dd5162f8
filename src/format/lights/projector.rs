//! The block `ProjectorLight` of the scene language: a point light that casts a picture.

use super::LightBlock;
use super::delta::{PATTERN_STRENGTH, PointLightStrength, add_delta_light};
use super::oriented::{LightPose, POSE_FIELDS};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldEntry};
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::span::{Span, Spanned};
use crate::image::PixelMeaning;
use crate::light::{IntensityPattern, OrientedPointLight, ProjectedPicture};
use crate::math::Motion;
use crate::scene::UnscaledDeltaLight;
use std::fmt;
use std::sync::Arc;

/// A point light that casts a picture like a slide projector.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectorLightDescription {
    /// Position and orientation of the light.
    pub pose: LightPose,
    /// Full vertical angle of view \[degrees], inside (0, 180).
    pub vertical_fov_degrees: f64,
    /// Path of the picture, as the scene file states it: not empty, without line breaks.
    pub path: Spanned<String>,
    /// Total flux, or the intensity in directions where the picture has the value 1.
    /// [`PointLightStrength::Mit6837Color`] is not allowed.
    pub strength: PointLightStrength,
}

impl BlockCodec for ProjectorLightDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let (path, angle) = (f.value_or_default("file")?, f.value_or_default("angle")?);
        Ok(Self { pose: LightPose::parse(f)?, vertical_fov_degrees: angle, path, strength: PATTERN_STRENGTH.parse(f)? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        self.pose.write(out)?;
        out.write_number("angle", self.vertical_fov_degrees)?;
        out.write_name_field("file", &self.path)?;
        PATTERN_STRENGTH.write(out, &self.strength)
    }
}

impl LightBlock for ProjectorLightDescription {
    const BLOCK: &'static BlockSchema = &block_schema("ProjectorLight", "pinhole that projects a picture")
        .with_own_fields(&[
            field_schema("angle", FieldKind::Number, "full vertical angle of the picture")
                .with_range(FieldRange::OpenInterval(0.0, 180.0))
                .make_required()
                .with_unit("degrees"),
            field_schema("file", FieldKind::Name, "projected picture: PNG, OpenEXR or Radiance HDR").make_required(),
        ])
        .with_shared_fields(&[POSE_FIELDS, PATTERN_STRENGTH.list.fields]);
    const IS_INFINITE: bool = false;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, _: Span) -> Result<(), SceneError> {
        let path = &self.path;
        let picture =
            ProjectedPicture::new(r.read_picture(path, PixelMeaning::Color)?, self.vertical_fov_degrees.to_radians());
        let picture = picture.map_err(|e| r.file_error(path, &e, "repair the picture or name another"))?;
        let black = || r.file_error(path, &"the picture is black", "name a picture with light in it");
        let pattern = IntensityPattern::ProjectedPicture(Arc::new(picture.ok_or_else(black)?));
        let (direction, up) = self.pose.direction_and_up();
        let source = OrientedPointLight { position: self.pose.position, direction, up, pattern };
        add_delta_light(r, UnscaledDeltaLight::Oriented(source), self.strength.resolve(), motion);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        Some(&mut self.path.value)
    }
}
