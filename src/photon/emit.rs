//! Emission of photon paths: samples a light, a position and a direction.
//!
//! Photons do not carry the direct light of `hybrid`: its maps hold only caustics and the light
//! that caustics reflect. Next-event estimation computes direct light by [`Light::sample_li`].

use super::guiding::EmissionGuidingDistribution;
use crate::color::{self, Rgb};
use crate::light::{Light, PhotonAim};
use crate::math::Ray;
use crate::sampling::{Dimension, DiscreteDistribution, Key, Purpose, sobol_2d};
use crate::scene::{Effect, Effects, Interior, InteriorKind, PathRay, Scene};
use glam::Vec2;

/// Number of samples that estimate the power of one light towards the caustic casters.
const POWER_SAMPLES: u32 = 256;

/// Fraction of each light's probability that follows its total power (defensive sampling).
///
/// A light whose aimed power was estimated as zero keeps a probability above zero.
const DEFENSIVE_FRACTION: f64 = 0.1;

/// Samples the emission of photon paths from all lights of a scene.
#[derive(Clone, Debug)]
pub struct PhotonSource<'a> {
    pub(super) scene: &'a Scene,
    /// Probabilities of the lights.
    pub(super) light_distribution: DiscreteDistribution,
    /// Bounding spheres of the caustic casters. Photons are emitted towards them; `None` emits in
    /// all directions.
    aim: Option<PhotonAim>,
    /// Guiding distribution of each light; `None` for an unguided light. Empty if no light is
    /// guided.
    pub(super) guiding: Vec<Option<EmissionGuidingDistribution>>,
    /// Effects that photon paths simulate.
    effects: Effects,
}

/// Choice of a light, and the sample points in \[0, 1)² from which an emission's position and
/// direction follow.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimaryEmissionSample {
    /// Index of the light.
    pub light: usize,
    /// Probability of the light.
    pub probability: f32,
    /// Sample point in \[0, 1)² from which the position on the light follows (primary sample).
    pub position: Vec2,
    /// Sample point in \[0, 1)² from which the direction follows (primary sample).
    pub direction: Vec2,
    /// Joint pdf of `position` and `direction` over the unit hypercube \[0, 1)⁴; 1 without guiding.
    pub pdf: f32,
}

impl<'a> PhotonSource<'a> {
    /// Creates a source that emits from each light in all directions of its emission; `None` if no
    /// light has power.
    ///
    /// Lights are chosen in proportion to their power.
    #[must_use]
    pub fn in_all_directions(scene: &'a Scene) -> Option<Self> {
        let light_distribution = DiscreteDistribution::new(light_powers(scene))?;
        let effects = effects_of_scene(scene);
        Some(Self { scene, light_distribution, aim: None, guiding: Vec::new(), effects })
    }

    /// Creates a source that emits only towards the bounding spheres of caustic casters.
    ///
    /// Lights are chosen in proportion to their power towards the spheres, estimated by sampling.
    /// If a caster is unbounded, the source emits in all directions. Returns `None` if no light can
    /// reach a caster.
    #[must_use]
    pub fn aimed_at_casters(scene: &'a Scene) -> Option<Self> {
        let Some(spheres) = scene.caster_bounding_spheres() else {
            return Self::in_all_directions(scene);
        };
        let domain = scene.photon_domain();
        let reaching = |(light, power): (&Light, f64)| {
            // A light that misses a moving caster now may reach it at another shutter time.
            let reaches =
                scene.has_motion() || spheres.iter().any(|sphere| light.may_illuminate(Some(*sphere), domain));
            if reaches { power } else { 0.0 }
        };
        let light_powers: Vec<f64> = scene.lights().iter().zip(light_powers(scene)).map(reaching).collect();
        let aim = PhotonAim::new(spheres.iter().copied());
        let aimed = |(i, power): (usize, &f64)| if *power > 0.0 { estimate_aimed_power(scene, &aim, i) } else { 0.0 };
        let aimed: Vec<f64> = light_powers.iter().enumerate().map(aimed).collect();
        let (total, total_aimed) = (light_powers.iter().sum::<f64>(), aimed.iter().sum::<f64>());
        let weight = |(power, aimed): (&f64, &f64)| {
            let plain = power / total;
            // An estimate of zero does not prove that no light reaches a caster.
            if total_aimed > 0.0 {
                DEFENSIVE_FRACTION * plain + (1.0 - DEFENSIVE_FRACTION) * aimed / total_aimed
            } else {
                plain
            }
        };
        let light_distribution =
            if total > 0.0 { DiscreteDistribution::new(light_powers.iter().zip(&aimed).map(weight)) } else { None };
        let effects = effects_of_scene(scene);
        light_distribution.map(|light_distribution| Self {
            scene,
            light_distribution,
            aim: Some(aim),
            guiding: Vec::new(),
            effects,
        })
    }

    /// Returns the source without the environment light; `None` if no other light has power.
    #[must_use]
    pub fn without_environment(self) -> Option<Self> {
        // Recomputed probabilities would differ by rounding.
        let Some(environment) = self.scene.environment_light_index() else { return Some(self) };
        let weight = |i| if i == environment { 0.0 } else { f64::from(self.light_distribution.probability(i)) };
        let light_distribution = DiscreteDistribution::new((0..self.scene.lights().len()).map(weight))?;
        Some(Self { light_distribution, ..self })
    }

    /// Returns the source for `scene`, which is the same scene at another shutter time.
    ///
    /// An aimed source then aims at the caster positions of that time.
    #[must_use]
    pub fn for_scene_at_time<'b>(&self, scene: &'b Scene) -> PhotonSource<'b> {
        let spheres = if self.aim.is_some() { scene.caster_bounding_spheres() } else { None };
        let aim = spheres.map(PhotonAim::new);
        let (light_distribution, guiding) = (self.light_distribution.clone(), self.guiding.clone());
        PhotonSource { scene, light_distribution, aim, guiding, ..*self }
    }

    /// Returns the source with photon paths that simulate `effects`.
    #[must_use]
    pub fn with_effects(self, effects: Effects) -> Self {
        Self { effects, ..self }
    }

    /// Kind of interior (nested bodies, medium, wavelength) that the photon paths must track.
    pub(super) fn interior_kind(&self) -> InteriorKind {
        self.effects.interior_kind()
    }

    /// Lights of the scene. Their mean radiance replaces emission textures if textures are not
    /// simulated.
    pub(super) fn lights(&self) -> &'a [Light] {
        if self.effects.has(Effect::Textures) { self.scene.lights() } else { self.scene.mean_emission_lights() }
    }

    /// Starts photon path `index` of `paths`; returns its ray and flux \[W], `None` without flux.
    ///
    /// Lights are chosen by systematic sampling over path indices. Positions and directions are
    /// Sobol' points, scrambled with `pass_key`.
    #[must_use]
    pub fn emit_photon_path<I: Interior>(&self, pass_key: Key, index: u32, paths: u32) -> Option<(PathRay<I>, Rgb)> {
        let point = self.primary_emission_sample(pass_key, index, paths);
        let (ray, flux) = self.start_photon_path(&point)?;
        Some((ray, flux / (point.probability * paths as f32 * point.pdf)))
    }

    /// Samples light, position and direction of photon path `index` of `paths`.
    #[inline]
    pub(super) fn primary_emission_sample(&self, pass_key: Key, index: u32, paths: u32) -> PrimaryEmissionSample {
        let u = (f64::from(index) + f64::from(pass_key.uniform_1d(Dimension::Light))) / f64::from(paths);
        let (light, probability) = self.light_distribution.sample((u as f32).min(1.0 - f32::EPSILON / 2.0));
        let position = sobol_2d(index, pass_key, Dimension::LightPosition);
        let direction = sobol_2d(index, pass_key, Dimension::LightDirection);
        let (position, direction, pdf) = match self.guiding.get(light) {
            Some(Some(distribution)) => distribution.sample(position, direction),
            Some(None) | None => (position, direction, 1.0),
        };
        PrimaryEmissionSample { light, probability, position, direction, pdf }
    }

    /// Starts the photon path of a primary sample; returns its ray and flux \[W].
    ///
    /// The flux is not divided by the probability of the light, the guiding pdf or the number of
    /// paths.
    #[inline]
    pub(super) fn start_photon_path<I: Interior>(&self, point: &PrimaryEmissionSample) -> Option<(PathRay<I>, Rgb)> {
        let light = &self.lights()[point.light];
        let domain = self.scene.photon_domain();
        let emission = match &self.aim {
            Some(aim) => light.sample_le_towards(aim, domain, point.position, point.direction),
            None => light.sample_le(domain, point.position, point.direction),
        }?;
        let ray = match (light.is_infinite(), light.is_delta()) {
            (true, _) => self.scene.move_origin_beyond_planes(emission.ray),
            // A delta light at a position.
            (false, true) => {
                Ray { origin: emission.ray.at(self.scene.light_contact_distance(point.light)), ..emission.ray }
            }
            // An emitting surface.
            (false, false) => emission.ray,
        };
        Some((self.scene.start_light_path(point.light, ray, self.effects), emission.flux))
    }
}

/// All effects, without [`Effect::Interiors`] if no object of `scene` has an interior.
fn effects_of_scene(scene: &Scene) -> Effects {
    if scene.has_interiors() { Effects::ALL } else { Effects::ALL.without_effect(Effect::Interiors) }
}

/// Power of each light \[W], averaged over RGB.
fn light_powers(scene: &Scene) -> impl Iterator<Item = f64> {
    scene.lights().iter().map(|light| f64::from(color::channel_mean(light.power(scene.photon_domain()))))
}

/// Estimated power of a light towards the spheres of `aim` \[W], averaged over RGB.
fn estimate_aimed_power(scene: &Scene, aim: &PhotonAim, light: usize) -> f64 {
    let key = Key::new(0).purpose_key(Purpose::LightWeights).light_key(light);
    let flux = |i| {
        let (position, direction) =
            (sobol_2d(i, key, Dimension::LightPosition), sobol_2d(i, key, Dimension::LightDirection));
        let emission = scene.lights()[light].sample_le_towards(aim, scene.photon_domain(), position, direction);
        emission.map_or(0.0, |e| f64::from(color::channel_mean(e.flux)))
    };
    (0..POWER_SAMPLES).map(flux).sum::<f64>() / f64::from(POWER_SAMPLES)
}

#[cfg(test)]
mod tests;
