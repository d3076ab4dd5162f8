//! From description to resolved scene: names and files are looked up, transforms multiplied through.

mod lights;
mod shapes;
#[cfg(test)]
mod tests;

use super::description::{Aim, Attenuation, Description, Group, Item, MaterialKind, Object, Span, Spanned};
use super::obj::{self, TriangleMesh};
use super::{SceneError, Source};
use crate::camera::Pinhole;
use crate::color::Rgb;
use crate::math::Transform;
use crate::scene::{Material, Scene, SceneBuilder};
use glam::{DAffine3, DVec3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Makes a scene of a description. Meshes are looked for in `folder`, then in the folder above it.
///
/// # Errors
/// [`SceneError`] with the place in `source`: a mesh that is missing or broken, a singular product of transforms, what cannot
/// emit or cannot be rendered yet.
pub fn resolve(description: &Description, source: &Source, folder: &Path) -> Result<Scene, SceneError> {
    let camera = camera(description, source)?;
    let mut resolver = Resolver {
        source,
        folder,
        description,
        builder: SceneBuilder::new(),
        meshes: HashMap::new(),
        material: 0,
        placing: None,
    };
    resolver.builder.background(rgb(description.background));
    for material in &description.materials {
        resolver.builder.material(self::material(&material.kind));
    }
    if description.materials.is_empty() {
        resolver.builder.material(Material::diffuse(Rgb::ONE));
    }
    for light in &description.lights {
        resolver.light(light);
    }
    resolver.group(&description.root, DAffine3::IDENTITY)?;
    resolver.builder.build(camera).map_err(|e| {
        SceneError::of_file(source, e.to_string(), "choose units in which the scene is neither huge nor empty")
    })
}

struct Resolver<'a> {
    source: &'a Source,
    folder: &'a Path,
    description: &'a Description,
    builder: SceneBuilder,
    meshes: HashMap<PathBuf, Rc<TriangleMesh>>,
    /// The material in force: it persists beyond the group that set it.
    material: u32,
    /// The innermost transform, for errors about the product.
    placing: Option<Span>,
}

impl Resolver<'_> {
    fn group(&mut self, group: &Group, to_world: DAffine3) -> Result<(), SceneError> {
        for item in &group.items {
            match item {
                Item::MaterialIndex(index) => self.material = index.value,
                Item::MaterialName(name) => {
                    let named = |m: &Spanned<_>| material_name(m) == Some(name.value.as_str());
                    let found = self.description.materials.iter().position(named);
                    let index = found.ok_or_else(|| {
                        let message = format!("there is no material named `{}`", name.value);
                        SceneError::at(self.source, name.span, message, "unknown name", "define it in Materials first")
                    })?;
                    self.material = index as u32;
                }
                Item::Object(object) => self.object(object, to_world)?,
            }
        }
        Ok(())
    }

    fn object(&mut self, object: &Spanned<Object>, to_world: DAffine3) -> Result<(), SceneError> {
        match &object.value {
            Object::Group(group) => self.group(group, to_world),
            Object::Transform { maps, object: inner } => {
                let outer = self.placing.replace(object.span);
                let product = to_world * super::description::Map::product(maps);
                self.object(inner, product)?;
                self.placing = outer;
                Ok(())
            }
            Object::Shape { shape, emission } => {
                let own = self.description.materials.get(self.material as usize).and_then(|m| m.emission);
                let emission = rgb(emission.or(own).unwrap_or(DVec3::ZERO));
                self.shape(shape, object.span, to_world, emission)
            }
        }
    }

    fn transform(&self, to_world: DAffine3, span: Span) -> Result<Transform, SceneError> {
        Transform::new(to_world).map_err(|e| {
            let place = self.placing.unwrap_or(span);
            let help = "no scale may be zero, and no axis of a matrix may be a mix of the others";
            SceneError::at(self.source, place, e.to_string(), "together with the transforms around it", help)
        })
    }

    /// The mesh of a path, read once.
    fn mesh(&mut self, path: &Spanned<String>) -> Result<Rc<TriangleMesh>, SceneError> {
        let error = |message: String, help: &str| SceneError::at(self.source, path.span, message, "named here", help);
        let Some(file) = find(self.folder, Path::new(&path.value)) else {
            let places: Vec<String> = places(self.folder, Path::new(&path.value)).map(|p| show(&p)).collect();
            let message = format!("the mesh `{}` does not exist", path.value);
            return Err(error(message, &format!("put the file at {}", places.join(" or "))));
        };
        if let Some(mesh) = self.meshes.get(&file) {
            return Ok(mesh.clone());
        }
        let mesh = obj::load(&file).map_err(|e| error(e.to_string(), "mend the mesh or name another"))?;
        let mesh = Rc::new(mesh);
        self.meshes.insert(file, mesh.clone());
        Ok(mesh)
    }
}

/// Where a mesh may be: beside the scene file, or in the folder above it.
fn places<'a>(folder: &'a Path, path: &'a Path) -> impl Iterator<Item = PathBuf> {
    let above = if folder.as_os_str().is_empty() { Path::new("..").to_owned() } else { folder.join("..") };
    [folder.join(path), above.join(path)].into_iter().take(if path.is_absolute() { 1 } else { 2 })
}

fn find(folder: &Path, path: &Path) -> Option<PathBuf> {
    places(folder, path).find(|p| p.is_file())
}

fn show(path: &Path) -> String {
    format!("`{}`", path.display())
}

fn material_name(material: &super::description::Material) -> Option<&str> {
    material.name.as_deref()
}

fn camera(description: &Description, source: &Source) -> Result<Pinhole, SceneError> {
    let camera = &description.camera;
    let direction = aim(camera.aim, camera.center);
    Pinhole::new(camera.center, direction, camera.up, camera.angle.to_radians(), camera.width, camera.height)
        .map_err(|e| SceneError::at(source, camera.span, e.to_string(), "this camera", "give another `up`"))
}

fn aim(aim: Aim, from: DVec3) -> DVec3 {
    match aim {
        Aim::Direction(direction) => direction,
        Aim::LookAt(point) => point - from,
    }
}

fn rgb(color: DVec3) -> Rgb {
    color.as_vec3()
}

fn material(kind: &MaterialKind) -> Material {
    match kind {
        MaterialKind::Phong { diffuse, specular, shininess, texture: _ } => {
            Material::phong(rgb(*diffuse), rgb(*specular), *shininess as f32)
        }
        MaterialKind::Diffuse { reflectance } => Material::diffuse(rgb(*reflectance)),
        MaterialKind::Mirror { reflectance } => Material::mirror(rgb(*reflectance)),
        MaterialKind::Dielectric { index, attenuation } => {
            let absorption = match attenuation {
                Attenuation::None => DVec3::ZERO,
                Attenuation::Absorption(sigma) => *sigma,
                Attenuation::Tint { color, distance } => -color.map(libm::log) / *distance,
            };
            Material::dielectric(*index as f32, rgb(absorption))
        }
    }
}
