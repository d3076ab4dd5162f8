//! Meshes, pictures and grids that a scene file itself contains.

use super::grid::DensityGridData;
use super::mesh::TriangleMesh;
use crate::image::Image;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Meshes, pictures and grids whose data the scene file itself contains. Each map's key is the path
/// by which the scene description refers to the item.
///
/// The file system is not searched for a path that is listed here.
#[derive(Clone, Debug, Default)]
pub struct EmbeddedAssets {
    /// Meshes of `TriangleMesh` shapes, by path.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Pictures of textures and lights, by path. Their values are linear.
    pub pictures: BTreeMap<String, Arc<Image>>,
    /// Density grids of media, by path.
    pub grids: BTreeMap<String, Arc<DensityGridData>>,
}

impl EmbeddedAssets {
    /// True if the scene file contains no mesh, picture or grid.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let Self { meshes, pictures, grids } = self;
        meshes.is_empty() && pictures.is_empty() && grids.is_empty()
    }

    /// True if `path` names an embedded mesh, picture or grid.
    #[must_use]
    pub fn contains(&self, path: &str) -> bool {
        self.meshes.contains_key(path) || self.pictures.contains_key(path) || self.grids.contains_key(path)
    }
}
