//! A hit that has been looked at.

use super::touching::Touching;
use super::{Material, Scattering};
use crate::bsdf::{Bsdf, BsdfSample, Transport};
use crate::color::Rgb;
use crate::math::{Ray, offset_origin};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// A surface as a ray met it.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction<'a> {
    /// Place and normals.
    pub point: SurfacePoint,
    /// Unit direction to where the ray came from.
    pub wo: Vec3,
    /// What it is made of; of a mix, what was chosen.
    pub material: &'a Material,
    /// Index of the material.
    pub(super) index: u32,
    /// How it scatters.
    pub bsdf: Bsdf,
    /// Roughness α, of the boundary of a body.
    pub(super) roughness: f32,
    /// The thing that it is a part of, where another's boundary may coincide with it.
    pub(super) crowded: Option<u32>,
    /// Boundaries that coincide with it, where it is one and was met as such.
    pub(super) touching: Touching,
    /// Index of the light that it is.
    pub light: Option<u32>,
    /// Radiance that it emits towards `wo` \[W/(m² sr)].
    pub emission: Rgb,
}

impl SurfaceInteraction<'_> {
    /// The geometric normal on the side of `wo`.
    #[inline]
    #[must_use]
    pub fn facing_normal(&self) -> Vec3 {
        if self.wo.dot(self.point.ng) < 0.0 { -self.point.ng } else { self.point.ng }
    }

    /// Whether it is but the bound of a place, which light does not notice.
    #[inline]
    #[must_use]
    pub fn is_clear(&self) -> bool {
        matches!(self.material.scattering, Scattering::Boundary(body) if body.clear)
    }

    /// A ray that leaves in unit `direction`.
    #[inline]
    #[must_use]
    pub fn leave(&self, direction: Vec3) -> Ray {
        Ray::new(offset_origin(self.point.p, self.point.error, self.point.ng, direction), direction)
    }

    /// The segment to `target`, which lies in unit `direction`.
    #[inline]
    #[must_use]
    pub fn segment_to(&self, target: Vec3, direction: Vec3) -> Ray {
        Ray::between(offset_origin(self.point.p, self.point.error, self.point.ng, direction), target)
    }

    /// f(wo, wi)·|wi · ns|: what a camera walk multiplies arriving radiance by.
    #[inline]
    #[must_use]
    pub fn scatter(&self, wi: Vec3) -> Rgb {
        let SurfacePoint { ns, ng, .. } = self.point;
        self.bsdf.evaluate(self.wo, wi, ns, ng, Transport::Radiance) * wi.dot(ns).abs()
    }

    /// Density with which [`SurfaceInteraction::sample`] draws `wi` \[1/sr].
    #[inline]
    #[must_use]
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.bsdf.pdf(self.wo, wi, self.point.ns, self.point.ng)
    }

    /// Draws where the walk goes on.
    #[inline]
    #[must_use]
    pub fn sample(&self, lobe: f32, u: Vec2, transport: Transport) -> Option<BsdfSample> {
        self.bsdf.sample(self.wo, self.point.ns, self.point.ng, lobe, u, transport)
    }
}
