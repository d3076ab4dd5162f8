//! Participating media in the scene language: descriptions, parsing and writing of their blocks,
//! and conversion to the media that are rendered.

use super::error::SceneError;
use super::grid;
use super::language::fields::{BlockFields, parse_block_by_keyword};
use super::language::lexer::Token;
use super::language::names::parse_unique_block_name;
use super::language::parser::Parser;
use super::language::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, MAX_MEDIUM_COEFFICIENT, block_keywords, block_schema,
    field_schema,
};
use super::language::transforms::write_transform_field;
use super::language::writer::SceneWriter;
use super::lights::LightDescription;
use super::resolve::{Resolver, rgb};
use super::span::Spanned;
use super::transform_step::TransformStep;
use crate::color::Rgb;
use crate::medium::{Cloud, GridDensity, GridDensityError, Medium, PhaseFunction};
use crate::stats::format_bytes;
use glam::{DAffine3, DVec3};
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

/// Absorption and scattering coefficients of a medium, in one of two parametrizations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MediumCoefficients {
    /// Absorption and scattering coefficients.
    AbsorptionScattering {
        /// Absorption coefficient σa in 1/length at density 1, at least 0.
        absorption: DVec3,
        /// Scattering coefficient σs in 1/length at density 1, at least 0.
        scattering: DVec3,
    },
    /// Extinction coefficient and single-scattering albedo.
    ExtinctionAlbedo {
        /// Extinction coefficient σt = σa + σs in 1/length at density 1, at least 0.
        extinction: DVec3,
        /// Single-scattering albedo σs/σt, inside \[0, 1].
        albedo: DVec3,
    },
}

/// Phase function of a medium, which gives the distribution of directions after scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunctionDescription {
    /// Equal scattering in all directions.
    Isotropic,
    /// Rayleigh scattering: particles much smaller than the wavelength.
    Rayleigh,
    /// Henyey–Greenstein phase function. The number is its mean cosine g, inside (−1, 1); above 0,
    /// forward scattering prevails.
    HenyeyGreenstein(f64),
}

/// Density of a medium as a function of position. It multiplies the medium's coefficients.
#[derive(Clone, Debug, PartialEq)]
pub enum DensityDescription {
    /// Density 1 everywhere.
    Homogeneous,
    /// Densities from a grid file.
    Grid {
        /// Path of the grid file, as the scene file states it: not empty, without line breaks.
        path: Spanned<String>,
        /// Factor that multiplies the file's densities, above 0.
        scale: f64,
        /// Box that the grid fills.
        extent: TransformedBoxDescription,
    },
    /// A procedural cloud in the ellipsoid inscribed in a box. Its density is noise from 0 to 1.
    Cloud {
        /// Cloud cover, from 0 (empty) to 1 (everywhere).
        cover: f64,
        /// Width of the cloud's soft edge, as a fraction of the ellipsoid's radius, inside \[0, 1].
        softness: f64,
        /// Number of noise octaves, from 1 to 16.
        octaves: u32,
        /// Number of noise periods of the first octave along each side of the box, above 0.
        frequency: f64,
        /// Random seed of the noise.
        seed: u32,
        /// Resolution of the grid on which the cloud is sampled: the number of cells along the
        /// longest side of the box, from 2 to 512.
        resolution: u32,
        /// Box that contains the cloud's ellipsoid.
        extent: TransformedBoxDescription,
    },
}

/// A box under an affine transform.
#[derive(Clone, Debug, PartialEq)]
pub struct TransformedBoxDescription {
    /// Corner with the lowest coordinates, before the transform.
    pub min: DVec3,
    /// Opposite corner, above `min` in every coordinate.
    pub max: DVec3,
    /// Steps of the transform to world space; see [`TransformStep::composed_matrix`].
    pub steps: Vec<TransformStep>,
}

/// Medium blocks of the scene language, each with the function that converts its density fields.
pub(super) static MEDIUM_BLOCK_PARSERS: &[BlockParser<ParseDensity>] = &[
    BlockParser { block: &MEDIUM, parse: parse_medium_density },
    BlockParser { block: &CLOUD, parse: parse_cloud_density },
];

/// Function that converts the parsed fields of a medium block to the density of the medium.
type ParseDensity = fn(&BlockFields<'_>) -> Result<DensityDescription, SceneError>;

const COEFFICIENT_RANGE: FieldRange = FieldRange::ClosedInterval(0.0, MAX_MEDIUM_COEFFICIENT);

const OPTICAL_FIELDS: &[FieldSchema] = &[
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
        .with_range(FieldRange::ClosedInterval(0.0, 1.0)),
    field_schema("emission", FieldKind::Color, "radiance gained per length")
        .with_range(COEFFICIENT_RANGE)
        .with_default_numbers(&[0.0, 0.0, 0.0])
        .with_unit("W/(m² sr)/length"),
    field_schema("phase", FieldKind::Word(&["isotropic", "rayleigh", "henyey-greenstein"]), "phase function")
        .make_optional("`isotropic`; with `anisotropy`, `henyey-greenstein`"),
    field_schema("anisotropy", FieldKind::Number, "mean cosine g; above 0 scatters forward")
        .with_range(FieldRange::DescribedOnly("−1 < g < 1")),
];

const EXTENT_FIELDS: &[FieldSchema] = &[
    field_schema("min", FieldKind::Point, "least corner of the box; required, but for a `Medium` without `grid`"),
    field_schema("max", FieldKind::Point, "greatest corner, above `min` in each component"),
    field_schema("Transform", FieldKind::TransformSteps, "maps from the space of the box to the world")
        .make_optional("none"),
];

static MEDIUM: BlockSchema = block_schema("Medium", "a medium of constant density, or with the densities of a grid")
    .with_own_fields(&[
        field_schema("grid", FieldKind::Name, "file of densities").make_optional("none: density 1 everywhere"),
        field_schema("densityScale", FieldKind::Number, "with `grid`: factor of its densities")
            .with_range(FieldRange::Positive)
            .with_default_numbers(&[1.0]),
    ])
    .with_shared_fields(&[OPTICAL_FIELDS, EXTENT_FIELDS]);

static CLOUD: BlockSchema =
    block_schema("Cloud", "a medium with noise as density, from 0 to 1, in the ellipsoid inscribed in its box")
        .with_own_fields(&[
            field_schema("cover", FieldKind::Number, "amount of noise: 0 is empty, 1 is noise everywhere")
                .with_range(FieldRange::ClosedInterval(0.0, 1.0))
                .with_default_numbers(&[0.5]),
            field_schema("softness", FieldKind::Number, "share of the radius over which the edge fades")
                .with_range(FieldRange::ClosedInterval(0.0, 1.0))
                .with_default_numbers(&[0.3]),
            field_schema("octaves", FieldKind::WholeNumber, "octaves of noise")
                .with_range(FieldRange::ClosedInterval(1.0, 16.0))
                .with_default_numbers(&[5.0]),
            field_schema("frequency", FieldKind::Number, "periods of the first octave along a side of the box")
                .with_range(FieldRange::Positive)
                .with_default_numbers(&[4.0]),
            field_schema("seed", FieldKind::WholeNumber, "seed of the noise").with_default_numbers(&[0.0]),
            field_schema("resolution", FieldKind::WholeNumber, "grid cells along the longest side")
                .with_range(FieldRange::ClosedInterval(2.0, 512.0))
                .with_default_numbers(&[96.0]),
        ])
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

fn parse_medium_coefficients(f: &BlockFields<'_>) -> Result<MediumCoefficients, SceneError> {
    for whole in ["extinction", "albedo"] {
        for part in ["absorption", "scattering"] {
            f.forbid_both_fields(part, whole)?;
        }
    }
    let Some(extinction) = f.optional_value("extinction") else {
        f.forbid_fields(&["albedo"], "has no effect without `extinction`")?;
        return Ok(MediumCoefficients::AbsorptionScattering {
            absorption: f.value_or_default("absorption")?,
            scattering: f.value_or_default("scattering")?,
        });
    };
    Ok(MediumCoefficients::ExtinctionAlbedo { extinction, albedo: f.value_or_default("albedo")? })
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
        (Some(_), None) => Ok(PhaseFunctionDescription::HenyeyGreenstein(f.value_or_default("anisotropy")?)),
    }
}

/// Parses the density of a `Medium`: a grid, or 1 everywhere.
fn parse_medium_density(f: &BlockFields<'_>) -> Result<DensityDescription, SceneError> {
    let Some(path) = f.optional_value("grid") else {
        f.forbid_fields(&["min", "max", "Transform", "densityScale"], "has no effect without `grid`")?;
        return Ok(DensityDescription::Homogeneous);
    };
    Ok(DensityDescription::Grid { path, scale: f.value_or_default("densityScale")?, extent: parse_medium_box(f)? })
}

fn parse_cloud_density(f: &BlockFields<'_>) -> Result<DensityDescription, SceneError> {
    Ok(DensityDescription::Cloud {
        cover: f.value_or_default("cover")?,
        softness: f.value_or_default("softness")?,
        octaves: f.value_or_default("octaves")?,
        frequency: f.value_or_default("frequency")?,
        seed: f.value_or_default("seed")?,
        resolution: f.value_or_default("resolution")?,
        extent: parse_medium_box(f)?,
    })
}

/// Returns the box of a grid or cloud, with the transform from box space to world space.
fn parse_medium_box(f: &BlockFields<'_>) -> Result<TransformedBoxDescription, SceneError> {
    let (min, max): (DVec3, DVec3) = (f.value_or_default("min")?, f.value_or_default("max")?);
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
            out.write_name_field("grid", path)?;
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

/// Greatest allowed density of a grid, after multiplication by the grid's `scale`.
///
/// Densities up to this value can be multiplied by coefficients and lengths without overflow in
/// single precision.
const MAX_DENSITY: f64 = 1e12;

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
    let (absorption, scattering) = match described.coefficients {
        MediumCoefficients::AbsorptionScattering { absorption, scattering } => (absorption, scattering),
        MediumCoefficients::ExtinctionAlbedo { extinction, albedo } => {
            (extinction * (1.0 - albedo), extinction * albedo)
        }
    };
    let phase = match described.phase {
        PhaseFunctionDescription::Isotropic => PhaseFunction::Isotropic,
        PhaseFunctionDescription::Rayleigh => PhaseFunction::Rayleigh,
        PhaseFunctionDescription::HenyeyGreenstein(g) => PhaseFunction::HenyeyGreenstein(g as f32),
    };
    let (absorption, scattering, emission) = (rgb(absorption), rgb(scattering), rgb(described.emission));
    Ok(match make_density_grid(r, described)? {
        None => Medium::homogeneous(absorption, scattering, emission, phase),
        Some(density) => Medium::heterogeneous(absorption, scattering, emission, phase, Arc::new(density)),
    })
}

/// Returns the density grid of a medium: scaled values of a grid file or embedded grid, or samples
/// of a cloud.
///
/// `None` for a homogeneous medium.
fn make_density_grid(
    r: &Resolver<'_>,
    described: &Spanned<MediumDescription>,
) -> Result<Option<GridDensity>, SceneError> {
    let help = "give a box with an extent, and fewer cells if memory does not suffice";
    let refuse = |e: GridDensityError| r.error_at(described.span, &e.to_string(), help);
    let density = match &described.density {
        DensityDescription::Homogeneous => return Ok(None),
        DensityDescription::Grid { path, scale, extent } => {
            let file = r.find_file("grid", path)?;
            let help = "repair the grid or name another; the grid format is described in docs/guide/scene-language.md";
            let mut grid = match r.assets.grids.get(path.as_str()) {
                Some(grid) => (**grid).clone(),
                None => grid::read_with_memory_limit(&file, r.memory.available_bytes()).map_err(|e| {
                    r.file_or_memory_error(path, &e, matches!(e, grid::GridError::OutOfMemory { .. }), help)
                })?,
            };
            for value in &mut grid.densities {
                let scaled = f64::from(*value) * scale;
                if scaled > MAX_DENSITY {
                    let message = format!("the grid `{}` is as dense as {value}, times {scale}", path.value);
                    return Err(r.file_error(path, &message, "choose a `densityScale` by which it is below 1e12"));
                }
                *value = scaled as f32;
            }
            GridDensity::new(grid.cell_counts, grid.densities, unit_cube_to_world(extent)).map_err(refuse)?
        }
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
            let cloud = Cloud {
                octaves: *octaves,
                frequency: *frequency,
                cover: *cover,
                softness: *softness,
                seed: u64::from(*seed),
            };
            let size = grid_size(extent, *resolution);
            let needed = grid::MEMORY_PER_CELL * size.iter().map(|n| u64::from(*n)).product::<u64>();
            if let Some(free) = r.memory.available_bytes().filter(|free| needed > *free) {
                let message =
                    format!("the cloud takes {} of memory, and {} are free", format_bytes(needed), format_bytes(free));
                let help = "choose a smaller `resolution`, or let the scene have more memory (--memory)";
                return Err(r.error_at(described.span, &message, help).marked_out_of_memory());
            }
            let density_at = cloud.density_function(1.0 / f64::from(*resolution));
            GridDensity::from_fn(size, unit_cube_to_world(extent), density_at).map_err(refuse)?
        }
    };
    Ok(Some(density))
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

/// Returns the map from the unit cube \[0, 1]³ to the transformed box `extent` in world space.
fn unit_cube_to_world(extent: &TransformedBoxDescription) -> DAffine3 {
    let fit = DAffine3::from_scale(extent.max - extent.min);
    TransformStep::composed_matrix(&extent.steps) * DAffine3 { translation: extent.min, ..fit }
}

/// Returns the number of grid cells along each axis of a box, with `resolution` along its longest
/// side.
///
/// Cells are nearly cubic before the box is transformed. Each axis has at least 2 cells.
fn grid_size(extent: &TransformedBoxDescription, resolution: u32) -> [u32; 3] {
    let sides = extent.max - extent.min;
    let count = |side: f64| (f64::from(resolution) * (side / sides.max_element())).ceil().max(2.0) as u32;
    DVec3::to_array(&sides).map(count)
}
