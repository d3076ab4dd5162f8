//! Choice of one light among many.

use super::Light;
use crate::color;
use crate::math::Sphere;
use crate::sampling::Discrete;
use glam::Vec3;

/// The lights, chosen by power.
#[derive(Clone, Debug)]
pub struct LightChoice {
    powers: Discrete,
}

impl LightChoice {
    /// `None` where no light has power.
    #[must_use]
    pub fn new(lights: &[Light], domain: Sphere) -> Option<Self> {
        let powers = lights.iter().map(|l| f64::from(color::mean(l.power(domain))));
        Some(Self { powers: Discrete::new(powers)? })
    }

    /// A light, its probability, and what is left of `u`.
    #[must_use]
    pub fn choose(&self, _: Vec3, _: Option<Vec3>, u: f32) -> Option<(usize, f32, f32)> {
        let (light, probability) = self.powers.sample(u);
        Some((light, probability, self.powers.remainder(u, light)))
    }

    /// Probability of a light.
    #[must_use]
    pub fn probability(&self, _: Vec3, _: Option<Vec3>, light: usize) -> f32 {
        self.powers.probability(light)
    }
}
