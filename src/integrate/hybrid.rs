//! Path tracing for every path that connections find, photons for exactly the rest.
//!
//! A light's path that begins with casters and then meets a receiver is found by photons, at the first receiver of the camera
//! walk: from the caustic map where that receiver is the first on the light's path, from a map of what caustics become where
//! it is a later one. All other paths are found by the walk itself, by shadow rays and by chance, weighted against each other.

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, History, Method, Plan, Vertex};
use super::maps::{MapMaker, Maps, Needs, Schedule};
use super::tiles::Worker;
use super::{Integrator, Lessons, Monitor, Pass, PhotonSettings, Radii};
use crate::color::Rgb;
use crate::scene::Scene;

/// Camera rays a pixel and pass, where the user does not say.
const SAMPLES: u32 = 8;

/// Path tracing with a caustic map.
#[derive(Debug)]
pub struct Hybrid<'a> {
    scene: &'a Scene,
    direct: DirectLight<'a>,
    maker: MapMaker<'a>,
}

impl<'a> Hybrid<'a> {
    /// Weighs the lights and finds the caustic map's radius where none is set.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: PhotonSettings) -> Self {
        let direct = DirectLight::new(scene, Asking::Walk);
        Self { scene, direct, maker: MapMaker::new(scene, settings, Needs::ByCasters, Schedule::Shrinking) }
    }
}

impl Integrator for Hybrid<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = &self.maker.make(pass, monitor, &mut out);
        let (settings, direct, method) = (&self.maker.settings.eye, &self.direct, &Connected { maps });
        EyePass { scene: self.scene, settings, direct, method, samples: SAMPLES, pass }.run(monitor, &mut out);
        out
    }

    fn radii(&self) -> Option<Radii> {
        Some(self.maker.radii)
    }

    fn lessons(&self) -> Lessons {
        self.maker.lessons
    }
}

struct Connected<'a> {
    maps: &'a Maps<'a>,
}

impl Method for Connected<'_> {
    fn plan(&self, _: &Vertex<'_>) -> Plan {
        Plan { direct: true, onward: true }
    }

    #[inline]
    fn photons(&self, vertex: &Vertex<'_>, worker: &mut Worker) -> Rgb {
        match vertex.draw.place() {
            // One estimate a pixel and pass: those of its other samples would rest on the same photons.
            (0, count) if vertex.history.receivers == 0 => {
                let caustic = self.maps.caustic.radiance(vertex, |w| &mut w.caustic, worker);
                (caustic + self.maps.smooth.radiance(vertex, |w| &mut w.smooth, worker)) * count as f32
            }
            _ => Rgb::ZERO,
        }
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }
}
