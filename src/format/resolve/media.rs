//! Adds media to the scene and fills bodies with them.

use super::{Resolver, rgb};
use crate::color::Rgb;
use crate::format::description::{
    self, DensityDescription, LightDescription, MaterialDescription, MediumCoefficients, MediumDescription, Span,
    Spanned, TransformStep, TransformedBoxDescription,
};
use crate::format::{SceneError, grid};
use crate::medium::{Cloud, GridDensity, GridDensityError, Medium, PhaseFunction};
use crate::scene;
use crate::stats::format_bytes;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// Greatest allowed density. Its products with coefficients and lengths fit into single precision.
const MAX_DENSITY: f64 = 1e12;

/// Adds all media of the description.
pub(super) fn add_media(r: &mut Resolver<'_>) -> Result<(), SceneError> {
    for described in &r.description.media {
        let medium = make_medium(r, described)?;
        let index = r.builder.add_medium(medium.clone());
        r.media.insert(&described.name, (index, medium));
    }
    Ok(())
}

/// Converts a described medium to one of the renderer. Reads its grid file or samples its cloud.
fn make_medium(r: &Resolver<'_>, described: &Spanned<MediumDescription>) -> Result<Medium, SceneError> {
    let (absorption, scattering) = match described.coefficients {
        MediumCoefficients::AbsorptionScattering { absorption, scattering } => (absorption, scattering),
        MediumCoefficients::ExtinctionAlbedo { extinction, albedo } => {
            (extinction * (1.0 - albedo), extinction * albedo)
        }
    };
    let phase = match described.phase {
        description::PhaseFunctionDescription::Isotropic => PhaseFunction::Isotropic,
        description::PhaseFunctionDescription::Rayleigh => PhaseFunction::Rayleigh,
        description::PhaseFunctionDescription::HenyeyGreenstein(g) => PhaseFunction::HenyeyGreenstein(g as f32),
    };
    let (absorption, scattering, emission) = (rgb(absorption), rgb(scattering), rgb(described.emission));
    Ok(match make_density_grid(r, described)? {
        None => Medium::homogeneous(absorption, scattering, emission, phase),
        Some(density) => Medium::heterogeneous(absorption, scattering, emission, phase, Arc::new(density)),
    })
}

/// Returns the density grid of a medium, read from a file or sampled from a cloud.
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
                    r.file_or_memory_error(path, &e, matches!(e, grid::GridError::NoMemory { .. }), help)
                })?,
            };
            for value in &mut grid.values {
                let scaled = f64::from(*value) * scale;
                if scaled > MAX_DENSITY {
                    let message = format!("the grid `{}` is as dense as {value}, times {scale}", path.value);
                    return Err(r.file_error(path, &message, "choose a `densityScale` by which it is below 1e12"));
                }
                *value = scaled as f32;
            }
            GridDensity::new(grid.size, grid.values, unit_cube_to_world(extent)).map_err(refuse)?
        }
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
            let cloud = Cloud {
                octaves: *octaves,
                scale: *frequency,
                cover: *cover,
                softness: *softness,
                seed: u64::from(*seed),
            };
            let size = grid_size(extent, *resolution);
            let needed = grid::BYTES_PER_CELL * size.iter().map(|n| u64::from(*n)).product::<u64>();
            if let Some(free) = r.memory.available_bytes().filter(|free| needed > *free) {
                let message =
                    format!("the cloud takes {} of memory, and {} are free", format_bytes(needed), format_bytes(free));
                let help = "choose a smaller `resolution`, or let the scene have more memory (--memory)";
                return Err(r.error_at(described.span, &message, help).marked_out_of_memory());
            }
            let density_at = cloud.density(1.0 / f64::from(*resolution));
            GridDensity::from_fn(size, unit_cube_to_world(extent), density_at).map_err(refuse)?
        }
    };
    Ok(Some(density))
}

/// Returns the light inside all [`LightDescription::Moving`] that wrap it.
fn still_light_inside_motions(mut light: &Spanned<LightDescription>) -> &Spanned<LightDescription> {
    while let LightDescription::Moving { light: inner, .. } = &light.value {
        light = inner;
    }
    light
}

/// Sets the medium outside all bodies, if the description names one.
///
/// # Errors
/// If the medium varies in space, or emits in a channel in which it neither absorbs nor scatters.
/// Also if it absorbs or scatters, and the scene has a light at infinity.
pub(super) fn add_ambient_medium(r: &mut Resolver<'_>) -> Result<(), SceneError> {
    let Some(name) = &r.description.ambient_medium else { return Ok(()) };
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
        && let Some(light) = r.description.lights.iter().find(|light| light.is_infinite())
    {
        let message =
            format!("the medium `{}` fills the scene and absorbs or scatters all light from infinity", name.value);
        let help = "leave the light out, or put the medium into a shape of a material `Clear { medium … }`";
        return Err(r.error_at(still_light_inside_motions(light).span, &message, help));
    }
    r.builder.set_ambient_medium(index);
    Ok(())
}

/// Returns `material` with its body filled by the medium that `described` names.
///
/// Returns it unchanged if it bounds no body or no medium is named. If the body itself absorbs,
/// adds a copy of the medium to the scene that includes this absorption.
pub(super) fn with_body_medium(
    r: &mut Resolver<'_>,
    material: scene::Material,
    described: &MaterialDescription,
) -> Result<scene::Material, SceneError> {
    let (Some(name), Some(body)) = (&described.medium, material.bounded_body()) else { return Ok(material) };
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

/// Fails if the current material is a null interface and `radiance` is above 0.
pub(super) fn refuse_null_interface_emission(r: &Resolver<'_>, radiance: Rgb, span: Span) -> Result<(), SceneError> {
    let material = r.description.materials.get(r.material as usize);
    if radiance == Rgb::ZERO || !material.is_some_and(|m| m.kind.is_null_interface()) {
        return Ok(());
    }
    let help = "give `emission` to its medium, or the object another material";
    Err(r.error_at(span, "what is `Clear` has no surface that could emit light", help))
}

/// Returns the index and a copy of the medium called `name`; an error if there is none.
fn medium_by_name(r: &Resolver<'_>, name: &Spanned<String>) -> Result<(u32, Medium), SceneError> {
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
/// Cells are nearly cubic. Each axis has at least 2.
fn grid_size(extent: &TransformedBoxDescription, resolution: u32) -> [u32; 3] {
    let sides = extent.max - extent.min;
    let count = |side: f64| (f64::from(resolution) * (side / sides.max_element())).ceil().max(2.0) as u32;
    DVec3::to_array(&sides).map(count)
}
