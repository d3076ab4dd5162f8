//! The materials.

use std::fmt::Result;

use super::super::description::{Attenuation, Material, MaterialKind, Metal};
use super::super::parser::is_identifier;
use super::{Name, Printer, Quoted};

impl Printer<'_, '_> {
    pub(super) fn material(&mut self, material: &Material) -> Result {
        let keyword = match material.kind {
            MaterialKind::Phong { .. } => "PhongMaterial",
            MaterialKind::Diffuse { .. } => "Diffuse",
            MaterialKind::Mirror { .. } => "Mirror",
            MaterialKind::Dielectric { .. } => "Dielectric",
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
                self.vector("diffuseColor", *diffuse)?;
                self.vector("specularColor", *specular)?;
                self.number("shininess", *shininess)?;
                texture.as_ref().map_or(Ok(()), |name| self.field("texture", Name(name)))?;
            }
            MaterialKind::Diffuse { reflectance } | MaterialKind::Mirror { reflectance } => {
                self.vector("reflectance", *reflectance)?;
            }
            MaterialKind::Dielectric { index, attenuation, roughness, priority } => {
                self.number("indexOfRefraction", *index)?;
                match *attenuation {
                    Attenuation::None => {}
                    Attenuation::Absorption(absorption) => self.vector("absorption", absorption)?,
                    Attenuation::Tint { color, distance } => {
                        self.vector("tint", color)?;
                        self.number("tintDistance", distance)?;
                    }
                }
                self.number("roughness", *roughness)?;
                self.field("priority", priority)?;
            }
            MaterialKind::Conductor { metal, roughness } => {
                match metal {
                    Metal::Named(name) => self.field("metal", Name(name))?,
                    Metal::Index { eta, k } => {
                        self.vector("eta", *eta)?;
                        self.vector("k", *k)?;
                    }
                }
                self.number("roughness", *roughness)?;
            }
            MaterialKind::Thin { index, transmittance } => {
                self.number("indexOfRefraction", *index)?;
                self.vector("transmittance", *transmittance)?;
            }
            MaterialKind::Mix { first, second, amount } => {
                self.field("first", Name(first))?;
                self.field("second", Name(second))?;
                self.number("amount", *amount)?;
            }
        }
        self.optional("emission", material.emission)?;
        self.close()
    }
}
