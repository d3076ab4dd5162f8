//! Adds the materials of the scene description to the scene.

use super::media::with_body_medium;
use super::textures::{ANY_TEXTURE_VALUE, TextureRequirements};
use super::{Resolver, rgb};
use crate::bsdf::{METALS, metal_refractive_index};
use crate::color::{DispersionFormula, GLASSES, Rgb, glass_by_name};
use crate::format::SceneError;
use crate::format::description::{
    EmissionDescription, MaterialKindDescription, MetalDescription, RefractiveIndexDescription, Spanned,
};
use crate::format::language::nearest_word;
use crate::scene::{Body, Material};

/// Adds all materials of the description to the scene. Their indices equal those in the
/// description.
///
/// Adds a white diffuse material if the description has none.
pub(super) fn add_materials(r: &mut Resolver<'_>) -> Result<(), SceneError> {
    for (index, described) in r.description.materials.iter().enumerate() {
        let mut requirements = TextureRequirements::default();
        let material = resolve_material(r, &described.kind, &mut requirements)?;
        let material = with_body_medium(r, material, described)?;
        let normals = r.resolve_normal_perturbation(described, &mut requirements)?;
        if let Some(EmissionDescription::Texture { name, .. }) = &described.emission {
            requirements.add_texture_requirements(&r.texture_by_name(name, &ANY_TEXTURE_VALUE)?);
        }
        for part in described.kind.mix_material_names().into_iter().flatten() {
            if let Some(part) = r.material_indices.get(part.as_str()).map(|i| r.texture_requirements[*i as usize]) {
                requirements.uses_textures |= part.uses_textures;
                requirements.needs_texcoords |= part.needs_texcoords;
            }
        }
        r.texture_requirements.push(requirements);
        r.builder.add_material(material.with_normal_perturbation(normals));
        if let Some(name) = &described.name {
            r.material_indices.entry(name).or_insert(index as u32);
        }
    }
    if r.description.materials.is_empty() {
        r.builder.add_material(Material::diffuse(Rgb::ONE));
    }
    Ok(())
}

/// Returns the index of the material called `name`; an error if there is none.
pub(super) fn material_index(r: &Resolver<'_>, name: &Spanned<String>) -> Result<u32, SceneError> {
    r.material_indices.get(name.as_str()).copied().ok_or_else(|| {
        let message = format!("there is no material named `{}`", name.value);
        SceneError::error_at_span(r.source, name.span, message, "unknown name", "define it in Materials first")
    })
}

/// Converts a described material to one of the renderer, without its medium and its bump or normal
/// map.
///
/// Adds to `requirements` the surface properties that the material's textures need.
pub(super) fn resolve_material(
    r: &mut Resolver<'_>,
    kind: &MaterialKindDescription,
    requirements: &mut TextureRequirements,
) -> Result<Material, SceneError> {
    Ok(match kind {
        MaterialKindDescription::Phong { diffuse, specular, shininess, texture } => {
            let diffuse = r.resolve_phong_diffuse_parameter(diffuse, texture.as_ref(), requirements)?;
            let specular = r.resolve_color_parameter(specular, &ANY_TEXTURE_VALUE, requirements)?;
            Material::phong(diffuse, specular, *shininess as f32)
        }
        MaterialKindDescription::Diffuse { reflectance } => {
            Material::diffuse(r.resolve_reflectance_parameter(reflectance, requirements)?)
        }
        MaterialKindDescription::Mirror { reflectance } => {
            Material::mirror(r.resolve_reflectance_parameter(reflectance, requirements)?)
        }
        MaterialKindDescription::Dielectric { refraction, attenuation, roughness, multiple_scattering, priority } => {
            let roughness = r.resolve_fraction_parameter(roughness, requirements)?;
            let (index, glass) = add_refractive_index(r, refraction)?;
            let absorption = rgb(attenuation.absorption_coefficient());
            let body = Body { absorption, priority: *priority, glass, ..Body::new(index) };
            with_scattering(Material::rough_boundary(body, roughness), *multiple_scattering)
        }
        MaterialKindDescription::NullInterface { priority } => {
            Material::smooth_boundary(Body { priority: *priority, is_null_interface: true, ..Body::new(1.0) })
        }
        MaterialKindDescription::Conductor { metal, roughness, multiple_scattering } => {
            let (eta, k) = complex_refractive_index(r, metal)?;
            let metal = Material::conductor(eta, k, r.resolve_fraction_parameter(roughness, requirements)?);
            with_scattering(metal, *multiple_scattering)
        }
        MaterialKindDescription::Thin { index, transmittance } => {
            Material::thin_dielectric(*index as f32, r.resolve_reflectance_parameter(transmittance, requirements)?)
        }
        MaterialKindDescription::CoatedDiffuse { reflectance, index, roughness, nonlinear } => {
            let reflectance = r.resolve_reflectance_parameter(reflectance, requirements)?;
            let roughness = r.resolve_fraction_parameter(roughness, requirements)?;
            Material::coated_diffuse(reflectance, *index as f32, roughness, *nonlinear)
        }
        MaterialKindDescription::Mix { first, second, amount } => {
            let (first, second) = (material_index(r, first)?, material_index(r, second)?);
            Material::mix(first, second, r.resolve_fraction_parameter(amount, requirements)?)
        }
    })
}

/// Returns `material`, with light that several microfacets scatter if `multiple_scattering` is
/// true.
fn with_scattering(material: Material, multiple_scattering: bool) -> Material {
    if multiple_scattering { material } else { material.with_single_scattering() }
}

/// Returns a dielectric's refractive index at the d line (587.56 nm), and the index of its glass.
///
/// Glasses are a list of the scene, to which this adds one. The index is `None`, and no glass is
/// added, for a dielectric without dispersion.
fn add_refractive_index(
    r: &mut Resolver<'_>,
    described: &RefractiveIndexDescription,
) -> Result<(f32, Option<u32>), SceneError> {
    let glass = match described {
        RefractiveIndexDescription::Index(index) => return Ok((*index as f32, None)),
        RefractiveIndexDescription::Named(name) => find_glass(r, name)?,
        RefractiveIndexDescription::Abbe { index, abbe } => DispersionFormula::from_abbe_number(*index, *abbe),
        RefractiveIndexDescription::Glass(glass) => *glass,
    };
    Ok((glass.refractive_index_at_d_line(), Some(r.builder.add_glass(glass))))
}

/// Returns the dispersion formula of the glass called `name`. The error for an unknown name lists
/// all names.
fn find_glass(r: &Resolver<'_>, name: &Spanned<String>) -> Result<DispersionFormula, SceneError> {
    glass_by_name(name).ok_or_else(|| {
        let names = || GLASSES.iter().map(|g| g.0);
        let message = format!("no glass is called `{}`", name.value);
        let guess = nearest_word(name, names()).map_or(String::new(), |n| format!("did you mean `{n}`? "));
        let known = names().collect::<Vec<_>>().join(", ");
        let help = format!("{guess}known are {known}; of others, give `cauchy`, or `indexOfRefraction` and `abbe`");
        SceneError::error_at_span(r.source, name.span, message, "unknown name", help)
    })
}

/// Returns η and k of a metal's complex refractive index η + ik, for red, green and blue.
fn complex_refractive_index(r: &Resolver<'_>, described: &MetalDescription) -> Result<(Rgb, Rgb), SceneError> {
    match described {
        MetalDescription::Index { eta, k } => Ok((rgb(*eta), rgb(*k))),
        MetalDescription::Named(name) => metal_refractive_index(name).ok_or_else(|| {
            let message = format!("no metal is called `{}`", name.value);
            let help = format!("known are {}; of others, give `eta` and `k`", METALS.join(", "));
            SceneError::error_at_span(r.source, name.span, message, "unknown name", help)
        }),
    }
}
