//! Converts the material extensions of glTF that add a layer: clear coats and diffuse transmission.

use super::conversion::{GltfMaterialConversion, clamped_to_unit};
use super::opaque::{MetallicRoughnessSurface, coat_refractive_index, opaque_dielectric_description};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::description::{
    DielectricAbsorption, DiffuseTransmissionDescription, MaterialKindDescription, PrincipledDescription, TexturedValue,
};
use crate::format::gltf::context::ReadResult;
use crate::format::gltf::textures::{GltfTextureUse, TextureReference};
use glam::DVec3;
use serde_json::Value;

/// Clear coat of a material (KHR_materials_clearcoat).
pub(super) struct GltfClearCoat {
    /// Fraction of the surface that the coat covers, in \[0, 1].
    amount: TexturedValue<f64>,
    /// GGX α of the coat.
    ggx_alpha: f64,
}

/// Returns the clear coat of `material`; `None` without one.
///
/// A clear coat on glass also gives `None`, and a message tells the user.
pub(super) fn clear_coat(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
) -> ReadResult<Option<GltfClearCoat>> {
    let Some(extension) = material.extension_value("KHR_materials_clearcoat") else { return Ok(None) };
    let texture = extension_texture(c, extension, "clearcoatTexture")?;
    let texture_use = GltfTextureUse::Channel(0, unit_number(extension, "clearcoatFactor", 0.0));
    let (amount, _) = c.textured_scalar_and_mean(texture.as_ref(), texture_use)?;
    if amount == TexturedValue::Constant(0.0) {
        return Ok(None);
    }
    if material.transmission().is_some_and(|transmission| transmission.transmission_factor() > 0.0) {
        c.add_note("clear coats of glass are ignored");
        return Ok(None);
    }
    if material.extension_value("KHR_materials_diffuse_transmission").is_some() {
        c.add_note("diffuse transmission under a clear coat is ignored");
    }
    if extension.get("clearcoatNormalTexture").is_some() {
        c.add_note("clear coats have the normals of the surface below");
    }
    let texture = extension_texture(c, extension, "clearcoatRoughnessTexture")?;
    let texture_use = GltfTextureUse::GgxAlpha(unit_number(extension, "clearcoatRoughnessFactor", 0.0));
    let (alpha, ggx_alpha) = c.textured_scalar_and_mean(texture.as_ref(), texture_use)?;
    if matches!(alpha, TexturedValue::Texture(_)) {
        c.add_note("textures of the roughness of clear coats become their mean");
    }
    Ok(Some(GltfClearCoat { amount, ggx_alpha }))
}

/// Converts an opaque surface under a clear coat. `metallic` is the metalness of this surface in
/// \[0, 1].
pub(super) fn clear_coated_description(
    c: &mut GltfMaterialConversion<'_, '_>,
    surface: &MetallicRoughnessSurface<'_>,
    metallic: TexturedValue<f64>,
    coat: GltfClearCoat,
) -> ReadResult<MaterialKindDescription> {
    let MetallicRoughnessSurface { base_color, base_texture, f0, ggx_alpha_and_mean: (roughness, _) } = surface;
    let eta = coat_refractive_index(*f0).unwrap_or_else(|| {
        c.add_note("strong or colored gloss of non-metals under a clear coat is gray, and at most 36 %");
        coat_refractive_index(DVec3::splat(f0.element_sum() / 3.0)).unwrap_or(MAX_COAT_INDEX.into())
    });
    Ok(MaterialKindDescription::Principled(PrincipledDescription {
        base_color: c.textured_color(base_texture.as_ref(), *base_color)?,
        metallic,
        roughness: roughness.clone(),
        eta,
        transmission: TexturedValue::Constant(0.0),
        absorption: DielectricAbsorption::None,
        clearcoat: coat.amount,
        clearcoat_roughness: coat.ggx_alpha,
        has_multiple_scattering: true,
    }))
}

/// Converts the part of a dielectric that is not glass: an opaque surface, a sheet that transmits
/// light diffusely (KHR_materials_diffuse_transmission), or a mix of both.
///
/// A factor f of diffuse transmission multiplies the diffuse reflection by 1 − f, as the
/// specification demands.
pub(super) fn sheet_or_opaque_description(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    surface: &MetallicRoughnessSurface<'_>,
) -> ReadResult<MaterialKindDescription> {
    let Some(extension) = material.extension_value("KHR_materials_diffuse_transmission") else {
        return opaque_dielectric_description(c, surface);
    };
    let texture = extension_texture(c, extension, "diffuseTransmissionTexture")?;
    let texture_use = GltfTextureUse::Channel(3, unit_number(extension, "diffuseTransmissionFactor", 0.0));
    let (amount, _) = c.textured_scalar_and_mean(texture.as_ref(), texture_use)?;
    if amount == TexturedValue::Constant(0.0) {
        return opaque_dielectric_description(c, surface);
    }
    if surface.f0 != DVec3::ZERO {
        c.add_note("surfaces with diffuse transmission have gloss on their reflecting share only");
    }
    let texture = extension_texture(c, extension, "diffuseTransmissionColorTexture")?;
    let transmittance = c.textured_color(texture.as_ref(), unit_color(extension, "diffuseTransmissionColorFactor"))?;
    let sheet = MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
        reflectance: DVec3::ZERO.into(),
        transmittance,
    });
    if amount == TexturedValue::Constant(1.0) {
        return Ok(sheet);
    }
    let opaque = opaque_dielectric_description(c, surface)?;
    Ok(c.mix_components([("reflecting", opaque), ("sheet", sheet)], amount))
}

/// Returns the texture `key` of a material extension; `None` without one, or if its texture
/// transform is not invertible.
fn extension_texture<'a>(
    c: &mut GltfMaterialConversion<'_, 'a>,
    extension: &Value,
    key: &str,
) -> ReadResult<Option<TextureReference<'a>>> {
    let Some(info) = extension.get(key) else { return Ok(None) };
    let Some(reference) = c.materials.textures.texture_of_json(info) else {
        return Err(c.context.error(&c.name, format!("its `{key}` is no texture of this file")));
    };
    Ok(c.with_valid_transform(reference))
}

/// Returns the number `key` of a material extension, clamped to \[0, 1]; `default` without one.
fn unit_number(extension: &Value, key: &str, default: f32) -> f64 {
    clamped_to_unit(extension.get(key).and_then(Value::as_f64).map_or(default, |number| number as f32))
}

/// Returns the color `key` of a material extension, clamped to \[0, 1]; white without one.
fn unit_color(extension: &Value, key: &str) -> DVec3 {
    let channel = |i: usize| extension.get(key)?.get(i)?.as_f64();
    DVec3::from([0, 1, 2].map(|i| clamped_to_unit(channel(i).map_or(1.0, |value| value as f32))))
}
