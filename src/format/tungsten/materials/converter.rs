//! Converts one BSDF of Tungsten to a material of the scene language.

use super::{TungstenMaterials, diffuse_description, null_interface};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricAbsorption, DielectricDescription, DiffuseDescription,
    DiffuseTransmissionDescription, MaterialKindDescription, MetalDescription, MirrorDescription, PhongDescription,
    TexturedValue, ThinDielectricDescription,
};
use crate::format::imported_metals::{metal_by_symbol, named_metal, normal_reflectance};
use crate::format::imported_textures::ConvertedTexture;
use crate::format::tungsten::context::ImportContext;
use crate::format::tungsten::object::{ReadResult, TungstenObject};
use crate::format::tungsten::textures::{TungstenTextureUse, TungstenTextures};
use glam::DVec3;

/// Greatest nesting depth of BSDFs.
const MAX_BSDF_DEPTH: u32 = 24;

/// Range of refractive indices.
const INDEX_RANGE: std::ops::RangeInclusive<f64> = 1e-2..=1e3;

/// Greatest absorption coefficient and thickness of a coat or pane.
const MAX_ABSORPTION: f64 = 1e12;

/// Converter of BSDFs to materials, with the tables that it needs and fills.
pub(super) struct TungstenMaterialConverter<'c, 'a> {
    /// Materials of the imported scene so far. The converter adds the two materials of each mix.
    pub materials: &'c mut TungstenMaterials,
    /// Textures of the imported scene.
    pub textures: &'c mut TungstenTextures,
    /// Objects, files and messages of the import.
    pub context: &'c ImportContext<'a>,
    /// Name of the material in the imported scene. If the material is a mix, the names of its two
    /// parts begin with this name.
    pub name: &'c str,
}

impl<'a> TungstenMaterialConverter<'_, 'a> {
    /// Returns the converted `bsdf`. Reuses an earlier result for the same BSDF.
    ///
    /// `depth` is the number of BSDFs that contain this one.
    pub(super) fn convert_bsdf(
        &mut self,
        bsdf: &TungstenObject<'a>,
        depth: u32,
    ) -> ReadResult<MaterialKindDescription> {
        // Without this table, a chain of mixes that each use the next one twice takes exponential
        // time.
        if let Some(known) = self.materials.kinds.get(&bsdf.key()) {
            return Ok(known.clone());
        }
        if depth > MAX_BSDF_DEPTH {
            return Err(bsdf.error("BSDFs are nested too deep, or contain themselves", "nest them less deep"));
        }
        if bsdf.value("bump").is_some() {
            self.context.add_note("bump maps are ignored", bsdf);
        }
        let kind = self.convert_new_bsdf(bsdf, depth)?;
        self.materials.kinds.insert(bsdf.key(), kind.clone());
        Ok(kind)
    }

    /// Converts a BSDF that has not been converted before. A BSDF of unknown kind becomes diffuse,
    /// and a message tells the user.
    fn convert_new_bsdf(&mut self, bsdf: &TungstenObject<'a>, depth: u32) -> ReadResult<MaterialKindDescription> {
        let kind = bsdf.kind()?;
        Ok(match kind {
            "lambert" => self.convert_diffuse(bsdf)?,
            // This BSDF of Tungsten absorbs all light. Only emission makes it visible.
            "null" => {
                bsdf.value("albedo");
                diffuse_description(DVec3::ZERO)
            }
            "forward" => {
                bsdf.value("albedo");
                null_interface()
            }
            "mirror" => {
                let reflectance = self.albedo(bsdf)?.into_color();
                MaterialKindDescription::Mirror(MirrorDescription { reflectance })
            }
            "conductor" | "rough_conductor" => self.convert_conductor(bsdf)?,
            "dielectric" | "rough_dielectric" => self.convert_dielectric(bsdf)?,
            "thinsheet" => self.convert_thin_sheet(bsdf)?,
            "plastic" | "rough_plastic" => {
                let albedo = self.albedo(bsdf)?;
                self.convert_plastic(bsdf, albedo)?
            }
            "smooth_coat" | "rough_coat" => self.convert_coat(bsdf, depth)?,
            "phong" => {
                self.context.add_note("`phong` becomes a Phong lobe, of one color, on a diffuse base", bsdf);
                let ratio = bsdf.number_in("diffuse_ratio", 0.2, 0.0..=1.0)?;
                let shininess = bsdf.number_in("exponent", 64.0, 0.0..=1e6)?;
                let specular = self.albedo(bsdf)?.mean() * (1.0 - ratio);
                let diffuse = self.color(bsdf, "albedo", ratio)?.into_color();
                MaterialKindDescription::Phong(PhongDescription::with_lobe_reflectance(diffuse, specular, shininess))
            }
            "diffuse_transmission" => {
                let share = bsdf.number_in("transmittance", 0.5, 0.0..=1.0)?;
                MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
                    reflectance: self.color(bsdf, "albedo", 1.0 - share)?.into_color(),
                    transmittance: self.color(bsdf, "albedo", share)?.into_color(),
                })
            }
            "mixed" => self.convert_mixed(bsdf, depth)?,
            "transparency" => self.convert_transparency(bsdf, depth)?,
            "oren_nayar" => {
                self.context.add_note("`oren_nayar` becomes diffuse", bsdf);
                bsdf.value("roughness");
                self.convert_diffuse(bsdf)?
            }
            other => {
                self.context.add_whole_object_note(&format!("BSDFs of kind `{other}` become diffuse"), bsdf);
                self.convert_diffuse(bsdf)?
            }
        })
    }

    fn convert_diffuse(&mut self, bsdf: &TungstenObject<'a>) -> ReadResult<MaterialKindDescription> {
        let reflectance = self.albedo(bsdf)?.into_color();
        Ok(MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }))
    }

    /// Converts a conductor. An unknown metal becomes chromium, and a message tells the user.
    ///
    /// The reflectance of the metal at normal incidence is multiplied by the mean of `albedo`.
    fn convert_conductor(&mut self, bsdf: &TungstenObject<'a>) -> ReadResult<MaterialKindDescription> {
        let metal = self.read_metal(bsdf)?;
        let roughness = if bsdf.kind()? == "conductor" { 0.0.into() } else { self.roughness(bsdf, 0.1)?.into_number() };
        let tint = self.albedo(bsdf)?.mean();
        let metal = if tint == DVec3::ONE {
            metal
        } else {
            self.context.add_note("the `albedo` of metals changes their reflectance at normal incidence", bsdf);
            MetalDescription::with_clamped_reflectance(tint * normal_reflectance(&metal))
        };
        // Tungsten loses light that several microfacets scatter in turn.
        let description = ConductorDescription { metal, roughness, has_multiple_scattering: false };
        Ok(MaterialKindDescription::Conductor(description))
    }

    /// Returns the metal that `eta` and `k` state, or else the name in `material`; copper without
    /// them.
    fn read_metal(&self, bsdf: &TungstenObject<'a>) -> ReadResult<MetalDescription> {
        let name = bsdf.text("material")?;
        let (eta, k) = (bsdf.vector("eta")?, bsdf.vector("k")?);
        if let (None, Some(eta), Some(k)) = (name, eta, k) {
            let is_valid = |index: DVec3| index.min_element() >= 0.0 && index.max_element() < 1e6;
            if !(is_valid(eta) && is_valid(k)) {
                return Err(bsdf.error("the index of this metal is not valid", "give `eta` and `k` at least 0"));
            }
            return Ok(MetalDescription::with_clamped_index(eta, k));
        }
        let name = name.unwrap_or("Cu");
        Ok(metal_by_symbol(name).unwrap_or_else(|| {
            self.context.add_note(&format!("the metal `{name}` is not known: it becomes chromium"), bsdf);
            named_metal("chromium")
        }))
    }

    /// Converts a dielectric. Without refraction, it becomes a black base under a coat, which
    /// reflects as much. A smooth dielectric of index 1 becomes a null interface.
    fn convert_dielectric(&mut self, bsdf: &TungstenObject<'a>) -> ReadResult<MaterialKindDescription> {
        let index = bsdf.number_in("ior", 1.5, INDEX_RANGE)?;
        let roughness = if bsdf.kind()? == "dielectric" {
            ConvertedTexture::Constant(DVec3::ZERO)
        } else {
            self.roughness(bsdf, 0.1)?
        };
        self.note_tint("dielectrics", bsdf)?;
        if !bsdf.boolean("enable_refraction", true)? {
            return Ok(MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
                reflectance: DVec3::ZERO.into(),
                eta: clamped_coat_index(index),
                roughness: roughness.into_number(),
                is_nonlinear: false,
            }));
        }
        let roughness = roughness.into_number();
        if (index - 1.0).abs() < 1e-9 && roughness == TexturedValue::Constant(0.0) {
            return Ok(null_interface());
        }
        Ok(MaterialKindDescription::Dielectric(DielectricDescription {
            refraction: index.into(),
            absorption: DielectricAbsorption::None,
            roughness,
            has_multiple_scattering: false,
            priority: 0,
        }))
    }

    /// Converts a `thinsheet`. Its absorption is that along the normal.
    fn convert_thin_sheet(&mut self, bsdf: &TungstenObject<'a>) -> ReadResult<MaterialKindDescription> {
        self.note_tint("thin sheets", bsdf)?;
        if bsdf.boolean("enable_interference", false)? {
            self.context.add_note("interference in thin sheets is ignored", bsdf);
        }
        let thickness = self.textures.convert_member(
            self.context,
            bsdf,
            ("thickness", 0.5),
            TungstenTextureUse::NonNegative,
            1.0,
        )?;
        // In Tungsten, light crosses twice the thickness.
        let depth = 2.0 * thickness.mean().x.min(MAX_ABSORPTION);
        let transmittance = beer_transmittance(self.absorption(bsdf)?, depth);
        let eta = bsdf.number_in("ior", 1.5, INDEX_RANGE)?;
        Ok(MaterialKindDescription::Thin(ThinDielectricDescription { eta, transmittance: transmittance.into() }))
    }

    /// Converts a `plastic`, or a coat over a diffuse base of reflectance `albedo`. An absorbing
    /// coat darkens the base as it does along the normal, and a message tells the user.
    pub(super) fn convert_plastic(
        &mut self,
        bsdf: &TungstenObject<'a>,
        albedo: ConvertedTexture,
    ) -> ReadResult<MaterialKindDescription> {
        let eta = clamped_coat_index(bsdf.number_in(
            "ior",
            if bsdf.kind()?.ends_with("coat") { 1.3 } else { 1.5 },
            INDEX_RANGE,
        )?);
        let roughness = self.coat_roughness(bsdf)?.into_number();
        let transmittance = self.coat_transmittance(bsdf)?;
        let reflectance =
            if transmittance == DVec3::ONE { albedo.into_color() } else { (albedo.mean() * transmittance).into() };
        Ok(MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
            reflectance,
            eta,
            roughness,
            is_nonlinear: true,
        }))
    }

    /// Returns the share of light that crosses the coat of `bsdf` twice along the normal. If it is
    /// below 1, a message tells the user that the coat has this share in all directions.
    pub(super) fn coat_transmittance(&self, bsdf: &TungstenObject<'a>) -> ReadResult<DVec3> {
        let thickness = bsdf.number_in("thickness", 1.0, 0.0..=MAX_ABSORPTION)?;
        let absorption = self.absorption(bsdf)?;
        if absorption == DVec3::ZERO {
            return Ok(DVec3::ONE);
        }
        self.context.add_note("coats absorb as along the normal, and textures below them become their mean", bsdf);
        Ok(beer_transmittance(absorption, 2.0 * thickness))
    }

    /// Returns the absorption coefficient `sigma_a` of a coat or pane.
    fn absorption(&self, bsdf: &TungstenObject<'a>) -> ReadResult<DVec3> {
        let absorption = bsdf.vector("sigma_a")?.unwrap_or(DVec3::ZERO);
        if absorption.min_element() >= 0.0 && absorption.max_element() <= MAX_ABSORPTION {
            return Ok(absorption);
        }
        Err(bsdf.error("`sigma_a` is negative or too large", "correct `sigma_a`"))
    }

    /// Returns GGX α of a coat: 0 for a smooth one.
    pub(super) fn coat_roughness(&mut self, bsdf: &TungstenObject<'a>) -> ReadResult<ConvertedTexture> {
        match bsdf.kind()? {
            "rough_plastic" | "rough_coat" => self.roughness(bsdf, 0.02),
            _ => Ok(ConvertedTexture::Constant(DVec3::ZERO)),
        }
    }

    /// Returns GGX α of a rough BSDF.
    ///
    /// The α of Beckmann is multiplied by √ln 2, so that GGX has the same median slope. A Phong
    /// distribution of Tungsten approximates the Beckmann distribution with the same `roughness`.
    fn roughness(&mut self, bsdf: &TungstenObject<'a>, default: f64) -> ReadResult<ConvertedTexture> {
        let factor = match bsdf.text("distribution")?.unwrap_or("ggx") {
            "ggx" => 1.0,
            "beckmann" | "phong" => {
                let message = "Beckmann and Phong distributions become GGX with the same median slope";
                self.context.add_note(message, bsdf);
                std::f64::consts::LN_2.sqrt()
            }
            other => {
                let message = format!("no microfacet distribution is called `{other}`");
                return Err(bsdf.error(message, "write ggx, beckmann or phong"));
            }
        };
        self.textures.convert_member(self.context, bsdf, ("roughness", default), TungstenTextureUse::Fraction, factor)
    }

    /// Adds a message if the mean of `albedo` is not 1, because it is ignored for these `surfaces`.
    pub(super) fn note_tint(&mut self, surfaces: &str, bsdf: &TungstenObject<'a>) -> ReadResult<()> {
        if self.albedo(bsdf)?.mean() != DVec3::ONE {
            self.context.add_note(&format!("the `albedo` of {surfaces} is ignored: it is 1"), bsdf);
        }
        Ok(())
    }

    /// Returns the color `albedo` of a BSDF; white if it is missing.
    pub(super) fn albedo(&mut self, bsdf: &TungstenObject<'a>) -> ReadResult<ConvertedTexture> {
        self.color(bsdf, "albedo", 1.0)
    }

    /// Converts the color `name` of a BSDF, multiplied by `factor`. A missing color is white.
    fn color(&mut self, bsdf: &TungstenObject<'a>, name: &str, factor: f64) -> ReadResult<ConvertedTexture> {
        self.textures.convert_member(self.context, bsdf, (name, 1.0), TungstenTextureUse::Color, factor)
    }
}

/// Returns a refractive index of a coat, clamped to the range that materials accept.
fn clamped_coat_index(index: f64) -> f64 {
    index.clamp(1.0, f64::from(MAX_COAT_INDEX))
}

/// Returns the share of light that is left after the distance `depth`, by Beer's law.
fn beer_transmittance(absorption: DVec3, depth: f64) -> DVec3 {
    // The smallest share keeps the value above 0, which thin sheets need.
    (absorption * -depth).map(libm::exp).max(DVec3::splat(1e-30))
}
