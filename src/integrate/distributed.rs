//! Distributed ray tracing (Cook, Porter and Carpenter 1984): ray tracing whose lights have a size, whose reflections may be
//! glossy and whose pixels have an area, each sampled by chance. Matt surfaces do not light each other.

use super::direct::{Asking, DirectLight};
use super::eye::{EyePass, History, Method, Plan, Vertex};
use super::{EyeSettings, Integrator, Monitor, Pass};
use crate::bsdf::Bsdf;
use crate::scene::Scene;

/// Camera rays a pixel and pass, where the user does not say.
const SAMPLES: u32 = 4;

/// Distributed ray tracing.
#[derive(Debug)]
pub struct Distributed<'a> {
    scene: &'a Scene,
    settings: EyeSettings,
    direct: DirectLight<'a>,
}

impl<'a> Distributed<'a> {
    /// Prepares the lights.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: EyeSettings) -> Self {
        Self { scene, settings, direct: DirectLight::new(scene, Asking::Walk) }
    }
}

impl Integrator for Distributed<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let (settings, direct, method) = (&self.settings, &self.direct, &Glossy);
        EyePass { scene: self.scene, settings, direct, method, samples: SAMPLES, pass }.run(monitor, &mut out);
        out
    }
}

struct Glossy;

impl Method for Glossy {
    /// A gloss is followed, a matt part is not.
    fn part(&self, bsdf: Bsdf, chance: f32) -> Bsdf {
        match bsdf {
            Bsdf::Phong(phong) => phong.part(chance),
            other => other,
        }
    }

    fn plan(&self, vertex: &Vertex<'_>) -> Plan {
        Plan { direct: true, onward: !matches!(vertex.surface.bsdf, Bsdf::Diffuse(_)) }
    }

    fn counts(&self, _: History) -> bool {
        true
    }
}
