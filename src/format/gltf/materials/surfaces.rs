//! Converts the reflection and transmission of a glTF material: picks its parts, and mixes them.

use super::conversion::{GltfMaterialConversion, clamped_to_unit};
use super::glass::glass_description;
use super::layers::{clear_coat, clear_coated_description, sheet_or_opaque_description};
use super::opaque::{MetallicRoughnessSurface, metal_description};
use crate::format::description::{MaterialKindDescription, TexturedValue};
use crate::format::gltf::context::ReadResult;
use crate::format::gltf::textures::{GltfTextureUse, TextureReference};
use glam::DVec3;

/// Converts the reflection and transmission of a material. The caller adds opacity and emission.
///
/// The base color is `base` times `base_texture`. Also stores the normal map in `c.normal`.
pub(super) fn surface_description<'t>(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'t>,
    base: DVec3,
    base_texture: Option<TextureReference<'t>>,
) -> ReadResult<MaterialKindDescription> {
    let pbr = material.pbr_metallic_roughness();
    c.normal = c.normal_map(material)?;
    let (metallic, alpha) = match material.pbr_specular_glossiness() {
        Some(glossy) => {
            if glossy.specular_glossiness_texture().is_some() {
                c.add_note("textures of specular color and glossiness are ignored");
            }
            let roughness = 1.0 - clamped_to_unit(glossy.glossiness_factor());
            (TexturedValue::Constant(0.0), (TexturedValue::Constant(roughness * roughness), roughness * roughness))
        }
        None => {
            let texture = c.texture_reference(pbr.metallic_roughness_texture().as_ref());
            let roughness = clamped_to_unit(pbr.roughness_factor());
            let metallic = c.textured_scalar_and_mean(
                texture.as_ref(),
                GltfTextureUse::Channel(2, clamped_to_unit(pbr.metallic_factor())),
            )?;
            let alpha = c.textured_scalar_and_mean(texture.as_ref(), GltfTextureUse::GgxAlpha(roughness))?;
            (metallic.0, alpha)
        }
    };
    let index = refractive_index(c, material);
    let surface = MetallicRoughnessSurface {
        base_color: base,
        base_texture,
        f0: dielectric_normal_reflectance(c, material, index),
        ggx_alpha_and_mean: alpha,
    };
    if let Some(coat) = clear_coat(c, material)? {
        return clear_coated_description(c, &surface, metallic, coat);
    }
    if metallic == TexturedValue::Constant(1.0) {
        return metal_description(c, &surface);
    }
    let dielectric = dielectric_description(c, material, &surface, index)?;
    if metallic == TexturedValue::Constant(0.0) {
        return Ok(dielectric);
    }
    let metal = metal_description(c, &surface)?;
    Ok(c.mix_components([("dielectric", dielectric), ("metal", metal)], metallic))
}

/// Converts the dielectric part of the metallic-roughness model, with refractive index `index`.
///
/// The extension KHR_materials_transmission decides the result: an opaque material, glass, or a mix
/// of both.
fn dielectric_description(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    surface: &MetallicRoughnessSurface<'_>,
    index: f64,
) -> ReadResult<MaterialKindDescription> {
    let Some(transmission) = material.transmission() else {
        return sheet_or_opaque_description(c, material, surface);
    };
    let factor = clamped_to_unit(transmission.transmission_factor());
    let texture = c.texture_reference(transmission.transmission_texture().as_ref());
    let (amount, _) = c.textured_scalar_and_mean(texture.as_ref(), GltfTextureUse::Channel(0, factor))?;
    if amount == TexturedValue::Constant(0.0) {
        return sheet_or_opaque_description(c, material, surface);
    }
    let glass = glass_description(c, material, surface, index)?;
    if amount == TexturedValue::Constant(1.0) {
        return Ok(glass);
    }
    let opaque_dielectric = sheet_or_opaque_description(c, material, surface)?;
    Ok(c.mix_components([("opaque", opaque_dielectric), ("glass", glass)], amount))
}

/// Returns the index of refraction; 1.5 without the extension KHR_materials_ior, or if the index in
/// the file is outside \[1, 1000].
fn refractive_index(c: &mut GltfMaterialConversion<'_, '_>, material: &gltf::Material<'_>) -> f64 {
    let index = material.ior().map_or(1.5, f64::from);
    if (1.0..=1e3).contains(&index) {
        return index;
    }
    if index != 0.0 {
        c.add_note("an index of refraction below 1 or above 1000 is taken as 1.5");
    }
    1.5
}

/// Returns the reflectance of the material's dielectric part at normal incidence, in \[0, 1].
///
/// The reflectance follows from the refractive `index` and the extension KHR_materials_specular. An
/// index of 0 in the file stands for total reflection. For a specular-glossiness material, the
/// reflectance is its specular color.
fn dielectric_normal_reflectance(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    index: f64,
) -> DVec3 {
    if let Some(glossy) = material.pbr_specular_glossiness() {
        return glossy.specular_factor().map(clamped_to_unit).into();
    }
    let root = if material.ior() == Some(0.0) { 1.0 } else { (index - 1.0) / (index + 1.0) };
    let Some(specular) = material.specular() else { return DVec3::splat(root * root) };
    if specular.specular_texture().is_some() || specular.specular_color_texture().is_some() {
        c.add_note("textures of specular strength and color are ignored");
    }
    let color = specular.specular_color_factor().map(|channel| f64::from(channel).clamp(0.0, 1e6));
    (DVec3::from(color) * root * root).min(DVec3::ONE) * clamped_to_unit(specular.specular_factor())
}
