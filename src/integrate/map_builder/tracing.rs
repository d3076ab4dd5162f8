//! Tracing of the photon paths of a pass.

use crate::integrate::pass::{PassResult, PassStage, PhotonReport, ProgressMonitor};
use crate::photon::{Deposits, LightTracer, Photon, PhotonTracer, Splat, TracedPhotons, VolumePhotons};
use crate::sampling::Key;
use std::ops::ControlFlow;
use std::time::Instant;

/// Set of photon paths to trace: their tracer, number and random key.
pub(super) struct PhotonTracingTask<'a> {
    /// Tracer with the photon source from which the paths start, and the kinds of photons to store;
    /// `None` traces nothing.
    pub tracer: Option<PhotonTracer<'a>>,
    /// Number of photon paths.
    pub paths: u32,
    pub key: Key,
    /// Light tracer that connects caustic photons to the camera; `None` without light tracing.
    pub light_tracer: Option<&'a LightTracer<'a>>,
}

/// Photons of one map, before its search structure is built.
pub(super) struct UnindexedMapPhotons {
    pub surface: Vec<Photon>,
    pub volume: VolumePhotons,
}

/// Photons and splats of the photon paths that are aimed at *casters*: mirrors, glass and other
/// surfaces that form caustics.
pub(super) struct AimedPhotons {
    /// Photons of the caustic map.
    pub caustic: UnindexedMapPhotons,
    /// Indirect light of caustics: photons that a diffuse surface, for example, has scattered after
    /// a caustic. They fill the indirect map of `hybrid`; other algorithms store none.
    pub after_caustic: UnindexedMapPhotons,
    pub splats: Vec<Splat>,
}

impl PhotonTracingTask<'_> {
    /// Emits and follows the photon paths of this task; none if the task has no tracer.
    ///
    /// Reports progress to `monitor`, and adds rays and time to `out`.
    pub fn trace_photons(self, monitor: &dyn ProgressMonitor, out: &mut PassResult) -> TracedPhotons {
        let Self { tracer, paths, key, light_tracer } = self;
        let Some(tracer) = tracer else { return TracedPhotons::default() };
        let start = Instant::now();
        monitor.begin_stage(PassStage::Photons, u64::from(paths));
        let traced = tracer.trace_and_connect(key, paths, light_tracer, &|n| {
            monitor.report_progress(n);
            if monitor.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        out.counters.photon_rays += traced.rays;
        out.counters.rejected_photons += traced.deposits.rejected_deposits;
        out.seconds.photons += start.elapsed().as_secs_f64();
        traced
    }
}

impl AimedPhotons {
    /// Divides the deposits of photon paths that are aimed at casters among the photon maps and the
    /// film.
    pub fn from_deposits(deposits: Deposits) -> Self {
        Self {
            caustic: UnindexedMapPhotons { surface: deposits.surface_photons, volume: deposits.volume_photons },
            after_caustic: UnindexedMapPhotons {
                surface: deposits.after_caustic_surface_photons,
                volume: deposits.after_caustic_volume_photons,
            },
            splats: deposits.splats,
        }
    }
}

/// Returns the number of emitted paths, the number of stored photons and the energy audit of
/// `traced`.
pub(super) fn photon_report(traced: &TracedPhotons) -> PhotonReport {
    PhotonReport { emitted_paths: traced.paths, stored_photons: traced.deposits.len() as u64, audit: traced.audit }
}
