//! Direct light by shadow rays.

use super::tiles::Worker;
use crate::color::{self, Rgb};
use crate::light::Reach;
use crate::sampling::{Dimension, Discrete, Key};
use crate::scene::{Scene, Surface};

/// Up to so many lights are all asked; of more, so many are chosen in proportion to their power.
const ASKED: usize = 4;

/// The lights, ready to be asked.
#[derive(Debug)]
pub(super) struct DirectLight<'a> {
    scene: &'a Scene,
    choice: Option<Discrete>,
}

impl<'a> DirectLight<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let choice = (scene.lights().len() > ASKED)
            .then(|| Discrete::new(scene.lights().iter().map(|l| f64::from(color::mean(l.power(scene.domain()))))))
            .flatten();
        Self { scene, choice }
    }

    /// Radiance that the surface sends to its viewer by light that comes straight from the lights: unbiased, one shadow ray a
    /// light asked.
    pub fn reflected(&self, surface: &Surface<'_>, key: Key, worker: &mut Worker) -> Rgb {
        match &self.choice {
            None => (0..self.scene.lights().len()).map(|i| self.from(i, surface, key.with(i as u64), worker)).sum(),
            Some(choice) => {
                // One uniform number spread over equal strata: no light is asked more often than it deserves, rounded up.
                let start = key.uniform(Dimension::Light);
                let strata = 0..ASKED;
                let ask = |i: usize| {
                    let (light, probability) = choice.sample((i as f32 + start) / ASKED as f32);
                    self.from(light, surface, key.with(i as u64), worker) / (probability * ASKED as f32)
                };
                strata.map(ask).sum()
            }
        }
    }

    fn from(&self, light: usize, surface: &Surface<'_>, key: Key, worker: &mut Worker) -> Rgb {
        let u = key.uniform_2d(Dimension::LightPosition);
        let Some(sample) = self.scene.lights()[light].sample_direct(surface.point.p, u) else {
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
