//! Reads meshes of Mitsuba scenes: OBJ, PLY and `.serialized` files, and the built-in cube.

use super::context::ImportContext;
use super::files::ReadResult;
use super::serialized;
use super::tree::MitsubaObject;
use crate::format::SceneError;
use crate::format::import::SceneReadError;
use crate::format::mesh::{self, LoadedMesh, TriangleMesh};
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// Relation between a shape's texture coordinates in Caustica and in Mitsuba.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TexcoordConvention {
    /// Caustica's (u, v) equals Mitsuba's.
    ///
    /// Pictures differ nevertheless: v = 0 is their top in Mitsuba, and their bottom in Caustica.
    Same,
    /// Caustica's v is 1 − v of Mitsuba; u is equal.
    FlippedV,
}

/// Distance between a thin wall and its inner copy, relative to the diagonal of the mesh's bounds.
const RELATIVE_INNER_DISTANCE: f64 = 1e-4;

/// Embedded meshes of the imported scene so far.
///
/// Each mesh of a file is read once for each combination of `face_normals` and `flip_normals`.
#[derive(Default)]
pub(super) struct MitsubaMeshes {
    /// Embedded meshes by path.
    pub embedded: BTreeMap<String, Arc<TriangleMesh>>,
    file_mesh_paths: HashMap<(PathBuf, usize, [bool; 2]), String>,
    shrunken_copy_paths: HashMap<String, String>,
    cube_path: Option<String>,
    inward_sphere_path: Option<String>,
}

impl MitsubaMeshes {
    /// Reads the mesh file of a shape and embeds the mesh, unless this was done before.
    ///
    /// Returns the path of the embedded mesh, and the convention for its texture coordinates. A
    /// mesh without normals gets smooth ones, unless it asks for flat faces or repeats vertices.
    pub fn embed_mesh_file(
        &mut self,
        context: &ImportContext<'_>,
        shape: &MitsubaObject,
    ) -> ReadResult<(String, TexcoordConvention)> {
        let Some(name) = shape.text("filename") else {
            return Err(shape.place.error("this mesh has no file", "give it a `filename`"));
        };
        // Mitsuba flips v of OBJ files by default, because v grows upwards in OBJ.
        let is_obj = shape.plugin == "obj";
        let turns = shape.boolean("flip_tex_coords", is_obj);
        let convention = if turns { TexcoordConvention::FlippedV } else { TexcoordConvention::Same };
        let file = context.files.find_file(name, &shape.place)?;
        let index = shape.number("shape_index").unwrap_or(0.0);
        if !(0.0..1e9).contains(&index) {
            return Err(shape.place.error("the number of the mesh is negative or too large", "correct `shape_index`"));
        }
        let flags = [shape.boolean("face_normals", false), shape.boolean("flip_normals", false)];
        let key = (file.clone(), index as usize, flags);
        if let Some(path) = self.file_mesh_paths.get(&key) {
            return Ok((path.clone(), convention));
        }
        let (mut triangles, is_flat, is_split) = if shape.plugin == "serialized" {
            let bytes = context.files.read_file(&file)?;
            let free = context.files.free_memory().map(|free| free.saturating_sub(bytes.len() as u64));
            let decoded = serialized::decode(&bytes, index as usize, free);
            let damaged = |defect| shape.place.error(format!("`{name}`: {defect}"), "export the mesh again");
            let mut decoded = decoded.map_err(damaged)?;
            let mut is_used = vec![false; decoded.mesh.positions.len()];
            for vertex in decoded.mesh.triangles.iter().flatten() {
                is_used.get_mut(*vertex as usize).into_iter().for_each(|used| *used = true);
            }
            let used = is_used.into_iter().filter(|used| *used).count();
            decoded.mesh.merge_equal_vertices();
            let is_split = decoded.mesh.distinct_position_indices().1 < used;
            (decoded.mesh, decoded.uses_flat_faces, is_split)
        } else {
            let loaded = mesh::load_with_memory_limit(&file, context.files.monitor, context.files.free_memory());
            let loaded: LoadedMesh = loaded.map_err(|error| mesh_error(shape, &error))?;
            let is_split = loaded.repeated_vertex_count() > 0;
            (loaded.mesh, false, is_split)
        };
        if shape.number("max_smooth_angle").is_some() {
            context.add_note("`max_smooth_angle` is ignored: normals are those of the file", shape);
        }
        // For a mesh without normals, Mitsuba computes smooth ones across all faces that share a
        // vertex.
        match triangles.normals {
            _ if flags[0] || is_flat => triangles.normals = None,
            None if !is_split => triangles.compute_missing_smooth_normals(180.0),
            None => context.add_note("meshes without normals that repeat vertices have flat faces", shape),
            Some(_) => {}
        }
        if flags[1] {
            triangles.reverse_orientation();
        }
        triangles.materials.clear();
        triangles.triangle_materials.clear();
        let path = self.embed_mesh(triangles);
        self.file_mesh_paths.insert(key, path.clone());
        Ok((path, convention))
    }

    /// Returns the path of an embedded mesh of the cube \[−1, 1]³. Embeds it at its first use.
    ///
    /// Each side has texture coordinates that cover the unit square.
    pub fn cube_path(&mut self) -> String {
        if let Some(path) = &self.cube_path {
            return path.clone();
        }
        let mut cube = TriangleMesh::default();
        let mut texcoords = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let side = |k: usize| DVec3::AXES[(axis + k) % 3];
                let (normal, u, v) = (side(0) * sign, side(1) * sign, side(2));
                let base = cube.positions.len() as u32;
                for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                    cube.positions.push(normal + u * (2.0 * s - 1.0) + v * (2.0 * t - 1.0));
                    texcoords.push(DVec2::new(s, t));
                }
                cube.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            }
        }
        cube.texcoords = Some(texcoords);
        let path = self.embed_mesh(cube);
        self.cube_path = Some(path.clone());
        path
    }

    /// Returns the path of an embedded mesh of the unit sphere with inward normals.
    ///
    /// Embeds it at its first use.
    pub fn inward_sphere_path(&mut self) -> String {
        const STACKS: u32 = 128;
        const SLICES: u32 = 2 * STACKS;
        if let Some(path) = &self.inward_sphere_path {
            return path.clone();
        }
        let mut sphere = TriangleMesh::default();
        for stack in 0..=STACKS {
            let theta = std::f64::consts::PI * f64::from(stack) / f64::from(STACKS);
            for slice in 0..SLICES {
                let phi = std::f64::consts::TAU * f64::from(slice) / f64::from(SLICES);
                let ring = if stack % STACKS == 0 { 0.0 } else { libm::sin(theta) };
                sphere.positions.push(DVec3::new(ring * libm::cos(phi), ring * libm::sin(phi), libm::cos(theta)));
            }
        }
        for stack in 0..STACKS {
            for slice in 0..SLICES {
                let at = |row: u32, column: u32| row * SLICES + column % SLICES;
                let [a, b] = [at(stack, slice), at(stack, slice + 1)];
                let [c, d] = [at(stack + 1, slice), at(stack + 1, slice + 1)];
                // The rings at both poles are single points, so one triangle of each quad there has
                // no area.
                if stack > 0 {
                    sphere.triangles.push([a, b, d]);
                }
                if stack + 1 < STACKS {
                    sphere.triangles.push([a, d, c]);
                }
            }
        }
        sphere.normals = Some(sphere.positions.iter().map(|p| -p.normalize()).collect());
        sphere.merge_equal_vertices();
        let path = self.embed_mesh(sphere);
        self.inward_sphere_path = Some(path.clone());
        path
    }

    /// Returns the path of a slightly smaller copy that lies just inside the embedded mesh `path`.
    ///
    /// Embeds the copy at its first use. It bounds the medium inside a thin wall, because the wall
    /// itself cannot bound a medium.
    pub fn embed_shrunken_copy(&mut self, path: &str) -> String {
        if let Some(inner) = self.shrunken_copy_paths.get(path) {
            return inner.clone();
        }
        let mut copy = self.embedded.get(path).map(|mesh| (**mesh).clone()).unwrap_or_default();
        let distance = RELATIVE_INNER_DISTANCE * copy.bounds_diagonal();
        let (indices, count) = copy.distinct_position_indices();
        let mut outward = vec![DVec3::ZERO; count];
        for triangle in &copy.triangles {
            let [a, b, c] = triangle.map(|v| copy.positions[v as usize]);
            let area = (b - a).cross(c - a);
            triangle.iter().for_each(|v| outward[indices[*v as usize] as usize] += area);
        }
        for (position, index) in copy.positions.iter_mut().zip(&indices) {
            *position -= outward[*index as usize].normalize_or_zero() * distance;
        }
        (copy.normals, copy.texcoords) = (None, None);
        copy.merge_equal_vertices();
        let inner = self.embed_mesh(copy);
        self.shrunken_copy_paths.insert(path.to_owned(), inner.clone());
        inner
    }

    fn embed_mesh(&mut self, mesh: TriangleMesh) -> String {
        let path = format!("mesh{}", self.embedded.len());
        self.embedded.insert(path.clone(), Arc::new(mesh));
        path
    }
}

/// Converts the error of a mesh file to an error at the shape that names the file.
fn mesh_error(shape: &MitsubaObject, error: &mesh::MeshError) -> SceneReadError {
    let help = "repair the mesh or name another";
    let place = &shape.place;
    let described = SceneError::error_at_span(&place.source, place.span, error.to_string(), "this mesh", help);
    let is_memory = matches!(error, mesh::MeshError::OutOfMemory { .. });
    if is_memory { described.marked_out_of_memory().into() } else { described.into() }
}
