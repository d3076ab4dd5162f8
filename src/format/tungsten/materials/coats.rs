//! Converts the coats of Tungsten: dielectric layers over another BSDF.

use super::converter::TungstenMaterialConverter;
use crate::format::description::{
    ConductorDescription, DielectricAbsorption, DiffuseDescription, MaterialKindDescription, MirrorDescription,
    PrincipledDescription, TexturedValue,
};
use crate::format::imported_metals::normal_reflectance;
use crate::format::tungsten::object::{ReadResult, TungstenObject};
use crate::format::tungsten::textures::ConvertedTexture;

/// Reflectance at normal incidence of the clear coats of Caustica, whose refractive index is 1.5.
const CLEAR_COAT_REFLECTANCE: f64 = 0.04;

impl<'a> TungstenMaterialConverter<'_, 'a> {
    /// Converts a `smooth_coat` or `rough_coat`. `depth` is the number of BSDFs that contain it.
    ///
    /// A coat over a diffuse base becomes plastic. A coat over metal becomes metal under a clear
    /// coat of index 1.5. Any other base loses its coat. A message tells the user.
    pub(super) fn convert_coat(
        &mut self,
        bsdf: &TungstenObject<'a>,
        depth: u32,
    ) -> ReadResult<MaterialKindDescription> {
        let Some(substrate) = self.context.bsdf(bsdf, "substrate")? else {
            return Err(bsdf.error("this coat has no base", "state it as `substrate`"));
        };
        self.note_tint("coats", bsdf)?;
        let base = self.convert_bsdf(&substrate, depth + 1)?;
        let (reflectance, roughness) = match &base {
            MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }) => {
                let albedo = match reflectance {
                    TexturedValue::Constant(color) => ConvertedTexture::Constant(*color),
                    TexturedValue::Texture(_) => self.albedo(&substrate)?,
                };
                return self.convert_plastic(bsdf, albedo);
            }
            MaterialKindDescription::Mirror(MirrorDescription { reflectance }) => (reflectance.clone(), 0.0.into()),
            MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, .. }) => {
                (normal_reflectance(metal).into(), roughness.clone())
            }
            MaterialKindDescription::Phong(_)
            | MaterialKindDescription::Dielectric(_)
            | MaterialKindDescription::NullInterface(_)
            | MaterialKindDescription::Thin(_)
            | MaterialKindDescription::CoatedDiffuse(_)
            | MaterialKindDescription::DiffuseTransmission(_)
            | MaterialKindDescription::Principled(_)
            | MaterialKindDescription::Mix(_) => {
                bsdf.mark_as_read();
                self.context.add_note("coats over other bases than diffuse ones and metals are left out", bsdf);
                return Ok(base);
            }
        };
        self.context.add_note("coats over metal become clear coats of index 1.5 with their reflectance", bsdf);
        let transmittance = self.coat_transmittance(bsdf)?;
        let base_color = match reflectance {
            TexturedValue::Constant(color) => (color * transmittance).into(),
            texture @ TexturedValue::Texture(_) => texture,
        };
        let index = bsdf.number_in("ior", 1.3, 1e-2..=1e3)?;
        let coat_reflectance = ((index - 1.0) / (index + 1.0)).powi(2);
        Ok(MaterialKindDescription::Principled(PrincipledDescription {
            base_color,
            metallic: 1.0.into(),
            roughness,
            eta: 1.5,
            transmission: 0.0.into(),
            absorption: DielectricAbsorption::None,
            clearcoat: (coat_reflectance / CLEAR_COAT_REFLECTANCE).min(1.0).into(),
            clearcoat_roughness: self.coat_roughness(bsdf)?.mean().x,
            has_multiple_scattering: false,
        }))
    }
}
