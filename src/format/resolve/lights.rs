//! Adds the lights of the scene description to the scene.

use super::{Resolver, aim_direction, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{
    AreaLightStrength, DirectionalLightStrength, EnvironmentRadiance, LightDescription, LightPattern,
    PointLightStrength, Span, Spanned, TransformStep,
};
use crate::image::PixelMeaning;
use crate::light::{
    EnvironmentLight, EquirectangularMap, IntensityPattern, OrientedPointLight, ProjectedPicture,
    map_from_intensity_profile,
};
use crate::math::Motion;
use crate::scene::{DeltaLightKind, LightStrength, Material};
use crate::shape::{Disc, Rectangle, Shape, Sphere};
use glam::DVec3;
use std::sync::Arc;

/// Adds a described light to the scene. Its `motion` rotates and scales it about its own position.
pub(super) fn add_light(
    r: &mut Resolver<'_>,
    light: &Spanned<LightDescription>,
    motion: &Motion,
) -> Result<(), SceneError> {
    match &light.value {
        LightDescription::Moving { steps, light } => {
            let motion = motion.preceded_by_steps(steps.iter().map(TransformStep::motion_step));
            add_light(r, light, &motion)?;
        }
        LightDescription::Point { position, strength } => {
            add_delta_light(r, DeltaLightKind::Point { position: *position }, point_light_strength(*strength), motion);
        }
        LightDescription::Spot { position, aim: target, angle, penumbra, strength } => {
            let outer = 0.5 * angle.to_radians();
            let kind = DeltaLightKind::Spot {
                position: *position,
                axis: aim_direction(*target, *position),
                inner: (outer - penumbra.to_radians()).max(0.0),
                outer,
            };
            add_delta_light(r, kind, point_light_strength(*strength), motion);
        }
        LightDescription::Oriented { position, aim: target, up, pattern, strength } => {
            let direction = aim_direction(*target, *position);
            let vertical = direction.cross(DVec3::Y).length() < 1e-6 * direction.length();
            let up = up.unwrap_or(if vertical { DVec3::NEG_Z } else { DVec3::Y });
            let source = make_oriented_light(r, *position, direction, up, pattern)?;
            add_delta_light(r, DeltaLightKind::Oriented(source), point_light_strength(*strength), motion);
        }
        LightDescription::Directional { direction, strength } => {
            let strength = match strength {
                DirectionalLightStrength::Color(c) => LightStrength::LegacyColor(rgb(*c)),
                DirectionalLightStrength::Irradiance(e) => LightStrength::Physical(rgb(*e)),
            };
            add_delta_light(r, DeltaLightKind::Directional { direction: *direction }, strength, motion);
        }
        LightDescription::Sphere { center, radius, strength } => {
            let sphere = Shape::Sphere(Sphere::new(*center, *radius));
            add_area_light(r, sphere, *center, *strength, motion, light.span)?;
        }
        LightDescription::Disc { center, normal, radius, strength } => {
            let disc = Shape::Disc(Disc::circular_disc(*center, *normal, *radius));
            add_area_light(r, disc, *center, *strength, motion, light.span)?;
        }
        LightDescription::Rectangle { corner, edge0, edge1, strength } => {
            let rectangle = Shape::Rectangle(Rectangle::new(*corner, *edge0, *edge1));
            let center = *corner + 0.5 * (*edge0 + *edge1);
            add_area_light(r, rectangle, center, *strength, motion, light.span)?;
        }
        LightDescription::Environment(radiance) => {
            let environment = make_environment(r, radiance, light.span)?;
            r.builder.set_environment(environment);
        }
    }
    Ok(())
}

fn make_environment(
    r: &Resolver<'_>,
    described: &EnvironmentRadiance,
    span: Span,
) -> Result<EnvironmentLight, SceneError> {
    match described {
        EnvironmentRadiance::Constant(radiance) => EnvironmentLight::with_constant_radiance(rgb(*radiance))
            .map_err(|e| r.error_at(span, &e.to_string(), "give a radiance that single precision can hold")),
        EnvironmentRadiance::Picture { path, scale, rotate } => {
            let map = r.read_picture(path, PixelMeaning::Radiance)?;
            EnvironmentLight::new(map, rotate.to_radians(), Rgb::splat(*scale as f32))
                .map_err(|e| r.file_error(path, &e, "repair the picture, or scale it less"))
        }
    }
}

/// Returns a projector or goniometric light; `direction` and `up` orient its pattern.
fn make_oriented_light(
    r: &Resolver<'_>,
    position: DVec3,
    direction: DVec3,
    up: DVec3,
    pattern: &LightPattern,
) -> Result<OrientedPointLight, SceneError> {
    let read = |path: &Spanned<String>| r.read_picture(path, PixelMeaning::Radiance);
    let (pattern, direction, up) = match pattern {
        LightPattern::Picture { path, angle } => {
            let picture = ProjectedPicture::new(read(path)?, angle.to_radians());
            let picture = picture.map_err(|e| r.file_error(path, &e, "repair the picture or name another"))?;
            let black = || r.file_error(path, &"the picture is black", "name a picture with light in it");
            (IntensityPattern::ProjectedPicture(Arc::new(picture.ok_or_else(black)?)), direction, up)
        }
        LightPattern::Map(path) => {
            let map = EquirectangularMap::new(read(path)?, Rgb::ONE);
            let map = map.map_err(|e| r.file_error(path, &e, "repair the picture or name another"))?;
            (IntensityPattern::Map(Arc::new(map)), direction, up)
        }
        LightPattern::Profile(path) => {
            let help = "write an angle from 0 to 180 degrees and an intensity per line, in ascending order";
            let refuse = |message: &str| r.file_error(path, &message, help);
            let text = std::fs::read_to_string(r.find_file("profile", path)?).map_err(|e| refuse(&e.to_string()))?;
            let profile =
                parse_intensity_profile(&text).ok_or_else(|| refuse("the profile is not a table of angles"))?;
            let map = map_from_intensity_profile(&profile).map_err(|e| refuse(&e.to_string()))?;
            // The intensity map of a profile is symmetric about its up direction. So `up` is the
            // light's axis.
            (IntensityPattern::Map(Arc::new(map)), direction.any_orthogonal_vector(), direction)
        }
    };
    Ok(OrientedPointLight { position, direction, up, pattern })
}

/// Parses an intensity profile: pairs of an angle from the axis \[degrees] and an intensity.
///
/// Each line holds one pair, in ascending order of angle. `#` starts a comment. `None` if the text
/// is no such table.
fn parse_intensity_profile(text: &str) -> Option<Vec<(f64, f64)>> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let pair = |line: &str| {
        let mut numbers = line.split_whitespace().map(str::parse::<f64>);
        match (numbers.next(), numbers.next(), numbers.next()) {
            (Some(Ok(angle)), Some(Ok(value)), None) => Some((angle, value)),
            _ => None,
        }
    };
    let pairs: Vec<(f64, f64)> = lines.filter(|line| !line.is_empty()).map(pair).collect::<Option<_>>()?;
    let ascending = pairs.windows(2).all(|pair| pair[0].0 < pair[1].0);
    let in_range = pairs.iter().all(|(angle, _)| (0.0..=180.0).contains(angle));
    (pairs.len() >= 2 && ascending && in_range).then_some(pairs)
}

/// Adds a light without area: point, spot, directional or oriented.
fn add_delta_light(r: &mut Resolver<'_>, kind: DeltaLightKind, strength: LightStrength, motion: &Motion) {
    if motion.is_constant() {
        r.builder.add_delta_light(kind, strength);
    } else {
        r.builder.add_moving_delta_light(kind, strength, motion);
    }
}

/// Adds a light-emitting shape that reflects nothing. Its `motion` rotates and scales it about
/// `center`.
fn add_area_light(
    r: &mut Resolver<'_>,
    shape: Shape,
    center: DVec3,
    strength: AreaLightStrength,
    motion: &Motion,
    span: Span,
) -> Result<(), SceneError> {
    let radiance = match strength {
        AreaLightStrength::Radiance(l) => l,
        AreaLightStrength::Power(w) => w / (std::f64::consts::PI * shape.area()),
    };
    r.require_finite_radiance(rgb(radiance), span)?;
    let black = r.builder.add_material(Material::black());
    if motion.is_constant() {
        r.builder.add_shape(shape, black, rgb(radiance));
    } else {
        r.builder.add_moving_shape(shape, motion.pivoted_at_point(center), black, rgb(radiance));
    }
    Ok(())
}

fn point_light_strength(strength: PointLightStrength) -> LightStrength {
    match strength {
        PointLightStrength::Color(c) => LightStrength::LegacyColor(rgb(c)),
        PointLightStrength::Intensity(i) => LightStrength::Physical(rgb(i)),
        PointLightStrength::Power(w) => LightStrength::Power(rgb(w)),
    }
}
