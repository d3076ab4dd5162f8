//! Construction of the photon maps of a pass.

mod options;
mod pilots;

pub(super) use options::{MapBuildOptions, PhotonPathCounts};

use options::photon_limit;

use super::indirect_division::{IndirectDivision, IndirectTechnique};
use super::pass::{PassResult, PassStage, PhotonReport, ProgressMonitor};
use super::photon_maps::{PhotonDensityEstimator, PhotonMaps};
use super::policy::{PathPolicy, PhotonMapRequest};
use super::radius_law::{RadiusLaw, kernel_radius_ratio, squared_radius_ratio};
use super::radius_pilot::{EmissionGuidingReports, GatherRadii, VolumeKernelRadii, min_gather_radius};
use super::settings::{IndirectPhotons, Settings};
use super::volume_estimate::{BeamAndPointMaps, VolumeEstimator};
use crate::photon::{
    AFTER_CAUSTIC_THINNING, Bandwidth, DensityEstimateShares, LightTracer, Photon, PhotonMap, PhotonSource,
    PhotonTracer, Splat, StoreMask, TracedPhotons, VolumePhotons, thin_beams,
};
use crate::sampling::{Dimension, Key, Purpose};
use crate::scene::{Effect, Effects, Scene};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

/// Default limit k on the number of photons of a density estimate in the caustic map.
pub const DEFAULT_CAUSTIC_K: u32 = 50;

/// Number of photon paths that fill the indirect map of a pass, divided by the number that a pass
/// traces to guide final-gathering rays.
const GUIDE_PHOTON_DIVISOR: u32 = 16;

/// Half width of the density-estimation kernel over wavelengths in the first pass \[nm].
///
/// After dispersive glass, photons and camera paths carry a single wavelength. A density estimate
/// for such a camera path uses such a photon only if their wavelengths are at most this far apart.
const WAVELENGTH_KERNEL_HALF_WIDTH: f32 = 20.0;

/// Smallest value to which the photon limit k of density estimates shrinks from pass to pass. A k
/// that is smaller already in the first pass does not shrink.
const MIN_K: f64 = 8.0;

/// Set of photon paths to trace: their source, number and random key, and the kinds of photons to
/// store.
struct PhotonTracingTask<'a> {
    /// Photon source from which the paths start; `None` traces nothing.
    source: Option<&'a PhotonSource<'a>>,
    mask: StoreMask,
    /// Number of photon paths.
    paths: u32,
    key: Key,
    /// Light tracer that connects caustic photons to the camera; `None` without light tracing.
    light_tracer: Option<&'a LightTracer<'a>>,
}

/// Photons of one map, before its search structure is built.
struct UnindexedMapPhotons {
    surface: Vec<Photon>,
    volume: VolumePhotons,
}

/// Gather radii of one map in the first pass \[length].
#[derive(Clone, Copy)]
struct MapRadii {
    /// Largest radius of gather discs on surfaces \[length].
    surface: f32,
    /// Radii of the density-estimation kernels in media \[length].
    volume: VolumeKernelRadii,
}

/// Gather radii and largest photon count of the density estimates of one map.
#[derive(Clone, Copy)]
struct DensityEstimateLimits {
    radii: MapRadii,
    /// Largest number of photons of a density estimate; 0 means no limit.
    k: u32,
}

/// Photons and splats of the photon paths that are aimed at *casters*: mirrors, glass and other
/// surfaces that form caustics.
struct AimedPhotons {
    /// Photons of the caustic map.
    caustic: UnindexedMapPhotons,
    /// Indirect light of caustics: photons that a diffuse surface, for example, has scattered after
    /// a caustic. They fill the indirect map of `hybrid`; other algorithms store none.
    after_caustic: UnindexedMapPhotons,
    splats: Vec<Splat>,
}

/// Photons of a pass, before their search structures are built, for each photon map.
struct UnindexedPassPhotons {
    caustic: UnindexedMapPhotons,
    indirect: UnindexedMapPhotons,
    /// Photons of the interreflection map of `hybrid`: indirect light that does not come from a
    /// caustic. `None` in other algorithms, or if camera paths carry all of this light.
    interreflection: Option<UnindexedMapPhotons>,
}

/// Radii of the density-estimation kernels in media, for each photon map \[length].
#[derive(Clone, Copy, Debug, Default)]
struct VolumeKernelRadiiPerMap {
    caustic: VolumeKernelRadii,
    indirect: VolumeKernelRadii,
    interreflection: VolumeKernelRadii,
}

/// Builder of the photon maps of any pass. It holds the photon sources and the gather radii of the
/// first pass.
///
/// A table in [`integrate`](super) lists the maps, and the photon paths that fill them.
#[derive(Debug)]
pub(super) struct PhotonMapBuilder<'a> {
    scene: &'a Scene,
    settings: Settings,
    policy: PathPolicy,
    pub request: PhotonMapRequest,
    /// Source of the unaimed photon paths, which start in all directions; `None` if passes trace no
    /// such paths.
    unaimed_source: Option<PhotonSource<'a>>,
    /// Source of the photon paths aimed at casters, such as mirrors and glass; `None` if passes
    /// trace no such paths. The source emits in all directions if no light reaches a caster.
    aimed_source: Option<PhotonSource<'a>>,
    pub counts: PhotonPathCounts,
    /// Largest gather radii of the first pass \[length]; `None` if passes trace no photons.
    pub radii: Option<GatherRadii>,
    /// Gather radius in the first pass of the interreflection map \[length]: the map of indirect
    /// light that does not come from caustics. Only `hybrid` builds this map.
    interreflection_radius: f32,
    /// Division of indirect light between camera paths and photon estimates, as a pilot (small
    /// simulation before the first pass) found it. `None` without such a pilot, or if the pilot
    /// left all of this light to camera paths.
    pub division: Option<Arc<IndirectDivision>>,
    /// True if camera paths and photon estimates both find all indirect light that does not come
    /// from caustics. A pilot (small simulation before the first pass) uses this to compare the two
    /// techniques.
    pub compares_techniques: bool,
    /// Radii of the density-estimation kernels in media in the first pass, for each map \[length].
    volume_radii: VolumeKernelRadiiPerMap,
    /// Lower bound on gather radii in the first pass \[length].
    min_radius: f32,
    pub emission_guiding_reports: EmissionGuidingReports,
    /// For each pixel, the fraction of a caustic photon's flux that density estimates use; light
    /// tracing (photons connected to the camera) carries the rest. `None` without light tracing.
    density_estimate_shares: Option<Arc<DensityEstimateShares>>,
}

impl<'a> PhotonMapBuilder<'a> {
    /// Makes a builder for the photon maps that `policy` reads.
    ///
    /// Runs the pilots (small simulations) that guide photon emission, and the pilots that find
    /// gather radii if `settings` give none.
    pub fn new(scene: &'a Scene, settings: Settings, policy: PathPolicy) -> Self {
        let mut request = policy.photon_map_request();
        if policy.indirect_photons != IndirectPhotons::Off && has_emitting_media(scene, policy.effects) {
            // Photons never start in media, so photon maps miss the light that media emit. If media
            // emit light, `hybrid` therefore traces no unaimed photon paths: camera paths carry all
            // indirect light that does not come from caustics.
            request.unaimed = StoreMask::NONE;
        }
        let source = |mask: StoreMask, paths: u32, new_source: &dyn Fn() -> Option<PhotonSource<'a>>| {
            if paths == 0 || mask == StoreMask::NONE {
                return None;
            }
            restrict_to_effects(new_source()?, policy.effects)
        };
        // If a user forces the effect of caustics on in a scene without lit casters, aimed paths
        // start in all directions.
        let aimed =
            || PhotonSource::aimed_at_casters(scene).or_else(|| PhotonSource::emitting_in_all_directions(scene));
        let aimed_source = source(request.aimed, settings.aimed_paths, &aimed);
        let unaimed_source =
            source(request.unaimed, settings.unaimed_paths, &|| PhotonSource::emitting_in_all_directions(scene));
        let counts = PhotonPathCounts { unaimed: settings.unaimed_paths, aimed: settings.aimed_paths };
        let mut builder = Self {
            scene,
            settings,
            policy,
            request,
            unaimed_source,
            aimed_source,
            counts,
            radii: None,
            interreflection_radius: 0.0,
            division: None,
            compares_techniques: false,
            volume_radii: VolumeKernelRadiiPerMap::default(),
            min_radius: 0.0,
            emission_guiding_reports: EmissionGuidingReports::default(),
            density_estimate_shares: None,
        };
        if builder.traces_photons() {
            builder.min_radius = min_gather_radius(scene);
        }
        builder.guide_emission();
        if builder.traces_photons() {
            builder.radii = Some(builder.find_gather_radii());
        }
        if builder.stores_volume_photons() {
            builder.volume_radii = builder.find_volume_kernel_radii();
        }
        builder
    }

    /// Returns a builder for `policy`, which must be this builder's policy with fewer effects of
    /// light. The new builder keeps the results of pilots.
    pub fn with_policy(&self, policy: &PathPolicy) -> Self {
        let request = policy.photon_map_request();
        let keep = |source: &Option<PhotonSource<'a>>, mask: StoreMask| {
            let source = source.clone().filter(|_| mask != StoreMask::NONE)?;
            restrict_to_effects(source, policy.effects)
        };
        Self {
            settings: self.settings.clone(),
            density_estimate_shares: self.density_estimate_shares.clone(),
            division: self.division.clone(),
            policy: *policy,
            request,
            unaimed_source: keep(&self.unaimed_source, request.unaimed),
            aimed_source: keep(&self.aimed_source, request.aimed),
            ..*self
        }
    }

    /// Returns a builder for `scene`, which must be the same scene at another shutter time. The new
    /// builder keeps the results of pilots.
    pub fn for_scene_at_time<'b>(&self, scene: &'b Scene) -> PhotonMapBuilder<'b> {
        let placed = |source: &Option<PhotonSource<'a>>| source.as_ref().map(|source| source.for_scene_at_time(scene));
        PhotonMapBuilder {
            scene,
            settings: self.settings.clone(),
            density_estimate_shares: self.density_estimate_shares.clone(),
            division: self.division.clone(),
            unaimed_source: placed(&self.unaimed_source),
            aimed_source: placed(&self.aimed_source),
            ..*self
        }
    }

    /// Returns the photon source of the indirect map, the kinds of photons that the map stores, and
    /// its number of photon paths per pass.
    ///
    /// In `hybrid`, photon paths that are aimed at casters, such as glass, fill this map. Russian
    /// roulette continues only one in [`AFTER_CAUSTIC_THINNING`] of these paths after a caustic. So
    /// the returned number is the number of all aimed paths, divided by that constant.
    fn indirect_map_inputs(&self) -> (&Option<PhotonSource<'a>>, StoreMask, u32) {
        if self.aimed_paths_fill_indirect_map() {
            let mask = StoreMask { after_caustic: true, ..StoreMask::NONE };
            (&self.aimed_source, mask, self.settings.aimed_paths / AFTER_CAUSTIC_THINNING)
        } else {
            (&self.unaimed_source, self.request.unaimed, self.settings.unaimed_paths)
        }
    }

    /// True if photon paths aimed at casters (mirrors, glass) fill the indirect map, as in
    /// `hybrid`. The map then holds only light that other surfaces or media have scattered after a
    /// caustic. False if unaimed paths fill it with all indirect light.
    fn aimed_paths_fill_indirect_map(&self) -> bool {
        self.request.aimed.separates_after_caustic || self.may_build_interreflection_map()
    }

    /// True if passes may build an interreflection map, with the indirect light that does not come
    /// from caustics. Only `hybrid` builds one.
    pub fn may_build_interreflection_map(&self) -> bool {
        self.policy.indirect_photons != IndirectPhotons::Off && self.unaimed_source.is_some()
    }

    /// Returns the area of gather discs in pass `pass`, divided by the area in the first pass.
    /// Passes are counted from 0.
    pub fn relative_disc_area(&self, pass: u32) -> f64 {
        squared_radius_ratio(self.radius_law().alpha, pass)
    }

    /// Sets how indirect light is divided between camera paths and photon estimates.
    ///
    /// The division also sets the number of photon paths that start in all directions. `None`
    /// leaves this light to camera paths, so that no photon paths start in all directions.
    pub fn set_division(&mut self, division: Option<IndirectDivision>) {
        if let Some(division) = &division {
            self.counts.unaimed = division.unaimed_paths;
        } else {
            self.unaimed_source = None;
            self.emission_guiding_reports.unaimed = None;
        }
        self.division = division.map(Arc::new);
    }

    /// Returns the technique that finds indirect light in pass `pass`, at the first receiver
    /// (surface or medium that stores photons) of each camera path.
    pub fn technique_of_pass(&self, pass: u32) -> IndirectTechnique<'_> {
        if !self.may_build_interreflection_map() {
            return IndirectTechnique::Paths;
        }
        if self.compares_techniques {
            return IndirectTechnique::Comparison;
        }
        if self.policy.indirect_photons == IndirectPhotons::Full {
            return IndirectTechnique::Photons;
        }
        match self.division.as_deref() {
            Some(division) if pass < division.passes_with_photons => IndirectTechnique::Weighted {
                division,
                pass_count: pass as f32 + 1.0,
                relative_disc_area: self.relative_disc_area(pass) as f32,
            },
            _ => IndirectTechnique::Paths,
        }
    }

    /// True if passes store photons in media.
    fn stores_volume_photons(&self) -> bool {
        let effects = self.policy.effects;
        let media = effects.has(Effect::Media) && effects.has(Effect::Interiors);
        media && self.traces_photons() && self.scene.media_in_use().iter().any(|medium| medium.scatters())
    }

    /// Returns a copy of `mask` in which `stores_beams` suits the estimator for media: true if the
    /// estimator reads photon beams, false if it reads photon points.
    fn mask_for_volume_estimator(&self, mask: StoreMask) -> StoreMask {
        StoreMask { stores_beams: self.settings.volume_estimator == VolumeEstimator::Beams, ..mask }
    }

    /// Returns the law by which gather radii shrink from pass to pass.
    pub fn radius_law(&self) -> RadiusLaw {
        let alpha = if self.policy.shrinking_radii { self.settings.alpha } else { 1.0 };
        RadiusLaw { alpha, kernel: self.settings.kernel }
    }

    /// True if passes trace photons.
    pub fn traces_photons(&self) -> bool {
        self.aimed_source.is_some() || self.unaimed_source.is_some()
    }

    /// True if camera rays start at random points of the lens; false if at its center.
    fn uses_lens(&self) -> bool {
        self.policy.effects.has(Effect::Lens)
    }

    /// Traces the photons that `options` describe, and builds their maps. Adds ray counts, reports
    /// and times to `out`.
    pub fn build(
        &self,
        options: &MapBuildOptions,
        monitor: &dyn ProgressMonitor,
        out: &mut PassResult,
    ) -> PhotonMaps<'a> {
        let AimedPhotons { caustic, after_caustic, splats } = self.trace_aimed_photons(options, monitor, out);
        let indirect = if self.aimed_paths_fill_indirect_map() {
            after_caustic
        } else {
            self.trace_unaimed_photons(options, monitor, out)
        };
        let technique = self.technique_of_pass(options.pass);
        let has_interreflection = !matches!(technique, IndirectTechnique::Paths);
        let interreflection = has_interreflection.then(|| self.trace_unaimed_photons(options, monitor, out));
        let guides = PhotonMap::build(self.trace_guide_photons(options, monitor, out));

        let photons = UnindexedPassPhotons { caustic, indirect, interreflection };
        let (caustic, indirect, interreflection) = self.index_photons(photons, options, monitor, out);
        PhotonMaps { guides, caustic, indirect, interreflection, splats }
    }

    /// Returns the light tracer that connects the caustic photons of a pass to the camera; `None`
    /// without light tracing.
    fn light_tracer(&self, options: &MapBuildOptions) -> Option<LightTracer<'_>> {
        let shares = self.density_estimate_shares.as_deref().filter(|_| options.connects_to_camera);
        shares.map(|shares| LightTracer::new(self.scene, self.uses_lens(), Some(shares.in_pass(options.pass))))
    }

    /// Traces the photon paths aimed at casters, such as mirrors and glass. Returns their photons
    /// and their splats on the film.
    ///
    /// Reports progress to `monitor`. Adds ray counts, time and the report on these paths to `out`.
    fn trace_aimed_photons(
        &self,
        options: &MapBuildOptions,
        monitor: &dyn ProgressMonitor,
        out: &mut PassResult,
    ) -> AimedPhotons {
        let light_tracer = self.light_tracer(options);
        let task = PhotonTracingTask {
            source: self.aimed_source.as_ref(),
            mask: self.request.aimed,
            paths: self.counts.divided_by(options.photon_path_divisor).aimed,
            key: options.photon_path_key(Purpose::AimedPhotons),
            light_tracer: light_tracer.as_ref(),
        };
        let traced = self.trace_photons(task, monitor, out);
        out.aimed += photon_report(&traced);
        let deposits = traced.deposits;
        AimedPhotons {
            caustic: UnindexedMapPhotons { surface: deposits.surface_photons, volume: deposits.volume_photons },
            after_caustic: UnindexedMapPhotons {
                surface: deposits.after_caustic_surface_photons,
                volume: deposits.after_caustic_volume_photons,
            },
            splats: deposits.splats,
        }
    }

    /// Traces the photon paths that start in all directions, and returns their photons. Adds ray
    /// counts, time and the report on these paths to `out`.
    fn trace_unaimed_photons(
        &self,
        options: &MapBuildOptions,
        monitor: &dyn ProgressMonitor,
        out: &mut PassResult,
    ) -> UnindexedMapPhotons {
        let task = PhotonTracingTask {
            source: self.unaimed_source.as_ref(),
            mask: self.request.unaimed,
            paths: self.counts.divided_by(options.photon_path_divisor).unaimed,
            key: options.photon_path_key(Purpose::UnaimedPhotons),
            light_tracer: None,
        };
        let traced = self.trace_photons(task, monitor, out);
        out.unaimed += photon_report(&traced);
        UnindexedMapPhotons { surface: traced.deposits.surface_photons, volume: traced.deposits.volume_photons }
    }

    /// Traces the photons that guide final-gathering rays, and returns them; empty if the policy
    /// does not guide these rays.
    fn trace_guide_photons(
        &self,
        options: &MapBuildOptions,
        monitor: &dyn ProgressMonitor,
        out: &mut PassResult,
    ) -> Vec<Photon> {
        if !self.request.builds_guide_map {
            return Vec::new();
        }
        let task = PhotonTracingTask {
            source: self.unaimed_source.as_ref(),
            mask: StoreMask::INDIRECT,
            paths: self.counts.divided_by(options.photon_path_divisor).unaimed / GUIDE_PHOTON_DIVISOR,
            key: options.photon_path_key(Purpose::GatherRayGuides),
            light_tracer: None,
        };
        self.trace_photons(task, monitor, out).deposits.surface_photons
    }

    /// Returns the default photon limit of caustic density estimates. It grows with the number of
    /// photon paths aimed at casters such as glass, so that gather discs keep their size.
    fn default_caustic_k(&self) -> u32 {
        let ratio = f64::from(self.counts.aimed) / f64::from(self.settings.aimed_paths.max(1));
        (f64::from(DEFAULT_CAUSTIC_K) * ratio).round().max(1.0) as u32
    }

    /// Builds the search structures of `photons`. Returns the caustic map, the indirect map, and
    /// the interreflection map, which only `hybrid` has. Reports progress to `monitor`, and adds
    /// the time to `out`.
    fn index_photons(
        &self,
        photons: UnindexedPassPhotons,
        options: &MapBuildOptions,
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
            let estimator = self.build_photon_estimator(photons, limits, options);
            monitor.report_progress(photon_count);
            estimator
        };

        let usual_k = self.default_caustic_k();
        let limits = |surface: f32, volume: VolumeKernelRadii, usual_k: u32| DensityEstimateLimits {
            radii: MapRadii { surface, volume },
            k: photon_limit(self.settings.gather_k.unwrap_or(usual_k), options.photon_path_divisor),
        };
        let radius = |of_map: fn(GatherRadii) -> f32| self.radii.map_or(1.0, of_map);
        let index_caustic = || {
            let limits = limits(radius(|radii| radii.caustic), self.volume_radii.caustic, usual_k);
            let mut estimator = index(caustic, limits);
            estimator.has_density_estimate_shares = self.light_tracer(options).is_some();
            estimator
        };
        let index_indirect = || index(indirect, limits(radius(|radii| radii.indirect), self.volume_radii.indirect, 0));
        let index_interreflection = || {
            let limits = limits(self.interreflection_radius, self.volume_radii.interreflection, 0);
            interreflection.map(|photons| index(photons, limits))
        };
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
    /// radii of pass `options.pass`.
    fn build_photon_estimator(
        &self,
        photons: UnindexedMapPhotons,
        DensityEstimateLimits { radii, k }: DensityEstimateLimits,
        options: &MapBuildOptions,
    ) -> PhotonDensityEstimator<'a> {
        // Shrink the radii of the first pass to those of this pass.
        let (pass, RadiusLaw { alpha, kernel }) = (options.pass, self.radius_law());
        let area = squared_radius_ratio(alpha, pass);
        let (beam_dimensions, point_dimensions) = self.settings.volume_estimator.kernel_dimensions();
        let volume_radii = (
            radii.volume.beams * kernel_radius_ratio(beam_dimensions, alpha, pass),
            radii.volume.points * kernel_radius_ratio(point_dimensions, alpha, pass),
        );
        let band = WAVELENGTH_KERNEL_HALF_WIDTH * area.sqrt() as f32;
        let limit = if options.has_photon_limit { k } else { 0 };
        let shrunk_k = (f64::from(limit) * area).round().max(MIN_K) as u32;
        let bandwidth = Bandwidth { radius: radii.surface * area.sqrt() as f32, k: shrunk_k.min(limit) };

        // Build the search structures. One random number can thin the beams of all maps, because
        // thinning keeps the expected flux of each beam.
        let first = options.photon_path_key(Purpose::BeamThinning).uniform_1d(Dimension::Roulette);
        let beams = thin_beams(photons.volume.beams, radii.volume.kept_beam_fraction, first);
        let volume_photons = VolumePhotons { beams, ..photons.volume };
        let volume = BeamAndPointMaps::build(volume_photons, volume_radii, self.settings.volume_estimator, band);
        let map = PhotonMap::build(photons.surface).with_min_radius(self.min_radius * area.sqrt() as f32);
        PhotonDensityEstimator { scene: self.scene, map, bandwidth, kernel, volume, has_density_estimate_shares: false }
    }

    /// Returns a tracer of photon paths from `source` that stores the kinds of photons of `mask`.
    fn photon_tracer<'b>(&'b self, source: &'b PhotonSource<'a>, mask: StoreMask) -> PhotonTracer<'b> {
        PhotonTracer { scene: self.scene, source, mask, max_bounces: self.settings.camera_paths.max_bounces }
    }

    /// Emits and follows the photon paths of `task`; none if the task has no source.
    ///
    /// Reports progress to `monitor`, and adds rays and time to `out`.
    fn trace_photons(
        &self,
        task: PhotonTracingTask<'_>,
        monitor: &dyn ProgressMonitor,
        out: &mut PassResult,
    ) -> TracedPhotons {
        let PhotonTracingTask { source, mask, paths, key, light_tracer } = task;
        let Some(source) = source else { return TracedPhotons::default() };
        let start = Instant::now();
        monitor.begin_stage(PassStage::Photons, u64::from(paths));
        let photon_tracer = self.photon_tracer(source, self.mask_for_volume_estimator(mask));
        let traced = photon_tracer.trace_and_connect(key, paths, light_tracer, &|n| {
            monitor.report_progress(n);
            if monitor.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        out.counters.photon_rays += traced.rays;
        out.counters.rejected_photons += traced.deposits.rejected_deposits;
        out.seconds.photons += start.elapsed().as_secs_f64();
        traced
    }
}

/// True if `effects` simulate media and the scene uses media that emit light.
pub(super) fn has_emitting_media(scene: &Scene, effects: Effects) -> bool {
    effects.has(Effect::Media) && scene.media_in_use().iter().any(|medium| medium.emits())
}

/// Returns `source` restricted to the light that `effects` simulate; `None` if no light is left.
fn restrict_to_effects<'a>(source: PhotonSource<'a>, effects: Effects) -> Option<PhotonSource<'a>> {
    let source = source.with_effects(effects);
    if effects.has(Effect::Environment) { Some(source) } else { source.without_environment_light() }
}

/// Returns the number of emitted paths, the number of stored photons and the energy audit of
/// `traced`.
fn photon_report(traced: &TracedPhotons) -> PhotonReport {
    PhotonReport { emitted_paths: traced.paths, stored_photons: traced.deposits.len() as u64, audit: traced.audit }
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
