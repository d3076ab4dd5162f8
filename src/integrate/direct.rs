//! Direct light by shadow rays.

use super::eye::Vertex;
use super::tiles::Worker;
use crate::color::Rgb;
use crate::light::{Light, LightChoice, Reach};
use crate::sampling::Dimension;
use crate::scene::Scene;
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// How light is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asking {
    /// So many shadow rays a point: up to so many lights are all asked, of more, so many are chosen.
    Sampled(u32),
    /// One shadow ray to the middle of every light.
    Middles,
}

/// The lights, ready to be asked.
#[derive(Debug)]
pub(super) struct DirectLight<'a> {
    scene: &'a Scene,
    asking: Asking,
    /// Where lights are chosen.
    choice: Option<LightChoice>,
    /// Shadow rays to a light that is seen under a solid angle, where all lights are asked.
    rays: u32,
}

/// The density of a direction in another technique.
type Pdf<'f> = dyn Fn(Vec3, &mut Worker) -> f32 + 'f;

impl<'a> DirectLight<'a> {
    pub fn new(scene: &'a Scene, asking: Asking) -> Self {
        let lights = scene.lights();
        let (choice, rays) = match asking {
            Asking::Middles => (None, 1),
            Asking::Sampled(n) if lights.len() > n as usize => (LightChoice::new(lights, scene.domain()), n),
            Asking::Sampled(n) => {
                let surfaces = lights.iter().filter(|l| l.has_surface()).count() as u32;
                (None, (n / surfaces.max(1)).max(1))
            }
        };
        Self { scene, asking, choice, rays }
    }

    /// Radiance that the surface sends to its viewer by light that comes straight from the lights; unbiased. Where the walk goes
    /// on and may meet a light by chance, `other` is the density of that.
    pub fn reflected(&self, vertex: &Vertex<'_>, other: Option<&Pdf<'_>>, worker: &mut Worker) -> Rgb {
        if let Some(choice) = &self.choice {
            return self.chosen(choice, vertex, other, worker);
        }
        let mut sum = Rgb::ZERO;
        for (i, light) in self.scene.lights().iter().enumerate() {
            let rays = if light.has_surface() { self.rays } else { 1 };
            let draw = vertex.shadow_draw.with(i as u64);
            for ray in 0..rays {
                let u = match self.asking {
                    Asking::Middles => Vec2::splat(0.5),
                    // A net spreads the rays over the light.
                    Asking::Sampled(_) => draw.of(ray, rays).two(Dimension::LightPosition),
                };
                sum += self.from(light, vertex, u, rays as f32, other, worker);
            }
        }
        sum
    }

    fn chosen(&self, choice: &LightChoice, vertex: &Vertex<'_>, other: Option<&Pdf<'_>>, worker: &mut Worker) -> Rgb {
        let point = &vertex.surface.point;
        let mut sum = Rgb::ZERO;
        // One uniform number over equal strata: no light is asked more often than it deserves, rounded up.
        let start = vertex.shadow_draw.one(Dimension::Light);
        for i in 0..self.rays {
            let u = ((i as f32 + start) / self.rays as f32).min(1.0 - f32::EPSILON / 2.0);
            let Some((light, probability, _)) = choice.choose(point.p, vertex.horizon(), u) else { continue };
            let u = vertex.shadow_draw.with(u64::from(i)).two(Dimension::LightPosition);
            let rays = probability * self.rays as f32;
            sum += self.from(&self.scene.lights()[light], vertex, u, rays, other, worker);
        }
        sum
    }

    /// Expected density with which light `light` is asked along unit `wi` from `p`, in rays per steradian.
    #[inline]
    pub fn density(&self, p: Vec3, horizon: Option<Vec3>, light: usize, wi: Vec3, seen: Option<&SurfacePoint>) -> f32 {
        let rays = match &self.choice {
            Some(choice) => choice.probability(p, horizon, light) * self.rays as f32,
            None => self.rays as f32,
        };
        rays * self.scene.lights()[light].density(p, wi, seen)
    }

    /// One shadow ray of `rays`.
    #[inline]
    fn from(
        &self,
        light: &Light,
        vertex: &Vertex<'_>,
        u: Vec2,
        rays: f32,
        other: Option<&Pdf<'_>>,
        worker: &mut Worker,
    ) -> Rgb {
        let surface = vertex.surface;
        let Some(sample) = light.sample_direct(surface.point.p, u) else {
            return Rgb::ZERO;
        };
        let mut reflected = surface.scatter(sample.wi) * sample.irradiance / rays;
        if reflected == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if let (Some(other), Some(pdf)) = (other, sample.pdf) {
            let asked = rays * pdf;
            reflected *= asked / (asked + other(sample.wi, worker));
        }
        worker.counters.shadow_rays += 1;
        let ray = match sample.reach {
            Reach::Point(target) => surface.segment_to(target, sample.wi),
            Reach::Infinity => surface.leave(sample.wi),
        };
        if self.scene.occluded(&ray) {
            return Rgb::ZERO;
        }
        match sample.reach {
            Reach::Point(target) => {
                reflected * vertex.transmittance(self.scene, sample.wi, (target - surface.point.p).length())
            }
            Reach::Infinity => reflected,
        }
    }
}
