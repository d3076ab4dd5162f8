//! The lights.

use glam::DVec3;

use super::super::description::{
    AreaStrength, DirectionalStrength, EnvironmentRadiance, Light, PointStrength, Spanned,
};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::Parser;
use super::fields::{Fields, Found, Kind};

const LIGHTS: [&str; 9] = [
    "numLights",
    "Moving",
    "PointLight",
    "DirectionalLight",
    "SpotLight",
    "SphereLight",
    "DiscLight",
    "RectangleLight",
    "EnvironmentLight",
];

/// Those that have a place or a direction to move.
const MOVABLE: &[&str] =
    &["Moving", "PointLight", "DirectionalLight", "SpotLight", "SphereLight", "DiscLight", "RectangleLight"];

const COLOR: (&str, Kind) = ("color", Kind::Vector);
const INTENSITY: (&str, Kind) = ("intensity", Kind::Vector);
const POWER: (&str, Kind) = ("power", Kind::Vector);
const RADIANCE: (&str, Kind) = ("radiance", Kind::Vector);

impl<'a> Parser<'a> {
    pub fn lights(&mut self, block: Token<'a>) -> Result<Vec<Spanned<Light>>, SceneError> {
        let mut lights = Vec::new();
        let mut count = None;
        let mut surrounded = false;
        self.open(block)?;
        while let Some(word) = self.word()? {
            if word.text == "EnvironmentLight" && std::mem::replace(&mut surrounded, true) {
                return Err(self.twice(word));
            }
            match word.text {
                "numLights" => self.count(word, &mut count)?,
                _ => lights.push(Spanned::new(self.light(word)?, word.span())),
            }
        }
        self.check_count("numLights", count, lights.len(), "light")?;
        Ok(lights)
    }

    fn light(&mut self, word: Token<'a>) -> Result<Light, SceneError> {
        use Kind::{Number, Vector};
        match word.text {
            "Moving" => {
                let (maps, light) =
                    self.moving(word, MOVABLE, |parser, word| Ok(Spanned::new(parser.light(word)?, word.span())))?;
                Ok(Light::Moving { maps, light: Box::new(light) })
            }
            "PointLight" => {
                let f = self.fields(word, &[("position", Vector), COLOR, INTENSITY, POWER])?;
                Ok(Light::Point { position: f.need("position")?.vector(), strength: f.point_strength()? })
            }
            "DirectionalLight" => {
                let f = self.fields(word, &[("direction", Vector), COLOR, ("irradiance", Vector)])?;
                let strength = f.one_of(&["color", "irradiance"])?;
                let colour = strength.colour()?;
                let strength = match strength.name() {
                    "color" => DirectionalStrength::Color(colour),
                    _ => DirectionalStrength::Irradiance(colour),
                };
                Ok(Light::Directional { direction: f.need("direction")?.direction()?, strength })
            }
            "SpotLight" => {
                let aim = [("direction", Vector), ("lookAt", Vector), ("angle", Number), ("penumbra", Number)];
                let known = [&[("position", Vector), COLOR, INTENSITY, POWER], &aim[..]].concat();
                let f = self.fields(word, &known)?;
                f.spot()
            }
            "SphereLight" => {
                let f = self.fields(word, &[("center", Vector), ("radius", Number), RADIANCE, POWER])?;
                Ok(Light::Sphere {
                    center: f.need("center")?.vector(),
                    radius: f.need("radius")?.positive()?,
                    strength: f.area_strength()?,
                })
            }
            "DiscLight" => {
                let known = [("center", Vector), ("normal", Vector), ("radius", Number), RADIANCE, POWER];
                let f = self.fields(word, &known)?;
                Ok(Light::Disc {
                    center: f.need("center")?.vector(),
                    normal: f.need("normal")?.direction()?,
                    radius: f.need("radius")?.positive()?,
                    strength: f.area_strength()?,
                })
            }
            "RectangleLight" => {
                let known = [("corner", Vector), ("edge0", Vector), ("edge1", Vector), RADIANCE, POWER];
                let f = self.fields(word, &known)?;
                let (corner, edge0, edge1) = f.rectangle()?;
                Ok(Light::Rectangle { corner, edge0, edge1, strength: f.area_strength()? })
            }
            "EnvironmentLight" => {
                let known = [RADIANCE, ("file", Kind::Name), ("scale", Number), ("rotate", Number)];
                Ok(Light::Environment(self.fields(word, &known)?.environment()?))
            }
            _ => Err(self.unexpected(word, &LIGHTS)),
        }
    }
}

impl Fields<'_> {
    fn spot(&self) -> Result<Light, SceneError> {
        let position = self.need("position")?.vector();
        let (aim, _) = self.aim("position", position)?;
        let angle = self.need("angle")?;
        angle.ensure(angle.number() > 0.0 && angle.number() <= 360.0, "must lie between 0 and 360 degrees")?;
        let angle = angle.number();
        let penumbra = self.get("penumbra");
        if let Some(rim) = penumbra {
            let ok = rim.number() >= 0.0 && rim.number() <= angle / 2.0;
            rim.ensure(ok, "must lie between 0 and half of the cone's angle")?;
        }
        let penumbra = penumbra.map_or(0.0, |rim| rim.number());
        Ok(Light::Spot { position, aim, angle, penumbra, strength: self.point_strength()? })
    }

    fn environment(&self) -> Result<EnvironmentRadiance, SceneError> {
        let radiance = self.one_of(&["file", "radiance"])?;
        let (scale, rotate) = (self.get("scale"), self.get("rotate"));
        if radiance.name() == "radiance" {
            for field in scale.iter().chain(&rotate) {
                field.ensure(false, "says nothing without `file`")?;
            }
            return Ok(EnvironmentRadiance::Constant(radiance.colour()?));
        }
        Ok(EnvironmentRadiance::Picture {
            path: radiance.text(),
            scale: scale.map_or(Ok(1.0), |s| s.amount())?,
            rotate: rotate.map_or(0.0, |r| r.number()),
        })
    }

    fn point_strength(&self) -> Result<PointStrength, SceneError> {
        let strength = self.one_of(&["color", "intensity", "power"])?;
        let colour = strength.colour()?;
        Ok(match strength.name() {
            "color" => PointStrength::Color(colour),
            "intensity" => PointStrength::Intensity(colour),
            _ => PointStrength::Power(colour),
        })
    }

    fn area_strength(&self) -> Result<AreaStrength, SceneError> {
        let strength = self.one_of(&["radiance", "power"])?;
        let colour = strength.colour()?;
        Ok(match strength.name() {
            "radiance" => AreaStrength::Radiance(colour),
            _ => AreaStrength::Power(colour),
        })
    }

    /// Corner and edges of a parallelogram that has an area.
    pub fn rectangle(&self) -> Result<(DVec3, DVec3, DVec3), SceneError> {
        let corner = self.need("corner")?.vector();
        let edge0 = self.need("edge0")?.direction()?;
        let last: Found = self.need("edge1")?;
        let edge1 = last.direction()?;
        // Rounding of the edges alone leaves a sine of about 1e-16 between parallel ones.
        let sine = edge0.normalize().cross(edge1.normalize()).length();
        last.ensure(sine > 1e-12, "must not be parallel to `edge0`: the area would be 0")?;
        Ok((corner, edge0, edge1))
    }
}
