//! Schemas, parsing and writing of medium blocks.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, Spanned,
    TransformedBoxDescription,
};
use super::super::error::SceneError;
use super::fields::{BlockFields, parse_block_by_keyword};
use super::lexer::Token;
use super::names::parse_unique_block_name;
use super::parser::Parser;
use super::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, MAX_COEFFICIENT, block_keywords, block_schema,
    field_schema,
};
use super::transforms::write_transform_field;
use super::writer::SceneWriter;

/// Medium blocks of the scene language, each with the function that converts its density fields.
pub(super) static MEDIA: &[BlockParser<ParseDensity>] = &[
    BlockParser { block: &MEDIUM, parse: parse_medium_density },
    BlockParser { block: &CLOUD, parse: parse_cloud_density },
];

/// Function that converts the parsed fields of a medium block to the density of the medium.
type ParseDensity = fn(&BlockFields<'_>) -> Result<DensityDescription, SceneError>;

const COEFFICIENT_RANGE: FieldRange = FieldRange::Within(0.0, MAX_COEFFICIENT);

static OPTICAL_FIELDS: &[FieldSchema] = &[
    field_schema("absorption", FieldKind::Color, "absorption coefficient σa")
        .with_range(COEFFICIENT_RANGE)
        .with_default_numbers(&[0.0, 0.0, 0.0])
        .with_unit("1/length"),
    field_schema("scattering", FieldKind::Color, "scattering coefficient σs")
        .with_range(COEFFICIENT_RANGE)
        .with_default_numbers(&[0.0, 0.0, 0.0])
        .with_unit("1/length"),
    field_schema("extinction", FieldKind::Color, "σa + σs, together with `albedo` instead of both")
        .with_range(COEFFICIENT_RANGE)
        .with_unit("1/length"),
    field_schema("albedo", FieldKind::Color, "σs/(σa + σs), together with `extinction`")
        .with_range(FieldRange::Within(0.0, 1.0)),
    field_schema("emission", FieldKind::Color, "radiance gained per length")
        .with_range(COEFFICIENT_RANGE)
        .with_default_numbers(&[0.0, 0.0, 0.0])
        .with_unit("W/(m² sr)/length"),
    field_schema("phase", FieldKind::Word(&["isotropic", "rayleigh", "henyey-greenstein"]), "phase function")
        .with_default_description("`isotropic`; with `anisotropy`, `henyey-greenstein`"),
    field_schema("anisotropy", FieldKind::Number, "mean cosine g; above 0 scatters forward")
        .with_range(FieldRange::Special("−1 < g < 1")),
];

static EXTENT_FIELDS: &[FieldSchema] = &[
    field_schema("min", FieldKind::Point, "least corner of the box; required, but for a `Medium` without `grid`"),
    field_schema("max", FieldKind::Point, "greatest corner, above `min` in each component"),
    field_schema("Transform", FieldKind::TransformSteps, "maps from the space of the box to the world")
        .with_default_description("none"),
];

static MEDIUM: BlockSchema = block_schema("Medium", "a medium of constant density, or with the densities of a grid")
    .with_fields(&[
        field_schema("grid", FieldKind::Name, "file of densities")
            .with_default_description("none: density 1 everywhere"),
        field_schema("densityScale", FieldKind::Number, "with `grid`: factor of its densities")
            .with_range(FieldRange::Positive)
            .with_default_numbers(&[1.0]),
    ])
    .with_shared_fields(&[OPTICAL_FIELDS, EXTENT_FIELDS]);

static CLOUD: BlockSchema =
    block_schema("Cloud", "a medium with noise as density, from 0 to 1, in the ellipsoid inscribed in its box")
        .with_fields(&[
            field_schema("cover", FieldKind::Number, "amount of noise: 0 is empty, 1 is noise everywhere")
                .with_range(FieldRange::Within(0.0, 1.0))
                .with_default_numbers(&[0.5]),
            field_schema("softness", FieldKind::Number, "share of the radius over which the edge fades")
                .with_range(FieldRange::Within(0.0, 1.0))
                .with_default_numbers(&[0.3]),
            field_schema("octaves", FieldKind::Whole, "octaves of noise")
                .with_range(FieldRange::Within(1.0, 16.0))
                .with_default_numbers(&[5.0]),
            field_schema("frequency", FieldKind::Number, "periods of the first octave along a side of the box")
                .with_range(FieldRange::Positive)
                .with_default_numbers(&[4.0]),
            field_schema("seed", FieldKind::Whole, "seed of the noise").with_default_numbers(&[0.0]),
            field_schema("resolution", FieldKind::Whole, "grid cells along the longest side")
                .with_range(FieldRange::Within(2.0, 512.0))
                .with_default_numbers(&[96.0]),
        ])
        .with_shared_fields(&[OPTICAL_FIELDS, EXTENT_FIELDS]);

/// Parses a `Media` block. Its media replace those of an earlier `Media` block.
pub(super) fn parse_media_block<'a>(parser: &mut Parser<'a>, block: Token<'a>) -> Result<(), SceneError> {
    parser.scope.check_precedes_materials(parser.lexer, block)?;
    parser.scope.media.clear();
    parser.parse_list_block(block, ("numMedia", "medium"), &block_keywords(&["numMedia"], MEDIA), |parser, word| {
        let is_taken = |parser: &Parser<'a>, name: &str| parser.scope.media.iter().any(|m| m.value.name == name);
        let name = parse_unique_block_name(parser, word, ("medium", "media"), is_taken)?;
        let (medium, result) = match parse_medium(parser, word, &name) {
            Ok(medium) => (medium, Ok(())),
            // A medium with errors still defines its name, so that references to it cause no more
            // errors.
            Err(error) => (placeholder_medium(&name), Err(error)),
        };
        parser.scope.media.push(Spanned::new(medium, word.span()));
        result
    })
}

/// Returns a medium without any effect, which replaces a medium that has errors.
///
/// References to its name then cause no more errors.
fn placeholder_medium(name: &str) -> MediumDescription {
    let coefficients = MediumCoefficients::AbsorptionScattering { absorption: DVec3::ZERO, scattering: DVec3::ZERO };
    let (emission, phase, density) =
        (DVec3::ZERO, PhaseFunctionDescription::Isotropic, DensityDescription::Homogeneous);
    MediumDescription { name: name.to_owned(), coefficients, emission, phase, density }
}

/// Parses `{ … }` of a medium. Its keyword `word` and its `name` have been read.
fn parse_medium<'a>(parser: &mut Parser<'a>, word: Token<'a>, name: &str) -> Result<MediumDescription, SceneError> {
    let (entry, f) = parse_block_by_keyword(parser, word, MEDIA)?;
    let f = &f;
    Ok(MediumDescription {
        name: name.to_owned(),
        coefficients: parse_medium_coefficients(f)?,
        emission: f.value("emission")?,
        phase: parse_phase_function(f)?,
        density: (entry.parse)(f)?,
    })
}

fn parse_medium_coefficients(f: &BlockFields<'_>) -> Result<MediumCoefficients, SceneError> {
    for whole in ["extinction", "albedo"] {
        for part in ["absorption", "scattering"] {
            f.forbid_both_fields(part, whole)?;
        }
    }
    let Some(extinction) = f.optional_value("extinction") else {
        f.forbid_fields(&["albedo"], "has no effect without `extinction`")?;
        return Ok(MediumCoefficients::AbsorptionScattering {
            absorption: f.value("absorption")?,
            scattering: f.value("scattering")?,
        });
    };
    Ok(MediumCoefficients::ExtinctionAlbedo { extinction, albedo: f.value("albedo")? })
}

fn parse_phase_function(f: &BlockFields<'_>) -> Result<PhaseFunctionDescription, SceneError> {
    let word: Option<Spanned<String>> = f.optional_value("phase");
    match (word.as_ref().map(|word| word.as_str()), f.get("anisotropy")) {
        (None | Some("isotropic"), None) => Ok(PhaseFunctionDescription::Isotropic),
        (Some("rayleigh"), None) => Ok(PhaseFunctionDescription::Rayleigh),
        (None | Some("henyey-greenstein"), Some(field)) => {
            let g: f64 = field.value();
            field.ensure_valid(g.abs() <= 1.0 - 1e-7, "must lie inside -1 … 1, by 1e-7 at least")?;
            Ok(PhaseFunctionDescription::HenyeyGreenstein(g))
        }
        (Some(_), Some(field)) => {
            field.ensure_valid(false, "belongs to `phase henyey-greenstein`: leave one of both out")?;
            Ok(PhaseFunctionDescription::Isotropic)
        }
        (Some(_), None) => Ok(PhaseFunctionDescription::HenyeyGreenstein(f.value("anisotropy")?)),
    }
}

/// Parses the density of a `Medium`: a grid, or 1 everywhere.
fn parse_medium_density(f: &BlockFields<'_>) -> Result<DensityDescription, SceneError> {
    let Some(path) = f.optional_value("grid") else {
        f.forbid_fields(&["min", "max", "Transform", "densityScale"], "has no effect without `grid`")?;
        return Ok(DensityDescription::Homogeneous);
    };
    Ok(DensityDescription::Grid { path, scale: f.value("densityScale")?, extent: parse_medium_box(f)? })
}

fn parse_cloud_density(f: &BlockFields<'_>) -> Result<DensityDescription, SceneError> {
    Ok(DensityDescription::Cloud {
        cover: f.value("cover")?,
        softness: f.value("softness")?,
        octaves: f.value("octaves")?,
        frequency: f.value("frequency")?,
        seed: f.value("seed")?,
        resolution: f.value("resolution")?,
        extent: parse_medium_box(f)?,
    })
}

/// Returns the box of a grid or cloud, with the transform from box space to world space.
fn parse_medium_box(f: &BlockFields<'_>) -> Result<TransformedBoxDescription, SceneError> {
    let (min, max): (DVec3, DVec3) = (f.value("min")?, f.value("max")?);
    let sides = max - min;
    let is_valid = sides.min_element() > 0.0 && sides.is_finite();
    f.require_field("max")?.ensure_valid(is_valid, "must be above `min` in each component")?;
    Ok(TransformedBoxDescription { min, max, steps: f.optional_value("Transform").unwrap_or_default() })
}

/// Writes a medium as scene text.
pub(super) fn write_medium(out: &mut SceneWriter<'_, '_>, medium: &MediumDescription) -> fmt::Result {
    let block = match medium.density {
        DensityDescription::Homogeneous | DensityDescription::Grid { .. } => &MEDIUM,
        DensityDescription::Cloud { .. } => &CLOUD,
    };
    out.begin_named_block(block, &medium.name)?;
    match medium.coefficients {
        MediumCoefficients::AbsorptionScattering { absorption, scattering } => {
            out.write_vec3("absorption", absorption)?;
            out.write_vec3("scattering", scattering)?;
        }
        MediumCoefficients::ExtinctionAlbedo { extinction, albedo } => {
            out.write_vec3("extinction", extinction)?;
            out.write_vec3("albedo", albedo)?;
        }
    }
    if medium.emission != DVec3::ZERO {
        out.write_vec3("emission", medium.emission)?;
    }
    match medium.phase {
        PhaseFunctionDescription::Isotropic => {}
        PhaseFunctionDescription::Rayleigh => out.write_field("phase", "rayleigh")?,
        PhaseFunctionDescription::HenyeyGreenstein(g) => out.write_number("anisotropy", g)?,
    }
    match &medium.density {
        DensityDescription::Homogeneous => {}
        DensityDescription::Grid { path, scale, extent } => {
            out.write_name("grid", path)?;
            out.write_number("densityScale", *scale)?;
            write_medium_box(out, extent)?;
        }
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
            out.write_number("cover", *cover)?;
            out.write_number("softness", *softness)?;
            out.write_field("octaves", octaves)?;
            out.write_number("frequency", *frequency)?;
            out.write_field("seed", seed)?;
            out.write_field("resolution", resolution)?;
            write_medium_box(out, extent)?;
        }
    }
    out.end_block()
}

fn write_medium_box(out: &mut SceneWriter<'_, '_>, extent: &TransformedBoxDescription) -> fmt::Result {
    out.write_vec3("min", extent.min)?;
    out.write_vec3("max", extent.max)?;
    write_transform_field(out, &extent.steps)
}
