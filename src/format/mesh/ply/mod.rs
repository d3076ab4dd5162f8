//! Reading and writing of triangle meshes as PLY files (Turk 1994, "The PLY Polygon File Format").

mod header;
mod numbers;
#[cfg(test)]
mod tests;
mod write;

use super::{LoadedMesh, MeshError, MeshReadMonitor, check_memory, unit_normal};
use crate::format::line_error::{MessageAndRemedy, strip_byte_order_mark};
use glam::{DVec2, DVec3};
use header::{ElementKind, NumberType, PlyElement, PlyEncoding, PlyHeader, PropertyRole};
use numbers::{BinaryNumberReader, NumberReader, TextNumberReader};
use std::path::Path;
pub(super) use write::write;

/// Memory per vertex while equal vertices are merged \[bytes].
///
/// It covers position, normal and texture coordinates (64), a copy of them (64), a flag (1), an
/// index (4), and an entry of a hash table (20).
const BYTES_PER_VERTEX: u64 = 160;

/// Memory per triangle, with unused list capacity \[bytes].
const BYTES_PER_TRIANGLE: u64 = 24;

/// Memory per corner of the current face, with unused list capacity \[bytes].
const BYTES_PER_CORNER: u64 = 8;

/// Number of elements between two progress reports.
const PROGRESS_STRIDE: u64 = 1 << 16;

/// Parses the triangles of a PLY file; skips elements and properties that meshes do not use.
///
/// `path` appears in errors only. Fails before allocating if the mesh takes more than `free`
/// bytes.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    monitor: &dyn MeshReadMonitor,
    free: Option<u64>,
) -> Result<LoadedMesh, MeshError> {
    let bytes = strip_byte_order_mark(bytes);
    let header = PlyHeader::parse(bytes).map_err(|(line, problem)| MeshError::at_line(path, line, problem))?;
    let count = |kind| header.elements.iter().find(|e| e.kind == kind).map_or(0, |e| e.count);
    if count(ElementKind::Vertex) > i32::MAX as u64 {
        return Err(MeshError::TooLarge { path: path.into() });
    }
    // The file can hold the header's counts, so the products do not overflow.
    let needed = BYTES_PER_VERTEX * count(ElementKind::Vertex) + BYTES_PER_TRIANGLE * count(ElementKind::Face);
    check_memory(path, needed, free)?;
    let mut reader = MeshReader {
        loaded: LoadedMesh::default(),
        used: Vec::new(),
        vertices: count(ElementKind::Vertex),
        monitor,
        free,
    };
    let offset = header.bytes;
    match header.encoding {
        PlyEncoding::Ascii => {
            let numbers = TextNumberReader { bytes, offset, line: header.lines + 1 };
            reader.read_elements(&header, numbers).map_err(|e| e.into_line_error(path))?;
        }
        PlyEncoding::Little => {
            let numbers = BinaryNumberReader::<false> { bytes, offset };
            reader.read_elements(&header, numbers).map_err(|e| e.into_byte_error(path))?;
        }
        PlyEncoding::Big => {
            let numbers = BinaryNumberReader::<true> { bytes, offset };
            reader.read_elements(&header, numbers).map_err(|e| e.into_byte_error(path))?;
        }
    }
    let MeshReader { mut loaded, used, .. } = reader;
    loaded.vertices = used.len();
    loaded.isolated = used.iter().filter(|used| !**used).count();
    loaded.mesh.merge_equal_vertices();
    Ok(loaded)
}

/// Error: one element of the body cannot be read.
struct ElementError {
    /// Line number in text files, byte offset in binary files.
    position: usize,
    /// Name and index of the element, such as `face 12`.
    element: String,
    cause: ElementErrorCause,
}

/// Cause of an [`ElementError`].
enum ElementErrorCause {
    Malformed(MessageAndRemedy),
    /// The mesh would need `needed` bytes, and `free` are available.
    Memory {
        needed: u64,
        free: u64,
    },
}

impl From<MessageAndRemedy> for ElementErrorCause {
    fn from(problem: MessageAndRemedy) -> Self {
        Self::Malformed(problem)
    }
}

impl ElementError {
    fn into_line_error(self, path: &Path) -> MeshError {
        match self.cause {
            ElementErrorCause::Malformed(problem) => MeshError::at_line(path, self.position, problem),
            ElementErrorCause::Memory { needed, free } => MeshError::Memory { path: path.into(), needed, free },
        }
    }

    fn into_byte_error(self, path: &Path) -> MeshError {
        match self.cause {
            ElementErrorCause::Malformed((message, remedy)) => {
                MeshError::Byte { path: path.into(), byte: self.position, element: self.element, message, remedy }
            }
            ElementErrorCause::Memory { needed, free } => MeshError::Memory { path: path.into(), needed, free },
        }
    }
}

/// State of reading a PLY body into a mesh.
struct MeshReader<'m> {
    loaded: LoadedMesh,
    /// True for each vertex that a face uses.
    used: Vec<bool>,
    /// Number of vertices that the header declares.
    vertices: u64,
    monitor: &'m dyn MeshReadMonitor,
    /// Memory that the mesh may take \[bytes]; `None` without a limit.
    free: Option<u64>,
}

impl MeshReader<'_> {
    fn read_elements<R: NumberReader>(&mut self, header: &PlyHeader, mut numbers: R) -> Result<(), ElementError> {
        // The header check has ensured that the file holds at least one byte per vertex.
        self.used = vec![false; self.vertices as usize];
        let mut reported = 0;
        for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
            let mut corners = Vec::new();
            self.reserve_lists(element);
            for i in 0..element.count {
                let start = numbers.error_position();
                let read = match element.kind {
                    ElementKind::Vertex => self.read_vertex(element, &mut numbers).map_err(ElementErrorCause::from),
                    ElementKind::Face => self.read_face(element, &mut numbers, &mut corners),
                    ElementKind::Other => skip_element(element, &mut numbers).map_err(ElementErrorCause::from),
                };
                read.map_err(|cause| ElementError {
                    // Errors in text name the line of the last word. Errors in binary files name
                    // the first byte of the element.
                    position: if header.encoding == PlyEncoding::Ascii { numbers.error_position() } else { start },
                    element: format!("{} {i}", element.name),
                    cause,
                })?;
                if i % PROGRESS_STRIDE == PROGRESS_STRIDE - 1 {
                    self.monitor.on_bytes_parsed((numbers.bytes_read() - reported) as u64);
                    reported = numbers.bytes_read();
                }
            }
        }
        Ok(())
    }

    /// Reserves memory for the element's count. The header check has ensured that the file can
    /// hold so many elements.
    fn reserve_lists(&mut self, element: &PlyElement) {
        let mesh = &mut self.loaded.mesh;
        let n = element.count as usize;
        match element.kind {
            ElementKind::Vertex => {
                mesh.positions.reserve_exact(n);
                mesh.normals = (3..6).all(|slot| element.has_property_slot(slot)).then(|| Vec::with_capacity(n));
                mesh.texcoords = (6..8).all(|slot| element.has_property_slot(slot)).then(|| Vec::with_capacity(n));
            }
            ElementKind::Face => mesh.triangles.reserve(n),
            ElementKind::Other => {}
        }
    }

    #[inline]
    fn read_vertex<R: NumberReader>(&mut self, element: &PlyElement, numbers: &mut R) -> Result<(), MessageAndRemedy> {
        let mut slots = [0.0; 8];
        for property in &element.properties {
            match (property.role, property.list) {
                (_, Some(length)) => skip_list(numbers, length, property.item)?,
                (PropertyRole::Slot(slot), None) => {
                    let number = numbers.read_number(property.item)?;
                    if !number.is_finite() {
                        let names = ["x", "y", "z", "nx", "ny", "nz", "s", "t"];
                        let message = format!("`{}` is {number}", names[slot]);
                        return Err((message, "numbers must be finite: repair it or export the mesh anew"));
                    }
                    slots[slot] = number;
                }
                (PropertyRole::Corners | PropertyRole::Other, None) => {
                    numbers.read_number(property.item)?;
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

    /// Fails if a face of `n` corners, which becomes `n − 2` triangles, would exceed the memory.
    #[inline]
    fn check_face_memory(&self, n: u64) -> Result<(), ElementErrorCause> {
        let triangles = self.loaded.mesh.triangles.len() as u64 + n - 2;
        let needed = BYTES_PER_VERTEX * self.vertices + BYTES_PER_TRIANGLE * triangles + BYTES_PER_CORNER * n;
        match self.free {
            Some(free) if needed > free => Err(ElementErrorCause::Memory { needed, free }),
            _ => Ok(()),
        }
    }

    #[inline]
    fn read_face<R: NumberReader>(
        &mut self,
        element: &PlyElement,
        numbers: &mut R,
        corners: &mut Vec<u32>,
    ) -> Result<(), ElementErrorCause> {
        for property in &element.properties {
            match (property.role, property.list) {
                (PropertyRole::Corners, Some(length)) => {
                    corners.clear();
                    let n = numbers.read_integer(length)?;
                    if n < 3 {
                        return Err((format!("a face with {n} corners"), "a face needs at least 3").into());
                    }
                    check_list_length(numbers, n as u64, property.item)?;
                    self.check_face_memory(n as u64)?;
                    for _ in 0..n {
                        let index = numbers.read_integer(property.item)?;
                        if u64::try_from(index).is_ok_and(|index| index < self.vertices) {
                            corners.push(index as u32);
                            self.used[index as usize] = true;
                        } else {
                            let message = format!("there is no vertex {index}: the file has {}", self.vertices);
                            return Err((message, "indices count from 0").into());
                        }
                    }
                    let fan = corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]);
                    self.loaded.mesh.triangles.extend(fan);
                }
                (PropertyRole::Slot(_) | PropertyRole::Other, Some(length)) => {
                    skip_list(numbers, length, property.item)?;
                }
                (_, None) => {
                    numbers.read_number(property.item)?;
                }
            }
        }
        Ok(())
    }
}

fn skip_element<R: NumberReader>(element: &PlyElement, numbers: &mut R) -> Result<(), MessageAndRemedy> {
    for property in &element.properties {
        match property.list {
            Some(length) => skip_list(numbers, length, property.item)?,
            None => {
                numbers.read_number(property.item)?;
            }
        }
    }
    Ok(())
}

fn skip_list<R: NumberReader>(numbers: &mut R, length: NumberType, item: NumberType) -> Result<(), MessageAndRemedy> {
    let n = numbers.read_integer(length)?;
    if n < 0 {
        return Err((format!("a list of {n} entries"), "the length of a list is at least 0"));
    }
    check_list_length(numbers, n as u64, item)?;
    for _ in 0..n {
        numbers.read_number(item)?;
    }
    Ok(())
}

/// Fails if the rest of the file cannot hold a list of `n` entries of type `item`.
#[inline]
fn check_list_length<R: NumberReader>(numbers: &R, n: u64, item: NumberType) -> Result<(), MessageAndRemedy> {
    let most = numbers.remaining_capacity(item);
    if n > most {
        let message = format!("a list of {n} entries, but the rest of the file holds at most {most}");
        return Err((message, "the file is cut short, or the length is wrong"));
    }
    Ok(())
}
