//! Converts BSDFs of Tungsten that contain others: coats, mixes and transparency.

use super::converter::TungstenMaterialConverter;
use crate::format::description::{
    ConductorDescription, DielectricAbsorption, DiffuseDescription, MAX_MIX_DEPTH, MaterialDescription,
    MaterialKindDescription, MirrorDescription, PrincipledDescription, TexturedValue,
};
use crate::format::import::SceneReadError;
use crate::format::imported_materials::{MixDefect, mix_of};
use crate::format::imported_metals::normal_reflectance;
use crate::format::imported_textures::ConvertedTexture;
use crate::format::tungsten::object::{ReadResult, TungstenObject};
use crate::format::tungsten::textures::TungstenTextureUse;
use glam::DVec3;

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
            texture @ TexturedValue::Texture(_) if transmittance == DVec3::ONE => texture,
            TexturedValue::Texture(_) => (self.albedo(&substrate)?.mean() * transmittance).into(),
        };
        let index = bsdf.number_in("ior", 1.3, 1e-2..=1e3)?;
        let root = (index - 1.0) / (index + 1.0);
        let coat_reflectance = root * root;
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

    /// Converts a `transparency` to a mix of its base and a fully transparent material.
    ///
    /// If the opacity is 1 everywhere, returns the base alone.
    pub(super) fn convert_transparency(
        &mut self,
        bsdf: &TungstenObject<'a>,
        depth: u32,
    ) -> ReadResult<MaterialKindDescription> {
        bsdf.value("albedo");
        let solid = self.required_bsdf(bsdf, "base")?;
        let opacity =
            self.textures.convert_member(self.context, bsdf, ("alpha", 1.0), TungstenTextureUse::Opacity, 1.0)?;
        let opacity = opacity.into_number();
        let kind = self.convert_bsdf(&solid, depth + 1)?;
        if opacity == TexturedValue::Constant(1.0) {
            return Ok(kind);
        }
        let clear = self.materials.list.transparent_material_name();
        let solid = self.add_mix_component("solid", &solid, kind)?;
        match self.materials.list.mix_defect(&clear, &solid) {
            Some(MixDefect::TooDeep) => Err(too_deep_error(bsdf)),
            // The transparent material bounds no body, so this is never a mix of two dielectrics.
            Some(MixDefect::TwoDielectrics) | None => Ok(mix_of(clear, solid, opacity)),
        }
    }

    /// Converts a `mixed` BSDF to a mix. Its `ratio` is the share of `bsdf0`.
    ///
    /// Caustica's scene language forbids mixes of two different dielectric bodies. Such a mix
    /// becomes the BSDF with the larger mean share, and a message tells the user.
    pub(super) fn convert_mixed(
        &mut self,
        bsdf: &TungstenObject<'a>,
        depth: u32,
    ) -> ReadResult<MaterialKindDescription> {
        self.note_tint("mixed BSDFs", bsdf)?;
        let ratio =
            self.textures.convert_member(self.context, bsdf, ("ratio", 0.5), TungstenTextureUse::Fraction, 1.0)?;
        let parts = [self.required_bsdf(bsdf, "bsdf0")?, self.required_bsdf(bsdf, "bsdf1")?];
        let kinds = [self.convert_bsdf(&parts[0], depth + 1)?, self.convert_bsdf(&parts[1], depth + 1)?];
        let [first_kind, second_kind] = kinds.clone();
        let first = self.add_mix_component("first", &parts[0], first_kind)?;
        let second = self.add_mix_component("second", &parts[1], second_kind)?;
        match self.materials.list.mix_defect(&first, &second) {
            Some(MixDefect::TooDeep) => Err(too_deep_error(bsdf)),
            Some(MixDefect::TwoDielectrics) => {
                self.context.add_note("mixes of two dielectrics become the one with the larger share", bsdf);
                let [first, second] = kinds;
                Ok(if ratio.mean().x > 0.5 { first } else { second })
            }
            // The mix of the scene language states the probability of its second material.
            None => Ok(mix_of(second, first, ratio.into_number())),
        }
    }

    fn required_bsdf(&self, bsdf: &TungstenObject<'a>, name: &str) -> ReadResult<TungstenObject<'a>> {
        let missing = || bsdf.error(format!("this BSDF has no `{name}`"), "state a BSDF or its name");
        self.context.bsdf(bsdf, name)?.ok_or_else(missing)
    }

    /// Adds the converted `bsdf` as one of the two materials of a mix. Returns the name of the
    /// added material.
    ///
    /// If another mix has added the same BSDF before, returns the name of that material. For a null
    /// interface, returns the name of the fully transparent material.
    fn add_mix_component(
        &mut self,
        suffix: &str,
        bsdf: &TungstenObject<'a>,
        kind: MaterialKindDescription,
    ) -> ReadResult<String> {
        if kind.is_null_interface() {
            return Ok(self.materials.list.transparent_material_name());
        }
        if let Some(name) = self.materials.mix_component_names.get(&bsdf.key()) {
            return Ok(name.clone());
        }
        let name = self.materials.list.unique_name(&format!("{} {suffix}", self.name));
        let description = MaterialDescription {
            name: Some(name.clone()),
            kind,
            emission: None,
            normal_perturbation: None,
            medium: None,
        };
        self.materials.push(self.context, description)?;
        self.materials.mix_component_names.insert(bsdf.key(), name.clone());
        Ok(name)
    }
}

/// Returns an error: the mix `bsdf` contains too many nested mixes.
fn too_deep_error(bsdf: &TungstenObject<'_>) -> SceneReadError {
    let message = format!("mixes nest more than {MAX_MIX_DEPTH} deep");
    bsdf.error(message, "mix fewer BSDFs, or BSDFs that are no mixes")
}
