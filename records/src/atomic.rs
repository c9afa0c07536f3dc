//! Files written whole or not at all.

use crate::error::Error;
use crate::unfinished::Unfinished;
use std::fs::{File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Temporary files in progress.
static UNFINISHED: Unfinished = Unfinished::new();

/// Removes temporary files in progress, for a program that ends on an interrupt.
pub fn remove_unfinished() {
    UNFINISHED.remove();
}

/// Writes `bytes` to `path`: to a temporary name in the same folder, synced, then renamed. A reader sees the old file or the new
/// one, never a part; on failure the old file remains and nothing else.
///
/// Follows a link; refuses a write-protected file. Writes directly to anything that is not a regular file (a device, a pipe).
///
/// # Errors
/// [`Error::Write`] with the system's reason.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write(path, bytes).map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// Checks that [`write_atomically`] can write to `path`, before the work that produces the content: creates and removes a file
/// beside it. An existing file at `path` is not touched.
///
/// # Errors
/// [`Error::Write`] as after the work.
pub fn check_writable(path: &Path) -> Result<(), Error> {
    try_beside(path).map_err(|source| Error::Write { path: path.to_owned(), source })
}

fn try_beside(path: &Path) -> io::Result<()> {
    if replaced(path)?.is_some_and(|old| !old.is_file()) {
        return Ok(());
    }
    let temporary = temporary_beside(&followed(path)?)?;
    File::create_new(&temporary)?;
    std::fs::remove_file(&temporary)
}

/// Metadata of what exists at `path`, if it may be replaced or written to.
fn replaced(path: &Path) -> io::Result<Option<Metadata>> {
    let old = std::fs::metadata(path).ok();
    match &old {
        Some(old) if old.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "a folder of that name exists")),
        Some(old) if old.is_file() && old.permissions().readonly() => {
            Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file there is write-protected"))
        }
        _ => Ok(old),
    }
}

/// The target of a link.
fn followed(path: &Path) -> io::Result<PathBuf> {
    if path.is_symlink() { std::fs::canonicalize(path) } else { Ok(path.to_owned()) }
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let old = replaced(path)?;
    if old.as_ref().is_some_and(|old| !old.is_file()) {
        // Renaming would replace the device.
        return File::options().write(true).open(path)?.write_all(bytes);
    }
    let path = followed(path)?;
    let temporary = temporary_beside(&path)?;
    let _unfinished = UNFINISHED.begin(&temporary);
    // Locked until renamed: an unlocked temporary file was left by a killed process.
    let result = fill(&temporary, bytes).and_then(|_locked| {
        if let Some(old) = old {
            std::fs::set_permissions(&temporary, old.permissions())?;
        }
        std::fs::rename(&temporary, &path)
    });
    if result.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    result
}

fn fill(path: &Path, bytes: &[u8]) -> io::Result<File> {
    let mut file = File::create_new(path)?;
    // Some file systems have no locks; the file is written anyway.
    let _ = file.lock();
    file.write_all(bytes)?;
    file.sync_all()?;
    Ok(file)
}

fn temporary_beside(path: &Path) -> io::Result<PathBuf> {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no file name"))?;
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}-{}.tmp", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    Ok(path.with_file_name(temporary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_remains() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a b.txt");
        write_atomically(&path, b"one").unwrap();
        write_atomically(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("absent/out.toml");
        let message = write_atomically(&path, b"x").unwrap_err().to_string();
        assert!(message.contains("absent/out.toml: cannot be written"), "{message}");
    }

    #[test]
    fn a_folder_in_the_way_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        std::fs::create_dir(&path).unwrap();
        assert!(write_atomically(&path, b"x").unwrap_err().to_string().contains("a folder of that name"));
        assert!(check_writable(&path).unwrap_err().to_string().contains("a folder of that name"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn finding_out_whether_a_file_can_be_written_leaves_the_folder_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        check_writable(&path).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        std::fs::write(&path, "kept").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"kept");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let message = check_writable(&folder.path().join("absent/model.toml")).unwrap_err().to_string();
        assert!(message.contains("model.toml: cannot be written"), "{message}");
    }

    #[test]
    fn a_write_protected_file_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept.toml");
        std::fs::write(&path, "kept").unwrap();
        let mut permissions = std::fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&path, permissions).unwrap();
        assert!(write_atomically(&path, b"x").unwrap_err().to_string().contains("write-protected"));
        assert!(check_writable(&path).unwrap_err().to_string().contains("write-protected"));
        assert_eq!(std::fs::read(&path).unwrap(), b"kept");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_its_file_keeps_its_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_written_to_and_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        write_atomically(Path::new("/dev/null"), b"x").unwrap();
        assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        let message = write_atomically(Path::new("/dev/full"), b"x").unwrap_err().to_string();
        assert!(message.starts_with("/dev/full: cannot be written: No space left"), "{message}");
    }
}
