//! What a camera walk stands on, and what tells one algorithm from another there.

use super::tiles::Worker;
use crate::bsdf::{Bsdf, BsdfSample, Transport};
use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::{Dimension, Sampler};
use crate::scene::{Effects, Interior, MediumSegment, PathRay, RayCone, Scene, SurfaceInteraction};
use glam::Vec3;
use rand::rngs::SmallRng;

/// What a camera walk has met before it stands where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct History {
    /// Receivers so far.
    pub receivers: u32,
    /// Casters since the last receiver, or since the camera.
    pub casters: u32,
}

impl History {
    /// Whether light that is met now comes by a path of the kind that photons find: over casters to a receiver.
    #[inline]
    pub fn is_caustic(self) -> bool {
        self.receivers > 0 && self.casters > 0
    }
}

/// A vertex whose surface scatters more than deltas.
pub(super) struct Vertex<'a, I> {
    /// The surface.
    pub surface: &'a SurfaceInteraction<'a>,
    /// What the surface is inside of, on the side of the viewer.
    pub inside: &'a I,
    /// What came before.
    pub history: History,
    /// Part of what it sends back that reaches the pixel.
    pub throughput: Rgb,
    /// Length of the way from the last vertex \[length].
    pub distance: f32,
    /// Random numbers of the vertex.
    pub draw: Sampler,
    /// Random numbers of its shadow rays.
    pub shadow_draw: Sampler,
}

impl<I: Interior> Vertex<'_, I> {
    /// The side on which light counts; `None` where both do.
    #[inline]
    pub fn horizon(&self) -> Option<Vec3> {
        horizon(self.surface)
    }

    /// A walk that leaves in unit direction `wi`.
    #[inline]
    pub fn leaving(&self, wi: Vec3) -> PathRay<I> {
        let cone = RayCone::point(Effects::NONE);
        let mut walk = PathRay { ray: Ray::new(self.surface.point.p, wi), inside: *self.inside, cone };
        let transmitted = wi.dot(self.surface.point.ng) * self.surface.wo.dot(self.surface.point.ng) < 0.0;
        walk.leave(self.surface, wi, transmitted);
        walk
    }

    /// Part of the light that is left of what comes from `distance` away in unit direction `wi`, where nothing is in the way.
    #[inline]
    pub fn transmittance(&self, scene: &Scene, wi: Vec3, distance: f32) -> Rgb {
        let walk = self.leaving(wi);
        if I::SPECTRAL {
            let ray = Ray { t_max: distance, ..walk.ray };
            return scene.interior_transmittance(&ray, &walk.inside, self.shadow_draw.key());
        }
        walk.inside.transmittance(scene, distance)
    }
}

/// A stretch of a medium that a walk goes through.
pub(super) struct Passage<'a, I> {
    pub stretch: &'a MediumSegment<'a, I>,
    /// What came before.
    pub history: History,
    /// Part of what it sends back that reaches the pixel.
    pub throughput: Rgb,
    /// Random numbers of the step.
    pub draw: Sampler,
}

/// The side of a surface on which light counts; `None` where both do.
#[inline]
fn horizon(surface: &SurfaceInteraction<'_>) -> Option<Vec3> {
    (!surface.bsdf.transmits()).then(|| surface.facing_normal())
}

/// What is done at a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct AtReceiver {
    /// Ask the lights.
    pub direct: bool,
    /// Walk on.
    pub onward: bool,
}

/// What tells one algorithm from another.
pub(super) trait Method: Sync {
    /// The part of a receiver's scattering that is looked at this time, over the probability of that.
    #[inline]
    fn part(&self, bsdf: Bsdf, _: f32) -> Bsdf {
        bsdf
    }

    /// What is done at a receiver.
    fn at_receiver<I: Interior>(&self, vertex: &Vertex<'_, I>) -> AtReceiver;

    /// Whether it looks at photons.
    fn estimates(&self) -> bool {
        false
    }

    /// Radiance that a receiver sends to its viewer of light that photons brought.
    fn photons<I: Interior>(&self, _: &Vertex<'_, I>, _: &mut Worker) -> Rgb {
        Rgb::ZERO
    }

    /// What is done where a medium scatters light.
    fn in_medium(&self, _: History) -> AtReceiver {
        AtReceiver { direct: true, onward: false }
    }

    /// Radiance that a stretch of a medium sends to its start of light that photons brought.
    fn volume<I: Interior>(&self, _: &Passage<'_, I>, _: &mut SmallRng, _: &mut Worker) -> Rgb {
        Rgb::ZERO
    }

    /// Whether light that is found after `history`, by a connection or by chance, counts.
    fn counts(&self, history: History) -> bool;

    /// Readies what [`Method::sample`] and [`Method::pdf`] need at a receiver.
    fn prepare<I: Interior>(&self, _: &Vertex<'_, I>, _: &mut Worker) {}

    /// Draws where the walk goes on from a surface.
    #[inline]
    fn sample<I: Interior>(&self, vertex: &Vertex<'_, I>, _: &mut Worker) -> Option<BsdfSample> {
        let (lobe, u) = (vertex.draw.get_1d(Dimension::BsdfLobe), vertex.draw.get_2d(Dimension::BsdfDirection));
        vertex.surface.sample(lobe, u, Transport::Radiance)
    }

    /// Density of `sample` per steradian.
    #[inline]
    fn pdf<I: Interior>(&self, vertex: &Vertex<'_, I>, wi: Vec3, _: &mut Worker) -> f32 {
        vertex.surface.pdf(wi)
    }

    /// Whether all passes share their camera walks.
    fn repeats_walks(&self) -> bool {
        false
    }

    /// Throughput below which a walk over casters is cut; 0 leaves that to roulette.
    fn cut(&self) -> f32 {
        0.0
    }
}
