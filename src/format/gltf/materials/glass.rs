//! Converts glTF materials that transmit light to glass: solid bodies and thin panes.

use super::conversion::{GltfMaterialConversion, clamped_to_unit};
use super::opaque::MetallicRoughnessSurface;
use crate::format::description::{
    DielectricAbsorption, DielectricDescription, MaterialKindDescription, RefractiveIndexDescription, TexturedValue,
    ThinDielectricDescription,
};
use crate::format::gltf::context::ReadResult;
use glam::DVec3;

/// Least transmittance of glass, by color channel; smaller values are raised to it.
///
/// A transmittance of 0 would need an infinite absorption coefficient.
const MIN_TRANSMITTANCE: f64 = 1e-6;

/// Least attenuation distance of glass \[length]; smaller distances are raised to it.
///
/// Together with [`MIN_TRANSMITTANCE`], it keeps absorption coefficients below 10¹² per length.
const MIN_ATTENUATION_DISTANCE: f64 = 1e-10;

/// Least Abbe number of glass with dispersion. Glass with a smaller Abbe number gets a refractive
/// index that is constant over wavelength.
///
/// With this Abbe number and the index [`MAX_DISPERSIVE_INDEX`], the refractive index goes from 2.5
/// at 720 nm to 5.1 at 380 nm.
const MIN_ABBE_NUMBER: f64 = 2.0;

/// Greatest refractive index of glass with dispersion. Glass with a greater index is imported
/// without dispersion: its index is equal at all wavelengths.
const MAX_DISPERSIVE_INDEX: f64 = 3.0;

/// Converts a material that transmits light to glass with the refractive index `index`.
///
/// With a volume of thickness above 0 (KHR_materials_volume), the result is a solid body. Else it
/// is a thin pane.
pub(super) fn glass_description(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    surface: &MetallicRoughnessSurface<'_>,
    index: f64,
) -> ReadResult<MaterialKindDescription> {
    let MetallicRoughnessSurface { base_color: base, base_texture, ggx_alpha_and_mean: alpha, .. } = surface;
    let Some(volume) = material.volume().filter(|volume| volume.thickness_factor() > 0.0) else {
        if alpha.1 > 0.0 {
            c.add_note("panes (transmission without volume) are smooth");
        }
        let transmittance = match c.textured_color(base_texture.as_ref(), *base)? {
            TexturedValue::Constant(color) => color.max(DVec3::splat(MIN_TRANSMITTANCE)).into(),
            texture @ TexturedValue::Texture(_) => texture,
        };
        return Ok(MaterialKindDescription::Thin(ThinDielectricDescription { eta: index, transmittance }));
    };
    if base_texture.is_some() || *base != DVec3::ONE {
        c.add_note("the base color of bodies of glass is ignored: their color is that of their attenuation");
    }
    let distance = f64::from(volume.attenuation_distance());
    let distance = if distance > 0.0 { distance.max(MIN_ATTENUATION_DISTANCE) } else { distance };
    let color = DVec3::from(volume.attenuation_color().map(clamped_to_unit)).max(DVec3::splat(MIN_TRANSMITTANCE));
    let is_clear = !(distance > 0.0 && distance.is_finite()) || color == DVec3::ONE;
    let attenuation =
        if is_clear { DielectricAbsorption::None } else { DielectricAbsorption::Tint { color, distance } };
    let dispersion = material.extension_value("KHR_materials_dispersion");
    let dispersion = dispersion.and_then(|value| value.get("dispersion")?.as_f64()).filter(|d| *d > 0.0);
    let refraction = match dispersion.map(|dispersion| 20.0 / dispersion) {
        Some(abbe) if abbe >= MIN_ABBE_NUMBER && index <= MAX_DISPERSIVE_INDEX => {
            RefractiveIndexDescription::Abbe { index, abbe }
        }
        Some(_) => {
            c.add_note("dispersion that is larger than that of any glass is ignored");
            index.into()
        }
        None => index.into(),
    };
    let (roughness, multiple_scattering) = (alpha.0.clone(), true);
    Ok(MaterialKindDescription::Dielectric(DielectricDescription {
        refraction,
        absorption: attenuation,
        roughness,
        has_multiple_scattering: multiple_scattering,
        priority: 0,
    }))
}
