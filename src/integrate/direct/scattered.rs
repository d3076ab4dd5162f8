//! Light of the lights that a medium scatters once, along a stretch of a walk.

use super::{DirectLight, MIDDLE, Scheme};
use crate::color::Rgb;
use crate::integrate::method::History;
use crate::integrate::tiles::Worker;
use crate::light::ShadowTarget;
use crate::math::Ray;
use crate::medium::DistanceSample;
use crate::plan::Effect;
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Interior, MediumSegment};
use glam::{Vec2, Vec3};

/// A stretch along which light is scattered to its start.
pub(in crate::integrate) struct Scattering<'a, I> {
    pub stretch: &'a MediumSegment<'a, I>,
    /// Of the walk where the stretch begins.
    pub throughput: Rgb,
    /// Where the walk would be scattered.
    pub distance_sample: &'a DistanceSample,
    pub history: History,
    /// Whether the walk goes on from where it is scattered, and may meet a light by chance.
    pub onward: bool,
    pub shadow_draw: Sampler,
}

/// A point of a stretch.
struct Place {
    p: Vec3,
    /// What is scattered there, of the light that arrives, on its way to the start of the stretch, over the density of the place.
    weight: Rgb,
}

impl DirectLight<'_> {
    /// Radiance that a medium sends to the start of a stretch by light that comes straight from the lights; unbiased.
    ///
    /// Of what chance could find too, only the part that directions of light are sampled for, by the balance heuristic over
    /// directions.
    pub fn scattered<I: Interior>(&self, scattering: &Scattering<'_, I>, worker: &mut Worker) -> Rgb {
        let flown = || {
            let t = scattering.distance_sample.scattered?;
            Some(Place { p: scattering.stretch.ray.at(t), weight: scattering.distance_sample.weight })
        };
        let mut sum = Rgb::ZERO;
        match (self.scheme(scattering.history), &self.choice) {
            (Scheme::All(rays), _) => {
                for (i, light) in self.lights.iter().enumerate() {
                    let rays = if !light.is_delta() && !self.middles { rays } else { 1 };
                    let draw = scattering.shadow_draw.with(i as u64);
                    for ray in 0..rays {
                        let draw = draw.of(ray, rays);
                        let pivot = light.emission_point().filter(|_| scattering.stretch.medium.is_homogeneous());
                        let place = pivot.map_or_else(flown, |pivot| scattering.near(pivot, draw));
                        if let Some(place) = place {
                            sum += self.scattered_at(&place, i, scattering, draw, rays as f32, worker);
                        }
                    }
                }
            }
            (Scheme::Chosen(rays), Some(choice)) => {
                let Some(place) = flown() else { return Rgb::ZERO };
                let start = scattering.shadow_draw.get_1d(Dimension::Light);
                for i in 0..rays {
                    let u = ((i as f32 + start) / rays as f32).min(1.0 - f32::EPSILON / 2.0);
                    let Some((light, probability, _)) = choice.sample(place.p, None, u) else { continue };
                    let draw = scattering.shadow_draw.with(u64::from(i));
                    let rays = probability * rays as f32;
                    sum += self.scattered_at(&place, light, scattering, draw, rays, worker);
                }
            }
            (Scheme::Chosen(_), None) => {}
        }
        sum
    }

    fn scattered_at<I: Interior>(
        &self,
        place: &Place,
        light: usize,
        scattering: &Scattering<'_, I>,
        draw: Sampler,
        rays: f32,
        worker: &mut Worker,
    ) -> Rgb {
        let stretch = scattering.stretch;
        let u = if self.middles { MIDDLE } else { draw.get_2d(Dimension::LightPosition) };
        let Some(sample) = self.lights[light].sample_li(place.p, u) else { return Rgb::ZERO };
        // Light travels against `wi`, and then against the walk.
        let phase = stretch.medium.phase.evaluate(stretch.ray.direction.dot(sample.wi));
        let mut found = place.weight * sample.weight * (phase / rays);
        if found == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if let (true, Some(pdf), false) = (scattering.onward, sample.pdf, self.middles) {
            let asked = rays * pdf;
            found *= asked / (asked + phase);
        }
        let (ray, t_max) = match sample.target {
            ShadowTarget::Point(target) => {
                (Ray::between(place.p, self.end(light, &sample, target, place.p)), (target - place.p).length())
            }
            ShadowTarget::Infinity => (Ray::new(place.p, sample.wi), f32::INFINITY),
        };
        if self.effects.has(Effect::Shadows) {
            worker.counters.shadow_rays += 1;
            if self.scene.occluded(&ray) {
                return if self.clear {
                    found * self.scene.shadow_transmittance(&ray, stretch.inside, draw.key())
                } else {
                    Rgb::ZERO
                };
            }
        }
        let ray = Ray { t_max, ..Ray::new(place.p, sample.wi) };
        found * self.scene.dimming(&ray, &stretch.inside, draw.key())
    }
}

impl<I: Interior> Scattering<'_, I> {
    /// A place in a homogeneous medium, drawn in equal parts as the walk would be scattered and by the angle under which `pivot` sees the
    /// stretch (Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in participating media").
    fn near(&self, pivot: Vec3, draw: Sampler) -> Option<Place> {
        let MediumSegment { ray, medium, .. } = self.stretch;
        // Shadow rays from the place have the numbers of the key itself.
        let mut rng = draw.key().with(1).rng();
        let angles = Angles::new(ray, pivot);
        let Vec2 { x: which, y: u } = draw.get_2d(Dimension::Medium);
        let t = if which < 0.5 {
            medium.distance_sample(ray, ray.t_max, self.throughput, &mut rng).scattered?
        } else {
            angles.sample(u)
        };
        let pdf = 0.5 * (medium.distance_pdf(t, self.throughput)? + angles.pdf(t));
        if !(t >= 0.0 && t <= ray.t_max && pdf > 0.0) {
            return None;
        }
        let left = medium.transmittance(ray, t, &mut rng);
        Some(Place { p: ray.at(t), weight: left * medium.scattering / pdf })
    }
}

/// The angles under which a point sees a ray.
struct Angles {
    /// Where the ray is nearest to the point.
    nearest: f32,
    /// How near that is.
    distance: f32,
    from: f32,
    to: f32,
}

impl Angles {
    fn new(ray: &Ray, pivot: Vec3) -> Self {
        let to = pivot - ray.origin;
        let nearest = to.dot(ray.direction);
        // Any distance above zero is unbiased; one below rounding would lose the rest of the ray.
        let distance = (to - ray.direction * nearest).length().max(1e-5 * to.length()).max(f32::MIN_POSITIVE);
        let angle = |t: f32| libm::atanf((t - nearest) / distance);
        Self { nearest, distance, from: angle(0.0), to: angle(ray.t_max) }
    }

    fn sample(&self, u: f32) -> f32 {
        self.nearest + self.distance * libm::tanf(self.from + (self.to - self.from) * u)
    }

    fn pdf(&self, t: f32) -> f32 {
        let x = (t - self.nearest) / self.distance;
        let range = self.to - self.from;
        if range > 0.0 { 1.0 / (self.distance * (1.0 + x * x) * range) } else { 0.0 }
    }
}
