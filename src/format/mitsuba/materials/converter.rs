//! Converts one BSDF of Mitsuba to a material of the scene language.

use super::MitsubaMaterials;
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::description::{
    CoatedDiffuseDescription, DielectricAbsorption, DielectricDescription, DiffuseDescription,
    DiffuseTransmissionDescription, MaterialKindDescription, NormalPerturbationDescription, NullInterfaceDescription,
    PhongDescription, PrincipledDescription, TexturedValue, ThinDielectricDescription,
};
use crate::format::imported_textures::ConvertedTexture;
use crate::format::mitsuba::conductors::convert_conductor;
use crate::format::mitsuba::context::ImportContext;
use crate::format::mitsuba::dielectrics::{is_index_matched, refractive_index};
use crate::format::mitsuba::files::ReadResult;
use crate::format::mitsuba::meshes::TexcoordConvention;
use crate::format::mitsuba::textures::{MitsubaTextureUse, MitsubaTextures, sign_of_scales};
use crate::format::mitsuba::tree::{MitsubaObject, ObjectClass};
use glam::DVec3;
use std::rc::Rc;

/// Greatest nesting depth of BSDFs.
const MAX_BSDF_DEPTH: u32 = 24;

/// A Mitsuba BSDF after conversion: reflection and transmission, and a bump map or normal map.
#[derive(Clone)]
pub(super) struct ConvertedBsdf {
    /// Reflection and transmission.
    pub kind: MaterialKindDescription,
    /// Bump map or normal map; `None` without one.
    pub normal: Option<NormalPerturbationDescription>,
}

impl From<MaterialKindDescription> for ConvertedBsdf {
    fn from(kind: MaterialKindDescription) -> Self {
        Self { kind, normal: None }
    }
}

/// Returns a diffuse material of the given reflectance.
pub(super) fn diffuse_description(reflectance: DVec3) -> MaterialKindDescription {
    MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: reflectance.into() })
}

/// Returns the first of `nested`, the BSDFs inside `bsdf`. Fails if there is none.
pub(super) fn first_nested<'s>(
    bsdf: &MitsubaObject,
    nested: &'s [(String, Rc<MitsubaObject>)],
) -> ReadResult<&'s Rc<MitsubaObject>> {
    let message = || format!("`{}` has no nested BSDF", bsdf.plugin);
    let missing = || bsdf.place.error(message(), "nest a `bsdf` in it, or refer to one");
    nested.first().map(|(_, inner)| inner).ok_or_else(missing)
}

/// Converter of one Mitsuba BSDF to a material, with the tables that it needs and fills.
pub(super) struct MitsubaMaterialConverter<'c, 'a> {
    /// Materials of the imported scene so far. The converter adds the two materials of each mix.
    pub materials: &'c mut MitsubaMaterials,
    /// Textures of the imported scene.
    pub textures: &'c mut MitsubaTextures,
    /// Objects, files and messages of the import.
    pub context: &'c ImportContext<'a>,
    /// Relation between the texture coordinates (u, v) of the shape with this material in Caustica
    /// and in Mitsuba: equal, or with v flipped.
    pub convention: TexcoordConvention,
    /// Name of the material in the imported scene. If the material is a mix, the names of its two
    /// parts begin with this name.
    pub name: &'c str,
}

impl MitsubaMaterialConverter<'_, '_> {
    /// Returns the converted `bsdf`. Reuses an earlier result for the same BSDF and the same
    /// convention for texture coordinates (`self.convention`).
    ///
    /// `depth` is the number of BSDFs that contain this one.
    pub(super) fn convert_bsdf(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        // Without this cache, a chain of blends that each use the next one twice takes exponential
        // time.
        let key = (Rc::as_ptr(bsdf), self.convention);
        if let Some(known) = self.materials.surfaces.get(&key) {
            return Ok(known.clone());
        }
        if depth > MAX_BSDF_DEPTH {
            return Err(bsdf.place.error("BSDFs are nested too deep, or contain themselves", "nest them less deep"));
        }
        let surface = self.convert_new_bsdf(bsdf, depth)?;
        self.materials.surfaces.insert(key, surface.clone());
        Ok(surface)
    }

    /// Converts a BSDF that has not been converted before. A BSDF of unknown kind becomes diffuse
    /// gray, and a message tells the user.
    fn convert_new_bsdf(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        let context = self.context;
        Ok(match bsdf.plugin.as_str() {
            "diffuse" | "lambertian" => {
                let reflectance = self.textured_color(bsdf, "reflectance", 0.5)?;
                MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }).into()
            }
            "difftrans" => {
                let transmittance = self.textured_color(bsdf, "transmittance", 0.5)?;
                let reflectance = DVec3::ZERO.into();
                MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
                    reflectance,
                    transmittance,
                })
                .into()
            }
            "roughdiffuse" => {
                context.add_whole_object_note(&format!("`{}` becomes diffuse", bsdf.plugin), bsdf);
                let reflectance = self.textured_color(bsdf, "reflectance", 0.5)?;
                MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }).into()
            }
            "dielectric" | "roughdielectric" => self.convert_dielectric(bsdf)?,
            "thindielectric" => {
                self.note_tints(bsdf)?;
                let index = refractive_index(context, bsdf)?;
                let transmittance = DVec3::ONE.into();
                MaterialKindDescription::Thin(ThinDielectricDescription { eta: index, transmittance }).into()
            }
            "conductor" | "roughconductor" => {
                let roughness = if bsdf.plugin == "conductor" { 0.0.into() } else { self.roughness(bsdf)? };
                let tint =
                    self.convert_texture_parameter(bsdf, "specular_reflectance", 1.0, MitsubaTextureUse::Color)?;
                convert_conductor(context, bsdf, tint, roughness)?.into()
            }
            "plastic" | "roughplastic" => self.convert_plastic(bsdf)?,
            "principled" | "principledthin" => self.convert_principled(bsdf)?,
            "phong" => self.convert_phong(bsdf)?,
            "twosided" => {
                let nested = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                if nested.len() > 1 {
                    context.add_note("surfaces with two BSDFs have the first one on both sides", bsdf);
                }
                self.convert_first_nested(bsdf, &nested, depth)?
            }
            "mask" => self.convert_mask(bsdf, depth)?,
            "blendbsdf" | "mixturebsdf" => self.convert_blend(bsdf, depth)?,
            "bumpmap" | "bump" => self.convert_bump_map(bsdf, depth)?,
            "normalmap" => {
                let nested = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                let mut surface = self.convert_first_nested(bsdf, &nested, depth)?;
                let texture_use = (MitsubaTextureUse::Normal, self.convention);
                let values = match context.children_of_class(bsdf, ObjectClass::Texture)?.first() {
                    Some((_, texture)) => Some(self.textures.convert_texture(context, texture, texture_use, 1.0, 0)?),
                    // A fork of Mitsuba names the picture file in the BSDF itself.
                    None if bsdf.values.contains_key("filename") => {
                        Some(self.textures.convert_bitmap(context, bsdf, texture_use, 1.0)?)
                    }
                    None => None,
                };
                if let Some(ConvertedTexture::Texture(name, _)) = values {
                    surface.normal = Some(NormalPerturbationDescription::NormalMap(name));
                }
                self.without_mix_perturbation(bsdf, surface)
            }
            "null" => MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 }).into(),
            "coating" | "roughcoating" => {
                context.add_whole_object_note(&format!("the coat of `{}` is ignored", bsdf.plugin), bsdf);
                let nested = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
                self.convert_first_nested(bsdf, &nested, depth)?
            }
            other => {
                context.add_whole_object_note(&format!("BSDFs of kind `{other}` become diffuse gray"), bsdf);
                diffuse_description(DVec3::splat(0.5)).into()
            }
        })
    }

    /// Converts the first of `nested`, the BSDFs inside `bsdf`. Fails if there is none.
    ///
    /// `depth` is the nesting depth of `bsdf`.
    fn convert_first_nested(
        &mut self,
        bsdf: &Rc<MitsubaObject>,
        nested: &[(String, Rc<MitsubaObject>)],
        depth: u32,
    ) -> ReadResult<ConvertedBsdf> {
        self.convert_bsdf(first_nested(bsdf, nested)?, depth + 1)
    }

    /// Converts a `bumpmap` element. The result is the BSDF nested in it, with the nested texture
    /// as bump map.
    fn convert_bump_map(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        let context = self.context;
        let nested = context.children_of_class(bsdf, ObjectClass::Bsdf)?;
        let mut surface = self.convert_first_nested(bsdf, &nested, depth)?;
        let scale = bsdf.number("scale").unwrap_or(1.0);
        if let Some((_, texture)) = context.children_of_class(bsdf, ObjectClass::Texture)?.first() {
            let texture_use = (MitsubaTextureUse::Height, self.convention);
            // Texture values cannot be negative here. So the sign of the texture's factor goes into
            // the height.
            let sign = sign_of_scales(context, texture)?;
            if let ConvertedTexture::Texture(texture, _) =
                self.textures.convert_texture(context, texture, texture_use, sign, 0)?
            {
                let height = sign * scale;
                surface.normal = Some(NormalPerturbationDescription::Bump { texture, height });
            }
        }
        Ok(self.without_mix_perturbation(bsdf, surface))
    }

    /// Converts a `dielectric` or `roughdielectric`. A smooth dielectric with relative index 1
    /// becomes a null interface, because it neither reflects nor bends light.
    fn convert_dielectric(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        self.note_tints(bsdf)?;
        let index = refractive_index(self.context, bsdf)?;
        let roughness = if bsdf.plugin == "dielectric" { 0.0.into() } else { self.roughness(bsdf)? };
        let (refraction, attenuation) = (index.into(), DielectricAbsorption::None);
        if is_index_matched(index) && roughness == TexturedValue::Constant(0.0) {
            return Ok(MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 }).into());
        }
        let multiple_scattering = false;
        let kind = MaterialKindDescription::Dielectric(DielectricDescription {
            refraction,
            absorption: attenuation,
            roughness,
            has_multiple_scattering: multiple_scattering,
            priority: 0,
        });
        Ok(kind.into())
    }

    /// Adds a message for each tint (`specular_reflectance`, `specular_transmittance`) whose mean
    /// is not 1, because the importer ignores the tints of dielectrics.
    fn note_tints(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<()> {
        for name in ["specular_reflectance", "specular_transmittance"] {
            if self.convert_texture_parameter(bsdf, name, 1.0, MitsubaTextureUse::Color)?.mean() != DVec3::ONE {
                self.context.add_note(&format!("`{name}` of dielectrics is ignored: it is 1"), bsdf);
            }
        }
        Ok(())
    }

    fn convert_plastic(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        let index = refractive_index(self.context, bsdf)?;
        let base = self.convert_texture_parameter(bsdf, "diffuse_reflectance", 0.5, MitsubaTextureUse::Color)?;
        let tint = self.convert_texture_parameter(bsdf, "specular_reflectance", 1.0, MitsubaTextureUse::Color)?.mean();
        let alpha = if bsdf.plugin == "plastic" { 0.0 } else { self.mean_roughness(bsdf)? };
        if tint != DVec3::ONE {
            self.context.add_note("`specular_reflectance` of plastic is ignored", bsdf);
        }
        let kind = MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
            reflectance: base.into_color(),
            eta: index.clamp(1.0, f64::from(MAX_COAT_INDEX)),
            roughness: alpha.into(),
            is_nonlinear: bsdf.boolean("nonlinear", false),
        });
        Ok(kind.into())
    }

    fn convert_principled(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        let context = self.context;
        for name in ["sheen", "flatness", "anisotropic", "spec_tint"] {
            if bsdf.number(name).is_some_and(|strength| strength != 0.0) {
                context.add_note(&format!("`{name}` of `principled` is ignored"), bsdf);
            }
        }
        let base = self.convert_texture_parameter(bsdf, "base_color", 0.5, MitsubaTextureUse::Color)?;
        let [metallic, transmission] = ["metallic", "spec_trans"]
            .map(|name| self.convert_texture_parameter(bsdf, name, 0.0, MitsubaTextureUse::Fraction));
        let (metallic, transmission) = (metallic?.into_number(), transmission?.into_number());
        let roughness =
            self.convert_texture_parameter(bsdf, "roughness", 0.5, MitsubaTextureUse::SquaredFraction)?.into_number();
        let index = match bsdf.number("eta") {
            Some(eta) if eta > 1.0 => eta,
            _ => {
                // The parameter `specular` from 0 to 1 stands for a normal reflectance from 0 to
                // 0.08.
                let root = (0.08 * bsdf.number("specular").unwrap_or(0.5).clamp(0.0, 1.0)).sqrt();
                (1.0 + root) / (1.0 - root)
            }
        };
        if transmission != TexturedValue::Constant(0.0) && base.mean() != DVec3::ONE {
            context.add_note("glass of `principled` is not colored by `base_color`", bsdf);
        }
        if transmission == TexturedValue::Constant(1.0) && metallic == TexturedValue::Constant(0.0) {
            return Ok(MaterialKindDescription::Dielectric(DielectricDescription {
                refraction: index.into(),
                absorption: DielectricAbsorption::None,
                roughness,
                has_multiple_scattering: false,
                priority: 0,
            })
            .into());
        }
        // Mitsuba's clear coat of strength 1 reflects only a quarter as much as a full coat.
        let clearcoat =
            0.25 * self.convert_texture_parameter(bsdf, "clearcoat", 0.0, MitsubaTextureUse::Fraction)?.mean().x;
        let gloss = self.convert_texture_parameter(bsdf, "clearcoat_gloss", 0.0, MitsubaTextureUse::Fraction)?.mean().x;
        Ok(MaterialKindDescription::Principled(PrincipledDescription {
            base_color: base.into_color(),
            metallic,
            roughness,
            eta: index.clamp(1.0, f64::from(MAX_COAT_INDEX)),
            transmission,
            absorption: DielectricAbsorption::None,
            clearcoat: clearcoat.into(),
            clearcoat_roughness: 0.1 + (0.001 - 0.1) * gloss,
            has_multiple_scattering: false,
        })
        .into())
    }

    fn convert_phong(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedBsdf> {
        let diffuse = self.textured_color(bsdf, "diffuse_reflectance", 0.5)?;
        let specular =
            self.convert_texture_parameter(bsdf, "specular_reflectance", 0.2, MitsubaTextureUse::Color)?.mean();
        let shininess = bsdf.number("exponent").unwrap_or(30.0).clamp(0.0, 1e6);
        Ok(MaterialKindDescription::Phong(PhongDescription::with_lobe_reflectance(diffuse, specular, shininess)).into())
    }

    /// Returns GGX α of a rough BSDF, as a constant or a texture. Mitsuba's `alpha` is 0.1 by
    /// default.
    ///
    /// Any distribution but `ggx` counts as Beckmann. A Beckmann α is multiplied by √ln 2, so that
    /// GGX has the same median slope. If the file states `alpha_u` or `alpha_v`, the result is
    /// constant: √(ᾱᵤ · ᾱᵥ), where ᾱ is the mean over a texture.
    fn roughness(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<TexturedValue<f64>> {
        let factor = self.ggx_alpha_factor(bsdf);
        let _ = bsdf.boolean("sample_visible", true);
        if bsdf.values.contains_key("alpha_u") || bsdf.values.contains_key("alpha_v") {
            self.context.add_note("anisotropic roughness becomes isotropic", bsdf);
            let [u, v] = ["alpha_u", "alpha_v"]
                .map(|name| self.convert_texture_parameter(bsdf, name, 0.1, MitsubaTextureUse::Fraction));
            return Ok((factor * (u?.mean().x * v?.mean().x).sqrt()).into());
        }
        Ok(self.ggx_alpha(bsdf, factor)?.into_number())
    }

    /// Returns GGX α of a rough BSDF; the mean over all pixels if α is a texture.
    fn mean_roughness(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<f64> {
        match self.roughness(bsdf)? {
            TexturedValue::Constant(alpha) => Ok(alpha),
            TexturedValue::Texture(_) => Ok(self.ggx_alpha(bsdf, self.ggx_alpha_factor(bsdf))?.mean().x),
        }
    }

    /// Returns the factor that converts α of a BSDF to GGX α: 1 for GGX, and √ln 2 for Beckmann.
    /// For Beckmann, a message tells the user of the conversion.
    fn ggx_alpha_factor(&self, bsdf: &MitsubaObject) -> f64 {
        if bsdf.text("distribution") == Some("ggx") {
            return 1.0;
        }
        self.context.add_note("Beckmann distributions become GGX with the same median slope", bsdf);
        std::f64::consts::LN_2.sqrt()
    }

    /// Returns the parameter `alpha` of a BSDF (0.1 if it is missing), multiplied by `factor`.
    fn ggx_alpha(&mut self, bsdf: &MitsubaObject, factor: f64) -> ReadResult<ConvertedTexture> {
        let texture_use = (MitsubaTextureUse::Fraction, self.convention);
        self.textures.convert_texture_parameter(self.context, bsdf, ("alpha", 0.1), texture_use, factor)
    }

    /// Converts the color or texture parameter `name` of a BSDF. A missing parameter counts as gray
    /// of value `default`.
    pub(super) fn convert_texture_parameter(
        &mut self,
        bsdf: &MitsubaObject,
        name: &str,
        default: f64,
        texture_use: MitsubaTextureUse,
    ) -> ReadResult<ConvertedTexture> {
        self.textures.convert_texture_parameter(
            self.context,
            bsdf,
            (name, default),
            (texture_use, self.convention),
            1.0,
        )
    }

    fn textured_color(&mut self, bsdf: &MitsubaObject, name: &str, default: f64) -> ReadResult<TexturedValue<DVec3>> {
        Ok(self.convert_texture_parameter(bsdf, name, default, MitsubaTextureUse::Color)?.into_color())
    }
}
