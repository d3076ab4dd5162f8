//! Converts the lights of a pbrt scene, and their maps.

use super::content::PbrtSceneContent;
use super::environment::{MapLayout, to_equirectangular};
use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::parameters::{Parameter, Parameters};
use super::pictures::{LevelCurve, read_picture};
use super::spectra::{ColorMeaning, linear_rgb};
use crate::format::description::{
    DirectionOrTarget, DirectionalLightDescription, DirectionalLightStrength, EnvironmentRadiance,
    GoniometricLightDescription, IntensityDistribution, LightDescription, LightPose, PointLightDescription,
    PointLightStrength, ProjectorLightDescription, Span, Spanned, SpotLightDescription,
};
use crate::image::{Image, PictureSizeError};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::f64::consts::PI;

/// Rotation about y for an environment map that shows −z at its left edge \[degrees].
///
/// Without rotation, Caustica's environment maps show −z at the center.
const LEFT_EDGE_ROTATION_DEGREES: f64 = 180.0;

/// Number of rows of a spotlight's intensity map: 8 per degree, over 180 degrees from the axis.
const SPOT_MAP_ROWS: u32 = 1_440;

/// Lights of the imported scene so far. All infinite lights become one environment light.
#[derive(Default)]
pub(super) struct PbrtLights {
    /// True if at least one converted shape emits light.
    pub has_emissive_surfaces: bool,
    /// Lights of the imported scene, without infinite lights.
    descriptions: Vec<Spanned<LightDescription>>,
    /// Sum of the radiances of all infinite lights without a picture \[W/(m² sr)].
    constant_radiance: DVec3,
    /// Radiance of the last infinite light with a picture, as an equirectangular map in world
    /// space.
    environment_map: Option<Image>,
}

impl PbrtLights {
    /// Converts the light of a `LightSource` directive, and adds it.
    ///
    /// `kind` is its type, such as `spot`. `to_world` maps the light's own space to the world space
    /// of the imported scene.
    pub fn add_light(
        &mut self,
        kind: &str,
        parameters: &Parameters,
        to_world: DAffine3,
        content: &mut PbrtSceneContent,
        files: &PbrtSceneFiles<'_>,
    ) -> ReadResult<()> {
        let place = &parameters.place;
        let is_v3 = content.is_v3;
        let meaning = ColorMeaning::Emission { is_v3 };
        let scale = light_scale(parameters, files)?;
        let color_of = |name: &str| -> ReadResult<DVec3> {
            match parameters.find(name) {
                Some(parameter) => Ok(linear_rgb(parameter, meaning, place, files)? * scale),
                None => Ok(scale),
            }
        };
        let position =
            |name: &str, default: DVec3| to_world.transform_point3(parameters.point(name).unwrap_or(default));
        let degenerate = |message: &str| place.error(message, "give two different points `from` and `to`");
        // With a parameter `power`, the light has the flux `power` times color and scale, as in
        // pbrt.
        let strength = |intensity: DVec3| match parameters.number("power") {
            Some(power) if power > 0.0 => PointLightStrength::Power(intensity * power),
            _ => PointLightStrength::Intensity(intensity),
        };
        let description = match kind {
            "point" => LightDescription::Point(PointLightDescription {
                position: position("from", DVec3::ZERO),
                strength: strength(color_of("I")?),
            }),
            "spot" => {
                let (from, to) = (position("from", DVec3::ZERO), position("to", DVec3::Z));
                if (to - from).try_normalize().is_none() {
                    return Err(degenerate("the spotlight has no direction"));
                }
                let cone = parameters.number_or("coneangle", 30.0);
                let rim = parameters.number_or("conedeltaangle", 5.0).clamp(0.0, cone.max(0.0));
                if !(cone > 0.0 && cone <= 180.0) {
                    return Err(place.error("the cone's angle is not between 0° and 180°", "correct `coneangle`"));
                }
                let strength = strength(color_of("I")?);
                if is_v3 {
                    let map = v3_spot_map(cone, rim).map_err(|e| place.error(e, "use another light"))?;
                    let path = Spanned::new(content.textures.embed_picture(map, files)?, Span::default());
                    // The map is symmetric about its up direction, which is the light's axis.
                    let axis = (to - from).normalize();
                    let aim = DirectionOrTarget::Direction(axis.any_orthonormal_vector());
                    let pose = LightPose { position: from, aim, up: Some(axis) };
                    let distribution = IntensityDistribution::MapFile(path);
                    GoniometricLightDescription { pose, distribution, strength }.into()
                } else {
                    LightDescription::Spot(SpotLightDescription {
                        position: from,
                        aim: DirectionOrTarget::Target(to),
                        full_cone_angle_degrees: 2.0 * cone,
                        penumbra_degrees: rim,
                        strength,
                    })
                }
            }
            "distant" => {
                let direction = position("to", DVec3::Z) - position("from", DVec3::ZERO);
                let direction = direction.try_normalize();
                let direction = direction.ok_or_else(|| degenerate("the distant light has no direction"))?;
                let mut irradiance = color_of("L")?;
                if let Some(illuminance) = parameters.number("illuminance").filter(|value| *value > 0.0) {
                    irradiance *= illuminance;
                }
                let strength = DirectionalLightStrength::Irradiance(irradiance);
                LightDescription::Directional(DirectionalLightDescription { direction, strength })
            }
            "infinite" | "exinfinite" => {
                return self.add_infinite_light(parameters, (to_world.matrix3, scale), color_of("L")?, content, files);
            }
            "goniometric" => {
                let intensity = strength(color_of("I")?);
                match goniometric_map(parameters, to_world.matrix3, content, files)? {
                    None => LightDescription::Point(PointLightDescription {
                        position: to_world.translation,
                        strength: intensity,
                    }),
                    Some(map) => {
                        // The map has −z at its left edge.
                        let aim = DirectionOrTarget::Direction(DVec3::Z);
                        let pose = LightPose { position: to_world.translation, aim, up: Some(DVec3::Y) };
                        let path = Spanned::new(content.textures.embed_picture(map, files)?, Span::default());
                        let distribution = IntensityDistribution::MapFile(path);
                        GoniometricLightDescription { pose, distribution, strength: intensity }.into()
                    }
                }
            }
            "projection" => {
                let (picture, angle) = projected_picture(parameters, to_world.matrix3, is_v3, files)?;
                let path = Spanned::new(content.textures.embed_picture(picture, files)?, Span::default());
                let pose = LightPose {
                    position: to_world.translation,
                    aim: DirectionOrTarget::Direction(to_world.transform_vector3(DVec3::Z)),
                    up: Some(to_world.transform_vector3(DVec3::Y)),
                };
                ProjectorLightDescription {
                    pose,
                    vertical_fov_degrees: angle,
                    path,
                    strength: strength(color_of("I")?),
                }
                .into()
            }
            _ => {
                let message = format!("no light is called `{kind}`");
                return Err(place
                    .error(message, "pbrt has the lights point, spot, distant, goniometric, projection and infinite"));
            }
        };
        files.reserve_memory(1000)?;
        self.descriptions.push(Spanned::new(description, Span::default()));
        Ok(())
    }

    /// Adds the radiance of an infinite light, constant or from a picture.
    ///
    /// `axes` is the linear part of the light's transform to world space. `constant` is the
    /// parameter `L` times `scale`. A light without a picture has the radiance `constant`, times
    /// illuminance / π if the file states an illuminance. The pixels of a picture are multiplied by
    /// `scale` in pbrt-v4, and by `constant` in pbrt-v3.
    fn add_infinite_light(
        &mut self,
        parameters: &Parameters,
        (axes, scale): (DMat3, DVec3),
        constant: DVec3,
        content: &mut PbrtSceneContent,
        files: &PbrtSceneFiles<'_>,
    ) -> ReadResult<()> {
        let place = &parameters.place;
        if parameters.find("portal").is_some() {
            content.notes.add_unsupported("portals of infinite lights are ignored", place.position_text());
        }
        let Some(parameter) = parameters.find_any(&["filename", "mapname"]) else {
            self.constant_radiance += match parameters.number("illuminance").filter(|value| *value > 0.0) {
                Some(illuminance) => constant * (illuminance / PI),
                None => constant,
            };
            return Ok(());
        };
        if parameters.find("illuminance").is_some() {
            content.notes.add_unsupported("the illuminance of environment maps is ignored", place.position_text());
        }
        let (image, layout) = read_spherical_map(parameter, place, content, files)?;
        files.reserve_memory(36 * image.pixels().len() as u64)?;
        let factor = if parameter.name == "mapname" { constant } else { scale };
        let map = to_equirectangular(&image, layout, axes);
        let mut map = map.ok_or_else(|| place.error("the transform of the light is singular", "scale it less"))?;
        for pixel in map.pixels_mut() {
            *pixel = nonnegative_finite_pixel(*pixel * factor.as_vec3());
        }
        if self.environment_map.is_some() {
            let message = "of several environment maps, only the last lights the scene";
            content.notes.add_unsupported(message, place.position_text());
        }
        self.environment_map = Some(map);
        Ok(())
    }

    /// Returns all lights of the scene, with the infinite lights merged into one environment light.
    ///
    /// An environment map is embedded as a picture in `content`.
    pub fn into_descriptions(
        mut self,
        content: &mut PbrtSceneContent,
        files: &PbrtSceneFiles<'_>,
    ) -> ReadResult<Vec<Spanned<LightDescription>>> {
        let radiance = match self.environment_map {
            Some(mut map) => {
                let sky = self.constant_radiance.as_vec3();
                map.pixels_mut().iter_mut().for_each(|pixel| *pixel += sky);
                let path = Spanned::new(content.textures.embed_picture(map, files)?, Span::default());
                Some(EnvironmentRadiance::Picture { path, scale: 1.0, rotate: LEFT_EDGE_ROTATION_DEGREES })
            }
            None => {
                (self.constant_radiance != DVec3::ZERO).then_some(EnvironmentRadiance::Constant(self.constant_radiance))
            }
        };
        if let Some(radiance) = radiance {
            self.descriptions.push(Spanned::new(LightDescription::Environment(radiance), Span::default()));
        }
        Ok(self.descriptions)
    }
}

/// Reads the picture that `parameter` names: an environment map, or the map of a goniometric light.
/// Returns the picture and its layout, the mapping of directions to pixels.
///
/// A square map of pbrt-v4 is octahedral. Any other map is by latitude and longitude.
fn read_spherical_map(
    parameter: &Parameter,
    place: &PbrtSourceLocation,
    content: &mut PbrtSceneContent,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<(Image, MapLayout)> {
    let name = parameter.texts.first().map(String::as_str).unwrap_or_default();
    let image = read_picture(name, LevelCurve::of_lights(content.is_v3), place, files)?.image;
    let layout = match (image.width() == image.height(), &*parameter.name) {
        (true, "filename") => MapLayout::Octahedral,
        (true, _) | (false, "mapname") => MapLayout::LatitudeLongitude,
        (false, _) => {
            let message = "maps of directions of pbrt-v4 that are not square are read by latitude and longitude";
            content.notes.add_unsupported(message, place.position_text());
            MapLayout::LatitudeLongitude
        }
    };
    Ok((image, layout))
}

/// Returns the intensity map of a goniometric light as an equirectangular map in world space;
/// `None` if the light has no picture.
///
/// The map shows −z at its left edge. Maps of pbrt-v4 become gray, because pbrt-v4 uses only the
/// mean of their channels. `axes` maps the light's space to world space.
fn goniometric_map(
    parameters: &Parameters,
    axes: DMat3,
    content: &mut PbrtSceneContent,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<Option<Image>> {
    let place = &parameters.place;
    let Some(parameter) = parameters.find_any(&["filename", "mapname"]) else { return Ok(None) };
    let (mut image, layout) = read_spherical_map(parameter, place, content, files)?;
    for pixel in image.pixels_mut() {
        let value = nonnegative_finite_pixel(*pixel);
        // pbrt-v4 uses the mean of the channels.
        *pixel = if parameter.name == "filename" { Vec3::splat(value.element_sum() / 3.0) } else { value };
    }
    files.reserve_memory(36 * image.pixels().len() as u64)?;
    // The z axis of the map is the y axis of the light.
    let axes = axes * DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
    let map = to_equirectangular(&image, layout, axes);
    map.map(Some).ok_or_else(|| place.error("the transform of the light is singular", "scale it less"))
}

/// Returns the picture of a projection light, and its full vertical field of view \[degrees].
///
/// The matrix `axes` maps the light's space to world space. If its columns are right-handed, the
/// picture is flipped left to right. A picture of pbrt-v3 is flipped top to bottom. Negative
/// channels become 0, and pixels that are not finite become black.
fn projected_picture(
    parameters: &Parameters,
    axes: DMat3,
    is_v3: bool,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<(Image, f64)> {
    let place = &parameters.place;
    let fov = parameters.number_or("fov", if is_v3 { 45.0 } else { 90.0 });
    if !(fov > 0.0 && fov < 180.0) {
        return Err(place.error("the field of view is not between 0° and 180°", "correct `fov`"));
    }
    let parameter = parameters.find_any(&["filename", "mapname"]);
    let name = parameter.and_then(|parameter| parameter.texts.first());
    let name = name.ok_or_else(|| place.error("the projection light has no picture", "give its `filename`"))?;
    let mut image = read_picture(name, LevelCurve::of_lights(is_v3), place, files)?.image;
    image.pixels_mut().iter_mut().for_each(|pixel| *pixel = nonnegative_finite_pixel(*pixel));
    let width = image.width() as usize;
    if is_v3 {
        // Reverse the order of all pixels, and then the order in each row: this swaps top and
        // bottom.
        image.pixels_mut().reverse();
        image.pixels_mut().chunks_mut(width).for_each(<[Vec3]>::reverse);
    }
    // Seen from the light, +x is to the right if the axes are left-handed. Flip other pictures.
    if axes.determinant() > 0.0 {
        image.pixels_mut().chunks_mut(width).for_each(<[Vec3]>::reverse);
    }
    // The field of view is that of the shorter side.
    let half_height =
        libm::tan((0.5 * fov).to_radians()) * (f64::from(image.height()) / f64::from(image.width())).max(1.0);
    Ok((image, 2.0 * libm::atan(half_height).to_degrees()))
}

/// Returns the intensity of a spotlight of pbrt-v3, relative to its axis, as an image of one
/// column. Rows go from 0 to 180 degrees from the axis.
///
/// `cone` is the half angle of the cone, and `rim` is the width of the falloff inside it
/// \[degrees]. In the falloff, the intensity is t⁴, where t is linear in the cosine: 0 at `cone`,
/// and 1 at `cone` − `rim`.
fn v3_spot_map(cone: f64, rim: f64) -> Result<Image, PictureSizeError> {
    let [cos_outer, cos_inner] = [cone, cone - rim].map(|degrees| libm::cos(degrees.to_radians()));
    let falloff = |row: u32| {
        let cosine = libm::cos((f64::from(row) + 0.5) * PI / f64::from(SPOT_MAP_ROWS));
        if cosine >= cos_inner {
            1.0
        } else {
            let delta = ((cosine - cos_outer) / (cos_inner - cos_outer)).max(0.0);
            delta * delta * delta * delta
        }
    };
    let pixels = (0..SPOT_MAP_ROWS).map(|row| Vec3::splat(falloff(row) as f32)).collect();
    Image::from_pixels(1, SPOT_MAP_ROWS, pixels)
}

/// Returns `pixel` with negative channels set to 0; black if a channel is infinite or NaN.
fn nonnegative_finite_pixel(pixel: Vec3) -> Vec3 {
    if pixel.is_finite() { pixel.max(Vec3::ZERO) } else { Vec3::ZERO }
}

/// Returns the parameter `scale` of a light: a number, or a color in pbrt-v3; 1 if it is missing.
fn light_scale(parameters: &Parameters, files: &PbrtSceneFiles<'_>) -> ReadResult<DVec3> {
    match parameters.find("scale") {
        Some(parameter) => linear_rgb(parameter, ColorMeaning::Unbounded, &parameters.place, files),
        None => Ok(DVec3::ONE),
    }
}

/// Emission of a shape, from the directive `AreaLightSource`: its strength and its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PbrtShapeEmission {
    /// Radiance or flux, as the file states it.
    strength: EmissionStrength,
    /// True if both sides of the surface emit.
    pub is_two_sided: bool,
}

/// Radiance or flux of a shape, in linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
enum EmissionStrength {
    /// Radiance \[W/(m² sr)].
    Radiance(DVec3),
    /// Flux of the whole shape, or of each triangle of a mesh \[W].
    Flux(DVec3),
}

impl PbrtShapeEmission {
    /// Reads the emission that the parameters of an `AreaLightSource` directive state.
    pub fn from_parameters(
        parameters: &Parameters,
        files: &PbrtSceneFiles<'_>,
        content: &mut PbrtSceneContent,
    ) -> ReadResult<Self> {
        let place: &PbrtSourceLocation = &parameters.place;
        let meaning = ColorMeaning::Emission { is_v3: content.is_v3 };
        let color = match parameters.find("L") {
            Some(parameter) => linear_rgb(parameter, meaning, place, files)?,
            None => DVec3::ONE,
        };
        if parameters.find("filename").is_some() {
            content
                .notes
                .add_unsupported("pictures of area lights are ignored: they emit evenly", place.position_text());
        }
        let is_two_sided = parameters.flag("twosided") == Some(true);
        let scaled = color * light_scale(parameters, files)?;
        let strength = match parameters.number("power").filter(|power| *power > 0.0) {
            Some(power) => EmissionStrength::Flux(scaled * power),
            None => EmissionStrength::Radiance(scaled),
        };
        Ok(Self { strength, is_two_sided })
    }

    /// True if the file states a flux instead of a radiance.
    pub fn is_flux(&self) -> bool {
        matches!(self.strength, EmissionStrength::Flux(_))
    }

    /// Returns the radiance of a shape \[W/(m² sr)].
    ///
    /// A flux Φ gives the radiance Φ / (π · area · number of sides that emit). The function `area`
    /// returns the area that emits the flux, in world space: that of the shape, or of one triangle
    /// of a mesh. `area` is called only if the file states a flux.
    pub fn radiance(&self, area: impl FnOnce() -> f64) -> DVec3 {
        let sides = if self.is_two_sided { 2.0 } else { 1.0 };
        match self.strength {
            EmissionStrength::Radiance(radiance) => radiance,
            EmissionStrength::Flux(flux) => flux / (PI * sides * area().max(f64::MIN_POSITIVE)),
        }
    }
}

#[cfg(test)]
mod tests;
