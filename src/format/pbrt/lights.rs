//! Converts lights and media of pbrt scenes.

use super::content::SceneContent;
use super::environment::{MapLayout, equirectangular};
use super::files::{Place, ReadResult, SceneFiles};
use super::parameters::Parameters;
use super::spectra::{ColorUse, color};
use crate::format::description::{
    DirectionOrTarget, DirectionalLightStrength, EnvironmentRadiance, LightDescription, PointLightStrength, Span,
    Spanned,
};
use crate::format::import_notes::ImportNotes;
use crate::image::{Image, PixelMeaning};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::f64::consts::PI;

/// Rotation about y of an environment map with −z at its left edge \[degrees].
///
/// Caustica's maps without rotation show −z at their center.
const LEFT_EDGE_ROTATION: f64 = 180.0;

/// Lights of the imported scene so far. All infinite lights are merged into one.
#[derive(Default)]
pub(super) struct Lights {
    /// True if a shape emits light.
    pub has_emitters: bool,
    descriptions: Vec<Spanned<LightDescription>>,
    /// Sum of the radiances of all infinite lights without a picture \[W/(m² sr)].
    sky: DVec3,
    /// Environment map of the last infinite light with a picture, as an equirectangular map.
    map: Option<Image>,
}

impl Lights {
    /// Converts and adds a light. `kind` is its name in pbrt, and `to_world` maps its own space to
    /// world space.
    pub fn add(
        &mut self,
        kind: &str,
        parameters: &Parameters,
        to_world: DAffine3,
        content: &mut SceneContent,
        files: &SceneFiles<'_>,
    ) -> ReadResult<()> {
        let place = &parameters.place;
        let is_v3 = content.is_v3;
        let wanted = ColorUse::Light { is_v3 };
        let scale = light_scale(parameters, files)?;
        let color_of = |name: &str| -> ReadResult<DVec3> {
            match parameters.find(name) {
                Some(parameter) => Ok(color(parameter, wanted, place, files)? * scale),
                None => Ok(scale),
            }
        };
        let position =
            |name: &str, default: DVec3| to_world.transform_point3(parameters.point(name).unwrap_or(default));
        let degenerate = |message: &str| place.error(message, "give two different points `from` and `to`");
        // A parameter `power` replaces the intensity. Only the hue of the color is kept.
        let strength = |intensity: DVec3| match parameters.number("power") {
            Some(power) if power >= 0.0 => {
                let hue = intensity / luminance(intensity).max(f64::MIN_POSITIVE);
                PointLightStrength::Power(if hue.is_finite() { hue * power } else { DVec3::splat(power) })
            }
            _ => PointLightStrength::Intensity(intensity),
        };
        let description = match kind {
            "point" => {
                LightDescription::Point { position: position("from", DVec3::ZERO), strength: strength(color_of("I")?) }
            }
            "spot" => {
                let (from, to) = (position("from", DVec3::ZERO), position("to", DVec3::Z));
                if (to - from).try_normalize().is_none() {
                    return Err(degenerate("the spotlight has no direction"));
                }
                let cone = parameters.number_or("coneangle", 30.0);
                let rim = parameters.number_or("conedeltaangle", 5.0);
                if !(cone > 0.0 && cone <= 180.0) {
                    return Err(place.error("the cone's angle is not between 0° and 180°", "correct `coneangle`"));
                }
                LightDescription::Spot {
                    position: from,
                    aim: DirectionOrTarget::LookAt(to),
                    angle: 2.0 * cone,
                    penumbra: rim.clamp(0.0, cone),
                    strength: strength(color_of("I")?),
                }
            }
            "distant" => {
                let direction = position("to", DVec3::Z) - position("from", DVec3::ZERO);
                let direction = direction.try_normalize();
                let direction = direction.ok_or_else(|| degenerate("the distant light has no direction"))?;
                let mut irradiance = color_of("L")?;
                if let Some(illuminance) = parameters.number("illuminance").filter(|value| *value >= 0.0) {
                    irradiance *= illuminance / luminance(irradiance).max(1e-30);
                }
                let strength = DirectionalLightStrength::Irradiance(irradiance);
                LightDescription::Directional { direction, strength }
            }
            "infinite" | "exinfinite" => {
                return self.add_infinite(parameters, (to_world.matrix3, scale), color_of("L")?, content, files);
            }
            "goniometric" | "projection" => {
                let message = format!("lights of kind `{kind}` are left out");
                content.notes.add_unsupported(&message, place.described());
                return Ok(());
            }
            _ => {
                let message = format!("no light is called `{kind}`");
                return Err(place.error(message, "pbrt has the lights point, spot, distant and infinite"));
            }
        };
        files.count_memory(1000)?;
        self.descriptions.push(Spanned::new(description, Span::default()));
        Ok(())
    }

    fn add_infinite(
        &mut self,
        parameters: &Parameters,
        (axes, scale): (DMat3, DVec3),
        constant: DVec3,
        content: &mut SceneContent,
        files: &SceneFiles<'_>,
    ) -> ReadResult<()> {
        let place = &parameters.place;
        if parameters.find("portal").is_some() {
            content.notes.add_unsupported("portals of infinite lights are ignored", place.described());
        }
        let Some(parameter) = parameters.find_any(&["filename", "mapname"]) else {
            self.sky += match parameters.number("illuminance").filter(|value| *value >= 0.0) {
                Some(illuminance) => constant * (illuminance / (PI * luminance(constant).max(1e-30))),
                None => constant,
            };
            return Ok(());
        };
        if parameters.find("illuminance").is_some() {
            content.notes.add_unsupported("the illuminance of environment maps is ignored", place.described());
        }
        let name = parameter.texts.first().map(String::as_str).unwrap_or_default();
        let image = super::textures::read_picture(name, PixelMeaning::Radiance, place, files)?;
        let layout = match (image.width() == image.height(), &*parameter.name) {
            (true, "filename") => MapLayout::Octahedral,
            (true, _) | (false, "mapname") => MapLayout::LatitudeLongitude,
            (false, _) => {
                let message = "environment maps of pbrt-v4 that are not square are read by latitude and longitude";
                content.notes.add_unsupported(message, place.described());
                MapLayout::LatitudeLongitude
            }
        };
        files.count_memory(36 * image.pixels().len() as u64)?;
        let factor = if parameter.name == "mapname" { constant } else { scale };
        let map = equirectangular(&image, layout, axes);
        let mut map = map.ok_or_else(|| place.error("the transform of the light is singular", "scale it less"))?;
        for pixel in map.pixels_mut() {
            let value = *pixel * factor.as_vec3();
            *pixel = if value.is_finite() { value.max(Vec3::ZERO) } else { Vec3::ZERO };
        }
        if self.map.is_some() {
            let message = "of several environment maps, only the last lights the scene";
            content.notes.add_unsupported(message, place.described());
        }
        self.map = Some(map);
        Ok(())
    }

    /// Returns all lights. Infinite lights are merged into one environment light.
    pub fn into_descriptions(
        mut self,
        content: &mut SceneContent,
        files: &SceneFiles<'_>,
    ) -> ReadResult<Vec<Spanned<LightDescription>>> {
        let radiance = match self.map {
            Some(mut map) => {
                let sky = self.sky.as_vec3();
                map.pixels_mut().iter_mut().for_each(|pixel| *pixel += sky);
                let path = Spanned::new(content.textures.embed(map, files)?, Span::default());
                Some(EnvironmentRadiance::Picture { path, scale: 1.0, rotate: LEFT_EDGE_ROTATION })
            }
            None => (self.sky != DVec3::ZERO).then_some(EnvironmentRadiance::Constant(self.sky)),
        };
        if let Some(radiance) = radiance {
            self.descriptions.push(Spanned::new(LightDescription::Environment(radiance), Span::default()));
        }
        Ok(self.descriptions)
    }
}

/// Returns the luminance of a linear RGB color by the weights of Rec. 709.
fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns the parameter `scale` of a light, which is a number, or a color in pbrt-v3.
fn light_scale(parameters: &Parameters, files: &SceneFiles<'_>) -> ReadResult<DVec3> {
    match parameters.find("scale") {
        Some(parameter) => color(parameter, ColorUse::Unbounded, &parameters.place, files),
        None => Ok(DVec3::ONE),
    }
}

/// Returns the radiance of an area light in W/(m² sr); it is never `None`.
///
/// Parameters that are ignored give a message.
pub(super) fn area_radiance(
    parameters: &Parameters,
    files: &SceneFiles<'_>,
    content: &mut SceneContent,
) -> ReadResult<Option<DVec3>> {
    let place: &Place = &parameters.place;
    let wanted = ColorUse::Light { is_v3: content.is_v3 };
    let radiance = match parameters.find("L") {
        Some(parameter) => color(parameter, wanted, place, files)?,
        None => DVec3::ONE,
    };
    let notes = &mut content.notes;
    if parameters.flag("twosided") == Some(true) {
        notes.add_unsupported("area lights with two sides emit from the front only", place.described());
    }
    if parameters.find("filename").is_some() {
        notes.add_unsupported("pictures of area lights are ignored: they emit evenly", place.described());
    }
    if parameters.find("power").is_some() {
        notes.add_unsupported("the power of area lights is ignored: their radiance holds", place.described());
    }
    Ok(Some(radiance * light_scale(parameters, files)?))
}

/// Returns σa and σs \[1/length], the emission, and the mean cosine g of a homogeneous medium.
///
/// The emission is in W/(m² sr) per length. Returns `None` for other media, which are left out with
/// a message.
pub(super) fn homogeneous_medium(
    name: &str,
    parameters: &Parameters,
    files: &SceneFiles<'_>,
    notes: &mut ImportNotes,
) -> ReadResult<Option<(DVec3, DVec3, DVec3, f64)>> {
    let place = &parameters.place;
    match parameters.text("type") {
        Some("homogeneous") | None => {}
        Some(kind) => {
            let message = format!("media of kind `{kind}` are left out: their shapes are empty");
            notes.add_unsupported(&message, format!("{}: `{name}`", place.described()));
            return Ok(None);
        }
    }
    if let Some(preset) = parameters.text("preset") {
        let message = format!("media by preset have pbrt's default coefficients, not those of `{preset}`");
        notes.add_unsupported(&message, place.described());
    }
    let value = |names: &[&str], default: DVec3| match parameters.find_any(names) {
        Some(parameter) => color(parameter, ColorUse::Unbounded, place, files),
        None => Ok(default),
    };
    let scale = parameters.number_or("scale", 1.0);
    let g = parameters.number_or("g", 0.0);
    if scale < 0.0 || !(g > -1.0 && g < 1.0) {
        return Err(place.error("the scale is negative, or g is not between -1 and 1", "correct the medium"));
    }
    // pbrt's defaults: whole milk, in 1/mm.
    let absorption = value(&["sigma_a"], DVec3::new(0.0011, 0.0024, 0.014))? * scale;
    let scattering = value(&["sigma_s"], DVec3::new(2.55, 3.21, 3.77))? * scale;
    let emission = value(&["Le"], DVec3::ZERO)? * parameters.number_or("Lescale", 1.0).max(0.0);
    // pbrt multiplies the emission `Le` by the absorption coefficient.
    Ok(Some((absorption, scattering, emission * absorption, g)))
}
