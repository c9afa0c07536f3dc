//! Storage of a study's folder: on a disk or, behind the same few operations, in an object store. File names are relative to the
//! folder, with `/`.

use crate::file_names::RECORDS;
use crate::hash;
use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// Suffix of temporary files; they begin with a dot and their final name.
pub const TEMPORARY: &str = ".tmp";

/// A folder whose files appear whole or not at all.
pub trait Store: Sync {
    /// Its location, for display.
    fn location(&self) -> &Path;

    /// A file's contents, if it exists.
    fn read(&self, name: &str) -> io::Result<Option<Vec<u8>>>;

    /// A file's length, if it exists.
    fn length(&self, name: &str) -> io::Result<Option<u64>>;

    /// Sorted names of the files in a subfolder, or in this folder itself if `folder` is empty.
    fn names(&self, folder: &str) -> io::Result<Vec<String>>;

    /// A file on the local disk: the stored file itself, or a copy that is removed when dropped.
    fn local(&self, name: &str) -> io::Result<LocalFile>;

    /// Writes a file, replacing an earlier one.
    ///
    /// # Errors
    /// It cannot be written; the earlier file is unchanged.
    fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()>;

    /// Publishes a complete file from [`Store::staging`] durably under its name; the staging file may then be removed.
    fn publish(&self, file: &File, path: &Path, name: &str) -> io::Result<()>;

    /// Removes a file, if it exists.
    fn remove(&self, name: &str) -> io::Result<()>;

    /// Free space, bytes; `None` if unknown or unlimited, or if nothing can be written.
    fn free(&self) -> Option<u64> {
        None
    }

    /// The folder on the local disk in which files are made.
    fn staging(&self) -> io::Result<PathBuf>;

    /// Removes unlocked temporary files that killed runs left for these names. Does nothing if each run has its own staging
    /// folder.
    fn clean(&self, _names: &[String]) -> io::Result<()> {
        Ok(())
    }

    /// SHA-256 of a file.
    fn sha256(&self, name: &str) -> io::Result<String> {
        hash::of_file(self.local(name)?.path())
    }
}

/// A file on the disk.
#[derive(Debug)]
pub enum LocalFile {
    /// The stored file itself.
    Itself(PathBuf),
    /// A copy, removed when dropped.
    Copy(TempPath),
}

impl LocalFile {
    /// Path of the file on the disk.
    pub fn path(&self) -> &Path {
        match self {
            LocalFile::Itself(path) => path,
            LocalFile::Copy(path) => path,
        }
    }
}

/// A folder of a file system.
#[derive(Clone, Debug)]
pub struct Local {
    path: PathBuf,
}

impl Local {
    /// The folder at `path`; it need not exist yet.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned() }
    }

    /// Path of a file, after creating its folder.
    fn prepared(&self, name: &str) -> io::Result<PathBuf> {
        let path = self.path.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        Ok(path)
    }
}

/// `None` where the file does not exist, instead of an error.
fn some<T>(result: io::Result<T>) -> io::Result<Option<T>> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        other => other.map(Some),
    }
}

/// The nearest existing folder, which shows the disk of `path`.
pub fn existing(path: &Path) -> Option<&Path> {
    let mut folders = path.ancestors().map(|path| if path == Path::new("") { Path::new(".") } else { path });
    folders.find(|path| path.is_dir())
}

impl Store for Local {
    fn location(&self) -> &Path {
        &self.path
    }

    fn read(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        some(std::fs::read(self.path.join(name)))
    }

    fn length(&self, name: &str) -> io::Result<Option<u64>> {
        Ok(some(std::fs::metadata(self.path.join(name)))?.map(|file| file.len()))
    }

    fn names(&self, folder: &str) -> io::Result<Vec<String>> {
        if self.path.is_file() {
            return Err(io::Error::new(ErrorKind::NotADirectory, "it is a file, not a folder"));
        }
        let Some(entries) = some(std::fs::read_dir(self.path.join(folder)))? else { return Ok(Vec::new()) };
        let mut names =
            entries.map(|e| e.map(|e| e.file_name().to_string_lossy().into_owned())).collect::<io::Result<Vec<_>>>()?;
        names.sort();
        Ok(names)
    }

    fn local(&self, name: &str) -> io::Result<LocalFile> {
        Ok(LocalFile::Itself(self.path.join(name)))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        records::write_atomically(&self.prepared(name)?, bytes).map_err(|error| match error {
            records::Error::Write { source, .. } => source,
            other => io::Error::other(other.to_string()),
        })
    }

    #[cfg(unix)]
    fn free(&self) -> Option<u64> {
        let disk = rustix::fs::statvfs(existing(&self.path)?).ok()?;
        let can_be_written = !disk.f_flag.contains(rustix::fs::StatVfsMountFlags::RDONLY);
        can_be_written.then(|| disk.f_bavail.saturating_mul(disk.f_frsize))
    }

    /// On a system that cannot sync folders, syncing the file suffices.
    fn publish(&self, file: &File, path: &Path, name: &str) -> io::Result<()> {
        let destination = self.prepared(name)?;
        file.sync_all()?;
        std::fs::rename(path, &destination)?;
        let folder = destination.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        some(std::fs::remove_file(self.path.join(name))).map(|_| ())
    }

    fn staging(&self) -> io::Result<PathBuf> {
        let path = self.path.join(RECORDS);
        std::fs::create_dir_all(&path)?;
        Ok(path)
    }

    fn clean(&self, names: &[String]) -> io::Result<()> {
        let prefixes: Vec<String> = names.iter().map(|name| format!(".{name}.")).collect();
        // JSON files are made in their final folders.
        for folder in ["", RECORDS] {
            for name in self.names(folder)? {
                if name.ends_with(TEMPORARY) && prefixes.iter().any(|prefix| name.starts_with(prefix.as_str())) {
                    let path = self.path.join(folder).join(&name);
                    let abandoned = File::open(&path).is_ok_and(|file| file.try_lock().is_ok());
                    if abandoned {
                        let _ = std::fs::remove_file(&path);
                    }
                }
            }
        }
        Ok(())
    }
}
