//! Converts the opaque parts of glTF's metallic-roughness model: the dielectric and the metal.

use super::conversion::GltfMaterialConversion;
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DiffuseDescription, MaterialKindDescription, MetalDescription,
    PhongDescription, TexturedValue,
};
use crate::format::gltf::context::ReadResult;
use crate::format::gltf::textures::TextureReference;
use glam::DVec3;

/// Parameters of glTF's metallic-roughness model from which its parts are made: metal, opaque
/// dielectric and glass. Metalness and transmission, which blend these parts, are not included.
pub(super) struct MetallicRoughnessSurface<'a> {
    /// Base color in \[0, 1], which multiplies `base_texture`.
    pub base_color: DVec3,
    /// Texture of the base color; `None` stands for white.
    pub base_texture: Option<TextureReference<'a>>,
    /// Reflectance of the dielectric part at normal incidence, by color channel.
    pub f0: DVec3,
    /// GGX α as a constant or a texture, and the mean of α over all pixels.
    pub ggx_alpha_and_mean: (TexturedValue<f64>, f64),
}

/// Converts the opaque dielectric part of the metallic-roughness model.
///
/// The reflectance at normal incidence decides the result:
///
/// - 0: a diffuse surface.
/// - Gray, and at most the reflectance of a dielectric with index [`MAX_COAT_INDEX`]: a diffuse
///   base under a coat.
/// - Otherwise: a diffuse surface with a Phong lobe for the gloss.
pub(super) fn opaque_dielectric_description(
    c: &mut GltfMaterialConversion<'_, '_>,
    surface: &MetallicRoughnessSurface<'_>,
) -> ReadResult<MaterialKindDescription> {
    let MetallicRoughnessSurface { base_color: base, base_texture, f0, ggx_alpha_and_mean: alpha } = surface;
    if *f0 == DVec3::ZERO {
        let reflectance = c.textured_color(base_texture.as_ref(), *base)?;
        return Ok(MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }));
    }
    if let Some(eta) = coat_refractive_index(*f0) {
        return Ok(MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
            reflectance: c.textured_color(base_texture.as_ref(), *base)?,
            eta,
            roughness: alpha.0.clone(),
            is_nonlinear: false,
        }));
    }
    let diffuse_share = 1.0 - f0.max_element();
    let diffuse = c.textured_color(base_texture.as_ref(), *base * diffuse_share)?;
    c.add_note("strong or colored gloss of non-metals is a Phong lobe, which does not grow towards grazing angles");
    Ok(MaterialKindDescription::Phong(PhongDescription::in_place_of_ggx(diffuse, *f0, alpha.1)))
}

/// Converts the metal part of the metallic-roughness model.
///
/// The reflectance of the metal at normal incidence is the base color.
pub(super) fn metal_description(
    c: &mut GltfMaterialConversion<'_, '_>,
    surface: &MetallicRoughnessSurface<'_>,
) -> ReadResult<MaterialKindDescription> {
    let MetallicRoughnessSurface { base_color: base, base_texture, ggx_alpha_and_mean: alpha, .. } = surface;
    let reflectance = c.textured_color(base_texture.as_ref(), *base)?;
    Ok(MaterialKindDescription::Conductor(ConductorDescription {
        metal: MetalDescription::with_clamped_reflectance(reflectance),
        roughness: alpha.0.clone(),
        has_multiple_scattering: true,
    }))
}

/// Returns the refractive index whose Fresnel reflectance at normal incidence is `f0`.
///
/// `None` if the channels of `f0` differ, or if the index is above [`MAX_COAT_INDEX`].
pub(super) fn coat_refractive_index(f0: DVec3) -> Option<f64> {
    let root = f0.x.sqrt();
    let index = (1.0 + root) / (1.0 - root);
    (f0 == DVec3::splat(f0.x) && (1.0..=f64::from(MAX_COAT_INDEX)).contains(&index)).then_some(index)
}
