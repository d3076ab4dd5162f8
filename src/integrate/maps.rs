//! The photon maps of a pass.

use super::eye::Vertex;
use super::tiles::Worker;
use super::visible::visible;
use super::{
    EyeSettings, FinalGathering, Lessons, Monitor, Pass, Phase, PhotonReport, PhotonSettings, Radii, auto_radius,
    shrink,
};
use crate::bsdf::Transport;
use crate::color::Rgb;
use crate::photon::{
    Bandwidth, Kernel, Photon, PhotonMap, PhotonPass, PhotonSource, Pilot, Scratch, THINNING, Traced, Wants, coverage,
};
use crate::sampling::{Key, Purpose};
use crate::scene::Scene;
use std::time::Instant;

/// Most photons of a caustic estimate, where the user does not say.
pub const CAUSTIC_K: u32 = 50;

/// Photons that most discs of the global map should hold, where the user does not say.
const GLOBAL_COUNT: u32 = 100;

/// The same for the map of what caustics become, a smaller part of the light.
const AFTER_COUNT: u32 = 50;

/// Radius within which a photon counts for what is seen, before the maps' own radii are known, in radii of the scene.
const SEEN_WITHIN: f32 = 0.01;

/// Learned emission is used where it would take at least so many times as many paths to do without.
const LEAST_GAIN: f64 = 1.5;

/// Gather rays are guided by one photon path of so many of the global map.
const GUIDING: u32 = 16;

/// An estimate over fewer photons is noise, however many passes have shrunk it.
const FEWEST: f64 = 8.0;

/// How radii go from pass to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Schedule {
    /// They shrink, so that bias goes away.
    Shrinking,
    /// They stay.
    Fixed,
}

/// Which maps a method looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Needs {
    /// The caustic map, and a global map of these classes.
    Global(Wants),
    /// The caustic map, and a map of what caustics become.
    ByCasters,
}

/// Makes the maps of any pass.
#[derive(Debug)]
pub(super) struct MapMaker<'a> {
    scene: &'a Scene,
    pub settings: PhotonSettings,
    needs: Needs,
    /// Whether gather rays are guided.
    guided: bool,
    global: Option<PhotonSource<'a>>,
    caustic: Option<PhotonSource<'a>>,
    schedule: Schedule,
    pub radii: Radii,
    pub lessons: Lessons,
}

/// A map with the width of its estimates.
pub(super) struct Gathering<'a> {
    scene: &'a Scene,
    map: PhotonMap,
    bandwidth: Bandwidth,
    kernel: Kernel,
}

/// The maps of one pass.
pub(super) struct Maps<'a> {
    pub caustic: Gathering<'a>,
    /// The global map, or that of what caustics become.
    pub smooth: Gathering<'a>,
    /// Scattered light by few photons, whose directions guide gather rays.
    pub guides: PhotonMap,
}

impl<'a> MapMaker<'a> {
    /// Weighs the lights and finds radii where none is set.
    pub fn new(scene: &'a Scene, settings: PhotonSettings, needs: Needs, schedule: Schedule) -> Self {
        let source = |paths: u32, make: fn(&'a Scene) -> Option<PhotonSource<'a>>| {
            if paths == 0 { None } else { make(scene) }
        };
        let mut caustic = source(settings.caustic_photons, PhotonSource::aimed);
        let mut global = match needs {
            Needs::Global(_) => source(settings.photons, PhotonSource::everywhere),
            Needs::ByCasters => None,
        };
        let wants = match needs {
            Needs::Global(_) => Wants::CAUSTIC,
            Needs::ByCasters => Wants::BY_CASTERS,
        };
        let mut lessons = Lessons::default();
        if caustic.is_some() || global.is_some() {
            let seen = visible(scene, &settings.eye, scene.domain().radius * SEEN_WITHIN);
            let learn =
                |source: Option<PhotonSource<'a>>, wants: Wants, make: fn(&'a Scene) -> Option<PhotonSource<'a>>| {
                    let Some(source) = source else { return (None, None) };
                    let EyeSettings { max_bounces, seed, .. } = settings.eye;
                    let pilot = Pilot { wants, max_bounces, visible: &seen, paths: Pilot::PATHS, seed };
                    let (learned, lesson) = source.learned(&pilot);
                    // Paths that are seen take longer: little gain is none.
                    (if lesson.gain > LEAST_GAIN { Some(learned) } else { make(scene) }, Some(lesson))
                };
            (caustic, lessons.caustic) = learn(caustic, wants, PhotonSource::aimed);
            // Gather rays look at the global map from everywhere.
            if needs == Needs::Global(Wants::GLOBAL) {
                (global, lessons.global) = learn(global, Wants::GLOBAL, PhotonSource::everywhere);
            }
        }
        let radius = |source: &Option<PhotonSource<'a>>, wants: Wants, paths: u32, fallback: u32| {
            let k = settings.gather_k.filter(|k| *k > 0).unwrap_or(fallback);
            let found = || {
                let source = source.as_ref()?;
                let pass = PhotonPass { scene, source, wants, max_bounces: settings.eye.max_bounces };
                auto_radius(scene, &pass, paths, k, settings.eye.seed)
            };
            // Without photons the radius never matters.
            settings.radius.or_else(found).unwrap_or(1.0)
        };
        let smooth = match needs {
            Needs::Global(wants) => radius(&global, wants, settings.photons, GLOBAL_COUNT),
            Needs::ByCasters => {
                let after = Wants { caustic: false, ..Wants::BY_CASTERS };
                radius(&caustic, after, settings.caustic_photons / THINNING, AFTER_COUNT)
            }
        };
        let caustic_radius = radius(&caustic, Wants::CAUSTIC, settings.caustic_photons, CAUSTIC_K);
        let radii = Radii { global: smooth, caustic: caustic_radius };
        // Only a map for gather rays holds direct light.
        let gathers = matches!(needs, Needs::Global(wants) if wants.direct);
        let guided = gathers && settings.final_gathering == FinalGathering::Importance;
        Self { scene, needs, guided, global, caustic, schedule, radii, lessons, settings }
    }

    /// Traces and indexes the photons of pass `pass`, and books the work in `out`.
    pub fn make(&self, pass: u32, monitor: &dyn Monitor, out: &mut Pass) -> Maps<'a> {
        let key = |purpose| Key::new(self.settings.eye.seed).purpose(purpose).with(u64::from(pass));
        let wants = if self.needs == Needs::ByCasters { Wants::BY_CASTERS } else { Wants::CAUSTIC };
        let job = (wants, self.settings.caustic_photons);
        let traced = self.trace(self.caustic.as_ref(), job, key(Purpose::CausticPhotons), monitor, out);
        out.caustic = report(&traced);
        let caustic = index(traced.photons, monitor, out);
        let smooth = match self.needs {
            Needs::Global(wants) => {
                let job = (wants, self.settings.photons);
                let traced = self.trace(self.global.as_ref(), job, key(Purpose::GlobalPhotons), monitor, out);
                out.global = report(&traced);
                index(traced.photons, monitor, out)
            }
            Needs::ByCasters => index(traced.after_caustic, monitor, out),
        };
        let gathering = |map, radius, most| Gathering {
            scene: self.scene,
            map,
            bandwidth: self.bandwidth(radius, self.settings.gather_k.unwrap_or(most), pass),
            kernel: self.settings.kernel,
        };
        let guides = if self.guided {
            let job = (Wants::GLOBAL, self.settings.photons / GUIDING);
            let traced = self.trace(self.global.as_ref(), job, key(Purpose::Guides), monitor, out);
            index(traced.photons, monitor, out)
        } else {
            PhotonMap::build(Vec::new())
        };
        Maps {
            guides,
            caustic: gathering(caustic, self.radii.caustic, CAUSTIC_K),
            smooth: gathering(smooth, self.radii.global, 0),
        }
    }

    fn bandwidth(&self, radius: f32, most: u32, pass: u32) -> Bandwidth {
        let area = match self.schedule {
            Schedule::Shrinking => shrink(pass),
            Schedule::Fixed => 1.0,
        };
        let k = (f64::from(most) * area).round().max(FEWEST) as u32;
        Bandwidth { radius: radius * area.sqrt() as f32, k: k.min(most) }
    }

    fn trace(
        &self,
        source: Option<&PhotonSource<'_>>,
        (wants, paths): (Wants, u32),
        key: Key,
        monitor: &dyn Monitor,
        out: &mut Pass,
    ) -> Traced {
        let Some(source) = source else { return Traced::default() };
        let start = Instant::now();
        monitor.begin(Phase::Photons, u64::from(paths));
        let pass = PhotonPass { scene: self.scene, source, wants, max_bounces: self.settings.eye.max_bounces };
        let traced = pass.trace(key, paths, &|n| monitor.advance(n));
        out.counters.photon_rays += traced.rays;
        out.seconds.photons += start.elapsed().as_secs_f64();
        traced
    }
}

fn report(traced: &Traced) -> PhotonReport {
    let stored = traced.photons.len() + traced.after_caustic.len();
    PhotonReport { emitted: traced.paths, stored: stored as u64, audit: traced.audit }
}

fn index(photons: Vec<Photon>, monitor: &dyn Monitor, out: &mut Pass) -> PhotonMap {
    let start = Instant::now();
    let count = photons.len() as u64;
    monitor.begin(Phase::Trees, count);
    let map = PhotonMap::build(photons);
    monitor.advance(count);
    out.seconds.trees += start.elapsed().as_secs_f64();
    map
}

impl Gathering<'_> {
    /// Radiance that the surface of `vertex` sends to its viewer of the light in the map.
    #[inline]
    pub fn radiance(&self, vertex: &Vertex<'_>, scratch: fn(&mut Worker) -> &mut Scratch, worker: &mut Worker) -> Rgb {
        if self.map.is_empty() {
            return Rgb::ZERO;
        }
        worker.counters.gathers += 1;
        let surface = vertex.surface;
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        let brdf = |from| surface.bsdf.evaluate(surface.wo, from, ns, ns, Transport::Radiance);
        let normal = surface.facing_normal();
        let found = self.map.estimate(surface.point.p, normal, self.bandwidth, self.kernel, scratch(worker), brdf);
        worker.counters.gathered_photons += u64::from(found.count);
        if found.count == 0 {
            return Rgb::ZERO;
        }
        let key = vertex.draw.key();
        found.radiance / coverage(self.scene, surface.point.p, normal, found.radius, self.kernel, key)
    }
}
