//! Density of a medium by position: constant, from a grid file, or a procedural cloud.

use super::extent::{TransformedBoxDescription, grid_size, parse_medium_box, unit_cube_to_world, write_medium_box};
use crate::format::error::SceneError;
use crate::format::grid;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldRange, FieldSchema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::span::{Span, Spanned};
use crate::medium::{Cloud, GridDensity};
use crate::stats::format_bytes;
use std::fmt;

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

/// Greatest allowed density of a grid, after multiplication by the grid's `scale`.
///
/// Densities up to this value can be multiplied by coefficients and lengths without overflow in
/// single precision.
const MAX_DENSITY: f64 = 1e12;

/// Fields of a `Medium` block for the densities of a grid.
pub(super) const GRID_FIELDS: &[FieldSchema] = &[
    field_schema("grid", FieldKind::Name, "file of densities").make_optional("none: density 1 everywhere"),
    field_schema("densityScale", FieldKind::Number, "with `grid`: factor of its densities")
        .with_range(FieldRange::Positive)
        .with_default_numbers(&[1.0]),
];

/// Fields of a `Cloud` block for its noise.
pub(super) const CLOUD_FIELDS: &[FieldSchema] = &[
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
];

/// Parses the density of a `Medium`: a grid, or 1 everywhere.
pub(super) fn parse_medium_density(f: &BlockFields<'_>) -> Result<DensityDescription, SceneError> {
    let Some(path) = f.optional_value("grid") else {
        f.forbid_fields(&["min", "max", "Transform", "densityScale"], "has no effect without `grid`")?;
        return Ok(DensityDescription::Homogeneous);
    };
    Ok(DensityDescription::Grid { path, scale: f.value_or_default("densityScale")?, extent: parse_medium_box(f)? })
}

/// Parses the density of a `Cloud`.
pub(super) fn parse_cloud_density(f: &BlockFields<'_>) -> Result<DensityDescription, SceneError> {
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

/// Writes the fields of the density; nothing for the constant density 1.
pub(super) fn write_density(out: &mut SceneWriter<'_, '_>, density: &DensityDescription) -> fmt::Result {
    match density {
        DensityDescription::Homogeneous => Ok(()),
        DensityDescription::Grid { path, scale, extent } => {
            out.write_name_field("grid", path)?;
            out.write_number("densityScale", *scale)?;
            write_medium_box(out, extent)
        }
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
            out.write_number("cover", *cover)?;
            out.write_number("softness", *softness)?;
            out.write_field("octaves", octaves)?;
            out.write_number("frequency", *frequency)?;
            out.write_field("seed", seed)?;
            out.write_field("resolution", resolution)?;
            write_medium_box(out, extent)
        }
    }
}

/// Returns the density grid of the medium at `span`: scaled values of a grid file or embedded grid,
/// or samples of a cloud.
///
/// `None` for a homogeneous medium.
pub(super) fn make_density_grid(
    r: &Resolver<'_>,
    span: Span,
    density: &DensityDescription,
) -> Result<Option<GridDensity>, SceneError> {
    let made = match density {
        DensityDescription::Homogeneous => return Ok(None),
        DensityDescription::Grid { path, scale, extent } => {
            let grid = read_scaled_grid(r, path, *scale)?;
            GridDensity::new(grid.cell_counts, grid.densities, unit_cube_to_world(extent))
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
                return Err(r.error_at(span, &message, help).marked_out_of_memory());
            }
            let density_at = cloud.density_function(1.0 / f64::from(*resolution));
            GridDensity::from_fn(size, unit_cube_to_world(extent), density_at)
        }
    };
    let help = "give a box with an extent, and fewer cells if memory does not suffice";
    made.map(Some).map_err(|e| r.error_at(span, &e.to_string(), help))
}

/// Returns the grid of the file or embedded grid `path`, its densities multiplied by `scale`.
fn read_scaled_grid(r: &Resolver<'_>, path: &Spanned<String>, scale: f64) -> Result<grid::DensityGridData, SceneError> {
    let file = r.find_file("grid", path)?;
    let help = "repair the grid or name another; the grid format is described in docs/guide/scene-language.md";
    let mut grid = match r.assets.grids.get(path.as_str()) {
        Some(grid) => (**grid).clone(),
        None => grid::read_with_memory_limit(&file, r.memory.available_bytes())
            .map_err(|e| r.file_or_memory_error(path, &e, matches!(e, grid::GridError::OutOfMemory { .. }), help))?,
    };
    for value in &mut grid.densities {
        let scaled = f64::from(*value) * scale;
        if scaled > MAX_DENSITY {
            let message = format!("the grid `{}` is as dense as {value}, times {scale}", path.value);
            return Err(r.file_error(path, &message, "choose a `densityScale` by which it is below 1e12"));
        }
        *value = scaled as f32;
    }
    Ok(grid)
}
