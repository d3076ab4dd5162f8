//! State and helpers for building a [`Scene`](crate::scene::Scene) from its description: lookups of
//! names and files, errors, and placement of shapes.
//!
//! The files of this folder know no kinds of lights, materials or shapes. Each kind adds itself to
//! the [`Resolver`].

pub(super) mod meshes;
pub(super) mod placement;
pub(super) mod scene_meshes;
pub(super) mod textures;

use super::assets::EmbeddedAssets;
use super::error::{MAX_REPORTED_ERRORS, SceneError, SourceText};
use super::file_extensions::{is_unsupported_mesh_format, lowercase_extension};
use super::mesh::MeshReadMonitor;
use super::span::{Span, Spanned};
use crate::color::Rgb;
use crate::math::Transform;
use crate::medium::Medium;
use crate::scene::{Material, MaterialParameter, SceneBuilder};
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec3};
use scene_meshes::{MeshKey, SceneMeshes};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use textures::{AddedTexture, TextureRequirements};

pub(super) const SINGULAR_REMEDY: &str = "no scale may be zero, and no axis of a matrix may be a mix of the others";

pub(super) const MEMORY_REMEDY: &str = "use a smaller file, or let the scene have more memory (--memory)";

/// Components of materials such as `Principled`, for example metal, glass and coated base. The
/// scene description lists only the `Principled` material.
///
/// The components are added to the scene after all materials of the description.
#[derive(Debug, Default)]
pub(super) struct MaterialParts {
    pub list: Vec<Material>,
    /// Material index that the first component of `list` will have in the scene.
    pub first_index: u32,
}

impl MaterialParts {
    /// Returns a mix that selects `second` with the probability `amount`, and `first` otherwise.
    /// Adds both materials to the list.
    ///
    /// If `amount` is constant 0 or 1, returns `first` or `second` and adds nothing.
    pub fn mix(&mut self, first: Material, second: Material, amount: MaterialParameter<f32>) -> Material {
        match amount {
            MaterialParameter::Constant(0.0) => first,
            MaterialParameter::Constant(1.0) => second,
            MaterialParameter::Constant(_) | MaterialParameter::Texture { .. } => {
                let first_index = self.first_index + self.list.len() as u32;
                self.list.extend([first, second]);
                Material::mix(first_index, first_index + 1, amount)
            }
        }
    }
}

/// State while a scene is built from its description: the scene so far, and tables of named items.
pub(super) struct Resolver<'a> {
    pub source: &'a SourceText,
    pub folder: &'a Path,
    pub assets: &'a EmbeddedAssets,
    /// Meshes of the previous version of the scene, which are reused if their files have not
    /// changed. `None` if there is no previous version.
    pub earlier_meshes: Option<&'a SceneMeshes>,
    /// Errors of lights and objects so far. Building continues after an error, to report several at
    /// once.
    pub errors: Vec<SceneError>,
    pub builder: SceneBuilder,
    /// Indices of the materials added so far, by name.
    pub material_indices: HashMap<&'a str, u32>,
    /// Textures that the description defines, by name.
    pub textures: HashMap<&'a str, AddedTexture>,
    /// Picture textures that materials refer to by path. The key's flag is true for sRGB encoding.
    pub picture_textures: HashMap<(PathBuf, bool), AddedTexture>,
    /// Media of the description with their indices in the scene, by name.
    pub media: HashMap<&'a str, (u32, Medium)>,
    /// Properties of the materials that were added so far, by material index, for the objects that
    /// have them. A material whose index is beyond the end of the list has the default properties.
    pub materials: Vec<AddedMaterial>,
    /// Component materials of composed materials such as `Principled`, not yet added to the scene.
    pub material_parts: MaterialParts,
    pub monitor: &'a dyn MeshReadMonitor,
    pub memory: MemoryLimit,
    /// Number of mesh triangles so far for which BVHs are built. Triangles of a shared mesh count
    /// once.
    pub bvh_triangle_count: u64,
    /// Meshes that were read so far, each split by material. The key states file and options.
    pub mesh_parts: HashMap<MeshKey, Rc<[meshes::MeshPart]>>,
    /// The meshes of `mesh_parts` without their materials in this scene. When the scene is edited
    /// and built again, the next version can reuse these meshes.
    pub scene_meshes: SceneMeshes,
    /// Materials from the MTL files of each mesh file, in the order of the mesh's material names.
    pub mesh_file_materials: HashMap<PathBuf, Rc<[meshes::AddedMeshFileMaterial]>>,
    /// Number of objects in the description that use each mesh file, by the path that the
    /// description states.
    pub mesh_use_counts: HashMap<&'a str, usize>,
    /// Index of the material of the next object. The end of a group does not reset it.
    pub current_material_index: u32,
    /// Position in the scene text of the innermost transform around the current object, for errors;
    /// `None` without a transform.
    pub transform_span: Option<Span>,
}

/// Properties of a material that was added to the scene, for the objects that have it.
#[derive(Clone, Default)]
pub(super) struct AddedMaterial {
    /// Name in the scene text; `None` for a material without a name, and for materials of mesh
    /// files.
    pub name: Option<String>,
    /// Emission of the objects with this material for which the scene text sets no emission of
    /// their own.
    pub emission: MaterialEmission,
    /// True if the material is a null interface, which bounds a medium and does not affect light.
    pub is_null_interface: bool,
    /// Properties that the material's textures need of a surface, such as texture coordinates.
    pub texture_requirements: TextureRequirements,
}

/// Radiance that a material emits: constant, or varied by a texture.
#[derive(Clone, Copy, Default)]
pub(super) struct MaterialEmission {
    /// Radiance in W/(m² sr); the mean radiance if a texture varies it.
    pub radiance: Rgb,
    /// Index of the texture that varies the emission, and the factor from texture values to
    /// radiance \[W/(m² sr)]; `None` for constant emission.
    pub texture: Option<(u32, Rgb)>,
}

impl Resolver<'_> {
    /// Returns the properties of the material at `current_material_index`, which the next object
    /// gets; `None` if all are the defaults.
    pub fn current_material(&self) -> Option<&AddedMaterial> {
        self.materials.get(self.current_material_index as usize)
    }

    /// Adds the error of `result`, if any, to `errors` and returns `Ok`, so that building can
    /// continue.
    ///
    /// Returns the error instead if the error is lack of memory, or if `MAX_REPORTED_ERRORS` is
    /// reached.
    pub fn record_error(&mut self, result: Result<(), SceneError>) -> Result<(), SceneError> {
        match result {
            Err(error) if error.is_out_of_memory() || self.errors.len() + 1 >= MAX_REPORTED_ERRORS => Err(error),
            Err(error) => {
                self.errors.push(error);
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// Fails with an error at `span` if single precision cannot hold `radiance`.
    pub fn require_finite_radiance(&self, radiance: Rgb, span: Span) -> Result<(), SceneError> {
        if radiance.is_finite() {
            return Ok(());
        }
        let help = "let it emit less, or choose other units";
        Err(self.error_at(span, "its radiance is above 3.4e38, which single precision holds", help))
    }

    pub fn error_at(&self, span: Span, message: &str, help: &str) -> SceneError {
        SceneError::error_at_span(self.source, span, message, "here", help)
    }

    /// Returns the matrix `to_world` with its inverse. Fails if the matrix is singular.
    ///
    /// The error points at the innermost transform around the object, or at `span` if there is
    /// none.
    pub fn invertible_transform(&self, to_world: DAffine3, span: Span) -> Result<Transform, SceneError> {
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
    pub fn find_file(&self, kind: &str, path: &Spanned<String>) -> Result<PathBuf, SceneError> {
        let written = Path::new(&path.value);
        if self.assets.contains(path) {
            return Ok(written.to_owned());
        }
        let extension = lowercase_extension(written);
        if kind == "mesh" && is_unsupported_mesh_format(&extension) {
            let message = format!("meshes of the format `.{extension}` are not read");
            return Err(self.file_error(path, &message, "convert it to OBJ or PLY, which are read"));
        }
        let found = candidate_file_paths(self.folder, written)
            .find(|p| p.is_file())
            .inspect(|file| self.monitor.on_input_file_found(file));
        found.ok_or_else(|| {
            if let Some(other) = candidate_file_paths(self.folder, written).find(|p| p.exists()) {
                let file_type = if other.is_dir() { "a folder" } else { "a pipe or a device" };
                let message = format!("the {kind} `{}` is {file_type}", path.value);
                return self.file_error(path, &message, "name a regular file");
            }
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
    pub fn file_or_memory_error(
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
    pub fn file_error(&self, path: &Spanned<String>, message: &impl ToString, help: &str) -> SceneError {
        SceneError::error_at_span(self.source, path.span, message.to_string(), "named here", help)
    }
}

/// Returns the paths at which the file `path` of a scene is looked up.
///
/// An absolute path is the only candidate. A relative path is looked up in the scene's `folder`,
/// then in the parent of `folder`.
pub(super) fn candidate_file_paths<'a>(folder: &'a Path, path: &'a Path) -> impl Iterator<Item = PathBuf> {
    let above = if folder.as_os_str().is_empty() { Path::new("..").to_owned() } else { folder.join("..") };
    [folder.join(path), above.join(path)].into_iter().take(if path.is_absolute() { 1 } else { 2 })
}

/// Converts a color to single precision.
pub(super) fn rgb(color: DVec3) -> Rgb {
    color.as_vec3()
}
