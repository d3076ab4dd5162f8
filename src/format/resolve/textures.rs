//! Textures of the description, and what wears them.

use super::{Resolver, rgb};
use crate::color::{self, Rgb};
use crate::format::SceneError;
use crate::format::description::{
    Coordinates, Encoding, Map, Material, MaterialKind, NormalPerturbation, Pattern, Spanned, TextureKind, Value, Wrap,
};
use crate::image::{self, Image, Meaning};
use crate::math::Transform;
use crate::scene::{self, Dress, Tint};
use crate::texture::{self, Checker, Picture, Solid, SolidKind, Texture};
use glam::DVec3;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A texture that was read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub index: u32,
    pub mean: Rgb,
    range: (f32, f32),
    solid: bool,
    /// Whether it is a picture of light rather than of numbers.
    light: bool,
}

/// What a material needs of the surfaces that wear it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Worn {
    /// Whether it follows a texture at all.
    pub textured: bool,
    /// Whether one of its textures goes by texture coordinates.
    pub by_coordinates: bool,
}

/// Any number that a texture can have.
const ANY: RangeInclusive<f32> = 0.0..=f32::MAX;

/// Shares of light, and roughness.
const SHARE: RangeInclusive<f32> = 0.0..=1.0;

impl<'a> Resolver<'a> {
    pub(super) fn textures(&mut self) -> Result<(), SceneError> {
        for texture in &self.description.textures {
            let made = match &texture.kind {
                TextureKind::Image { path, encoding, wrap, coordinates } => {
                    self.picture(path, *encoding, *wrap, *coordinates)?
                }
                TextureKind::Checker { colors, coordinates } => {
                    let checker = Texture::Checker(Checker { colors: colors.map(rgb) }, laid(coordinates));
                    self.add(checker, false)
                }
                TextureKind::Solid { pattern, colors, octaves, frequency, amplitude, maps } => {
                    let help = "no scale may be zero, and no axis of a matrix may be a mix of the others";
                    let place = Transform::new(Map::product(maps))
                        .map_err(|e| super::shapes::refuse(self, texture.span, &e.to_string(), help))?;
                    let solid = Solid {
                        kind: match pattern {
                            Pattern::Noise => SolidKind::Noise,
                            Pattern::Marble => SolidKind::Marble,
                            Pattern::Wood => SolidKind::Wood,
                        },
                        colors: colors.map(rgb),
                        octaves: *octaves,
                        frequency: *frequency,
                        amplitude: *amplitude,
                        to_pattern: *place.inverse(),
                    };
                    self.add(Texture::Solid(solid), false)
                }
            };
            self.known.insert(&texture.name, made);
        }
        Ok(())
    }

    fn add(&mut self, texture: Texture, light: bool) -> Known {
        let (mean, range, solid) = (texture.mean(), texture.range(), texture.is_solid());
        Known { index: self.builder.texture(texture), mean, range, solid, light }
    }

    fn picture(
        &mut self,
        path: &Spanned<String>,
        encoding: Encoding,
        wrap: Wrap,
        coordinates: Coordinates,
    ) -> Result<Known, SceneError> {
        let file = self.file("picture", path)?;
        let image = self.read_picture(
            path,
            &file,
            match encoding {
                Encoding::Srgb => Meaning::Light,
                Encoding::Linear => Meaning::Numbers,
            },
        )?;
        let wrap = match wrap {
            Wrap::Repeat => texture::Wrap::Repeat,
            Wrap::Clamp => texture::Wrap::Clamp,
            Wrap::Mirror => texture::Wrap::Mirror,
        };
        let picture = Picture::new(&image, wrap)
            .map_err(|e| self.bad_file(path, &e, "a texture's values must be finite and not negative"))?;
        Ok(self.add(Texture::Picture(picture, laid(&coordinates)), encoding == Encoding::Srgb))
    }

    pub(super) fn read_picture(
        &self,
        path: &Spanned<String>,
        file: &Path,
        meaning: Meaning,
    ) -> Result<Image, SceneError> {
        let help = "mend the picture or name another: PNG, OpenEXR or Radiance HDR";
        if let Some(picture) = self.assets.pictures.get(path.as_str()) {
            return Ok((**picture).clone());
        }
        let read = image::read_within(file, meaning, self.memory.free());
        read.map_err(|e| self.refuse_file(path, &e, matches!(e, image::ReadError::Memory { .. }), help))
    }

    /// The texture of a name, whose values lie in `range`.
    pub(super) fn known(&self, name: &Spanned<String>, range: &RangeInclusive<f32>) -> Result<Known, SceneError> {
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

    /// The texture of a name, else the picture at that path, read once for each meaning of its numbers.
    fn known_or_picture(&mut self, name: &Spanned<String>, encoding: Encoding) -> Result<Known, SceneError> {
        if self.known.contains_key(name.as_str()) {
            return self.known(name, &ANY);
        }
        let key: (PathBuf, bool) = (self.file("texture or picture", name)?, encoding == Encoding::Srgb);
        if let Some(known) = self.pictures.get(&key) {
            return Ok(*known);
        }
        let known = self.picture(name, encoding, Wrap::Repeat, Coordinates::default())?;
        self.pictures.insert(key, known);
        Ok(known)
    }

    /// A colour and its mean.
    pub(super) fn tint(
        &self,
        value: &Value<DVec3>,
        range: &RangeInclusive<f32>,
        worn: &mut Worn,
    ) -> Result<(Tint, Rgb), SceneError> {
        match value {
            Value::Plain(color) => Ok((Tint::plain(rgb(*color)), rgb(*color))),
            Value::Texture(name) => {
                let known = self.known(name, range)?;
                worn.by(&known);
                Ok((Tint { factor: Rgb::ONE, texture: Some(known.index) }, known.mean))
            }
        }
    }

    /// A share's texture, if it follows one, and its mean.
    pub(super) fn degree(&self, value: &Value<f64>, worn: &mut Worn) -> Result<(Option<u32>, f32), SceneError> {
        match value {
            Value::Plain(number) => Ok((None, *number as f32)),
            Value::Texture(name) => {
                let known = self.known(name, &SHARE)?;
                worn.by(&known);
                Ok((Some(known.index), color::mean(known.mean)))
            }
        }
    }

    /// A reflectance or transmittance.
    pub(super) fn share(&self, value: &Value<DVec3>, worn: &mut Worn) -> Result<(Tint, Rgb), SceneError> {
        self.tint(value, &SHARE, worn)
    }

    /// The diffuse colour of the course's material times its texture.
    pub(super) fn phong_diffuse(
        &mut self,
        diffuse: &Value<DVec3>,
        texture: Option<&Spanned<String>>,
        worn: &mut Worn,
    ) -> Result<(Tint, Rgb), SceneError> {
        let Some(name) = texture else { return self.tint(diffuse, &ANY, worn) };
        let Value::Plain(factor) = diffuse else {
            let help = "give `diffuseColor` in numbers, or leave `texture` out";
            return Err(SceneError::at(self.source, name.span, "two textures for one colour", "the second", help));
        };
        let known = self.known_or_picture(name, Encoding::Srgb)?;
        worn.by(&known);
        let factor = rgb(*factor);
        Ok((Tint { factor, texture: Some(known.index) }, factor * known.mean))
    }

    /// What tilts the normals of a material.
    pub(super) fn relief(&mut self, material: &Material, worn: &mut Worn) -> Result<scene::Relief, SceneError> {
        Ok(match &material.relief {
            None => scene::Relief::Smooth,
            Some(NormalPerturbation::Bump { texture, height }) => {
                let known = self.known_or_picture(texture, Encoding::Linear)?;
                if *height == 0.0 {
                    return Ok(scene::Relief::Smooth);
                }
                worn.by(&known);
                scene::Relief::Bumps { texture: known.index, height: *height as f32 }
            }
            Some(NormalPerturbation::NormalMap(name)) => {
                let known = self.known_or_picture(name, Encoding::Linear)?;
                if known.light {
                    let message = format!("the texture `{}` is read as a picture of light", name.value);
                    let help = "give it `encoding linear`: normals are numbers";
                    return Err(SceneError::at(self.source, name.span, message, "no normals", help));
                }
                // Directions go by texture coordinates, whatever the texture goes by.
                (worn.textured, worn.by_coordinates) = (true, true);
                scene::Relief::Normals(known.index)
            }
        })
    }

    /// What a material wears, if anything.
    pub(super) fn dress(coat: scene::Coat, relief: scene::Relief) -> Option<Dress> {
        let plain = coat == scene::Coat::Plain && relief == scene::Relief::Smooth;
        (!plain).then_some(Dress { coat, relief })
    }

    /// Whether a surface has what the material in force needs of it.
    ///
    /// `own` is the name of a material of the mesh's own, where it has one.
    pub(super) fn check_coordinates(
        &self,
        there: bool,
        path: &Spanned<String>,
        own: Option<&str>,
    ) -> Result<(), SceneError> {
        let worn = self.worn.get(self.material as usize).copied().unwrap_or_default();
        if there || !worn.by_coordinates {
            return Ok(());
        }
        let described = self.description.materials.get(self.material as usize);
        let name = own.or_else(|| described.and_then(|m| m.name.as_deref()));
        let material = name.map_or(format!("material {}", self.material), |name| format!("the material `{name}`"));
        let message = format!("the mesh `{}` has no texture coordinates, which {material} needs", path.value);
        let help = "export it with texture coordinates (lines `vt`), or use Noise, Marble or Wood, which need none";
        Err(self.bad_file(path, &message, help))
    }

    /// Means of what materials a mix is made of.
    pub(super) fn worn_by_parts(&self, kind: &MaterialKind, worn: &mut Worn) {
        if let MaterialKind::Mix { first, second, .. } = kind {
            for part in [first, second] {
                if let Some(of_part) = self.names.get(part.as_str()).map(|i| self.worn[*i as usize]) {
                    worn.textured |= of_part.textured;
                    worn.by_coordinates |= of_part.by_coordinates;
                }
            }
        }
    }
}

impl Worn {
    pub fn by(&mut self, known: &Known) {
        self.textured = true;
        self.by_coordinates |= !known.solid;
    }

    /// `coat` where it follows a texture.
    pub fn coat(&self, coat: scene::Coat) -> scene::Coat {
        if self.textured { coat } else { scene::Coat::Plain }
    }
}

/// How a texture lies on the coordinates of a surface.
fn laid(coordinates: &Coordinates) -> texture::Coordinates {
    let Coordinates { scale, rotate, offset } = *coordinates;
    texture::Coordinates::new(scale, rotate.to_radians(), offset)
}
