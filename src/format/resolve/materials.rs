//! Materials of the description.

use super::{Resolver, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{Attenuation, Material as Described, MaterialKind, Spanned};
use crate::scene::{Body, Look, Material};
use glam::DVec3;

impl Resolver<'_> {
    /// All materials, each by the index that it has in the file; white where there is none.
    pub(super) fn materials(&mut self) -> Result<(), SceneError> {
        let mut materials = Vec::new();
        for (index, described) in self.description.materials.iter().enumerate() {
            materials.push(self.material(described, &materials)?);
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
    fn material(&self, described: &Spanned<Described>, before: &[Material]) -> Result<Material, SceneError> {
        Ok(match &described.kind {
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
            MaterialKind::Conductor { .. } | MaterialKind::Thin { .. } => {
                let help = "use Mirror or Dielectric";
                return Err(self.refuse(described.span, "this material cannot be rendered yet", help));
            }
            MaterialKind::Mix { first, second, amount } => {
                let (first, second, amount) = (self.named(first)?, self.named(second)?, *amount as f32);
                let look = blend(before[first as usize].look, before[second as usize].look, amount);
                Material::mix(first, second, amount, look)
            }
        })
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
