//! `caustica convert`: writes any scene that can be read as scene text.

use super::input_files::InputFileCollector;
use super::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use super::progress::print_message;
use super::scene::{import_warnings, read_scene_file};
use super::scene_args::ImportArguments;
use super::{CommandFailure, Exit};
use crate::format::ConvertedScene;
use crate::format::grid::{self, GridEncoding};
use crate::format::mesh::MeshFormat;
use crate::image::{self, WriteOptions, replace_file_with};
use crate::stats::MemoryLimit;
use clap::Args;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// Scene to read
    pub scene: PathBuf,

    /// Scene file to write, in the text format of this program. Meshes, pictures and grids of the
    /// scene become files beside it
    #[arg(required_unless_present = "output_flag")]
    pub output: Option<PathBuf>,

    /// Scene file to write; another way to give the output
    #[arg(short, long = "output", id = "output_flag", value_name = "FILE", conflicts_with = "output")]
    pub output_flag: Option<PathBuf>,

    #[command(flatten)]
    pub import: ImportArguments,

    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
}

impl ConvertArguments {
    /// Returns the path of the scene file to write, given by `-o` or as the second argument.
    #[must_use]
    pub fn output_file(&self) -> Option<&PathBuf> {
        self.output.as_ref().or(self.output_flag.as_ref())
    }
}

/// Error: an output file exists already, and `--force` is not given.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` exists already", .0.display())]
#[diagnostic(help("choose another name, or replace it with --force"))]
struct OutputExistsError(PathBuf);

pub(super) fn run(arguments: &ConvertArguments) -> Result<Exit, CommandFailure> {
    let output = arguments.output_file().cloned().unwrap_or_default();
    let files = InputFileCollector::new(&());
    let scene = read_scene_file(&arguments.scene, &arguments.import, &files, MemoryLimit::System)?;
    import_warnings(&scene).iter().for_each(|line| print_message(line));
    let conversion = ConvertedScene::new(&scene, &output);
    let meshes = conversion.meshes.iter().map(|(path, _)| path);
    let pictures = conversion.pictures.iter().map(|(path, _)| path);
    let grids = conversion.grids.iter().map(|(path, _)| path);
    let outputs: Vec<&PathBuf> = std::iter::once(&output).chain(meshes).chain(pictures).chain(grids).collect();
    let named: Vec<FileWithRole> = outputs.iter().map(|path| FileWithRole::new("the output", path)).collect();
    let mut inputs = vec![FileWithRole::new("the scene file", &arguments.scene)];
    let read_files = files.into_input_paths();
    inputs.extend(
        read_files.iter().chain(&conversion.existing_file_paths).map(|path| FileWithRole::new("the input", path)),
    );
    check_distinct_files(&named, &inputs)?;
    if let Some(path) = outputs.iter().find(|path| !arguments.force && path.exists()) {
        return Err(CommandFailure::new(Exit::Output, OutputExistsError((*path).clone())));
    }
    let mut failures = OutputFailures::default();
    for (path, mesh) in &conversion.meshes {
        failures.ok_or_collect_error(mesh.write(path, MeshFormat::PlyBinary, &[]));
    }
    for (path, picture) in &conversion.pictures {
        failures.ok_or_collect_error(image::write(path, picture, &WriteOptions::default()));
    }
    for (path, grid) in &conversion.grids {
        let encoding = GridEncoding::F32;
        failures
            .ok_or_collect_error(replace_file_with(path, |file| grid::write_to(BufWriter::new(file), grid, encoding)));
    }
    let written = replace_file_with(&output, |file| file.write_all(conversion.text.as_bytes()));
    if failures.ok_or_collect_error(written).is_some() {
        print_message(&format!("wrote {}", output.display()));
    }
    failures.into_result(Exit::Success)
}
