//! Vertices of camera paths.

use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::Sampler;
use crate::scene::{Effects, Interior, MediumSegment, PathRay, RayCone, Scene, SurfaceInteraction};
use glam::Vec3;

/// Receivers and casters on a camera path, up to a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PathHistory {
    /// Receivers, and scattering events in media, since the camera.
    pub receivers: u32,
    /// Casters since the last receiver, or since the camera.
    pub casters: u32,
}

impl PathHistory {
    /// True if emission found now arrives as a caustic: from the light over casters to a receiver.
    #[inline]
    pub fn is_caustic(self) -> bool {
        self.receivers > 0 && self.casters > 0
    }
}

/// Vertex of a camera path on a surface: a receiver or a caster, which may be a delta.
pub(super) struct PathVertex<'a, I> {
    /// The surface.
    pub surface: &'a SurfaceInteraction<'a>,
    /// Interior on the viewer's side of the surface.
    pub interior: &'a I,
    /// Receivers and casters before this vertex; a caster counts itself.
    pub history: PathHistory,
    /// Weight of outgoing radiance in the pixel.
    pub throughput: Rgb,
    /// Distance from the previous vertex \[length].
    pub distance: f32,
    /// Random numbers of the vertex.
    pub sampler: Sampler,
    /// Random numbers of its shadow rays.
    pub shadow_sampler: Sampler,
}

impl<I: Interior> PathVertex<'_, I> {
    /// Normal of the hemisphere from which light scatters; `None` for surfaces that transmit.
    #[inline]
    pub fn scattering_hemisphere(&self) -> Option<Vec3> {
        (!self.surface.bsdf.transmits()).then(|| self.surface.facing_normal())
    }

    /// Path ray that leaves in unit direction `wi`.
    #[inline]
    pub fn outgoing_path_ray(&self, wi: Vec3) -> PathRay<I> {
        let cone = RayCone::zero_width(Effects::NONE);
        let mut path_ray = PathRay { ray: Ray::new(self.surface.point.p, wi), inside: *self.interior, cone };
        let transmitted = wi.dot(self.surface.point.ng) * self.surface.wo.dot(self.surface.point.ng) < 0.0;
        path_ray.leave(self.surface, wi, transmitted);
        path_ray
    }

    /// Unbiased transmittance of the interior over `distance` \[length] in unit direction `wi`;
    /// surfaces are ignored.
    #[inline]
    pub fn transmittance(&self, scene: &Scene, wi: Vec3, distance: f32) -> Rgb {
        let path_ray = self.outgoing_path_ray(wi);
        if I::SPECTRAL {
            let ray = Ray { t_max: distance, ..path_ray.ray };
            return scene.interior_transmittance(&ray, &path_ray.inside, self.shadow_sampler.sample_key());
        }
        path_ray.inside.transmittance(scene, distance)
    }
}

/// Segment of a camera path through a scattering medium.
pub(super) struct MediumVertex<'a, I> {
    /// The segment.
    pub segment: &'a MediumSegment<'a, I>,
    /// Receivers and casters before the segment.
    pub history: PathHistory,
    /// Weight in the pixel of radiance that leaves the start of the segment.
    pub throughput: Rgb,
    /// Random numbers of the segment.
    pub sampler: Sampler,
    /// Random numbers of its shadow rays.
    pub shadow_sampler: Sampler,
}

/// Previous vertex of a camera path, for multiple importance sampling.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrevVertex {
    /// Position of the vertex.
    pub p: Vec3,
    /// Normal of the hemisphere from which light scatters there; `None` if that is the whole
    /// sphere.
    pub hemisphere: Option<Vec3>,
    /// Receivers and casters before the vertex.
    pub history: PathHistory,
    /// Pdf of the direction that the path took from there \[1/sr].
    pub pdf: f32,
}
