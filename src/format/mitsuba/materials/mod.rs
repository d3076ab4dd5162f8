//! Materials of a scene that is imported from Mitsuba. Each BSDF is converted at its first use.

mod converter;
mod mixes;

use super::context::ImportContext;
use super::files::ReadResult;
use super::meshes::TexcoordConvention;
use super::textures::MitsubaTextures;
use super::tree::MitsubaObject;
use crate::format::description::{
    EmissionDescription, MaterialDescription, MaterialKindDescription, NullInterfaceDescription, Span, Spanned,
};
use crate::format::imported_materials::ImportedMaterials;
use converter::{ConvertedBsdf, MitsubaMaterialConverter, diffuse_description};
use glam::DVec3;
use std::collections::HashMap;
use std::rc::Rc;

/// Estimated memory of each material \[bytes], in the scene description and in the built scene
/// together.
const MEMORY_PER_MATERIAL: u64 = 2_000;

/// Kind of boundary that a material makes around a shape. The kind decides whether a medium can
/// fill the shape itself, or needs a second surface inside the shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MaterialBoundary {
    /// Opaque, diffusely transmitting or principled material, or a mix.
    Surface,
    /// Boundary of a solid dielectric body, such as a lens.
    Body,
    /// A thin pane without volume.
    Pane,
    /// No surface: a null interface, which may bound a medium.
    Null,
}

/// A material of the imported scene, with the properties that shapes depend on.
#[derive(Clone, Debug)]
pub(super) struct MitsubaImportedMaterial {
    /// Name of the material in the imported scene.
    pub name: String,
    /// Kind of boundary that the material makes.
    pub boundary: MaterialBoundary,
    /// True if the material uses a texture, or if it is a mix, whose two materials may use
    /// textures.
    pub may_be_textured: bool,
}

/// Properties of a shape on which its converted material depends.
///
/// A BSDF becomes one material for each distinct combination of these properties.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShapeMaterialInputs {
    /// Name of the medium inside the shape; `None` for vacuum.
    pub medium: Option<String>,
    /// Emission texture: its name, and the factor from its values to radiance.
    ///
    /// `None` if the shape emits constant radiance or nothing.
    pub emission_texture: Option<(Spanned<String>, f64)>,
    /// Relation between the shape's texture coordinates (u, v) in Caustica and in Mitsuba: equal,
    /// or with v flipped.
    pub convention: TexcoordConvention,
}

/// Materials of the imported scene so far, with tables that find materials for reuse.
#[derive(Default)]
pub(super) struct MitsubaMaterials {
    /// Materials of the imported scene.
    pub list: ImportedMaterials,
    /// Converted BSDFs. A key holds the address of the BSDF object, and the convention for the
    /// texture coordinates of the shape, because textures are converted differently for each
    /// convention.
    surfaces: HashMap<(*const MitsubaObject, TexcoordConvention), ConvertedBsdf>,
    /// Names of the materials that are parts of mixes. A key holds the address of the BSDF object,
    /// and the convention for the texture coordinates of the shape.
    mix_component_names: HashMap<(*const MitsubaObject, TexcoordConvention), String>,
    /// Materials of shapes. A key holds the shape's BSDF object (`None` for a shape without one)
    /// and the shape's [`ShapeMaterialInputs`] as text.
    converted: HashMap<(Option<*const MitsubaObject>, String), MitsubaImportedMaterial>,
    black_material_name: Option<String>,
    /// Names of null-interface materials, by the name of the medium that they bound.
    null_interface_names: HashMap<String, String>,
}

impl MitsubaMaterials {
    /// Returns the material of a shape. Converts the shape's BSDF, unless the same BSDF was
    /// converted for equal `inputs` before.
    ///
    /// A shape without a BSDF is diffuse, with reflectance 0.5. A null interface with an emission
    /// texture becomes a black surface that emits light.
    pub fn imported_material(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        bsdf: Option<&Rc<MitsubaObject>>,
        inputs: &ShapeMaterialInputs,
    ) -> ReadResult<MitsubaImportedMaterial> {
        let key = (bsdf.map(Rc::as_ptr), format!("{inputs:?}"));
        if let Some(known) = self.converted.get(&key) {
            return Ok(known.clone());
        }
        let ShapeMaterialInputs { medium, emission_texture: emission, convention } = inputs;
        let wanted_name = bsdf.and_then(|bsdf| bsdf.id.clone()).unwrap_or_else(|| "material".to_owned());
        let name = self.list.unique_name(&wanted_name);
        let mut converter =
            MitsubaMaterialConverter { materials: self, textures, context, convention: *convention, name: &name };
        let surface = match bsdf {
            Some(bsdf) => converter.convert_bsdf(bsdf, 0)?,
            None => diffuse_description(DVec3::splat(0.5)).into(),
        };
        let ConvertedBsdf { mut kind, normal } = surface;
        let emission = emission.clone().map(|(name, scale)| EmissionDescription::Texture { name, scale });
        if kind.is_null_interface() && emission.is_some() {
            kind = diffuse_description(DVec3::ZERO);
        }
        let boundary = if kind.is_dielectric() {
            MaterialBoundary::Body
        } else if kind.is_null_interface() {
            MaterialBoundary::Null
        } else if let MaterialKindDescription::Thin(_) = kind {
            MaterialBoundary::Pane
        } else {
            MaterialBoundary::Surface
        };
        let fills = matches!(boundary, MaterialBoundary::Body | MaterialBoundary::Null);
        let medium = medium.clone().filter(|_| fills).map(|name| Spanned::new(name, Span::default()));
        let description =
            MaterialDescription { name: Some(name.clone()), kind, emission, normal_perturbation: normal, medium };
        let is_textured = !description.texture_names().is_empty() || description.kind.mix_material_names().is_some();
        self.list.push(description);
        context.files.check_total_memory(MEMORY_PER_MATERIAL * self.list.descriptions.len() as u64)?;
        let imported = MitsubaImportedMaterial { name, boundary, may_be_textured: is_textured };
        if !imported.may_be_textured {
            // Without textures, the convention for texture coordinates makes no difference.
            for convention in [TexcoordConvention::Same, TexcoordConvention::FlippedV] {
                let inputs = ShapeMaterialInputs { convention, ..inputs.clone() };
                self.converted.insert((key.0, format!("{inputs:?}")), imported.clone());
            }
        }
        self.converted.insert(key, imported.clone());
        Ok(imported)
    }

    /// Returns the name of the null-interface material that bounds `medium`. The first call for a
    /// medium adds this material to the imported scene.
    pub fn null_interface_name(&mut self, medium: &str) -> String {
        if let Some(name) = self.null_interface_names.get(medium) {
            return name.clone();
        }
        let name = self.list.unique_name("boundary");
        let kind = MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 });
        let filling = Some(Spanned::new(medium.to_owned(), Span::default()));
        self.list.push(MaterialDescription {
            name: Some(name.clone()),
            kind,
            emission: None,
            normal_perturbation: None,
            medium: filling,
        });
        self.null_interface_names.insert(medium.to_owned(), name.clone());
        name
    }

    /// Returns the name of a material that reflects and transmits nothing. The first call adds this
    /// material to the imported scene.
    pub fn black_material_name(&mut self) -> String {
        if let Some(name) = &self.black_material_name {
            return name.clone();
        }
        let name = self.list.unique_name("black");
        self.list.push_surface(name.clone(), diffuse_description(DVec3::ZERO), None);
        self.black_material_name = Some(name.clone());
        name
    }
}
