//! Converts participating media of pbrt scenes.

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::parameters::Parameters;
use super::spectra::{ColorMeaning, linear_rgb};
use crate::format::description::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, Span, Spanned, TransformStep,
    TransformedBoxDescription,
};
use crate::format::grid::DensityGridData;
use crate::format::import_notes::ImportNotes;
use glam::{DAffine3, DMat4, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Memory per cell of a density grid \[bytes]: 4 for the density, and the rest for the majorant
/// grid that the renderer builds.
const MEMORY_PER_CELL: u64 = 8;

/// Tolerance for colors that vary over the cells of a grid medium, relative to the density.
///
/// A message is added if a cell of density d has |σ − c · d| > tolerance · d for σ = σa or σs,
/// where c is the mean color: the sum of σ over all cells, divided by the sum of d. Emission is
/// tested likewise.
const MAX_RELATIVE_COLOR_DEVIATION: f64 = 1e-3;

/// Converted properties of a medium: scattering coefficients, emission and density.
struct MediumProperties {
    coefficients: MediumCoefficients,
    emission: DVec3,
    density: DensityDescription,
}

/// Embedded density grids, by the path to which media refer.
type GridFiles = BTreeMap<String, Arc<DensityGridData>>;

/// Media of the imported scene so far, with their density grids.
#[derive(Default)]
pub(super) struct PbrtMedia {
    /// Media of the imported scene. The boxes of their grids are still in pbrt's world space.
    descriptions: Vec<Spanned<MediumDescription>>,
    grids: GridFiles,
}

impl PbrtMedia {
    /// True if a medium called `name` has been added.
    pub fn contains(&self, name: &str) -> bool {
        self.descriptions.iter().any(|medium| medium.name == name)
    }

    /// Returns the media and their density grids.
    ///
    /// `map` goes from pbrt's world space to that of the imported scene. It is applied to the boxes
    /// of the grids.
    pub fn into_descriptions(mut self, map: DAffine3) -> (Vec<Spanned<MediumDescription>>, GridFiles) {
        for medium in &mut self.descriptions {
            if let DensityDescription::Grid { extent, .. } = &mut medium.value.density {
                // A matrix applies after all earlier steps.
                extent.steps.push(TransformStep::Matrix(DMat4::from(map)));
            }
        }
        (self.descriptions, self.grids)
    }

    /// Converts and adds the medium `name`. It replaces an earlier medium of this name.
    ///
    /// `to_world` maps the medium's own space to pbrt's world space. Media of unknown kinds are
    /// left out, and a message tells the user.
    pub fn add_medium(
        &mut self,
        name: &str,
        parameters: &Parameters,
        to_world: DAffine3,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<()> {
        let place = &parameters.place;
        let g = parameters.number_or("g", 0.0);
        if parameters.number_or("scale", 1.0) < 0.0 || !(g > -1.0 && g < 1.0) {
            return Err(place.error("the scale is negative, or g is not between -1 and 1", "correct the medium"));
        }
        let values = match parameters.text("type") {
            Some("homogeneous") | None => homogeneous_medium(parameters, files, notes)?,
            Some("uniformgrid" | "heterogeneous") => self.uniform_grid_medium(parameters, to_world, files, notes)?,
            Some("rgbgrid") => self.rgb_grid_medium(parameters, to_world, files, notes)?,
            Some("nanovdb") => {
                let help = "export the density as a `uniformgrid` medium";
                return Err(place.error(format!("the medium `{name}` is a NanoVDB file, which is not read"), help));
            }
            Some(kind) => {
                let message = format!("media of kind `{kind}` are left out: their shapes are empty");
                notes.add_unsupported(&message, format!("{}: `{name}`", place.position_text()));
                return Ok(());
            }
        };
        let phase = match g {
            0.0 => PhaseFunctionDescription::Isotropic,
            _ => PhaseFunctionDescription::HenyeyGreenstein(g),
        };
        let MediumProperties { coefficients, emission, density } = values;
        let description = MediumDescription { name: name.to_owned(), coefficients, emission, phase, density };
        files.reserve_memory(1_000)?;
        self.descriptions.retain(|medium| medium.name != name);
        self.descriptions.push(Spanned::new(description, Span::default()));
        Ok(())
    }

    /// Converts a grid medium with one density per cell, and embeds its grid.
    ///
    /// Emission that varies over cells becomes its density-weighted mean, and a message tells the
    /// user.
    fn uniform_grid_medium(
        &mut self,
        parameters: &Parameters,
        to_world: DAffine3,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<MediumProperties> {
        let place = &parameters.place;
        let size = grid_size(parameters)?;
        let densities = cell_values::<1>(parameters, "density", size)?;
        let densities =
            densities.ok_or_else(|| place.error("the medium has no `density`", "give one for each cell"))?;
        let is_v3 = parameters.text("type") == Some("heterogeneous");
        let [absorption, scattering] = absorption_and_scattering(parameters, !is_v3, files)?;
        if parameters.find("temperature").is_some() {
            notes.add_unsupported("emission by the temperature of media is left out", place.position_text());
        }
        // pbrt's media emit σa · Le per length.
        let mut emission = unscaled_emission(parameters, files)? * absorption;
        if emission != DVec3::ZERO
            && let Some(factors) = cell_values::<1>(parameters, "Lescale", size)?
        {
            notes.add_unsupported("emission of media that varies in space becomes its mean", place.position_text());
            let weight: f64 = densities.iter().map(|[density]| density).sum();
            let sum: f64 = densities.iter().zip(factors).map(|([density], [factor])| density * factor).sum();
            emission *= if weight > 0.0 { sum / weight } else { 0.0 };
        }
        let densities = densities.iter().map(|[density]| *density as f32).collect();
        let density = self.embed_grid((size, densities), parameters, to_world, files)?;
        let coefficients = MediumCoefficients::AbsorptionScattering { absorption, scattering };
        Ok(MediumProperties { coefficients, emission, density })
    }

    /// Converts a grid medium with RGB absorption and scattering per cell (`rgbgrid`).
    ///
    /// In Caustica, only the density varies over cells. The density of a cell is the channel mean
    /// of its extinction. Absorption, scattering and emission per density are equal in all cells:
    /// the sum over the cells, divided by the sum of densities. A message is added if cells deviate
    /// from these ratios.
    fn rgb_grid_medium(
        &mut self,
        parameters: &Parameters,
        to_world: DAffine3,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<MediumProperties> {
        let place = &parameters.place;
        let size = grid_size(parameters)?;
        let (absorption, scattering) =
            (cell_values(parameters, "sigma_a", size)?, cell_values(parameters, "sigma_s", size)?);
        let count = absorption.or(scattering).map(<[_]>::len);
        let count =
            count.ok_or_else(|| place.error("the medium has no coefficients", "give `sigma_a` or `sigma_s`"))?;
        let color_of = |values: Option<&[[f64; 3]]>, i: usize| values.map_or(DVec3::ONE, |v| DVec3::from_array(v[i]));
        let emitted = cell_values(parameters, "Le", size)?.filter(|_| absorption.is_some());
        let emission_of = |i: usize| emitted.map_or(DVec3::ZERO, |emitted| DVec3::from_array(emitted[i]));
        let mut densities = Vec::with_capacity(count);
        let (mut weight, mut sums) = (0.0, [DVec3::ZERO; 3]);
        for i in 0..count {
            let (a, s) = (color_of(absorption, i), color_of(scattering, i));
            let density = (a + s).element_sum() / 3.0;
            sums = [sums[0] + a, sums[1] + s, sums[2] + emission_of(i) * a];
            weight += density;
            densities.push(density as f32);
        }
        let [absorbed, scattered, light] = sums.map(|sum| if weight > 0.0 { sum / weight } else { DVec3::ZERO });
        let deviates = (0..count).any(|i| {
            let (a, s) = (color_of(absorption, i), color_of(scattering, i));
            let density = (a + s).element_sum() / 3.0;
            let deviation = (a - absorbed * density).abs().max((s - scattered * density).abs()).max_element();
            let light_deviation = (emission_of(i) * a - light * density).abs().max_element();
            deviation > MAX_RELATIVE_COLOR_DEVIATION * density
                || light_deviation > MAX_RELATIVE_COLOR_DEVIATION * density * light.max_element()
        });
        if deviates {
            notes.add_unsupported("colors of media that vary in space become their mean", place.position_text());
        }
        let scale = parameters.number_or("scale", 1.0);
        let density = self.embed_grid((size, densities), parameters, to_world, files)?;
        let coefficients =
            MediumCoefficients::AbsorptionScattering { absorption: absorbed * scale, scattering: scattered * scale };
        let emission = light * scale * parameters.number_or("Lescale", 1.0).max(0.0);
        Ok(MediumProperties { coefficients, emission, density })
    }

    /// Embeds a density grid that fills the medium's box, and returns a reference to it.
    fn embed_grid(
        &mut self,
        (size, values): ([u32; 3], Vec<f32>),
        parameters: &Parameters,
        to_world: DAffine3,
        files: &PbrtSceneFiles<'_>,
    ) -> ReadResult<DensityDescription> {
        let place = &parameters.place;
        let corner = |name: &str, default: DVec3| parameters.point(name).unwrap_or(default);
        let (min, max) = (corner("p0", DVec3::ZERO), corner("p1", DVec3::ONE));
        if !min.cmplt(max).all() {
            return Err(place.error("the box of the medium is empty", "give a `p1` above `p0` in every coordinate"));
        }
        files.reserve_memory(MEMORY_PER_CELL * values.len() as u64)?;
        let extent = TransformedBoxDescription { min, max, steps: vec![TransformStep::Matrix(DMat4::from(to_world))] };
        let path = format!("grid{}", self.grids.len());
        self.grids.insert(path.clone(), Arc::new(DensityGridData { cell_counts: size, densities: values }));
        Ok(DensityDescription::Grid { path: Spanned::new(path, Span::default()), scale: 1.0, extent })
    }
}

/// Converts a homogeneous medium.
fn homogeneous_medium(
    parameters: &Parameters,
    files: &PbrtSceneFiles<'_>,
    notes: &mut ImportNotes,
) -> ReadResult<MediumProperties> {
    if let Some(preset) = parameters.text("preset") {
        let message = format!("media by preset have pbrt's default coefficients, not those of `{preset}`");
        notes.add_unsupported(&message, parameters.place.position_text());
    }
    let [absorption, scattering] = absorption_and_scattering(parameters, false, files)?;
    // pbrt's media emit σa · Le per length.
    let emission = unscaled_emission(parameters, files)? * parameters.number_or("Lescale", 1.0).max(0.0) * absorption;
    let coefficients = MediumCoefficients::AbsorptionScattering { absorption, scattering };
    Ok(MediumProperties { coefficients, emission, density: DensityDescription::Homogeneous })
}

/// Returns σa and σs \[1/length], multiplied by the parameter `scale`.
///
/// A coefficient that is missing in the file is 1 if `defaults_to_one` is true. Else it is the
/// coefficient of whole milk per millimeter, as in pbrt-v3.
fn absorption_and_scattering(
    parameters: &Parameters,
    defaults_to_one: bool,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<[DVec3; 2]> {
    let place = &parameters.place;
    let scale = parameters.number_or("scale", 1.0);
    let value = |name: &str, milk: DVec3| -> ReadResult<DVec3> {
        let default = if defaults_to_one { DVec3::ONE } else { milk };
        let found = parameters.find(name).map(|parameter| linear_rgb(parameter, ColorMeaning::Unbounded, place, files));
        Ok(found.transpose()?.unwrap_or(default) * scale)
    };
    Ok([value("sigma_a", DVec3::new(0.0011, 0.0024, 0.014))?, value("sigma_s", DVec3::new(2.55, 3.21, 3.77))?])
}

/// Returns the parameter `Le` of a medium, not yet multiplied by `Lescale`; 0 if it is missing.
///
/// `Le` times σa is the emission: radiance per length \[W/(m³ sr)].
fn unscaled_emission(parameters: &Parameters, files: &PbrtSceneFiles<'_>) -> ReadResult<DVec3> {
    match parameters.find("Le") {
        Some(parameter) => linear_rgb(parameter, ColorMeaning::Emission { is_v3: false }, &parameters.place, files),
        None => Ok(DVec3::ZERO),
    }
}

/// Returns the number of cells of a grid medium along x, y and z: the parameters `nx`, `ny`, `nz`.
fn grid_size(parameters: &Parameters) -> ReadResult<[u32; 3]> {
    let size = ["nx", "ny", "nz"].map(|name| parameters.number_or(name, 1.0));
    if size.iter().all(|n| *n >= 1.0 && *n <= f64::from(u32::MAX) && n.fract() == 0.0) {
        return Ok(size.map(|n| n as u32));
    }
    Err(parameters.place.error("the numbers of cells are no whole numbers above 0", "correct `nx`, `ny` and `nz`"))
}

/// Returns the values of the parameter `name`, with `N` numbers for each cell of a grid; `None` if
/// the parameter is missing.
///
/// `size` is the number of cells along each axis. Fails if the parameter does not have `N` values
/// for each cell, or if a value is negative or too large.
fn cell_values<'p, const N: usize>(
    parameters: &'p Parameters,
    name: &str,
    size: [u32; 3],
) -> ReadResult<Option<&'p [[f64; N]]>> {
    let place: &PbrtSourceLocation = &parameters.place;
    let Some(parameter) = parameters.find(name) else { return Ok(None) };
    let (values, rest) = parameter.numbers.as_chunks::<N>();
    let count = size.iter().map(|n| u128::from(*n)).product::<u128>();
    if values.len() as u128 != count || !rest.is_empty() {
        let [x, y, z] = size;
        let message = format!("`{name}` has {} numbers for {x} × {y} × {z} cells", parameter.numbers.len());
        return Err(place.error(message, "give as many values as cells, with x running fastest"));
    }
    let is_valid = |value: &f64| *value >= 0.0 && *value <= f64::from(f32::MAX);
    if !values.as_flattened().iter().all(is_valid) {
        return Err(place.error(format!("a value of `{name}` is negative or too large"), "use values of at least 0"));
    }
    Ok(Some(values))
}

#[cfg(test)]
mod tests;
