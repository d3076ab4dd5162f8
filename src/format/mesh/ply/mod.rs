//! Reading and writing of triangle meshes as PLY files (Turk 1994, "The PLY Polygon File Format").

mod header;
mod numbers;
#[cfg(test)]
mod tests;
mod write;

use super::{LoadedMesh, MeshError, MeshReadMonitor, check_memory, unit_normal};
use crate::format::line_error::{MessageAndRemedy, strip_byte_order_mark};
use glam::{DVec2, DVec3};
use header::{PlyElement, PlyElementKind, PlyEncoding, PlyHeader, PlyNumberType, PlyPropertyRole};
use numbers::{PlyBinaryReader, PlyNumberReader, PlyTextReader};
use std::path::Path;
pub(super) use write::write;

/// Memory per vertex while equal vertices are merged \[bytes].
///
/// It covers position, normal and texture coordinates (64), their copy in the merged mesh (64), a
/// flag (1), an index (4), and an entry of a hash table (20).
const MEMORY_PER_VERTEX: u64 = 160;

/// Memory per triangle \[bytes], including unused capacity of its list.
const MEMORY_PER_TRIANGLE: u64 = 24;

/// Memory per corner of the face that is being read \[bytes], including unused capacity of its
/// list.
const MEMORY_PER_CORNER: u64 = 8;

/// Number of elements between two progress reports.
const ELEMENTS_PER_PROGRESS_REPORT: u64 = 1 << 16;

/// Reads a mesh from the bytes of a PLY file. Skips elements and properties that meshes do not use.
///
/// `path` appears in errors only. Fails before allocating if the mesh takes more than `free` bytes.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    monitor: &dyn MeshReadMonitor,
    free: Option<u64>,
) -> Result<LoadedMesh, MeshError> {
    let bytes = strip_byte_order_mark(bytes);
    let header = PlyHeader::parse(bytes).map_err(|(line, problem)| MeshError::error_at_line(path, line, problem))?;
    let count = |kind| header.elements.iter().find(|e| e.kind == kind).map_or(0, |e| e.count);
    if count(PlyElementKind::Vertex) > i32::MAX as u64 {
        return Err(MeshError::TooManyVertices { path: path.into() });
    }
    // The header check ensured that the file can hold these counts, so the products do not
    // overflow.
    let needed = MEMORY_PER_VERTEX * count(PlyElementKind::Vertex) + MEMORY_PER_TRIANGLE * count(PlyElementKind::Face);
    check_memory(path, needed, free)?;
    let mut reader = PlyMeshReader {
        loaded: LoadedMesh::default(),
        used_vertices: Vec::new(),
        vertex_count: count(PlyElementKind::Vertex),
        monitor,
        free_memory: free,
    };
    let offset = header.byte_count;
    match header.encoding {
        PlyEncoding::Ascii => {
            let numbers = PlyTextReader { bytes, offset, line: header.line_count + 1 };
            reader.read_ply_elements(&header, numbers).map_err(|e| e.into_line_error(path))?;
        }
        PlyEncoding::LittleEndian => {
            let numbers = PlyBinaryReader::<false> { bytes, offset };
            reader.read_ply_elements(&header, numbers).map_err(|e| e.into_byte_error(path))?;
        }
        PlyEncoding::BigEndian => {
            let numbers = PlyBinaryReader::<true> { bytes, offset };
            reader.read_ply_elements(&header, numbers).map_err(|e| e.into_byte_error(path))?;
        }
    }
    let PlyMeshReader { mut loaded, used_vertices: used, .. } = reader;
    loaded.file_vertex_count = used.len();
    loaded.isolated_vertex_count = used.iter().filter(|used| !**used).count();
    loaded.mesh.merge_equal_vertices();
    Ok(loaded)
}

/// Error in one element of a PLY body, such as a face.
struct PlyElementError {
    /// Line number from 1 in a text file; byte offset of the element in a binary file.
    position: usize,
    /// Name and index, from 0, of the invalid element, such as `face 12`.
    element: String,
    cause: PlyElementErrorCause,
}

/// Cause of a [`PlyElementError`].
enum PlyElementErrorCause {
    Malformed(MessageAndRemedy),
    /// The mesh needs more memory than is free. Both numbers are in bytes.
    OutOfMemory {
        needed: u64,
        free: u64,
    },
}

impl From<MessageAndRemedy> for PlyElementErrorCause {
    fn from(problem: MessageAndRemedy) -> Self {
        Self::Malformed(problem)
    }
}

impl PlyElementError {
    fn into_line_error(self, path: &Path) -> MeshError {
        match self.cause {
            PlyElementErrorCause::Malformed(problem) => MeshError::error_at_line(path, self.position, problem),
            PlyElementErrorCause::OutOfMemory { needed, free } => {
                MeshError::OutOfMemory { path: path.into(), needed, free }
            }
        }
    }

    fn into_byte_error(self, path: &Path) -> MeshError {
        match self.cause {
            PlyElementErrorCause::Malformed((message, remedy)) => MeshError::InvalidElement {
                path: path.into(),
                byte: self.position,
                element: self.element,
                message,
                remedy,
            },
            PlyElementErrorCause::OutOfMemory { needed, free } => {
                MeshError::OutOfMemory { path: path.into(), needed, free }
            }
        }
    }
}

/// State of reading a PLY body into a mesh.
struct PlyMeshReader<'m> {
    loaded: LoadedMesh,
    /// True for each vertex that a face uses.
    used_vertices: Vec<bool>,
    /// Number of vertices that the header declares.
    vertex_count: u64,
    monitor: &'m dyn MeshReadMonitor,
    /// Memory that the mesh may take \[bytes]; `None` without a limit.
    free_memory: Option<u64>,
}

impl PlyMeshReader<'_> {
    fn read_ply_elements<R: PlyNumberReader>(
        &mut self,
        header: &PlyHeader,
        mut numbers: R,
    ) -> Result<(), PlyElementError> {
        // The header check has ensured that the file holds at least one byte per vertex.
        self.used_vertices = vec![false; self.vertex_count as usize];
        let mut reported = 0;
        for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
            let mut corners = Vec::new();
            self.reserve_mesh_memory(element);
            for i in 0..element.count {
                let start = numbers.error_position();
                let read = match element.kind {
                    PlyElementKind::Vertex => {
                        self.read_ply_vertex(element, &mut numbers).map_err(PlyElementErrorCause::from)
                    }
                    PlyElementKind::Face => self.read_ply_face(element, &mut numbers, &mut corners),
                    PlyElementKind::Other => {
                        skip_ply_element(element, &mut numbers).map_err(PlyElementErrorCause::from)
                    }
                };
                read.map_err(|cause| PlyElementError {
                    // Errors in text name the line of the last word. Errors in binary files name
                    // the first byte of the element.
                    position: if header.encoding == PlyEncoding::Ascii { numbers.error_position() } else { start },
                    element: format!("{} {i}", element.name),
                    cause,
                })?;
                if i % ELEMENTS_PER_PROGRESS_REPORT == ELEMENTS_PER_PROGRESS_REPORT - 1 {
                    self.monitor.on_bytes_parsed((numbers.bytes_read() - reported) as u64);
                    reported = numbers.bytes_read();
                }
            }
        }
        Ok(())
    }

    /// Reserves capacity in the mesh for all vertices or faces that `element` declares.
    ///
    /// The declared count is plausible: the header check ensured that the file is long enough for
    /// so many elements.
    fn reserve_mesh_memory(&mut self, element: &PlyElement) {
        let mesh = &mut self.loaded.mesh;
        let n = element.count as usize;
        match element.kind {
            PlyElementKind::Vertex => {
                mesh.positions.reserve_exact(n);
                mesh.normals = (3..6).all(|slot| element.has_vertex_component(slot)).then(|| Vec::with_capacity(n));
                mesh.texcoords = (6..8).all(|slot| element.has_vertex_component(slot)).then(|| Vec::with_capacity(n));
            }
            PlyElementKind::Face => mesh.triangles.reserve(n),
            PlyElementKind::Other => {}
        }
    }

    #[inline]
    fn read_ply_vertex<R: PlyNumberReader>(
        &mut self,
        element: &PlyElement,
        numbers: &mut R,
    ) -> Result<(), MessageAndRemedy> {
        let mut slots = [0.0; 8];
        for property in &element.properties {
            match (property.role, property.list_length_type) {
                (_, Some(length)) => skip_ply_list(numbers, length, property.number_type)?,
                (PlyPropertyRole::VertexComponent(slot), None) => {
                    let number = numbers.read_number(property.number_type)?;
                    if !number.is_finite() {
                        let names = ["x", "y", "z", "nx", "ny", "nz", "s", "t"];
                        let message = format!("`{}` is {number}", names[slot]);
                        return Err((message, "numbers must be finite: repair it or export the mesh anew"));
                    }
                    slots[slot] = number;
                }
                (PlyPropertyRole::VertexIndices | PlyPropertyRole::Other, None) => {
                    numbers.read_number(property.number_type)?;
                }
            }
        }
        let [x, y, z, nx, ny, nz, s, t] = slots;
        let mesh = &mut self.loaded.mesh;
        mesh.positions.push(DVec3::new(x, y, z));
        mesh.normals.iter_mut().for_each(|list| list.push(unit_normal(DVec3::new(nx, ny, nz))));
        mesh.texcoords.iter_mut().for_each(|list| list.push(DVec2::new(s, t)));
        Ok(())
    }

    /// Fails if another face of `n` corners would make the mesh exceed the memory limit.
    ///
    /// The face becomes `n − 2` triangles.
    #[inline]
    fn check_face_memory(&self, n: u64) -> Result<(), PlyElementErrorCause> {
        let triangles = self.loaded.mesh.triangles.len() as u64 + n - 2;
        let needed = MEMORY_PER_VERTEX * self.vertex_count + MEMORY_PER_TRIANGLE * triangles + MEMORY_PER_CORNER * n;
        match self.free_memory {
            Some(free) if needed > free => Err(PlyElementErrorCause::OutOfMemory { needed, free }),
            _ => Ok(()),
        }
    }

    #[inline]
    fn read_ply_face<R: PlyNumberReader>(
        &mut self,
        element: &PlyElement,
        numbers: &mut R,
        corners: &mut Vec<u32>,
    ) -> Result<(), PlyElementErrorCause> {
        for property in &element.properties {
            match (property.role, property.list_length_type) {
                (PlyPropertyRole::VertexIndices, Some(length)) => {
                    corners.clear();
                    let n = numbers.read_integer(length)?;
                    if n < 3 {
                        return Err((format!("a face with {n} corners"), "a face needs at least 3").into());
                    }
                    check_ply_list_length(numbers, n as u64, property.number_type)?;
                    self.check_face_memory(n as u64)?;
                    for _ in 0..n {
                        let index = numbers.read_integer(property.number_type)?;
                        if u64::try_from(index).is_ok_and(|index| index < self.vertex_count) {
                            corners.push(index as u32);
                            self.used_vertices[index as usize] = true;
                        } else {
                            let message = format!("there is no vertex {index}: the file has {}", self.vertex_count);
                            return Err((message, "indices count from 0").into());
                        }
                    }
                    let fan = corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]);
                    self.loaded.mesh.triangles.extend(fan);
                }
                (PlyPropertyRole::VertexComponent(_) | PlyPropertyRole::Other, Some(length)) => {
                    skip_ply_list(numbers, length, property.number_type)?;
                }
                (_, None) => {
                    numbers.read_number(property.number_type)?;
                }
            }
        }
        Ok(())
    }
}

fn skip_ply_element<R: PlyNumberReader>(element: &PlyElement, numbers: &mut R) -> Result<(), MessageAndRemedy> {
    for property in &element.properties {
        match property.list_length_type {
            Some(length) => skip_ply_list(numbers, length, property.number_type)?,
            None => {
                numbers.read_number(property.number_type)?;
            }
        }
    }
    Ok(())
}

fn skip_ply_list<R: PlyNumberReader>(
    numbers: &mut R,
    length: PlyNumberType,
    item: PlyNumberType,
) -> Result<(), MessageAndRemedy> {
    let n = numbers.read_integer(length)?;
    if n < 0 {
        return Err((format!("a list of {n} entries"), "the length of a list is at least 0"));
    }
    check_ply_list_length(numbers, n as u64, item)?;
    for _ in 0..n {
        numbers.read_number(item)?;
    }
    Ok(())
}

/// Fails if the rest of the file is too short for a list of `n` numbers of type `item`.
#[inline]
fn check_ply_list_length<R: PlyNumberReader>(numbers: &R, n: u64, item: PlyNumberType) -> Result<(), MessageAndRemedy> {
    let most = numbers.max_remaining_values(item);
    if n > most {
        let message = format!("a list of {n} entries, but the rest of the file holds at most {most}");
        return Err((message, "the file is cut short, or the length is wrong"));
    }
    Ok(())
}
