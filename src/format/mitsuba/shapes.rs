//! Converts shapes of Mitsuba to objects of the scene language.

use super::context::ImportContext;
use super::files::ReadResult;
use super::materials::{MaterialBoundary, MitsubaMaterials, ShapeMaterialInputs};
use super::media::MitsubaMedia;
use super::meshes::{MitsubaFileMesh, MitsubaMeshes, TexcoordConvention, file_texcoord_convention, read_obj_parts};
use super::textures::{MitsubaTextureUse, MitsubaTextures};
use super::tree::{MitsubaObject, ObjectClass};
use crate::format::description::{
    BoxDescription, CylinderDescription, DiscDescription, GroupItem, MeshDescription, MeshOptions, ObjectGroup,
    RectangleDescription, ShapeDescription, Span, Spanned, SphereDescription,
};
use crate::format::imported_objects::{extended_bounds, placed_object};
use crate::format::imported_textures::ConvertedTexture;
use crate::math::Transform;
use glam::{DAffine3, DMat4, DVec3};
use std::collections::HashMap;
use std::rc::Rc;

/// Estimated memory of each object \[bytes], in the scene description and in the built scene
/// together.
const MEMORY_PER_OBJECT: u64 = 1_500;

/// Greatest nesting depth of shapes.
const MAX_SHAPE_DEPTH: u32 = 8;

/// Objects of the imported scene so far, with the meshes, materials and media that they use.
#[derive(Default)]
pub(super) struct MitsubaShapes {
    /// Objects of the imported scene with their materials, in the order of the Mitsuba file.
    pub root: ObjectGroup,
    /// Embedded meshes of the objects.
    pub meshes: MitsubaMeshes,
    /// Materials of the objects in the imported scene.
    pub materials: MitsubaMaterials,
    /// Media inside the objects in the imported scene.
    pub media: MitsubaMedia,
    /// Lower and upper corner of the objects' bounds in world space; `None` if there are no
    /// objects.
    pub world_bounds: Option<(DVec3, DVec3)>,
    /// True if at least one converted shape emits light.
    pub has_emissive_surfaces: bool,
    /// Converted shapes of each shape group, by the address of the group's [`MitsubaObject`].
    groups: HashMap<*const MitsubaObject, Rc<Vec<PlacedShape>>>,
}

/// A converted shape with its material, emission and transform.
#[derive(Clone, Debug)]
struct PlacedShape {
    /// Name of the material in the imported scene.
    material: String,
    shape: ShapeDescription,
    /// Emitted radiance. `None` if the shape emits nothing, or if its radiance is a texture: then
    /// the material emits.
    emission: Option<DVec3>,
    /// Transform from the shape's own space to world space, or to the space of its shape group.
    to_world: DAffine3,
    /// Lower and upper corner of the shape's bounds in its own space, before `to_world`.
    local_bounds: (DVec3, DVec3),
}

/// Mesh of a shape that comes from a mesh file.
enum ShapeMesh {
    /// The whole mesh of the shape's file.
    File,
    /// A part of the file's mesh: all faces of one BSDF, or all faces without a BSDF.
    Part(MitsubaFileMesh),
}

/// Geometry of a converted shape, with its transform.
struct ShapeGeometry {
    surface: ShapeDescription,
    /// Transform from the surface's own space to world space, or to the space of its shape group.
    to_world: DAffine3,
    /// Lower and upper corner of the surface's bounds in its own space, before `to_world`.
    local_bounds: (DVec3, DVec3),
}

/// Emission of a shape: constant radiance, or a texture; neither if the shape emits nothing.
#[derive(Default)]
struct MitsubaShapeEmission {
    radiance: Option<DVec3>,
    /// Name of the emission texture, and the factor from its values to radiance.
    texture: Option<(Spanned<String>, f64)>,
}

impl MitsubaShapes {
    /// Converts and adds a shape at the top level of the file.
    ///
    /// A shape group adds nothing by itself: only its instances do.
    pub fn add_shape(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        shape: &Rc<MitsubaObject>,
    ) -> ReadResult<()> {
        if shape.plugin == "shapegroup" {
            return Ok(());
        }
        for placed in self.placed_shapes(context, textures, shape, 0)? {
            self.push_shape(context, placed, shape)?;
        }
        Ok(())
    }

    /// Converts a shape, an instance or a shape group to a list of shapes with transforms.
    fn placed_shapes(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        shape: &Rc<MitsubaObject>,
        depth: u32,
    ) -> ReadResult<Vec<PlacedShape>> {
        if depth > MAX_SHAPE_DEPTH {
            return Err(shape.place.error("shapes are nested too deep, or contain themselves", "nest them less deep"));
        }
        match shape.plugin.as_str() {
            "instance" => {
                let to_world = to_world_matrix(shape);
                let groups = context.children_of_class(shape, ObjectClass::Shape)?;
                let Some((_, group)) = groups.first() else {
                    return Err(shape.place.error("this instance names no shape group", "refer to one by its id"));
                };
                let members = self.shapes_of_group(context, textures, group, depth)?;
                Ok(members.iter().map(|m| PlacedShape { to_world: to_world * m.to_world, ..m.clone() }).collect())
            }
            "shapegroup" | "merge" => Ok(self.shapes_of_group(context, textures, shape, depth)?.to_vec()),
            _ => self.convert_single_shape(context, textures, shape),
        }
    }

    /// Returns the converted shapes of a `shapegroup` or `merge`. The first call for a group
    /// converts its shapes.
    fn shapes_of_group(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        group: &Rc<MitsubaObject>,
        depth: u32,
    ) -> ReadResult<Rc<Vec<PlacedShape>>> {
        if let Some(known) = self.groups.get(&Rc::as_ptr(group)) {
            return Ok(Rc::clone(known));
        }
        let mut members = Vec::new();
        for (_, shape) in context.children_of_class(group, ObjectClass::Shape)? {
            members.extend(self.placed_shapes(context, textures, &shape, depth + 1)?);
            context.files.check_total_memory(MEMORY_PER_OBJECT * members.len() as u64)?;
        }
        let members = Rc::new(members);
        self.groups.insert(Rc::as_ptr(group), Rc::clone(&members));
        Ok(members)
    }

    /// Converts one shape, which is neither a group nor an instance.
    ///
    /// An OBJ file with several BSDFs becomes one shape for each BSDF.
    fn convert_single_shape(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        shape: &Rc<MitsubaObject>,
    ) -> ReadResult<Vec<PlacedShape>> {
        if !context.children_of_class(shape, ObjectClass::Subsurface)?.is_empty() {
            context.add_note("subsurface scattering is ignored", shape);
        }
        let bsdfs = context.children_of_class(shape, ObjectClass::Bsdf)?;
        if bsdfs.len() > 1 && shape.plugin == "obj" {
            return self.convert_obj_parts(context, textures, shape, &bsdfs);
        }
        if bsdfs.len() > 1 {
            context.add_note("BSDFs of a shape after the first one are ignored", shape);
        }
        let is_mesh = matches!(shape.plugin.as_str(), "obj" | "ply" | "serialized");
        let mesh = is_mesh.then_some(ShapeMesh::File);
        self.convert_surface(context, textures, shape, bsdfs.first().map(|(_, bsdf)| bsdf), mesh)
    }

    /// Converts an OBJ shape with several BSDFs. Each BSDF applies to the faces of the OBJ material
    /// that has the name of the BSDF.
    fn convert_obj_parts(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        shape: &Rc<MitsubaObject>,
        bsdfs: &[(String, Rc<MitsubaObject>)],
    ) -> ReadResult<Vec<PlacedShape>> {
        let names: Vec<&str> = bsdfs.iter().map(|(name, _)| name.as_str()).collect();
        let parts = read_obj_parts(context, shape, &names)?;
        if (0..bsdfs.len()).any(|bsdf| parts.iter().all(|(part_bsdf, _)| *part_bsdf != Some(bsdf))) {
            context.add_note("BSDFs without faces of their name are ignored", shape);
        }
        let mut placed = Vec::new();
        for (bsdf, mesh) in parts {
            let bsdf = bsdf.and_then(|bsdf| bsdfs.get(bsdf)).map(|(_, bsdf)| bsdf);
            if bsdf.is_none() {
                context.add_note("faces without a BSDF of their name become diffuse gray", shape);
            }
            placed.extend(self.convert_surface(context, textures, shape, bsdf, Some(ShapeMesh::Part(mesh)))?);
        }
        Ok(placed)
    }

    /// Converts a shape with at most one BSDF. `mesh` is the mesh of the shape's file; `None` for a
    /// built-in shape, such as a sphere.
    ///
    /// A thin pane around a medium becomes two shapes: the pane, and a null interface inside it.
    /// Returns an empty list for an unsupported kind of shape, and for a null interface that
    /// neither emits nor contains a medium.
    fn convert_surface(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        shape: &Rc<MitsubaObject>,
        bsdf: Option<&Rc<MitsubaObject>>,
        mesh: Option<ShapeMesh>,
    ) -> ReadResult<Vec<PlacedShape>> {
        let medium = match context.named_child(shape, ObjectClass::Medium, "interior")? {
            Some(medium) => Some(self.media.medium_name(context, &medium)?.value),
            None => None,
        };
        let convention = match &mesh {
            Some(_) => file_texcoord_convention(shape),
            None => built_in_texcoord_convention(shape),
        };
        let emission = self.shape_emission(context, textures, shape, convention)?;
        let inputs =
            ShapeMaterialInputs { medium: medium.clone(), emission_texture: emission.texture.clone(), convention };
        let material = self.materials.imported_material(context, textures, bsdf, &inputs)?;
        let texcoords = material.may_be_textured.then_some(convention);
        let mesh = match mesh {
            Some(ShapeMesh::File) => Some(self.meshes.embed_mesh_file(context, shape, texcoords)?),
            Some(ShapeMesh::Part(part)) => Some(self.meshes.embed_mesh_part(context, shape, part, texcoords)?),
            None => None,
        };
        let Some(ShapeGeometry { surface, to_world, local_bounds: bounds }) =
            self.shape_geometry(context, shape, mesh.as_deref(), material.may_be_textured, material.boundary)?
        else {
            return Ok(Vec::new());
        };
        let (mut name, boundary) = (material.name, material.boundary);
        if boundary == MaterialBoundary::Null && emission.radiance.is_some() {
            context.add_note("emitters without a surface become black", shape);
            name = self.materials.black_material_name();
        } else if boundary == MaterialBoundary::Null && medium.is_none() {
            return Ok(Vec::new());
        }
        let place = |material: String, shape, emission| PlacedShape {
            material,
            shape,
            emission,
            to_world,
            local_bounds: bounds,
        };
        let mut placed = vec![place(name, surface.clone(), emission.radiance)];
        if let (MaterialBoundary::Pane, Some(medium)) = (boundary, medium) {
            let interface = self.materials.null_interface_name(&medium);
            let inner = self.shrunken_shape(surface);
            placed.push(place(interface, inner, None));
        }
        Ok(placed)
    }

    /// Returns the emission of a shape, from its first nested emitter.
    ///
    /// An emitter of another kind than `area` is ignored, and a message tells the user.
    fn shape_emission(
        &mut self,
        context: &ImportContext<'_>,
        textures: &mut MitsubaTextures,
        shape: &MitsubaObject,
        convention: TexcoordConvention,
    ) -> ReadResult<MitsubaShapeEmission> {
        let emitters = context.children_of_class(shape, ObjectClass::Emitter)?;
        let Some((_, emitter)) = emitters.first() else { return Ok(MitsubaShapeEmission::default()) };
        if emitter.plugin != "area" {
            let message = format!("emitters of kind `{}` on surfaces are ignored", emitter.plugin);
            context.add_whole_object_note(&message, emitter);
            return Ok(MitsubaShapeEmission::default());
        }
        let texture_use = (MitsubaTextureUse::Radiance, convention);
        Ok(match textures.convert_texture_parameter(context, emitter, ("radiance", 1.0), texture_use, 1.0)? {
            ConvertedTexture::Constant(radiance) => {
                let radiance = Some(radiance).filter(|radiance| *radiance != DVec3::ZERO);
                self.has_emissive_surfaces |= radiance.is_some();
                MitsubaShapeEmission { radiance, texture: None }
            }
            ConvertedTexture::Texture(name, _) => {
                self.has_emissive_surfaces = true;
                MitsubaShapeEmission { radiance: None, texture: Some((name, 1.0)) }
            }
        })
    }

    /// Returns the geometry and transform of a shape; `None` if its kind is not supported.
    ///
    /// `mesh` is the path of the embedded mesh of the shape's file; `None` for a built-in shape.
    /// `is_textured` is true if the material may have textures. `boundary` is the kind of boundary
    /// that the material makes.
    fn shape_geometry(
        &mut self,
        context: &ImportContext<'_>,
        shape: &MitsubaObject,
        mesh: Option<&str>,
        is_textured: bool,
        boundary: MaterialBoundary,
    ) -> ReadResult<Option<ShapeGeometry>> {
        let mut to_world = to_world_matrix(shape);
        if let Some(path) = mesh {
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let positions = self.meshes.embedded.get(path).into_iter().flat_map(|mesh| &mesh.positions);
            let bounds = positions.fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
            return Ok(Some(ShapeGeometry { surface: mesh_shape(path.to_owned()), to_world, local_bounds: bounds }));
        }
        let flips_normals = shape.boolean("flip_normals", false);
        let cube_bounds = (DVec3::splat(-1.0), DVec3::ONE);
        let square_bounds = (DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0));
        let radius = |default: f64| {
            let radius = shape.number("radius").unwrap_or(default);
            let invalid = || shape.place.error("the radius of this shape is not above 0", "correct `radius`");
            if radius > 0.0 && radius < 1e30 { Ok(radius) } else { Err(invalid()) }
        };
        let (surface, bounds) = match shape.plugin.as_str() {
            "sphere" => {
                let center = shape.vector("center").unwrap_or(DVec3::ZERO);
                let radius = radius(1.0)?;
                to_world *= DAffine3::from_translation(center);
                let is_inward = flips_normals && boundary != MaterialBoundary::Null;
                if is_inward {
                    context.add_note("spheres with flipped normals become meshes of 65,000 triangles", shape);
                    to_world *= DAffine3::from_scale(DVec3::splat(radius));
                    (mesh_shape(self.meshes.inward_sphere_path()), cube_bounds)
                } else {
                    if is_textured {
                        // Rotate the sphere, because Caustica's texture coordinates on spheres use
                        // other axes than Mitsuba's.
                        let columns = [DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y];
                        let inverse = glam::DMat3::from_cols(columns[0], columns[1], columns[2]).transpose();
                        to_world *= DAffine3::from_mat3(inverse);
                    }
                    (
                        ShapeDescription::Sphere(SphereDescription { center: DVec3::ZERO, radius }),
                        (cube_bounds.0 * radius, cube_bounds.1 * radius),
                    )
                }
            }
            "rectangle" => {
                // A rectangle with flipped normals keeps the direction of u, and reverses that of
                // v.
                let side = if flips_normals { -1.0 } else { 1.0 };
                let (corner, edge0) = (DVec3::new(-1.0, -side, 0.0), DVec3::new(2.0, 0.0, 0.0));
                let edge1 = DVec3::new(0.0, 2.0 * side, 0.0);
                (ShapeDescription::Rectangle(RectangleDescription { corner, edge0, edge1 }), square_bounds)
            }
            "disk" => {
                if is_textured {
                    context.add_note("textures lie flat on disks instead of by radius and angle", shape);
                }
                let normal = if flips_normals { DVec3::NEG_Z } else { DVec3::Z };
                (ShapeDescription::Disc(DiscDescription { center: DVec3::ZERO, normal, radius: 1.0 }), square_bounds)
            }
            "cylinder" => {
                if is_textured {
                    context.add_note("textures lie on cylinders by our coordinates instead of Mitsuba's", shape);
                }
                if flips_normals {
                    context.add_note("flipped normals of cylinders are ignored", shape);
                }
                let ends = [shape.vector("p0").unwrap_or(DVec3::ZERO), shape.vector("p1").unwrap_or(DVec3::Z)];
                let radius = radius(1.0)?;
                if ends[0] == ends[1] {
                    return Err(shape.place.error("both ends of this cylinder are the same point", "move one of them"));
                }
                let bounds = (ends[0].min(ends[1]) - radius, ends[0].max(ends[1]) + radius);
                (ShapeDescription::Cylinder(CylinderDescription { ends, radius, is_capped: false }), bounds)
            }
            "cube" if is_textured || flips_normals => {
                if flips_normals {
                    context.add_note("flipped normals of cubes are ignored", shape);
                }
                (mesh_shape(self.meshes.cube_path()), cube_bounds)
            }
            "cube" => (ShapeDescription::Box(BoxDescription { min: cube_bounds.0, max: cube_bounds.1 }), cube_bounds),
            other => {
                context.add_whole_object_note(&format!("shapes of kind `{other}` are left out"), shape);
                return Ok(None);
            }
        };
        Ok(Some(ShapeGeometry { surface, to_world, local_bounds: bounds }))
    }

    /// Returns a slightly smaller copy of `shape`, just inside it.
    ///
    /// Only meshes, spheres and boxes become smaller. Other shapes enclose no volume, and are
    /// returned unchanged. The smaller copy of a mesh is embedded.
    fn shrunken_shape(&mut self, shape: ShapeDescription) -> ShapeDescription {
        const SHRINK_FACTOR: f64 = 1.0 - 1e-4;
        match shape {
            ShapeDescription::Mesh(MeshDescription { path, options }) => {
                let inner = self.meshes.embed_shrunken_copy(&path.value);
                ShapeDescription::Mesh(MeshDescription { path: Spanned::new(inner, Span::default()), options })
            }
            ShapeDescription::Sphere(SphereDescription { center, radius }) => {
                ShapeDescription::Sphere(SphereDescription { center, radius: radius * SHRINK_FACTOR })
            }
            ShapeDescription::Box(BoxDescription { min, max }) => {
                ShapeDescription::Box(BoxDescription { min: min * SHRINK_FACTOR, max: max * SHRINK_FACTOR })
            }
            // Discs, rectangles and open cylinders enclose no volume.
            sheet => sheet,
        }
    }

    /// Adds a shape to the imported scene. `source` is the shape's object in the Mitsuba file.
    ///
    /// A shape with a singular transform is left out, and a message tells the user.
    fn push_shape(
        &mut self,
        context: &ImportContext<'_>,
        placed: PlacedShape,
        source: &MitsubaObject,
    ) -> ReadResult<()> {
        let PlacedShape { material, shape, emission, to_world, local_bounds } = placed;
        if Transform::new(to_world).is_err() {
            context.add_note("objects that are scaled to nothing are left out", source);
            return Ok(());
        }
        let objects = self.root.items.len() as u64 / 2 + 1;
        context.files.check_total_memory(MEMORY_PER_OBJECT * objects)?;
        self.world_bounds = Some(extended_bounds(self.world_bounds, &to_world, local_bounds));
        let object = placed_object(shape, emission, to_world);
        self.root.items.push(GroupItem::MaterialName(Spanned::new(material, Span::default())));
        self.root.items.push(GroupItem::Object(Spanned::new(object, Span::default())));
        Ok(())
    }
}

/// Returns the texture-coordinate convention of a shape without a mesh file, such as a sphere:
/// whether v in Caustica equals v in Mitsuba, or is 1 minus it.
fn built_in_texcoord_convention(shape: &MitsubaObject) -> TexcoordConvention {
    match shape.plugin.as_str() {
        "sphere" => TexcoordConvention::FlippedV,
        "rectangle" if shape.boolean("flip_normals", false) => TexcoordConvention::FlippedV,
        _ => TexcoordConvention::Same,
    }
}

fn mesh_shape(path: String) -> ShapeDescription {
    ShapeDescription::Mesh(MeshDescription {
        path: Spanned::new(path, Span::default()),
        options: MeshOptions::default(),
    })
}

fn to_world_matrix(shape: &MitsubaObject) -> DAffine3 {
    DAffine3::from_mat4(shape.transform("to_world").unwrap_or(DMat4::IDENTITY))
}
