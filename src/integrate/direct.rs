//! Direct light by shadow rays.

mod scattered;

pub(super) use scattered::Scattering;

use super::eye::Last;
use super::method::{History, Vertex};
use super::tiles::Worker;
use crate::color::Rgb;
use crate::light::{DirectSample, Light, LightBvhSampler, ShadowTarget};
use crate::plan::{Effect, Effects};
use crate::sampling::Dimension;
use crate::scene::{Interior, Scene};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// How light is sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asking {
    /// So many shadow rays a point.
    Sampled(u32),
    /// One shadow ray a point, but one for each of a few lights where the walk has met no receiver before.
    Walk,
    /// One shadow ray to the middle of every light.
    Middles,
}

/// The middle of a light.
const MIDDLE: Vec2 = Vec2::splat(0.5);

/// Up to so many lights are few.
const FEW: usize = 4;

/// Which lights are asked at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scheme {
    /// All, with so many rays each.
    All(u32),
    /// So many, chosen by chance.
    Chosen(u32),
}

/// The lights, ready to be asked.
#[derive(Debug)]
pub(super) struct DirectLight<'a> {
    scene: &'a Scene,
    lights: &'a [Light],
    effects: Effects,
    /// Whether some bodies let shadow rays in.
    clear: bool,
    /// Whether lights are asked at their middles.
    middles: bool,
    /// Where lights are chosen.
    choice: Option<LightBvhSampler>,
    /// Before the first receiver, and after it.
    schemes: [Scheme; 2],
}

/// The density of a direction in another technique.
type Pdf<'f> = dyn Fn(Vec3, &mut Worker) -> f32 + 'f;

impl<'a> DirectLight<'a> {
    pub fn new(scene: &'a Scene, asking: Asking, effects: Effects) -> Self {
        // What stands for a whole light is its mean.
        let middles = asking == Asking::Middles || !effects.has(Effect::SoftShadows);
        let all = if middles || !effects.has(Effect::Textures) { scene.mean_lights() } else { scene.lights() };
        let sky = scene.environment().filter(|_| !effects.has(Effect::Environment));
        // The environment is the last of the lights.
        let lights = &all[..sky.unwrap_or(all.len())];
        let sampled = |n: u32| {
            let surfaces = if middles { 1 } else { lights.iter().filter(|l| !l.is_delta()).count() as u32 };
            if lights.len() > n as usize { Scheme::Chosen(n) } else { Scheme::All((n / surfaces.max(1)).max(1)) }
        };
        let schemes = match asking {
            Asking::Middles => [Scheme::All(1); 2],
            Asking::Sampled(n) => [sampled(n); 2],
            Asking::Walk if lights.len() <= FEW => [Scheme::All(1), sampled(1)],
            Asking::Walk => [sampled(1); 2],
        };
        let choice = if schemes.iter().any(|s| matches!(s, Scheme::Chosen(_))) {
            LightBvhSampler::new(lights, scene.domain())
        } else {
            None
        };
        let clear = scene.bodies().any(|body| body.clear);
        Self { scene, lights, effects, clear, middles, choice, schemes }
    }

    fn scheme(&self, history: History) -> Scheme {
        self.schemes[usize::from(history.receivers > 0)]
    }

    /// Radiance that the surface sends to its viewer by light that comes straight from the lights; unbiased. Where the walk goes
    /// on and may meet a light by chance, `other` is the density of that.
    pub fn reflected<I: Interior>(&self, vertex: &Vertex<'_, I>, other: Option<&Pdf<'_>>, worker: &mut Worker) -> Rgb {
        let each = match (self.scheme(vertex.history), &self.choice) {
            (Scheme::All(rays), _) => rays,
            (Scheme::Chosen(rays), Some(choice)) => return self.chosen(choice, rays, vertex, other, worker),
            (Scheme::Chosen(_), None) => return Rgb::ZERO,
        };
        let mut sum = Rgb::ZERO;
        for (i, light) in self.lights.iter().enumerate() {
            let rays = if !light.is_delta() && !self.middles { each } else { 1 };
            let draw = vertex.shadow_draw.with(i as u64);
            for ray in 0..rays {
                // A net spreads the rays over the light.
                let u = if self.middles { MIDDLE } else { draw.of(ray, rays).get_2d(Dimension::LightPosition) };
                sum += self.from(i, vertex, u, rays as f32, other, worker);
            }
        }
        sum
    }

    fn chosen<I: Interior>(
        &self,
        choice: &LightBvhSampler,
        rays: u32,
        vertex: &Vertex<'_, I>,
        other: Option<&Pdf<'_>>,
        worker: &mut Worker,
    ) -> Rgb {
        let point = &vertex.surface.point;
        let mut sum = Rgb::ZERO;
        // One uniform number over equal strata: no light is asked more often than it deserves, rounded up.
        let start = vertex.shadow_draw.get_1d(Dimension::Light);
        for i in 0..rays {
            let u = ((i as f32 + start) / rays as f32).min(1.0 - f32::EPSILON / 2.0);
            let Some((light, probability, _)) = choice.sample(point.p, vertex.horizon(), u) else { continue };
            let draw = vertex.shadow_draw.with(u64::from(i));
            let u = if self.middles { MIDDLE } else { draw.get_2d(Dimension::LightPosition) };
            sum += self.from(light, vertex, u, probability * rays as f32, other, worker);
        }
        sum
    }

    /// Expected density with which light `light` is asked along unit `wi` from the point of `last`, in rays per steradian.
    #[inline]
    pub fn density(&self, last: &Last, light: usize, wi: Vec3, seen: Option<&SurfacePoint>) -> f32 {
        let rays = match (self.scheme(last.history), &self.choice) {
            (Scheme::All(rays), _) => rays as f32,
            (Scheme::Chosen(rays), Some(choice)) => choice.probability(last.p, last.horizon, light) * rays as f32,
            (Scheme::Chosen(_), None) => 0.0,
        };
        rays * self.lights[light].pdf_li(last.p, wi, seen)
    }

    /// One shadow ray of `rays` to light `light`.
    #[inline]
    fn from<I: Interior>(
        &self,
        light: usize,
        vertex: &Vertex<'_, I>,
        u: Vec2,
        rays: f32,
        other: Option<&Pdf<'_>>,
        worker: &mut Worker,
    ) -> Rgb {
        let surface = vertex.surface;
        let Some(sample) = self.lights[light].sample_li(surface.point.p, u) else {
            return Rgb::ZERO;
        };
        let mut reflected = surface.scatter(sample.wi) * sample.weight / rays;
        if reflected == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if let (Some(other), Some(pdf), false) = (other, sample.pdf, self.middles) {
            let asked = rays * pdf;
            reflected *= asked / (asked + other(sample.wi, worker));
        }
        if !self.effects.has(Effect::Shadows) {
            return reflected * self.left(vertex, &sample);
        }
        worker.counters.shadow_rays += 1;
        let ray = match sample.target {
            ShadowTarget::Point(target) => {
                surface.segment_to(self.end(light, &sample, target, surface.point.p), sample.wi)
            }
            ShadowTarget::Infinity => surface.leave(sample.wi),
        };
        if self.scene.occluded(&ray) {
            return if self.clear { reflected * self.shadow_transmittance(light, vertex, &sample) } else { Rgb::ZERO };
        }
        reflected * self.left(vertex, &sample)
    }

    /// Where a shadow ray from `p` to a sample ends: short of a light without a surface, which may stand in that of something else.
    #[inline]
    fn end(&self, light: usize, sample: &DirectSample, target: Vec3, p: Vec3) -> Vec3 {
        if sample.pdf.is_some() {
            return target;
        }
        target - sample.wi * self.scene.light_contact(light).min(0.5 * (target - p).length())
    }

    /// The same where something is in the way, which may be clear.
    fn shadow_transmittance<I: Interior>(&self, light: usize, vertex: &Vertex<'_, I>, sample: &DirectSample) -> Rgb {
        let walk = vertex.leaving(sample.wi);
        let ray = match sample.target {
            ShadowTarget::Point(target) => {
                vertex.surface.segment_to(self.end(light, sample, target, vertex.surface.point.p), sample.wi)
            }
            ShadowTarget::Infinity => walk.ray,
        };
        self.scene.shadow_transmittance(&ray, walk.inside, vertex.shadow_draw.key())
    }

    /// Part of the light that is left after its way from a light.
    #[inline]
    fn left<I: Interior>(&self, vertex: &Vertex<'_, I>, sample: &DirectSample) -> Rgb {
        match sample.target {
            ShadowTarget::Point(target) => {
                vertex.transmittance(self.scene, sample.wi, (target - vertex.surface.point.p).length())
            }
            ShadowTarget::Infinity if I::IMMERSED => vertex.transmittance(self.scene, sample.wi, f32::INFINITY),
            ShadowTarget::Infinity => Rgb::ONE,
        }
    }
}
