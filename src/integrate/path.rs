//! Path tracing: unbiased. At each receiver the lights are asked and the walk goes on; light that both could find is weighted
//! (Veach 1997, chapters 9 and 10).

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, History, Method, Plan, Vertex};
use super::{EyeSettings, Integrator, Monitor, Pass};
use crate::scene::Scene;

/// Camera rays a pixel and pass, where the user does not say.
const SAMPLES: u32 = 4;

/// Path tracing.
#[derive(Debug)]
pub struct PathTracing<'a> {
    scene: &'a Scene,
    settings: EyeSettings,
    direct: DirectLight<'a>,
}

impl<'a> PathTracing<'a> {
    /// Prepares the choice of lights.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: EyeSettings) -> Self {
        Self { scene, settings, direct: DirectLight::new(scene, Asking::Walk) }
    }
}

impl Integrator for PathTracing<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let (settings, direct, method) = (&self.settings, &self.direct, &Everywhere);
        EyePass { scene: self.scene, settings, direct, method, samples: SAMPLES, pass }.run(monitor, &mut out);
        out
    }
}

struct Everywhere;

impl Method for Everywhere {
    fn plan(&self, _: &Vertex<'_>) -> Plan {
        Plan { direct: true, onward: true }
    }

    fn counts(&self, _: History) -> bool {
        true
    }
}
