//! Builds the [`Scene`] that the renderer uses from a [`SceneDescription`]: each part of the
//! description adds itself to the scene.

#[cfg(test)]
mod tests;

use super::assets::EmbeddedAssets;
use super::camera::resolve_camera;
use super::description::{GroupItem, ObjectDescription, ObjectGroup, SceneDescription};
use super::error::{SceneError, SourceText};
use super::lights::add_light;
use super::materials::{add_materials, material_index};
use super::media::{add_media, set_ambient_medium};
use super::mesh::MeshReadMonitor;
use super::resolve::placement::ObjectEmission;
use super::resolve::scene_meshes::SceneMeshes;
use super::resolve::{MaterialParts, Resolver, rgb};
use super::shapes::{ShapeDescription, add_shape};
use super::span::{Span, Spanned};
use super::textures::add_textures;
use super::transform_step::TransformStep;
use crate::color::Rgb;
use crate::math::{Motion, MotionFactor};
use crate::scene::{Scene, SceneBuilder};
use crate::stats::MemoryLimit;
use glam::DVec3;
use std::collections::HashMap;
use std::path::Path;

/// Returns the scene that a description describes, ready to render.
///
/// Meshes, pictures and grids are looked up in `folder`, then in its parent folder.
///
/// # Errors
/// [`SceneError`] with a position in `source`. Examples: a missing file, an unknown glass, a
/// singular transform, an object that cannot emit.
pub fn resolve(description: &SceneDescription, source: &SourceText, folder: &Path) -> Result<Scene, SceneError> {
    resolve_monitored(description, source, folder, &(), MemoryLimit::Unbounded)
}

/// Returns the scene that a description describes, built within the memory limit `memory`.
///
/// Looks up files in the same folders as [`resolve`]. `monitor` receives the progress of reading
/// meshes. A file that would exceed the memory limit is refused before it is read.
///
/// # Errors
/// [`SceneError`] for an invalid scene, or [for lack of memory](SceneError::is_out_of_memory).
pub fn resolve_monitored(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    monitor: &dyn MeshReadMonitor,
    memory: MemoryLimit,
) -> Result<Scene, SceneError> {
    let assets = EmbeddedAssets::default();
    Ok(resolve_with_assets(description, source, folder, &assets, None, monitor, memory)?.scene)
}

/// A scene that is ready to render, with the meshes that were read for it.
///
/// When the scene file is edited, the next version of the scene can reuse the meshes.
#[derive(Clone, Debug)]
pub struct ResolvedScene {
    /// The scene, ready to render.
    pub scene: Scene,
    /// Meshes of the scene as they were read.
    pub meshes: SceneMeshes,
}

/// Returns the scene that a description describes, with embedded `assets` in place of files.
///
/// A path that is listed in `assets` is not looked up in the file system. The scene reuses
/// unchanged meshes and BVHs of `earlier`, its previous version; the result has the same bits as
/// without reuse. [`resolve_monitored`] explains other paths, `monitor` and `memory`.
///
/// # Errors
/// [`SceneError`] for an invalid scene, or [for lack of memory](SceneError::is_out_of_memory).
pub(super) fn resolve_with_assets(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    assets: &EmbeddedAssets,
    earlier: Option<&ResolvedScene>,
    monitor: &dyn MeshReadMonitor,
    memory: MemoryLimit,
) -> Result<ResolvedScene, SceneError> {
    let camera = resolve_camera(&description.camera, source)?;
    let mut resolver = Resolver {
        source,
        folder,
        assets,
        earlier_meshes: earlier.map(|earlier| &earlier.meshes),
        errors: Vec::new(),
        builder: SceneBuilder::new(),
        material_indices: HashMap::new(),
        monitor,
        memory,
        bvh_triangle_count: 0,
        textures: HashMap::new(),
        picture_textures: HashMap::new(),
        media: HashMap::new(),
        materials: Vec::new(),
        material_parts: MaterialParts::default(),
        mesh_parts: HashMap::new(),
        mesh_file_materials: HashMap::new(),
        mesh_use_counts: count_mesh_uses(&description.root),
        scene_meshes: SceneMeshes::default(),
        current_material_index: 0,
        transform_span: None,
    };
    let final_error = add_description(&mut resolver, description).err();
    resolver.errors.extend(final_error);
    if let Some(error) = SceneError::from_errors(resolver.errors) {
        return Err(error);
    }
    let scene =
        resolver.builder.build_reusing_hierarchy(earlier.map(|earlier| &earlier.scene), camera).map_err(|e| {
            SceneError::error_for_whole_file(
                source,
                e.to_string(),
                "choose units in which the scene is neither huge nor empty",
            )
        })?;
    Ok(ResolvedScene { scene, meshes: resolver.scene_meshes })
}

/// Adds everything in the description to the scene builder, except for the camera.
fn add_description<'a>(r: &mut Resolver<'a>, description: &'a SceneDescription) -> Result<(), SceneError> {
    r.builder.set_background(rgb(description.background));
    add_textures(r, &description.textures)?;
    add_media(r, &description.media)?;
    set_ambient_medium(r, description.ambient_medium.as_ref(), &description.lights)?;
    add_materials(r, &description.materials)?;
    for light in &description.lights {
        let result = add_light(r, light, &Motion::default());
        r.record_error(result)?;
    }
    if !description.camera.motion.is_empty() {
        let steps = description.camera.motion.iter().map(TransformStep::motion_factor);
        r.builder.set_camera_motion(Motion::default().preceded_by_factors(steps));
    }
    add_group(r, &description.root, &Motion::default())
}

/// Adds the objects of a group. `to_world` is the motion from the group's space to world space.
fn add_group(r: &mut Resolver<'_>, group: &ObjectGroup, to_world: &Motion) -> Result<(), SceneError> {
    for item in &group.items {
        match item {
            GroupItem::MaterialIndex(index) => r.current_material_index = index.value,
            GroupItem::MaterialName(name) => r.current_material_index = material_index(r, name)?,
            GroupItem::Object(object) => {
                let transform_span = r.transform_span;
                let result = add_object(r, object, to_world);
                r.transform_span = transform_span;
                r.record_error(result)?;
            }
        }
    }
    Ok(())
}

/// Adds an object. `to_world` is the motion from the space that surrounds the object to world
/// space.
///
/// Changes `transform_span` if the object is a transform. The caller restores it.
fn add_object(r: &mut Resolver<'_>, object: &Spanned<ObjectDescription>, to_world: &Motion) -> Result<(), SceneError> {
    match &object.value {
        ObjectDescription::Group(group) => add_group(r, group, to_world),
        ObjectDescription::Transform { steps, object: inner } => {
            r.transform_span = Some(object.span);
            let step = MotionFactor::Fixed(TransformStep::composed_matrix(steps));
            add_object(r, inner, &to_world.preceded_by_factors([step]))
        }
        ObjectDescription::Moving { steps, object: inner } => {
            r.transform_span = Some(object.span);
            add_object(r, inner, &to_world.preceded_by_factors(steps.iter().map(TransformStep::motion_factor)))
        }
        ObjectDescription::Shape { shape, emission } => {
            let emission = object_emission(r, *emission);
            r.require_finite_radiance(emission.radiance, object.span)?;
            refuse_null_interface_emission(r, emission.radiance, object.span)?;
            add_shape(r, shape, object.span, to_world, &emission)
        }
    }
}

/// Returns the emission of the next object, whose material is at `r.current_material_index`.
///
/// `own` is the radiance set on the object; `None` selects the emission of the material.
fn object_emission(r: &Resolver<'_>, own: Option<DVec3>) -> ObjectEmission {
    match own {
        Some(emission) => ObjectEmission { radiance: rgb(emission), is_set_on_object: true, texture: None },
        None => {
            let emission = r.current_material().map(|material| material.emission).unwrap_or_default();
            ObjectEmission { radiance: emission.radiance, is_set_on_object: false, texture: emission.texture }
        }
    }
}

/// Fails if `radiance` is above 0 and the material at `r.current_material_index` is a null
/// interface, which cannot emit.
fn refuse_null_interface_emission(r: &Resolver<'_>, radiance: Rgb, span: Span) -> Result<(), SceneError> {
    if radiance == Rgb::ZERO || !r.current_material().is_some_and(|material| material.is_null_interface) {
        return Ok(());
    }
    let help = "give `emission` to its medium, or the object another material";
    Err(r.error_at(span, "what is `Clear` has no surface that could emit light", help))
}

/// Returns, for each mesh path in the description, the number of objects with that mesh.
fn count_mesh_uses(group: &ObjectGroup) -> HashMap<&str, usize> {
    fn count_mesh_uses_in_group<'a>(group: &'a ObjectGroup, uses: &mut HashMap<&'a str, usize>) {
        for item in &group.items {
            if let GroupItem::Object(object) = item {
                count_mesh_uses_in_object(object, uses);
            }
        }
    }
    fn count_mesh_uses_in_object<'a>(object: &'a ObjectDescription, uses: &mut HashMap<&'a str, usize>) {
        match object {
            ObjectDescription::Group(group) => count_mesh_uses_in_group(group, uses),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                count_mesh_uses_in_object(object, uses)
            }
            ObjectDescription::Shape { shape: ShapeDescription::Mesh(mesh), .. } => {
                *uses.entry(&mesh.path).or_insert(0) += 1
            }
            ObjectDescription::Shape { .. } => {}
        }
    }
    let mut uses = HashMap::new();
    count_mesh_uses_in_group(group, &mut uses);
    uses
}
