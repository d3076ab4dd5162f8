use super::*;

fn sorted_file_names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_failed_write_leaves_only_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    replace_file(&path, b"old").unwrap();
    let failed = replace_file_with(&path, |file| {
        file.write_all(b"new but cut sh")?;
        Err(io::Error::other("disk full"))
    });
    assert!(failed.unwrap_err().to_string().contains("disk full"));
    assert_eq!(
        (fs::read(&path).unwrap(), sorted_file_names(folder.path())),
        (b"old".to_vec(), vec!["a.png".to_owned()])
    );

    replace_file(&path, b"new").unwrap();
    assert_eq!(
        (fs::read(&path).unwrap(), sorted_file_names(folder.path())),
        (b"new".to_vec(), vec!["a.png".to_owned()])
    );
}

#[test]
fn unwritable_paths_are_refused_before_work() {
    let folder = tempfile::tempdir().unwrap();
    let nowhere = folder.path().join("none/a.png");
    assert!(matches!(check_replaceable(&nowhere), Err(WriteError::NoFolder { .. })));
    assert!(matches!(check_replaceable(folder.path()), Err(WriteError::NotAFile { .. })));
    let locked = folder.path().join("locked.png");
    fs::write(&locked, "mine").unwrap();
    let mut permissions = fs::metadata(&locked).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&locked, permissions).unwrap();
    assert!(matches!(replace_file(&locked, b"x"), Err(WriteError::ReadOnly { .. })));
    check_replaceable(&folder.path().join("fine.png")).unwrap();
    assert_eq!(sorted_file_names(folder.path()), ["locked.png"]);
}

#[test]
fn only_old_temporary_files_are_removed() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, hours: u64| {
        let file = File::create(folder.path().join(name)).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(3600 * hours)).unwrap();
    };
    put(".caustica-old.tmp", 2);
    put(".caustica-new.tmp", 0);
    put(".other-old.tmp", 2);
    replace_file(&folder.path().join("a.png"), b"x").unwrap();
    assert_eq!(sorted_file_names(folder.path()), [".caustica-new.tmp", ".other-old.tmp", "a.png"]);
}

/// If the clock is set back by a day, existing files have times in the future. They may be in use,
/// so they stay.
#[test]
fn clocks_that_go_back_remove_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(".caustica-new.tmp");
    File::create(&path).unwrap();
    let day = Duration::from_secs(86_400);
    remove_abandoned_files(folder.path(), SystemTime::now() - day);
    assert!(path.exists());
    replace_file(&folder.path().join("a.png"), b"x").unwrap();
    File::open(folder.path().join("a.png")).unwrap().set_modified(SystemTime::now() + day).unwrap();
    replace_file(&folder.path().join("a.png"), b"y").unwrap();
    assert_eq!(fs::read(folder.path().join("a.png")).unwrap(), b"y");
    remove_abandoned_files(folder.path(), SystemTime::now() + day);
    assert!(!path.exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_without_write_permission_is_refused() {
    assert!(matches!(check_replaceable(Path::new("/proc/a.png")), Err(WriteError::Io { .. })));
}

#[cfg(unix)]
#[test]
fn permissions_are_kept_and_links_followed() {
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
