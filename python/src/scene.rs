//! Scenes: loaded from files or text, planned and rendered.

use crate::errors::Failure;
use crate::render::{RenderOptions, render_scene};
use crate::rendered::NativeResult;
use caustica::format::mesh::TriangleMesh;
use caustica::format::{ImportOptions, SceneReadError};
use caustica::plan::Plan;
use caustica::stats::MemoryLimit;
use caustica::{Scene, SceneFile};
use glam::{DVec2, DVec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use std::path::PathBuf;
use std::sync::Arc;

/// A scene that was read and resolved.
#[pyclass(frozen)]
pub struct NativeScene {
    file: SceneFile,
    memory: MemoryLimit,
    /// The scene with the picture size that the file describes.
    resolved: Arc<Scene>,
}

/// Triangle mesh from Python: name, positions, triangles, normals and texture coordinates.
///
/// Positions, normals and texture coordinates are f64, triangles are u32, in native byte order.
type MeshBytes = (String, PyBackedBytes, PyBackedBytes, Option<PyBackedBytes>, Option<PyBackedBytes>);

/// Reads the scene file at `path`.
#[pyfunction]
pub fn load_file(
    py: Python<'_>,
    path: PathBuf,
    format: Option<String>,
    allows_outside_files: bool,
    memory: Option<u64>,
) -> PyResult<NativeScene> {
    let memory = memory.map_or(MemoryLimit::System, MemoryLimit::ProcessBytes);
    let options = ImportOptions { memory_limit: memory, format_extension: format, allows_outside_files };
    let read =
        || NativeScene::resolve(SceneFile::read_with_options(&path, &(), &options).map_err(Failure::Read)?, memory);
    py.detach(read).map_err(|failure| failure.into_exception(py))
}

/// Reads scene `text`, as from a file named `name` in `folder`. The text may name `meshes`.
#[pyfunction]
pub fn load_text(
    py: Python<'_>,
    text: String,
    name: String,
    folder: PathBuf,
    meshes: Vec<MeshBytes>,
    memory: Option<u64>,
) -> PyResult<NativeScene> {
    let memory = memory.map_or(MemoryLimit::System, MemoryLimit::ProcessBytes);
    let meshes = meshes.iter().map(|mesh| Ok((mesh.0.clone(), Arc::new(triangle_mesh(mesh)?))));
    let meshes = meshes.collect::<PyResult<Vec<_>>>()?;
    let read = || {
        let mut file =
            SceneFile::from_text(&name, &text, &folder).map_err(SceneReadError::from).map_err(Failure::Read)?;
        file.assets.meshes.extend(meshes);
        NativeScene::resolve(file, memory)
    };
    py.detach(read).map_err(|failure| failure.into_exception(py))
}

impl NativeScene {
    fn resolve(file: SceneFile, memory: MemoryLimit) -> Result<Self, Failure> {
        let scene = file.resolve_monitored(&(), memory).map_err(Failure::Scene)?;
        Ok(Self { file, memory, resolved: Arc::new(scene) })
    }

    /// Returns the scene with a picture of `size` (width, height).
    ///
    /// The files of the scene are read again only if the size is not the described one, and the
    /// camera moves while the shutter is open.
    pub fn resolved_for_size(&self, size: (u32, u32)) -> Result<Arc<Scene>, Failure> {
        if self.resolved.camera().size() == size {
            return Ok(Arc::clone(&self.resolved));
        }
        let mut file = self.file.clone();
        (file.description.camera.value.width, file.description.camera.value.height) = size;
        let scene = if file.description.camera.motion.is_empty() {
            self.resolved.with_camera(&file.resolve_camera().map_err(Failure::Scene)?)
        } else {
            file.resolve_monitored(&(), self.memory).map_err(Failure::Scene)?
        };
        Ok(Arc::new(scene))
    }

    /// Returns the picture size (width, height) that the scene asks for.
    pub fn described_size(&self) -> (u32, u32) {
        (self.file.description.camera.width, self.file.description.camera.height)
    }

    /// Returns the limit of the memory that loading and rendering may take.
    pub fn memory(&self) -> MemoryLimit {
        self.memory
    }
}

#[pymethods]
impl NativeScene {
    /// Width and height of the picture that the scene asks for \[pixels].
    fn size(&self) -> (u32, u32) {
        self.described_size()
    }

    /// Numbers of triangles, of other shapes and of lights.
    fn counts(&self) -> (usize, usize, usize) {
        let scene = &self.resolved;
        (scene.triangle_count(), scene.analytic_shape_count(), scene.lights().len())
    }

    /// The scene in the scene language.
    fn text(&self) -> String {
        self.file.description.to_string()
    }

    /// Warnings about content that is ignored, approximated or unused, one line each.
    fn warnings(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| [self.file.import_warnings(), self.file.warnings()].concat())
    }

    /// Decisions of the plan: effect, whether it is needed, whether it is simulated, the reason.
    fn plan(
        &self,
        py: Python<'_>,
        integrator: &str,
        effects: &str,
    ) -> PyResult<Vec<(&'static str, bool, bool, String)>> {
        let algorithm = crate::render::algorithm_by_name(integrator)?;
        let overrides =
            effects.parse().map_err(|e: caustica::plan::UnknownOverrideError| PyValueError::new_err(e.to_string()))?;
        let plan = py.detach(|| Plan::new(&self.resolved, algorithm.supported_effects(), overrides));
        let decisions = plan.decisions.iter();
        Ok(decisions.map(|d| (d.effect.name(), d.is_needed, d.is_simulated, d.reason.to_string())).collect())
    }

    /// Renders the scene. `callback` receives passes, seconds and the estimated error.
    fn render(&self, py: Python<'_>, options: RenderOptions, callback: Option<Py<PyAny>>) -> PyResult<NativeResult> {
        render_scene(py, self, &options, callback)
    }
}

/// Returns the mesh that Python described by bytes.
///
/// Raises `ValueError` if a triangle names a vertex that does not exist, or lists differ in length.
fn triangle_mesh((name, positions, triangles, normals, texcoords): &MeshBytes) -> PyResult<TriangleMesh> {
    let positions: Vec<DVec3> = numbers(positions).map(DVec3::from_array).collect();
    let triangles: Vec<[u32; 3]> =
        triangles.as_chunks::<4>().0.as_chunks::<3>().0.iter().map(|corners| corners.map(u32::from_ne_bytes)).collect();
    let normals: Option<Vec<DVec3>> = normals.as_ref().map(|bytes| numbers(bytes).map(DVec3::from_array).collect());
    let texcoords: Option<Vec<DVec2>> = texcoords.as_ref().map(|bytes| numbers(bytes).map(DVec2::from_array).collect());
    let fits = |length: Option<usize>| length.is_none_or(|length| length == positions.len());
    let indices_exist = triangles.iter().flatten().all(|index| (*index as usize) < positions.len());
    if !indices_exist || !fits(normals.as_ref().map(Vec::len)) || !fits(texcoords.as_ref().map(Vec::len)) {
        return Err(PyValueError::new_err(format!("the arrays of mesh {name} do not fit each other")));
    }
    let mut mesh = TriangleMesh { positions, triangles, normals, texcoords, ..TriangleMesh::default() };
    mesh.merge_equal_vertices();
    Ok(mesh)
}

/// Returns the f64 numbers in `bytes`, in groups of `N`.
fn numbers<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [f64; N]> {
    bytes.as_chunks::<8>().0.as_chunks::<N>().0.iter().map(|group| group.map(f64::from_ne_bytes))
}
