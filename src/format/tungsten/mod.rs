//! Imports scenes of the renderer Tungsten: JSON, with `.wo3` meshes.

mod camera;
mod context;
mod geometry;
mod lights;
mod materials;
mod media;
mod medium_region;
mod meshes;
mod object;
mod primitives;
mod settings;
#[cfg(test)]
mod tests;
mod textures;
mod transforms;
mod wo3;

use super::SourceText;
use super::assets::EmbeddedAssets;
use super::default_camera::framing_camera;
use super::description::{EnvironmentRadiance, LightDescription, SceneDescription, Span, Spanned};
use super::import::{ImportOptions, ImportedScene, SceneImporter, SceneReadError};
use super::mesh::MeshReadMonitor;
use camera::read_camera;
use context::{ImportContext, TungstenSceneFiles};
use glam::{DAffine3, DVec3};
use object::{ReadRecord, ReadResult, TungstenObject};
use primitives::TungstenPrimitives;
use settings::suggested_flags;
use std::path::Path;

/// Names of members. A Tungsten scene has at least one of these members.
const SCENE_MEMBERS: [&str; 4] = ["primitives", "bsdfs", "camera", "media"];

/// Importer of Tungsten scenes.
pub(super) struct TungstenImporter;

impl SceneImporter for TungstenImporter {
    fn name(&self) -> &'static str {
        "Tungsten JSON"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn import(
        &self,
        path: &Path,
        monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<ImportedScene, SceneReadError> {
        let files = TungstenSceneFiles { path, monitor, options };
        let bytes = files.read_file(path)?;
        import_bytes(&files, &bytes)
    }
}

/// Imports the bytes of a Tungsten scene file.
///
/// Errors name `path`. Files that the scene names are looked up in the folder of `path`.
///
/// # Errors
/// [`SceneReadError`] at the first defect, or at content that cannot be imported.
pub fn decode(path: &Path, bytes: &[u8], options: &ImportOptions) -> Result<ImportedScene, SceneReadError> {
    import_bytes(&TungstenSceneFiles { path, monitor: &(), options }, bytes)
}

/// Decodes the bytes of a `.wo3` mesh. Returns the error as text.
///
/// # Errors
/// If the file is damaged, or if the mesh takes more than `free` bytes of memory.
pub fn decode_wo3(bytes: &[u8], free: Option<u64>) -> Result<super::mesh::TriangleMesh, String> {
    wo3::decode(bytes, free)
}

fn import_bytes(files: &TungstenSceneFiles<'_>, bytes: &[u8]) -> ReadResult<ImportedScene> {
    let json = files.parse_json(bytes)?;
    let members = json.as_object().filter(|members| SCENE_MEMBERS.iter().any(|name| members.contains_key(*name)));
    let Some(members) = members else {
        let message = "the JSON is no scene of Tungsten: it has neither `primitives` nor `camera`";
        return Err(files.file_error(message, "name a scene file of Tungsten"));
    };
    let (file, record) = (files.path.display().to_string(), ReadRecord::default());
    let scene = TungstenObject::new(&file, &record, members, String::new());
    let context = ImportContext::new(files, &record, scene)?;
    let mut primitives = TungstenPrimitives::default();
    for primitive in context.scene.children("primitives")? {
        primitives.add_primitive(&context, &primitive, &DAffine3::IDENTITY, 0)?;
    }
    let (mut camera, mut ambient_medium) = (None, None);
    if let Some(object) = context.scene.child("camera") {
        camera = Some(read_camera(&context, &object)?);
        // The medium of the camera fills the space outside all bodies.
        if let Some(medium) = context.medium(&object, "medium")? {
            ambient_medium = primitives.media.medium_name(&context, &medium)?;
        }
    }
    primitives.add_medium_regions(&context, ambient_medium.as_deref())?;
    let camera = camera.unwrap_or_else(|| {
        let message = "the file has no camera: the picture shows the whole scene from above and in front";
        context.notes.borrow_mut().add_missing(message);
        framing_camera(primitives.world_bounds.unwrap_or((DVec3::ZERO, DVec3::ZERO)))
    });
    add_default_sky(&context, &mut primitives);
    note_settings(&context)?;
    context.note_unread_members();
    let TungstenPrimitives { root, meshes, mut materials, mut textures, media, mut lights, .. } = primitives;
    let used_textures = materials.list.remove_unused(&root);
    let pictures_of_lights =
        lights.descriptions.iter_mut().filter_map(|light| light.value.file_path_mut().cloned()).collect();
    textures.keep_textures(&used_textures, &pictures_of_lights);
    let description = SceneDescription {
        camera: Spanned::new(camera, Span::default()),
        background: DVec3::ZERO,
        ambient_medium: ambient_medium.map(|name| Spanned::new(name, Span::default())),
        lights: lights.descriptions,
        textures: textures.descriptions,
        media: media.descriptions,
        materials: materials.list.descriptions,
        root,
    };
    let assets = EmbeddedAssets { meshes: meshes.embedded, pictures: textures.pictures, ..EmbeddedAssets::default() };
    let source = SourceText::new(&file, "");
    Ok(ImportedScene { description, source, assets, notes: context.notes.into_inner().into_notes() })
}

/// Adds a white sky if the scene has no light, and a message tells the user.
fn add_default_sky(context: &ImportContext<'_>, primitives: &mut TungstenPrimitives) {
    if primitives.lights.descriptions.is_empty() && !primitives.has_emissive_surfaces {
        let message = "the file has no light: a white sky of radiance 1 lights the scene";
        context.notes.borrow_mut().add_missing(message);
        let sky = LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE));
        primitives.lights.descriptions.push(Spanned::new(sky, Span::default()));
    }
}

/// Adds a message that names the flags for the settings of the scene, which are not applied.
fn note_settings(context: &ImportContext<'_>) -> ReadResult<()> {
    context.scene.value("renderer");
    let flags = suggested_flags(&context.scene)?;
    if !flags.is_empty() {
        let message = format!("the settings of the file are not applied: they stand for `{flags}`");
        context.notes.borrow_mut().add_missing(&message);
    }
    Ok(())
}
