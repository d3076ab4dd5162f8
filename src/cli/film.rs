//! Film files of the command line: `caustica film`, and the film that a render saves and continues.

use super::number::count_with_noun;
use super::progress::print_message;
use super::settings::method_flags;
use super::{CommandFailure, Exit, RenderArguments, forecast_text};
use crate::image::{WriteError, replace_file_with};
use crate::render::error_estimate::MIN_PASSES;
use crate::render::{FilmFile, FilmFileError, FilmHeader, InputDigest, PassSet, RenderResult};
use clap::Args;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufReader, BufWriter, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Smallest time between two saves, as a multiple of the time that a save takes. So saves take at
/// most 1 % of a render.
const MIN_INTERVAL_FACTOR: u32 = 100;

/// Arguments of `film`.
#[derive(Debug, Args)]
pub struct FilmArguments {
    /// Film file
    pub film: PathBuf,
}

/// Error: a film file cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot read the film `{}`: {source}", path.display())]
pub(super) struct FilmReadError {
    path: PathBuf,
    source: FilmFileError,
}

/// Error: a film belongs to another scene or to other settings.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the film `{}` is of another render:\n{}", path.display(), differences.join("\n"))]
#[diagnostic(help("render with the settings of `caustica film {}`, or choose another film file", path.display()))]
pub(super) struct OtherRenderError {
    pub path: PathBuf,
    pub differences: Vec<String>,
}

/// Error: another process uses a film file.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("another render writes the film `{}` now", .0.display())]
#[diagnostic(help("wait for its end, or choose another film file"))]
struct FilmInUseError(PathBuf);

/// Error: a film holds passes outside of the shard that is to be rendered.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the film `{}` holds passes {passes}, which are not those of --shard", path.display())]
#[diagnostic(help("give each part of the passes a film file of its own"))]
struct OtherShardError {
    path: PathBuf,
    passes: String,
}

/// The film file of a render. It is locked until the value is dropped.
pub(super) struct SavedFilm<'a> {
    path: &'a Path,
    header: FilmHeader,
    interval: Duration,
    next: Instant,
    _lock: FileLock,
}

/// Lock of a film file: a locked file beside it.
struct FileLock {
    path: PathBuf,
    /// Open file that holds the lock. The system releases the lock when the process ends.
    _file: File,
}

pub(super) fn run(arguments: &FilmArguments) -> Result<Exit, CommandFailure> {
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

/// Writes a film file. An existing file is replaced as a whole.
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
    let _ = writeln!(text, "program   caustica {}", header.version);
    let _ = writeln!(text, "passes    {}: {}", rendered.numbers.len(), rendered.numbers);
    let missing = header.missing_passes(&rendered.numbers);
    if !missing.is_empty() {
        let _ = writeln!(text, "missing   {}: {missing}", missing.len());
    }
    let _ = writeln!(text, "time      {}", forecast_text::duration_text(rendered.wall.as_secs_f64()));
    let enough = rendered.film.passes() >= MIN_PASSES;
    if let Some(estimator) = rendered.estimator.as_ref().filter(|_| enough) {
        let _ = writeln!(text, "error     {}", forecast_text::error_text(&estimator.estimate(&rendered.film)));
    }
    text
}

/// Returns the header of the film of a render of `size` (width, height) pixels, which may be a
/// window of a `whole` picture. `inputs` are the files that the scene names.
pub(super) fn film_header(
    arguments: &RenderArguments,
    size: (u32, u32),
    whole: (u32, u32),
    inputs: &[PathBuf],
) -> Result<FilmHeader, CommandFailure> {
    let mut settings = method_flags(&arguments.method, "--effects", arguments.effects.effects);
    if arguments.no_error_estimate {
        settings.push("--no-error-estimate".to_owned());
    }
    if arguments.light_groups {
        settings.push("--light-groups".to_owned());
    }
    if let Some(limit) = arguments.clamp {
        settings.push(format!("--clamp {limit}"));
    }
    if let Some(window) = arguments.crop {
        settings.push(format!("--crop {window} --size {}x{}", whole.0, whole.1));
    }
    let scene = &arguments.scene.scene;
    let digests = std::iter::once(scene).chain(inputs).map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(InputDigest { name, digest: file_digest(path)? })
    });
    let digests: io::Result<Vec<InputDigest>> = digests.collect();
    let mut digests = digests.map_err(|error| CommandFailure::new(Exit::Input, miette::Report::from_err(error)))?;
    digests.sort_by(|a, b| (&a.name, &a.digest).cmp(&(&b.name, &b.digest)));
    digests.dedup();
    Ok(FilmHeader {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: scene.display().to_string(),
        inputs: digests,
        width: size.0,
        height: size.1,
        settings,
        seed: arguments.method.seed,
        planned_passes: arguments.shard.and(arguments.passes),
    })
}

/// Returns the SHA-256 digest of a file in hexadecimal digits.
fn file_digest(path: &Path) -> io::Result<String> {
    let mut hasher = Sha256::new();
    io::copy(&mut File::open(path)?, &mut HashWriter(&mut hasher))?;
    Ok(hasher.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

/// Writer that adds all written bytes to a SHA-256 digest.
struct HashWriter<'a>(&'a mut Sha256);

impl io::Write for HashWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<'a> SavedFilm<'a> {
    /// Locks the film file at `path`. Returns it with the render that it holds; `None` if the file
    /// does not exist.
    ///
    /// The file must be of the render with `header`. `interval` is the time between two saves.
    pub fn open(
        path: &'a Path,
        header: FilmHeader,
        interval: Duration,
    ) -> Result<(Self, Option<RenderResult>), CommandFailure> {
        let lock = FileLock::acquire(path)?;
        let mut rendered = None;
        if path.exists() {
            let film = read_film(path)?;
            let differences = header.differences(&film.header);
            if !differences.is_empty() {
                let error = OtherRenderError { path: path.to_owned(), differences };
                return Err(CommandFailure::usage_error(error));
            }
            rendered = Some(film.rendered);
        }
        Ok((Self { path, header, interval, next: Instant::now() + interval, _lock: lock }, rendered))
    }

    /// Returns an error unless all passes of `rendered` are among `numbers`.
    pub fn check_shard(&self, rendered: &RenderResult, numbers: Range<u32>) -> Result<(), CommandFailure> {
        let mut shard = PassSet::default();
        shard.insert(numbers);
        if rendered.numbers.intersection(&shard) == rendered.numbers {
            return Ok(());
        }
        let passes = rendered.numbers.to_string();
        Err(CommandFailure::usage_error(OtherShardError { path: self.path.to_owned(), passes }))
    }

    /// Saves `rendered` if a save is due. If writing fails, prints a warning: the next save may
    /// succeed.
    pub fn save_if_due(&mut self, rendered: &RenderResult) {
        let start = Instant::now();
        if start < self.next {
            return;
        }
        if let Err(error) = self.save(rendered) {
            print_message(&format!("warning: the film is not saved: {error}"));
        }
        let now = Instant::now();
        self.next = now + self.interval.max((now - start) * MIN_INTERVAL_FACTOR);
    }

    /// Saves `rendered` to the film file.
    pub fn save(&self, rendered: &RenderResult) -> Result<(), WriteError> {
        write_film(self.path, &self.header, rendered)
    }

    /// Returns a line that says how many passes the film file already held when this render began.
    pub fn continuation_line(&self, rendered: &RenderResult) -> String {
        let passes = count_with_noun(rendered.film.passes() as usize, "pass", "passes");
        format!("continuing {}: {passes}", self.path.display())
    }
}

impl FileLock {
    /// Locks the film file at `path`.
    fn acquire(path: &Path) -> Result<Self, CommandFailure> {
        let mut name = path.as_os_str().to_owned();
        name.push(".lock");
        let lock = PathBuf::from(name);
        loop {
            let file = File::create(&lock).map_err(CommandFailure::output_error)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(CommandFailure::usage_error(FilmInUseError(path.to_owned())));
                }
                Err(TryLockError::Error(error)) => return Err(CommandFailure::output_error(error)),
            }
            // If a process that just ended has removed the lock file, try again.
            if is_file_at(&file, &lock) {
                return Ok(Self { path: lock, _file: file });
            }
        }
    }
}

impl Drop for FileLock {
    fn drop(&mut self) {
        // If this fails and the lock file stays, the next render locks it again.
        let _ = fs::remove_file(&self.path);
    }
}

/// True if `path` leads to the open `file`.
#[cfg(unix)]
fn is_file_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (open, named) = (file.metadata(), fs::metadata(path));
    open.is_ok_and(|open| named.is_ok_and(|named| (open.dev(), open.ino()) == (named.dev(), named.ino())))
}

/// True if `path` leads to the open `file`. Systems other than Unix do not remove open files, so an
/// existing file at `path` is `file`.
#[cfg(not(unix))]
fn is_file_at(_: &File, path: &Path) -> bool {
    path.exists()
}
