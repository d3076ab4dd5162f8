//! Reads Mitsuba's mesh format `.serialized`, which holds several compressed meshes in one file.

use crate::format::mesh::{TriangleMesh, unit_normal};
use flate2::read::ZlibDecoder;
use glam::{DVec2, DVec3};
use std::io::Read;

/// First two bytes of a `.serialized` file and of each mesh in it, as a little-endian number.
const SIGNATURE: u16 = 0x041c;

// Bits of the flags at the start of a mesh.
const HAS_NORMALS: u32 = 0x0001;
const HAS_TEXCOORDS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const USES_FLAT_FACES: u32 = 0x0010;
const DOUBLE_PRECISION: u32 = 0x2000;

/// Greatest number of decompressed bytes per compressed byte that zlib can reach.
const MAX_COMPRESSION_RATIO: u64 = 1_032;

/// Estimated memory per vertex and per triangle of a decoded mesh \[bytes].
const MEMORY_PER_MESH_ELEMENT: u64 = 200;

/// Greatest length of a mesh's name \[bytes]. Names are skipped.
const MAX_NAME_BYTES: usize = 1 << 16;

/// Text of an error about a malformed file.
pub(super) type Defect = String;

/// One of the meshes of a `.serialized` file.
#[derive(Debug)]
pub(super) struct SerializedMesh {
    /// The mesh, with the normals of the file if it has any.
    pub mesh: TriangleMesh,
    /// True if the file asks for flat faces instead of smooth shading.
    pub uses_flat_faces: bool,
}

/// Decodes the mesh with number `index`, from 0, of a `.serialized` file.
///
/// `free` is the free memory \[bytes]; `None` without a limit.
///
/// # Errors
/// A text, if the file is damaged, has no such mesh, or holds one that does not fit into `free`.
pub(super) fn decode(file: &[u8], index: usize, free: Option<u64>) -> Result<SerializedMesh, Defect> {
    let truncated = || "the file is too short".to_owned();
    let bytes = |at: usize, count: usize| at.checked_add(count).and_then(|end| file.get(at..end)).ok_or_else(truncated);
    let u16_at = |at: usize| Ok::<u16, Defect>(u16::from_le_bytes([bytes(at, 2)?[0], bytes(at, 2)?[1]]));
    let version = u16_at(2)?;
    if u16_at(0)? != SIGNATURE {
        return Err("the file is no `.serialized` mesh".to_owned());
    }
    if version != 3 && version != 4 {
        return Err(format!("version {version} of the format is not known"));
    }
    let start =
        if index == 0 { 0 } else { mesh_offset(file, index, version).ok_or_else(|| missing_mesh_error(index))? };
    if u16_at(start)? != SIGNATURE {
        return Err("the list of meshes at the end of the file is damaged".to_owned());
    }
    let data = file.get(start + 4..).ok_or_else(truncated)?;
    let mut reader = MeshReader { stream: ZlibDecoder::new(data), is_double: false };
    let flags = u32::from_le_bytes(reader.read_array()?);
    reader.is_double = flags & DOUBLE_PRECISION != 0;
    if version == 4 {
        reader.skip_name()?;
    }
    let (vertices, triangles) = (u64::from_le_bytes(reader.read_array()?), u64::from_le_bytes(reader.read_array()?));
    let needed = vertices.saturating_add(triangles).saturating_mul(MEMORY_PER_MESH_ELEMENT);
    // A vertex or triangle takes at least twelve decompressed bytes.
    if needed / MEMORY_PER_MESH_ELEMENT * 12 > MAX_COMPRESSION_RATIO * data.len() as u64 || vertices > i32::MAX as u64 {
        return Err(format!("{vertices} vertices and {triangles} triangles cannot be in this file"));
    }
    if let Some(free) = free.filter(|free| needed > *free) {
        return Err(format!("the mesh takes {needed} bytes of memory, and {free} are free"));
    }
    let count = vertices as usize;
    let positions: Vec<DVec3> = reader.read_vectors(count)?;
    let normals = if flags & HAS_NORMALS != 0 { Some(reader.read_vectors(count)?) } else { None };
    let texcoords: Option<Vec<DVec2>> = if flags & HAS_TEXCOORDS != 0 {
        Some(
            (0..count)
                .map(|_| Ok(DVec2::new(reader.read_number()?, reader.read_number()?)))
                .collect::<Result<_, Defect>>()?,
        )
    } else {
        None
    };
    if flags & HAS_COLORS != 0 {
        reader.read_vectors(count)?;
    }
    let mut corners = Vec::with_capacity(triangles as usize);
    for _ in 0..triangles {
        let corner = [0; 3].map(|_: u8| reader.read_array().map(u32::from_le_bytes));
        let [Ok(a), Ok(b), Ok(c)] = corner else { return Err(truncated()) };
        if let Some(index) = [a, b, c].into_iter().find(|index| u64::from(*index) >= vertices) {
            return Err(format!("index {index} is out of range: there are {vertices} vertices"));
        }
        corners.push([a, b, c]);
    }
    let is_finite = positions.iter().all(|p| p.is_finite()) && texcoords.iter().flatten().all(|uv| uv.is_finite());
    if !is_finite {
        return Err("a position or texture coordinate is not finite".to_owned());
    }
    let normals = normals.map(|normals| normals.into_iter().map(unit_normal).collect());
    let mesh = TriangleMesh { positions, triangles: corners, normals, texcoords, ..TriangleMesh::default() };
    Ok(SerializedMesh { mesh, uses_flat_faces: flags & USES_FLAT_FACES != 0 })
}

fn missing_mesh_error(index: usize) -> Defect {
    format!("the file has no mesh with number {index}")
}

/// Returns the byte offset in the file of mesh `index`, from the list at the end of the file;
/// `None` if the list has no such entry.
fn mesh_offset(file: &[u8], index: usize, version: u16) -> Option<usize> {
    let end = file.len().checked_sub(4)?;
    let count = u32::from_le_bytes(file[end..].try_into().ok()?) as usize;
    let size = if version == 4 { 8 } else { 4 };
    let at = end.checked_sub(count.checked_sub(index).filter(|rest| *rest > 0)?.checked_mul(size)?)?;
    let offset = &file[at..at + size];
    if version == 4 {
        u64::from_le_bytes(offset.try_into().ok()?).try_into().ok()
    } else {
        Some(u32::from_le_bytes(offset.try_into().ok()?) as usize)
    }
}

/// Reader of the numbers of one mesh. It decompresses while it reads.
struct MeshReader<'f> {
    stream: ZlibDecoder<&'f [u8]>,
    /// True if the numbers are in double precision, false for single precision.
    is_double: bool,
}

impl MeshReader<'_> {
    fn read_array<const N: usize>(&mut self) -> Result<[u8; N], Defect> {
        let mut bytes = [0; N];
        self.stream.read_exact(&mut bytes).map_err(|error| format!("the compressed data are damaged: {error}"))?;
        Ok(bytes)
    }

    /// Skips the name of the mesh, a text that ends with a zero byte.
    fn skip_name(&mut self) -> Result<(), Defect> {
        for _ in 0..MAX_NAME_BYTES {
            if self.read_array::<1>()? == [0] {
                return Ok(());
            }
        }
        Err("the name of the mesh has no end".to_owned())
    }

    fn read_number(&mut self) -> Result<f64, Defect> {
        Ok(if self.is_double {
            f64::from_le_bytes(self.read_array()?)
        } else {
            f32::from_le_bytes(self.read_array()?).into()
        })
    }

    fn read_vectors(&mut self, count: usize) -> Result<Vec<DVec3>, Defect> {
        (0..count).map(|_| Ok(DVec3::new(self.read_number()?, self.read_number()?, self.read_number()?))).collect()
    }
}

#[cfg(test)]
mod tests;
