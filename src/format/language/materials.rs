//! Schemas, parsing and writing of material blocks, and parsing of references to materials.

use std::fmt;

use super::super::description::{
    DielectricAbsorption, EmissionDescription, MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX, MaterialDescription,
    MaterialKindDescription, MetalDescription, NormalPerturbationDescription, Spanned, TexturedValue,
};
use super::super::error::SceneError;
use super::fields::{BlockFields, ParsedField, parse_block_by_keyword};
use super::lexer::Token;
use super::names::parse_block_name;
use super::parser::Parser;
use super::refraction::{INDEX_FIELD, parse_refraction, write_refraction};
use super::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, MAX_COEFFICIENT, block_keywords, block_schema,
    field_schema,
};
use super::text::clip_for_message;
use super::writer::SceneWriter;
use crate::bsdf::MAX_COAT_INDEX;
use glam::DVec3;

/// Material blocks of the scene language, each with the function that converts its fields.
pub(super) static MATERIALS: &[BlockParser<ParseMaterial>] = &[
    BlockParser { block: &PHONG, parse: parse_phong_material },
    BlockParser { block: &DIFFUSE, parse: parse_diffuse_material },
    BlockParser { block: &MIRROR, parse: parse_mirror_material },
    BlockParser { block: &DIELECTRIC, parse: parse_dielectric },
    BlockParser { block: &NULL_INTERFACE, parse: parse_null_interface },
    BlockParser { block: &CONDUCTOR, parse: parse_conductor },
    BlockParser { block: &THIN, parse: parse_thin_dielectric },
    BlockParser { block: &COATED_DIFFUSE, parse: parse_coated_diffuse },
    BlockParser { block: &MIX, parse: parse_mix_material },
];

/// Function that converts the parsed fields of a material block to a material.
///
/// A `Mix` needs the parser to look up the materials before it.
type ParseMaterial = for<'a> fn(&Parser<'a>, &BlockFields<'a>) -> Result<MaterialKindDescription, SceneError>;

/// Largest accepted nesting depth of mixes. Each level can double the number of materials in a mix.
const MAX_MIX_DEPTH: u8 = 8;

const UNIT_RANGE: FieldRange = FieldRange::Within(0.0, 1.0);
const TRANSMITTANCE_RANGE: FieldRange = FieldRange::UpTo(0.0, 1.0);
const COEFFICIENT_RANGE: FieldRange = FieldRange::Within(0.0, MAX_COEFFICIENT);

const ROUGHNESS_FIELD: FieldSchema = field_schema("roughness", FieldKind::NumberOrTexture, "GGX α; smooth below 0.001")
    .with_range(UNIT_RANGE)
    .with_default_numbers(&[0.0]);
const MULTIPLE_SCATTERING_FIELD: FieldSchema =
    field_schema("multipleScattering", FieldKind::Word(&["yes", "no"]), "`no`: light between microfacets is lost")
        .with_default_word("yes");
const PRIORITY_FIELD: FieldSchema =
    field_schema("priority", FieldKind::Whole, "where bodies overlap, the highest priority counts")
        .with_range(FieldRange::Within(0.0, 255.0))
        .with_default_numbers(&[0.0]);

static EMISSION_FIELDS: &[FieldSchema] = &[
    field_schema("emission", FieldKind::ColorOrTexture, "emitted radiance; not for `Clear`")
        .with_default_description("0 0 0")
        .with_unit("W/(m² sr)"),
    field_schema("emissionScale", FieldKind::Number, "with a texture as `emission`: factor of its values")
        .with_range(FieldRange::NonNegative)
        .with_default_numbers(&[1.0]),
];

static NORMAL_PERTURBATION_FIELDS: &[FieldSchema] = &[
    field_schema("bump", FieldKind::Name, "texture or picture of heights; not for `Clear`")
        .with_default_description("none"),
    field_schema("bumpHeight", FieldKind::Number, "height of the value 1 of `bump`, required with it")
        .with_range(FieldRange::Single)
        .with_unit("length"),
    field_schema("normalMap", FieldKind::Name, "instead of `bump`: texture or picture of normals")
        .with_default_description("none"),
];

static PHONG: BlockSchema = block_schema("PhongMaterial", "Phong's reflection model")
    .with_fields(&[
        field_schema("diffuseColor", FieldKind::ColorOrTexture, "diffuse reflectance kd")
            .with_default_numbers(&[1.0, 1.0, 1.0])
            .mark_as_course_syntax(),
        field_schema("specularColor", FieldKind::ColorOrTexture, "specular coefficient ks")
            .with_default_numbers(&[0.0, 0.0, 0.0])
            .mark_as_course_syntax(),
        field_schema("shininess", FieldKind::Number, "Phong exponent")
            .with_range(FieldRange::NonNegative)
            .with_default_numbers(&[0.0])
            .mark_as_course_syntax(),
        field_schema("texture", FieldKind::Name, "texture or picture that `diffuseColor` is multiplied by")
            .with_default_description("none")
            .mark_as_course_syntax(),
    ])
    .with_aliases(&["Material", "Phong"])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS])
    .mark_as_course_syntax();

static DIFFUSE: BlockSchema = block_schema("Diffuse", "Lambertian reflection")
    .with_fields(&[field_schema("reflectance", FieldKind::ColorOrTexture, "albedo")
        .with_range(UNIT_RANGE)
        .make_required()])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static MIRROR: BlockSchema = block_schema("Mirror", "perfect mirror")
    .with_fields(&[field_schema("reflectance", FieldKind::ColorOrTexture, "reflectance")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[1.0, 1.0, 1.0])])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static DIELECTRIC: BlockSchema = block_schema("Dielectric", "boundary of a body of glass, water or the like")
    .with_fields(&[
        INDEX_FIELD,
        field_schema("abbe", FieldKind::Number, "with `indexOfRefraction`: Abbe number")
            .with_range(FieldRange::Positive)
            .with_default_description("none: no dispersion"),
        field_schema("glass", FieldKind::Name, "instead of `indexOfRefraction`: a glass by name"),
        field_schema("cauchy", FieldKind::Numbers, "instead of `indexOfRefraction`: Cauchy's equation; C is optional")
            .with_range(FieldRange::Special("A, B \\[µm²], C \\[µm⁴]")),
        field_schema("sellmeierB", FieldKind::Numbers, "instead of `indexOfRefraction`: Sellmeier's equation")
            .with_range(FieldRange::Special("1 to 4")),
        field_schema("sellmeierC", FieldKind::Numbers, "squared resonance wavelengths for `sellmeierB`")
            .with_range(FieldRange::Special("1 to 4"))
            .with_unit("µm²"),
        field_schema("absorption", FieldKind::Color, "absorption coefficient of the inside")
            .with_range(COEFFICIENT_RANGE)
            .with_default_description("0 0 0")
            .with_unit("1/length"),
        field_schema("tint", FieldKind::Color, "instead of `absorption`: transmittance over `tintDistance`")
            .with_range(TRANSMITTANCE_RANGE),
        field_schema("tintDistance", FieldKind::Number, "distance of `tint`; the absorption is at most 1e12")
            .with_range(FieldRange::Positive)
            .with_default_numbers(&[1.0])
            .with_unit("length"),
        ROUGHNESS_FIELD,
        MULTIPLE_SCATTERING_FIELD,
        PRIORITY_FIELD,
        field_schema("medium", FieldKind::Name, "medium that fills the body").with_default_description("none"),
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static NULL_INTERFACE: BlockSchema = block_schema("Clear", "null interface: boundary of a region without a surface")
    .with_fields(&[
        field_schema("medium", FieldKind::Name, "medium that fills the region").with_default_description("none"),
        PRIORITY_FIELD,
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static CONDUCTOR: BlockSchema = block_schema("Conductor", "metal; opaque, reflects on both sides")
    .with_fields(&[
        field_schema("metal", FieldKind::Name, "a metal by name; give this, or `eta` and `k`"),
        field_schema("eta", FieldKind::Color, "η of the complex index η + ik for red, green and blue")
            .with_range(FieldRange::Within(MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX)),
        field_schema("k", FieldKind::Color, "k of the complex index")
            .with_range(FieldRange::Within(0.0, MAX_REFRACTIVE_INDEX)),
        ROUGHNESS_FIELD,
        MULTIPLE_SCATTERING_FIELD,
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static THIN: BlockSchema = block_schema("Thin", "pane without thickness; the index is relative to the surroundings")
    .with_fields(&[
        INDEX_FIELD,
        field_schema("transmittance", FieldKind::ColorOrTexture, "transmittance of the inside at normal incidence")
            .with_range(TRANSMITTANCE_RANGE)
            .with_default_numbers(&[1.0, 1.0, 1.0]),
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static COATED_DIFFUSE: BlockSchema =
    block_schema("CoatedDiffuse", "diffuse base under a dielectric coat: plastic, varnish, glaze")
        .with_fields(&[
            field_schema("reflectance", FieldKind::ColorOrTexture, "albedo of the base")
                .with_range(UNIT_RANGE)
                .make_required(),
            field_schema("indexOfRefraction", FieldKind::Number, "index of the coat relative to the surroundings")
                .with_range(FieldRange::Within(1.0, MAX_COAT_INDEX as f64))
                .with_default_numbers(&[1.5]),
            ROUGHNESS_FIELD,
            field_schema(
                "nonlinear",
                FieldKind::Word(&["yes", "no"]),
                "`no`: light between coat and base does not make colors deeper",
            )
            .with_default_word("yes"),
        ])
        .with_aliases(&["Plastic"])
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

static MIX: BlockSchema = block_schema("Mix", "one of two materials at each point, chosen at random")
    .with_fields(&[
        field_schema("first", FieldKind::Name, "name of a material that stands before this one").make_required(),
        field_schema("second", FieldKind::Name, "name of a material that stands before this one").make_required(),
        field_schema("amount", FieldKind::NumberOrTexture, "share of the second material")
            .with_range(UNIT_RANGE)
            .make_required(),
    ])
    .with_shared_fields(&[EMISSION_FIELDS]);

/// Parses a `Materials` block. Its materials replace those of an earlier `Materials` block.
pub(super) fn parse_materials_block<'a>(parser: &mut Parser<'a>, block: Token<'a>) -> Result<(), SceneError> {
    if parser.scope.group_uses_materials {
        parser.scope.late_materials = Some(block);
    }
    parser.scope.clear_materials();
    let allowed = block_keywords(&["numMaterials"], MATERIALS);
    parser.parse_list_block(block, ("numMaterials", "material"), &allowed, |parser, word| {
        let (name, material) = match parse_new_material_name(parser) {
            Ok(name) => (name.clone(), parse_material(parser, word, name)),
            Err(error) => (None, Err(error)),
        };
        let (material, result) = match material {
            Ok(material) => (material, Ok(())),
            Err(error) => {
                // A material with errors keeps its index and name, so that references to it cause
                // no more errors.
                let kind = MaterialKindDescription::Mirror { reflectance: DVec3::ONE.into() };
                (
                    MaterialDescription { name, kind, emission: None, normal_perturbation: None, medium: None },
                    Err(error),
                )
            }
        };
        parser.scope.add_material(Spanned::new(material, word.span()));
        result
    })
}

/// Parses the optional name of a new material. Registers the name in the parser's scope with the
/// index that the material will have.
fn parse_new_material_name(parser: &mut Parser<'_>) -> Result<Option<String>, SceneError> {
    let Some(name) = parse_block_name(parser, "material")? else { return Ok(None) };
    if parser.scope.material_indices.contains_key(&name.value) {
        let message = format!("two materials are called `{}`", clip_for_message(&name.value));
        return Err(parser.lexer.error_at(name.span, message, "the second", "give it another name".to_owned()));
    }
    parser.scope.material_indices.insert(name.value.clone(), parser.scope.materials.len());
    Ok(Some(name.value))
}

/// Parses `{ … }` of a material. Its keyword `word` and its `name` have been read.
fn parse_material<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    name: Option<String>,
) -> Result<MaterialDescription, SceneError> {
    let (BlockParser { block, parse }, f) = parse_block_by_keyword(parser, word, MATERIALS)?;
    let f = &f;
    let kind = parse(parser, f)?;
    let accepted = accepted_material_fields(&kind);
    debug_assert_eq!(accepted.medium, block.find_field("medium").is_some(), "{}", block.keyword);
    debug_assert_eq!(accepted.normal_perturbation, block.find_field("bump").is_some(), "{}", block.keyword);
    let medium: Option<Spanned<String>> = if accepted.medium { f.optional_value("medium") } else { None };
    if let Some(name) = &medium {
        parser.scope.check_medium_exists(parser.lexer, name, "ahead of the Materials")?;
    }
    let normal_perturbation = if accepted.normal_perturbation { parse_normal_perturbation(f)? } else { None };
    Ok(MaterialDescription { name, kind, emission: parse_emission(f)?, normal_perturbation, medium })
}

/// Flags for the fields that a kind of material accepts: `medium`, and those of bump and normal
/// maps.
struct AcceptedMaterialFields {
    medium: bool,
    normal_perturbation: bool,
}

/// Returns which fields materials of this `kind` accept: `medium`, and those of bump and normal
/// maps.
fn accepted_material_fields(kind: &MaterialKindDescription) -> AcceptedMaterialFields {
    match kind {
        MaterialKindDescription::Dielectric { .. } | MaterialKindDescription::NullInterface { .. } => {
            AcceptedMaterialFields { medium: true, normal_perturbation: true }
        }
        MaterialKindDescription::Phong { .. }
        | MaterialKindDescription::Diffuse { .. }
        | MaterialKindDescription::Mirror { .. }
        | MaterialKindDescription::Conductor { .. }
        | MaterialKindDescription::Thin { .. }
        | MaterialKindDescription::CoatedDiffuse { .. } => {
            AcceptedMaterialFields { medium: false, normal_perturbation: true }
        }
        MaterialKindDescription::Mix { .. } => AcceptedMaterialFields { medium: false, normal_perturbation: false },
    }
}

fn parse_phong_material(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Phong {
        diffuse: f.value("diffuseColor")?,
        specular: f.value("specularColor")?,
        shininess: f.value("shininess")?,
        texture: f.optional_value("texture"),
    })
}

fn parse_diffuse_material(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Diffuse { reflectance: f.value("reflectance")? })
}

fn parse_mirror_material(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Mirror { reflectance: f.value("reflectance")? })
}

fn parse_dielectric(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Dielectric {
        refraction: parse_refraction(f)?,
        attenuation: parse_dielectric_absorption(f)?,
        roughness: f.value("roughness")?,
        multiple_scattering: f.field_word_or_default("multipleScattering")? == "yes",
        priority: f.value::<u32>("priority")? as u8,
    })
}

fn parse_null_interface(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    let advice = "needs a surface, and `Clear` has none: ";
    f.forbid_fields(&["emission", "emissionScale"], &format!("{advice}give `emission` to its medium"))?;
    f.forbid_fields(&["bump", "bumpHeight", "normalMap"], &format!("{advice}leave it out"))?;
    Ok(MaterialKindDescription::NullInterface { priority: f.value::<u32>("priority")? as u8 })
}

fn parse_conductor(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Conductor {
        metal: parse_metal(f)?,
        roughness: f.value("roughness")?,
        multiple_scattering: f.field_word_or_default("multipleScattering")? == "yes",
    })
}

fn parse_thin_dielectric(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::Thin { index: f.value("indexOfRefraction")?, transmittance: f.value("transmittance")? })
}

fn parse_coated_diffuse(_: &Parser<'_>, f: &BlockFields<'_>) -> Result<MaterialKindDescription, SceneError> {
    Ok(MaterialKindDescription::CoatedDiffuse {
        reflectance: f.value("reflectance")?,
        index: f.value("indexOfRefraction")?,
        roughness: f.value("roughness")?,
        nonlinear: f.field_word_or_default("nonlinear")? == "yes",
    })
}

/// Returns the absorption inside a dielectric, from the field `absorption` or `tint`; none if both
/// are absent.
fn parse_dielectric_absorption(f: &BlockFields<'_>) -> Result<DielectricAbsorption, SceneError> {
    f.forbid_both_fields("absorption", "tint")?;
    let Some(color) = f.optional_value("tint") else {
        f.forbid_fields(&["tintDistance"], "has no effect without `tint`")?;
        return Ok(f
            .optional_value("absorption")
            .map_or(DielectricAbsorption::None, DielectricAbsorption::Coefficient));
    };
    let attenuation = DielectricAbsorption::Tint { color, distance: f.value("tintDistance")? };
    if let Some(field) = f.get("tintDistance") {
        let is_valid = attenuation.absorption_coefficient().max_element() <= MAX_COEFFICIENT;
        field.ensure_valid(is_valid, "must be longer: over it, `tint` is an absorption above 1e12")?;
    }
    Ok(attenuation)
}

/// Parses the complex refractive index of a conductor, or the name of its metal.
fn parse_metal(f: &BlockFields<'_>) -> Result<MetalDescription, SceneError> {
    for index in ["eta", "k"] {
        f.forbid_both_fields("metal", index)?;
    }
    if let Some(name) = f.optional_value("metal") {
        return Ok(MetalDescription::Named(name));
    }
    if f.get("k").is_none() {
        // If both `metal` and `eta` are absent, this error names both.
        f.require_one_field_of(&["metal", "eta"])?;
    }
    Ok(MetalDescription::Index { eta: f.value("eta")?, k: f.value("k")? })
}

/// Parses the fields of a `Mix`. The text must define both of its materials before it.
fn parse_mix_material<'a>(parser: &Parser<'a>, f: &BlockFields<'a>) -> Result<MaterialKindDescription, SceneError> {
    let first = parse_mix_component(parser, f.require_field("first")?)?;
    let second = parse_mix_component(parser, f.require_field("second")?)?;
    let amount = f.value("amount")?;
    let scope = &parser.scope;
    for component in [&first, &second] {
        if scope.constraints_of_mixed_material(component).mix_depth == MAX_MIX_DEPTH {
            let message = format!("mixes nest more than {MAX_MIX_DEPTH} deep");
            let help = "mix fewer materials, or materials that are no mixes".to_owned();
            return Err(f.error_at(component.span, message, "the deepest that may be", help));
        }
        let index = scope.material_indices.get(&component.value).copied();
        if index
            .is_some_and(|index| matches!(scope.materials[index].kind, MaterialKindDescription::NullInterface { .. }))
        {
            let message = "a mix cannot be `Clear`, which has no surface".to_owned();
            let help = "mix a `Dielectric { indexOfRefraction 1 … }` of the same medium instead".to_owned();
            return Err(f.error_at(component.span, message, "no surface", help));
        }
    }
    // Otherwise, a path could enter one dielectric and leave the other. The first would stay on the
    // path's stack of bodies.
    if let (Some(a), Some(b)) = (
        scope.constraints_of_mixed_material(&first).dielectric,
        scope.constraints_of_mixed_material(&second).dielectric,
    ) && a != b
    {
        let message = "a mix cannot be two different Dielectrics".to_owned();
        let help = "mix a Dielectric with an opaque material, or with itself".to_owned();
        return Err(f.error_at(second.span, message, "the second body", help));
    }
    Ok(MaterialKindDescription::Mix { first, second, amount })
}

/// Returns the name of a material that a `Mix` refers to in `field`. Fails unless the text defines
/// this material before the mix.
fn parse_mix_component<'a>(parser: &Parser<'a>, field: ParsedField<'_, 'a>) -> Result<Spanned<String>, SceneError> {
    let name: Spanned<String> = field.value();
    let help = "a mix is made of materials that stand before it";
    parser.scope.check_material_exists(parser.lexer, &name, help)?;
    if parser.scope.material_indices.get(&name.value).is_some_and(|index| *index == parser.scope.materials.len()) {
        let message = format!("`{}` is a part of itself", clip_for_message(&name.value));
        let help = format!("name a material that stands before it as `{}`", field.name());
        return Err(parser.lexer.error_at(name.span, message, "this mix", help));
    }
    Ok(name)
}

fn parse_emission(f: &BlockFields<'_>) -> Result<Option<EmissionDescription>, SceneError> {
    let radiance = match f.optional_value("emission") {
        Some(TexturedValue::Texture(name)) => {
            return Ok(Some(EmissionDescription::Texture { name, scale: f.value("emissionScale")? }));
        }
        Some(TexturedValue::Plain(radiance)) => Some(EmissionDescription::Radiance(radiance)),
        None => None,
    };
    f.forbid_fields(&["emissionScale"], "has no effect without a texture as `emission`")?;
    Ok(radiance)
}

/// Returns the bump map with its height, or the normal map; `None` if the block has neither.
fn parse_normal_perturbation(f: &BlockFields<'_>) -> Result<Option<NormalPerturbationDescription>, SceneError> {
    f.forbid_both_fields("bump", "normalMap")?;
    let Some(texture) = f.optional_value("bump") else {
        f.forbid_fields(&["bumpHeight"], "has no effect without `bump`")?;
        return Ok(f.optional_value("normalMap").map(NormalPerturbationDescription::NormalMap));
    };
    Ok(Some(NormalPerturbationDescription::Bump { texture, height: f.value("bumpHeight")? }))
}

/// Parses the index of a material. The word `MaterialIndex` has been read.
pub(super) fn parse_material_index<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Spanned<u32>, SceneError> {
    parser.scope.group_uses_materials = true;
    let index = parser.parse_integer(word)?;
    let count = parser.scope.materials.len();
    if (index.value as usize) < count {
        return Ok(index);
    }
    let message = format!("there is no material {}", index.value);
    let help = match count {
        0 => "no material stands before this line: put `Materials { … }` ahead of the Group".to_owned(),
        1 => "the one material is number 0".to_owned(),
        n => format!("materials are numbered from 0 to {}", n - 1),
    };
    Err(parser.lexer.error_at(index.span, message, "out of range", help))
}

/// Parses the name of a material. The word `MaterialName` has been read.
pub(super) fn parse_material_reference<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
) -> Result<Spanned<String>, SceneError> {
    parser.scope.group_uses_materials = true;
    let name = parser.parse_name(word)?;
    let help = "name it ahead of the Group: `Materials { Diffuse name { … } }`";
    parser.scope.check_material_exists(parser.lexer, &name, help)?;
    Ok(name)
}

/// Writes the field `multipleScattering`, unless it has its default.
fn write_multiple_scattering(out: &mut SceneWriter<'_, '_>, multiple_scattering: bool) -> fmt::Result {
    if multiple_scattering { Ok(()) } else { out.write_field("multipleScattering", "no") }
}

/// Writes a material as scene text.
pub(super) fn write_material(out: &mut SceneWriter<'_, '_>, material: &MaterialDescription) -> fmt::Result {
    let block = match material.kind {
        MaterialKindDescription::Phong { .. } => &PHONG,
        MaterialKindDescription::Diffuse { .. } => &DIFFUSE,
        MaterialKindDescription::Mirror { .. } => &MIRROR,
        MaterialKindDescription::Dielectric { .. } => &DIELECTRIC,
        MaterialKindDescription::NullInterface { .. } => &NULL_INTERFACE,
        MaterialKindDescription::Conductor { .. } => &CONDUCTOR,
        MaterialKindDescription::Thin { .. } => &THIN,
        MaterialKindDescription::CoatedDiffuse { .. } => &COATED_DIFFUSE,
        MaterialKindDescription::Mix { .. } => &MIX,
    };
    match &material.name {
        None => out.begin_schema_block(block)?,
        Some(name) => out.begin_named_block(block, name)?,
    }
    match &material.kind {
        MaterialKindDescription::Phong { diffuse, specular, shininess, texture } => {
            out.write_color_or_texture("diffuseColor", diffuse)?;
            out.write_color_or_texture("specularColor", specular)?;
            out.write_number("shininess", *shininess)?;
            texture.as_ref().map_or(Ok(()), |name| out.write_name("texture", name))?;
        }
        MaterialKindDescription::Diffuse { reflectance } | MaterialKindDescription::Mirror { reflectance } => {
            out.write_color_or_texture("reflectance", reflectance)?;
        }
        MaterialKindDescription::Dielectric { refraction, attenuation, roughness, multiple_scattering, priority } => {
            write_refraction(out, refraction)?;
            match *attenuation {
                DielectricAbsorption::None => {}
                DielectricAbsorption::Coefficient(absorption) => out.write_vec3("absorption", absorption)?,
                DielectricAbsorption::Tint { color, distance } => {
                    out.write_vec3("tint", color)?;
                    out.write_number("tintDistance", distance)?;
                }
            }
            out.write_number_or_texture("roughness", roughness)?;
            write_multiple_scattering(out, *multiple_scattering)?;
            out.write_field("priority", priority)?;
        }
        MaterialKindDescription::NullInterface { priority } => out.write_field("priority", priority)?,
        MaterialKindDescription::Conductor { metal, roughness, multiple_scattering } => {
            match metal {
                MetalDescription::Named(name) => out.write_name("metal", name)?,
                MetalDescription::Index { eta, k } => {
                    out.write_vec3("eta", *eta)?;
                    out.write_vec3("k", *k)?;
                }
            }
            out.write_number_or_texture("roughness", roughness)?;
            write_multiple_scattering(out, *multiple_scattering)?;
        }
        MaterialKindDescription::Thin { index, transmittance } => {
            out.write_number("indexOfRefraction", *index)?;
            out.write_color_or_texture("transmittance", transmittance)?;
        }
        MaterialKindDescription::CoatedDiffuse { reflectance, index, roughness, nonlinear } => {
            out.write_color_or_texture("reflectance", reflectance)?;
            out.write_number("indexOfRefraction", *index)?;
            out.write_number_or_texture("roughness", roughness)?;
            out.write_field("nonlinear", if *nonlinear { "yes" } else { "no" })?;
        }
        MaterialKindDescription::Mix { first, second, amount } => {
            out.write_name("first", first)?;
            out.write_name("second", second)?;
            out.write_number_or_texture("amount", amount)?;
        }
    }
    material.medium.as_ref().map_or(Ok(()), |medium| out.write_name("medium", medium))?;
    match &material.normal_perturbation {
        None => {}
        Some(NormalPerturbationDescription::Bump { texture, height }) => {
            out.write_name("bump", texture)?;
            out.write_number("bumpHeight", *height)?;
        }
        Some(NormalPerturbationDescription::NormalMap(texture)) => out.write_name("normalMap", texture)?,
    }
    match &material.emission {
        None => {}
        Some(EmissionDescription::Radiance(radiance)) => out.write_vec3("emission", *radiance)?,
        Some(EmissionDescription::Texture { name, scale }) => {
            out.write_texture_name("emission", name)?;
            out.write_number("emissionScale", *scale)?;
        }
    }
    out.end_block()
}
