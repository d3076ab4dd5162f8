//! Converts the emission and the opacity of a glTF material.

use super::conversion::{GltfMaterialConversion, clamped_to_unit};
use crate::format::description::{EmissionDescription, TexturedValue};
use crate::format::gltf::context::ReadResult;
use crate::format::gltf::textures::{GltfTextureUse, TextureReference};
use glam::DVec3;
use gltf::material::AlphaMode;

/// Returns the opacity of a material in \[0, 1], by its alpha mode, as a constant or a texture.
///
/// Alpha is `factor` times the alpha channel of `texture`. The opacity is 1 in mode `OPAQUE` and
/// alpha in mode `BLEND`. In mode `MASK`, it is 1 where alpha reaches the cutoff, else 0.
pub(super) fn opacity(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    factor: f64,
    texture: Option<&TextureReference<'_>>,
) -> ReadResult<TexturedValue<f64>> {
    let texture_use = match material.alpha_mode() {
        AlphaMode::Opaque => return Ok(TexturedValue::Constant(1.0)),
        AlphaMode::Blend => GltfTextureUse::Channel(3, factor),
        AlphaMode::Mask => GltfTextureUse::AlphaMask(factor, f64::from(material.alpha_cutoff().unwrap_or(0.5))),
    };
    Ok(c.textured_scalar_and_mean(texture, texture_use)?.0)
}

/// Returns the emitted radiance, constant or by a texture; `None` if the surface emits nothing.
///
/// An unlit material emits its base color `base` times `base_texture`.
pub(super) fn emission(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    base: DVec3,
    base_texture: Option<&TextureReference<'_>>,
) -> ReadResult<Option<EmissionDescription>> {
    let strength = f64::from(material.emissive_strength().unwrap_or(1.0)).max(0.0);
    if !strength.is_finite() {
        return Err(c.context.error(&c.name, "its emissive strength is not finite"));
    }
    let emissive_texture = c.texture_reference(material.emissive_texture().as_ref());
    let (factor, texture, scale) = if material.unlit() {
        (base, base_texture, 1.0)
    } else {
        (material.emissive_factor().map(clamped_to_unit).into(), emissive_texture.as_ref(), strength)
    };
    if factor * scale == DVec3::ZERO {
        return Ok(None);
    }
    if material.double_sided() {
        c.add_note("surfaces emit light from their front only");
    }
    Ok(match c.textured_color(texture, factor)? {
        TexturedValue::Constant(color) if color == DVec3::ZERO => None,
        TexturedValue::Constant(color) => Some(EmissionDescription::Constant(color * scale)),
        TexturedValue::Texture(name) => Some(EmissionDescription::Texture { name, scale }),
    })
}

/// Returns `emission` times the opacity `alpha`, because only the opaque fraction of a surface
/// emits.
///
/// If `alpha` is a texture, returns `emission` unchanged and adds a note.
pub(super) fn emission_times_alpha(
    c: &mut GltfMaterialConversion<'_, '_>,
    emission: EmissionDescription,
    alpha: &TexturedValue<f64>,
) -> EmissionDescription {
    let alpha = match alpha {
        TexturedValue::Constant(alpha) => *alpha,
        TexturedValue::Texture(_) => {
            c.add_note("surfaces with a texture of alpha emit light from their transparent points too");
            1.0
        }
    };
    match emission {
        EmissionDescription::Constant(radiance) => EmissionDescription::Constant(radiance * alpha),
        EmissionDescription::Texture { name, scale } => EmissionDescription::Texture { name, scale: scale * alpha },
    }
}
