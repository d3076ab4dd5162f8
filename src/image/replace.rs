//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::error::WriteError;

/// Puts `bytes` at `path` whole or not at all: a reader sees the old file or the new one, and a failure leaves the old one.
///
/// The bytes go to a temporary file in the same folder, to the disk, and are then renamed over the path. A symbolic link
/// is followed; a replaced file's permissions are kept, a new one's are those of any created file.
///
/// # Errors
/// [`WriteError`] where the folder is missing, a folder, device or read-only file stands at the path, or the system refuses.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    replace_with(path, |file| file.write_all(bytes))
}

/// As [`replace_file`], with what `fill` writes.
///
/// # Errors
/// [`WriteError`], as of [`replace_file`], or where `fill` fails.
pub fn replace_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), WriteError> {
    let place = Place::find(path)?;
    // Dropping the temporary file on an early return removes it.
    let mut temporary = place.temporary()?;
    let wrote = fill(temporary.as_file_mut()).and_then(|()| temporary.as_file().sync_all());
    wrote.map_err(|source| WriteError::Io { action: "write", path: path.to_owned(), source })?;
    match temporary.persist(&place.file) {
        Ok(_) => Ok(()),
        Err(error) => Err(WriteError::Io { action: "replace", path: path.to_owned(), source: error.error }),
    }
}

/// Checks before a long work that [`replace_file`] would find its folder and be let in, and leaves no trace.
///
/// # Errors
/// [`WriteError`], as [`replace_file`] would give.
pub fn check_place(path: &Path) -> Result<(), WriteError> {
    Place::find(path)?.temporary().map(drop)
}

/// Where a file will go: links followed, and what is there looked at.
struct Place {
    file: PathBuf,
    folder: PathBuf,
    existing: Option<fs::Permissions>,
}

impl Place {
    fn find(path: &Path) -> Result<Self, WriteError> {
        let file = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let folder = match file.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        if !folder.is_dir() {
            return Err(WriteError::NoFolder { path: path.to_owned(), folder });
        }
        let existing = match fs::metadata(&file) {
            Ok(metadata) if !metadata.is_file() => return Err(WriteError::NotAFile { path: path.to_owned() }),
            Ok(metadata) if metadata.permissions().readonly() => {
                return Err(WriteError::ReadOnly { path: path.to_owned() });
            }
            Ok(metadata) => Some(metadata.permissions()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(source) => return Err(WriteError::Io { action: "look at", path: path.to_owned(), source }),
        };
        Ok(Self { file, folder, existing })
    }

    fn temporary(&self) -> Result<NamedTempFile, WriteError> {
        let refused = |source| WriteError::Io { action: "create a file in", path: self.folder.clone(), source };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".caustica-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // tempfile's default is 0600; the system takes the umask off this as off any new file.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let temporary = builder.tempfile_in(&self.folder).map_err(refused)?;
        if let Some(permissions) = &self.existing {
            temporary.as_file().set_permissions(permissions.clone()).map_err(refused)?;
        }
        Ok(temporary)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_half_way_leaves_the_old_file_and_no_litter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        replace_file(&path, b"old").unwrap();
        let failed = replace_with(&path, |file| {
            file.write_all(b"new but cut sh")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"old".to_vec(), vec!["a.png".to_owned()]));

        replace_file(&path, b"new").unwrap();
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"new".to_vec(), vec!["a.png".to_owned()]));
    }

    #[test]
    fn places_that_cannot_hold_a_file_are_named_before_any_work() {
        let folder = tempfile::tempdir().unwrap();
        let nowhere = folder.path().join("none/a.png");
        assert!(matches!(check_place(&nowhere), Err(WriteError::NoFolder { .. })));
        assert!(matches!(check_place(folder.path()), Err(WriteError::NotAFile { .. })));
        let locked = folder.path().join("locked.png");
        fs::write(&locked, "mine").unwrap();
        let mut permissions = fs::metadata(&locked).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&locked, permissions).unwrap();
        assert!(matches!(replace_file(&locked, b"x"), Err(WriteError::ReadOnly { .. })));
        check_place(&folder.path().join("fine.png")).unwrap();
        assert_eq!(names(folder.path()), ["locked.png"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_that_refuses_new_files_is_an_error() {
        assert!(matches!(check_place(Path::new("/proc/a.png")), Err(WriteError::Io { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_an_ordinary_file_and_links_are_followed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        let (ordinary, ours) = (folder.path().join("ordinary"), folder.path().join("ours"));
        fs::write(&ordinary, "x").unwrap();
        replace_file(&ours, b"x").unwrap();
        assert_eq!(mode(&ours), mode(&ordinary));

        fs::set_permissions(&ours, fs::Permissions::from_mode(0o640)).unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&ours, &link).unwrap();
        replace_file(&link, b"y").unwrap();
        assert_eq!((fs::read(&ours).unwrap(), mode(&ours) & 0o777), (b"y".to_vec(), 0o640));
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
