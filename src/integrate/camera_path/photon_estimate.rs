//! Photon estimates along a camera path: which maps a vertex reads, and for how many paths.

use super::{PathContext, PathWeights};
use crate::bsdf::TransportMode;
use crate::color::{self, Rgb};
use crate::integrate::path_task::PathTask;
use crate::integrate::photon_maps::PhotonMapChoice;
use crate::integrate::policy::PhotonLookups;
use crate::integrate::vertex::{MediumPathSegment, PathVertex};
use crate::photon::VisiblePoint;
use crate::scene::Interior;
use rand::rngs::SmallRng;

/// Returns the radiance that `vertex` reflects towards the previous vertex, estimated from photon
/// maps \[W/(m² sr)]. Also adds the radiance, times the throughput, to the light that `task`
/// records.
///
/// If only a few paths of a pixel read the maps, the radiance is scaled up to stand for the pixel's
/// other paths. Returns 0 if the policy reads no map at `vertex`. With
/// [`PhotonLookups::RecordVisible`], records `vertex` as a visible point and returns 0.
#[inline]
pub(super) fn radiance<I: Interior>(
    paths: &PathContext<'_>,
    weights: &PathWeights,
    vertex: &PathVertex<'_, I>,
    ends_gather_ray: bool,
    task: &mut PathTask,
) -> Rgb {
    let lookup_scale = match paths.policy.lookups {
        PhotonLookups::Never => return Rgb::ZERO,
        PhotonLookups::FewPerPixel => match vertex.sampler.sample_index_and_count() {
            (index, samples) if vertex.history.receivers == 0 && index < weights.prefix.lookup_count => {
                samples as f32 * weights.prefix.lookup_weight
            }
            _ => return Rgb::ZERO,
        },
        PhotonLookups::FirstReceiver | PhotonLookups::GatherRays => 1.0,
        PhotonLookups::RecordVisible => {
            record_visible_point(vertex, task);
            return Rgb::ZERO;
        }
    };
    let before_gather_ray = paths.policy.lookups == PhotonLookups::GatherRays && !ends_gather_ray;
    let lookup = if before_gather_ray { PhotonMapChoice::Caustic } else { PhotonMapChoice::CausticAndIndirect };
    let estimate = paths.maps.map_or(Rgb::ZERO, |maps| maps.radiance(vertex, lookup, lookup_scale, task));
    let interreflection = if weights.shares_indirect_light(vertex.history) {
        let lookup_scale = lookup_scale * weights.indirect.photon_weight;
        paths.maps.map_or(Rgb::ZERO, |maps| maps.interreflection_radiance(vertex, lookup_scale, task))
    } else {
        Rgb::ZERO
    };
    let estimate = estimate + interreflection;
    task.records.light.photon_estimates += vertex.throughput * estimate;
    task.pixel.photon_radiance += vertex.throughput * estimate;
    estimate
}

/// Returns the radiance that a medium segment scatters to its start, estimated from photon maps
/// \[W/(m² sr)]; 0 if the policy reads no map on this segment. Also adds the radiance, times the
/// throughput, to the light that `task` records.
///
/// If only one path of a pixel reads the maps, the radiance is multiplied by the number of the
/// pixel's paths, to stand for all of them.
pub(super) fn radiance_in_medium<I: Interior>(
    paths: &PathContext<'_>,
    weights: &PathWeights,
    path_segment: &MediumPathSegment<'_, I>,
    rng: &mut SmallRng,
    task: &mut PathTask,
) -> Rgb {
    let Some(maps) = paths.maps else { return Rgb::ZERO };
    let lookup_scale = match paths.policy.lookups {
        PhotonLookups::Never | PhotonLookups::RecordVisible => return Rgb::ZERO,
        PhotonLookups::FewPerPixel => match path_segment.sampler.sample_index_and_count() {
            (0, samples) if path_segment.history.receivers == 0 => samples as f32,
            _ => return Rgb::ZERO,
        },
        PhotonLookups::FirstReceiver | PhotonLookups::GatherRays => 1.0,
    };
    let mut estimate = maps.radiance_in_medium(path_segment, lookup_scale, rng, task);
    if weights.shares_indirect_light(path_segment.history) {
        estimate += maps.interreflection_radiance_in_medium(
            path_segment,
            lookup_scale * weights.indirect.photon_weight,
            rng,
            task,
        );
    }
    task.records.light.photon_estimates += path_segment.throughput * estimate;
    task.pixel.photon_radiance += path_segment.throughput * estimate;
    estimate
}

/// Records `vertex` in `task` as a point that the camera sees, once for each side from which it
/// scatters light.
///
/// The weight of the point is the importance of photons on that side: the throughput times the BSDF
/// for light along the normal, averaged over RGB.
fn record_visible_point<I: Interior>(vertex: &PathVertex<'_, I>, task: &mut PathTask) {
    let surface = vertex.surface;
    for normal in surface.light_side_normals() {
        let bsdf = surface.bsdf.evaluate(surface.wo, normal, normal, normal, TransportMode::Radiance);
        task.records.visible_points.push(VisiblePoint {
            position: surface.point.p,
            position_error: surface.point.position_error,
            normal,
            weight: color::channel_mean(vertex.throughput * bsdf),
        });
    }
}
