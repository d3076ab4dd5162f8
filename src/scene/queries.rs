//! Scene queries of planning and of path tracing, beyond ray queries.

use super::animation::scene_at;
use super::geometry::ObjectAttributes;
use super::path_ray;
use super::{Body, Effects, Interior, Material, NormalPerturbation, PathRay, RayCone, Scene};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::light::Light;
use crate::math::{BoundingSphere, Bounds, Ray};
use crate::medium::Medium;
use crate::sampling::Key;
use glam::Vec3;

/// A shape, mesh or plane in the terms of planning.
#[derive(Clone, Copy, Debug)]
pub struct ObjectSummary {
    /// Bounding sphere, tight for spheres; `None` for unbounded planes.
    pub ball: Option<BoundingSphere>,
    /// A point and the unit normal of the plane in which the object lies, if it is known to be
    /// flat. No two points of a flat object see each other.
    pub plane: Option<(Vec3, Vec3)>,
    /// Index of the material.
    pub material: u32,
    /// True if the object emits by a texture.
    pub has_emission_texture: bool,
}

/// A material that a hit may resolve to, with one BSDF that it may have.
#[derive(Clone, Copy, Debug)]
pub struct LeafMaterial<'a> {
    /// The body that the material bounds.
    pub bounded_body: Option<&'a Body>,
    /// The BSDF of mean parameters, or at an extreme of a roughness texture.
    pub bsdf: Bsdf,
}

impl LeafMaterial<'_> {
    /// True if the material focuses light: see [`Bsdf::casts_caustics`].
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        match self.bounded_body {
            Some(body) => !body.null_interface,
            None => self.bsdf.casts_caustics(),
        }
    }
}

impl Scene {
    /// True if anything moves while the shutter is open.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        self.animation.is_some()
    }

    /// The scene at `time` in \[0, 1\], from the opening of the shutter to its closing.
    ///
    /// Triangles, their hierarchies, textures and the environment are shared.
    #[must_use]
    pub fn at(&self, time: f64) -> Self {
        scene_at(self, time)
    }

    /// All objects: shapes, then meshes with triangles, then planes.
    pub fn object_summaries(&self) -> impl Iterator<Item = ObjectSummary> {
        let geometry = &self.geometry;
        let summary = |attributes: &ObjectAttributes, ball, plane| ObjectSummary {
            ball,
            plane,
            material: attributes.material,
            has_emission_texture: self.has_emission_texture(attributes),
        };
        let shapes = geometry.shapes.iter().zip(&geometry.objects).map(move |(shape, attributes)| {
            let plane = shape.point_if_planar().map(|point| (point.p, point.ng));
            summary(attributes, Some(shape.bounding_sphere()), plane)
        });
        let meshes = geometry.mesh_ranges.iter().zip(geometry.mesh_attributes()).filter(|(range, _)| !range.is_empty());
        let meshes = meshes.map(move |(range, attributes)| {
            let corners = range.clone().flat_map(|i| geometry.mesh.corners(i as usize));
            summary(attributes, Some(Bounds::from_points(corners).bounding_sphere()), None)
        });
        let planes = geometry.planes.iter().zip(geometry.plane_attributes());
        let planes = planes.map(move |(plane, attributes)| summary(attributes, None, Some(plane.point_and_normal())));
        shapes.chain(meshes).chain(planes)
    }

    fn has_emission_texture(&self, attributes: &ObjectAttributes) -> bool {
        let light = attributes.light.map(|light| &self.lights[light as usize]);
        matches!(light, Some(Light::Area(area)) if area.texture.is_some())
    }

    /// The bodies that materials bound.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.materials.iter().filter_map(Material::bounded_body)
    }

    /// True if paths need to record interiors: there are bodies, or an ambient medium.
    #[must_use]
    pub fn has_interiors(&self) -> bool {
        self.ambient_medium.is_some() || self.bodies().next().is_some()
    }

    /// Calls `visit` with every leaf that `material` may resolve to.
    ///
    /// A conductor with a roughness texture is visited at the texture's extremes too, as they may
    /// differ in kind.
    pub fn for_each_leaf_material(&self, material: u32, visit: &mut impl FnMut(LeafMaterial<'_>)) {
        let material = &self.materials[material as usize];
        match material.mix_parts() {
            Some(parts) => parts.into_iter().for_each(|part| self.for_each_leaf_material(part, visit)),
            None => material.for_each_possible_bsdf(&self.textures, |bsdf| {
                visit(LeafMaterial { bounded_body: material.bounded_body(), bsdf });
            }),
        }
    }

    /// The media in use, each once: in bodies that objects bound, and the ambient medium.
    #[must_use]
    pub fn media_in_use(&self) -> Vec<&Medium> {
        let mut indices: Vec<u32> = self.ambient_medium.into_iter().collect();
        for object in self.object_summaries() {
            self.for_each_leaf_material(object.material, &mut |leaf| {
                indices.extend(leaf.bounded_body.and_then(|body| body.medium));
            });
        }
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter().map(|index| &self.media[index as usize]).collect()
    }

    /// Two flags of a material or any part of a mix: a parameter is textured, and normals are
    /// perturbed.
    #[must_use]
    pub fn texture_usage(&self, material: u32) -> (bool, bool) {
        let material = &self.materials[material as usize];
        let own = (material.is_textured(), material.normal_perturbation() != NormalPerturbation::None);
        let Some(parts) = material.mix_parts() else { return own };
        let parts = parts.map(|part| self.texture_usage(part));
        parts.iter().fold(own, |all, part| (all.0 || part.0, all.1 || part.1))
    }

    /// Bounding spheres of all objects that cast caustics, as targets of photons; `None` if one is
    /// unbounded.
    #[must_use]
    pub fn caster_bounding_spheres(&self) -> Option<Vec<BoundingSphere>> {
        let casts_caustics = |material: u32| {
            let mut casts = false;
            self.for_each_leaf_material(material, &mut |leaf| casts |= leaf.casts_caustics());
            casts
        };
        self.object_summaries().filter(|o| casts_caustics(o.material)).map(|o| o.ball).collect()
    }

    /// A camera path that starts along `ray` and simulates `effects`.
    #[inline]
    #[must_use]
    pub fn start_camera_path<I: Interior>(&self, ray: Ray, effects: Effects) -> PathRay<I> {
        PathRay { ray, inside: I::at_camera(self, &ray, effects), cone: self.camera_ray_cone(effects) }
    }

    /// The cone of a camera ray.
    #[inline]
    #[must_use]
    pub fn camera_ray_cone(&self, effects: Effects) -> RayCone {
        RayCone::from_pixel(self.camera.pixel_footprint(), effects)
    }

    /// A light path that starts at light `light` along `ray` and simulates `effects`.
    #[inline]
    #[must_use]
    pub fn start_light_path<I: Interior>(&self, light: usize, ray: Ray, effects: Effects) -> PathRay<I> {
        PathRay { ray, inside: I::at_light(self, light, effects), cone: RayCone::zero_width(effects) }
    }

    /// `ray` with its origin moved back beyond all unbounded planes, for light from infinity.
    #[must_use]
    pub(crate) fn move_origin_beyond_planes(&self, ray: Ray) -> Ray {
        let back = Ray::new(ray.origin, -ray.direction);
        let hits = self.geometry.planes.iter().filter_map(|plane| plane.intersect(&back));
        let farthest = hits.map(|(t, ..)| t).fold(0.0, f32::max);
        if farthest == 0.0 {
            return ray;
        }
        // The radius of the domain beyond, so that rounding does not lose the intersection itself.
        Ray { origin: back.at(farthest * 1.001 + self.photon_domain().radius), ..ray }
    }

    /// Unbiased transmittance from the end of `ray` to its origin, which lies in `inside`; 0 if a
    /// surface blocks it.
    ///
    /// The direction of a finite ray reaches from its origin to its end. That of an infinite ray is
    /// a unit vector.
    #[must_use]
    pub fn shadow_transmittance<I: Interior>(&self, ray: &Ray, inside: I, key: Key) -> Rgb {
        path_ray::shadow_transmittance(self, ray, inside, key)
    }

    /// Unbiased transmittance of the interior around the origin of `ray`, of unit direction;
    /// surfaces are ignored.
    #[inline]
    #[must_use]
    pub fn interior_transmittance<I: Interior>(&self, ray: &Ray, inside: &I, key: Key) -> Rgb {
        path_ray::interior_transmittance(self, ray, inside, key)
    }
}
