//! The materials.

use std::fmt::Result;

use super::super::description::{Attenuation, Material, MaterialKind, Metal, Refraction};
use super::super::parser::is_identifier;
use super::{Name, Numbers, Printer, Quoted};
use crate::color::Glass;

impl Printer<'_, '_> {
    pub(super) fn material(&mut self, material: &Material) -> Result {
        let keyword = match material.kind {
            MaterialKind::Phong { .. } => "PhongMaterial",
            MaterialKind::Diffuse { .. } => "Diffuse",
            MaterialKind::Mirror { .. } => "Mirror",
            MaterialKind::Dielectric { .. } => "Dielectric",
            MaterialKind::Clear { .. } => "Clear",
            MaterialKind::Conductor { .. } => "Conductor",
            MaterialKind::Thin { .. } => "Thin",
            MaterialKind::Mix { .. } => "Mix",
        };
        match &material.name {
            None => self.open(keyword)?,
            Some(name) if is_identifier(name) => self.open(format_args!("{keyword} {name}"))?,
            Some(name) => self.open(format_args!("{keyword} {}", Quoted(name)))?,
        }
        match &material.kind {
            MaterialKind::Phong { diffuse, specular, shininess, texture } => {
                self.tint("diffuseColor", diffuse)?;
                self.tint("specularColor", specular)?;
                self.number("shininess", *shininess)?;
                texture.as_ref().map_or(Ok(()), |name| self.field("texture", Name(name)))?;
            }
            MaterialKind::Diffuse { reflectance } | MaterialKind::Mirror { reflectance } => {
                self.tint("reflectance", reflectance)?;
            }
            MaterialKind::Dielectric { refraction, attenuation, roughness, priority } => {
                self.refraction(refraction)?;
                match *attenuation {
                    Attenuation::None => {}
                    Attenuation::Absorption(absorption) => self.vector("absorption", absorption)?,
                    Attenuation::Tint { color, distance } => {
                        self.vector("tint", color)?;
                        self.number("tintDistance", distance)?;
                    }
                }
                self.degree("roughness", roughness)?;
                self.field("priority", priority)?;
            }
            MaterialKind::Clear { priority } => self.field("priority", priority)?,
            MaterialKind::Conductor { metal, roughness } => {
                match metal {
                    Metal::Named(name) => self.field("metal", Name(name))?,
                    Metal::Index { eta, k } => {
                        self.vector("eta", *eta)?;
                        self.vector("k", *k)?;
                    }
                }
                self.degree("roughness", roughness)?;
            }
            MaterialKind::Thin { index, transmittance } => {
                self.number("indexOfRefraction", *index)?;
                self.tint("transmittance", transmittance)?;
            }
            MaterialKind::Mix { first, second, amount } => {
                self.field("first", Name(first))?;
                self.field("second", Name(second))?;
                self.degree("amount", amount)?;
            }
        }
        material.medium.as_ref().map_or(Ok(()), |medium| self.field("medium", Name(medium)))?;
        material.relief.as_ref().map_or(Ok(()), |relief| self.relief(relief))?;
        material.emission.as_ref().map_or(Ok(()), |emission| self.emission(emission))?;
        self.close()
    }

    fn refraction(&mut self, refraction: &Refraction) -> Result {
        match refraction {
            Refraction::Index(index) => self.number("indexOfRefraction", *index),
            Refraction::Named(name) => self.field("glass", Name(name)),
            Refraction::Abbe { index, abbe } => {
                self.number("indexOfRefraction", *index)?;
                self.number("abbe", *abbe)
            }
            Refraction::Own(Glass::Cauchy { a, b, c }) => self.field("cauchy", Numbers(&[*a, *b, *c])),
            Refraction::Own(Glass::Sellmeier { b, c }) => {
                // Terms that are not there take no words.
                let terms = (1..b.len()).rev().find(|i| (b[*i], c[*i]) != (0.0, 0.0)).map_or(1, |last| last + 1);
                self.field("sellmeierB", Numbers(&b[..terms]))?;
                self.field("sellmeierC", Numbers(&c[..terms]))
            }
        }
    }
}
