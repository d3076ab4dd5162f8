//! Radii found by a pilot pass.

use super::{Settings, VolumeEstimate};
use crate::bsdf::Transport;
use crate::math::Ray;
use crate::photon::{BeamMap, GuidingReport, Photon, PhotonMap, PhotonPass, PointMap};
use crate::sampling::{Dimension, Key, Purpose, Sampler};
use crate::scene::{Effects, PathEvent, Scene, SpectralInterior, SurfaceVertex};
use glam::Vec2;

/// Most paths of the pilot: its radii are scaled to the photon count of a pass.
const PATHS: u32 = 1 << 16;

/// Passes that a pilot may cost, and paths below which none tells enough.
const PASSES: u32 = 4;
const FEWEST: u32 = 1 << 14;

/// Stored photons at which the pilot looks for their k-th neighbour.
const PROBES: usize = 512;

/// The part of the probes whose k-th neighbour is within the radius: the rest is too sparse to be served.
const SERVED: f64 = 0.75;

/// Largest radius as part of the scene's: beyond it, photons are too few to tell one place from another.
const WIDEST: f32 = 0.1;

/// Narrowest radius as part of the distance of what it is for from the middle of all coordinates: within less, places are but few steps of
/// single precision apart.
const NARROWEST: f32 = 1e-6;

/// The same as part of a pixel's width on what is seen: a narrower spot of light is met by no ray.
const OF_PIXEL: f32 = 0.125;

/// Rays that tell how near that is, along each edge of the picture.
const SIGHTS: u32 = 8;

/// Camera rays that the pilot of media looks along.
const RAYS: u32 = 512;

/// Casters that those rays are followed over.
const MOST_CASTERS: u32 = 8;

/// How many beams or photons half of the rays that meet any should meet.
const MET: f64 = 64.0;

/// The trial radius of that pilot as part of the scene's.
const TRIAL: f32 = 0.02;

/// Largest gather radii of the first pass \[length].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radii {
    /// For the global map.
    pub global: f32,
    /// For the caustic map.
    pub caustic: f32,
}

/// What emission learned for each map; `None` where nothing was to be learned.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct GuidingReports {
    /// For the global map.
    pub global: Option<GuidingReport>,
    /// For the caustic map.
    pub caustic: Option<GuidingReport>,
}

/// Paths of a pilot for passes of `paths` paths: `most`, but for small passes that it would outweigh.
pub(super) fn pilot_paths(paths: u32, most: u32) -> u32 {
    paths.saturating_mul(PASSES).max(FEWEST).min(most)
}

/// The radius within which three of four photons of a pass of `paths` paths have `k` neighbours, found from a smaller pilot; `None`
/// where the pilot stores nothing.
///
/// It is `least` at least, and else depends on the scene, the seed and the counts alone.
pub(super) fn auto_radius(pass: &PhotonPass<'_>, paths: u32, k: u32, seed: u64, least: f32) -> Option<f32> {
    let scene = pass.scene;
    let key = Key::new(seed).purpose(Purpose::Pilot);
    let tried = pilot_paths(paths, PATHS);
    let traced = pass.trace(key, tried, &|_| {});
    let photons = &traced.deposits.photons;
    if photons.is_empty() {
        return None;
    }
    let size = scene.domain().radius.max(f32::MIN_POSITIVE);
    let map = PhotonMap::build(photons.clone());
    let step = photons.len().div_ceil(PROBES);
    let distance = |p: &Photon| {
        let normal = p.data.normal().normalize();
        map.kth_distance(p.position, normal, k, size).unwrap_or(size)
    };
    let mut radii: Vec<f32> = photons.iter().step_by(step).map(distance).collect();
    radii.sort_by(f32::total_cmp);
    let most = ((radii.len() - 1) as f64 * SERVED) as usize;
    let served = radii[most];
    let mut places: Vec<f32> = photons.iter().step_by(step).map(|p| p.position.abs().max_element()).collect();
    places.sort_by(f32::total_cmp);
    // What lies at the very middle lies at one place.
    let far = Some(places[most]).filter(|far| *far > 0.0).unwrap_or(size);
    // Density grows with the number of paths, area with the square of the radius.
    let scaled = served * (tried as f32 / paths as f32).sqrt();
    Some(scaled.max(least).clamp(size.min(far) * NARROWEST, size * WIDEST))
}

/// Narrowest disc of the first pass \[length]: part of a pixel's width on what is nearest of all that is seen, by some rays.
pub(super) fn narrowest(scene: &Scene) -> f32 {
    let (width, spread) = scene.camera().pixel();
    let (columns, rows) = scene.camera().size();
    let part = |i: u32, of: u32| (i as f32 + 0.5) / SIGHTS as f32 * of as f32;
    let rays = (0..SIGHTS * SIGHTS).map(|i| Vec2::new(part(i % SIGHTS, columns), part(i / SIGHTS, rows)));
    let hits = rays.filter_map(|p| scene.intersect(&scene.camera().ray(p, None)));
    // Where nothing is seen, nothing matters.
    let away = hits.map(|hit| hit.t).min_by(f32::total_cmp).unwrap_or(0.0);
    ((width + spread * away) * OF_PIXEL).min(scene.domain().radius * WIDEST)
}

/// Radii of blurs in media \[length].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blurs {
    pub beams: f32,
    pub points: f32,
}

impl Default for Blurs {
    fn default() -> Self {
        Self { beams: 1.0, points: 1.0 }
    }
}

/// Radii within which most rays find enough of what a pass of `paths` paths stores in media, found from a smaller pilot; `None` where it
/// stores nothing there.
pub(super) fn volume_blurs(pass: &PhotonPass<'_>, detail: Effects, paths: u32, settings: &Settings) -> Option<Blurs> {
    let scene = pass.scene;
    let key = Key::new(settings.eye.seed).purpose(Purpose::Pilot);
    let tried = pilot_paths(paths, PATHS);
    let traced = pass.trace(key, tried, &|_| {});
    let mut volume = traced.deposits.volume;
    volume.beams.extend(traced.deposits.after_volume.beams);
    volume.points.extend(traced.deposits.after_volume.points);
    if volume.is_empty() {
        return None;
    }
    let size = scene.domain().radius.max(f32::MIN_POSITIVE);
    let trial = size * TRIAL;
    let ways = ways(scene, detail, key);
    let more = f64::from(paths) / f64::from(tried);
    let radius = |counts: Vec<f64>, dimensions: u32| {
        let mut counts: Vec<f64> = counts.into_iter().filter(|n| *n > 0.0).collect();
        counts.sort_by(f64::total_cmp);
        let median = counts.get(counts.len() / 2).copied().unwrap_or(1.0);
        let ratio = libm::pow(MET / (median * more), 1.0 / f64::from(dimensions)) as f32;
        (trial * ratio).clamp(size * NARROWEST, size * WIDEST)
    };
    let (of_beams, of_points) = settings.volume.dimensions();
    let (beams, points) = (BeamMap::build(volume.beams, trial), PointMap::build(volume.points, trial));
    let beams = ways.iter().map(|way| {
        let mut count = 0.0;
        way.iter().for_each(|ray| beams.visit(ray, |_, _| count += 1.0));
        count
    });
    let beams = radius(beams.collect(), of_beams);
    let points = ways.iter().map(|way| {
        let mut count = 0.0;
        for ray in way {
            if settings.volume == VolumeEstimate::Points {
                points.around(ray.at(0.5 * ray.t_max.min(2.0 * size)), |_, _, _| count += 1.0);
            } else {
                points.visit(ray, |_, _, _, _, _| count += 1.0);
            }
        }
        count
    });
    Some(Blurs { beams, points: radius(points.collect(), of_points) })
}

/// The stretches of media along camera rays, over casters to the first other surface.
fn ways(scene: &Scene, detail: Effects, key: Key) -> Vec<Vec<Ray>> {
    let (width, height) = scene.camera().size();
    let size = Vec2::new(width as f32, height as f32);
    let along = |i| {
        let draw = Sampler::new(key, i, RAYS);
        let ray = scene.camera().ray(draw.get_2d(Dimension::Film) * size, None);
        let mut walk = scene.start_camera_path::<SpectralInterior>(ray, detail);
        let mut found = Vec::new();
        for bounce in 0..MOST_CASTERS {
            let draw = draw.with(bounce.into());
            let step = walk.next_vertex(scene, draw.key(), |stretch| {
                if stretch.medium.scatters() {
                    found.push(stretch.ray);
                }
                None
            });
            let PathEvent::Surface(SurfaceVertex { surface, .. }) = step else { break };
            if surface.bsdf.stores_photons() {
                break;
            }
            let (lobe, u) = (draw.get_1d(Dimension::BsdfLobe), draw.get_2d(Dimension::BsdfDirection));
            let Some(sample) = surface.sample(lobe, u, Transport::Radiance) else { break };
            let _ = walk.leave(&surface, sample.wi, sample.transmitted);
        }
        found
    };
    (0..RAYS).map(along).collect()
}
