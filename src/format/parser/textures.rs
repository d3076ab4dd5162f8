//! The textures.

use glam::{DVec2, DVec3};

use super::super::description::{Coordinates, Encoding, Pattern, Spanned, Texture, TextureKind, Wrap};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::fields::{Fields, Found, Kind};
use super::{Parser, clip};

const TEXTURES: [&str; 6] = ["numTextures", "Image", "Checker", "Noise", "Marble", "Wood"];

const COORDINATES: [(&str, Kind); 3] = [("scale", Kind::Pair), ("rotate", Kind::Number), ("offset", Kind::Pair)];
const COLORS: [(&str, Kind); 2] = [("color0", Kind::Vector), ("color1", Kind::Vector)];

/// Octaves of noise: the last is 32,768 times finer than the first.
const OCTAVES: std::ops::RangeInclusive<f64> = 1.0..=16.0;

impl<'a> Parser<'a> {
    pub fn textures(&mut self, block: Token<'a>) -> Result<(), SceneError> {
        if !self.materials.is_empty() {
            let message = "`Textures` stand behind the `Materials` that may use them".to_owned();
            let help = "put the Textures ahead of the Materials".to_owned();
            return Err(self.lexer.error(block.span(), message, "too late", help));
        }
        self.textures.clear();
        let mut count = None;
        self.open(block)?;
        while let Some(word) = self.word()? {
            match word.text {
                "numTextures" => self.count(word, &mut count)?,
                text if TEXTURES.contains(&text) => {
                    let texture = self.texture(word)?;
                    self.textures.push(Spanned::new(texture, word.span()));
                }
                _ => return Err(self.unexpected(word, &TEXTURES)),
            }
        }
        self.check_count("numTextures", count, self.textures.len(), "texture")
    }

    fn texture(&mut self, word: Token<'a>) -> Result<Texture, SceneError> {
        use Kind::{Integer, Maps, Name, Number};
        let Some(name) = self.block_name_of("texture")? else {
            let message = format!("this `{}` has no name", word.text);
            let help = format!("name it, so that materials can use it: `{} name {{ … }}`", word.text);
            return Err(self.lexer.error(word.span(), message, "this texture", help));
        };
        if self.textures.iter().any(|texture| texture.value.name == name.value) {
            let message = format!("two textures are called `{}`", clip(&name.value));
            return Err(self.lexer.error(name.span, message, "the second", "give it another name".to_owned()));
        }
        let kind = match word.text {
            "Image" => {
                let own = [("file", Name), ("encoding", Name), ("wrap", Name)];
                self.fields(word, &[&own[..], &COORDINATES].concat())?.image()?
            }
            "Checker" => {
                let f = self.fields(word, &[&COLORS[..], &COORDINATES].concat())?;
                TextureKind::Checker { colors: f.colors()?, coordinates: f.coordinates()? }
            }
            other => {
                let own = [("octaves", Integer), ("frequency", Number), ("amplitude", Number), ("Transform", Maps)];
                let pattern = match other {
                    "Noise" => Pattern::Noise,
                    "Marble" => Pattern::Marble,
                    _ => Pattern::Wood,
                };
                self.fields(word, &[&COLORS[..], &own].concat())?.solid(pattern)?
            }
        };
        Ok(Texture { name: name.value, kind })
    }
}

impl Fields<'_> {
    fn image(&self) -> Result<TextureKind, SceneError> {
        let one_of = |field: Found<'_, '_>, known: &[&str]| {
            let word = field.text().value;
            let listed = known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ");
            field.ensure(known.contains(&word.as_str()), &format!("must be one of {listed}"))?;
            Ok(word)
        };
        let encoding = self.get("encoding").map(|e| one_of(e, &["srgb", "linear"])).transpose()?;
        let wrap = self.get("wrap").map(|w| one_of(w, &["repeat", "clamp", "mirror"])).transpose()?;
        Ok(TextureKind::Image {
            path: self.need("file")?.text(),
            encoding: if encoding.as_deref() == Some("linear") { Encoding::Linear } else { Encoding::Srgb },
            wrap: match wrap.as_deref() {
                Some("clamp") => Wrap::Clamp,
                Some("mirror") => Wrap::Mirror,
                _ => Wrap::Repeat,
            },
            coordinates: self.coordinates()?,
        })
    }

    fn solid(&self, pattern: Pattern) -> Result<TextureKind, SceneError> {
        let (octaves, frequency, amplitude) = (self.get("octaves"), self.get("frequency"), self.get("amplitude"));
        if let Some(octaves) = octaves {
            octaves.ensure(OCTAVES.contains(&octaves.number()), "must be a whole number from 1 to 16")?;
        }
        Ok(TextureKind::Solid {
            pattern,
            colors: self.colors()?,
            octaves: octaves.map_or(4, |o| o.number() as u32),
            frequency: frequency.map_or(Ok(1.0), |f| f.positive())?,
            amplitude: amplitude.map_or(Ok(1.0), |a| a.amount())?,
            maps: self.get("Transform").map_or(Vec::new(), |t| t.maps()),
        })
    }

    fn colors(&self) -> Result<[DVec3; 2], SceneError> {
        Ok([
            self.get("color0").map_or(Ok(DVec3::ZERO), |c| c.colour())?,
            self.get("color1").map_or(Ok(DVec3::ONE), |c| c.colour())?,
        ])
    }

    fn coordinates(&self) -> Result<Coordinates, SceneError> {
        let plain = Coordinates::default();
        let scale = self.get("scale");
        if let Some(scale) = scale {
            scale.ensure(scale.pair().abs().min_element() > 0.0, "must not be 0")?;
        }
        Ok(Coordinates {
            scale: scale.map_or(DVec2::ONE, |s| s.pair()),
            rotate: self.get("rotate").map_or(plain.rotate, |r| r.number()),
            offset: self.get("offset").map_or(plain.offset, |o| o.pair()),
        })
    }
}
