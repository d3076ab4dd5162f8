//! Resolves the materials of a description.

use super::media::fill_body;
use super::textures::TextureNeeds;
use super::{Resolver, rgb};
use crate::bsdf::{METALS, named_metal};
use crate::color::{DispersionFormula, GLASSES, Rgb, glass_by_name};
use crate::format::SceneError;
use crate::format::description::{
    EmissionDescription, MaterialKindDescription, MetalDescription, RefractiveIndexDescription, Spanned,
};
use crate::format::language::nearest_word;
use crate::scene::{Body, Material};

impl Resolver<'_> {
    /// Adds all materials under the indices of the description; a white one if there is none.
    pub(super) fn materials(&mut self) -> Result<(), SceneError> {
        for (index, described) in self.description.materials.iter().enumerate() {
            let mut needs = TextureNeeds::default();
            let material = self.material(&described.kind, &mut needs)?;
            let material = fill_body(self, material, described)?;
            let normals = self.normals(described, &mut needs)?;
            if let Some(EmissionDescription::Texture { name, .. }) = &described.emission {
                needs.add(&self.known(name, &(0.0..=f32::MAX))?);
            }
            self.add_needs_of_parts(&described.kind, &mut needs);
            self.texture_needs.push(needs);
            self.builder.material(material.with_normal_perturbation(normals));
            if let Some(name) = &described.name {
                self.names.entry(name).or_insert(index as u32);
            }
        }
        if self.description.materials.is_empty() {
            self.builder.material(Material::diffuse(Rgb::ONE));
        }
        Ok(())
    }

    /// Index of the material with a name.
    pub(super) fn named(&self, name: &Spanned<String>) -> Result<u32, SceneError> {
        self.names.get(name.as_str()).copied().ok_or_else(|| {
            let message = format!("there is no material named `{}`", name.value);
            SceneError::at(self.source, name.span, message, "unknown name", "define it in Materials first")
        })
    }

    /// A material without medium and with unperturbed normals. Adds the textures that it uses to
    /// `needs`.
    pub(super) fn material(
        &mut self,
        kind: &MaterialKindDescription,
        needs: &mut TextureNeeds,
    ) -> Result<Material, SceneError> {
        Ok(match kind {
            MaterialKindDescription::Phong { diffuse, specular, shininess, texture } => {
                let diffuse = self.phong_diffuse(diffuse, texture.as_ref(), needs)?;
                let specular = self.color(specular, &(0.0..=f32::MAX), needs)?;
                Material::phong(diffuse, specular, *shininess as f32)
            }
            MaterialKindDescription::Diffuse { reflectance } => {
                Material::diffuse(self.reflectance(reflectance, needs)?)
            }
            MaterialKindDescription::Mirror { reflectance } => Material::mirror(self.reflectance(reflectance, needs)?),
            MaterialKindDescription::Dielectric { refraction, attenuation, roughness, priority } => {
                let roughness = self.fraction(roughness, needs)?;
                let (index, glass) = self.refraction(refraction)?;
                let absorption = rgb(attenuation.coefficient());
                Material::rough_boundary(Body { absorption, priority: *priority, glass, ..Body::new(index) }, roughness)
            }
            MaterialKindDescription::Clear { priority } => {
                Material::smooth_boundary(Body { priority: *priority, null_interface: true, ..Body::new(1.0) })
            }
            MaterialKindDescription::Conductor { metal, roughness } => {
                let (eta, k) = self.metal(metal)?;
                Material::conductor(eta, k, self.fraction(roughness, needs)?)
            }
            MaterialKindDescription::Thin { index, transmittance } => {
                Material::thin(*index as f32, self.reflectance(transmittance, needs)?)
            }
            MaterialKindDescription::Mix { first, second, amount } => {
                let (first, second) = (self.named(first)?, self.named(second)?);
                Material::mix(first, second, self.fraction(amount, needs)?)
            }
        })
    }

    /// The refractive index at the d line, and the index of the glass if it depends on the
    /// wavelength.
    fn refraction(&mut self, described: &RefractiveIndexDescription) -> Result<(f32, Option<u32>), SceneError> {
        let glass = match described {
            RefractiveIndexDescription::Index(index) => return Ok((*index as f32, None)),
            RefractiveIndexDescription::Named(name) => self.glass_named(name)?,
            RefractiveIndexDescription::Abbe { index, abbe } => DispersionFormula::from_abbe_number(*index, *abbe),
            RefractiveIndexDescription::Glass(glass) => *glass,
        };
        Ok((glass.d_line_index(), Some(self.builder.glass(glass))))
    }

    /// The glass with a name.
    fn glass_named(&self, name: &Spanned<String>) -> Result<DispersionFormula, SceneError> {
        glass_by_name(name).ok_or_else(|| {
            let names = || GLASSES.iter().map(|g| g.0);
            let message = format!("no glass is called `{}`", name.value);
            let guess = nearest_word(name, names()).map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let known = names().collect::<Vec<_>>().join(", ");
            let help = format!("{guess}known are {known}; of others, give `cauchy`, or `indexOfRefraction` and `abbe`");
            SceneError::at(self.source, name.span, message, "unknown name", help)
        })
    }

    /// The complex refractive index η + i·k.
    fn metal(&self, described: &MetalDescription) -> Result<(Rgb, Rgb), SceneError> {
        match described {
            MetalDescription::Index { eta, k } => Ok((rgb(*eta), rgb(*k))),
            MetalDescription::Named(name) => named_metal(name).ok_or_else(|| {
                let message = format!("no metal is called `{}`", name.value);
                let help = format!("known are {}; of others, give `eta` and `k`", METALS.join(", "));
                SceneError::at(self.source, name.span, message, "unknown name", help)
            }),
        }
    }
}
