//! `caustica mesh`.

mod args;
mod text;

pub use args::MeshArguments;

use super::progress::{Progress, tell};
use super::{Exit, Failure};
use crate::format::mesh::{self, Loaded, MeshError, MeshFormat, MeshReport, Repair, Repaired, TriangleMesh};
use crate::format::mtl;
use crate::image::check_place;
use crate::stats::Memory;
use glam::DVec3;
use miette::IntoDiagnostic;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A path whose extension names no form of meshes.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` names no known form of meshes", path.display())]
#[diagnostic(help("give it the extension .obj or .ply"))]
struct NoForm {
    path: PathBuf,
}

/// What is left of a mesh is not one.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum Lost {
    #[error("no triangle of `{}` is left", .0.display())]
    #[diagnostic(help("weld less, or keep triangles without area"))]
    Triangles(PathBuf),
    #[error("the coordinates of `{}` are too large after the change", .0.display())]
    #[diagnostic(help("scale less, or move it less far"))]
    Coordinates(PathBuf),
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report {
    schema: u32,
    version: &'static str,
    mesh: String,
    before: MeshReport,
    /// `None` where nothing was to be changed.
    repaired: Option<Repaired>,
    after: Option<MeshReport>,
}

pub(super) fn run(arguments: &MeshArguments) -> Result<Exit, Failure> {
    let output = |e| Failure::new(Exit::Output, e);
    let form = arguments.output.as_deref().map(|path| form(path, arguments.ascii)).transpose()?;
    let progress = Progress::new(arguments.quiet);
    let memory = arguments.memory.map_or(Memory::System, Memory::Limit);
    let loaded = mesh::load_within(&arguments.mesh, &progress, memory.free()).map_err(|e| {
        let exit = if matches!(e, MeshError::Memory { .. }) { Exit::Usage } else { Exit::Input };
        Failure::new(exit, miette::Report::from_err(e))
    })?;
    progress.finish();
    check_room(&arguments.mesh, &loaded.mesh, memory)?;
    let mut before = loaded.mesh.report();
    before.vertices = loaded.vertices;
    before.isolated_vertices = loaded.isolated;
    before.repeated_vertices = loaded.repeated();
    let mut changed = None;
    let (mut after, mut repaired) = (None, None);
    if arguments.changes() {
        let mut mesh = loaded.mesh.clone();
        repaired = Some(change(&mut mesh, arguments)?);
        after = Some(mesh.report());
        changed = Some(mesh);
    }
    let report = Report {
        schema: 1,
        version: env!("CARGO_PKG_VERSION"),
        mesh: arguments.mesh.display().to_string(),
        before,
        repaired,
        after,
    };
    let told = if arguments.json {
        serde_json::to_string_pretty(&report).into_diagnostic().map_err(output)? + "\n"
    } else {
        text::table(&report.mesh, &report.before, report.repaired.as_ref(), report.after.as_ref())
    };
    if let (Some(path), Some(form)) = (&arguments.output, form) {
        write(arguments, &loaded, changed.as_ref().unwrap_or(&loaded.mesh), (path, form), memory)?;
        progress.say(&format!("wrote {}", path.display()));
    }
    std::io::stdout().write_all(told.as_bytes()).into_diagnostic().map_err(output)?;
    Ok(Exit::Success)
}

/// Bytes that a triangle takes while its mesh is looked at or repaired: 165 as measured on a grid of a million, with the mesh itself.
const PER_TRIANGLE: u64 = 200;

/// Refuses what could be read, but neither looked at nor repaired.
fn check_room(path: &Path, mesh: &TriangleMesh, memory: Memory) -> Result<(), Failure> {
    let needed = PER_TRIANGLE * mesh.triangles.len() as u64;
    match memory.free() {
        Some(free) if needed > free => {
            let error = MeshError::Memory { path: path.to_owned(), needed, free };
            Err(Failure::new(Exit::Usage, miette::Report::from_err(error)))
        }
        _ => Ok(()),
    }
}

fn form(path: &Path, text: bool) -> Result<MeshFormat, Failure> {
    let form = MeshFormat::of(path, text);
    let form = form.ok_or_else(|| Failure::new(Exit::Output, NoForm { path: path.to_owned() }))?;
    check_place(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
    Ok(form)
}

/// Changes the mesh as the command line asks.
fn change(mesh: &mut TriangleMesh, arguments: &MeshArguments) -> Result<Repaired, Failure> {
    let (scale, offset) = (arguments.scale.unwrap_or(1.0), arguments.translate.unwrap_or(DVec3::ZERO));
    if arguments.scale.is_some() || arguments.translate.is_some() {
        mesh.positions.iter_mut().for_each(|p| *p = *p * scale + offset);
    }
    let lost = |lost: fn(PathBuf) -> Lost, exit| Err(Failure::new(exit, lost(arguments.mesh.clone())));
    if !mesh.positions.iter().all(|p| p.is_finite()) {
        return lost(Lost::Coordinates, Exit::Usage);
    }
    let all = arguments.repair;
    let repaired = mesh.repair(&Repair {
        weld: arguments.weld.or_else(|| all.then(|| Repair::WELD * mesh.diagonal())),
        duplicates: all || arguments.remove_duplicates,
        degenerate: all || arguments.remove_degenerate,
        orient: all || arguments.orient,
    });
    if arguments.flip {
        mesh.flip();
    }
    if arguments.flat || arguments.smooth.is_some() {
        mesh.normals = None;
        mesh.share();
    }
    if let Some(angle) = arguments.smooth {
        mesh.smooth(angle);
    }
    if mesh.triangles.is_empty() {
        return lost(Lost::Triangles, Exit::Input);
    }
    Ok(repaired)
}

/// Writes the mesh, and its materials beside it where it goes to another folder than it came from.
fn write(
    arguments: &MeshArguments,
    loaded: &Loaded,
    mesh: &TriangleMesh,
    (path, form): (&Path, MeshFormat),
    memory: Memory,
) -> Result<(), Failure> {
    let output = |e| Failure::new(Exit::Output, e);
    let mut libraries = loaded.libraries.clone();
    if !mesh.materials.is_empty() && form != MeshFormat::Obj {
        tell("note: PLY holds no materials: they are left out");
    } else if !libraries.is_empty() && form == MeshFormat::Obj && folder(path) != folder(&arguments.mesh) {
        libraries = match mtl::load(&arguments.mesh, &loaded.libraries, memory.free()) {
            Ok(materials) => {
                let beside = path.with_extension("mtl");
                mtl::write(&beside, &materials).into_diagnostic().map_err(output)?;
                beside.file_name().map(|name| name.to_string_lossy().into_owned()).into_iter().collect()
            }
            Err(error) => {
                tell(&format!("warning: materials are named but not written: {error}"));
                Vec::new()
            }
        };
    }
    mesh.write(path, form, &libraries).into_diagnostic().map_err(output)
}

/// The folder that a file lies in, links followed where it can be.
fn folder(path: &Path) -> PathBuf {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::canonicalize(parent).unwrap_or_else(|_| parent.to_owned())
}
