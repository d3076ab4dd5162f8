//! Emission of photon paths: samples a light, a position and a direction.
//!
//! The integrator `hybrid` needs no photons for direct light: it samples lights by
//! [`Light::sample_li`] at each surface point.

use super::guiding::EmissionGuidingDistribution;
use crate::color::{self, Rgb};
use crate::light::{Light, PhotonAim};
use crate::math::Ray;
use crate::sampling::{Dimension, DiscreteDistribution, Key, Purpose, sobol_2d};
use crate::scene::{Effect, Effects, Interior, InteriorKind, PathRay, Scene};
use glam::Vec2;

/// Number of emission samples from which the power of each light towards casters is estimated.
/// Casters are the surfaces that cast caustics.
const POWER_SAMPLES: u32 = 256;

/// Weight of the lights' total powers in the selection of lights, for photon paths that are aimed
/// at casters (defensive sampling). Casters are the surfaces that cast caustics.
///
/// Light i is selected with the probability 0.1·Pᵢ/ΣP + 0.9·Aᵢ/ΣA, where P is the total power, and
/// A the estimated power towards the casters. If A is wrongly estimated as 0, the light still has a
/// probability above 0.
const DEFENSIVE_FRACTION: f64 = 0.1;

/// Source of photon paths. For each path, it samples a light of the scene and the ray that leaves
/// this light.
#[derive(Clone, Debug)]
pub struct PhotonSource<'a> {
    pub(super) scene: &'a Scene,
    /// Discrete distribution from which the light of a photon path is sampled.
    pub(super) light_distribution: DiscreteDistribution,
    /// Bounding spheres of the [casters](super::PhotonKind), such as glass and mirrors, towards
    /// which photons are emitted; `None` if photons are emitted in all directions.
    aim: Option<PhotonAim>,
    /// Pdfs by which emission guiding samples the position and the direction of emitted photons,
    /// one for each light. `None` stands for a light whose positions and directions are not guided.
    /// The list is empty without emission guiding.
    pub(super) guiding: Vec<Option<EmissionGuidingDistribution>>,
    /// Parts of light transport that photon paths simulate, such as textures or media.
    effects: Effects,
}

/// A sampled light, with the random numbers that determine position and direction of the emitted
/// ray.
///
/// These numbers in \[0, 1)⁴ are called primary samples (Kelemen et al. 2002).
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimaryEmissionSample {
    /// Index of the sampled light in [`Scene::lights`].
    pub light: usize,
    /// Probability with which the source samples light number `light`.
    pub light_probability: f32,
    /// Primary sample in \[0, 1)² that determines the position on the light.
    pub position_sample: Vec2,
    /// Primary sample in \[0, 1)² that determines the emitted direction.
    pub direction_sample: Vec2,
    /// Joint pdf of `position_sample` and `direction_sample` over \[0, 1)⁴. Without emission
    /// guiding, the pdf is 1, because both samples are uniform.
    pub pdf: f32,
}

impl<'a> PhotonSource<'a> {
    /// Creates a source that emits from all lights, in all directions of each light; `None` if no
    /// light has power.
    ///
    /// Lights are chosen in proportion to their power.
    #[must_use]
    pub fn emitting_in_all_directions(scene: &'a Scene) -> Option<Self> {
        let light_distribution = DiscreteDistribution::new(light_powers(scene))?;
        let effects = effects_of_scene(scene);
        Some(Self { scene, light_distribution, aim: None, guiding: Vec::new(), effects })
    }

    /// Creates a source that emits only towards the bounding spheres of
    /// [casters](super::PhotonKind), such as glass and mirrors.
    ///
    /// The light of a path is chosen mainly by the power of each light towards the spheres, which
    /// is estimated by sampling. If a caster is unbounded, the source emits in all directions.
    ///
    /// Returns `None` if no light can reach a caster. If the scene has motion, or a caster is
    /// unbounded, returns `None` only if no light has power.
    #[must_use]
    pub fn aimed_at_casters(scene: &'a Scene) -> Option<Self> {
        let Some(spheres) = scene.caster_bounding_spheres() else {
            return Self::emitting_in_all_directions(scene);
        };
        let domain = scene.photon_domain();
        let reaching = |(light, power): (&Light, f64)| {
            // A light that misses a moving caster at this time may reach it at another shutter
            // time.
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
            // If all estimated powers are zero, light may still reach a caster. Lights are then
            // chosen by their total powers.
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

    /// Returns the source without the environment light, for renders that leave this light out;
    /// `None` if the source samples no other light.
    #[must_use]
    pub fn without_environment_light(self) -> Option<Self> {
        // Recomputing equal probabilities could round them differently, so a source without
        // environment light is returned unchanged.
        let Some(environment) = self.scene.environment_light_index() else { return Some(self) };
        let weight = |i| if i == environment { 0.0 } else { f64::from(self.light_distribution.probability(i)) };
        let light_distribution = DiscreteDistribution::new((0..self.scene.lights().len()).map(weight))?;
        Some(Self { light_distribution, ..self })
    }

    /// Returns a copy of the source for `scene`, which must be this source's scene at another
    /// shutter time.
    ///
    /// A source that is aimed at casters then aims at their positions at that time.
    #[must_use]
    pub fn for_scene_at_time<'b>(&self, scene: &'b Scene) -> PhotonSource<'b> {
        let spheres = if self.aim.is_some() { scene.caster_bounding_spheres() } else { None };
        let aim = spheres.map(PhotonAim::new);
        let (light_distribution, guiding) = (self.light_distribution.clone(), self.guiding.clone());
        PhotonSource { scene, light_distribution, aim, guiding, ..*self }
    }

    /// Returns the source with its photon paths restricted to `effects`, the parts of light
    /// transport to simulate.
    #[must_use]
    pub fn with_effects(self, effects: Effects) -> Self {
        Self { effects, ..self }
    }

    /// Returns the simplest kind of [`Interior`](crate::scene::Interior) that suffices for the
    /// simulated effects. Photon paths carry an `Interior` of this kind along.
    ///
    /// An `Interior` tracks the nested bodies, the medium and the wavelength of a path.
    pub(super) fn interior_kind(&self) -> InteriorKind {
        self.effects.interior_kind()
    }

    /// Lights of the scene, from which photons are emitted. If [`Effect::Textures`] is not
    /// simulated, each light emits the mean radiance of its emission texture.
    pub(super) fn lights(&self) -> &'a [Light] {
        if self.effects.has(Effect::Textures) { self.scene.lights() } else { self.scene.mean_emission_lights() }
    }

    /// Samples a light and a ray from it, for the start of photon path `index` in a pass of `paths`
    /// paths.
    ///
    /// Returns the ray and its flux \[W], or `None` if the sample carries no flux. The flux is
    /// already divided by the probability of the light, by the pdf of the primary samples, and by
    /// `paths`.
    ///
    /// Lights are chosen by systematic sampling over path indices. Positions and directions are
    /// Sobol' points, scrambled with `pass_key`. The wavelengths of each light's paths are
    /// stratified, jointly with the positions and with the directions.
    #[must_use]
    pub fn emit_photon_path<I: Interior>(&self, pass_key: Key, index: u32, paths: u32) -> Option<(PathRay<I>, Rgb)> {
        let point = self.sample_primary_emission(pass_key, index, paths);
        let (mut ray, flux) = self.start_photon_path::<I>(&point)?;
        let wavelength_sample = || self.wavelength_sample(pass_key, index, paths, point.light);
        ray.interior.set_wavelength_sample(self.scene, wavelength_sample);
        Some((ray, flux / (point.light_probability * paths as f32 * point.pdf)))
    }

    /// Samples the light, and the primary samples of position and direction, for photon path
    /// `index` in a pass of `paths` paths.
    #[inline]
    pub(super) fn sample_primary_emission(&self, pass_key: Key, index: u32, paths: u32) -> PrimaryEmissionSample {
        let (light, probability) = self.light_distribution.sample(systematic_light_sample(pass_key, index, paths));
        let position = sobol_2d(index, pass_key, Dimension::LightPosition);
        let direction = sobol_2d(index, pass_key, Dimension::LightDirection);
        let (position, direction, pdf) = match self.guiding.get(light) {
            Some(Some(distribution)) => distribution.sample(position, direction),
            Some(None) | None => (position, direction, 1.0),
        };
        PrimaryEmissionSample {
            light,
            light_probability: probability,
            position_sample: position,
            direction_sample: direction,
            pdf,
        }
    }

    /// Returns the uniform sample in \[0, 1) that selects the wavelength of photon path `index`,
    /// which starts at light number `light`, in a pass of `paths` paths.
    ///
    /// The paths of one light have consecutive indices. From path to path, the sample grows in
    /// equal steps, modulo 1; it starts at a random offset (Cranley and Patterson 1976). So the
    /// paths of each range of wavelengths use consecutive Sobol' points, which fill the unit
    /// squares of positions and of directions evenly.
    fn wavelength_sample(&self, pass_key: Key, index: u32, paths: u32, light: usize) -> f32 {
        let u = systematic_light_sample(pass_key, index, paths);
        (self.light_distribution.remapped_sample(u, light) + pass_key.uniform_1d(Dimension::Wavelength)).fract()
    }

    /// Starts the photon path that the emission sample `point` determines. Returns its ray and its
    /// flux \[W] before division by any probability.
    ///
    /// Returns `None` if the sample carries no flux. The caller must divide the flux by the
    /// probability of the light, the pdf of `point` and the number of paths.
    #[inline]
    pub(super) fn start_photon_path<I: Interior>(&self, point: &PrimaryEmissionSample) -> Option<(PathRay<I>, Rgb)> {
        let light = &self.lights()[point.light];
        let domain = self.scene.photon_domain();
        let emission = match &self.aim {
            Some(aim) => light.sample_le_towards(aim, domain, point.position_sample, point.direction_sample),
            None => light.sample_le(domain, point.position_sample, point.direction_sample),
        }?;
        let ray = match (light.is_infinite(), light.is_delta()) {
            (true, _) => self.scene.move_origin_beyond_planes(emission.ray),
            // A point light may touch a surface, so the ray starts beyond this surface.
            (false, true) => {
                Ray { origin: emission.ray.at(self.scene.light_contact_distance(point.light)), ..emission.ray }
            }
            // The ray of an emitting surface already starts off the surface, beyond rounding
            // errors.
            (false, false) => emission.ray,
        };
        Some((self.scene.start_light_path(point.light, ray, self.effects), emission.weight))
    }
}

/// Returns the uniform sample in \[0, 1) that chooses the light of photon path `index` in a pass of
/// `paths` paths. The sample increases with `index` in equal steps (systematic sampling).
#[inline]
fn systematic_light_sample(pass_key: Key, index: u32, paths: u32) -> f32 {
    let u = (f64::from(index) + f64::from(pass_key.uniform_1d(Dimension::Light))) / f64::from(paths);
    (u as f32).min(1.0 - f32::EPSILON / 2.0)
}

/// Returns the parts of light transport that photon paths in `scene` simulate by default: all,
/// except [`Effect::Interiors`] if no object has an interior.
fn effects_of_scene(scene: &Scene) -> Effects {
    if scene.has_interiors() { Effects::ALL } else { Effects::ALL.without_effect(Effect::Interiors) }
}

/// Iterates over the powers of the lights of `scene` \[W], averaged over RGB.
fn light_powers(scene: &Scene) -> impl Iterator<Item = f64> {
    scene.lights().iter().map(|light| f64::from(color::channel_mean(light.power(scene.photon_domain()))))
}

/// Estimates the power \[W] that the light with index `light` emits towards the spheres of `aim`,
/// averaged over RGB.
fn estimate_aimed_power(scene: &Scene, aim: &PhotonAim, light: usize) -> f64 {
    let key = Key::new(0).purpose_key(Purpose::AimedLightPower).light_power_pilot_key(light);
    let flux = |i| {
        let (position, direction) =
            (sobol_2d(i, key, Dimension::LightPosition), sobol_2d(i, key, Dimension::LightDirection));
        let emission = scene.lights()[light].sample_le_towards(aim, scene.photon_domain(), position, direction);
        emission.map_or(0.0, |e| f64::from(color::channel_mean(e.weight)))
    };
    (0..POWER_SAMPLES).map(flux).sum::<f64>() / f64::from(POWER_SAMPLES)
}

#[cfg(test)]
mod tests;
