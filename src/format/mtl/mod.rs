//! Reads and writes MTL files, the material files of OBJ meshes. Converts their materials to those
//! of the scene language.
//!
//! Submodule `check` checks each line; the crate `tobj` parses the valid lines.

mod check;
#[cfg(test)]
mod tests;
mod to_description;
mod write;

use super::line_error::strip_byte_order_mark;
use super::mesh::{MeshError, check_memory, read_file_bytes};
use glam::DVec3;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
pub use write::write;

/// Upper bound of the memory for parsing an MTL file \[bytes per byte of the file].
///
/// Measured worst case: 76, for a file that consists of lines `newmtl a`.
const MEMORY_PER_FILE_BYTE: u64 = 100;

/// Material of an MTL file. A property that the file does not define is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlMaterial {
    /// Name that the `usemtl` lines of the mesh file refer to.
    pub name: String,
    /// Diffuse reflectance (Kd).
    pub diffuse: Option<DVec3>,
    /// Specular reflectance (Ks).
    pub specular: Option<DVec3>,
    /// Emitted radiance (Ke).
    pub emission: Option<DVec3>,
    /// Transmittance color (Tf).
    pub transmission_filter: Option<DVec3>,
    /// Phong exponent of the highlight (Ns).
    pub shininess: Option<f64>,
    /// Opacity (d, or 1 − Tr): 1 is opaque.
    pub opacity: Option<f64>,
    /// Index of refraction (Ni).
    pub refractive_index: Option<f64>,
    /// Number of the illumination model (illum).
    pub illumination_model: Option<u8>,
    /// Path of the picture that multiplies Kd (map_Kd), joined to the folder of the MTL file.
    pub diffuse_texture_path: Option<PathBuf>,
}

/// Returns the paths of the MTL files of a mesh, in the order of `libraries`.
///
/// [`load_mtl_files`] explains the arguments.
pub(super) fn mtl_file_paths(mesh: &Path, libraries: &[String]) -> Vec<PathBuf> {
    let folder = mesh.parent().unwrap_or(Path::new(""));
    let paths = |library: &String| {
        let whole = folder.join(path_with_slashes(library));
        match whole.is_file() {
            true => vec![whole],
            false => library.split_whitespace().map(|part| folder.join(path_with_slashes(part))).collect(),
        }
    };
    libraries.iter().flat_map(paths).collect()
}

/// Returns the materials of all MTL files of a mesh, in the order of `libraries`.
///
/// `mesh` is the path of the mesh file, and `libraries` holds the arguments of its `mtllib` lines.
/// An argument that is not the path of a file is a list of paths, separated by spaces. If a
/// material is defined repeatedly, the last definition counts. Fails if reading or parsing a file
/// would take more than `free` bytes; `None` sets no limit.
///
/// # Errors
/// [`MeshError`], which names the file.
pub fn load_mtl_files(mesh: &Path, libraries: &[String], free: Option<u64>) -> Result<Vec<MtlMaterial>, MeshError> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    for path in mtl_file_paths(mesh, libraries) {
        let bytes = read_file_bytes(&path, free).map_err(|e| match e {
            MeshError::MissingMeshFile { path } => MeshError::MissingMtlFile { path },
            other => other,
        })?;
        check_memory(&path, MEMORY_PER_FILE_BYTE * bytes.len() as u64, free)?;
        materials.extend(decode(&path, &bytes)?);
    }
    let mut names = HashSet::new();
    let mut last: Vec<bool> = materials.iter().rev().map(|material| names.insert(material.name.clone())).collect();
    materials.retain(|_| last.pop().unwrap_or_default());
    Ok(materials)
}

/// Returns the materials of a mesh that have these `names`, in this order.
///
/// `path` is the path of the mesh file. [`load_mtl_files`] explains `libraries` and `free`.
///
/// # Errors
/// [`MeshError`] if a material file is missing or invalid, or if a material is not defined.
pub fn load_mesh_materials(
    path: &Path,
    libraries: &[String],
    names: &[String],
    free: Option<u64>,
) -> Result<Vec<MtlMaterial>, MeshError> {
    let library = load_mtl_files(path, libraries, free)?;
    let by_name: HashMap<&str, &MtlMaterial> = library.iter().map(|m| (m.name.as_str(), m)).collect();
    let find = |name: &String| {
        let none = || MeshError::UndefinedMaterial { path: path.into(), name: name.clone() };
        by_name.get(name.as_str()).map(|material| (*material).clone()).ok_or_else(none)
    };
    names.iter().map(find).collect()
}

/// Parses the bytes of an MTL file, whose path is `path`.
///
/// Errors name this path. Relative paths of pictures are joined to the folder of `path`.
///
/// # Errors
/// [`MeshError`].
pub fn decode(path: &Path, bytes: &[u8]) -> Result<Vec<MtlMaterial>, MeshError> {
    let valid_lines = check::check_and_rewrite_mtl(&String::from_utf8_lossy(strip_byte_order_mark(bytes)))
        .map_err(|(line, problem)| MeshError::error_at_line(path, line, problem))?;
    let malformed = |source| MeshError::RejectedByTobj { path: path.into(), source };
    let (materials, _) = tobj::load_mtl_buf(&mut valid_lines.as_bytes()).map_err(malformed)?;
    let vector = |v: Option<[f64; 3]>| v.map(DVec3::from_array);
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(materials
        .into_iter()
        .map(|m| MtlMaterial {
            diffuse: vector(m.diffuse),
            specular: vector(m.specular),
            emission: vector(m.emissive),
            // `tobj` keeps `Tf` as text. The check has rewritten it as three numbers.
            transmission_filter: m.unknown_param.get("Tf").map(|text| {
                let mut numbers = text.split(' ').map(|word| word.parse().unwrap_or_default());
                DVec3::from_array([(); 3].map(|()| numbers.next().unwrap_or_default()))
            }),
            shininess: m.shininess,
            opacity: m.dissolve,
            refractive_index: m.optical_density,
            illumination_model: m.illumination_model,
            diffuse_texture_path: m.diffuse_texture.map(|picture| folder.join(path_with_slashes(&picture))),
            name: m.name,
        })
        .collect())
}

/// Returns the path with backslashes replaced by slashes, which all systems accept as separators.
fn path_with_slashes(path: &str) -> PathBuf {
    PathBuf::from(path.replace('\\', "/"))
}
