//! Direct light by shadow rays.

use super::tiles::Worker;
use crate::color::{self, Rgb};
use crate::light::{Light, Reach};
use crate::sampling::{Dimension, Discrete, Key, sobol_2d};
use crate::scene::{Scene, Surface};
use glam::Vec2;

/// Shadow rays a point: up to so many lights are all asked, of more, so many are chosen in proportion to their power.
const ASKED: usize = 4;

/// The lights, ready to be asked.
#[derive(Debug)]
pub(super) struct DirectLight<'a> {
    scene: &'a Scene,
    choice: Option<Discrete>,
    /// Shadow rays to a light that has a surface, where all lights are asked.
    rays: u32,
}

impl<'a> DirectLight<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let lights = scene.lights();
        let powers = lights.iter().map(|l| f64::from(color::mean(l.power(scene.domain()))));
        let choice = if lights.len() > ASKED { Discrete::new(powers) } else { None };
        let surfaces = lights.iter().filter(|l| l.has_surface()).count();
        Self { scene, choice, rays: (ASKED / surfaces.max(1)).max(1) as u32 }
    }

    /// Radiance that the surface sends to its viewer by light that comes straight from the lights; unbiased.
    pub fn reflected(&self, surface: &Surface<'_>, key: Key, worker: &mut Worker) -> Rgb {
        match &self.choice {
            None => {
                let ask = |(i, light): (usize, &Light)| {
                    let rays = if light.has_surface() { self.rays } else { 1 };
                    let key = key.with(i as u64);
                    // A net spreads the rays over the light.
                    let u = |ray| sobol_2d(ray, key, Dimension::LightPosition);
                    (0..rays).map(|ray| self.from(light, surface, u(ray), worker)).sum::<Rgb>() / rays as f32
                };
                self.scene.lights().iter().enumerate().map(ask).sum()
            }
            Some(choice) => {
                // One uniform number over equal strata: no light is asked more often than it deserves, rounded up.
                let start = key.uniform(Dimension::Light);
                let ask = |i: usize| {
                    let (light, probability) = choice.sample((i as f32 + start) / ASKED as f32);
                    let u = key.with(i as u64).uniform_2d(Dimension::LightPosition);
                    self.from(&self.scene.lights()[light], surface, u, worker) / (probability * ASKED as f32)
                };
                (0..ASKED).map(ask).sum()
            }
        }
    }

    fn from(&self, light: &Light, surface: &Surface<'_>, u: Vec2, worker: &mut Worker) -> Rgb {
        let Some(sample) = light.sample_direct(surface.point.p, u) else {
            return Rgb::ZERO;
        };
        let reflected = surface.scatter(sample.wi) * sample.irradiance;
        if reflected == Rgb::ZERO {
            return Rgb::ZERO;
        }
        worker.counters.shadow_rays += 1;
        let ray = match sample.reach {
            Reach::Point(target) => surface.segment_to(target, sample.wi),
            Reach::Infinity => surface.leave(sample.wi),
        };
        if self.scene.occluded(&ray) { Rgb::ZERO } else { reflected }
    }
}
