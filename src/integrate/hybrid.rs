//! Path tracing for every path that connections find, photons for exactly the rest.
//!
//! A light's path that begins with casters and then meets a receiver is found by photons: each receiver of a camera walk, the
//! first and all that follow, looks at the caustic map. All other paths are found by the walk itself, by shadow rays and by
//! chance, weighted against each other.

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, History, Method, Plan, Vertex};
use super::maps::{MapMaker, Maps, Schedule};
use super::tiles::Worker;
use super::{Integrator, Monitor, Pass, PhotonSettings, Radii};
use crate::color::Rgb;
use crate::photon::Wants;
use crate::scene::Scene;

/// Camera rays a pixel and pass, where the user does not say.
const SAMPLES: u32 = 16;

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
        let direct = DirectLight::new(scene, Asking::Sampled(1));
        Self { scene, direct, maker: MapMaker::new(scene, settings, Wants::NONE, Schedule::Shrinking) }
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
}

struct Connected<'a> {
    maps: &'a Maps,
}

impl Method for Connected<'_> {
    fn plan(&self, _: &Vertex<'_>) -> Plan {
        Plan { direct: true, onward: true }
    }

    #[inline]
    fn photons(&self, vertex: &Vertex<'_>, worker: &mut Worker) -> Rgb {
        match vertex.draw.place() {
            _ if vertex.history.receivers > 0 => self.maps.thin.radiance(vertex, |w| &mut w.later, worker),
            // One estimate a pixel and pass: those of its other samples would rest on the same photons.
            (0, count) => self.maps.caustic.radiance(vertex, |w| &mut w.caustic, worker) * count as f32,
            _ => Rgb::ZERO,
        }
    }

    fn counts(&self, history: History) -> bool {
        !history.is_caustic()
    }
}
