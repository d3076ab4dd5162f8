//! Imports scenes in Mitsuba's XML format, versions 0.4 to 3.

mod color;
mod conductors;
mod context;
mod dielectrics;
mod document;
mod environment;
mod files;
mod lights;
mod materials;
mod media;
mod meshes;
mod names;
mod sensor;
mod serialized;
mod settings;
mod shapes;
#[cfg(test)]
mod tests;
mod textures;
mod transforms;
mod tree;
mod volume;

use super::SourceText;
use super::assets::EmbeddedAssets;
use super::default_camera::framing_camera;
use super::description::{EnvironmentRadiance, LightDescription, SceneDescription, Span, Spanned};
use super::import::{ImportOptions, ImportedScene, SceneImporter, SceneReadError};
use super::mesh::MeshReadMonitor;
use context::ImportContext;
use document::read_tree;
use files::{MitsubaSceneFiles, ReadResult};
use glam::DVec3;
use lights::read_light;
use sensor::read_camera;
use settings::suggested_flags;
use shapes::MitsubaShapes;
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use textures::MitsubaTextures;
use tree::{MitsubaObject, ObjectClass};

/// Importer of Mitsuba scenes.
pub(super) struct MitsubaImporter;

impl SceneImporter for MitsubaImporter {
    fn name(&self) -> &'static str {
        "Mitsuba XML"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["xml"]
    }

    fn import(
        &self,
        path: &Path,
        monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<ImportedScene, SceneReadError> {
        let files = MitsubaSceneFiles::new(path, monitor, options);
        let bytes = files.read_file(path)?;
        import_bytes(&files, bytes)
    }
}

/// Imports the bytes of a Mitsuba scene file.
///
/// Errors name `path`. Files that the scene names are looked up in the folder of `path`.
///
/// # Errors
/// [`SceneReadError`] at the first defect, or at content that cannot be imported.
pub fn decode(path: &Path, bytes: &[u8], options: &ImportOptions) -> Result<ImportedScene, SceneReadError> {
    import_bytes(&MitsubaSceneFiles::new(path, &(), options), bytes.to_vec())
}

fn import_bytes(files: &MitsubaSceneFiles<'_>, bytes: Vec<u8>) -> ReadResult<ImportedScene> {
    let tree = read_tree(files, bytes)?;
    let context = ImportContext { files, tree: &tree, notes: RefCell::default() };
    let (mut shapes, mut textures) = (MitsubaShapes::default(), MitsubaTextures::default());
    for (_, shape) in context.children_of_class(&tree.root, ObjectClass::Shape)? {
        shapes.add_shape(&context, &mut textures, &shape)?;
    }
    let mut lights = read_lights(&context, &mut textures, shapes.has_emissive_surfaces)?;
    let sensors = context.children_of_class(&tree.root, ObjectClass::Sensor)?;
    let sensor = sensors.first().map(|(_, sensor)| sensor);
    if let Some((_, second)) = sensors.get(1) {
        context.add_note("sensors after the first one are ignored", second);
    }
    let mut camera = None;
    let mut ambient_medium = None;
    if let Some(sensor) = sensor {
        camera = read_camera(&context, sensor)?;
        if camera.is_none() {
            context.add_whole_object_note(&format!("sensors of kind `{}` are ignored", sensor.plugin), sensor);
        }
        // The medium of the sensor fills the space outside all shapes.
        if let Some((_, medium)) = context.children_of_class(sensor, ObjectClass::Medium)?.first() {
            ambient_medium = Some(shapes.media.medium_name(&context, medium)?);
        }
    }
    let camera = camera.unwrap_or_else(|| {
        let message = "the file has no camera: the picture shows the whole scene from above and in front";
        context.notes.borrow_mut().add_missing(message);
        framing_camera(shapes.world_bounds.unwrap_or((DVec3::ZERO, DVec3::ZERO)))
    });
    let flags = suggested_flags(&context, sensor)?;
    if !flags.is_empty() {
        let message = format!("the settings of the file are not applied: they stand for `{flags}`");
        context.notes.borrow_mut().add_missing(&message);
    }
    context.note_unread_values();
    let used_textures = shapes.materials.list.remove_unused(&shapes.root);
    let pictures_of_lights = lights.iter_mut().filter_map(|light| light.value.file_path_mut().cloned()).collect();
    textures.keep_textures(&used_textures, &pictures_of_lights);
    let notes = context.notes.into_inner();
    let description = SceneDescription {
        camera: Spanned::new(camera, Span::default()),
        background: DVec3::ZERO,
        ambient_medium,
        lights,
        textures: textures.descriptions,
        media: shapes.media.descriptions,
        materials: shapes.materials.list.descriptions,
        root: shapes.root,
    };
    let assets =
        EmbeddedAssets { meshes: shapes.meshes.embedded, pictures: textures.pictures, grids: shapes.media.grids };
    let source = SourceText::new(&files.path.display().to_string(), "");
    Ok(ImportedScene { description, source, assets, notes: notes.into_notes() })
}

/// Converts the lights of the scene, except area lights, which are emission of shapes.
///
/// Only the first environment emitter is kept. Others are left out, and a message tells the user.
/// If there is no light, and `has_emissive_surfaces` is false (no shape emits), adds a white sky,
/// and a message tells the user.
fn read_lights(
    context: &ImportContext<'_>,
    textures: &mut MitsubaTextures,
    has_emissive_surfaces: bool,
) -> ReadResult<Vec<Spanned<LightDescription>>> {
    let mut lights: Vec<Spanned<LightDescription>> = Vec::new();
    let emitters: Vec<(String, Rc<MitsubaObject>)> =
        context.children_of_class(&context.tree.root, ObjectClass::Emitter)?;
    let is_environment = |light: &LightDescription| matches!(light, LightDescription::Environment(_));
    for (_, emitter) in &emitters {
        let Some(light) = read_light(context, textures, emitter)? else { continue };
        if is_environment(&light) && lights.iter().any(|light| is_environment(&light.value)) {
            context.add_note("environment emitters after the first one are left out", emitter);
            continue;
        }
        lights.push(Spanned::new(light, Span::default()));
    }
    if lights.is_empty() && !has_emissive_surfaces {
        let cause = if emitters.is_empty() { "the file has no light" } else { "no emitter of the file gives light" };
        let message = format!("{cause}: a white sky of radiance 1 lights the scene");
        context.notes.borrow_mut().add_missing(&message);
        let sky = LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE));
        lights.push(Spanned::new(sky, Span::default()));
    }
    Ok(lights)
}
