//! Building a resolved scene from objects in world coordinates.

mod cull_air_boundaries;
mod derived;
mod light_contact_distance;
mod lights;
mod lights_across_boundaries;
mod media;
mod object;
mod place;
mod recenter;
mod validate;

pub(super) use derived::{DerivedSceneData, derive_scene_data};
pub(super) use lights::mean_emission_lights;

use super::interiors::{CoincidentFlags, flag_coincident_primitives};
use super::{BuildError, LightStrength, Material, Scene, UnscaledDeltaLight};
use crate::camera::Camera;
use crate::color::{DispersionFormula, Rgb};
use crate::light::EnvironmentLight;
use crate::math::Motion;
use crate::medium::Medium;
use crate::shape::{Plane, Shape, TextureMappingKind, TriangleIndices};
use crate::texture::Texture;
use cull_air_boundaries::{cull_air_boundaries, may_bound_body};
use glam::{DVec2, DVec3, Vec3};
use lights::{CollectedLights, DeltaLight, collect_lights};
use media::place_media;
use object::{MergedMeshes, ObjectGeometry, SceneObject};
use place::{PlacedObjects, place_camera, sort_and_place_objects};
use recenter::choose_scene_origin;
use std::sync::Arc;
use validate::{validate_coordinate_range, validate_light_power, validate_objects};

/// Builder of a [`Scene`] from parts in world coordinates.
#[derive(Debug, Default)]
pub struct SceneBuilder {
    background: Rgb,
    environment: Option<EnvironmentLight>,
    materials: Vec<Material>,
    dispersion_formulas: Vec<DispersionFormula>,
    media: Vec<Medium>,
    ambient_medium: Option<u32>,
    textures: Vec<Arc<Texture>>,
    objects: Vec<SceneObject>,
    /// The triangles of all mesh objects. Instances of a mesh are not included: each instance is a
    /// shape.
    mesh: MergedMeshes,
    delta_lights: Vec<DeltaLight>,
    camera_motion: Option<Motion>,
}

impl SceneBuilder {
    /// An empty builder.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the radiance \[W/(m² sr)] of camera rays that hit nothing. The background does not
    /// light surfaces.
    pub fn set_background(&mut self, color: Rgb) -> &mut Self {
        self.background = color;
        self
    }

    /// Sets the environment light. It replaces an environment light that was set before. Camera
    /// rays that hit nothing see it instead of the background.
    pub fn set_environment(&mut self, environment: EnvironmentLight) -> &mut Self {
        self.environment = Some(environment);
        self
    }

    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// Adds a dispersion formula (refractive index by wavelength) for dielectric bodies, and
    /// returns its index: see [`Body::dispersion_formula`](super::Body::dispersion_formula).
    pub fn add_dispersion_formula(&mut self, formula: DispersionFormula) -> u32 {
        self.dispersion_formulas.push(formula);
        self.dispersion_formulas.len() as u32 - 1
    }

    /// Adds a medium and returns its index.
    pub fn add_medium(&mut self, medium: Medium) -> u32 {
        self.media.push(medium);
        self.media.len() as u32 - 1
    }

    /// Fills the space outside of all dielectric bodies with medium `medium`: see
    /// [`Scene::ambient_medium`].
    pub fn set_ambient_medium(&mut self, medium: u32) -> &mut Self {
        self.ambient_medium = Some(medium);
        self
    }

    /// Adds a texture and returns its index.
    pub fn add_texture(&mut self, texture: Texture) -> u32 {
        self.textures.push(Arc::new(texture));
        self.textures.len() as u32 - 1
    }

    /// Adds a shape. An `emission` above zero \[W/(m² sr)] makes it an area light.
    pub fn add_shape(&mut self, shape: Shape, material: u32, emission: Rgb) -> &mut Self {
        self.add_object(ObjectGeometry::Shape(shape), None, material, emission)
    }

    /// Adds an unbounded plane. `emission` must be zero, else [`SceneBuilder::build`] fails.
    pub fn add_plane(&mut self, plane: Plane, material: u32, emission: Rgb) -> &mut Self {
        self.add_object(ObjectGeometry::Plane(plane), None, material, emission)
    }

    /// Adds a triangle mesh. `normals` are unit vectors, one per vertex, or empty. `triangles`
    /// index the vertices.
    ///
    /// Triangles without area are dropped, because no ray hits them.
    pub fn add_mesh(
        &mut self,
        positions: &[DVec3],
        normals: &[Vec3],
        triangles: &[TriangleIndices],
        material: u32,
        emission: Rgb,
    ) -> &mut Self {
        let range = self.mesh.add_mesh(positions, normals, triangles);
        self.add_object(ObjectGeometry::Mesh(range), None, material, emission)
    }

    /// Adds a shape that moves while the shutter is open.
    pub fn add_moving_shape(&mut self, shape: Shape, motion: Motion, material: u32, emission: Rgb) -> &mut Self {
        self.add_object(ObjectGeometry::Shape(shape), Some(motion), material, emission)
    }

    /// Adds an unbounded plane that moves while the shutter is open.
    pub fn add_moving_plane(&mut self, plane: Plane, motion: Motion, material: u32, emission: Rgb) -> &mut Self {
        self.add_object(ObjectGeometry::Plane(plane), Some(motion), material, emission)
    }

    fn add_object(
        &mut self,
        geometry: ObjectGeometry,
        motion: Option<Motion>,
        material: u32,
        emission: Rgb,
    ) -> &mut Self {
        self.objects.push(SceneObject { geometry, motion, material, emission, emission_texture: None, mapping: None });
        self
    }

    /// Sets the texture mapping of the object added last; `to_world` maps the object space of the
    /// mapping to the world.
    ///
    /// Without this call, the object has its own texture coordinates (see [`Shape::tex_coord`]),
    /// and solid textures are evaluated in world space. Spheres, ellipsoids and planes have no
    /// texture coordinates of their own.
    pub fn set_last_texture_mapping(&mut self, kind: TextureMappingKind, to_world: &Motion) -> &mut Self {
        if let Some(object) = self.objects.last_mut() {
            object.mapping = Some((kind, to_world.clone()));
        }
        self
    }

    /// Sets the radiance emitted by the object added last to `texture` times `scale` \[W/(m² sr)].
    ///
    /// The mean of this product must equal the emission with which the object was added.
    pub fn set_last_emission_texture(&mut self, texture: u32, scale: Rgb) -> &mut Self {
        if let Some(object) = self.objects.last_mut() {
            object.emission_texture = Some((texture, scale));
        }
        self
    }

    /// Sets the texture coordinates of the mesh added last, one per vertex.
    pub fn set_last_mesh_texcoords(&mut self, texcoords: &[DVec2]) -> &mut Self {
        self.mesh.add_texcoords(texcoords);
        self
    }

    /// Adds a light that emits from one point or from one direction.
    pub fn add_delta_light(&mut self, kind: UnscaledDeltaLight, strength: LightStrength) -> &mut Self {
        self.delta_lights.push(DeltaLight { kind, strength, motion: None });
        self
    }

    /// Adds a delta light that moves while the shutter is open. The motion rotates and scales about
    /// the light's position.
    pub fn add_moving_delta_light(
        &mut self,
        kind: UnscaledDeltaLight,
        strength: LightStrength,
        motion: &Motion,
    ) -> &mut Self {
        let motion = kind.position().map_or_else(|| motion.clone(), |position| motion.pivoted_at_point(position));
        self.delta_lights.push(DeltaLight { kind, strength, motion: Some(motion) });
        self
    }

    /// Moves the camera while the shutter is open. The motion rotates and scales about the camera's
    /// position.
    pub fn set_camera_motion(&mut self, motion: Motion) -> &mut Self {
        self.camera_motion = Some(motion);
        self
    }

    /// Builds the scene: checks its parts, chooses the origin and builds bounding volume
    /// hierarchies.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if the parts cannot be rendered.
    pub fn build(self, camera: Camera) -> Result<Scene, BuildError> {
        self.build_reusing_hierarchy(None, camera)
    }

    /// Builds the scene as [`SceneBuilder::build`] does. If the scene `earlier` was built from the
    /// same geometry, both scenes share its bounding volume hierarchy. The result is equal bit for
    /// bit to that of `build`.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if the parts cannot be rendered.
    pub fn build_reusing_hierarchy(mut self, earlier: Option<&Scene>, camera: Camera) -> Result<Scene, BuildError> {
        set_photon_storage_of_mixes(&mut self.materials)?;
        validate_objects(&self.objects, &self.mesh)?;
        let (objects, mesh) =
            cull_air_boundaries(self.objects, self.mesh, &self.materials, self.ambient_medium.is_some());
        let origin = choose_scene_origin(&objects, &mesh, &camera)?;
        let PlacedObjects { objects, geometry, mappings, mut animation } =
            sort_and_place_objects(objects, mesh, origin)?;
        validate_coordinate_range(&geometry, &animation)?;
        let CollectedLights {
            lights,
            environment_light_index,
            mit_6837_lights,
            moving_delta_lights: moving,
            area_light_of_object: of_object,
        } = collect_lights(
            &self.delta_lights,
            &objects,
            &geometry,
            &mappings,
            &self.textures,
            self.environment,
            origin,
        )?;
        animation.lights = moving;
        let camera = place_camera(&camera, self.camera_motion, origin, &mut animation)?;
        let media = place_media(&self.media, &objects, &self.materials, origin, &mut animation);
        let geometry =
            geometry.build_hierarchies(&objects, &mappings, &of_object, earlier.map(|scene| &scene.geometry));
        let mut scene = Scene {
            camera,
            background: self.background,
            geometry,
            materials: self.materials,
            dispersion_formulas: self.dispersion_formulas,
            media,
            ambient_medium: self.ambient_medium,
            shadow_rays_cross_surfaces: false,
            textures: self.textures,
            mappings: mappings.texture_mappings,
            mean_emission_lights: mean_emission_lights(&lights),
            lights,
            environment_light_index,
            mit_6837_lights,
            animation: (!animation.is_empty()).then(|| Arc::new(animation)),
            origin,
            coincident: CoincidentFlags::default(),
            derived: DerivedSceneData::default(),
        };
        scene.coincident =
            flag_coincident_primitives(&scene.geometry, |material| may_bound_body(&scene.materials, material));
        let mut crosses = false;
        for object in scene.geometry.objects.iter() {
            scene.for_each_leaf_material(object.material, &mut |leaf| crosses |= leaf.is_crossed_by_shadow_rays());
        }
        scene.shadow_rays_cross_surfaces = crosses;
        scene.derived = derive_scene_data(&scene);
        validate_light_power(&scene)?;
        Ok(scene)
    }
}

/// Sets the flag `may_store_photons` of each mix in `materials`: true if a component may store
/// photons.
///
/// A mix may precede its components in the list. The function therefore passes over all mixes again
/// and again, until the flags of all mixes are known.
///
/// # Errors
///
/// [`BuildError::InvalidMix`] for a mix that contains itself or a material that does not exist.
fn set_photon_storage_of_mixes(materials: &mut [Material]) -> Result<(), BuildError> {
    let mut is_done: Vec<bool> = materials.iter().map(|m| m.mix_component_indices().is_none()).collect();
    loop {
        let mut has_changed = false;
        for i in 0..materials.len() {
            let Some(parts) = materials[i].mix_component_indices().filter(|_| !is_done[i]) else { continue };
            if parts.into_iter().all(|part| is_done.get(part as usize).is_some_and(|done| *done)) {
                materials[i] = materials[i].with_mix_photon_storage(materials);
                (is_done[i], has_changed) = (true, true);
            }
        }
        if !has_changed {
            return is_done.iter().position(|done| !done).map_or(Ok(()), |i| Err(BuildError::InvalidMix(i)));
        }
    }
}

#[cfg(test)]
mod tests;
