//! Materials of the description.

use super::textures::Worn;
use super::{Resolver, rgb};
use crate::bsdf::{METALS, metal};
use crate::color::{GLASSES, Glass, Rgb, glass};
use crate::format::SceneError;
use crate::format::description::{Emission, MaterialKind, Metal, Refraction, Spanned};
use crate::format::language::nearest;
use crate::scene::{Body, Coat, Material, PhongAppearance};

impl Resolver<'_> {
    /// All materials, each by the index that it has in the file; white where there is none.
    pub(super) fn materials(&mut self) -> Result<(), SceneError> {
        let mut looks = Vec::new();
        for (index, described) in self.description.materials.iter().enumerate() {
            let mut worn = Worn::default();
            let (mut material, coat) = self.material(&described.kind, &looks, &mut worn)?;
            super::media::fill_body(self, &mut material, described)?;
            let relief = self.relief(described, &mut worn)?;
            if let Some(Emission::Texture { name, .. }) = &described.emission {
                worn.by(&self.known(name, &(0.0..=f32::MAX))?);
            }
            self.worn_by_parts(&described.kind, &mut worn);
            self.worn.push(worn);
            looks.push(material.look);
            match Self::dress(coat, relief) {
                Some(dress) => self.builder.dressed(material, dress),
                None => self.builder.material(material),
            };
            if let Some(name) = &described.name {
                self.names.entry(name).or_insert(index as u32);
            }
        }
        if looks.is_empty() {
            self.builder.material(Material::diffuse(Rgb::ONE));
        }
        Ok(())
    }

    /// Index of the material of a name.
    pub(super) fn named(&self, name: &Spanned<String>) -> Result<u32, SceneError> {
        self.names.get(name.as_str()).copied().ok_or_else(|| {
            let message = format!("there is no material named `{}`", name.value);
            SceneError::at(self.source, name.span, message, "unknown name", "define it in Materials first")
        })
    }

    /// A material of means, which may refer to those whose looks are known, and what of it follows textures.
    pub(super) fn material(
        &mut self,
        kind: &MaterialKind,
        looks: &[PhongAppearance],
        worn: &mut Worn,
    ) -> Result<(Material, Coat), SceneError> {
        Ok(match kind {
            MaterialKind::Phong { diffuse, specular, shininess, texture } => {
                let (diffuse, kd) = self.phong_diffuse(diffuse, texture.as_ref(), worn)?;
                let (specular, ks) = self.tint(specular, &(0.0..=f32::MAX), worn)?;
                let shininess = *shininess as f32;
                (Material::phong(kd, ks, shininess), worn.coat(Coat::Phong { diffuse, specular, shininess }))
            }
            MaterialKind::Diffuse { reflectance } => {
                let (tint, mean) = self.share(reflectance, worn)?;
                (Material::diffuse(mean), worn.coat(Coat::Diffuse(tint)))
            }
            MaterialKind::Mirror { reflectance } => {
                let (tint, mean) = self.share(reflectance, worn)?;
                (Material::mirror(mean), worn.coat(Coat::Mirror(tint)))
            }
            MaterialKind::Dielectric { refraction, attenuation, roughness, priority } => {
                let (texture, roughness) = self.degree(roughness, worn)?;
                let (index, glass) = self.refraction(refraction)?;
                let absorption = rgb(attenuation.coefficient());
                let body = Body { absorption, priority: *priority, roughness, glass, ..Body::new(index) };
                (Material::body(body), texture.map_or(Coat::Plain, Coat::Boundary))
            }
            MaterialKind::Clear { priority } => {
                let place = Body { priority: *priority, clear: true, ..Body::new(1.0) };
                (Material::body(place), Coat::Plain)
            }
            MaterialKind::Conductor { metal, roughness } => {
                let (eta, k) = self.metal(metal)?;
                let (texture, alpha) = self.degree(roughness, worn)?;
                let coat = texture.map_or(Coat::Plain, |roughness| Coat::Conductor { eta, k, roughness });
                (Material::conductor(eta, k, alpha), coat)
            }
            MaterialKind::Thin { index, transmittance } => {
                let (transmittance, mean) = self.share(transmittance, worn)?;
                let eta = *index as f32;
                (Material::thin(eta, mean), worn.coat(Coat::Thin { eta, transmittance }))
            }
            MaterialKind::Mix { first, second, amount } => {
                let (first, second) = (self.named(first)?, self.named(second)?);
                let (texture, amount) = self.degree(amount, worn)?;
                let look = blend(looks[first as usize], looks[second as usize], amount);
                (Material::mix(first, second, amount, look), texture.map_or(Coat::Plain, Coat::Mix))
            }
        })
    }

    /// The index of refraction at the line d, and that of the glass where it depends on the wavelength.
    fn refraction(&mut self, described: &Refraction) -> Result<(f32, Option<u32>), SceneError> {
        let glass = match described {
            Refraction::Index(index) => return Ok((*index as f32, None)),
            Refraction::Named(name) => self.substance(name)?,
            Refraction::Abbe { index, abbe } => Glass::of_abbe(*index, *abbe),
            Refraction::Own(glass) => *glass,
        };
        Ok((glass.index_d(), Some(self.builder.glass(glass))))
    }

    fn substance(&self, name: &Spanned<String>) -> Result<Glass, SceneError> {
        glass(name).ok_or_else(|| {
            let names = || GLASSES.iter().map(|g| g.0);
            let message = format!("no glass is called `{}`", name.value);
            let guess = nearest(name, names()).map_or(String::new(), |n| format!("did you mean `{n}`? "));
            let known = names().collect::<Vec<_>>().join(", ");
            let help = format!("{guess}known are {known}; of others, give `cauchy`, or `indexOfRefraction` and `abbe`");
            SceneError::at(self.source, name.span, message, "unknown name", help)
        })
    }

    /// η and k.
    fn metal(&self, described: &Metal) -> Result<(Rgb, Rgb), SceneError> {
        match described {
            Metal::Index { eta, k } => Ok((rgb(*eta), rgb(*k))),
            Metal::Named(name) => metal(name).ok_or_else(|| {
                let message = format!("no metal is called `{}`", name.value);
                let help = format!("known are {}; of others, give `eta` and `k`", METALS.join(", "));
                SceneError::at(self.source, name.span, message, "unknown name", help)
            }),
        }
    }
}

/// The course's shading knows no chance: it sees the mean.
fn blend(first: PhongAppearance, second: PhongAppearance, amount: f32) -> PhongAppearance {
    PhongAppearance {
        diffuse: first.diffuse.lerp(second.diffuse, amount),
        specular: first.specular.lerp(second.specular, amount),
        shininess: (1.0 - amount) * first.shininess + amount * second.shininess,
    }
}
