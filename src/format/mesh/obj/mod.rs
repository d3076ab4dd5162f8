//! Reading and writing of triangle meshes as Wavefront OBJ files.
//!
//! Submodule `check` checks each line, and crate `tobj` parses the valid lines. `tobj` alone
//! reports no line numbers and stops at comments that are not UTF-8. It assigns normals to wrong
//! vertices if only some faces have them, and overflows on invalid indices.

mod check;
#[cfg(test)]
mod tests;
mod write;

use super::{LoadedMesh, MeshError, MeshReadMonitor, NO_MATERIAL, TriangleMesh, check_memory, unit_normal};
use check::CheckedObjFile;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::io::{BufRead, Read};
use std::path::Path;
pub(super) use write::write;

/// Memory per coordinate \[bytes]: 8 each in a list of `tobj`, in the mesh that `tobj` returns, and
/// in [`TriangleMesh`].
const MEMORY_PER_COORDINATE: u64 = 8 * 3;

/// Memory per corner of a face \[bytes]: 24 for three indices in `tobj`, 4 for an index in the mesh
/// that `tobj` returns, and 4 for an index in [`TriangleMesh`].
const MEMORY_PER_CORNER: u64 = 32;

/// Reads a mesh from the bytes of an OBJ file. Ignores line and point elements, groups and object
/// names.
///
/// `path` appears in errors only. Fails before allocating if the mesh takes more than `free` bytes.
pub(super) fn read(
    path: &Path,
    bytes: Vec<u8>,
    monitor: &dyn MeshReadMonitor,
    free: Option<u64>,
) -> Result<LoadedMesh, MeshError> {
    // Comments and names may be in another encoding than UTF-8, so invalid bytes are replaced.
    let length = bytes.len() as u64;
    check_memory(path, length, free)?;
    let text = String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
    let checked = check::check_and_rewrite_obj(text.strip_prefix('\u{feff}').unwrap_or(&text), monitor)
        .map_err(|e| MeshError::error_at_line(path, e.line, e.defect))?;
    drop(text);
    // The original text is freed. The following steps take less memory than the text took.
    check_memory(
        path,
        MEMORY_PER_COORDINATE * checked.coordinate_count as u64 + MEMORY_PER_CORNER * checked.corner_count as u64,
        free,
    )?;
    let malformed = |source| MeshError::RejectedByTobj { path: path.into(), source };
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let no_materials = |_: &Path| Ok(Default::default());
    let mut reader = MonitoredObjReader { texts: &checked.chunk_texts, first_text_offset: 0, monitor };
    reader.skip_empty_texts();
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, no_materials).map_err(malformed)?;
    let mesh = join_obj_groups(&models, &checked).ok_or_else(|| MeshError::TooManyVertices { path: path.into() })?;
    Ok(LoadedMesh {
        mesh,
        mtllib_arguments: checked.mtllib_arguments,
        file_vertex_count: checked.vertex_count,
        isolated_vertex_count: checked.isolated_vertex_count,
        has_separate_indices: true,
    })
}

/// Reader that presents a list of texts as one stream and reports progress to a monitor.
struct MonitoredObjReader<'t> {
    texts: &'t [String],
    /// Number of bytes read from the first of `texts`.
    first_text_offset: usize,
    monitor: &'t dyn MeshReadMonitor,
}

impl BufRead for MonitoredObjReader<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.texts.first().map_or(&[], |text| &text.as_bytes()[self.first_text_offset..]))
    }

    fn consume(&mut self, n: usize) {
        self.first_text_offset += n;
        if let Some(text) = self.texts.first()
            && self.first_text_offset == text.len()
        {
            self.monitor.on_bytes_parsed(text.len() as u64 / 2);
            (self.texts, self.first_text_offset) = (&self.texts[1..], 0);
            self.skip_empty_texts();
        }
    }
}

impl MonitoredObjReader<'_> {
    /// Removes empty texts from the front of the list. An empty text would give the caller an empty
    /// buffer, which means the end of the file.
    fn skip_empty_texts(&mut self) {
        while let [first, rest @ ..] = self.texts
            && first.is_empty()
        {
            self.texts = rest;
        }
    }
}

impl Read for MonitoredObjReader<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let n = self.fill_buf()?.read(into)?;
        self.consume(n);
        Ok(n)
    }
}

/// Joins the meshes of all face groups into one mesh, and merges its equal vertices.
///
/// Returns `None` if these meshes have more than `i32::MAX` vertices in total.
fn join_obj_groups(models: &[tobj::Model], checked: &CheckedObjFile) -> Option<TriangleMesh> {
    let mut mesh = TriangleMesh::default();
    let has = |list: fn(&tobj::Mesh) -> &Vec<f64>| models.iter().any(|model| !list(&model.mesh).is_empty());
    let (has_normals, has_texcoords) = (has(|mesh| &mesh.normals), has(|mesh| &mesh.texcoords));
    let (mut normals, mut texcoords) = (Vec::new(), Vec::new());
    let mut material_indices: HashMap<&str, u32> = HashMap::new();
    for (model, material) in models.iter().zip(&checked.group_material_names) {
        let part = &model.mesh;
        let base = u32::try_from(mesh.positions.len()).ok()?;
        let (points, _) = part.positions.as_chunks::<3>();
        mesh.positions.extend(points.iter().copied().map(DVec3::from_array));
        if i32::try_from(mesh.positions.len()).is_err() {
            return None;
        }
        if has_normals {
            normals.extend(part.normals.as_chunks::<3>().0.iter().map(|n| unit_normal(DVec3::from_array(*n))));
            normals.resize(mesh.positions.len(), DVec3::ZERO);
        }
        if has_texcoords {
            texcoords.extend(part.texcoords.as_chunks::<2>().0.iter().copied().map(DVec2::from_array));
            texcoords.resize(mesh.positions.len(), DVec2::ZERO);
        }
        let (corners, _) = part.indices.as_chunks::<3>();
        mesh.triangles.extend(corners.iter().map(|t| t.map(|v| v + base)));
        let material_index = if material.is_empty() {
            NO_MATERIAL
        } else {
            *material_indices.entry(material).or_insert_with(|| {
                mesh.materials.push(material.clone());
                mesh.materials.len() as u32 - 1
            })
        };
        mesh.triangle_materials.resize(mesh.triangles.len(), material_index);
    }
    if mesh.materials.is_empty() {
        mesh.triangle_materials = Vec::new();
    }
    mesh.normals = has_normals.then_some(normals);
    mesh.texcoords = has_texcoords.then_some(texcoords);
    mesh.merge_equal_vertices();
    Some(mesh)
}
