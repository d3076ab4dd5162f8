//! Detection of changed scene files by their modification time and length.

use crate::format::FileStamp;
use crate::format::mesh::{MeshReadMonitor, TriangleMesh};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Files of a scene, each with its stamp (modification time and length) from before it was read.
/// The stamp is `None` if the file did not exist.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct WatchedFiles(Vec<(PathBuf, Option<FileStamp>)>);

impl WatchedFiles {
    /// Makes a list of one file with its current stamp (modification time and length).
    pub fn new(path: &Path) -> Self {
        Self(vec![(path.to_owned(), FileStamp::of_file(path))])
    }

    /// Adds the files of `other` that are not in this list. They keep their stamps (modification
    /// time and length).
    pub fn add_all(&mut self, other: &Self) {
        for (path, stamp) in &other.0 {
            if self.0.iter().all(|(known, _)| known != path) {
                self.0.push((path.clone(), *stamp));
            }
        }
    }

    /// Adds the file at `path` with its current stamp, unless the list already has it.
    fn add(&mut self, path: &Path) {
        if self.0.iter().all(|(known, _)| known != path) {
            self.0.push((path.to_owned(), FileStamp::of_file(path)));
        }
    }

    /// Returns a list of the same files with their current stamps.
    fn with_current_stamps(&self) -> Self {
        Self(self.0.iter().map(|(path, _)| (path.clone(), FileStamp::of_file(path))).collect())
    }

    /// True if no file of the list, except the scene file (the first), has changed since its stamp
    /// was taken.
    pub fn has_unchanged_inputs(&self) -> bool {
        self.0.iter().skip(1).all(|(path, stamp)| FileStamp::of_file(path) == *stamp)
    }
}

/// Monitor of scene reading that records each file that the scene names, with its stamp, just
/// before the file is read.
pub(super) struct WatchedFileCollector(Mutex<WatchedFiles>);

impl WatchedFileCollector {
    /// Makes a monitor that already holds the scene file at `path`. Call this before the file is
    /// read.
    pub fn new(path: &Path) -> Self {
        Self(Mutex::new(WatchedFiles::new(path)))
    }

    /// Returns the scene file and the files that it names.
    pub fn into_files(self) -> WatchedFiles {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MeshReadMonitor for WatchedFileCollector {
    fn on_input_file_found(&self, path: &Path) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).add(path);
    }

    fn on_read_start(&self, _: &Path, _: u64) {}
    fn on_bytes_parsed(&self, _: u64) {}
    fn on_read_end(&self, _: &Path, _: &TriangleMesh) {}
}

/// Detector of changed files, which polls them only in [`Self::has_settled_change`].
///
/// A change is reported when two polls in a row find the same changed stamps. So a file that is
/// still being written is not reported.
#[derive(Debug, Default)]
pub(super) struct FileWatch {
    files: WatchedFiles,
    /// Changed stamps (modification times and lengths) that the last poll found; `None` if it found
    /// no change. The change is reported if the next poll finds the same stamps.
    unsettled: Option<WatchedFiles>,
}

impl FileWatch {
    /// Watches `files`. A file that differs from its stamp in `files` counts as changed.
    pub fn set_files(&mut self, files: WatchedFiles) {
        (self.files, self.unsettled) = (files, None);
    }

    /// Polls all files. Returns true once per change: when two calls in a row have found the same
    /// changed stamps.
    pub fn has_settled_change(&mut self) -> bool {
        let now = self.files.with_current_stamps();
        if now == self.files {
            self.unsettled = None;
            return false;
        }
        let is_settled = self.unsettled.as_ref() == Some(&now);
        if is_settled {
            self.set_files(now);
        } else {
            self.unsettled = Some(now);
        }
        is_settled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn settled_changes_are_reported_once() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, mesh] = ["scene.txt", "mesh.obj"].map(|name| folder.path().join(name));
        fs::write(&scene, "a").unwrap();
        let monitor = WatchedFileCollector::new(&scene);
        monitor.on_input_file_found(&mesh);
        monitor.on_input_file_found(&mesh);
        let files = monitor.into_files();
        assert_eq!(files.0.len(), 2);
        let mut watch = FileWatch::default();
        watch.set_files(files.clone());
        assert!(!watch.has_settled_change());
        // A file that is still growing is not reported yet.
        fs::write(&scene, "ab").unwrap();
        assert!(!watch.has_settled_change());
        fs::write(&scene, "abc").unwrap();
        assert!(!watch.has_settled_change());
        assert!(watch.has_settled_change() && !watch.has_settled_change() && files.has_unchanged_inputs());
        // A file that appears for only one poll is not reported.
        fs::write(&mesh, "v").unwrap();
        assert!(!watch.has_settled_change() && !files.has_unchanged_inputs());
        fs::remove_file(&mesh).unwrap();
        assert!(!watch.has_settled_change() && !watch.has_settled_change());
    }
}
