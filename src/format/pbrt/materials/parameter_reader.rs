//! Reads parameters of pbrt materials as constants or textures of the imported scene.

use crate::format::description::TexturedValue;
use crate::format::import_notes::ImportNotes;
use crate::format::pbrt::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use crate::format::pbrt::parameters::Parameters;
use crate::format::pbrt::textures::{PbrtTexture, PbrtTextures};
use glam::DVec3;

/// Reader of material parameters, with the tables that receive textures and messages.
pub(super) struct ParameterReader<'m> {
    /// Textures of the file and of the imported scene.
    pub textures: &'m mut PbrtTextures,
    /// Access to the files of the scene, within a memory limit.
    pub files: &'m PbrtSceneFiles<'m>,
    /// Messages about content that is ignored or approximated.
    pub notes: &'m mut ImportNotes,
}

impl ParameterReader<'_> {
    /// Returns the first of the parameters `names` that exists; the gray value `default` if none
    /// does.
    ///
    /// `is_color` tells whether the parameter is a color, or a number.
    pub fn value_or_gray(
        &self,
        p: &Parameters,
        names: &[&str],
        is_color: bool,
        default: f64,
    ) -> ReadResult<PbrtTexture> {
        match p.find_any(names) {
            Some(parameter) => self.textures.parameter_value(parameter, is_color, &p.place, self.files),
            None => Ok(PbrtTexture::Constant(DVec3::splat(default))),
        }
    }

    /// Returns the color parameter `name`, as a constant or a texture, and its mean over the
    /// texture.
    ///
    /// Colors are clamped to \[0, 1], and then mapped by `map`. `default` is the gray value of a
    /// missing parameter.
    pub fn textured_color_and_mean(
        &mut self,
        p: &Parameters,
        name: &str,
        default: f64,
        map: &dyn Fn(DVec3) -> DVec3,
    ) -> ReadResult<(TexturedValue<DVec3>, DVec3)> {
        let value = self.value_or_gray(p, &[name], true, default)?;
        let unit = |color: DVec3| map(color.clamp(DVec3::ZERO, DVec3::ONE));
        self.textures.add_texture(&value, &unit, self.files)
    }

    /// Converts a texture to a number parameter. Returns it as a constant or a texture, and its
    /// mean over the texture.
    ///
    /// Each color gives one number: `map` applied to the mean of the color's channels.
    pub fn textured_scalar_and_mean(
        &mut self,
        value: &PbrtTexture,
        map: &dyn Fn(f64) -> f64,
    ) -> ReadResult<(TexturedValue<f64>, f64)> {
        let mean = |c: DVec3| if c.x == c.y && c.y == c.z { c.x } else { c.element_sum() / 3.0 };
        let gray = |color: DVec3| DVec3::splat(map(mean(color)));
        let (value, mean) = self.textures.add_texture(value, &gray, self.files)?;
        Ok(match value {
            TexturedValue::Constant(value) => (TexturedValue::Constant(value.x), value.x),
            TexturedValue::Texture(name) => (TexturedValue::Texture(name), mean.x),
        })
    }

    /// Adds a message about content of the directive at `place` that is ignored or approximated.
    pub fn add_note(&mut self, message: &str, place: &PbrtSourceLocation) {
        self.notes.add_unsupported(message, place.position_text());
    }
}
