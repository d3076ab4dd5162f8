//! Which light a photon leaves, and where to.

use super::guiding::GuidingDistribution;
use crate::color::{self, Rgb};
use crate::light::{Light, PhotonAim};
use crate::math::Ray;
use crate::sampling::{Dimension, Discrete, Key, Purpose, sobol_2d};
use crate::scene::{Effect, Effects, Interior, InteriorKind, PathRay, Scene};
use glam::Vec2;

/// Draws a light finds its aimed power with.
const WEIGHT_DRAWS: u32 = 256;

/// Part of the choice among lights that follows plain power, so that no light that can matter is left out by the pilot.
const SAFE_SHARE: f64 = 0.1;

/// Emits a fixed number of paths, divided among the lights.
#[derive(Clone, Debug)]
pub struct PhotonSource<'a> {
    pub(super) scene: &'a Scene,
    pub(super) choice: Discrete,
    aim: Option<PhotonAim>,
    /// Of each light, where it was learned.
    pub(super) densities: Vec<Option<GuidingDistribution>>,
    /// The effects that photons simulate.
    effects: Effects,
}

/// A point in the space of all that can be emitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmissionDraw {
    /// The light.
    pub light: usize,
    /// With what probability it was chosen.
    pub probability: f32,
    /// Where on it, in [0, 1)².
    pub position: Vec2,
    /// Which way, in [0, 1)².
    pub direction: Vec2,
    /// Density of position and direction.
    pub density: f32,
}

impl<'a> PhotonSource<'a> {
    /// Emission from all lights in proportion to their power; `None` where no light has any.
    #[must_use]
    pub fn everywhere(scene: &'a Scene) -> Option<Self> {
        let choice = Discrete::new(powers(scene))?;
        let effects = all_effects(scene);
        Some(Self { scene, choice, aim: None, densities: Vec::new(), effects })
    }

    /// Emission towards casters, from each light in proportion to the power that goes there; `None` where there is no caster, or
    /// none that a light can reach. Lights are weighed by a pilot that depends on the scene alone; those that cannot reach a caster
    /// emit nothing.
    #[must_use]
    pub fn aimed(scene: &'a Scene) -> Option<Self> {
        let Some(balls) = scene.caster_balls() else {
            return Self::everywhere(scene);
        };
        let domain = scene.domain();
        let reaching = |(light, power): (&Light, f64)| {
            // What moves may be reached at another time.
            let reaches = scene.moves() || balls.iter().any(|ball| light.may_reach(Some(*ball), domain));
            if reaches { power } else { 0.0 }
        };
        let powers: Vec<f64> = scene.lights().iter().zip(powers(scene)).map(reaching).collect();
        let aim = PhotonAim::new(balls.iter().copied());
        let aimed = |(i, power): (usize, &f64)| if *power > 0.0 { aimed_power(scene, &aim, i) } else { 0.0 };
        let aimed: Vec<f64> = powers.iter().enumerate().map(aimed).collect();
        let (total, total_aimed) = (powers.iter().sum::<f64>(), aimed.iter().sum::<f64>());
        let weight = |(power, aimed): (&f64, &f64)| {
            let plain = power / total;
            // A pilot that finds no way to a caster does not prove that there is none.
            if total_aimed > 0.0 { SAFE_SHARE * plain + (1.0 - SAFE_SHARE) * aimed / total_aimed } else { plain }
        };
        let choice = if total > 0.0 { Discrete::new(powers.iter().zip(&aimed).map(weight)) } else { None };
        let effects = all_effects(scene);
        choice.map(|choice| Self { scene, choice, aim: Some(aim), densities: Vec::new(), effects })
    }

    /// This source without the light from all around, the same to the bit where there is none; `None` where nothing else shines.
    #[must_use]
    pub fn without_environment(self) -> Option<Self> {
        // Probabilities that are added up again differ by rounding.
        let Some(sky) = self.scene.environment() else { return Some(self) };
        let weight = |i| if i == sky { 0.0 } else { f64::from(self.choice.probability(i)) };
        let choice = Discrete::new((0..self.scene.lights().len()).map(weight))?;
        Some(Self { choice, ..self })
    }

    /// This source in `scene`, which is its own at another time: it is aimed at where casters are then.
    #[must_use]
    pub fn at<'b>(&self, scene: &'b Scene) -> PhotonSource<'b> {
        let balls = if self.aim.is_some() { scene.caster_balls() } else { None };
        let aim = balls.map(PhotonAim::new);
        let (choice, densities) = (self.choice.clone(), self.densities.clone());
        PhotonSource { scene, choice, aim, densities, ..*self }
    }

    /// This source, whose photons simulate `effects`.
    #[must_use]
    pub fn with_effects(self, effects: Effects) -> Self {
        Self { effects, ..self }
    }

    /// What its photons remember.
    pub(super) fn memory(&self) -> InteriorKind {
        self.effects.interior_kind()
    }

    /// The lights, as photons leave them.
    pub(super) fn lights(&self) -> &'a [Light] {
        if self.effects.has(Effect::Textures) { self.scene.lights() } else { self.scene.mean_lights() }
    }

    /// The start of path `index` of `paths`, with its share of the flux \[W].
    ///
    /// Lights are dealt to consecutive paths by systematic sampling, and positions and directions come from scrambled nets
    /// keyed by the pass: each path alone is as if independent, together they are spread more evenly.
    #[must_use]
    pub fn emit<I: Interior>(&self, pass: Key, index: u32, paths: u32) -> Option<(PathRay<I>, Rgb)> {
        let draw = self.draw(pass, index, paths);
        let (walk, flux) = self.start(&draw)?;
        Some((walk, flux / (draw.probability * paths as f32 * draw.density)))
    }

    /// What path `index` of `paths` starts from.
    #[inline]
    pub(super) fn draw(&self, pass: Key, index: u32, paths: u32) -> EmissionDraw {
        let u = (f64::from(index) + f64::from(pass.uniform(Dimension::Light))) / f64::from(paths);
        let (light, probability) = self.choice.sample((u as f32).min(1.0 - f32::EPSILON / 2.0));
        let position = sobol_2d(index, pass, Dimension::LightPosition);
        let direction = sobol_2d(index, pass, Dimension::LightDirection);
        let (position, direction, density) = match self.densities.get(light) {
            Some(Some(density)) => density.sample(position, direction),
            _ => (position, direction, 1.0),
        };
        EmissionDraw { light, probability, position, direction, density }
    }

    /// The start of a path, with its flux \[W] as if the light were alone and unlearned.
    #[inline]
    pub(super) fn start<I: Interior>(&self, draw: &EmissionDraw) -> Option<(PathRay<I>, Rgb)> {
        let light = &self.lights()[draw.light];
        let domain = self.scene.domain();
        let emission = match &self.aim {
            Some(aim) => light.sample_le_towards(aim, domain, draw.position, draw.direction),
            None => light.sample_le(domain, draw.position, draw.direction),
        }?;
        let ray = if light.is_infinite() {
            self.scene.starting_beyond_planes(emission.ray)
        } else if light.is_delta() {
            Ray { origin: emission.ray.at(self.scene.light_contact(draw.light)), ..emission.ray }
        } else {
            emission.ray
        };
        Some((self.scene.start_light_path(draw.light, ray, self.effects), emission.flux))
    }
}

/// All effects, without interiors where `scene` has none.
fn all_effects(scene: &Scene) -> Effects {
    if scene.has_interiors() { Effects::ALL } else { Effects::ALL.without(Effect::Interiors) }
}

fn powers(scene: &Scene) -> impl Iterator<Item = f64> {
    scene.lights().iter().map(|light| f64::from(color::mean(light.power(scene.domain()))))
}

fn aimed_power(scene: &Scene, aim: &PhotonAim, light: usize) -> f64 {
    let key = Key::new(0).purpose(Purpose::LightWeights).light(light);
    let flux = |i| {
        let (position, direction) =
            (sobol_2d(i, key, Dimension::LightPosition), sobol_2d(i, key, Dimension::LightDirection));
        let emission = scene.lights()[light].sample_le_towards(aim, scene.domain(), position, direction);
        emission.map_or(0.0, |e| f64::from(color::mean(e.flux)))
    };
    (0..WEIGHT_DRAWS).map(flux).sum::<f64>() / f64::from(WEIGHT_DRAWS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::photon::{PhotonPass, StoreMask};
    use crate::scene::{LightStrength, Material, SceneBuilder, SourceKind};
    use crate::shape::{Plane, Shape, Sphere};
    use glam::DVec3;

    /// A sun above a ball, and a plane between them at a height.
    fn sun_over_ball(height: f64) -> Scene {
        let mut builder = SceneBuilder::new();
        let white = builder.material(Material::diffuse(Rgb::ONE));
        builder.shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 0.5)), white, Rgb::ZERO);
        builder.plane(Plane::new(DVec3::Y * height, DVec3::Y), white, Rgb::ZERO);
        let direction = DVec3::new(0.3, -1.0, 0.1);
        builder.source(SourceKind::Directional { direction }, LightStrength::Physical(Rgb::ONE));
        let eye = Camera::perspective(DVec3::Z * 9.0, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
        builder.build(eye).unwrap()
    }

    #[test]
    fn suns_light_scenes_of_planes_alone() {
        let mut builder = SceneBuilder::new();
        let white = builder.material(Material::diffuse(Rgb::ONE));
        builder.plane(Plane::new(DVec3::NEG_Y, DVec3::Y), white, Rgb::ZERO);
        builder.plane(Plane::new(DVec3::Z * -3.0, DVec3::Z), white, Rgb::ZERO);
        let direction = DVec3::new(0.1, -1.0, -0.5);
        builder.source(SourceKind::Directional { direction }, LightStrength::Physical(Rgb::ONE));
        let eye = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
        let scene = builder.build(eye).unwrap();
        // As far as the farther plane, with room.
        assert!(scene.domain().radius >= 3.0);
        let source = PhotonSource::everywhere(&scene).unwrap();
        let pass = PhotonPass { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
        let photons = pass.trace(Key::new(1), 4096, &|_| {}).photons;
        let on = |axis: usize, at: f32| photons.iter().any(|p| (p.position[axis] - at).abs() < 1e-3);
        assert!(on(1, -1.0) && on(2, -3.0));
    }

    #[test]
    fn planes_shade_parallel_light_however_far_upstream() {
        for (height, shaded) in [(1.0, true), (100.0, true), (1e6, true), (-1.0, false)] {
            let scene = sun_over_ball(height);
            let source = PhotonSource::everywhere(&scene).unwrap();
            let pass = PhotonPass { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
            let photons = pass.trace(Key::new(1), 4096, &|_| {}).photons;
            let on_ball = photons.iter().filter(|p| p.position.length() < 0.6).count();
            assert_eq!(on_ball == 0, shaded, "{on_ball} of {} under a plane at {height}", photons.len());
            assert!(!photons.is_empty());
        }
    }
}
