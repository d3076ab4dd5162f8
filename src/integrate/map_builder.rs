//! Construction of the photon maps of a pass: photons are traced (`tracing.rs`) from their sources
//! (`sources.rs`), and then search structures over them are built (`indexing.rs`). `options.rs`
//! states the pass and its numbers of photon paths. Pilots before the first pass (`pilots.rs`) find
//! gather radii and guide photon emission.

mod indexing;
mod options;
mod pilots;
mod sources;
mod tracing;

pub(super) use options::{MapBuildOptions, PhotonPathCounts};

use indexing::{DensityEstimateLimits, PerMap, PhotonIndexer, UnindexedPassPhotons};
use options::photon_limit;
use sources::PhotonSources;
use tracing::{AimedPhotons, PhotonTracingTask, UnindexedMapPhotons, photon_report};

use super::indirect_division::{IndirectDivision, IndirectTechnique};
use super::pass::{PassResult, ProgressMonitor};
use super::photon_maps::PhotonMaps;
use super::policy::{PathPolicy, PhotonMapRequest};
use super::radius_law::{RadiusLaw, squared_radius_ratio};
use super::radius_pilot::{EmissionGuidingReports, GatherRadii, VolumeKernelRadii, min_gather_radius};
use super::settings::{IndirectPhotons, Settings};
use super::volume_estimate::VolumeEstimator;
use crate::photon::{
    AFTER_CAUSTIC_THINNING, DensityEstimateShares, LightTracer, Photon, PhotonMap, PhotonSource, PhotonTracer,
    StoreMask,
};
use crate::sampling::Purpose;
use crate::scene::{Effect, Scene};
use std::sync::Arc;

/// Default limit k on the number of photons of a density estimate in the caustic map.
pub const DEFAULT_CAUSTIC_K: u32 = 50;

/// Number of photon paths that fill the indirect map of a pass, divided by the number that a pass
/// traces to guide final-gathering rays.
const GUIDE_PHOTON_DIVISOR: u32 = 16;

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
    sources: PhotonSources<'a>,
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
    /// True in the pilot (small simulation before the first pass) that compares camera paths with
    /// photon estimates. Each of the two techniques then estimates all indirect light that does not
    /// come from caustics, while passes count this light only once.
    pub compares_techniques: bool,
    /// Radii of the density-estimation kernels in media in the first pass, for each map \[length].
    volume_radii: PerMap<VolumeKernelRadii>,
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
        if policy.indirect_photons != IndirectPhotons::Off
            && policy.effects.has(Effect::Media)
            && scene.has_emitting_media()
        {
            // Photons never start in media, so photon maps miss the light that media emit. If media
            // emit light, `hybrid` therefore traces no unaimed photon paths: camera paths carry all
            // indirect light that does not come from caustics.
            request.unaimed = StoreMask::NONE;
        }
        let counts = PhotonPathCounts { unaimed: settings.unaimed_paths, aimed: settings.aimed_paths };
        let mut builder = Self {
            scene,
            sources: PhotonSources::new(scene, &settings, request, policy.effects),
            settings,
            policy,
            request,
            counts,
            radii: None,
            interreflection_radius: 0.0,
            division: None,
            compares_techniques: false,
            volume_radii: PerMap::default(),
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
        Self {
            settings: self.settings.clone(),
            density_estimate_shares: self.density_estimate_shares.clone(),
            division: self.division.clone(),
            policy: *policy,
            request,
            sources: self.sources.restricted_to(request, policy.effects),
            ..*self
        }
    }

    /// Returns a builder for `scene`, which must be the same scene at another shutter time. The new
    /// builder keeps the results of pilots.
    pub fn for_scene_at_time<'b>(&self, scene: &'b Scene) -> PhotonMapBuilder<'b> {
        PhotonMapBuilder {
            scene,
            settings: self.settings.clone(),
            density_estimate_shares: self.density_estimate_shares.clone(),
            division: self.division.clone(),
            sources: self.sources.for_scene_at_time(scene),
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
            (&self.sources.aimed, mask, self.settings.aimed_paths / AFTER_CAUSTIC_THINNING)
        } else {
            (&self.sources.unaimed, self.request.unaimed, self.settings.unaimed_paths)
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
        self.policy.indirect_photons != IndirectPhotons::Off && self.sources.unaimed.is_some()
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
            self.sources.unaimed = None;
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
        !self.sources.is_empty()
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
        let indexer = PhotonIndexer {
            scene: self.scene,
            options,
            radius_law: self.radius_law(),
            volume_estimator: self.settings.volume_estimator,
            min_radius: self.min_radius,
        };
        let limits = self.density_estimate_limits(options);
        let (mut caustic, indirect, interreflection) = indexer.index_photons(photons, &limits, monitor, out);
        caustic.has_density_estimate_shares = options.connects_to_camera && self.density_estimate_shares.is_some();
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
            tracer: self.pass_photon_tracer(self.sources.aimed.as_ref(), self.request.aimed),
            paths: self.counts.divided_by(options.photon_path_divisor).aimed,
            key: options.photon_path_key(Purpose::AimedPhotons),
            light_tracer: light_tracer.as_ref(),
        };
        let traced = task.trace_photons(monitor, out);
        out.aimed += photon_report(&traced);
        AimedPhotons::from_deposits(traced.deposits)
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
            tracer: self.pass_photon_tracer(self.sources.unaimed.as_ref(), self.request.unaimed),
            paths: self.counts.divided_by(options.photon_path_divisor).unaimed,
            key: options.photon_path_key(Purpose::UnaimedPhotons),
            light_tracer: None,
        };
        let traced = task.trace_photons(monitor, out);
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
            tracer: self.pass_photon_tracer(self.sources.unaimed.as_ref(), StoreMask::INDIRECT),
            paths: self.counts.divided_by(options.photon_path_divisor).unaimed / GUIDE_PHOTON_DIVISOR,
            key: options.photon_path_key(Purpose::GatherRayGuides),
            light_tracer: None,
        };
        task.trace_photons(monitor, out).deposits.surface_photons
    }

    /// Returns the limits of density estimates from each photon map, for the gather radii of the
    /// first pass.
    fn density_estimate_limits(&self, options: &MapBuildOptions) -> PerMap<DensityEstimateLimits> {
        let limits = |surface_radius: f32, volume_radii: VolumeKernelRadii, usual_k: u32| DensityEstimateLimits {
            surface_radius,
            volume_radii,
            k: photon_limit(self.settings.gather_k.unwrap_or(usual_k), options.photon_path_divisor),
        };
        let radius = |of_map: fn(GatherRadii) -> f32| self.radii.map_or(1.0, of_map);
        PerMap {
            caustic: limits(radius(|radii| radii.caustic), self.volume_radii.caustic, self.default_caustic_k()),
            indirect: limits(radius(|radii| radii.indirect), self.volume_radii.indirect, 0),
            interreflection: limits(self.interreflection_radius, self.volume_radii.interreflection, 0),
        }
    }

    /// Returns the default photon limit of caustic density estimates. It grows with the number of
    /// photon paths aimed at casters such as glass, so that gather discs keep their size.
    fn default_caustic_k(&self) -> u32 {
        let ratio = f64::from(self.counts.aimed) / f64::from(self.settings.aimed_paths.max(1));
        (f64::from(DEFAULT_CAUSTIC_K) * ratio).round().max(1.0) as u32
    }

    /// Returns a tracer of photon paths from `source` that stores the kinds of photons of `mask`.
    fn photon_tracer<'b>(&'b self, source: &'b PhotonSource<'a>, mask: StoreMask) -> PhotonTracer<'b> {
        PhotonTracer { scene: self.scene, source, mask, max_bounces: self.settings.camera_paths.max_bounces }
    }

    /// Returns a tracer of photon paths from `source` that stores the kinds of photons of `mask`,
    /// in media as the volume estimator needs them; `None` without a source.
    fn pass_photon_tracer<'b>(
        &'b self,
        source: Option<&'b PhotonSource<'a>>,
        mask: StoreMask,
    ) -> Option<PhotonTracer<'b>> {
        source.map(|source| self.photon_tracer(source, self.mask_for_volume_estimator(mask)))
    }
}
