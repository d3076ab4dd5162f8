//! Stochastic progressive photon mapping (Hachisuka and Jensen 2009) by independent passes (Knaus and Zwicker 2011): new photons
//! and new camera walks in each, with radii that shrink.

use super::direct::{Asking, DirectLight};
use super::eye::EyePass;
use super::maps::{MapMaker, Needs, Schedule};
use super::pm::Seen;
use super::{Integrator, Lessons, Monitor, Pass, PhotonSettings, Radii};
use crate::photon::Wants;
use crate::scene::Scene;

/// Stochastic progressive photon mapping.
#[derive(Debug)]
pub struct Sppm<'a> {
    scene: &'a Scene,
    direct: DirectLight<'a>,
    maker: MapMaker<'a>,
}

impl<'a> Sppm<'a> {
    /// Weighs the lights and finds radii where none is set.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: PhotonSettings) -> Self {
        let direct = DirectLight::new(scene, Asking::Sampled(4));
        Self { scene, direct, maker: MapMaker::new(scene, settings, Needs::Global(Wants::GLOBAL), Schedule::Shrinking) }
    }
}

impl Integrator for Sppm<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = &self.maker.make(pass, monitor, &mut out);
        let (settings, direct, method) = (&self.maker.settings.eye, &self.direct, &Seen { maps, repeats: false });
        EyePass { scene: self.scene, settings, direct, method, samples: 1, pass }.run(monitor, &mut out);
        out
    }

    fn radii(&self) -> Option<Radii> {
        Some(self.maker.radii)
    }

    fn lessons(&self) -> Lessons {
        self.maker.lessons
    }
}
