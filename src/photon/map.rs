//! The photon map: surface photons in a kd-tree (crate kiddo).

use super::{Photon, PhotonAttributes};
use crate::math::morton_order;
use glam::{Mat3, Vec3};
use kiddo::leaf_strategy::VecOfArenas;
use kiddo::{Eytzinger, KdTree, SquaredEuclidean};
use rayon::prelude::*;

/// Largest number of photons in a leaf of the kd-tree.
const LEAF_SIZE: usize = 32;

type Tree = KdTree<f32, PhotonAttributes, Eytzinger, VecOfArenas<f32, PhotonAttributes, 3, LEAF_SIZE>, 3, LEAF_SIZE>;

/// Surface photons in a kd-tree, for density estimates.
///
/// The tree splits x, y and z in turn, so every third split would be useless for photons on an
/// axis-aligned wall. The map therefore rotates all positions of photons and queries by a fixed
/// oblique rotation.
pub struct PhotonMap {
    tree: Option<Tree>,
    len: usize,
    /// Smallest radius to which the discs of k-nearest-neighbour estimates may shrink \[length].
    pub(super) min_radius: f32,
}

impl std::fmt::Debug for PhotonMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PhotonMap").field("len", &self.len).finish()
    }
}

/// Fixed oblique rotation of all positions before they enter the kd-tree. With it, no split of the
/// tree is parallel to an axis-aligned wall.
///
/// The rotation is about (1, 2, 3)/√14 by 0.7 rad, rounded to f32.
const ROTATION: Mat3 = Mat3::from_cols(
    Vec3::new(0.781_639_2, 0.550_117_2, -0.293_957_9),
    Vec3::new(-0.482_929_3, 0.832_030_1, 0.272_956_3),
    Vec3::new(0.394_739_8, -0.071_392_5, 0.916_015_1),
);

/// Largest number of photons at one position; more photons are merged. The kd-tree keeps all
/// photons of one position in one leaf, which would otherwise exceed its normal size.
const MAX_COINCIDENT_PHOTONS: usize = LEAF_SIZE;

/// Smallest number of photons that one Rayon task tests for equal positions. For each photon, the
/// test compares it with the 32 photons that follow it in the list.
const MIN_WINDOWS_PER_TASK: usize = 4096;

/// Number of photons from which the two halves of a node of the kd-tree are built in parallel.
const PARALLEL_BUILD_THRESHOLD: usize = 4096;

impl PhotonMap {
    /// Builds the kd-tree of `photons`. The result does not depend on the number of threads.
    #[must_use]
    pub fn build(mut photons: Vec<Photon>) -> Self {
        photons.par_iter_mut().for_each(|p| p.position = ROTATION * p.position);
        // Morton order makes memory access coherent.
        let order = morton_order(&photons, |p| p.position);
        photons = order.par_iter().map(|i| photons[*i as usize]).collect();
        merge_coincident_photons(&mut photons);
        let len = photons.len();
        let at = |p: &Photon, axis: usize| p.position[axis];
        let builder = Tree::builder().with_parallel_construction_threshold(PARALLEL_BUILD_THRESHOLD);
        // Construction can fail only for mutable trees and generated indices, which are not used.
        let tree =
            if photons.is_empty() { None } else { builder.build_from_source(&photons, at, |_, p| p.attributes).ok() };
        Self { tree, len, min_radius: 0.0 }
    }

    /// Returns the map with `min_radius` \[length] as the smallest radius of k-nearest-neighbour
    /// estimates.
    ///
    /// Without this limit, the radius approaches zero at a focus of a caustic.
    #[must_use]
    pub fn with_min_radius(self, min_radius: f32) -> Self {
        Self { min_radius, ..self }
    }

    /// Number of photons in the map.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if the map holds no photon.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Calls `visitor` for each photon within `radius` \[length] of `p`, with the photon and its
    /// squared distance from `p`.
    #[inline]
    pub fn visit_within_radius(&self, p: Vec3, radius: f32, mut visitor: impl FnMut(&PhotonAttributes, f32)) {
        let Some(tree) = &self.tree else { return };
        if !p.is_finite() {
            return;
        }
        tree.query(&(ROTATION * p).to_array())
            .within::<SquaredEuclidean<f32>>(radius * radius)
            .unsorted()
            .visit(|found| visitor(&found.item, found.distance));
    }
}

/// Merges photons at positions that more than [`MAX_COINCIDENT_PHOTONS`] photons share. Only
/// photons of equal normal, wavelength and density-estimate share are merged. That share is the
/// fraction of the flux that density estimates use.
///
/// A merged photon has the sum of the fluxes, and the mean of the directions weighted by flux.
fn merge_coincident_photons(photons: &mut Vec<Photon>) {
    // Morton order makes photons at one position adjacent, unless other photons share their Morton
    // cell.
    let coincide = |run: &[Photon]| {
        let position = run[0].position;
        run[MAX_COINCIDENT_PHOTONS].position == position && run.iter().all(|photon| photon.position == position)
    };
    if !photons.par_windows(MAX_COINCIDENT_PHOTONS + 1).with_min_len(MIN_WINDOWS_PER_TASK).any(coincide) {
        return;
    }
    let mut merged: Vec<Photon> = Vec::with_capacity(photons.len());
    for run in photons.chunk_by(|a, b| a.position == b.position) {
        if run.len() <= MAX_COINCIDENT_PHOTONS {
            merged.extend_from_slice(run);
            continue;
        }
        let mut run = run.to_vec();
        let class = |photon: &Photon| {
            let attributes = &photon.attributes;
            let share = attributes.density_estimate_share_steps();
            (attributes.quantized_normal(), attributes.wavelength_code(), share)
        };
        run.sort_by_key(class);
        for side in run.chunk_by(|a, b| class(a) == class(b)) {
            let flux: glam::DVec3 = side.iter().map(|p| p.attributes.flux().as_dvec3()).sum();
            let from: Vec3 =
                side.iter().map(|p| p.attributes.incident_direction() * p.attributes.flux().element_sum()).sum();
            let normal = side[0].attributes.normal().normalize();
            let position = side[0].position;
            // The position is rotated, but the normal is not. So their product is not the plane
            // offset, which is taken from an original photon instead.
            let photon = Photon::new(position, flux.as_vec3(), from.normalize_or(normal), normal);
            let (_, wavelength, share) = class(&side[0]);
            merged.extend(photon.map(|p| {
                let p = p.with_wavelength_code(wavelength).with_density_estimate_share(share);
                Photon { position, attributes: p.attributes.with_plane_offset_of(&side[0].attributes) }
            }));
        }
    }
    *photons = merged;
}

#[cfg(test)]
mod tests;
