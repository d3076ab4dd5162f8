//! Arguments that name a scene and its format.

use super::value_parsers::{parse_bytes, parse_picture_size, parse_threads};
use crate::format::{IMPORTERS, ImportOptions, SCENE_TEXT_EXTENSIONS};
use crate::stats::MemoryLimit;
use clap::Args;
use std::path::PathBuf;

/// Flags for reading scenes of other programs.
#[derive(Clone, Debug, Default, Args)]
pub struct ImportArguments {
    /// File extension that names the format of the scene, such as `gltf`; `None` to use the
    /// extension of the scene file.
    #[arg(long, help = scene_format_help(), value_parser = parse_scene_format, value_name = "EXTENSION")]
    pub format: Option<String>,

    /// Refuse a scene with anything that would be ignored or approximated, instead of printing
    /// warnings
    #[arg(long)]
    pub strict: bool,

    /// Let a scene of another program name files outside its own folder
    #[arg(long)]
    pub allow_outside: bool,
}

impl ImportArguments {
    /// Returns the flags with which another command reads the scene in the same way. Leaves out
    /// `--strict`, which only refuses scenes.
    pub(super) fn reproducing_flags(&self) -> Vec<String> {
        let format = self.format.iter().flat_map(|format| ["--format".to_owned(), format.clone()]);
        format.chain(self.allow_outside.then(|| "--allow-outside".to_owned())).collect()
    }

    /// Returns the options for reading a scene that these flags describe. `memory` limits the
    /// memory that reading may take.
    pub(super) fn import_options(&self, memory: MemoryLimit) -> ImportOptions {
        ImportOptions {
            memory_limit: memory,
            format_extension: self.format.clone(),
            allows_outside_files: self.allow_outside,
        }
    }
}

/// The scene file, and flags for picture size, threads and memory.
#[derive(Clone, Debug, Args)]
pub struct SceneArguments {
    /// Scene file.
    #[arg(help = scene_file_help())]
    pub scene: PathBuf,

    #[command(flatten)]
    pub import: ImportArguments,

    /// Picture size, such as 1280x720  [default: the scene's]
    #[arg(long, value_parser = parse_picture_size, value_name = "WxH")]
    pub size: Option<(u32, u32)>,

    /// Number of threads  [default: one per core]
    #[arg(long, value_parser = parse_threads, value_name = "N")]
    pub threads: Option<u32>,

    /// Memory limit of the program, such as 4G or 512M. Work that needs more is refused before it
    /// begins  [default: the free memory]
    #[arg(long, value_parser = parse_bytes, value_name = "SIZE")]
    pub memory: Option<u64>,
}

impl SceneArguments {
    /// Returns the limit of `--memory`, or else the system's free memory.
    pub(super) fn memory_limit(&self) -> MemoryLimit {
        self.memory.map_or(MemoryLimit::System, MemoryLimit::ProcessBytes)
    }
}

/// Returns the file extensions of all scene formats.
fn scene_extensions() -> impl Iterator<Item = &'static str> {
    IMPORTERS.iter().flat_map(|importer| importer.extensions()).copied()
}

/// Returns the help text of `--format`, which lists the extensions of all scene formats.
fn scene_format_help() -> String {
    let known = join_with_or(scene_extensions().map(str::to_owned).collect());
    format!("Format of the scene, by its file extension: {known}  [default: by the extension of the file]")
}

/// Returns the help text of the scene file: scene text, or a format of another program by its file
/// extension.
fn scene_file_help() -> String {
    let foreign = scene_extensions().filter(|extension| !SCENE_TEXT_EXTENSIONS.contains(extension));
    let kinds = std::iter::once("scene text".to_owned()).chain(foreign.map(|extension| format!(".{extension}")));
    format!("Scene file: {}", join_with_or(kinds.collect()))
}

/// Joins words by commas, the last two by "or".
fn join_with_or(mut words: Vec<String>) -> String {
    let last = words.pop().unwrap_or_default();
    if words.is_empty() { last } else { format!("{} or {last}", words.join(", ")) }
}

/// Parses the file extension of a scene format.
fn parse_scene_format(text: &str) -> Result<String, String> {
    let wanted = text.trim_start_matches('.').to_ascii_lowercase();
    if scene_extensions().any(|extension| extension == wanted) {
        return Ok(wanted);
    }
    let known = scene_extensions().collect::<Vec<_>>().join(", ");
    Err(format!("`{text}` is no scene format: write one of {known}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_of_format_names_every_extension() {
        let words = words_of_help("format");
        for extension in scene_extensions() {
            assert!(words.iter().any(|word| word == extension), "{extension}");
        }
    }

    #[test]
    fn help_of_scene_names_every_imported_format() {
        let words = words_of_help("scene");
        for extension in scene_extensions().filter(|extension| !SCENE_TEXT_EXTENSIONS.contains(extension)) {
            assert!(words.iter().any(|word| word == extension), "{extension}");
        }
    }

    /// Returns the words of the help text of the argument `id` of [`SceneArguments`].
    fn words_of_help(id: &str) -> Vec<String> {
        let command = SceneArguments::augment_args(clap::Command::new("render"));
        let argument = command.get_arguments().find(|argument| argument.get_id() == id).unwrap();
        let help = argument.get_help().unwrap().to_string();
        help.split(|c: char| !c.is_alphanumeric()).map(str::to_owned).collect()
    }
}
