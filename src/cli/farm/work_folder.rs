//! Folder of a farm render: it holds the scripts, films and logs, and the numbers of the jobs.

use super::division::ShardDivision;
use crate::cli::file_lock::FileLock;
use crate::image::replace_file;
use crate::render::{FilmHeader, PassSet, read_pass_numbers};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// Name of the film file into which the films of all shards are merged.
pub(super) const MERGED_FILM_NAME: &str = "merged.film";

/// Name of the file whose existence shows that a merge has succeeded.
pub(super) const MERGE_MARK_NAME: &str = "merge.done";

/// Name of the JSON file that stores the [`FarmState`].
const STATE_FILE_NAME: &str = "farm.json";

/// Name of the job script that renders a shard, which is a part of the passes.
pub(super) const SHARD_SCRIPT_NAME: &str = "shard.sh";

/// Name of the job script that merges the films of all shards.
pub(super) const MERGE_SCRIPT_NAME: &str = "merge.sh";

/// Work folder of a farm render, given by its absolute path.
#[derive(Clone, Debug)]
pub(super) struct WorkFolder {
    path: PathBuf,
}

/// Description of a farm render. It is stored in the work folder, so that a later command can
/// continue the render.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct FarmState {
    /// Scene and settings on which the passes depend.
    pub header: FilmHeader,
    /// Division into shards of all passes that were submitted so far.
    pub division: ShardDivision,
    /// Slurm's numbers of the jobs that the last round of jobs submitted.
    #[serde(rename = "jobs")]
    pub last_round_jobs: Vec<String>,
}

/// Error: the folder of a farm render cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(super) enum WorkFolderError {
    /// The folder holds files that no farm render wrote.
    #[error("the folder `{}` is not empty, and is not of an earlier farm render", .0.display())]
    #[diagnostic(help("choose another --work-dir"))]
    Foreign(PathBuf),
    /// Another process uses the folder.
    #[error("another `caustica farm` works in the folder `{}`", .0.display())]
    #[diagnostic(help("wait for its end, or choose another --work-dir"))]
    InUse(PathBuf),
    /// The file that describes the render is damaged.
    #[error("the file `{}` is damaged", .0.display())]
    #[diagnostic(help("choose another --work-dir"))]
    Damaged(PathBuf),
    /// A file of the folder cannot be read, written or created.
    #[error("cannot use the folder `{}`: {source}", path.display())]
    Io {
        /// Path of the folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl WorkFolder {
    /// Returns the folder at `path`, which need not exist.
    pub fn new(path: &Path) -> io::Result<Self> {
        Ok(Self { path: std::path::absolute(path)? })
    }

    /// Returns the absolute path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path of a file in the folder.
    pub fn file_path(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Creates the folder if needed and locks it. Returns the lock, and the description of the
    /// render that the folder holds. The description is `None` for a new render.
    pub fn lock_and_read_state(&self) -> Result<(FileLock, Option<FarmState>), WorkFolderError> {
        let failed = |source| WorkFolderError::Io { path: self.path.clone(), source };
        let is_known = self.file_path(STATE_FILE_NAME).is_file();
        if !is_known && self.has_foreign_files().map_err(failed)? {
            return Err(WorkFolderError::Foreign(self.path.clone()));
        }
        fs::create_dir_all(self.file_path("log")).map_err(failed)?;
        let lock = FileLock::acquire(&self.file_path("farm")).map_err(failed)?;
        let lock = lock.ok_or_else(|| WorkFolderError::InUse(self.path.clone()))?;
        let state = match fs::read(self.file_path(STATE_FILE_NAME)) {
            Ok(bytes) => Some(
                serde_json::from_slice(&bytes)
                    .map_err(|_| WorkFolderError::Damaged(self.file_path(STATE_FILE_NAME)))?,
            ),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(failed(error)),
        };
        Ok((lock, state))
    }

    /// True if the folder exists and holds files that no farm render wrote: other files than the
    /// log folder and the lock file. A farm render creates these two first.
    fn has_foreign_files(&self) -> io::Result<bool> {
        let entries = match fs::read_dir(&self.path) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
            Err(error) => return Err(error),
        };
        let names: io::Result<Vec<_>> = entries.map(|entry| Ok(entry?.file_name())).collect();
        Ok(names?.iter().any(|name| name != "log" && name != "farm.lock"))
    }

    /// Stores the description of the render in the folder.
    pub fn save(&self, state: &FarmState) -> Result<(), WorkFolderError> {
        let json = serde_json::to_vec_pretty(state).map_err(|e| self.error(io::Error::other(e)))?;
        self.write(STATE_FILE_NAME, &json)
    }

    /// Writes `bytes` to the file `name` in the folder, atomically: by a temporary file and a
    /// rename.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), WorkFolderError> {
        replace_file(&self.file_path(name), bytes).map_err(|e| self.error(io::Error::other(e)))
    }

    /// True if the folder has a file `name` with content `bytes`.
    pub fn has_file(&self, name: &str, bytes: &[u8]) -> bool {
        fs::read(self.file_path(name)).is_ok_and(|stored| stored == bytes)
    }

    /// Removes the file that shows that an earlier merge has succeeded.
    pub fn remove_merge_mark(&self) -> Result<(), WorkFolderError> {
        match fs::remove_file(self.file_path(MERGE_MARK_NAME)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(self.error(error)),
            _ => Ok(()),
        }
    }

    /// True if the merge script has merged all films since [`Self::remove_merge_mark`] was called.
    pub fn is_merged(&self) -> bool {
        self.file_path(MERGE_MARK_NAME).is_file()
    }

    /// Returns the indices of the passes in the film of shard `number`; an empty set if there is no
    /// readable film.
    pub fn completed_shard_passes(&self, number: u32) -> PassSet {
        let file = File::open(self.file_path(&format!("shard-{number:06}.film")));
        file.ok().and_then(|file| read_pass_numbers(BufReader::new(file)).ok()).unwrap_or_default()
    }

    /// Returns the last eight lines of the log file `name`; empty if there is no such file.
    pub fn log_end(&self, name: &str) -> String {
        let text = fs::read(self.file_path("log").join(name)).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let lines: Vec<&str> = text.lines().collect();
        lines[lines.len().saturating_sub(8)..].join("\n")
    }

    fn error(&self, source: io::Error) -> WorkFolderError {
        WorkFolderError::Io { path: self.path.clone(), source }
    }
}
