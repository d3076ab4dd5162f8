//! `caustica mesh`: inspects, repairs and converts a mesh file.

mod args;
mod text;

pub use args::MeshArguments;

use super::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use super::progress::{ProgressDisplay, print_message};
use super::{CommandFailure, Exit};
use crate::format::mesh::{
    self, LoadedMesh, MeshError, MeshFormat, MeshRepairOptions, MeshReport, RepairCounts, TriangleMesh,
};
use crate::format::mtl;
use crate::image::{check_replaceable, parent_folder};
use crate::stats::MemoryLimit;
use glam::DVec3;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Error: the extension of the output path is not that of a mesh format.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` has no extension of a mesh format that can be written", path.display())]
#[diagnostic(help("give it the extension .obj or .ply"))]
struct UnknownMeshFormatError {
    path: PathBuf,
}

/// Error: the requested changes leave no triangle, or make coordinates too large.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum InvalidMeshResultError {
    #[error("the repair leaves no triangle of `{}`", .0.display())]
    #[diagnostic(help("choose a smaller --weld, or keep triangles without area"))]
    Triangles(PathBuf),
    #[error("the coordinates of `{}` are too large after the change", .0.display())]
    #[diagnostic(help("choose a smaller --scale or --translate"))]
    Coordinates(PathBuf),
}

/// JSON report of `caustica mesh`.
#[derive(Debug, Serialize)]
struct MeshCommandReport {
    schema: u32,
    version: &'static str,
    mesh: String,
    before: MeshReport,
    /// Numbers of repairs of each kind; `None` if the command line asks for no change of the mesh.
    repaired: Option<RepairCounts>,
    after: Option<MeshReport>,
}

pub(super) fn run(arguments: &MeshArguments) -> Result<Exit, CommandFailure> {
    let format = arguments.output.as_deref().map(|path| output_mesh_format(path, arguments)).transpose()?;
    let progress = ProgressDisplay::new(arguments.quiet);
    let memory = arguments.memory.map_or(MemoryLimit::System, MemoryLimit::ProcessBytes);
    let loaded = mesh::load_with_memory_limit(&arguments.mesh, &progress, memory.available_bytes()).map_err(|e| {
        let exit = if matches!(e, MeshError::OutOfMemory { .. }) { Exit::Usage } else { Exit::Input };
        CommandFailure::new(exit, miette::Report::from_err(e))
    })?;
    progress.remove_progress_bar();
    check_mesh_memory(&arguments.mesh, &loaded.mesh, memory)?;
    let mut before = loaded.mesh.mesh_report();
    before.vertices = loaded.file_vertex_count;
    before.isolated_vertices = loaded.isolated_vertex_count;
    before.repeated_vertices = loaded.repeated_vertex_count();
    let mut changed = None;
    let (mut after, mut repaired) = (None, None);
    if arguments.changes_mesh() {
        let mut mesh = loaded.mesh.clone();
        repaired = Some(apply_mesh_changes(&mut mesh, arguments)?);
        after = Some(mesh.mesh_report());
        changed = Some(mesh);
    }
    let report = MeshCommandReport {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        mesh: arguments.mesh.display().to_string(),
        before,
        repaired,
        after,
    };
    let text = if arguments.json {
        serde_json::to_string_pretty(&report).map_err(CommandFailure::output_error)? + "\n"
    } else {
        text::mesh_report_table(&report.mesh, &report.before, report.repaired.as_ref(), report.after.as_ref())
    };
    let mut failures = OutputFailures::default();
    if let (Some(path), Some(format)) = (&arguments.output, format) {
        let mesh = changed.as_ref().unwrap_or(&loaded.mesh);
        if write_mesh_and_materials(arguments, &loaded, mesh, (path, format), memory, &mut failures).is_some() {
            progress.print_line(&format!("wrote {}", path.display()));
        }
    }
    failures.ok_or_collect_error(std::io::stdout().write_all(text.as_bytes()));
    failures.into_result(Exit::Success)
}

/// Memory that inspecting or repairing a mesh takes, including the mesh itself \[bytes per
/// triangle].
///
/// The value is a measured 165 bytes (a grid of a million triangles) plus a reserve.
const BYTES_PER_TRIANGLE: u64 = 200;

/// Checks that there is enough memory to inspect or repair a loaded mesh.
fn check_mesh_memory(path: &Path, mesh: &TriangleMesh, memory: MemoryLimit) -> Result<(), CommandFailure> {
    let needed = BYTES_PER_TRIANGLE * mesh.triangles.len() as u64;
    match memory.available_bytes() {
        Some(free) if needed > free => {
            let error = MeshError::OutOfMemory { path: path.to_owned(), needed, free };
            Err(CommandFailure::new(Exit::Usage, miette::Report::from_err(error)))
        }
        _ => Ok(()),
    }
}

/// Returns the format of the output mesh file.
///
/// Returns a failure if the file extension is unknown, if the file cannot be written, or if the
/// file is the source mesh.
fn output_mesh_format(path: &Path, arguments: &MeshArguments) -> Result<MeshFormat, CommandFailure> {
    let format = MeshFormat::from_path(path, arguments.ascii);
    let format =
        format.ok_or_else(|| CommandFailure::new(Exit::Output, UnknownMeshFormatError { path: path.to_owned() }))?;
    check_replaceable(path).map_err(CommandFailure::output_error)?;
    check_distinct_files(&[FileWithRole::new("-o", path)], &[FileWithRole::new("the mesh", &arguments.mesh)])?;
    Ok(format)
}

/// Applies all changes of the command line to the mesh, and returns counts of the repairs.
///
/// Returns a failure if the changes leave no triangle, or if coordinates become too large.
fn apply_mesh_changes(mesh: &mut TriangleMesh, arguments: &MeshArguments) -> Result<RepairCounts, CommandFailure> {
    let (scale, offset) = (arguments.scale.unwrap_or(1.0), arguments.translate.unwrap_or(DVec3::ZERO));
    if arguments.scale.is_some() || arguments.translate.is_some() {
        mesh.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
    }
    let invalid_result = |error: fn(PathBuf) -> InvalidMeshResultError, exit| {
        Err(CommandFailure::new(exit, error(arguments.mesh.clone())))
    };
    if !mesh.positions.iter().all(|p| p.is_finite()) {
        return invalid_result(InvalidMeshResultError::Coordinates, Exit::Usage);
    }
    let all = arguments.repair;
    let repaired = mesh.repair(&MeshRepairOptions {
        weld_tolerance: arguments
            .weld
            .or_else(|| all.then(|| MeshRepairOptions::DEFAULT_RELATIVE_WELD_TOLERANCE * mesh.bounds_diagonal())),
        removes_duplicates: all || arguments.remove_duplicates,
        removes_degenerates: all || arguments.remove_degenerate,
        orients_outward: all || arguments.orient,
    });
    if arguments.flip {
        mesh.reverse_orientation();
    }
    if arguments.flat || arguments.smooth.is_some() {
        mesh.normals = None;
        mesh.merge_equal_vertices();
    }
    if let Some(angle) = arguments.smooth {
        mesh.compute_missing_smooth_normals(angle);
    }
    if mesh.triangles.is_empty() {
        return invalid_result(InvalidMeshResultError::Triangles, Exit::Input);
    }
    Ok(repaired)
}

/// Writes the mesh to `path`. Returns `None` if the mesh file could not be written.
///
/// If `path` is an OBJ file in another folder than the source mesh, the function also writes an MTL
/// file beside it, with the materials of the source mesh. Errors are collected in `failures`.
fn write_mesh_and_materials(
    arguments: &MeshArguments,
    loaded: &LoadedMesh,
    mesh: &TriangleMesh,
    (path, format): (&Path, MeshFormat),
    memory: MemoryLimit,
    failures: &mut OutputFailures,
) -> Option<()> {
    let mut libraries = loaded.mtllib_arguments.clone();
    if !mesh.materials.is_empty() && format != MeshFormat::Obj {
        print_message("note: PLY cannot hold materials: they are left out");
    } else if !libraries.is_empty()
        && format == MeshFormat::Obj
        && canonical_parent_folder(path) != canonical_parent_folder(&arguments.mesh)
    {
        libraries = match mtl::load_mtl_files(&arguments.mesh, &loaded.mtllib_arguments, memory.available_bytes()) {
            Ok(materials) => {
                let mtl_path = path.with_extension("mtl");
                failures.ok_or_collect_error(mtl::write(&mtl_path, &materials));
                mtl_path.file_name().map(|name| name.to_string_lossy().into_owned()).into_iter().collect()
            }
            Err(error) => {
                print_message(&format!("warning: materials are named but not written: {error}"));
                Vec::new()
            }
        };
    }
    failures.ok_or_collect_error(mesh.write(path, format, &libraries))
}

/// Returns the folder that contains the file `path`. Symbolic links are resolved if the folder
/// exists.
fn canonical_parent_folder(path: &Path) -> PathBuf {
    let parent = parent_folder(path);
    std::fs::canonicalize(parent).unwrap_or_else(|_| parent.to_owned())
}
