//! Checks that a mesh bounds a solid body. Dielectric materials and media need such bodies.

use super::TriangleMesh;
use super::normals::face_normal;
use super::topology::MeshTopology;
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as Written};

/// Reason why a mesh does not bound a solid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidDefect {
    /// The surface has open edges, so it has no inside.
    Open {
        /// Number of edges with one triangle.
        boundary_edges: usize,
    },
    /// Triangles that share an edge disagree about which of their sides is outside.
    InconsistentWinding {
        /// Number of edges whose triangles disagree about the outer side.
        edges: usize,
    },
    /// Triangles agree which side is outside, but this side faces the enclosed volume.
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

/// Memory that [`TriangleMesh::solid_defect`] takes per triangle \[bytes].
pub const SOLIDITY_BYTES_PER_TRIANGLE: u64 = 120;

pub(super) fn solid_defect(mesh: &TriangleMesh) -> Option<SolidDefect> {
    let topology = MeshTopology::new(mesh);
    let flipped: Vec<bool> = mesh.triangles.iter().map(|t| normals_oppose_winding(mesh, *t)).collect();
    let (mut open, mut inconsistent) = (0, 0);
    for half_edges in topology.half_edges_by_edge() {
        let forward =
            half_edges.iter().filter(|half_edge| half_edge.is_forward != flipped[half_edge.triangle as usize]).count();
        open += usize::from(half_edges.len() == 1);
        inconsistent += usize::from(half_edges.len() > 1 && 2 * forward != half_edges.len());
    }
    if open > 0 {
        return Some(SolidDefect::Open { boundary_edges: open });
    }
    if inconsistent > 0 {
        return Some(SolidDefect::InconsistentWinding { edges: inconsistent });
    }
    // An origin near the mesh reduces cancellation.
    let origin = mesh.triangles.first().map_or(DVec3::ZERO, |t| mesh.positions[t[0] as usize]);
    let six_volumes = mesh.triangles.iter().zip(&flipped).map(|(t, flipped)| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize] - origin);
        let six = a.dot(b.cross(c));
        if *flipped { -six } else { six }
    });
    (six_volumes.sum::<f64>() < 0.0).then_some(SolidDefect::InsideOut)
}

/// True if the sum of the shading normals at the triangle's corners points away from the triangle's
/// counter-clockwise side.
fn normals_oppose_winding(mesh: &TriangleMesh, triangle: [u32; 3]) -> bool {
    let Some(normals) = &mesh.normals else { return false };
    let sum: DVec3 = triangle.iter().map(|v| normals[*v as usize]).sum();
    sum.dot(face_normal(mesh, triangle)) < 0.0
}
