//! Converts Mitsuba emitters to lights, except area lights, which are emission of shapes.

use super::color::ColorMeaning;
use super::context::ImportContext;
use super::environment::read_environment;
use super::files::ReadResult;
use super::sensor::tan_half_vertical_fov;
use super::textures::MitsubaTextures;
use super::tree::{MitsubaObject, ObjectClass};
use crate::color::Rgb;
use crate::format::description::{
    DirectionOrTarget, DirectionalLightDescription, DirectionalLightStrength, EnvironmentRadiance,
    GoniometricLightDescription, IntensityDistribution, LightDescription, LightPose, PointLightDescription,
    PointLightStrength, ProjectorLightDescription, Span, Spanned,
};
use crate::image::Image;
use glam::{DMat4, DVec3, Vec3};
use std::f64::consts::PI;

/// Number of rows of a spotlight's intensity map: 8 per degree, over 180 degrees from the axis.
const SPOT_MAP_ROWS: u32 = 1_440;

/// Width and height of the picture into which a textured spotlight is converted \[pixels].
const SPOT_PICTURE_SIZE: u32 = 512;

/// Greatest half angle of the cone of a textured spotlight \[degrees].
///
/// The light becomes a projector. Its flat picture cannot reach 90 degrees from the axis.
const MAX_TEXTURED_CUTOFF_DEGREES: f64 = 85.0;

/// Converts an emitter to a light. Returns `None` for a light of strength 0, and for an area light,
/// which becomes emission of its shape.
///
/// Also returns `None` for an emitter of unknown kind, and a message tells the user.
///
/// # Errors
/// If a value or file is not valid, or if the emitter is a daylight model.
pub(super) fn read_light(
    context: &ImportContext<'_>,
    textures: &mut MitsubaTextures,
    emitter: &MitsubaObject,
) -> ReadResult<Option<LightDescription>> {
    let to_world = emitter.transform("to_world").unwrap_or(DMat4::IDENTITY);
    let position = emitter.vector("position").unwrap_or(to_world.w_axis.truncate());
    let axis = |column: DVec3| column.try_normalize().ok_or_else(|| singular_transform_error(emitter));
    let color = |name: &str| context.linear_rgb(emitter, name, ColorMeaning::Emission, 1.0);
    let light = match emitter.plugin.as_str() {
        "point" => {
            let strength = scaled_strength(emitter, color("intensity")?);
            let light = PointLightDescription { position, strength: PointLightStrength::Intensity(strength) };
            unless_black(strength, light)
        }
        "spot" => read_spot(context, textures, emitter, to_world)?,
        "projector" => read_projector(context, textures, emitter, to_world)?,
        "directional" => {
            let direction = match emitter.vector("direction") {
                Some(direction) => axis(to_world.transform_vector3(direction))?,
                None => axis(to_world.z_axis.truncate())?,
            };
            let irradiance = scaled_strength(emitter, color("irradiance")?);
            let strength = DirectionalLightStrength::Irradiance(irradiance);
            unless_black(irradiance, DirectionalLightDescription { direction, strength })
        }
        "constant" => {
            let radiance = scaled_strength(emitter, color("radiance")?);
            unless_black(radiance, EnvironmentRadiance::Constant(radiance))
        }
        "envmap" => Some(read_environment(context, textures, emitter, to_world)?.into()),
        "sky" | "sun" | "sunsky" => {
            let message = format!("the daylight model `{}` is not supported", emitter.plugin);
            return Err(emitter.place.error(message, "render the sky as a picture, and use it as an `envmap`"));
        }
        // An area light is the emission of its shape.
        "area" | "directionalarea" => return Ok(None),
        other => {
            context.add_whole_object_note(&format!("emitters of kind `{other}` are left out"), emitter);
            return Ok(None);
        }
    };
    Ok(light)
}

/// Returns `strength` times the emitter's parameter `scale`, which is 1 by default.
///
/// A negative `scale` counts as 0. Only scenes before version 2 of the format have `scale`.
fn scaled_strength(emitter: &MitsubaObject, strength: DVec3) -> DVec3 {
    strength * emitter.number("scale").unwrap_or(1.0).max(0.0)
}

fn singular_transform_error(emitter: &MitsubaObject) -> crate::format::import::SceneReadError {
    emitter.place.error("the direction of this emitter is zero", "correct its transform")
}

/// Returns `light`; `None` if `strength`, the strength of the light, is 0 in all channels.
fn unless_black(strength: DVec3, light: impl Into<LightDescription>) -> Option<LightDescription> {
    (strength != DVec3::ZERO).then(|| light.into())
}

/// Converts a spotlight to a goniometric light or a projector; `None` if its intensity is 0.
///
/// Mitsuba's falloff is linear in the angle from the axis. A spotlight without a texture becomes a
/// goniometric light with the falloff as intensity map. A spotlight with a `bitmap` texture becomes
/// a projector, whose picture is texture times falloff.
fn read_spot(
    context: &ImportContext<'_>,
    textures: &mut MitsubaTextures,
    emitter: &MitsubaObject,
    to_world: DMat4,
) -> ReadResult<Option<LightDescription>> {
    let cutoff = emitter.number("cutoff_angle").unwrap_or(20.0);
    let beam = emitter.number("beam_width").unwrap_or(0.75 * cutoff);
    if !(cutoff > 0.0 && cutoff <= 180.0 && beam >= 0.0 && beam <= cutoff) {
        let help = "choose angles with 0 ≤ beam_width ≤ cutoff_angle ≤ 180";
        return Err(emitter.place.error("the angles of this spotlight are not valid", help));
    }
    let falloff = |degrees: f64| {
        if degrees <= beam { 1.0 } else { ((cutoff - degrees) / (cutoff - beam)).max(0.0) }
    };
    let intensity = scaled_strength(emitter, context.linear_rgb(emitter, "intensity", ColorMeaning::Emission, 1.0)?);
    let strength = PointLightStrength::Intensity(intensity);
    let position = to_world.w_axis.truncate();
    let [right, up, axis] = emitter_axes(emitter, to_world)?;
    let texture = context.named_child(emitter, ObjectClass::Texture, "texture")?;
    let embed_picture = |textures: &mut MitsubaTextures, width, height, pixels| {
        let image = Image::from_pixels(width, height, pixels);
        image
            .map(|image| textures.embed_picture(image))
            .map_err(|error| emitter.place.error(error, "use another texture"))
    };
    if let Some(texture) = texture.filter(|texture| texture.plugin == "bitmap") {
        if cutoff > MAX_TEXTURED_CUTOFF_DEGREES {
            let message = format!("a spotlight with a texture is wider than {MAX_TEXTURED_CUTOFF_DEGREES} degrees");
            return Err(emitter.place.error(message, "choose a smaller `cutoff_angle`"));
        }
        let (_, picture) = textures.decode_picture_file(context, &texture, texture.boolean("raw", false))?;
        let size = SPOT_PICTURE_SIZE;
        let tangent = libm::tan(cutoff.to_radians());
        let mut pixels = Vec::with_capacity((size * size) as usize);
        for row in 0..size {
            for column in 0..size {
                let centered = |i: u32| (f64::from(i) + 0.5) / f64::from(size) * 2.0 - 1.0;
                // The right side of the picture is −x of the emitter's frame, and its top is +y.
                let (x, y) = (-centered(column), -centered(row));
                let degrees = libm::atan(libm::hypot(x, y) * tangent).to_degrees();
                let value = interpolated_pixel(&picture, 0.5 + 0.5 * x, 0.5 + 0.5 * y);
                pixels.push(value * falloff(degrees) as f32);
            }
        }
        let path = Spanned::new(embed_picture(textures, size, size, pixels)?, Span::default());
        let pose = LightPose { position, aim: DirectionOrTarget::Direction(axis), up: Some(up) };
        let angle = 2.0 * cutoff;
        return Ok(unless_black(
            intensity,
            ProjectorLightDescription { pose, vertical_fov_degrees: angle, path, strength },
        ));
    }
    let angle = |row: u32| (f64::from(row) + 0.5) * 180.0 / f64::from(SPOT_MAP_ROWS);
    let pixels: Vec<Rgb> = (0..SPOT_MAP_ROWS).map(|row| Vec3::splat(falloff(angle(row)) as f32)).collect();
    let path = Spanned::new(embed_picture(textures, 1, SPOT_MAP_ROWS, pixels)?, Span::default());
    // The intensity map is symmetric about its up direction, which is the light's axis.
    let pose = LightPose { position, aim: DirectionOrTarget::Direction(right), up: Some(axis) };
    let distribution = IntensityDistribution::MapFile(path);
    Ok(unless_black(intensity, GoniometricLightDescription { pose, distribution, strength }))
}

/// Converts a projector; `None` if its `scale` is not above 0.
///
/// Pixels of Mitsuba's texture are the irradiance on a plane at distance 1, divided by π. Pixels of
/// the converted picture are intensities. Negative channels become 0, and pixels that are not
/// finite become black.
fn read_projector(
    context: &ImportContext<'_>,
    textures: &mut MitsubaTextures,
    emitter: &MitsubaObject,
    to_world: DMat4,
) -> ReadResult<Option<LightDescription>> {
    let [_, up, axis] = emitter_axes(emitter, to_world)?;
    let scale = emitter.number("scale").unwrap_or(1.0).max(0.0);
    let texture = context.named_child(emitter, ObjectClass::Texture, "irradiance")?;
    let image = match texture.filter(|texture| texture.plugin == "bitmap") {
        Some(texture) => (*textures.decode_picture_file(context, &texture, texture.boolean("raw", false))?.1).clone(),
        None => {
            let irradiance = context.linear_rgb(emitter, "irradiance", ColorMeaning::Emission, 1.0)?;
            let image = Image::from_pixels(1, 1, vec![irradiance.as_vec3()]);
            image.map_err(|error| emitter.place.error(error, "use a picture"))?
        }
    };
    let (width, height) = (image.width(), image.height());
    let size = [f64::from(width), f64::from(height)];
    let half = tan_half_vertical_fov(emitter, size)?;
    let mut image = image;
    for (i, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let (column, row) = (i as u32 % width, i as u32 / width);
        let x = ((f64::from(column) + 0.5) / size[0] * 2.0 - 1.0) * half * size[0] / size[1];
        let y = ((f64::from(row) + 0.5) / size[1] * 2.0 - 1.0) * half;
        // Irradiance is intensity times the cube of the cosine of the angle to the axis.
        let squared = 1.0 + x * x + y * y;
        let value = if pixel.is_finite() { pixel.max(Vec3::ZERO) } else { Vec3::ZERO };
        *pixel = value * (PI * squared * squared.sqrt()) as f32;
    }
    let path = Spanned::new(textures.embed_picture(image), Span::default());
    let angle = 2.0 * libm::atan(half).to_degrees();
    let intensity = DVec3::splat(scale);
    let strength = PointLightStrength::Intensity(intensity);
    let position = to_world.w_axis.truncate();
    let pose = LightPose { position, aim: DirectionOrTarget::Direction(axis), up: Some(up) };
    Ok(unless_black(intensity, ProjectorLightDescription { pose, vertical_fov_degrees: angle, path, strength }))
}

/// Returns the unit vectors right, up and forward of an emitter, in world space.
///
/// In the emitter's own frame, these directions are −x, +y and +z.
fn emitter_axes(emitter: &MitsubaObject, to_world: DMat4) -> ReadResult<[DVec3; 3]> {
    let axes = [-to_world.x_axis.truncate(), to_world.y_axis.truncate(), to_world.z_axis.truncate()];
    let [Some(right), Some(up), Some(forward)] = axes.map(DVec3::try_normalize) else {
        return Err(singular_transform_error(emitter));
    };
    if forward.cross(up).length() < 1e-6 {
        return Err(singular_transform_error(emitter));
    }
    Ok([right, up, forward])
}

/// Returns the value of a picture at (u, v) in \[0, 1]², with bilinear interpolation.
///
/// v = 0 is the top of the picture. The picture repeats beyond its edges. Negative channels of the
/// result become 0, and a result that is not finite becomes black.
fn interpolated_pixel(image: &Image, u: f64, v: f64) -> Rgb {
    let (width, height) = (f64::from(image.width()), f64::from(image.height()));
    let (x, y) = (u * width - 0.5, v * height - 0.5);
    let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let pixel_at = |x: f64, y: f64| {
        let (x, y) = (x.rem_euclid(width) as u32, y.rem_euclid(height) as u32);
        image.get(x.min(image.width() - 1), y.min(image.height() - 1)).unwrap_or_default()
    };
    let row = |y: f64| pixel_at(x.floor(), y) * (1.0 - fx) + pixel_at(x.floor() + 1.0, y) * fx;
    let value = row(y.floor()) * (1.0 - fy) + row(y.floor() + 1.0) * fy;
    if value.is_finite() { value.max(Vec3::ZERO) } else { Vec3::ZERO }
}
