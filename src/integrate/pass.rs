//! What a pass hands back, and whom it tells of its progress.

use super::Gauged;
use crate::color::Rgb;
use crate::photon::Audit;
use crate::stats::Counters;
use serde::Serialize;
use std::ops::AddAssign;

/// Stages of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Tracing photons from the lights; counted in paths.
    Photons,
    /// Building the trees.
    Trees,
    /// Tracing camera rays; counted in pixels.
    Eye,
}

/// Hears of progress, from any thread.
pub trait Monitor: Sync {
    /// A stage begins that has `total` units.
    fn begin(&self, phase: Stage, total: u64);
    /// So many more units are done.
    fn advance(&self, units: u64);
}

/// A monitor that ignores everything.
#[derive(Clone, Copy, Debug)]
pub struct Silent;

impl Monitor for Silent {
    fn begin(&self, _: Stage, _: u64) {}
    fn advance(&self, _: u64) {}
}

/// Wall seconds by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Tracing photons.
    pub photons: f64,
    /// Building trees.
    pub trees: f64,
    /// Tracing camera rays.
    pub eye: f64,
}

/// What became of the photons of one map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhotonReport {
    /// Paths emitted.
    pub emitted: u64,
    /// Photons stored.
    pub stored: u64,
    /// Where their flux went \[W].
    pub audit: Audit,
}

/// What a pass will keep in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expected {
    /// Photon paths of all maps.
    pub paths: u64,
    /// Stored photons of all maps, about.
    pub photons: u64,
    /// Photons of the largest map, about.
    pub most: u64,
}

/// One pass.
#[derive(Clone, Debug, Default)]
pub struct Pass {
    /// Mean radiance of each pixel, by rows from the top \[W/(m² sr)].
    pub image: Vec<Rgb>,
    /// Work done.
    pub counters: Counters,
    /// Time by stage.
    pub seconds: Seconds,
    /// The global map's photons.
    pub global: PhotonReport,
    /// The caustic map's photons.
    pub caustic: PhotonReport,
    /// What is told of the error of each pixel's estimates; empty where nobody asked, or where there are none.
    pub gauged: Vec<Gauged>,
    /// Of passes that share their camera walks: some pixels, by walks of the pass's own, each with its place in `image`.
    pub fresh: Vec<(u32, Rgb)>,
}

impl AddAssign for Seconds {
    fn add_assign(&mut self, o: Self) {
        self.photons += o.photons;
        self.trees += o.trees;
        self.eye += o.eye;
    }
}

impl AddAssign for PhotonReport {
    fn add_assign(&mut self, o: Self) {
        self.emitted += o.emitted;
        self.stored += o.stored;
        self.audit += o.audit;
    }
}
