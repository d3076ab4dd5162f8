//! The materials, and references to them.

use glam::DVec3;

use super::super::description::{Attenuation, Material, MaterialKind, Metal, Relief, Spanned, Value};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::fields::{DENSEST, Fields, Found, Kind};
use super::{Parser, clip, suggest};

const MATERIALS: [&str; 11] = [
    "numMaterials",
    "Material",
    "PhongMaterial",
    "Phong",
    "Diffuse",
    "Mirror",
    "Dielectric",
    "Clear",
    "Conductor",
    "Thin",
    "Mix",
];

/// Indices of refraction whose ratios and squares single precision can tell apart; all of nature lies inside.
pub(super) const INDICES: std::ops::RangeInclusive<f64> = 0.001..=1000.0;

const EMISSION: [(&str, Kind); 2] = [("emission", Kind::Tint), ("emissionScale", Kind::Number)];
const RELIEF: [(&str, Kind); 3] = [("bump", Kind::Name), ("bumpHeight", Kind::Number), ("normalMap", Kind::Name)];
const INDEX: (&str, Kind) = ("indexOfRefraction", Kind::Number);
const ROUGHNESS: (&str, Kind) = ("roughness", Kind::Degree);
const REFLECTANCE: (&str, Kind) = ("reflectance", Kind::Tint);

/// Most mixes inside one another: each level doubles the ways through.
const MAX_MIXES: u8 = 8;

/// What light may find behind a material.
#[derive(Clone, Copy, Default)]
pub(super) struct Reach {
    /// The Dielectric that it may enter.
    body: Option<usize>,
    /// The depth of mixes.
    mixes: u8,
}

impl<'a> Parser<'a> {
    pub fn materials(&mut self, block: Token<'a>) -> Result<(), SceneError> {
        if self.indexed {
            self.late = Some(block);
        }
        self.materials.clear();
        self.names.clear();
        self.reach.clear();
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
        use Kind::{Degree, Integer, Name, Number, Numbers, Tint, Vector};
        let name = self.material_name()?;
        let own: &[(&str, Kind)] = match word.text {
            "Diffuse" | "Mirror" => &[REFLECTANCE],
            "Dielectric" => &[
                INDEX,
                ("abbe", Number),
                ("glass", Name),
                ("cauchy", Numbers),
                ("sellmeierB", Numbers),
                ("sellmeierC", Numbers),
                ("absorption", Vector),
                ("tint", Vector),
                ("tintDistance", Number),
                ROUGHNESS,
                ("priority", Integer),
                ("medium", Name),
            ],
            "Clear" => &[("medium", Name), ("priority", Integer)],
            "Conductor" => &[("metal", Name), ("eta", Vector), ("k", Vector), ROUGHNESS],
            "Thin" => &[INDEX, ("transmittance", Tint)],
            "Mix" => &[("first", Name), ("second", Name), ("amount", Degree)],
            _ => &[("diffuseColor", Tint), ("specularColor", Tint), ("shininess", Number), ("texture", Name)],
        };
        // What a mix stands for has its own relief.
        let relief: &[(&str, Kind)] = if word.text == "Mix" { &[] } else { &RELIEF };
        let f = self.fields(word, &[own, relief, &EMISSION].concat())?;
        let kind = match word.text {
            "Diffuse" => MaterialKind::Diffuse { reflectance: f.need("reflectance")?.or_texture(Found::reflectance)? },
            "Mirror" => {
                let white = Ok(DVec3::ONE.into());
                let reflectance = f.get("reflectance").map_or(white, |r| r.or_texture(Found::reflectance))?;
                MaterialKind::Mirror { reflectance }
            }
            "Dielectric" => f.dielectric()?,
            "Clear" => f.clear()?,
            "Conductor" => f.conductor()?,
            "Thin" => {
                let clear = Ok(DVec3::ONE.into());
                let transmittance = f.get("transmittance").map_or(clear, |t| t.or_texture(Found::transmittance))?;
                MaterialKind::Thin { index: f.index()?, transmittance }
            }
            "Mix" => self.mix(&f)?,
            _ => f.phong()?,
        };
        self.reach.push(match &kind {
            MaterialKind::Dielectric { .. } => Reach { body: Some(self.materials.len()), mixes: 0 },
            MaterialKind::Mix { first, second, .. } => {
                let (a, b) = (self.reach(first), self.reach(second));
                Reach { body: a.body.or(b.body), mixes: a.mixes.max(b.mixes) + 1 }
            }
            _ => Reach::default(),
        });
        let medium = self.contents(&f)?;
        Ok(Material { name, kind, emission: f.emission_or_texture()?, relief: f.relief()?, medium })
    }

    fn mix(&self, f: &Fields<'a>) -> Result<MaterialKind, SceneError> {
        let first = self.part(f.need("first")?)?;
        let second = self.part(f.need("second")?)?;
        let amount = f.need("amount")?.or_texture(Found::share)?;
        for part in [&first, &second] {
            if self.reach(part).mixes == MAX_MIXES {
                let message = format!("mixes nest more than {MAX_MIXES} deep");
                let help = "mix fewer materials, or materials that are no mixes".to_owned();
                return Err(f.error(part.span, message, "the deepest that may be", help));
            }
            let index = self.names.get(&part.value).copied();
            if index.is_some_and(|index| matches!(self.materials[index].kind, MaterialKind::Clear { .. })) {
                let message = "a mix cannot be `Clear`, which has no surface".to_owned();
                let help = "mix a `Dielectric { indexOfRefraction 1 … }` of the same medium instead".to_owned();
                return Err(f.error(part.span, message, "no surface", help));
            }
        }
        // Light would enter one of them, leave the other, and take the first for what is around it ever after.
        if let (Some(a), Some(b)) = (self.reach(&first).body, self.reach(&second).body)
            && a != b
        {
            let message = "a mix cannot be two different Dielectrics".to_owned();
            let help = "mix a Dielectric with what light does not enter, or with itself".to_owned();
            return Err(f.error(second.span, message, "the second body", help));
        }
        Ok(MaterialKind::Mix { first, second, amount })
    }

    /// The name of a material that stands before the one that is being read.
    fn part(&self, field: Found<'_, 'a>) -> Result<Spanned<String>, SceneError> {
        let name = field.text();
        match self.names.get(&name.value) {
            Some(&index) if index < self.materials.len() => Ok(name),
            Some(_) => {
                let message = format!("`{}` is a part of itself", clip(&name.value));
                let help = format!("name a material that stands before it as `{}`", field.name());
                Err(self.lexer.error(name.span, message, "this mix", help))
            }
            None => Err(self.unknown_material(&name, "a mix is made of materials that stand before it")),
        }
    }

    fn reach(&self, name: &Spanned<String>) -> Reach {
        self.names.get(&name.value).map_or(Reach::default(), |&index| self.reach[index])
    }

    fn material_name(&mut self) -> Result<Option<String>, SceneError> {
        let Some(name) = self.block_name_of("material")? else { return Ok(None) };
        if self.names.insert(name.value.clone(), self.materials.len()).is_some() {
            let message = format!("two materials are called `{}`", clip(&name.value));
            return Err(self.lexer.error(name.span, message, "the second", "give it another name".to_owned()));
        }
        Ok(Some(name.value))
    }

    /// The name between the kind of a material or texture and its `{`, if any.
    pub fn block_name_of(&mut self, what: &str) -> Result<Option<Spanned<String>>, SceneError> {
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
            return Err(self.lexer.error(name.span, message, &format!("as a {what}'s name"), help));
        }
        if name.value.is_empty() {
            let help = "write a name, or leave the quotes out".to_owned();
            return Err(self.lexer.error(name.span, format!("the {what}'s name is empty"), "empty", help));
        }
        Ok(Some(name))
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
        Err(self.unknown_material(&name, "name it ahead of the Group: `Materials { Diffuse name { … } }`"))
    }

    fn unknown_material(&self, name: &Spanned<String>, help: &str) -> SceneError {
        let message = format!("no material is called `{}`", clip(&name.value));
        let nearest = suggest::nearest(&name.value, self.materials.iter().filter_map(|m| m.name.as_deref()));
        let help = nearest.map_or(help.to_owned(), |nearest| format!("did you mean `{}`?", clip(nearest)));
        self.lexer.error(name.span, message, "unknown name", help)
    }
}

impl Fields<'_> {
    fn phong(&self) -> Result<MaterialKind, SceneError> {
        Ok(MaterialKind::Phong {
            diffuse: self.get("diffuseColor").map_or(Ok(DVec3::ONE.into()), |c| c.or_texture(Found::colour))?,
            specular: self.get("specularColor").map_or(Ok(DVec3::ZERO.into()), |c| c.or_texture(Found::colour))?,
            shininess: self.get("shininess").map_or(Ok(0.0), |s| s.amount())?,
            texture: self.get("texture").map(|t| t.text()),
        })
    }

    fn dielectric(&self) -> Result<MaterialKind, SceneError> {
        Ok(MaterialKind::Dielectric {
            refraction: self.refraction()?,
            attenuation: self.attenuation()?,
            roughness: self.roughness()?,
            priority: self.priority()?,
        })
    }

    pub(super) fn priority(&self) -> Result<u8, SceneError> {
        let Some(priority) = self.get("priority") else { return Ok(0) };
        priority.ensure(priority.number() <= f64::from(u8::MAX), "must be a whole number from 0 to 255")?;
        Ok(priority.number() as u8)
    }

    fn attenuation(&self) -> Result<Attenuation, SceneError> {
        if self.get("absorption").is_some() && self.get("tint").is_some() {
            // Names the second of the two.
            self.one_of(&["absorption", "tint"])?;
        }
        let distance = self.get("tintDistance");
        if let Some(tint) = self.get("tint") {
            let color = tint.transmittance()?;
            let Some(field) = distance else { return Ok(Attenuation::Tint { color, distance: 1.0 }) };
            let attenuation = Attenuation::Tint { color, distance: field.positive()? };
            let ok = attenuation.coefficient().max_element() <= DENSEST;
            field.ensure(ok, "must be longer: over it, `tint` is an absorption above 1e12")?;
            return Ok(attenuation);
        }
        if let Some(distance) = distance {
            distance.ensure(false, "says nothing without `tint`")?;
        }
        self.get("absorption").map_or(Ok(Attenuation::None), |a| a.coefficient().map(Attenuation::Absorption))
    }

    fn conductor(&self) -> Result<MaterialKind, SceneError> {
        for index in ["eta", "k"] {
            if self.get("metal").is_some() && self.get(index).is_some() {
                self.one_of(&["metal", index])?;
            }
        }
        let metal = if let Some(name) = self.get("metal") {
            Metal::Named(name.text())
        } else {
            if self.get("k").is_none() {
                // Asks for both ways at once where there is neither.
                self.one_of(&["metal", "eta"])?;
            }
            let (eta, k) = (self.need("eta")?, self.need("k")?);
            let within = |v: DVec3, least: f64| v.min_element() >= least && v.max_element() <= *INDICES.end();
            eta.ensure(within(eta.vector(), *INDICES.start()), "must lie between 0.001 and 1000 in each component")?;
            k.ensure(within(k.vector(), 0.0), "must lie between 0 and 1000 in each component")?;
            Metal::Index { eta: eta.vector(), k: k.vector() }
        };
        Ok(MaterialKind::Conductor { metal, roughness: self.roughness()? })
    }

    pub(super) fn index(&self) -> Result<f64, SceneError> {
        let Some(index) = self.get("indexOfRefraction") else { return Ok(1.5) };
        index.ensure(INDICES.contains(&index.number()), "must lie between 0.001 and 1000")?;
        Ok(index.number())
    }

    fn roughness(&self) -> Result<Value<f64>, SceneError> {
        self.get("roughness").map_or(Ok(0.0.into()), |r| r.or_texture(Found::share))
    }

    fn relief(&self) -> Result<Option<Relief>, SceneError> {
        let height = self.get("bumpHeight");
        if self.get("bump").is_none() {
            if let Some(height) = height {
                height.ensure(false, "says nothing without `bump`")?;
            }
            return Ok(self.get("normalMap").map(|map| Relief::NormalMap(map.text())));
        }
        let bump = self.one_of(&["bump", "normalMap"])?;
        Ok(Some(Relief::Bump { texture: bump.text(), height: self.need("bumpHeight")?.fits()? }))
    }
}

impl Found<'_, '_> {
    pub(super) fn share(&self) -> Result<f64, SceneError> {
        self.ensure((0.0..=1.0).contains(&self.number()), "must lie between 0 and 1")?;
        Ok(self.number())
    }

    /// What is left of light; none at all would be no number to take the logarithm of.
    fn transmittance(&self) -> Result<DVec3, SceneError> {
        let ok = self.vector().min_element() > 0.0 && self.vector().max_element() <= 1.0;
        self.ensure(ok, "must lie above 0 and at most at 1 in each component")?;
        Ok(self.vector())
    }
}

/// Whether a name can stand without quotes.
pub(crate) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b))
}
