//! Builds the [`Scene`] that the renderer uses from a [`SceneDescription`]: looks up names, reads
//! files and applies transforms.

mod camera;
mod lights;
mod materials;
mod media;
mod meshes;
mod placement;
mod shapes;
#[cfg(test)]
mod tests;
mod textures;

pub(super) use camera::resolve_camera;

use super::description::{
    DirectionOrTarget, EmissionDescription, GroupItem, ObjectDescription, ObjectGroup, SceneDescription,
    ShapeDescription, Span, Spanned, TransformStep,
};
use super::error::MAX_ERRORS;
use super::import::{EmbeddedAssets, is_unread_mesh_format, lowercase_extension};
use super::mesh::{MeshReadMonitor, TriangleMesh};
use super::{SceneError, SourceText};
use crate::color::Rgb;
use crate::math::{Motion, MotionStep, Transform};
use crate::medium::Medium;
use crate::scene::{Scene, SceneBuilder};
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec3};
use placement::{NormalizedMesh, ObjectEmission};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use textures::{ANY_TEXTURE_VALUE, AddedTexture, TextureRequirements};

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
    resolve_with_assets(description, source, folder, &EmbeddedAssets::default(), monitor, memory)
}

/// Returns the scene that a description describes, with embedded `assets` in place of files.
///
/// A path that is listed in `assets` is not looked up in the file system. [`resolve_monitored`]
/// explains other paths, `monitor` and `memory`.
///
/// # Errors
/// [`SceneError`] for an invalid scene, or [for lack of memory](SceneError::is_out_of_memory).
pub(super) fn resolve_with_assets(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    assets: &EmbeddedAssets,
    monitor: &dyn MeshReadMonitor,
    memory: MemoryLimit,
) -> Result<Scene, SceneError> {
    let camera = resolve_camera(description, source)?;
    let mut resolver = Resolver {
        source,
        folder,
        assets,
        errors: Vec::new(),
        description,
        builder: SceneBuilder::new(),
        material_indices: HashMap::new(),
        monitor,
        memory,
        triangles: 0,
        textures: HashMap::new(),
        pictures: HashMap::new(),
        media: HashMap::new(),
        texture_requirements: Vec::new(),
        meshes: HashMap::new(),
        file_materials: HashMap::new(),
        mesh_uses: count_mesh_uses(&description.root),
        shared_meshes: HashMap::new(),
        material: 0,
        transform_span: None,
    };
    let final_error = resolver.add_description().err();
    resolver.errors.extend(final_error);
    if let Some(error) = SceneError::from_errors(resolver.errors) {
        return Err(error);
    }
    resolver.builder.build(camera).map_err(|e| {
        SceneError::error_for_whole_file(
            source,
            e.to_string(),
            "choose units in which the scene is neither huge nor empty",
        )
    })
}

const SINGULAR_REMEDY: &str = "no scale may be zero, and no axis of a matrix may be a mix of the others";

const MEMORY_REMEDY: &str = "use a smaller file, or let the scene have more memory (--memory)";

/// State while a scene is built from its description: the scene so far, and tables of named items.
struct Resolver<'a> {
    source: &'a SourceText,
    folder: &'a Path,
    assets: &'a EmbeddedAssets,
    /// Errors of lights and objects so far. Building continues after an error, to report several at
    /// once.
    errors: Vec<SceneError>,
    description: &'a SceneDescription,
    builder: SceneBuilder,
    /// Indices of the materials added so far, by name.
    material_indices: HashMap<&'a str, u32>,
    /// Textures that the description defines, by name.
    textures: HashMap<&'a str, AddedTexture>,
    /// Picture textures that materials refer to by path. The key's flag is true for sRGB encoding.
    pictures: HashMap<(PathBuf, bool), AddedTexture>,
    /// Media of the description with their indices in the scene, by name.
    media: HashMap<&'a str, (u32, Medium)>,
    /// Surface properties that each material's textures need, by material index.
    texture_requirements: Vec<TextureRequirements>,
    monitor: &'a dyn MeshReadMonitor,
    memory: MemoryLimit,
    /// Number of mesh triangles so far for which BVHs are built. Triangles of a shared mesh count
    /// once.
    triangles: u64,
    /// Meshes that were read so far, each split by material. The key states file and options.
    meshes: HashMap<meshes::MeshKey, Rc<[meshes::MeshPart]>>,
    /// Materials from the MTL files of each mesh, by mesh file, in the order of its material names.
    file_materials: HashMap<PathBuf, Rc<[meshes::AddedMeshFileMaterial]>>,
    /// Number of objects that refer to each mesh file, by its path in the description.
    mesh_uses: HashMap<&'a str, usize>,
    /// Geometry that instances share. The key is the address of the mesh in `meshes`.
    shared_meshes: HashMap<*const TriangleMesh, Rc<NormalizedMesh>>,
    /// Index of the current material: that of the next object. It stays current after the end of a
    /// group.
    material: u32,
    /// Position in the scene text of the innermost transform around the current object, for errors;
    /// `None` without a transform.
    transform_span: Option<Span>,
}

impl Resolver<'_> {
    /// Adds everything in the description to the scene builder, except for the camera.
    fn add_description(&mut self) -> Result<(), SceneError> {
        let description = self.description;
        self.builder.set_background(rgb(description.background));
        self.add_textures()?;
        media::add_media(self)?;
        media::add_ambient_medium(self)?;
        materials::add_materials(self)?;
        for light in &description.lights {
            let result = lights::add_light(self, light, &Motion::default());
            self.record_error(result)?;
        }
        if !description.camera.motion.is_empty() {
            let steps = description.camera.motion.iter().map(TransformStep::motion_step);
            self.builder.set_camera_motion(Motion::default().preceded_by_steps(steps));
        }
        self.add_group(&description.root, &Motion::default())
    }

    /// Keeps the error of `result`, if any, and returns `Ok`, so that building can continue.
    ///
    /// Returns the error instead if memory is exhausted, or if `MAX_ERRORS` is reached.
    fn record_error(&mut self, result: Result<(), SceneError>) -> Result<(), SceneError> {
        match result {
            Err(error) if error.is_out_of_memory() || self.errors.len() + 1 >= MAX_ERRORS => Err(error),
            Err(error) => {
                self.errors.push(error);
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// Adds the objects of a group. `to_world` is the motion from the group's space to world space.
    fn add_group(&mut self, group: &ObjectGroup, to_world: &Motion) -> Result<(), SceneError> {
        for item in &group.items {
            match item {
                GroupItem::MaterialIndex(index) => self.material = index.value,
                GroupItem::MaterialName(name) => self.material = materials::material_index(self, name)?,
                GroupItem::Object(object) => {
                    let transform_span = self.transform_span;
                    let result = self.add_object(object, to_world);
                    self.transform_span = transform_span;
                    self.record_error(result)?;
                }
            }
        }
        Ok(())
    }

    /// Adds an object. `to_world` is the motion from its surrounding space to world space.
    ///
    /// Changes `transform_span` if the object is a transform. The caller restores it.
    fn add_object(&mut self, object: &Spanned<ObjectDescription>, to_world: &Motion) -> Result<(), SceneError> {
        match &object.value {
            ObjectDescription::Group(group) => self.add_group(group, to_world),
            ObjectDescription::Transform { steps, object: inner } => {
                self.transform_span = Some(object.span);
                let step = MotionStep::Fixed(TransformStep::composed_matrix(steps));
                self.add_object(inner, &to_world.preceded_by_steps([step]))
            }
            ObjectDescription::Moving { steps, object: inner } => {
                self.transform_span = Some(object.span);
                self.add_object(inner, &to_world.preceded_by_steps(steps.iter().map(TransformStep::motion_step)))
            }
            ObjectDescription::Shape { shape, emission } => {
                let emission = self.object_emission(*emission)?;
                self.require_finite_radiance(emission.radiance, object.span)?;
                media::refuse_null_interface_emission(self, emission.radiance, object.span)?;
                shapes::add_shape(self, shape, object.span, to_world, &emission)
            }
        }
    }

    /// Returns the emission of an object with the current material.
    ///
    /// `own` is the radiance set on the object; `None` selects the emission of the material.
    fn object_emission(&self, own: Option<DVec3>) -> Result<ObjectEmission, SceneError> {
        let material = self.description.materials.get(self.material as usize);
        let (radiance, texture) = match (own, material.and_then(|m| m.emission.as_ref())) {
            (Some(emission), _) => (rgb(emission), None),
            (None, Some(EmissionDescription::Radiance(emission))) => (rgb(*emission), None),
            (None, Some(EmissionDescription::Texture { name, scale })) => {
                let texture = self.texture_by_name(name, &ANY_TEXTURE_VALUE)?;
                let scale = Rgb::splat(*scale as f32);
                (texture.mean * scale, Some((texture.index, scale)))
            }
            (None, None) => (Rgb::ZERO, None),
        };
        Ok(ObjectEmission { radiance, is_of_object: own.is_some(), texture })
    }

    /// Fails with an error at `span` if single precision cannot hold `radiance`.
    fn require_finite_radiance(&self, radiance: Rgb, span: Span) -> Result<(), SceneError> {
        if radiance.is_finite() {
            return Ok(());
        }
        let help = "let it emit less, or choose other units";
        Err(self.error_at(span, "its radiance is above 3.4e38, which single precision holds", help))
    }

    fn error_at(&self, span: Span, message: &str, help: &str) -> SceneError {
        SceneError::error_at_span(self.source, span, message, "here", help)
    }

    /// Returns the matrix `to_world` with its inverse; an error if it is singular.
    ///
    /// The error points at the innermost transform, or at `span` if there is none.
    fn invertible_transform(&self, to_world: DAffine3, span: Span) -> Result<Transform, SceneError> {
        Transform::new(to_world).map_err(|e| {
            let culprit = self.transform_span.unwrap_or(span);
            SceneError::error_at_span(
                self.source,
                culprit,
                e.to_string(),
                "together with the transforms around it",
                SINGULAR_REMEDY,
            )
        })
    }

    /// Returns the path of the existing file that the description refers to as `path`.
    ///
    /// `kind` is the type of file for errors, such as "mesh". The path of an embedded asset is
    /// returned unchanged.
    fn find_file(&self, kind: &str, path: &Spanned<String>) -> Result<PathBuf, SceneError> {
        let written = Path::new(&path.value);
        if self.assets.contains(path) {
            return Ok(written.to_owned());
        }
        let extension = lowercase_extension(written);
        if kind == "mesh" && is_unread_mesh_format(&extension) {
            let message = format!("meshes of the format `.{extension}` are not read");
            return Err(self.file_error(path, &message, "convert it to OBJ or PLY, which are read"));
        }
        let found = candidate_file_paths(self.folder, written)
            .find(|p| p.is_file())
            .inspect(|file| self.monitor.on_input_file_found(file));
        found.ok_or_else(|| {
            let places: Vec<String> =
                candidate_file_paths(self.folder, written).map(|p| format!("`{}`", p.display())).collect();
            let message = format!("the {kind} `{}` does not exist", path.value);
            self.file_error(path, &message, &format!("put the file at {}", places.join(" or ")))
        })
    }

    /// Returns an error with `message`, at the place in the scene text where `path` stands.
    ///
    /// `help` is the remedy. If the file exceeds the memory limit (`is_too_large`), the error is
    /// marked as out of memory and has another remedy.
    fn file_or_memory_error(
        &self,
        path: &Spanned<String>,
        message: &impl ToString,
        is_too_large: bool,
        help: &str,
    ) -> SceneError {
        if is_too_large {
            self.file_error(path, message, MEMORY_REMEDY).marked_out_of_memory()
        } else {
            self.file_error(path, message, help)
        }
    }

    /// Returns an error with `message` and the remedy `help`, at the place in the text where `path`
    /// stands.
    fn file_error(&self, path: &Spanned<String>, message: &impl ToString, help: &str) -> SceneError {
        SceneError::error_at_span(self.source, path.span, message.to_string(), "named here", help)
    }
}

/// Returns the paths at which the file `path` of a scene is looked up.
///
/// An absolute path is the only candidate. A relative one is looked up in the scene's `folder`,
/// then in its parent folder.
pub(super) fn candidate_file_paths<'a>(folder: &'a Path, path: &'a Path) -> impl Iterator<Item = PathBuf> {
    let above = if folder.as_os_str().is_empty() { Path::new("..").to_owned() } else { folder.join("..") };
    [folder.join(path), above.join(path)].into_iter().take(if path.is_absolute() { 1 } else { 2 })
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
            ObjectDescription::Shape { shape: ShapeDescription::Mesh { path, .. }, .. } => {
                *uses.entry(path).or_insert(0) += 1
            }
            ObjectDescription::Shape { .. } => {}
        }
    }
    let mut uses = HashMap::new();
    count_mesh_uses_in_group(group, &mut uses);
    uses
}

/// Returns the given direction, or the vector from the point `from` to the target; of any length.
fn aim_direction(aim: DirectionOrTarget, from: DVec3) -> DVec3 {
    match aim {
        DirectionOrTarget::Direction(direction) => direction,
        DirectionOrTarget::LookAt(point) => point - from,
    }
}

fn rgb(color: DVec3) -> Rgb {
    color.as_vec3()
}
