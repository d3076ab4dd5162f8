//! Meshes, textures and materials that the directives of a pbrt scene share.

use super::materials::PbrtMaterials;
use super::textures::PbrtTextures;
use crate::format::import_notes::ImportNotes;
use crate::format::mesh::TriangleMesh;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Meshes, textures, materials and messages collected while the directives of a pbrt scene are
/// read.
pub(super) struct PbrtSceneContent {
    /// Embedded meshes, by the path to which shapes refer.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Textures that the pbrt file defines, and textures and pictures of the imported scene.
    pub textures: PbrtTextures,
    /// Materials that the pbrt file defines, and materials of the imported scene.
    pub materials: PbrtMaterials,
    /// Messages about content that is ignored, approximated or added.
    pub notes: ImportNotes,
    /// True for a scene of pbrt-v3. There, spectra of lights are radiance; in pbrt-v4 they are
    /// normalized.
    pub is_v3: bool,
}
