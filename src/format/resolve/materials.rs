//! Materials of the description.

use super::{Resolver, rgb};
use crate::bsdf::{METALS, metal};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{Attenuation, MaterialKind, Metal, Spanned};
use crate::scene::{Body, Look, Material};
use glam::DVec3;

impl Resolver<'_> {
    /// All materials, each by the index that it has in the file; white where there is none.
    pub(super) fn materials(&mut self) -> Result<(), SceneError> {
        let mut materials = Vec::new();
        for (index, described) in self.description.materials.iter().enumerate() {
            materials.push(self.material(&described.kind, &materials)?);
            if let Some(name) = &described.name {
                self.names.entry(name).or_insert(index as u32);
            }
        }
        if materials.is_empty() {
            materials.push(Material::diffuse(Rgb::ONE));
        }
        for material in materials {
            self.builder.material(material);
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

    /// A material that may refer to those `before` it.
    pub(super) fn material(&self, kind: &MaterialKind, before: &[Material]) -> Result<Material, SceneError> {
        Ok(match kind {
            MaterialKind::Phong { diffuse, specular, shininess, texture: _ } => {
                Material::phong(rgb(*diffuse), rgb(*specular), *shininess as f32)
            }
            MaterialKind::Diffuse { reflectance } => Material::diffuse(rgb(*reflectance)),
            MaterialKind::Mirror { reflectance } => Material::mirror(rgb(*reflectance)),
            MaterialKind::Dielectric { index, attenuation, roughness, priority } => Material::body(Body {
                index: *index as f32,
                absorption: absorption(*attenuation),
                priority: *priority,
                roughness: *roughness as f32,
            }),
            MaterialKind::Conductor { metal, roughness } => {
                let (eta, k) = self.metal(metal)?;
                Material::conductor(eta, k, *roughness as f32)
            }
            MaterialKind::Thin { index, transmittance } => Material::thin(*index as f32, rgb(*transmittance)),
            MaterialKind::Mix { first, second, amount } => {
                let (first, second, amount) = (self.named(first)?, self.named(second)?, *amount as f32);
                let look = blend(before[first as usize].look, before[second as usize].look, amount);
                Material::mix(first, second, amount, look)
            }
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

/// Per length, by Beer's law.
fn absorption(attenuation: Attenuation) -> Rgb {
    rgb(match attenuation {
        Attenuation::None => DVec3::ZERO,
        Attenuation::Absorption(sigma) => sigma,
        Attenuation::Tint { color, distance } => -color.map(libm::log) / distance,
    })
}

/// The course's shading knows no chance: it sees the mean.
fn blend(first: Look, second: Look, amount: f32) -> Look {
    Look {
        diffuse: first.diffuse.lerp(second.diffuse, amount),
        specular: first.specular.lerp(second.specular, amount),
        shininess: (1.0 - amount) * first.shininess + amount * second.shininess,
    }
}
