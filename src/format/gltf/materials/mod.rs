//! Materials of a scene that is imported from a glTF file, each converted at its first use.

mod conversion;
mod emission;
mod glass;
mod layers;
mod opaque;
mod surfaces;

use super::context::{FileContext, ReadResult};
use super::document::IGNORED_MATERIAL_EXTENSIONS;
use super::textures::GltfTextures;
use crate::format::description::{
    DiffuseDescription, MaterialDescription, MaterialKindDescription, ObjectGroup, TexturedValue,
};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_materials::{ImportedMaterials, mix_of};
use conversion::{GltfMaterialConversion, clamped_to_unit};
use emission::{emission, emission_times_alpha, opacity};
use glam::{DVec3, DVec4};
use std::collections::HashMap;
use surfaces::surface_description;

/// A material of the imported scene, with those of its properties that the objects with this
/// material need.
#[derive(Clone, Debug)]
pub(super) struct GltfImportedMaterial {
    /// Name of the material in the imported scene.
    pub name: String,
    /// Index of the texture coordinates that the material's textures use (`TEXCOORD_0`, …); `None`
    /// if the material has no texture.
    pub texcoord_set: Option<u32>,
    /// True if alpha is 0 everywhere, so that the surface is not visible.
    pub is_invisible: bool,
    /// True if the surface emits light.
    pub emits: bool,
}

/// Materials of the imported scene so far, with their textures.
pub(super) struct GltfMaterials<'a> {
    /// Textures of the materials, and embedded pictures.
    pub textures: GltfTextures<'a>,
    /// Materials of the imported scene.
    pub list: ImportedMaterials,
    /// Imported materials. One material of the file becomes several if primitives with different
    /// vertex colors use it.
    ///
    /// A key holds the material index in the file (`None` for the default material of glTF) and the
    /// vertex color: the bits of its red, green, blue and alpha.
    converted_materials: HashMap<(Option<usize>, [u64; 4]), GltfImportedMaterial>,
}

impl<'a> GltfMaterials<'a> {
    /// Returns an empty table of materials, whose textures go to `textures`.
    pub fn new(textures: GltfTextures<'a>) -> Self {
        Self { textures, list: ImportedMaterials::default(), converted_materials: HashMap::new() }
    }

    /// Returns the material of the imported scene for the file's `material`. The first call for a
    /// pair of material and vertex color converts the material.
    ///
    /// `vertex_color` multiplies the base color and alpha; `None` stands for white.
    pub fn imported_material(
        &mut self,
        context: &FileContext<'a>,
        material: &gltf::Material<'_>,
        vertex_color: Option<DVec4>,
        notes: &mut ImportNotes,
    ) -> ReadResult<GltfImportedMaterial> {
        let vertex_color = vertex_color.unwrap_or(DVec4::ONE);
        let key = (material.index(), vertex_color.to_array().map(f64::to_bits));
        if let Some(known) = self.converted_materials.get(&key) {
            return Ok(known.clone());
        }
        let number = material.index().map_or_else(|| "default".to_owned(), |i| format!("material {i}"));
        let name = self.list.unique_name(material.name().unwrap_or(&number));
        let mut conversion =
            GltfMaterialConversion { materials: self, notes, context, name, texcoord_set: None, normal: None };
        let imported = convert_material(&mut conversion, material, vertex_color)?;
        self.converted_materials.insert(key, imported.clone());
        Ok(imported)
    }

    /// Removes all materials that no object uses, directly or through a mix. Removes the textures
    /// and pictures that only they use.
    pub fn remove_unused(&mut self, objects: &ObjectGroup) {
        let textures = self.list.remove_unused(objects);
        self.textures.keep_textures(&textures);
    }
}

/// Converts `material`, adds the result to the imported scene, and returns its name and properties.
///
/// `vertex_color` multiplies the base color and alpha.
fn convert_material(
    c: &mut GltfMaterialConversion<'_, '_>,
    material: &gltf::Material<'_>,
    vertex_color: DVec4,
) -> ReadResult<GltfImportedMaterial> {
    for (extension, message) in IGNORED_MATERIAL_EXTENSIONS {
        if material.extension_value(extension).is_some() {
            c.add_note(message);
        }
    }
    let pbr = material.pbr_metallic_roughness();
    let glossy = material.pbr_specular_glossiness();
    let (factor, texture) = match &glossy {
        Some(glossy) => (glossy.diffuse_factor(), glossy.diffuse_texture()),
        None => (pbr.base_color_factor(), pbr.base_color_texture()),
    };
    let base_texture = c.texture_reference(texture.as_ref());
    let factor = DVec4::from(factor.map(clamped_to_unit)) * vertex_color;
    let alpha = opacity(c, material, factor.w, base_texture.as_ref())?;
    let emission = emission(c, material, factor.truncate(), base_texture.as_ref())?;
    let emission = emission.map(|emission| emission_times_alpha(c, emission, &alpha));
    let emits = emission.is_some();
    let kind = if material.unlit() {
        c.add_note("unlit surfaces emit their base color, and reflect nothing");
        MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: DVec3::ZERO.into() })
    } else {
        surface_description(c, material, factor.truncate(), base_texture)?
    };
    let kind = match &alpha {
        TexturedValue::Constant(alpha) if *alpha == 1.0 => kind,
        _ => {
            let (clear, solid) = (c.materials.list.transparent_material_name(), c.add_mix_component("solid", kind));
            mix_of(clear, solid, alpha.clone())
        }
    };
    let normal = if kind.mix_material_names().is_none() { c.normal.take() } else { None };
    c.materials.list.push(MaterialDescription {
        name: Some(c.name.clone()),
        kind,
        emission,
        normal_perturbation: normal,
        medium: None,
    });
    let is_invisible = alpha == TexturedValue::Constant(0.0);
    Ok(GltfImportedMaterial { name: c.name.clone(), texcoord_set: c.texcoord_set, is_invisible, emits })
}
