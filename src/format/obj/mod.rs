//! Triangle meshes from Wavefront OBJ files.
//!
//! Crate `tobj` reads the numbers and fans the polygons. Handed a file as it is, it names no lines, stops at comments
//! that are not UTF-8, lets normals slip to other vertices where only some faces have them, and overflows on wild
//! indices. So each line is checked here first, and only sound ones are passed on.

mod check;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::hash::Hash;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

/// Triangles with shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Places of the vertices, each used by a triangle.
    pub positions: Vec<DVec3>,
    /// Counterclockwise seen from outside; indices into `positions`. Triangles without area are kept.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals by vertex, of unit length. Zero where the file has none: then at all corners of a triangle.
    pub normals: Option<Vec<DVec3>>,
    /// Texture coordinates by vertex; zero where the file has none.
    pub texcoords: Option<Vec<DVec2>>,
}

/// Why a mesh could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    /// There is no such file.
    #[error("there is no mesh file {}: check the path, which counts from the scene file's folder or the one above it", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The file is there but cannot be read.
    #[error("cannot read the mesh {}: check that it is a file and that you may read it", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line that says nothing sound.
    #[error("{}:{line}: {message}: {remedy}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong.
        message: String,
        /// What would be right.
        remedy: &'static str,
    },
    /// Nothing to see.
    #[error("the mesh {} has no faces: export it with faces (lines that start with `f`)", path.display())]
    NoFaces {
        /// The file.
        path: PathBuf,
    },
    /// More vertices than an index can count.
    #[error("the mesh {} has more than 4294967295 vertices: split it", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The reader refuses what the check let pass.
    #[error("cannot read the mesh {}: {source}: export it anew as plain triangles", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What the reader says.
        source: tobj::LoadError,
    },
}

/// Reads the triangles of an OBJ file; polygons are cut into fans about their first corner.
///
/// Vertices are shared where position, normal and texture coordinates agree in every bit. Materials, lines, points,
/// groups and names are passed over.
///
/// # Errors
/// See [`ObjError`]; all name the file.
pub fn load(path: &Path) -> Result<TriangleMesh, ObjError> {
    let bytes = std::fs::read(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => ObjError::Missing { path: path.into() },
        _ => ObjError::Unreadable { path: path.into(), source },
    })?;
    // Only comments and names may hold other encodings, and they are passed over.
    from_text(path, &String::from_utf8_lossy(&bytes))
}

fn from_text(path: &Path, text: &str) -> Result<TriangleMesh, ObjError> {
    let sound = check::sound_lines(text).map_err(|e| ObjError::Line {
        path: path.into(),
        line: e.line,
        message: e.message,
        remedy: e.remedy,
    })?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut sound.as_bytes(), &options, no_materials)
        .map_err(|source| ObjError::Malformed { path: path.into(), source })?;
    let mut mesh = Merge::default();
    for model in &models {
        mesh.add(&model.mesh).ok_or_else(|| ObjError::TooLarge { path: path.into() })?;
    }
    if mesh.triangles.is_empty() {
        return Err(ObjError::NoFaces { path: path.into() });
    }
    Ok(mesh.finish())
}

/// What makes a vertex: the bits of its position, normal and texture coordinates.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Vertex {
    position: [u64; 3],
    normal: [u64; 3],
    texcoord: [u64; 2],
}

/// Meshes put together, with equal vertices made one.
#[derive(Default)]
struct Merge {
    vertices: Vec<Vertex>,
    indices: HashMap<Vertex, u32>,
    triangles: Vec<[u32; 3]>,
    textured: bool,
}

impl Merge {
    /// Adds the triangles of `mesh`; none if there are too many vertices.
    fn add(&mut self, mesh: &tobj::Mesh) -> Option<()> {
        let vector = |list: &[f64], i: u32| {
            let i = 3 * i as usize;
            list.get(i..i + 3).map_or(DVec3::ZERO, DVec3::from_slice)
        };
        self.textured |= !mesh.texcoords.is_empty();
        for corners in mesh.indices.chunks_exact(3) {
            let corners = [corners[0], corners[1], corners[2]];
            let mut normals = corners.map(|i| unit(vector(&mesh.normals, i)));
            if normals.contains(&DVec3::ZERO) {
                normals = [DVec3::ZERO; 3];
            }
            let mut triangle = [0; 3];
            for k in 0..3 {
                let i = 2 * corners[k] as usize;
                let texcoord = mesh.texcoords.get(i..i + 2).map_or(DVec2::ZERO, DVec2::from_slice);
                triangle[k] = self.vertex(Vertex {
                    position: vector(&mesh.positions, corners[k]).to_array().map(f64::to_bits),
                    normal: normals[k].to_array().map(f64::to_bits),
                    texcoord: texcoord.to_array().map(f64::to_bits),
                })?;
            }
            self.triangles.push(triangle);
        }
        Some(())
    }

    fn vertex(&mut self, vertex: Vertex) -> Option<u32> {
        let next = u32::try_from(self.vertices.len()).ok()?;
        Some(*self.indices.entry(vertex).or_insert_with(|| {
            self.vertices.push(vertex);
            next
        }))
    }

    fn finish(self) -> TriangleMesh {
        let all = |part: fn(&Vertex) -> [u64; 3]| -> Vec<DVec3> {
            self.vertices.iter().map(|v| DVec3::from_array(part(v).map(f64::from_bits))).collect()
        };
        let normals = all(|v| v.normal);
        let texcoords = || self.vertices.iter().map(|v| DVec2::from_array(v.texcoord.map(f64::from_bits))).collect();
        TriangleMesh {
            positions: all(|v| v.position),
            normals: normals.iter().any(|n| *n != DVec3::ZERO).then_some(normals),
            texcoords: self.textured.then(texcoords),
            triangles: self.triangles,
        }
    }
}

/// `v` at unit length, or zero where it is too short or long to tell.
fn unit(v: DVec3) -> DVec3 {
    if v.length_squared().is_normal() { v.normalize() } else { DVec3::ZERO }
}
