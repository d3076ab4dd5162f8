//! Radii found by a pilot pass.

use crate::photon::{Lesson, Photon, PhotonMap, PhotonPass};
use crate::sampling::{Key, Purpose};
use crate::scene::Scene;

/// Paths of the pilot: its radii are scaled to the photon count of a pass.
const PATHS: u32 = 1 << 16;

/// Stored photons at which the pilot looks for their k-th neighbour.
const PROBES: usize = 512;

/// The part of the probes whose k-th neighbour is within the radius: the rest is too sparse to be served.
const SERVED: f64 = 0.75;

/// Largest radius as part of the scene's: beyond it, photons are too few to tell one place from another.
const WIDEST: f32 = 0.1;

/// Narrowest radius as part of the scene's.
const NARROWEST: f32 = 1e-6;

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
pub struct Lessons {
    /// For the global map.
    pub global: Option<Lesson>,
    /// For the caustic map.
    pub caustic: Option<Lesson>,
}

/// The radius within which three of four photons of a pass of `paths` paths have `k` neighbours, found from a smaller pilot; `None`
/// where the pilot stores nothing.
///
/// It depends on the scene, the seed and the counts alone.
pub(super) fn auto_radius(scene: &Scene, pass: &PhotonPass<'_>, paths: u32, k: u32, seed: u64) -> Option<f32> {
    let key = Key::new(seed).purpose(Purpose::Pilot);
    let traced = pass.trace(key, PATHS, &|_| {});
    let photons = &traced.photons;
    if photons.is_empty() {
        return None;
    }
    let size = scene.domain().radius.max(f32::MIN_POSITIVE);
    let map = PhotonMap::build(photons.clone());
    let step = photons.len().div_ceil(PROBES);
    let distance = |p: &Photon| {
        let normal = p.flux.normal().normalize();
        map.kth_distance(p.position, normal, k, size).unwrap_or(size)
    };
    let mut radii: Vec<f32> = photons.iter().step_by(step).map(distance).collect();
    radii.sort_by(f32::total_cmp);
    let served = radii[((radii.len() - 1) as f64 * SERVED) as usize];
    // Density grows with the number of paths, area with the square of the radius.
    let scaled = served * (PATHS as f32 / paths as f32).sqrt();
    Some(scaled.clamp(size * NARROWEST, size * WIDEST))
}
