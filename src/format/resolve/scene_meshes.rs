//! Meshes of a scene as they were read, which a later version of the scene can share.

use super::placement::NormalizedMesh;
use crate::format::FileStamp;
use crate::format::mesh::{MeshOptions, NO_MATERIAL, TriangleMesh};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Key of a mesh that was read: the file, both flags of its [`MeshOptions`], and the bits of the
/// largest smoothing angle.
pub(super) type MeshKey = (PathBuf, bool, bool, Option<u64>);

/// Returns the key of the mesh that is read from `file` with `options`.
pub(super) fn mesh_key(file: &Path, options: MeshOptions) -> MeshKey {
    let MeshOptions { uses_file_materials, ignores_normals, max_smoothing_angle } = options;
    (file.to_owned(), uses_file_materials, ignores_normals, max_smoothing_angle.map(f64::to_bits))
}

/// Meshes of a scene as they were read, with the BVHs that their instances share.
///
/// When the scene is edited and built again, the next version takes over the meshes that have not
/// changed; see [`resolve_incrementally`](crate::format::SceneFile::resolve_incrementally). Meshes
/// that the next version does not use are dropped, so edits do not make the list grow.
#[derive(Clone, Default)]
pub struct SceneMeshes(HashMap<MeshKey, Arc<PreparedMesh>>);

impl std::fmt::Debug for SceneMeshes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.0.keys().map(|(file, ..)| file)).finish()
    }
}

impl SceneMeshes {
    /// Returns the mesh with this `key` if its triangles still come from an unchanged source:
    /// `source` has the same file stamp or the same embedded mesh. Otherwise returns `None`.
    pub(super) fn find_unchanged(&self, key: &MeshKey, source: &MeshSource) -> Option<Arc<PreparedMesh>> {
        self.0.get(key).filter(|mesh| mesh.source.is_unchanged(source)).cloned()
    }

    #[cfg(test)]
    pub(in crate::format) fn expect_single_part(&self) -> Arc<PreparedPart> {
        let mut parts = self.0.values().flat_map(|mesh| &mesh.parts);
        let part = parts.next().unwrap().clone();
        assert!(parts.next().is_none(), "the scene has several parts of meshes");
        part
    }

    pub(super) fn insert(&mut self, key: MeshKey, mesh: Arc<PreparedMesh>) {
        self.0.insert(key, mesh);
    }
}

/// Source of a mesh's triangles: a file or the scene file itself.
pub(super) enum MeshSource {
    /// A mesh file, with its stamp (time of change and length) from before the file was read;
    /// `None` if the system gives no stamp.
    File(Option<FileStamp>),
    /// A mesh that the scene file contains.
    Embedded(Arc<TriangleMesh>),
}

impl MeshSource {
    /// True if both sources are known to hold the same mesh: equal file stamps, or embedded meshes
    /// that are equal bit for bit.
    fn is_unchanged(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::File(Some(a)), Self::File(Some(b))) => a == b,
            (Self::Embedded(a), Self::Embedded(b)) => a.is_equal_in_bits(b),
            (Self::File(_) | Self::Embedded(_), Self::File(_) | Self::Embedded(_)) => false,
        }
    }
}

/// A mesh that was read with given [`MeshOptions`], which select its normals. The mesh is split by
/// material if the options select the materials of the file.
pub(super) struct PreparedMesh {
    source: MeshSource,
    /// Arguments of the `mtllib` lines of an OBJ file.
    pub mtllib_arguments: Vec<String>,
    /// Names of the materials that the parts refer to; empty if the mesh is not split.
    pub material_names: Vec<String>,
    pub parts: Vec<Arc<PreparedPart>>,
}

/// Triangles of a mesh file that have the same material.
pub(in crate::format) struct PreparedPart {
    pub mesh: Arc<TriangleMesh>,
    /// Index of the material in [`PreparedMesh::material_names`]; `None` for triangles that have
    /// the material that the scene text sets.
    pub material: Option<usize>,
    /// The mesh in normalized coordinates, with the BVH that all instances share. Built when the
    /// first instance is added.
    normalized: OnceLock<NormalizedMesh>,
}

impl PreparedMesh {
    /// Prepares `mesh`, which was read from `source`: drops or computes normals and splits the mesh
    /// by material, as `options` select. `libraries` are the arguments of its `mtllib` lines.
    pub fn new(mut mesh: Arc<TriangleMesh>, libraries: Vec<String>, source: MeshSource, options: MeshOptions) -> Self {
        if options.ignores_normals && mesh.normals.is_some() {
            Arc::make_mut(&mut mesh).normals = None;
        }
        if let Some(angle) = options.max_smoothing_angle {
            Arc::make_mut(&mut mesh).compute_missing_smooth_normals(angle);
        }
        if !options.uses_file_materials || mesh.materials.is_empty() {
            let parts = vec![Arc::new(PreparedPart::new(mesh, None))];
            return Self { source, mtllib_arguments: libraries, material_names: Vec::new(), parts };
        }
        let part = |(number, part): (u32, TriangleMesh)| {
            let material = (number != NO_MATERIAL).then_some(number as usize);
            Arc::new(PreparedPart::new(Arc::new(part), material))
        };
        let parts = mesh.split_by_material().into_iter().map(part).collect();
        Self { source, mtllib_arguments: libraries, material_names: mesh.materials.clone(), parts }
    }
}

impl PreparedPart {
    fn new(mesh: Arc<TriangleMesh>, material: Option<usize>) -> Self {
        Self { mesh, material, normalized: OnceLock::new() }
    }

    /// True if the BVH that the part's instances share is already built.
    pub fn has_bvh(&self) -> bool {
        self.normalized.get().is_some()
    }

    /// Returns the geometry that all instances of the part share. The first call builds it.
    pub fn normalized_mesh(&self) -> &NormalizedMesh {
        self.normalized.get_or_init(|| {
            let TriangleMesh { positions, triangles, normals, texcoords, .. } = &*self.mesh;
            NormalizedMesh::new(positions, normals.as_deref(), texcoords.as_deref(), triangles)
        })
    }
}
