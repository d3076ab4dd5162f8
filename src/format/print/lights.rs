//! The lights.

use std::fmt::Result;

use super::super::description::{AreaStrength, DirectionalStrength, EnvironmentRadiance, Light, PointStrength};
use super::{Name, Printer};

impl Printer<'_, '_> {
    pub(super) fn light(&mut self, light: &Light) -> Result {
        match *light {
            Light::Moving { ref maps, ref light } => {
                self.open("Moving")?;
                maps.iter().try_for_each(|map| self.map(map))?;
                self.light(light)?;
            }
            Light::Point { position, strength } => {
                self.open("PointLight")?;
                self.vector("position", position)?;
                self.point_strength(strength)?;
            }
            Light::Directional { direction, strength } => {
                self.open("DirectionalLight")?;
                self.vector("direction", direction)?;
                match strength {
                    DirectionalStrength::Color(c) => self.vector("color", c)?,
                    DirectionalStrength::Irradiance(c) => self.vector("irradiance", c)?,
                }
            }
            Light::Spot { position, aim, angle, penumbra, strength } => {
                self.open("SpotLight")?;
                self.vector("position", position)?;
                self.aim(aim)?;
                self.number("angle", angle)?;
                self.number("penumbra", penumbra)?;
                self.point_strength(strength)?;
            }
            Light::Sphere { center, radius, strength } => {
                self.open("SphereLight")?;
                self.vector("center", center)?;
                self.number("radius", radius)?;
                self.area_strength(strength)?;
            }
            Light::Disc { center, normal, radius, strength } => {
                self.open("DiscLight")?;
                self.vector("center", center)?;
                self.vector("normal", normal)?;
                self.number("radius", radius)?;
                self.area_strength(strength)?;
            }
            Light::Rectangle { corner, edge0, edge1, strength } => {
                self.open("RectangleLight")?;
                self.rectangle(corner, edge0, edge1)?;
                self.area_strength(strength)?;
            }
            Light::Environment(ref radiance) => {
                self.open("EnvironmentLight")?;
                match radiance {
                    EnvironmentRadiance::Constant(radiance) => self.vector("radiance", *radiance)?,
                    EnvironmentRadiance::Picture { path, scale, rotate } => {
                        self.field("file", Name(path))?;
                        self.number("scale", *scale)?;
                        self.number("rotate", *rotate)?;
                    }
                }
            }
        }
        self.close()
    }

    fn point_strength(&mut self, strength: PointStrength) -> Result {
        match strength {
            PointStrength::Color(c) => self.vector("color", c),
            PointStrength::Intensity(c) => self.vector("intensity", c),
            PointStrength::Power(c) => self.vector("power", c),
        }
    }

    fn area_strength(&mut self, strength: AreaStrength) -> Result {
        match strength {
            AreaStrength::Radiance(c) => self.vector("radiance", c),
            AreaStrength::Power(c) => self.vector("power", c),
        }
    }
}
