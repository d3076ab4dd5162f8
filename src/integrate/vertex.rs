//! Vertices of camera paths, and the receivers and casters that a path has visited before.

use crate::color::Rgb;
use crate::math::Ray;
use crate::sampling::Sampler;
use crate::scene::{Effects, Interior, MediumSegment, PathRay, RayCone, Scene, SurfaceInteraction};
use glam::Vec3;

/// Numbers of receivers and casters that a camera path has visited up to a vertex.
///
/// *Receiver*: a surface or medium that stores photons, such as a diffuse wall. *Caster*: a surface
/// that passes photons on, such as a mirror or glass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PathHistory {
    /// Number of receivers (surfaces and media that store photons) visited since the camera.
    pub receivers: u32,
    /// Number of casters (mirrors, glass and the like) visited since the last receiver, or since
    /// the camera if there is no receiver.
    pub casters_since_receiver: u32,
}

impl PathHistory {
    /// True if the light that the path finds next is caustic: it reaches the path's last receiver
    /// (a surface or medium that stores photons) via one or more casters, such as glass.
    #[inline]
    pub fn is_caustic(self) -> bool {
        self.receivers > 0 && self.casters_since_receiver > 0
    }
}

/// Vertex of a camera path on a surface.
pub(super) struct PathVertex<'a, I> {
    /// Surface point, with its BSDF and the direction to the previous vertex.
    pub surface: &'a SurfaceInteraction<'a>,
    /// Nested bodies and medium on the side of the surface from which the path arrived.
    pub interior: &'a I,
    /// Numbers of receivers (surfaces and media that store photons) and casters (such as glass)
    /// that the path visited before this vertex. If this vertex itself is a caster, the number of
    /// casters includes it.
    pub history: PathHistory,
    /// Factor from radiance that leaves the vertex to radiance of the pixel.
    pub throughput: Rgb,
    /// Distance from the previous vertex \[length].
    pub distance: f32,
    /// Sampler of the vertex's random decisions.
    pub sampler: Sampler,
    /// Sampler of the vertex's shadow rays.
    pub shadow_sampler: Sampler,
}

impl<I: Interior> PathVertex<'_, I> {
    /// Returns the unit normal of the hemisphere from which the BSDF scatters light to the viewer;
    /// `None` if the BSDF also transmits.
    #[inline]
    pub fn scattering_hemisphere(&self) -> Option<Vec3> {
        (!self.surface.bsdf.transmits()).then(|| self.surface.facing_normal())
    }

    /// Returns the path ray that leaves the surface in unit direction `wi`: a ray with the nested
    /// bodies and the medium around its origin.
    #[inline]
    pub fn outgoing_path_ray(&self, wi: Vec3) -> PathRay<I> {
        let cone = RayCone::zero_width_cone(Effects::NONE);
        let mut path_ray = PathRay { ray: Ray::new(self.surface.point.p, wi), interior: *self.interior, cone };
        path_ray.leave_surface_with_wavelength_weight(self.surface, wi, self.surface.is_transmitted(wi));
        path_ray
    }

    /// Returns an unbiased estimate of the transmittance of the medium or body into which unit
    /// direction `wi` leads from the vertex, over `distance` \[length]. Surfaces are ignored.
    #[inline]
    pub fn transmittance(&self, scene: &Scene, wi: Vec3, distance: f32) -> Rgb {
        let path_ray = self.outgoing_path_ray(wi);
        if I::HAS_MEDIA_OR_WAVELENGTH {
            let ray = Ray { t_max: distance, ..path_ray.ray };
            return scene.interior_transmittance(&ray, &path_ray.interior, self.shadow_sampler.sample_key());
        }
        path_ray.interior.absorption_transmittance(scene, distance)
    }
}

/// Segment of a camera path through a medium, with the path's state at the start of the segment.
pub(super) struct MediumPathSegment<'a, I> {
    /// Ray and medium of the segment.
    pub segment: &'a MediumSegment<'a, I>,
    /// Numbers of receivers (surfaces and media that store photons) and casters (such as glass)
    /// that the camera path visited before the segment.
    pub history: PathHistory,
    /// Factor from radiance at the start of the segment to radiance of the pixel.
    pub throughput: Rgb,
    /// Sampler of the segment's random decisions.
    pub sampler: Sampler,
    /// Sampler of the segment's shadow rays.
    pub shadow_sampler: Sampler,
}

/// Previous vertex of a camera path, for multiple importance sampling of emission.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrevVertex {
    /// Position of the previous vertex.
    pub p: Vec3,
    /// Unit normal of the hemisphere from which the previous vertex scatters light; `None` for the
    /// whole sphere.
    pub hemisphere: Option<Vec3>,
    /// Numbers of receivers (surfaces and media that store photons) and casters (such as glass)
    /// that the camera path visited before the previous vertex. If that vertex itself is a caster,
    /// the number of casters includes it.
    pub history: PathHistory,
    /// Pdf of the direction in which the path left the previous vertex \[1/sr].
    pub pdf: f32,
}
