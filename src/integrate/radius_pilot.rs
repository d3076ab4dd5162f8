//! Pilots (small photon simulations) that find the gather radii of the first pass.

use super::settings::Settings;
use super::volume_estimate::VolumeEstimator;
use crate::bsdf::TransportMode;
use crate::math::Ray;
use crate::photon::{EmissionGuidingReport, Photon, PhotonBeamMap, PhotonMap, PhotonTracer, VolumePhotonMap};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effects, PathEvent, Scene, SpectralInterior, SurfaceVertex};
use glam::Vec2;
use rayon::prelude::*;

/// Largest number of photon paths of a pilot (small photon simulation) that finds gather radii. The
/// found radii are scaled to the photon density of a pass.
pub(super) const MAX_PATHS: u32 = 1 << 16;

/// Largest number of photon paths of a pilot (small photon simulation) that finds the gather radius
/// of a map of indirect light. Few paths suffice, because the density of indirect photons varies
/// slowly.
pub(super) const MAX_INDIRECT_PATHS: u32 = 1 << 14;

/// Factor on the number of photon paths of a pass: a pilot (small photon simulation) that finds
/// gather radii or guides photon emission traces 4 times as many. [`MIN_PATHS`] and a maximum of
/// each pilot bound the product.
const PILOT_PATH_FACTOR: u32 = 4;

/// Smallest number of photon paths of a pilot (small photon simulation) that finds gather radii or
/// guides photon emission, even if a pass traces fewer paths.
const MIN_PATHS: u32 = 1 << 14;

/// Largest number of stored photons at which a pilot measures the distance to the k-th nearest
/// photon. The gather radius is a quantile of these distances.
const RADIUS_SAMPLES: usize = 512;

/// Quantile of the distances from stored photons to their k-th nearest photon. The distance at this
/// quantile becomes the gather radius.
const RADIUS_QUANTILE: f64 = 0.75;

/// Largest gather radius, divided by the scene's radius. A larger radius would blur the whole
/// scene.
const MAX_RELATIVE_RADIUS: f32 = 0.1;

/// Smallest gather radius that single precision resolves, as a fraction of the smaller of two
/// lengths: the radius of the scene, and a distance from the origin within which three of four
/// photons lie. Single precision resolves finer details near the origin.
const MIN_RELATIVE_RADIUS: f32 = 1e-6;

/// Smallest gather radius, divided by the width of a pixel's footprint on the closest visible
/// surface.
const MIN_RADIUS_PIXELS: f32 = 0.125;

/// Number of columns and of rows in a grid of camera rays over the picture that finds the closest
/// visible surface.
const DISTANCE_RAYS: u32 = 8;

/// Number of camera rays with which a pilot measures the density of photons in media.
const MEDIA_RAYS: u32 = 512;

/// Largest number of casters (mirrors, glass and the like) that a camera path may pass while it
/// measures the density of photons in media.
const MAX_CASTERS: u32 = 8;

/// Number of photon beams or photon points that the median camera ray in media should find within
/// the kernel radius. Rays that find none do not count.
const TARGET_MEDIAN_KERNEL_COUNT: f64 = 64.0;

/// Smallest kernel radius of photon beams, divided by the width of a pixel's footprint in the
/// medium.
///
/// If a smaller radius would already hold enough beams, passes drop beams at random instead.
const MIN_BEAM_RADIUS_PIXELS: f32 = 0.25;

/// Kernel radius within which a pilot counts photons in media, divided by the scene's radius. The
/// kernel radius of passes follows from the count.
const TRIAL_RELATIVE_RADIUS: f32 = 0.02;

/// Largest gather radii on surfaces in the first pass \[length].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherRadii {
    /// Gather radius of the indirect map \[length].
    pub indirect: f32,
    /// Gather radius of the caustic map \[length].
    pub caustic: f32,
}

/// Work and benefit of guiding photon emission, for each set of photon paths; `None` if no pilot
/// (small simulation before the first pass) tried to guide them.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct EmissionGuidingReports {
    /// Report for the photon paths that start in all directions. They fill the indirect map or, in
    /// `hybrid`, the interreflection map.
    #[serde(rename = "global")]
    pub unaimed: Option<EmissionGuidingReport>,
    /// Report for the photon paths aimed at casters, such as mirrors and glass. They fill the
    /// caustic map, and in `hybrid` the indirect map too.
    #[serde(rename = "caustic")]
    pub aimed: Option<EmissionGuidingReport>,
}

/// Returns the number of photon paths of a pilot that finds gather radii or guides photon emission:
/// four times the `paths` of a pass, but at least 16,384 and at most `most`.
pub(super) fn pilot_path_count(paths: u32, most: u32) -> u32 {
    paths.saturating_mul(PILOT_PATH_FACTOR).max(MIN_PATHS).min(most)
}

/// Runs a pilot (small photon simulation). Returns the radius \[length] within which three of four
/// stored photons have at least `k` photons around them; `None` if the pilot stores no photon.
///
/// The radius suits a pass of `paths` photon paths. It is at least `min_radius`, and at most 1/10
/// of the scene's radius. The pilot traces at most `max_pilot_paths` paths.
pub(super) fn find_gather_radius(
    tracer: &PhotonTracer<'_>,
    (paths, max_pilot_paths): (u32, u32),
    k: u32,
    seed: u64,
    min_radius: f32,
) -> Option<f32> {
    let scene = tracer.scene;
    let key = Key::new(seed).purpose_key(Purpose::RadiusPilot);
    let pilot = pilot_path_count(paths, max_pilot_paths);
    let traced = tracer.trace(key, pilot, &|_| {});
    let photons = &traced.deposits.surface_photons;
    if photons.is_empty() {
        return None;
    }
    let size = scene.photon_domain().radius.max(f32::MIN_POSITIVE);
    let map = PhotonMap::build(photons.par_iter().copied().collect());
    let step = photons.len().div_ceil(RADIUS_SAMPLES);
    let distance = |p: &Photon| {
        let normal = p.attributes.normal().normalize();
        map.kth_photon_distance(p.position, normal, k, size).unwrap_or(size)
    };
    let mut radii: Vec<f32> = photons.par_iter().step_by(step).map(distance).collect();
    radii.sort_by(f32::total_cmp);
    let quantile = ((radii.len() - 1) as f64 * RADIUS_QUANTILE) as usize;
    let mut coordinates: Vec<f32> = photons.iter().step_by(step).map(|p| p.position.abs().max_element()).collect();
    coordinates.sort_by(f32::total_cmp);
    // If most photons lie at the origin, use the scene's radius.
    let far = Some(coordinates[quantile]).filter(|far| *far > 0.0).unwrap_or(size);
    // Photon density is proportional to the number of paths, disc area to the square of the radius.
    let scaled = radii[quantile] * (pilot as f32 / paths as f32).sqrt();
    Some(scaled.max(min_radius).clamp(size.min(far) * MIN_RELATIVE_RADIUS, size * MAX_RELATIVE_RADIUS))
}

/// Returns the lower bound on gather radii in the first pass \[length]: 1/8 of the width of a
/// pixel's footprint on the closest visible surface, but at most 1/10 of the scene's radius.
pub(super) fn min_gather_radius(scene: &Scene) -> f32 {
    let (width, spread) = scene.camera().pixel_footprint_and_growth();
    let (columns, rows) = scene.camera().size();
    let position = |i: u32, size: u32| (i as f32 + 0.5) / DISTANCE_RAYS as f32 * size as f32;
    let rays = (0..DISTANCE_RAYS * DISTANCE_RAYS)
        .map(|i| Vec2::new(position(i % DISTANCE_RAYS, columns), position(i / DISTANCE_RAYS, rows)));
    let hits = rays.filter_map(|p| scene.intersect(&scene.camera().generate_ray(p, None)));
    // If nothing is visible, any radius will do.
    let distance = hits.map(|hit| hit.t).min_by(f32::total_cmp).unwrap_or(0.0);
    ((width + spread * distance) * MIN_RADIUS_PIXELS).min(scene.photon_domain().radius * MAX_RELATIVE_RADIUS)
}

/// Kernel radii of density estimates from photon beams and from photon points in media \[length].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VolumeKernelRadii {
    pub beams: f32,
    pub points: f32,
    /// Fraction in \[0, 1] of the photon beams that a pass keeps, chosen at random. The kept beams
    /// get more flux, so that the expected flux of each beam does not change.
    pub kept_beam_fraction: f32,
}

impl Default for VolumeKernelRadii {
    fn default() -> Self {
        Self { beams: 1.0, points: 1.0, kept_beam_fraction: 1.0 }
    }
}

/// Runs a pilot (small photon simulation). Returns the kernel radii of density estimates in media
/// \[length], and the fraction of beams that passes keep; `None` if the pilot stores no photon in
/// media.
///
/// In a pass of `paths` photon paths, the median camera ray finds 64 beams or photons within the
/// kernel radius. Rays that find none do not count. The radius for beams is at least
/// [`MIN_BEAM_RADIUS_PIXELS`] times the width of a pixel's footprint. If that radius holds more
/// than 64 beams, passes keep only a fraction of the beams. This costs little sharpness and saves
/// time: with a smaller radius, the bounding boxes of dense beams would not shrink much.
pub(super) fn find_volume_kernel_radii(
    tracer: &PhotonTracer<'_>,
    effects: Effects,
    paths: u32,
    settings: &Settings,
) -> Option<VolumeKernelRadii> {
    let scene = tracer.scene;
    let key = Key::new(settings.camera_paths.seed).purpose_key(Purpose::RadiusPilot);
    let pilot = pilot_path_count(paths, MAX_PATHS);
    let traced = tracer.trace(key, pilot, &|_| {});
    let mut volume = traced.deposits.volume_photons;
    volume.beams.extend(traced.deposits.after_caustic_volume_photons.beams);
    volume.points.extend(traced.deposits.after_caustic_volume_photons.points);
    if volume.is_empty() {
        return None;
    }
    let size = scene.photon_domain().radius.max(f32::MIN_POSITIVE);
    let trial = size * TRIAL_RELATIVE_RADIUS;
    let camera_paths = trace_medium_segments(scene, effects, key);
    let more = f64::from(paths) / f64::from(pilot);
    let radius = |counts: Vec<f64>, dimensions: u32| {
        let mut counts: Vec<f64> = counts.into_iter().filter(|n| *n > 0.0).collect();
        counts.sort_by(f64::total_cmp);
        let median = counts.get(counts.len() / 2).copied().unwrap_or(1.0);
        let ratio = libm::pow(TARGET_MEDIAN_KERNEL_COUNT / (median * more), 1.0 / f64::from(dimensions)) as f32;
        (trial * ratio).clamp(size * MIN_RELATIVE_RADIUS, size * MAX_RELATIVE_RADIUS)
    };
    let (beam_dimensions, point_dimensions) = settings.volume_estimator.kernel_dimensions();
    let (beams, points) = (PhotonBeamMap::build(volume.beams, trial), VolumePhotonMap::build(volume.points, trial));
    let beams = camera_paths.par_iter().map(|segments| {
        let mut count = 0.0;
        segments.iter().for_each(|ray| beams.visit_near_ray(ray, |_, _| count += 1.0));
        count
    });
    let beams = radius(beams.collect(), beam_dimensions);
    let points = camera_paths.par_iter().map(|segments| {
        let mut count = 0.0;
        for ray in segments {
            if settings.volume_estimator == VolumeEstimator::Points {
                points.visit_near_point(ray.at(0.5 * ray.t_max.min(2.0 * size)), |_, _, _| count += 1.0);
            } else {
                points.visit_near_ray(ray, |_, _, _, _, _| count += 1.0);
            }
        }
        count
    });
    let points = radius(points.collect(), point_dimensions);
    let widest = (median_footprint(scene, &camera_paths) * MIN_BEAM_RADIUS_PIXELS).min(size * MAX_RELATIVE_RADIUS);
    let kept_beam_fraction = if beams < widest { beams / widest } else { 1.0 };
    Some(VolumeKernelRadii { beams: beams.max(widest), points, kept_beam_fraction })
}

/// Returns the width of a pixel's footprint \[length] at the median distance at which the
/// `camera_paths` cross a medium; 0 if no path does.
///
/// `camera_paths` holds the medium segments of each path. The distance of a path is the distance
/// from the camera to its first segment, plus half the length of all its segments.
fn median_footprint(scene: &Scene, camera_paths: &[Vec<Ray>]) -> f32 {
    let (width, spread) = scene.camera().pixel_footprint_and_growth();
    let size = scene.photon_domain().radius;
    let eye = scene.camera().center().as_vec3();
    let middle = |segments: &Vec<Ray>| {
        let before = (segments.first()?.origin - eye).length();
        Some(before + 0.5 * segments.iter().map(|ray| ray.t_max.min(2.0 * size)).sum::<f32>())
    };
    let mut distances: Vec<f32> = camera_paths.iter().filter_map(middle).collect();
    distances.sort_by(f32::total_cmp);
    distances.get(distances.len() / 2).map_or(0.0, |distance| width + spread * distance)
}

/// Traces 512 camera paths up to their first surface that stores photons. The paths reflect and
/// refract at casters, such as glass. Returns the segments of each path in scattering media.
fn trace_medium_segments(scene: &Scene, effects: Effects, key: Key) -> Vec<Vec<Ray>> {
    let (width, height) = scene.camera().size();
    let size = Vec2::new(width as f32, height as f32);
    let along_path = |i| {
        let sampler = Sampler::new(key, i, MEDIA_RAYS);
        let ray = scene.camera().generate_ray(sampler.get_2d(Dimension::Film) * size, None);
        let mut path_ray = scene.start_camera_path::<SpectralInterior>(ray, effects);
        let mut segments = Vec::new();
        for bounce in 0..MAX_CASTERS {
            let sampler = sampler.pilot_bounce_sampler(bounce);
            let event = path_ray.next_vertex(scene, sampler.sample_key(), |segment| {
                if segment.medium.scatters() {
                    segments.push(segment.ray);
                }
                None
            });
            let PathEvent::Surface(SurfaceVertex { surface, .. }) = event else { break };
            if surface.bsdf.stores_photons() {
                break;
            }
            let (lobe, u) = (sampler.get_1d(Dimension::BsdfLobe), sampler.get_2d(Dimension::BsdfDirection));
            let Some(sample) = surface.sample(lobe, u, TransportMode::Radiance) else { break };
            let _ = path_ray.leave_surface_with_wavelength_weight(&surface, sample.wi, sample.is_transmitted);
        }
        segments
    };
    (0..MEDIA_RAYS).into_par_iter().map(along_path).collect()
}
