//! Direction sampling at the vertices of camera paths.

use super::gather_guide::GUIDE_PHOTONS;
use super::path_task::{PathTask, ScratchBuffers};
use super::photon_maps::PhotonMaps;
use super::policy::DirectionSampling;
use super::vertex::PathVertex;
use crate::bsdf::{BsdfSample, TransportMode};
use crate::color::Rgb;
use crate::photon::{Bandwidth, Kernel};
use crate::sampling::Dimension;
use crate::scene::Interior;
use glam::Vec3;
use std::cell::RefCell;

/// Radius of the search for photons that guide a final-gathering ray, divided by the smallest
/// length at which such a ray reads the indirect map.
const RELATIVE_GUIDE_RADIUS: f32 = 4.0;

/// Collects the directions from which photons near `vertex` arrived, in the task's
/// [`GatherGuide`](super::gather_guide::GatherGuide). Final-gathering rays from `vertex` then
/// sample these directions.
pub(super) fn collect_gather_directions<I: Interior>(
    maps: &PhotonMaps<'_>,
    min_gather_distance: f32,
    vertex: &PathVertex<'_, I>,
    task: &mut PathTask,
) {
    let ScratchBuffers { gather_guide, searches, .. } = &mut task.scratch;
    gather_guide.clear();
    let guide = RefCell::new(gather_guide);
    let bandwidth = Bandwidth { radius: min_gather_distance * RELATIVE_GUIDE_RADIUS, k: GUIDE_PHOTONS };
    let p = vertex.surface.point.p;
    for normal in vertex.surface.light_side_normals() {
        // The lookup visits the photons; its estimate is not used.
        let _ = maps.guides.estimate_radiance(p, normal, bandwidth, Kernel::Cone, &mut searches.guides, |flux| {
            guide.borrow_mut().push_direction(flux.incident_direction());
            Rgb::ZERO
        });
    }
}

/// Samples the direction in which a camera path leaves `vertex`. Returns `None` if the path ends.
#[inline]
pub(super) fn sample<I: Interior>(
    sampling: DirectionSampling,
    vertex: &PathVertex<'_, I>,
    task: &PathTask,
) -> Option<BsdfSample> {
    let surface = vertex.surface;
    let (lobe, u) = (vertex.sampler.get_1d(Dimension::BsdfLobe), vertex.sampler.get_2d(Dimension::BsdfDirection));
    if is_guided(sampling, vertex) {
        return sample_bsdf_or_guide(vertex, task);
    }
    surface.sample(lobe, u, TransportMode::Radiance)
}

/// Returns the pdf with which [`sample`] chooses unit direction `wi` \[1/sr].
#[inline]
pub(super) fn pdf<I: Interior>(
    sampling: DirectionSampling,
    vertex: &PathVertex<'_, I>,
    wi: Vec3,
    task: &PathTask,
) -> f32 {
    let bsdf = vertex.surface.pdf(wi);
    if !is_guided(sampling, vertex) {
        return bsdf;
    }
    task.scratch.gather_guide.pdf(wi).map_or(bsdf, |guide| 0.5 * (bsdf + guide))
}

/// True if directions at `vertex` are sampled both from the BSDF and from the directions of nearby
/// photons.
///
/// False at casters, such as glass: the photon directions were collected at the last surface that
/// stores photons.
#[inline]
fn is_guided<I>(sampling: DirectionSampling, vertex: &PathVertex<'_, I>) -> bool {
    match sampling {
        DirectionSampling::Bsdf | DirectionSampling::OneLobe => false,
        DirectionSampling::Guided => vertex.surface.bsdf.stores_photons(),
    }
}

/// Samples a direction from the BSDF or from the directions of nearby photons, with equal
/// probability. Returns `None` if the sample carries no light.
fn sample_bsdf_or_guide<I: Interior>(vertex: &PathVertex<'_, I>, task: &PathTask) -> Option<BsdfSample> {
    let surface = vertex.surface;
    let (lobe, u) = (vertex.sampler.get_1d(Dimension::BsdfLobe), vertex.sampler.get_2d(Dimension::BsdfDirection));
    let mixed = |wi| pdf(DirectionSampling::Guided, vertex, wi, task);
    if lobe >= 0.5 {
        let mut sample = surface.sample(2.0 * lobe - 1.0, u, TransportMode::Radiance)?;
        let mixed = mixed(sample.wi);
        sample.weight *= sample.pdf / mixed;
        sample.pdf = mixed;
        return Some(sample);
    }
    let Some(wi) = task.scratch.gather_guide.sample_direction(2.0 * lobe, u) else {
        return surface.sample(2.0 * lobe, u, TransportMode::Radiance);
    };
    let reflected = surface.bsdf_cosine(wi);
    let pdf = mixed(wi);
    let is_transmitted = surface.is_transmitted(wi);
    (reflected != Rgb::ZERO && pdf > 0.0)
        .then(|| BsdfSample::non_specular_sample(wi, reflected / pdf, pdf, is_transmitted))
}
