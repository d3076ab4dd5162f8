//! Content that the shapes, materials and lights of a pbrt scene share.

use super::materials::Materials;
use super::textures::Textures;
use crate::format::import_notes::ImportNotes;
use crate::format::mesh::TriangleMesh;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Content that objects of a scene share while directives are read.
pub(super) struct SceneContent {
    /// Meshes, by path.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Textures and pictures.
    pub textures: Textures,
    /// Materials of the scene and of the description.
    pub materials: Materials,
    /// Messages about the scene.
    pub notes: ImportNotes,
    /// True if the file has the spellings of pbrt-v3, whose spectra of light keep their unit.
    pub is_v3: bool,
}
