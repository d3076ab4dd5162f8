//! Converts primitives of Tungsten to objects of the scene language.

use super::context::ImportContext;
use super::geometry::{PrimitiveGeometry, mesh_geometry, primitive_geometry};
use super::lights::{TungstenLights, read_emission};
use super::materials::{MaterialInputs, TungstenMaterials};
use super::media::TungstenMedia;
use super::medium_region::{HalfSpace, region_mesh};
use super::meshes::TungstenMeshes;
use super::object::{ReadResult, TungstenObject};
use super::textures::TungstenTextures;
use super::transforms::read_transform;
use crate::format::description::{
    GroupItem, MeshDescription, MeshOptions, ObjectDescription, ObjectGroup, ShapeDescription, Span, Spanned,
};
use crate::format::imported_files;
use crate::format::imported_objects::{extended_bounds, placed_object};
use crate::math::Transform;
use glam::{DAffine3, DMat3, DVec3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Estimated memory of each object \[bytes], in the scene description and in the built scene
/// together.
const MEMORY_PER_OBJECT: u64 = 1_500;

/// Greatest number of flat surfaces that bound one medium. More surfaces would take long.
const MAX_HALF_SPACES: usize = 256;

/// Greatest nesting depth of instances.
const MAX_INSTANCE_DEPTH: u32 = 8;

/// Objects and lights of the imported scene so far, with all that they use.
#[derive(Default)]
pub(super) struct TungstenPrimitives {
    /// Objects of the imported scene with their materials, in the order of the file.
    pub root: ObjectGroup,
    /// Embedded meshes of the objects.
    pub meshes: TungstenMeshes,
    /// Materials of the objects.
    pub materials: TungstenMaterials,
    /// Textures of the objects and lights.
    pub textures: TungstenTextures,
    /// Media inside the objects.
    pub media: TungstenMedia,
    /// Lights without a surface.
    pub lights: TungstenLights,
    /// Lower and upper corner of the objects' bounds in world space; `None` if there are no
    /// objects.
    pub world_bounds: Option<(DVec3, DVec3)>,
    /// True if at least one object emits light.
    pub has_emissive_surfaces: bool,
    /// Number of instances so far, whether they add objects or not.
    instance_count: u64,
    /// Half-spaces behind flat surfaces that let light pass, by the medium behind them.
    half_spaces: BTreeMap<String, Vec<HalfSpace>>,
    /// Names of the media in front of surfaces, each with a primitive that states it.
    outer_media: BTreeMap<String, String>,
}

impl TungstenPrimitives {
    /// Converts and adds a primitive. `depth` is the number of instances that contain it,
    /// and `outer` is their transform to world space.
    pub fn add_primitive<'a>(
        &mut self,
        context: &ImportContext<'a>,
        object: &TungstenObject<'a>,
        outer: &DAffine3,
        depth: u32,
    ) -> ReadResult<()> {
        if self.lights.add_light(context, &mut self.textures, object, outer)? {
            return Ok(());
        }
        let to_world = *outer * read_transform(object)?;
        match object.kind()? {
            "instances" => self.add_instances(context, object, &to_world, depth),
            "mesh" => {
                let bsdfs = mesh_bsdfs(context, object)?;
                let parts = self.meshes.embed_mesh_file(context, object, bsdfs.len())?;
                if parts.is_empty() {
                    context.add_note("meshes without triangles are left out", object);
                }
                let part_geometry = |path: String| mesh_geometry(&self.meshes, path, to_world);
                let parts: Vec<_> = parts.into_iter().map(|(bsdf, path)| (bsdf, part_geometry(path))).collect();
                // The power of a mesh is that of all its parts.
                let area = parts.iter().map(|(_, part)| part.area).sum();
                for (bsdf, geometry) in parts {
                    let bsdf = bsdfs.get(bsdf).and_then(Option::as_ref);
                    self.add_surface(context, object, bsdf, PrimitiveGeometry { area, ..geometry })?;
                }
                Ok(())
            }
            _ => {
                let bsdf = context.bsdf(object, "bsdf")?;
                let probe = self.materials.imported_material(
                    context,
                    &mut self.textures,
                    bsdf.as_ref(),
                    &MaterialInputs::default(),
                )?;
                let emits_texture = self.emits_texture(context, object)?;
                let is_textured = probe.may_be_textured || emits_texture;
                match primitive_geometry(context, &mut self.meshes, object, to_world, is_textured)? {
                    Some(geometry) => self.add_surface(context, object, bsdf.as_ref(), geometry),
                    None => Ok(()),
                }
            }
        }
    }

    /// True if the emission of a primitive is a texture.
    fn emits_texture(&mut self, context: &ImportContext<'_>, object: &TungstenObject<'_>) -> ReadResult<bool> {
        Ok(read_emission(context, &mut self.textures, object, 1.0)?.texture.is_some())
    }

    /// Adds the instances of a primitive `instances`. `to_world` is its transform.
    fn add_instances<'a>(
        &mut self,
        context: &ImportContext<'a>,
        object: &TungstenObject<'a>,
        to_world: &DAffine3,
        depth: u32,
    ) -> ReadResult<()> {
        if depth >= MAX_INSTANCE_DEPTH {
            return Err(object.error("instances are nested too deep", "nest them less deep"));
        }
        let masters = object.children("masters")?;
        if !matches!(object.value("instances"), Some(Value::Array(_))) {
            context.add_whole_object_note("instances in files are left out", object);
            return Ok(());
        }
        for instance in object.children("instances")? {
            // Without this check, nested instances of nothing take exponential time.
            self.instance_count += 1;
            let needed = MEMORY_PER_OBJECT * self.instance_count;
            imported_files::check_memory(context.files.path, needed, context.files.free_memory())?;
            let id = instance.number_in("id", 0.0, 0.0..=1e9)?;
            let Some(master) = masters.get(id as usize) else {
                return Err(instance.error(format!("`masters` has no entry {id}"), "correct `id`"));
            };
            // Instances are rotated and moved, but not scaled, as in Tungsten.
            let placed = read_transform(&instance)?;
            let (Some(rotation), Some(outer)) = (rotation_of(&placed), rotation_of(to_world)) else {
                context.add_note("objects that are scaled to nothing are left out", &instance);
                continue;
            };
            let position = to_world.transform_point3(placed.translation);
            let outer = DAffine3 { matrix3: outer * rotation, translation: position };
            self.add_primitive(context, master, &outer, depth + 1)?;
        }
        Ok(())
    }

    /// Adds a surface with at most one BSDF.
    ///
    /// Leaves out surfaces that let all light pass and neither emit nor bound a medium.
    fn add_surface<'a>(
        &mut self,
        context: &ImportContext<'a>,
        object: &TungstenObject<'a>,
        bsdf: Option<&TungstenObject<'a>>,
        geometry: PrimitiveGeometry,
    ) -> ReadResult<()> {
        let medium = match context.medium(object, "int_medium")? {
            Some(medium) => self.media.medium_name(context, &medium)?,
            None => None,
        };
        if let Some(outer) = context.medium(object, "ext_medium")?
            && let Some(name) = self.media.medium_name(context, &outer)?
        {
            self.outer_media.entry(name).or_insert_with(|| object.label());
        }
        let emission = read_emission(context, &mut self.textures, object, 1.0 / (PI * geometry.area))?;
        let inputs = MaterialInputs { medium: medium.clone(), emission_texture: emission.texture.clone() };
        let material = self.materials.imported_material(context, &mut self.textures, bsdf, &inputs)?;
        let mut name = material.name;
        if material.is_null && emission.radiance.is_some() {
            context.add_note("emitters without a surface become black", object);
            name = self.materials.add_black_material(context)?;
        } else if material.is_null {
            let Some(medium) = medium else { return Ok(()) };
            if let Some(half_space) = geometry.half_space {
                context.add_note("a medium behind flat surfaces fills the bounds of the scene behind them", object);
                self.grow_bounds(&geometry);
                let half_spaces = self.half_spaces.entry(medium).or_default();
                if half_spaces.len() < MAX_HALF_SPACES {
                    half_spaces.push(half_space);
                } else {
                    let message = format!("flat surfaces of a medium after the first {MAX_HALF_SPACES} are ignored");
                    context.add_note(&message, object);
                }
                return Ok(());
            }
        } else if medium.is_some() && !material.bounds_medium {
            context.add_note("media behind surfaces that are neither dielectric nor `forward` are left out", object);
        }
        self.has_emissive_surfaces |= emission.radiance.is_some() || emission.texture.is_some();
        self.push_object(context, object, name, geometry, emission.radiance)
    }

    /// Adds an object to the imported scene. An object with a singular transform is left out, and a
    /// message tells the user.
    fn push_object(
        &mut self,
        context: &ImportContext<'_>,
        source: &TungstenObject<'_>,
        material: String,
        geometry: PrimitiveGeometry,
        emission: Option<DVec3>,
    ) -> ReadResult<()> {
        if Transform::new(geometry.to_world).is_err() {
            context.add_note("objects that are scaled to nothing are left out", source);
            return Ok(());
        }
        let needed = MEMORY_PER_OBJECT * (self.root.items.len() as u64 / 2 + 1);
        imported_files::check_memory(context.files.path, needed, context.files.free_memory())?;
        self.grow_bounds(&geometry);
        let PrimitiveGeometry { surface: shape, to_world, .. } = geometry;
        let object = placed_object(shape, emission, to_world);
        self.root.items.push(GroupItem::MaterialName(Spanned::new(material, Span::default())));
        self.root.items.push(GroupItem::Object(Spanned::new(object, Span::default())));
        Ok(())
    }

    /// Extends the bounds of the scene by a surface.
    fn grow_bounds(&mut self, geometry: &PrimitiveGeometry) {
        self.world_bounds = Some(extended_bounds(self.world_bounds, &geometry.to_world, geometry.local_bounds));
    }

    /// Adds the bodies of media behind flat surfaces. `ambient` is the medium around all bodies.
    ///
    /// Call this once, after all primitives. A medium that is only stated in front of surfaces is
    /// left out, and a message tells the user.
    pub fn add_medium_regions(&mut self, context: &ImportContext<'_>, ambient: Option<&str>) -> ReadResult<()> {
        let bounds = self.world_bounds.unwrap_or((DVec3::ZERO, DVec3::ZERO));
        for (medium, half_spaces) in std::mem::take(&mut self.half_spaces) {
            let Some(mesh) = region_mesh(bounds, &half_spaces) else { continue };
            let material = self.materials.add_null_interface(context, &medium)?;
            let path = Spanned::new(self.meshes.embed_mesh(mesh), Span::default());
            let shape = ShapeDescription::Mesh(MeshDescription { path, options: MeshOptions::default() });
            let object = ObjectDescription::Shape { shape, emission: None };
            self.root.items.push(GroupItem::MaterialName(Spanned::new(material, Span::default())));
            self.root.items.push(GroupItem::Object(Spanned::new(object, Span::default())));
        }
        for (medium, place) in &self.outer_media {
            let is_filled = self
                .materials
                .list
                .descriptions
                .iter()
                .any(|material| material.medium.as_ref().is_some_and(|filling| filling.value == *medium));
            if !is_filled && ambient != Some(medium) {
                let message = "media that are only stated as `ext_medium` are left out";
                context.notes.borrow_mut().add_unsupported(message, place.clone());
            }
        }
        Ok(())
    }
}

/// Returns the BSDFs of a mesh: those of a list, or a single one. `None` stands for a mesh without
/// a BSDF.
fn mesh_bsdfs<'a>(
    context: &ImportContext<'a>,
    object: &TungstenObject<'a>,
) -> ReadResult<Vec<Option<TungstenObject<'a>>>> {
    let Some(Value::Array(list)) = object.value("bsdf") else { return Ok(vec![context.bsdf(object, "bsdf")?]) };
    if list.is_empty() {
        return Err(object.error("the list `bsdf` is empty", "name at least one BSDF"));
    }
    let entry =
        |(i, value): (usize, &'a Value)| context.referenced_bsdf(object, &format!("bsdf[{i}]"), value).map(Some);
    list.iter().enumerate().map(entry).collect()
}

/// Returns the linear part of a transform with axes of unit length; `None` if an axis has none.
fn rotation_of(transform: &DAffine3) -> Option<DMat3> {
    let matrix = transform.matrix3;
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::try_normalize);
    Some(DMat3::from_cols(x?, y?, z?))
}
