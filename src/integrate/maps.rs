//! The photon maps of a pass.

use super::eye::Vertex;
use super::tiles::Worker;
use super::{Monitor, Pass, Phase, PhotonReport, PhotonSettings, Radii, Seconds, auto_radius, shrink};
use crate::bsdf::Transport;
use crate::color::Rgb;
use crate::photon::{Bandwidth, Kernel, PhotonMap, PhotonPass, PhotonSource, Scratch, Wants};
use crate::sampling::{Key, Purpose};
use crate::scene::Scene;
use std::time::Instant;

/// Most photons of a caustic estimate, where the user does not say.
pub const CAUSTIC_K: u32 = 50;

/// Photons that most discs of the global map should hold, where the user does not say.
const GLOBAL_COUNT: u32 = 100;

/// The thin map has one of so many photons.
const THINNING: u32 = 8;

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

/// Makes the maps of any pass.
#[derive(Debug)]
pub(super) struct MapMaker<'a> {
    scene: &'a Scene,
    pub settings: PhotonSettings,
    /// What the global map stores.
    wants: Wants,
    global: Option<PhotonSource<'a>>,
    caustic: Option<PhotonSource<'a>>,
    schedule: Schedule,
    pub radii: Radii,
}

/// A map with the width of its estimates.
pub(super) struct Gathering {
    map: PhotonMap,
    bandwidth: Bandwidth,
    kernel: Kernel,
}

/// The maps of one pass.
pub(super) struct Maps {
    pub global: Gathering,
    pub caustic: Gathering,
    /// The caustic map of fewer photons, quick to look at, for estimates whose noise is hidden by other noise.
    pub thin: Gathering,
}

impl<'a> MapMaker<'a> {
    /// Weighs the lights and finds radii where none is set. `wants` is what the global map stores; nothing wanted, it stays
    /// empty.
    pub fn new(scene: &'a Scene, settings: PhotonSettings, wants: Wants, schedule: Schedule) -> Self {
        let source = |paths: u32, make: fn(&'a Scene) -> Option<PhotonSource<'a>>| {
            if paths == 0 { None } else { make(scene) }
        };
        let global = if wants == Wants::NONE { None } else { source(settings.photons, PhotonSource::everywhere) };
        let caustic = source(settings.caustic_photons, PhotonSource::aimed);
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
        let radii = Radii {
            global: radius(&global, wants, settings.photons, GLOBAL_COUNT),
            caustic: radius(&caustic, Wants::CAUSTIC, settings.caustic_photons, CAUSTIC_K),
        };
        Self { scene, wants, global, caustic, schedule, radii, settings }
    }

    /// Traces and indexes the photons of pass `pass`, and books the work in `out`.
    pub fn make(&self, pass: u32, monitor: &dyn Monitor, out: &mut Pass) -> Maps {
        let key = |purpose| Key::new(self.settings.eye.seed).purpose(purpose).with(u64::from(pass));
        let job = (Wants::CAUSTIC, self.settings.caustic_photons);
        let ((caustic, thin), report) =
            self.map(self.caustic.as_ref(), job, key(Purpose::CausticPhotons), monitor, out);
        out.caustic = report;
        let job = (self.wants, self.settings.photons);
        let ((global, _), report) = self.map(self.global.as_ref(), job, key(Purpose::GlobalPhotons), monitor, out);
        out.global = report;
        let gathering = |map, radius, most| Gathering {
            map,
            bandwidth: self.bandwidth(radius, self.settings.gather_k.unwrap_or(most), pass),
            kernel: self.settings.kernel,
        };
        let later = Bandwidth { k: 0, ..self.bandwidth(self.radii.caustic, 0, pass) };
        Maps {
            global: gathering(global, self.radii.global, 0),
            caustic: gathering(caustic, self.radii.caustic, CAUSTIC_K),
            thin: Gathering { map: thin, bandwidth: later, kernel: Kernel::Epanechnikov },
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

    /// Traces one map's photons and indexes them.
    fn map(
        &self,
        source: Option<&PhotonSource<'_>>,
        (wants, paths): (Wants, u32),
        key: Key,
        monitor: &dyn Monitor,
        out: &mut Pass,
    ) -> ((PhotonMap, PhotonMap), PhotonReport) {
        let Some(source) = source else {
            return ((PhotonMap::build(Vec::new()), PhotonMap::build(Vec::new())), PhotonReport::default());
        };
        let start = Instant::now();
        monitor.begin(Phase::Photons, u64::from(paths));
        let pass = PhotonPass { scene: self.scene, source, wants, max_bounces: self.settings.eye.max_bounces };
        let traced = pass.trace(key, paths, &|n| monitor.advance(n));
        let stored = traced.photons.len() as u64;
        let built = Instant::now();
        monitor.begin(Phase::Trees, stored);
        let thin = if self.wants == Wants::NONE {
            PhotonMap::thinned(&traced.photons, THINNING)
        } else {
            PhotonMap::build(Vec::new())
        };
        let map = PhotonMap::build(traced.photons);
        monitor.advance(stored);
        out.counters.photon_rays += traced.rays;
        out.seconds += Seconds {
            photons: (built - start).as_secs_f64(),
            trees: built.elapsed().as_secs_f64(),
            ..Seconds::default()
        };
        ((map, thin), PhotonReport { emitted: traced.paths, stored, audit: traced.audit })
    }
}

impl Gathering {
    /// Radiance that the surface of `vertex` sends to its viewer of the light in the map.
    #[inline]
    pub fn radiance(&self, vertex: &Vertex<'_>, which: fn(&mut Worker) -> &mut Scratch, worker: &mut Worker) -> Rgb {
        self.radiance_of(vertex, self.bandwidth, which, worker)
    }

    #[inline]
    fn radiance_of(
        &self,
        vertex: &Vertex<'_>,
        bandwidth: Bandwidth,
        which: fn(&mut Worker) -> &mut Scratch,
        worker: &mut Worker,
    ) -> Rgb {
        if self.map.is_empty() {
            return Rgb::ZERO;
        }
        worker.counters.gathers += 1;
        let surface = vertex.surface;
        let ns = if surface.wo.dot(surface.point.ng) < 0.0 { -surface.point.ns } else { surface.point.ns };
        let brdf = |from| surface.bsdf.evaluate(surface.wo, from, ns, ns, Transport::Radiance);
        let normal = surface.facing_normal();
        let found = self.map.estimate(surface.point.p, normal, bandwidth, self.kernel, which(worker), brdf);
        worker.counters.gathered_photons += u64::from(found.count);
        found.radiance
    }
}
