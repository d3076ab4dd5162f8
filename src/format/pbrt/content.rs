//! Tables of meshes, textures and materials that the directives of a pbrt scene fill and use.

use super::materials::PbrtMaterials;
use super::textures::PbrtTextures;
use crate::format::import_notes::ImportNotes;
use crate::format::mesh::TriangleMesh;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Tables of meshes, textures, materials and messages that the directives of a pbrt scene fill.
pub(super) struct PbrtSceneContent {
    /// Embedded meshes, by the path to which shapes refer.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Textures that the pbrt file defines, and textures and pictures of the imported scene.
    pub textures: PbrtTextures,
    /// Materials that the pbrt file defines, and materials of the imported scene.
    pub materials: PbrtMaterials,
    /// Messages about content that is ignored, approximated or added.
    pub notes: ImportNotes,
    /// True for a scene of pbrt-v3, whose defaults and conversions differ from pbrt-v4.
    pub is_v3: bool,
}
