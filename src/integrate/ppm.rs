//! Progressive photon mapping (Hachisuka, Ogaki and Jensen 2008): hit points that stay, passes of photons with radii that shrink.
//!
//! All passes share their camera walks, so that the hit points are the same; radii follow the law of independent passes (Knaus
//! and Zwicker 2011) in place of statistics kept at each hit point, so that any pass can be computed alone. What the camera
//! samples once, such as the edge of an object within a pixel, more passes do not refine.

use super::direct::{Asking, DirectLight};
use super::eye::EyePass;
use super::maps::{MapMaker, Needs, Schedule};
use super::pm::Seen;
use super::{Integrator, Lessons, Monitor, Pass, PhotonSettings, Radii};
use crate::photon::Wants;
use crate::scene::Scene;

/// Camera walks a pixel, where the user does not say: all that the picture will ever have.
const SAMPLES: u32 = 4;

/// Progressive photon mapping.
#[derive(Debug)]
pub struct Ppm<'a> {
    scene: &'a Scene,
    direct: DirectLight<'a>,
    maker: MapMaker<'a>,
}

impl<'a> Ppm<'a> {
    /// Weighs the lights and finds radii where none is set.
    #[must_use]
    pub fn new(scene: &'a Scene, settings: PhotonSettings) -> Self {
        let direct = DirectLight::new(scene, Asking::Sampled(1));
        Self { scene, direct, maker: MapMaker::new(scene, settings, Needs::Global(Wants::GLOBAL), Schedule::Shrinking) }
    }
}

impl Integrator for Ppm<'_> {
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass {
        let mut out = Pass::default();
        let maps = &self.maker.make(pass, monitor, &mut out);
        let (settings, direct) = (&self.maker.settings.eye, &self.direct);
        let method = &Seen { maps, repeats: true };
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
