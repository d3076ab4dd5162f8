//! Splitting of a mesh into parts with one material each.

use super::TriangleMesh;

const UNASSIGNED: u32 = u32::MAX;

impl TriangleMesh {
    /// Splits the mesh by material; returns pairs of material index and part.
    ///
    /// Pairs are in the order of the first triangle of each material. Triangles without material
    /// have index [`NO_MATERIAL`](super::NO_MATERIAL). Parts have empty lists of materials.
    #[must_use]
    pub fn split_by_material(&self) -> Vec<(u32, Self)> {
        let number = |t: usize| self.triangle_materials.get(t).copied().unwrap_or(super::NO_MATERIAL);
        let mut order: Vec<usize> = (0..self.triangles.len()).collect();
        // The sort is stable: triangles of one material stay in order.
        order.sort_by_key(|t| number(*t));
        let mut known = vec![UNASSIGNED; self.positions.len()];
        let mut parts: Vec<(usize, u32, Self)> = Vec::new();
        for group in order.chunk_by(|a, b| number(*a) == number(*b)) {
            let mut part = Self::default();
            let mut used: Vec<u32> = Vec::new();
            for t in group {
                let triangle = self.triangles[*t].map(|v| {
                    let number = &mut known[v as usize];
                    if *number == UNASSIGNED {
                        *number = used.len() as u32;
                        used.push(v);
                    }
                    *number
                });
                part.triangles.push(triangle);
            }
            part.positions = used.iter().map(|v| self.positions[*v as usize]).collect();
            if let Some(normals) = &self.normals {
                part.normals = Some(used.iter().map(|v| normals[*v as usize]).collect());
            }
            if let Some(texcoords) = &self.texcoords {
                part.texcoords = Some(used.iter().map(|v| texcoords[*v as usize]).collect());
            }
            used.iter().for_each(|v| known[*v as usize] = UNASSIGNED);
            parts.push((group[0], number(group[0]), part));
        }
        parts.sort_by_key(|(first, ..)| *first);
        parts.into_iter().map(|(_, number, part)| (number, part)).collect()
    }
}
