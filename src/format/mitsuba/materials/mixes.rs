//! Converts BSDFs of Mitsuba that mix two others: masks and blends.

use super::MEMORY_PER_MATERIAL;
use super::converter::{ConvertedBsdf, MitsubaMaterialConverter, first_nested};
use crate::format::description::{MAX_MIX_DEPTH, TexturedValue};
use crate::format::imported_materials::{MixDefect, mix_of};
use crate::format::imported_textures::ConvertedTexture;
use crate::format::mitsuba::color::parse_numbers;
use crate::format::mitsuba::files::ReadResult;
use crate::format::mitsuba::textures::MitsubaTextureUse;
use crate::format::mitsuba::tree::{MitsubaObject, ObjectClass};
use glam::DVec3;
use std::rc::Rc;

impl MitsubaMaterialConverter<'_, '_> {
    /// Converts a `mask` to a mix of the nested BSDF and a fully transparent material.
    ///
    /// If the opacity is 1 everywhere, returns the nested BSDF alone.
    pub(super) fn convert_mask(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        let opacity = self.convert_texture_parameter(bsdf, "opacity", 0.5, MitsubaTextureUse::Fraction)?.into_number();
        let nested = self.context.children_of_class(bsdf, ObjectClass::Bsdf)?;
        let solid = first_nested(bsdf, &nested)?;
        let surface = self.convert_bsdf(solid, depth + 1)?;
        if opacity == TexturedValue::Constant(1.0) {
            return Ok(surface);
        }
        let clear = self.materials.list.transparent_material_name();
        let solid = self.add_mix_component("solid", solid, surface)?;
        match self.materials.list.mix_defect(&clear, &solid) {
            Some(MixDefect::TooDeep) => Err(too_deep_error(bsdf)),
            // The transparent material bounds no body, so a mask never mixes two dielectrics.
            Some(MixDefect::TwoDielectrics) | None => Ok(mix_of(clear, solid, opacity).into()),
        }
    }

    /// Converts a `blendbsdf` or `mixturebsdf` of two BSDFs to a mix.
    ///
    /// Caustica's scene language forbids mixes of two different dielectric bodies. Such a blend
    /// becomes the BSDF of the larger mean weight, and a message tells the user.
    pub(super) fn convert_blend(&mut self, bsdf: &Rc<MitsubaObject>, depth: u32) -> ReadResult<ConvertedBsdf> {
        let weight = self.blend_weight(bsdf)?;
        let parts = self.context.children_of_class(bsdf, ObjectClass::Bsdf)?;
        let [(_, first), (_, second)] = &parts[..] else {
            return Err(bsdf.place.error("a blend needs two BSDFs", "nest two `bsdf` elements in it"));
        };
        let surfaces = [self.convert_bsdf(first, depth + 1)?, self.convert_bsdf(second, depth + 1)?];
        let [first_surface, second_surface] = surfaces.clone();
        let first = self.add_mix_component("first", first, first_surface)?;
        let second = self.add_mix_component("second", second, second_surface)?;
        match self.materials.list.mix_defect(&first, &second) {
            Some(MixDefect::TooDeep) => Err(too_deep_error(bsdf)),
            Some(MixDefect::TwoDielectrics) => {
                self.context.add_note("blends of two dielectrics become the one with the larger weight", bsdf);
                let [first, second] = surfaces;
                Ok(if weight.mean().x > 0.5 { second } else { first })
            }
            None => Ok(mix_of(first, second, weight.into_number()).into()),
        }
    }

    /// Returns the weight of the second BSDF in a `blendbsdf` or `mixturebsdf`, in \[0, 1].
    fn blend_weight(&mut self, bsdf: &Rc<MitsubaObject>) -> ReadResult<ConvertedTexture> {
        if bsdf.plugin != "mixturebsdf" {
            return self.convert_texture_parameter(bsdf, "weight", 0.5, MitsubaTextureUse::Fraction);
        }
        let weights = bsdf.text("weights").and_then(parse_numbers).unwrap_or_default();
        match weights[..] {
            [a, b] if a >= 0.0 && b >= 0.0 && a + b > 0.0 => {
                if (a + b - 1.0).abs() > 1e-6 {
                    self.context.add_note("weights of mixtures are scaled to the sum 1", bsdf);
                }
                Ok(ConvertedTexture::Constant(DVec3::splat(b / (a + b))))
            }
            _ => Err(bsdf.place.error("this mixture has not two weights", "give `weights` of two BSDFs")),
        }
    }

    /// Returns `surface`. If `surface` is a mix with a bump map or normal map, removes this map,
    /// and a message tells the user.
    ///
    /// In Caustica, only the two materials of a mix can have such maps, not the mix itself.
    pub(super) fn without_mix_perturbation(&mut self, bsdf: &MitsubaObject, surface: ConvertedBsdf) -> ConvertedBsdf {
        if surface.kind.mix_material_names().is_some() && surface.normal.is_some() {
            self.context.add_note("bump maps and normal maps of mixes are ignored", bsdf);
            return surface.kind.into();
        }
        surface
    }

    /// Adds `surface`, the converted `bsdf`, as one of the two materials of a mix. Returns the name
    /// of the added material.
    ///
    /// If another mix has added the same BSDF before, returns the name of that material. For a null
    /// interface, returns the name of the fully transparent material.
    fn add_mix_component(
        &mut self,
        suffix: &str,
        bsdf: &Rc<MitsubaObject>,
        surface: ConvertedBsdf,
    ) -> ReadResult<String> {
        if surface.kind.is_null_interface() {
            return Ok(self.materials.list.transparent_material_name());
        }
        let key = (Rc::as_ptr(bsdf), self.convention);
        if let Some(name) = self.materials.mix_component_names.get(&key) {
            return Ok(name.clone());
        }
        let name = self.materials.list.unique_name(&format!("{} {suffix}", self.name));
        self.materials.list.push_surface(name.clone(), surface.kind, surface.normal);
        let count = self.materials.list.descriptions.len() as u64;
        self.context.files.check_total_memory(MEMORY_PER_MATERIAL * count)?;
        self.materials.mix_component_names.insert(key, name.clone());
        Ok(name)
    }
}

/// Returns an error: the mix at `bsdf` contains too many nested mixes.
fn too_deep_error(bsdf: &MitsubaObject) -> crate::format::import::SceneReadError {
    let message = format!("mixes nest more than {MAX_MIX_DEPTH} deep");
    bsdf.place.error(message, "mix fewer BSDFs, or BSDFs that are no mixes")
}
