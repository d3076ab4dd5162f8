//! Adds the media of a description to the scene, and the bodies that they fill.

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

/// Greatest density: its products with coefficients and lengths still fit single precision.
const DENSEST: f64 = 1e12;

pub(super) fn add_media(r: &mut Resolver<'_>) -> Result<(), SceneError> {
    for described in &r.description.media {
        let medium = make_medium(r, described)?;
        let index = r.builder.medium(medium.clone());
        r.media.insert(&described.name, (index, medium));
    }
    Ok(())
}

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
    Ok(match make_density(r, described)? {
        None => Medium::homogeneous(absorption, scattering, emission, phase),
        Some(field) => Medium::heterogeneous(absorption, scattering, emission, phase, Arc::new(field)),
    })
}

fn make_density(r: &Resolver<'_>, described: &Spanned<MediumDescription>) -> Result<Option<GridDensity>, SceneError> {
    let help = "give a box with an extent, and fewer cells if memory does not suffice";
    let refuse = |e: GridDensityError| r.refuse(described.span, &e.to_string(), help);
    let field = match &described.density {
        DensityDescription::Homogeneous => return Ok(None),
        DensityDescription::Grid { path, scale, extent } => {
            let file = r.file("grid", path)?;
            let help = "repair the grid or name another; the grid format is described in docs/guide/scene-language.md";
            let read = grid::read_with_memory_limit(&file, r.memory.available_bytes());
            let mut grid =
                read.map_err(|e| r.refuse_file(path, &e, matches!(e, grid::GridError::NoMemory { .. }), help))?;
            for value in &mut grid.values {
                let scaled = f64::from(*value) * scale;
                if scaled > DENSEST {
                    let message = format!("the grid `{}` is as dense as {value}, times {scale}", path.value);
                    return Err(r.bad_file(path, &message, "choose a `densityScale` by which it is below 1e12"));
                }
                *value = scaled as f32;
            }
            GridDensity::new(grid.size, grid.values, placement(extent)).map_err(refuse)?
        }
        DensityDescription::Cloud { cover, softness, octaves, frequency, seed, resolution, extent } => {
            let cloud = Cloud {
                octaves: *octaves,
                scale: *frequency,
                cover: *cover,
                softness: *softness,
                seed: u64::from(*seed),
            };
            let size = cells(extent, *resolution);
            let needed = grid::BYTES_PER_CELL * size.iter().map(|n| u64::from(*n)).product::<u64>();
            if let Some(free) = r.memory.available_bytes().filter(|free| needed > *free) {
                let message =
                    format!("the cloud takes {} of memory, and {} are free", format_bytes(needed), format_bytes(free));
                let help = "choose a smaller `resolution`, or let the scene have more memory (--memory)";
                return Err(r.refuse(described.span, &message, help).marked_out_of_memory());
            }
            let density = cloud.density(1.0 / f64::from(*resolution));
            GridDensity::from_fn(size, placement(extent), density).map_err(refuse)?
        }
    };
    Ok(Some(field))
}

/// The light that a motion carries, or `light` itself.
fn innermost(mut light: &Spanned<LightDescription>) -> &Spanned<LightDescription> {
    while let LightDescription::Moving { light: inner, .. } = &light.value {
        light = inner;
    }
    light
}

/// Adds the medium that fills the space outside all bodies.
pub(super) fn fill_background(r: &mut Resolver<'_>) -> Result<(), SceneError> {
    let Some(name) = &r.description.ambient_medium else { return Ok(()) };
    let (index, medium) = known_medium(r, name)?;
    let refuse = |what: &str, help: &str| {
        let message = format!("the medium `{}` cannot fill the scene: {what}", name.value);
        Err(SceneError::at(r.source, name.span, message, "fills the scene", help))
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
        return Err(r.refuse(innermost(light).span, &message, help));
    }
    r.builder.ambient_medium(index);
    Ok(())
}

/// `material` with the described medium in the body that it bounds, if it bounds one.
///
/// A body with an absorption of its own gets a copy of the medium with both absorptions.
pub(super) fn fill_body(
    r: &mut Resolver<'_>,
    material: scene::Material,
    described: &MaterialDescription,
) -> Result<scene::Material, SceneError> {
    let (Some(name), Some(body)) = (&described.medium, material.bounded_body()) else { return Ok(material) };
    let mut body = *body;
    let (mut index, mut medium) = known_medium(r, name)?;
    if body.absorption != Rgb::ZERO {
        if !medium.is_homogeneous() {
            let message = format!("the body absorbs, and so does the medium `{}`, which varies", name.value);
            let help = "leave out `absorption` and `tint`, or fill the body with a medium that is even";
            return Err(SceneError::at(r.source, name.span, message, "fills this body", help));
        }
        medium.absorption += std::mem::replace(&mut body.absorption, Rgb::ZERO);
        index = r.builder.medium(medium);
    }
    body.medium = Some(index);
    Ok(material.with_body(body))
}

/// Refuses emission of an object with a `Clear` material.
pub(super) fn check_clear(r: &Resolver<'_>, radiance: Rgb, span: Span) -> Result<(), SceneError> {
    let material = r.description.materials.get(r.material as usize);
    if radiance == Rgb::ZERO || !material.is_some_and(|m| m.kind.is_clear()) {
        return Ok(());
    }
    let help = "give `emission` to its medium, or the object another material";
    Err(r.refuse(span, "what is `Clear` has no surface that could emit light", help))
}

fn known_medium(r: &Resolver<'_>, name: &Spanned<String>) -> Result<(u32, Medium), SceneError> {
    r.media.get(name.as_str()).cloned().ok_or_else(|| {
        let message = format!("no medium is called `{}`", name.value);
        SceneError::at(r.source, name.span, message, "unknown name", "define it in Media first")
    })
}

/// Returns the map from the unit cube to the world.
fn placement(extent: &TransformedBoxDescription) -> DAffine3 {
    let fit = DAffine3::from_scale(extent.max - extent.min);
    TransformStep::composed_matrix(&extent.maps) * DAffine3 { translation: extent.min, ..fit }
}

/// Returns the grid size of nearly cubic cells, with `resolution` cells along the longest side.
fn cells(extent: &TransformedBoxDescription, resolution: u32) -> [u32; 3] {
    let sides = extent.max - extent.min;
    let count = |side: f64| (f64::from(resolution) * (side / sides.max_element())).ceil().max(2.0) as u32;
    DVec3::to_array(&sides).map(count)
}
