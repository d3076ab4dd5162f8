//! Writes meshes as OBJ text, each distinct value once.

use crate::format::mesh::{DeduplicatedList, NO_MATERIAL, ShortestDecimal, TriangleMesh, coordinate_bits};
use glam::DVec3;
use std::io::{Result, Write};

/// Writes a mesh as OBJ text with one line for each distinct position, texture coordinate and
/// normal.
///
/// `libraries` are the paths of MTL files for the `mtllib` lines.
pub(in crate::format) fn write(mesh: &TriangleMesh, libraries: &[String], out: &mut impl Write) -> Result<()> {
    writeln!(out, "# Caustica {}", env!("CARGO_PKG_VERSION"))?;
    for library in libraries {
        writeln!(out, "mtllib {library}")?;
    }
    let (position_indices, positions) = deduplicate_keys(mesh.positions.iter().map(|p| coordinate_bits(*p)));
    for [x, y, z] in positions {
        writeln!(
            out,
            "v {} {} {}",
            shortest_decimal_from_bits(x),
            shortest_decimal_from_bits(y),
            shortest_decimal_from_bits(z)
        )?;
    }
    let texcoords = mesh.texcoords.as_deref().unwrap_or_default();
    let (texcoord_indices, texcoords) = deduplicate_keys(texcoords.iter().map(|t| t.to_array().map(f64::to_bits)));
    for [s, t] in texcoords {
        writeln!(out, "vt {} {}", shortest_decimal_from_bits(s), shortest_decimal_from_bits(t))?;
    }
    let normals = mesh.normals.as_deref().unwrap_or_default();
    let (normal_indices, distinct_normals) = deduplicate_keys(normals.iter().map(|n| coordinate_bits(*n)));
    for [x, y, z] in distinct_normals {
        writeln!(
            out,
            "vn {} {} {}",
            shortest_decimal_from_bits(x),
            shortest_decimal_from_bits(y),
            shortest_decimal_from_bits(z)
        )?;
    }
    let mut material = NO_MATERIAL;
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        let own = mesh.triangle_materials.get(i).copied().unwrap_or(NO_MATERIAL);
        if own != material {
            material = own;
            writeln!(out, "usemtl {}", mesh.materials.get(own as usize).map_or("", String::as_str))?;
        }
        let smooth = !normals.is_empty() && triangle.iter().all(|v| normals[*v as usize] != DVec3::ZERO);
        out.write_all(b"f")?;
        for v in triangle.map(|v| v as usize) {
            let position = position_indices[v] + 1;
            match (texcoord_indices.get(v), smooth) {
                (None, false) => write!(out, " {position}")?,
                (None, true) => write!(out, " {position}//{}", normal_indices[v] + 1)?,
                (Some(t), false) => write!(out, " {position}/{}", t + 1)?,
                (Some(t), true) => write!(out, " {position}/{}/{}", t + 1, normal_indices[v] + 1)?,
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Gives each distinct key an index, counted from 0. Returns the index of each of `keys`, and the
/// list of distinct keys.
fn deduplicate_keys<const N: usize>(keys: impl ExactSizeIterator<Item = [u64; N]>) -> (Vec<u32>, Vec<[u64; N]>) {
    let mut distinct = DeduplicatedList::with_capacity(keys.len());
    let list = keys.map(|key| distinct.find_or_append(key, |key| *key)).collect();
    (list, distinct.into_values())
}

fn shortest_decimal_from_bits(bits: u64) -> ShortestDecimal<f64> {
    ShortestDecimal(f64::from_bits(bits))
}
