//! Meshes of Mitsuba scenes: reads OBJ, PLY and `.serialized` files, and makes cubes and spheres.

use super::context::ImportContext;
use super::files::ReadResult;
use super::names::snake_case;
use super::serialized;
use super::tree::MitsubaObject;
use crate::format::SceneError;
use crate::format::import::SceneReadError;
use crate::format::mesh::{self, LoadedMesh, NO_MATERIAL, TriangleMesh};
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Relation between the texture coordinates (u, v) of a shape in Caustica and in Mitsuba.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TexcoordConvention {
    /// Both have equal u and v.
    ///
    /// Pictures still need a flip: v = 0 is their top in Mitsuba, and their bottom in Caustica.
    Same,
    /// Both have equal u, and v in Caustica is 1 minus v in Mitsuba.
    FlippedV,
}

/// Distance between the mesh of a thin pane and its smaller copy, which bounds the medium inside
/// the pane. The unit is the diagonal of the mesh's bounds.
const RELATIVE_INNER_DISTANCE: f64 = 1e-4;

/// Estimated memory of a triangle that shares no vertices with other triangles \[bytes].
const MEMORY_PER_SPLIT_TRIANGLE: u64 = 3 * 64;

/// Mesh from the file of a shape, or a part of such a mesh: all faces of one BSDF.
pub(super) struct MitsubaFileMesh {
    /// Vertices and triangles, before parameters of the shape, such as `flip_normals`, apply.
    triangles: TriangleMesh,
    /// True if the file asks for flat faces.
    is_flat: bool,
    /// True if the file repeats vertices instead of sharing them between faces.
    is_split: bool,
}

/// Key of an embedded mesh: the mesh in a file, and how the importer changes it.
#[derive(PartialEq, Eq, Hash)]
struct FileMeshKey {
    file: PathBuf,
    /// Number of the mesh in the file, from 0.
    index: usize,
    /// Flags for flat faces and reversed orientation: see [`orientation_flags`].
    flags: [bool; 2],
    /// Convention for the texture coordinates that the importer adds; `None` if the material of the
    /// shape needs no texture coordinates.
    texcoords: Option<TexcoordConvention>,
}

/// Embedded meshes of the imported scene so far.
///
/// Each mesh of a file is embedded at most once for each combination of `face_normals`,
/// `flip_normals` and the texture coordinates that the importer adds.
#[derive(Default)]
pub(super) struct MitsubaMeshes {
    /// Embedded meshes by path.
    pub embedded: BTreeMap<String, Arc<TriangleMesh>>,
    /// Paths of the embedded meshes that come from files. A key states the mesh in its file, and
    /// how the importer changed it.
    file_mesh_paths: HashMap<FileMeshKey, String>,
    /// Paths of the smaller copies that bound media inside thin panes, by the path of the original
    /// mesh.
    shrunken_copy_paths: HashMap<String, String>,
    cube_path: Option<String>,
    inward_sphere_path: Option<String>,
}

impl MitsubaMeshes {
    /// Returns the path of the embedded mesh of a shape's file. The first call for a mesh reads and
    /// embeds it.
    ///
    /// `texcoords` is the convention for texture coordinates that are added to a mesh without any;
    /// `None` if the material of the shape needs none.
    pub fn embed_mesh_file(
        &mut self,
        context: &ImportContext<'_>,
        shape: &MitsubaObject,
        texcoords: Option<TexcoordConvention>,
    ) -> ReadResult<String> {
        let (file, index) = mesh_file(context, shape)?;
        let key = |texcoords| FileMeshKey { file: file.clone(), index, flags: orientation_flags(shape), texcoords };
        if let Some(path) = self.file_mesh_paths.get(&key(texcoords)) {
            return Ok(path.clone());
        }
        let mesh = read_mesh_file(context, shape, &file, index)?;
        let has_own_texcoords = mesh.triangles.texcoords.is_some();
        let path = self.embed_mesh_part(context, shape, mesh, texcoords)?;
        if has_own_texcoords {
            let needs = [None, Some(TexcoordConvention::Same), Some(TexcoordConvention::FlippedV)];
            self.file_mesh_paths.extend(needs.map(|texcoords| (key(texcoords), path.clone())));
        } else {
            self.file_mesh_paths.insert(key(texcoords), path.clone());
        }
        Ok(path)
    }

    /// Applies the parameters of a shape to `mesh`, embeds the result, and returns its path.
    ///
    /// A mesh without normals gets smooth ones, unless its faces are flat, or its file repeats the
    /// vertices for each face. A mesh without texture coordinates gets Mitsuba's default
    /// coordinates, unless `texcoords` is `None`.
    pub fn embed_mesh_part(
        &mut self,
        context: &ImportContext<'_>,
        shape: &MitsubaObject,
        mesh: MitsubaFileMesh,
        texcoords: Option<TexcoordConvention>,
    ) -> ReadResult<String> {
        let MitsubaFileMesh { mut triangles, is_flat, is_split } = mesh;
        if shape.number("max_smooth_angle").is_some() {
            context.add_note("`max_smooth_angle` is ignored: normals are those of the file", shape);
        }
        let [has_flat_faces, flips_normals] = orientation_flags(shape);
        // For a mesh without normals, Mitsuba computes smooth ones across all faces that share a
        // vertex.
        match triangles.normals {
            _ if has_flat_faces || is_flat => triangles.normals = None,
            None if !is_split => triangles.compute_missing_smooth_normals(180.0),
            None => context.add_note("meshes without normals that repeat vertices have flat faces", shape),
            Some(_) => {}
        }
        if let Some(convention) = texcoords.filter(|_| triangles.texcoords.is_none()) {
            let needed = MEMORY_PER_SPLIT_TRIANGLE * triangles.triangles.len() as u64;
            context.files.check_memory(context.files.path, needed)?;
            add_barycentric_texcoords(&mut triangles, convention);
        }
        if flips_normals {
            triangles.reverse_orientation();
        }
        triangles.materials.clear();
        triangles.triangle_materials.clear();
        Ok(self.embed_mesh(triangles))
    }

    /// Returns the path of an embedded mesh of the cube \[−1, 1]³. The first call embeds this mesh.
    ///
    /// The texture coordinates of each side cover \[0, 1]².
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

    /// Returns the path of an embedded mesh of the unit sphere with inward normals. The first call
    /// embeds this mesh.
    ///
    /// Texture coordinates are u = φ / 2π and v = 1 − θ / π. Here, θ is the angle from the z
    /// axis, and φ is the angle about it.
    pub fn inward_sphere_path(&mut self) -> String {
        const STACKS: u32 = 128;
        const SLICES: u32 = 2 * STACKS;
        if let Some(path) = &self.inward_sphere_path {
            return path.clone();
        }
        let mut sphere = TriangleMesh::default();
        let mut texcoords = Vec::new();
        for stack in 0..=STACKS {
            let theta = std::f64::consts::PI * f64::from(stack) / f64::from(STACKS);
            for slice in 0..=SLICES {
                let phi = std::f64::consts::TAU * f64::from(slice % SLICES) / f64::from(SLICES);
                let ring = if stack % STACKS == 0 { 0.0 } else { libm::sin(theta) };
                sphere.positions.push(DVec3::new(ring * libm::cos(phi), ring * libm::sin(phi), libm::cos(theta)));
                // Each triangle at a pole has its own pole vertex, with u between its other two.
                let shift = [(0, 0.5), (STACKS, -0.5)].iter().find(|(row, _)| *row == stack).map_or(0.0, |row| row.1);
                let u = (f64::from(slice) + shift) / f64::from(SLICES);
                texcoords.push(DVec2::new(u, 1.0 - f64::from(stack) / f64::from(STACKS)));
            }
        }
        for stack in 0..STACKS {
            for slice in 0..SLICES {
                let vertex = |row: u32, column: u32| row * (SLICES + 1) + column;
                let [a, b] = [vertex(stack, slice), vertex(stack, slice + 1)];
                let [c, d] = [vertex(stack + 1, slice), vertex(stack + 1, slice + 1)];
                // At the poles, a ring is a single point. Skip the triangle of each quad without
                // area.
                if stack > 0 {
                    sphere.triangles.push([a, b, d]);
                }
                if stack + 1 < STACKS {
                    sphere.triangles.push([a, d, c]);
                }
            }
        }
        sphere.texcoords = Some(texcoords);
        sphere.normals = Some(sphere.positions.iter().map(|p| -p.normalize()).collect());
        sphere.merge_equal_vertices();
        let path = self.embed_mesh(sphere);
        self.inward_sphere_path = Some(path.clone());
        path
    }

    /// Returns the path of a slightly smaller copy of the embedded mesh `path`, just inside it. The
    /// first call for a mesh embeds its copy.
    ///
    /// The copy bounds the medium inside a thin pane, because a pane cannot bound a medium.
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

/// Returns the texture-coordinate convention of a shape from a mesh file: whether v in Caustica
/// equals v in Mitsuba, or is 1 minus it.
pub(super) fn file_texcoord_convention(shape: &MitsubaObject) -> TexcoordConvention {
    // Mitsuba flips v of OBJ files by default, because v grows upwards in OBJ.
    let is_flipped = shape.boolean("flip_tex_coords", shape.plugin == "obj");
    if is_flipped { TexcoordConvention::FlippedV } else { TexcoordConvention::Same }
}

/// Reads the OBJ file of a shape with several BSDFs, and splits the mesh by BSDF.
///
/// Returns each part with the index of its BSDF in `bsdf_names`; `None` for faces without a BSDF.
/// Faces of an OBJ material have the BSDF of the same name. All other faces have the BSDF with an
/// empty name, if there is one.
pub(super) fn read_obj_parts(
    context: &ImportContext<'_>,
    shape: &MitsubaObject,
    bsdf_names: &[&str],
) -> ReadResult<Vec<(Option<usize>, MitsubaFileMesh)>> {
    let (file, index) = mesh_file(context, shape)?;
    let MitsubaFileMesh { triangles: mut mesh, is_flat, is_split } = read_mesh_file(context, shape, &file, index)?;
    let bsdf_called = |name: &str| bsdf_names.iter().position(|bsdf_name| *bsdf_name == name);
    let others = bsdf_called("").map_or(NO_MATERIAL, |bsdf| bsdf as u32);
    // The importer stores names of objects in snake case.
    let bsdf_of_material = |material: &String| bsdf_called(&snake_case(material)).map_or(others, |bsdf| bsdf as u32);
    let bsdfs: Vec<u32> = mesh.materials.iter().map(bsdf_of_material).collect();
    let bsdf_of_triangle = |t: usize| {
        let material = mesh.triangle_materials.get(t).copied().unwrap_or(NO_MATERIAL);
        bsdfs.get(material as usize).copied().unwrap_or(others)
    };
    mesh.triangle_materials = (0..mesh.triangles.len()).map(bsdf_of_triangle).collect();
    let parts = mesh.split_by_material().into_iter().map(|(bsdf, triangles)| {
        let bsdf = (bsdf != NO_MATERIAL).then_some(bsdf as usize);
        (bsdf, MitsubaFileMesh { triangles, is_flat, is_split })
    });
    Ok(parts.collect())
}

/// Returns the path of a shape's mesh file, and the index of the mesh in the file (`shape_index`).
fn mesh_file(context: &ImportContext<'_>, shape: &MitsubaObject) -> ReadResult<(PathBuf, usize)> {
    let Some(name) = shape.text("filename") else {
        return Err(shape.place.error("this mesh has no file", "give it a `filename`"));
    };
    let file = context.files.find_file(name, &shape.place)?;
    let index = shape.number("shape_index").unwrap_or(0.0);
    if !(0.0..1e9).contains(&index) {
        return Err(shape.place.error("the number of the mesh is negative or too large", "correct `shape_index`"));
    }
    Ok((file, index as usize))
}

/// Returns whether the faces of the shape are flat (`face_normals`), and whether its orientation is
/// reversed (`flip_normals`).
fn orientation_flags(shape: &MitsubaObject) -> [bool; 2] {
    ["face_normals", "flip_normals"].map(|name| shape.boolean(name, false))
}

/// Reads the mesh with number `index` of a file. Only `.serialized` files have several meshes.
fn read_mesh_file(
    context: &ImportContext<'_>,
    shape: &MitsubaObject,
    file: &Path,
    index: usize,
) -> ReadResult<MitsubaFileMesh> {
    if shape.plugin != "serialized" {
        let loaded = mesh::load_with_memory_limit(file, context.files.monitor, context.files.free_memory());
        let loaded: LoadedMesh = loaded.map_err(|error| mesh_error(shape, &error))?;
        let is_split = loaded.repeated_vertex_count() > 0;
        return Ok(MitsubaFileMesh { triangles: loaded.mesh, is_flat: false, is_split });
    }
    let bytes = context.files.read_file(file)?;
    let free = context.files.free_memory().map(|free| free.saturating_sub(bytes.len() as u64));
    let name = shape.text("filename").unwrap_or_default();
    let damaged = |defect| shape.place.error(format!("`{name}`: {defect}"), "export the mesh again");
    let mut decoded = serialized::decode(&bytes, index, free).map_err(damaged)?;
    let mut is_used = vec![false; decoded.mesh.positions.len()];
    for vertex in decoded.mesh.triangles.iter().flatten() {
        is_used.get_mut(*vertex as usize).into_iter().for_each(|used| *used = true);
    }
    let used = is_used.into_iter().filter(|used| *used).count();
    decoded.mesh.merge_equal_vertices();
    let is_split = decoded.mesh.distinct_position_indices().1 < used;
    Ok(MitsubaFileMesh { triangles: decoded.mesh, is_flat: decoded.uses_flat_faces, is_split })
}

/// Gives each triangle the texture coordinates (0, 0), (1, 0) and (0, 1), which Mitsuba uses for
/// meshes without any.
///
/// A shared vertex is split if its triangles need different coordinates. With the convention
/// `FlippedV`, 1 − v is stored instead of v.
fn add_barycentric_texcoords(mesh: &mut TriangleMesh, convention: TexcoordConvention) {
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    mesh.positions = corners.iter().map(|v| mesh.positions[*v as usize]).collect();
    mesh.normals = mesh.normals.take().map(|normals| corners.iter().map(|v| normals[*v as usize]).collect());
    let unflipped = [DVec2::ZERO, DVec2::X, DVec2::Y];
    let texcoords = match convention {
        TexcoordConvention::Same => unflipped,
        TexcoordConvention::FlippedV => unflipped.map(|uv| DVec2::new(uv.x, 1.0 - uv.y)),
    };
    mesh.texcoords = Some(texcoords.iter().copied().cycle().take(corners.len()).collect());
    mesh.triangles = (0..corners.len() as u32).step_by(3).map(|v| [v, v + 1, v + 2]).collect();
    mesh.merge_equal_vertices();
}

/// Converts `error`, a defect of a mesh file, to a scene error at the position of `shape`, the
/// object that names the file.
fn mesh_error(shape: &MitsubaObject, error: &mesh::MeshError) -> SceneReadError {
    let help = "repair the mesh or name another";
    let place = &shape.place;
    let described = SceneError::error_at_span(&place.source, place.span, error.to_string(), "this mesh", help);
    let is_memory = matches!(error, mesh::MeshError::OutOfMemory { .. });
    if is_memory { described.marked_out_of_memory().into() } else { described.into() }
}
