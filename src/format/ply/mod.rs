//! Triangle meshes from and to PLY files (Turk 1994, "The PLY Polygon File Format"), in text and in both binary forms.

mod body;
mod header;
#[cfg(test)]
mod tests;
mod write;

use super::mesh::{Loaded, MeshError, ReadMonitor, Wrong, check_room, unit};
use body::{Ascii, Binary, Body};
use glam::{DVec2, DVec3};
use header::{Element, Encoding, Header, Kind, Role};
use std::path::Path;
pub(super) use write::write;

/// Bytes that a vertex takes while vertices are made one: where it is, its normal and texture coordinates (64), that again as it is
/// rewritten, its flag (1), its new number (4) and its place in a table (20).
const PER_VERTEX: u64 = 160;

/// Bytes that a triangle takes, and the slack of growing lists.
const PER_TRIANGLE: u64 = 24;

/// Bytes that a corner of the face takes that is being read, with the same slack.
const PER_CORNER: u64 = 8;

/// Elements between two words to the monitor.
const STRIDE: u64 = 1 << 16;

/// The triangles of a PLY file. Elements and properties that mean nothing here are passed over.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    monitor: &dyn ReadMonitor,
    free: Option<u64>,
) -> Result<Loaded, MeshError> {
    let header = Header::parse(bytes).map_err(|(line, wrong)| MeshError::line(path, line, wrong))?;
    let count = |kind| header.elements.iter().find(|e| e.kind == kind).map_or(0, |e| e.count);
    if count(Kind::Vertex) > i32::MAX as u64 {
        return Err(MeshError::TooLarge { path: path.into() });
    }
    // What the header tells fits into the file, so the products do not overflow.
    check_room(path, PER_VERTEX * count(Kind::Vertex) + PER_TRIANGLE * count(Kind::Face), free)?;
    let mut reading =
        Reading { loaded: Loaded::default(), used: Vec::new(), vertices: count(Kind::Vertex), monitor, free };
    match header.encoding {
        Encoding::Ascii => {
            let body = Ascii { bytes, at: header.bytes, line: header.lines + 1 };
            reading.elements(&header, body).map_err(|fault| fault.at_line(path))?;
        }
        Encoding::Little => {
            let body = Binary::<false> { bytes, at: header.bytes };
            reading.elements(&header, body).map_err(|fault| fault.at_byte(path))?;
        }
        Encoding::Big => {
            let body = Binary::<true> { bytes, at: header.bytes };
            reading.elements(&header, body).map_err(|fault| fault.at_byte(path))?;
        }
    }
    let Reading { mut loaded, used, .. } = reading;
    loaded.vertices = used.len();
    loaded.isolated = used.iter().filter(|used| !**used).count();
    loaded.mesh.share();
    Ok(loaded)
}

/// What is wrong with an element.
struct Fault {
    place: usize,
    element: String,
    stop: Stop,
}

/// Why an element is not read.
enum Stop {
    Wrong(Wrong),
    /// With it, the mesh takes so many bytes of those that are free.
    Memory {
        needed: u64,
        free: u64,
    },
}

impl From<Wrong> for Stop {
    fn from(wrong: Wrong) -> Self {
        Self::Wrong(wrong)
    }
}

impl Fault {
    fn at_line(self, path: &Path) -> MeshError {
        match self.stop {
            Stop::Wrong(wrong) => MeshError::line(path, self.place, wrong),
            Stop::Memory { needed, free } => MeshError::Memory { path: path.into(), needed, free },
        }
    }

    fn at_byte(self, path: &Path) -> MeshError {
        match self.stop {
            Stop::Wrong((message, remedy)) => {
                MeshError::Byte { path: path.into(), byte: self.place, element: self.element, message, remedy }
            }
            Stop::Memory { needed, free } => MeshError::Memory { path: path.into(), needed, free },
        }
    }
}

struct Reading<'m> {
    loaded: Loaded,
    /// Whether a face uses the vertex.
    used: Vec<bool>,
    /// How many the header tells of.
    vertices: u64,
    monitor: &'m dyn ReadMonitor,
    /// Bytes of memory that it may take.
    free: Option<u64>,
}

impl Reading<'_> {
    fn elements<B: Body>(&mut self, header: &Header, mut body: B) -> Result<(), Fault> {
        // A vertex takes a byte of the file at least: the header has been checked for that.
        self.used = vec![false; self.vertices as usize];
        let mut told = 0;
        for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
            let mut corners = Vec::new();
            self.reserve(element);
            for i in 0..element.count {
                let place = body.place();
                let read = match element.kind {
                    Kind::Vertex => self.vertex(element, &mut body).map_err(Stop::from),
                    Kind::Face => self.face(element, &mut body, &mut corners),
                    Kind::Other => skip(element, &mut body).map_err(Stop::from),
                };
                read.map_err(|stop| Fault {
                    // A line is known at its last word, a byte is that of the element's beginning.
                    place: if header.encoding == Encoding::Ascii { body.place() } else { place },
                    element: format!("{} {i}", element.name),
                    stop,
                })?;
                if i % STRIDE == STRIDE - 1 {
                    self.monitor.advance((body.bytes() - told) as u64);
                    told = body.bytes();
                }
            }
        }
        Ok(())
    }

    /// Takes memory for as many as the file has been found to have room for.
    fn reserve(&mut self, element: &Element) {
        let mesh = &mut self.loaded.mesh;
        let n = element.count as usize;
        match element.kind {
            Kind::Vertex => {
                mesh.positions.reserve_exact(n);
                mesh.normals = (3..6).all(|slot| element.has(slot)).then(|| Vec::with_capacity(n));
                mesh.texcoords = (6..8).all(|slot| element.has(slot)).then(|| Vec::with_capacity(n));
            }
            Kind::Face => mesh.triangles.reserve(n),
            Kind::Other => {}
        }
    }

    #[inline]
    fn vertex<B: Body>(&mut self, element: &Element, body: &mut B) -> Result<(), Wrong> {
        let mut slots = [0.0; 8];
        for property in &element.properties {
            match (property.role, property.list) {
                (_, Some(length)) => skip_list(body, length, property.item)?,
                (Role::Slot(slot), None) => {
                    let number = body.number(property.item)?;
                    if !number.is_finite() {
                        let names = ["x", "y", "z", "nx", "ny", "nz", "s", "t"];
                        let message = format!("`{}` is {number}", names[slot]);
                        return Err((message, "numbers must be finite: repair it or export the mesh anew"));
                    }
                    slots[slot] = number;
                }
                _ => {
                    body.number(property.item)?;
                }
            }
        }
        let [x, y, z, nx, ny, nz, s, t] = slots;
        let mesh = &mut self.loaded.mesh;
        mesh.positions.push(DVec3::new(x, y, z));
        mesh.normals.iter_mut().for_each(|list| list.push(unit(DVec3::new(nx, ny, nz))));
        mesh.texcoords.iter_mut().for_each(|list| list.push(DVec2::new(s, t)));
        Ok(())
    }

    /// Checks that there is room for a face of so many corners, each of which but two is a triangle.
    #[inline]
    fn check_corners(&self, n: u64) -> Result<(), Stop> {
        let triangles = self.loaded.mesh.triangles.len() as u64 + n - 2;
        let needed = PER_VERTEX * self.vertices + PER_TRIANGLE * triangles + PER_CORNER * n;
        match self.free {
            Some(free) if needed > free => Err(Stop::Memory { needed, free }),
            _ => Ok(()),
        }
    }

    #[inline]
    fn face<B: Body>(&mut self, element: &Element, body: &mut B, corners: &mut Vec<u32>) -> Result<(), Stop> {
        for property in &element.properties {
            match (property.role, property.list) {
                (Role::Corners, Some(length)) => {
                    corners.clear();
                    let n = body.whole(length)?;
                    if n < 3 {
                        return Err((format!("a face with {n} corners"), "a face needs at least 3").into());
                    }
                    self.check_corners(n as u64)?;
                    for _ in 0..n {
                        let index = body.whole(property.item)?;
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
                (_, Some(length)) => skip_list(body, length, property.item)?,
                (_, None) => {
                    body.number(property.item)?;
                }
            }
        }
        Ok(())
    }
}

fn skip<B: Body>(element: &Element, body: &mut B) -> Result<(), Wrong> {
    for property in &element.properties {
        match property.list {
            Some(length) => skip_list(body, length, property.item)?,
            None => {
                body.number(property.item)?;
            }
        }
    }
    Ok(())
}

fn skip_list<B: Body>(body: &mut B, length: header::Type, item: header::Type) -> Result<(), Wrong> {
    let n = body.whole(length)?;
    if n < 0 {
        return Err((format!("a list of {n} entries"), "the length of a list is at least 0"));
    }
    for _ in 0..n {
        body.number(item)?;
    }
    Ok(())
}
