//! Converts participating media of Mitsuba scenes: homogeneous media, and heterogeneous ones with a
//! density grid.

use super::color::ColorMeaning;
use super::context::ImportContext;
use super::files::ReadResult;
use super::tree::{MitsubaObject, ObjectClass};
use super::volume::{self, VolumeGrid};
use crate::format::description::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, Span, Spanned, TransformStep,
    TransformedBoxDescription,
};
use crate::format::grid::DensityGridData;
use crate::format::import::SceneReadError;
use glam::{DMat4, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

/// Greatest magnitude of the mean cosine g of a phase function; larger magnitudes are clamped to
/// it. A phase function with |g| = 1 would be a delta function.
const MAX_MEAN_COSINE: f64 = 0.999;

/// A Mitsuba volume: a constant or a grid, and its transform to world space.
enum VolumeValues {
    /// A constant value, and the transform from the unit cube \[0, 1]³ to world space.
    Constant(DVec3, DMat4),
    /// A grid of values, and the transform to world space from the unit cube \[0, 1]³ that the grid
    /// fills.
    Grid(VolumeGrid, DMat4),
}

/// Media and density grids of the imported scene so far.
#[derive(Default)]
pub(super) struct MitsubaMedia {
    /// Media of the imported scene.
    pub descriptions: Vec<Spanned<MediumDescription>>,
    /// Embedded density grids, by path.
    pub grids: BTreeMap<String, Arc<DensityGridData>>,
    /// Names of converted media, by the address of the [`MitsubaObject`].
    names: HashMap<*const MitsubaObject, String>,
}

impl MitsubaMedia {
    /// Returns the name of a medium in the imported scene. The first call for a medium converts it.
    pub fn medium_name(
        &mut self,
        context: &ImportContext<'_>,
        medium: &Rc<MitsubaObject>,
    ) -> ReadResult<Spanned<String>> {
        let key = Rc::as_ptr(medium);
        if let Some(name) = self.names.get(&key) {
            return Ok(Spanned::new(name.clone(), Span::default()));
        }
        let name = format!("medium{}", self.descriptions.len());
        let description = self.convert_medium(context, medium, &name)?;
        self.descriptions.push(Spanned::new(description, Span::default()));
        self.names.insert(key, name.clone());
        Ok(Spanned::new(name, Span::default()))
    }

    fn convert_medium(
        &mut self,
        context: &ImportContext<'_>,
        medium: &MitsubaObject,
        name: &str,
    ) -> ReadResult<MediumDescription> {
        let phase = read_phase_function(context, medium)?;
        let scale = medium.number("scale").unwrap_or(1.0);
        if !(0.0..=1e12).contains(&scale) {
            return Err(medium.place.error("the scale of the medium is negative or too large", "correct `scale`"));
        }
        let (coefficients, density) = match medium.plugin.as_str() {
            "homogeneous" => (self.homogeneous_coefficients(context, medium, scale)?, DensityDescription::Homogeneous),
            "heterogeneous" => self.heterogeneous_medium(context, medium, (name, scale))?,
            other => {
                let help = "use a `homogeneous` or `heterogeneous` medium";
                return Err(medium.place.error(format!("media of kind `{other}` are not supported"), help));
            }
        };
        let emission = context.linear_rgb(medium, "emission", ColorMeaning::Emission, 0.0)?;
        Ok(MediumDescription { name: name.to_owned(), coefficients, emission, phase, density })
    }

    /// Returns the coefficients of a homogeneous medium: absorption and scattering, or extinction
    /// and albedo. All but the albedo are multiplied by `scale`.
    fn homogeneous_coefficients(
        &self,
        context: &ImportContext<'_>,
        medium: &MitsubaObject,
        scale: f64,
    ) -> ReadResult<MediumCoefficients> {
        if let Some(material) = medium.text("material") {
            let message = format!("the material `{material}` of a medium is not known");
            return Err(medium.place.error(message, "write its coefficients: `sigma_t` and `albedo`"));
        }
        let values = |name: &str| -> ReadResult<Option<DVec3>> {
            if let Some(volume) = context.named_child(medium, ObjectClass::Volume, name)? {
                return match read_volume(context, &volume)? {
                    VolumeValues::Constant(color, _) => Ok(Some(color)),
                    VolumeValues::Grid(..) => {
                        let message = format!("`{name}` of a homogeneous medium varies");
                        Err(volume.place.error(message, "use a `heterogeneous` medium"))
                    }
                };
            }
            let is_given = context.color_value(medium, name)?.is_some();
            Ok(if is_given { Some(context.linear_rgb(medium, name, ColorMeaning::Unbounded, 0.0)?) } else { None })
        };
        if let (Some(absorption), Some(scattering)) = (values("sigma_a")?, values("sigma_s")?) {
            let (absorption, scattering) = (absorption * scale, scattering * scale);
            return Ok(MediumCoefficients::AbsorptionScattering { absorption, scattering });
        }
        let extinction = values("sigma_t")?.unwrap_or(DVec3::ONE) * scale;
        let albedo = values("albedo")?.unwrap_or(DVec3::splat(0.75)).min(DVec3::ONE);
        Ok(MediumCoefficients::ExtinctionAlbedo { extinction, albedo })
    }

    /// Returns the coefficients and the density grid of a heterogeneous medium. Embeds the grid
    /// under the path `name`.
    ///
    /// Only the density varies over the grid. A varying color or albedo becomes its mean, and a
    /// message tells the user.
    fn heterogeneous_medium(
        &mut self,
        context: &ImportContext<'_>,
        medium: &MitsubaObject,
        (name, scale): (&str, f64),
    ) -> ReadResult<(MediumCoefficients, DensityDescription)> {
        let values = |names: [&str; 2], default: f64| -> ReadResult<VolumeValues> {
            for name in names {
                if let Some(volume) = context.named_child(medium, ObjectClass::Volume, name)? {
                    return read_volume(context, &volume);
                }
                if context.color_value(medium, name)?.is_some() {
                    let color = context.linear_rgb(medium, name, ColorMeaning::Unbounded, 0.0)?;
                    return Ok(VolumeValues::Constant(color, DMat4::IDENTITY));
                }
            }
            Ok(VolumeValues::Constant(DVec3::splat(default), DMat4::IDENTITY))
        };
        // Before version 2, the extinction is called `density`.
        let extinction = values(["sigma_t", "density"], 1.0)?;
        let albedo = values(["albedo", "albedo"], 0.75)?;
        let (grid, to_world) = match extinction {
            // In Mitsuba, a medium of constant extinction fills only the unit cube of its volume.
            VolumeValues::Constant(extinction, to_world) => {
                let values = extinction.as_vec3().to_array().to_vec();
                (VolumeGrid { size: [1; 3], channel_count: 3, bounds: [[0.0; 3], [1.0; 3]], values }, to_world)
            }
            VolumeValues::Grid(grid, to_world) => (grid, to_world),
        };
        let is_one_cell = grid.size == [1; 3];
        let mean = weighted_mean(&grid, |_| 1.0);
        let gray = mean.element_sum() / 3.0;
        let color = if gray > 0.0 { mean / gray } else { DVec3::ONE };
        if grid.channel_count == 3 && !is_one_cell {
            context.add_note("a color of extinction that varies in space becomes its mean", medium);
        }
        let cells = grid.values.chunks(grid.channel_count);
        let densities: Vec<f32> = cells.map(|cell| cell.iter().sum::<f32>() / cell.len() as f32).collect();
        let albedo = match albedo {
            VolumeValues::Constant(albedo, _) => albedo,
            VolumeValues::Grid(albedos, albedo_to_world) => {
                context.add_note("an albedo that varies in space becomes its mean", medium);
                let is_aligned = albedos.size == grid.size && albedo_to_world == to_world;
                weighted_mean(&albedos, |cell| if is_aligned { f64::from(densities[cell]) } else { 1.0 })
            }
        };
        let steps = vec![TransformStep::Matrix(to_world)];
        let extent = TransformedBoxDescription { min: DVec3::ZERO, max: DVec3::ONE, steps };
        self.grids.insert(name.to_owned(), Arc::new(DensityGridData { cell_counts: grid.size, densities }));
        let path = Spanned::new(name.to_owned(), Span::default());
        let coefficients =
            MediumCoefficients::ExtinctionAlbedo { extinction: color * scale, albedo: albedo.min(DVec3::ONE) };
        Ok((coefficients, DensityDescription::Grid { path, scale: 1.0, extent }))
    }
}

/// Returns the weighted mean color of a grid. `weight` returns the weight of a cell from its index.
///
/// If all weights are 0, returns the unweighted mean.
fn weighted_mean(grid: &VolumeGrid, weight: impl Fn(usize) -> f64) -> DVec3 {
    let (mut sum, mut total, mut plain) = (DVec3::ZERO, 0.0, DVec3::ZERO);
    for (i, cell) in grid.values.chunks(grid.channel_count).enumerate() {
        let channel = |k: usize| f64::from(cell[k % cell.len()]);
        let color = DVec3::new(channel(0), channel(1), channel(2));
        plain += color;
        sum += color * weight(i);
        total += weight(i);
    }
    if total > 0.0 { sum / total } else { plain / (grid.values.len() / grid.channel_count).max(1) as f64 }
}

/// Reads a `constvolume` or `gridvolume`. Fails for any other kind of volume.
fn read_volume(context: &ImportContext<'_>, volume: &MitsubaObject) -> ReadResult<VolumeValues> {
    match volume.plugin.as_str() {
        "constvolume" => {
            let color = context.linear_rgb(volume, "value", ColorMeaning::Unbounded, 1.0)?;
            let to_world = volume.transform("to_world").unwrap_or(DMat4::IDENTITY);
            if to_world.determinant() == 0.0 || !to_world.is_finite() {
                return Err(singular_transform_error(volume));
            }
            Ok(VolumeValues::Constant(color, to_world))
        }
        "gridvolume" => {
            let Some(name) = volume.text("filename") else {
                return Err(volume.place.error("this volume has no file", "give it a `filename`"));
            };
            let file = context.files.find_file(name, &volume.place)?;
            let bytes = context.files.read_file(&file)?;
            context.files.check_memory(&file, 4 * bytes.len() as u64)?;
            let damaged = |defect| volume.place.error(format!("`{name}`: {defect}"), "export the volume again");
            let grid = volume::decode(&bytes).map_err(damaged)?;
            let mut to_world = volume.transform("to_world").unwrap_or(DMat4::IDENTITY);
            to_world *= grid_to_volume(context, volume, &grid);
            if volume.text("filter_type") == Some("nearest") {
                context.add_note("volumes are interpolated instead of showing cells", volume);
            }
            if to_world.determinant() == 0.0 || !to_world.is_finite() {
                return Err(singular_transform_error(volume));
            }
            Ok(VolumeValues::Grid(grid, to_world))
        }
        other => {
            let message = format!("volumes of kind `{other}` are not supported");
            Err(volume.place.error(message, "use a `gridvolume` or `constvolume`"))
        }
    }
}

/// Returns the transform from the unit cube to the volume's own space. The unit cube stands for the
/// box that the cells of a `gridvolume` fill.
///
/// In old files (version 0, or with the value `send_data` or `min`), the box of the grid file joins
/// the centers of the outermost cells. The cells then reach half a cell beyond that box, and a
/// message tells the user. In later files, the cells fill the unit cube, or the box of the grid
/// file if `use_grid_bbox` is true.
fn grid_to_volume(context: &ImportContext<'_>, volume: &MitsubaObject, grid: &VolumeGrid) -> DMat4 {
    let is_old = context.tree.has_version_zero || ["send_data", "min"].iter().any(|k| volume.values.contains_key(*k));
    if !volume.boolean("use_grid_bbox", is_old) {
        return DMat4::IDENTITY;
    }
    let [low, high] = grid.bounds.map(|corner| DVec3::from(corner.map(f64::from)));
    let mut margin = DVec3::ZERO;
    if is_old {
        context.add_note("grids of volumes reach half a cell beyond their box", volume);
        for axis in (0..3).filter(|axis| grid.size[*axis] > 1) {
            margin[axis] = 0.5 * (high[axis] - low[axis]) / f64::from(grid.size[axis] - 1);
        }
    }
    DMat4::from_translation(low - margin) * DMat4::from_scale(high - low + 2.0 * margin)
}

fn singular_transform_error(volume: &MitsubaObject) -> SceneReadError {
    volume.place.error("the transform of the volume is singular", "scale it less")
}

/// Reads the phase function of a medium. A phase function of unknown kind becomes isotropic, and a
/// message tells the user.
fn read_phase_function(context: &ImportContext<'_>, medium: &MitsubaObject) -> ReadResult<PhaseFunctionDescription> {
    let Some(phase) = context.named_or_unnamed_child(medium, ObjectClass::PhaseFunction, "phase")? else {
        return Ok(PhaseFunctionDescription::Isotropic);
    };
    Ok(match phase.plugin.as_str() {
        "isotropic" => PhaseFunctionDescription::Isotropic,
        "rayleigh" => PhaseFunctionDescription::Rayleigh,
        "hg" => {
            let g = phase.number("g").unwrap_or(0.8).clamp(-MAX_MEAN_COSINE, MAX_MEAN_COSINE);
            PhaseFunctionDescription::HenyeyGreenstein(g)
        }
        other => {
            context.add_whole_object_note(&format!("phase functions of kind `{other}` become isotropic"), &phase);
            PhaseFunctionDescription::Isotropic
        }
    })
}
