//! Converts primitives of a glTF file to triangle meshes.

use super::accessors::GltfBuffers;
use super::context::{FileContext, ReadResult};
use crate::format::import_notes::ImportNotes;
use crate::format::mesh::{TriangleMesh, unit_normal};
use glam::{DVec2, DVec3, DVec4};
use gltf::mesh::Mode;
use gltf::{Primitive, Semantic};

/// Estimated memory that the import of a primitive takes for each of its vertices, and again for
/// each of its triangle corners \[bytes]. It includes the merging of equal vertices.
const MEMORY_PER_CORNER: u64 = 200;

/// Converts a primitive to a triangle mesh; `None` if it has no triangles.
///
/// `texcoord_set` is the index of the texture coordinates that the material uses (`TEXCOORD_0`, …);
/// `None` if the material uses none. `place` is the name of the primitive in messages.
pub(super) fn read_primitive(
    buffers: &GltfBuffers<'_>,
    context: &FileContext<'_>,
    primitive: &Primitive<'_>,
    (place, texcoord_set): (&str, Option<u32>),
    notes: &mut ImportNotes,
) -> ReadResult<Option<TriangleMesh>> {
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        notes.add_unsupported("points and lines are left out", place);
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        notes.add_unsupported("primitives without positions are left out", place);
        return Ok(None);
    };
    let name = |attribute: &str| format!("{place}.attributes.{attribute}");
    let positions: Vec<[f64; 3]> = buffers.read_accessor(&positions)?.vector_elements(context, &name("POSITION"))?;
    let corners: Vec<u32> = match primitive.indices() {
        Some(indices) => buffers.read_indices(&indices)?,
        None => (0..positions.len() as u32).collect(),
    };
    if let Some(index) = corners.iter().find(|index| **index as usize >= positions.len()) {
        let message = format!("index {index} is out of range: there are {} vertices", positions.len());
        return Err(context.error(format!("{place}.indices"), message));
    }
    context.check_memory(MEMORY_PER_CORNER * (positions.len() + 3 * corners.len()) as u64)?;
    let check_count = |place: String, count: usize| {
        let message = format!("{count} elements for {} positions", positions.len());
        if count == positions.len() { Ok(()) } else { Err(context.error(place, message)) }
    };
    let normals = match primitive.get(&Semantic::Normals) {
        Some(accessor) => {
            let normals: Vec<[f64; 3]> = buffers.read_accessor(&accessor)?.vector_elements(context, &name("NORMAL"))?;
            check_count(name("NORMAL"), normals.len())?;
            Some(normals.into_iter().map(|n| unit_normal(n.into())).collect::<Vec<DVec3>>())
        }
        None => None,
    };
    let texcoords = match texcoord_set.map(|set| (set, primitive.get(&Semantic::TexCoords(set)))) {
        Some((set, Some(accessor))) => {
            let name = name(&format!("TEXCOORD_{set}"));
            let texcoords: Vec<[f64; 2]> = buffers.read_accessor(&accessor)?.vector_elements(context, &name)?;
            check_count(name, texcoords.len())?;
            // In glTF, v grows downwards; in Caustica, it grows upwards.
            Some(texcoords.into_iter().map(|[u, v]| DVec2::new(u, 1.0 - v)).collect())
        }
        Some((_, None)) => {
            notes.add_unsupported("texture coordinates are missing: the surface shows one pixel", place);
            Some(vec![DVec2::ZERO; positions.len()])
        }
        None => None,
    };
    let mut mesh = TriangleMesh {
        positions: positions.into_iter().map(DVec3::from).collect(),
        triangles: triangles_of_mode(mode, &corners),
        normals,
        texcoords,
        ..TriangleMesh::default()
    };
    mesh.merge_equal_vertices();
    Ok((!mesh.triangles.is_empty()).then_some(mesh))
}

/// Returns the triangles of a triangle list, strip or fan with the vertex indices `corners`.
fn triangles_of_mode(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let oriented_triangle =
                |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] };
            corners.windows(3).enumerate().map(oriented_triangle).collect()
        }
        Mode::TriangleFan => match corners {
            [center, rim @ ..] => rim.windows(2).map(|edge| [edge[0], edge[1], *center]).collect(),
            [] => Vec::new(),
        },
        _ => corners.as_chunks().0.to_vec(),
    }
}

/// Returns the mean color and alpha of all vertices; `None` if the primitive has no vertex colors.
///
/// Each color is clamped to \[0, 1] first. Colors without alpha have alpha 1.
pub(super) fn mean_vertex_color(
    buffers: &GltfBuffers<'_>,
    context: &FileContext<'_>,
    primitive: &Primitive<'_>,
    place: &str,
) -> ReadResult<Option<DVec4>> {
    let Some(accessor) = primitive.get(&Semantic::Colors(0)) else { return Ok(None) };
    let place = format!("{place}.attributes.COLOR_0");
    let values = buffers.read_accessor(&accessor)?;
    let colors: Vec<DVec4> = if values.components_per_element == 3 {
        values.vector_elements::<3>(context, &place)?.into_iter().map(|c| DVec3::from(c).extend(1.0)).collect()
    } else {
        values.vector_elements::<4>(context, &place)?.into_iter().map(DVec4::from).collect()
    };
    let sum: DVec4 = colors.iter().map(|color| color.clamp(DVec4::ZERO, DVec4::ONE)).sum();
    Ok((!colors.is_empty()).then(|| sum / colors.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_orientation() {
        assert_eq!(triangles_of_mode(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(triangles_of_mode(Mode::TriangleFan, &[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(triangles_of_mode(Mode::Triangles, &[0, 1, 2, 3]), [[0, 1, 2]]);
        assert!(triangles_of_mode(Mode::TriangleFan, &[]).is_empty());
    }
}
