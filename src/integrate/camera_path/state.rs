//! State of a camera path between two vertices, and the steps that change it.

use super::PathContext;
use crate::color::{self, Rgb};
use crate::integrate::camera_ray::CameraRay;
use crate::integrate::indirect_division::IndirectWeights;
use crate::integrate::vertex::{PathHistory, PathVertex, PrevVertex};
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Interior, PathRay, SurfaceInteraction};
use glam::Vec3;

/// Throughput, as a mean over RGB, below which Russian roulette may end a camera path.
const ROULETTE_THROUGHPUT: f32 = 0.125;

/// State of a camera path between two vertices. At a smooth dielectric, a path splits into a
/// reflected and a refracted branch; each branch then has a state of its own.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrate) struct PathState<I> {
    pub(super) path_ray: PathRay<I>,
    /// Factor from radiance that arrives along the ray to radiance of the pixel.
    pub(super) throughput: Rgb,
    pub(super) bounce: u32,
    pub(super) history: PathHistory,
    /// Factor by which the next vertex multiplies the throughput. On the ray that leaves the path's
    /// first receiver (surface or medium that stores photons), the factor is
    /// [`IndirectWeights::continued_path_factor`], because photon estimates may carry a part of the
    /// indirect light. On all other rays, the factor is 1.
    ///
    /// Emission at the next vertex is direct light of the receiver, so the path adds that emission
    /// before it applies the factor.
    pub(super) pending_weight: f32,
    /// True if the path's indirect light is divided: this path finds a part of that light, and a
    /// photon estimate at the path's first receiver the rest. False before the first receiver.
    pub(super) shares_indirect: bool,
    /// Previous vertex, if next-event estimation there could have sampled the light that the path
    /// hits next. `None` at the camera, after a specular bounce, and beyond a boundary that blocks
    /// shadow rays.
    pub(super) prev_nee_vertex: Option<PrevVertex>,
    /// Sampler of the next vertex's random decisions.
    pub(super) sampler: Sampler,
}

impl<I: Interior> PathState<I> {
    /// Returns the state of a new path that starts with `camera_ray`.
    pub(super) fn from_camera_ray(paths: &PathContext<'_>, camera_ray: &CameraRay) -> Self {
        let CameraRay { ray, sampler, .. } = *camera_ray;
        let mut path_ray: PathRay<I> = paths.scene.start_camera_path(ray, paths.policy.effects);
        path_ray.interior.set_wavelength_sample(paths.scene, || sampler.get_1d(Dimension::Wavelength));
        let history = PathHistory::default();
        Self {
            path_ray,
            throughput: Rgb::ONE,
            bounce: 0,
            history,
            pending_weight: 1.0,
            shares_indirect: false,
            prev_nee_vertex: None,
            sampler,
        }
    }

    /// Counts a crossed boundary as one of `history.casters_since_receiver`, and clears
    /// `prev_nee_vertex`. Does nothing if `crossed_hidden_boundary` is false.
    ///
    /// A hidden boundary lies inside a body of higher priority. It blocks shadow rays, but not
    /// camera rays. So next-event estimation could not have sampled the light beyond it.
    #[inline]
    pub(super) fn count_crossed_boundary(&mut self, crossed_hidden_boundary: bool) {
        if crossed_hidden_boundary {
            self.history.casters_since_receiver += 1;
            self.prev_nee_vertex = None;
        }
    }

    /// Returns the vertex of this path at `surface`, which is `distance` \[length] from the
    /// previous vertex. `interior` holds the nested bodies on the side from which the path arrives.
    pub(super) fn vertex_at_surface<'v>(
        &self,
        paths: &PathContext<'_>,
        surface: &'v SurfaceInteraction<'v>,
        interior: &'v I,
        distance: f32,
    ) -> PathVertex<'v, I> {
        let shadow_sampler = self.sampler.shadow_ray_sampler(paths.pass);
        let Self { history, throughput, sampler, .. } = *self;
        PathVertex { surface, interior, history, throughput, distance, sampler, shadow_sampler }
    }

    /// Returns the state of the path after it leaves `surface` in unit `direction`.
    /// `prev_nee_vertex` is `None`, as after a specular bounce; the caller sets it after other
    /// bounces.
    ///
    /// `weight` is the product of the BSDF and the cosine, divided by the pdf of the direction.
    #[inline]
    pub(super) fn after_scattering(
        &self,
        surface: &SurfaceInteraction<'_>,
        direction: Vec3,
        weight: Rgb,
        transmitted: bool,
    ) -> Self {
        let mut path_ray = self.path_ray;
        let weight = weight * path_ray.leave_surface_with_wavelength_weight(surface, direction, transmitted);
        let sampler = self.sampler.next_vertex_sampler(self.bounce, transmitted);
        let throughput = self.throughput * weight;
        Self { path_ray, throughput, bounce: self.bounce + 1, prev_nee_vertex: None, sampler, ..*self }
    }

    /// Plays Russian roulette by the path's throughput, before a vertex is shaded. Returns false if
    /// the path ends.
    ///
    /// If the path survives, its throughput is divided by the survival probability. A bright path
    /// needs no random number.
    #[inline]
    pub(super) fn play_shading_roulette(&mut self) -> bool {
        let survival = color::channel_mean(self.throughput) / ROULETTE_THROUGHPUT;
        if survival < 1.0 {
            if self.sampler.get_1d(Dimension::ShadingRoulette) >= survival {
                return false;
            }
            self.throughput /= survival;
        }
        true
    }

    /// Plays Russian roulette by the path's throughput. Returns false if the path ends.
    ///
    /// If the path survives, its throughput is divided by the survival probability. `sampler`
    /// provides the random number.
    #[inline]
    pub(super) fn play_russian_roulette(&mut self, sampler: Sampler) -> bool {
        let survival = (color::channel_mean(self.throughput) / ROULETTE_THROUGHPUT).min(1.0);
        if survival.is_nan() || sampler.get_1d(Dimension::Roulette) >= survival {
            return false;
        }
        self.throughput /= survival;
        true
    }

    /// Sets the weight of the indirect light that this path will find beyond its first receiver,
    /// the surface or medium that stores photons. Photon estimates carry the rest of that light.
    ///
    /// `sampler` is the sampler of the path's vertex at the receiver.
    #[inline]
    pub(super) fn share_indirect_with_photons(&mut self, weights: IndirectWeights, sampler: Sampler) {
        let (_, samples) = sampler.sample_index_and_count();
        self.pending_weight = weights.continued_path_factor(samples);
        self.shares_indirect = true;
    }
}
