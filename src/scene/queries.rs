//! Queries about the objects, materials and paths of a scene.

use super::animation::scene_at_time;
use super::geometry::ObjectAttributes;
use super::path_ray;
use super::{Body, Effects, Hit, Interior, Material, NormalPerturbation, PathRay, RayCone, Scene};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::{BoundingSphere, Bounds, Ray};
use crate::medium::Medium;
use crate::sampling::Key;
use glam::Vec3;

/// Summary of one object of the scene (a shape, mesh or plane), for aiming photons and for planning
/// how to render the scene.
#[derive(Clone, Copy, Debug)]
pub struct ObjectSummary {
    /// Bounding sphere; `None` for unbounded planes. The bounding sphere of a sphere is the sphere
    /// itself.
    pub bounding_sphere: Option<BoundingSphere>,
    /// Point and unit normal of the plane that contains the object; `None` if the object may not be
    /// flat.
    pub plane: Option<(Vec3, Vec3)>,
    /// Index of the object's material.
    pub material: u32,
    /// True if a texture determines the object's emission.
    pub has_emission_texture: bool,
}

/// A material that is not a mix, with one of the BSDFs that it can have at a hit.
#[derive(Clone, Copy, Debug)]
pub struct LeafMaterial<'a> {
    /// The dielectric body that the material bounds, if it bounds one.
    pub enclosed_body: Option<&'a Body>,
    /// One of the BSDFs that the material can have at a hit.
    ///
    /// Textured parameters have their mean values, or the least or greatest value of a roughness
    /// texture. The BSDF may also be that of a coat alone, or of the surface under a clear coat.
    pub bsdf: Bsdf,
}

impl LeafMaterial<'_> {
    /// True if the surface is a caster: it scatters light, but stores no photons, such as glass or
    /// a mirror ([`PhotonKind`](crate::photon::PhotonKind) has the definition).
    ///
    /// False for a null interface, which light crosses undeflected.
    #[must_use]
    pub fn casts_caustics(&self) -> bool {
        match self.enclosed_body {
            Some(body) => !body.is_null_interface,
            None => self.bsdf.casts_caustics(),
        }
    }

    /// True if shadow rays cross surfaces of the material: null interfaces and thin sheets.
    #[must_use]
    pub fn is_crossed_by_shadow_rays(&self) -> bool {
        self.bsdf.transmits_straight() || self.enclosed_body.is_some_and(|body| body.is_null_interface)
    }
}

impl Scene {
    /// True if anything moves while the shutter is open.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        self.animation.is_some()
    }

    /// Number of parts that each call of [`Scene::at_time`] copies: moving shapes, and all planes,
    /// lights and texture mappings. Other large parts are shared, so this number measures the cost
    /// of a call.
    #[must_use]
    pub fn parts_copied_per_time(&self) -> usize {
        let Self { geometry, lights, mappings, .. } = self;
        geometry.shapes.moving().len() + geometry.planes.len() + lights.len() + mappings.len()
    }

    /// Returns a copy of the scene with all moving parts placed at `time`: 0 is the opening of the
    /// shutter, 1 its closing.
    ///
    /// The copy shares triangles, their bounding volume hierarchy, textures and the environment
    /// light with this scene.
    #[must_use]
    pub fn at_time(&self, time: f64) -> Self {
        scene_at_time(self, time)
    }

    /// Summaries of all objects: shapes, then meshes that have triangles, then planes.
    pub fn object_summaries(&self) -> impl Iterator<Item = ObjectSummary> {
        let geometry = &self.geometry;
        let summary = |attributes: &ObjectAttributes, bounding_sphere, plane| ObjectSummary {
            bounding_sphere,
            plane,
            material: attributes.material,
            has_emission_texture: self.object_has_emission_texture(attributes),
        };
        let shapes = geometry.shapes.iter().zip(&*geometry.objects).map(move |(shape, attributes)| {
            let plane = shape.point_if_planar().map(|point| (point.p, point.ng));
            summary(attributes, Some(shape.bounding_sphere()), plane)
        });
        let meshes =
            geometry.mesh_ranges.iter().zip(geometry.mesh_object_attributes()).filter(|(range, _)| !range.is_empty());
        let meshes = meshes.map(move |(range, attributes)| {
            let corners = range.clone().flat_map(|i| geometry.mesh.corners(i as usize));
            summary(attributes, Some(Bounds::from_points(corners).bounding_sphere()), None)
        });
        let planes = geometry.planes.iter().zip(geometry.plane_object_attributes());
        let planes = planes.map(move |(plane, attributes)| summary(attributes, None, Some(plane.point_and_normal())));
        shapes.chain(meshes).chain(planes)
    }

    fn object_has_emission_texture(&self, attributes: &ObjectAttributes) -> bool {
        attributes.light.is_some_and(|light| self.lights[light as usize].has_emission_texture())
    }

    /// The dielectric body of each material that bounds one.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.materials.iter().filter_map(Material::enclosed_body)
    }

    /// True if shadow rays cross some of the surfaces: null interfaces and thin sheets.
    ///
    /// See [`Scene::shadow_transmittance`].
    #[must_use]
    pub fn shadow_rays_cross_surfaces(&self) -> bool {
        self.shadow_rays_cross_surfaces
    }

    /// Returns the indices of the object and of the material at `hit`. The material may be a mix.
    ///
    /// Objects are numbered in this order: shapes at rest, moving shapes, meshes, planes.
    #[must_use]
    pub fn object_and_material_index(&self, hit: &Hit) -> (u32, u32) {
        let object = self.geometry.object_index(hit.primitive);
        (object, self.geometry.objects[object as usize].material)
    }

    /// True if the scene has dielectric bodies or an ambient medium, so that paths must track an
    /// [`Interior`].
    #[must_use]
    pub fn has_interiors(&self) -> bool {
        self.ambient_medium.is_some() || self.bodies().next().is_some()
    }

    /// Calls `visit` with every leaf material to which material `material` can resolve. These are
    /// the components of a mix that are no mixes themselves, or else the material itself.
    ///
    /// A conductor or coat with a roughness texture is visited with its mean, least and greatest
    /// roughness, which decide whether the BSDF is specular or stores photons. A coat that is too
    /// smooth to store photons is also visited alone, without its base: its α is at most
    /// [`MIN_PHOTON_STORAGE_ALPHA`](crate::bsdf::MIN_PHOTON_STORAGE_ALPHA). For a clear coat of any
    /// roughness, the coat alone and the surface under it are also visited.
    pub fn for_each_leaf_material(&self, material: u32, visit: &mut impl FnMut(LeafMaterial<'_>)) {
        let material = &self.materials[material as usize];
        match material.mix_component_indices() {
            Some(parts) => parts.into_iter().for_each(|part| self.for_each_leaf_material(part, visit)),
            None => material.visit_bsdf_variants(&self.textures, |bsdf| {
                visit(LeafMaterial { enclosed_body: material.enclosed_body(), bsdf });
            }),
        }
    }

    /// True if a medium in use emits light.
    #[must_use]
    pub fn has_emitting_media(&self) -> bool {
        self.media_in_use().iter().any(|medium| medium.emits())
    }

    /// Returns the media in use, each once: those of the bodies that objects bound, and the ambient
    /// medium.
    #[must_use]
    pub fn media_in_use(&self) -> Vec<&Medium> {
        let mut indices: Vec<u32> = self.ambient_medium.into_iter().collect();
        for object in self.object_summaries() {
            self.for_each_leaf_material(object.material, &mut |leaf| {
                indices.extend(leaf.enclosed_body.and_then(|body| body.medium));
            });
        }
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter().map(|index| &self.media[index as usize]).collect()
    }

    /// Returns two flags for the material with index `material`. The first is true if a texture
    /// sets a BSDF parameter or the amount of a mix. The second is true if a bump map or normal map
    /// perturbs shading normals.
    ///
    /// For a mix, the flags are true if they are true for the mix or for one of its components.
    #[must_use]
    pub fn material_texture_usage(&self, material: u32) -> (bool, bool) {
        let material = &self.materials[material as usize];
        let own = (material.is_textured(), material.normal_perturbation() != NormalPerturbation::None);
        let Some(parts) = material.mix_component_indices() else { return own };
        let parts = parts.map(|part| self.material_texture_usage(part));
        parts.iter().fold(own, |all, part| (all.0 || part.0, all.1 || part.1))
    }

    /// Bounding spheres of all casters: objects of mirror, glass and the like, which scatter light
    /// but store no photons. Photons for the caustic map are aimed at these spheres.
    ///
    /// `None` if a caster is an unbounded plane. [`PhotonKind`](crate::photon::PhotonKind) defines
    /// casters.
    #[must_use]
    pub fn caster_bounding_spheres(&self) -> Option<Vec<BoundingSphere>> {
        let casts_caustics = |material: u32| {
            let mut casts = false;
            self.for_each_leaf_material(material, &mut |leaf| casts |= leaf.casts_caustics());
            casts
        };
        self.object_summaries().filter(|o| casts_caustics(o.material)).map(|o| o.bounding_sphere).collect()
    }

    /// Returns the first ray of a camera path: `ray`, with the interior (surrounding bodies and
    /// media) at its origin, and the ray cone over which textures are filtered.
    ///
    /// The path simulates `effects`.
    #[inline]
    #[must_use]
    pub fn start_camera_path<I: Interior>(&self, ray: Ray, effects: Effects) -> PathRay<I> {
        PathRay { ray, interior: I::interior_at_camera(self, &ray, effects), cone: self.camera_ray_cone(effects) }
    }

    /// The ray cone of a camera ray at its origin. Textures are filtered over its width.
    #[inline]
    #[must_use]
    pub fn camera_ray_cone(&self, effects: Effects) -> RayCone {
        RayCone::from_pixel_footprint(self.camera.pixel_footprint_and_growth(), effects)
    }

    /// Returns the first ray of a light path: `ray`, with the interior (surrounding bodies and
    /// media) at its origin on light `light`. Textures are not filtered.
    ///
    /// The path simulates `effects`.
    #[inline]
    #[must_use]
    pub fn start_light_path<I: Interior>(&self, light: usize, ray: Ray, effects: Effects) -> PathRay<I> {
        let interior = I::interior_at_light(self, light, &ray, effects);
        PathRay { ray, interior, cone: RayCone::zero_width_cone(effects) }
    }

    /// Returns `ray` with its origin moved back along the ray, until no unbounded plane lies behind
    /// the origin.
    ///
    /// Photons of lights at infinity start at the moved origin, so that they hit these planes
    /// first.
    #[must_use]
    pub(crate) fn move_origin_beyond_planes(&self, ray: Ray) -> Ray {
        let back = Ray::new(ray.origin, -ray.direction);
        let hits = self.geometry.planes.iter().filter_map(|plane| plane.intersect(&back));
        let farthest = hits.map(|hit| hit.t).fold(0.0, f32::max);
        if farthest == 0.0 {
            return ray;
        }
        // Go farther by the domain's radius, so that rounding does not lose the intersection.
        Ray { origin: back.at(farthest * 1.001 + self.photon_domain().radius), ..ray }
    }

    /// Unbiased estimate of the transmittance along a shadow ray; 0 if a surface blocks the ray.
    ///
    /// Shadow rays cross null interfaces and, if `effects` has
    /// [`Effect::Specular`](super::Effect::Specular), thin sheets. `effects` also decides whether
    /// textures of sheets and mixes are looked up.
    ///
    /// `interior` holds the dielectric bodies and media around the ray's origin, and the random key
    /// `key` seeds all random choices. If `ray.t_max` is finite, the direction of `ray` must be the
    /// vector from its origin to its end, so that t = 1 at the end. If `ray.t_max` is infinite, the
    /// direction must have unit length.
    #[must_use]
    pub fn shadow_transmittance<I: Interior>(&self, ray: &Ray, interior: I, effects: Effects, key: Key) -> Rgb {
        path_ray::shadow_transmittance(self, ray, interior, effects, key)
    }

    /// Unbiased estimate of the transmittance along `ray`, which has a unit direction. Surfaces are
    /// ignored.
    ///
    /// `interior` holds the dielectric bodies and media around the origin of `ray`. They are
    /// assumed to surround the whole ray.
    #[inline]
    #[must_use]
    pub fn interior_transmittance<I: Interior>(&self, ray: &Ray, interior: &I, key: Key) -> Rgb {
        path_ray::interior_transmittance(self, ray, interior, key)
    }
}
