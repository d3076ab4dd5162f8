//! Result of a pass, and progress reports about it.

use super::nested_differences::NestedDifferences;
use crate::color::Rgb;
use crate::photon::EnergyAudit;
use crate::stats::Counters;
use serde::Serialize;
use std::ops::AddAssign;

/// Stage of the work of a pass, for progress reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassStage {
    /// Photon tracing. Progress counts photon paths.
    Photons,
    /// Construction of the photon maps. Progress counts photons.
    Indexing,
    /// Tracing of camera paths. Progress counts pixels.
    Camera,
}

/// Callback interface for the progress of passes. Any thread may call it.
pub trait ProgressMonitor: Sync {
    /// Reports the start of a stage of `total` units; see [`PassStage`] for the unit.
    fn begin_stage(&self, stage: PassStage, total: u64);
    /// Reports that `units` more units of the current stage are done.
    fn report_progress(&self, units: u64);
    /// True if the pass should be abandoned. Its remaining photons and pixels are then skipped, and
    /// its result is discarded.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// [`ProgressMonitor`] that ignores all reports.
#[derive(Clone, Copy, Debug)]
pub struct SilentMonitor;

impl ProgressMonitor for SilentMonitor {
    fn begin_stage(&self, _: PassStage, _: u64) {}
    fn report_progress(&self, _: u64) {}
}

/// Wall time of each stage of a pass \[s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, serde::Deserialize)]
pub struct StageTimes {
    /// Time of photon tracing \[s].
    pub photons: f64,
    /// Time of building the photon maps \[s].
    pub indexing: f64,
    /// Time of tracing camera paths \[s].
    pub camera: f64,
}

/// Counts and energy balance of one set of photon paths: paths aimed at casters (mirrors, glass),
/// or paths that start in all directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, serde::Deserialize)]
pub struct PhotonReport {
    /// Number of photon paths of the set, including paths that started without flux.
    #[serde(rename = "emitted")]
    pub emitted_paths: u64,
    /// Number of stored photons and photon beams.
    #[serde(rename = "stored")]
    pub stored_photons: u64,
    /// Flux \[W] that the paths emitted, and the parts of it that were absorbed, escaped from the
    /// scene, or were lost where paths ended early.
    pub audit: EnergyAudit,
}

/// Expected numbers of photon paths and stored photons of a pass, from which its memory is
/// estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExpectedPhotons {
    /// Number of photon paths that a pass traces for all maps.
    pub paths: u64,
    /// Expected number of stored photons of all maps. A photon beam counts as four photons, because
    /// it takes as much memory.
    pub memory_in_photons: u64,
    /// Expected number of stored photons in the largest map. A photon beam counts as four photons,
    /// because it takes as much memory.
    pub largest_map_in_photons: u64,
}

/// Result of one pass.
#[derive(Clone, Debug, Default)]
pub struct PassResult {
    /// Mean radiance of each pixel of the rendered window, by rows from the top \[W/(m² sr)].
    pub image: Vec<Rgb>,
    /// Counts of rays and photons.
    pub counters: Counters,
    /// Wall time of each stage.
    pub seconds: StageTimes,
    /// Report on the photon paths that start in all directions.
    pub unaimed: PhotonReport,
    /// Report on the photon paths that are aimed at casters, such as mirrors and glass.
    ///
    /// These paths fill the caustic map, and in `hybrid` the indirect map too.
    pub aimed: PhotonReport,
    /// Differences between photon estimates with gather discs of full, half and quarter area, for
    /// each pixel. Empty unless the error is estimated and the algorithm reads photon maps.
    pub nested: Vec<NestedDifferences>,
    /// Radiance of each pixel \[W/(m² sr)], for each light group in the order of
    /// [`LightGroup::ALL`](super::LightGroup::ALL). The groups add up to `image`.
    ///
    /// Empty unless [`CameraPathSettings::groups_light`](super::CameraPathSettings::groups_light)
    /// is true.
    pub light_groups: Vec<Vec<Rgb>>,
    /// Radiance that clamping removed from each pixel \[W/(m² sr)].
    ///
    /// Empty unless [`CameraPathSettings::clamp`](super::CameraPathSettings::clamp) is set.
    pub removed_by_clamp: Vec<Rgb>,
    /// Some pixels of `image`, rendered a second time with camera paths that only this pass traces.
    /// Each pair holds the pixel's index in `image`, and its radiance \[W/(m² sr)] by these paths.
    ///
    /// If all passes share the camera paths of `image`, more passes do not reduce the error of
    /// these paths. The difference between a pair's radiance and `image` then shows this error. The
    /// list is empty if passes do not share camera paths, or if the error is not estimated.
    pub unshared_path_pixels: Vec<(u32, Rgb)>,
}

impl AddAssign for StageTimes {
    fn add_assign(&mut self, o: Self) {
        self.photons += o.photons;
        self.indexing += o.indexing;
        self.camera += o.camera;
    }
}

impl AddAssign for PhotonReport {
    fn add_assign(&mut self, o: Self) {
        self.emitted_paths += o.emitted_paths;
        self.stored_photons += o.stored_photons;
        self.audit += o.audit;
    }
}
