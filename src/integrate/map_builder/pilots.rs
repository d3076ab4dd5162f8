//! Pilots of the map builder: small photon simulations before the render.
//!
//! They guide photon emission, find gather radii, divide caustics between photon estimates and
//! light tracing, and predict how many photons a pass stores.

use super::{DEFAULT_CAUSTIC_K, GUIDE_PHOTON_DIVISOR, PerMap, PhotonMapBuilder};
use crate::integrate::pass::ExpectedPhotons;
use crate::integrate::radius_pilot::{
    self, GatherRadii, VolumeKernelRadii, find_gather_radius, find_volume_kernel_radii, pilot_path_count,
};
use crate::integrate::settings::{CameraPathSettings, IndirectPhotons, LightTracing};
use crate::integrate::visible_pilot::find_visible_points;
use crate::photon::{
    DensityEstimateShares, EmissionGuidingPilotSettings, LightTracer, PhotonSource, StoreMask, VolumePhotons,
};
use crate::sampling::{Key, Purpose};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Ratio of two numbers of photon paths aimed at casters, such as glass: those of a pass, and those
/// of the pilot that divides caustics between photon estimates and light tracing.
const SHARE_PILOT_PATH_DIVISOR: u32 = 4;

/// Least number of photon paths of the pilot that divides caustics between photon estimates and
/// light tracing. If a pass has fewer paths, the pilot has as many as the pass.
const MIN_SHARE_PILOT_PATHS: u32 = 1 << 15;

/// Largest number of photon paths of the pilot that divides caustics between photon estimates and
/// light tracing.
const MAX_SHARE_PILOT_PATHS: u32 = 1 << 20;

/// Target number of photons in a gather disc of the indirect map: a pilot chooses the gather radius
/// with which three of four discs hold at least this many. In `hybrid`, the target applies instead
/// to the interreflection map, which holds the indirect light that does not come from caustics.
const DEFAULT_INDIRECT_K: u32 = 100;

/// Target number of photons in a gather disc of the indirect map of `hybrid`, which holds the
/// indirect light of caustics. A pilot chooses the gather radius with which three of four discs
/// hold at least this many.
const DEFAULT_AFTER_CAUSTIC_K: u32 = 50;

/// Radius around a point that the camera sees within which photons count as visible, divided by the
/// scene radius. [`find_visible_points`] adapts it to the found points. Pilots guide photon
/// emission towards visible points.
const VISIBLE_RELATIVE_RADIUS: f32 = 0.01;

/// Gather radius on surfaces, or kernel radius in media, divided by the scene radius, for the case
/// that a pilot stores no photons and so cannot find a radius.
const DEFAULT_RELATIVE_RADIUS: f32 = 0.01;

/// Largest number of photon paths of the pilot that guides emission for the interreflection map of
/// `hybrid`.
///
/// The camera sees many photons of that map, so few paths suffice.
const MAX_INTERREFLECTION_GUIDING_PATHS: u32 = 1 << 15;

/// Least gain at which passes use guided photon emission. The gain is the number of unguided photon
/// paths, divided by the number of guided ones with the same noise.
///
/// The threshold exceeds 1, because guided paths take longer to sample.
const MIN_GUIDING_GAIN: f64 = 1.5;

/// Memory of a photon beam with its bounding boxes, divided by the memory of a photon.
const BEAM_MEMORY_IN_PHOTONS: usize = 4;

/// Largest number of photon paths that are traced, for each set of photon paths, to predict how
/// many photons a pass stores.
const PROBE_PATHS: u32 = 4096;

impl<'a> PhotonMapBuilder<'a> {
    /// Guides photon emission towards points that the camera sees, if a pilot (small simulation
    /// before the first pass) finds that more efficient. Stores the pilot's report for each set of
    /// photon paths.
    ///
    /// Does nothing if media store photons, because the points that guide emission lie on surfaces.
    /// Paths that start in all directions stay unguided if final-gathering rays read their photons,
    /// because these rays need photons everywhere.
    pub(super) fn guide_emission(&mut self) {
        // Visible points lie on surfaces, so they cannot guide photons that are stored in media.
        if !self.traces_photons() || self.stores_volume_photons() {
            return;
        }
        let (scene, settings) = (self.scene, &self.settings);
        let radius = scene.photon_domain().radius * VISIBLE_RELATIVE_RADIUS;
        let visible = find_visible_points(scene, &settings.camera_paths, self.policy.effects, radius);
        let guide = |source: &mut Option<PhotonSource<'a>>, mask: StoreMask, paths: u32, max_paths: u32| {
            let unguided = source.take()?;
            let CameraPathSettings { max_bounces, seed, .. } = settings.camera_paths;
            let paths = pilot_path_count(paths, max_paths);
            let pilot = EmissionGuidingPilotSettings { mask, max_bounces, visible_points: &visible, paths, seed };
            let (guided, report) = unguided.clone().with_guided_emission(&pilot);
            *source = Some(if report.variance_gain > MIN_GUIDING_GAIN { guided } else { unguided });
            Some(report)
        };
        self.emission_guiding_reports.aimed = guide(
            &mut self.sources.aimed,
            self.request.aimed,
            settings.aimed_paths,
            EmissionGuidingPilotSettings::DEFAULT_PATHS,
        );
        // If gather rays read the indirect map, its photons are needed everywhere, so they are not
        // guided.
        if !self.request.unaimed.direct {
            let max_paths = if self.policy.indirect_photons == IndirectPhotons::Off {
                EmissionGuidingPilotSettings::DEFAULT_PATHS
            } else {
                MAX_INTERREFLECTION_GUIDING_PATHS
            };
            self.emission_guiding_reports.unaimed =
                guide(&mut self.sources.unaimed, self.request.unaimed, settings.unaimed_paths, max_paths);
        }
    }

    /// Returns the gather radii of the caustic and the indirect map \[length], and stores the
    /// gather radius of the interreflection map.
    ///
    /// The radii come from the settings, or else from pilots (small photon simulations). A pilot
    /// finds the radius within which three of four photons have enough neighbours.
    pub(super) fn find_gather_radii(&mut self) -> GatherRadii {
        let settings = &self.settings;
        let radius = |source: &Option<PhotonSource<'a>>, mask: StoreMask, paths: (u32, u32), default_k: u32| {
            let k = settings.gather_k.filter(|k| *k > 0).unwrap_or(default_k);
            let found = || {
                let source = source.as_ref()?;
                find_gather_radius(
                    &self.photon_tracer(source, mask),
                    paths,
                    k,
                    settings.camera_paths.seed,
                    self.min_radius,
                )
            };
            // A pilot may store no photon although passes will, for example if objects move.
            settings
                .initial_gather_radius
                .or_else(found)
                .unwrap_or(self.scene.photon_domain().radius * DEFAULT_RELATIVE_RADIUS)
        };
        let interreflection = if self.may_build_interreflection_map() {
            let paths = (self.settings.unaimed_paths, radius_pilot::MAX_INDIRECT_PATHS);
            radius(&self.sources.unaimed, self.request.unaimed, paths, DEFAULT_INDIRECT_K)
        } else {
            0.0
        };
        let (source, mask, paths) = self.indirect_map_inputs();
        let (default_k, max_pilot_paths) = if self.request.aimed.separates_after_caustic {
            (DEFAULT_AFTER_CAUSTIC_K, radius_pilot::MAX_INDIRECT_PATHS)
        } else {
            (DEFAULT_INDIRECT_K, radius_pilot::MAX_PATHS)
        };
        let indirect = radius(source, mask, (paths, max_pilot_paths), default_k);
        let paths = (settings.aimed_paths, radius_pilot::MAX_PATHS);
        let caustic = radius(&self.sources.aimed, StoreMask::CAUSTIC, paths, DEFAULT_CAUSTIC_K);
        self.interreflection_radius = interreflection;
        GatherRadii { indirect, caustic }
    }

    /// Returns the kernel radii \[length] of photon estimates in media, for each photon map.
    ///
    /// The radii come from the settings, or else from pilots (small photon simulations). A pilot
    /// finds the radius within which the median camera ray meets enough photons.
    pub(super) fn find_volume_kernel_radii(&self) -> PerMap<VolumeKernelRadii> {
        let settings = &self.settings;
        let found = |source: &Option<PhotonSource<'a>>, mask: StoreMask, paths: u32| {
            let source = source.as_ref()?;
            find_volume_kernel_radii(&self.photon_tracer(source, mask), self.policy.effects, paths, settings)
        };
        let radii = |source, mask, paths| {
            if let Some(radius) = settings.initial_gather_radius {
                return VolumeKernelRadii { beams: radius, points: radius, kept_beam_fraction: 1.0 };
            }
            let default = self.scene.photon_domain().radius * DEFAULT_RELATIVE_RADIUS;
            found(source, self.mask_for_volume_estimator(mask), paths).unwrap_or(VolumeKernelRadii {
                beams: default,
                points: default,
                kept_beam_fraction: 1.0,
            })
        };
        let (source, mask, paths) = self.indirect_map_inputs();
        let caustic = radii(&self.sources.aimed, StoreMask::CAUSTIC, settings.aimed_paths);
        let interreflection = if self.may_build_interreflection_map() {
            radii(&self.sources.unaimed, self.request.unaimed, settings.unaimed_paths)
        } else {
            VolumeKernelRadii::default()
        };
        let indirect = radii(source, StoreMask { direct: false, ..mask }, paths);
        PerMap { caustic, indirect, interreflection }
    }

    /// Sets the fraction of caustic flux that photon estimates carry at each pixel. Light tracing
    /// (photons connected to the camera) carries the rest.
    ///
    /// The fractions depend on the number of photon paths aimed at casters such as glass, so this
    /// number must be final. Without light tracing or caustic photons, the function does nothing.
    pub fn set_density_estimate_shares(&mut self) {
        let size = self.scene.camera().size();
        let Some(source) = self.sources.aimed.as_ref().filter(|_| self.request.aimed.caustic) else { return };
        let shares = match self.policy.light_tracing {
            LightTracing::Off => return,
            LightTracing::Full => DensityEstimateShares::all_to_splats(size),
            LightTracing::Weighted => {
                let fraction = self.counts.aimed / SHARE_PILOT_PATH_DIVISOR;
                let paths = fraction.clamp(MIN_SHARE_PILOT_PATHS, MAX_SHARE_PILOT_PATHS).min(self.counts.aimed);
                let photon_tracer = self.photon_tracer(source, StoreMask::CAUSTIC);
                let key = Key::new(self.settings.camera_paths.seed).purpose_key(Purpose::DensityEstimateShares);
                let light_tracer = LightTracer::new(self.scene, self.uses_lens(), None);
                let traced =
                    photon_tracer.trace_and_connect(key, paths, Some(&light_tracer), &|_| ControlFlow::Continue(()));
                let ratio = f64::from(self.counts.aimed) / f64::from(paths.max(1));
                // Without a limit, the radius alone bounds a disc. It suits the default limit.
                let k = self.settings.gather_k.filter(|k| *k > 0).unwrap_or_else(|| self.default_caustic_k());
                DensityEstimateShares::from_splats(&traced.deposits.splats, size, ratio, k.into())
            }
        };
        self.density_estimate_shares = Some(Arc::new(shares));
    }

    /// Returns how many photon paths a pass traces, and estimates how many photons it stores. For
    /// the estimate, traces at most 4096 photon paths for each set of paths. A photon beam counts
    /// as four photons, because it takes as much memory.
    pub fn expected_photons(&self) -> ExpectedPhotons {
        let settings = &self.settings;
        let key = Key::new(settings.camera_paths.seed).purpose_key(Purpose::RadiusPilot);
        let expected = |source: &Option<PhotonSource<'a>>, mask: StoreMask, paths: u32| {
            let Some(source) = source.as_ref().filter(|_| paths > 0) else { return ExpectedPhotons::default() };
            let probe = paths.min(PROBE_PATHS);
            let traced = self.photon_tracer(source, self.mask_for_volume_estimator(mask)).trace(key, probe, &|_| {});
            let scale = |n: usize| (n as f64 * f64::from(paths) / f64::from(probe)) as u64;
            let volume_photon_size =
                |volume: &VolumePhotons| volume.points.len() + BEAM_MEMORY_IN_PHOTONS * volume.beams.len();
            let one =
                scale(traced.deposits.surface_photons.len() + volume_photon_size(&traced.deposits.volume_photons));
            let other = scale(
                traced.deposits.after_caustic_surface_photons.len()
                    + volume_photon_size(&traced.deposits.after_caustic_volume_photons),
            );
            ExpectedPhotons {
                paths: paths.into(),
                memory_in_photons: one + other,
                largest_map_in_photons: one.max(other),
            }
        };
        let guides = if self.request.builds_guide_map { self.counts.unaimed / GUIDE_PHOTON_DIVISOR } else { 0 };
        let maps = [
            expected(&self.sources.aimed, self.request.aimed, self.counts.aimed),
            expected(&self.sources.unaimed, self.request.unaimed, self.counts.unaimed),
            expected(&self.sources.unaimed, StoreMask::INDIRECT, guides),
        ];
        maps.into_iter().fold(ExpectedPhotons::default(), |all, map| ExpectedPhotons {
            paths: all.paths + map.paths,
            memory_in_photons: all.memory_in_photons + map.memory_in_photons,
            largest_map_in_photons: all.largest_map_in_photons.max(map.largest_map_in_photons),
        })
    }
}
