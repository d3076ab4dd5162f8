//! The materials, and references to them.

use glam::DVec3;

use super::super::description::{Attenuation, Material, MaterialKind, Spanned};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::fields::{Fields, Kind};
use super::{Parser, clip, suggest};

const MATERIALS: [&str; 7] = ["numMaterials", "Material", "PhongMaterial", "Phong", "Diffuse", "Mirror", "Dielectric"];

const EMISSION: (&str, Kind) = ("emission", Kind::Vector);
const REFLECTANCE: (&str, Kind) = ("reflectance", Kind::Vector);

impl<'a> Parser<'a> {
    pub fn materials(&mut self, block: Token<'a>) -> Result<(), SceneError> {
        if self.indexed {
            self.late = Some(block);
        }
        self.materials.clear();
        self.names.clear();
        let mut count = None;
        self.open(block)?;
        while let Some(word) = self.word()? {
            match word.text {
                "numMaterials" => self.count(word, &mut count)?,
                text if MATERIALS.contains(&text) => {
                    let material = self.material(word)?;
                    self.materials.push(Spanned::new(material, word.span()));
                }
                _ => return Err(self.unexpected(word, &MATERIALS)),
            }
        }
        self.check_count("numMaterials", count, self.materials.len(), "material")
    }

    fn material(&mut self, word: Token<'a>) -> Result<Material, SceneError> {
        use Kind::{Name, Number, Vector};
        let name = self.material_name()?;
        let f = match word.text {
            "Diffuse" | "Mirror" => self.fields(word, &[REFLECTANCE, EMISSION])?,
            "Dielectric" => {
                let tint = [("tint", Vector), ("tintDistance", Number)];
                let known = [("indexOfRefraction", Number), ("absorption", Vector), tint[0], tint[1], EMISSION];
                self.fields(word, &known)?
            }
            _ => {
                let colours = [("diffuseColor", Vector), ("specularColor", Vector)];
                let known = [colours[0], colours[1], ("shininess", Number), ("texture", Name), EMISSION];
                self.fields(word, &known)?
            }
        };
        let kind = match word.text {
            "Diffuse" => MaterialKind::Diffuse { reflectance: f.need("reflectance")?.reflectance()? },
            "Mirror" => {
                let reflectance = f.get("reflectance").map_or(Ok(DVec3::ONE), |r| r.reflectance())?;
                MaterialKind::Mirror { reflectance }
            }
            "Dielectric" => f.dielectric()?,
            _ => f.phong()?,
        };
        Ok(Material { name, kind, emission: f.emission()? })
    }

    /// The name between a material's kind and its `{`, if any.
    fn material_name(&mut self) -> Result<Option<String>, SceneError> {
        let token = self.lexer.peek();
        let name = match token.text {
            "" | "{" => return Ok(None),
            "\"" => self.lexer.quoted()?,
            text => {
                self.lexer.take(token);
                Spanned::new(text.to_owned(), token.span())
            }
        };
        let shown = clip(&name.value);
        if token.text != "\"" && !is_identifier(token.text) {
            let message = format!("`{shown}` is not a plain name");
            let help =
                format!("put it in quotes, or open the block with `{{`: names start with a letter, not `{shown}`");
            return Err(self.lexer.error(name.span, message, "as a material's name", help));
        }
        if name.value.is_empty() {
            let help = "write a name, or leave the quotes out".to_owned();
            return Err(self.lexer.error(name.span, "the material's name is empty".to_owned(), "empty", help));
        }
        if self.names.insert(name.value.clone(), self.materials.len()).is_some() {
            let message = format!("two materials are called `{shown}`");
            return Err(self.lexer.error(name.span, message, "the second", "give it another name".to_owned()));
        }
        Ok(Some(name.value))
    }

    pub fn material_by_index(&mut self, word: Token<'a>) -> Result<Spanned<u32>, SceneError> {
        self.indexed = true;
        let index = self.integer(word)?;
        let known = self.materials.len();
        if (index.value as usize) < known {
            return Ok(index);
        }
        let message = format!("there is no material {}", index.value);
        let help = match known {
            0 => "no material stands before this place: put `Materials { … }` ahead of the Group".to_owned(),
            1 => "the one material is number 0".to_owned(),
            n => format!("materials are numbered from 0 to {}", n - 1),
        };
        Err(self.lexer.error(index.span, message, "out of range", help))
    }

    pub fn material_by_name(&mut self, word: Token<'a>) -> Result<Spanned<String>, SceneError> {
        self.indexed = true;
        let name = self.name(word)?;
        if self.names.contains_key(&name.value) {
            return Ok(name);
        }
        let message = format!("no material is called `{}`", clip(&name.value));
        let nearest = suggest::nearest(&name.value, self.materials.iter().filter_map(|m| m.name.as_deref()));
        let help = match nearest {
            Some(nearest) => format!("did you mean `{}`?", clip(nearest)),
            None => "name it ahead of the Group: `Materials { Diffuse name { … } }`".to_owned(),
        };
        Err(self.lexer.error(name.span, message, "unknown name", help))
    }
}

impl Fields<'_> {
    fn phong(&self) -> Result<MaterialKind, SceneError> {
        let shininess = self.get("shininess");
        if let Some(s) = shininess {
            s.ensure(s.number() >= 0.0, "must not be negative")?;
        }
        Ok(MaterialKind::Phong {
            diffuse: self.get("diffuseColor").map_or(Ok(DVec3::ONE), |c| c.colour())?,
            specular: self.get("specularColor").map_or(Ok(DVec3::ZERO), |c| c.colour())?,
            shininess: shininess.map_or(0.0, |s| s.number()),
            texture: self.get("texture").map(|t| t.text().value),
        })
    }

    fn dielectric(&self) -> Result<MaterialKind, SceneError> {
        let index = self.get("indexOfRefraction").map_or(Ok(1.5), |i| i.positive())?;
        if self.get("absorption").is_some() && self.get("tint").is_some() {
            // Names the second of the two.
            self.one_of(&["absorption", "tint"])?;
        }
        let distance = self.get("tintDistance");
        let attenuation = match (self.get("absorption"), self.get("tint")) {
            (_, Some(tint)) => {
                let ok = tint.vector().min_element() > 0.0 && tint.vector().max_element() <= 1.0;
                tint.ensure(ok, "must lie above 0 and at most at 1 in each component")?;
                let distance = distance.map_or(Ok(1.0), |d| d.positive())?;
                return Ok(MaterialKind::Dielectric {
                    index,
                    attenuation: Attenuation::Tint { color: tint.vector(), distance },
                });
            }
            (Some(absorption), None) => Attenuation::Absorption(absorption.colour()?),
            (None, None) => Attenuation::None,
        };
        if let Some(distance) = distance {
            distance.ensure(false, "says nothing without `tint`")?;
        }
        Ok(MaterialKind::Dielectric { index, attenuation })
    }
}

/// Whether a name can stand without quotes.
pub(crate) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b))
}
