//! Converts primitives of Tungsten that are lights without a surface: skies, suns and points.

use super::context::ImportContext;
use super::object::{ReadResult, TungstenObject};
use super::textures::{TungstenTextureUse, TungstenTextures};
use super::transforms::read_transform;
use crate::format::description::{
    DirectionalLightDescription, DirectionalLightStrength, EnvironmentRadiance, LightDescription,
    PointLightDescription, PointLightStrength, Span, Spanned,
};
use crate::format::imported_environment::place_environment_map;
use crate::format::imported_textures::ConvertedTexture;
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// Greatest radiance and intensity.
const MAX_RADIANCE: f64 = 1e30;

/// Lights of the imported scene so far.
#[derive(Default)]
pub(super) struct TungstenLights {
    /// Lights of the imported scene.
    pub descriptions: Vec<Spanned<LightDescription>>,
    /// True if a sky was converted, even a black one.
    has_sky: bool,
}

impl TungstenLights {
    /// Converts a primitive if it is a light without a surface. Returns false for all other
    /// primitives.
    ///
    /// Only the first sky is kept. Others are left out, and a message tells the user.
    pub fn add_light(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut TungstenTextures,
        object: &TungstenObject<'_>,
        outer: &DAffine3,
    ) -> ReadResult<bool> {
        let kind = object.kind()?;
        if !matches!(kind, "infinite_sphere" | "infinite_sphere_cap" | "skydome" | "point") {
            return Ok(false);
        }
        let to_world = *outer * read_transform(object)?;
        object.value("bsdf");
        let light = match kind {
            "point" => {
                let intensity = mean_emission(context, textures, object, 1.0 / (4.0 * PI))?;
                let (position, strength) = (to_world.translation, PointLightStrength::Intensity(intensity));
                (intensity != DVec3::ZERO)
                    .then_some(LightDescription::Point(PointLightDescription { position, strength }))
            }
            "infinite_sphere_cap" => sun(context, textures, object, to_world)?,
            sky => {
                if std::mem::replace(&mut self.has_sky, true) {
                    context.add_whole_object_note("skies after the first one are left out", object);
                    return Ok(true);
                }
                if sky == "skydome" {
                    context.add_whole_object_note("skydomes become a white sky of radiance 1", object);
                    Some(LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE)))
                } else {
                    environment(context, textures, object, to_world)?.map(LightDescription::Environment)
                }
            }
        };
        self.descriptions.extend(light.map(|light| Spanned::new(light, Span::default())));
        Ok(true)
    }
}

/// Emission of a primitive: constant radiance, or a texture; neither if the primitive emits
/// nothing.
#[derive(Default)]
pub(super) struct PrimitiveEmission {
    /// Constant radiance.
    pub radiance: Option<DVec3>,
    /// Name of the emission texture, and the factor from its values to radiance.
    pub texture: Option<(Spanned<String>, f64)>,
}

/// Reads the emission of a primitive: its `power` times `power_factor`, or else its `emission`.
pub(super) fn read_emission(
    context: &ImportContext<'_>,
    textures: &mut TungstenTextures,
    object: &TungstenObject<'_>,
    power_factor: f64,
) -> ReadResult<PrimitiveEmission> {
    let emission = object.value("emission").is_some();
    let (name, factor) = match object.value("power") {
        Some(_) => ("power", power_factor),
        None if emission => ("emission", 1.0),
        None => return Ok(PrimitiveEmission::default()),
    };
    if !factor.is_finite() {
        return Err(object.error("the `power` of a primitive without area is not finite", "scale the primitive"));
    }
    Ok(match textures.convert_member(context, object, (name, 0.0), TungstenTextureUse::NonNegative, 1.0)? {
        ConvertedTexture::Constant(color) => {
            let radiance = color * factor;
            if radiance.max_element() > MAX_RADIANCE {
                return Err(object.error(format!("`{name}` is too large"), "write smaller numbers"));
            }
            PrimitiveEmission { radiance: Some(radiance).filter(|radiance| *radiance != DVec3::ZERO), texture: None }
        }
        ConvertedTexture::Texture(name, _) => PrimitiveEmission { radiance: None, texture: Some((name, factor)) },
    })
}

/// Returns the emission of a light whose emission cannot vary. A texture becomes its mean, and a
/// message tells the user.
fn mean_emission(
    context: &ImportContext<'_>,
    textures: &mut TungstenTextures,
    object: &TungstenObject<'_>,
    power_factor: f64,
) -> ReadResult<DVec3> {
    let name = if object.value("power").is_some() { "power" } else { "emission" };
    let emission = textures.convert_member(context, object, (name, 0.0), TungstenTextureUse::NonNegative, 1.0)?;
    if let ConvertedTexture::Texture(..) = emission {
        context.add_note("textures of point lights and suns become their mean", object);
    }
    let mean = emission.mean() * if name == "power" { power_factor } else { 1.0 };
    if mean.max_element() <= MAX_RADIANCE {
        return Ok(mean);
    }
    Err(object.error(format!("`{name}` is too large"), "write smaller numbers"))
}

/// Converts an `infinite_sphere_cap`, a round part of the sky about the direction +y, to a
/// directional light of the same irradiance. Returns `None` if it is black.
fn sun(
    context: &ImportContext<'_>,
    textures: &mut TungstenTextures,
    object: &TungstenObject<'_>,
    to_world: DAffine3,
) -> ReadResult<Option<LightDescription>> {
    context.add_note("caps of the sky become directional lights: shadows are sharp", object);
    let mut to_world = to_world;
    if let Some(name) = object.text("skydome")?.filter(|name| !name.is_empty()) {
        match context.primitive(name) {
            Some(dome) => to_world = read_transform(dome)?,
            None => context.add_note("the `skydome` of a cap is no primitive: its own transform counts", object),
        }
    }
    let angle = object.number_in("cap_angle", 10.0, 1e-6..=90.0)?.to_radians();
    let power_factor = 1.0 / (TAU * (1.0 - libm::cos(angle)));
    let radiance = mean_emission(context, textures, object, power_factor)?;
    let sine = libm::sin(angle);
    let irradiance = radiance * PI * sine * sine;
    let Some(up) = to_world.matrix3.y_axis.try_normalize() else {
        return Err(object.error("the transform of the cap is singular", "scale it by numbers above 0"));
    };
    let strength = DirectionalLightStrength::Irradiance(irradiance);
    let light = LightDescription::Directional(DirectionalLightDescription { direction: -up, strength });
    Ok((irradiance != DVec3::ZERO).then_some(light))
}

/// Returns the radiance of an `infinite_sphere`, with its picture resampled if the transform is not
/// a rotation about y. Returns `None` if it is black.
fn environment(
    context: &ImportContext<'_>,
    textures: &mut TungstenTextures,
    object: &TungstenObject<'_>,
    to_world: DAffine3,
) -> ReadResult<Option<EnvironmentRadiance>> {
    let emission = read_emission(context, textures, object, 1.0 / (4.0 * PI))?;
    let Some((texture, scale)) = emission.texture else {
        return Ok(emission.radiance.map(EnvironmentRadiance::Constant));
    };
    let Some(picture) = textures.picture_of_texture(&texture.value) else {
        context.add_note("skies with other textures than pictures become their mean", object);
        let mean = mean_emission(context, textures, object, scale)?;
        return Ok((mean != DVec3::ZERO).then_some(EnvironmentRadiance::Constant(mean)));
    };
    let needed = 24 * picture.pixels().len() as u64;
    context.files.check_memory(context.files.path, needed)?;
    let axes = to_world.matrix3;
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::try_normalize);
    let singular = || object.error("the transform of the sky is singular", "scale it by numbers above 0");
    let [Some(x), Some(y), Some(z)] = axes else { return Err(singular()) };
    // Tungsten's pictures show −x at their left edge. The columns are the images of the axes of a
    // picture that shows −z there.
    let to_world = DMat3::from_cols(-z, y, x);
    let (image, rotate) = place_environment_map((*picture).clone(), to_world).ok_or_else(singular)?;
    let path = Spanned::new(textures.embed_picture(image), Span::default());
    Ok(Some(EnvironmentRadiance::Picture { path, scale, rotate }))
}
