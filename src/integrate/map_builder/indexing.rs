//! Search structures over the photons of a pass, and the gather radii of the pass.

use super::MapBuildOptions;
use super::tracing::UnindexedMapPhotons;
use crate::integrate::pass::{PassResult, PassStage, ProgressMonitor};
use crate::integrate::photon_maps::PhotonDensityEstimator;
use crate::integrate::radius_law::{RadiusLaw, kernel_radius_ratio, squared_radius_ratio};
use crate::integrate::radius_pilot::VolumeKernelRadii;
use crate::integrate::volume_estimate::{BeamAndPointMaps, VolumeEstimator};
use crate::photon::{Bandwidth, PhotonMap, VolumePhotons, thin_beams};
use crate::sampling::{Dimension, Purpose};
use crate::scene::Scene;
use std::time::Instant;

/// Half width of the density-estimation kernel over wavelengths in the first pass \[nm].
///
/// After dispersive glass, photons and camera paths carry a single wavelength. A density estimate
/// for such a camera path uses such a photon only if their wavelengths are at most this far apart.
const WAVELENGTH_KERNEL_HALF_WIDTH: f32 = 20.0;

/// Smallest value to which the photon limit k of density estimates shrinks from pass to pass. A k
/// that is smaller already in the first pass does not shrink.
const MIN_K: f64 = 8.0;

/// One value for each photon map.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PerMap<T> {
    pub caustic: T,
    pub indirect: T,
    pub interreflection: T,
}

/// Photons of a pass, before their search structures are built, for each photon map.
pub(super) struct UnindexedPassPhotons {
    pub caustic: UnindexedMapPhotons,
    pub indirect: UnindexedMapPhotons,
    /// Photons of the interreflection map of `hybrid`: indirect light that does not come from a
    /// caustic. `None` in other algorithms, or if camera paths carry all of this light.
    pub interreflection: Option<UnindexedMapPhotons>,
}

/// Gather radii of the first pass, and largest photon count, of the density estimates of one map.
#[derive(Clone, Copy)]
pub(super) struct DensityEstimateLimits {
    /// Largest radius of gather discs on surfaces \[length].
    pub surface_radius: f32,
    /// Radii of the density-estimation kernels in media \[length].
    pub volume_radii: VolumeKernelRadii,
    /// Largest number of photons of a density estimate; 0 means no limit.
    pub k: u32,
}

/// Builder of search structures over the photons of a pass.
pub(super) struct PhotonIndexer<'a, 'o> {
    pub scene: &'a Scene,
    pub options: &'o MapBuildOptions,
    /// Law by which the gather radii of the first pass shrink to those of this pass.
    pub radius_law: RadiusLaw,
    pub volume_estimator: VolumeEstimator,
    /// Lower bound on gather radii in the first pass \[length].
    pub min_radius: f32,
}

impl<'a> PhotonIndexer<'a, '_> {
    /// Builds the search structures of `photons`. Returns the caustic map, the indirect map, and
    /// the interreflection map, which only `hybrid` has. Reports progress to `monitor`, and adds
    /// the time to `out`.
    ///
    /// `limits` hold for density estimates in the first pass.
    pub fn index_photons(
        &self,
        photons: UnindexedPassPhotons,
        limits: &PerMap<DensityEstimateLimits>,
        monitor: &dyn ProgressMonitor,
        out: &mut PassResult,
    ) -> (PhotonDensityEstimator<'a>, PhotonDensityEstimator<'a>, Option<PhotonDensityEstimator<'a>>) {
        let start = Instant::now();
        let UnindexedPassPhotons { caustic, indirect, interreflection } = photons;
        let count = |photons: &UnindexedMapPhotons| (photons.surface.len() + photons.volume.len()) as u64;
        let caustic_count = count(&caustic);
        let other_count = count(&indirect) + interreflection.as_ref().map_or(0, count);
        monitor.begin_stage(PassStage::Indexing, caustic_count + other_count);
        let index = |photons: UnindexedMapPhotons, limits: DensityEstimateLimits| {
            let photon_count = count(&photons);
            let estimator = self.build_photon_estimator(photons, limits);
            monitor.report_progress(photon_count);
            estimator
        };

        let index_caustic = || index(caustic, limits.caustic);
        let index_indirect = || index(indirect, limits.indirect);
        let index_interreflection = || interreflection.map(|photons| index(photons, limits.interreflection));
        // Let the calling thread build the larger part, so that it works until the stage ends.
        let (caustic, (indirect, interreflection)) = if caustic_count < other_count {
            let (others, caustic) =
                join_on_calling_thread(|| (index_indirect(), index_interreflection()), index_caustic);
            (caustic, others)
        } else {
            join_on_calling_thread(index_caustic, || rayon::join(index_indirect, index_interreflection))
        };
        out.seconds.indexing += start.elapsed().as_secs_f64();
        (caustic, indirect, interreflection)
    }

    /// Builds the search structures of the photons of one map. Returns the map with the gather
    /// radii of this pass. `limits` hold for density estimates in the first pass.
    fn build_photon_estimator(
        &self,
        photons: UnindexedMapPhotons,
        limits: DensityEstimateLimits,
    ) -> PhotonDensityEstimator<'a> {
        let DensityEstimateLimits { surface_radius, volume_radii, k } = limits;
        // Shrink the radii of the first pass to those of this pass.
        let (pass, RadiusLaw { alpha, kernel }) = (self.options.pass, self.radius_law);
        let area = squared_radius_ratio(alpha, pass);
        let (beam_dimensions, point_dimensions) = self.volume_estimator.kernel_dimensions();
        let shrunk_volume_radii = (
            volume_radii.beams * kernel_radius_ratio(beam_dimensions, alpha, pass),
            volume_radii.points * kernel_radius_ratio(point_dimensions, alpha, pass),
        );
        let band = WAVELENGTH_KERNEL_HALF_WIDTH * area.sqrt() as f32;
        let limit = if self.options.has_photon_limit { k } else { 0 };
        let shrunk_k = (f64::from(limit) * area).round().max(MIN_K) as u32;
        let bandwidth = Bandwidth { radius: surface_radius * area.sqrt() as f32, k: shrunk_k.min(limit) };

        // Build the search structures. One random number can thin the beams of all maps, because
        // thinning keeps the expected flux of each beam.
        let first = self.options.photon_path_key(Purpose::BeamThinning).uniform_1d(Dimension::Roulette);
        let beams = thin_beams(photons.volume.beams, volume_radii.kept_beam_fraction, first);
        let volume_photons = VolumePhotons { beams, ..photons.volume };
        let volume = BeamAndPointMaps::build(volume_photons, shrunk_volume_radii, self.volume_estimator, band);
        let map = PhotonMap::build(photons.surface).with_min_radius(self.min_radius * area.sqrt() as f32);
        PhotonDensityEstimator { scene: self.scene, map, bandwidth, kernel, volume, has_density_estimate_shares: false }
    }
}

/// Runs both closures in parallel and returns their results. The calling thread runs `here`, and
/// the thread pool runs `elsewhere`.
///
/// Unlike with `rayon::join`, a thread outside of the pool runs `here` itself. With one thread, the
/// closures run one after the other.
fn join_on_calling_thread<A, B: Send>(here: impl FnOnce() -> A, elsewhere: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_num_threads() == 1 {
        return (here(), elsewhere());
    }
    let mut found = None;
    let own = rayon::in_place_scope(|scope| {
        scope.spawn(|_| found = Some(elsewhere()));
        here()
    });
    let Some(found) = found else { unreachable!("the scope waits for its tasks") };
    (own, found)
}
