//! The surface that a ray hits: position, normals, material, BSDF and emission.

use super::Material;
use super::geometry::CoincidenceGroup;
use super::interiors::CoincidentFaces;
use crate::bsdf::{Bsdf, BsdfSample, TransportMode};
use crate::color::Rgb;
use crate::math::{Ray, offset_ray_origin};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// The surface at a hit, with its BSDF and emission.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction<'a> {
    /// Position and normals of the surface at the hit.
    pub point: SurfacePoint,
    /// Unit direction from the surface towards the origin of the ray that hit it.
    pub wo: Vec3,
    /// The material; for a mix, the selected component, which is not a mix itself.
    pub material: &'a Material,
    /// Index of the material `material` in the scene.
    pub(super) material_index: u32,
    /// The BSDF of the material at this point; for a coated surface, the selected layer.
    pub bsdf: Bsdf,
    /// True if another random choice at this hit could have given a BSDF that stores photons. The
    /// choice is among the components of a mix, or between coat and base.
    pub(super) other_choice_stores_photons: bool,
    /// Roughness α of a dielectric body's boundary; 0 for other materials.
    pub(super) boundary_roughness: f32,
    /// Coincidence group of the object: the objects whose boundaries count as one boundary if they
    /// coincide. `None` if no boundary of another object can coincide with the surface here.
    pub(super) coincidence_group: Option<CoincidenceGroup>,
    /// Boundaries of other dielectric bodies that coincide with the surface here; empty until
    /// `Interior::resolve_boundary` finds them.
    pub(super) coincident: CoincidentFaces,
    /// Index of the object's area light; `None` if the object does not emit light.
    pub area_light_index: Option<u32>,
    /// Radiance that the surface emits towards `wo` \[W/(m² sr)].
    pub emission: Rgb,
}

impl SurfaceInteraction<'_> {
    /// The geometric unit normal, turned to the side of the surface from which the ray arrives.
    #[inline]
    #[must_use]
    pub fn facing_normal(&self) -> Vec3 {
        if self.wo.dot(self.point.ng) < 0.0 { -self.point.ng } else { self.point.ng }
    }

    /// Geometric unit normals of the sides from which incident light is scattered towards `wo`: the
    /// [facing normal](Self::facing_normal) and, if the BSDF transmits, its opposite.
    #[inline]
    pub fn light_side_normals(&self) -> impl Iterator<Item = Vec3> {
        let facing = self.facing_normal();
        std::iter::once(facing).chain(self.bsdf.transmits().then_some(-facing))
    }

    /// True if unit direction `wi` leaves the surface on the other side than `wo`.
    #[inline]
    #[must_use]
    pub fn is_transmitted(&self, wi: Vec3) -> bool {
        wi.dot(self.point.ng) * self.wo.dot(self.point.ng) < 0.0
    }

    /// True if photons are stored here: by the BSDF that was chosen, or by another one that the
    /// random choice at this hit could have given.
    ///
    /// Camera paths and photon paths choose their BSDFs independently. Suppose a mix gives a
    /// diffuse BSDF with probability p. A camera path that chose the diffuse BSDF needs all photons
    /// of this point. If photons were stored only by photon paths that chose the diffuse BSDF too,
    /// the estimate would be too small by the factor p.
    #[inline]
    #[must_use]
    pub fn stores_photons(&self) -> bool {
        self.bsdf.stores_photons() || self.other_choice_stores_photons
    }

    /// True if the surface is a null interface, which light passes unchanged.
    #[inline]
    #[must_use]
    pub fn is_null_interface(&self) -> bool {
        self.material.enclosed_body().is_some_and(|body| body.is_null_interface)
    }

    /// True if the ray arrives from the side of the geometric normal. For the boundary of a
    /// dielectric body, this side is outside.
    #[inline]
    pub(super) fn is_entering(&self) -> bool {
        self.wo.dot(self.point.ng) >= 0.0
    }

    /// The ray that leaves the surface in unit `direction`.
    ///
    /// Its origin is offset from the surface, so that the ray does not hit the surface again here.
    #[inline]
    #[must_use]
    pub fn spawn_ray(&self, direction: Vec3) -> Ray {
        Ray::new(offset_ray_origin(self.point.p, self.point.position_error, self.point.ng, direction), direction)
    }

    /// The ray segment from the surface to the point `target`, which lies in unit `direction`.
    ///
    /// t is 1 at `target`. The origin is offset, so that the ray does not hit the surface again
    /// here.
    #[inline]
    #[must_use]
    pub fn spawn_ray_to(&self, target: Vec3, direction: Vec3) -> Ray {
        Ray::between_points(
            offset_ray_origin(self.point.p, self.point.position_error, self.point.ng, direction),
            target,
        )
    }

    /// BSDF times cosine, f(wo, wi)·|wi · ns| \[1/sr], for radiance along a camera path.
    #[inline]
    #[must_use]
    pub fn bsdf_cosine(&self, wi: Vec3) -> Rgb {
        let SurfacePoint { ns, ng, .. } = self.point;
        self.bsdf.evaluate(self.wo, wi, ns, ng, TransportMode::Radiance) * wi.dot(ns).abs()
    }

    /// Solid-angle pdf with which [`SurfaceInteraction::sample`] samples `wi` \[1/sr].
    #[inline]
    #[must_use]
    pub fn pdf(&self, wi: Vec3) -> f32 {
        self.bsdf.pdf(self.wo, wi, self.point.ns, self.point.ng)
    }

    /// Samples the direction in which the path continues; `None` if the path is absorbed.
    ///
    /// `lobe` in \[0, 1) selects a lobe of the BSDF, and `u` in \[0, 1)² a direction of that lobe.
    #[inline]
    #[must_use]
    pub fn sample(&self, lobe: f32, u: Vec2, transport: TransportMode) -> Option<BsdfSample> {
        self.bsdf.sample(self.wo, self.point.ns, self.point.ng, lobe, u, transport)
    }
}
