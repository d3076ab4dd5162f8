//! Photon mapping with two maps (Jensen 2001, chapter 9), seen directly, over progressive passes.
//!
//! At the first surface that is not specular: direct light by shadow rays, light focused by specular surfaces from the caustic
//! map, light that was scattered before from the global map. Each path from a light to the eye falls into one of the three.

use super::direct::DirectLight;
use super::tiles::{self, Worker};
use super::{Integrator, Monitor, Pass, Phase, PhotonReport, Radii, Seconds, auto_radius, shrink};
use crate::bsdf::{Bsdf, Transport};
use crate::camera::{Filter, FilterKind};
use crate::color::{self, Rgb};
use crate::math::Ray;
use crate::photon::{Bandwidth, Kernel, PhotonMap, PhotonPass, PhotonSource, Wants};
use crate::sampling::{Dimension, Key, Purpose};
use crate::scene::{Arrival, Scene, Surface, Walk};
use std::time::Instant;

/// What a user may set.
#[derive(Clone, Debug)]
pub struct PhotonSettings {
    /// Paths of the global map a pass.
    pub photons: u32,
    /// Paths aimed at specular surfaces a pass.
    pub caustic_photons: u32,
    /// Camera rays a pixel and pass.
    pub samples: u32,
    /// Most photons an estimate takes, 0 for no limit; `None`: [`CAUSTIC_K`] in the caustic map, no limit in the global one,
    /// whose light is smooth.
    pub gather_k: Option<u32>,
    /// Largest radius of the first pass \[length]; `None` lets a pilot find one for each map.
    pub radius: Option<f32>,
    /// Kernel of the estimates.
    pub kernel: Kernel,
    /// Bounces after which a path is cut.
    pub max_bounces: u32,
    /// Seed of all randomness.
    pub seed: u64,
    /// Reconstruction filter.
    pub filter: Filter,
}

impl Default for PhotonSettings {
    fn default() -> Self {
        Self {
            photons: 500_000,
            caustic_photons: 250_000,
            samples: 1,
            gather_k: None,
            radius: None,
            kernel: Kernel::default(),
            max_bounces: 100,
            seed: 0,
            filter: Filter::new(FilterKind::default()),
        }
    }
}

/// Most photons of a caustic estimate, where the user does not say.
pub const CAUSTIC_K: u32 = 50;

/// Photons that most discs of the global map should hold, where the user does not say.
const GLOBAL_COUNT: u32 = 100;

/// An estimate over fewer photons is noise, however many passes have shrunk it.
const FEWEST: f64 = 8.0;

/// A specular branch weaker than this part of the pixel is followed by chance only.
const WORTH_SPLITTING: f32 = 0.001;

/// What a branch weaker than this part of the pixel ends on is lit by chance only.
const WORTH_GATHERING: f32 = 0.1;

/// Branches that may wait at once.
const BRANCHES: usize = 16;

/// After so many specular bounces the walk goes on with the probability of its throughput.
const CERTAIN_BOUNCES: u32 = 8;

/// The algorithm, prepared for a scene.
#[derive(Debug)]
pub struct PhotonMapping<'a> {
    scene: &'a Scene,
    settings: PhotonSettings,
    direct: DirectLight<'a>,
    global: Option<PhotonSource<'a>>,
    caustic: Option<PhotonSource<'a>>,
    radii: Radii,
}

/// The maps of one pass.
struct Maps {
    global: PhotonMap,
    caustic: PhotonMap,
    global_bandwidth: Bandwidth,
    caustic_bandwidth: Bandwidth,
}

/// A camera walk that waits to be continued.
#[derive(Clone, Copy)]
struct Branch {
    walk: Walk,
    throughput: Rgb,
    bounce: u32,
    key: Key,
}

impl<'a> PhotonMapping<'a> {
    /// Weighs the lights and finds radii where none is set.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: PhotonSettings) -> Self {
        let source = |paths: u32, make: fn(&'a Scene) -> Option<PhotonSource<'a>>| {
            if paths == 0 { None } else { make(scene) }
        };
        let global = source(settings.photons, PhotonSource::everywhere);
        let caustic = source(settings.caustic_photons, PhotonSource::aimed);
        let radius = |source: &Option<PhotonSource<'a>>, wants: Wants, paths: u32, fallback: u32| {
            let k = settings.gather_k.filter(|k| *k > 0).unwrap_or(fallback);
            let found = || {
                let source = source.as_ref()?;
                let pass = PhotonPass { scene, source, wants, max_bounces: settings.max_bounces };
                auto_radius(scene, &pass, paths, k, settings.seed)
            };
            // Without photons the radius never matters.
            settings.radius.or_else(found).unwrap_or(1.0)
        };
        let radii = Radii {
            global: radius(&global, Wants::GLOBAL, settings.photons, GLOBAL_COUNT),
            caustic: radius(&caustic, Wants::CAUSTIC, settings.caustic_photons, CAUSTIC_K),
        };
        Self { scene, direct: DirectLight::new(scene), global, caustic, radii, settings }
    }

    /// Largest radii of the first pass.
    #[must_use]
    pub fn radii(&self) -> Radii {
        self.radii
    }

    fn bandwidth(&self, radius: f32, most: u32, pass: u32) -> Bandwidth {
        let area = shrink(pass);
        let k = (f64::from(most) * area).round().max(FEWEST) as u32;
        Bandwidth { radius: radius * area.sqrt() as f32, k: k.min(most) }
    }

    /// Traces one map's photons and indexes them.
    fn map(
        &self,
        source: Option<&PhotonSource<'_>>,
        (wants, paths): (Wants, u32),
        key: Key,
        monitor: &dyn Monitor,
        out: &mut Pass,
    ) -> (PhotonMap, PhotonReport) {
        let Some(source) = source else {
            return (PhotonMap::build(Vec::new()), PhotonReport::default());
        };
        let start = Instant::now();
        monitor.begin(Phase::Photons, u64::from(paths));
        let pass = PhotonPass { scene: self.scene, source, wants, max_bounces: self.settings.max_bounces };
        let traced = pass.trace(key, paths, &|n| monitor.advance(n));
        let stored = traced.photons.len() as u64;
        let built = Instant::now();
        monitor.begin(Phase::Trees, stored);
        let map = PhotonMap::build(traced.photons);
        monitor.advance(stored);
        out.counters.photon_rays += traced.rays;
        out.seconds += Seconds {
            photons: (built - start).as_secs_f64(),
            trees: built.elapsed().as_secs_f64(),
            ..Seconds::default()
        };
        (map, PhotonReport { emitted: traced.paths, stored, audit: traced.audit })
    }

    /// Radiance along a camera ray.
    fn radiance(&self, ray: &Ray, key: Key, maps: &Maps, worker: &mut Worker) -> Rgb {
        let first = Branch { walk: self.scene.walk_from_camera(*ray), throughput: Rgb::ONE, bounce: 0, key };
        let mut waiting = [first; BRANCHES];
        let mut count = 1;
        let mut radiance = Rgb::ZERO;
        while count > 0 {
            count -= 1;
            let mut branch = waiting[count];
            while let Some(next) = self.step(&mut branch, count < BRANCHES, maps, worker, &mut radiance) {
                if let Next::Both(other) = next {
                    waiting[count] = other;
                    count += 1;
                }
            }
        }
        radiance
    }

    /// Follows a walk to its next surface, adds what that sends back, and leaves in `branch` how it goes on; it splits in two
    /// only where there is `room`.
    #[inline]
    fn step(
        &self,
        branch: &mut Branch,
        room: bool,
        maps: &Maps,
        worker: &mut Worker,
        radiance: &mut Rgb,
    ) -> Option<Next> {
        if branch.bounce > 0 {
            worker.counters.specular_rays += 1;
        }
        let Some(Arrival { surface, transmittance, .. }) = branch.walk.advance(self.scene, branch.key) else {
            *radiance += branch.throughput * self.scene.background();
            return None;
        };
        branch.throughput *= transmittance;
        *radiance += branch.throughput * surface.emission;
        if !surface.bsdf.is_specular() {
            // Faint reflections are looked at by chance: an estimate costs as much as dozens of rays.
            let worth = (color::mean(branch.throughput) / WORTH_GATHERING).min(1.0);
            if branch.key.uniform(Dimension::Roulette) < worth {
                *radiance += branch.throughput * self.reflected(&surface, branch.key, maps, worker) / worth;
            }
            return None;
        }
        if branch.bounce == self.settings.max_bounces {
            return None;
        }
        self.scatter(branch, room, &surface)
    }

    /// How a walk goes on from a specular surface.
    #[inline]
    fn scatter(&self, branch: &mut Branch, room: bool, surface: &Surface<'_>) -> Option<Next> {
        let key = branch.key.with(u64::from(branch.bounce));
        let go = |direction, weight: Rgb, transmitted: bool| {
            let mut walk = branch.walk;
            walk.leave(surface, direction, transmitted);
            let key = key.with(transmitted.into());
            Branch { walk, throughput: branch.throughput * weight, bounce: branch.bounce + 1, key }
        };
        if let Bsdf::Dielectric(dielectric) = surface.bsdf {
            let split = dielectric.split(surface.wo, surface.point.ns, surface.point.ng, Transport::Radiance);
            let weaker = split.reflected.1.min(split.transmitted.1) * color::mean(branch.throughput);
            if room && weaker > WORTH_SPLITTING {
                let reflected = go(split.reflected.0, Rgb::splat(split.reflected.1), false);
                let transmitted = go(split.transmitted.0, Rgb::splat(split.transmitted.1 / split.squeeze), true);
                *branch = transmitted;
                return Some(Next::Both(reflected));
            }
        }
        let (lobe, u) = (key.uniform(Dimension::BsdfLobe), key.uniform_2d(Dimension::BsdfDirection));
        let sample = surface.sample(lobe, u, Transport::Radiance)?;
        let mut next = go(sample.wi, sample.weight, sample.transmitted);
        if next.bounce > CERTAIN_BOUNCES {
            let survival = color::mean(next.throughput).min(1.0);
            if key.uniform(Dimension::Roulette) >= survival {
                return None;
            }
            next.throughput /= survival;
        }
        *branch = next;
        Some(Next::One)
    }

    /// What a surface sends to its viewer of the light that reaches it.
    #[inline]
    fn reflected(&self, surface: &Surface<'_>, key: Key, maps: &Maps, worker: &mut Worker) -> Rgb {
        let direct = self.direct.reflected(surface, key, worker);
        if !surface.bsdf.stores_photons() {
            return direct;
        }
        let normal = surface.facing_normal();
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        let mut estimate = |map: &PhotonMap, bandwidth, scratch| {
            worker.counters.gathers += 1;
            let brdf = |from| surface.bsdf.evaluate(surface.wo, from, ns, ns, Transport::Radiance);
            let found = map.estimate(surface.point.p, normal, bandwidth, self.settings.kernel, scratch, brdf);
            worker.counters.gathered_photons += u64::from(found.count);
            found.radiance
        };
        let mut sum = direct;
        if !maps.caustic.is_empty() {
            sum += estimate(&maps.caustic, maps.caustic_bandwidth, &mut worker.caustic);
        }
        if !maps.global.is_empty() {
            sum += estimate(&maps.global, maps.global_bandwidth, &mut worker.global);
        }
        sum
    }
}

/// What follows a step.
enum Next {
    /// The branch itself.
    One,
    /// The branch, and another one.
    Both(Branch),
}

impl Integrator for PhotonMapping<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let key = |purpose| Key::new(self.settings.seed).purpose(purpose).with(u64::from(pass));
        let job = (Wants::CAUSTIC, self.settings.caustic_photons);
        let (caustic, report) = self.map(self.caustic.as_ref(), job, key(Purpose::CausticPhotons), monitor, &mut out);
        out.caustic = report;
        let job = (Wants::GLOBAL, self.settings.photons);
        let (global, report) = self.map(self.global.as_ref(), job, key(Purpose::GlobalPhotons), monitor, &mut out);
        out.global = report;
        let maps = Maps {
            global,
            caustic,
            global_bandwidth: self.bandwidth(self.radii.global, self.settings.gather_k.unwrap_or(0), pass),
            caustic_bandwidth: self.bandwidth(self.radii.caustic, self.settings.gather_k.unwrap_or(CAUSTIC_K), pass),
        };

        let start = Instant::now();
        let sampling = tiles::Sampling {
            camera: self.scene.camera(),
            filter: Some(&self.settings.filter),
            samples: self.settings.samples,
        };
        let (image, counters) = tiles::render(&sampling, key(Purpose::Camera), monitor, |ray, key, worker| {
            self.radiance(ray, key, &maps, worker)
        });
        out.image = image;
        out.counters += counters;
        out.seconds.eye = start.elapsed().as_secs_f64();
        out
    }
}
