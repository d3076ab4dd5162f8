//! A hit that has been looked at.

use super::{Interface, Material};
use crate::bsdf::{BsdfSample, Transport};
use crate::color::Rgb;
use crate::math::{Ray, offset_origin};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// A surface as a ray met it.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Place and normals.
    pub point: SurfacePoint,
    /// Unit direction to where the ray came from.
    pub wo: Vec3,
    /// What it is made of.
    pub material: &'a Material,
    /// Radiance that it emits towards `wo` \[W/(m² sr)].
    pub emission: Rgb,
}

impl Surface<'_> {
    /// The geometric normal on the side of `wo`.
    #[inline]
    #[must_use]
    pub fn facing_normal(&self) -> Vec3 {
        if self.wo.dot(self.point.ng) < 0.0 { -self.point.ng } else { self.point.ng }
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
        self.material.bsdf.evaluate(self.wo, wi, ns, ng, Transport::Radiance) * wi.dot(ns).abs()
    }

    /// Draws where the walk goes on.
    #[inline]
    #[must_use]
    pub fn sample(&self, lobe: f32, u: Vec2, transport: Transport) -> Option<BsdfSample> {
        self.material.bsdf.sample(self.wo, self.point.ns, self.point.ng, lobe, u, transport)
    }

    /// Absorption of what lies on the side of `direction` \[1/length], where this surface bounds a body; `None` on its outside.
    #[inline]
    #[must_use]
    pub fn body_towards(&self, direction: Vec3) -> Option<Rgb> {
        match self.material.interface {
            Interface::Body(absorption) if direction.dot(self.point.ng) < 0.0 => Some(absorption),
            _ => None,
        }
    }
}
