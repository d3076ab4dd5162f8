//! From description to resolved scene: looks up names and files, and applies transforms.

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

use super::description::{
    DirectionOrTarget, EmissionDescription, Group, GroupItem, ObjectDescription, SceneDescription, ShapeDescription,
    Span, Spanned, TransformStep,
};
use super::error::MAX_ERRORS;
use super::import::EmbeddedAssets;
use super::mesh::{MeshReadMonitor, TriangleMesh};
use super::{SceneError, SourceText};
use crate::color::Rgb;
use crate::math::{Motion, MotionStep, Transform};
use crate::medium::Medium;
use crate::scene::{Scene, SceneBuilder};
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec3};
use placement::EmissionOverride;
use placement::Instanced;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use textures::{KnownTexture, TextureNeeds};

/// Returns the scene of a description. Meshes, pictures and grids are looked up in `folder`, then
/// in its parent.
///
/// # Errors
/// [`SceneError`] with the position in `source`: a mesh, picture or grid that is missing or broken,
/// an unknown metal or glass, a singular product of transforms, an object that cannot emit, a
/// medium that cannot fill its body.
pub fn resolve(description: &SceneDescription, source: &SourceText, folder: &Path) -> Result<Scene, SceneError> {
    resolve_monitored(description, source, folder, &(), MemoryLimit::Unbounded)
}

/// Like [`resolve`], within `memory`; `monitor` receives the progress of reading meshes.
///
/// Pictures, grids, and meshes with their hierarchies are refused before they exceed the memory
/// limit.
///
/// # Errors
/// [`SceneError`], as for [`resolve`], or [for lack of memory](SceneError::is_out_of_memory).
pub fn resolve_monitored(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    monitor: &dyn MeshReadMonitor,
    memory: MemoryLimit,
) -> Result<Scene, SceneError> {
    resolve_with_assets(description, source, folder, &EmbeddedAssets::default(), monitor, memory)
}

/// Like [`resolve_monitored`]; paths that `assets` lists are not looked up in the file system.
///
/// # Errors
/// [`SceneError`], as for [`resolve_monitored`].
pub(super) fn resolve_with_assets(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    assets: &EmbeddedAssets,
    monitor: &dyn MeshReadMonitor,
    memory: MemoryLimit,
) -> Result<Scene, SceneError> {
    let camera = camera::camera(description, source)?;
    let mut resolver = Resolver {
        source,
        folder,
        assets,
        errors: Vec::new(),
        description,
        builder: SceneBuilder::new(),
        names: HashMap::new(),
        monitor,
        memory,
        triangles: 0,
        known: HashMap::new(),
        pictures: HashMap::new(),
        media: HashMap::new(),
        texture_needs: Vec::new(),
        meshes: HashMap::new(),
        own_materials: HashMap::new(),
        uses: uses(&description.root),
        instanced: HashMap::new(),
        material: 0,
        placing: None,
    };
    let last = resolver.all().err();
    resolver.errors.extend(last);
    if let Some(error) = SceneError::join(resolver.errors) {
        return Err(error);
    }
    resolver.builder.build(camera).map_err(|e| {
        SceneError::of_file(source, e.to_string(), "choose units in which the scene is neither huge nor empty")
    })
}

/// Extensions of mesh formats that are not read.
const FOREIGN_MESHES: [&str; 14] =
    ["stl", "off", "glb", "gltf", "fbx", "dae", "3ds", "usd", "usda", "usdc", "usdz", "abc", "blend", "x3d"];

const ROOM: &str = "use a smaller file, or let the scene have more memory (--memory)";

struct Resolver<'a> {
    source: &'a SourceText,
    folder: &'a Path,
    assets: &'a EmbeddedAssets,
    /// Errors of objects so far; resolving goes on to find more.
    errors: Vec<SceneError>,
    description: &'a SceneDescription,
    builder: SceneBuilder,
    /// Indices of the materials so far, by name.
    names: HashMap<&'a str, u32>,
    /// Textures, by name.
    known: HashMap<&'a str, KnownTexture>,
    /// Pictures that materials name by path, each as light or as numbers.
    pictures: HashMap<(PathBuf, bool), KnownTexture>,
    /// Media with their indices, by name.
    media: HashMap<&'a str, (u32, Medium)>,
    /// Texture coordinates that each material needs.
    texture_needs: Vec<TextureNeeds>,
    monitor: &'a dyn MeshReadMonitor,
    memory: MemoryLimit,
    /// Triangles so far that hierarchies will be built over.
    triangles: u64,
    /// Meshes that were read, by file and options.
    meshes: HashMap<meshes::MeshKey, Rc<meshes::Pieces>>,
    /// Materials of mesh files, in the order in which the meshes name them.
    own_materials: HashMap<PathBuf, Rc<Vec<meshes::MtlMaterial>>>,
    /// Number of objects that name each mesh path.
    uses: HashMap<&'a str, usize>,
    /// Shared copies, by mesh.
    instanced: HashMap<*const TriangleMesh, Rc<Instanced>>,
    /// Index of the material in force; it holds beyond the group that set it.
    material: u32,
    /// Span of the innermost transform, for errors about the product.
    placing: Option<Span>,
}

impl Resolver<'_> {
    /// Adds everything that the description names to the builder.
    fn all(&mut self) -> Result<(), SceneError> {
        let description = self.description;
        self.builder.background(rgb(description.background));
        self.textures()?;
        media::add_media(self)?;
        media::fill_background(self)?;
        self.materials()?;
        for light in &description.lights {
            let result = lights::add_light(self, light, &Motion::default());
            self.record(result)?;
        }
        if !description.camera.motion.is_empty() {
            self.builder.moving_camera(growing_motion(&description.camera.motion));
        }
        self.group(&description.root, &Motion::default())
    }

    /// Records an error and goes on, unless memory is exhausted or there are many errors already.
    fn record(&mut self, result: Result<(), SceneError>) -> Result<(), SceneError> {
        match result {
            Err(error) if error.is_out_of_memory() || self.errors.len() + 1 >= MAX_ERRORS => Err(error),
            Err(error) => {
                self.errors.push(error);
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    fn group(&mut self, group: &Group, to_world: &Motion) -> Result<(), SceneError> {
        for item in &group.items {
            match item {
                GroupItem::MaterialIndex(index) => self.material = index.value,
                GroupItem::MaterialName(name) => self.material = self.named(name)?,
                GroupItem::Object(object) => {
                    let placing = self.placing;
                    let result = self.object(object, to_world);
                    self.placing = placing;
                    self.record(result)?;
                }
            }
        }
        Ok(())
    }

    fn object(&mut self, object: &Spanned<ObjectDescription>, to_world: &Motion) -> Result<(), SceneError> {
        match &object.value {
            ObjectDescription::Group(group) => self.group(group, to_world),
            ObjectDescription::Transform { maps, object: inner } => {
                let outer = self.placing.replace(object.span);
                let product = to_world.preceded_by([MotionStep::Fixed(TransformStep::composed_matrix(maps))]);
                self.object(inner, &product)?;
                self.placing = outer;
                Ok(())
            }
            ObjectDescription::Moving { maps, object: inner } => {
                let outer = self.placing.replace(object.span);
                self.object(inner, &to_world.preceded_by(maps.iter().map(TransformStep::motion_step)))?;
                self.placing = outer;
                Ok(())
            }
            ObjectDescription::Shape { shape, emission } => {
                let own = self.description.materials.get(self.material as usize).and_then(|m| m.emission.as_ref());
                let (radiance, texture) = match (emission, own) {
                    (Some(emission), _) | (None, Some(EmissionDescription::Radiance(emission))) => {
                        (rgb(*emission), None)
                    }
                    (None, Some(EmissionDescription::Texture { name, scale })) => {
                        let known = self.known(name, &(0.0..=f32::MAX))?;
                        let scale = Rgb::splat(*scale as f32);
                        (known.mean * scale, Some((known.index, scale)))
                    }
                    (None, None) => (Rgb::ZERO, None),
                };
                self.check_radiance(radiance, object.span)?;
                media::check_clear(self, radiance, object.span)?;
                let emission = EmissionOverride { radiance, of_object: emission.is_some(), texture };
                shapes::add_shape(self, shape, object.span, to_world, &emission)
            }
        }
    }

    /// Refuses a radiance that single precision cannot hold.
    fn check_radiance(&self, radiance: Rgb, span: Span) -> Result<(), SceneError> {
        if radiance.is_finite() {
            return Ok(());
        }
        let help = "let it emit less, or choose other units";
        Err(self.refuse(span, "its radiance is above 3.4e38, which single precision holds", help))
    }

    /// Returns an error at `span`.
    fn refuse(&self, span: Span, message: &str, help: &str) -> SceneError {
        SceneError::at(self.source, span, message, "here", help)
    }

    fn transform(&self, to_world: DAffine3, span: Span) -> Result<Transform, SceneError> {
        Transform::new(to_world).map_err(|e| {
            let culprit = self.placing.unwrap_or(span);
            let help = "no scale may be zero, and no axis of a matrix may be a mix of the others";
            SceneError::at(self.source, culprit, e.to_string(), "together with the transforms around it", help)
        })
    }

    /// Returns the file of a path; `kind` names its type in errors.
    fn file(&self, kind: &str, path: &Spanned<String>) -> Result<PathBuf, SceneError> {
        let written = Path::new(&path.value);
        if self.assets.contains(path) {
            return Ok(written.to_owned());
        }
        let extension = written.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if kind == "mesh" && FOREIGN_MESHES.contains(&extension.as_str()) {
            let message = format!("meshes of the format `.{extension}` are not read");
            return Err(self.bad_file(path, &message, "convert it to OBJ or PLY, which are read"));
        }
        let found =
            candidates(self.folder, written).find(|p| p.is_file()).inspect(|file| self.monitor.on_file_named(file));
        found.ok_or_else(|| {
            let places: Vec<String> = candidates(self.folder, written).map(|p| format!("`{}`", p.display())).collect();
            let message = format!("the {kind} `{}` does not exist", path.value);
            self.bad_file(path, &message, &format!("put the file at {}", places.join(" or ")))
        })
    }

    /// Returns the error of a file: it exceeds the memory limit, or `help` is the remedy.
    fn refuse_file(&self, path: &Spanned<String>, message: &impl ToString, exhausts: bool, help: &str) -> SceneError {
        if exhausts {
            self.bad_file(path, message, ROOM).marked_out_of_memory()
        } else {
            self.bad_file(path, message, help)
        }
    }

    fn bad_file(&self, path: &Spanned<String>, message: &impl ToString, help: &str) -> SceneError {
        SceneError::at(self.source, path.span, message.to_string(), "named here", help)
    }
}

/// Iterates over the paths where a file may be: beside the scene file, and in the folder above it.
pub(super) fn candidates<'a>(folder: &'a Path, path: &'a Path) -> impl Iterator<Item = PathBuf> {
    let above = if folder.as_os_str().is_empty() { Path::new("..").to_owned() } else { folder.join("..") };
    [folder.join(path), above.join(path)].into_iter().take(if path.is_absolute() { 1 } else { 2 })
}

/// Returns the number of objects that name each mesh path.
fn uses(group: &Group) -> HashMap<&str, usize> {
    fn count<'a>(object: &'a ObjectDescription, uses: &mut HashMap<&'a str, usize>) {
        match object {
            ObjectDescription::Group(group) => group.items.iter().for_each(|item| {
                if let GroupItem::Object(object) = item {
                    count(object, uses);
                }
            }),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                count(object, uses)
            }
            ObjectDescription::Shape { shape: ShapeDescription::Mesh { path, .. }, .. } => {
                *uses.entry(path).or_insert(0) += 1
            }
            ObjectDescription::Shape { .. } => {}
        }
    }
    let mut uses = HashMap::new();
    for item in &group.items {
        if let GroupItem::Object(object) = item {
            count(object, &mut uses);
        }
    }
    uses
}

/// Returns the motion of maps that grow while the shutter is open.
fn growing_motion(maps: &[TransformStep]) -> Motion {
    Motion::default().preceded_by(maps.iter().map(TransformStep::motion_step))
}

fn aim(aim: DirectionOrTarget, from: DVec3) -> DVec3 {
    match aim {
        DirectionOrTarget::Direction(direction) => direction,
        DirectionOrTarget::LookAt(point) => point - from,
    }
}

fn rgb(color: DVec3) -> Rgb {
    color.as_vec3()
}
