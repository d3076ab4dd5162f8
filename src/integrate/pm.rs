//! Photon mapping with two maps of fixed radii (Jensen 2001, chapter 9).
//!
//! At the first receiver: direct light by shadow rays, light focused by casters from the caustic map, and light that was
//! scattered before either from the global map itself (*direct visualisation*) or by one more ray, at whose end the map is
//! looked at (*final gathering*), which hides the map's blur and its seams at edges.

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, History, Method, Plan, Vertex};
use super::maps::{MapMaker, Maps, Needs, Schedule};
use super::tiles::Worker;
use super::{Integrator, Lessons, Monitor, Pass, PhotonSettings, Radii};
use crate::color::Rgb;
use crate::photon::Wants;
use crate::scene::Scene;

/// A gather ray shorter than so many radii of the global map ends where the map knows no more than where it began: the walk goes
/// on.
const SHORT: f32 = 2.0;

/// Camera rays a pixel and pass with final gathering, one gather ray each, where the user does not say.
const GATHER_RAYS: u32 = 4;

/// Photon mapping.
#[derive(Debug)]
pub struct PhotonMapping<'a> {
    scene: &'a Scene,
    direct: DirectLight<'a>,
    maker: MapMaker<'a>,
}

impl<'a> PhotonMapping<'a> {
    /// Weighs the lights and finds radii where none is set.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: PhotonSettings) -> Self {
        // A gather ray sees direct light too.
        let (wants, asking) = if settings.final_gathering {
            (Wants { caustic: false, ..Wants::ALL }, Asking::Walk)
        } else {
            (Wants::GLOBAL, Asking::Sampled(4))
        };
        let direct = DirectLight::new(scene, asking);
        Self { scene, direct, maker: MapMaker::new(scene, settings, Needs::Global(wants), Schedule::Fixed) }
    }
}

impl Integrator for PhotonMapping<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = &self.maker.make(pass, monitor, &mut out);
        let (settings, direct) = (&self.maker.settings.eye, &self.direct);
        if self.maker.settings.final_gathering {
            let method = &Gathered { maps, short: SHORT * self.maker.radii.global };
            EyePass { scene: self.scene, settings, direct, method, samples: GATHER_RAYS, pass }.run(monitor, &mut out);
        } else {
            let method = &Seen { maps, repeats: false };
            EyePass { scene: self.scene, settings, direct, method, samples: 1, pass }.run(monitor, &mut out);
        }
        out
    }

    fn radii(&self) -> Option<Radii> {
        Some(self.maker.radii)
    }

    fn lessons(&self) -> Lessons {
        self.maker.lessons
    }
}

/// Both maps seen at the first receiver.
pub(super) struct Seen<'a> {
    pub maps: &'a Maps<'a>,
    /// Whether all passes share their camera walks.
    pub repeats: bool,
}

impl Method for Seen<'_> {
    fn plan(&self, _: &Vertex<'_>) -> Plan {
        Plan { direct: true, onward: false }
    }

    #[inline]
    fn photons(&self, vertex: &Vertex<'_>, worker: &mut Worker) -> Rgb {
        let caustic = self.maps.caustic.radiance(vertex, |w| &mut w.caustic, worker);
        caustic + self.maps.smooth.radiance(vertex, |w| &mut w.smooth, worker)
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }

    fn repeats_walks(&self) -> bool {
        self.repeats
    }
}

/// The global map seen through a gather ray.
struct Gathered<'a> {
    maps: &'a Maps<'a>,
    short: f32,
}

impl Gathered<'_> {
    /// Whether the map is looked at here.
    #[inline]
    fn ends_at(&self, vertex: &Vertex<'_>) -> bool {
        vertex.history.receivers > 0 && vertex.distance > self.short
    }
}

impl Method for Gathered<'_> {
    fn plan(&self, vertex: &Vertex<'_>) -> Plan {
        let goes_on = !self.ends_at(vertex);
        Plan { direct: goes_on, onward: goes_on }
    }

    fn photons(&self, vertex: &Vertex<'_>, worker: &mut Worker) -> Rgb {
        let caustic = self.maps.caustic.radiance(vertex, |w| &mut w.caustic, worker);
        if self.ends_at(vertex) {
            caustic + self.maps.smooth.radiance(vertex, |w| &mut w.smooth, worker)
        } else {
            caustic
        }
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }
}
