//! Ray tracing (Whitted 1980): shading by shadow rays to the middle of each light, reflection and refraction in Fresnel's shares,
//! until a branch is too deep or too faint.

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, History, Method, Plan, Vertex};
use super::{EyeSettings, Integrator, Monitor, Pass};
use crate::scene::Scene;

/// A branch fainter than one level of an 8-bit picture is cut.
const FAINTEST: f32 = 1.0 / 256.0;

/// Ray tracing.
#[derive(Debug)]
pub struct Whitted<'a> {
    scene: &'a Scene,
    settings: EyeSettings,
    direct: DirectLight<'a>,
}

impl<'a> Whitted<'a> {
    /// Prepares the lights.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: EyeSettings) -> Self {
        Self { scene, settings, direct: DirectLight::new(scene, Asking::Middles) }
    }
}

impl Integrator for Whitted<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let (settings, direct, method) = (&self.settings, &self.direct, &Shaded);
        EyePass { scene: self.scene, settings, direct, method, samples: 1, pass }.run(monitor, &mut out);
        out
    }
}

struct Shaded;

impl Method for Shaded {
    fn plan(&self, _: &Vertex<'_>) -> Plan {
        Plan { direct: true, onward: false }
    }

    fn counts(&self, _: History) -> bool {
        true
    }

    fn cut(&self) -> f32 {
        FAINTEST
    }
}
