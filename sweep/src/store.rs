//! Where a study's folder is: on a disk or, behind the same few operations, in an object store. Files are named relative to
//! the folder, with `/`.

use crate::hash;
use crate::new_file::TEMPORARY;
use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// A folder of files that appear whole or not at all.
pub trait Store: Sync {
    /// Where it is, as people write it.
    fn place(&self) -> &Path;

    /// Says no where the folder can be none.
    ///
    /// # Errors
    /// What stands there, or why it cannot be reached.
    fn check(&self) -> io::Result<()>;

    /// A file's contents, where there is one.
    ///
    /// # Errors
    /// It cannot be read.
    fn read(&self, name: &str) -> io::Result<Option<Vec<u8>>>;

    /// A file's length, where there is one.
    ///
    /// # Errors
    /// It cannot be asked for.
    fn length(&self, name: &str) -> io::Result<Option<u64>>;

    /// Names of what is in a folder of this one, in order; of this folder itself where that is empty.
    ///
    /// # Errors
    /// It cannot be read.
    fn names(&self, folder: &str) -> io::Result<Vec<String>>;

    /// A file on the disk: the one itself, or a copy.
    ///
    /// # Errors
    /// It is not there or cannot be read.
    fn local(&self, name: &str) -> io::Result<LocalFile>;

    /// Whether what is stored is guarded against damage by the store itself, so that a file of the right length is whole.
    fn guards_its_bytes(&self) -> bool;

    /// Writes a file, in place of an earlier one.
    ///
    /// # Errors
    /// It cannot be written; the earlier one is still there.
    fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()>;

    /// Gives a whole file of [`Store::workshop`] its name, and makes it last; returns whether it was moved there.
    ///
    /// # Errors
    /// It cannot be written.
    fn publish(&self, file: &File, path: &Path, name: &str) -> io::Result<bool>;

    /// Removes a file, if it is there.
    ///
    /// # Errors
    /// It cannot be removed.
    fn remove(&self, name: &str) -> io::Result<()>;

    /// Makes it ready to be written, some folders in it too.
    ///
    /// # Errors
    /// It cannot be made.
    fn prepare(&self, folders: &[&str]) -> io::Result<()>;

    /// The folder on the disk in which files are made.
    fn workshop(&self) -> PathBuf;

    /// Removes what killed runs left: temporary files of those names that nobody has locked.
    ///
    /// # Errors
    /// It cannot be read.
    fn clean(&self, folders: &[&str], names: &[String]) -> io::Result<()>;

    /// SHA-256 of a file.
    ///
    /// # Errors
    /// It is not there or cannot be read.
    fn sha256(&self, name: &str) -> io::Result<String> {
        hash::of_file(self.local(name)?.path())
    }
}

/// A file on the disk; a copy is removed in the end.
#[derive(Debug)]
pub struct LocalFile {
    path: PathBuf,
    is_copy: bool,
}

impl LocalFile {
    /// A copy.
    pub fn copy(path: PathBuf) -> Self {
        Self { path, is_copy: true }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for LocalFile {
    fn drop(&mut self) {
        if self.is_copy {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// A folder of a file system.
#[derive(Debug)]
pub struct Local<'a> {
    path: &'a Path,
    workshop: PathBuf,
}

impl<'a> Local<'a> {
    /// At that path; files are made in one of its own folders.
    pub fn new(path: &'a Path, workshop: &str) -> Self {
        Self { path, workshop: path.join(workshop) }
    }

    fn prepared(&self, name: &str) -> io::Result<PathBuf> {
        let path = self.path.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        Ok(path)
    }
}

/// Nothing where nothing is.
fn some<T>(result: io::Result<T>) -> io::Result<Option<T>> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        other => other.map(Some),
    }
}

impl Store for Local<'_> {
    fn place(&self) -> &Path {
        self.path
    }

    fn check(&self) -> io::Result<()> {
        if self.path.exists() && !self.path.is_dir() {
            return Err(io::Error::new(ErrorKind::NotADirectory, "it is a file, not a folder"));
        }
        Ok(())
    }

    fn read(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        some(std::fs::read(self.path.join(name)))
    }

    fn length(&self, name: &str) -> io::Result<Option<u64>> {
        Ok(some(std::fs::metadata(self.path.join(name)))?.map(|file| file.len()))
    }

    fn names(&self, folder: &str) -> io::Result<Vec<String>> {
        let Some(entries) = some(std::fs::read_dir(self.path.join(folder)))? else { return Ok(Vec::new()) };
        let mut names =
            entries.map(|e| e.map(|e| e.file_name().to_string_lossy().into_owned())).collect::<io::Result<Vec<_>>>()?;
        names.sort();
        Ok(names)
    }

    fn local(&self, name: &str) -> io::Result<LocalFile> {
        Ok(LocalFile { path: self.path.join(name), is_copy: false })
    }

    fn guards_its_bytes(&self) -> bool {
        false
    }

    fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        records::write_atomically(&self.prepared(name)?, bytes).map_err(|error| match error {
            records::Error::Write { source, .. } => source,
            other => io::Error::other(other.to_string()),
        })
    }

    fn publish(&self, file: &File, path: &Path, name: &str) -> io::Result<bool> {
        put_in_place(file, path, &self.prepared(name)?).map(|()| true)
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        some(std::fs::remove_file(self.path.join(name))).map(|_| ())
    }

    fn prepare(&self, folders: &[&str]) -> io::Result<()> {
        folders.iter().try_for_each(|folder| std::fs::create_dir_all(self.path.join(folder)))
    }

    fn workshop(&self) -> PathBuf {
        self.workshop.clone()
    }

    fn clean(&self, folders: &[&str], names: &[String]) -> io::Result<()> {
        let prefixes: Vec<String> = names.iter().map(|name| format!(".{name}.")).collect();
        for folder in folders {
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

/// Makes a file last under another name on the same disk; a system whose folders cannot be synced needs no more than the
/// file's own sync.
pub(crate) fn put_in_place(file: &File, from: &Path, to: &Path) -> io::Result<()> {
    file.sync_all()?;
    std::fs::rename(from, to)?;
    let folder = to.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
