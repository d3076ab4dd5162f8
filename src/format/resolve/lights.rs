//! Adds the lights of a description to the scene.

use super::{Resolver, aim, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{
    AreaLightStrength, DirectionalLightStrength, EnvironmentRadiance, LightDescription, LightPattern,
    PointLightStrength, Span, Spanned, TransformStep,
};
use crate::image::PictureContent;
use crate::light::{
    EnvironmentLight, EquirectangularMap, IntensityPattern, OrientedPointLight, ProjectedPicture,
    map_from_intensity_profile,
};
use crate::math::Motion;
use crate::scene::{DeltaLightKind, LightStrength, Material};
use crate::shape::{Disc, Rectangle, Shape, Sphere};
use glam::DVec3;
use std::sync::Arc;

pub(super) fn add_light(
    r: &mut Resolver<'_>,
    light: &Spanned<LightDescription>,
    motion: &Motion,
) -> Result<(), SceneError> {
    match &light.value {
        LightDescription::Moving { maps, light } => {
            let motion = motion.preceded_by(maps.iter().map(TransformStep::motion_step));
            add_light(r, light, &motion)?;
        }
        LightDescription::Point { position, strength } => {
            add_source(r, DeltaLightKind::Point { position: *position }, point(*strength), motion);
        }
        LightDescription::Spot { position, aim: target, angle, penumbra, strength } => {
            let outer = 0.5 * angle.to_radians();
            let kind = DeltaLightKind::Spot {
                position: *position,
                axis: aim(*target, *position),
                inner: (outer - penumbra.to_radians()).max(0.0),
                outer,
            };
            add_source(r, kind, point(*strength), motion);
        }
        LightDescription::Oriented { position, aim: target, up, pattern, strength } => {
            let direction = aim(*target, *position);
            let vertical = direction.cross(DVec3::Y).length() < 1e-6 * direction.length();
            let up = up.unwrap_or(if vertical { DVec3::NEG_Z } else { DVec3::Y });
            let source = oriented(r, *position, direction, up, pattern)?;
            add_source(r, DeltaLightKind::Oriented(source), point(*strength), motion);
        }
        LightDescription::Directional { direction, strength } => {
            let strength = match strength {
                DirectionalLightStrength::Color(c) => LightStrength::Course(rgb(*c)),
                DirectionalLightStrength::Irradiance(e) => LightStrength::Physical(rgb(*e)),
            };
            add_source(r, DeltaLightKind::Directional { direction: *direction }, strength, motion);
        }
        LightDescription::Sphere { center, radius, strength } => {
            add_area_light(r, Shape::Sphere(Sphere::new(*center, *radius)), *center, *strength, motion, light.span)?;
        }
        LightDescription::Disc { center, normal, radius, strength } => {
            add_area_light(
                r,
                Shape::Disc(Disc::with_normal(*center, *normal, *radius)),
                *center,
                *strength,
                motion,
                light.span,
            )?;
        }
        LightDescription::Rectangle { corner, edge0, edge1, strength } => {
            let middle = *corner + 0.5 * (*edge0 + *edge1);
            add_area_light(
                r,
                Shape::Rectangle(Rectangle::new(*corner, *edge0, *edge1)),
                middle,
                *strength,
                motion,
                light.span,
            )?;
        }
        LightDescription::Environment(radiance) => {
            let environment = make_environment(r, radiance, light.span)?;
            r.builder.environment(environment);
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
        EnvironmentRadiance::Constant(radiance) => EnvironmentLight::constant(rgb(*radiance))
            .map_err(|e| r.refuse(span, &e.to_string(), "give a radiance that single precision can hold")),
        EnvironmentRadiance::Picture { path, scale, rotate } => {
            let file = r.file("picture", path)?;
            let map = r.read_picture(path, &file, PictureContent::Radiance)?;
            EnvironmentLight::new(map, rotate.to_radians(), Rgb::splat(*scale as f32))
                .map_err(|e| r.bad_file(path, &e, "repair the picture, or scale it less"))
        }
    }
}

/// Returns the oriented point light of a pattern.
fn oriented(
    r: &Resolver<'_>,
    position: DVec3,
    direction: DVec3,
    up: DVec3,
    pattern: &LightPattern,
) -> Result<OrientedPointLight, SceneError> {
    let read = |path: &Spanned<String>| r.read_picture(path, &r.file("picture", path)?, PictureContent::Radiance);
    let (pattern, direction, up) = match pattern {
        LightPattern::Picture { path, angle } => {
            let slide = ProjectedPicture::new(read(path)?, angle.to_radians());
            let slide = slide.map_err(|e| r.bad_file(path, &e, "repair the picture or name another"))?;
            let black = || r.bad_file(path, &"the picture is black", "name a picture with light in it");
            (IntensityPattern::ProjectedPicture(Arc::new(slide.ok_or_else(black)?)), direction, up)
        }
        LightPattern::Map(path) => {
            let map = EquirectangularMap::new(read(path)?, Rgb::ONE);
            let map = map.map_err(|e| r.bad_file(path, &e, "repair the picture or name another"))?;
            (IntensityPattern::Map(Arc::new(map)), direction, up)
        }
        LightPattern::Profile(path) => {
            let help = "write an angle from 0 to 180 degrees and an intensity per line, in ascending order";
            let refuse = |message: &str| r.bad_file(path, &message, help);
            let text = std::fs::read_to_string(r.file("profile", path)?).map_err(|e| refuse(&e.to_string()))?;
            let profile = profile(&text).ok_or_else(|| refuse("the profile is not a table of angles"))?;
            let map = map_from_intensity_profile(&profile).map_err(|e| refuse(&e.to_string()))?;
            // Profiles are symmetric about the top of their map, which lies along the axis.
            (IntensityPattern::Map(Arc::new(map)), direction.any_orthogonal_vector(), direction)
        }
    };
    Ok(OrientedPointLight { position, direction, up, pattern })
}

/// Pairs of angle \[degrees] and intensity, one per line; `#` starts a comment. `None` if the table
/// is invalid.
fn profile(text: &str) -> Option<Vec<(f64, f64)>> {
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

fn add_source(r: &mut Resolver<'_>, kind: DeltaLightKind, strength: LightStrength, motion: &Motion) {
    if motion.is_constant() {
        r.builder.delta_light(kind, strength);
    } else {
        r.builder.moving_delta_light(kind, strength, motion);
    }
}

/// Adds a black emitting surface that moves about `place`.
fn add_area_light(
    r: &mut Resolver<'_>,
    shape: Shape,
    place: DVec3,
    strength: AreaLightStrength,
    motion: &Motion,
    span: Span,
) -> Result<(), SceneError> {
    let radiance = match strength {
        AreaLightStrength::Radiance(l) => l,
        AreaLightStrength::Power(w) => w / (std::f64::consts::PI * shape.area()),
    };
    r.check_radiance(rgb(radiance), span)?;
    let black = r.builder.material(Material::black());
    if motion.is_constant() {
        r.builder.shape(shape, black, rgb(radiance));
    } else {
        r.builder.moving_shape(shape, motion.around_point(place), black, rgb(radiance));
    }
    Ok(())
}

fn point(strength: PointLightStrength) -> LightStrength {
    let take = |c: DVec3| rgb(c);
    match strength {
        PointLightStrength::Color(c) => LightStrength::Course(take(c)),
        PointLightStrength::Intensity(i) => LightStrength::Physical(take(i)),
        PointLightStrength::Power(w) => LightStrength::Power(take(w)),
    }
}
