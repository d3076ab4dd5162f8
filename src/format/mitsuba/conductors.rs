//! Converts conductors of Mitsuba, which state a metal's name or a complex refractive index.

use super::color::{ColorMeaning, ColorValue};
use super::context::ImportContext;
use super::files::ReadResult;
use super::tree::MitsubaObject;
use crate::color::conductor_refractive_index;
use crate::format::description::{
    ConductorDescription, MaterialKindDescription, MetalDescription, MirrorDescription, TexturedValue,
};
use crate::format::imported_metals::{metal_by_symbol, named_metal, normal_reflectance};
use crate::format::imported_textures::ConvertedTexture;
use glam::DVec3;

/// Converts a conductor. An unknown metal becomes chromium, and a message tells the user.
///
/// A conductor that states no metal is a perfect mirror, but copper in files of version 0. `tint`
/// (`specular_reflectance`) is the reflectance of a perfect mirror. The reflectance of a metal at
/// normal incidence is multiplied by the mean of `tint` over its texture.
pub(super) fn convert_conductor(
    context: &ImportContext<'_>,
    bsdf: &MitsubaObject,
    tint: ConvertedTexture,
    roughness: TexturedValue<f64>,
) -> ReadResult<MaterialKindDescription> {
    let eta = context.color_value(bsdf, "eta")?;
    let k = context.color_value(bsdf, "k")?;
    let default = if context.tree.has_version_zero { "Cu" } else { "none" };
    let name = bsdf.text("material").unwrap_or(default);
    let is_ideal = match (&eta, &k) {
        (None, None) => name == "none",
        (_, Some(k)) => {
            eta.as_ref().is_some_and(|eta| eta.uniform_value() == Some(0.0)) && k.uniform_value() == Some(1.0)
        }
        _ => false,
    };
    if is_ideal {
        return Ok(match roughness {
            TexturedValue::Constant(0.0) => {
                MaterialKindDescription::Mirror(MirrorDescription { reflectance: tint.into_color() })
            }
            roughness => single_scattering_conductor(MetalDescription::Reflectance(tint.into_color()), roughness),
        });
    }
    let metal = if eta.is_some() || k.is_some() {
        metal_from_index(bsdf, eta, k)?
    } else if let Some(metal) = metal_by_symbol(name) {
        metal
    } else {
        context.add_note(&format!("the metal `{name}` is not known: it becomes chromium"), bsdf);
        named_metal("chromium")
    };
    let mean = tint.mean();
    if mean == DVec3::ONE {
        return Ok(single_scattering_conductor(metal, roughness));
    }
    context.add_note("factors of metals change their reflectance at normal incidence", bsdf);
    let metal = MetalDescription::with_clamped_reflectance(mean * normal_reflectance(&metal));
    Ok(single_scattering_conductor(metal, roughness))
}

/// Returns the metal with the relative complex index (η + ik) / η₀, where η₀ is the refractive
/// index outside (`ext_eta`).
///
/// `eta` and `k` are RGB values or spectra; `None` stands for 0. The result is clamped to the range
/// that materials accept.
fn metal_from_index(
    bsdf: &MitsubaObject,
    eta: Option<ColorValue>,
    k: Option<ColorValue>,
) -> ReadResult<MetalDescription> {
    let (eta, k) = (eta.unwrap_or(ColorValue::Uniform(0.0)), k.unwrap_or(ColorValue::Uniform(0.0)));
    let outer = bsdf.number("ext_eta").unwrap_or(1.0);
    let (eta, k) = match (&eta, &k) {
        (ColorValue::Sampled(_), _) | (_, ColorValue::Sampled(_)) => match (eta.to_spectrum(), k.to_spectrum()) {
            (Some(eta), Some(k)) => conductor_refractive_index(&eta, &k),
            _ => (eta.to_rgb(ColorMeaning::Unbounded), k.to_rgb(ColorMeaning::Unbounded)),
        },
        _ => (eta.to_rgb(ColorMeaning::Unbounded), k.to_rgb(ColorMeaning::Unbounded)),
    };
    if !(eta.min_element() >= 0.0 && k.min_element() >= 0.0 && eta.max_element() < 1e6 && k.max_element() < 1e6) {
        return Err(bsdf.place.error("the index of this metal is not valid", "give `eta` and `k` at least 0"));
    }
    Ok(MetalDescription::with_clamped_index(eta / outer, k / outer))
}

/// Returns a conductor with the given roughness. Light that scatters several times between its
/// microfacets is lost, as in Mitsuba.
fn single_scattering_conductor(metal: MetalDescription, roughness: TexturedValue<f64>) -> MaterialKindDescription {
    MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, has_multiple_scattering: false })
}
