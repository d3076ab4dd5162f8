//! Splitting of a mesh into parts with one material each.

use super::TriangleMesh;

const UNASSIGNED: u32 = u32::MAX;

pub(super) fn split_by_material(mesh: &TriangleMesh) -> Vec<(u32, TriangleMesh)> {
    let number = |t: usize| mesh.triangle_materials.get(t).copied().unwrap_or(super::NO_MATERIAL);
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    // The sort is stable: triangles of one material stay in order.
    order.sort_by_key(|t| number(*t));
    let mut known = vec![UNASSIGNED; mesh.positions.len()];
    let mut parts: Vec<(usize, u32, TriangleMesh)> = Vec::new();
    for group in order.chunk_by(|a, b| number(*a) == number(*b)) {
        let mut part = TriangleMesh::default();
        let mut used: Vec<u32> = Vec::new();
        for t in group {
            let triangle = mesh.triangles[*t].map(|v| {
                let number = &mut known[v as usize];
                if *number == UNASSIGNED {
                    *number = used.len() as u32;
                    used.push(v);
                }
                *number
            });
            part.triangles.push(triangle);
        }
        part.positions = used.iter().map(|v| mesh.positions[*v as usize]).collect();
        if let Some(normals) = &mesh.normals {
            part.normals = Some(used.iter().map(|v| normals[*v as usize]).collect());
        }
        if let Some(texcoords) = &mesh.texcoords {
            part.texcoords = Some(used.iter().map(|v| texcoords[*v as usize]).collect());
        }
        used.iter().for_each(|v| known[*v as usize] = UNASSIGNED);
        parts.push((group[0], number(group[0]), part));
    }
    parts.sort_by_key(|(first, ..)| *first);
    parts.into_iter().map(|(_, number, part)| (number, part)).collect()
}
