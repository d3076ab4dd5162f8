//! Result of a pass, and its progress.

use super::nested_estimates::NestedEstimates;
use crate::color::Rgb;
use crate::photon::EnergyAudit;
use crate::stats::Counters;
use serde::Serialize;
use std::ops::AddAssign;

/// Stage of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Tracing photons from the lights; counted in paths.
    Photons,
    /// Indexing photons; counted in photons.
    Indexing,
    /// Tracing camera paths; counted in pixels.
    Camera,
}

/// Receiver of progress reports, from any thread.
pub trait Monitor: Sync {
    /// Starts a stage of `total` units.
    fn begin(&self, stage: Stage, total: u64);
    /// Reports `units` more units as done.
    fn advance(&self, units: u64);
}

/// Monitor that ignores all reports.
#[derive(Clone, Copy, Debug)]
pub struct Silent;

impl Monitor for Silent {
    fn begin(&self, _: Stage, _: u64) {}
    fn advance(&self, _: u64) {}
}

/// Wall time of each stage \[s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Time of tracing photons.
    pub photons: f64,
    /// Time of indexing photons.
    pub indexing: f64,
    /// Time of tracing camera paths.
    pub camera: f64,
}

/// Photons of one map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhotonReport {
    /// Emitted paths.
    pub emitted: u64,
    /// Stored photons.
    pub stored: u64,
    /// Balance of their flux \[W].
    pub audit: EnergyAudit,
}

/// Expected memory of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expected {
    /// Photon paths of all maps.
    pub paths: u64,
    /// Stored photons of all maps, estimated.
    pub photons: u64,
    /// Stored photons of the largest map, estimated.
    pub most: u64,
}

/// Result of one pass.
#[derive(Clone, Debug, Default)]
pub struct Pass {
    /// Mean radiance of each pixel, by rows from the top \[W/(m² sr)].
    pub image: Vec<Rgb>,
    /// Work done.
    pub counters: Counters,
    /// Time of each stage.
    pub seconds: Seconds,
    /// Photons of the global map.
    pub global: PhotonReport,
    /// Photons of the caustic map.
    pub caustic: PhotonReport,
    /// Nested photon estimates of each pixel; empty unless requested.
    pub nested: Vec<NestedEstimates>,
    /// Some pixels by fresh camera paths, each with its index in `image`; empty unless passes share
    /// their paths.
    pub fresh: Vec<(u32, Rgb)>,
}

impl AddAssign for Seconds {
    fn add_assign(&mut self, o: Self) {
        self.photons += o.photons;
        self.indexing += o.indexing;
        self.camera += o.camera;
    }
}

impl AddAssign for PhotonReport {
    fn add_assign(&mut self, o: Self) {
        self.emitted += o.emitted;
        self.stored += o.stored;
        self.audit += o.audit;
    }
}
