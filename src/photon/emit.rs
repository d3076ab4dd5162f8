//! Emission of photon paths: choice of the light, position and direction.

use super::guiding::GuidingDistribution;
use crate::color::{self, Rgb};
use crate::light::{Light, PhotonAim};
use crate::math::Ray;
use crate::sampling::{Dimension, DiscreteDistribution, Key, Purpose, sobol_2d};
use crate::scene::{Effect, Effects, Interior, InteriorKind, PathRay, Scene};
use glam::Vec2;

/// Samples per light for the estimate of its aimed power.
const POWER_SAMPLES: u32 = 256;

/// Fraction of the light probabilities that follows total power, so that no light is lost by a bad
/// estimate.
const DEFENSIVE_FRACTION: f64 = 0.1;

/// Source of photon paths from all lights of a scene.
#[derive(Clone, Debug)]
pub struct PhotonSource<'a> {
    pub(super) scene: &'a Scene,
    /// Distribution over the lights.
    pub(super) choice: DiscreteDistribution,
    /// Spheres to aim at; `None` emits in all directions.
    aim: Option<PhotonAim>,
    /// Guiding distribution of each guided light.
    pub(super) guiding: Vec<Option<GuidingDistribution>>,
    /// The effects that photons simulate.
    effects: Effects,
}

/// Primary sample of one photon path.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimaryEmissionSample {
    /// Index of the light.
    pub light: usize,
    /// Probability of the light.
    pub probability: f32,
    /// Sample point of the position, in \[0, 1)².
    pub position: Vec2,
    /// Sample point of the direction, in \[0, 1)².
    pub direction: Vec2,
    /// Pdf of `position` and `direction` together; 1 without guiding.
    pub pdf: f32,
}

impl<'a> PhotonSource<'a> {
    /// A source that emits in all directions, from each light in proportion to its power; `None` if
    /// no light has power.
    #[must_use]
    pub fn in_all_directions(scene: &'a Scene) -> Option<Self> {
        let choice = DiscreteDistribution::new(light_powers(scene))?;
        let effects = effects_of_scene(scene);
        Some(Self { scene, choice, aim: None, guiding: Vec::new(), effects })
    }

    /// A source that aims at the casters, from each light in proportion to the aimed power.
    ///
    /// `None` if no light can reach a caster. The aimed power is estimated by a pilot that depends
    /// on the scene alone.
    #[must_use]
    pub fn aimed_at_casters(scene: &'a Scene) -> Option<Self> {
        let Some(spheres) = scene.caster_balls() else {
            return Self::in_all_directions(scene);
        };
        let domain = scene.domain();
        let reaching = |(light, power): (&Light, f64)| {
            // A light may reach moving objects at another time.
            let reaches = scene.moves() || spheres.iter().any(|sphere| light.may_illuminate(Some(*sphere), domain));
            if reaches { power } else { 0.0 }
        };
        let light_powers: Vec<f64> = scene.lights().iter().zip(light_powers(scene)).map(reaching).collect();
        let aim = PhotonAim::new(spheres.iter().copied());
        let aimed = |(i, power): (usize, &f64)| if *power > 0.0 { estimate_aimed_power(scene, &aim, i) } else { 0.0 };
        let aimed: Vec<f64> = light_powers.iter().enumerate().map(aimed).collect();
        let (total, total_aimed) = (light_powers.iter().sum::<f64>(), aimed.iter().sum::<f64>());
        let weight = |(power, aimed): (&f64, &f64)| {
            let plain = power / total;
            // Zero estimated power does not prove that no light reaches a caster.
            if total_aimed > 0.0 {
                DEFENSIVE_FRACTION * plain + (1.0 - DEFENSIVE_FRACTION) * aimed / total_aimed
            } else {
                plain
            }
        };
        let choice =
            if total > 0.0 { DiscreteDistribution::new(light_powers.iter().zip(&aimed).map(weight)) } else { None };
        let effects = effects_of_scene(scene);
        choice.map(|choice| Self { scene, choice, aim: Some(aim), guiding: Vec::new(), effects })
    }

    /// The source without the environment light; `None` if no other light has power.
    #[must_use]
    pub fn without_environment(self) -> Option<Self> {
        // Without an environment, the source stays equal to the bit: new probabilities would differ
        // by rounding.
        let Some(sky) = self.scene.environment() else { return Some(self) };
        let weight = |i| if i == sky { 0.0 } else { f64::from(self.choice.probability(i)) };
        let choice = DiscreteDistribution::new((0..self.scene.lights().len()).map(weight))?;
        Some(Self { choice, ..self })
    }

    /// The source for `scene`, its own scene at another time. It aims at the casters of that time.
    #[must_use]
    pub fn at<'b>(&self, scene: &'b Scene) -> PhotonSource<'b> {
        let spheres = if self.aim.is_some() { scene.caster_balls() } else { None };
        let aim = spheres.map(PhotonAim::new);
        let (choice, guiding) = (self.choice.clone(), self.guiding.clone());
        PhotonSource { scene, choice, aim, guiding, ..*self }
    }

    /// The source with photons that simulate `effects`.
    #[must_use]
    pub fn with_effects(self, effects: Effects) -> Self {
        Self { effects, ..self }
    }

    /// Which interiors its photons track.
    pub(super) fn interior_kind(&self) -> InteriorKind {
        self.effects.interior_kind()
    }

    /// The lights, with or without their emission textures.
    pub(super) fn lights(&self) -> &'a [Light] {
        if self.effects.has(Effect::Textures) { self.scene.lights() } else { self.scene.mean_lights() }
    }

    /// Starts path `index` of `paths`, with its flux \[W]; `None` if it carries no flux.
    ///
    /// Lights are chosen by systematic sampling over the indices. Positions and directions are
    /// scrambled Sobol points keyed by the pass: each path is uniform by itself, and all paths
    /// together are stratified.
    #[must_use]
    pub fn emit<I: Interior>(&self, pass: Key, index: u32, paths: u32) -> Option<(PathRay<I>, Rgb)> {
        let point = self.primary_emission_sample(pass, index, paths);
        let (ray, flux) = self.start_path(&point)?;
        Some((ray, flux / (point.probability * paths as f32 * point.pdf)))
    }

    /// Primary sample of path `index` of `paths`.
    #[inline]
    pub(super) fn primary_emission_sample(&self, pass: Key, index: u32, paths: u32) -> PrimaryEmissionSample {
        let u = (f64::from(index) + f64::from(pass.uniform_1d(Dimension::Light))) / f64::from(paths);
        let (light, probability) = self.choice.sample((u as f32).min(1.0 - f32::EPSILON / 2.0));
        let position = sobol_2d(index, pass, Dimension::LightPosition);
        let direction = sobol_2d(index, pass, Dimension::LightDirection);
        let (position, direction, pdf) = match self.guiding.get(light) {
            Some(Some(distribution)) => distribution.sample(position, direction),
            Some(None) | None => (position, direction, 1.0),
        };
        PrimaryEmissionSample { light, probability, position, direction, pdf }
    }

    /// Starts a path, with its flux \[W] as if its light were the only one and not guided.
    #[inline]
    pub(super) fn start_path<I: Interior>(&self, point: &PrimaryEmissionSample) -> Option<(PathRay<I>, Rgb)> {
        let light = &self.lights()[point.light];
        let domain = self.scene.domain();
        let emission = match &self.aim {
            Some(aim) => light.sample_le_towards(aim, domain, point.position, point.direction),
            None => light.sample_le(domain, point.position, point.direction),
        }?;
        let ray = if light.is_infinite() {
            self.scene.start_beyond_planes(emission.ray)
        } else if light.is_delta() {
            Ray { origin: emission.ray.at(self.scene.light_contact(point.light)), ..emission.ray }
        } else {
            emission.ray
        };
        Some((self.scene.start_light_path(point.light, ray, self.effects), emission.flux))
    }
}

/// All effects, without interiors if `scene` has none.
fn effects_of_scene(scene: &Scene) -> Effects {
    if scene.has_interiors() { Effects::ALL } else { Effects::ALL.without(Effect::Interiors) }
}

/// Power of each light, mean over the channels \[W].
fn light_powers(scene: &Scene) -> impl Iterator<Item = f64> {
    scene.lights().iter().map(|light| f64::from(color::channel_mean(light.power(scene.domain()))))
}

/// Estimated power of a light towards the spheres of `aim`, mean over the channels \[W].
fn estimate_aimed_power(scene: &Scene, aim: &PhotonAim, light: usize) -> f64 {
    let key = Key::new(0).purpose_key(Purpose::LightWeights).light_key(light);
    let flux = |i| {
        let (position, direction) =
            (sobol_2d(i, key, Dimension::LightPosition), sobol_2d(i, key, Dimension::LightDirection));
        let emission = scene.lights()[light].sample_le_towards(aim, scene.domain(), position, direction);
        emission.map_or(0.0, |e| f64::from(color::channel_mean(e.flux)))
    };
    (0..POWER_SAMPLES).map(flux).sum::<f64>() / f64::from(POWER_SAMPLES)
}

#[cfg(test)]
mod tests;
