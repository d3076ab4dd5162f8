//! Writes meshes as PLY, binary or text.

use crate::format::mesh::{ShortestDecimal, TriangleMesh};
use std::io::{Result, Write};

/// Group of vertex properties that are written together, such as x, y and z of the position.
struct PlyVertexPropertyGroup<'m> {
    names: &'static [&'static str],
    /// True if single precision represents all values exactly. They are then written as `float`.
    is_single_precision: bool,
    /// Function that returns the values of the properties at the vertex with a given index. If the
    /// group has fewer than three properties, the surplus elements are not used.
    get: Box<dyn Fn(usize) -> [f64; 3] + 'm>,
}

impl<'m> PlyVertexPropertyGroup<'m> {
    fn new(names: &'static [&'static str], n: usize, get: impl Fn(usize) -> [f64; 3] + 'm) -> Self {
        let fits = |x: f64| f64::from(x as f32).to_bits() == x.to_bits();
        let is_single_precision = (0..n).all(|v| get(v)[..names.len()].iter().all(|x| fits(*x)));
        Self { names, is_single_precision, get: Box::new(get) }
    }
}

/// Writes a mesh as PLY: as text if `text` is true, else as little-endian binary.
pub(in crate::format) fn write(mesh: &TriangleMesh, text: bool, out: &mut impl Write) -> Result<()> {
    let n = mesh.positions.len();
    let mut columns = vec![PlyVertexPropertyGroup::new(&["x", "y", "z"], n, |v| mesh.positions[v].to_array())];
    if let Some(normals) = &mesh.normals {
        columns.push(PlyVertexPropertyGroup::new(&["nx", "ny", "nz"], n, |v| normals[v].to_array()));
    }
    if let Some(texcoords) = &mesh.texcoords {
        columns.push(PlyVertexPropertyGroup::new(&["s", "t"], n, |v| [texcoords[v].x, texcoords[v].y, 0.0]));
    }
    let encoding = if text { "ascii" } else { "binary_little_endian" };
    writeln!(out, "ply\nformat {encoding} 1.0\ncomment Caustica {}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "element vertex {n}")?;
    for column in &columns {
        for name in column.names {
            writeln!(out, "property {} {name}", if column.is_single_precision { "float" } else { "double" })?;
        }
    }
    writeln!(out, "element face {}\nproperty list uchar int vertex_indices\nend_header", mesh.triangles.len())?;
    for v in 0..n {
        let mut gap = "";
        for column in &columns {
            for x in &(column.get)(v)[..column.names.len()] {
                match (text, column.is_single_precision) {
                    (true, true) => write!(out, "{gap}{}", ShortestDecimal(*x as f32))?,
                    (true, false) => write!(out, "{gap}{}", ShortestDecimal(*x))?,
                    (false, true) => out.write_all(&(*x as f32).to_le_bytes())?,
                    (false, false) => out.write_all(&x.to_le_bytes())?,
                }
                gap = " ";
            }
        }
        if text {
            writeln!(out)?;
        }
    }
    for [a, b, c] in &mesh.triangles {
        if text {
            writeln!(out, "3 {a} {b} {c}")?;
        } else {
            out.write_all(&[3])?;
            for v in [a, b, c] {
                out.write_all(&v.to_le_bytes())?;
            }
        }
    }
    Ok(())
}
