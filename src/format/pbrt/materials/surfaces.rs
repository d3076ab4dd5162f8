//! Converts the reflection and transmission of each kind of pbrt material.

use super::parameter_reader::ParameterReader;
use super::refractive_index::{
    DEFAULT_REFRACTIVE_INDEX, normal_reflectance, refractive_index, refractive_index_description,
};
use super::roughness::{RoughnessMap, roughness, roughness_from_names};
use crate::bsdf::{LossyCoat, MAX_COAT_INDEX, metal_refractive_index};
use crate::color::conductor_refractive_index;
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricAbsorption, DielectricDescription, DiffuseDescription,
    DiffuseTransmissionDescription, MaterialKindDescription, MetalDescription, MirrorDescription,
    NullInterfaceDescription, PhongDescription, PrincipledDescription, TexturedValue, ThinDielectricDescription,
};
use crate::format::pbrt::files::ReadResult;
use crate::format::pbrt::parameters::{Parameter, Parameters};
use crate::format::pbrt::spectra::{SpectralValue, spectral_value};
use glam::DVec3;

/// Thickness of the coat of `coateddiffuse` if the file states none.
///
/// The thickness is also the optical depth of the coat, because pbrt's coats have extinction 1.
const DEFAULT_COAT_THICKNESS: f64 = 0.01;

/// Converts the reflection and transmission of the pbrt material `kind` with the parameters `p`.
///
/// `has_medium` tells whether a medium fills the shape.
pub(super) fn surface_description(
    r: &mut ParameterReader<'_>,
    kind: &str,
    p: &Parameters,
    has_medium: bool,
) -> ReadResult<MaterialKindDescription> {
    let place = &p.place;
    Ok(match kind {
        "diffuse" => diffuse_description(r, p, "reflectance")?,
        "matte" => {
            if p.find("sigma").is_some_and(|sigma| sigma.numbers != [0.0]) {
                r.add_note("rough diffuse surfaces (`sigma`) are Lambertian", place);
            }
            diffuse_description(r, p, "Kd")?
        }
        "coateddiffuse" => coated_diffuse_description(r, p)?,
        "disney" => disney_description(r, p)?,
        "plastic" | "uber" | "substrate" => phong_description(r, kind, p)?,
        "mirror" => MaterialKindDescription::Mirror(MirrorDescription {
            reflectance: r.textured_color_and_mean(p, "Kr", 0.9, &|c| c)?.0,
        }),
        "glass" | "dielectric" => dielectric_description(r, kind, p)?,
        "thindielectric" => MaterialKindDescription::Thin(ThinDielectricDescription {
            eta: refractive_index(r, p, &["eta"])?,
            transmittance: DVec3::ONE.into(),
        }),
        "conductor" | "metal" => {
            let (default, map) = match kind {
                "metal" => (0.01, RoughnessMap::Polynomial),
                _ => (0.0, RoughnessMap::SquareRoot),
            };
            let roughness = roughness(r, p, default, map)?;
            conductor_description(r, p, ["reflectance", "eta", "k"], roughness.alpha)?
        }
        "coatedconductor" => {
            r.add_note("coats of conductors are left out: the conductor is bare", place);
            let names = ["conductor.uroughness", "conductor.vroughness"];
            let alpha = roughness_from_names(r, p, names, 0.0, RoughnessMap::SquareRoot)?.alpha;
            conductor_description(r, p, ["reflectance", "conductor.eta", "conductor.k"], alpha)?
        }
        "diffusetransmission" => {
            let scale = p.number_or("scale", 1.0);
            let scaled = |c: DVec3| (c * scale).clamp(DVec3::ZERO, DVec3::ONE);
            MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
                reflectance: r.textured_color_and_mean(p, "reflectance", 0.25, &scaled)?.0,
                transmittance: r.textured_color_and_mean(p, "transmittance", 0.25, &scaled)?.0,
            })
        }
        "translucent" => translucent_description(r, p)?,
        "interface" | "none" | "" if has_medium => {
            MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 })
        }
        // Without a medium inside, the boundary has no effect.
        "interface" | "none" | "" => {
            MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.0, transmittance: DVec3::ONE.into() })
        }
        "subsurface" | "kdsubsurface" => {
            r.add_note("subsurface scattering is left out: surfaces are diffuse", place);
            diffuse_description(r, p, if kind == "kdsubsurface" { "Kd" } else { "reflectance" })?
        }
        _ => {
            let message = format!("the material `{kind}` is not supported");
            return Err(place.error(message, "replace it, for example by a `diffuse` or `conductor` material"));
        }
    })
}

/// Returns a diffuse surface with the reflectance of the color parameter `name`.
fn diffuse_description(r: &mut ParameterReader<'_>, p: &Parameters, name: &str) -> ReadResult<MaterialKindDescription> {
    let reflectance = r.textured_color_and_mean(p, name, 0.5, &|c| c)?.0;
    Ok(MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }))
}

/// Converts the material `coateddiffuse`.
fn coated_diffuse_description(r: &mut ParameterReader<'_>, p: &Parameters) -> ReadResult<MaterialKindDescription> {
    let eta = refractive_index(r, p, &["eta"])?.clamp(1.0, f64::from(MAX_COAT_INDEX));
    let roughness = roughness(r, p, 0.0, RoughnessMap::SquareRoot)?;
    if p.find("albedo").is_some_and(|albedo| albedo.numbers.iter().any(|a| *a != 0.0)) {
        r.add_note("scattering inside coats (`albedo`) is left out: they absorb only", &p.place);
    }
    let thickness = p.number_or("thickness", DEFAULT_COAT_THICKNESS).max(0.0);
    let coat = LossyCoat::new(eta, roughness.mean, thickness);
    let under_coat = |c: DVec3| c.map(|reflectance| coat.equivalent_lossless_reflectance(reflectance));
    let (reflectance, _) = r.textured_color_and_mean(p, "reflectance", 0.5, &under_coat)?;
    Ok(MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
        reflectance,
        eta,
        roughness: roughness.alpha,
        is_nonlinear: true,
    }))
}

/// Converts the material `disney` of pbrt-v3.
fn disney_description(r: &mut ParameterReader<'_>, p: &Parameters) -> ReadResult<MaterialKindDescription> {
    let place = &p.place;
    // The list lacks `sheentint`, which has no effect without `sheen`.
    for name in ["anisotropic", "speculartint", "sheen", "flatness", "difftrans", "scatterdistance"] {
        if p.find(name).is_some_and(|value| value.numbers.iter().any(|number| *number != 0.0)) {
            r.add_note(&format!("`{name}` of `disney` is ignored"), place);
        }
    }
    if p.flag("thin") == Some(true) {
        r.add_note("`thin` of `disney` is ignored", place);
    }
    let mut scalar = |name: &str, default: f64, map: &dyn Fn(f64) -> f64| {
        let value = r.value_or_gray(p, &[name], false, default)?;
        r.textured_scalar_and_mean(&value, &|number| map(number.clamp(0.0, 1.0)))
    };
    let metallic = scalar("metallic", 0.0, &|share| share)?.0;
    let roughness = scalar("roughness", 0.5, &|roughness| roughness * roughness)?.0;
    let transmission = scalar("spectrans", 0.0, &|share| share)?.0;
    // pbrt's clear coat of strength 1 reflects only a quarter as much as a full coat.
    let clearcoat = scalar("clearcoat", 0.0, &|strength| 0.25 * strength)?.0;
    let clearcoat_roughness = scalar("clearcoatgloss", 1.0, &|gloss| 0.1 + (0.001 - 0.1) * gloss)?.1;
    if transmission != TexturedValue::Constant(0.0) {
        r.add_note("glass of `disney` is not colored by `color`", place);
    }
    Ok(MaterialKindDescription::Principled(PrincipledDescription {
        base_color: r.textured_color_and_mean(p, "color", 0.5, &|c| c)?.0,
        metallic,
        roughness,
        eta: refractive_index(r, p, &["eta"])?.clamp(1.0, f64::from(MAX_COAT_INDEX)),
        transmission,
        absorption: DielectricAbsorption::None,
        clearcoat,
        clearcoat_roughness,
        has_multiple_scattering: false,
    }))
}

/// Converts the materials `plastic`, `uber` and `substrate` of pbrt-v3 to Phong shading.
fn phong_description(r: &mut ParameterReader<'_>, kind: &str, p: &Parameters) -> ReadResult<MaterialKindDescription> {
    let place = &p.place;
    let default = if kind == "substrate" { 0.5 } else { 0.25 };
    r.add_note(&format!("`{kind}` is a diffuse surface and a Phong lobe of constant strength"), place);
    if p.find_any(&["Kr", "Kt"]).is_some() {
        r.add_note("mirrors and transmission of `uber` (Kr, Kt) are left out", place);
    }
    let (_, gloss) = r.textured_color_and_mean(p, "Ks", default, &|c| c)?;
    let f0 = match kind {
        "plastic" => normal_reflectance(DEFAULT_REFRACTIVE_INDEX) * gloss,
        "uber" => normal_reflectance(refractive_index(r, p, &["eta", "index"])?) * gloss,
        _ => gloss,
    };
    let diffuse_share = DVec3::splat(1.0 - f0.max_element());
    let (diffuse, _) = r.textured_color_and_mean(p, "Kd", default, &|c| c * diffuse_share)?;
    let roughness = roughness(r, p, 0.1, RoughnessMap::Polynomial)?;
    Ok(MaterialKindDescription::Phong(PhongDescription::in_place_of_ggx(diffuse, f0, roughness.mean)))
}

/// Converts the materials `glass` of pbrt-v3 and `dielectric` of pbrt-v4.
fn dielectric_description(
    r: &mut ParameterReader<'_>,
    kind: &str,
    p: &Parameters,
) -> ReadResult<MaterialKindDescription> {
    let is_one = |color: &Parameter| color.texts.is_empty() && color.numbers.iter().all(|c| *c == 1.0);
    if ["Kr", "Kt"].iter().any(|name| p.find(name).is_some_and(|color| !is_one(color))) {
        r.add_note("colors of glass (Kr, Kt) are ignored", &p.place);
    }
    let map = if kind == "glass" { RoughnessMap::PolynomialOrSmooth } else { RoughnessMap::SquareRoot };
    let roughness = roughness(r, p, 0.0, map)?;
    Ok(MaterialKindDescription::Dielectric(DielectricDescription {
        refraction: refractive_index_description(r, p)?,
        absorption: DielectricAbsorption::None,
        roughness: roughness.alpha,
        has_multiple_scattering: false,
        priority: 0,
    }))
}

/// Returns the conductor that the parameters `p` describe, by its reflectance at normal
/// incidence or else by its complex index η + ik.
///
/// `[reflectance, eta, k]` are the names of these parameters. Missing η and k are copper's.
fn conductor_description(
    r: &mut ParameterReader<'_>,
    p: &Parameters,
    [reflectance, eta, k]: [&str; 3],
    roughness: TexturedValue<f64>,
) -> ReadResult<MaterialKindDescription> {
    let place = &p.place;
    let conductor = |metal| {
        let has_multiple_scattering = false;
        MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, has_multiple_scattering })
    };
    if p.find(reflectance).is_some() {
        let (value, _) = r.textured_color_and_mean(p, reflectance, 0.5, &|c| c)?;
        return Ok(conductor(MetalDescription::with_clamped_reflectance(value)));
    }
    let mut value = |name: &str, is_eta: bool| match p.find(name) {
        Some(parameter) if parameter.kind == "texture" => {
            let value = r.textures.parameter_value(parameter, true, place, r.files)?;
            Ok(SpectralValue::Rgb(r.textures.add_texture(&value, &|c| c, r.files)?.1))
        }
        Some(parameter) => spectral_value(parameter, place, r.files),
        None => {
            let copper = metal_refractive_index("copper").unwrap_or_default();
            Ok(SpectralValue::Rgb(if is_eta { copper.0 } else { copper.1 }.as_dvec3()))
        }
    };
    let (eta, k) = match (value(eta, true)?, value(k, false)?) {
        (SpectralValue::Spectrum(eta), SpectralValue::Spectrum(k)) => conductor_refractive_index(&eta, &k),
        (eta, k) => (eta.mean_rgb(), k.mean_rgb()),
    };
    if !(eta.min_element() > 0.0 && k.min_element() >= 0.0) {
        return Err(place.error("the index of the metal is not positive", "give η above 0, and k of at least 0"));
    }
    Ok(conductor(MetalDescription::with_clamped_index(eta, k)))
}

/// Converts the material `translucent` of pbrt-v3, without its gloss.
fn translucent_description(r: &mut ParameterReader<'_>, p: &Parameters) -> ReadResult<MaterialKindDescription> {
    if p.find("Ks").is_none_or(|gloss| gloss.numbers.iter().any(|ks| *ks != 0.0)) {
        r.add_note("the gloss of `translucent` (Ks) is left out", &p.place);
    }
    let mut part_of_kd = |name: &str| -> ReadResult<TexturedValue<DVec3>> {
        let (_, share) = r.textured_color_and_mean(p, name, 0.5, &|c| c)?;
        Ok(r.textured_color_and_mean(p, "Kd", 0.25, &|c| c * share)?.0)
    };
    Ok(MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
        reflectance: part_of_kd("reflect")?,
        transmittance: part_of_kd("transmit")?,
    }))
}
