//! Mending meshes.

use super::TriangleMesh;
use super::topology::Topology;
use serde::Serialize;

/// What is mended. In the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Repair {
    /// Vertices at most this far apart become one \[length]; 0 is for those at the same place.
    pub weld: Option<f64>,
    /// Triangles on the three places of an earlier one are removed.
    pub duplicates: bool,
    /// Triangles without area are removed.
    pub degenerate: bool,
    /// Windings are made to agree; see [`TriangleMesh::orient`].
    pub orient: bool,
}

impl Repair {
    /// How far apart vertices are that are taken for one, if nothing else is told, as a part of the
    /// diagonal of the mesh: below what single precision can tell.
    pub const WELD: f64 = 1e-9;
}

/// What was mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Repaired {
    /// Places that became one with others.
    pub welded: usize,
    /// Duplicate triangles removed.
    pub duplicates: usize,
    /// Triangles without area removed.
    pub degenerate: usize,
    /// Triangles turned.
    pub turned: usize,
}

impl TriangleMesh {
    /// Mends the mesh, and drops vertices that no triangle uses.
    pub fn repair(&mut self, repair: &Repair) -> Repaired {
        let mut done = Repaired::default();
        if let Some(tolerance) = repair.weld {
            done.welded = self.weld(tolerance);
        }
        if repair.duplicates {
            let duplicates = self.duplicates(&Topology::new(self));
            done.duplicates = self.remove(&duplicates);
        }
        if repair.degenerate {
            let degenerate = self.degenerate();
            done.degenerate = self.remove(&degenerate);
        }
        if repair.orient {
            done.turned = self.orient();
        }
        self.share();
        done
    }

    /// The triangles without area, but not those that close a surface: where a corner of one
    /// triangle lies on another's edge, such a needle fills the slit between them.
    fn degenerate(&self) -> Vec<bool> {
        let topology = Topology::new(self);
        let mut closing = vec![0_u8; self.triangles.len()];
        for sides in topology.edges().filter(|sides| sides.len() == 2) {
            sides.iter().for_each(|side| closing[side.triangle as usize] += 1);
        }
        self.triangles.iter().zip(closing).map(|(t, edges)| self.area(*t) == 0.0 && edges < 3).collect()
    }

    /// Removes triangles, and returns how many.
    fn remove(&mut self, unwanted: &[bool]) -> usize {
        let before = self.triangles.len();
        let mut keep = unwanted.iter().map(|unwanted| !unwanted);
        self.triangle_materials.retain(|_| keep.next().unwrap_or(true));
        let mut keep = unwanted.iter().map(|unwanted| !unwanted);
        self.triangles.retain(|_| keep.next().unwrap_or(true));
        self.drop_materials();
        before - self.triangles.len()
    }

    /// Forgets materials that no triangle has any more.
    fn drop_materials(&mut self) {
        let mut used = vec![false; self.materials.len()];
        for number in &self.triangle_materials {
            if let Some(used) = used.get_mut(*number as usize) {
                *used = true;
            }
        }
        if used.iter().all(|used| *used) {
            return;
        }
        let mut next = 0;
        let renumbered: Vec<u32> = used
            .iter()
            .map(|used| {
                next += u32::from(*used);
                next.wrapping_sub(1)
            })
            .collect();
        for number in &mut self.triangle_materials {
            *number = renumbered.get(*number as usize).copied().unwrap_or(*number);
        }
        let mut keep = used.into_iter();
        self.materials.retain(|_| keep.next().unwrap_or(true));
        if self.materials.is_empty() {
            self.triangle_materials.clear();
        }
    }
}
