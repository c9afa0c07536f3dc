//! Where a study's folder is: on a disk or, behind the same few operations, in an object store. Files are named relative to
//! the folder, with `/`.

use crate::file_names::RECORDS;
use crate::hash;
use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// Ending of temporary files; they begin with a dot and the name they are meant to have.
pub const TEMPORARY: &str = ".tmp";

/// A folder of files that appear whole or not at all.
pub trait Store: Sync {
    /// Where it is, as people write it.
    fn place(&self) -> &Path;

    /// A file's contents, where there is one.
    fn read(&self, name: &str) -> io::Result<Option<Vec<u8>>>;

    /// A file's length, where there is one.
    fn length(&self, name: &str) -> io::Result<Option<u64>>;

    /// Names of the files in a folder of this one, in order; in this folder itself where that is empty.
    fn names(&self, folder: &str) -> io::Result<Vec<String>>;

    /// A file on the disk: the one itself, or a copy that is removed when dropped.
    fn local(&self, name: &str) -> io::Result<LocalFile>;

    /// Writes a file, in place of an earlier one.
    ///
    /// # Errors
    /// It cannot be written; the earlier one is still there.
    fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()>;

    /// Makes a whole file of [`Store::staging`] last under its name; what stays in the staging folder may be removed.
    fn publish(&self, file: &File, path: &Path, name: &str) -> io::Result<()>;

    /// Removes a file, if it is there.
    fn remove(&self, name: &str) -> io::Result<()>;

    /// Bytes that can still be written there; none where that is not known or has no end, or nothing can be written.
    fn free(&self) -> Option<u64> {
        None
    }

    /// The folder on the disk in which files are made.
    fn staging(&self) -> io::Result<PathBuf>;

    /// Removes what killed runs left of files of those names: temporary files that nobody has locked. Nothing is left where
    /// each run has a staging folder of its own.
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
    /// A copy, which is removed when dropped.
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

    /// Where a file will be, in a folder that exists.
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

/// The nearest folder that is there: the disk that `path` is on or will be on.
pub fn existing(path: &Path) -> Option<&Path> {
    let mut folders = path.ancestors().map(|path| if path == Path::new("") { Path::new(".") } else { path });
    folders.find(|path| path.is_dir())
}

impl Store for Local {
    fn place(&self) -> &Path {
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

    /// A system whose folders cannot be synced needs no more than the file's own sync.
    fn publish(&self, file: &File, path: &Path, name: &str) -> io::Result<()> {
        let place = self.prepared(name)?;
        file.sync_all()?;
        std::fs::rename(path, &place)?;
        let folder = place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
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
        // JSON files are made beside their places.
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
