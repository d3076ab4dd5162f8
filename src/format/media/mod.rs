//! Participating media in the scene language: descriptions, parsing and writing of their blocks,
//! and conversion to the media that are rendered.

mod coefficients;
mod density;
mod extent;
mod phase_function;

use super::error::SceneError;
use super::language::fields::{BlockFields, parse_block_by_keyword};
use super::language::lexer::Token;
use super::language::names::parse_unique_block_name;
use super::language::parser::Parser;
use super::language::schema::{
    BlockParser, BlockSchema, FieldKind, FieldSchema, block_keywords, block_schema, field_schema,
};
use super::language::writer::SceneWriter;
use super::lights::LightDescription;
use super::resolve::{Resolver, rgb};
use super::span::Spanned;
use crate::color::Rgb;
use crate::medium::Medium;
pub use coefficients::MediumCoefficients;
use coefficients::{
    ABSORPTION, ALBEDO, COEFFICIENT_RANGE, EXTINCTION, SCATTERING, parse_medium_coefficients, write_medium_coefficients,
};
pub use density::DensityDescription;
use density::{CLOUD_FIELDS, GRID_FIELDS, make_density_grid, parse_cloud_density, parse_medium_density, write_density};
use extent::EXTENT_FIELDS;
pub use extent::TransformedBoxDescription;
use glam::DVec3;
pub use phase_function::PhaseFunctionDescription;
use phase_function::{ANISOTROPY, PHASE, parse_phase_function, resolve_phase_function, write_phase_function};
use std::fmt;
use std::sync::Arc;

/// A participating medium as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumDescription {
    /// Name that materials and the scene's ambient medium refer to: not empty, without line breaks.
    pub name: String,
    /// Absorption and scattering in 1/length at density 1.
    pub coefficients: MediumCoefficients,
    /// Emitted radiance per length at density 1, in W/(m² sr) per unit of length.
    pub emission: DVec3,
    /// Phase function of the medium.
    pub phase: PhaseFunctionDescription,
    /// Density by position. It multiplies the coefficients and the emission.
    pub density: DensityDescription,
}

/// Medium blocks of the scene language, each with the function that converts its density fields.
pub(super) static MEDIUM_BLOCK_PARSERS: &[BlockParser<ParseDensity>] = &[
    BlockParser { block: &MEDIUM, parse: parse_medium_density },
    BlockParser { block: &CLOUD, parse: parse_cloud_density },
];

/// Function that converts the parsed fields of a medium block to the density of the medium.
type ParseDensity = fn(&BlockFields<'_>) -> Result<DensityDescription, SceneError>;

/// Field for the emission.
const EMISSION: FieldSchema = field_schema("emission", FieldKind::Color, "radiance gained per length")
    .with_range(COEFFICIENT_RANGE)
    .with_default_numbers(&[0.0, 0.0, 0.0])
    .with_unit("W/(m² sr)/length");

/// Fields that all medium blocks have.
const OPTICAL_FIELDS: &[FieldSchema] = &[ABSORPTION, SCATTERING, EXTINCTION, ALBEDO, EMISSION, PHASE, ANISOTROPY];

static MEDIUM: BlockSchema = block_schema("Medium", "a medium of constant density, or with the densities of a grid")
    .with_own_fields(GRID_FIELDS)
    .with_shared_fields(&[OPTICAL_FIELDS, EXTENT_FIELDS]);

static CLOUD: BlockSchema =
    block_schema("Cloud", "a medium with noise as density, from 0 to 1, in the ellipsoid inscribed in its box")
        .with_own_fields(CLOUD_FIELDS)
        .with_shared_fields(&[OPTICAL_FIELDS, EXTENT_FIELDS]);

/// Parses a `Media` block. Its media replace those of an earlier `Media` block.
pub(super) fn parse_media_block<'a>(
    parser: &mut Parser<'a>,
    block: Token<'a>,
) -> Result<Vec<Spanned<MediumDescription>>, SceneError> {
    let mut media = Vec::new();
    parser.scope.check_precedes_materials(parser.lexer, block)?;
    parser.scope.medium_names.clear();
    parser.parse_list_block(
        block,
        ("numMedia", "medium"),
        &block_keywords(&["numMedia"], MEDIUM_BLOCK_PARSERS),
        |parser, word| {
            let is_taken = |parser: &Parser<'a>, name: &str| parser.scope.medium_names.iter().any(|m| m == name);
            let name = parse_unique_block_name(parser, word, ("medium", "media"), is_taken)?;
            let (medium, result) = match parse_medium(parser, word, &name) {
                Ok(medium) => (medium, Ok(())),
                // A medium with errors still defines its name, so that references to it cause no
                // more errors.
                Err(error) => (placeholder_medium(&name), Err(error)),
            };
            parser.scope.medium_names.push(name);
            media.push(Spanned::new(medium, word.span()));
            result
        },
    )?;
    Ok(media)
}

/// Returns a medium without any effect, to take the place of a medium whose block has errors.
///
/// So the name stays defined, and references to it do not cause further errors.
fn placeholder_medium(name: &str) -> MediumDescription {
    let coefficients = MediumCoefficients::AbsorptionScattering { absorption: DVec3::ZERO, scattering: DVec3::ZERO };
    let (emission, phase, density) =
        (DVec3::ZERO, PhaseFunctionDescription::Isotropic, DensityDescription::Homogeneous);
    MediumDescription { name: name.to_owned(), coefficients, emission, phase, density }
}

/// Parses the `{ … }` of a medium block. The caller has read its keyword `word` and its `name`.
fn parse_medium<'a>(parser: &mut Parser<'a>, word: Token<'a>, name: &str) -> Result<MediumDescription, SceneError> {
    let (entry, f) = parse_block_by_keyword(parser, word, MEDIUM_BLOCK_PARSERS)?;
    let f = &f;
    Ok(MediumDescription {
        name: name.to_owned(),
        coefficients: parse_medium_coefficients(f)?,
        emission: f.value_or_default("emission")?,
        phase: parse_phase_function(f)?,
        density: (entry.parse)(f)?,
    })
}

/// Writes a medium as scene text.
pub(super) fn write_medium(out: &mut SceneWriter<'_, '_>, medium: &MediumDescription) -> fmt::Result {
    let block = match medium.density {
        DensityDescription::Homogeneous | DensityDescription::Grid { .. } => &MEDIUM,
        DensityDescription::Cloud { .. } => &CLOUD,
    };
    out.begin_named_block(block, &medium.name)?;
    write_medium_coefficients(out, medium.coefficients)?;
    if medium.emission != DVec3::ZERO {
        out.write_vec3("emission", medium.emission)?;
    }
    write_phase_function(out, medium.phase)?;
    write_density(out, &medium.density)?;
    out.end_block()
}

/// Adds all `media` of the description to the scene.
pub(super) fn add_media<'a>(r: &mut Resolver<'a>, media: &'a [Spanned<MediumDescription>]) -> Result<(), SceneError> {
    for described in media {
        let medium = make_medium(r, described)?;
        let index = r.builder.add_medium(medium.clone());
        r.media.insert(&described.name, (index, medium));
    }
    Ok(())
}

/// Converts a medium's description to the renderer's [`Medium`]. Reads its density grid, or samples
/// its cloud on a grid.
fn make_medium(r: &Resolver<'_>, described: &Spanned<MediumDescription>) -> Result<Medium, SceneError> {
    let (absorption, scattering) = described.coefficients.absorption_and_scattering();
    let phase = resolve_phase_function(described.phase);
    let (absorption, scattering, emission) = (rgb(absorption), rgb(scattering), rgb(described.emission));
    Ok(match make_density_grid(r, described.span, &described.density)? {
        None => Medium::homogeneous(absorption, scattering, emission, phase),
        Some(density) => Medium::heterogeneous(absorption, scattering, emission, phase, Arc::new(density)),
    })
}

/// Makes the medium called `name` the ambient medium, which fills the space outside all bodies.
/// Does nothing if `name` is `None`.
///
/// # Errors
/// - No medium has this name.
/// - The medium varies in space.
/// - The medium emits in a color channel in which it neither absorbs nor scatters, so it would be
///   infinitely bright.
/// - The medium absorbs or scatters, and one of the `lights` is at infinity, so none of its light
///   would arrive.
pub(super) fn set_ambient_medium(
    r: &mut Resolver<'_>,
    name: Option<&Spanned<String>>,
    lights: &[Spanned<LightDescription>],
) -> Result<(), SceneError> {
    let Some(name) = name else { return Ok(()) };
    let (index, medium) = medium_by_name(r, name)?;
    let refuse = |reason: &str, help: &str| {
        let message = format!("the medium `{}` cannot fill the scene: {reason}", name.value);
        Err(SceneError::error_at_span(r.source, name.span, message, "fills the scene", help))
    };
    if !medium.is_homogeneous() {
        return refuse("it is not the same everywhere", "put it into a shape of a material `Clear { medium … }`");
    }
    let extinction = medium.extinction();
    if (medium.emission.cmpgt(Rgb::ZERO) & extinction.cmpeq(Rgb::ZERO)).any() {
        let help = "let it absorb in each channel in which it emits, or put it into a shape of a material `Clear`";
        return refuse("it emits without absorbing, so it is infinitely bright", help);
    }
    if extinction != Rgb::ZERO
        && let Some(light) = lights.iter().find(|light| light.is_infinite())
    {
        let message =
            format!("the medium `{}` fills the scene and absorbs or scatters all light from infinity", name.value);
        let help = "leave the light out, or put the medium into a shape of a material `Clear { medium … }`";
        return Err(r.error_at(LightDescription::innermost_light(light).span, &message, help));
    }
    r.builder.set_ambient_medium(index);
    Ok(())
}

/// Returns the medium called `name` and its index in the scene; an error if there is none.
pub(super) fn medium_by_name(r: &Resolver<'_>, name: &Spanned<String>) -> Result<(u32, Medium), SceneError> {
    r.media.get(name.as_str()).cloned().ok_or_else(|| {
        let message = format!("no medium is called `{}`", name.value);
        SceneError::error_at_span(r.source, name.span, message, "unknown name", "define it in Media first")
    })
}
