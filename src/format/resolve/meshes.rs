//! Adds meshes from files. Each file is read once, given smooth normals if requested, and split by
//! material.

use super::placement::{
    ObjectEmission, ObjectPlacement, add_instance, add_still_mesh, set_emission_texture, set_texcoords_if_needed,
    set_texture_mapping_if_needed,
};
use super::scene_meshes::{MeshSource, PreparedMesh, PreparedPart, mesh_key};
use super::textures::TextureRequirements;
use super::{AddedMaterial, Resolver, rgb};
use crate::color::Rgb;
use crate::format::materials::{EmissionDescription, MaterialDescription, MaterialKindDescription};
use crate::format::mesh::{self, LoadedMesh, MeshError, MeshOptions};
use crate::format::span::Spanned;
use crate::format::{FileStamp, SceneError, mtl};
use crate::shape::TextureMappingKind;
use crate::stats::format_bytes;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

/// Smallest number of triangles that instancing must save to be used for meshes at rest. Below this
/// number, each use of a mesh gets its own copy of the triangles.
const MIN_TRIANGLES_INSTANCING_SAVES: usize = 50_000;

const MESH_REMEDY: &str = "repair the mesh or name another";

/// Peak memory per triangle while the scene's BVH is built \[bytes], including vertices.
///
/// Measured: 436 to 482, for grids of a million triangles with normals and texture coordinates.
const MEMORY_PER_TRIANGLE: u64 = 500;

/// Triangles of a mesh file that share a material, with that material.
pub(in crate::format) struct MeshPart {
    prepared: Arc<PreparedPart>,
    /// Material from the MTL file of the mesh; `None` for the material that the scene text sets.
    file_material: Option<AddedMeshFileMaterial>,
}

/// Material of an MTL file that was added to the scene: its name, its index in the scene, and the
/// radiance that it emits.
#[derive(Clone, Debug)]
pub(in crate::format) struct AddedMeshFileMaterial {
    name: Rc<str>,
    index: u32,
    emission: Rgb,
}

/// Adds the mesh of a file to the scene.
///
/// The mesh becomes one object. If `options` select the file's materials, it becomes one object for
/// each material.
pub(in crate::format) fn add_mesh(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    path: &Spanned<String>,
    options: MeshOptions,
    object_emission: &ObjectEmission,
) -> Result<(), SceneError> {
    let parts = load_mesh_parts(r, path, options)?;
    let current_material = r.current_material_index;
    let added = parts.iter().try_for_each(|part| {
        let material = part.file_material.as_ref().map_or(current_material, |material| material.index);
        r.current_material_index = material;
        add_file_part(r, placement, path, part, object_emission)
    });
    // The parts of the mesh changed the current material. Restore it for later objects.
    r.current_material_index = current_material;
    added
}

/// Adds one part of a mesh file: all its triangles, or those of one material. The caller has made
/// the part's material the current material of `r`.
fn add_file_part(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    path: &Spanned<String>,
    MeshPart { prepared, file_material }: &MeshPart,
    object_emission: &ObjectEmission,
) -> Result<(), SceneError> {
    let emission = match file_material {
        Some(material) if !object_emission.is_set_on_object => material.emission,
        _ => object_emission.radiance,
    };
    let name = file_material.as_ref().map(|material| &*material.name);
    r.require_texcoords(prepared.mesh.texcoords.is_some(), path, name)?;
    add_mesh_part(r, placement, path, prepared, emission)?;
    if file_material.is_none() {
        set_emission_texture(r, object_emission);
    }
    Ok(())
}

/// Adds a mesh with the material at `r.current_material_index` and the emitted radiance `emission`.
///
/// The mesh becomes an instance if it moves. It also becomes one if it emits nothing and instancing
/// saves at least [`MIN_TRIANGLES_INSTANCING_SAVES`] triangles.
fn add_mesh_part(
    r: &mut Resolver<'_>,
    placement: &ObjectPlacement<'_>,
    path: &Spanned<String>,
    part: &PreparedPart,
    emission: Rgb,
) -> Result<(), SceneError> {
    let mesh = &*part.mesh;
    let (normals, texcoords) = (mesh.normals.as_deref(), mesh.texcoords.as_deref());
    let further_copies = r.mesh_use_counts.get(path.as_str()).map_or(0, |uses| uses - 1);
    let is_shared = emission == Rgb::ZERO && further_copies * mesh.triangles.len() >= MIN_TRIANGLES_INSTANCING_SAVES;
    let is_instance = is_shared || !placement.to_world.is_constant();
    // Instances of one mesh share one BVH, so only the first instance takes memory for it.
    if !(is_instance && part.has_bvh()) {
        claim_triangle_memory(r, path, mesh.triangles.len())?;
    }
    if is_instance {
        add_instance(r, placement, part.normalized_mesh(), emission)?;
    } else {
        add_still_mesh(r, &placement.to_world_at_open, &mesh.positions, normals, &mesh.triangles, emission);
        set_texcoords_if_needed(r, texcoords);
    }
    set_texture_mapping_if_needed(r, TextureMappingKind::Uv, placement.to_world);
    Ok(())
}

/// Adds `triangles`, a number of triangles, to [`Resolver::bvh_triangle_count`]. Fails if building
/// BVHs over the sum would exceed the memory limit.
fn claim_triangle_memory(r: &mut Resolver<'_>, path: &Spanned<String>, triangles: usize) -> Result<(), SceneError> {
    r.bvh_triangle_count += triangles as u64;
    let needed = MEMORY_PER_TRIANGLE * r.bvh_triangle_count;
    let Some(free) = r.memory.available_bytes().filter(|free| needed > *free) else { return Ok(()) };
    let (needed, free) = (format_bytes(needed), format_bytes(free));
    let message = format!(
        "the scene has {} triangles with this mesh, which take {needed} of memory, and {free} are free",
        r.bvh_triangle_count
    );
    let help = "simplify meshes, or let the scene have more memory (--memory)";
    Err(r.file_error(path, &message, help).marked_out_of_memory())
}

/// Returns the triangles of the mesh at `path`, split by material if `options` select the file's
/// materials. Uses of one file with the same options share one reading of the file.
fn load_mesh_parts(
    r: &mut Resolver<'_>,
    path: &Spanned<String>,
    options: MeshOptions,
) -> Result<Rc<[MeshPart]>, SceneError> {
    let file = r.find_file("mesh", path)?;
    let key = mesh_key(&file, options);
    if let Some(parts) = r.mesh_parts.get(&key) {
        return Ok(parts.clone());
    }
    let prepared = prepare_mesh(r, path, &file, options)?;
    let materials = match prepared.material_names.is_empty() {
        true => Rc::default(),
        false => add_mesh_file_materials(r, path, &file, &prepared)?,
    };
    let part = |prepared: &Arc<PreparedPart>| MeshPart {
        file_material: prepared.material.and_then(|index| materials.get(index).cloned()),
        prepared: prepared.clone(),
    };
    let parts: Rc<[MeshPart]> = prepared.parts.iter().map(part).collect();
    r.scene_meshes.insert(key.clone(), prepared);
    r.mesh_parts.insert(key, parts.clone());
    Ok(parts)
}

/// Returns the mesh in `file`, which the description names as `path`. If the mesh was read for the
/// previous version of the scene and has not changed, returns that mesh instead of reading the
/// file.
fn prepare_mesh(
    r: &Resolver<'_>,
    path: &Spanned<String>,
    file: &Path,
    options: MeshOptions,
) -> Result<Arc<PreparedMesh>, SceneError> {
    let embedded = r.assets.meshes.get(path.as_str());
    let source = match embedded {
        Some(mesh) => MeshSource::Embedded(mesh.clone()),
        None => MeshSource::File(FileStamp::of_file(file)),
    };
    let earlier = r.earlier_meshes.and_then(|meshes| meshes.find_unchanged(&mesh_key(file, options), &source));
    if let Some(prepared) = earlier {
        return Ok(prepared);
    }
    let (mesh, libraries) = match embedded {
        Some(mesh) => (mesh.clone(), Vec::new()),
        None => {
            let LoadedMesh { mesh, mtllib_arguments: libraries, .. } =
                mesh::load_with_memory_limit(file, r.monitor, r.memory.available_bytes())
                    .map_err(|e| mesh_error_at_path(r, path, &e))?;
            (Arc::new(mesh), libraries)
        }
    };
    Ok(Arc::new(PreparedMesh::new(mesh, libraries, source, options)))
}

/// Adds to the scene the materials that a mesh file uses, as its MTL files define them. A repeated
/// call for the same file adds nothing.
///
/// Returns the materials in the order of the mesh's material indices.
fn add_mesh_file_materials(
    r: &mut Resolver<'_>,
    path: &Spanned<String>,
    file: &Path,
    mesh: &PreparedMesh,
) -> Result<Rc<[AddedMeshFileMaterial]>, SceneError> {
    if let Some(materials) = r.mesh_file_materials.get(file) {
        return Ok(materials.clone());
    }
    mtl::mtl_file_paths(file, &mesh.mtllib_arguments).iter().for_each(|library| r.monitor.on_input_file_found(library));
    let library =
        mtl::load_mesh_materials(file, &mesh.mtllib_arguments, &mesh.material_names, r.memory.available_bytes())
            .map_err(|e| mesh_error_at_path(r, path, &e))?;
    let mut materials = Vec::with_capacity(library.len());
    for material in library {
        let bad = |(message, remedy)| MeshError::UnconvertibleMaterial { path: file.into(), message, remedy };
        let description = material.to_description().map_err(|e| r.file_error(path, &bad(e), MESH_REMEDY))?;
        materials.push(add_mesh_file_material(r, path, description)?);
    }
    let materials: Rc<[AddedMeshFileMaterial]> = materials.into();
    r.mesh_file_materials.insert(file.to_owned(), materials.clone());
    Ok(materials)
}

/// Adds a material from the MTL file of a mesh to the scene.
///
/// Errors point to the place in the scene text that names the mesh file.
fn add_mesh_file_material(
    r: &mut Resolver<'_>,
    path: &Spanned<String>,
    mut description: MaterialDescription,
) -> Result<AddedMeshFileMaterial, SceneError> {
    if let MaterialKindDescription::Phong(phong) = &mut description.kind
        && let Some(picture) = &mut phong.texture
    {
        picture.span = path.span;
    }
    let mut requirements = TextureRequirements::default();
    let material = description.kind.resolve(r, &mut requirements)?;
    debug_assert!(r.material_parts.list.is_empty(), "files of meshes define no materials with parts");
    let normals = description.resolve_normal_perturbation(r, &mut requirements)?;
    let index = r.builder.add_material(material.with_normal_perturbation(normals));
    r.materials.resize(index as usize + 1, AddedMaterial::default());
    r.materials[index as usize].texture_requirements = requirements;
    let emission = match description.emission {
        Some(EmissionDescription::Constant(radiance)) => rgb(radiance),
        // Emission from an MTL file never has a texture.
        Some(EmissionDescription::Texture { .. }) | None => Rgb::ZERO,
    };
    Ok(AddedMeshFileMaterial { name: description.name.unwrap_or_default().into(), index, emission })
}

fn mesh_error_at_path(r: &Resolver<'_>, path: &Spanned<String>, error: &MeshError) -> SceneError {
    r.file_or_memory_error(path, error, matches!(error, MeshError::OutOfMemory { .. }), MESH_REMEDY)
}
