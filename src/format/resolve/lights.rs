//! Lights of the description.

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

impl Resolver<'_> {
    pub(super) fn light(&mut self, light: &Spanned<Light>, motion: &Motion) -> Result<(), SceneError> {
        match &light.value {
            Light::Moving { maps, light } => {
                let motion = motion.then_inside(maps.iter().map(Map::growing));
                self.light(light, &motion)?;
            }
            Light::Point { position, strength } => {
                self.source(SourceKind::Point { position: *position }, point(*strength), motion);
            }
            Light::Spot { position, aim: target, angle, penumbra, strength } => {
                let outer = 0.5 * angle.to_radians();
                let kind = SourceKind::Spot {
                    position: *position,
                    axis: aim(*target, *position),
                    inner: (outer - penumbra.to_radians()).max(0.0),
                    outer,
                };
                self.source(kind, point(*strength), motion);
            }
            Light::Directional { direction, strength } => {
                let strength = match strength {
                    DirectionalStrength::Color(c) => LightStrength::Course(rgb(*c)),
                    DirectionalStrength::Irradiance(e) => LightStrength::Physical(rgb(*e)),
                };
                self.source(SourceKind::Directional { direction: *direction }, strength, motion);
            }
            Light::Sphere { center, radius, strength } => {
                self.area_light(Shape::Sphere(Sphere::new(*center, *radius)), *center, *strength, motion, light.span)?;
            }
            Light::Disc { center, normal, radius, strength } => {
                self.area_light(
                    Shape::Disc(Disc::around(*center, *normal, *radius)),
                    *center,
                    *strength,
                    motion,
                    light.span,
                )?;
            }
            Light::Rectangle { corner, edge0, edge1, strength } => {
                let middle = *corner + 0.5 * (*edge0 + *edge1);
                self.area_light(
                    Shape::Rectangle(Rectangle::new(*corner, *edge0, *edge1)),
                    middle,
                    *strength,
                    motion,
                    light.span,
                )?;
            }
            Light::Environment(radiance) => {
                let environment = self.environment(radiance, light.span)?;
                self.builder.environment(environment);
            }
        }
        Ok(())
    }

    fn environment(&self, described: &EnvironmentRadiance, span: Span) -> Result<EnvironmentLight, SceneError> {
        match described {
            EnvironmentRadiance::Constant(radiance) => EnvironmentLight::constant(rgb(*radiance))
                .map_err(|e| self.refuse(span, &e.to_string(), "give a radiance that single precision can hold")),
            EnvironmentRadiance::Picture { path, scale, rotate } => {
                let file = self.file("picture", path)?;
                let map = self.read_picture(path, &file, Meaning::Light)?;
                EnvironmentLight::new(map, rotate.to_radians(), Rgb::splat(*scale as f32))
                    .map_err(|e| self.bad_file(path, &e, "mend the picture, or scale it less"))
            }
        }
    }

    fn source(&mut self, kind: SourceKind, strength: LightStrength, motion: &Motion) {
        if motion.is_still() {
            self.builder.source(kind, strength);
        } else {
            self.builder.moving_source(kind, strength, motion);
        }
    }

    /// A black surface that radiates, and moves as if `place` were the origin.
    fn area_light(
        &mut self,
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
        self.check_radiance(rgb(radiance), span)?;
        let black = self.builder.material(Material::black());
        if motion.is_still() {
            self.builder.shape(shape, black, rgb(radiance));
        } else {
            self.builder.moving_shape(shape, motion.about(place), black, rgb(radiance));
        }
        Ok(())
    }
}

fn point(strength: PointStrength) -> LightStrength {
    let take = |c: DVec3| rgb(c);
    match strength {
        PointStrength::Color(c) => LightStrength::Course(take(c)),
        PointStrength::Intensity(i) => LightStrength::Physical(take(i)),
        PointStrength::Power(w) => LightStrength::Power(take(w)),
    }
}
