//! The media, and references to them.

use glam::DVec3;

use super::super::description::{Coefficients, Density, Extent, MaterialKind, Medium, Phase, Spanned};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::fields::{Fields, Kind};
use super::{Parser, clip, suggest};

const MEDIA: [&str; 3] = ["numMedia", "Medium", "Cloud"];

const LIGHT: [(&str, Kind); 7] = [
    ("absorption", Kind::Vector),
    ("scattering", Kind::Vector),
    ("extinction", Kind::Vector),
    ("albedo", Kind::Vector),
    ("emission", Kind::Vector),
    ("phase", Kind::Name),
    ("anisotropy", Kind::Number),
];
const EXTENT: [(&str, Kind); 3] = [("min", Kind::Vector), ("max", Kind::Vector), ("Transform", Kind::Maps)];
const GRID: [(&str, Kind); 2] = [("grid", Kind::Name), ("densityScale", Kind::Number)];
const CLOUD: [(&str, Kind); 6] = [
    ("cover", Kind::Number),
    ("softness", Kind::Number),
    ("octaves", Kind::Integer),
    ("frequency", Kind::Number),
    ("seed", Kind::Integer),
    ("resolution", Kind::Integer),
];

const PHASES: [&str; 3] = ["isotropic", "rayleigh", "henyey-greenstein"];

impl<'a> Parser<'a> {
    pub fn media(&mut self, block: Token<'a>) -> Result<(), SceneError> {
        if !self.materials.is_empty() {
            let message = "`Media` stand behind the `Materials` that may use them".to_owned();
            let help = "put the Media ahead of the Materials".to_owned();
            return Err(self.lexer.error(block.span(), message, "too late", help));
        }
        self.media.clear();
        let mut count = None;
        self.open(block)?;
        while let Some(word) = self.word()? {
            match word.text {
                "numMedia" => self.count(word, &mut count)?,
                text if MEDIA.contains(&text) => {
                    let medium = self.medium(word)?;
                    self.media.push(Spanned::new(medium, word.span()));
                }
                _ => return Err(self.unexpected(word, &MEDIA)),
            }
        }
        self.check_count("numMedia", count, self.media.len(), "medium")
    }

    fn medium(&mut self, word: Token<'a>) -> Result<Medium, SceneError> {
        let Some(name) = self.block_name_of("medium")? else {
            let message = format!("this `{}` has no name", word.text);
            let help = format!("name it, so that materials can use it: `{} name {{ … }}`", word.text);
            return Err(self.lexer.error(word.span(), message, "this medium", help));
        };
        if self.media.iter().any(|medium| medium.value.name == name.value) {
            let message = format!("two media are called `{}`", clip(&name.value));
            return Err(self.lexer.error(name.span, message, "the second", "give it another name".to_owned()));
        }
        let cloud = word.text == "Cloud";
        let own: &[(&str, Kind)] = if cloud { &CLOUD } else { &GRID };
        let f = self.fields(word, &[&LIGHT, own, &EXTENT].concat())?;
        Ok(Medium {
            name: name.value,
            coefficients: f.coefficients()?,
            emission: f.get("emission").map_or(Ok(DVec3::ZERO), |e| e.coefficient())?,
            phase: f.phase()?,
            density: if cloud { f.cloud()? } else { f.grid()? },
        })
    }

    /// The medium that fills the body of a material.
    pub(super) fn contents(&self, f: &Fields<'a>) -> Result<Option<Spanned<String>>, SceneError> {
        let Some(name) = f.get("medium").map(|m| m.text()) else { return Ok(None) };
        self.check_medium(&name, "ahead of the Materials")?;
        Ok(Some(name))
    }

    /// Refuses a name that no medium has.
    pub(super) fn check_medium(&self, name: &Spanned<String>, place: &str) -> Result<(), SceneError> {
        let names = || self.media.iter().map(|medium| medium.value.name.as_str());
        if names().any(|known| known == name.value) {
            return Ok(());
        }
        let message = format!("no medium is called `{}`", clip(&name.value));
        let listed = || names().take(8).map(clip).collect::<Vec<_>>().join(", ");
        let help = match suggest::nearest(&name.value, names()) {
            Some(nearest) => format!("did you mean `{}`?", clip(nearest)),
            None if self.media.is_empty() => format!("define it {place}: `Media {{ Medium name {{ … }} }}`"),
            None => format!("known are {}; define it with them", listed()),
        };
        Err(self.lexer.error(name.span, message, "unknown name", help))
    }
}

impl Fields<'_> {
    fn coefficients(&self) -> Result<Coefficients, SceneError> {
        for whole in ["extinction", "albedo"] {
            for part in ["absorption", "scattering"] {
                if self.get(whole).is_some() && self.get(part).is_some() {
                    // Names the second of the two.
                    self.one_of(&[part, whole])?;
                }
            }
        }
        let Some(extinction) = self.get("extinction") else {
            if let Some(albedo) = self.get("albedo") {
                albedo.ensure(false, "says nothing without `extinction`")?;
            }
            let part = |name| self.get(name).map_or(Ok(DVec3::ZERO), |c| c.coefficient());
            return Ok(Coefficients::Parts { absorption: part("absorption")?, scattering: part("scattering")? });
        };
        let albedo = self.need("albedo")?.reflectance()?;
        Ok(Coefficients::Whole { extinction: extinction.coefficient()?, albedo })
    }

    fn phase(&self) -> Result<Phase, SceneError> {
        let (phase, anisotropy) = (self.get("phase"), self.get("anisotropy"));
        let word = phase.map(|phase| phase.text().value);
        if let Some(phase) = phase {
            let listed = PHASES.map(|p| format!("`{p}`")).join(", ");
            phase.ensure(PHASES.contains(&phase.text().as_str()), &format!("must be one of {listed}"))?;
        }
        match (word.as_deref(), anisotropy) {
            (None | Some("isotropic"), None) => Ok(Phase::Isotropic),
            (Some("rayleigh"), None) => Ok(Phase::Rayleigh),
            (None | Some("henyey-greenstein"), Some(g)) => {
                let rule = "must lie inside -1 … 1, by 1e-7 at least";
                g.ensure(g.number().abs() <= 1.0 - 1e-7, rule)?;
                Ok(Phase::HenyeyGreenstein(g.number()))
            }
            (_, Some(g)) => {
                g.ensure(false, "is that of `phase henyey-greenstein`: leave one of both out")?;
                Ok(Phase::Isotropic)
            }
            (_, None) => Ok(Phase::HenyeyGreenstein(self.need("anisotropy")?.number())),
        }
    }

    fn grid(&self) -> Result<Density, SceneError> {
        let Some(grid) = self.get("grid") else {
            let rest = EXTENT.iter().map(|(name, _)| *name).chain(["densityScale"]);
            for field in rest.filter_map(|name| self.get(name)) {
                field.ensure(false, "says nothing without `grid`")?;
            }
            return Ok(Density::Even);
        };
        let scale = self.get("densityScale").map_or(Ok(1.0), |s| s.positive())?;
        Ok(Density::Grid { path: grid.text(), scale, extent: self.extent()? })
    }

    fn cloud(&self) -> Result<Density, SceneError> {
        let whole = |name: &str, least: u32, most: u32, default: u32| {
            let Some(field) = self.get(name) else { return Ok(default) };
            let within = (f64::from(least)..=f64::from(most)).contains(&field.number());
            field.ensure(within, &format!("must be a whole number from {least} to {most}"))?;
            Ok(field.number() as u32)
        };
        Ok(Density::Cloud {
            cover: self.get("cover").map_or(Ok(0.5), |c| c.share())?,
            softness: self.get("softness").map_or(Ok(0.3), |s| s.share())?,
            octaves: whole("octaves", 1, 16, 5)?,
            frequency: self.get("frequency").map_or(Ok(4.0), |f| f.positive())?,
            seed: whole("seed", 0, u32::MAX, 0)?,
            resolution: whole("resolution", 2, 512, 96)?,
            extent: self.extent()?,
        })
    }

    fn extent(&self) -> Result<Extent, SceneError> {
        let (min, max) = (self.need("min")?.vector(), self.need("max")?);
        let sides = max.vector() - min;
        max.ensure(sides.min_element() > 0.0 && sides.is_finite(), "must be above `min` in each component")?;
        Ok(Extent { min, max: max.vector(), maps: self.get("Transform").map_or(Vec::new(), |t| t.maps()) })
    }

    /// A place without a surface.
    pub(super) fn clear(&self) -> Result<MaterialKind, SceneError> {
        for field in ["emission", "emissionScale"].iter().filter_map(|name| self.get(name)) {
            field.ensure(false, "wants a surface, and this has none: give `emission` to its medium")?;
        }
        for field in ["bump", "bumpHeight", "normalMap"].iter().filter_map(|name| self.get(name)) {
            field.ensure(false, "wants a surface, and this has none: leave it out")?;
        }
        Ok(MaterialKind::Clear { priority: self.priority()? })
    }
}
