//! The textures.

use std::fmt::{Display, Formatter, Result};

use glam::{DVec2, DVec3};

use super::super::description::{
    Coordinates, Emission, Encoding, Map, Pattern, Relief, Spanned, Texture, TextureKind, Value, Wrap,
};
use super::super::parser::is_identifier;
use super::{Name, Numbers, Printer, Quoted};

impl Printer<'_, '_> {
    pub(super) fn texture(&mut self, texture: &Texture) -> Result {
        let keyword = match texture.kind {
            TextureKind::Image { .. } => "Image",
            TextureKind::Checker { .. } => "Checker",
            TextureKind::Solid { pattern: Pattern::Noise, .. } => "Noise",
            TextureKind::Solid { pattern: Pattern::Marble, .. } => "Marble",
            TextureKind::Solid { pattern: Pattern::Wood, .. } => "Wood",
        };
        self.open(format_args!("{keyword} {}", Reference(&texture.name)))?;
        match &texture.kind {
            TextureKind::Image { path, encoding, wrap, coordinates } => {
                self.field("file", Name(path))?;
                match encoding {
                    Encoding::Srgb => self.field("encoding", "srgb")?,
                    Encoding::Linear => self.field("encoding", "linear")?,
                }
                match wrap {
                    Wrap::Repeat => self.field("wrap", "repeat")?,
                    Wrap::Clamp => self.field("wrap", "clamp")?,
                    Wrap::Mirror => self.field("wrap", "mirror")?,
                }
                self.coordinates(coordinates)?;
            }
            TextureKind::Checker { colors, coordinates } => {
                self.colors(colors)?;
                self.coordinates(coordinates)?;
            }
            TextureKind::Solid { pattern: _, colors, octaves, frequency, amplitude, maps } => {
                self.colors(colors)?;
                self.field("octaves", octaves)?;
                self.number("frequency", *frequency)?;
                self.number("amplitude", *amplitude)?;
                self.maps(maps)?;
            }
        }
        self.close()
    }

    /// A `Transform` of no object, unless it does nothing.
    pub(super) fn maps(&mut self, maps: &[Map]) -> Result {
        if maps.is_empty() {
            return Ok(());
        }
        self.open("Transform")?;
        maps.iter().try_for_each(|map| self.map(map))?;
        self.close()
    }

    fn colors(&mut self, colors: &[DVec3; 2]) -> Result {
        self.vector("color0", colors[0])?;
        self.vector("color1", colors[1])
    }

    fn coordinates(&mut self, coordinates: &Coordinates) -> Result {
        self.pair("scale", coordinates.scale)?;
        self.number("rotate", coordinates.rotate)?;
        self.pair("offset", coordinates.offset)
    }

    pub(super) fn pair(&mut self, name: &str, value: DVec2) -> Result {
        self.field(name, Numbers(&value.to_array()))
    }

    /// A colour, or a texture.
    pub(super) fn tint(&mut self, name: &str, value: &Value<DVec3>) -> Result {
        match value {
            Value::Plain(value) => self.vector(name, *value),
            Value::Texture(texture) => self.reference(name, texture),
        }
    }

    /// A number, or a texture.
    pub(super) fn degree(&mut self, name: &str, value: &Value<f64>) -> Result {
        match value {
            Value::Plain(value) => self.number(name, *value),
            Value::Texture(texture) => self.reference(name, texture),
        }
    }

    fn reference(&mut self, name: &str, texture: &Spanned<String>) -> Result {
        self.field(name, Reference(texture))
    }

    pub(super) fn relief(&mut self, relief: &Relief) -> Result {
        match relief {
            Relief::Bump { texture, height } => {
                self.field("bump", Name(texture))?;
                self.number("bumpHeight", *height)
            }
            Relief::NormalMap(texture) => self.field("normalMap", Name(texture)),
        }
    }

    pub(super) fn emission(&mut self, emission: &Emission) -> Result {
        match emission {
            Emission::Radiance(radiance) => self.vector("emission", *radiance),
            Emission::Texture { name, scale } => {
                self.reference("emission", name)?;
                self.number("emissionScale", *scale)
            }
        }
    }
}

/// A texture's name where numbers may stand too: bare where nothing else reads so.
pub(super) struct Reference<'a>(pub &'a str);

impl Display for Reference<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let number = ["nan", "inf", "infinity"].contains(&self.0.to_ascii_lowercase().as_str());
        if is_identifier(self.0) && !number { f.write_str(self.0) } else { Quoted(self.0).fmt(f) }
    }
}
