//! Adds the lights of a description to the scene.

use super::{Resolver, aim, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{
    AreaStrength, DirectionalStrength, EnvironmentRadiance, Light, Map, PointStrength, Span, Spanned,
};
use crate::image::Meaning;
use crate::light::EnvironmentLight;
use crate::math::Motion;
use crate::scene::{LightStrength, Material, SourceKind};
use crate::shape::{Disc, Rectangle, Shape, Sphere};
use glam::DVec3;

pub(super) fn add_light(r: &mut Resolver<'_>, light: &Spanned<Light>, motion: &Motion) -> Result<(), SceneError> {
    match &light.value {
        Light::Moving { maps, light } => {
            let motion = motion.then_inside(maps.iter().map(Map::growing));
            add_light(r, light, &motion)?;
        }
        Light::Point { position, strength } => {
            add_source(r, SourceKind::Point { position: *position }, point(*strength), motion);
        }
        Light::Spot { position, aim: target, angle, penumbra, strength } => {
            let outer = 0.5 * angle.to_radians();
            let kind = SourceKind::Spot {
                position: *position,
                axis: aim(*target, *position),
                inner: (outer - penumbra.to_radians()).max(0.0),
                outer,
            };
            add_source(r, kind, point(*strength), motion);
        }
        Light::Directional { direction, strength } => {
            let strength = match strength {
                DirectionalStrength::Color(c) => LightStrength::Course(rgb(*c)),
                DirectionalStrength::Irradiance(e) => LightStrength::Physical(rgb(*e)),
            };
            add_source(r, SourceKind::Directional { direction: *direction }, strength, motion);
        }
        Light::Sphere { center, radius, strength } => {
            add_area_light(r, Shape::Sphere(Sphere::new(*center, *radius)), *center, *strength, motion, light.span)?;
        }
        Light::Disc { center, normal, radius, strength } => {
            add_area_light(
                r,
                Shape::Disc(Disc::around(*center, *normal, *radius)),
                *center,
                *strength,
                motion,
                light.span,
            )?;
        }
        Light::Rectangle { corner, edge0, edge1, strength } => {
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
        Light::Environment(radiance) => {
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
        EnvironmentRadiance::Constant(radiance) => EnvironmentLight::constant(rgb(*radiance)).map_err(|e| {
            super::shapes::refuse(r, span, &e.to_string(), "give a radiance that single precision can hold")
        }),
        EnvironmentRadiance::Picture { path, scale, rotate } => {
            let file = r.file("picture", path)?;
            let map = r.read_picture(path, &file, Meaning::Light)?;
            EnvironmentLight::new(map, rotate.to_radians(), Rgb::splat(*scale as f32))
                .map_err(|e| r.bad_file(path, &e, "mend the picture, or scale it less"))
        }
    }
}

fn add_source(r: &mut Resolver<'_>, kind: SourceKind, strength: LightStrength, motion: &Motion) {
    if motion.is_still() {
        r.builder.source(kind, strength);
    } else {
        r.builder.moving_source(kind, strength, motion);
    }
}

/// Adds a black emitting surface that moves about `place`.
fn add_area_light(
    r: &mut Resolver<'_>,
    shape: Shape,
    place: DVec3,
    strength: AreaStrength,
    motion: &Motion,
    span: Span,
) -> Result<(), SceneError> {
    let radiance = match strength {
        AreaStrength::Radiance(l) => l,
        AreaStrength::Power(w) => w / (std::f64::consts::PI * shape.area()),
    };
    r.check_radiance(rgb(radiance), span)?;
    let black = r.builder.material(Material::black());
    if motion.is_still() {
        r.builder.shape(shape, black, rgb(radiance));
    } else {
        r.builder.moving_shape(shape, motion.about(place), black, rgb(radiance));
    }
    Ok(())
}

fn point(strength: PointStrength) -> LightStrength {
    let take = |c: DVec3| rgb(c);
    match strength {
        PointStrength::Color(c) => LightStrength::Course(take(c)),
        PointStrength::Intensity(i) => LightStrength::Physical(take(i)),
        PointStrength::Power(w) => LightStrength::Power(take(w)),
    }
}
