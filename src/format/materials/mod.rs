//! Materials in the scene language.
//!
//! [`kinds`] holds the kinds of materials. This file holds the common parts of all materials: name,
//! emission, normal perturbation and medium.

mod absorption;
mod emission;
mod kinds;
mod metal;
mod normals;
mod references;
mod refraction;

pub use absorption::DielectricAbsorption;
pub use emission::EmissionDescription;
pub use kinds::*;
pub use metal::MetalDescription;
pub use normals::NormalPerturbationDescription;
pub(super) use references::{material_index, parse_material_index, parse_material_name};
pub use refraction::{MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX, RefractiveIndexDescription};

use super::error::SceneError;
use super::language::fields::parse_block_by_keyword;
use super::language::lexer::Token;
use super::language::names::parse_block_name;
use super::language::parser::Parser;
use super::language::schema::{BlockParser, block_keywords};
use super::language::scope::{DefinedMaterial, MixConstraints, ParserScope};
use super::language::text::clip_for_message;
use super::language::writer::SceneWriter;
use super::media::medium_by_name;
use super::resolve::textures::TextureRequirements;
use super::resolve::{AddedMaterial, Resolver};
use super::span::Spanned;
use crate::color::Rgb;
use crate::scene::{self, Material, NormalPerturbation};
use glam::DVec3;
use std::fmt;

/// A material as the scene file describes it: scattering, emission, normals and inner medium.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    /// Name that objects and mixes refer to: not empty, without line breaks. `None` if objects can
    /// refer to the material only by its index.
    pub name: Option<String>,
    /// Model of reflection and transmission, with its parameters.
    pub kind: MaterialKindDescription,
    /// Emitted radiance; `None` for a material that does not emit.
    pub emission: Option<EmissionDescription>,
    /// Bump map or normal map that perturbs shading normals; `None` if nothing perturbs them.
    pub normal_perturbation: Option<NormalPerturbationDescription>,
    /// Name of the medium that fills a body with this material; only for `Dielectric` and
    /// `NullInterface`.
    pub medium: Option<Spanned<String>>,
}

impl MaterialDescription {
    /// Returns the names of all textures that the material uses: in its parameters, its bump or
    /// normal map, and its emission.
    ///
    /// A name in a bump map, a normal map or a `Phong` material's `texture` may be the path of a
    /// picture instead.
    #[must_use]
    pub fn texture_names(&self) -> Vec<&Spanned<String>> {
        let mut textures = self.kind.texture_names();
        textures.extend(self.normal_perturbation.as_ref().map(NormalPerturbationDescription::texture_name_or_path));
        textures.extend(self.emission.as_ref().and_then(EmissionDescription::texture_name));
        textures
    }

    /// Iterates over the material's fields that hold either the name of a texture or the path of a
    /// picture.
    pub fn texture_names_or_paths_mut(&mut self) -> impl Iterator<Item = &mut Spanned<String>> {
        let normals = self.normal_perturbation.as_mut();
        let normal_map = normals.map(NormalPerturbationDescription::ambiguous_texture_reference_mut);
        self.kind.ambiguous_texture_reference_mut().into_iter().chain(normal_map)
    }

    /// Returns the bump map or normal map with its texture looked up.
    ///
    /// Records in `requirements` that a texture is used, and whether it needs texture coordinates.
    pub(super) fn resolve_normal_perturbation(
        &self,
        r: &mut Resolver<'_>,
        requirements: &mut TextureRequirements,
    ) -> Result<NormalPerturbation, SceneError> {
        self.normal_perturbation
            .as_ref()
            .map_or(Ok(NormalPerturbation::None), |normals| normals.resolve(r, requirements))
    }
}

/// Parses a `Materials` block. Its materials replace those of an earlier `Materials` block.
pub(super) fn parse_materials_block<'a>(
    parser: &mut Parser<'a>,
    block: Token<'a>,
) -> Result<Vec<Spanned<MaterialDescription>>, SceneError> {
    if parser.scope.group_uses_materials {
        parser.scope.late_materials_keyword = Some(block);
    }
    parser.scope.clear_materials();
    let mut materials = Vec::new();
    let allowed = block_keywords(&["numMaterials"], MATERIAL_BLOCK_PARSERS);
    parser.parse_list_block(block, ("numMaterials", "material"), &allowed, |parser, word| {
        let (name, material) = match parse_and_register_name(parser) {
            Ok(name) => (name.clone(), parse_material(parser, word, name)),
            Err(error) => (None, Err(error)),
        };
        let (material, result) = match material {
            Ok(material) => (material, Ok(())),
            Err(error) => {
                // A material with errors keeps its index and name, so that references to it cause
                // no more errors.
                let kind = MirrorDescription { reflectance: DVec3::ONE.into() }.into();
                (
                    MaterialDescription { name, kind, emission: None, normal_perturbation: None, medium: None },
                    Err(error),
                )
            }
        };
        let defined = defined_material(&parser.scope, &material);
        parser.scope.materials.push(defined);
        materials.push(Spanned::new(material, word.span()));
        result
    })?;
    Ok(materials)
}

/// Returns the entry of `scope` for `material`: its name, and properties that limit its use in a
/// mix.
///
/// The caller must append the entry to the materials of `scope`.
fn defined_material(scope: &ParserScope<'_>, material: &MaterialDescription) -> DefinedMaterial {
    let kind = &material.kind;
    let mix_constraints =
        MixConstraints::of_material(kind, scope.materials.len(), |component| scope.mix_constraints(component));
    DefinedMaterial { name: material.name.clone(), is_null_interface: kind.is_null_interface(), mix_constraints }
}

/// Parses the optional name of a new material. Adds the name to the parser's scope, with the index
/// that the material will have in the list of materials.
fn parse_and_register_name(parser: &mut Parser<'_>) -> Result<Option<String>, SceneError> {
    let Some(name) = parse_block_name(parser, "material")? else { return Ok(None) };
    if parser.scope.material_indices.contains_key(&name.value) {
        let message = format!("two materials are called `{}`", clip_for_message(&name.value));
        return Err(parser.lexer.error_at(name.span, message, "the second", "give it another name".to_owned()));
    }
    parser.scope.material_indices.insert(name.value.clone(), parser.scope.materials.len());
    Ok(Some(name.value))
}

/// Parses the `{ … }` of a material block. The caller has read its keyword `word` and its `name`.
fn parse_material<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    name: Option<String>,
) -> Result<MaterialDescription, SceneError> {
    let (BlockParser { block, parse }, f) = parse_block_by_keyword(parser, word, MATERIAL_BLOCK_PARSERS)?;
    let f = &f;
    let kind = parse(parser, f)?;
    let has_field = |name| block.find_field(name).is_some();
    let medium: Option<Spanned<String>> = if has_field("medium") { f.optional_value("medium") } else { None };
    if let Some(name) = &medium {
        parser.scope.check_medium_exists(parser.lexer, name, "ahead of the Materials")?;
    }
    let normal_perturbation = if has_field("bump") { NormalPerturbationDescription::parse(f)? } else { None };
    Ok(MaterialDescription { name, kind, emission: EmissionDescription::parse(f)?, normal_perturbation, medium })
}

/// Writes a material as scene text.
pub(super) fn write_material(out: &mut SceneWriter<'_, '_>, material: &MaterialDescription) -> fmt::Result {
    let block = material.kind.block();
    match &material.name {
        None => out.begin_schema_block(block)?,
        Some(name) => out.begin_named_block(block, name)?,
    }
    material.kind.write_fields(out)?;
    material.medium.as_ref().map_or(Ok(()), |medium| out.write_name_field("medium", medium))?;
    material.normal_perturbation.as_ref().map_or(Ok(()), |normals| normals.write(out))?;
    material.emission.as_ref().map_or(Ok(()), |emission| emission.write(out))?;
    out.end_block()
}

/// Adds all `materials` of the description to the scene. Each keeps the index that it has in the
/// description.
///
/// Adds a white diffuse material if the description has no materials. Metal, glass and the other
/// components of `Principled` materials become materials of their own, with the indices that
/// follow.
pub(super) fn add_materials<'a>(
    r: &mut Resolver<'a>,
    materials: &'a [Spanned<MaterialDescription>],
) -> Result<(), SceneError> {
    r.material_parts.first_index = materials.len() as u32;
    for (index, described) in materials.iter().enumerate() {
        let mut textures = TextureRequirements::default();
        let first_part = r.material_parts.list.len();
        let material = described.kind.resolve(r, &mut textures)?;
        let material = with_body_medium(r, material, described)?;
        let normals = described.resolve_normal_perturbation(r, &mut textures)?;
        for part in &mut r.material_parts.list[first_part..] {
            *part = part.with_normal_perturbation(normals);
        }
        let emission = described.emission.as_ref().map(|emission| emission.resolve(r, &mut textures)).transpose()?;
        for part in described.kind.mix_material_names().into_iter().flatten() {
            if let Some(part) =
                r.material_indices.get(part.as_str()).map(|i| r.materials[*i as usize].texture_requirements)
            {
                textures.uses_textures |= part.uses_textures;
                textures.needs_texcoords |= part.needs_texcoords;
            }
        }
        r.materials.push(AddedMaterial {
            name: described.name.clone(),
            emission: emission.unwrap_or_default(),
            is_null_interface: described.kind.is_null_interface(),
            texture_requirements: textures,
        });
        r.builder.add_material(material.with_normal_perturbation(normals));
        if let Some(name) = &described.name {
            r.material_indices.entry(name).or_insert(index as u32);
        }
    }
    if materials.is_empty() {
        r.builder.add_material(Material::diffuse(Rgb::ONE));
    }
    for part in std::mem::take(&mut r.material_parts.list) {
        r.materials.push(AddedMaterial::default());
        r.builder.add_material(part);
    }
    Ok(())
}

/// Returns `material` with its body filled by the medium that `described` names.
///
/// Returns `material` unchanged if it bounds no body or no medium is named. If the body has an
/// absorption of its own, a copy of the medium fills the body, and this absorption is added to the
/// copy.
///
/// # Errors
/// If no such medium exists, or if the body absorbs and the medium is heterogeneous.
fn with_body_medium(
    r: &mut Resolver<'_>,
    material: scene::Material,
    described: &MaterialDescription,
) -> Result<scene::Material, SceneError> {
    let (Some(name), Some(body)) = (&described.medium, material.enclosed_body()) else { return Ok(material) };
    let mut body = *body;
    let (mut index, mut medium) = medium_by_name(r, name)?;
    if body.absorption != Rgb::ZERO {
        if !medium.is_homogeneous() {
            let message = format!("the body absorbs, and so does the medium `{}`, which varies", name.value);
            let help = "leave out `absorption` and `tint`, or fill the body with a medium that is even";
            return Err(SceneError::error_at_span(r.source, name.span, message, "fills this body", help));
        }
        medium.absorption += std::mem::replace(&mut body.absorption, Rgb::ZERO);
        index = r.builder.add_medium(medium);
    }
    body.medium = Some(index);
    Ok(material.with_body(body))
}
