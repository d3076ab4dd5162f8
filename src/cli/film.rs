//! Film files of the command line: `caustica film`, and the film that a render saves and continues.

use super::args::MethodArguments;
use super::file_lock::FileLock;
use super::input_files::{InputFile, input_digests};
use super::progress::print_message;
use super::settings::method_flags;
use super::value_parsers::{count_with_noun, parse_bytes};
use super::{CommandFailure, Exit, forecast_text};
use crate::camera::CropWindow;
use crate::image::{WriteError, replace_file_with};
use crate::integrate::Algorithm;
use crate::plan::EffectOverrides;
use crate::render::error_estimate::MIN_ERROR_ESTIMATE_PASSES;
use crate::render::{
    FilmFile, FilmFileError, FilmHeader, InputDigest, LayerSelection, PassSet, RenderResult, check_films_memory,
    check_layered_picture_memory, read_film_header,
};
use crate::stats::MemoryLimit;
use clap::Args;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Shortest time between two saves of a film, in units of the time that the last save took. So
/// saves take at most 1 % of a render.
const MIN_INTERVAL_SAVE_RATIO: u32 = 100;

/// Memory of `caustica merge` beside its films: the program, and buffers for reading and writing
/// \[bytes].
const MERGE_MEMORY_RESERVE: u64 = 64 << 20;

/// Flag that turns off the error estimate. The film of such a render lacks the data for the
/// estimate.
const NO_ERROR_ESTIMATE_FLAG: &str = "--no-error-estimate";

/// Flag that adds light groups (direct, indirect and caustic light) to a film.
const LIGHT_GROUPS_FLAG: &str = "--light-groups";

/// Flag that limits the radiance of each camera path.
const CLAMP_FLAG: &str = "--clamp";

/// Arguments of `film`.
#[derive(Debug, Args)]
pub struct FilmArguments {
    /// Film file
    pub film: PathBuf,

    /// Memory limit of the program, such as 4G or 512M  [default: the free memory]
    #[arg(long, value_parser = parse_bytes, value_name = "SIZE")]
    pub memory: Option<u64>,
}

/// Error: a film file cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot read the film `{}`: {source}", path.display())]
pub(super) struct FilmReadError {
    path: PathBuf,
    source: FilmFileError,
}

/// Error: a film was rendered from another scene or with other settings than this render.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the film `{}` is of another render:\n{}", path.display(), differences.join("\n"))]
#[diagnostic(help("render with the settings of `caustica film {}`, or choose another film file", path.display()))]
pub(super) struct FilmOfOtherRenderError {
    pub path: PathBuf,
    pub differences: Vec<String>,
}

/// Error: another process uses a film file.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("another render writes the film `{}` now", .0.display())]
#[diagnostic(help("wait for its end, or choose another film file"))]
struct FilmInUseError(PathBuf);

/// Error: a film holds passes outside of the shard that `--shard` names.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the film `{}` holds passes {passes}, which are not those of --shard", path.display())]
#[diagnostic(help("give each part of the passes a film file of its own"))]
struct FilmOfOtherShardError {
    path: PathBuf,
    passes: String,
}

/// Film file of a running render, with the time of its next save. The file stays locked against
/// other processes until this value is dropped.
pub(super) struct LockedFilmFile<'a> {
    path: &'a Path,
    header: FilmHeader,
    interval: Duration,
    next_save: Instant,
    _lock: FileLock,
}

pub(super) fn run(arguments: &FilmArguments) -> Result<Exit, CommandFailure> {
    check_film_memory(std::slice::from_ref(&arguments.film), 1, arguments.memory)?;
    let film = read_film(&arguments.film)?;
    let written = io::stdout().write_all(film_text(&film).as_bytes());
    written.map_err(CommandFailure::output_error)?;
    Ok(Exit::Success)
}

/// Reads the film file at `path`.
pub(super) fn read_film(path: &Path) -> Result<FilmFile, CommandFailure> {
    let read = || FilmFile::read(BufReader::new(File::open(path)?));
    read().map_err(|source| CommandFailure::new(Exit::Input, FilmReadError { path: path.to_owned(), source }))
}

/// Returns a failure if `count` of the films at `paths` do not fit into memory together.
///
/// `memory` is the limit of `--memory` \[bytes]. Only the headers of the films are read.
pub(super) fn check_film_memory(paths: &[PathBuf], count: usize, memory: Option<u64>) -> Result<(), CommandFailure> {
    let free = memory.map_or(MemoryLimit::System, MemoryLimit::ProcessBytes).available_bytes();
    for path in paths {
        let header = read_header(path)?;
        let size = (header.width, header.height);
        check_films_memory(count, size, film_layers(&header), free).map_err(CommandFailure::usage_error)?;
    }
    Ok(())
}

/// Returns a number of bytes for `--memory` that lets `caustica merge` merge films with this
/// header.
pub(super) fn merge_memory(header: &FilmHeader) -> u64 {
    let size = (header.width, header.height);
    let film = check_layered_picture_memory(size, film_layers(header), None);
    // A picture size beyond all limits counts as 0 bytes, because a render of that size has failed
    // before.
    2 * film.unwrap_or_default() + MERGE_MEMORY_RESERVE
}

/// Reads the header of a film file.
fn read_header(path: &Path) -> Result<FilmHeader, CommandFailure> {
    let read = || read_film_header(BufReader::new(File::open(path)?));
    read().map_err(|source| CommandFailure::new(Exit::Input, FilmReadError { path: path.to_owned(), source }))
}

/// Writes a film file. An existing file is replaced atomically: by a temporary file and a rename.
pub(super) fn write_film(path: &Path, header: &FilmHeader, rendered: &RenderResult) -> Result<(), WriteError> {
    replace_file_with(path, |file| {
        let mut out = BufWriter::new(file);
        FilmFile::write(header, rendered, &mut out)?;
        out.flush()
    })
}

/// Returns a text that describes a film: its scene, settings, passes and error.
fn film_text(FilmFile { header, rendered }: &FilmFile) -> String {
    let mut text = format!("scene     {}\n", header.scene);
    for InputDigest { name, digest } in &header.inputs {
        let _ = writeln!(text, "file      {name}, SHA-256 {digest}");
    }
    let settings = if header.settings.is_empty() { "default".to_owned() } else { header.settings.join(" ") };
    let _ = writeln!(text, "settings  {settings}");
    let _ = writeln!(text, "seed      {}", header.seed);
    let _ = writeln!(text, "size      {}x{}", header.width, header.height);
    let _ = writeln!(text, "program   caustica {}", header.program_version);
    let _ = writeln!(text, "passes    {}: {}", rendered.pass_numbers.len(), rendered.pass_numbers);
    let missing = header.missing_passes(&rendered.pass_numbers);
    if !missing.is_empty() {
        let _ = writeln!(text, "missing   {}: {missing}", missing.len());
    }
    let _ = writeln!(text, "time      {}", forecast_text::duration_text(rendered.wall_time.as_secs_f64()));
    let enough = rendered.film.passes() >= MIN_ERROR_ESTIMATE_PASSES;
    if let Some(estimator) = rendered.estimator.as_ref().filter(|_| enough) {
        let _ = writeln!(text, "error     {}", forecast_text::error_text(&estimator.estimate(&rendered.film)));
    }
    text
}

/// Scene and settings that determine the passes of a render. The header of its film stores them.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilmHeaderSettings<'a> {
    /// Path of the scene file.
    pub scene: &'a Path,
    pub method: &'a MethodArguments,
    pub effects: EffectOverrides,
    /// True if the flag `--no-error-estimate` is given.
    pub no_error_estimate: bool,
    /// True if the flag `--light-groups` is given.
    pub light_groups: bool,
    /// Largest radiance that one camera path may add \[W/(m² sr)]: the value of `--clamp`; `None`
    /// without this flag.
    pub clamp: Option<f32>,
    /// Window of the picture to render; `None` for the whole picture.
    pub crop: Option<CropWindow>,
    /// Number of passes of the whole render, if the film holds only one shard (part) of them;
    /// `None` for a film without `--shard`.
    pub planned_passes: Option<u32>,
}

impl FilmHeaderSettings<'_> {
    /// Returns `--integrator`, and the flags of all other settings that differ from their default.
    /// Leaves out the seed and the size of the picture.
    pub fn non_default_flags(&self) -> Vec<String> {
        let mut flags = method_flags(self.method, "--effects", self.effects);
        if self.no_error_estimate {
            flags.push(NO_ERROR_ESTIMATE_FLAG.to_owned());
        }
        if self.light_groups {
            flags.push(LIGHT_GROUPS_FLAG.to_owned());
        }
        if let Some(limit) = self.clamp {
            flags.extend([CLAMP_FLAG.to_owned(), limit.to_string()]);
        }
        if let Some(window) = self.crop {
            flags.extend(["--crop".to_owned(), window.to_string()]);
        }
        flags
    }
}

/// Returns the layers besides the picture that a film with this header holds, such as light groups.
fn film_layers(header: &FilmHeader) -> LayerSelection {
    let has = |flag: &str| header.settings.iter().any(|word| word == flag);
    LayerSelection {
        estimates_error: !has(NO_ERROR_ESTIMATE_FLAG) && !has(Algorithm::Raycast.name()),
        groups_light: has(LIGHT_GROUPS_FLAG),
        clamps_light: has(CLAMP_FLAG),
        sends_to_tev: false,
        renders_aovs: false,
    }
}

/// Returns the header of the film of a render. `size` is the width and height of the film
/// \[pixels]; `whole` is the size of the picture without `--crop`. `scene` is the scene file, and
/// `inputs` are the files that it names.
///
/// Call this function right after loading. It returns a failure if a file changed since it was
/// read.
pub(super) fn make_film_header(
    render: &FilmHeaderSettings<'_>,
    size: (u32, u32),
    whole: (u32, u32),
    scene: &InputFile,
    inputs: &[InputFile],
) -> Result<FilmHeader, CommandFailure> {
    let mut settings = render.non_default_flags();
    if render.crop.is_some() {
        // In a picture of another size, a crop window with these coordinates shows something else.
        // So the settings include the size of the whole picture.
        settings.extend(["--size".to_owned(), format!("{}x{}", whole.0, whole.1)]);
    }
    Ok(FilmHeader {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: render.scene.display().to_string(),
        inputs: input_digests(scene, inputs)?,
        width: size.0,
        height: size.1,
        settings,
        seed: render.method.seed,
        planned_passes: render.planned_passes,
    })
}

impl<'a> LockedFilmFile<'a> {
    /// Locks the film file at `path`. Returns the locked file and the passes that it already holds.
    /// The passes are `None` if the file does not exist.
    ///
    /// Returns a failure if another process uses the file, or if its film is of another render than
    /// `header` describes. `interval` is the smallest time between two saves while the render goes
    /// on.
    pub fn open(
        path: &'a Path,
        header: FilmHeader,
        interval: Duration,
    ) -> Result<(Self, Option<RenderResult>), CommandFailure> {
        let lock = FileLock::acquire(path).map_err(CommandFailure::output_error)?;
        let in_use = || CommandFailure::usage_error(FilmInUseError(path.to_owned()));
        let lock = lock.ok_or_else(in_use)?;
        let mut rendered = None;
        if path.exists() {
            // Reading the film needs no memory check: the check of this render has covered its
            // film.
            let differences = header.differences(&read_header(path)?);
            if !differences.is_empty() {
                let error = FilmOfOtherRenderError { path: path.to_owned(), differences };
                return Err(CommandFailure::usage_error(error));
            }
            rendered = Some(read_film(path)?.rendered);
        }
        Ok((Self { path, header, interval, next_save: Instant::now() + interval, _lock: lock }, rendered))
    }

    /// Returns a failure if `rendered` has a pass outside of `numbers`, the pass indices of the
    /// shard.
    pub fn check_shard(&self, rendered: &RenderResult, numbers: Range<u32>) -> Result<(), CommandFailure> {
        let mut shard = PassSet::default();
        shard.insert(numbers);
        if rendered.pass_numbers.intersection(&shard) == rendered.pass_numbers {
            return Ok(());
        }
        let passes = rendered.pass_numbers.to_string();
        Err(CommandFailure::usage_error(FilmOfOtherShardError { path: self.path.to_owned(), passes }))
    }

    /// Saves `rendered` if a save is due. Prints a warning if writing fails, because the next save
    /// may succeed.
    pub fn save_if_due(&mut self, rendered: &RenderResult) {
        let start = Instant::now();
        if start < self.next_save {
            return;
        }
        if let Err(error) = self.save(rendered) {
            print_message(&format!("warning: the film is not saved: {error}"));
        }
        let now = Instant::now();
        self.next_save = now + self.interval.max((now - start) * MIN_INTERVAL_SAVE_RATIO);
    }

    /// Saves `rendered` to the film file.
    pub fn save(&self, rendered: &RenderResult) -> Result<(), WriteError> {
        write_film(self.path, &self.header, rendered)
    }

    /// Returns the message that the render continues this film file. The message states the number
    /// of passes in `rendered`, which the film already holds.
    pub fn continuation_line(&self, rendered: &RenderResult) -> String {
        let passes = count_with_noun(rendered.film.passes() as usize, "pass", "passes");
        format!("continuing {}: {passes}", self.path.display())
    }
}
