//! The media.

use std::fmt::Result;

use glam::DVec3;

use super::super::description::{Coefficients, Density, Extent, Medium, Phase};
use super::textures::Reference;
use super::{Name, Printer};

impl Printer<'_, '_> {
    pub(super) fn medium(&mut self, medium: &Medium) -> Result {
        let keyword = if matches!(medium.density, Density::Cloud { .. }) { "Cloud" } else { "Medium" };
        self.open(format_args!("{keyword} {}", Reference(&medium.name)))?;
        match medium.coefficients {
            Coefficients::Parts { absorption, scattering } => {
                self.vector("absorption", absorption)?;
                self.vector("scattering", scattering)?;
            }
            Coefficients::Whole { extinction, albedo } => {
                self.vector("extinction", extinction)?;
                self.vector("albedo", albedo)?;
            }
        }
        if medium.emission != DVec3::ZERO {
            self.vector("emission", medium.emission)?;
        }
        match medium.phase {
            Phase::Isotropic => {}
            Phase::Rayleigh => self.field("phase", "rayleigh")?,
            Phase::HenyeyGreenstein(g) => self.number("anisotropy", g)?,
        }
        match &medium.density {
            Density::Even => {}
            Density::Grid { path, scale, extent } => {
                self.field("grid", Name(path))?;
                self.number("densityScale", *scale)?;
                self.extent(extent)?;
            }
            Density::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
                self.number("cover", *cover)?;
                self.number("softness", *softness)?;
                self.field("octaves", octaves)?;
                self.number("frequency", *frequency)?;
                self.field("seed", seed)?;
                self.field("resolution", resolution)?;
                self.extent(extent)?;
            }
        }
        self.close()
    }

    fn extent(&mut self, extent: &Extent) -> Result {
        self.vector("min", extent.min)?;
        self.vector("max", extent.max)?;
        self.maps(&extent.maps)
    }
}
