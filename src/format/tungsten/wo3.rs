//! Reads Tungsten's mesh format `.wo3`.
//!
//! A file has the number of vertices, the vertices, the number of triangles, and the triangles. All
//! numbers are little-endian. A vertex has a position, a normal and texture coordinates, eight
//! numbers in single precision. A triangle has three vertex indices and the index of its BSDF.

use crate::format::mesh::{TriangleMesh, unit_normal};
use glam::{DVec2, DVec3};

/// Length of a vertex in the file \[bytes].
const VERTEX_BYTES: u64 = 32;

/// Length of a triangle in the file \[bytes].
const TRIANGLE_BYTES: u64 = 16;

/// Length of each of the two counts in the file \[bytes].
const COUNT_BYTES: u64 = 8;

/// Estimated memory per vertex and per triangle of a decoded mesh \[bytes].
const MEMORY_PER_MESH_ELEMENT: u64 = 200;

/// Text of an error about a malformed file.
pub(super) type Defect = String;

/// Decodes a `.wo3` file. The material of a triangle is the index of its BSDF; a negative index
/// counts as 0.
///
/// `free` is the free memory \[bytes]; `None` without a limit.
///
/// # Errors
/// A text, if the file is damaged, or if the mesh does not fit into `free`.
pub(super) fn decode(file: &[u8], free: Option<u64>) -> Result<TriangleMesh, Defect> {
    let length = file.len() as u64;
    let vertex_count = read_count(file, 0, VERTEX_BYTES, "vertices")?;
    let triangles_start = COUNT_BYTES + vertex_count * VERTEX_BYTES;
    let triangle_count = read_count(file, triangles_start, TRIANGLE_BYTES, "triangles")?;
    let end = triangles_start + COUNT_BYTES + triangle_count * TRIANGLE_BYTES;
    if end != length {
        return Err(format!("the file has {length} bytes, and its mesh ends after {end}"));
    }
    let needed = (vertex_count + triangle_count).saturating_mul(MEMORY_PER_MESH_ELEMENT);
    if let Some(free) = free.filter(|free| needed > *free) {
        return Err(format!("the mesh takes {needed} bytes of memory, and {free} are free"));
    }
    let mut mesh = TriangleMesh::default();
    let (mut normals, mut texcoords) = (Vec::new(), Vec::new());
    for vertex in file[COUNT_BYTES as usize..triangles_start as usize].chunks_exact(VERTEX_BYTES as usize) {
        let number = |i: usize| f64::from(f32::from_le_bytes(word(vertex, i)));
        mesh.positions.push(DVec3::new(number(0), number(1), number(2)));
        normals.push(unit_normal(DVec3::new(number(3), number(4), number(5))));
        texcoords.push(DVec2::new(number(6), number(7)));
    }
    if !(mesh.positions.iter().all(|p| p.is_finite()) && texcoords.iter().all(|uv| uv.is_finite())) {
        return Err("a position or texture coordinate is not finite".to_owned());
    }
    for triangle in file[(triangles_start + COUNT_BYTES) as usize..].chunks_exact(TRIANGLE_BYTES as usize) {
        let corners = [0, 1, 2].map(|i| u32::from_le_bytes(word(triangle, i)));
        if let Some(index) = corners.into_iter().find(|index| u64::from(*index) >= vertex_count) {
            return Err(format!("index {index} is out of range: there are {vertex_count} vertices"));
        }
        mesh.triangles.push(corners);
        mesh.triangle_materials.push(i32::from_le_bytes(word(triangle, 3)).max(0) as u32);
    }
    (mesh.normals, mesh.texcoords) = (Some(normals), Some(texcoords));
    Ok(mesh)
}

/// Returns the count at byte `at` of the file. The rest of the file must have room for as many
/// elements of `element_bytes` each.
fn read_count(file: &[u8], at: u64, element_bytes: u64, elements: &str) -> Result<u64, Defect> {
    let at = at as usize;
    let Some(count) = file.get(at..).and_then(|rest| rest.first_chunk::<8>()) else {
        return Err(format!("the file ends before its number of {elements}"));
    };
    let count = u64::from_le_bytes(*count);
    let room = (file.len() - at) as u64 - COUNT_BYTES;
    if count > room / element_bytes {
        return Err(format!("the file is too short for {count} {elements}: {room} bytes are left"));
    }
    Ok(count)
}

/// Returns the four bytes with index `i`, counted in steps of four bytes.
fn word(bytes: &[u8], i: usize) -> [u8; 4] {
    [0, 1, 2, 3].map(|k| bytes[4 * i + k])
}

#[cfg(test)]
pub(super) mod tests;
