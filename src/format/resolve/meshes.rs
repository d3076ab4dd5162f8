//! Adds meshes from files: each file is read once, smoothed on request, and split by material.

use super::placement::{Instanced, Placing, place_instance, place_mesh, set_mapping, set_texcoords};
use super::textures::TextureNeeds;
use super::{Resolver, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{
    EmissionDescription, MaterialDescription, MaterialKindDescription, MeshOptions, Spanned,
};
use crate::format::mesh::{self, LoadedMesh, MeshError, NO_MATERIAL, TriangleMesh};
use crate::format::mtl;
use crate::shape::MappingKind;
use crate::stats::format_bytes;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Copies of a mesh share its triangles if that saves at least this many.
const WORTH_SHARING: usize = 50_000;

const REPAIR: &str = "repair the mesh or name another";

/// Bytes per placed triangle while its hierarchy is built, including its share of vertices.
///
/// Measured: 436 to 482, on grids of a million triangles with normals and texture coordinates.
const PER_TRIANGLE: u64 = 500;

/// A file with the options of its use; the smoothing angle as its bits.
pub(super) type MeshKey = (PathBuf, bool, bool, Option<u64>);

/// Parts of a mesh, one for each material.
pub(super) struct Pieces {
    list: Vec<Piece>,
}

struct Piece {
    mesh: Rc<TriangleMesh>,
    /// The file's own material; `None` for the scene's.
    own: Option<MtlMaterial>,
}

/// A material of a mesh file.
#[derive(Clone, Debug)]
pub(super) struct MtlMaterial {
    name: Rc<str>,
    index: u32,
    emission: Rgb,
}

/// Adds the mesh of a file.
pub(super) fn add_mesh(
    r: &mut Resolver<'_>,
    placing: &Placing<'_>,
    path: &Spanned<String>,
    options: MeshOptions,
) -> Result<(), SceneError> {
    let pieces = mesh_pieces(r, path, options)?;
    let again = r.uses.get(path.as_str()).map_or(0, |n| n - 1);
    let in_force = r.material;
    for Piece { mesh, own } in &pieces.list {
        let emission = match own {
            Some(own) if !placing.emission.of_object => own.emission,
            _ => placing.emission.radiance,
        };
        r.material = own.as_ref().map_or(in_force, |own| own.index);
        let name = own.as_ref().map(|own| &*own.name);
        r.check_coordinates(mesh.texcoords.is_some(), path, name)?;
        add_piece(r, path, placing, mesh, again, emission)?;
        if let (Some((texture, scale)), None) = (placing.emission.texture, own) {
            r.builder.emission_texture(texture, scale);
        }
    }
    r.material = in_force;
    Ok(())
}

/// Adds triangles of the material in force; the scene has `again` more copies of them.
fn add_piece(
    r: &mut Resolver<'_>,
    path: &Spanned<String>,
    placing: &Placing<'_>,
    mesh: &Rc<TriangleMesh>,
    again: usize,
    emission: Rgb,
) -> Result<(), SceneError> {
    let (normals, texcoords) = (mesh.normals.as_deref(), mesh.texcoords.as_deref());
    let shared = emission == Rgb::ZERO && again * mesh.triangles.len() >= WORTH_SHARING;
    let instanced = shared || !placing.to_world.is_constant();
    // Copies that share their triangles share the tree over them.
    if !(instanced && r.instanced.contains_key(&Rc::as_ptr(mesh))) {
        check_trees(r, path, mesh.triangles.len())?;
    }
    if instanced {
        let instance = r
            .instanced
            .entry(Rc::as_ptr(mesh))
            .or_insert_with(|| Rc::new(Instanced::new(&mesh.positions, normals, texcoords, &mesh.triangles)));
        let instance = Rc::clone(instance);
        place_instance(r, &instance, placing.to_world, placing.map, placing.span, emission)?;
    } else {
        place_mesh(r, placing.map, &mesh.positions, normals, &mesh.triangles, emission);
        set_texcoords(r, texcoords);
    }
    set_mapping(r, MappingKind::Uv, placing.to_world);
    Ok(())
}

/// Counts triangles towards the memory limit; refuses the mesh if they exceed it.
fn check_trees(r: &mut Resolver<'_>, path: &Spanned<String>, triangles: usize) -> Result<(), SceneError> {
    r.triangles += triangles as u64;
    let needed = PER_TRIANGLE * r.triangles;
    let Some(free) = r.memory.available_bytes().filter(|free| needed > *free) else { return Ok(()) };
    let (needed, free) = (format_bytes(needed), format_bytes(free));
    let message = format!(
        "the scene has {} triangles with this mesh, which take {needed} of memory, and {free} are free",
        r.triangles
    );
    let help = "simplify meshes, or let the scene have more memory (--memory)";
    Err(r.bad_file(path, &message, help).marked_out_of_memory())
}

/// Returns the parts of the mesh of a path, read once.
fn mesh_pieces(r: &mut Resolver<'_>, path: &Spanned<String>, options: MeshOptions) -> Result<Rc<Pieces>, SceneError> {
    let file = r.file("mesh", path)?;
    let MeshOptions { uses_file_materials, ignores_normals, max_smoothing_angle } = options;
    let key = (file.clone(), uses_file_materials, ignores_normals, max_smoothing_angle.map(f64::to_bits));
    if let Some(pieces) = r.meshes.get(&key) {
        return Ok(pieces.clone());
    }
    let loaded = match r.assets.meshes.get(path.as_str()) {
        Some(mesh) => Ok(LoadedMesh { mesh: (**mesh).clone(), ..LoadedMesh::default() }),
        None => mesh::load_with_memory_limit(&file, r.monitor, r.memory.available_bytes()),
    };
    let mut loaded = loaded.map_err(|e| r.refuse_file(path, &e, matches!(e, MeshError::Memory { .. }), REPAIR))?;
    if ignores_normals {
        loaded.mesh.normals = None;
    }
    if let Some(angle) = max_smoothing_angle {
        loaded.mesh.compute_smooth_normals(angle);
    }
    let mut list = Vec::new();
    if uses_file_materials && !loaded.mesh.materials.is_empty() {
        let own = mesh_materials(r, path, &file, &loaded)?;
        for (number, part) in loaded.mesh.split_by_material() {
            let own = own.get(number as usize).cloned().filter(|_| number != NO_MATERIAL);
            list.push(Piece { mesh: Rc::new(part), own });
        }
    } else {
        list.push(Piece { mesh: Rc::new(loaded.mesh), own: None });
    }
    let pieces = Rc::new(Pieces { list });
    r.meshes.insert(key, pieces.clone());
    Ok(pieces)
}

/// Returns the materials that the mesh of a file names.
fn mesh_materials(
    r: &mut Resolver<'_>,
    path: &Spanned<String>,
    file: &Path,
    loaded: &LoadedMesh,
) -> Result<Rc<Vec<MtlMaterial>>, SceneError> {
    if let Some(own) = r.own_materials.get(file) {
        return Ok(own.clone());
    }
    let library = mtl::load_mesh_materials(file, loaded, r.memory.available_bytes());
    let library = library.map_err(|e| r.refuse_file(path, &e, matches!(e, MeshError::Memory { .. }), REPAIR))?;
    let mut own = Vec::with_capacity(library.len());
    for found in library {
        let bad = |(message, remedy)| MeshError::BadMaterial { path: file.into(), message, remedy };
        let meaning = found.to_description().map_err(|e| r.bad_file(path, &bad(e), REPAIR))?;
        own.push(own_material(r, path, meaning)?);
    }
    let own = Rc::new(own);
    r.own_materials.insert(file.to_owned(), own.clone());
    Ok(own)
}

/// Adds a material of a mesh file; errors have the position of the mesh's path.
fn own_material(
    r: &mut Resolver<'_>,
    path: &Spanned<String>,
    mut meaning: MaterialDescription,
) -> Result<MtlMaterial, SceneError> {
    if let MaterialKindDescription::Phong { texture: Some(picture), .. } = &mut meaning.kind {
        picture.span = path.span;
    }
    let mut needs = TextureNeeds::default();
    let material = r.material(&meaning.kind, &mut needs)?;
    let normals = r.normals(&meaning, &mut needs)?;
    let index = r.builder.material(material.with_normal_perturbation(normals));
    r.texture_needs.resize(index as usize + 1, TextureNeeds::default());
    r.texture_needs[index as usize] = needs;
    let emission = match meaning.emission {
        Some(EmissionDescription::Radiance(radiance)) => rgb(radiance),
        _ => Rgb::ZERO,
    };
    Ok(MtlMaterial { name: meaning.name.unwrap_or_default().into(), index, emission })
}
