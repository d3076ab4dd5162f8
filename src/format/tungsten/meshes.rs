//! Meshes of Tungsten scenes: reads `.wo3`, OBJ and PLY files, and makes cubes.

use super::context::ImportContext;
use super::object::{ReadResult, TungstenObject};
use super::wo3;
use crate::format::SceneError;
use crate::format::mesh::{self, TriangleMesh};
use glam::{DAffine3, DVec2, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// Greatest angle between the normals of adjacent faces over which recomputed normals are smooth
/// \[degrees]. It is that of Tungsten.
const SMOOTHING_ANGLE: f64 = 27.0;

/// Embedded meshes of the imported scene so far.
#[derive(Default)]
pub(super) struct TungstenMeshes {
    /// Embedded meshes by path.
    pub embedded: BTreeMap<String, Arc<TriangleMesh>>,
    /// Paths of the parts of embedded mesh files, each with the index of its BSDF. The key is the
    /// file, and how the importer changes its mesh.
    file_parts: HashMap<MeshFileKey, Vec<(usize, String)>>,
    cube_path: Option<String>,
}

/// Key of the embedded parts of a mesh file: the file, and how the importer changes its mesh.
#[derive(Clone, PartialEq, Eq, Hash)]
struct MeshFileKey {
    file: PathBuf,
    /// True for smooth shading; false for flat faces.
    is_smooth: bool,
    /// True if normals are computed from the faces; false if they are those of the file.
    recomputes_normals: bool,
    /// Number of BSDFs to which the mesh is divided.
    bsdf_count: usize,
}

impl TungstenMeshes {
    /// Returns the embedded mesh of the primitive `mesh`, divided among its BSDFs. Each part has
    /// the index of its BSDF and the path of its mesh.
    ///
    /// A triangle whose index exceeds the list of BSDFs has the last one, as in Tungsten.
    pub fn embed_mesh_file(
        &mut self,
        context: &ImportContext<'_>,
        object: &TungstenObject<'_>,
        bsdf_count: usize,
    ) -> ReadResult<Vec<(usize, String)>> {
        let Some(name) = object.text("file")? else {
            return Err(object.error("this mesh has no file", "state it as `file`"));
        };
        let key = MeshFileKey {
            file: context.files.find_file(name, object)?,
            is_smooth: object.boolean("smooth", false)?,
            recomputes_normals: object.boolean("recompute_normals", false)?,
            bsdf_count,
        };
        if object.boolean("backface_culling", false)? {
            context.add_note("surfaces with `backface_culling` are visible from both sides", object);
        }
        if let Some(parts) = self.file_parts.get(&key) {
            return Ok(parts.clone());
        }
        let mut mesh = read_mesh_file(context, object, name, &key)?;
        let last = bsdf_count.saturating_sub(1) as u32;
        mesh.triangle_materials.iter_mut().for_each(|bsdf| *bsdf = last.min(*bsdf));
        mesh.triangle_materials.resize(mesh.triangles.len(), 0);
        if !key.is_smooth || key.recomputes_normals {
            mesh.normals = None;
        }
        mesh.merge_equal_vertices();
        if key.is_smooth {
            mesh.compute_missing_smooth_normals(SMOOTHING_ANGLE);
        }
        let parts = mesh.split_by_material().into_iter().map(|(bsdf, part)| (bsdf as usize, self.embed_mesh(part)));
        let parts: Vec<_> = parts.collect();
        self.file_parts.insert(key, parts.clone());
        Ok(parts)
    }

    /// Returns the path of an embedded mesh of the cube \[−½, ½]³. The first call embeds it.
    ///
    /// The texture coordinates of a side across the axis k are those along the axes k + 1 and k +
    /// 2, from 0 to 1.
    pub fn cube_path(&mut self) -> String {
        if let Some(path) = &self.cube_path {
            return path.clone();
        }
        let mut cube = TriangleMesh::default();
        let mut texcoords = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let side = |k: usize| DVec3::AXES[(axis + k) % 3];
                let base = cube.positions.len() as u32;
                for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                    cube.positions.push(0.5 * sign * side(0) + (s - 0.5) * side(1) + (t - 0.5) * side(2));
                    texcoords.push(DVec2::new(s, t));
                }
                let corners = if sign > 0.0 { [0, 1, 2, 3] } else { [0, 3, 2, 1] }.map(|corner| base + corner);
                let [a, b, c, d] = corners;
                cube.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        cube.texcoords = Some(texcoords);
        let path = self.embed_mesh(cube);
        self.cube_path = Some(path.clone());
        path
    }

    /// Embeds a mesh and returns its path.
    pub fn embed_mesh(&mut self, mut mesh: TriangleMesh) -> String {
        mesh.materials.clear();
        mesh.triangle_materials.clear();
        let path = format!("mesh{}", self.embedded.len());
        self.embedded.insert(path.clone(), Arc::new(mesh));
        path
    }

    /// Returns the bounds of the embedded mesh called `path`.
    pub fn bounds(&self, path: &str) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let positions = self.embedded.get(path).into_iter().flat_map(|mesh| &mesh.positions);
        positions.fold(start, |(low, high), p| (low.min(*p), high.max(*p)))
    }

    /// Returns the area of the embedded mesh called `path` under the transform `to_world`.
    pub fn area(&self, path: &str, to_world: &DAffine3) -> f64 {
        let Some(mesh) = self.embedded.get(path) else { return 0.0 };
        let triangle_area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| to_world.transform_point3(mesh.positions[v as usize]));
            0.5 * (b - a).cross(c - a).length()
        };
        mesh.triangles.iter().map(triangle_area).sum()
    }
}

/// Reads the mesh file called `name` of the primitive `object`. The importer embeds the mesh as
/// `key` states.
fn read_mesh_file(
    context: &ImportContext<'_>,
    object: &TungstenObject<'_>,
    name: &str,
    key: &MeshFileKey,
) -> ReadResult<TriangleMesh> {
    let files = context.files;
    let extension = key.file.extension().unwrap_or_default().to_ascii_lowercase();
    if extension != "wo3" {
        let loaded = mesh::load_with_memory_limit(&key.file, files.monitor, files.free_memory());
        let mut mesh = loaded.map_err(|error| mesh_error(files, object, &error))?.mesh;
        mesh.triangle_materials.clear();
        return Ok(mesh);
    }
    let bytes = files.read_file(&key.file)?;
    let free = files.free_memory().map(|free| free.saturating_sub(bytes.len() as u64));
    wo3::decode(&bytes, free).map_err(|defect| object.error(format!("`{name}`: {defect}"), "export the mesh again"))
}

/// Converts `error`, a defect of a mesh file, to a scene error about the primitive `object`.
fn mesh_error(
    files: &super::context::TungstenSceneFiles<'_>,
    object: &TungstenObject<'_>,
    error: &mesh::MeshError,
) -> crate::format::import::SceneReadError {
    if !matches!(error, mesh::MeshError::OutOfMemory { .. }) {
        return object.error(error, "repair the mesh or name another");
    }
    let file = files.path.display().to_string();
    let message = format!("{}: {error}", object.label());
    let help = "allow more memory (--memory)";
    SceneError::error_without_position(&file, message, help).marked_out_of_memory().into()
}
