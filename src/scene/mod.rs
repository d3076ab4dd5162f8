//! The scene in the form that integrators read: geometry with bounding volume hierarchies,
//! materials, lights, camera.
//!
//! Coordinates are relative to an origin near the objects, so that single precision suffices for
//! triangles.

mod animation;
mod build;
mod delta_light;
mod effects;
mod error;
mod film_motion;
mod geometry;
mod interiors;
mod material;
mod motion_length;
mod near_primitives;
mod path_ray;
mod queries;
mod ray_cone;
mod shape_list;
mod surface_interaction;
mod textured;

pub use crate::light::UnscaledDeltaLight;
pub use build::SceneBuilder;
pub use delta_light::{LightStrength, Mit6837Light};
pub use effects::{CASTER_DESCRIPTION, Effect, Effects};
pub use error::BuildError;
pub use film_motion::FilmMotionMeter;
pub use geometry::Hit;
pub(crate) use interiors::with_interior_type;
pub use interiors::{
    Body, BoundaryContext, BoundaryEvent, CurrentMedium, Interior, InteriorKind, InteriorStack, NoInterior,
    SpectralInterior,
};
pub use material::{ConductorIndex, Material, MaterialKind, PhongAppearance};
pub use motion_length::max_motion_in_pixels;
pub use near_primitives::NearPrimitives;
pub use path_ray::{MediumSegment, PathEvent, PathRay, SurfaceVertex};
pub use queries::{LeafMaterial, ObjectSummary};
pub use ray_cone::RayCone;
pub use surface_interaction::SurfaceInteraction;
pub use textured::{
    MaterialParameter, MeanParameterEvaluator, NormalPerturbation, ParameterEvaluator, TextureEvaluator,
};

use crate::camera::Camera;
use crate::color::{DispersionFormula, Rgb};
use crate::light::Light;
use crate::math::{BoundingSphere, Ray};
use crate::medium::Medium;
use crate::shape::{Shape, SurfacePoint, TextureMapping};
use crate::texture::{Texture, TextureEvalContext};
use animation::Animation;
use build::{DerivedSceneData, derive_scene_data};
use geometry::Geometry;
use glam::{DVec3, Vec3};
use interiors::{CoincidentFaces, CoincidentFlags};
use std::sync::Arc;
use textured::{TextureFootprint, perturbed_normal};

/// A scene ready to be rendered, with moving objects placed at one time of the shutter interval.
///
/// Coordinates are relative to [`Scene::origin`]. Ray queries ([`Scene::intersect`]) return the
/// nearest primitive. [`Scene::surface_interaction`] adds material, textures and emission at the
/// hit.
#[derive(Clone)]
pub struct Scene {
    camera: Camera,
    background: Rgb,
    geometry: Geometry,
    materials: Vec<Material>,
    dispersion_formulas: Vec<DispersionFormula>,
    media: Vec<Medium>,
    ambient_medium: Option<u32>,
    /// True if shadow rays cross the surface of some object: a null interface or a thin sheet, or a
    /// mix that may resolve to one of these.
    shadow_rays_cross_surfaces: bool,
    textures: Vec<Arc<Texture>>,
    /// Texture mappings, by index. The first one is the default, for objects that define none.
    mappings: Vec<TextureMapping>,
    lights: Vec<Light>,
    /// Index of the environment light in `lights`; `None` if there is none.
    environment_light_index: Option<usize>,
    /// The lights with each emission texture replaced by its mean radiance; empty if no light has
    /// an emission texture.
    mean_emission_lights: Vec<Light>,
    mit_6837_lights: Vec<Mit6837Light>,
    animation: Option<Arc<Animation>>,
    origin: DVec3,
    coincident: CoincidentFlags,
    derived: DerivedSceneData,
}

impl std::fmt::Debug for Scene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scene")
            .field("triangles", &self.triangle_count())
            .field("shapes", &self.analytic_shape_count())
            .field("lights", &self.lights)
            .field("materials", &self.materials)
            .finish_non_exhaustive()
    }
}

impl Scene {
    /// The camera, in coordinates relative to [`Scene::origin`].
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Returns a copy of the scene with another camera, given in the coordinates of the scene
    /// description (not relative to [`Scene::origin`]).
    ///
    /// This camera does not move while the shutter is open. The copy has the same [`Scene::origin`]
    /// as this scene, and shares geometry, bounding volume hierarchies and textures with it.
    #[must_use]
    pub fn with_camera(&self, camera: &Camera) -> Self {
        let mut scene = self.clone();
        scene.camera = camera.translated(-self.origin);
        scene.animation = self.animation.as_deref().and_then(|animation| {
            let resting = Animation { camera: None, ..animation.clone() };
            (!resting.is_empty()).then(|| Arc::new(resting))
        });
        scene.derived = derive_scene_data(&scene);
        scene
    }

    /// Returns the camera in the coordinates of the scene description, at mid-shutter.
    #[must_use]
    pub fn camera_in_description(&self) -> Camera {
        self.camera.translated(self.origin)
    }

    /// Radiance \[W/(m² sr)] of camera rays that hit nothing, used if there is no environment
    /// light.
    ///
    /// The background does not illuminate surfaces.
    #[must_use]
    pub fn background(&self) -> Rgb {
        self.background
    }

    /// Radiance \[W/(m² sr)] that a ray in unit `direction` receives if it hits nothing.
    ///
    /// It is the radiance of the environment light, or the background if there is none.
    #[inline]
    #[must_use]
    pub fn escaped_radiance(&self, direction: Vec3) -> Rgb {
        let environment = self.environment_light_index.and_then(|index| self.lights[index].as_environment_light());
        environment.map_or(self.background, |environment| environment.radiance(direction))
    }

    /// Index of the environment light in [`Scene::lights`], if there is one.
    #[must_use]
    pub fn environment_light_index(&self) -> Option<usize> {
        self.environment_light_index
    }

    /// All lights of the scene. An environment light is the last.
    #[must_use]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The lights with each emission texture replaced by its mean radiance, in the order of
    /// [`Scene::lights`]. These lights replace [`Scene::lights`] if [`Effect::Textures`] is off, or
    /// if each light is sampled only at its center.
    #[must_use]
    pub fn mean_emission_lights(&self) -> &[Light] {
        if self.mean_emission_lights.is_empty() { &self.lights } else { &self.mean_emission_lights }
    }

    /// The lights that algorithm `raycast` uses. Their light does not fall off with distance, as in
    /// MIT course 6.837. The order is that of [`Scene::lights`], without the environment light.
    #[must_use]
    pub fn mit_6837_lights(&self) -> &[Mit6837Light] {
        &self.mit_6837_lights
    }

    /// Distance \[length] below which a surface point counts as touching the light with index
    /// `light`; 0 for area lights and lights at infinity.
    ///
    /// A light that touches a surface illuminates both sides of the surface. The reason is that
    /// coordinates are rounded by up to 2⁻²⁴ of their values, so the light's side is unknown.
    #[inline]
    #[must_use]
    pub fn light_contact_distance(&self, light: usize) -> f32 {
        self.derived.light_contact_distances[light]
    }

    /// All materials, by material index.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Dispersion formulas to which [`Body::dispersion_formula`] refers by index.
    #[must_use]
    pub fn dispersion_formulas(&self) -> &[DispersionFormula] {
        &self.dispersion_formulas
    }

    /// All participating media, by medium index.
    #[must_use]
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// Index in [`Scene::media`] of the medium outside all dielectric bodies, such as fog; `None`
    /// for air.
    ///
    /// The medium fills a ball around the center of the [photon domain](Scene::photon_domain). The
    /// ball's radius is 2d, where d is the greatest distance from this center to a light, the
    /// camera or the domain's edge.
    #[must_use]
    pub fn ambient_medium(&self) -> Option<u32> {
        self.ambient_medium
    }

    /// The ball onto which lights at infinity emit photons.
    ///
    /// The ball's surface passes through the corners of the box around all bounded objects. In a
    /// scene with unbounded planes, the radius is four times as large. Without bounded objects, the
    /// greatest distance of a plane from the origin determines the radius.
    #[must_use]
    pub fn photon_domain(&self) -> BoundingSphere {
        self.derived.photon_domain
    }

    /// Origin of the coordinates of this scene, in the coordinates of the scene description. A
    /// position in the scene is the position in the description minus this point.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Number of triangles. The triangles of a mesh count once for each of its instances.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        let instanced =
            |shape: &Shape| if let Shape::Instance(instance) = shape { instance.triangle_count() } else { 0 };
        self.geometry.mesh.triangles.len() + self.geometry.shapes.iter().map(instanced).sum::<usize>()
    }

    /// Number of analytic shapes, planes included.
    #[must_use]
    pub fn analytic_shape_count(&self) -> usize {
        let analytic = |shape: &&Shape| !matches!(shape, Shape::Instance(_));
        self.geometry.shapes.iter().filter(analytic).count() + self.geometry.planes.len()
    }

    /// The nearest intersection of `ray` with any surface, for 0 < t < `ray.t_max`; `None` if the
    /// ray hits nothing.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.geometry.intersect(ray)
    }

    /// True if `ray` hits any surface, for 0 < t < `ray.t_max`.
    #[inline]
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.geometry.occluded(ray)
    }

    /// Returns the surface at `hit` of `ray`, which must have a unit direction.
    ///
    /// Textures are filtered over the width of `cone`. `u_mix` returns a uniform number in \[0, 1),
    /// and is called only if the BSDF is chosen at random: from the components of a mix, or from
    /// coat and base. The boundary of a dielectric body gets the BSDF that it has in air.
    /// [`Interior::resolve_boundary`] then replaces this BSDF according to the bodies around the
    /// path.
    #[inline]
    #[must_use]
    pub fn surface_interaction(
        &self,
        ray: &Ray,
        hit: &Hit,
        cone: &RayCone,
        u_mix: impl FnOnce() -> f32,
    ) -> SurfaceInteraction<'_> {
        let point = self.geometry.surface_point(ray, hit);
        let object = self.geometry.object_attributes(hit.primitive);
        let wo = -ray.direction;
        let emission = match object.light.and_then(|l| self.lights[l as usize].as_area_light()) {
            Some(area) if wo.dot(point.ng) > 0.0 => match &area.texture {
                Some(texture) if cone.effects.has(Effect::Textures) => {
                    texture.radiance(&self.texture_context(hit, &point, wo, &cone.emission_texture_cone()))
                }
                Some(_) | None => area.radiance,
            },
            Some(_) | None => Rgb::ZERO,
        };
        let mut material_index = object.material;
        let mut material = &self.materials[material_index as usize];
        // Only a material that can have several BSDFs needs a random number.
        let is_chosen_by_chance = material.chooses_bsdf_randomly();
        let mut chance = if is_chosen_by_chance { u_mix() } else { 0.0 };
        let other_stores_photons = is_chosen_by_chance && material.may_store_photons();
        if material.mix_component_indices().is_some() {
            (material_index, chance) = self.resolve_mix_to_leaf(material_index, chance, cone.effects, &|| {
                self.texture_context(hit, &point, wo, cone)
            });
            material = &self.materials[material_index as usize];
        }
        let near_boundary = self.coincident.may_coincide(hit.primitive);
        let mut surface = SurfaceInteraction {
            point,
            wo,
            material,
            material_index,
            bsdf: material.mean_bsdf(),
            other_choice_stores_photons: other_stores_photons,
            boundary_roughness: material.mean_boundary_roughness(),
            coincidence_group: near_boundary.then(|| self.geometry.coincidence_group(hit.primitive)),
            coincident: CoincidentFaces::NONE,
            area_light_index: object.light,
            emission,
        };
        if material.needs_textures() {
            self.evaluate_surface_textures(&mut surface, hit, cone);
        }
        surface.bsdf = surface.bsdf.select_layer(wo, surface.point.ns, chance);
        surface
    }

    /// Geometric unit normal at `hit` of `ray`, which must have a unit direction.
    #[inline]
    #[must_use]
    pub fn geometric_normal_at(&self, ray: &Ray, hit: &Hit) -> Vec3 {
        self.geometry.surface_point(ray, hit).ng
    }

    /// Texture coordinates and object-space point at `hit`, with the filter footprint that `cone`
    /// has on the surface.
    #[inline(never)]
    #[must_use]
    pub fn texture_context(&self, hit: &Hit, point: &SurfacePoint, wo: Vec3, cone: &RayCone) -> TextureEvalContext {
        TextureFootprint::new(&self.geometry, &self.mappings, hit, point, wo, cone).context
    }

    /// The textures, to which material parameters refer by index.
    #[must_use]
    pub fn textures(&self) -> &[Arc<Texture>] {
        &self.textures
    }

    /// Evaluates the textured parameters of a surface, and perturbs its shading normal.
    #[inline(never)]
    fn evaluate_surface_textures(&self, surface: &mut SurfaceInteraction<'_>, hit: &Hit, cone: &RayCone) {
        let footprint = TextureFootprint::new(&self.geometry, &self.mappings, hit, &surface.point, surface.wo, cone);
        let material = surface.material;
        if material.is_textured() && cone.effects.has(Effect::Textures) {
            let lookups = TextureEvaluator { textures: &self.textures, context: footprint.context };
            surface.bsdf = material.bsdf(&lookups);
            surface.boundary_roughness = material.boundary_roughness(&lookups);
        }
        if cone.effects.has(Effect::Bump) {
            let width = f64::from(cone.width());
            surface.point.ns =
                perturbed_normal(material.normal_perturbation(), &self.textures, &surface.point, &footprint, width);
        }
    }

    /// Resolves a mix, or a mix of mixes, to one leaf material by the uniform number `u` in \[0,
    /// 1). Returns the leaf's material index, and a uniform number in \[0, 1) for further choices.
    /// A material that is not a mix is its own leaf.
    ///
    /// `context` returns the point at which a textured mix amount is looked up. It is called only
    /// if there is such a texture and `effects` include textures.
    fn resolve_mix_to_leaf(
        &self,
        mut index: u32,
        mut u: f32,
        effects: Effects,
        context: &dyn Fn() -> TextureEvalContext,
    ) -> (u32, f32) {
        while let Some(([first, second], amount)) = self.materials[index as usize].kind().as_mix() {
            let amount = match amount {
                MaterialParameter::Texture { .. } if effects.has(Effect::Textures) => {
                    TextureEvaluator { textures: &self.textures, context: context() }.evaluate_scalar(amount)
                }
                amount => amount.mean(),
            };
            // Rescale `u` within the chosen interval, so that a nested mix can use it.
            // Rounding must not raise it to 1.
            (index, u) = if u < amount {
                (second, u / amount)
            } else {
                (first, ((u - amount) / (1.0 - amount)).min(1f32.next_down()))
            };
        }
        (index, u)
    }
}
