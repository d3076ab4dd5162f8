//! Resolves the textures of a description, and material parameters that follow them.

use super::{Resolver, rgb};
use crate::color::{self, Rgb};
use crate::format::SceneError;
use crate::format::description::{
    self, MaterialDescription, MaterialKindDescription, PictureEncoding, SolidPatternDescription, Spanned,
    TexcoordTransformDescription, TextureKindDescription, TexturedValue, TransformStep, Wrap,
};
use crate::image::{self, Image, PictureContent};
use crate::math::Transform;
use crate::scene::{NormalPerturbation, Textured};
use crate::texture::{self, Checker, Picture, SolidPattern, SolidTexture, Texture};
use glam::DVec3;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A texture added to the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnownTexture {
    pub index: u32,
    pub mean: Rgb,
    range: (f32, f32),
    solid: bool,
    /// True if its values encode light (sRGB) rather than numbers.
    light: bool,
}

/// Requirements of a material's textures on its surfaces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TextureNeeds {
    /// True if any texture is used.
    pub textured: bool,
    /// True if texture coordinates are needed.
    pub coordinates: bool,
}

/// The range of all texture values.
const ANY: RangeInclusive<f32> = 0.0..=f32::MAX;

/// The range of reflectance, transmittance and roughness.
const UNIT: RangeInclusive<f32> = 0.0..=1.0;

impl<'a> Resolver<'a> {
    pub(super) fn textures(&mut self) -> Result<(), SceneError> {
        for texture in &self.description.textures {
            let made = match &texture.kind {
                TextureKindDescription::Image { path, encoding, wrap, coordinates } => {
                    self.picture(path, *encoding, *wrap, *coordinates)?
                }
                TextureKindDescription::Checker { colors, coordinates } => {
                    let checker = Texture::Checker(Checker { colors: colors.map(rgb) }, uv_map(coordinates));
                    self.add(checker, false)
                }
                TextureKindDescription::Solid { pattern, colors, octaves, frequency, amplitude, maps } => {
                    let help = "no scale may be zero, and no axis of a matrix may be a mix of the others";
                    let to_object = Transform::new(TransformStep::composed_matrix(maps))
                        .map_err(|e| self.refuse(texture.span, &e.to_string(), help))?;
                    let solid = SolidTexture {
                        kind: match pattern {
                            SolidPatternDescription::Noise => SolidPattern::Noise,
                            SolidPatternDescription::Marble => SolidPattern::Marble,
                            SolidPatternDescription::Wood => SolidPattern::Wood,
                        },
                        colors: colors.map(rgb),
                        octaves: *octaves,
                        frequency: *frequency,
                        amplitude: *amplitude,
                        to_pattern: *to_object.inverse(),
                    };
                    self.add(Texture::Solid(solid), false)
                }
            };
            self.known.insert(&texture.name, made);
        }
        Ok(())
    }

    fn add(&mut self, texture: Texture, light: bool) -> KnownTexture {
        let (mean, range, solid) = (texture.mean(), texture.range(), texture.is_solid());
        KnownTexture { index: self.builder.texture(texture), mean, range, solid, light }
    }

    fn picture(
        &mut self,
        path: &Spanned<String>,
        encoding: PictureEncoding,
        wrap: Wrap,
        coordinates: TexcoordTransformDescription,
    ) -> Result<KnownTexture, SceneError> {
        let file = self.file("picture", path)?;
        let image = self.read_picture(
            path,
            &file,
            match encoding {
                PictureEncoding::Srgb => PictureContent::Radiance,
                PictureEncoding::Linear => PictureContent::Data,
            },
        )?;
        let picture = Picture::new(&image, wrap)
            .map_err(|e| self.bad_file(path, &e, "a texture's values must be finite and not negative"))?;
        Ok(self.add(Texture::Picture(picture, uv_map(&coordinates)), encoding == PictureEncoding::Srgb))
    }

    pub(super) fn read_picture(
        &self,
        path: &Spanned<String>,
        file: &Path,
        meaning: PictureContent,
    ) -> Result<Image, SceneError> {
        let help = "repair the picture or name another: PNG, OpenEXR or Radiance HDR";
        if let Some(picture) = self.assets.pictures.get(path.as_str()) {
            return Ok((**picture).clone());
        }
        let read = image::read_with_memory_limit(file, meaning, self.memory.available_bytes());
        read.map_err(|e| self.refuse_file(path, &e, matches!(e, image::ReadError::Memory { .. }), help))
    }

    /// The texture with a name, whose values lie in `range`.
    pub(super) fn known(
        &self,
        name: &Spanned<String>,
        range: &RangeInclusive<f32>,
    ) -> Result<KnownTexture, SceneError> {
        let known = self.known.get(name.as_str()).copied().ok_or_else(|| {
            let message = format!("no texture is called `{}`", name.value);
            SceneError::at(self.source, name.span, message, "unknown name", "define it in Textures first")
        })?;
        let (least, most) = known.range;
        if range.contains(&least) && range.contains(&most) {
            return Ok(known);
        }
        let message = format!("the texture `{}` goes from {least} to {most}", name.value);
        let help = format!("its values must lie between {} and {} here", range.start(), range.end());
        Err(SceneError::at(self.source, name.span, message, "out of range", help))
    }

    /// The texture with a name, else the picture at that path, read once per encoding.
    fn known_or_picture(
        &mut self,
        name: &Spanned<String>,
        encoding: PictureEncoding,
    ) -> Result<KnownTexture, SceneError> {
        if self.known.contains_key(name.as_str()) {
            return self.known(name, &ANY);
        }
        let key: (PathBuf, bool) = (self.file("texture or picture", name)?, encoding == PictureEncoding::Srgb);
        if let Some(known) = self.pictures.get(&key) {
            return Ok(*known);
        }
        let known = self.picture(name, encoding, Wrap::Repeat, TexcoordTransformDescription::default())?;
        self.pictures.insert(key, known);
        Ok(known)
    }

    /// A colour parameter, whose texture has values in `range`.
    pub(super) fn color(
        &self,
        value: &TexturedValue<DVec3>,
        range: &RangeInclusive<f32>,
        needs: &mut TextureNeeds,
    ) -> Result<Textured<Rgb>, SceneError> {
        match value {
            TexturedValue::Plain(color) => Ok(Textured::Constant(rgb(*color))),
            TexturedValue::Texture(name) => {
                let known = self.known(name, range)?;
                needs.add(&known);
                Ok(Textured::Texture { texture: known.index, factor: Rgb::ONE, mean: known.mean })
            }
        }
    }

    /// A number parameter in \[0, 1].
    pub(super) fn fraction(
        &self,
        value: &TexturedValue<f64>,
        needs: &mut TextureNeeds,
    ) -> Result<Textured<f32>, SceneError> {
        match value {
            TexturedValue::Plain(number) => Ok(Textured::Constant(*number as f32)),
            TexturedValue::Texture(name) => {
                let known = self.known(name, &UNIT)?;
                needs.add(&known);
                Ok(Textured::Texture { texture: known.index, factor: 1.0, mean: color::channel_mean(known.mean) })
            }
        }
    }

    /// A reflectance or transmittance: a colour parameter in \[0, 1].
    pub(super) fn reflectance(
        &self,
        value: &TexturedValue<DVec3>,
        needs: &mut TextureNeeds,
    ) -> Result<Textured<Rgb>, SceneError> {
        self.color(value, &UNIT, needs)
    }

    /// The diffuse colour of the course's material times its texture.
    pub(super) fn phong_diffuse(
        &mut self,
        diffuse: &TexturedValue<DVec3>,
        texture: Option<&Spanned<String>>,
        needs: &mut TextureNeeds,
    ) -> Result<Textured<Rgb>, SceneError> {
        let Some(name) = texture else { return self.color(diffuse, &ANY, needs) };
        let TexturedValue::Plain(factor) = diffuse else {
            let help = "give `diffuseColor` in numbers, or leave `texture` out";
            return Err(SceneError::at(self.source, name.span, "two textures for one colour", "the second", help));
        };
        let known = self.known_or_picture(name, PictureEncoding::Srgb)?;
        needs.add(&known);
        let factor = rgb(*factor);
        Ok(Textured::Texture { texture: known.index, factor, mean: factor * known.mean })
    }

    /// The perturbation of a material's normals.
    pub(super) fn normals(
        &mut self,
        material: &MaterialDescription,
        needs: &mut TextureNeeds,
    ) -> Result<NormalPerturbation, SceneError> {
        Ok(match &material.normal_perturbation {
            None => NormalPerturbation::None,
            Some(description::NormalPerturbationDescription::Bump { texture, height }) => {
                let known = self.known_or_picture(texture, PictureEncoding::Linear)?;
                if *height == 0.0 {
                    return Ok(NormalPerturbation::None);
                }
                needs.add(&known);
                NormalPerturbation::BumpMap { texture: known.index, height: *height as f32 }
            }
            Some(description::NormalPerturbationDescription::NormalMap(name)) => {
                let known = self.known_or_picture(name, PictureEncoding::Linear)?;
                if known.light {
                    let message = format!("the texture `{}` is read as a picture of light", name.value);
                    let help = "give it `encoding linear`: normals are numbers";
                    return Err(SceneError::at(self.source, name.span, message, "no normals", help));
                }
                // Tangents follow texture coordinates, even if the texture is solid.
                *needs = TextureNeeds { textured: true, coordinates: true };
                NormalPerturbation::NormalMap(known.index)
            }
        })
    }

    /// Refuses a mesh without texture coordinates if the current material needs them.
    ///
    /// `there` is true if the mesh has them. `own` is the name of the mesh's own material, if it
    /// has one.
    pub(super) fn check_coordinates(
        &self,
        there: bool,
        path: &Spanned<String>,
        own: Option<&str>,
    ) -> Result<(), SceneError> {
        let needs = self.texture_needs.get(self.material as usize).copied().unwrap_or_default();
        if there || !needs.coordinates {
            return Ok(());
        }
        let described = self.description.materials.get(self.material as usize);
        let name = own.or_else(|| described.and_then(|m| m.name.as_deref()));
        let material = name.map_or(format!("material {}", self.material), |name| format!("the material `{name}`"));
        let message = format!("the mesh `{}` has no texture coordinates, which {material} needs", path.value);
        let help = "export it with texture coordinates (lines `vt`), or use Noise, Marble or Wood, which need none";
        Err(self.bad_file(path, &message, help))
    }

    /// Adds the needs of a mix's parts.
    pub(super) fn add_needs_of_parts(&self, kind: &MaterialKindDescription, needs: &mut TextureNeeds) {
        if let MaterialKindDescription::Mix { first, second, .. } = kind {
            for part in [first, second] {
                if let Some(of_part) = self.names.get(part.as_str()).map(|i| self.texture_needs[*i as usize]) {
                    needs.textured |= of_part.textured;
                    needs.coordinates |= of_part.coordinates;
                }
            }
        }
    }
}

impl TextureNeeds {
    /// Adds the needs of one texture.
    pub fn add(&mut self, known: &KnownTexture) {
        self.textured = true;
        self.coordinates |= !known.solid;
    }
}

/// The affine map of texture coordinates.
fn uv_map(coordinates: &TexcoordTransformDescription) -> texture::Coordinates {
    let TexcoordTransformDescription { scale, rotate, offset } = *coordinates;
    texture::Coordinates::new(scale, rotate.to_radians(), offset)
}
