//! Check that a mesh bounds a solid body, which dielectric materials and media need.

use super::TriangleMesh;
use super::topology::MeshTopology;
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as Written};

/// Defect of a mesh that keeps it from bounding a solid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidDefect {
    /// The surface has open edges, so it has no inside.
    Open {
        /// Number of edges with one triangle.
        boundary_edges: usize,
    },
    /// Triangles that share an edge disagree about which side is outside.
    InconsistentWinding {
        /// Number of edges where they disagree.
        edges: usize,
    },
    /// All triangles agree, but their outer side faces the enclosed volume.
    InsideOut,
}

impl Display for SolidDefect {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        match self {
            Self::Open { boundary_edges: 1 } => f.write_str("it is open at 1 edge"),
            Self::Open { boundary_edges } => write!(f, "it is open at {boundary_edges} edges"),
            Self::InconsistentWinding { edges: 1 } => {
                f.write_str("its triangles disagree about the outer side at 1 edge")
            }
            Self::InconsistentWinding { edges } => {
                write!(f, "its triangles disagree about the outer side at {edges} edges")
            }
            Self::InsideOut => f.write_str("it is inside out"),
        }
    }
}

/// Bytes of memory per triangle that [`TriangleMesh::solid_defect`] takes.
pub const SOLID_CHECK_BYTES: u64 = 120;

impl TriangleMesh {
    /// First defect that keeps the mesh from bounding a solid body; `None` if the mesh is closed
    /// and faces outward.
    ///
    /// Shading normals decide which side of a triangle is outside, and the winding decides for
    /// triangles without normals. The renderer uses this rule too. Triangles with two corners at
    /// one position are ignored.
    #[must_use]
    pub fn solid_defect(&self) -> Option<SolidDefect> {
        let topology = MeshTopology::new(self);
        let flipped: Vec<bool> = self.triangles.iter().map(|t| self.normals_oppose_winding(*t)).collect();
        let (mut open, mut inconsistent) = (0, 0);
        for half_edges in topology.half_edges_by_edge() {
            let forward = half_edges
                .iter()
                .filter(|half_edge| half_edge.is_forward != flipped[half_edge.triangle as usize])
                .count();
            open += usize::from(half_edges.len() == 1);
            inconsistent += usize::from(half_edges.len() > 1 && 2 * forward != half_edges.len());
        }
        if open > 0 {
            return Some(SolidDefect::Open { boundary_edges: open });
        }
        if inconsistent > 0 {
            return Some(SolidDefect::InconsistentWinding { edges: inconsistent });
        }
        // An origin near the mesh keeps cancellation small.
        let origin = self.triangles.first().map_or(DVec3::ZERO, |t| self.positions[t[0] as usize]);
        let six_volumes = self.triangles.iter().zip(&flipped).map(|(t, flipped)| {
            let [a, b, c] = t.map(|v| self.positions[v as usize] - origin);
            let six = a.dot(b.cross(c));
            if *flipped { -six } else { six }
        });
        (six_volumes.sum::<f64>() < 0.0).then_some(SolidDefect::InsideOut)
    }

    /// True if the sum of the corners' shading normals points to the back of the winding.
    fn normals_oppose_winding(&self, triangle: [u32; 3]) -> bool {
        let Some(normals) = &self.normals else { return false };
        let sum: DVec3 = triangle.iter().map(|v| normals[*v as usize]).sum();
        sum.dot(self.face_normal(triangle)) < 0.0
    }
}
