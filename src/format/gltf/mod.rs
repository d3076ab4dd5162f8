//! Imports scenes in glTF 2.0: `.gltf` with its files, and `.glb`.

mod accessors;
mod context;
mod document;
mod geometry;
mod materials;
mod scene;
#[cfg(test)]
mod tests;
mod textures;

use super::assets::EmbeddedAssets;
use super::default_camera::framing_camera;
use super::description::{EnvironmentRadiance, LightDescription, SceneDescription, Span, Spanned};
use super::import::{ImportOptions, ImportedScene, SceneImporter, SceneReadError};
use super::import_notes::ImportNotes;
use super::mesh::MeshReadMonitor;
use accessors::GltfBuffers;
use context::FileContext;
use document::{GltfFile, parse_document};
use glam::DVec3;
use materials::GltfMaterials;
use scene::read_scene;
use std::path::Path;
use textures::GltfTextures;

/// Importer of glTF 2.0 scenes.
pub(super) struct GltfImporter;

impl SceneImporter for GltfImporter {
    fn name(&self) -> &'static str {
        "glTF 2.0"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["gltf", "glb"]
    }

    fn import(
        &self,
        path: &Path,
        monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<ImportedScene, SceneReadError> {
        let context = FileContext { path, monitor, options };
        let bytes = context.read_file(path)?;
        import_bytes(&context, &bytes)
    }
}

/// Imports the bytes of a `.gltf` or `.glb` file.
///
/// Errors name `path`. Files that the scene names are looked up in the folder of `path`.
///
/// # Errors
/// [`SceneReadError`] at the first defect, or at content that cannot be imported.
pub fn decode(path: &Path, bytes: &[u8], options: &ImportOptions) -> Result<ImportedScene, SceneReadError> {
    import_bytes(&FileContext { path, monitor: &(), options }, bytes)
}

fn import_bytes(context: &FileContext<'_>, bytes: &[u8]) -> Result<ImportedScene, SceneReadError> {
    let mut notes = ImportNotes::default();
    let GltfFile { document, blob } = parse_document(context, bytes, &mut notes)?;
    let buffers = GltfBuffers::new(context, document.buffers().len(), blob);
    let mut materials = GltfMaterials::new(GltfTextures::new(context, &document, &buffers));
    let content = read_scene(context, &buffers, &document, &mut materials, &mut notes)?;
    let mut lights = content.lights;
    if lights.is_empty() && !content.has_emissive_surfaces {
        notes.add_missing("the file has no light: a white sky of radiance 1 lights the scene");
        let sky = LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE));
        lights.push(Spanned::new(sky, Span::default()));
    }
    let camera = content.camera.unwrap_or_else(|| {
        notes.add_missing("the file has no camera: the picture shows the whole scene from above and in front");
        framing_camera(content.world_bounds)
    });
    materials.remove_unused(&content.root);
    let GltfMaterials { textures: GltfTextures { textures, pictures, .. }, list, .. } = materials;
    let description = SceneDescription {
        camera: Spanned::new(camera, Span::default()),
        background: DVec3::ZERO,
        ambient_medium: None,
        lights,
        textures,
        media: Vec::new(),
        materials: list.descriptions,
        root: content.root,
    };
    let assets = EmbeddedAssets { meshes: content.meshes, pictures, ..EmbeddedAssets::default() };
    Ok(ImportedScene { description, source: context.source(), assets, notes: notes.into_notes() })
}
