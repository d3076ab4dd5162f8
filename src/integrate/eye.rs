//! The walk of a camera ray: the one loop behind every method.
//!
//! Surfaces are *casters* (mirrors, glass, narrow lobes), *receivers* (they store photons) or black. A light's path to the eye
//! is carried by photons where it begins with casters and then meets a receiver: no connection finds it. What a method leaves
//! to photons, its walk does not count when it meets a light by chance, so that each path counts once.

mod media;

use super::direct::DirectLight;
use super::method::{AtReceiver, History, Method, Vertex};
use super::tiles::{self, Worker};
use super::{EyeSettings, Monitor, Pass, Silent};
use crate::bsdf::{Bsdf, Transport};
use crate::color::{self, Rgb};
use crate::math::Ray;
use crate::medium::PhaseFunction;
use crate::plan::{Effect, Effects};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{
    Interior, InteriorKind, InteriorStack, NoInterior, PathEvent, PathRay, Scene, SpectralInterior, SurfaceInteraction,
    SurfaceVertex,
};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::time::Instant;

/// A branch at a smooth dielectric that is weaker than this part of the pixel is followed by chance only.
const WORTH_SPLITTING: f32 = 0.001;

/// A walk that counts for less than this part of the pixel goes on by chance only. Roulette that begins earlier costs more noise
/// than it saves time: see docs/decisions/.
const CERTAIN: f32 = 0.125;

/// Points of the film a chunk, where they are few.
const CHUNK: usize = 64;

/// Branches that may wait at once.
const BRANCHES: usize = 16;

/// Where passes share their camera walks, about so many tiles are walked anew in each, to tell what is amiss with those that stay.
const FRESH: u32 = 48;

/// After so many casters a walk goes on with the probability of its throughput.
const CERTAIN_CASTERS: u32 = 8;

/// The camera walks of a pass.
pub(super) struct EyePass<'a, M> {
    pub scene: &'a Scene,
    pub effects: Effects,
    pub settings: &'a EyeSettings,
    pub direct: &'a DirectLight<'a>,
    pub method: &'a M,
    /// Camera rays a pixel.
    pub samples: u32,
    /// How many each pixel gets, in parts of that.
    pub density: Option<&'a [f32]>,
    pub pass: u32,
}

/// A camera walk that waits to be continued.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch<I> {
    walk: PathRay<I>,
    throughput: Rgb,
    bounce: u32,
    history: History,
    /// Where a connection could have been made instead, and the density of the direction that was taken from there.
    last: Option<Last>,
    draw: Sampler,
}

/// The last vertex, where it was not a delta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Last {
    pub p: Vec3,
    pub horizon: Option<Vec3>,
    /// What the walk had met before it.
    pub history: History,
    pdf: f32,
}

/// What follows a step.
enum Next<I> {
    /// The branch itself.
    One,
    /// The branch, and another one.
    Both(Branch<I>),
}

impl<M: Method> EyePass<'_, M> {
    /// Renders all pixels into `out`.
    pub fn run(&self, monitor: &dyn Monitor, out: &mut Pass) {
        match self.effects.interior_kind() {
            InteriorKind::Spectral => self.run_in::<SpectralInterior>(monitor, out),
            InteriorKind::Bodies => self.run_in::<InteriorStack>(monitor, out),
            InteriorKind::Nothing => self.run_in::<NoInterior>(monitor, out),
        }
    }

    fn run_in<I: Interior>(&self, monitor: &dyn Monitor, out: &mut Pass) {
        let start = Instant::now();
        let (camera, filter) = (self.scene.camera(), Some(&self.settings.filter));
        let lens = self.effects.has(Effect::Lens);
        let gauge = self.settings.gauge && self.method.estimates();
        let (samples, density) = (self.samples, self.density);
        let mut sampling = tiles::Sampling { camera, filter, samples, lens, density, gauge, every: 1 };
        let repeats = self.method.repeats_walks();
        let key = Key::new(self.settings.seed).purpose(Purpose::Camera);
        let render = |sampling: &tiles::Sampling<'_>, walks: u64, monitor: &dyn Monitor| {
            tiles::render(sampling, key.with(walks), monitor, |ray, draw, worker, waiting: &mut Vec<Branch<I>>| {
                self.radiance(ray, draw, worker, waiting)
            })
        };
        let rendered = render(&sampling, if repeats { 0 } else { u64::from(self.pass) }, monitor);
        (out.image, out.gauged) = (rendered.image, rendered.gauged);
        out.counters += rendered.counters;
        if gauge && repeats {
            sampling = tiles::Sampling { gauge: false, every: tiles::every(camera.size(), FRESH), ..sampling };
            let fresh = render(&sampling, u64::from(self.pass) + 1, &Silent);
            out.fresh = fresh.places.iter().map(|i| (*i, fresh.image[*i as usize])).collect();
        }
        out.seconds.eye += start.elapsed().as_secs_f64();
    }

    /// Radiance along camera rays through points of the film, each with its random numbers; in parallel where there are many.
    pub fn at(&self, points: &[(Vec2, Sampler)]) -> (Vec<Rgb>, Vec<Worker>) {
        match self.effects.interior_kind() {
            InteriorKind::Spectral => self.at_in::<SpectralInterior>(points),
            InteriorKind::Bodies => self.at_in::<InteriorStack>(points),
            InteriorKind::Nothing => self.at_in::<NoInterior>(points),
        }
    }

    fn at_in<I: Interior>(&self, points: &[(Vec2, Sampler)]) -> (Vec<Rgb>, Vec<Worker>) {
        let chunks = points.par_chunks(CHUNK).map(|chunk| {
            let (mut worker, mut waiting) = (Worker::default(), Vec::<Branch<I>>::new());
            let radiance = chunk.iter().map(|(at, draw)| {
                worker.counters.camera_rays += 1;
                let lens = self.effects.has(Effect::Lens).then(|| draw.get_2d(Dimension::Lens));
                self.radiance(&self.scene.camera().ray(*at, lens), *draw, &mut worker, &mut waiting)
            });
            (radiance.collect::<Vec<Rgb>>(), worker)
        });
        let (radiance, workers): (Vec<Vec<Rgb>>, Vec<Worker>) = chunks.collect::<Vec<_>>().into_iter().unzip();
        (radiance.concat(), workers)
    }

    /// Radiance along a camera ray. `waiting` is empty before and after.
    pub fn radiance<I: Interior>(
        &self,
        ray: &Ray,
        draw: Sampler,
        worker: &mut Worker,
        waiting: &mut Vec<Branch<I>>,
    ) -> Rgb {
        let walk = self.scene.start_camera_path(*ray, self.effects);
        let mut next =
            Some(Branch { walk, throughput: Rgb::ONE, bounce: 0, history: History::default(), last: None, draw });
        let mut radiance = Rgb::ZERO;
        while let Some(mut branch) = next {
            while let Some(next) = self.step(&mut branch, waiting.len() < BRANCHES, worker, &mut radiance) {
                if let Next::Both(other) = next {
                    waiting.push(other);
                }
            }
            next = waiting.pop();
        }
        radiance
    }

    /// Follows a walk to its next surface, adds what that sends back, and leaves in `branch` how it goes on; it splits in two
    /// only where there is `room`.
    #[inline]
    fn step<I: Interior>(
        &self,
        branch: &mut Branch<I>,
        room: bool,
        worker: &mut Worker,
        radiance: &mut Rgb,
    ) -> Option<Next<I>> {
        worker.counters.continuation_rays += u64::from(branch.bounce > 0);
        let (step, phase) = if I::IMMERSED {
            self.advance_in_media(branch, worker, radiance)
        } else {
            (branch.walk.next_vertex(self.scene, branch.draw.key(), |_| None), PhaseFunction::Isotropic)
        };
        let SurfaceVertex { mut surface, transmittance, distance, crossed } = match step {
            PathEvent::Surface(arrival) => arrival,
            PathEvent::Scattered { transmittance, crossed } => {
                branch.throughput *= transmittance;
                branch.history.casters += u32::from(crossed);
                return self.scatter(branch, phase);
            }
            PathEvent::Escaped { crossed } => {
                if crossed {
                    branch.history.casters += 1;
                    branch.last = None;
                }
                *radiance += branch.throughput * self.escaped(branch);
                return None;
            }
        };
        branch.throughput *= transmittance;
        if crossed {
            branch.history.casters += 1;
            branch.last = None;
        }
        // Lights without an extent to sample are seen, but not met by chance.
        let meets = branch.last.is_none() || self.effects.has(Effect::SoftShadows);
        if surface.emission != Rgb::ZERO && meets && self.method.counts(branch.history) {
            let weight = branch.last.map_or(1.0, |last| self.weight_of_chance(&last, &surface));
            *radiance += branch.throughput * surface.emission * weight;
        }
        let inside = branch.walk.inside;
        if surface.bsdf.stores_photons() {
            self.receive(branch, &mut surface, &inside, distance, worker, radiance)
        } else if surface.bsdf == Bsdf::Black || !self.effects.has(Effect::Specular) {
            None
        } else {
            self.cast(branch, &surface, &inside, distance, room, worker, radiance)
        }
    }

    /// A step that ends at a receiver.
    #[inline]
    fn receive<I: Interior>(
        &self,
        branch: &mut Branch<I>,
        surface: &mut SurfaceInteraction<'_>,
        inside: &I,
        distance: f32,
        worker: &mut Worker,
        radiance: &mut Rgb,
    ) -> Option<Next<I>> {
        // Shading costs as much as dozens of rays.
        let worth = color::mean(branch.throughput) / CERTAIN;
        if worth < 1.0 && self.method.cut() == 0.0 {
            if branch.draw.get_1d(Dimension::Worth) >= worth {
                return None;
            }
            branch.throughput /= worth;
        }
        surface.bsdf = self.method.part(surface.bsdf, branch.draw.get_1d(Dimension::Part));
        let vertex = self.vertex(branch, surface, inside, distance);
        let mut to_do = self.method.at_receiver(&vertex);
        to_do.onward &= branch.bounce < self.settings.max_bounces;
        if to_do.onward {
            self.method.prepare(&vertex, worker);
        }
        let found = self.direct(&vertex, to_do, worker) + self.method.photons(&vertex, worker);
        *radiance += branch.throughput * found;
        branch.history = History { receivers: branch.history.receivers + 1, casters: 0 };
        if to_do.onward { self.onward(branch, &vertex, worker) } else { None }
    }

    /// A step that ends at a caster. Apart from the loop, which scenes without casters need not carry it through.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    fn cast<I: Interior>(
        &self,
        branch: &mut Branch<I>,
        surface: &SurfaceInteraction<'_>,
        inside: &I,
        distance: f32,
        room: bool,
        worker: &mut Worker,
        radiance: &mut Rgb,
    ) -> Option<Next<I>> {
        let onward = branch.bounce < self.settings.max_bounces;
        branch.history.casters += 1;
        let vertex = self.vertex(branch, surface, inside, distance);
        if !surface.bsdf.is_specular() {
            // A connection from here comes over this caster too.
            let to_do = AtReceiver { direct: self.method.counts(branch.history), onward };
            *radiance += branch.throughput * self.direct(&vertex, to_do, worker);
        }
        if !onward {
            return None;
        }
        if let Bsdf::Dielectric(dielectric) = surface.bsdf {
            let split = dielectric.split(surface.wo, surface.point.ns, surface.point.ng, Transport::Radiance);
            let weaker = split.reflected.1.min(split.transmitted.1) * color::mean(branch.throughput);
            if room && branch.history.receivers == 0 && weaker > WORTH_SPLITTING.max(self.method.cut()) {
                let reflected = branch.leaving(surface, split.reflected.0, Rgb::splat(split.reflected.1), false);
                let weight = Rgb::splat(split.transmitted.1 / split.squeeze);
                *branch = branch.leaving(surface, split.transmitted.0, weight, true);
                return Some(Next::Both(reflected));
            }
        }
        self.onward(branch, &vertex, worker)
    }

    fn vertex<'v, I: Interior>(
        &self,
        branch: &Branch<I>,
        surface: &'v SurfaceInteraction<'v>,
        inside: &'v I,
        distance: f32,
    ) -> Vertex<'v, I> {
        let shadow_draw = branch.draw.with(u64::from(self.pass) << 32);
        let (history, throughput) = (branch.history, branch.throughput);
        Vertex { surface, inside, history, throughput, distance, draw: branch.draw, shadow_draw }
    }

    /// Draws how a walk goes on.
    #[inline]
    fn onward<I: Interior>(
        &self,
        branch: &mut Branch<I>,
        vertex: &Vertex<'_, I>,
        worker: &mut Worker,
    ) -> Option<Next<I>> {
        let sample = self.method.sample(vertex, worker)?;
        let roulette = branch.draw.get_1d(Dimension::Roulette);
        let mut next = branch.leaving(vertex.surface, sample.wi, sample.weight, sample.transmitted);
        let point = &vertex.surface.point;
        next.last = (!sample.specular).then_some(Last {
            p: point.p,
            horizon: vertex.horizon(),
            history: vertex.history,
            pdf: sample.pdf,
        });
        let strength = color::mean(next.throughput);
        if strength < self.method.cut() {
            return None;
        }
        if next.history.receivers > 0 || next.bounce > CERTAIN_CASTERS {
            let survival = (strength / CERTAIN).min(1.0);
            if survival.is_nan() || roulette >= survival {
                return None;
            }
            next.throughput /= survival;
        }
        *branch = next;
        Some(Next::One)
    }

    /// Light that the surface scatters to its viewer straight from the lights.
    #[inline]
    fn direct<I: Interior>(&self, vertex: &Vertex<'_, I>, to_do: AtReceiver, worker: &mut Worker) -> Rgb {
        if !to_do.direct {
            return Rgb::ZERO;
        }
        let pdf = |wi: Vec3, worker: &mut Worker| self.method.pdf(vertex, wi, worker);
        self.direct.reflected(vertex, if to_do.onward { Some(&pdf) } else { None }, worker)
    }

    /// Weight of light that was met by chance, where it could also have been asked for (the balance heuristic, Veach 1997,
    /// section 9.2.2).
    #[inline]
    fn weight_of_chance(&self, last: &Last, seen: &SurfaceInteraction<'_>) -> f32 {
        let Some(light) = seen.light else { return 1.0 };
        last.pdf / (last.pdf + self.direct.density(last, light as usize, -seen.wo, Some(&seen.point)))
    }

    /// Radiance from where nothing is.
    fn escaped<I: Interior>(&self, branch: &Branch<I>) -> Rgb {
        let direction = branch.walk.ray.direction;
        let meets = branch.last.is_none() || self.effects.has(Effect::SoftShadows);
        match self.scene.environment().filter(|_| self.effects.has(Effect::Environment)) {
            // The background is seen but lights nothing.
            None if branch.history.receivers > 0 => Rgb::ZERO,
            None => self.scene.background(),
            Some(_) if !meets || !self.method.counts(branch.history) => Rgb::ZERO,
            Some(light) => {
                let density = |last: Last| self.direct.density(&last, light, direction, None);
                let weight = branch.last.map_or(1.0, |last| last.pdf / (last.pdf + density(last)));
                self.scene.escaping(direction) * weight
            }
        }
    }
}

impl<I: Interior> Branch<I> {
    /// The walk after `surface`.
    #[inline]
    fn leaving(&self, surface: &SurfaceInteraction<'_>, direction: Vec3, weight: Rgb, transmitted: bool) -> Self {
        let mut walk = self.walk;
        let weight = weight * walk.leave(surface, direction, transmitted);
        let draw = self.draw.with(u64::from(self.bounce) << 1 | u64::from(transmitted));
        Self { walk, throughput: self.throughput * weight, bounce: self.bounce + 1, last: None, draw, ..*self }
    }
}
