//! Conversion of MTL materials to materials of the scene language.

use super::MtlMaterial;
use crate::format::description::{
    DielectricAbsorption, DielectricDescription, EmissionDescription, MaterialDescription, MaterialKindDescription,
    MirrorDescription, PhongDescription, Span, Spanned,
};
use crate::format::line_error::MessageAndRemedy;
use glam::DVec3;
use std::path::{PathBuf, absolute};

/// Index of refraction of a transparent material whose MTL file states none: that of glass.
const DEFAULT_REFRACTIVE_INDEX: f64 = 1.5;

impl MtlMaterial {
    /// Returns the closest material of the scene language.
    ///
    /// - Dielectric with index `Ni`, if the opacity `d` is below 1, or if the illumination model is
    ///   4, 6, 7 or 9 (glass or refraction). The dielectric's tint at distance 1 is `Tf`. It has no
    ///   tint if `Tf` is white or a component of `Tf` is outside (0, 1].
    /// - Otherwise mirror with reflectance `Ks`, clamped to 1, if the model is 3, 5 or 8
    ///   (reflection), `Kd` is black, and there is no picture.
    /// - Otherwise Phong with diffuse color `Kd` times the picture. Its highlight has the color
    ///   `Ks` and the exponent `Ns`. Models 0 and 1 have no highlight.
    ///
    /// # Errors
    /// A message and a remedy if the index of a dielectric is not in \[0.001, 1000].
    pub fn to_description(&self) -> Result<MaterialDescription, MessageAndRemedy> {
        let model = self.illumination_model;
        let diffuse = self.diffuse.unwrap_or(DVec3::ONE);
        let specular = self.specular.unwrap_or(DVec3::ZERO);
        let transparent = matches!(model, Some(4 | 6 | 7 | 9)) || self.opacity.is_some_and(|d| d < 1.0);
        let kind = if transparent {
            let index = self.refractive_index.unwrap_or(DEFAULT_REFRACTIVE_INDEX);
            if !(0.001..=1000.0).contains(&index) {
                let message = format!("the material `{}` is transparent and its `Ni` is {index}", self.name);
                return Err((message, "give it an index of refraction between 0.001 and 1000"));
            }
            let tint = self
                .transmission_filter
                .filter(|f| f.min_element() > 0.0 && f.max_element() <= 1.0 && *f != DVec3::ONE);
            let attenuation =
                tint.map_or(DielectricAbsorption::None, |color| DielectricAbsorption::Tint { color, distance: 1.0 });
            MaterialKindDescription::Dielectric(DielectricDescription {
                refraction: index.into(),
                absorption: attenuation,
                roughness: 0.0.into(),
                has_multiple_scattering: true,
                priority: 0,
            })
        } else if matches!(model, Some(3 | 5 | 8)) && diffuse == DVec3::ZERO && self.diffuse_texture_path.is_none() {
            MaterialKindDescription::Mirror(MirrorDescription { reflectance: specular.min(DVec3::ONE).into() })
        } else {
            let highlights = model.is_none_or(|model| model >= 2);
            MaterialKindDescription::Phong(PhongDescription {
                diffuse: diffuse.into(),
                specular: if highlights { specular } else { DVec3::ZERO }.into(),
                shininess: self.shininess.unwrap_or(0.0),
                texture: self.diffuse_texture_path.as_ref().map(absolute_texture_path),
            })
        };
        let emission = self.emission.filter(|e| *e != DVec3::ZERO).map(EmissionDescription::Constant);
        Ok(MaterialDescription {
            name: Some(self.name.clone()),
            kind,
            emission,
            normal_perturbation: None,
            medium: None,
        })
    }
}

/// Returns `path` as an absolute path. A relative path would be looked up in the folder of the
/// scene file, but it refers to the folder of the MTL file.
fn absolute_texture_path(path: &PathBuf) -> Spanned<String> {
    let whole = absolute(path).unwrap_or_else(|_| path.clone());
    Spanned::new(whole.display().to_string(), Span::default())
}
